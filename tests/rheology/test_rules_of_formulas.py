"""Rules of typed formulas: where a fault stands, what a parameter may be, what its size is."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.rheology import grammar, parameters
from springpot.rheology.typed import Parts, expression_parts
from springpot.rheology.written import size_of, written

LAWS = ("slip", "drag")


@pytest.mark.parametrize(
    ("text", "offset", "place"),
    [
        ("k+)", 2, 3),
        ("  k+)", 2, 5),
        ("k^2+)", 5, 5),
        (" k^2*a^3+)", 10, 10),
        ("k**2+)", 5, 6),
        ("k^2+)+a^3", 5, 5),
    ],
)
def test_a_fault_is_told_at_the_sign_that_the_user_typed(text, offset, place):
    """Python counts a power as two signs, and none of the blanks before."""
    assert grammar._place(text, offset) == place
    assert text[place - 1] == ")"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("exp(k, 2)", "exp takes 1 part"),
        ("exp(X, **k)", "exp takes 1 part"),
        ("exp()", "exp takes 1 part"),
        ("min(X)", "min takes 2 parts"),
        ("max(X, Xc, 3)", "max takes 2 parts"),
        ("sinus(X)", "'sinus' is no function: known are "),
    ],
)
def test_a_function_takes_its_parts_and_no_names(text, says):
    with pytest.raises(ModelError, match=says.replace("(", r"\(")):
        grammar.parsed(text)


def test_a_function_of_two_joins_them():
    assert isinstance(grammar.parsed("min(X, Xc)"), grammar.Joined)
    assert isinstance(grammar.parsed("exp(X)"), grammar.Called)


@pytest.mark.parametrize(
    ("text", "plane", "name", "lower", "upper", "scale"),
    [
        ("k*(i*omega*tau)^a", "stiffness", "a", 0.0, 1.0, "linear"),
        ("k*(1+(X/Xc)^n)", "stiffness", "n", 0.0, 4.0, "linear"),
        ("k*(1+a*(X/Xc)^2)", "stiffness", "a", 0.0, inf, "log"),
        ("k*(1+a*(X/Xc)^n)", "stiffness", "a", 0.0, inf, "log"),
        ("k*exp(2^a*X/Xc)", "stiffness", "a", 0.0, inf, "log"),
        ("(T/T0)^m", "log-complex", "m", -20.0, 20.0, "linear"),
        ("E/(R*T)", "shift", "E", 0.0, 2000.0, "log"),
        ("k*exp(T/Ta)", "stiffness", "Ta", 0.0, 1e4, "log"),
    ],
)
def test_bounds_of_a_parameter_are_those_of_what_it_is(text, plane, name, lower, upper, scale):
    [found] = [each for each in written(text, plane).free if each.name == name]
    assert (found.lower, found.upper, found.scale) == (lower, upper, scale)
    assert found.symbol == name


@pytest.mark.parametrize(
    ("text", "plane", "size"),
    [
        ("k*(1+a*(X/Xc)^n)", "stiffness", ("k", 0.0)),
        ("1e-30*(1+a)*k", "stiffness", ("k", 0.0)),
        ("1 + (X/Xc)^2", "log-complex", ("Xc", inf)),
        ("1 + a*(X/Xc)^2", "log-complex", ("a", 0.0)),
        ("k + c*i*omega", "stiffness", None),
    ],
)
def test_the_size_of_a_law_is_what_alone_makes_it_vanish(text, plane, size):
    assert size_of(written(text, plane)) == size


@pytest.mark.parametrize(
    ("expression", "parts"),
    [
        ("kelvin", Parts("kelvin", False, ())),
        ("kelvin + slip + drag", Parts("kelvin", False, ("slip", "drag"))),
        ("k + c*i*omega", Parts("k + c*i*omega", True, ())),
        ("k*X + slip + drag", Parts("k*X", True, ("slip", "drag"))),
        ("slip*2 + slip + k*X + drag", Parts("slip*2 + slip + k*X", True, ("drag",))),
    ],
)
def test_a_formula_is_told_from_a_name_by_its_signs(expression, parts):
    assert expression_parts(expression, lambda name: name in LAWS) == parts


@pytest.mark.parametrize("form", [parameters.MAXWELL_FORM, parameters.KELVIN_FORM])
def test_the_slopes_of_a_search_form_are_its_differences(form):
    x, step = np.array([2.0, 7.0, 0.3, 0.6]), 1e-6
    there = form.to_elements
    found = [
        (there(x + step * x[i] * unit) - there(x - step * x[i] * unit)) / (2.0 * step * x[i])
        for i, unit in enumerate(np.eye(4))
    ]
    np.testing.assert_allclose(form.jacobian(x), np.array(found).T, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(form.from_elements(there(x)), x)
