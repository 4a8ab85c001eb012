"""A model at one temperature and amplitude on a band: its series, and what to say of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.errors import ModelError
from springpot.identification.prediction import Known
from springpot.measurement.covered import RATE
from springpot.measurement.units import AMPLITUDE_UNITS, LENGTH_UNITS
from springpot.rheology.nodes import Parallel
from springpot.rheology.points import KELVIN, Complex, Points, Real

from .handoff import Handoff, ShiftLaw, shift_law_of
from .prony import Prony, prony_of, prony_through
from .writer import Writer


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
