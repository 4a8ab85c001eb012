"""From a fit, or a model with its parameters, to the text that a solver reads.

What an identified model hands to a solver, and the formats that plugins write it in.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os.path import exists
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError, SpringpotError
from springpot.identification.prediction import Known, require_known
from springpot.identified import fitted, stated
from springpot.measurement.covered import RATE
from springpot.measurement.units import (
    FREQUENCY_UNITS,
    MODULI,
    known_unit,
    one_modulus,
)
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Layer
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Points, Real

from .handoff import Handoff, Writer
from .prony import BULKS, Prony, prony_of

_EDGE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s.].*?)\s*")
"""A frequency and its unit."""


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
    outside : str
        What of it lies outside of what was measured, in one line; empty where nothing does.
    """

    text: str
    writer: Writer
    handoff: Handoff
    data: bytes | None = None
    outside: str = ""

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        prony = self.handoff.prony
        return {
            "model": self.handoff.model,
            "format": self.writer.name,
            "terms": len(prony.times),
            "error": prony.error,
            "unit": self.handoff.unit,
            "modulus": self.handoff.letter or None,
            "measured_rad_per_s": self.handoff.covered,
            "remarks": list(self.handoff.remarks),
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
    modulus: str | None = None,
    bulk: str | None = None,
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
    modulus : {"shear", "young", "bulk"}, optional
        Which modulus the parameters are of, where the data do not say.
    bulk : {"constant", "relaxing"}, optional
        What the bulk modulus of a solid does; see `springpot.rheology.solid_of`.

    Raises
    ------
    SpringpotError
        If something of it is unknown, missing or does not go together, in one line.
    """
    # What is asked for wrongly is told before a spectrum is worked out.
    writer: Writer = plugins().find("writer", format_name)
    if terms is not None and tolerance is not None:
        raise ModelError("give a tolerance or a number of terms, not both")
    if dashpot and not writer.dashpot:
        raise ModelError(
            f"{writer.name} has no place for a dashpot beside the terms: leave out --dashpot"
        )
    known = _known(source, values, unit).without(without)
    # Once those that the user leaves out are gone.
    _refuse_rig(known.model)
    letter, bulk = _letter(known, modulus), _bulk(bulk)
    kelvin = None
    if temperature is not None:
        kelvin = temperature + KELVIN
        require_known(known.model, known.covered, "temperature", np.array([temperature]))
    edges = _band(band)
    spectrum = known.model.spectrum(
        known.theta, edges, temperature=kelvin, reference_temperature=known.reference
    )
    prony = prony_of(spectrum, tolerance=_share(tolerance), terms=terms, dashpot=dashpot)
    # Numbers given for a model expression have a unit only if the user says which.
    shown_unit = ""
    if _is_file(source) or unit is not None:
        shown_unit = known.units.stiffness
    outside = _outside(known, edges, temperature)
    handoff = _handoff(known, prony, shown_unit, kelvin, outside)
    handoff = replace(handoff, poisson=poisson, letter=letter, bulk=bulk)
    # An FMU is no text: its bytes are made beside the text that says what is in it.
    data = None
    if writer.data is not None:
        data = writer.data(handoff)
    return Exported(writer.written(handoff), writer, handoff, data, outside)


def _letter(known: Known, modulus: str | None) -> str:
    """The letter of the modulus, from the data or as the user says; of both, they must agree."""
    if modulus is None:
        return known.units.modulus
    if modulus not in MODULI:
        raise ModelError(f"a modulus is {', '.join(MODULI)}, not '{modulus:.20}'")
    if not known.units.is_modulus:
        raise ModelError(
            f"{known.model.name} is a stiffness in {known.units.stiffness}: leave out --modulus"
        )
    told = replace(known.units, letter=MODULI[modulus])
    return one_modulus([(known.model.name, known.units), (f"--modulus {modulus}", told)])


def _bulk(bulk: str | None) -> str | None:
    if bulk is not None and bulk not in BULKS:
        raise ModelError(f"the bulk modulus is {' or '.join(BULKS)}, not '{bulk:.20}'")
    return bulk


def _measured(known: Known) -> tuple[float, float] | None:
    """Angular frequencies between which a model was measured.

    Nothing of one whose parameters were stated.
    """
    if not np.isfinite(known.covered.rate[1]):
        return None
    return known.covered.rate


def _told(known: Known) -> str:
    if _measured(known) is None:
        return "not measured: parameters as stated"
    return f"measured: {known.covered.told(known.units)}"


def _outside(known: Known, edges: tuple[float, float], celsius: float | None) -> str:
    """What of the band and of the temperature lies outside of what was measured, in one line."""
    asked: dict[str, Real] = {}
    if celsius is not None:
        asked["temperature"] = np.array([celsius])
    beyond = known.covered.beyond(np.array(edges), asked)
    parts = []
    if RATE in beyond:
        low, high = np.clip(known.covered.rate, *edges)
        decades, within = np.log10(edges[1] / edges[0]), np.log10(high / low)
        parts.append(f"{decades - within:.2g} of {decades:.2g} decades of the band")
    if "temperature" in beyond:
        parts.append(f"the temperature of {celsius:.4g} degC")
    if not parts:
        return ""
    spans = " and ".join(known.covered.span(name, known.units) for name in beyond)
    return (
        f"outside of what was measured ({spans}): {' and '.join(parts)}; there it holds only if the"
        " model does"
    )


def _handoff(known: Known, prony: Prony, unit: str, kelvin: float | None, outside: str) -> Handoff:
    """What a writer is given: the series, and the parameters as a user knows them."""
    model, theta, reference = known.model, known.theta, known.reference
    # Where none is asked for, the temperature at which shifts are one.
    at = reference
    if kelvin is not None:
        at = kelvin
    shown = _printed(known, unit)
    if "temperature" in model.needs:
        shown["temperature"] = f"{at - KELVIN:.6g} degC"
    return Handoff(
        prony,
        model.name,
        shown,
        unit,
        bool(unit) and known.units.is_modulus,
        covered=_measured(known),
        remarks=tuple(filter(None, [_told(known), outside])),
        exact=lambda omega: model.stiffness(theta, _points(omega, at, reference)),
    )


def _is_file(source: str) -> bool:
    """Whether a source is a file: what its name says, or what is there and is no model."""
    if source.endswith(".json"):
        return True
    try:
        parse_model(source)
    except SpringpotError:
        return exists(source)
    return False


def _known(source: str, values: Sequence[str], unit: str | None) -> Known:
    """The fit in a JSON file, or a model with its parameters."""
    if _is_file(source):
        known = fitted(source)
        if values or unit is not None:
            raise ModelError(
                f"{source} has parameters and units of its own: leave out"
                f" --{'set' if values else 'unit'}, which is for a model by its name"
            )
        return known
    numbers: dict[str, float] = {}
    for text in values:
        name, _, value = text.partition("=")
        try:
            numbers[name.strip()] = float(value)
        except ValueError:
            raise ModelError(f"'{text}' is no NAME=VALUE, such as k=400") from None
    return stated(source, numbers, unit, "the stiffness")


def _refuse_rig(model: Model) -> None:
    for effect in model.effects:
        # What belongs to the rig would act on the structure, which has no such rig.
        if effect.layer > Layer.SPECIMEN:
            raise ModelError(
                f"'{effect.name}' belongs to the rig, not to the specimen: leave it out with"
                f" --without {effect.name}"
            )


def _printed(known: Known, unit: str) -> dict[str, str]:
    """Parameters with their units, those included that were held.

    The lines of a spectrum are left to the series.
    """
    # Held and tied parameters are none of the model's own: only the released one has them all.
    values = dict(zip(known.model.names, known.theta.tolist(), strict=True)) | known.model.held
    values |= {each.parameter.name: each.value for each in known.model.followers(known.theta)}
    shown = {}
    for parameter in known.model.released().parameters:
        if not parameter.detail:
            # Without a unit numbers are printed as they were given.
            factor, label = 1.0, ""
            if unit:
                factor, label = known.units.of(parameter.unit)
            shown[parameter.name] = f"{factor * values[parameter.name]:.9g} {label}".strip()
    return shown


def _points(omega: Real, kelvin: float, reference: float) -> Points:
    """Points (n,) at one temperature."""
    return Points(np.log(omega), None, np.full(len(omega), kelvin), reference)


def _band(text: str) -> tuple[float, float]:
    """Angular frequencies of a band such as ``1Hz:48Hz``."""
    edges = []
    for part in text.split(":"):
        match = _EDGE.fullmatch(part)
        # 1e999 is written as a number, and read as none that is finite.
        if match is None or not 0.0 < float(match[1]) < np.inf:
            raise DataError(
                f"'{text}' is no band: write two frequencies with their units, such as 1Hz:48Hz"
            )
        edges.append(
            float(match[1]) * FREQUENCY_UNITS[known_unit(match[2], FREQUENCY_UNITS, "the band")]
        )
    if len(edges) != 2 or not edges[0] < edges[1]:
        raise DataError(
            f"'{text}' is no band: write two frequencies, the lower first, such as 1Hz:48Hz"
        )
    return edges[0], edges[1]


def _share(tolerance: str | float | None) -> float | None:
    # None is left to the series, which has a usual tolerance of its own.
    if tolerance is None or isinstance(tolerance, float):
        return tolerance
    number, percent, _ = tolerance.strip().partition("%")
    try:
        share = float(number)
    except ValueError:
        raise ModelError(f"'{tolerance}' is no tolerance: write 0.5% or 0.005") from None
    if percent:
        share /= 100.0
    return share
