"""A model whose parameters are known, from a fit or as a user states them.

What solvers and structures take.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.identification.prediction import Known
from springpot.identification.result import Identification
from springpot.loading import load
from springpot.measurement.units import MODULUS_UNITS, Units, known_unit
from springpot.registry import effect_of, parse_model, plugins
from springpot.rheology.elements import spring
from springpot.rheology.model import Model
from springpot.rheology.parameters import Dimension
from springpot.rheology.points import ROOM
from springpot.rheology.tied import allowed, hold
from springpot.suggestions import suggested


def fitted(path: str | Path) -> Known:
    """What a fit found, from the JSON that ``springpot identify --json`` printed.

    Raises
    ------
    DataError
        If the file cannot be read or is no fit.
    """
    answer = load(path)
    if isinstance(answer, Identification):
        return answer.of_specimen
    raise DataError(no_fit(path))


def no_fit(path: str | Path) -> str:
    """What is said of a file that holds another answer, or none."""
    making = suggested("identify", "DATA", "--model", "EXPR", "--json")
    return f"{path} is no fit: give the output of '{making}'"


def stated(expression: str, values: Mapping[str, float], unit: str | None, what: str) -> Known:
    """A model with the parameters that a user gives, in the units in which they are printed.

    A mass is in kg, but a force in that of the stiffness, or a stress in the modulus itself: kN
    where it is kN/m.

    Parameters
    ----------
    expression : str
        Such as ``fractional-maxwell``; or effects alone that act beside a material, as a slider
        that is a whole damper.
    values : mapping of str to float
        By name, all of them.
    unit : str or None
        Of the stiffness; without one the numbers are taken as they are.
    what : str
        Whose unit that is, for the message where it is unknown.

    Raises
    ------
    SpringpotError
        If model or unit are unknown, or a parameter is, lacks or has a value that it cannot take.
    """
    model = _alone(expression) or parse_model(expression)
    given = model.vector(dict(values)).tolist()
    # A bound of a stiffness or a length is zero or infinity, the same in any unit.
    printed = np.array(list(map(allowed, model.parameters, given)))
    units = Units()
    if unit is not None:
        stiffness = known_unit(unit, MODULUS_UNITS, what)
        # Of kN/m amplitudes are in m; a modulus belongs to strains, which have no unit.
        _, _, length = stiffness.partition("/")
        units = Units(stiffness, length or "-")
        factors = [_factor(units, parameter.unit) for parameter in model.parameters]
        printed = printed / np.array(factors)
    # What a user states has no uncertainty to carry on.
    exact = np.zeros((len(printed), len(printed)))
    return Known(
        model=model, theta=printed, slopes=exact, spread=exact, units=units, reference=ROOM
    )


def _alone(expression: str) -> Model | None:
    """A model of effects alone, beside nothing; None where the expression begins with a model."""
    names = [name.strip() for name in expression.split("+")]
    first = plugins().shelves["effect"].find(names[0])
    if first is None or first.plane != "stiffness":
        return None
    model = Model("nothing", hold(spring("k"), {"k": 0.0}, {}))
    for name in names:
        model = model.taking(effect_of(name))
    return model


def _factor(units: Units, dimension: Dimension) -> float:
    """By which a parameter in SI units of mechanics, or the user's, exceeds that in these units."""
    # A stiffness times its own length is a force in its own unit, whatever a fit of it would print.
    if (dimension.stiffness, dimension.amplitude) == (1, 1):
        return 1.0
    return units.of(dimension)[0]
