"""What a damper takes and how warm that makes it."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.structure import Damper, Frame, GroundMotion, motion_of
from springpot.structure.answers import rises_of

STEP = 0.002
PULSE = GroundMotion(STEP, np.where(np.arange(2500) < 100, 3.0, 0.0), "pulse")
FRAME = """[structure]
mass = 1e5
stiffness = 8e7
damping = 0.02

[[damper]]
model = "maxwell{shift}"
parameters = {{ k = 40, c = 6{more} }}
unit = "kN/mm"
count = 2
slope = 30
heat_capacity = 500
{temperature}
"""
RECORD = "time [s],acceleration [g]\n" + "".join(
    f"{0.02 * i:.2f},{0.3 if i < 10 else 0.0}\n" for i in range(60)
)


def test_a_dashpot_alone_turns_all_that_the_ground_puts_in_into_heat():
    """c times the square of the speed, along the axis of each of three."""
    c, count, cosine, capacity = 2e5, 3.0, 0.8, 250.0
    dampers = (
        Damper(parse_model("dashpot"), np.array([c]), count=count, cosine=cosine),
        Damper(parse_model("dashpot"), np.array([c]), heat_capacity=capacity),
    )
    motion = motion_of(Frame([1e4], [4e6], dampers=dampers), PULSE)
    rate = motion.velocity[:, 0]
    squares = STEP * np.sum(rate**2)
    sloping, level = motion.work[-1]
    assert sloping == pytest.approx(c * cosine**2 * squares, rel=1e-3)
    assert level == pytest.approx(c * squares, rel=1e-3)
    assert count * sloping + level == pytest.approx(motion.energy["input"][-1], rel=1e-3)
    assert rises_of(motion) == [None, pytest.approx(level / capacity)]


def test_the_rise_is_told_and_whether_the_model_would_feel_it(springpot, write):
    record = write(RECORD, "record.csv")

    def simulated(**given: str):
        text = FRAME.format(**{"shift": "", "more": "", "temperature": "", **given})
        asked = springpot("simulate", write(text, "frame.toml"), "--record", record, "--json")
        (damper,) = asked.json["dampers"]
        assert damper["temperature_rise"] == pytest.approx(damper["energy"] / 500.0)
        return damper, asked.json["notes"]

    cold, (note,) = simulated()
    assert f"warms by {cold['temperature_rise']:.3g} K" in note
    assert "knows no temperature" in note
    shifted = {
        "shift": " + arrhenius-shift",
        "more": ', "arrhenius-shift.Ea" = 60',
        "temperature": "temperature = 20",
    }
    warm, (note,) = simulated(**shifted)
    assert warm["energy"] == pytest.approx(cold["energy"])
    # A Maxwell element that is warmer flows more easily, and is softer.
    share = float(note.partition("end at ")[2].split(" %")[0])
    assert 50.0 < share < 100.0
    told = springpot(
        "simulate",
        write(FRAME.format(shift="", more="", temperature=""), "f.toml"),
        "--record",
        record,
    ).out
    assert "warmer by [K]" in told
