"""Factors for each level.

What is a level, exact derivatives, the same physics as a law of temperature.
"""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import springpot
from springpot.diagnosis.search import applicable
from springpot.errors import ModelError
from springpot.registry import parse_model, plugins
from springpot.rheology import FULL, Levels, Points, levels_of, wlf
from springpot.rheology.nodes import GRADIENT

OMEGA = np.geomspace(0.1, 100.0, 12)
CELSIUS = np.repeat([0.0, 20.0, 22.5, -40.0], 3)
POINTS = Points(np.log(OMEGA), temperature=CELSIUS + 273.15, reference_temperature=293.15)
BASE = {"k": 2.0, "c": 1.3, "alpha": 0.7}


def bound(expression="fractional-maxwell + free-shift + free-vertical-shift"):
    return parse_model(expression).bound_to(POINTS)


def some_theta(model):
    values = dict(BASE)
    for i, name in enumerate(model.names):
        values.setdefault(name, 0.5 + 0.3 * i)
    return model.vector(values)


def test_a_template_takes_its_levels_from_the_points_and_names_each_factor():
    own = bound().names[3:]
    assert own[:3] == ("free-shift.a_m40", "free-shift.a_0", "free-shift.a_22p5")
    assert own[3:] == tuple(
        name.replace("free-shift.a", "free-vertical-shift.b") for name in own[:3]
    )


def test_a_bound_effect_keeps_its_levels():
    model = bound()
    assert model.bound_to(POINTS.shifted(np.ones(12))) is model


def test_a_model_without_levels_is_left_as_it_is():
    model = parse_model("fractional-maxwell + wlf-shift")
    assert model.bound_to(POINTS) is model


@pytest.mark.parametrize(
    ("column", "values", "expected"),
    [
        ("temperature", [20.0, 20.3, 19.8, 25.0, 24.9], [0, 0, 0, 1, 1]),
        ("amplitude", [1.0, 1.01, 0.99, 2.0, 2.03], [0, 0, 0, 1, 1]),
        ("water", [0.0, 5.0, 0.0, 5.005, 10.0], [0, 1, 0, 1, 2]),
    ],
)
def test_what_a_rig_holds_only_nearly_is_one_level(column, values, expected):
    assert levels_of(column, np.array(values)).tolist() == expected


def test_a_drifting_temperature_is_not_one_level():
    ramp = np.linspace(0.0, 40.0, 200)
    number = levels_of("temperature", ramp)
    assert max(np.ptp(ramp[number == i]) for i in range(number.max() + 1)) <= 1.0


@given(
    st.lists(st.floats(-50.0, 150.0), min_size=1, max_size=30), st.randoms(use_true_random=False)
)
def test_levels_do_not_depend_on_the_order_of_rows(values, random):
    order = list(range(len(values)))
    random.shuffle(order)
    number = levels_of("temperature", np.array(values))
    shuffled = levels_of("temperature", np.array(values)[order])
    assert shuffled.tolist() == number[order].tolist()


def test_free_factors_can_be_those_of_a_law():
    """At the levels a free shift is WLF if its factors are."""
    law, theta = (
        parse_model("fractional-maxwell + wlf-shift"),
        np.array([2.0, 1.3, 0.7, 8.0, 120.0]),
    )
    free = bound("fractional-maxwell + free-shift")
    at = np.array([-40.0, 0.0, 22.5]) + 273.15
    a = np.exp(wlf().respond(theta[3:], Points(np.zeros(3), temperature=at)).value.real)
    own = free.vector(BASE | dict(zip(free.names[3:], a, strict=True)))
    np.testing.assert_allclose(
        free.stiffness(own, POINTS), law.stiffness(theta, POINTS), rtol=1e-12
    )


def test_derivatives_are_exact():
    """Cauchy's integral in each parameter and in ln omega."""
    model = bound()
    theta = some_theta(model)
    response = model.network.respond(theta, POINTS, FULL)
    turn = np.exp(2j * np.pi * np.arange(24) / 24)
    for i, value in enumerate(theta):
        total = 0.0
        for each in turn:
            moved = theta.astype(complex)
            moved[i] += 0.02 * value * each
            total = total + model.network.respond(moved, POINTS).value / each / (24 * 0.02 * value)
        np.testing.assert_allclose(response.by_theta[i], total, rtol=1e-9, atol=1e-10)
    along = sum(model.network.respond(theta, POINTS.shifted(0.02 * t)).value / t for t in turn) / (
        24 * 0.02
    )
    np.testing.assert_allclose(response.by_log_omega, along, rtol=1e-9)


def test_between_levels_the_logarithm_is_interpolated_and_beyond_them_it_stays():
    levels = Levels("water", values=(0.0, 10.0, 20.0), reference=0)
    at = Points(np.zeros(4), columns={"water": np.array([5.0, 10.0, 15.0, 90.0])})
    value = levels.respond(np.array([4.0, 16.0]), at, GRADIENT).value
    np.testing.assert_allclose(np.exp(value.real), [2.0, 4.0, 8.0, 16.0], rtol=1e-12)


def test_any_column_can_have_factors():
    water = np.repeat([0.0, 5.0], 6)
    data = springpot.Measurement(OMEGA, OMEGA * (1 + 1j), conditions={"water": water})
    model = parse_model("material + free-shift:water").bound_to(data.points)
    assert model.names[-1] == "free-shift:water.a_5"
    assert model.needs == {"water"}


def test_temperature_and_another_column_can_both_have_factors():
    expression = "fractional-maxwell + free-shift + free-shift:water"
    assert parse_model(expression).name == expression


@pytest.mark.parametrize(
    ("expression", "match"),
    [
        ("material + inertia:", "name a test"),
        ("material + free-shift:", "name a column"),
        ("material + free-shift + free-shift", "already"),
        ("material + free-shift + free-shift:temperature", "already"),
    ],
)
def test_what_makes_no_sense_is_refused(expression, match):
    with pytest.raises(ModelError, match=match):
        parse_model(expression)


def test_one_level_needs_no_factor():
    data = springpot.Measurement(
        OMEGA, OMEGA * (1 + 1j), conditions={"temperature": np.full(12, 20.0)}
    )
    with pytest.raises(ModelError, match="two levels of temperature"):
        springpot.identify(data, "material + free-shift")


def test_a_missing_column_is_named():
    data = springpot.Measurement(OMEGA, OMEGA * (1 + 1j))
    with pytest.raises(ModelError, match="salt"):
        springpot.identify(data, "material + free-shift:salt")


def test_a_column_with_gaps_is_refused():
    salt = np.where(np.arange(12) < 3, np.nan, 1.0)
    data = springpot.Measurement(OMEGA, OMEGA * (1 + 1j), conditions={"salt": salt})
    with pytest.raises(ModelError, match="salt"):
        springpot.identify(data, "material + free-shift:salt")


def test_diagnosis_looks_for_laws_and_not_for_factors_of_every_level():
    assert {"free-shift", "free-vertical-shift"} <= set(plugins().names("effect"))
    data = springpot.Measurement(OMEGA, OMEGA * (1 + 1j), conditions={"temperature": CELSIUS})
    assert not [
        effect.name
        for effect in applicable(list(plugins().items("effect")), data)
        if effect.by_levels
    ]
