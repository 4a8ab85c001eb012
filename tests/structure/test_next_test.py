"""Which test of a damper narrows the band of the drift most: promised, and then made."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.measurement.units import Units
from springpot.registry import parse_model
from springpot.structure import Damper, Frame, artificial, simulate
from springpot.structure.answers import further_tests

pytestmark = pytest.mark.usefixtures("asked_once")

RECORD = artificial(np.random.default_rng(1), duration=1.5)
MODEL = "kelvin + inertia"
UNITS = Units("N/m", "m")
TRUTH = {"k": 4e7, "c": 6e5, "inertia.m": 40.0}


def measured(omega, seed: int = 0, noise: float = 0.05):
    """K of the truth with five per cent of noise, told as such."""
    model, rng = parse_model(MODEL), np.random.default_rng(seed)
    k = model.stiffness(model.vector(TRUTH), np.asarray(omega))
    sd = noise * np.abs(k) * (1 + 1j)
    noisy = k + sd.real * (rng.normal(size=len(k)) + 1j * rng.normal(size=len(k)))
    return springpot.Measurement(omega, noisy, sd=sd, units=UNITS)


def frame_of(fit, *more: Damper) -> Frame:
    known = fit.of_specimen
    own = known.without(["inertia"])
    damper = Damper(own.model, own.theta, covariance=own.theta_covariance, tested=known)
    return Frame([1e5, 1e5], [8e7, 7e7], 0.02, (damper, *more))


@pytest.fixture(scope="module")
def fit():
    return springpot.identify(measured(np.geomspace(3.0, 300.0, 12)), MODEL)


def test_what_is_promised_of_a_further_test_is_what_it_brings(fit):
    """The promised test is made, and all points fitted together."""
    frame = frame_of(fit)
    found = further_tests(frame, [RECORD])
    widths = [test.half_width for test in found.tests]
    assert widths == sorted(widths)
    assert widths[0] < 0.8 * found.half_width
    test = next(test for test in found.tests if test.says.startswith("extend the frequencies down"))
    old, new = fit.sweep, measured(np.array(test.action["omega"]), seed=1)
    together = springpot.Measurement(
        np.concatenate([old.omega, new.omega]),
        np.concatenate([old.stiffness, new.stiffness]),
        sd=np.concatenate([old.sd, new.sd]),
        units=UNITS,
    )
    after = further_tests(frame_of(springpot.identify(together, MODEL)), [RECORD])
    assert after.half_width == pytest.approx(test.half_width, rel=0.15)


@pytest.mark.soak
def test_the_band_now_is_that_of_the_draws(fit):
    frame = frame_of(fit)
    found = further_tests(frame, [RECORD])
    drawn = simulate(frame, RECORD, np.random.default_rng(2), draws=50)
    sd = np.std(drawn.drifts, axis=0)[found.storey - 1]
    assert found.half_width == pytest.approx(1.96 * sd, rel=0.3)


def test_dampers_of_one_fit_move_together(fit):
    """Two at half the count are the one, and not two that make up for each other."""
    known = fit.of_specimen
    own = known.without(["inertia"])
    half = Damper(own.model, own.theta, count=0.5, tested=known)
    one, two = frame_of(fit), Frame([1e5, 1e5], [8e7, 7e7], 0.02, (half, half))
    widths = [further_tests(frame, [RECORD]).half_width for frame in (one, two)]
    assert widths[1] == pytest.approx(widths[0])
    peaks = [
        simulate(frame, RECORD, np.random.default_rng(3), draws=3).drifts for frame in (one, two)
    ]
    np.testing.assert_allclose(peaks[1], peaks[0], rtol=1e-6)


def test_a_record_again_changes_nothing_and_a_damper_that_is_stated_has_no_test(fit):
    stated = Damper(parse_model("kelvin"), np.array([1e7, 1e5]), storey=2)
    frame = frame_of(fit, stated)
    one, twice = (further_tests(frame, [RECORD] * count) for count in (1, 2))
    assert twice.half_width == pytest.approx(one.half_width)
    assert {test.damper for test in one.tests} == {1}
    with pytest.raises(ModelError, match="no damper is from the fit of a sweep"):
        further_tests(Frame([1e5], [8e7], dampers=(Damper(stated.model, stated.theta),)), [RECORD])


def test_asked_for_it_stands_in_table_and_json(springpot, write, fit):
    text = """[structure]
mass = 1e5
stiffness = 8e7
damping = 0.02

[[damper]]
fit = "fit.json"
without = "inertia"
"""
    path = write(text, "frame.toml")
    (path.parent / "fit.json").write_text(json.dumps(fit.to_dict()))
    rows = zip(RECORD.time.tolist(), RECORD.acceleration.tolist(), strict=True)
    record = write(
        "time [s],acceleration [m/s^2]\n" + "".join(f"{t:.3f},{a}\n" for t, a in rows), "r.csv"
    )
    asked = ["simulate", path, "--record", record, "--draws", "0", "--next-experiment"]
    answer = springpot(*asked, "--json").json["next_experiment"]
    assert answer["storey"] == 1
    assert answer["tests"][0]["half_width"] < answer["half_width"]
    assert "then +- [mm]" in springpot(*asked).out
    assert "next_experiment" not in springpot(*asked[:-1], "--json").json
    springpot("simulate", path, "-f", "1", "--next-experiment").is_one_line("for a --record")
