"""What a state of the page would be, before it is asked for: a first look, or one fit, drawn.

A first look comes some tenths of a second after data were dropped: how far the model lies from
them, what noise and any material would leave, and where it fails. Then a law that is typed, another
model, points left out, parameters set, fixed or bounded by hand; and laws that are found.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from springpot.comparison.result import Comparison, Judgement
from springpot.constraints import constrained, owning
from springpot.diagnosis.grown import size_of
from springpot.diagnosis.result import Fitted, TriedEffect, unseen
from springpot.errors import DataError, ModelError
from springpot.identification.result import Identification
from springpot.invention.result import Invention
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test
from springpot.measurement.units import Units
from springpot.misfit.error import percent
from springpot.misfit.refit import Refit
from springpot.misfit.residuals_of_tests import units_of
from springpot.numerics import evenly
from springpot.registry import parse_model
from springpot.report.interactive.answers import (
    DrawnTests,
    Preview,
    TimeScene,
    drawn_at_once,
    preview,
)
from springpot.report.interactive.scene import PageScene
from springpot.rheology.effect import Effect
from springpot.rheology.grammar import LONGEST
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.rheology.tied import allowed
from springpot.rheology.typed import law
from springpot.timetests.specimen import as_had_by
from springpot.writing import LISTED

from .sessions import Opened, Specimen, State, kept, tests_in

FEW = 100
"""Rows that are looked at, evenly many of all: more would take longer than a first look may."""
Told = Callable[[Any], None]
"""Called with a stage in words, or with a line that holds one."""
SAYS = "what may be missing is being sought"


def model_and_tests(state: State, tests: Sequence[Test]) -> tuple[Model, list[Test]]:
    """The model with what is held, tied and each level's own, and the tests with their levels."""
    known = state.known
    fix, tie = known.pop("fix"), known.pop("tie", ())
    model = constrained(parse_model(state.expression), units_of(tests), fix, tie=tie)
    return owning(model, tests, known.pop("own", None), **known)


def leveled(state: State, tests: Sequence[Test]) -> Sequence[Test]:
    """The tests as the model of a state sees them."""
    return model_and_tests(state, tests)[1] if _has_levels(state) else tests


def _has_levels(state: State) -> bool:
    """Whether a model may have levels of a column, as of a parameter or of ``EFFECT:COLUMN``."""
    return bool(state.options) or ":" in state.expression


def scene_of(state: State, data: Opened) -> DrawnTests:
    """The data as the page draws them, all rows with the levels that a fit of those used has."""
    if isinstance(data, Specimen):
        used = kept(data, state.excluded).tests
        there = {test.name for test in used}
        # Numbered in their order, those first that the fit has.
        order = sorted(range(len(data.tests)), key=lambda i: data.tests[i].name not in there)
        first = leveled(state, [data.tests[i] for i in order])
        return TimeScene([first[order.index(i)] for i in range(len(order))], used)
    if not _has_levels(state):
        return PageScene(data)
    [few], [seen] = leveled(state, [kept(data, state.excluded)]), leveled(state, [data])
    assert isinstance(seen, Measurement)
    stays = np.ones(len(data), dtype=bool)
    stays[list(state.excluded)] = False
    conditions = dict(seen.conditions)
    for name in conditions.keys() - data.conditions.keys():
        number = dict(zip(conditions[name][stays].tolist(), few.conditions[name], strict=True))
        # Of a level that is left out wholly there are no parameters: it is drawn as the last.
        conditions[name] = np.array([number.get(n, len(seen)) for n in conditions[name].tolist()])
    return PageScene(data, replace(seen, conditions=conditions))


def bound(state: State, data: Opened) -> Model:
    """The model of a state, with the levels of its rows."""
    return as_had_by(*model_and_tests(state, tests_in(kept(data, state.excluded))))


def looked_at(state: State, data: Opened) -> tuple[Model, list[Test]]:
    """The model of a state, and what a first look is at: of a large sweep some rows."""
    used = kept(data, state.excluded)
    if isinstance(used, Measurement) and len(used) > FEW:
        rows = np.zeros(len(used), dtype=bool)
        rows[evenly(len(used), FEW)] = True
        used = used.subset(rows)
    return model_and_tests(state, tests_in(used))


def first_look(state: State, data: Opened, judged: Judgement) -> dict[str, Any]:
    """A judged model as `springpot.web.tasks.answer`, without a single cause."""
    assert isinstance(judged.fitted, Identification | Refit)
    error, model = judged.error.to_dict(), judged.model
    rung = {"model": model.name, "accepted": None, "class": [], **error}
    diagnosis = {
        "model": model.name,
        "verdict": "sought",
        "says": SAYS,
        "error": error,
        "where": [place.to_dict() for place in judged.where],
        "candidates": [],
        "leading": [],
        "next_experiment": None,
    }
    return {
        "state": state.to_dict(),
        "discovery": {"steps": [rung], "verdict": "sought", "diagnosis": diagnosis},
        "spots": [place.spot for place in judged.where],
        **drawn_at_once(judged.fitted, scene_of(state, data)),
    }


def with_law(state: State, typed: object) -> tuple[State, Effect | None]:
    """A state with a law as a page sent it, and the law; an empty text is none.

    Raises
    ------
    SpringpotError
        If it is no law.
    """
    if not typed:
        return state, None
    if not isinstance(typed, str) or len(typed) > LONGEST:
        raise DataError(f"a law has at most {LONGEST} signs")
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
        **drawing(state, data)(fit.model, fit.theta),
        "says": says,
        "accept": list(state.accepted[-1:]),
        "sizes": sizes,
    }


def drawing(state: State, data: Opened) -> Callable[[Model, Real], dict[str, Any]]:
    """How fitted models are drawn, with their relative error over the rows that are used."""
    scene, name = scene_of(state, data), state.expression
    used = leveled(state, tests_in(kept(data, state.excluded)))
    return lambda model, theta: preview(scene, used, Preview(name, model, theta, True))


def telling(told: Told, state: State, data: Opened) -> Fitted:
    """What tells of each effect that was tried by itself an ``action`` as in an answer.

    With its ``preview``; only beside new data: beside a further rung the answer before is there.
    """
    if state.accepted:
        return unseen
    draw, units = drawing(state, data), units_of(tests_in(data))
    left: dict[str, str] = {}

    def tell(tried: TriedEffect) -> None:
        name, shown = tried.effect.name, draw(tried.model, tried.theta)
        leaves = f"{name} would leave {percent(shown['error'])}"
        # Tried again in another noise, most leave the same.
        if left.get(name) == leaves:
            return
        left[name] = leaves
        size = tried.effect.element.parameters[0]
        factor, unit = units.of(size.unit)
        value = factor * size_of(tried.model, tried.theta, tried.effect)
        action: dict[str, Any] = {"name": name, "label": name, "says": tried.effect.summary}
        action |= {"shown": f"{size.name} = {value:.3g} {unit.strip('-')}".strip()}
        action |= {"accept": [name], "exclude": []}
        told({"stage": leaves, "action": action, "preview": shown})

    return tell


def ranked(state: State, data: Opened, found: Comparison) -> dict[str, Any]:
    """A ranking, each of its models as something that can be done.

    Returns
    -------
    dict
        Schema ``springpot.comparison/2``; ``actions`` as in an answer, with the ``model`` that
        takes the place of the present one, what is ``shown`` of it, and ``previews`` by their
        names.
    """
    handy, draw = [found.handy] if found.handy else [], drawing(state, data)
    actions, previews = [], {}
    for one in list(dict.fromkeys([*found.shown[: LISTED - len(handy)], *handy])):
        assert isinstance(one.fitted, Identification | Refit)
        name, count = f"{one.model.name} instead", one.free_parameters
        previews[name] = draw(one.fitted.model, one.fitted.theta)
        actions.append(
            {
                "name": name,
                "label": one.model.name,
                "says": one.says,
                "shown": f"{count} parameters, {'fails' if one.fails else 'holds'}",
                "model": one.model.base,
                "accept": [effect.name for effect in one.model.effects],
                "exclude": [],
            }
        )
    return {**found.to_dict(), "actions": actions, "previews": previews}


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
        text: preview(scene, [used], Preview(name, fit.model, fit.theta, True))
        for text, fit in zip(texts, fits, strict=False)
    }
    return {"invention": found.to_dict(), "laws": texts, "previews": previews}


@dataclass(frozen=True)
class Hand:
    """What a user set, in printed units.

    Parameters
    ----------
    values : dict of str to float
        Where each parameter stands.
    fix : dict of str to float
        Those that stay.
    bounds : dict of str to (float, float)
        Ends, of those that have any by hand.
    """

    values: dict[str, float]
    fix: dict[str, float] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)


def hand_of(model: Model, given: object) -> Hand:
    """What a page sent, which may be anything.

    Raises
    ------
    ModelError
        If a parameter is missing or stands outside its ends.
    """
    hand = Hand({})
    entries: Mapping[str, object] = {}
    if isinstance(given, Mapping):
        entries = given
    for name in model.names:
        # By the model's names, never by those of the page: what it sends beside them is dropped.
        entry = entries.get(name)
        if not isinstance(entry, Mapping):
            raise ModelError(f"{model.name}: the parameter {name} has no value")
        value = _number(entry.get("value"), np.nan)
        ends = _number(entry.get("lower"), -np.inf), _number(entry.get("upper"), np.inf)
        if ends[0] > ends[1]:
            raise ModelError(
                f"{name}: the lower end {ends[0]:.4g} lies above the upper end {ends[1]:.4g};"
                " swap them"
            )
        # Written this way round, a value that is no number is refused too.
        if not ends[0] <= value <= ends[1]:
            raise ModelError(
                f"{name} = {value:.4g} is not within {ends[0]:.4g} to {ends[1]:.4g}; move one of"
                " them"
            )
        hand.values[name] = value
        # A parameter that stays needs no ends.
        if entry.get("fixed"):
            hand.fix[name] = value
        elif np.isfinite(ends).any():
            hand.bounds[name] = ends
    return hand


def theta_of(model: Model, units: Units, hand: Hand) -> Real:
    """The parameters (p,) in the model's own units.

    Raises
    ------
    ModelError
        If one is outside what the model allows.
    """
    own = []
    for parameter in model.parameters:
        factor, _ = units.of(parameter.unit)
        own.append(hand.values[parameter.name] / factor)
    # A hand may set wider ends than there is a model for.
    return np.array(list(map(allowed, model.parameters, own)))


def _number(value: object, otherwise: float) -> float:
    # True is an int to Python.
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return float(value)
    return otherwise
