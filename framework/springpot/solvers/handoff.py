"""What an identified model hands to a solver, and the formats that plugins write it in.

Handed over are its series, and the law that shifts its times. `springpot.testing.check_writer` asks
for the contract of a format: a card says what it is, holds all of the series, is refused in one
line where it cannot, and read back by somebody else's reader it is the same material.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.measurement.units import MODULUS_WORDS
from springpot.rheology.model import Model
from springpot.rheology.nodes import VALUE, Shift
from springpot.rheology.points import GAS_CONSTANT, KELVIN, Complex, Points, Real
from springpot.rheology.spectrum import MOST_TERMS

from ..numerics import ALIKE, DECADE, NEGLIGIBLE
from .prony import Prony, Solid, solid_of, young_of

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Handoff:
    """A model as a Prony series, with all that its first lines must say.

    Attributes
    ----------
    prony : Prony
        The series, in the unit of `unit`.
    model : str
        Its expression.
    parameters : dict of str to str
        Each with its value and unit, as printed.
    unit : str
        Of the stiffness or modulus, such as ``kN/m`` or ``MPa``; empty if nobody said.
    is_modulus : bool
        Whether stress over strain is meant, rather than force over displacement.
    poisson : float, optional
        Poisson's ratio, for formats that describe a solid.
    name : str
        What the material or damper shall be called.
    exact : callable, optional
        From angular frequencies in rad/s to the model's own complex K, for formats that hold K
        itself.
    letter : {"", "G", "E", "K"}
        Which modulus it is: shear, Young's or bulk; empty for a stiffness, or if nobody said.
    bulk : {"constant", "relaxing"}, optional
        What the bulk modulus of a solid does; see `solid_of`.
    covered : tuple of float, optional
        Angular frequencies in rad/s between which the model was measured, where it was.
    remarks : tuple of str
        What was measured and what lies outside, in lines for the heading.
    shift : ShiftLaw, optional
        By which the times of the series follow the temperature.
    beside : dict of str to dict
        What is not linear and stands beside the series, where the format asks for it: by the name
        of its effect its parameters, in `unit` and the length that belongs to it.
    number : int
        Of the material among several in one file, from one.
    """

    prony: Prony
    model: str
    parameters: dict[str, str]
    unit: str
    is_modulus: bool
    poisson: float | None = None
    name: str = "springpot"
    exact: Callable[[Real], Complex] | None = None
    letter: str = ""
    bulk: str | None = None
    covered: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()
    shift: ShiftLaw | None = None
    beside: dict[str, dict[str, float]] = field(default_factory=dict)
    number: int = 1

    @cached_property
    def solid(self) -> Solid:
        """The shear and bulk modulus, for formats that describe a solid.

        Raises
        ------
        ModelError
            If it is not known which modulus this is, or Poisson's ratio is not.
        """
        if not self.letter:
            raise ModelError(
                f"{self.model} in {self.unit} is a shear, Young's or bulk modulus, which the data"
                " do not say: give --modulus shear, young or bulk"
            )
        # At 0.5 the bulk modulus is without end, and below -1 the shear modulus is negative.
        if self.poisson is None or not -1.0 < self.poisson < 0.5:
            raise ModelError(
                "a solid needs Poisson's ratio, above -1 and below 0.5: give --poisson 0.49"
            )
        return solid_of(self.prony, self.letter, self.poisson, self.bulk)

    def as_modulus(self, letter: str) -> Handoff:
        """The same as the series of a shear (``G``) or Young's modulus (``E``).

        A stiffness as it is.

        Raises
        ------
        ModelError
            As of `solid`.
        """
        if not self.is_modulus or self.letter == letter:
            return self
        if self.beside:
            raise ModelError(
                f"'{next(iter(self.beside))}' of {self.model} is told in another modulus than that"
                " which the format takes: no law of elasticity turns a slider's stress into it"
            )
        series = self.solid.shear
        if letter == "E":
            series = young_of(self.solid)
        remarks = (*self.remarks, self.solid.says)
        # The model itself is of the measured modulus: what reads it would take it for the other.
        return replace(self, prony=series, letter=letter, exact=None, remarks=remarks)

    @cached_property
    def outside(self) -> NDArray[np.bool_]:
        """Whether each term (m,) has its rate outside of what was measured."""
        rates = 1.0 / self.prony.times
        low, high = self.covered or (0.0, np.inf)
        return np.asarray((rates < low) | (rates > high))

    def stiffness(self, omega: Real) -> Complex:
        """K (n,) at omega (n,) in rad/s.

        That of the model itself where it is known, else that of the series.
        """
        if self.exact is None:
            return self.prony.stiffness(omega)
        return self.exact(omega)

    def heading(self) -> list[str]:
        """What it is, in lines of plain text.

        Model, parameters, band, error, unit, long-term and instantaneous.
        """
        prony = self.prony
        low, high = (omega / (2.0 * np.pi) for omega in prony.band)
        # A solver has no units: what the numbers are in must be read from the file's first lines.
        unit = self.unit or "unit of the parameters"
        what = "stiffness"
        if self.is_modulus:
            what = MODULUS_WORDS[self.letter]
        values = ", ".join(f"{name} = {value}" for name, value in self.parameters.items())
        dashpot = ""
        if prony.viscosity:
            dashpot = f", beside a dashpot of {prony.viscosity:.9g} [{unit} s]"
        return [
            f"springpot: {self.model}: {values}",
            (
                f"Prony series of {len(prony.times)} terms for {low:.6g} to {high:.6g} Hz, "
                f"within {100 * prony.error:.3g} % of |K| of the model"
            ),
            (
                f"{what} in {unit}, times in s; long-term {prony.equilibrium:.9g}, instantaneous"
                f" {prony.instantaneous:.9g}{dashpot}"
            ),
            *self.remarks,
            *([] if self.shift is None else [self.shift.says]),
        ]


ABOUT = np.array([-8.0, -5.0, 4.0, 9.0, 15.0])
"""Kelvin from the reference at which a law is recognised by its shape."""


@dataclass(frozen=True)
class ShiftLaw:
    """All times follow one factor a_T, which is one at the reference.

    Attributes
    ----------
    reference : float
        In degC.
    kind : {"wlf", "arrhenius"}
        log10 a_T = -C1 (T - Tr) / (C2 + T - Tr), or ln a_T = (E / R) (1/T - 1/Tr).
    constants : tuple of float
        C1 and C2 in kelvin, or E in J/mol.
    """

    reference: float
    kind: str
    constants: tuple[float, ...]

    def log_factor(self, celsius: Real) -> Real:
        """Ln a_T at these temperatures (n,) in degC."""
        above = np.asarray(celsius, dtype=float) - self.reference
        if self.kind == "wlf":
            c1, c2 = self.constants
            return np.asarray(-DECADE * c1 * above / (c2 + above))
        energy = self.constants[0] / (1e3 * GAS_CONSTANT)
        inverse = 1.0 / (self.reference + above + KELVIN) - 1.0 / (self.reference + KELVIN)
        return np.asarray(energy * inverse)

    @property
    def says(self) -> str:
        """The law in one line."""
        at = f"Tr = {self.reference:.6g} degC"
        if self.kind == "wlf":
            c1, c2 = self.constants
            return (
                f"times follow log10 a_T = -C1 (T - Tr) / (C2 + T - Tr), C1 = {c1:.9g}, C2 ="
                f" {c2:.9g} K, {at}"
            )
        return f"times follow ln a_T = E/R (1/T - 1/Tr), E = {self.constants[0]:.9g} J/mol, {at}"

    def to_dict(self) -> dict[str, object]:
        """As plain data."""
        return {
            "law": self.kind,
            "reference_degC": self.reference,
            "constants": list(self.constants),
        }


def shift_law_of(model: Model, theta: Real, reference: float) -> ShiftLaw | None:
    """The law of a model with its parameters (p,), reference in kelvin.

    Told by its shape, whatever effect or formula it is from. None where temperature does more than
    to shift times, or by another law.
    """
    warm = [placed for placed in model.placed if "temperature" in placed.effect.needs]
    if not warm or any(placed.effect.composition.kind is not Shift for placed in warm):
        return None
    kelvin = reference + ABOUT
    at = Points(np.zeros(len(kelvin)), None, kelvin, reference)
    factor = sum(
        (placed.effect.element.respond(theta[placed.own], at, VALUE).value.real for placed in warm),
        np.zeros(len(kelvin)),
    )
    # A law that does nothing has no constants.
    if not np.all(factor != 0.0):
        return None
    energies = 1e3 * GAS_CONSTANT * factor / (1.0 / kelvin - 1.0 / reference)
    if np.ptp(energies) <= ALIKE * np.abs(energies).max():
        return ShiftLaw(reference - KELVIN, "arrhenius", (float(energies.mean()),))
    # (T - Tr) / ln a is a straight line of T - Tr.
    slope, start = np.polyfit(ABOUT, ABOUT / factor, 1)
    if np.ptp(ABOUT / factor - start - slope * ABOUT) <= ALIKE * np.abs(ABOUT / factor).max():
        c1, c2 = -1.0 / (DECADE * slope), start / slope
        return ShiftLaw(reference - KELVIN, "wlf", (float(c1), float(c2)))
    return None


Reading: TypeAlias = Callable[[str, Real], Complex]
"""From a card and angular frequencies (n,) in rad/s to K (n,), as the solver would have it."""
SERIES = Prony(
    12.5,
    0.0,
    np.array([31.25, 4.125, 127.0]),
    np.array([1.2345678e-3, 0.25, 7.0]),
    (1.0, 300.0),
    0.0043,
)
WITHIN = 1e-3
"""Of K read back: what straight lines of a table or the fields of a fixed card leave."""


def sample_for(writer: Writer, prony: Prony = SERIES, **changes: Any) -> Handoff:
    """What a format can hold: a stiffness for dampers, else the modulus that it takes."""
    own: dict[str, Any] = {"unit": "MPa", "is_modulus": True, "letter": writer.modulus or "E"}
    if writer.damper:
        own = {"unit": "kN/m", "is_modulus": False}
    whole = {"poisson": 0.49, "bulk": "relaxing", "remarks": ("measured: 1 to 48 Hz",)}
    parameters = {"k": "3 MPa"}
    given: dict[str, Any] = {"model": "zener", "parameters": parameters} | own | whole | changes
    return Handoff(prony, **given)


def _text(writer: Writer) -> Iterator[str]:
    if not writer.suffix.startswith("."):
        yield f"the suffix is '{writer.suffix}', not the end of a file's name such as '.inp'"
    handoff = sample_for(writer)
    text = writer.written(handoff)
    if text != writer.written(handoff):
        yield "two cards of one material differ"
    if not text.endswith("\n"):
        yield "the text does not end its last line"
    for line in handoff.heading():
        if line not in text:
            yield f"a user is not told '{line[:60]}': write every line of heading() as a comment"


def _holds(writer: Writer) -> Iterator[str]:
    first = np.array([1.5, 1.0, 1.0])
    changes: dict[str, Handoff] = {
        "the weight of a term": sample_for(writer, replace(SERIES, weights=first * SERIES.weights)),
        "the time of a term": sample_for(writer, replace(SERIES, times=first * SERIES.times)),
        "the long-term stiffness": sample_for(writer, replace(SERIES, equilibrium=13.5)),
        "a term more": sample_for(
            writer,
            replace(
                SERIES, weights=np.append(SERIES.weights, 9.0), times=np.append(SERIES.times, 50.0)
            ),
        ),
    }
    if writer.dashpot:
        changes["a dashpot"] = sample_for(writer, replace(SERIES, viscosity=2.5))
    if writer.solid:
        changes["Poisson's ratio"] = sample_for(writer, poisson=0.2)
    plain = _below(writer, sample_for(writer))
    for what, handoff in changes.items():
        if _below(writer, handoff) == plain:
            yield f"{what} changes nothing in the card"


def _below(writer: Writer, handoff: Handoff) -> list[str]:
    """Lines of a card without those of its heading, which tells of all in any case."""
    told = handoff.heading()
    if writer.solid:
        told.append(handoff.solid.says)
    lines = writer.written(handoff).splitlines()
    return [line for line in lines if not any(words in line for words in told)]


def _refuses(writer: Writer) -> Iterator[str]:
    times = np.geomspace(1e-4, 1e2, MOST_TERMS)
    cases = {
        f"{MOST_TERMS} terms": replace(SERIES, weights=np.ones(MOST_TERMS), times=times),
        "a spring alone": replace(SERIES, weights=np.zeros(0), times=np.zeros(0)),
    }
    for what, prony in cases.items():
        # Any other error is told by who runs the contract.
        try:
            writer.written(sample_for(writer, prony))
        except SpringpotError as error:
            if "\n" in str(error) or not str(error):
                yield f"{what}: refuse it in one line that says why"


def _several(writer: Writer) -> Iterator[str]:
    if writer.several is None:
        return
    one, other = sample_for(writer), sample_for(writer, model="kelvin", number=2)
    text = writer.together([one, other])
    for handoff in (one, other):
        if handoff.heading()[0] not in text:
            yield f"of two materials in one file that of {handoff.model} is lost"


def _read_back(writer: Writer, read: Reading) -> Iterator[str]:
    omega = np.geomspace(*SERIES.band, 40)
    cases = {"a series": SERIES}
    if writer.dashpot:
        cases["a series beside a dashpot"] = replace(SERIES, viscosity=0.25)
    for what, prony in cases.items():
        found = np.asarray(read(writer.written(sample_for(writer, prony)), omega))
        off = np.abs(found / prony.stiffness(omega) - 1.0)
        if not np.all(off <= WITHIN):
            worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
            yield (
                f"{what}: K read back is {100 * off[worst]:.3g} % off at {omega[worst]:.3g} rad/s"
            )


@dataclass(frozen=True)
class Writer:
    """A format for solvers.

    Parameters
    ----------
    name : str
        What users type behind ``--to``.
    text : callable
        From a `Handoff` to the file's text.
    summary : str
        Who reads it, in one line.
    suffix : str
        Of the file, such as ``".inp"``.
    solid : bool
        Whether the format describes a solid material: it then needs a modulus of which it is known
        whether it is shear's, Young's or bulk, a long-term one above zero, and Poisson's ratio.
    dashpot : bool
        Whether it has room for a dashpot beside the terms.
    aliases : tuple of str
        Other names.
    damper : bool
        Whether the format describes a damper: it then needs a stiffness.
    modulus : {"", "G", "E"}
        Which modulus the series is of where the format takes that of a material but describes no
        whole solid; empty where it takes any and says which.
    data : callable, optional
        From a `Handoff` to the bytes of a file that is no text; `text` then says what is in it.
    several : callable, optional
        From the texts of several materials, such as one at several amplitudes, to that of a file
        with all of them.
    beside : tuple of str
        Effects that are not linear and that it writes beside the series.
    """

    name: str
    text: Callable[[Handoff], str]
    summary: str
    suffix: str
    solid: bool = False
    dashpot: bool = True
    aliases: tuple[str, ...] = ()
    damper: bool = False
    modulus: str = ""
    data: Callable[[Handoff], bytes] | None = None
    several: Callable[[list[str]], str] | None = None
    beside: tuple[str, ...] = ()

    def together(self, handoffs: Sequence[Handoff]) -> str:
        """The text of one or of several materials; see `written`."""
        texts = [self.written(handoff) for handoff in handoffs]
        if len(texts) == 1:
            return texts[0]
        if self.several is None:
            raise ModelError(f"{self.name} holds one material: give one amplitude")
        return self.several(texts)

    def aspects(self, read: Reading | None = None) -> Mapping[str, Callable[[], Iterable[str]]]:
        """Its contract, by the name of each aspect; see `springpot.testing.check_writer`."""
        aspects = {
            "text": lambda: _text(self),
            "holds": lambda: _holds(self),
            "refuses": lambda: _refuses(self),
            "several": lambda: _several(self),
        }
        if read is not None:
            aspects["read-back"] = lambda: _read_back(self, read)
        return aspects

    def written(self, handoff: Handoff) -> str:
        """The text, where the format can hold what is handed over.

        Raises
        ------
        ModelError
            If it cannot, with the reason and how to mend it.
        """
        prony = handoff.prony
        if self.solid and not handoff.is_modulus:
            given = "a stiffness"
            if handoff.unit:
                given += f" in {handoff.unit}"
            raise ModelError(
                f"{self.name} needs a modulus, and {handoff.model} is {given}: identify it with the"
                " --geometry"
            )
        if self.solid and not prony.equilibrium >= NEGLIGIBLE * prony.instantaneous:
            raise ModelError(
                f"{self.name} needs a solid, and {handoff.model} is a liquid on this band"
                f" (long-term modulus {prony.equilibrium:.3g}): add a spring beside it or begin the"
                " band lower"
            )
        if self.solid:
            _ = handoff.solid
        if not self.dashpot and prony.viscosity > 0.0:
            raise ModelError(f"{self.name} has no dashpot beside its terms: leave out --dashpot")
        if self.damper and handoff.is_modulus:
            raise ModelError(
                f"{self.name} needs a stiffness, and {handoff.model} is a modulus in"
                f" {handoff.unit}: identify it with the --geometry of the damper"
            )
        if self.modulus:
            handoff = handoff.as_modulus(self.modulus)
        return self.text(handoff)
