"""The hum of the mains is taken off a response; what a specimen makes of a motion is not."""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.measurement.instrument import hum_in
from springpot.measurement.timenoise import said_of_strays, strays

TIME = np.arange(900) / 300.0
MOTION = np.sin(3.0 * np.pi * TIME)
NOISE = 0.01 * np.random.default_rng(1).normal(size=900)


def record(force, time=TIME, motion=MOTION):
    return TimeTest.of_history(
        time, motion, force, "mm", "N", control="displacement", name="record"
    )


@pytest.mark.parametrize("mains", [49.96, 60.03])
def test_a_hum_is_taken_off_and_told(mains):
    hum = 0.1 * np.sin(2.0 * np.pi * mains * TIME + 1.0)
    test = record(MOTION + NOISE + hum)
    assert test.response == pytest.approx(MOTION + NOISE, abs=0.005)
    assert f"record: the force holds the hum of the mains, {mains:.3g} Hz (0." in said_of_strays(
        test
    )


def test_two_lines_of_the_mains_are_found():
    hums = hum_in(
        MOTION + NOISE + 0.1 * np.sin(100.0 * np.pi * TIME) + 0.06 * np.cos(200.0 * np.pi * TIME),
        TIME,
        MOTION,
    )
    assert [round(hum.hertz) for hum in hums] == [50, 100]


@pytest.mark.parametrize("hertz", [10.0, 50.0 / 3.0, 25.0, 50.0])
def test_a_harmonic_of_the_motion_is_none(hertz):
    motion = np.sin(2.0 * np.pi * hertz * TIME)
    speed = np.cos(2.0 * np.pi * hertz * TIME)
    assert hum_in(motion + 0.3 * np.sign(speed) + NOISE, TIME, motion) == []


def test_a_recorder_slower_than_the_mains_tells_none():
    slow = slice(None, None, 4)
    hum = 0.1 * np.sin(100.0 * np.pi * TIME)
    assert hum_in((MOTION + NOISE + hum)[slow], TIME[slow], MOTION[slow]) == []


def test_a_force_that_stood_still_is_left_out():
    force = 2.0 * MOTION + NOISE
    force[341:350] = force[340]
    test = record(force)
    assert strays(test).tolist() == list(range(341, 350))
    assert "the force stood still from 1.133 to 1.163 s" in said_of_strays(test)


def test_a_channel_at_its_limit_did_not_stand_still():
    test = record(np.clip(2.0 * MOTION + NOISE, -1.5, 1.5))
    assert len(strays(test)) == 0
