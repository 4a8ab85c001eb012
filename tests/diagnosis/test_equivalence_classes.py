"""Exact dualities: effects that no data of this kind can tell apart come back as one class."""

import numpy as np
import pytest
from hidden_data import (
    KELVIN,
    MAXWELL,
    TEMPERATURES,
    Base,
    Design,
    design,
    exact,
    hidden,
    jenkins,
    measured,
)

import springpot
from soaked import soaked

SWEEP = design(24)
ONE_AMPLITUDE = design(24, amplitudes=(0.5,))
TWO_AMPLITUDES = design(12, amplitudes=(0.5, 1.0))
TWO_TEMPERATURES = design(12, temperatures=(10.0, 40.0))
ONE_TEMPERATURE = design(24, temperatures=(25.0,))
S = 1j * SWEEP.omega


def classical(p, s):
    return p[0] + p[1] * s


def maxwell_classical(p, s):
    return p[0] * p[1] * s / (p[0] + p[1] * s)


CLASSICAL_KELVIN = Base("kelvin", classical, (100.0, 0.6))
CLASSICAL_MAXWELL = Base("maxwell", maxwell_classical, (400.0, 100.0))


def of(diagnosis, effect):
    return next(c for c in diagnosis.candidates if c.effect == effect)


def one_class(diagnosis, *names):
    """All of them in the first class, with one error after acceptance."""
    assert diagnosis.verdict == "effect-missing"
    assert set(names) <= set(diagnosis.best.alike)
    assert any(set(names) <= set(group) for group in diagnosis.classes)
    for name in names:
        assert set(names) <= set(of(diagnosis, name).alike)
        assert of(diagnosis, name).probability <= 0.95


@pytest.mark.soak_cases("friction")
@pytest.mark.parametrize("effect", ["friction", soaked("hysteretic-loss")])
def test_friction_at_one_amplitude_is_a_hysteretic_loss(effect):
    diagnosis = springpot.diagnose(hidden(KELVIN, ONE_AMPLITUDE, effect, 1000.0), KELVIN.name)
    one_class(diagnosis, "friction", "hysteretic-loss")
    assert of(diagnosis, "friction").error_after == pytest.approx(
        of(diagnosis, "hysteretic-loss").error_after, rel=1e-3
    )
    # 4 F / (pi X) is the loss: the two describe one number.
    force, loss = (
        of(diagnosis, name).parameters[p].value
        for name, p in (("friction", "F"), ("hysteretic-loss", "h"))
    )
    assert 4.0 * force / (np.pi * 0.5) == pytest.approx(loss, rel=1e-2)


# Its short form is in test_exact_twins.py.
@pytest.mark.soak
def test_crosstalk_in_quadrature_at_one_amplitude_is_friction():
    stiffness = exact(KELVIN, ONE_AMPLITUDE) + 12.0j
    diagnosis = springpot.diagnose(measured(ONE_AMPLITUDE, stiffness), KELVIN.name)
    one_class(diagnosis, "friction", "hysteretic-loss", "crosstalk")
    assert of(diagnosis, "crosstalk").error_after == pytest.approx(
        of(diagnosis, "friction").error_after, rel=1e-3
    )


@pytest.mark.soak_cases("relaxation-mode-kelvin")
@pytest.mark.parametrize(
    "base", [CLASSICAL_KELVIN, soaked(CLASSICAL_MAXWELL)], ids=lambda b: b.name
)
@pytest.mark.parametrize("effect", ["relaxation-mode", soaked("retardation-mode")])
def test_relaxation_and_retardation_modes_are_one(base, effect):
    """A mode beside and a mode in series are the same rational function of s."""
    stiffness = exact(
        base, SWEEP, effect, {"relaxation-mode": 150.0, "retardation-mode": 4e-3}[effect]
    )
    diagnosis = springpot.diagnose(measured(SWEEP, stiffness, level=0.005), base.name)
    one_class(diagnosis, "relaxation-mode", "retardation-mode")
    assert of(diagnosis, "relaxation-mode").error_after == pytest.approx(
        of(diagnosis, "retardation-mode").error_after, rel=1e-3
    )


@pytest.mark.soak
def test_modes_on_a_fractional_kelvin_are_one_class_where_they_are_small():
    diagnosis = springpot.diagnose(
        hidden(KELVIN, SWEEP, "retardation-mode", 60.0, seed=3, just=True), KELVIN.name
    )
    one_class(diagnosis, "relaxation-mode", "retardation-mode")


@pytest.mark.soak_cases("1.0")
@pytest.mark.parametrize("alpha", [1.0, soaked(0.43)])
def test_a_spring_in_series_with_kelvin_is_the_zener_form(alpha):
    """k0 = ke + k1, k2 = ke (ke + k1) / k1, c2 = c ((ke + k1) / k1)^2."""
    ke, k1, c = 80.0, 300.0, 12.0
    ratio = (ke + k1) / k1
    zener = ke + 1.0 / (1.0 / k1 + 1.0 / (c * S**alpha))
    kelvin4 = 1.0 / (1.0 / (ke + k1) + 1.0 / (ke * ratio + c * ratio**2 * S**alpha))
    np.testing.assert_allclose(zener, kelvin4, rtol=1e-12)
    names = ("fractional-kelvin", "fractional-zener", "fractional-kelvin4")
    if alpha == 1.0:
        names = ("kelvin", "zener", "zener-kelvin")
    data = measured(SWEEP, zener)
    diagnosis = springpot.diagnose(data, names[0])
    assert diagnosis.verdict == "effect-missing"
    assert "series-spring" in diagnosis.best.alike
    both = [springpot.diagnose(data, name) for name in names[1:]]
    assert [d.verdict for d in both] == ["adequate", "adequate"]
    assert both[0].error.relative_rms == pytest.approx(both[1].error.relative_rms, rel=1e-4)
    assert of(diagnosis, "series-spring").error_after == pytest.approx(
        both[0].error.relative_rms, rel=1e-3
    )


@pytest.mark.soak
def test_a_solvent_beside_and_a_dashpot_in_series_are_one_fluid():
    """c0 in series with (c1 || V s^a) is cS beside (cP in series with VP s^a)."""
    c0, c1, v, a = 30.0, 1.0, 12.0, 0.4
    ratio = (c0 + c1) / c0
    series = 1.0 / (1.0 / (c0 * S) + 1.0 / (c1 * S + v * S**a))
    c_solvent, c_series, v_series = c1 / ratio, c0 / ratio, v / ratio**2
    parallel = c_solvent * S + 1.0 / (1.0 / (c_series * S) + 1.0 / (v_series * S**a))
    np.testing.assert_allclose(series, parallel, rtol=1e-12)
    data = measured(SWEEP, series)
    inside = springpot.diagnose(data, "fractional-kelvin-dashpot")
    beside = springpot.diagnose(data, "fractional-maxwell-dashpot")
    assert "series-dashpot" in inside.best.alike
    assert "parallel-dashpot" in beside.best.alike
    assert of(inside, "series-dashpot").error_after == pytest.approx(
        of(beside, "parallel-dashpot").error_after, rel=1e-3
    )


@pytest.mark.soak
@pytest.mark.parametrize("name", [soaked("fractional-maxwell"), "maxwell"])
def test_mounting_compliance_is_absorbed_by_a_model_with_a_spring_in_series(name):
    law = {"fractional-maxwell": MAXWELL, "maxwell": CLASSICAL_MAXWELL}[name]
    data = measured(SWEEP, exact(law, SWEEP, "series-spring", 2e-3))
    diagnosis = springpot.diagnose(data, name)
    assert diagnosis.verdict == "adequate"
    assert [c.verdict for c in diagnosis.candidates if c.effect == "series-spring"] in (
        [],
        ["cannot-tell"],
    )


@pytest.mark.soak_cases("frequency-error")
@pytest.mark.parametrize("effect", ["gain-error", "frequency-error"])
def test_errors_of_scale_are_absorbed_by_the_moduli(effect):
    diagnosis = springpot.diagnose(measured(SWEEP, exact(KELVIN, SWEEP, effect, 0.2)), KELVIN.name)
    assert diagnosis.verdict == "adequate"
    assert [c.verdict for c in diagnosis.candidates if c.effect == effect] in ([], ["cannot-tell"])


@pytest.mark.parametrize(
    ("alias", "name"),
    [
        ("bearing-spring", "parallel-spring"),
        ("equilibrium-spring", "parallel-spring"),
        ("solvent-dashpot", "parallel-dashpot"),
        ("bearing-drag", "parallel-dashpot"),
        ("slip", "series-dashpot"),
        ("flow", "series-dashpot"),
        ("mounting-compliance", "series-spring"),
        ("inerter", "inertia"),
        ("fixture-mass", "inertia"),
    ],
)
def test_two_words_for_one_effect(alias, name):
    one, other = (springpot.parse_model(f"fractional-maxwell + {word}") for word in (alias, name))
    theta = np.array([400.0, 60.0, 0.5, 0.01])
    np.testing.assert_array_equal(
        one.stiffness(theta, SWEEP.omega), other.stiffness(theta, SWEEP.omega)
    )
    assert [p.name for p in one.parameters] == [p.name for p in other.parameters]


@pytest.mark.soak
@pytest.mark.parametrize(
    ("chi2", "seed"),
    [(300.0, 1), (30000.0, 2)]
    + [
        pytest.param(*case, marks=pytest.mark.soak)
        for case in ((300.0, 2), (300.0, 3), (30000.0, 1), (30000.0, 3))
    ],
)
@pytest.mark.parametrize("effect", ["arrhenius-shift", "wlf-shift"])
def test_two_temperatures_cannot_tell_arrhenius_from_wlf(effect, chi2, seed):
    """One shift is all that two temperatures tell.

    One constant or two, where the fit ends among them is chance.
    """
    diagnosis = springpot.diagnose(
        hidden(KELVIN, TWO_TEMPERATURES, effect, chi2, seed), KELVIN.name
    )
    one_class(diagnosis, "arrhenius-shift", "wlf-shift")
    assert max(each.probability for each in diagnosis.candidates) < 0.9


# On a spring alone it is in test_exact_twins.py.
@pytest.mark.soak
def test_two_amplitudes_cannot_tell_a_cubic_spring_from_a_gap():
    diagnosis = springpot.diagnose(
        hidden(KELVIN, TWO_AMPLITUDES, "cubic-stiffness", 400.0), KELVIN.name
    )
    one_class(diagnosis, "cubic-stiffness", "dead-zone")


@pytest.mark.soak
def test_friction_at_two_amplitudes_stays_apart_from_a_hysteretic_loss():
    diagnosis = springpot.diagnose(hidden(KELVIN, TWO_AMPLITUDES, "friction", 1000.0), KELVIN.name)
    assert diagnosis.best.effect == "friction"
    assert "hysteretic-loss" not in diagnosis.best.alike


@pytest.mark.suite_cases("entropic-spring-parallel-spring-base1")
@pytest.mark.parametrize(
    ("effect", "partner", "base"),
    [("rig-drag", "parallel-dashpot", KELVIN), ("entropic-spring", "parallel-spring", MAXWELL)],
)
def test_one_temperature_cannot_tell_what_temperature_would(effect, partner, base):
    diagnosis = springpot.diagnose(hidden(base, ONE_TEMPERATURE, effect, 1000.0), base.name)
    assert diagnosis.verdict == "effect-missing"
    assert partner in diagnosis.best.alike
    assert [c for c in diagnosis.candidates if c.effect == effect and partner not in c.alike] == []


@pytest.mark.soak
@pytest.mark.parametrize("effect", ["inertia", soaked("specimen-inertia")])
def test_fixture_and_specimen_inertia_are_one_class_while_waves_are_long(effect):
    one_class(
        springpot.diagnose(hidden(KELVIN, SWEEP, effect, 400.0, just=True), KELVIN.name),
        "inertia",
        "specimen-inertia",
    )


@pytest.mark.soak
def test_a_small_delay_and_a_small_filter_are_one_class():
    one_class(
        springpot.diagnose(hidden(KELVIN, SWEEP, "time-delay", 60.0, just=True), KELVIN.name),
        "time-delay",
        "filter-mismatch",
    )


@pytest.mark.soak
def test_a_slider_that_always_slips_at_one_amplitude_is_no_friction_alone():
    """A slider with a spring changes storage too.

    At one amplitude the spring is absorbed and friction remains.
    """
    at = Design(ONE_AMPLITUDE.omega, ONE_AMPLITUDE.x)
    diagnosis = springpot.diagnose(
        measured(at, exact(KELVIN, at) + jenkins(at, 200.0, 5.0)), KELVIN.name
    )
    assert diagnosis.verdict == "effect-missing"
    assert "hysteretic-loss" in diagnosis.best.alike


@pytest.mark.soak
def test_three_temperatures_tell_a_vertical_shift_from_a_horizontal_one():
    best = springpot.diagnose(
        hidden(KELVIN, TEMPERATURES, "vertical-shift", 1000.0), KELVIN.name
    ).best
    assert best.effect == "vertical-shift"
    assert "arrhenius-shift" not in best.alike
