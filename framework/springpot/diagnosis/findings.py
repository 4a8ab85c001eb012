"""Tests on the residual of one fit: what each looks for, how sure it is, and a plain sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, norm, t

from springpot.rheology import Real

from .frame import Frame
from .noise import Source, trimmed
from .sweeps import sweeps_of
from .words import times

ALARM = 0.05
"""Chance that any of the tests on a fit without fault gives an alarm."""
FEWEST = 6
"""Points that a sweep needs for signs and neighbours to say anything."""
MAINS = (50.0, 60.0)
MAINS_FACTORS = (1.0 / 3.0, 0.5, 1.0, 2.0, 3.0)
"""Multiples at which hum lands: harmonics of the mains, and tests one of whose own harmonics is the mains."""
NEAR_MAINS = 0.015
PARTS: tuple[Literal["storage", "loss"], ...] = ("storage", "loss")


@dataclass(frozen=True)
class Finding:
    """The outcome of one test.

    Attributes
    ----------
    test : str
        What was looked for.
    statistic : float
        In the units named by the sentence.
    p_value : float
        Chance that noise alone goes at least as far.
    found : bool
        Whether this is rarer than the tests together may be by chance.
    says : str
        One plain sentence.
    """

    test: str
    statistic: float
    p_value: float
    found: bool
    says: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)


def findings(frame: Frame, source: Source) -> list[Finding]:
    """All tests on a fit, those that found something first.

    Parameters
    ----------
    frame : Frame
        The fit.
    source : {"given", "repeats", "estimated"}
        Where its noise comes from.
    """
    tests: tuple[Callable[[Frame], Iterator[Finding]], ...] = (_parts, _runs, _neighbours, _trends, _outliers)
    found = [finding for test in (lambda fit: _lack_of_fit(fit, source), *tests) for finding in test(frame)]
    return judged(found)


def judged(found: list[Finding]) -> list[Finding]:
    """Findings held against the number of tests made (Bonferroni), the surest first."""
    kept = [replace(one, found=one.p_value * len(found) < ALARM) for one in found]
    return sorted(kept, key=lambda one: (not one.found, one.p_value))


def tail(value: float, dof: float, scale_dof: float) -> float:
    """Chance of at least `value` for a sum of `dof` squares of unit noise, whose unit may itself be estimated."""
    if scale_dof == inf:
        return float(chi2.sf(value, dof))
    return float(f.sf(value / dof, dof, max(scale_dof, 1.0)))


def _lack_of_fit(frame: Frame, source: Source) -> Iterator[Finding]:
    """Known noise against all of the residual; estimated noise only against its slow part."""
    free = frame.size - frame.absorbed.shape[1]
    if source == "estimated":
        slow, rough = frame.smooth.shape[1], frame.rough_dof
        if slow == 0 or rough < 1:
            return
        value = float(np.sum((frame.smooth.T @ frame.rest) ** 2))
        scatter = float(frame.rough @ frame.rough) / rough
        ratio = value / slow / max(scatter, 1e-300)
        words = f"slow structure in the residual is {times(np.sqrt(ratio))} what point-to-point scatter leaves"
        yield Finding("lack of fit", ratio, float(f.sf(ratio, slow, rough)), False, words)
        return
    value = float(frame.rest @ frame.rest)
    words = (
        f"the residual is {times(np.sqrt(value / free))} what the noise leaves "
        f"(chi-square {value:.4g} on {free} degrees of freedom)"
    )
    yield Finding("lack of fit", value, tail(value, free, frame.scale_dof), False, words)


def _parts(frame: Frame) -> Iterator[Finding]:
    """Real and imaginary part by themselves."""
    n = len(frame.measurement)
    taken = np.sum(frame.absorbed**2, axis=1)
    for k, word in enumerate(PARTS):
        rows = slice(k * n, (k + 1) * n)
        free = max(float(n - np.sum(taken[rows])), 1.0)
        value = float(np.sum(frame.rest[rows] ** 2))
        ratio = float(np.sqrt(value / free))
        words = f"{word} alone is {times(ratio)} what its noise leaves"
        yield Finding(f"{word} alone", ratio, tail(value, free, frame.scale_dof), False, words)


def _orders(frame: Frame) -> list[NDArray[np.int64]]:
    """Rows of each sweep that is long enough, along frequency."""
    return [sweep.rows for sweep in sweeps_of(frame.measurement) if len(sweep.rows) >= FEWEST]


def _runs(frame: Frame) -> Iterator[Finding]:
    """Too few changes of sign along frequency (Wald and Wolfowitz 1940, doi:10.1214/aoms/1177731909)."""
    n = len(frame.measurement)
    orders = _orders(frame)
    for k, word in enumerate(PARTS):
        counts = np.array([_run_count(frame.rest[rows + k * n] > 0) for rows in orders]).reshape(-1, 3)
        seen, expected, variance = counts.sum(axis=0)
        if variance <= 0:
            continue
        chance = float(norm.cdf((seen - expected + 0.5) / np.sqrt(variance)))
        words = (
            f"the {word} residual changes side in {seen:.0f} runs along frequency where noise would in {expected:.0f}"
        )
        yield Finding(f"runs, {word}", float(seen), chance, False, words + _guilty(counts))


def _run_count(positive: NDArray[np.bool_]) -> tuple[float, float, float]:
    """Runs of one sweep: seen, expected, variance."""
    n, plus = len(positive), int(np.sum(positive))
    both = 2.0 * plus * (n - plus)
    seen = 1.0 + float(np.sum(positive[1:] != positive[:-1]))
    # All on one side: expected as if the sides were even, or the clearest misfit of all would not count.
    both = both or 0.5 * n * n
    return seen, both / n + 1.0, both * (both - n) / (n * n * (n - 1.0))


def _guilty(counts: Real) -> str:
    """In how many of several sweeps the runs are too few."""
    if len(counts) < 2:
        return ""
    z = (counts[:, 0] - counts[:, 1] + 0.5) / np.sqrt(np.maximum(counts[:, 2], 1e-9))
    return f" (too few in {np.sum(z < norm.ppf(0.05))} of {len(counts)} sweeps)"


def _neighbours(frame: Frame) -> Iterator[Finding]:
    """Correlation of neighbours along frequency, with the moments that the fit leaves it (Durbin and Watson 1950)."""
    n = len(frame.measurement)
    orders = _orders(frame)
    for k, word in enumerate(PARTS):
        pairs = [(rows[:-1] + k * n, rows[1:] + k * n) for rows in orders]
        if not pairs:
            return
        first, second = (np.concatenate(side) for side in zip(*pairs, strict=True))
        mean, deviation = _moments(frame.absorbed, first, second)
        rest = frame.rest
        scale = float(np.mean(rest[k * n : (k + 1) * n] ** 2)) or 1.0
        value = float(np.sum(rest[first] * rest[second])) / scale
        chance = float(norm.sf((value - mean) / deviation)) if deviation > 0 else 1.0
        # By the size of the very points that are paired (Cauchy and Schwarz): within -1 and 1.
        size = float(np.linalg.norm(rest[first]) * np.linalg.norm(rest[second])) or 1.0
        correlation = float(np.clip(np.sum(rest[first] * rest[second]) / size, -1.0, 1.0))
        words = f"neighbouring {word} residuals correlate by {correlation:.2f}, noise by {mean / len(first):.2f}"
        yield Finding(f"autocorrelation, {word}", correlation, chance, False, words)


def _moments(absorbed: Real, first: NDArray[np.int64], second: NDArray[np.int64]) -> tuple[float, float]:
    """Mean and deviation of the sum of products of neighbours in projected unit noise."""
    linked = np.zeros_like(absorbed)
    np.add.at(linked, first, 0.5 * absorbed[second])
    np.add.at(linked, second, 0.5 * absorbed[first])
    inner = absorbed.T @ linked
    squares = 0.5 * len(first) - 2.0 * float(np.sum(linked**2)) + float(np.sum(inner**2))
    return -float(np.trace(inner)), float(np.sqrt(max(2.0 * squares, 0.0)))


def _trends(frame: Frame) -> Iterator[Finding]:
    """A drift of size or phase of K with amplitude or temperature that the model does not follow."""
    data = frame.measurement
    off = np.log(data.stiffness / frame.model_stiffness)
    for name in ("amplitude", "temperature"):
        column = data.conditions.get(name)
        if column is None or np.ptp(column) < 1e-3 * np.max(np.abs(column)):
            continue
        x = np.log(column) if name == "amplitude" and np.all(column > 0) else column
        x = (x - np.mean(x)) / np.ptp(x)
        lines = frame.whiten(np.array([x, 1j * x]) * frame.model_stiffness).T
        basis = frame.beyond(lines, 1e-3)
        value = float(np.sum((basis.T @ frame.rest) ** 2))
        size, phase = ((off.real @ x) / (x @ x), np.degrees((off.imag @ x) / (x @ x)))
        words = (
            f"from the lowest to the highest {name} the measured |K| {'gains' if size > 0 else 'loses'} "
            f"{100 * abs(np.expm1(size)):.2g} % and its phase {phase:+.2g} deg against the model"
        )
        yield Finding(f"trend with {name}", value, tail(value, max(basis.shape[1], 1), frame.scale_dof), False, words)


def _outliers(frame: Frame) -> Iterator[Finding]:
    """Single points far from the slow course of the residual, and those at multiples of the mains frequency."""
    if frame.rough_dof < 10:
        return
    n = len(frame.measurement)
    left = 1.0 - np.sum(frame.absorbed**2, axis=1) - np.sum(frame.structured**2, axis=1)
    scale = np.sqrt(np.maximum(left, 0.05) * trimmed(frame).variance)
    size = np.abs(frame.rough) / scale
    each = 2.0 * t.sf(size, frame.rough_dof)
    chance = float(min(1.0, np.min(each) * frame.size))
    rows = np.unique(np.flatnonzero(each * frame.size < ALARM / 10) % n)
    yield Finding("outliers", float(np.max(size)), chance, False, _points(frame, rows))
    yield from _hum(frame)


def _hum(frame: Frame) -> Iterator[Finding]:
    """Whether points at multiples of the mains frequency stand off from their neighbours more than others do."""
    n = len(frame.measurement)
    frequency, rest = frame.measurement.frequency, frame.rest
    middles = [(rows[:-2], rows[1:-1], rows[2:]) for rows in _orders(frame)]
    if not middles:
        return
    before, here, after = (np.concatenate(side) for side in zip(*middles, strict=True))
    off = np.concatenate([rest[here + k] - 0.5 * (rest[before + k] + rest[after + k]) for k in (0, n)])
    near = np.tile(_near_mains(frequency[here]), 2)
    count, others = int(np.sum(near)), int(np.sum(~near))
    if count == 0 or others < 10:
        return
    ratio = float(np.mean(off[near] ** 2)) / max(float(np.mean(off[~near] ** 2)), 1e-300)
    places = ", ".join(sorted({f"{x:.3g}" for x in frequency[here][near[: len(here)]]}, key=float)[:4])
    words = f"at multiples of the mains ({places} Hz) points stand off {times(np.sqrt(ratio))} as far as others"
    yield Finding("mains frequency", ratio, float(f.sf(ratio, count, others)), False, words)


def _near_mains(frequency: Real) -> NDArray[np.bool_]:
    lines = np.outer(MAINS, MAINS_FACTORS).ravel()
    near: NDArray[np.bool_] = np.any(np.abs(frequency[:, None] / lines - 1.0) < NEAR_MAINS, axis=1)
    return near


def _points(frame: Frame, rows: NDArray[np.int64]) -> str:
    if len(rows) == 0:
        return "no single point stands out"
    hertz = [f"{x:.3g} Hz" for x in frame.measurement.frequency[rows][:3]]
    hum = " (a multiple of the mains frequency)" if np.all(_near_mains(frame.measurement.frequency[rows])) else ""
    more = "" if len(rows) <= 3 else f" and {len(rows) - 3} more"
    return (
        f"{'a single point stands' if len(rows) == 1 else 'single points stand'} out at {', '.join(hertz)}{more}{hum}"
    )
