import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Measurement, with_noise


@pytest.fixture
def exact():
    omega = np.linspace(1.0, 90.0, 4000)
    return Measurement(omega, np.full(4000, 300.0 + 120.0j))


def test_noise_is_that_of_eq_53(exact):
    """Redo eq. (53), (17), (43) in complex numbers: force times conj(displacement) / its square."""
    r = np.random.default_rng(5).uniform(size=(4, len(exact)))
    q = 0.005 - 0.01j
    u = exact.stiffness * q
    noisy_u = u.real * (1 + 0.02 * r[0]) + 1j * u.imag * (1 + 0.02 * r[1])
    noisy_q = q.real * (1 + 0.02 * r[2]) + 1j * q.imag * (1 + 0.02 * r[3])
    got = with_noise(exact, 0.02, np.random.default_rng(5))
    np.testing.assert_allclose(got.stiffness, noisy_u / noisy_q, rtol=1e-12)


def test_one_sided_noise_cancels_on_average_but_scatters(exact):
    spread = []
    for symmetric in (False, True):
        noisy = with_noise(exact, 0.01, np.random.default_rng(1), symmetric=symmetric)
        error = noisy.stiffness / exact.stiffness - 1
        assert abs(error.mean()) < 5e-4
        spread.append(np.std(error))
    # A uniform number from (-1, 1) scatters twice as much as one from (0, 1).
    assert spread[1] == pytest.approx(2 * spread[0], rel=0.05)


@pytest.mark.parametrize("level", [0.0, -0.1, 1.5, float("nan")])
def test_a_level_out_of_range_is_refused(exact, level):
    with pytest.raises(DataError, match="noise level"):
        with_noise(exact, level, np.random.default_rng(0))
