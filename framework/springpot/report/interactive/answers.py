"""What is drawn of an answer, and what it could become: each hypothesis is seen before it is taken.

K of the model and of every candidate, parameters, noise, the rivals' next points; what each
candidate would make of the curve, from fits that the diagnosis has already done; and what can be
done with the data themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.diagnosis.ladder import Examined, Ladder
from springpot.diagnosis.result import ToDo
from springpot.errors import SpringpotError
from springpot.identification.fitted import FittedModel
from springpot.identification.result import Identification
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned_over
from springpot.measurement.opening import Test, sweep_of
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residuals_of_tests import units_of
from springpot.registry import of_each
from springpot.rheology.model import Model
from springpot.rheology.points import Points, Real
from springpot.timetests.fitting import identify

from ..answers import reference_note
from .in_time import DrawnTests, TimeScene
from .scene import parameters_of, proposed_points, rounded


@dataclass(frozen=True, eq=False)
class Preview:
    """The present model with one more effect.

    Parameters
    ----------
    effect : str
        Its name.
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters: refitted, or where the scan puts them.
    refitted : bool
        Which of these.
    """

    effect: str
    model: Model
    theta: Real
    refitted: bool


def grown_by_each(case: Examined, only: Container[str] | None = None) -> Iterator[Preview]:
    """For each candidate of a diagnosis, the model that has accepted it alone, as far as known.

    Of all, or of the effects `only`.
    """
    for candidate in case.diagnosis.candidates:
        if only is not None and candidate.effect not in only:
            continue
        try:
            grown = case.grown_with(candidate.physics)
        # An effect that does not fit this model or these data has nothing to be drawn.
        except SpringpotError:
            continue
        yield Preview(candidate.effect, *grown)


@dataclass(frozen=True, eq=False)
class Act:
    """Something that can be done with the data.

    Parameters
    ----------
    name, label, says : str
        By which it is known, called, and told.
    preview : Preview
        The model as it would then be.
    used : tuple of Measurement or TimeTest
        The tests that would then be used.
    accept : tuple of str
        Effects that are accepted by it.
    exclude : tuple of int
        Rows that are left out by it, counted from 0 among those that were used.
    turns : tuple of str
        The tests of which a channel is turned by it.
    """

    name: str
    label: str
    says: str
    preview: Preview
    used: tuple[Test, ...]
    accept: tuple[str, ...] = ()
    exclude: tuple[int, ...] = ()
    turns: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """What it is called, and what accepting it does."""
        names = ("name", "label", "says", "accept", "exclude", "turns")
        return {name: getattr(self, name) for name in names}

    def drawn_in(self, scene: DrawnTests) -> dict[str, Any]:
        """The model as it would then be, over the data as they stand."""
        if isinstance(scene, TimeScene):
            scene = replace(scene, turned=self.turns)
        return preview(scene, self.used, self.preview)


def acted(case: Examined) -> Iterator[Act]:
    """What can be done with the data of an answer."""
    base, tests = case.base, tuple(case.tests)
    for step in case.diagnosis.steps:
        if step.split:
            effect = of_each(step.split)
            assert isinstance(base, Refit)
            grown = refit(base.model + effect, base.data, base.noise)
            one = Preview(effect.name, grown.model, grown.theta, True)
            label = f"split by {step.split}"
            yield Act(effect.name, label, step.says, one, tests, accept=(effect.name,))
    turns = [step for step in case.diagnosis.steps if step.turns]
    if turns:
        names = tuple(step.turns for step in turns)
        turned = tuple(turned_over(test) if test.name in names else test for test in tests)
        said, one = " and ".join(names), _fitted_anew(base, turned)
        yield Act(f"{said} turned", f"turn {said}", turns[0].says, one, turned, turns=names)
    # All at once, as the answer was found without all of them.
    leaving = [step for step in case.diagnosis.steps if step.exclude]
    if leaving:
        yield _without(leaving, base, tests)


def _fitted_anew(base: FittedModel, tests: Sequence[Test]) -> Preview:
    """The model fitted to tests that an answer was not found for; a sweep was searched without."""
    if isinstance(base, Identification):
        base = identify(tests, base.model)
    return Preview("", base.model, base.theta, True)


def _without(steps: Sequence[ToDo], base: FittedModel, tests: tuple[Test, ...]) -> Act:
    rows, says = [row - 1 for step in steps for row in step.exclude], steps[0].says
    what = f"row {rows[0] + 1}"
    if len(rows) > 1:
        what = f"rows {', '.join(str(row + 1) for row in rows)}"
    if 2 < len(rows) == rows[-1] - rows[0] + 1:
        what = f"rows {rows[0] + 1} to {rows[-1] + 1}"
    if len(steps) > 1:
        says = f"{what} stand out: without them every fit is that of the others"
    stays = np.ones(len(tests[0]), dtype=bool)
    stays[rows] = False
    used = (tests[0].subset(stays), *tests[1:])
    return Act(
        f"without {what}",
        f"leave out {what}",
        says,
        _fitted_anew(base, used),
        used,
        exclude=tuple(rows),
    )


DRAWABLE = {"omega", "amplitude", "temperature", "repeats"}
"""What an experiment may change for its rivals to be drawn."""
ON_A_RIVAL = 160
"""Points of a rival's curve: as many as the picture has columns of three pixels."""


def drawn(ladder: Ladder, scene: DrawnTests) -> dict[str, Any]:
    """The last rung of a ladder as a page shows it.

    Parameters
    ----------
    ladder : Ladder
        The answer.
    scene : PageScene or TimeScene
        Its data.

    Returns
    -------
    dict
        ``discovery`` (schema ``springpot.discovery/2``); ``of``: what errors are shares of;
        ``parameters`` of the last rung, each with its correlations to the others;
        ``spots``: which points each place is of;
        ``noise``: standard deviations of storage and loss at the drawn points; ``reference``: to
        which temperature or amplitude the parameters belong; ``model``: K of the last rung,
        ``{"points", "curves", "planes"}``, each with ``storage`` and ``loss``, at the drawn points,
        on one smooth curve for each sweep, in the order and unit of the data, and as residuals in
        each plane with the ``width`` of their noise; ``previews``: for each candidate curves and
        planes of the model grown by it alone, with its ``error``, ``model`` and whether it was
        ``refitted`` or comes from the scan; ``actions``: see `acted`; ``proposed``: what
        to measure next;
        ``next``: the rivals at the proposed points.
    """
    step = ladder.steps[-1]
    case = step.examined
    assert case is not None
    (model, correlation), units = case.correlated, units_of(case.tests)
    # Once, for previews and rivals alike: each is a model with its parameters.
    grown, acts = list(grown_by_each(case)), list(acted(case))
    acted_on = {act.name: act.drawn_in(scene) for act in acts}
    return {
        **scene.whole(case.base),
        "discovery": ladder.to_dict(),
        "parameters": parameters_of(model, step.parameters, units, correlation),
        "spots": [place.spot for place in case.diagnosis.where],
        "reference": reference_note(sweep_of(case.tests), [case.base.model.network]),
        "actions": [act.to_dict() for act in acts],
        "previews": acted_on | {one.effect: preview(scene, case.tests, one) for one in grown},
        "proposed": ladder.proposed,
        "next": _next(ladder, {one.effect: one for one in grown}, scene.seen),
    }


def drawn_at_once(base: FittedModel, scene: DrawnTests) -> dict[str, Any]:
    """A fitted model as `drawn`, without anything that it may lack."""
    nothing = {"parameters": [], "reference": "", "actions": [], "previews": {}}
    return {**scene.whole(base), **nothing, "proposed": None, "next": None}


def rungs(ladder: Ladder, draw: Callable[[Ladder], dict[str, Any]]) -> list[dict[str, Any]]:
    """Each rung of a ladder, drawn: every ladder is the beginning of the next, to the bit."""
    answers = []
    for count, step in enumerate(ladder.steps):
        diagnosis = step.diagnosis
        part = Ladder(ladder.data, ladder.steps[: count + 1], diagnosis.verdict, diagnosis)
        answers.append(draw(part))
    return answers


def preview(scene: DrawnTests, used: Sequence[Test], one: Preview) -> dict[str, Any]:
    """A grown model as the page draws it, with its relative error over the rows that are used."""
    # Where a scan begins may be no model at all at some points; they are not drawn.
    with np.errstate(all="ignore"):
        error = scene.error(used, one.model, one.theta)
        curve = scene.curve(one.model, one.theta)
    return {"model": one.model.name, "error": error, "refitted": one.refitted, **curve}


def _next(
    ladder: Ladder, grown: dict[str, Preview], measurement: Measurement | None
) -> dict[str, Any] | None:
    """The proposed experiment, and what the two rivals predict along it.

    None where nothing is proposed, or a test in time is.
    """
    if measurement is None:
        return None
    case = ladder.undecided.case
    proposed = case.diagnosis.next_experiment
    if proposed is None or not proposed.action.get("omega"):
        return None
    if ladder.undecided is not ladder.steps[-1]:
        grown = {one.effect: one for one in grown_by_each(case, proposed.separates)}
    points = _along(proposed_points(proposed.action, measurement), proposed.action)
    floor = case.diagnosis.error.noise_floor
    rivals = []
    for name in proposed.separates:
        # Of another specimen or a known mass the rivals would have to be computed anew.
        if name in grown and set(proposed.action) <= DRAWABLE:
            rivals.append(
                {"effect": name, **_band(grown[name].model, grown[name].theta, points, floor)}
            )
    action = {key: list(values) for key, values in proposed.action.items()}
    return {"action": action, "frequency": rounded(points.omega / (2 * np.pi)), "rivals": rivals}


def _along(points: Points, action: dict[str, list[float]]) -> Points:
    """Where only the frequency moves.

    Points close enough for a curve, on which a resonance is seen as one.
    """
    if set(action) != {"omega"}:
        return points
    rows = np.zeros(ON_A_RIVAL, dtype=int)
    whole = points.mapped(lambda column: column[rows])
    log_omega = np.linspace(points.log_omega.min(), points.log_omega.max(), ON_A_RIVAL)
    return replace(whole, log_omega=log_omega)


def _band(model: Model, theta: Real, points: Points, floor: float) -> dict[str, Any]:
    stiffness = model.stiffness(theta, points)
    # 95 % of what would be measured.
    width = 2.0 * floor * np.abs(stiffness)
    return {
        "storage": rounded(stiffness.real),
        "loss": rounded(stiffness.imag),
        "width": rounded(width),
    }
