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
from springpot.loading import fitted, stated
from springpot.measurement.covered import Covered
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.units import (
    FREQUENCY_UNITS,
    MODULI,
    Units,
    known_unit,
    one_modulus,
)
from springpot.registry import open_measurement, parse_model, plugins
from springpot.rheology.effect import Layer
from springpot.rheology.model import Model
from springpot.rheology.nodes import Parallel
from springpot.rheology.points import Real, held

from .handoff import Handoff
from .placing import ModelPlace, split
from .prony import BULKS, at_times
from .writer import Writer

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
    more : tuple of Handoff
        Further ones in the same file, at other amplitudes.
    """

    text: str
    writer: Writer
    handoff: Handoff
    data: bytes | None = None
    outside: str = ""
    more: tuple[Handoff, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """As plain data; of several amplitudes the first, with all of them as ``each``."""
        told = self._told(self.handoff) | {"format": self.writer.name}
        if self.more:
            told["each"] = [self._told(handoff) for handoff in (self.handoff, *self.more)]
        return told

    @staticmethod
    def _told(handoff: Handoff) -> dict[str, Any]:
        prony = handoff.prony
        return {
            "model": handoff.model,
            "parameters": handoff.parameters,
            "terms": len(prony.times),
            "error": prony.error,
            "unit": handoff.unit,
            "modulus": handoff.letter or None,
            "measured_rad_per_s": handoff.covered,
            "remarks": list(handoff.remarks),
            "shift": None if handoff.shift is None else handoff.shift.to_dict(),
            "beside": handoff.beside,
            "equilibrium": prony.equilibrium,
            "viscosity": prony.viscosity,
            "weights": prony.weights.tolist(),
            "times": prony.times.tolist(),
        }


def exported(
    source: str,
    format_name: str,
    *,
    band: str | None = None,
    tolerance: str | float | None = None,
    terms: int | None = None,
    dashpot: bool = False,
    values: Sequence[str] = (),
    unit: str | None = None,
    without: Sequence[str] = (),
    temperature: float | None = None,
    amplitudes: Sequence[float] = (),
    times: Real | None = None,
    poisson: float | None = None,
    modulus: str | None = None,
    bulk: str | None = None,
) -> Exported:
    """A model in a solver's format.

    Parameters
    ----------
    source : str
        The JSON file of an identification, or a model expression; with `times` measured data too.
    format_name : str
        Name of a writer.
    band : str, optional
        Such as ``"1Hz:48Hz"``; of data it is where they were measured.
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
        In degrees Celsius; without it the series is that at the reference temperature, and formats
        that have laws of temperature get that too.
    amplitudes : sequence of float
        In the amplitude unit of the data: what is not linear is told by its first harmonic there,
        one material for each.
    times : ndarray, optional
        Relaxation times in s that are given.
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
    wanted = _wanted(writer, tolerance, terms, dashpot, times)
    if times is not None and not source.endswith(".json") and not _is_model(source):
        told = _of_data(source, times, dashpot, modulus)
        return _finished(writer, [replace(told, poisson=poisson, bulk=_bulk(bulk))], "")
    if band is None and _is_file(source) and not source.endswith(".json"):
        raise ModelError(f"{source}: of data give the relaxation --times, such as 1e-3:1e2")
    if band is None:
        raise ModelError(f"{source}: give the --band on which a series follows this model")
    known = _known(source, values, unit).without(without)
    whole = known
    sliding: dict[str, dict[str, float]] = {}
    if not amplitudes and writer.beside:
        known, sliding = split(whole, writer)
    # Once those that the user leaves out are gone.
    _refuse_rig(known.model, bool(amplitudes))
    letter, bulk = _letter(known.model.name, known.units, modulus), _bulk(bulk)
    places = _places(known, whole, _band(band), temperature, amplitudes)
    # Numbers given for a model expression have a unit only if the user says which.
    shown_unit = ""
    if _is_file(source) or unit is not None:
        shown_unit = known.units.stiffness
    solid: dict[str, Any] = {"poisson": poisson, "letter": letter, "bulk": bulk, "beside": sliding}
    handoffs = [
        replace(each.handoff(wanted, shown_unit), number=number, **solid)
        for number, each in enumerate(places, 1)
    ]
    outside = "; ".join(dict.fromkeys(filter(None, (each.outside for each in places))))
    return _finished(writer, handoffs, outside)


def _finished(writer: Writer, handoffs: list[Handoff], outside: str) -> Exported:
    # An FMU is no text: its bytes are made beside the text that says what is in it.
    data, text = None, writer.together(handoffs)
    if writer.data is not None:
        data = writer.data(handoffs[0])
    return Exported(text, writer, handoffs[0], data, outside, tuple(handoffs[1:]))


def _of_data(source: str, times: Real, dashpot: bool, modulus: str | None) -> Handoff:
    """The series of given times straight from measured points."""
    data = open_measurement(source)
    told = series_of(data, times, dashpot)
    return replace(told, letter=_letter(data.name, data.units, modulus))


def _wanted(
    writer: Writer,
    tolerance: str | float | None,
    terms: int | None,
    dashpot: bool,
    times: Real | None,
) -> dict[str, Any]:
    """What is asked of the series, as `prony_of` takes it."""
    if terms is not None and tolerance is not None:
        raise ModelError("give a tolerance or a number of terms, not both")
    if times is not None and (terms, tolerance) != (None, None):
        raise ModelError(
            "times that are given are as many terms: leave out --terms and --tolerance"
        )
    if dashpot and not writer.dashpot:
        raise ModelError(
            f"{writer.name} has no place for a dashpot beside the terms: leave out --dashpot"
        )
    share = _share(tolerance)
    return {"tolerance": share, "terms": terms, "dashpot": dashpot, "times": times}


def _places(
    known: Known,
    whole: Known,
    band: tuple[float, float],
    celsius: float | None,
    amplitudes: Sequence[float],
) -> list[ModelPlace]:
    """The model at each amplitude, where such are asked for, and at the temperature."""
    for name, asked in (("temperature", celsius), ("amplitude", tuple(amplitudes) or None)):
        if asked is not None:
            require_known(known.model, known.covered, name, np.atleast_1d(asked))
    place = ModelPlace(known, whole, band, celsius)
    return [replace(place, amplitude=each) for each in amplitudes] or [place]


def _letter(name: str, units: Units, modulus: str | None) -> str:
    """The letter of the modulus, from the data or as the user says; of both, they must agree."""
    if modulus is None:
        return units.modulus
    if modulus not in MODULI:
        raise ModelError(f"a modulus is {', '.join(MODULI)}, not '{modulus:.20}'")
    if not units.is_modulus:
        raise ModelError(f"{name} is a stiffness in {units.stiffness}: leave out --modulus")
    told = replace(units, letter=MODULI[modulus])
    return one_modulus([(name, units), (f"--modulus {modulus}", told)])


def _bulk(bulk: str | None) -> str | None:
    if bulk is not None and bulk not in BULKS:
        raise ModelError(f"the bulk modulus is {' or '.join(BULKS)}, not '{bulk:.20}'")
    return bulk


def _is_file(source: str) -> bool:
    """Whether a source is the file of a fit: what its name says, or what is there and no model."""
    if source.endswith(".json"):
        return True
    return exists(source) and not _is_model(source)


def _is_model(source: str) -> bool:
    try:
        parse_model(source)
    except SpringpotError:
        return False
    return True


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


def _refuse_rig(model: Model, linearised: bool) -> None:
    for effect in model.effects:
        # What slides beside the material is part of a damper, told at an amplitude.
        if "amplitude" in effect.needs and effect.composition.kind is Parallel:
            if linearised:
                continue
            raise ModelError(
                f"'{effect.name}' depends on the amplitude: give --amplitude, at which it is"
                f" linearised, or leave it out with --without {effect.name}"
            )
        # What belongs to the rig would act on the structure, which has no such rig.
        if effect.layer > Layer.SPECIMEN:
            raise ModelError(
                f"'{effect.name}' belongs to the rig, not to the specimen: leave it out with"
                f" --without {effect.name}"
            )


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


def series_of(data: Measurement, times: Real, dashpot: bool = False) -> Handoff:
    """The series of given times that misses measured points least, each relative to its own size.

    Parameters
    ----------
    data : Measurement
        At one temperature and one amplitude, or such as do not matter.
    times : ndarray, shape (m,)
        In s; weights are none below zero, so that there is one best series and no start.
    dashpot : bool
        Whether a dashpot may stand beside the terms.

    Raises
    ------
    ModelError
        If a condition changes within the data, or there are fewer numbers than terms.
    """
    # What else stands in further columns a user may know to be one.
    for name, column in ((name, data.conditions.get(name)) for name in CONDITIONS):
        if column is not None and np.ptp(column) > np.max(held(name, column)):
            raise ModelError(
                f"{data.name} has more than one {name}, and a series is that of one: choose one,"
                f" {data.name}@{name}=VALUE, or fit a model with an effect of it"
            )
    if 2 * len(data) < len(times) + 1:
        raise ModelError(f"{len(data)} points do not tell {len(times)} weights: give fewer times")
    covered = Covered.of([data])
    series = at_times(np.log(data.omega), data.stiffness, times, dashpot, covered.rate)
    unit = data.units.stiffness
    return Handoff(
        series,
        f"Prony series of {data.name}",
        {"terms": f"{len(times)}"},
        unit,
        data.units.is_modulus,
        covered=covered.rate,
        remarks=(f"measured: {covered.told(data.units)}; times as given",),
        letter=data.units.modulus,
    )
