"""What is drawn of an answer, and what it could become: each hypothesis is seen before it is taken.

K of the model and of every candidate, parameters, noise, the rivals' next points; what each
candidate would make of the curve, from fits that the diagnosis has already done; and what can be
done with the data themselves. Tests in time are drawn in the same terms as sweeps: rows, curves,
residuals over noise; which axes there are, and what stands on them, is told to the page as data.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.diagnosis.ladder import Examined, Ladder
from springpot.diagnosis.result import ToDo
from springpot.errors import SpringpotError
from springpot.identification.native import FittedModel
from springpot.identification.result import Identification
from springpot.measurement.covered import OtherTest
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned_over
from springpot.measurement.opening import Test, sweep_of
from springpot.measurement.recording import recorded
from springpot.measurement.replicates import THINNED
from springpot.measurement.timetest import TimeTest
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residuals_of_tests import TestPart, parts_of_specimen, units_of
from springpot.numerics import evenly, rms
from springpot.registry import of_each
from springpot.rheology.model import Model
from springpot.rheology.points import Points, Real
from springpot.timetests.fitting import identify
from springpot.timetests.specimen import reference_of
from springpot.writing import DIGITS as OF_RESIDUALS

from ..answers import reference_note
from .scene import DRAWN, PageScene, parameters_of, proposed_points, rounded

PLANE = "signal"
"""The one plane of residuals: what was measured less what was computed."""


@dataclass(frozen=True, eq=False)
class TimeScene:
    """Tests of one specimen as the page draws them.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        All rows, those that are left out among them.
    fitted : sequence of TimeTest or Measurement, optional
        Those that models are fitted to, where some are left out: they tell the temperature to which
        parameters belong.
    turned : collection of str, optional
        The tests of which a channel counts the other way: what is computed stands there turned.
    """

    tests: Sequence[Test]
    fitted: Sequence[Test] = ()
    turned: Collection[str] = ()
    seen = None

    @cached_property
    def reference(self) -> float:
        """Temperature in kelvin to which parameters belong."""
        return reference_of(self.fitted or self.tests)

    @cached_property
    def parts(self) -> list[TestPart]:
        """The tests as numbers, in the units of the first."""
        return parts_of_specimen(self.tests)

    @cached_property
    def rows(self) -> list[NDArray[np.int64]]:
        """Numbers of the rows that are drawn of each test."""
        most = THINNED.points // len(self.parts)
        return [evenly(len(part.test), most) for part in self.parts]

    @cached_property
    def grids(self) -> list[Real]:
        """Where the curve of each test is computed: times in s, or numbers of rows of a sweep."""
        return [_grid(part.test, DRAWN.curves // len(self.parts)) for part in self.parts]

    @cached_property
    def thin(self) -> NDArray[np.int64]:
        """Which of the drawn rows the residuals of a preview are lines through."""
        count = sum(map(len, self.rows))
        return np.arange(0, count, max(1, -(-count // DRAWN.curves)))

    def to_dict(self) -> dict[str, Any]:
        """Rows, tests, axes and views, as the page needs them."""
        tests = [part.test for part in self.parts]
        starts = np.cumsum([0, *map(len, tests)])
        columns = [_columns(part, rows) for part, rows in zip(self.parts, self.rows, strict=True)]
        views = [view for i, part in enumerate(self.parts) for view in _views(part, i, len(tests))]
        first = self.parts[0]
        return {
            "name": ", ".join(test.name for test in tests),
            "count": int(starts[-1]),
            "planes": {
                PLANE: {
                    "name": PLANE,
                    "shows": "what was measured less what was computed",
                    "label": "",
                }
            },
            "thin": self.thin.tolist(),
            "units": {"stiffness": first.test.units.stiffness, "amplitude": ""},
            "axis": {"column": "time", "label": "t [s]", "logarithmic": True, "per_hertz": 1.0},
            "words": {"each": "test"},
            "rows": np.concatenate(
                [rows + start for rows, start in zip(self.rows, starts, strict=False)]
            ).tolist(),
            **{
                name: rounded(np.concatenate([each[name] for each in columns]))
                for name in ("x", "storage", "loss", "moved")
            },
            "sweep": np.repeat(np.arange(len(tests)), list(map(len, self.rows))).tolist(),
            "sweeps": [{"label": test.name, "points": len(test)} for test in tests],
            "grids": [
                _grid_columns(part.test, grid)
                for part, grid in zip(self.parts, self.grids, strict=True)
            ],
            "views": dict(views),
        }

    def error(self, tests: Sequence[Test], model: Model, theta: Real) -> float:
        """Relative error of the test that is missed most, as `Identification.relative_rms`."""
        return max(
            rms(part.residual(model, theta, self.reference).value * part.relative_sd)
            for part in parts_of_specimen(tests)
        )

    def whole(self, base: FittedModel) -> dict[str, Any]:
        """What a fit computes at all drawn rows, the noise there, what errors are shares of."""
        whole = self.curve(base.model, base.theta, whole=True)
        width = whole["planes"][PLANE]["width"]
        return {"of": "the signal", "noise": {"storage": width, "loss": width}, "model": whole}

    def curve(self, model: Model, theta: Real, whole: bool = False) -> dict[str, Any]:
        """What is computed of each test, and the residuals.

        Parameters
        ----------
        model : Model
            The model.
        theta : ndarray, shape (p,)
            Its parameters.
        whole : bool
            Whether residuals are told at all drawn rows, with the width of their noise, and what is
            computed there.
        """
        curves, points, missed, widths = [], [], [], []
        for part, rows, grid in zip(self.parts, self.rows, self.grids, strict=True):
            with np.errstate(all="ignore"):
                every = np.arange(len(part.measured))
                sign = -1.0 if part.test.name in self.turned else 1.0
                answer = sign * part.answer(model, theta, self.reference, every).value
                curve = _curve(part, model, theta, self.reference, grid, sign * answer)
                curves.append([sign * each for each in curve])
            points.append(_both(answer, part, rows))
            missed.append(_both(part.measured - answer, part, rows))
            widths.append(_both(part.sd, part, rows)[0])
        planes = _joined(missed, OF_RESIDUALS)
        drawn: dict[str, Any] = {}
        if whole:
            planes["width"] = rounded(np.concatenate(widths), OF_RESIDUALS)
            drawn["points"] = _joined(points)
        else:
            planes = {name: [values[i] for i in self.thin] for name, values in planes.items()}
        told = [{"storage": rounded(k[0]), "loss": rounded(k[1])} for k in curves]
        return {**drawn, "curves": told, "planes": {PLANE: planes}}


DrawnTests: TypeAlias = PageScene | TimeScene
"""Tests of whatever kind as the page draws them."""


def _grid(test: Test, most: int) -> Real:
    """Smooth after a step; a record swings faster than that, and is computed where it was read."""
    if isinstance(test, Measurement):
        return np.argsort(test.omega).astype(float)
    if isinstance(test, OtherTest):
        return np.arange(float(len(test)))
    positive = test.time[test.time > 0.0]
    if test.after_step:
        return np.geomspace(positive[0], positive[-1], min(DRAWN.step, most))
    # Of its swings a picture needs five times the points of a smooth curve.
    return np.asarray(test.time[evenly(len(test), 5 * most)])


def _moved(test: TimeTest, at: Real) -> Real:
    return np.interp(at, test.loading.time, test.loading.value)


def _both(values: Real, part: TestPart, rows: NDArray[np.int64]) -> tuple[Real, Real]:
    """The numbers of a test at its drawn rows, and those of the loss, which only a sweep has."""
    if isinstance(part.test, Measurement):
        storage, loss = np.split(values, 2)
        return storage[rows], loss[rows]
    return values[rows], np.full(len(rows), np.nan)


def _columns(part: TestPart, rows: NDArray[np.int64]) -> dict[str, Real]:
    test = part.test
    storage, loss = _both(part.measured, part, rows)
    if isinstance(test, Measurement):
        x, moved = test.units.on_clock(test.frequency[rows]), np.full(len(rows), np.nan)
    elif isinstance(test, OtherTest):
        x, moved = test.at[rows], np.full(len(rows), np.nan)
    else:
        x, moved = test.time[rows], _moved(test, test.time[rows])
    return {"x": x, "storage": storage, "loss": loss, "moved": moved}


def _grid_columns(test: Test, grid: Real) -> dict[str, Any]:
    if isinstance(test, Measurement):
        x = test.units.on_clock(test.frequency[grid.astype(int)])
        return {"x": rounded(np.asarray(x)), "moved": []}
    if isinstance(test, OtherTest):
        return {"x": rounded(test.at), "moved": []}
    return {"x": rounded(grid), "moved": rounded(_moved(test, grid))}


def _curve(
    part: TestPart, model: Model, theta: Real, reference: float, grid: Real, answer: Real
) -> tuple[Real, Real]:
    if not isinstance(part.test, TimeTest):
        return _both(answer, part, grid.astype(int))
    value = recorded(model, theta, part.test, reference, grid).value
    return value, np.full(len(grid), np.nan)


def _joined(pairs: Sequence[tuple[Real, Real]], digits: int = 6) -> dict[str, Any]:
    storage, loss = (np.concatenate(each) for each in zip(*pairs, strict=True))
    return {"storage": rounded(storage, digits), "loss": rounded(loss, digits)}


def _views(part: TestPart, number: int, count: int) -> list[tuple[str, dict[str, Any]]]:
    """The views of one test: what answered over time, and over what was imposed where it swings."""
    test, shown = part.test, ["storage"]
    named = f"{test.name}: " if count > 1 else ""
    if isinstance(test, Measurement):
        units, shown = test.units, ["storage", "loss"]
        name, label = "storage and loss", f"[{units.stiffness}]"
        x = {"label": f"frequency [{units.clock}]", "log": True, "column": "x"}
        y = {"label": f"{units.storage} and {units.loss} {label}", "log": True}
    elif isinstance(test, OtherTest):
        name, label = test.quantity, f"{test.quantity} [{test.unit}]"
        x = {"label": test.clock, "log": test.control == "frequency", "column": "x"}
        y = {"label": label, "log": False}
    else:
        imposed, answered = test.words
        name, label = f"{answered} over time", f"{answered} [{test.response_unit}]"
        # After a step all decades of time tell.
        x = {"label": "t [s]", "log": test.after_step, "column": "x"}
        y = {"label": label, "log": test.after_step and bool(np.all(test.response > 0.0))}
    of = {"test": number, "parts": shown, "along": x, "residual": f"Δ {label}", "y": y}
    views = [(f"test-{number}", {**of, "name": f"{named}{name}", "x": x})]
    if isinstance(test, TimeTest) and test.kind in ("history", "recovery"):
        x = {"label": f"{imposed} [{test.loading_unit}]", "log": False, "column": "moved"}
        views.append(
            (f"loop-{number}", {**of, "name": f"{named}{answered} over {imposed}", "x": x})
        )
    return views


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
    rows = np.zeros(DRAWN.rival, dtype=int)
    whole = points.mapped(lambda column: column[rows])
    log_omega = np.linspace(points.log_omega.min(), points.log_omega.max(), DRAWN.rival)
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
