"""A mode too fast for the tests is a dashpot: its two parameters make nothing else of it."""

from dataclasses import replace

import numpy as np

import springpot
from springpot.measurement import Measurement, TimeTest, Units
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.timetests import identify
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.score import TimeScan

OMEGA, T = 2.0 * np.pi * np.geomspace(0.05, 50.0, 40), np.geomspace(0.1, 100.0, 40)


def test_a_mode_too_fast_does_not_hide_a_mass():
    """Moved by a million times themselves they made less than nothing of a mass.

    So it was taken for what the model's own parameters can follow, and never fitted.
    """
    noise = np.random.default_rng(4).normal(size=(3, len(T)))
    stiffness = 600.0 + 1.6j * OMEGA - 0.02 * OMEGA**2
    off = 1.0 + 0.01 * (noise[0] + 1j * noise[1])
    swept = Measurement(OMEGA, stiffness * off, units=Units("Pa"), name="swept")
    held = TimeTest.of_relaxation(T, 600.0 * (1.0 + 0.01 * noise[2]), "Pa", name="held")
    fit = identify([swept, held], springpot.parse_model("prony-1"))
    # As fast as a search may leave it.
    k0, k, tau = fit.theta
    base = replace(fit, theta=np.array([k0, k * tau / 2e-10, 2e-10]))
    scan = TimeScan(base, quick_parts(parts_of_specimen([swept, held])))
    inertia = springpot.plugins().effect("inertia")
    [entry, *_] = scan.entries([inertia])["inertia"]
    assert entry.drop > 0.5 * float(scan.residual @ scan.residual)
