"""A motion recorded far more often than it turns is searched by fewer knots, else by all."""

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.misfit.residuals_of_tests import InTimePart
from springpot.numerics import ENOUGH, PRINTED, rms
from springpot.timetests.exponentials import QuickPart

COUNT = 10 * ENOUGH
CLOCK = np.arange(COUNT) / 1000.0


def quick(moved: np.ndarray) -> QuickPart:
    return QuickPart.of(InTimePart(TimeTest.of_history(CLOCK, moved, 3.0 * moved, "mm", "N")))


@pytest.mark.parametrize("hertz", [0.3, 3.0])
def test_a_slow_motion_is_as_near_by_fewer_knots(hertz):
    moved = np.sin(2.0 * np.pi * hertz * CLOCK) * np.minimum(1.0, CLOCK)
    part, every = quick(moved), quick(moved)
    vars(every)["with_fewer_knots"] = every.test
    knots = part.with_fewer_knots.loading
    assert len(knots.time) < COUNT / 2
    assert np.isin(part.t, knots.time).all()
    model, theta = springpot.parse_model("zener + time-delay"), np.array([2.0, 1.0, 0.4, 0.002])
    coarse = part.recorded(model, theta, 293.0)
    whole = every.recorded(model, theta, 293.0)
    assert rms(coarse.value - whole.value) < 3.0 * PRINTED * rms(whole.value)


def test_what_fewer_knots_would_miss_keeps_all():
    part = quick(np.sin(2.0 * np.pi * 120.0 * CLOCK) + np.sin(2.0 * np.pi * CLOCK))
    assert part.with_fewer_knots is part.test
