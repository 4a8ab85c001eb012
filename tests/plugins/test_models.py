"""Every registered model: physics, exact derivatives, units, names."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from derivatives import cauchy, check_derivatives, sample
from springpot.errors import ModelError
from springpot.identification.space import paper_box
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model, plugins
from springpot.rheology import Dimension, Model, Parameter, Points, drawing_of
from springpot.rheology.model import Family

OF_THE_NETWORK = [each.name for each in plugins().items("effect") if not each.of_test]

REGISTERED = [
    item.build(3) if isinstance(item, Family) else item for item in plugins().items("model")
]
MODELS = {model.base: model for model in REGISTERED}
SEARCHED = [name for name, model in MODELS.items() if model.search]
LIMITED = [name for name in SEARCHED if "kinf" in [p.name for p in MODELS[name].search.parameters]]
OMEGA = np.logspace(-3, 3, 9)
AT_UNIT_SPEED = {"power-law-damper", "power-law-slip", "yielding"}
"""Effects whose parameter is a force at one unit of speed: at another speed in other units."""
MODEL_SOURCE = re.compile(r"eq\. \(\d+\)|10\.\d{4,}/\S+|\(\d{4}\)")


def points(n: int = 9) -> Points:
    return Points(
        np.log(np.logspace(-1, 1.5, n)), np.linspace(0.5, 2.0, n), np.linspace(285.0, 305.0, n)
    )


def with_orders(model: Model, rng: np.random.Generator, *ends: float) -> np.ndarray:
    """Random parameters over four decades, some orders at the ends of their range."""
    theta = []
    for parameter in model.parameters:
        if parameter.scale == "log":
            theta.append(np.exp(rng.uniform(-5.0, 5.0)))
        else:
            theta.append(rng.choice([*ends, rng.uniform(0.0, 1.0)]))
    return np.array(theta)


@pytest.mark.parametrize("name", MODELS)
def test_says_what_it_is(name: str):
    model = MODELS[name]
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", model.base)
    assert 10 < len(model.summary) < 140
    assert MODEL_SOURCE.search(model.citation), model.citation
    assert len(set(model.names)) == len(model.names)
    assert len(drawing_of(model).splitlines()) >= 2


@pytest.mark.parametrize("name", MODELS)
def test_derivatives_are_exact(name: str, rng: np.random.Generator):
    model = MODELS[name]
    for _ in range(3):
        check_derivatives(model.network, sample(model.parameters, rng), points())


@pytest.mark.soak_cases("hardening-mount", "power-law-slip", "smooth-hysteresis", "yielding")
@pytest.mark.parametrize("effect", OF_THE_NETWORK)
def test_derivatives_are_exact_with_every_effect(effect: str, rng: np.random.Generator):
    model = MODELS["fractional-zener"] + effect
    for _ in range(3):
        check_derivatives(model.network, sample(model.parameters, rng), points())


@pytest.mark.parametrize("name", MODELS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_dissipates_and_stores_for_all_lawful_parameters(name: str, seed: int):
    model = MODELS[name]
    stiffness = model.stiffness(with_orders(model, np.random.default_rng(seed), 0.0, 1.0), OMEGA)
    rounding = 1e-12 * np.abs(stiffness)
    assert np.all(stiffness.imag >= -rounding)
    assert np.all(stiffness.real >= -rounding)


def storage_from_loss(loss: Callable[[np.ndarray], np.ndarray], relaxed: float) -> np.ndarray:
    """K'(w) = K'(0) + PV integral over v of K''(w e^v) (1 - coth v) / pi.

    The rule of the integral steps around v = 0.
    """
    v = 0.2 * (np.arange(-1100, 200) + 0.5)
    log_omega = np.log(OMEGA[:, None]) + v
    weights = 0.2 / np.pi * (1.0 - 1.0 / np.tanh(v))
    return relaxed + loss(log_omega.ravel()).reshape(log_omega.shape) @ weights


@pytest.mark.parametrize("name", MODELS)
def test_storage_follows_from_loss_by_kramers_and_kronig(name: str, rng: np.random.Generator):
    model = MODELS[name]
    theta = sample(model.parameters, rng)

    def at(log_omega: np.ndarray) -> np.ndarray:
        return model.network.respond(theta, Points(log_omega)).value

    storage = storage_from_loss(
        lambda log_omega: at(log_omega).imag, at(np.array([-220.0])).real[0]
    )
    exact = model.stiffness(theta, OMEGA)
    np.testing.assert_allclose(storage / np.abs(exact), exact.real / np.abs(exact), atol=1e-8)


def test_kramers_and_kronig_refuse_a_loss_that_does_not_belong_to_the_storage():
    model, theta = MODELS["fractional-zener"], np.array([1.0, 2.0, 3.0, 0.5])

    def tilted(log_omega: np.ndarray) -> np.ndarray:
        return model.network.respond(theta, Points(log_omega)).value.imag * (
            1 + 0.01 * np.tanh(log_omega)
        )

    exact = model.stiffness(theta, OMEGA).real
    assert np.max(np.abs(storage_from_loss(tilted, 1.0) / exact - 1)) > 1e-3


def converted(
    model: Model, theta: np.ndarray, stiffness: float, time: float = 1.0, amplitude: float = 1.0
) -> np.ndarray:
    """`theta` in units where stiffness, time and amplitude have these values for each old one."""
    values = dict(zip(model.names, theta, strict=True))

    def factor(unit: Dimension) -> float:
        power = values[unit.time] if isinstance(unit.time, str) else unit.time
        return stiffness**unit.stiffness * time**power * amplitude**unit.amplitude

    return theta * np.array([factor(parameter.unit) for parameter in model.parameters])


@pytest.mark.parametrize("name", MODELS)
def test_units_are_those_of_the_equations(name: str, rng: np.random.Generator):
    """From N to kN and from s to min the numbers change as the parameters' units say."""
    model = MODELS[name]
    theta = sample(model.parameters, rng)
    minutes = model.stiffness(converted(model, theta, 1e-3, time=1 / 60), OMEGA * 60)
    np.testing.assert_allclose(minutes, 1e-3 * model.stiffness(theta, OMEGA), rtol=1e-9)


@pytest.mark.parametrize("effect", [name for name in OF_THE_NETWORK if name not in AT_UNIT_SPEED])
def test_units_of_effects_are_those_of_their_equations(effect: str, rng: np.random.Generator):
    """From newton and metre to kilonewton and millimetre."""
    model, at = MODELS["fractional-zener"] + effect, points()
    assert at.amplitude is not None
    theta = sample(model.parameters, rng)
    in_millimetres = replace(at, amplitude=1e3 * at.amplitude)
    other = model.stiffness(converted(model, theta, 1e-6, amplitude=1e3), in_millimetres)
    np.testing.assert_allclose(other, 1e-6 * model.stiffness(theta, at), rtol=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_units_are_printed(name: str):
    model = MODELS[name]
    searched: tuple[Parameter, ...] = model.search.parameters if model.search else ()
    for parameter in (*model.parameters, *searched):
        for units in (Units("kN/m", "mm"), Units("Pa", "-")):
            _, label = units.of(parameter.unit)
            assert label.strip()
            if parameter.unit.stiffness:
                assert units.stiffness.split("/")[0] in label
        if isinstance(parameter.unit.time, str):
            assert parameter.unit.time in [
                p.name for p in (searched if parameter in searched else model.parameters)
            ]


def test_units_are_printed_as_the_paper_prints_them():
    (_, c), (_, alpha) = (Units("kN/m", "mm").of(p.unit) for p in MODELS["springpot"].parameters)
    assert (c, alpha) == ("kN s^alpha/m", "-")


@pytest.mark.parametrize("name", MODELS)
def test_leading_axes_equal_looping(name: str, rng: np.random.Generator):
    model = MODELS[name]
    theta = sample(model.parameters, rng, (2, 3))
    stiffness, jacobian, slope = (
        f(theta, OMEGA) for f in (model.stiffness, model.jacobian, model.slope)
    )
    assert jacobian.shape == (2, 3, len(OMEGA), len(model.names))
    for i in np.ndindex(2, 3):
        np.testing.assert_allclose(stiffness[i], model.stiffness(theta[i], OMEGA), rtol=1e-13)
        np.testing.assert_allclose(
            jacobian[i], model.jacobian(theta[i], OMEGA), rtol=1e-12, atol=1e-14
        )
        np.testing.assert_allclose(slope[i], model.slope(theta[i], OMEGA), rtol=1e-12, atol=1e-14)


def searched_points(model: Model, rng: np.random.Generator, n: int) -> np.ndarray:
    assert model.search is not None
    low_high = model.search.ordered
    x = sample(model.search.parameters, rng, (n,))
    if low_high:
        x[:, list(low_high)] = np.sort(x[:, list(low_high)], axis=-1)
    return x


@pytest.mark.parametrize("name", SEARCHED)
def test_search_forms_invert_and_their_jacobians_are_exact(name: str, rng: np.random.Generator):
    form = MODELS[name].search
    assert form is not None
    x = searched_points(MODELS[name], rng, 4)
    np.testing.assert_allclose(form.from_elements(form.to_elements(x)), x, rtol=1e-10)
    for one, exact in zip(x, form.jacobian(x), strict=True):
        numeric = cauchy(form.to_elements, one)
        np.testing.assert_allclose(exact, numeric, rtol=1e-9, atol=1e-9 * np.max(np.abs(numeric)))


@pytest.mark.parametrize("name", SEARCHED)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_any_repaired_search_point_is_within_the_model_s_bounds(name: str, seed: int):
    model = MODELS[name]
    assert model.search is not None
    x = sample(model.search.parameters, np.random.default_rng(seed), (20,))
    theta = model.search.to_elements(model.search.repaired(x))
    assert np.all(theta >= [p.lower for p in model.parameters])
    assert np.all(theta <= [p.upper for p in model.parameters])


@pytest.mark.parametrize("name", MODELS)
def test_the_whole_box_of_the_race_is_finite(name: str, rng: np.random.Generator):
    """Optimisers visit corners; none may meet an infinity or a warning there."""
    measurement = Measurement(omega=OMEGA, stiffness=500 * (1j * OMEGA) ** 0.4)
    box = paper_box(MODELS[name], measurement)
    inside = rng.random((500, len(box.lower)))
    for x in (inside, np.round(inside)):
        theta = box.theta(box.lower + x * (box.upper - box.lower))
        with np.errstate(all="raise", under="ignore"):
            assert np.all(np.isfinite(MODELS[name].stiffness(theta, OMEGA)))
            assert np.all(np.isfinite(MODELS[name].jacobian(theta, OMEGA)))


@pytest.mark.parametrize("name", LIMITED)
def test_limits_are_those_of_the_search_form(name: str, rng: np.random.Generator):
    model = MODELS[name]
    assert model.search is not None
    searched = [p.name for p in model.search.parameters]
    x = searched_points(model, rng, 1)[0]
    far = Points(np.array([-200.0, 200.0]))
    limits = model.network.respond(model.search.to_elements(x), far).value
    np.testing.assert_allclose(
        limits, [x[searched.index("k0")], x[searched.index("kinf")]], rtol=1e-6
    )


@pytest.mark.parametrize("effect", OF_THE_NETWORK)
def test_a_grown_network_still_shows_its_material(effect: str):
    model = MODELS["fractional-kelvin4"] + effect
    picture = drawing_of(model)
    assert f"{effect}." in picture
    for name in MODELS["fractional-kelvin4"].names:
        assert re.search(rf"\b{name}\b", picture)


def test_names_and_aliases_are_unique():
    counted = Counter(
        name for item in plugins().items("model") for name in (_title(item), *item.aliases)
    )
    assert [name for name, count in counted.items() if count > 1] == []


def _title(item: Model | Family) -> str:
    return item.name


@pytest.mark.parametrize("item", list(plugins().items("model")), ids=_title)
def test_aliases_resolve(item: Model | Family):
    for alias in (_title(item), *item.aliases):
        found = parse_model(alias.replace("-N", "-3"))
        assert found.base == (item.build(3).base if isinstance(item, Family) else item.base)


@pytest.mark.parametrize("effect", OF_THE_NETWORK)
@pytest.mark.parametrize("name", ["springpot", "fractional-zener", "makris", "prony-4"])
def test_expressions_round_trip(name: str, effect: str):
    text = f"{name} + {effect}"
    model = parse_model(text)
    assert str(model) == text
    again = parse_model(str(model))
    assert again.names == model.names
    assert str(model - effect) == name
    assert parse_model(f"  {name}+{effect} ").name == text


def test_an_effect_taken_twice_keeps_its_parameters_apart():
    names = parse_model("spring + filter-mismatch + filter-mismatch").names
    assert names == ("k", "filter-mismatch.tau", "filter-mismatch#2.tau")
    names = parse_model("kelvin + relaxation-mode + relaxation-mode").names
    assert names[-2:] == ("relaxation-mode#2.k", "relaxation-mode#2.tau")


SUMS = (
    "inertia parallel-spring series-spring series-dashpot friction time-delay gain-error"
    " phase-error arrhenius-shift"
)


@pytest.mark.parametrize("effect", SUMS.split())
def test_the_same_thing_twice_is_refused(effect: str):
    """Two masses are one mass, two delays one delay: no data could share the size between them."""
    with pytest.raises(ModelError, match=f"has the effect '{effect}' already"):
        parse_model(f"kelvin + {effect} + {effect}")
    with pytest.raises(ModelError, match="a second one would be the same"):
        parse_model(f"kelvin + {effect}") + effect


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("fractional-maxwel", "did you mean fractional-maxwell"),
        ("prony-N", "needs a number for N"),
        ("prony-0", "unknown model"),
        ("kelvin + ", "empty part"),
        ("kelvin + inertai", "did you mean inertia"),
        ("fractional-maxwell-gel", "unknown model"),
    ],
)
def test_a_wrong_expression_is_one_line_with_a_hint(text: str, says: str):
    with pytest.raises(ModelError, match=re.escape(says)) as caught:
        parse_model(text)
    assert "\n" not in str(caught.value)
