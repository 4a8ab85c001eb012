"""Noise that is many times larger at the weak end of a rig is noise, not misfit."""

import numpy as np
import pytest

from springpot import Measurement
from springpot.distributions import autoregressive
from springpot.measurement.replicates import average_repeats
from springpot.measurement.scatter import Noise
from springpot.misfit.floor import as_given, fitted_to_floor, remembered, sharpened
from springpot.misfit.refit import refit
from springpot.misfit.residual_tests import battery
from springpot.registry import parse_model


def test_a_floor_holds_noise_that_the_quiet_points_do_not_tell():
    rng = np.random.default_rng(9)
    omega = np.tile(np.geomspace(0.3, 300.0, 12), 6)
    temperature = np.repeat(np.arange(6) * 10.0 + 273.0, 12)
    s = 1j * omega
    stiffness = 1.5 + 2.2 * 0.7 * s / (2.2 + 0.7 * s)
    # Nine times as large at the lowest frequency, where the torque is small.
    along = np.log(omega / omega.min()) / np.log(omega.max() / omega.min())
    noise = 0.01 * (1.0 + 8.0 * (1.0 - along) ** 2)
    noise = noise * (rng.normal(size=len(omega)) + 1j * rng.normal(size=len(omega)))
    data = Measurement(omega, stiffness * (1.0 + noise), conditions={"temperature": temperature})
    fitted = fitted_to_floor(parse_model("zener"), data)
    assert fitted.relative_rms == pytest.approx(fitted.floor, rel=0.3)


def test_a_misfit_that_swings_is_no_noise_that_rises():
    rng = np.random.default_rng(4)
    omega = np.geomspace(0.1, 100.0, 24)
    s = 1j * omega
    stiffness = 60.0 * (1.0 + 0.4 * s**0.5) * (1.0 + 0.08 * np.sin(3.0 * np.log(omega)))
    noise = 0.01 * (rng.normal(size=24) + 1j * rng.normal(size=24))
    data = Measurement(omega, stiffness * (1.0 + noise))
    fitted = fitted_to_floor(parse_model("fractional-kelvin"), data)
    assert fitted.floor < 0.03 < 0.05 < fitted.relative_rms


def test_a_point_far_from_the_others_does_not_tell_that_it_has_no_noise():
    """Frequencies in equal steps: the slow curves go through the first one of each sweep."""
    rng = np.random.default_rng(0)
    omega = np.tile(np.linspace(0.05, 18.0, 15), 4)
    scatter = 1.0 + 0.003 * (rng.normal(size=60) + 1j * rng.normal(size=60))
    data = Measurement(
        omega,
        80.0 * (0.8 + 0.5 * (1j * omega) ** 0.6) * scatter,
        conditions={"preload": np.repeat([0.2, 0.5, 1.0, 2.0], 15)},
    )
    fitted = fitted_to_floor(parse_model("fractional-kelvin"), data)
    shares = fitted.noise.parts.real / data.magnitude
    assert np.min(shares[::15]) > 0.9 * np.median(shares)


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_a_point_far_from_the_others_is_not_taken_for_the_surest(seed):
    """The same noise of the force at all frequencies: little of |K| but at the first of them."""
    rng = np.random.default_rng(seed)
    omega = np.linspace(0.05, 60.0, 24)
    exact = 300.0 * 1j * omega / (1.0 + 1j * omega)
    data = Measurement(omega, exact + 1.5 * (rng.normal(size=24) + 1j * rng.normal(size=24)))
    fitted = fitted_to_floor(parse_model("maxwell"), data)
    shares = np.abs(fitted.noise.parts) / data.magnitude
    assert shares[0] > 5.0 * np.median(shares)


@pytest.mark.soak_cases("1")
@pytest.mark.parametrize("seed", [1, 3])
def test_noise_of_one_size_in_all_of_k_is_not_taken_for_one_that_rises(seed):
    """A fit in units of |K| misses by less than that noise, and seems to scatter at the ends."""
    rng = np.random.default_rng(seed)
    omega = np.tile(np.geomspace(0.5, 25.0, 16), 4)
    celsius = np.repeat(np.arange(4) * 10.0, 16)
    s = 1j * omega * np.exp(14e3 * (1.0 / (celsius + 273.15) - 1.0 / 293.15))
    noise = 1.2 * (rng.normal(size=64) + 1j * rng.normal(size=64))
    exact = 2500.0 * 0.21 * s / (1.0 + 0.21 * s)
    data = Measurement(omega, exact + noise, conditions={"temperature": celsius})
    parts = fitted_to_floor(parse_model("maxwell + arrhenius-shift"), data).noise.parts.real
    assert np.median(parts) == pytest.approx(1.2, rel=0.2)
    assert np.max(parts) < 1.3 * np.min(parts)


def test_a_gain_that_grows_along_a_column_is_no_memory_of_the_noise():
    rng = np.random.default_rng(5)
    omega, current = np.tile(np.geomspace(0.3, 60.0, 10), 4), np.repeat(np.arange(4.0), 10)
    s = (0.3j * omega) ** 0.5
    scatter = 0.005 * rng.normal(size=40) + 0.014j * rng.normal(size=40)
    exact = 600.0 * s / (1.0 + s) * (1.0 + 0.005 * (1.0 + 0.4j) * current)
    data = Measurement(omega, exact + np.abs(exact) * scatter, conditions={"current": current})
    assert fitted_to_floor(parse_model("fractional-maxwell"), data).noise.memory == 0.0


def _swept(memory, misfit=0.0, seed=3):
    """Four amplitudes of a Zener body of which the errors go on from point to point."""
    rng = np.random.default_rng(seed)
    omega = np.tile(np.geomspace(0.1, 100.0, 20), 4)
    scatter = rng.normal(size=(80, 2)) @ [1.0, 1j]
    for row in range(1, 80):
        scatter[row] = memory * scatter[row - 1] + np.sqrt(1.0 - memory**2) * scatter[row]
    s = 1j * omega
    exact = 50.0 + 90.0 * s / (1.0 + s)
    data = exact * (1.0 + 0.01 * scatter + misfit * np.sin(3.0 * np.log(omega)))
    levels = {"amplitude": np.repeat([0.1, 0.2, 0.4, 0.8], 20)}
    return fitted_to_floor(parse_model("zener"), Measurement(omega, data, conditions=levels))


def test_errors_that_go_on_from_point_to_point_are_noise():
    fitted = _swept(0.6)
    assert fitted.noise.memory == pytest.approx(0.6, abs=0.2)
    assert fitted.floor == pytest.approx(0.014, rel=0.2)
    assert not battery(fitted.frame(), np.random.default_rng(0)).alarm


def test_noise_with_a_memory_excuses_no_misfit():
    assert _swept(0.0).noise.memory == 0.0
    assert battery(_swept(0.6, 0.03).frame(), np.random.default_rng(0)).alarm


def test_slow_curves_of_short_sweeps_hide_no_memory():
    """They follow most of what goes on from point to point: that is the other of two stories."""
    assert _swept(0.7, seed=1).noise.memory == pytest.approx(0.6, abs=0.2)


def test_noise_that_was_doubted_keeps_its_memory_as_it_was_given():
    omega = np.geomspace(0.1, 10.0, 12)
    data = Measurement(omega, 5.0 + 2.0j * omega, sd=np.full(12, 0.1 + 0.1j))
    averaged = average_repeats(data)
    noise = Noise(averaged.mean.sd, 20.0, "estimated", memory=0.5)
    assert as_given(refit(parse_model("kelvin"), averaged, noise, starts=2)).noise.memory == 0.5


def test_a_memory_in_one_sweep_is_told_unless_a_rival_explains_it_better():
    omega = np.geomspace(0.1, 100.0, 36)
    noise = autoregressive(np.random.default_rng(2).normal(size=(2, 36)), 0.7)
    stiffness = (5.0 + 2.0j * omega) * (1.0 + 0.01 * (noise[0] + 1j * noise[1]))
    data = average_repeats(Measurement(omega, stiffness))
    white = Noise(0.005 * np.abs(stiffness) * (1.0 + 1.0j), 20.0, "estimated")
    base = refit(parse_model("kelvin"), data, white, starts=2)
    found = remembered(base, 0.0)
    assert found.noise.memory == pytest.approx(0.6, abs=0.2)
    assert found.noise.sd[0].real > 1.3 * white.sd[0].real
    assert remembered(base, 100.0) is None
    assert remembered(found, 0.0) is None


def test_a_level_that_a_better_model_leaves_is_no_larger_noise_of_one_part():
    """Where storage and loss are equal but for such levels, all of them is in one part."""
    rng = np.random.default_rng(5)
    omega = np.tile(np.geomspace(1.0, 100.0, 16), 5)
    temperature = np.repeat([263.0, 283.0, 293.0, 313.0, 323.0], 16)
    shift = np.exp(7000.0 * (1.0 / temperature - 1.0 / 293.0))
    level = np.repeat([0.0, 0.018, -0.024, 0.01, 0.016], 16)
    noise = rng.normal(size=(2, len(omega))) * [[0.006], [0.0015]]
    stiffness = 20.0 * (1j * omega * shift) ** 0.38
    stiffness *= np.exp(level) + 0.0j
    stiffness += np.abs(stiffness) * (noise[0] + 1j * noise[1])
    data = Measurement(omega, stiffness, conditions={"temperature": temperature})
    base = fitted_to_floor(parse_model("springpot + arrhenius-shift"), data)
    better = parse_model("springpot + arrhenius-shift + vertical-shift")
    grown = refit(better, base.data, base.noise)
    assert grown.relative_rms > 2.0 * base.floor
    sharper = sharpened(base, grown)
    assert sharper is None or sharper.floor < 1.3 * base.floor
