"""Settings of the effects around a material, solved for side by side, are what each is alone."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.identification.material import SpectrumSearch
from springpot.identification.problem import default_objective


@pytest.fixture
def damper(rng) -> springpot.Measurement:
    omega = 2.0 * np.pi * np.geomspace(0.5, 50.0, 12)
    stiffness = 3.0e5 + 6.0e4 * (1j * omega) ** 0.5 - 0.8 * omega**2
    noise = 1.0 + 0.005 * (rng.normal(size=12) + 1j * rng.normal(size=12))
    warm = {"temperature": np.tile([20.0, 40.0], 6)}
    return springpot.Measurement(omega, stiffness * noise, conditions=warm)


@pytest.mark.suite_cases("arrhenius-shift + inertia")
@pytest.mark.parametrize(
    "effects",
    [
        "inertia + time-delay",  # K is linear in the weights, asked where it was measured
        "series-spring + inertia",  # K bends with the weights
        "arrhenius-shift + inertia",  # the lines go with the setting
    ],
)
def test_they_are_what_each_is_alone(damper, rng, effects):
    model = springpot.parse_model(f"material + {effects}").bound_to(damper.points)
    search = SpectrumSearch.of(model, damper, default_objective(damper))
    low, high = np.maximum(search.low, -3.0), np.minimum(search.high, 1.0)
    settings = [low + (high - low) * rng.uniform(size=len(low)) for _ in range(9)]
    together = search.solve_each([search.begun(u) for u in settings])
    alone = [search.solve(u) for u in settings]
    costs = np.array([(a.cost, b.cost) for a, b in zip(together, alone, strict=True)])
    assert np.isfinite(costs).any()
    np.testing.assert_allclose(costs[:, 0], costs[:, 1], rtol=1e-6)
    for a, b in zip(search.descend_each(together), alone, strict=True):
        np.testing.assert_allclose(a[0].cost, search.descend(b)[0].cost, rtol=1e-3)
