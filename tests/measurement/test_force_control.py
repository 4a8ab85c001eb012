"""Sweeps in which the amplitude moved: one for each temperature all the same."""

from dataclasses import replace

import numpy as np
import pytest

from springpot.measurement import sweeps_of
from wide_sweeps import CELSIUS, HERTZ, spectrum


@pytest.mark.parametrize("force_held", [False, True])
def test_each_temperature_is_a_sweep_whatever_the_amplitude_did_in_it(force_held):
    data = spectrum(np.random.default_rng(1), force_held=force_held)
    sweeps = sweeps_of(data)
    assert len(sweeps) == 21
    for sweep in sweeps:
        assert len(set(CELSIUS[sweep.rows])) == 1
        assert HERTZ[sweep.rows].tolist() == sorted(set(HERTZ))


def test_amplitudes_that_were_set_still_part_the_sweeps():
    """Four of them at each temperature, each held while the frequency was swept."""
    data = spectrum(np.random.default_rng(1))
    strain = np.repeat([1e-5, 1e-4, 1e-3, 1e-2], len(data))
    several = data.subset(np.tile(np.arange(len(data)), 4))
    several = replace(several, conditions={**several.conditions, "amplitude": strain})
    assert len(sweeps_of(several)) == 84
