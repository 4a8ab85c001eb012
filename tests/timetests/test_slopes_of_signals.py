"""What a small lag of the force changes in a record, samples that are not counted included."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import plugins
from springpot.timetests import identify, predicted
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.score import TimeScan

MODEL = springpot.parse_model("zener + time-delay")
LATE = 0.01


@pytest.mark.parametrize("start", [0.0, 1.25])
def test_a_small_lag_is_foretold(start):
    """A motion that sets off at once, and one that had gone on before; both turn at samples."""
    t = np.linspace(0.0, 6.0, 481)
    x = np.sin(2.0 * np.pi * (t + start)) + 0.2 * np.sin(6.0 * np.pi * (t + start))
    blank = TimeTest.of_history(t, x, 0.0 * t, "mm", "N", control="displacement")
    theta = MODEL.theta(k1=1.0, k2=2.0, c=0.3, **{"time-delay.tau": LATE})
    noise = 0.01 * np.random.default_rng(1).normal(size=len(t))
    force = predicted(MODEL, theta, blank).value + noise
    test = TimeTest.of_history(t, x, force, "mm", "N", control="displacement")
    base = identify(test, springpot.parse_model("zener"))
    scan = TimeScan(base, quick_parts(parts_of_specimen([test])))
    [entry] = scan.entries([plugins().effect("time-delay")])["time-delay"]
    assert entry.values[0] == pytest.approx(LATE, rel=0.1)
    assert entry.leaves < 1.3 * len(t)
