"""The contract of a writer: a format for solvers."""

from __future__ import annotations

from collections.abc import Callable, Collection

from springpot.hooks import SolverFormat
from springpot.rheology.points import Complex, Real

from .networks import complaints, name_and_summary


def check_writer(
    writer: SolverFormat,
    read: Callable[[str, Real], Complex] | None = None,
    *,
    skip: Collection[str] = (),
) -> list[str]:
    """What is wrong with a writer, as plain sentences.

    Aspects: ``words``, ``text`` (the same twice, with every line of the heading), ``holds`` (weight
    and time of every term, the long-term stiffness, a dashpot and Poisson's ratio where the format
    has them), ``refuses`` (what does not fit, in one line), ``several`` (none of two materials is
    lost) and ``read-back`` (K of the card is that of the series), for which a reader is needed.

    Parameters
    ----------
    writer : Writer
        The writer.
    read : callable, optional
        From the text of a card and angular frequencies (n,) in rad/s to K (n,), of the modulus that
        was handed over: Young's, or that which the format takes. Not by the writer's own constants.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(writer.name, writer.summary, writer.aliases),
        **writer.aspects(read),
    }
    return complaints(aspects, skip)
