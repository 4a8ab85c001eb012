"""Numbers that no instrument gives are told as such, and end in no fault."""

import numpy as np
import pytest

import springpot
from springpot.errors import DataError

OMEGA = np.geomspace(0.1, 10.0, 12)
K = (1j * OMEGA) ** 0.3 * (1.0 + 0.01 * np.random.default_rng(2).standard_normal(12))


@pytest.mark.parametrize("size", [1e-200, 1e200])
@pytest.mark.parametrize("ask", [springpot.diagnose, springpot.identify])
def test_numbers_beyond_all_units_are_told(size, ask):
    with pytest.raises(
        DataError, match=r"size of storage and loss of .* cannot be fitted; is its unit right"
    ):
        ask(springpot.Measurement(OMEGA, size * K), "kelvin")
    with pytest.raises(
        DataError, match=r"frequency in rad/s of .* cannot be fitted; is its unit right"
    ):
        ask(springpot.Measurement(size * OMEGA, K), "kelvin")


@pytest.mark.parametrize("size", [1e-28, 1e28])
def test_the_unit_of_a_modulus_changes_no_fit(size):
    usual, other = (
        springpot.identify(springpot.Measurement(OMEGA, k * K), "kelvin") for k in (1.0, size)
    )
    assert other["c"].value == pytest.approx(size * usual["c"].value, rel=1e-6)
