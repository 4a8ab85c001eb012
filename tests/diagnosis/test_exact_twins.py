"""Diagnoses of the exact dualities of linear and first-harmonic rheology, one by one.

Data come from formulas written here, at two sizes of the effect relative to the noise, each with a
seed of its own; each base meets one of the two here, and both in ``make soak``. Wherever two
effects draw the same curve both must be in the first class and neither may be said to be known.
Where two forms of a model draw the same curve they must fit equally and be told the same.

What is only nested (one of the two draws every curve of the other, but not the other way round) is
no duality: the restricted effect may be preferred, but the wider one must fit as well. Such tests
say "nested".
"""

import numpy as np
import pytest
from hidden_data import (
    GAS,
    KELVIN,
    MAXWELL,
    WARM,
    ZENER,
    ZERO,
    Base,
    Design,
    design,
    exact,
    jenkins,
    measured,
)

import springpot
from soaked import soaked
from springpot.rheology import Model, dashpot, parallel, series, spring

SWEEP = design(24)
SWEEP_S = 1j * SWEEP.omega
ONE_AMPLITUDE = design(24, amplitudes=(0.5,))
TWO_AMPLITUDES = design(12, amplitudes=(0.5, 1.0))
ONE_TEMPERATURE = design(24, temperatures=(25.0,))
TWO_TEMPERATURES = design(12, temperatures=(10.0, 40.0))
FOUR_TEMPERATURES = design(8, temperatures=(-10.0, 10.0, 30.0, 50.0))
CONFIDENT = 0.95

NOISES = ((0.002, 1), (0.02, 3))
"""Noise as a fraction of |K|, and its seed."""


def crossed(name, values, noises=NOISES, rare=()):
    """Each value with the noises in turn, so that either is seen.

    Other pairs, and rare values, are for the soak.
    """
    pairs = []
    for i, value in enumerate(values):
        for j, (level, seed) in enumerate(noises):
            marks = [] if i % len(noises) == j and value not in rare else [pytest.mark.soak]
            label = getattr(value, "name", value)
            pairs.append(pytest.param(value, level, seed, marks=marks, id=f"{label}-{level:g}"))
    return pytest.mark.parametrize((name, "level", "seed"), pairs)


SPRING = Base("spring", lambda p, s: p[0] + 0 * s, (100.0,))
DASHPOT = Base("dashpot", lambda p, s: p[0] * s, (3.0,))
SPRINGPOT = Base("springpot", lambda p, s: p[0] * s ** p[1], (40.0, 0.4))
SOFT_KELVIN = Base("kelvin", lambda p, s: p[0] + p[1] * s, (100.0, 0.6))
STIFF_KELVIN = Base("kelvin", lambda p, s: p[0] + p[1] * s, (100.0, 0.02))


def mode(s, k, tau):
    """A Maxwell element."""
    return k * s * tau / (1.0 + s * tau)


def in_series(*stiffness):
    return 1.0 / sum(1.0 / each for each in stiffness)


def of(diagnosis, effect):
    return next(c for c in diagnosis.candidates if c.effect == effect)


def one_class(diagnosis, *names, error=1e-3):
    """All of them in the first class, with one error after acceptance, and none of them known."""
    assert diagnosis.verdict == "effect-missing"
    assert set(names) <= set(diagnosis.best.alike)
    assert max(each.probability for each in diagnosis.candidates) <= CONFIDENT
    for name in names:
        assert of(diagnosis, name).alike == diagnosis.best.alike
        assert of(diagnosis, name).verdict != "absent"
        assert of(diagnosis, name).error_after == pytest.approx(
            of(diagnosis, names[0]).error_after, rel=error
        )
        assert of(diagnosis, name).error_after < 1.2 * diagnosis.error.noise_floor


def absorbed(diagnosis, *names):
    """Nothing is missing, and of these effects nothing can be said.

    The model's own parameters follow them.
    """
    assert diagnosis.verdict == "adequate"
    for name in names:
        assert of(diagnosis, name).verdict == "cannot-tell"
        assert of(diagnosis, name).probability < 0.05


# E1 and E2: springs, and dashpots, inside and outside


@pytest.mark.soak_cases("dashpot-0.02", "spring-0.002")
@crossed("base", [SPRING, DASHPOT])
def test_a_mode_beside_a_spring_is_a_mode_in_series(base, level, seed):
    """Zener is Poynting-Thomson, and Jeffreys is a dashpot in series with Kelvin.

    Alpha = 1 of the duality.
    """
    data = measured(SWEEP, exact(base, SWEEP) + mode(SWEEP_S, 60.0, 0.05), seed, level)
    one_class(springpot.diagnose(data, base.name), "relaxation-mode", "retardation-mode")


@pytest.mark.soak_cases("dashpot-0.02", "kelvin-0.002")
@crossed("base", [SOFT_KELVIN, DASHPOT])
def test_a_spring_in_series_is_a_filter(base, level, seed):
    """(k + c s) / (1 + s tau) is Zener and c s / (1 + s tau) is Maxwell.

    Not in the catalogue, but exact.
    """
    data = measured(SWEEP, in_series(exact(base, SWEEP), 4000.0), seed, level)
    one_class(springpot.diagnose(data, base.name), "series-spring", "filter-mismatch")


@pytest.mark.soak_cases("zener alpha=0.43")
@pytest.mark.parametrize(
    ("kind", "law", "inside", "outside", "level", "seed"),
    [
        (
            "spring",
            60.0 + in_series(400.0, 40.0 * SWEEP_S**0.43),
            "fractional-kelvin",
            "fractional-maxwell",
            0.002,
            1,
        ),
        soaked("spring", 60.0 + in_series(400.0, 6.0 * SWEEP_S), "kelvin", "maxwell", 0.02, 3),
        soaked(
            "dashpot",
            0.3 * SWEEP_S + in_series(30.0 * SWEEP_S, 12.0 * SWEEP_S**0.4),
            "fractional-kelvin-dashpot",
            "fractional-maxwell-dashpot",
            0.02,
            3,
        ),
        soaked(
            "dashpot",
            0.3 * SWEEP_S + in_series(30.0 * SWEEP_S, 150.0),
            "kelvin",
            "maxwell",
            0.002,
            1,
        ),
    ],
    ids=["zener alpha=0.43", "zener alpha=1", "jeffreys alpha=0.4", "jeffreys spring"],
)
def test_zener_and_jeffreys_forms_are_reached_from_both_sides(
    kind, law, inside, outside, level, seed
):
    """In series with Kelvin's form or beside Maxwell's.

    Each is found, and both end at the same error.
    """
    data = measured(SWEEP, law, seed, level)
    one, other = springpot.diagnose(data, inside), springpot.diagnose(data, outside)
    series, parallel = f"series-{kind}", f"parallel-{kind}"
    assert series in one.best.alike
    assert parallel in other.best.alike
    assert of(one, series).error_after == pytest.approx(of(other, parallel).error_after, rel=1e-3)


# E3: mounting compliance and an instantaneous spring


@pytest.mark.soak_cases("0.003-1-burgers", "0.003-1-zener")
@pytest.mark.parametrize(
    ("law", "names"),
    [
        (60.0 + in_series(400.0, 6.0 * SWEEP_S), ("zener", "zener-kelvin")),
        soaked(exact(ZENER, SWEEP), ("fractional-zener", "fractional-kelvin4")),
        (in_series(400.0, 40.0 * SWEEP_S, 60.0 + 2.0 * SWEEP_S), ("burgers", "maxwell-2")),
    ],
    ids=["zener", "fractional-zener", "burgers"],
)
@pytest.mark.parametrize(
    ("level", "seed"), [(0.003, 1), pytest.param(0.015, 2, marks=pytest.mark.soak)]
)
def test_compliance_hides_in_every_form_that_has_a_spring_in_series(law, names, level, seed):
    data = measured(SWEEP, in_series(law, 700.0), seed, level)
    found = [springpot.diagnose(data, name) for name in names]
    for diagnosis in found:
        absorbed(diagnosis, "series-spring", "gain-error")
        assert diagnosis.error.relative_rms == pytest.approx(found[0].error.relative_rms, rel=1e-4)


@pytest.mark.soak_cases("dashpot-0.002", "kelvin-0.002")
@crossed("base", [SOFT_KELVIN, SPRINGPOT, DASHPOT], rare=[SPRINGPOT])
def test_compliance_shows_where_no_spring_is_in_series(base, level, seed):
    data = measured(SWEEP, in_series(exact(base, SWEEP), 900.0), seed, level)
    assert "series-spring" in springpot.diagnose(data, base.name).best.alike


# E4: N modes side by side, N in series, ladders


def cauer(n):
    """A spring in series with (a dashpot beside (a spring in series with ...)), n dashpots deep."""
    node = spring(f"k{n}")
    for i in range(n, 0, -1):
        node = series(spring(f"k{i - 1}"), parallel(dashpot(f"c{i}"), node))
    return Model(f"cauer-{n}", node, "a ladder of springs and dashpots")


def spectrum(n, s=SWEEP_S):
    """A solid with n relaxation times, a decade apart."""
    return 40.0 + sum(mode(s, 120.0, 0.6 * 0.08**i) for i in range(n))


@pytest.mark.soak_cases("3-0.01-2")
@pytest.mark.parametrize(("n", "level", "seed"), [(2, 0.003, 1), (3, 0.01, 2)])
def test_modes_side_by_side_in_series_and_in_a_ladder_fit_alike(n, level, seed):
    data = measured(SWEEP, spectrum(n), seed, level)
    forms = [f"prony-{n}", f"kelvin-{n}", cauer(n)] + (["zener-2"] if n == 2 else [])
    errors = [springpot.identify(data, form).relative_rms for form in forms]
    np.testing.assert_allclose(errors, errors[0], rtol=1e-4)
    assert errors[0] == pytest.approx(level * np.sqrt(2.0), rel=0.3)


@pytest.mark.soak_cases("1-0.01-2-2")
@pytest.mark.parametrize(
    ("n", "level", "seed", "forms"),
    [(1, 0.01, 2, 2), soaked(1, 0.01, 2, 3), soaked(2, 0.003, 1, 3)],
)
def test_one_more_mode_is_told_the_same_on_every_form(n, level, seed, forms):
    """On N modes in any form, one more beside them and one more in series are one class."""
    data = measured(SWEEP, spectrum(n + 1), seed, level)
    found = [
        springpot.diagnose(data, form) for form in (f"prony-{n}", f"kelvin-{n}", cauer(n))[:forms]
    ]
    for diagnosis in found:
        one_class(diagnosis, "relaxation-mode", "retardation-mode")
        assert diagnosis.best.error_after == pytest.approx(found[0].best.error_after, rel=1e-3)


# E6: gauges


@pytest.mark.soak_cases("base2-0.5-2")
@pytest.mark.parametrize(
    ("base", "gain", "seed"), [(SPRINGPOT, 0.5, 1), soaked(KELVIN, 1.2, 2), (MAXWELL, 0.5, 2)]
)
def test_a_gain_is_a_scale_of_all_moduli(base, gain, seed):
    """Gain, area or gap error, and vertical shift at one temperature.

    Nothing but the moduli changes.
    """
    plain = measured(ONE_TEMPERATURE, exact(base, ONE_TEMPERATURE), seed)
    data = measured(ONE_TEMPERATURE, gain * exact(base, ONE_TEMPERATURE), seed)
    absorbed(springpot.diagnose(data, base.name), "gain-error", "frequency-error")
    before, after = (springpot.identify(each, base.name).theta for each in (plain, data))
    scale = np.where(np.array(springpot.parse_model(base.name).names) == "alpha", 1.0, gain)
    np.testing.assert_allclose(after, before * scale, rtol=1e-4)


@pytest.mark.soak
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.soak)])
def test_a_gain_at_one_of_two_temperatures_is_a_vertical_shift(seed):
    """And no gain error, which is the same at both."""
    at = TWO_TEMPERATURES
    gain = np.where(at.celsius > 20.0, 1.15, 1.0)
    diagnosis = springpot.diagnose(measured(at, gain * exact(WARM, at), seed), WARM.name)
    assert "vertical-shift" in diagnosis.best.alike
    assert of(diagnosis, "vertical-shift").error_after < 1.2 * diagnosis.error.noise_floor
    assert of(diagnosis, "gain-error").verdict == "cannot-tell"


@pytest.mark.soak
@pytest.mark.parametrize(
    ("base", "faster", "seed"), [soaked(SPRINGPOT, 0.7, 1), (KELVIN, 1.3, 2), (MAXWELL, 0.7, 2)]
)
def test_a_wrong_clock_is_a_scale_of_all_times(base, faster, seed):
    """As is a thermometer that is off at one temperature.

    The order and the spring stay, the springpot takes it.
    """
    at, name = ONE_TEMPERATURE, base.name
    plain = measured(at, base.stiffness(base.truth, at), seed, level=1e-4)
    data = measured(at, base.stiffness(base.truth, at, np.log(faster)), seed, level=1e-4)
    absorbed(springpot.diagnose(data, name), "gain-error", "frequency-error")
    before, after = (springpot.identify(each, name).theta for each in (plain, data))
    names = springpot.parse_model(name).names
    scale = np.where(np.array(names) == "c", faster ** base.truth[names.index("alpha")], 1.0)
    np.testing.assert_allclose(after, before * scale, rtol=2e-3)


@pytest.mark.soak
@pytest.mark.parametrize(("offset", "seed"), [(-15.0, 1), soaked(15.0, 2)])
def test_a_wrong_thermometer_hides_in_a_model_with_a_shift(offset, seed):
    """All times by one factor, and what is left bends the shift by less than any sweep can show."""
    at = FOUR_TEMPERATURES
    inverse = 1.0 / (at.celsius + offset + ZERO) - 1.0 / at.reference
    data = measured(at, KELVIN.stiffness(KELVIN.truth, at, 40.0 / GAS * inverse), seed)
    diagnosis = springpot.diagnose(data, WARM.name)
    absorbed(diagnosis, "frequency-error", "gain-error")
    assert "arrhenius-shift" not in {c.effect for c in diagnosis.candidates}, (
        "two shifts of one law are no physics"
    )


@pytest.mark.suite_cases("0.01-2")
@pytest.mark.soak
@pytest.mark.parametrize(("level", "seed"), [(0.003, 1), (0.01, 2)])
def test_a_clock_wrong_at_one_of_two_temperatures_is_a_shift(level, seed):
    """The cold sweep at a frequency too high by half: Arrhenius, WLF and a free factor are one."""
    at = TWO_TEMPERATURES
    ln_shift = np.where(at.celsius < 20.0, np.log(1.5), 0.0)
    data = measured(at, KELVIN.stiffness(KELVIN.truth, at, ln_shift), seed, level)
    diagnosis = springpot.diagnose(data, KELVIN.name)
    one_class(diagnosis, "arrhenius-shift", "wlf-shift", error=1e-2)


# E8: a constant loss at one amplitude


@pytest.mark.soak
@crossed("base", [KELVIN, SOFT_KELVIN, SPRING], rare=[KELVIN, SOFT_KELVIN])
def test_a_constant_loss_at_one_amplitude_has_three_names(base, level, seed):
    """Friction, a hysteretic loss, and crosstalk whose part in phase the spring takes."""
    data = measured(ONE_AMPLITUDE, exact(base, ONE_AMPLITUDE) + 12.0j, seed, level)
    one_class(springpot.diagnose(data, base.name), "friction", "hysteretic-loss", "crosstalk")


@pytest.mark.soak_cases("1.5707963267948966-0.02")
@crossed("phase", [0.8, np.pi / 2.0], rare=[0.8])
def test_crosstalk_at_one_amplitude_is_friction(phase, level, seed):
    data = measured(
        ONE_AMPLITUDE, exact(KELVIN, ONE_AMPLITUDE) + 14.0 * np.exp(1j * phase), seed, level
    )
    one_class(springpot.diagnose(data, KELVIN.name), "friction", "hysteretic-loss", "crosstalk")


@pytest.mark.soak_cases("friction-spring-0.01", "phase-error-spring-0.01")
@crossed("base", [SPRING, STIFF_KELVIN], noises=[(0.01, 1), (0.02, 3)], rare=[STIFF_KELVIN])
@pytest.mark.parametrize("turned", [True, False], ids=["phase-error", "friction"])
def test_a_phase_error_on_a_dominant_spring_is_friction(base, turned, level, seed):
    """K e^(i phi) is K + i phi k where K is nearly k.

    Exact on a spring, a matter of noise on a stiff Kelvin.
    """
    stiffness = exact(base, ONE_AMPLITUDE)
    stiffness = stiffness * np.exp(0.05j) if turned else stiffness + 5.0j
    diagnosis = springpot.diagnose(measured(ONE_AMPLITUDE, stiffness, seed, level), base.name)
    names = ("friction", "hysteretic-loss", "crosstalk", "phase-error")
    one_class(diagnosis, *names, error=1e-3 if base is SPRING else 0.1)


# E9: two amplitudes


@pytest.mark.soak_cases("spring-cubic-stiffness-0.001")
@crossed(
    "effect", ["cubic-stiffness", "dead-zone"], noises=[(0.001, 1), (0.01, 3)], rare=["dead-zone"]
)
@pytest.mark.parametrize("base", [soaked(KELVIN), SPRING], ids=lambda base: base.name)
def test_storage_that_rises_between_two_amplitudes_has_two_names_or_three(
    base, effect, level, seed
):
    """One number, the rise.

    A cubic spring, a gap, and on a pure spring also K (1 + q X^2), which scales K''.

    Payne and Jenkins soften, and always lose energy in doing so; self-heating needs a loss to heat
    with.
    """
    size = {"cubic-stiffness": 14.0, "dead-zone": 40.0}[effect]
    diagnosis = springpot.diagnose(
        measured(TWO_AMPLITUDES, exact(base, TWO_AMPLITUDES, effect, size), seed, level), base.name
    )
    names = ("cubic-stiffness", "dead-zone") + (
        ("intrinsic-nonlinearity",) if base is SPRING else ()
    )
    one_class(diagnosis, *names)


@pytest.mark.soak_cases("0.01-2")
@pytest.mark.parametrize(("level", "seed"), [soaked(0.003, 1), (0.01, 2)])
def test_storage_that_falls_between_two_amplitudes_is_nested_in_payne(level, seed):
    """A gap only stiffens, so a cubic spring is left.

    Payne without loss has two numbers more and fits as well.
    """
    softening = exact(KELVIN, TWO_AMPLITUDES) - 0.75 * 14.0 * TWO_AMPLITUDES.x**2
    diagnosis = springpot.diagnose(measured(TWO_AMPLITUDES, softening, seed, level), KELVIN.name)
    assert "cubic-stiffness" in diagnosis.best.alike
    cubic, payne = of(diagnosis, "cubic-stiffness"), of(diagnosis, "payne")
    assert payne.error_after <= 1.02 * cubic.error_after
    assert payne.verdict == "cannot-tell"


@pytest.mark.soak_cases("0.003-1")
@pytest.mark.parametrize(("level", "seed"), [(0.003, 1), soaked(0.01, 2)])
def test_a_slider_at_two_amplitudes_is_nested_in_payne(level, seed):
    """Its two numbers fit three facts, the fall of K' and two losses.

    The four of Payne fit any three.
    """
    data = exact(KELVIN, TWO_AMPLITUDES) + jenkins(TWO_AMPLITUDES, 40.0, 15.0)
    diagnosis = springpot.diagnose(measured(TWO_AMPLITUDES, data, seed, level), KELVIN.name)
    assert "elasto-sliding" in diagnosis.best.alike
    slider, payne = of(diagnosis, "elasto-sliding"), of(diagnosis, "payne")
    assert payne.error_after <= 1.05 * slider.error_after
    assert payne.verdict == "cannot-tell"


# E10: one springpot


@pytest.mark.soak_cases("0.06-2")
@pytest.mark.parametrize(("phi", "seed"), [(-0.06, 1), (0.06, 2)])
def test_a_turned_and_tilted_springpot_is_a_springpot_of_another_order(phi, seed):
    """c s^alpha e^(i phi) omega^(2 phi / pi) is of order alpha + 2 phi / pi."""
    turned = exact(SPRINGPOT, SWEEP) * np.exp(1j * phi) * SWEEP.omega ** (2.0 * phi / np.pi)
    data = measured(SWEEP, turned, seed, level=0.003)
    assert springpot.diagnose(data, "springpot").verdict == "adequate"
    found = springpot.identify(data, "springpot").theta[1]
    assert found == pytest.approx(0.4 + 2.0 * phi / np.pi, abs=2e-3)


@pytest.mark.parametrize(("phi", "level", "seed"), [(-0.06, 0.003, 1), soaked(0.06, 0.02, 2)])
def test_at_one_frequency_a_phase_error_is_an_order(phi, level, seed):
    """Without a tilt to see nothing at all can be said of a phase error."""
    at = Design(np.full(12, 10.0))
    diagnosis = springpot.diagnose(
        measured(at, exact(SPRINGPOT, at) * np.exp(1j * phi), seed, level), "springpot"
    )
    assert diagnosis.verdict in ("adequate", "inconclusive")
    assert [c.verdict for c in diagnosis.candidates if c.effect == "phase-error"] in (
        [],
        ["cannot-tell"],
    )


@pytest.mark.suite_cases("-0.03-1")
@pytest.mark.soak
@pytest.mark.parametrize(("phi", "seed"), [(-0.03, 1), (0.03, 2)])
def test_over_an_octave_a_phase_error_hides_in_the_order_and_over_decades_it_shows(phi, seed):
    octave = design(24, 1.0, 2.0)
    narrow = springpot.diagnose(
        measured(octave, exact(SPRINGPOT, octave) * np.exp(1j * phi), seed), "springpot"
    )
    assert narrow.verdict == "adequate"
    assert of(narrow, "phase-error").verdict == "cannot-tell"
    wide = springpot.diagnose(
        measured(SWEEP, exact(SPRINGPOT, SWEEP) * np.exp(1j * phi), seed), "springpot"
    )
    assert wide.best.effect == "phase-error"
    assert wide.best.error_after < 1.2 * wide.error.noise_floor < wide.error.relative_rms
