"""Effects around a material of few relaxation times, between the lines of the first lattice."""

import numpy as np
import pytest

import springpot
from springpot.identification.material import SpectrumSearch
from springpot.identification.problem import relative_objective

FREQUENCY = np.geomspace(0.1, 50.0, 15)
WATER = (0.0, 5.0, 10.0, 15.0)
OMEGA = np.tile(2.0 * np.pi * FREQUENCY, len(WATER))
COLUMN = np.repeat(WATER, FREQUENCY.size)
TIMES = 10.0 ** np.arange(1, -5, -1)


def noise(level, seed):
    real, imaginary = np.random.default_rng(seed).normal(size=(2, OMEGA.size))
    return level * (real + 1j * imaginary)


def measured(level, seed=2):
    """One Maxwell element a decade, softened by water."""
    s = 1j * OMEGA * 10.0 ** (-COLUMN / 6.0)
    stiffness = 1e3 + 1e5 * np.sum(s * TIMES[:, None] / (1.0 + s * TIMES[:, None]), axis=0)
    disturbed = stiffness * (1.0 + noise(level, seed))
    return springpot.Measurement(OMEGA, disturbed, conditions={"water": COLUMN}, name="nylon")


@pytest.mark.parametrize("seed", [2, 3])
def test_shifts_are_those_of_the_material_and_not_of_the_lattice(seed):
    result = springpot.identify(measured(0.004, seed), "material + free-shift:water")
    factors = dict(zip(result.model.names, result.theta.tolist(), strict=True))
    # Relative to the second level, at which the factor is 1.
    for value in (0.0, 10.0, 15.0):
        expected = 10.0 ** (-(value - 5.0) / 6.0)
        assert factors[f"free-shift:water.a_{value:g}"] == pytest.approx(expected, rel=0.012)
    # The parameters follow a part of the noise, and nothing else is left.
    assert result.relative_rms < float(np.sqrt(np.mean(np.abs(noise(0.004, seed)) ** 2)))


@pytest.mark.soak
def test_more_freedom_never_comes_out_worse():
    data = measured(0.004)
    one = springpot.identify(data, "material + free-shift:water")
    both = springpot.identify(data, "material + free-shift:water + free-vertical-shift:water")
    assert both.relative_rms < 1.01 * one.relative_rms


@pytest.mark.soak
def test_a_column_behind_a_misfit_is_offered_to_a_master_curve():
    found = springpot.diagnose(measured(0.004))
    assert any(
        "mastercurve DATA --column water" in note and "free-shift:water" in note
        for note in found.notes
    )
    joined = springpot.diagnose(measured(0.004), "material + free-shift:water")
    assert "same conditions" not in joined.says


@pytest.mark.parametrize("begun", [(493.0, 1.0), (300.0, 0.9), (150.0, 0.01)])
def test_a_try_that_is_refused_is_none_of_the_last_steps(begun):
    """Along a bent valley a first step is too long: three of them that are refused led nowhere."""
    omega = np.geomspace(1.5, 35.0, 60)
    s, share = 1j * omega, omega / 181.0
    exact = 1.0 / (0.375 + 1.02 / s + 1.0 / (1.33 + 0.2 * s)) / (1.0 - share**2 + 0.1j * share)
    real, imaginary = np.random.default_rng(0).normal(size=(2, omega.size))
    data = springpot.Measurement(omega, exact * (1.0 + 0.002 * (real + 1j * imaginary)))
    model = springpot.parse_model("material + fixture-resonance")
    search = SpectrumSearch.of(model, data, relative_objective())
    start = search.refined(search.solve(search.u_of(np.array(begun))))
    end, _ = search.descend(start, 3, lines=search.about(start))
    assert end.cost < 0.97 * start.cost
