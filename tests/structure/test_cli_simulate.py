"""``springpot simulate``: a structure with an identified damper."""

from __future__ import annotations

import numpy as np
import pytest

from springpot import load
from springpot.measurement.covered import Covered
from springpot.measurement.units import Units
from springpot.registry import parse_model
from springpot.structure import Damper

FRAME = """[structure]
storeys = 2
mass = 1e5
stiffness = [8e7, 7e7]
damping = 0.02

[[damper]]
fit = "fit.json"
storey = 1
count = 40
slope = 30
"""
RECORD = "time [s],acceleration [g]\n" + "".join(
    f"{0.02 * i:.2f},{0.1 if i % 40 < 20 else -0.1}\n" for i in range(300)
)


@pytest.fixture
def frame(springpot, damper, write, asked_once):
    path = write(FRAME, "frame.toml")
    (path.parent / "fit.json").write_text(
        springpot("identify", damper, "-m", "fractional-maxwell", "--json").out
    )
    return path


@pytest.mark.soak
def test_drift_with_its_band_modes_and_energy(springpot, frame, write, tmp_path):
    record, picture = write(RECORD, "record.csv"), tmp_path / "motion.png"
    told = springpot("simulate", frame, "--record", record, "--draws", "5", "--figure", picture)
    assert told.code == 0, told.err
    for word in ("storey", "drift [mm]", "67 % band", "damping", "taken by the dampers"):
        assert word in told.out
    assert picture.stat().st_size > 10_000
    answer = springpot("simulate", frame, "--record", record, "--draws", "5", "--json").json
    assert answer["schema"] == "springpot.simulation/2"
    assert answer["record"]["peak"] == pytest.approx(0.980665)
    assert all(row["low"] <= row["drift"] <= row["high"] for row in answer["storeys"])
    assert answer["modes"][0]["damping"] > 0.02
    assert answer == springpot("simulate", frame, "--record", record, "--draws", "5", "--json").json


@pytest.mark.soak
def test_a_steady_state_balances_force_and_energy(springpot, frame, tmp_path):
    """What the dampers take in a cycle is pi times force, way and the sine between them."""
    picture = tmp_path / "steady.png"
    told = springpot("simulate", frame, "--frequency", "0.5,4,20", "--figure", picture)
    assert told.code == 0, told.err
    assert "drift 2 [mm]" in told.out
    assert picture.stat().st_size > 5_000
    answer = springpot("simulate", frame, "--frequency", "0.5,4,20", "--json").json
    assert [point["frequency"] for point in answer["points"]] == pytest.approx([0.5, 4, 20])
    for point in answer["points"]:
        [force], [energy], [way] = point["axial_force"], point["energy"], point["stroke"]
        fit = load(frame.parent / "fit.json")
        [k] = fit.model.stiffness(fit.theta, np.array([2.0 * np.pi * point["frequency"]]))
        assert energy == pytest.approx(np.pi * 40 * force * way * k.imag / abs(k), rel=1e-3)
    springpot("simulate", frame).is_one_line("give a --record or a --frequency")


SLIDING = """model = "fractional-maxwell + friction"
unit = "kN/mm"
parameters = {k = 4, c = 0.6, alpha = 0.5, "friction.F" = %g}"""


@pytest.mark.soak
def test_friction_in_a_damper_is_followed(springpot, write):
    """F is in kN, as the unit says.

    40 dampers of 20 kN hold the lowest storey still under a weak record.
    """
    record = write(RECORD, "record.csv")

    def simulated(force: float):
        path = write(FRAME.replace('fit = "fit.json"', SLIDING % force), f"{force}.toml")
        return springpot("simulate", path, "--record", record, "--json").json

    held, free = simulated(20.0), simulated(1e-6)
    assert held["storeys"][0]["drift"] < 0.1 * free["storeys"][0]["drift"]
    assert held["modes"] == free["modes"]
    path = write(FRAME.replace('fit = "fit.json"', SLIDING % 20.0), "sliding.toml")
    springpot("simulate", path, "--frequency", "1").is_one_line("'friction' has no steady state")


@pytest.mark.soak
def test_a_stated_force_is_in_the_unit_of_the_stiffness(springpot, write):
    """Friction was in N whatever the unit: a thousandth of what was meant."""
    told, record = [], write("".join(RECORD.splitlines(True)[:100]), "record.csv")
    for unit, stiff, force in (
        ("kN/mm", 1.0, 20.0),
        ("N/mm", 1e3, 2e4),
        ("N/m", 1e6, 2e4),
        ("MN/m", 1.0, 0.02),
    ):
        given = (
            f"parameters = {{k = {4 * stiff}, c = {0.6 * stiff}, "
            f'alpha = 0.5, "friction.F" = {force}}}'
        )
        model = f'model = "fractional-maxwell + friction"\nunit = "{unit}"\n{given}'
        path = write(FRAME.replace('fit = "fit.json"', model), "frame.toml")
        told.append(springpot("simulate", path, "--record", record, "--json").json)
    drifts = [row["drift"] for row in told[0]["storeys"]]
    for each in told[1:]:
        assert [row["drift"] for row in each["storeys"]] == pytest.approx(drifts, rel=1e-6)


def test_one_damper_and_all_of_a_storey_are_told_apart(springpot, frame, write):
    """What one of forty at 30 degrees feels along its axis, and what the floor gets of all."""
    record = write(RECORD, "record.csv")
    answer = springpot("simulate", frame, "--record", record, "--draws", "0", "--json").json
    [damper], storey = answer["dampers"], answer["storeys"][0]
    cosine = 0.75**0.5
    assert damper["slope"] == pytest.approx(30.0)
    assert damper["stroke"] == pytest.approx(cosine * storey["drift"])
    assert storey["damper_force"] == pytest.approx(40 * cosine * damper["axial_force"])
    assert answer["storeys"][1]["damper_force"] == 0.0
    told = springpot("simulate", frame, "--record", record, "--draws", "0").out
    for word in ("axial force [kN]", "stroke [mm]", "force of its dampers [kN]"):
        assert word in told


@pytest.mark.soak
def test_stated_parameters_have_no_band_and_need_no_quotes(springpot, write):
    stated = SLIDING.replace('"friction.F"', "friction.F") % 20.0
    record, path = (
        write(RECORD, "record.csv"),
        write(FRAME.replace('fit = "fit.json"', stated), "stated.toml"),
    )
    quoted = write(FRAME.replace('fit = "fit.json"', SLIDING % 20.0), "quoted.toml")
    told = springpot("simulate", path, "--record", record)
    assert told.code == 0, told.err
    assert "band" not in told.out
    assert told.out == springpot("simulate", quoted, "--record", record).out


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("mass = 1e5", "weight = 1e5"), "no 'weight'"),
        (("mass = 1e5", ""), "has no mass"),
        (
            ("slope = 30", "temperature = 60"),
            "damper 1: fractional-maxwell does not know temperature",
        ),
        (("slope = 30", "slope = 90"), "below 90"),
        (("storey = 1", "storey = 7"), "storey 7 of a frame of 2"),
        (('fit = "fit.json"', 'fit = "none.json"'), "none.json"),
        (('fit = "fit.json"', ""), "has a fit"),
        (
            ('fit = "fit.json"', 'fit = "fit.json"\nparameters = {k = 2}\nunit = "kN/m"'),
            "leave out parameters and unit",
        ),
        (("[structure]", "[structure"), "is no toml"),
        (("mass = 1e5", 'mass = "heavy"'), "no number"),
        (("mass = 1e5", "mass = 1e-300"), "above 1e-15"),
        (("mass = 1e5", "mass = 1e-9"), "far below the record's steps"),
        (
            ('fit = "fit.json"', 'model = "spring"\nparameters = {k = 1}\nunit = "kPa"'),
            "a damper has a stiffness",
        ),
        (
            ('fit = "fit.json"', 'model = "spring"\nparameters = {k = -9}\nunit = "kN/m"'),
            "k cannot be -9",
        ),
    ],
)
def test_a_bad_description_is_one_line(springpot, frame, change, says):
    frame.write_text(FRAME.replace(*change))
    springpot("simulate", frame, "--record", "artificial").is_one_line(says)


@pytest.mark.soak_cases("time [s],acceleration [g]\\n0,1\\n1,nan\\n-sample 2 is no number")
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("time [s],acceleration\n0,1\n1,1\n", "with the unit it has"),
        ("time [s],acceleration [ft]\n0,1\n1,1\n", "unknown unit [ft]"),
        ("time [s],acceleration [g]\n0,1\n1,x\n", "could not convert"),
        ("time [s],acceleration [g]\n0,1\n1,nan\n", "sample 2 is no number"),
        ("time [s],acceleration [g]\n0,1\n1,1\n1.5,1\n", "not equal"),
        ("time [s],acceleration [g]\n0,1\n0,1\n1.5,1\n", "does not rise"),
        ("time [s],acceleration [g]\n0,1\n", "two samples"),
    ],
)
def test_a_bad_record_is_one_line(springpot, frame, write, text, says):
    springpot("simulate", frame, "--record", write(text, "record.csv")).is_one_line(says)


def test_a_damper_used_beyond_what_it_was_measured_at_is_told(springpot, frame, write):
    """At frequencies, in the modes of a record as well, and at its temperature."""
    steady = springpot("simulate", frame, "--frequency", "10,100", "--json").json
    (note,) = steady["notes"]
    assert note.startswith("damper 1: beyond the measured 0.5 to 50 Hz (1 of 2 frequencies)")
    assert [point["outside_measured"] for point in steady["points"]] == [False, True]
    told = springpot("simulate", frame, "--frequency", "10,100").out
    assert note in told
    rows = [line.split()[-1] for line in told.splitlines() if line.lstrip().startswith("10")]
    assert rows == ["within", "outside"]
    inside = springpot("simulate", frame, "--frequency", "1,10")
    assert "measured" not in inside.out
    assert springpot("simulate", frame, "--frequency", "1,10", "--json").json["notes"] == []
    stiff = FRAME.replace("stiffness = [8e7, 7e7]", "stiffness = [8e10, 7e10]")
    record = ("--record", write(RECORD, "record.csv"), "--draws", "0")
    told = springpot("simulate", write(stiff, "stiff.toml"), *record)
    assert "damper 1: beyond the measured 0.5 to 50 Hz (2 of 2 modes)" in told.out
    assert told.out.count(" % outside") + told.out.count("%  outside") == 2
    assert springpot("simulate", frame, *record, "--json").json["notes"] == []


def test_a_damper_used_at_another_temperature_is_told():
    covered = Covered((1.0, 10.0), {"temperature": (20.0, 30.0)})
    model = parse_model("kelvin + arrhenius-shift")
    theta = model.vector({"k": 1.0, "c": 1.0, "arrhenius-shift.Ea": 50.0})
    damper = Damper(model, theta, temperature=-10.0, covered=covered)
    said = damper.remark(np.array([2.0]), "modes")
    assert said.startswith("beyond the measured temperature of 20 to 30 [degC] (1 of 1 modes)")


def test_a_damper_that_moves_further_than_it_was_measured_is_told():
    covered = Covered((1.0, 10.0), {"amplitude": (0.5, 2.0)})
    damper = Damper(parse_model("spring"), np.array([1.0]), covered=covered)
    within, beyond = (damper.remark_on_stroke(each * damper.length) for each in (1.0, 3.0))
    assert within == ""
    assert beyond.startswith("beyond the measured amplitude of 0.5 to 2 [")
    assert "(1 of 1 peak strokes)" in beyond


def test_a_condition_that_was_held_is_one_number():
    covered = Covered((1.0, 10.0), {"temperature": (23.0, 23.0)})
    assert covered.span("temperature", Units()) == "temperature of 23 [degC]"


@pytest.mark.parametrize("peak", [0.0, 0.05])
def test_of_a_frame_that_does_not_move_nobody_takes_a_share(springpot, write, peak):
    """At rest, or stuck in friction: what is left of its energy is rounding, or nothing."""
    stuck = """[structure]
mass = 1e3
stiffness = 1e6
damping = 0.02

[[damper]]
model = "spring + friction"
parameters = { k = 100, "friction.F" = 1.0 }
unit = "kN/m"
"""
    quiet = "".join(f"{0.02 * i:.2f},{peak * (i % 2)}\n" for i in range(40))
    record = write("time [s],acceleration [g]\n" + quiet, "quiet.csv")
    told = springpot("simulate", write(stuck, "stuck.toml"), "--record", record)
    assert told.code == 0, told.err
    assert "energy      0 kJ put in\n" in told.out
