"""The regularised spectrum of any material: against spectra that are known in closed form."""

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.identification import regularised
from springpot.measurement import Measurement, Units

OMEGA = np.geomspace(1e-1, 1e3, 30)


def identified(expression, theta, level=0.002, seed=5, factor=1.0, fitted="material"):
    exact = factor * springpot.parse_model(expression).stiffness(np.array(theta), OMEGA)
    rng = np.random.default_rng(seed)
    scatter = rng.normal(size=len(OMEGA)) + 1j * rng.normal(size=len(OMEGA))
    data = Measurement(OMEGA, exact * (1 + level * scatter), units=Units("kN/m", "mm"), name="made")
    return springpot.identify(data, fitted)


def inside(spectrum, margin=3.0):
    return (spectrum.rates > margin * spectrum.seen[0]) & (
        spectrum.rates < spectrum.seen[1] / margin
    )


@pytest.mark.parametrize("alpha", [0.3, 0.6])
def test_a_springpot_has_the_power_law_that_its_formula_says(alpha):
    """c s^alpha has H(r) = c sin(pi alpha) / pi r^alpha (Schiessel et al. 1995)."""
    spectrum = identified("springpot", [50.0, alpha]).spectrum
    here = inside(spectrum)
    known = 50.0 * np.sin(np.pi * alpha) / np.pi * spectrum.rates[here] ** alpha
    np.testing.assert_allclose(spectrum.density[here], known, rtol=0.1)
    assert spectrum.seen == pytest.approx((OMEGA[0], OMEGA[-1]))
    assert len(spectrum.peaks) == 0


def test_it_gives_the_stiffness_back_to_within_the_noise():
    found = identified("fractional-zener", [300.0, 200.0, 30.0, 0.4])
    spectrum, s = found.spectrum, 1j * OMEGA
    maxwell = s / (s + spectrum.rates[:, None])
    again = (
        spectrum.equilibrium + spectrum.viscosity * s + spectrum.step * spectrum.density @ maxwell
    )
    exact = springpot.parse_model("fractional-zener").stiffness(
        np.array([300.0, 200.0, 30.0, 0.4]), OMEGA
    )
    assert np.max(np.abs(again / exact - 1.0)) < 0.005
    misfit = np.abs(again / found.measurement.stiffness - 1.0) ** 2
    variance = found.fit.cost / found.fit.dof
    assert np.sum(misfit) == pytest.approx(
        2 * len(OMEGA) * variance, rel=1e-2
    )  # the discrepancy principle


def test_no_weight_is_negative_and_the_band_holds_the_line():
    spectrum = identified("zener-2", [100.0, 80.0, 8.0, 120.0, 1.0]).spectrum
    assert np.all(spectrum.density >= 0.0)
    assert np.all(spectrum.low >= 0.0)
    assert np.all(spectrum.low <= spectrum.density)
    assert np.all(spectrum.density <= spectrum.high)


def test_two_modes_far_apart_are_two_peaks():
    spectrum = identified("zener-2", [100.0, 80.0, 80.0, 120.0, 1.0]).spectrum
    assert sorted(spectrum.rates[spectrum.peaks]) == pytest.approx([1.0, 120.0], rel=0.4)
    low, high = spectrum.within(0.9)
    assert low < 1.0 < 120.0 < high


def test_more_noise_is_smoother_and_less_certain():
    quiet, loud = (
        identified("zener-2", [100.0, 80.0, 80.0, 120.0, 1.0], level).spectrum
        for level in (0.001, 0.05)
    )
    assert quiet.density.max() > 1.2 * loud.density.max()
    here = inside(quiet)
    assert np.mean((loud.high - loud.low)[here]) > 3.0 * np.mean((quiet.high - quiet.low)[here])


def test_another_unit_of_stiffness_changes_the_numbers_alone():
    one, ten = (
        identified("springpot", [50.0, 0.4], factor=factor).spectrum for factor in (1.0, 1e6)
    )
    np.testing.assert_allclose(
        ten.density, 1e6 * one.density, rtol=1e-5, atol=1e-3 * one.density.max()
    )


def test_effects_around_the_material_stay_as_they_were_found():
    found = identified(
        "fractional-maxwell + inertia", [400.0, 60.0, 0.5, 1e-4], fitted="material + inertia"
    )
    spectrum = found.spectrum
    plain = identified("fractional-maxwell", [400.0, 60.0, 0.5]).spectrum
    here = inside(plain, 10.0)
    np.testing.assert_allclose(spectrum.density[here], plain.density[here], rtol=0.3)


def test_the_same_generator_gives_the_same_band():
    found = identified("springpot", [50.0, 0.4])
    first, again, other = (
        regularised(found.fit, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert np.array_equal(first.high, again.high)
    assert not np.array_equal(first.high, other.high)
    assert np.array_equal(first.density, other.density)


def test_a_network_of_elements_has_no_spectrum_to_choose():
    found = identified("springpot", [50.0, 0.4], fitted="springpot")
    assert found.spectrum is None
    assert "spectrum" not in found.to_dict()
    with pytest.raises(ModelError, match="springpot"):
        regularised(found.fit, np.random.default_rng(0))


def test_plain_data_give_the_stiffness_back():
    found = identified("fractional-zener", [300.0, 200.0, 30.0, 0.4])
    row, s = found.to_dict()["spectrum"], 1j * OMEGA
    assert set(row) == {
        "rates",
        "weights",
        "low",
        "high",
        "unit",
        "equilibrium",
        "viscosity",
        "seen",
    }
    assert (row["unit"], row["viscosity"]["unit"]) == ("kN/m", "kN s/m")
    lines = np.array(row["weights"])[:, None] * s / (s + np.array(row["rates"])[:, None])
    again = row["equilibrium"]["value"] + row["viscosity"]["value"] * s + lines.sum(axis=0)
    assert np.max(np.abs(again / found.measurement.stiffness - 1.0)) < 0.01
