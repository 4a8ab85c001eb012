"""The formats that plugins write a handed-over model in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from springpot.errors import ModelError

from ..numerics import NEGLIGIBLE
from .contract import Reading, aspects_of
from .handoff import Handoff


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
        return aspects_of(self, read)

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
