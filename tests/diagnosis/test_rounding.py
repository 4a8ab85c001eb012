"""What a file's few digits round away bounds the noise from below."""

import numpy as np
import pytest
from hidden_data import design

import springpot
from soaked import soaked
from springpot import Measurement
from springpot.measurement.scatter import rounding_steps


@pytest.mark.soak_cases("0", "1")
@pytest.mark.parametrize("seed", [0, 1, *map(soaked, range(2, 6))])
def test_three_digits_of_a_plateau_are_no_structure(seed):
    """Neighbours on a plateau are all rounded the same way; the noise is a quarter of a step."""
    at = design(60, 0.01, 100.0)
    exact = 100.0 + 50.0 * 1j * at.omega / (30.0 + 1j * at.omega)
    noise = 0.25 * np.random.default_rng(seed).normal(size=(2, 60))
    values = exact + noise[0] + 0.1j * noise[1]

    def written(part):
        step = 10.0 ** (np.floor(np.log10(np.abs(part))) - 2)
        return np.round(part / step) * step

    data = Measurement(at.omega, written(values.real) + 1j * written(values.imag))
    assert springpot.diagnose(data, "zener").verdict in ("adequate", "inconclusive")


@pytest.mark.soak_cases("False")
@pytest.mark.parametrize("turned", [False, True])
def test_a_constant_exact_column_is_not_taken_for_one_of_coarse_digits(turned):
    """The noise is that of the column beside it, and no third of the tens of an exact 90."""
    omega = np.geomspace(0.1, 10.0, 15)
    varied = 50.0 * omega * (1.0 + 0.002 * np.random.default_rng(1).normal(size=15))
    stiffness = varied + 90.0j if turned else 90.0 + 1j * varied
    data = Measurement(omega, stiffness)
    assert np.all(rounding_steps(data) == 0.0)
    # Written to a tenth, the column beside it tells of no finer one.
    told = rounding_steps(Measurement(omega, np.round(stiffness, 1)))
    np.testing.assert_allclose([told.real, told.imag], 0.1)
    if not turned:
        assert springpot.diagnose(data, "kelvin").error.noise_floor < 0.003


def test_steps_of_a_converter_bound_the_noise_too():
    """They are no round numbers: sweeps that agreed to the step had no noise at all."""
    omega = np.geomspace(0.1, 10.0, 12)
    exact = springpot.parse_model("zener").stiffness(np.array([30.0, 60.0, 40.0]), omega)
    steps = 1.3731 * np.round(np.stack([exact.real, exact.imag]) / 1.3731)
    values = np.tile(steps[0] + 1j * steps[1], 3)
    amplitude = np.repeat([0.1, 0.2, 0.4], 12)
    data = Measurement(np.tile(omega, 3), values, conditions={"amplitude": amplitude})
    assert rounding_steps(data) == pytest.approx(np.full(36, 1.3731 * (1.0 + 1.0j)))
