"""A wrong derivative of a plugin's model is noticed on first use, whatever uses the model."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.identification import Problem, default_objective, problem as derivative
from springpot.measurement import Measurement, Units
from springpot.rheology import Formula, Model, Parameter
from springpot.rheology.elements import Springpot
from springpot.rheology.nodes import VALUE
from springpot.rheology.parameters import order, quasi_property

OMEGA = 2 * np.pi * np.geomspace(0.5, 50.0, 25)


def model(slip):
    """A fractional Kelvin element, its derivative off by `slip` of the share of one parameter."""

    def respond(at, k, c, alpha):
        power = (1j * at.omega) ** alpha
        log = np.log(1j * at.omega)
        slopes = [np.ones_like(power), power, c * power * log]
        for i, off in enumerate(slip):
            slopes[i] = slopes[i] * (1.0 + off)
        return k + c * power, tuple(slopes), c * alpha * power

    parameters = (Parameter("k", "k"), Parameter("c", "c"), order())
    return Model(f"slip {slip}", Formula(parameters, respond, kind="slip"), "a test", "none")


def data(scale=1.0):
    stiffness = scale * (100.0 + 60.0 * (1j * OMEGA) ** 0.5)
    return Measurement(OMEGA, stiffness, units=Units("kN/m"), name="kelvin")


@pytest.mark.parametrize("scale", [1.0, 1e6])
@pytest.mark.parametrize(
    ("slip", "name"), [((0.1, 0, 0), "k"), ((0, -2.0, 0), "c"), ((0, 0, 0.01), "alpha")]
)
def test_it_is_told_before_anything_is_fitted(slip, name, scale):
    for use in (
        lambda: springpot.identify(data(scale), model(slip)),
        lambda: springpot.diagnose(data(scale), model(slip)),
        lambda: Problem.of(model(slip), data(scale), default_objective(data(scale))),
    ):
        for _ in range(2):
            with pytest.raises(ModelError, match=rf"by {name} is wrong by"):
                use()


class TwoWays(Springpot):
    """A springpot whose quick way, without derivatives, has a slip in it."""

    def respond(self, theta, at, depth=VALUE):
        found = super().respond(theta, at, depth)
        if depth == VALUE:
            return found._replace(value=1.02 * found.value)
        return found


def test_so_is_a_stiffness_that_depends_on_whether_derivatives_are_asked_for():
    careless = Model("careless", TwoWays(quasi_property("c", "alpha"), order()), "a test", "none")
    for _ in range(2):
        with pytest.raises(
            ModelError,
            match="stiffness of careless is another by 2 % where its derivative is asked",
        ):
            springpot.identify(data(), careless)


def test_a_right_derivative_is_no_complaint():
    found = springpot.identify(data(), model((0, 0, 0)))
    assert found.theta == pytest.approx([100.0, 60.0, 0.5], rel=1e-6)


@pytest.mark.parametrize(
    "name", [each.name for each in springpot.plugins().items("effect") if not each.of_test]
)
def test_no_installed_effect_is_accused(name):
    conditions = {
        "temperature": np.linspace(10.0, 40.0, len(OMEGA)),
        "amplitude": np.linspace(0.5, 2.0, len(OMEGA)),
    }
    measured = replace(data(), conditions=conditions, units=Units("kN/m", "mm"))
    grown = springpot.parse_model("fractional-maxwell") + name
    Problem.of(grown, measured, default_objective(measured))


@pytest.mark.parametrize(
    ("apart", "wrong"), [((0.1, 0.0, 0.0, 0.0), False), ((0.1, 0.1, 0.1, 0.1), True)]
)
def test_what_differs_at_one_place_only_has_no_single_solution_there(monkeypatch, apart, wrong):
    """If a hardening mount balances a resonant specimen, rounding picks one of two amplitudes."""
    found = iter(apart)
    monkeypatch.setattr(derivative, "_apart", lambda *_: next(found))
    sound = model((0.0, 0.0, 0.0))
    derivative._checked.discard(sound.network)
    theta, points = np.array([100.0, 60.0, 0.5]), data().points
    if not wrong:
        derivative.require_derivative(sound, theta, points)
        return
    with pytest.raises(ModelError, match="another by 10 %"):
        derivative.require_derivative(sound, theta, points)
