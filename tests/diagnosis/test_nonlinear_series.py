"""A mount that hardens and a film that slips, in series with a specimen.

Integrated in time, then reduced here.

The library balances first harmonics only; the records here hold all of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import springpot
from soaked import soaked
from springpot.diagnosis.scan import applicable
from springpot.registry import plugins

SAMPLES = 256
SOFT = pytest.param({"stiff": 100.0, "cubic": 20.0}, marks=pytest.mark.soak)
QUARTIC = pytest.param({"force": 100.0, "power": 4}, marks=pytest.mark.soak)
OMEGA, X = (
    grid.ravel()
    for grid in np.meshgrid(
        2.0 * np.pi * np.geomspace(0.1, 10.0, 6), [0.3, 1.0, 2.0, 4.0], indexing="ij"
    )
)


def first_harmonic(rate, force, omega, cycles):
    """F_1 of the last of some cycles from rest; `force` and `rate` take the time and the state."""
    period = 2.0 * np.pi / omega
    last = period * (cycles - 1.0 + np.arange(SAMPLES) / SAMPLES)
    found = solve_ivp(
        rate,
        (0.0, period * cycles),
        [0.0],
        "LSODA",
        last,
        rtol=1e-7,
        atol=1e-9,
        max_step=period / 50,
    )
    return np.fft.rfft(force(last, found.y[0]))[1] * 2.0 / SAMPLES


def hardening_mount(omega, amplitude, k=100.0, c=4.0, stiff=300.0, cubic=60.0):
    """A Kelvin specimen that moves by y behind a mount of force stiff z + cubic z^3, z = x - y."""

    def mount(t, y):
        z = amplitude * np.cos(omega * t) - y
        return stiff * z + cubic * z**3

    return first_harmonic(lambda t, y: (mount(t, y) - k * y) / c, mount, omega, 5)


def slipping_film(omega, amplitude, k=100.0, c=20.0, force=60.0, power=3):
    """A Maxwell specimen between plates on which it slips at the speed (F / force)^power."""

    def rate(t, f):
        slip = np.sign(f) * np.abs(f / force) ** power
        return k * (-omega * amplitude * np.sin(omega * t) - f / c - slip)

    return first_harmonic(rate, lambda t, f: f, omega, 10)


def measured(law, **own):
    stiffness = np.array([law(*at, **own) / at[1] for at in zip(OMEGA, X, strict=True)])
    scatter = np.random.default_rng(1).standard_normal((2, len(X)))
    noisy = stiffness * (1.0 + 0.01 * (scatter[0] + 1j * scatter[1]))
    return springpot.Measurement(
        OMEGA, noisy, conditions={"amplitude": X}, units=springpot.Units("kN/m", "mm")
    )


@pytest.mark.soak
@pytest.mark.parametrize("own", [{}, SOFT], ids=["stiff", "soft"])
def test_a_hardening_spring_in_series_is_no_nonlinearity_of_the_material(own):
    some = ["hardening-mount", "cubic-stiffness", "payne", "friction", "series-spring"]
    found = springpot.diagnose(measured(hardening_mount, **own), "kelvin", only=some)
    assert found.verdict == "effect-missing"
    assert found.best.alike == ("hardening-mount",)
    stiff, cubic = own.get("stiff", 300.0), own.get("cubic", 60.0)
    assert found.best.parameters["k"].value == pytest.approx(stiff, rel=0.03)
    # K = stiff + 3/4 cubic Z^2 is twice as stiff at Xh.
    assert found.best.parameters["Xh"].value == pytest.approx(
        np.sqrt(stiff / (0.75 * cubic)), rel=0.05
    )


@pytest.mark.parametrize("own", [soaked({}), QUARTIC], ids=["cubic", "quartic"])
def test_slip_that_grows_with_the_stress_is_no_heat(own):
    found = springpot.diagnose(measured(slipping_film, **own), "maxwell")
    assert found.verdict == "effect-missing"
    assert found.best.alike == ("power-law-slip",)
    assert found.best.parameters["a"].value == pytest.approx(1.0 / own.get("power", 3), rel=0.05)
    assert found.best.parameters["F"].value == pytest.approx(own.get("force", 60.0), rel=0.1)


def test_at_one_amplitude_no_joint_is_told_from_what_goes_with_the_frequency():
    omega = np.geomspace(0.1, 10.0, 20)
    data = springpot.Measurement(omega, 1.0 + 1j * omega, conditions={"amplitude": np.ones(20)})
    asked = [plugins().effect(name) for name in ("hardening-mount", "power-law-slip", "friction")]
    assert [effect.name for effect in applicable(asked, data)] == ["friction"]
