"""Two parts of a material that are needed together may as well be one spectrum of another shape: that is said."""

import numpy as np
import pytest

import springpot

OMEGA = np.geomspace(0.1, 1e3, 45)


def havriliak_negami(omega, alpha, gamma):
    """An asymmetric relaxation, which no two parts of the library make."""
    s = 1j * omega
    return 40.0 + 200.0 * (1.0 - (1.0 + (s * 0.05) ** alpha) ** -gamma)


@pytest.fixture(scope="module", params=[(0.6, 1.3, 0.001), (0.6, 0.3, 0.003)], ids=["wide", "skewed"])
def found(request):
    alpha, gamma, noise = request.param
    rng = np.random.default_rng(8)
    stiffness = havriliak_negami(OMEGA, alpha, gamma)
    real, imaginary = noise * rng.normal(size=(2, len(OMEGA)))
    stiffness = stiffness * (1.0 + real + 1j * imaginary)
    units = springpot.Units("kN/m", "mm")
    return springpot.diagnose(springpot.Measurement(OMEGA, stiffness, units=units), "fractional-zener")


def test_something_is_missing_but_no_part_is_named_with_confidence(found):
    assert found.verdict == "effect-missing"
    assert found.candidates[0].probability < 0.95
    assert "something of another shape" in found.says
