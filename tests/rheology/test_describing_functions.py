"""Describing functions and third harmonics against forces computed in time, cycle by cycle.

The forces here are written from their definitions, sampled over a cycle and Fourier transformed;
nothing of the elements' own formulas enters.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import lambertw

from soaked import soaked
from springpot.registry import parse_model, plugins
from springpot.rheology import Points

SAMPLES = 2**15
ANGLE = 2.0 * np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES


def harmonics(force: np.ndarray) -> tuple[complex, complex]:
    """F_1 and F_3 of a force sampled over one cycle, x = X cos(angle)."""
    return tuple(2.0 * np.mean(force * np.exp(-1j * n * ANGLE)) for n in (1, 3))


def stop(x: np.ndarray, reach: float) -> np.ndarray:
    """Strain of a spring behind a slider that lets go at `reach`.

    The second cycle is the steady one.
    """
    strain, last, out = 0.0, x[-1], np.empty_like(x)
    for _ in range(2):
        for i, now in enumerate(x):
            strain = min(max(strain + now - last, -reach), reach)
            last = now
            out[i] = strain
    return out


def yielding(amplitude: float, k: float, force: float, n: float, beta: float) -> np.ndarray:
    """Steady force of a Bouc-Wen element, its differential equation integrated from either tip.

    Each integration covers half a cycle.
    """

    def rate(angle, z):
        speed = -amplitude * np.sin(angle) * k / force
        return speed * (1.0 - np.abs(z) ** n * (beta * np.sign(z * speed) + 1.0 - beta))

    def half(tip, angles=None):
        return solve_ivp(
            rate, (0.0, np.pi), [tip], "DOP853", angles, rtol=1e-11, atol=1e-13, max_step=0.02
        ).y[0]

    tip = brentq(lambda tip: half(tip)[-1] + tip, 0.0, 1.0, xtol=1e-13)
    falling = half(tip, ANGLE[: SAMPLES // 2])
    return force * np.concatenate([falling, -falling])


def powered(v: np.ndarray, exponent: float) -> np.ndarray:
    return np.sign(v) * np.abs(v) ** exponent


def touching(x: np.ndarray, b: float) -> np.ndarray:
    return np.sign(x) * np.maximum(np.abs(x) - b, 0.0)


FORCES = {
    "friction": [((0.7,), lambda x, v, F: F * np.sign(v))],
    "elasto-sliding": [
        ((2.0, F), lambda x, v, k, F: k * stop(x, F / k))
        for F in (0.1, 0.26, 0.65, 1.3, 1.95, 2.6, 5.0)
    ],
    "power-law-damper": [
        ((0.6, a), lambda x, v, F, a: F * powered(v, a)) for a in (0.05, 0.4, 1.0, 1.5, 2.0)
    ],
    "smooth-hysteresis": [
        (theta, lambda x, v, *theta: yielding(x[0] / np.cos(ANGLE[0]), *theta))
        for theta in (
            (2.0, 0.65, 1.0, 0.5),
            (2.0, 2.6, 1.7, 0.9),
            (2.0, 0.13, 4.0, 0.3),
            (1.0, 0.5, 0.7, 1.2),
        )
    ],
    "cubic-damping": [((0.3,), lambda x, v, c3: c3 * v**3)],
    "cubic-stiffness": [((k3,), lambda x, v, k3: k3 * x**3) for k3 in (0.4, -0.2)],
    "dead-zone": [
        ((2.0, b), lambda x, v, k, b: k * touching(x, b)) for b in (0.01, 0.3, 0.9, 1.29, 1.5)
    ],
    "crosstalk": [((0.3, 0.8), lambda x, v, F, phi: F * np.cos(ANGLE + phi))],
}
CASES = [(name, theta, force) for name, cases in FORCES.items() for theta, force in cases]


@pytest.mark.soak_cases(
    "1.3-0.8-smooth-hysteresis-(2.0, 0.13, 4.0, 0.3)",
    "1.3-0.8-smooth-hysteresis-(1.0, 0.5, 0.7, 1.2)",
    "1.3-0.8-smooth-hysteresis-(2.0, 0.65, 1.0, 0.5)",
    "1.3-0.8-smooth-hysteresis-(2.0, 2.6, 1.7, 0.9)",
)
@pytest.mark.parametrize(("name", "theta", "force"), CASES, ids=[f"{n}-{t}" for n, t, _ in CASES])
@pytest.mark.parametrize(("amplitude", "omega"), [(1.3, 0.8), soaked(0.4, 5.0)])
def test_first_and_third_harmonic_are_those_of_the_force_in_time(
    name, theta, force, amplitude, omega
):
    x, v = amplitude * np.cos(ANGLE), -omega * amplitude * np.sin(ANGLE)
    first, third = harmonics(force(x, v, *theta))
    effect = plugins().effect(name)
    at = Points(np.log([omega]), amplitude=np.array([amplitude]))
    scale = max(abs(first), np.max(np.abs(force(x, v, *theta)))) / amplitude
    predicted = effect.element.respond(np.array(theta), at).value[0]
    np.testing.assert_allclose(predicted, first / amplitude, atol=2e-7 * scale)
    np.testing.assert_allclose(
        effect.third_harmonic(np.array(theta), at)[0], third / amplitude, atol=2e-7 * scale
    )


@pytest.mark.parametrize("b", [0.05, 0.4, 0.9, 1.25, 1.31])
def test_play_moves_a_linear_specimen_by_the_first_harmonic_of_its_output(b):
    """Output of play = input - stop; the linear specimen answers each harmonic by itself."""
    x = 1.3 * np.cos(ANGLE)
    moved, _ = harmonics(x - stop(x, b))
    model = plugins().model("fractional-maxwell") + plugins().effect("backlash")
    own = {"k": 2.0, "c": 1.3, "alpha": 0.7}
    at = Points(np.log([0.5, 7.0]), amplitude=np.full(2, 1.3))
    bare = plugins().model("fractional-maxwell")
    specimen = bare.stiffness(bare.vector(own), at)
    measured = model.stiffness(model.vector(own | {"backlash.b": b}), at)
    np.testing.assert_allclose(
        measured, specimen * moved / 1.3, atol=1e-7 * np.max(np.abs(specimen))
    )


@pytest.mark.parametrize(("rho", "ratio"), [(0.1, 0.30), (0.25, 0.26), (0.5, 0.18), (0.75, 0.095)])
def test_harmonic_ratios_of_a_jenkins_element_known_from_elsewhere(rho, ratio):
    effect = plugins().effect("elasto-sliding")
    theta, at = np.array([1.0, rho]), Points(np.zeros(1), amplitude=np.ones(1))
    found = np.abs(effect.third_harmonic(theta, at) / effect.element.respond(theta, at).value)[0]
    assert found == pytest.approx(ratio, abs=0.006)


def test_the_energy_of_self_heating_is_that_of_the_loop():
    """Mean power of force times speed in time is what the heating element counts.

    K'' of the specimen is given.
    """
    k, omega, amplitude = 3.0 + 1.7j, 2.5, 0.6
    force = np.real(k * amplitude * np.exp(1j * ANGLE))
    power = np.mean(force * -omega * amplitude * np.sin(ANGLE))
    at = Points(np.log([omega]), amplitude=np.array([amplitude]))
    shift = plugins().effect("self-heating").element.respond(np.array([1.0]), at).value[0] * k.imag
    assert shift == pytest.approx(power, rel=1e-12)


@pytest.mark.parametrize("s", [0.01, 0.3, 3.0])
def test_a_specimen_is_kept_warm_by_what_it_loses_when_it_is_warm(s):
    own, omega, amplitude = (
        {"k1": 1.0, "k2": 5.0, "c": 1.0, "alpha": 0.6},
        np.geomspace(1, 100),
        0.5,
    )
    bare, at = plugins().model("fractional-zener"), Points.at(omega, amplitude=amplitude)
    model = bare + plugins().effect("self-heating")
    warm = model.stiffness(model.vector(own | {"self-heating.s": s}), at)
    slower = Points.at(omega * np.exp(-s * 0.5 * omega * warm.imag * amplitude**2))
    np.testing.assert_allclose(warm, bare.stiffness(bare.vector(own), slower), rtol=1e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["slower", "faster"])
def test_the_warmth_of_a_springpot_is_lamberts_function_of_its_heating(sign):
    """K'' falls by exp(-alpha h), so that h exp(alpha h) is the heating of the cold specimen.

    Cooled beyond 1 / e it has no steady temperature: times then change as far as is allowed.
    """
    model = parse_model("springpot + self-heating")
    s = sign * np.geomspace(1e-9, 1e12, 43)
    heat = s * 0.5 * np.sin(0.25 * np.pi)
    steady = lambertw(0.5 * heat).real / 0.5
    expected = np.where(0.5 * heat > -np.exp(-1.0), np.clip(steady, -60.0, 60.0), -60.0)
    at = Points.at(np.ones(1), amplitude=1.0)
    names = {"c": 1.0, "alpha": 0.5}
    theta = np.array([model.vector(names | {"self-heating.s": each}) for each in s])
    shift = -np.log(np.abs(model.stiffness(theta, at))[:, 0]) / 0.5
    np.testing.assert_allclose(shift, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("beyond", [-1e-3, 1e-3, 1e-5, 1e-7])
def test_beyond_the_last_steady_temperature_a_specimen_runs_away_to_a_hot_one(beyond):
    """Above its relaxation a Maxwell model makes the more loss the warmer it is, up to a peak.

    Just beyond the power at which the cold temperature ends, a step misses next to nothing for
    long: the hot one is come to all the same.
    """
    omega = 100.0

    def loss(shift):
        slow = omega * np.exp(-shift)
        return slow / (1.0 + slow**2)

    # The two steady temperatures h = s P(h) meet where h / P(h) is largest.
    end = brentq(lambda h: (loss(h + 1e-6) - loss(h - 1e-6)) / 2e-6 - loss(h) / h, 0.5, 1.5)
    s = end / loss(end) * (1.0 + beyond)
    places = (end, 60.0) if beyond > 0.0 else (0.0, end)
    slow = omega * np.exp(-brentq(lambda h: h - s * loss(h), *places))
    model = parse_model("maxwell + self-heating")
    theta = np.array([1.0, 1.0, s / (0.5 * omega)])
    (found,) = model.stiffness(theta, Points.at([omega], amplitude=1.0))
    assert found == pytest.approx(1j * slow / (1.0 + 1j * slow), rel=1e-6)


@pytest.mark.parametrize(
    ("softening", "exponent"), [("strain-softening", 3.0), ("shear-thinning", 1.0)]
)
def test_softening_keeps_to_the_range_of_numbers(softening, exponent):
    """A limit that a fit takes towards zero leaves almost no stiffness, and slopes are numbers."""
    at = Points.at([1e20, 1e22], amplitude=[1.0, 2.0])
    found = plugins().effect(softening).element.respond(np.array([1e-290, exponent]), at, 2)
    assert np.all(np.abs(found.value) < 1e-100)
    assert np.all(np.isfinite(found.by_theta))
    assert np.all(np.isfinite(found.by_log_omega))
