"""The equation that an effect is listed with is the one it computes."""

import re

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import gamma

import springpot
from springpot import Units
from springpot.errors import SpringpotError
from springpot.registry import plugins
from springpot.rheology import Effect, Points
from springpot.rheology.terms import slip_fraction

OMEGA = 2.0 * np.pi * np.geomspace(0.1, 100.0, 9)
AMPLITUDE = np.geomspace(0.2, 4.0, 9)
TEMPERATURE = np.linspace(270.0, 330.0, 9)
REFERENCE = 295.0
MODEL = springpot.parse_model("fractional-maxwell")
THETA = np.array([400.0, 60.0, 0.5])
VALUES = {
    "k": 120.0,
    "c": 3.0,
    "m": 2e-3,
    "F": 30.0,
    "tau": 0.02,
    "k3": 5.0,
    "c3": 1e-3,
    "h": 0.4,
    "Xh": 0.9,
    "Xc": 1.1,
    "Vc": 7.0,
    "b": 0.6,
}
VALUES |= {
    "q": 0.03,
    "s": 1e-6,
    "phi": 0.1,
    "g": 0.2,
    "e": 0.05,
    "Ea": 40.0,
    "C1": 5.0,
    "C2": 120.0,
    "n": 1.2,
}
VALUES |= {"b": 0.6, "alpha": 0.3, "a": 0.7, "zeta": 0.1, "omega_r": 300.0}
OWN = {("payne", "m"): 0.6, ("hysteretic-loss", "h"): 12.0, ("basset", "c"): 0.02}
# A loop that solves a differential equation is compared with it in time, in
# test_describing_functions.
EFFECTS = sorted(
    (
        effect
        for effect in plugins().items("effect")
        if "z' =" not in effect.equation and not (effect.by_levels or effect.of_test)
    ),
    key=lambda effect: effect.name,
)
SHARED = "Y = "
"""An amplitude that its own definition holds.

What the element of a series takes of the displacement.
"""

WARM = "P = omega * imag(K(omega * exp(-s * P)))"
"""A power that its own definition holds: that of the specimen which it warms."""
STEPS_TO_STEADY = 50


def modelled(omega):
    return MODEL.stiffness(THETA, omega)


class Stiffness(np.ndarray):
    """K at the measured frequencies, and K(omega) where it is called."""

    def __call__(self, omega):
        return modelled(omega)


def evaluated(equation, values):
    """The equation read as arithmetic; definitions follow it after commas."""
    functions = ["exp", "sin", "tan", "tanh", "sqrt", "arcsin", "arccos", "imag", "pi", "abs"]
    names = {name: getattr(np, name) for name in functions}
    names |= {"gamma": gamma, "min": np.minimum, "i": 1j, "s": 1j * OMEGA, "omega": OMEGA}
    names |= {"R": 8.31446261815324e-3, "slider": lambda r: slip_fraction(r)[0]}
    names |= {
        "K": modelled(OMEGA).view(Stiffness),
        "X": AMPLITUDE,
        "T": TEMPERATURE,
        "Tr": REFERENCE,
        **values,
    }
    typed = re.sub(r"\|(.*)\|", r"abs(\1)", equation.replace("^", "**"))
    whole, *definitions = re.split(r", (\w+) = ", typed)
    meanings = dict(zip(definitions[::2], definitions[1::2], strict=True))
    if SHARED in equation:
        names["Y"] = np.array([shared(names, meanings, row) for row in range(len(OMEGA))])
        del meanings["Y"]
    if WARM in equation:
        names["P"] = 0.0
        for _ in range(STEPS_TO_STEADY):
            names["P"] = eval(meanings["P"], {}, names)
    for name, meaning in reversed(meanings.items()):
        names[name] = eval(meaning, {}, names)
    return np.asarray(eval(whole, {}, names))


def shared(names, meanings, row):
    """The amplitude at one row that is what its definition says."""

    def off(amplitude):
        here = {name: value[row] if np.ndim(value) else value for name, value in names.items()} | {
            "Y": amplitude
        }
        for name, meaning in reversed(meanings.items()):
            if name != "Y":
                here[name] = eval(meaning, {}, here)
        return eval(meanings["Y"], {}, here) - amplitude

    return brentq(off, 1e-9, AMPLITUDE[row] * 10.0, xtol=1e-14)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_the_equation_is_what_the_effect_computes(effect):
    grown = MODEL + effect
    own = {
        p.name: OWN.get((effect.name, p.name), VALUES[p.name]) for p in effect.element.parameters
    }
    theta = dict(zip(MODEL.names, THETA, strict=True)) | {
        f"{effect.name}.{name}": own[name] for name in own
    }
    at = Points(np.log(OMEGA), AMPLITUDE, TEMPERATURE, REFERENCE)
    computed = grown.stiffness(np.array([theta[name] for name in grown.names]), at)
    np.testing.assert_allclose(evaluated(effect.equation, own), computed, rtol=1e-10, atol=1e-10)


PLANES = {
    r"1 / \(1 / K \+ (.*)\)": "series: ",
    r"K\(omega \* ([^,]*)\)": "shift: ",
    r"K \+ (.*)": "parallel: ",
    r"K - (.*)": "parallel: -",
    r"K \* (.*)": "chain: ",
    r"K / (.*)": "chain: 1 / ",
}
NOT_TYPED = {
    # They ask for the model's own K, or have a part in series within one beside the model.
    *("specimen-inertia", "specimen-inertia-fixed", "self-heating", "yielding"),
    # Functions and cases that no formula has.
    *("elasto-sliding", "dead-zone", "power-law-damper", "filter-mismatch"),
    "power-law-slip",
}


def formula_of(equation):
    """The equation as somebody would type it, and its definitions where they are used."""
    whole, *definitions = re.split(r", (\w+) = ", equation)
    for name, meaning in zip(definitions[::2], definitions[1::2], strict=True):
        # What a part in series takes itself is a name of its own.
        if f"{name} = " == SHARED:
            continue
        whole = re.sub(rf"\b{name}\b", f"({meaning})", whole)
    found = ((re.fullmatch(pattern, whole), plane) for pattern, plane in PLANES.items())
    return next(plane + match[1] for match, plane in found if match)


@pytest.mark.parametrize(
    "effect",
    [effect for effect in EFFECTS if effect.name not in NOT_TYPED],
    ids=lambda effect: effect.name,
)
def test_the_formula_of_an_effect_is_that_effect(effect):
    typed = Effect.from_formula("typed", formula_of(effect.equation))
    names = [p.name for p in effect.element.parameters]
    assert [p.name for p in typed.element.parameters] == names
    assert typed.vanishes_at == effect.vanishes_at
    # A rig's drag asks for the temperature only to be no material's.
    assert typed.needs == effect.needs - {"temperature"} or typed.needs == effect.needs
    units = Units("kN/m", "mm")
    for own, installed in zip(typed.element.parameters, effect.element.parameters, strict=True):
        # To a formula an angle is a pure number.
        assert units.of(own.unit)[1] == units.of(installed.unit)[1].replace("rad", "-", 1) or (
            own.unit == installed.unit
        )
    own = [OWN.get((effect.name, name), VALUES[name]) for name in names]
    theta = np.array([*THETA, *own])
    at = Points(np.log(OMEGA), AMPLITUDE, TEMPERATURE, REFERENCE)
    computed = (MODEL + effect).stiffness(theta, at)
    np.testing.assert_allclose((MODEL + typed).stiffness(theta, at), computed, rtol=1e-12)


def test_what_no_formula_holds_is_refused():
    for effect in EFFECTS:
        if effect.name in NOT_TYPED:
            with pytest.raises(SpringpotError):
                Effect.from_formula("typed", formula_of(effect.equation))


def test_a_negative_delay_of_a_filter_sits_in_the_other_channel():
    effect = next(effect for effect in EFFECTS if effect.name == "filter-mismatch")
    grown = MODEL + effect
    computed = grown.stiffness(np.array([*THETA, -0.02]), Points(np.log(OMEGA)))
    np.testing.assert_allclose(evaluated(effect.equation, {"tau": -0.02}), computed, rtol=1e-10)
