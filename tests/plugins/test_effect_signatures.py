"""The signature of each effect to first order.

What it does to storage and loss, and how that varies.

One test for each row of the matrix of signatures, from formulas written here by hand.
"""

from __future__ import annotations

import numpy as np
import pytest
from effects_common import BASES, EFFECTS, POINTS, base, grown

from springpot.rheology import (
    FULL,
    Points,
    balanced_series,
    fixed_side_wave,
    heated,
    mass,
    moving_side_wave,
    spring,
)

SMALL = 1e-6
W, X, T, TR = POINTS.omega, POINTS.amplitude, POINTS.temperature, POINTS.reference_temperature
ZENER = base("fractional-zener")
THETA = ZENER.vector(BASES["fractional-zener"])
RESPONSE = ZENER.network.respond(THETA, POINTS, FULL)
K = RESPONSE.value
SLOPE = RESPONSE.by_log_omega / K


def measured(name, at=POINTS, **own):
    model = ZENER + EFFECTS[name]
    return model.stiffness(
        model.vector(BASES["fractional-zener"] | {f"{name}.{k}": v for k, v in own.items()}), at
    )


def same(found, expected, order=SMALL):
    np.testing.assert_allclose(
        found, np.broadcast_to(expected, found.shape), rtol=0, atol=20 * order
    )


PARALLEL = {
    "parallel-spring": ({"k": 0.3}, 0.3 + 0j),
    "parallel-dashpot": ({"c": 0.3}, 0.3j * W),
    "parallel-springpot": ({"c": 0.3, "alpha": 0.4}, 0.3 * (1j * W) ** 0.4),
    "relaxation-mode": ({"k": 0.3, "tau": 2.0}, 0.3 * 2j * W / (1 + 2j * W)),
    "diffusion": ({"k": 0.3, "tau": 2.0}, 0.3 * (1 - np.tanh((2j * W) ** 0.5) / (2j * W) ** 0.5)),
    "inertia": ({"m": 0.3}, -0.3 * W**2 + 0j),
    "basset": ({"c": 0.3}, 0.3 * W**1.5 * np.exp(0.75j * np.pi)),
    "hysteretic-loss": ({"h": 0.3}, 0.3j + 0 * W),
    "friction": ({"F": 0.3}, 4j * 0.3 / (np.pi * X)),
    "cubic-stiffness": ({"k3": -0.3}, -0.75 * 0.3 * X**2 + 0j),
    "cubic-damping": ({"c3": 0.3}, 0.75j * 0.3 * W**3 * X**2),
    "crosstalk": ({"F": 0.3, "phi": 0.5}, 0.3 * np.exp(0.5j) / X),
    "entropic-spring": ({"k": 0.3}, 0.3 * T / TR + 0j),
    "arrhenius-dashpot": (
        {"c": 0.3, "Ea": 20.0},
        0.3j * W * np.exp(20e3 / 8.314462618 * (1 / T - 1 / TR)),
    ),
    "arrhenius-springpot": (
        {"c": 0.3, "alpha": 0.4, "Ea": 20.0},
        0.3 * (1j * W * np.exp(20e3 / 8.314462618 * (1 / T - 1 / TR))) ** 0.4,
    ),
    "rig-drag": ({"c": 0.3}, 0.3j * W),
}


@pytest.mark.parametrize("name", PARALLEL)
def test_parallel_effects_add_to_the_stiffness(name):
    own, added = PARALLEL[name]
    np.testing.assert_allclose(measured(name, **own) - K, added, rtol=1e-9, atol=1e-13)


SERIES = {
    "series-spring": ({"k": 5.0}, 0.2 + 0j),
    "series-dashpot": ({"c": 5.0}, 1 / (5j * W)),
    "series-springpot": ({"c": 5.0, "alpha": 0.4}, 0.2 * (1j * W) ** -0.4),
    "retardation-mode": ({"k": 5.0, "tau": 2.0}, 0.2 / (1 + 2j * W)),
    "frame-resonance": (
        {"k": 5.0, "omega_r": 9.0, "zeta": 0.2},
        0.2 / (1 - (W / 9) ** 2 + 0.4j * W / 9),
    ),
}


@pytest.mark.parametrize("name", SERIES)
def test_series_effects_add_to_the_compliance(name):
    own, added = SERIES[name]
    np.testing.assert_allclose(1 / measured(name, **own) - 1 / K, added, rtol=1e-9, atol=1e-13)


e = 1e-6
CHAIN = {
    "time-delay": ({"tau": e}, -1j * W),
    "filter-mismatch": ({"tau": e}, -1j * W),
    "phase-error": ({"phi": e}, 1j),
    "gain-error": ({"g": e}, 1.0),
    "fixture-resonance": ({"omega_r": e**-0.5, "zeta": 1e-4}, W**2 - 2e-4j * W * e**-0.5),
    "intrinsic-nonlinearity": ({"q": -e}, -(X**2)),
    "vertical-shift": ({"n": e}, np.log(T / TR)),
    "frequency-error": ({"e": e}, SLOPE),
    "arrhenius-shift": ({"Ea": e}, SLOPE * 1e3 / 8.314462618 * (1 / T - 1 / TR)),
    "wlf-shift": ({"C1": e, "C2": 100.0}, -SLOPE * np.log(10) * (T - TR) / (100 + T - TR)),
    "self-heating": ({"s": e}, -SLOPE * 0.5 * W * X**2 * K.imag),
}


@pytest.mark.parametrize("name", CHAIN)
def test_chain_and_shift_effects_change_the_logarithm(name):
    own, relative = CHAIN[name]
    same((measured(name, **own) / K - 1) / e, relative, order=3e-5)


def test_the_two_signs_of_a_filter_belong_to_the_two_channels():
    np.testing.assert_allclose(measured("filter-mismatch", tau=0.3), K / (1 + 0.3j * W), rtol=1e-12)
    np.testing.assert_allclose(
        measured("filter-mismatch", tau=-0.3), K * (1 + 0.3j * W), rtol=1e-12
    )


def test_specimen_inertia_is_a_third_of_the_mass_or_minus_a_sixth():
    same((measured("specimen-inertia", m=e) - K) / e, -(W**2) / 3, order=1e-5)
    same((measured("specimen-inertia-fixed", m=e) - K) / e, W**2 / 6, order=1e-5)


def test_specimen_inertia_is_the_wave_in_a_bar_of_many_slices():
    """A ladder of small masses and springs, solved slice by slice, is the wave.

    Both ends are checked.
    """
    slices, m = 4000, 0.4
    stiffness, mass = K * slices, m / slices
    # From the fixed end outwards: displacement and force of each slice, masses halved at the ends.
    x, force = np.zeros_like(K), np.ones_like(K)
    for i in range(slices):
        x = x + force / stiffness
        force = force - mass * W**2 * x * (0.5 if i == slices - 1 else 1.0)
    np.testing.assert_allclose(measured("specimen-inertia", m=m), force / x, rtol=1e-6)
    np.testing.assert_allclose(measured("specimen-inertia-fixed", m=m), 1 / x, rtol=1e-6)


@pytest.mark.parametrize("size", [1e-3, 0.019, 0.021, 0.5, 30.0])
def test_the_power_series_of_the_wave_meets_the_closed_form(size):
    u = size * np.exp(1j * np.array([0.3, 1.0, 2.0, 3.0]))
    for name, exact in (
        ("specimen-inertia", lambda z: z / np.tan(z)),
        ("specimen-inertia-fixed", lambda z: z / np.sin(z)),
    ):
        wave = EFFECTS[name].composition(spring(), mass())
        # At omega = 1 rad/s and K = 1, u is the mass itself, and the element takes complex ones.
        value = wave.respond(np.stack([np.ones(4), u], axis=-1), Points(np.zeros(1))).value[:, 0]
        np.testing.assert_allclose(value, exact(np.sqrt(u)), rtol=3e-13)


def test_specimen_inertia_far_beyond_the_first_resonance_stays_finite():
    at = Points(np.log(np.array([1e2, 1e4, 1e6])))
    for name in ("specimen-inertia", "specimen-inertia-fixed"):
        model, theta = grown("fractional-maxwell", name)
        response = model.network.respond(theta, at, FULL)
        assert np.all(np.isfinite(response.value))
        assert np.all(np.isfinite(response.by_theta))


def test_elasto_sliding_knows_no_rate_and_loses_most_at_half_slip():
    k, force = 2.0, 1.0
    x = np.array([0.1, 0.5, 1.0, 5.0, 5e4])
    element = EFFECTS["elasto-sliding"].element
    value = element.respond(np.array([k, force]), Points(np.zeros(5), amplitude=x)).value
    np.testing.assert_array_equal(value[:2], k)
    assert value[2].imag == pytest.approx(k / np.pi)
    assert value[4] == pytest.approx(4j * force / (np.pi * 5e4), rel=1e-2)
    fast = element.respond(np.array([k, force]), Points(np.full(5, 3.0), amplitude=x)).value
    np.testing.assert_array_equal(value, fast)


@pytest.mark.parametrize("a", [0.3, 1.0, 1.7])
def test_power_law_damper_has_no_storage_and_two_power_laws(a):
    element, theta = EFFECTS["power-law-damper"].element, np.array([0.5, a])
    at = Points(np.log([1.0, 3.0, 1.0]), amplitude=np.array([1.0, 1.0, 2.0]))
    value = element.respond(theta, at).value
    np.testing.assert_array_equal(value.real, 0.0)
    assert value[1].imag / value[0].imag == pytest.approx(3.0**a)
    assert value[2].imag / value[0].imag == pytest.approx(2.0 ** (a - 1))
    if a == 1.0:
        assert value[0].imag == pytest.approx(0.5)


def test_dead_zone_stiffens_with_amplitude_and_loses_nothing():
    x = np.array([0.3, 0.6, 1.0, 10.0, 1e6])
    value = (
        EFFECTS["dead-zone"]
        .element.respond(np.array([2.0, 0.5]), Points(np.zeros(5), amplitude=x))
        .value
    )
    assert value[0] == 0.0
    assert np.all(np.diff(value.real) > 0)
    np.testing.assert_array_equal(value.imag, 0.0)
    assert value[-1].real == pytest.approx(2.0, rel=1e-5)


def test_payne_halves_at_its_amplitude_where_the_loss_peaks():
    x = np.array([1e-6, 0.9, 1.0, 1.1, 1e6])
    theta = np.array([2.0, 0.4, 1.0, 0.6])
    value = EFFECTS["payne"].element.respond(theta, Points(np.zeros(5), amplitude=x)).value
    assert value[0].real == pytest.approx(2.0, rel=1e-3)
    assert value[2] == pytest.approx(1.0 + 0.8j)
    assert value[2].imag > max(value[1].imag, value[3].imag)
    assert abs(value[4]) < 2e-3


def test_temperature_superposes_what_arrhenius_or_wlf_shifted():
    for name, own, log_shift in (
        ("arrhenius-shift", {"Ea": 60.0}, 60e3 / 8.314462618 * (1 / T - 1 / TR)),
        ("wlf-shift", {"C1": 8.86, "C2": 101.6}, -np.log(10) * 8.86 * (T - TR) / (101.6 + T - TR)),
    ):
        at_reference = ZENER.stiffness(THETA, Points(POINTS.log_omega + log_shift))
        np.testing.assert_allclose(measured(name, **own), at_reference, rtol=1e-9)


def test_wlf_survives_its_pole():
    at = Points(
        np.zeros(4), temperature=np.array([150.0, 197.9, 198.0, 198.1]), reference_temperature=298.0
    )
    model = ZENER + EFFECTS["wlf-shift"]
    theta = model.vector(BASES["fractional-zener"] | {"wlf-shift.C1": 15.0, "wlf-shift.C2": 100.0})
    response = model.network.respond(theta, at, FULL)
    assert np.all(np.isfinite(response.value))
    assert np.all(np.isfinite(response.by_theta))
    glass = ZENER.stiffness(THETA, np.exp(60.0))
    np.testing.assert_allclose(response.value, glass[0], rtol=1e-9)


LINEAR_IN_PLANE = {
    "stiffness": lambda new, old: new - old,
    "compliance": lambda new, old: 1 / new - 1 / old,
    "log-complex": lambda new, old: np.log(new / old),
}
OF_THE_SPECIMEN = (heated, moving_side_wave, fixed_side_wave, balanced_series)
OF_THE_DEVICE = [
    effect
    for effect in EFFECTS.values()
    if effect.plane != "shift" and effect.composition not in OF_THE_SPECIMEN
]


@pytest.mark.parametrize("effect", OF_THE_DEVICE, ids=lambda effect: effect.name)
def test_the_change_in_its_own_plane_does_not_depend_on_the_model(effect):
    change = []
    for base_name, values in BASES.items():
        model, theta = grown(base_name, effect.name)
        old = base(base_name)
        pair = model.stiffness(theta, POINTS), old.stiffness(old.vector(values), POINTS)
        change.append(LINEAR_IN_PLANE[effect.plane](*pair))
    np.testing.assert_allclose(change[0], change[1], rtol=1e-9, atol=1e-12)


def test_smooth_hysteresis_is_a_spring_when_small_and_friction_when_large():
    x = np.array([1e-4, 1e5])
    k, force, _, beta = theta = np.array([2.0, 0.5, 1.0, 0.5])
    value = (
        EFFECTS["smooth-hysteresis"].element.respond(theta, Points(np.zeros(2), amplitude=x)).value
    )
    assert value[0] == pytest.approx(k, rel=1e-3)
    assert value[1] == pytest.approx(4j * force / (np.pi * x[1]), rel=3e-3)
    # To first order in z the way down is z - (2 beta - 1) z^2 / 2, then z + z^2 / 2: a loop of 4
    # beta / 3 Z^3.
    area = 4.0 * beta * k**2 * x[0] ** 3 / (3.0 * force)
    assert value[0].imag == pytest.approx(area / (np.pi * x[0] ** 2), rel=1e-3)


def test_sharp_smooth_hysteresis_is_elasto_sliding():
    x = np.geomspace(0.05, 20.0, 9)
    at = Points(np.zeros(9), amplitude=x)
    smooth = (
        EFFECTS["smooth-hysteresis"].element.respond(np.array([2.0, 0.5, 200.0, 0.5]), at).value
    )
    sharp = EFFECTS["elasto-sliding"].element.respond(np.array([2.0, 0.5]), at).value
    np.testing.assert_allclose(smooth, sharp, atol=0.01 * 2.0)


def test_dahl_friction_has_a_loop_of_two_exponentials():
    """If n = beta = 1 the falling half is z = (1 + Z) exp((x - X) k / F) - 1; Z = tanh(k X / F)."""
    k, force, amplitude = 2.0, 0.5, 0.4
    angle = (np.arange(4096) + 0.5) * np.pi / 4096
    reach = k * amplitude / force
    falling = (1.0 + np.tanh(reach)) * np.exp(reach * (np.cos(angle) - 1.0)) - 1.0
    theta, at = np.array([k, force, 1.0, 1.0]), Points(np.zeros(1), amplitude=np.array([amplitude]))
    effect = EFFECTS["smooth-hysteresis"]
    for n, found in (
        (1, effect.element.respond(theta, at).value),
        (3, effect.third_harmonic(theta, at)),
    ):
        expected = 2.0 * force / amplitude * np.mean(falling * np.exp(-1j * n * angle))
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_softening_of_the_whole_halves_k_at_its_amplitude_and_leaves_the_phase():
    found = measured("strain-softening", Xc=1.2, n=1.6) / K
    np.testing.assert_allclose(found, 1.0 / (1.0 + (X / 1.2) ** 1.6), rtol=1e-12)
    x = np.array([1e-6, 1.2, 1.2e5, 1.2e6])
    value = (
        EFFECTS["strain-softening"]
        .element.respond(np.array([1.2, 1.6]), Points(np.zeros(4), amplitude=x))
        .value
    )
    assert value[0] == pytest.approx(1.0, rel=1e-9)
    assert value[1] == pytest.approx(0.5)
    assert np.log10(value[2].real / value[3].real) == pytest.approx(1.6, rel=1e-6)


def test_a_little_softening_with_the_square_is_the_intrinsic_nonlinearity():
    softened = measured("strain-softening", Xc=100.0, n=2.0)
    np.testing.assert_allclose(softened, measured("intrinsic-nonlinearity", q=-1e-4), rtol=2e-7)


def test_shear_thinning_knows_only_frequency_times_amplitude():
    rate = np.array([0.01, 5.0, 500.0])
    own = np.array([5.0, 0.8])
    element = EFFECTS["shear-thinning"].element
    slow = element.respond(own, Points(np.log(rate / 10.0), amplitude=np.full(3, 10.0))).value
    fast = element.respond(own, Points(np.log(rate / 0.1), amplitude=np.full(3, 0.1))).value
    np.testing.assert_allclose(slow, fast, rtol=1e-12)
    np.testing.assert_allclose(slow, 1.0 / (1.0 + (rate / 5.0) ** 0.8), rtol=1e-12)


def test_nobody_says_of_softening_how_loud_its_third_harmonic_is():
    for name in ("strain-softening", "shear-thinning"):
        model, theta = grown("fractional-zener", name)
        assert np.all(np.isinf(model.third_harmonic_range(theta, POINTS)[1]))
