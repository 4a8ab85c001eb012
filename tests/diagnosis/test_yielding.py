"""Yielding dampers and filled rubber.

Alike in K of the first harmonic, apart in what else the force holds.

The dampers are Bouc and Wen's differential equation, integrated in time here and reduced to
harmonics by a Fourier transform: nothing of the library's formulas enters.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import springpot
from soaked import soaked
from springpot.registry import parse_model
from springpot.rheology import Points

HERTZ = np.geomspace(0.3, 10.0, 6)
SIZES = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
OMEGA, X = (grid.ravel() for grid in np.meshgrid(2.0 * np.pi * HERTZ, SIZES, indexing="ij"))
SOLID = 50.0 + 30.0 * (1j * OMEGA) ** 0.4
SAMPLES, CYCLES = 1024, 6


def bouc_wen(amplitude, k, force, n, beta):
    """F_1 and F_3 over X of the last of some cycles from rest; x = X cos(angle)."""

    def rate(angle, z):
        speed = -amplitude * np.sin(angle) * k / force
        return speed * (1.0 - np.abs(z) ** n * (beta * np.sign(z * speed) + 1.0 - beta))

    last = 2.0 * np.pi * (CYCLES - 1.0 + np.arange(SAMPLES) / SAMPLES)
    found = solve_ivp(
        rate, (0.0, 2.0 * np.pi * CYCLES), [0.0], t_eval=last, rtol=1e-8, atol=1e-10, max_step=0.05
    )
    spectrum = np.fft.rfft(force * found.y[0]) * 2.0 / SAMPLES
    return spectrum[1] / amplitude, spectrum[3] / amplitude


def measured(stiffness, third=None, seed=1, noise=0.01):
    rng = np.random.default_rng(seed)
    scatter = rng.standard_normal((4, len(X)))
    harmonics = None
    if third is not None:
        harmonics = np.full((len(X), 2), 1e-4 + 0j)
        harmonics[:, 1] = third / stiffness + 0.5 * noise * (scatter[2] + 1j * scatter[3])
    return springpot.Measurement(
        OMEGA,
        stiffness * (1.0 + noise * (scatter[0] + 1j * scatter[1])),
        conditions={"amplitude": X},
        harmonics=harmonics,
        units=springpot.Units("kN/m", "mm"),
    )


def damper(*theta):
    """A solid beside a damper that yields: K and the third harmonic over X."""
    each = {size: bouc_wen(size, *theta) for size in SIZES}
    return SOLID + [each[x][0] for x in X], np.array([each[x][1] for x in X])


SHARP, DAHL = (100.0, 200.0, 2.0, 0.5), (100.0, 50.0, 1.0, 0.9)


@pytest.mark.soak_cases("theta0")
@pytest.mark.parametrize(
    "theta", [(100.0, 100.0, 1.0, 0.5), soaked(SHARP), soaked((100.0, 300.0, 1.0, 0.7))]
)
def test_a_damper_that_yields_gradually_is_no_filled_rubber(theta):
    found = springpot.diagnose(measured(damper(*theta)[0]), "fractional-kelvin")
    assert found.verdict == "effect-missing"
    assert found.best.effect == "smooth-hysteresis"
    assert all(
        candidate.probability < 0.2 for candidate in found.candidates if candidate.effect == "payne"
    )
    for name, value in zip(("k", "F"), theta[:2], strict=True):
        interval = found.best.parameters[name]
        assert interval.low < value < interval.high


@pytest.mark.soak
def test_where_k_alone_cannot_tell_them_apart_the_third_harmonic_does():
    stiffness, third = damper(*DAHL)
    alone = springpot.diagnose(measured(stiffness), "fractional-kelvin")
    assert {"payne", "smooth-hysteresis"} <= set(alone.best.alike)
    told = springpot.diagnose(measured(stiffness, third), "fractional-kelvin")
    assert told.best.effect == "smooth-hysteresis"
    assert "payne" not in told.best.alike


U = (X / 2.0) ** 0.6
RUBBER = SOLID + 80.0 * (1.0 + 0.6j * U) / (1.0 + U**2)


@pytest.mark.soak_cases("quiet")
@pytest.mark.parametrize("share", [soaked(0.0, id="silent"), pytest.param(0.02, id="quiet")])
def test_filled_rubber_whose_stress_is_nearly_a_sinusoid_is_payne(share):
    found = springpot.diagnose(measured(RUBBER, share * RUBBER), "fractional-kelvin")
    assert found.verdict == "effect-missing"
    assert found.best.alike == ("payne",)


def test_the_bound_is_half_of_what_an_elastic_law_would_make():
    """A cubic spring's third harmonic is a sixth of how its K moves with ln X.

    Payne may make half as much of its.
    """
    at = Points(np.zeros(3), amplitude=np.array([0.3, 1.0, 4.0]))
    moved = Points(np.zeros(3), amplitude=at.amplitude * np.exp(1e-5))
    for name, theta, share in (
        ("cubic-stiffness", [0.7], 1.0 / 6.0),
        ("payne", [3.0, 0.4, 1.1, 0.5], 1.0 / 12.0),
    ):
        model = parse_model(f"springpot + {name}")
        given = np.array([1.0, 0.0, *theta])
        slope = (model.stiffness(given, moved) - model.stiffness(given, at)) / 1e-5
        centre, radius = model.third_harmonic_range(given, at)
        most = np.abs(centre) + radius
        np.testing.assert_allclose(
            most * np.abs(model.stiffness(given, at)), share * np.abs(slope), rtol=1e-4
        )
    assert np.all(
        np.isinf(
            parse_model("springpot + backlash").third_harmonic_range(np.array([1.0, 0.5, 0.1]), at)[
                1
            ]
        )
    )


def test_a_warm_specimen_makes_no_harmonic_but_hides_no_other():
    at = Points(np.zeros(2), amplitude=np.ones(2))
    warm = parse_model("springpot + self-heating + friction")
    cold = parse_model("springpot + friction")
    values = {"c": 2.0, "alpha": 0.5, "friction.F": 0.3}
    third = warm.third_harmonic(warm.vector(values | {"self-heating.s": 0.0}), at)
    np.testing.assert_allclose(third, cold.third_harmonic(cold.vector(values), at))
