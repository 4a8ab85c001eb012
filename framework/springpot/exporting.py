"""From a fit, or a model with its parameters, to the text that a solver reads."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError
from springpot.measurement import Units
from springpot.measurement.units import FREQUENCY_UNITS, MODULUS_UNITS, known_unit
from springpot.registry import parse_model, plugins
from springpot.rheology import Handoff, Layer, Model, Prony, Real, Writer, prony_of

ZERO_CELSIUS = 273.15
_EDGE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s.].*?)\s*")
"""A frequency and its unit."""
LARGEST = 10_000_000
"""Bytes of a fit's JSON: it has some thousand."""


@dataclass(frozen=True, eq=False)
class Exported:
    """The text for a solver, and the series in it.

    Attributes
    ----------
    text : str
        As the file will be.
    writer : Writer
        Its format.
    handoff : Handoff
        What was written.
    data : bytes, optional
        The file, where the format is no text.
    """

    text: str
    writer: Writer
    handoff: Handoff
    data: bytes | None = None

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        prony = self.handoff.prony
        return {
            "model": self.handoff.model,
            "format": self.writer.name,
            "terms": len(prony.times),
            "error": prony.error,
            "unit": self.handoff.unit,
            "equilibrium": prony.equilibrium,
            "viscosity": prony.viscosity,
            "weights": prony.weights.tolist(),
            "times": prony.times.tolist(),
        }


def exported(
    source: str,
    format_name: str,
    *,
    band: str,
    tolerance: str | float | None = None,
    terms: int | None = None,
    dashpot: bool = False,
    values: Sequence[str] = (),
    unit: str | None = None,
    without: Sequence[str] = (),
    temperature: float | None = None,
    poisson: float | None = None,
) -> Exported:
    """A model in a solver's format.

    Parameters
    ----------
    source : str
        The JSON file of an identification, or a model expression.
    format_name : str
        Name of a writer.
    band : str
        Such as ``"1Hz:48Hz"``.
    tolerance : str or float, optional
        Largest |dK| / |K|, such as ``"0.5%"`` or 0.005.
    terms : int, optional
        Number of terms instead.
    dashpot : bool
        Whether a dashpot may stand beside the terms.
    values : sequence of str
        ``"name=value"`` for each parameter of a model expression.
    unit : str, optional
        Of the stiffness of a model expression.
    without : sequence of str
        Effects to leave out.
    temperature : float, optional
        In degrees Celsius.
    poisson : float, optional
        Poisson's ratio.

    Raises
    ------
    SpringpotError
        If something of it is unknown, missing or does not go together, in one line.
    """
    writer: Writer = plugins().find("writer", format_name)
    if terms is not None and tolerance is not None:
        raise ModelError("give a tolerance or a number of terms, not both")
    model, printed, units = _read_fit(Path(source)) if source.endswith(".json") else _given(source, values, unit)
    theta = _own_units(model, {name: value for name, (value, _) in printed.items()}, units)
    model, theta = _of_specimen(model, theta, without)
    omega = _band(band)
    kelvin = None if temperature is None else temperature + ZERO_CELSIUS
    spectrum = model.spectrum(theta, omega, temperature=kelvin)
    prony: Prony = prony_of(spectrum, tolerance=_share(tolerance), terms=terms, dashpot=dashpot and writer.dashpot)
    shown = {name: f"{printed[name][0]:.9g} {printed[name][1]}".strip() for name in model.names}
    stated = "" if units is None else units.stiffness
    handoff = Handoff(prony, model.name, shown, stated, units is not None and units.is_modulus, poisson)
    text = writer.written(handoff)
    return Exported(text, writer, handoff, None if writer.data is None else writer.data(handoff))


Printed = dict[str, tuple[float, str]]


def _read_fit(path: Path) -> tuple[Model, Printed, Units | None]:
    try:
        if path.stat().st_size > LARGEST:
            raise DataError(f"{path} is too large for the JSON of a fit")
        fit = json.loads(path.read_text(encoding="utf-8"))
        model = parse_model(str(fit["model"]))
        printed = {name: (float(e["value"]), str(e["unit"])) for name, e in fit["parameters"].items()}
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DataError(f"{path} is no fit: give the output of 'springpot identify ... --json'") from None
    for parameter in model.parameters:
        if parameter.unit.stiffness == 1 and not parameter.unit.amplitude and parameter.unit.time != 2:
            label = printed.get(parameter.name, (0.0, ""))[1]
            stiffness = re.sub(r" s(\^[^/\s]+)?(?=/|$)", "", label)
            if stiffness in MODULUS_UNITS:
                return model, printed, Units(stiffness)
    return model, printed, None


def _given(expression: str, values: Sequence[str], unit: str | None) -> tuple[Model, Printed, Units | None]:
    model = parse_model(expression)
    units = None if unit is None else Units(known_unit(unit, MODULUS_UNITS, "the stiffness"))
    numbers: dict[str, float] = {}
    for text in values:
        name, _, value = text.partition("=")
        try:
            numbers[name.strip()] = float(value)
        except ValueError:
            raise ModelError(f"'{text}' is no NAME=VALUE, such as k=400") from None
    theta = model.vector(numbers)
    labels = [units.of(p.unit)[1] if units else "" for p in model.parameters]
    return model, {n: (v, label) for n, v, label in zip(model.names, theta.tolist(), labels, strict=True)}, units


def _own_units(model: Model, values: dict[str, float], units: Units | None) -> Real:
    """Parameters in the units of the data, from those in which they are printed (a mass in kg)."""
    theta = model.vector(values)
    if not np.all(np.isfinite(theta)):
        raise ModelError(f"a parameter of {model.name} is no finite number")
    if units is None:
        return theta
    factors = [units.of(p.unit, 1.0 if isinstance(p.unit.time, str) else None)[0] for p in model.parameters]
    own: Real = theta / np.array(factors)
    return own


def _of_specimen(model: Model, theta: Real, without: Sequence[str]) -> tuple[Model, Real]:
    known = dict(zip(model.names, theta.tolist(), strict=True))
    for name in without:
        model = model - plugins().effect(name)
    for effect in model.effects:
        if effect.layer > Layer.SPECIMEN:
            raise ModelError(
                f"'{effect.name}' belongs to the rig, not to the specimen: leave it out with --without {effect.name}"
            )
    return model, model.vector({name: known[name] for name in model.names})


def _band(text: str) -> tuple[float, float]:
    """Angular frequencies of a band such as ``1Hz:48Hz``."""
    edges = []
    for part in text.split(":"):
        match = _EDGE.fullmatch(part)
        number = float(match[1]) if match else np.nan
        if match is None or not 0.0 < number < np.inf:
            raise DataError(f"'{text}' is no band: write two frequencies with their units, such as 1Hz:48Hz")
        edges.append(number * FREQUENCY_UNITS[known_unit(match[2], FREQUENCY_UNITS, "the band")])
    if len(edges) != 2 or not edges[0] < edges[1]:
        raise DataError(f"'{text}' is no band: write two frequencies, the lower first, such as 1Hz:48Hz")
    return edges[0], edges[1]


def _share(tolerance: str | float | None) -> float | None:
    if tolerance is None or isinstance(tolerance, float):
        return tolerance
    number, percent, _ = tolerance.strip().partition("%")
    try:
        return float(number) / (100.0 if percent else 1.0)
    except ValueError:
        raise ModelError(f"'{tolerance}' is no tolerance: write 0.5% or 0.005") from None
