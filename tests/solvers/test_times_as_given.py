"""A Prony series of given relaxation times: from data, and from a model."""

from __future__ import annotations

import json
from time import process_time

import numpy as np
import pytest

from springpot import Measurement, identify
from springpot.cli.identify import _meant
from springpot.constraints import at_times, times_of
from springpot.errors import ModelError, OptionError
from springpot.measurement.units import Units
from springpot.registry import parse_model
from springpot.solvers.exporting import exported, series_of

OMEGA = np.geomspace(1e-6, 1e6, 340)
TIMES = times_of("1e-8:1e8")


def wide(noise: float = 0.0, omega=OMEGA, **more):
    """A rubber over twelve decades, by terms that lie on the times."""
    rng = np.random.default_rng(1)
    weights = np.exp(-0.05 * np.arange(-8, 9) ** 2)
    turned = 1j * omega[:, None] * TIMES
    k = 0.5 + (turned / (1.0 + turned)) @ weights
    noisy = k * (1.0 + noise * (rng.normal(size=len(k)) + 1j * rng.normal(size=len(k))))
    units = Units("MPa", "-", letter="E")
    return weights, Measurement(omega, noisy, units=units, name="rubber", **more)


def test_the_terms_that_the_data_were_made_of_come_back():
    """But for those whose times were not reached, which are springs there."""
    weights, data = wide()
    series = series_of(data, TIMES).prony
    np.testing.assert_array_equal(series.times, TIMES)
    seen = (TIMES > 1e-5) & (TIMES < 1e5)
    np.testing.assert_allclose(series.weights[seen], weights[seen], rtol=1e-3)
    assert series.error < 1e-6


def test_noise_makes_no_weight_negative_and_stays_what_is_missed():
    _, data = wide(0.02)
    times = times_of("1e-7:1e7", 2)
    series = series_of(data, times).prony
    assert np.all(series.weights >= 0.0)
    left = np.abs(series.stiffness(OMEGA) / data.stiffness - 1.0)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(0.02 * np.sqrt(2.0), rel=0.1)


def test_340_points_and_20_terms_take_no_time():
    """25 s as a model whose times are searched; a busy machine is allowed some more than 50 ms."""
    _, data = wide(0.02)
    times = np.geomspace(1e-7, 1e7, 20)
    began = process_time()
    series_of(data, times)
    assert process_time() - began < 0.2


@pytest.mark.parametrize(
    ("text", "says"),
    [("1:", "no range"), ("1e3:1", "no range"), ("0:1", "no range"), ("1e-90:1e90", "60 of")],
)
def test_what_is_no_range_of_times_is_refused(text, says):
    with pytest.raises(OptionError, match=says):
        times_of(text)


def test_a_series_is_of_one_temperature_and_of_enough_points():
    temperature = np.repeat([20.0, 40.0], 170)
    _, data = wide(conditions={"temperature": temperature})
    with pytest.raises(ModelError, match="more than one temperature"):
        series_of(data, TIMES)
    _, few = wide(omega=OMEGA[::60])
    with pytest.raises(ModelError, match="do not tell 17 weights"):
        series_of(few, TIMES)
    # Each point is two numbers, and the long-term stiffness is one more that they are to tell.
    _, just = wide(omega=OMEGA[::40][:9])
    assert len(series_of(just, TIMES).prony.times) == 17


def test_data_become_a_card_at_once(springpot, write):
    _, data = wide(0.01)
    rows = zip(OMEGA.tolist(), data.storage.tolist(), data.loss.tolist(), strict=True)
    table = "omega [rad/s],E' [MPa],E'' [MPa]\n" + "".join(f"{w},{a},{b}\n" for w, a, b in rows)
    path = write(table, "rubber.csv")
    asked = ["export-model", path, "--times", "1e-7:1e7", "--per-decade", "1"]
    card = json.loads(springpot(*asked, "--to", "json").out)
    assert [term["time_s"] for term in card["terms"]] == pytest.approx(np.geomspace(1e-7, 1e7, 15))
    assert card["modulus"] == "E"
    abaqus = springpot(*asked, "--to", "abaqus", "--poisson", "0.49", "--bulk", "relaxing")
    assert "*VISCOELASTIC, TIME=PRONY" in abaqus.out
    springpot(*asked, "--to", "json", "--terms", "3").is_one_line("leave out --terms")
    springpot("export-model", "zener", "--to", "csv").is_one_line("give the --band")
    springpot("export-model", path, "--to", "csv").is_one_line("of data", "--times")


def test_a_model_has_them_on_its_band():
    given = {"values": ["c=60", "alpha=0.5"], "unit": "kN/m", "band": "0.01Hz:100Hz"}
    told = exported("springpot", "csv", times=times_of("1e-5:1e3", 2), **given).handoff.prony
    assert len(told.times) == 17
    omega = 2.0 * np.pi * np.geomspace(0.01, 100.0, 50)
    exact = 60.0 * (1j * omega) ** 0.5
    assert np.abs(told.stiffness(omega) / exact - 1.0).max() < 1.05 * told.error < 0.02


@pytest.mark.soak
def test_a_fit_with_its_times_held_is_that_series(springpot, write):
    """One convex problem: 27 s of searching found the same, and a kelvin of given times is none."""
    _, data = wide(0.01, omega=OMEGA[::8])
    times = times_of("1e-6:1e6")
    model = parse_model("prony-13")
    held = at_times(model, times)
    began = process_time()
    fit = identify(data, model, fix=held, objective="relative")
    assert process_time() - began < 5.0
    weights = [fit[f"k{i}"].value for i in range(1, 14)]
    np.testing.assert_allclose(weights, series_of(data, times).prony.weights, rtol=1e-5, atol=1e-9)
    with pytest.raises(OptionError, match="prony-2 has 2"):
        at_times(parse_model("prony-2"), times)
    rows = zip(data.omega.tolist(), data.storage.tolist(), data.loss.tolist(), strict=True)
    table = "omega [rad/s],E' [MPa],E'' [MPa]\n" + "".join(f"{w},{a},{b}\n" for w, a, b in rows)
    asked = ["identify", write(table, "rubber.csv"), "--model", "prony", "--times", "1e-6:1e6"]
    answer = springpot(*asked, "--json").json
    assert answer["model"] == "prony-13"
    assert answer["parameters"]["tau3"]["value"] == pytest.approx(1e-4)


def test_times_of_a_model_that_is_no_family_are_refused():
    """With `--model kelvin` a chain of as many Kelvin elements was fitted without a word."""
    for model, members in (("kelvin", 0), ("maxwell", 0)):
        with pytest.raises(OptionError, match=f"{model} has {members}: give a family"):
            _meant(model, "1e-2:1e3", 1)
    for model, member in (("prony", "prony-6"), ("maxwell-N + inertia", "maxwell-6 + inertia")):
        assert _meant(model, "1e-2:1e3", 1)[0] == member
