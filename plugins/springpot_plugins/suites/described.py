"""A suite as a table of models, true parameters and tests; its data are computed from them."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from importlib.resources import files
from io import StringIO
from itertools import product
from typing import Any

import numpy as np

import springpot
from springpot.measurement import (
    DataSet,
    Loading,
    Measured,
    Measurement,
    TimeTest,
    Units,
    with_noise,
)
from springpot.rheology import Real
from springpot.timetests import Test, answered, as_had_by

CONDITIONS = ("amplitude", "temperature", "specimen")
NAMES = dict(zip(CONDITIONS, ("amplitudes", "temperatures", "specimens"), strict=True))
UNIT, LENGTH, FORCE = "kN/m", "mm", "N"
OBJECTIVE = "relative"


@cache
def loaded(suite: str) -> tuple[DataSet, ...]:
    """The problems of a suite, none of them computed yet."""
    told = tomllib.loads(_text(f"{suite}.toml"))
    best = {name: row.get("best") for name, row in _rows(suite).items()}
    return tuple(
        _problem(f"{suite}/{each['name']}", each, told["protocol"], best)
        for each in told["problem"]
    )


def measured(suite: str) -> Mapping[str, Measured]:
    """What was measured of its problems: the table that ``studies/suite.py`` wrote."""
    found = {}
    for name, row in _rows(suite).items():
        features = {key: float(value) for key, value in row.items() if key not in ("best", "part")}
        found[name] = Measured(row["part"], features)
    return found


def _rows(suite: str) -> dict[str, dict[str, str]]:
    rows = list(csv.DictReader(StringIO(_text(f"{suite}.csv"))))
    return {row.pop("problem"): row for row in rows}


def _text(name: str) -> str:
    # By the package, which may be installed as a zip file.
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _problem(
    name: str,
    told: Mapping[str, Any],
    protocols: Mapping[str, Any],
    best: Mapping[str, str | None],
) -> DataSet:
    least = best.get(name)
    common: dict[str, Any] = {
        "objective": told.get("objective", OBJECTIVE),
        "best": float(least) if least else None,
    }
    if "data" in told:
        return _of_known(name, told, common)
    tests = [protocols[each] for each in told["tests"]]
    truth, noise = dict(told["truth"]), float(told.get("noise", 0.0))
    return DataSet(
        name,
        told["says"],
        partial(computed, name, told["model"], tests, truth, noise),
        kind="artificial",
        licence="none needed",
        citation="computed here",
        truth=truth,
        model=told["model"],
        test=f"{' and '.join(_words(each) for each in tests)}; "
        + (f"noise of {100 * noise:g} %" if noise else "no noise"),
        stiffness_scale=told.get("scale"),
        **common,
    )


def _words(protocol: Mapping[str, Any]) -> str:
    kind = protocol["kind"]
    if kind == "record":
        return "record of {samples} samples in {seconds:g} s, up to {amplitude:g} mm".format(
            **protocol
        )
    low, high, count = protocol["hertz"] if kind == "sweep" else protocol["seconds"]
    told = f"{kind} at {count} {'frequencies' if kind == 'sweep' else 'times'}"
    told += f" from {low:g} to {high:g} {'Hz' if kind == 'sweep' else 's'}"
    for name in CONDITIONS:
        if name in protocol:
            told += f" and {len(protocol[name])} {NAMES[name]}"
    return told


def _of_known(name: str, told: Mapping[str, Any], common: Mapping[str, Any]) -> DataSet:
    """A problem on a data set that is registered anyway."""
    known: DataSet = springpot.plugins().find("data set", told["data"].partition("@")[0])
    model, truth = told.get("model", known.model), dict[str, float]()
    if model == known.model:
        truth = dict(known.truth)
    return DataSet(
        name,
        told["says"],
        lambda: springpot.open_measurement(told["data"]),
        kind=known.kind,
        licence=known.licence,
        citation=known.citation,
        doi=known.doi,
        truth=truth,
        model=model,
        test=f"data set {told['data']}",
        stiffness_scale=known.stiffness_scale,
        **common,
    )


def computed(
    name: str,
    expression: str,
    protocols: Sequence[Mapping[str, Any]],
    truth: Mapping[str, float],
    noise: float,
) -> tuple[Test, ...]:
    """Tests as a model says them, with noise that hangs on the problem's name alone."""
    plans = [planned(protocol) for protocol in protocols]
    model = as_had_by(springpot.parse_model(expression), plans)
    exact = answered(model, model.vector(dict(truth)), plans)
    if not noise:
        return exact
    rng = np.random.default_rng(list(name.encode()))
    return tuple(_noisy(test, noise, rng) for test in exact)


def planned(protocol: Mapping[str, Any]) -> Test:
    """A test that nothing has answered yet."""
    kind = protocol["kind"]
    if kind == "sweep":
        return _sweep(protocol)
    if kind == "record":
        clock = np.linspace(0.0, protocol["seconds"], protocol["samples"])
        moved = _course(clock / protocol["seconds"]) * protocol["amplitude"]
        # Straight between its samples, so that the numbers of the suite are whatever a motion is.
        loading = Loading(clock, moved)
        return TimeTest(
            clock, np.zeros_like(clock), loading, "displacement", LENGTH, FORCE, name=kind
        )
    low, high, count = protocol["seconds"]
    clock = np.geomspace(low, high, count)
    control = {"relaxation": "displacement", "creep": "force"}[kind]
    return TimeTest(clock, np.zeros(count), Loading.step(1.0), control, LENGTH, FORCE, name=kind)


def _course(share: Real) -> Real:
    """A growing sine of four cycles, then two as large of half the frequency."""
    early = share < 0.5
    grown = np.where(early, 0.25 + 1.5 * share, 1.0)
    phase = np.where(early, 8.0 * share, 4.0 + 4.0 * (share - 0.5))
    return np.asarray(grown * np.sin(2.0 * np.pi * phase), dtype=float)


def _sweep(protocol: Mapping[str, Any]) -> Measurement:
    low, high, count = protocol["hertz"]
    columns = {name: protocol[name] for name in CONDITIONS if name in protocol}
    rows = np.array(list(product(*columns.values(), np.geomspace(low, high, count))))
    conditions = {name: rows[:, i] for i, name in enumerate(columns)}
    return Measurement(
        2.0 * np.pi * rows[:, -1],
        np.ones(len(rows), dtype=complex),
        conditions=conditions,
        units=Units(UNIT, LENGTH),
        name="sweep",
    )


def _noisy(test: Test, level: float, rng: np.random.Generator) -> Test:
    """Of a sweep by eq. (53); of steps a share of each sample, of a record one of them all."""
    if isinstance(test, Measurement):
        return with_noise(test, level, rng, symmetric=True)
    assert isinstance(test, TimeTest)
    size = np.abs(test.response)
    if not test.after_step:
        size = np.full(len(size), float(np.sqrt(np.mean(size**2))))
    return replace(test, response=test.response + level * size * rng.normal(size=len(size)))
