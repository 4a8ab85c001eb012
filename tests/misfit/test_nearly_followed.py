"""What the fitted parameters follow but for a small share is no place to look for structure."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.measurement import Measurement
from springpot.misfit.frame import NoiseFrame

FREQUENCIES, AMPLITUDES = 3, 14
OMEGA = np.repeat([1.0, 10.0, 50.0], AMPLITUDES)
PATTERN = np.tile([1.0, -1.0], FREQUENCIES * AMPLITUDES // 2)


@pytest.mark.parametrize(("left", "columns"), [(0.05, 11), (0.5, 12)])
def test_one_shape_in_all_sweeps_needs_a_share_that_is_left(left, columns):
    """A constant storage at all three frequencies, which one parameter follows but for a share.

    Of 42 points even a twentieth is as long as a third of one point. The loss is free.
    """
    k = np.full(len(OMEGA), 1.0 + 1.0j)
    amplitude = np.tile(np.geomspace(0.1, 10.0, AMPLITUDES), FREQUENCIES)
    data = Measurement(OMEGA, k, conditions={"amplitude": amplitude})
    followed = (np.sqrt(1.0 - left**2) + left * PATTERN).astype(complex)
    frame = NoiseFrame(data, k, np.full(len(OMEGA), 1.0 + 1.0j), followed[None])
    assert frame.narrow.shape[1] == columns
    assert np.allclose(np.linalg.norm(frame.narrow, axis=0), 1.0)
