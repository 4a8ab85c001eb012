"""Carry out the experiment that a diagnosis suggests, on a case whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hidden_effects.bases import Real, Sweep
from hidden_effects.cases import Case
from hidden_effects.setup import deviation


def remeasure(case: Case, action: dict[str, Any]) -> Case | None:
    """Return the case with the suggested rows added, or None where that cannot be simulated.

    ``action`` may hold ``omega`` [rad/s], ``temperature`` [degC] and ``amplitude`` [as in the
    data], each a list of values to measure at (what is missing stays as in the data), and
    ``repeats``, how often.
    """
    usable = {"omega", "temperature", "amplitude", "repeats"}
    if case.outside or not action or not set(action) <= usable:
        return None
    if ("temperature" in action and case.temperature is None) or (
        "amplitude" in action and case.amplitude is None
    ):
        return None
    rng = np.random.default_rng([13, case.seed])
    more = _new_rows(case.sweep, action)
    k = case.network.stiffness(more, case.theta)
    sigma = deviation(case.noise, more, k)
    seen = k + sigma * (rng.standard_normal(len(more)) + 1j * rng.standard_normal(len(more)))
    return replace(
        case,
        sweep=_join(case.sweep, more),
        K=np.concatenate([case.K, seen]),
        K_true=np.concatenate([case.K_true, k]),
        sigma=np.concatenate([case.sigma, sigma]),
        sd=None if case.sd is None else np.concatenate([case.sd, sigma]),
    )


def _new_rows(old: Sweep, action: dict[str, Any]) -> Sweep:
    """Return every combination of the asked values, and of measured ones where none is asked."""

    def values(name: str, column: Real | None) -> Real:
        if name in action:
            return np.atleast_1d(np.asarray(action[name], dtype=float))
        return np.unique(column) if column is not None else np.zeros(1)

    repeats = np.arange(int(np.max(action.get("repeats", 1))))
    axes = (values("temperature", old.temperature), values("amplitude", old.amplitude), repeats)
    t, x, n, w = (g.ravel() for g in np.meshgrid(*axes, values("omega", old.omega), indexing="ij"))
    first = 1 if old.repeat is None else int(old.repeat.max())
    again = "repeats" in action or old.repeat is not None
    new = np.ones(len(w), dtype=bool) if again else ~_measured(old, w, t, x)
    return Sweep(
        w[new],
        t[new] if old.temperature is not None else None,
        x[new] if old.amplitude is not None else None,
        n[new].astype(int) + first + again,
    )


def _measured(old: Sweep, w: Real, t: Real, x: Real) -> np.ndarray:
    """Whether rows stand in the data already, to the digits with which these are written."""
    same = np.abs(np.log(w[:, None] / old.omega)) < 1e-6
    for new, column in ((t, old.temperature), (x, old.amplitude)):
        if column is not None:
            same &= np.abs(new[:, None] - column) < 1e-6 * np.maximum(np.abs(column), 1e-12)
    return np.asarray(same.any(axis=1))


def _join(a: Sweep, b: Sweep) -> Sweep:
    """Put the rows of ``b`` after those of ``a``."""

    def both(first: Real | None, second: Real | None) -> Real | None:
        return None if first is None or second is None else np.concatenate([first, second])

    repeat = np.ones(len(a), dtype=int) if a.repeat is None else a.repeat
    return Sweep(
        np.concatenate([a.omega, b.omega]),
        both(a.temperature, b.temperature),
        both(a.amplitude, b.amplitude),
        both(repeat, b.repeat),
    )
