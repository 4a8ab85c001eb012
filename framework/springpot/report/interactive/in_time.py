"""What is drawn of tests in time, in the same terms as sweeps: rows, curves, residuals over noise.

Which axes there are, and what stands on them, is told to the page as data.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.identification.fitted import FittedModel
from springpot.measurement.measurement import Measurement
from springpot.measurement.other_test import OtherTest
from springpot.measurement.recording import recorded
from springpot.measurement.timetest import TimeTest
from springpot.misfit.residuals_of_tests import Test, TestPart, parts_of_specimen
from springpot.numerics import evenly, rms
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.timetests.specimen import reference_of
from springpot.writing import DIGITS as OF_RESIDUALS

from .scene import MOST_ON_CURVES, MOST_POINTS, PageScene, rounded

PLANE = "signal"
"""The one plane of residuals: what was measured less what was computed."""
SMOOTH = 120
"""Points of the curve of a test after a step."""


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
        most = MOST_POINTS // len(self.parts)
        return [evenly(len(part.test), most) for part in self.parts]

    @cached_property
    def grids(self) -> list[Real]:
        """Where the curve of each test is computed: times in s, or numbers of rows of a sweep."""
        return [_grid(part.test, MOST_ON_CURVES // len(self.parts)) for part in self.parts]

    @cached_property
    def thin(self) -> NDArray[np.int64]:
        """Which of the drawn rows the residuals of a preview are lines through."""
        count = sum(map(len, self.rows))
        return np.arange(0, count, max(1, -(-count // MOST_ON_CURVES)))

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
        return np.geomspace(positive[0], positive[-1], min(SMOOTH, most))
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
