"""K of a sum of exponentials anywhere in the plane of s, and all its slopes, by differences."""

from dataclasses import replace

import numpy as np
import pytest

from springpot.rheology.intime import _pair, _times
from springpot.rheology.spectrum import Slopes, Spectrum

S = np.array([0.3 + 0.8j, -0.2 + 3.0j, 5.0 - 1.0j, 0.7 + 0.0j])
STEP = 1e-6


@pytest.fixture
def modes(rng):
    """Four rates, everything there, three parameters that move all of it."""
    by = Slopes(*rng.normal(size=(3, 3)), *rng.normal(size=(2, 4, 3)))
    rates, weights = np.sort(rng.uniform(0.5, 9.0, 4)), rng.uniform(1.0, 3.0, 4)
    return Spectrum(2.0, 0.7, 0.4, rates, weights, (0.1, 10.0), 0.0, by)


def stiffness(modes, s):
    """The sum, term by term."""
    found = modes.equilibrium + modes.viscosity * s + modes.mass * s**2
    for rate, weight in zip(modes.rates, modes.weights, strict=True):
        found = found + weight * s / (s + rate)
    return found


def moved(modes, i, step):
    return replace(
        modes,
        **{
            name: getattr(modes, name) + step * getattr(modes.by_theta, name)[..., i]
            for name in ("equilibrium", "viscosity", "mass", "rates", "weights")
        },
    )


def test_value_and_slope_along_s(modes):
    steep, bend, _, _ = modes.modes.around(S)
    value, plain_steep = modes.modes.at(S)
    np.testing.assert_allclose(value, stiffness(modes, S), rtol=1e-12)
    wanted = (stiffness(modes, S + STEP) - stiffness(modes, S - STEP)) / (2 * STEP)
    np.testing.assert_allclose(steep, wanted, rtol=1e-7)
    np.testing.assert_allclose(plain_steep, wanted, rtol=1e-7)
    after, before = (modes.modes.around(S + sign * STEP)[0] for sign in (1.0, -1.0))
    np.testing.assert_allclose(bend, (after - before) / (2 * STEP), rtol=1e-6)


def test_slopes_by_the_parameters(modes):
    _, _, by_theta, steep_by_theta = modes.modes.around(S)
    for i in range(3):
        ends = [moved(modes, i, sign * STEP).modes.at(S) for sign in (1.0, -1.0)]
        for k, slopes in ((0, by_theta), (1, steep_by_theta)):
            wanted = (ends[0][k] - ends[1][k]) / (2 * STEP)
            np.testing.assert_allclose(slopes[:, i], wanted, rtol=1e-6, atol=1e-8)


def test_on_the_axis_it_is_what_a_sweep_measures(modes):
    omega = np.geomspace(0.1, 100.0, 9)
    np.testing.assert_allclose(modes.stiffness(omega), stiffness(modes, 1j * omega), rtol=1e-12)
    wanted = [
        (moved(modes, i, STEP).stiffness(omega) - moved(modes, i, -STEP).stiffness(omega))
        / (2 * STEP)
        for i in range(3)
    ]
    np.testing.assert_allclose(modes.jacobian(omega), np.array(wanted).T, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(("viscosity", "spring"), [(0.1, 4.0), (6.0, 1.0)])
def test_a_mass_on_a_spring_and_dashpot_swings_or_creeps(modes, viscosity, spring):
    nothing = replace(
        modes,
        equilibrium=spring,
        viscosity=viscosity,
        mass=1.0,
        rates=np.zeros(0),
        weights=np.zeros(0),
    )
    found = np.sort_complex(_pair(nothing, viscosity + 1e-3, spring - 1e-3))
    np.testing.assert_allclose(found, np.sort_complex(np.roots([1.0, viscosity, spring])))


def test_the_times_of_a_record_are_its_finest_step_over_pi_and_its_length():
    assert _times(np.array([1.0, 2.0, 2.5, 5.0])) == pytest.approx((0.5 / np.pi, 4.0))
