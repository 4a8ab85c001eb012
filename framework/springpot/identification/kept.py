"""What the JSON of a fit keeps beside what people read, so that it can be taken up again.

Theta and the data.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from math import inf
from typing import Any

import numpy as np

from springpot.measurement.conversion import LEVELS, levels_in_words
from springpot.measurement.measurement import Measurement, points_at
from springpot.measurement.units import Units
from springpot.plain_data import json_number
from springpot.rheology.effect import SWEEPS
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.points import ROOM, Real


def rates_of(model: Model) -> list[float] | None:
    """Those of the lines of any material, which the tests place; of another model nothing."""
    if not isinstance(model.material, Continuum):
        return None
    return list(model.material.rates)


def bounds_of(model: Model) -> dict[str, list[float]]:
    """Bounds that are narrower than those of physics."""
    if not model.constrained:
        return {}
    # Only what a user narrowed is kept: bounds of physics belong to the model, and may be mended
    # there.
    # So it is of what a tie leaves free, whose bounds keep what is tied within its own.
    model = model.untied()
    wide = {p.name: (p.lower, p.upper) for p in model.released().parameters}
    narrow = {}
    for origin, p in zip(model.origins, model.parameters, strict=True):
        if (p.lower, p.upper) != wide[origin]:
            narrow[origin] = [p.lower, p.upper]
    return narrow


def measurement_to_dict(data: Measurement) -> dict[str, Any]:
    """A measurement as plain data."""
    columns = {"storage_sd": None, "loss_sd": None, "repeat": None}
    if data.sd is not None:
        columns |= {"storage_sd": data.sd.real.tolist(), "loss_sd": data.sd.imag.tolist()}
    if data.repeat is not None:
        columns |= {"repeat": data.repeat.tolist()}
    return {
        "name": data.name,
        "units": asdict(data.units),
        "omega": data.omega.tolist(),
        "storage": data.storage.tolist(),
        "loss": data.loss.tolist(),
        "storage_sd": columns["storage_sd"],
        "loss_sd": columns["loss_sd"],
        "conditions": {name: column.tolist() for name, column in data.conditions.items()},
        "repeat": columns["repeat"],
        "reference": data.reference,
        **({"levels": words} if (words := words_in(data)) else {}),
    }


def words_in(data: Measurement) -> dict[str, list[str]]:
    """What the levels of its numbered columns are called."""
    told = {name: levels_in_words(data, name) for name in data.conditions}
    return {name: words for name, words in told.items() if words}


def measurement_of(kept: dict[str, Any]) -> Measurement:
    """The measurement that `measurement_to_dict` gave.

    Labels, harmonics and provenance are not kept, but for what numbered levels are called.
    """
    sd = None
    if kept["storage_sd"] is not None:
        sd = np.array(kept["storage_sd"]) + 1j * np.array(kept["loss_sd"])
    repeat, reference = None, kept["reference"]
    if kept["repeat"] is not None:
        repeat = np.array(kept["repeat"])
    if reference is not None:
        reference = float(reference)
    conditions = {
        name: np.array(column, dtype=float) for name, column in kept["conditions"].items()
    }
    levels = {
        LEVELS.format(name): json.dumps([str(word) for word in words])
        for name, words in kept.get("levels", {}).items()
    }
    return Measurement(
        np.array(kept["omega"], dtype=float),
        np.array(kept["storage"], dtype=float) + 1j * np.array(kept["loss"], dtype=float),
        sd=sd,
        conditions=conditions,
        repeat=repeat,
        units=Units(**kept["units"]),
        name=str(kept["name"]),
        reference=reference,
        provenance=levels,
    )


def called(
    words: Mapping[str, Sequence[str]], column: str, numbers: Sequence[float | str]
) -> list[float | str]:
    """What is told of these levels of a column: their names, where it numbers such."""
    if column not in words:
        return list(numbers)
    return [words[column][round(float(number)) - 1] for number in numbers]


def note_on_levels(words: Mapping[str, Sequence[str]], column: str) -> str:
    """Which number stands for which word in a numbered column; empty for one of plain numbers."""
    meant = ", ".join(f"{number} is {word}" for number, word in enumerate(words.get(column, ()), 1))
    return meant and f"{column}: {meant}"


def ends_of(kept: Mapping[str, Any], count: int) -> tuple[Real, Real]:
    """Both ends of the intervals of so many parameters, with infinity back in its place.

    Raises
    ------
    ValueError
        If they are not as many.
    """
    low, high = (np.array(kept[name], dtype=float) for name in ("low", "high"))
    if low.shape != (count,) or high.shape != (count,):
        raise ValueError(f"there are {count} parameters, and other intervals")
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def fitted_model(model: Model, kept: Mapping[str, Any]) -> tuple[Model, Real]:
    """A model of that name with what its name does not tell, and its parameters (p,).

    Raises
    ------
    ValueError
        If they cannot be those of the model.
    """
    # Lines of a spectrum lie where the tests put them.
    if kept["rates"] is not None:
        model = replace(model, material=Continuum(tuple(map(float, kept["rates"]))))
    # Nor which effects are of the rig of the sweeps that stood beside tests in time.
    alone = set(kept["only_sweeps"])
    effects = [each.at(SWEEPS) if each.name in alone else each for each in model.effects]
    bounds = {
        name: (json_number(low, -inf), json_number(high, inf))
        for name, (low, high) in kept["bounds"].items()
    }
    # As when it was fitted: first what is held and tied, then the levels of the data.
    model = replace(model, effects=tuple(effects)).holding(kept["held"], bounds)
    units = Units(**kept["units"])
    factors = {each.name: units.of(each.unit)[0] for each in model.parameters}
    model = model.tying(kept.get("ties", ()), factors)
    for name, column in kept.get("own", {}).items():
        model = model.owning([name], column)
    if "measurement" in kept:
        model = model.bound_to(measurement_of(kept["measurement"]).points)
    elif model.own:
        levels = {name: np.array(column) for name, column in kept["levels"].items()}
        size = len(next(iter(levels.values())))
        model = model.bound_to(points_at(np.zeros(size), levels, ROOM))
    # Strictly: of a model that has changed since the numbers may mean something else, and it is
    # refused.
    if any(isinstance(value, str) for value in kept["theta"]):
        raise ValueError("theta holds a word where a number belongs")
    theta = model.vector(dict(zip(model.names, kept["theta"], strict=True)))
    if not all(
        p.lower <= value <= p.upper
        for p, value in zip(model.parameters, theta.tolist(), strict=True)
    ):
        raise ValueError(f"theta {theta.tolist()} is not within the bounds of {model.name}")
    return model, theta


def coordinates_of(rows: Sequence[Any], model: Model, units: Units) -> tuple[Real, Real]:
    """Slopes and spread (p, p) of parameters, by their covariance as it is printed.

    Raises
    ------
    ValueError
        If it cannot be that of the model.
    """
    covariance = np.array(rows, dtype=float)
    count = len(model.parameters)
    if covariance.shape != (count, count):
        raise ValueError(f"the covariance cannot be that of {model.name}")
    factor = np.array([units.of(each.unit)[0] for each in model.parameters])
    return np.eye(count), covariance / np.outer(factor, factor)
