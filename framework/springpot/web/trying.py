"""What a state of the page would be, before it is asked for: one fit, drawn like a preview.

A law that is typed, another model, points left out; and laws that are found.
"""

from __future__ import annotations

from typing import Any

from springpot.errors import DataError
from springpot.identification.result import Identification
from springpot.invention.result import Invention
from springpot.measurement.measurement import Measurement
from springpot.report.interactive.answers import preview
from springpot.report.interactive.hypotheses import Preview
from springpot.report.interactive.in_time import TimeScene
from springpot.report.interactive.scene import PageScene
from springpot.rheology.effect import Effect
from springpot.rheology.typed import law

from .sessions import LONGEST_NAME, State, kept
from .specimen import Opened, Specimen


def with_law(state: State, typed: object) -> tuple[State, Effect | None]:
    """A state with a law as a page sent it, and the law; an empty text is none.

    Raises
    ------
    SpringpotError
        If it is no law.
    """
    if not typed:
        return state, None
    if not isinstance(typed, str) or len(typed) > LONGEST_NAME:
        raise DataError(f"a law has at most {LONGEST_NAME} signs")
    own = law(typed, _next_name(state))
    # Without its brackets, but with its name: a later one would be called otherwise.
    return state.accepting(own.expression[1:-1]), own


def _next_name(state: State) -> str:
    return f"law-{len(state.accepted) + 1}"


def tried(state: State, own: Effect | None, data: Opened, fit: Identification) -> dict[str, Any]:
    """The model of a state fitted to its rows.

    Parameters
    ----------
    state : State
        What is tried.
    own : Effect, optional
        The law that was typed; it is the last that the state has accepted.
    data : Measurement or Specimen
        The data, all rows.
    fit : Identification
        Of the rows that the state uses.

    Returns
    -------
    dict
        Like the preview of an effect; ``says``: what kind of law it is, ``accept``: what the state
        accepts last, ``sizes``: parameters of the law, or of the model where there is none.
    """
    says, mine = "", ""
    if own is not None:
        says, mine = own.summary, f"{own.name}."
    values = {name: value for name, value in fit.parameters.items() if name.startswith(mine)}
    sizes = [f"{name.removeprefix(mine)} = {value}" for name, value in values.items()]
    return {
        **_drawn(state, data, fit),
        "says": says,
        "accept": list(state.accepted[-1:]),
        "sizes": sizes,
    }


def _drawn(state: State, data: Opened, fit: Identification) -> dict[str, Any]:
    if isinstance(data, Specimen):
        told = {"model": fit.model.name, "error": fit.relative_rms, "refitted": True}
        return {**told, **TimeScene(data.tests).curve(fit.model, fit.theta, fit.reference)}
    used = kept(data, state.excluded)
    return preview(PageScene(data), used, Preview(state.expression, fit.model, fit.theta, True))


def invented(state: State, measurement: Measurement, found: Invention) -> dict[str, Any]:
    """Laws that were found beside the effects that a state accepts.

    Returns
    -------
    dict
        ``invention``: schema ``springpot.invention/1``; ``laws`` as a state accepts them;
        ``previews`` by these texts, like those of effects.
    """
    used, name = kept(measurement, state.excluded), _next_name(state)
    scene, texts = PageScene(measurement), [f"{name} = {each.text}" for each in found.laws]
    fits = [one.grown.refit for one in found.ranked]
    previews = {
        text: preview(scene, used, Preview(name, fit.model, fit.theta, True))
        for text, fit in zip(texts, fits, strict=False)
    }
    return {"invention": found.to_dict(), "laws": texts, "previews": previews}
