"""The formats that plugins write a handed-over model in, and their contract.

`springpot.testing.check_writer` asks for it: a card says what it is, holds all of the series, is
refused in one line where it cannot, and read back by somebody else's reader it is the same
material.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.rheology.points import Complex, Real
from springpot.rheology.spectrum import MOST_TERMS

from ..numerics import NEGLIGIBLE
from .handoff import Handoff
from .prony import Prony

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
