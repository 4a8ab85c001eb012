"""What is drawn of an answer.

K of the model and of every candidate, parameters, noise, the rivals' next points.

What is drawn of data, and K of fitted models there.

At the measured points and on smooth curves between them.

What each candidate would make of the curve, from fits that the diagnosis has already done.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.diagnosis.examination import Case
from springpot.diagnosis.ladder import Ladder
from springpot.errors import SpringpotError
from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL, PLANES
from springpot.rheology.points import KELVIN, Complex, Points, Real

from ..answers import reference_note
from ..residuals import plane_of
from ..sweeps import DrawnSweep, chosen
from ..views import DrawnAxis, axis_of, smooth, sweeps_of

MOST_POINTS = 1500
"""Measured points that are drawn.

As SVG, each is an element of the page, and a screen has hardly more columns.
"""
MOST_ON_CURVES = 480
"""Points on all smooth curves of one model together, and of its residuals in a plane.

With thirty previews this keeps an answer below half a MB.
"""
DIGITS = 6
"""Significant digits of what is drawn; a screen shows three."""
OF_RESIDUALS = 4
"""Significant digits of residuals, of which an answer has the most numbers."""


@dataclass(frozen=True, eq=False)
class PageScene:
    """Data as the page draws them.

    Parameters
    ----------
    measurement : Measurement
        All rows, those that are left out among them.
    """

    measurement: Measurement

    @cached_property
    def axis(self) -> DrawnAxis:
        """The column along which the data are drawn."""
        return axis_of(self.measurement)

    @cached_property
    def sweeps(self) -> list[DrawnSweep]:
        """The sweeps that are drawn."""
        return chosen(sweeps_of(self.measurement, self.axis))

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """Numbers of the rows that are drawn: all, or evenly many of each sweep."""
        rows = np.concatenate([sweep.rows for sweep in self.sweeps])
        if len(rows) <= MOST_POINTS:
            return rows
        # Evenly along each sweep, its ends among them: a browser draws some thousand marks without
        # a pause.
        return np.asarray(rows[np.linspace(0, len(rows) - 1, MOST_POINTS).round().astype(int)])

    @cached_property
    def thin(self) -> NDArray[np.int64]:
        """Which of the drawn rows the residuals of a preview are lines through."""
        step = max(1, int(np.ceil(len(self.rows) / MOST_ON_CURVES)))
        return np.arange(0, len(self.rows), step)

    @cached_property
    def points(self) -> Points:
        """Where these rows were measured."""
        return _rows_of(self.measurement.points, self.rows)

    @cached_property
    def grids(self) -> list[tuple[Real, Points]]:
        """For each sweep the places of its smooth curve along the axis, and their conditions."""
        whole = [smooth(self.measurement, self.axis, sweep) for sweep in self.sweeps]
        # Each preview carries such a curve for each sweep: the page would otherwise grow by
        # megabytes.
        count = sum(len(x) for x, _ in whole)
        step = max(2, int(np.ceil(count / MOST_ON_CURVES)))
        thin = []
        for x, points in whole:
            # With its last point, or a curve would end before its data.
            rows = np.unique(np.append(np.arange(0, len(x), step), len(x) - 1))
            thin.append((x[rows], _rows_of(points, rows)))
        return thin

    def to_dict(self) -> dict[str, Any]:
        """Rows, sweeps and axis, as the page needs them."""
        measurement, rows = self.measurement, self.rows
        sweep_of = np.zeros(len(measurement), dtype=int)
        for number, sweep in enumerate(self.sweeps):
            sweep_of[sweep.rows] = number
        conditions = {
            name: rounded(column[rows]) for name, column in measurement.conditions.items()
        }
        # Places of a diagnosis and planned frequencies are in Hz, whatever the data are told in.
        per_hertz = 1.0
        if self.axis.column == "frequency":
            per_hertz = measurement.units.on_clock(1.0)
        planes = {
            plane.plane: {"shows": plane.shows, "label": plane.label(measurement.units.stiffness)}
            for plane in PLANES
        }
        return {
            "name": measurement.name,
            "count": len(measurement),
            "planes": planes,
            "thin": self.thin.tolist(),
            "units": {
                "stiffness": measurement.units.stiffness,
                "amplitude": measurement.units.amplitude,
            },
            "axis": {
                "column": self.axis.column,
                "label": self.axis.label,
                "logarithmic": self.axis.logarithmic,
                "per_hertz": per_hertz,
            },
            "words": {
                "symbol": measurement.units.magnitude.strip("|*"),
                "magnitude": measurement.units.magnitude,
                "clock": measurement.units.clock,
                "per_hertz": measurement.units.on_clock(1.0),
            },
            "rows": rows.tolist(),
            "x": rounded(self.axis.values[rows]),
            "omega": rounded(measurement.omega[rows]),
            "storage": rounded(measurement.storage[rows]),
            "loss": rounded(measurement.loss[rows]),
            "conditions": conditions,
            "sweep": sweep_of[rows].tolist(),
            "sweeps": [{"label": sweep.label, "points": len(sweep.rows)} for sweep in self.sweeps],
            "grids": [
                {"x": rounded(x), "omega": rounded(np.broadcast_to(points.omega, x.shape))}
                for x, points in self.grids
            ],
        }

    def curve(self, model: Model, theta: Real, sd: Real | None = None) -> dict[str, Any]:
        """K of a model on the smooth curves, and its residuals in each plane.

        Parameters
        ----------
        model : Model
            The model.
        theta : ndarray, shape (p,)
            Its parameters.
        sd : ndarray, shape (n,), optional
            Standard deviation of K at the drawn points. With it K is told there too, and residuals
            at all of them with the width of their noise; else at the thinned ones.
        """
        rows, width = self.thin, np.zeros(len(self.thin))
        if sd is not None:
            rows, width = np.arange(len(self.rows)), sd
        response = model.network.respond(theta, _rows_of(self.points, rows), FULL)
        measured, drawn = self.measurement.stiffness[self.rows[rows]], {}
        planes = {}
        for plane in PLANES:
            # What is no model at some point, or no loss at all, has no residual there.
            with np.errstate(all="ignore"):
                residual, noise = plane_of(plane, measured, response, width)
            planes[plane.plane] = _parts(residual, OF_RESIDUALS)
            if sd is not None:
                planes[plane.plane]["width"] = rounded(noise, OF_RESIDUALS)
        if sd is not None:
            drawn["points"] = _parts(response.value)
        curves = [_parts(model.stiffness(theta, points)) for _, points in self.grids]
        return {**drawn, "curves": curves, "planes": planes}


def relative_error(measurement: Measurement, model: Model, theta: Real) -> float:
    """Root mean square of |K_model - K| / |K| over all rows, K being what was measured."""
    left = measurement.stiffness - model.stiffness(theta, measurement.points)
    return float(np.sqrt(np.mean(np.abs(left / measurement.stiffness) ** 2)))


def rounded(values: Real, digits: int = DIGITS) -> list[float | None]:
    """Numbers with as many digits as a picture needs; null for what is not finite."""
    values = np.asarray(values, dtype=float)
    finite = np.isfinite(values)
    # Neither zero nor an infinity has a first digit to count from.
    size = np.where(finite & (values != 0.0), np.abs(values), 1.0)
    scale = 10.0 ** (digits - 1 - np.floor(np.log10(size)))
    whole = np.round(np.where(finite, values, 0.0) * scale) / scale
    told: list[float | None] = whole.tolist()
    for i in np.flatnonzero(~finite):
        told[i] = None
    return told


def _parts(values: Complex, digits: int = DIGITS) -> dict[str, Any]:
    return {"storage": rounded(values.real, digits), "loss": rounded(values.imag, digits)}


def _rows_of(points: Points, rows: NDArray[np.int64]) -> Points:
    log_omega = np.broadcast_to(points.log_omega, (points.log_omega.size,))
    return replace(points.mapped(lambda column: column[rows]), log_omega=log_omega[rows])


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


def grown_by_each(case: Case) -> Iterator[Preview]:
    """For each candidate of a diagnosis, the model that has accepted it alone, as far as known."""
    for candidate in case.diagnosis.candidates:
        try:
            grown = case.grown_with(candidate.physics)
        # An effect that does not fit this model or these data has nothing to be drawn.
        except SpringpotError:
            continue
        yield Preview(candidate.effect, *grown)


DRAWABLE = {"omega", "amplitude", "temperature", "repeats"}
"""What an experiment may change for its rivals to be drawn."""
ON_A_RIVAL = 160
"""Points of a rival's curve: as many as the picture has columns of three pixels."""


def drawn(ladder: Ladder, measurement: Measurement) -> dict[str, Any]:
    """The last rung of a ladder as a page shows it.

    Parameters
    ----------
    ladder : Ladder
        The answer.
    measurement : Measurement
        Its data, all rows, those that are left out among them.

    Returns
    -------
    dict
        ``discovery`` (schema ``springpot.discovery/2``); ``parameters`` of the last rung;
        ``noise``: standard deviations of storage and loss at the drawn points; ``reference``: to
        which temperature or amplitude the parameters belong; ``model``: K of the last rung,
        ``{"points", "curves", "planes"}``, each with ``storage`` and ``loss``, at the drawn points,
        on one smooth curve for each sweep, in the order and unit of the data, and as residuals in
        each plane with the ``width`` of their noise; ``previews``: for each candidate curves and
        planes of the model grown by it alone, with its ``error``, ``model`` and whether it was
        ``refitted`` or comes from the scan; ``next``: the rivals at the proposed points.
    """
    scene, case = PageScene(measurement), ladder.steps[-1].case
    base = case.search.base
    used = base.data.raw
    # Once, for previews and rivals alike: each is a model with its parameters.
    grown = list(grown_by_each(case))
    noise = _noise(scene, case)
    return {
        "discovery": ladder.to_dict(),
        "parameters": parameters_of(ladder),
        "noise": _parts(noise),
        "reference": reference_note(used, [base.model.network]),
        "model": scene.curve(base.model, base.theta, np.maximum(noise.real, noise.imag)),
        "previews": {one.effect: _preview(scene, used, one) for one in grown},
        "next": _next(case, {one.effect: one for one in grown}, measurement),
    }


def rungs(ladder: Ladder, measurement: Measurement) -> list[dict[str, Any]]:
    """Each rung of a ladder as `drawn`: every ladder is the beginning of the next, to the bit."""
    answers = []
    for count, step in enumerate(ladder.steps):
        diagnosis = step.case.diagnosis
        part = Ladder(ladder.data, ladder.steps[: count + 1], diagnosis.verdict, diagnosis)
        answers.append(drawn(part, measurement))
    return answers


def parameters_of(ladder: Ladder) -> list[dict[str, Any]]:
    """Parameters of the last rung in printed units, with the ends that a search respects."""
    step = ladder.steps[-1]
    units = step.case.search.base.fit.measurement.units
    rows = []
    for parameter in step.case.search.base.model.parameters:
        value = step.parameters.get(parameter.name)
        # A line of a free spectrum: hundreds of them, none of which anybody would move.
        if value is None:
            continue
        factor, _ = units.of(parameter.unit)
        rows.append(
            {
                "name": parameter.name,
                "symbol": parameter.symbol,
                "unit": value.unit,
                "value": value.value,
                "low": value.low,
                "high": value.high,
                "lower": parameter.lower * factor,
                "upper": parameter.upper * factor,
                "scale": parameter.scale,
            }
        )
    return rows


def _noise(scene: PageScene, case: Case) -> Complex:
    """Standard deviations at the drawn points.

    Those of the fitted point of nearest |K|, as a share of it.
    """
    base = case.search.base
    fitted, drawn = base.fit.measurement.magnitude, scene.measurement.magnitude[scene.rows]
    # Points that are drawn need not be those that were fitted: repeats are fitted as their mean.
    order = np.argsort(fitted)
    nearest = order[np.clip(np.searchsorted(fitted[order], drawn), 0, len(fitted) - 1)]
    share = base.noise.sd[nearest] / fitted[nearest]
    return np.asarray(share * drawn)


def _preview(scene: PageScene, used: Measurement, one: Preview) -> dict[str, Any]:
    # Where a scan begins may be no model at all at some points; they are not drawn.
    with np.errstate(all="ignore"):
        error = relative_error(used, one.model, one.theta)
        curve = scene.curve(one.model, one.theta)
    return {"model": one.model.name, "error": error, "refitted": one.refitted, **curve}


def _next(case: Case, grown: dict[str, Preview], measurement: Measurement) -> dict[str, Any] | None:
    """The proposed experiment, and what the two rivals predict along it.

    None where nothing is proposed.
    """
    proposed = case.diagnosis.next_experiment
    if proposed is None or not proposed.action.get("omega"):
        return None
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


def proposed_points(action: dict[str, list[float]], measurement: Measurement) -> Points:
    """Where a proposed experiment measures.

    Conditions that it leaves open are as they were on the median.
    """
    omega = np.asarray(action["omega"], dtype=float)
    points = measurement.points

    def level(name: str, column: Real | None) -> Real | None:
        # The model was never told it.
        if column is None:
            return None
        if not action.get(name):
            return np.full(omega.shape, float(np.median(column)))
        given = np.resize(np.asarray(action[name], dtype=float), omega.shape)
        if name == "temperature":
            given = given + KELVIN
        return given

    columns = {name: level(name, column) for name, column in points.columns.items()}
    return replace(
        points,
        log_omega=np.log(omega),
        amplitude=level("amplitude", points.amplitude),
        temperature=level("temperature", points.temperature),
        columns={name: column for name, column in columns.items() if column is not None},
    )


def _band(model: Model, theta: Real, points: Points, floor: float) -> dict[str, Any]:
    stiffness = model.stiffness(theta, points)
    # 95 % of what would be measured.
    width = 2.0 * floor * np.abs(stiffness)
    return {
        "storage": rounded(stiffness.real),
        "loss": rounded(stiffness.imag),
        "width": rounded(width),
    }
