"""The answer to a state: exactly what ``springpot discover DATA --accept ...`` gives, and what is drawn of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from springpot.api import discover
from springpot.diagnosis import Case, Ladder
from springpot.diagnosis.progress import silent
from springpot.measurement import Measurement
from springpot.report.reference import reference_note
from springpot.rheology import Model, Points, Real

from .datatext import kept
from .previews import Grown, grown_by_each
from .scene import Scene, relative_error, rounded
from .state import State

SCHEMA = "springpot.workbench/1"
DRAWABLE = {"omega", "amplitude", "temperature", "repeats"}
"""What an experiment may change for its rivals to be drawn."""
Told = Callable[[str], None]


def ladder_of(state: State, measurement: Measurement, told: Told = silent) -> Ladder:
    """The ladder of a state; the same bits for the same state and data."""
    used = kept(measurement, state.excluded)
    return discover(used, state.model or None, accept=list(state.accepted), seed=state.seed, progress=told)


def answer(state: State, measurement: Measurement, told: Told) -> dict[str, Any]:
    """Schema ``springpot.workbench/1``: the discovery, and K of the model and of every candidate.

    Parameters
    ----------
    state : State
        What is asked.
    measurement : Measurement
        The data, all rows.
    told : callable
        Told in a few words what is being done.

    Returns
    -------
    dict
        ``state``; ``discovery`` (schema ``springpot.discovery/1``); ``parameters`` of the last rung;
        ``noise``: standard deviations of storage and loss at the drawn points;
        ``model``: K of the last rung, ``{"points", "curves", "slope"}``, each with ``storage`` and ``loss``, at the
        drawn points and on one smooth curve for each sweep, in the order and unit of the data;
        ``previews``: for each candidate the same for the model grown by it alone, with its ``error``, ``model`` and
        whether it was ``refitted`` or comes from the scan; ``next``: the rivals at the proposed points.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.
    """
    ladder = ladder_of(state, measurement, told)
    told("drawing what each effect would change")
    return drawn(state, ladder, measurement)


def drawn(state: State, ladder: Ladder, measurement: Measurement) -> dict[str, Any]:
    """The answer to a state whose ladder is known; see `answer`."""
    scene, case = Scene(measurement), ladder.steps[-1].case
    base = case.search.base
    used = base.data.raw
    grown = list(grown_by_each(case))
    return {
        "schema": SCHEMA,
        "state": state.to_dict(),
        "key": state.key,
        "discovery": ladder.to_dict(),
        "parameters": parameters_of(ladder),
        "noise": _noise(scene, case),
        "reference": reference_note(used, [base.model.network], "°C"),
        "model": scene.curve(base.model, base.theta, slope=True),
        "previews": {one.effect: _preview(scene, used, one) for one in grown},
        "next": _next(case, {one.effect: one for one in grown}, measurement),
    }


def rungs(state: State, ladder: Ladder, measurement: Measurement) -> list[dict[str, Any]]:
    """The answers to all states on the way: each ladder is the beginning of the next, to the bit."""
    answers = []
    for count, step in enumerate(ladder.steps):
        at = State(state.data, state.model, state.accepted[:count], state.excluded, state.seed)
        diagnosis = step.case.diagnosis
        part = Ladder(ladder.data, ladder.steps[: count + 1], diagnosis.verdict, diagnosis)
        answers.append(drawn(at, part, measurement))
    return answers


def parameters_of(ladder: Ladder) -> list[dict[str, Any]]:
    """Parameters of the last rung in printed units, with the ends that a search respects."""
    step = ladder.steps[-1]
    units = step.case.search.base.fit.measurement.units
    rows = []
    for parameter in step.case.search.base.model.parameters:
        value = step.parameters.get(parameter.name)
        if value is None:  # a line of a free spectrum: hundreds of them, none of which anybody would move
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


def _noise(scene: Scene, case: Case) -> dict[str, Any]:
    """Standard deviations at the drawn points: those of the fitted point of nearest |K|, as a share of it."""
    base = case.search.base
    fitted, drawn = base.fit.measurement.magnitude, scene.measurement.magnitude[scene.rows]
    order = np.argsort(fitted)
    nearest = order[np.clip(np.searchsorted(fitted[order], drawn), 0, len(fitted) - 1)]
    share = base.noise.sd[nearest] / fitted[nearest]
    return {"storage": rounded(share.real * drawn), "loss": rounded(share.imag * drawn)}


def _preview(scene: Scene, used: Measurement, one: Grown) -> dict[str, Any]:
    with np.errstate(all="ignore"):  # where a scan begins may be no model at all at some points; they are not drawn
        error = relative_error(used, one.model, one.theta)
        curve = scene.curve(one.model, one.theta)
    return {"model": one.model.name, "error": error, "refitted": one.refitted, **curve}


def _next(case: Case, grown: dict[str, Grown], measurement: Measurement) -> dict[str, Any] | None:
    """The proposed points, and what the two rivals predict there; None where nothing is proposed."""
    proposed = case.diagnosis.next_experiment
    if proposed is None or not proposed.action.get("omega"):
        return None
    points = proposed_points(proposed.action, measurement)
    floor = case.diagnosis.error.noise_floor
    rivals = []
    for name in proposed.separates:
        # Of another specimen or a known mass the rivals would have to be computed anew.
        if name in grown and set(proposed.action) <= DRAWABLE:
            rivals.append({"effect": name, **_band(grown[name].model, grown[name].theta, points, floor)})
    told = {key: list(values) for key, values in proposed.action.items()}
    return {"action": told, "frequency": rounded(points.omega / (2 * np.pi)), "rivals": rivals}


def proposed_points(action: dict[str, list[float]], measurement: Measurement) -> Points:
    """Where a proposed experiment measures; conditions that it leaves open are as they were on the median."""
    omega = np.asarray(action["omega"], dtype=float)
    points = measurement.points

    def level(name: str, column: Real) -> Real:
        given = action.get(name)
        if given:
            return np.resize(np.asarray(given, dtype=float), omega.shape) + (273.15 if name == "temperature" else 0.0)
        return np.full(omega.shape, float(np.median(column)))

    return replace(
        points,
        log_omega=np.log(omega),
        amplitude=None if points.amplitude is None else level("amplitude", points.amplitude),
        temperature=None if points.temperature is None else level("temperature", points.temperature),
        columns={name: level(name, column) for name, column in points.columns.items()},
    )


def _band(model: Model, theta: Real, points: Points, floor: float) -> dict[str, Any]:
    stiffness = model.stiffness(theta, points)
    width = 2.0 * floor * np.abs(stiffness)  # 95 % of what would be measured
    return {"storage": rounded(stiffness.real), "loss": rounded(stiffness.imag), "width": rounded(width)}
