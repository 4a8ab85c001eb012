"""Small rules of structures, each at both sides of its edge, with values by hand."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import DataError, ModelError
from springpot.registry import parse_model
from springpot.structure import (
    Damper,
    Frame,
    GroundMotion,
    answers,
    artificial,
    damper,
    motion,
    motion_of,
    reading,
    shown,
)


@pytest.mark.parametrize(
    ("start", "end", "slope", "last"),
    [
        (0.0, 0.0, 4.0, -4.0),
        (0.0, 0.0, 27.0, 0.0),
        (0.0, 0.0, -1.0, 5.0),
        (1.0, 1.0, 30.0, 30.0),
        (1.0, -2.0, 0.0, 0.0),
        (0.0, 1.0, 1.0, 1.0),
        (-3.0, 1.0, -9.0, 2.0),
        (0.5, 0.2, 8.0, -20.0),
    ],
)
def test_the_largest_of_a_cubic_may_lie_within_the_step(start, end, slope, last):
    u = np.linspace(0.0, 1.0, 100_001)
    hermite = (
        start * (1 + 2 * u) * (1 - u) ** 2
        + slope * u * (1 - u) ** 2
        + end * u**2 * (3 - 2 * u)
        + last * u**2 * (u - 1)
    )
    found = motion._largest_of_cubic(*(np.array([each]) for each in (start, end, slope, last)))
    assert found[0] == pytest.approx(np.abs(hermite).max(), rel=1e-8)


def test_a_frame_too_stiff_for_short_steps_is_told_by_its_shortest_period():
    model = parse_model("kelvin + friction")
    theta = np.array([1e3, 1e2, 5.0])
    stiff = Frame(np.full(2, 1.0), np.full(2, 1e16), 0.0, (Damper(model, theta),))
    # The frequencies of two alike storeys are those of one times 0.618 and 1.618.
    period = 2.0 * np.pi / (1e8 * 0.5 * (1.0 + np.sqrt(5.0)))
    with pytest.raises(ModelError, match=f"the shortest period of the frame is {period:.3g} s"):
        motion_of(stiff, GroundMotion(0.01, np.ones(5)))


@pytest.mark.parametrize(
    ("time", "acceleration", "says"),
    [
        ([0.0], [1.0], "a record has two samples or more"),
        ([0.0, 1.0], [1.0], "a record has two samples or more"),
        ([0.0, 1.0, np.nan], [1.0, 1.0, 1.0], "sample 3 is no number"),
        ([0.0, 1.0, 2.0], [1.0, np.inf, 1.0], "sample 2 is no number"),
        ([0.0, 1.0, 2.0], [1.0, 1.0, -1.1e6], "sample 3 is -1.1e+06 m/s^2"),
        ([0.0, 1.0, 1.0], [1.0] * 3, "the time does not rise after sample 2 (t = 1 s)"),
        ([0.0, 1.0, 0.5], [1.0] * 3, "the time does not rise after sample 2 (t = 1 s)"),
        ([0.0, 1.0, 2.0, 3.01], [1.0] * 4, "(1.01 s after sample 3, 1.003 s on average)"),
        ([0.0, 1.0, 2.0, 3.0012], [1.0] * 4, ""),
        ([0.0, 1.0], [1e6, -1e6], ""),
    ],
)
def test_a_record_is_even_and_of_numbers(time, acceleration, says):
    if not says:
        record = GroundMotion.of(time, acceleration)
        assert record.step == pytest.approx(time[-1] / (len(time) - 1))
        return
    with pytest.raises(DataError) as error:
        GroundMotion.of(time, acceleration, "quake")
    assert says in str(error.value)
    assert str(error.value).startswith("quake: ")


def test_steps_may_scatter_by_so_much_and_not_more(monkeypatch):
    monkeypatch.setattr(motion, "STRUCTURE", motion.STRUCTURE._replace(even=0.25))
    assert GroundMotion.of([0.0, 0.75, 2.0], [1.0] * 3).step == 1.0
    monkeypatch.setattr(motion, "STRUCTURE", motion.STRUCTURE._replace(even=0.2499))
    with pytest.raises(DataError, match="the steps are not equal"):
        GroundMotion.of([0.0, 0.75, 2.0], [1.0] * 3)


@pytest.mark.parametrize(
    ("value", "most", "number"),
    [
        (1, 5, 1),
        (5, 5, 5),
        (0, 5, None),
        (6, 5, None),
        (True, 5, None),
        (2.0, 5, None),
        ("2", 5, None),
    ],
)
def test_a_count_is_a_whole_number_from_one_on(value, most, number):
    if number is None:
        with pytest.raises(DataError, match="give a whole one from 1 to 5"):
            reading._count(value, "count", most)
    else:
        assert reading._count(value, "count", most) == number


@pytest.mark.parametrize(
    ("value", "ends", "wanted"),
    [
        (2, (), ""),
        (2.5, (2.0, 3.0), ""),
        (2.0, (2.0, 3.0), "give a finite number above 2 and below 3"),
        (3.0, (2.0, 3.0), "give a finite number above 2 and below 3"),
        (1.0, (2.0,), "give a finite number above 2$"),
        (np.inf, (), "give a finite number$"),
        (True, (), "give a finite number$"),
        (10**400, (), "give a finite number$"),
        ("1", (), "give a finite number$"),
    ],
)
def test_a_number_is_finite_and_between_its_ends(value, ends, wanted):
    if wanted:
        with pytest.raises(DataError, match=wanted):
            reading._number(value, "mass", *ends)
    else:
        assert reading._number(value, "mass", *ends) == value


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("time [s],acceleration [m/s^2]", 1.0),
        ("Time [s] , Acceleration [g]", 9.80665),
        ("time [s],acceleration [gal],more", 0.01),
        ("time [s],acceleration [furlong]", None),
        ("time [ms],acceleration [g]", None),
        ("time [s],displacement [m]", None),
        ("time [s]", None),
        ("", None),
    ],
)
def test_units_of_a_record_are_those_of_its_first_line(header, factor):
    if factor is None:
        with pytest.raises(DataError):
            reading._acceleration_unit(header, Path("quake.csv"))
    else:
        assert reading._acceleration_unit(header, Path("quake.csv")) == factor


def test_parameters_of_a_damper_may_stand_in_tables():
    flat = reading._flat({"k": 2, "inertia": {"m": 0.5, "x": 1}}, "damper 1")
    assert flat == {"k": 2.0, "inertia.m": 0.5, "inertia.x": 1.0}
    for wrong in (3, {"k": "a"}, {"inertia": {"m": True}}):
        with pytest.raises(DataError, match="damper 1"):
            reading._flat(wrong, "damper 1")
    assert reading._without({}, "damper 1") == []
    assert reading._without({"without": "inertia"}, "damper 1") == ["inertia"]
    assert reading._without({"without": ["a", "b"]}, "damper 1") == ["a", "b"]
    with pytest.raises(DataError, match="without is a list"):
        reading._without({"without": 3}, "damper 1")


DAMPER = "[[damper]]\nmodel = 'kelvin'\nparameters = {k = 2.0, c = 3.0}\nunit = 'N/m'\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "there is no [structure]"),
        ("structure = 3", "there is no [structure]"),
        ("damper = 3\n[structure]\nmass = 1\nstiffness = 2", "each damper is a [[damper]]"),
        ("[structure]\nmass = 1\nstiffness = 2\nheight = 3", "[structure] has no 'height'"),
        ("[structure]\nstiffness = 2", "[structure] has no mass"),
        ("[structure]\nmass = [1, 1]\nstiffness = 2", "2 floors have a mass and 1 storeys"),
        ("[structure]\nmass = 1\nstiffness = 2\ndamping = 1", "is a ratio from 0 to below 1"),
        ("[structure]\nmass = 1\nstiffness = 2\n" + DAMPER + "fit = 'a.json'", "has a fit ="),
        ("[structure]\nmass = 1\nstiffness = 2\n[[damper]]\nunit = 'N/m'", "damper 1 has a fit ="),
        ("[structure]\nmass = 1\nstiffness = 2\n" + DAMPER + "storey = 2", "braces storey 2 of"),
        ("[structure]\nmass = 1\nstiffness = 2\n" + DAMPER + "slope = 90", "slope: 90 is no"),
        ("[structure]\nmass = 1\nstiffness = 2\n" + DAMPER + "count = 0", "count: 0 is no number"),
        (
            "[structure]\nmass = 1\nstiffness = 2\n" + DAMPER.replace("N/m", "Pa"),
            "a damper has a stiffness, and kelvin is in Pa",
        ),
    ],
)
def test_a_description_that_does_not_fit_is_told_in_one_line(text, says, tmp_path):
    path = tmp_path / "frame.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((DataError, ModelError)) as error:
        reading.read_structure(path)
    assert says in str(error.value)
    assert str(error.value).count(str(path)) == 1


def test_a_description_gives_its_frame(tmp_path):
    path = tmp_path / "frame.toml"
    text = "[structure]\nmass = [3, 2]\nstiffness = 5\nstoreys = 2\ndamping = 0.1\n"
    path.write_text(text + DAMPER + "storey = 2\ncount = 3\nslope = 60", encoding="utf-8")
    frame = reading.read_structure(path)
    assert (frame.mass.tolist(), frame.stiffness.tolist()) == ([3.0, 2.0], [5.0, 5.0])
    [damper] = frame.dampers
    assert (frame.damping, damper.storey, damper.count) == (0.1, 2, 3.0)
    assert damper.cosine == pytest.approx(0.5)
    assert (damper.theta.tolist(), damper.covariance, damper.temperature) == (
        [2.0, 3.0],
        None,
        None,
    )
    # Three of them at 60 degrees: a quarter of the stiffness reaches the floor.
    assert damper.size == pytest.approx(0.75)
    assert frame.floor_per_axis.tolist() == pytest.approx([1.5])


@pytest.mark.parametrize("size", [0.5, 20.0])
def test_a_positive_parameter_is_drawn_by_its_logarithm_whatever_its_size(size):
    model = parse_model("kelvin")
    theta = np.array([size, 0.0])
    covariance = np.diag([(2.0 * size) ** 2, 0.0])
    damper = Damper(model, theta, covariance=covariance)
    rng = np.random.default_rng(4)
    drawn = np.array([damper.moved(rng.standard_normal(2)).theta for _ in range(60)])
    assert np.all(drawn[:, 0] > 0.0)
    # A standard deviation of 2 of the logarithm, about that of the size.
    logs = np.log(drawn[:, 0] / size)
    assert abs(np.mean(logs)) < 1.0
    assert 1.5 < np.std(logs) < 2.5
    # What is nothing has no logarithm, and stays.
    assert np.all(drawn[:, 1] == 0.0)
    assert Damper(model, theta).moved(np.zeros(0)).theta is theta


@pytest.mark.parametrize(
    ("unit", "earth"),
    [("m/s^2", 9.80665), ("m/s2", 9.80665), ("g", 1.0), ("gal", 980.665), ("mm/s^2", 9806.65)],
)
def test_the_pull_of_the_earth_is_the_same_in_every_unit(tmp_path, unit, earth):
    path = tmp_path / "record.csv"
    path.write_text(f"time [s],acceleration [{unit}]\n0,0\n0.1,{earth}\n0.2,0\n")
    record = reading.read_record(str(path), np.random.default_rng(0))
    assert record.acceleration == pytest.approx([0.0, 9.80665, 0.0])


@pytest.mark.parametrize("most", [100.0, 1.5, 0.5])
def test_sliders_that_hold_each_other_up_come_to_rest_or_slide_at_their_limit(most):
    """Two that push each other: each is at rest, or at the end that holds it back."""
    speed, by_force = np.array([2.0, -1.0]), np.array([[-1.0, 0.6], [0.6, -1.0]])
    low, high = np.full(2, -most), np.full(2, most)
    force = damper._at_rest_if_it_can(speed, by_force, low, high, np.zeros(2))
    left = speed + by_force @ force
    for moves, holds in zip(left, force, strict=True):
        assert abs(moves) < 1e-6 or holds == np.sign(moves) * most
    if most > 10.0:
        assert force == pytest.approx(np.linalg.solve(by_force, -speed))


@pytest.mark.parametrize("level", [0.0, 0.9])
def test_the_mean_and_the_envelope_of_records_stand_each_before_its_band(level, capsys):
    def row(mean, envelope):
        ends = {"mean_low": 0.5 * mean, "mean_high": 2.0 * mean}
        ends |= {"envelope_low": 0.5 * envelope, "envelope_high": 2.0 * envelope}
        return {"mean": mean, "envelope": envelope, "worst": "record-3", **ends}

    damper = {"axial_force": row(3e3, 5e3), "stroke": row(7e-3, 9e-3), "energy": row(11e3, 13e3)}
    result = {"storeys": [{"drift": row(0.02, 0.04)}], "dampers": [damper]}
    shown._show_mean_and_envelope(result, level)
    lines = [line.split("  ") for line in capsys.readouterr().out.splitlines()]
    lines = [[cell.strip() for cell in line if cell.strip()] for line in lines]
    drift = ["drift 1 [mm]", "20.00", "[10.00, 40.00]", "40.00", "[20.00, 80.00]", "record-3"]
    if not level:
        drift = [cell for cell in drift if not cell.startswith("[")]
    assert drift in lines
    assert ["energy 1 [kJ]", "11.00", "13.00", "record-3"] in lines


@pytest.mark.parametrize(("periods", "parts"), [(0.9, 1), (1.1, 2), (2.5, 3)])
def test_steps_are_parted_until_the_shortest_period_has_sixteen(periods, parts, monkeypatch):
    """Of an oscillator whose period holds less than sixteen steps."""
    asked = []
    step = 0.1
    omega = 2.0 * np.pi * periods / (motion.STEPS.short * step)
    matrix = np.array([[0.0, 1.0], [-(omega**2), 0.0]])
    system = motion.System(matrix, np.array([0.0, 1.0]), step)
    whole = type(system).in_steps_of
    monkeypatch.setattr(
        type(system), "in_steps_of", lambda self, fine: asked.append(fine) or whole(self, fine)
    )
    a = np.sin(np.arange(60.0) * 0.3)
    found = system.largest(system.run(a), a, np.eye(2))
    assert asked == ([] if parts == 1 else [pytest.approx(step / parts)])
    assert np.all(found > 0.0)


def test_a_further_test_is_told_in_hertz():
    points = SimpleNamespace(log_omega=np.log(2.0 * np.pi * np.array([0.5, 3.0])))
    assert answers._hertz(SimpleNamespace(points=points), 1) == pytest.approx(3.0)


@pytest.mark.parametrize(("samples", "step"), [(4000, 0.01), (100, 0.01), (100, 0.5)])
def test_a_damper_is_followed_between_the_record_and_what_the_frame_can_show(
    monkeypatch, samples, step
):
    """To ten of its slowest radians, or the record; to its fastest mode, or half the sampling."""
    asked = []

    def part(damper, frame, band, start):
        asked.append(band)
        raise ModelError("enough")

    monkeypatch.setattr(motion, "_part", part)
    model = parse_model("kelvin")
    frame = Frame(np.full(2, 1.0), np.full(2, 100.0), 0.0, (Damper(model, np.array([1.0, 1.0])),))
    slow, fast = (
        10.0 * np.sqrt(0.5 * (3.0 - np.sqrt(5.0))),
        10.0 * np.sqrt(0.5 * (3.0 + np.sqrt(5.0))),
    )
    with pytest.raises(ModelError, match="enough"):
        motion._system(frame, GroundMotion(step, np.ones(samples)))
    longest = max(samples * step, 10.0 / slow)
    wanted = 1.0 / (motion.STEPS.beyond * longest), max(motion.STEPS.beyond * fast, np.pi / step)
    assert asked[0] == pytest.approx(wanted)


def test_an_artificial_record_swells_and_dies_as_it_says():
    """Its envelope is t squared times exp(-12 t / duration), of noise that one oscillator felt."""
    draws = np.array(
        [artificial(np.random.default_rng(seed), duration=20.0, step=0.02, peak=3.0).acceleration
         for seed in range(60)]
    )  # fmt: skip
    assert np.abs(draws).max(axis=1) == pytest.approx(np.full(60, 3.0))
    assert draws[:, 0] == pytest.approx(np.zeros(60))
    time = 0.02 * np.arange(draws.shape[1])
    felt = np.sqrt(np.mean(draws**2, axis=0))
    envelope = time**2 * np.exp(-12.0 * time / 20.0)
    share = np.array([felt[(time > a) & (time < a + 1.0)].sum() for a in (1.0, 3.0, 6.0)])
    wanted = np.array([envelope[(time > a) & (time < a + 1.0)].sum() for a in (1.0, 3.0, 6.0)])
    np.testing.assert_allclose(share / share.sum(), wanted / wanted.sum(), rtol=0.12)
    # The oscillator has 2.48 Hz: at 20 Hz the noise is heard little, at rest as it is.
    heard = np.mean(np.abs(np.fft.rfft(draws, axis=1)) ** 2, axis=0)
    hertz = np.fft.rfftfreq(draws.shape[1], 0.02)
    at = [heard[(hertz > low) & (hertz < low + 1.0)].mean() for low in (2.0, 20.0)]
    assert at[1] < 0.04 * at[0]


@pytest.mark.parametrize(("warmer", "told"), [(2.0, "200 %"), (0.5, "50 %")])
def test_of_what_a_damper_would_feel_of_its_heat_the_first_mode_is_told(warmer, told):
    asked = []

    def stiffness(s):
        asked.append(s[0])
        return (np.array([3.0 + 4.0j]),)

    def after(s):
        return (warmer * (3.0 + 4.0j) * np.ones(1),)

    damper = SimpleNamespace(
        temperature=20.0, model=SimpleNamespace(needs={"temperature"}), stiffness=stiffness
    )
    heated = SimpleNamespace(stiffness=after)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(answers, "replace", lambda damper, temperature: heated)
        says = answers._felt(damper, 5.0, SimpleNamespace(frequency=1.5))
    assert f"would end at {told} of that at 20 degC" in says
    assert asked == [2j * np.pi * 1.5]
