"""A material that softens with amplitude, a liquid that thins with the rate, and neither.

The material softens as a whole. The laws are typed here by hand; nothing of the library's elements
enters.
"""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from soaked import soaked
from springpot.diagnosis.scan import applicable
from springpot.registry import plugins

HERTZ = np.geomspace(0.1, 10.0, 6)
STRAINS = np.geomspace(0.02, 5.0, 7)
OMEGA, X = (grid.ravel() for grid in np.meshgrid(2.0 * np.pi * HERTZ, STRAINS, indexing="ij"))
GEL = "fractional-kelvin"
LIQUID = "maxwell"


def gel(omega):
    return 300.0 + 80.0 * (1j * omega) ** 0.3


def liquid(omega):
    return 500.0 / (1.0 + 1.0 / (1j * omega * 0.05))


def damping(x, limit=1.5, n=1.6):
    return 1.0 / (1.0 + (x / limit) ** n)


def thinned(omega, x, limit=8.0, m=0.7):
    return 1.0 / (1.0 + (omega * x / limit) ** m)


def slipping(omega, x, force=400.0, power=0.4):
    """A gel behind a film whose stress goes as a power of its speed.

    The film's share of the strain by iteration.
    """
    k, speed = gel(omega), 0.5 * omega * x
    for _ in range(500):
        film = force * speed**power / (speed / omega)
        speed = 0.5 * speed + 0.5 * omega * x * np.abs(k / (k + 1j * film))
    return 1.0 / (1.0 / k + 1.0 / (1j * film))


def payne(x):
    u = (x / 0.4) ** 0.6
    return 200.0 * (1.0 + 0.6j * u) / (1.0 + u**2)


def measured(stiffness, omega=OMEGA, x=X, seed=1, noise=0.01):
    scatter = np.random.default_rng(seed).standard_normal((2, len(x)))
    noisy = stiffness * (1.0 + noise * (scatter[0] + 1j * scatter[1]))
    return springpot.Measurement(
        omega, noisy, conditions={"amplitude": x}, units=springpot.Units("Pa", "-")
    )


@pytest.mark.soak_cases("fractional-kelvin-1.5-1.6")
@pytest.mark.parametrize(("limit", "n"), [(1.5, 1.6), soaked(0.5, 2.0), soaked(3.0, 0.9)])
@pytest.mark.parametrize("model", [GEL, soaked(None)])
def test_a_gel_that_softens_as_a_whole_is_no_slip(limit, n, model):
    found = springpot.diagnose(measured(gel(OMEGA) * damping(X, limit, n)), model)
    assert found.verdict == "effect-missing"
    assert found.best.alike == ("strain-softening",)
    for name, value in (("Xc", limit), ("n", n)):
        interval = found.best.parameters[name]
        assert interval.low < value < interval.high


@pytest.mark.soak_cases("maxwell")
@pytest.mark.parametrize("model", [LIQUID, soaked(None)])
def test_a_liquid_that_thins_with_the_rate_is_told_by_that_rate(model):
    found = springpot.diagnose(measured(liquid(OMEGA) * thinned(OMEGA, X)), model)
    assert found.verdict == "effect-missing"
    assert found.best.alike == ("shear-thinning",)
    interval = found.best.parameters["Vc"]
    assert interval.low < 8.0 < interval.high
    assert interval.unit == "1/s"


@pytest.mark.soak
def test_at_one_frequency_strain_and_rate_are_one_class():
    """omega X is X times a number there: both names stand, and neither is certain."""
    x = np.geomspace(0.02, 5.0, 14)
    omega = np.full(len(x), 2.0 * np.pi)
    found = springpot.diagnose(measured(gel(omega) * damping(x, 1.5, 0.8), omega, x), GEL)
    assert {"strain-softening", "shear-thinning"} <= set(found.best.alike)
    assert all(candidate.probability < 0.95 for candidate in found.candidates)


OTHERS = {
    "payne": lambda: gel(OMEGA) + payne(X),
    "friction": lambda: gel(OMEGA) + 4j * 5.0 / (np.pi * X),
    "power-law-slip": lambda: slipping(OMEGA, X),
    "cubic-stiffness": lambda: gel(OMEGA) - 0.75 * 8.0 * X**2,
}


@pytest.mark.soak_cases("payne")
@pytest.mark.parametrize(
    "effect", ["payne", *map(soaked, ("power-law-slip", "friction", "cubic-stiffness"))]
)
def test_what_changes_storage_and_loss_unequally_is_no_softening_of_the_whole(effect):
    found = springpot.diagnose(measured(OTHERS[effect]()), GEL)
    assert effect in found.best.alike
    assert not {"strain-softening", "shear-thinning"} & set(found.best.alike)


@pytest.mark.soak_cases("1")
@pytest.mark.parametrize("seed", [1, *map(soaked, range(2, 8))])
def test_a_material_that_does_not_soften_lacks_nothing(seed):
    assert springpot.diagnose(measured(gel(OMEGA), seed=seed), GEL).verdict == "adequate"


def test_at_one_amplitude_no_rate_is_made_of_the_frequency():
    """K / (1 + (omega X)^n) would be a factor of the frequency there, which no liquid has."""
    omega = 2.0 * np.pi * np.geomspace(0.1, 10.0, 25)
    held, varied = (
        np.full(25, 0.01),
        np.geomspace(0.01, 1.0, 25)[np.random.default_rng(2).permutation(25)],
    )
    thinning = plugins().effect("shear-thinning")
    assert applicable([thinning], measured(gel(omega), omega, held)) == []
    assert applicable([thinning], measured(gel(omega), omega, varied)) == [thinning]
