"""From a fit, or a model with its parameters, to the text that a solver reads.

A model at one temperature and amplitude on a band gives the series, and what to say of it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import exists
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError, SpringpotError
from springpot.identification.prediction import Known, require_known
from springpot.loading import fitted, stated
from springpot.measurement.covered import RATE, Covered
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    FREQUENCY_UNITS,
    LENGTH_UNITS,
    MODULI,
    Units,
    known_unit,
    one_modulus,
)
from springpot.registry import open_measurement, parse_model, plugins
from springpot.rheology.effect import Layer
from springpot.rheology.model import Model
from springpot.rheology.nodes import Parallel
from springpot.rheology.points import KELVIN, Complex, Points, Real, held

from .handoff import Handoff, ShiftLaw, Writer, shift_law_of
from .prony import BULKS, Prony, at_times, prony_of, prony_through


@dataclass(frozen=True, eq=False)
class ModelPlace:
    """A model at one temperature and amplitude on a band.

    Parameters
    ----------
    known : Known
        What the series is of.
    whole : Known
        The same with what stands beside the series.
    band : tuple of float
        Angular frequencies in rad/s.
    celsius : float, optional
        In degC; without it the reference temperature, and a law of temperature counts.
    amplitude : float, optional
        In the unit of the fit.
    """

    known: Known
    whole: Known
    band: tuple[float, float]
    celsius: float | None = None
    amplitude: float | None = None

    @property
    def kelvin(self) -> float:
        """Its temperature; where none is asked for that at which shifts are one."""
        if self.celsius is None:
            return self.known.reference
        return self.celsius + KELVIN

    def stiffness(self, omega: Real) -> Complex:
        """K (n,) at omega (n,) in rad/s: of what is not linear its first harmonic."""
        amplitude = None
        if self.amplitude is not None:
            amplitude = np.full(len(omega), self.amplitude)
        kelvin = np.full(len(omega), self.kelvin)
        at = Points(np.log(omega), amplitude, kelvin, self.known.reference)
        return self.known.model.stiffness(self.known.theta, at)

    def series(self, wanted: Mapping[str, Any]) -> Prony:
        """Its Prony series, with the arguments of `prony_of`."""
        if self.amplitude is not None:
            return prony_through(self.stiffness, self.band, **wanted)
        model, theta = self.known.model, self.known.theta
        spectrum = model.spectrum(
            theta, self.band, temperature=self.kelvin, reference_temperature=self.known.reference
        )
        return prony_of(spectrum, **wanted)

    @property
    def shift(self) -> ShiftLaw | None:
        """The law that its times follow, where no temperature was asked for."""
        if self.celsius is not None:
            return None
        return shift_law_of(self.known.model, self.known.theta, self.known.reference)

    def handoff(self, wanted: Mapping[str, Any], unit: str) -> Handoff:
        """What a writer is given: the series, and the parameters as a user knows them."""
        shown = _printed(self.whole, unit)
        if "temperature" in self.whole.model.needs:
            shown["temperature"] = f"{self.kelvin - KELVIN:.6g} degC"
        harmonic = ""
        if self.amplitude is not None:
            shown["amplitude"] = f"{self.amplitude:.6g} {self.known.units.amplitude}"
            harmonic = f"linearised: the first harmonic at an amplitude of {shown['amplitude']}"
        return Handoff(
            self.series(wanted),
            self.whole.model.name,
            shown,
            unit,
            bool(unit) and self.known.units.is_modulus,
            covered=_measured(self.known),
            remarks=tuple(filter(None, [_told(self.known), harmonic, self.outside])),
            exact=self.stiffness,
            shift=self.shift,
        )

    @property
    def outside(self) -> str:
        """What of band, temperature and amplitude was not measured, in one line."""
        known, edges = self.known, self.band
        units = {"temperature": "degC", "amplitude": known.units.amplitude}
        given = {"temperature": self.celsius, "amplitude": self.amplitude}
        asked = {name: np.array([value]) for name, value in given.items() if value is not None}
        beyond = known.covered.beyond(np.array(edges), asked)
        parts = []
        if RATE in beyond:
            low, high = np.clip(known.covered.rate, *edges)
            decades, within = np.log10(edges[1] / edges[0]), np.log10(high / low)
            parts.append(f"{decades - within:.2g} of {decades:.2g} decades of the band")
        parts += [
            f"the {name} of {asked[name][0]:.4g} {unit}"
            for name, unit in units.items()
            if name in beyond
        ]
        if not parts:
            return ""
        spans = " and ".join(known.covered.span(name, known.units) for name in beyond)
        return (
            f"outside of what was measured ({spans}): {' and '.join(parts)}; there it holds only if"
            " the model does"
        )


def split(known: Known, writer: Writer) -> tuple[Known, dict[str, dict[str, float]]]:
    """The linear part, and what stands beside it that the format writes for what it is.

    Forces are in the unit of the stiffness times the length in it.

    Raises
    ------
    ModelError
        If a part that is not linear stands elsewhere, or is one that the format does not have.
    """
    placed = known.model.placed
    own = known.model.names
    sliding: dict[str, dict[str, float]] = {}
    _, _, length = known.units.stiffness.partition("/")
    reach = AMPLITUDE_UNITS[known.units.amplitude] / LENGTH_UNITS.get(length, 1.0)
    for i, (effect, prefix, places) in enumerate(placed):
        if "amplitude" not in effect.needs:
            continue
        # Around it a linear part in series would share its way.
        outer = [other.effect.composition.kind for other in placed[i:]]
        if any(kind is not Parallel for kind in outer) or effect.name not in writer.beside:
            raise ModelError(
                f"{writer.name} has no '{effect.name}' beside a series ({', '.join(writer.beside)}"
                " it has): give --amplitude, at which it is linearised, or leave it out"
            )
        dimensions = [known.model.parameters[place].unit for place in places]
        names = [own[place].removeprefix(f"{prefix}.") for place in places]
        values = [
            float(known.theta[place]) * reach**dimension.amplitude
            for place, dimension in zip(places, dimensions, strict=True)
        ]
        sliding[effect.name] = dict(zip(names, values, strict=True))
    return known.without(sliding), sliding


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


def _printed(known: Known, unit: str) -> dict[str, str]:
    """Parameters with their units, those included that were held.

    The lines of a spectrum are left to the series.
    """
    # Held and tied parameters are none of the model's own: only the released one has them all.
    values = known.model.named(known.theta) | known.model.held
    if own := known.model.own:
        column = next(iter(own.values()))
        raise ModelError(
            f"each {column} has {', '.join(own)} of its own: a card is of one material; identify"
            f" one alone, such as {column}=1, or share all parameters"
        )
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
