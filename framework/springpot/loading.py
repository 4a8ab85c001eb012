"""What springpot wrote, taken up again; and a model with known parameters, as a user states them.

A fit is whole: it predicts, draws and tells its intervals as before. Of a diagnosis, a discovery,
a comparison and an invention the file holds what they say, not the fits behind it. A known model is
what predictions, solvers and structures take.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from springpot.comparison.result import Comparison, Ranking
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.errors import DataError, ModelError
from springpot.files import bytes_of, json_of, keep_input
from springpot.identification.levels_alone import usual_objective
from springpot.identification.prediction import Known
from springpot.identification.problem import Objective, default_objective
from springpot.identification.result import Identification
from springpot.invention.result import Invention
from springpot.measurement.measurement import Measurement
from springpot.measurement.units import MODULUS_UNITS, Units, known_unit
from springpot.plain_data import as_declared
from springpot.registry import effect_of, parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.elements import spring
from springpot.rheology.model import Model
from springpot.rheology.parameters import Dimension
from springpot.rheology.points import ROOM
from springpot.rheology.tied import allowed, hold
from springpot.writing import suggested

AGAIN = "give the output of a command of springpot with --json"


Loaded: TypeAlias = Identification | Diagnosis | Ladder | Comparison | Invention


def load(path: str | Path) -> Loaded:
    """What a command or `to_dict` wrote as JSON: a fit, a diagnosis, a discovery, an invention ...

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Identification, Diagnosis, Ladder, Comparison or Invention
        By the schema that the file names: what the command or `to_dict` told of.

    Raises
    ------
    DataError
        If the file cannot be read or holds none of these.
    ModelError
        If a model or effect in it is not installed.

    Examples
    --------
    >>> import json, springpot
    >>> fit = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    >>> with open("fit.json", "w") as file:
    ...     json.dump(fit.to_dict(), file)
    >>> springpot.load("fit.json")["inertia.m"] == fit["inertia.m"]
    True
    """
    answer = _read(Path(path))
    schema = None
    # Other JSON may be a list or a number.
    if isinstance(answer, dict):
        schema = answer.get("schema")
    if not isinstance(schema, str) or schema not in _KNOWN:
        raise DataError(
            f"{path} holds no answer that can be loaded ({schema or 'no schema'}): {AGAIN}"
        )
    try:
        # Of a parameter that is nothing, as a part of a series, the slopes may be no numbers.
        with np.errstate(divide="ignore", invalid="ignore"):
            return as_declared(_KNOWN[schema](answer))
    except (DataError, ModelError) as error:
        raise type(error)(f"{path}: {error}") from None
    # A file that was cut off or edited by hand fails anywhere: to its user these are one fault.
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise DataError(
            f"{path} is damaged or of an older version ({type(error).__name__}: {error}): {AGAIN}"
        ) from None


def law_of(path: str | Path, name: str = "law-1") -> Effect:
    """The law in a file of ``springpot invent -o``, as an effect.

    Parameters
    ----------
    path : str or Path
        The file.
    name : str
        What it is to be called.

    Raises
    ------
    DataError
        If the file holds no invention.
    ModelError
        If no law was found.
    """
    found = load(path)
    if not isinstance(found, Invention):
        raise DataError(f"{path} holds no law: give a file that the command invent wrote by -o")
    return found.effect(name)


def _read(path: Path) -> Any:
    # A structure names its fits, which no argument of the command line does.
    keep_input(path)
    try:
        return json_of(bytes_of(path).decode("utf-8-sig"), finite=True)
    except ValueError as error:
        # Of what is no text in UTF-8, as data of an old spreadsheet, the reason; else the message.
        why = getattr(error, "reason", getattr(error, "msg", error))
        raise DataError(
            f"{path} is no JSON ({why}): {AGAIN}; data are opened by springpot.read"
        ) from None


def _fit(answer: dict[str, Any]) -> Identification:
    model = parse_model(answer["model"])
    return Identification.from_dict(answer, model, partial(_objective, model))


def _objective(model: Model, name: str, data: Measurement) -> Objective:
    # The objective that is taken where none is named need not be a plugin's, so it comes first.
    standard = default_objective(data)
    objective = standard
    if standard.name != name:
        objective = plugins().find("objective", name)
    return usual_objective(model, data, objective)


def _comparison(answer: dict[str, Any]) -> Comparison:
    if "ranking" in answer:
        return Ranking.from_dict(answer)
    return Comparison.from_dict(answer)


# At the end, as it holds the functions above. The number is that of the schema: a change of it is
# another reader.
_KNOWN: dict[str, Callable[[dict[str, Any]], Loaded]] = {
    "springpot.identification/2": _fit,
    "springpot.diagnosis/2": Diagnosis.from_dict,
    "springpot.discovery/2": Ladder.from_dict,
    "springpot.comparison/2": _comparison,
    "springpot.invention/1": Invention.from_dict,
}


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
    first = plugins().shelf("effect").find(names[0])
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
