"""Master curves of made series whose factors are exact: how far off, and how often intervals hold.

    python studies/master_curve_coverage.py [--series 40] [--seed 25] [--out results/master_curves]

Question: how often do the intervals of shift factors hold the truth, and how far off is the worst
level of a long series? Measure: the share of the 95 % intervals that hold exact factors, and the
difference of log10 a at the worst of 21 temperatures. What would answer it: 95 % of the intervals,
as far as so many series can tell, and each level within 0.3 decades.

Short series of a few temperatures tell how often the 95 % intervals hold the truth. Series of 21
temperatures, as a laboratory measures them on a polymer from glass to rubber (sweeps, and
relaxations), tell how far each tool is off at its worst level. Beside springpot stands the way of
NREL's pyvisco, written anew after its documentation (each sweep is laid over its neighbour by power
laws fitted where their moduli overlap), and the PyPI package `mastercurves` where it is installed.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from time import process_time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

import springpot
from paper.asking import asking
from springpot import Measurement, TimeTest
from springpot.benchmark import Interval, Table, save_table
from springpot.rheology import Continuum, Points
from springpot.rheology.elements import Relaxation

ROOT = Path(__file__).resolve().parent.parent
LN10 = float(np.log(10.0))
KELVIN = 273.15
GAS_CONSTANT = 8.31446261815324e-3
DRAWS = 2000
"""Of series, with which the interval of a share is found."""

Reals = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Series:
    """Data with their exact factors.

    Attributes
    ----------
    data : Measurement or list of TimeTest
        What was measured.
    log_a, log_b : ndarray, shape (m,)
        Exact factors of frequency and of stiffness.
    constants : mapping
        Exact constants of its law, at the level of reference.
    """

    data: Measurement | list[TimeTest]
    log_a: Reals
    log_b: Reals
    constants: dict[str, float]


def curved(noise: float, decades: float, rng: np.random.Generator) -> Series:
    """Five temperatures of a fractional Zener model; b goes with the temperature."""
    celsius = np.array([0.0, 15.0, 30.0, 45.0, 60.0])
    log_a = -LN10 * 8.0 * (celsius - 30.0) / (120.0 + celsius - 30.0)
    log_b = np.log((celsius + KELVIN) / 303.15)
    return _zener(celsius, log_a, log_b, noise, decades, {"C1": 8.0, "C2": 120.0}, rng)


def of_law(law: str, rng: np.random.Generator) -> Series:
    """Five temperatures without a vertical factor, 1 % of noise."""
    celsius = np.array([0.0, 15.0, 30.0, 45.0, 60.0])
    if law == "WLF":
        return curved_of(celsius, {"C1": 8.0, "C2": 120.0}, rng)
    log_a = 100.0 / GAS_CONSTANT * (1.0 / (celsius + KELVIN) - 1.0 / 303.15)
    return _zener(celsius, log_a, np.zeros(5), 0.01, 2.0, {"Ea": 100.0}, rng)


def curved_of(celsius: Reals, constants: dict[str, float], rng: np.random.Generator) -> Series:
    """Sweeps of these constants of WLF."""
    away = celsius - 30.0
    log_a = -LN10 * constants["C1"] * away / (constants["C2"] + away)
    return _zener(celsius, log_a, np.zeros(len(celsius)), 0.01, 2.0, constants, rng)


def _zener(
    celsius: Reals,
    log_a: Reals,
    log_b: Reals,
    noise: float,
    decades: float,
    constants: dict[str, float],
    rng: np.random.Generator,
) -> Series:
    model, theta = springpot.parse_model("fractional-zener"), np.array([1.0, 30.0, 2.0, 0.6])
    omega = np.geomspace(10.0 ** (-decades / 2.0), 10.0 ** (decades / 2.0), 13)
    parts = [
        np.exp(b) * model.stiffness(theta, omega * np.exp(a))
        for a, b in zip(log_a, log_b, strict=True)
    ]
    return Series(_sweeps(celsius, omega, parts, noise, rng), log_a, log_b, constants)


def power_law(power: float, rng: np.random.Generator) -> Series:
    """Four temperatures of a springpot, which leaves a and b open; b a power of temperature."""
    celsius, omega = np.linspace(0.0, 60.0, 4), np.geomspace(0.1, 10.0, 8)
    kelvin = celsius + KELVIN
    log_a = 8000.0 * (1.0 / kelvin - 1.0 / 293.15)
    log_b = power * np.log(kelvin / 293.15)
    parts = [
        1e3 * np.exp(b) * (1j * omega * np.exp(a)) ** 0.4 for a, b in zip(log_a, log_b, strict=True)
    ]
    return Series(_sweeps(celsius, omega, parts, 0.003, rng), log_a, log_b, {})


def _sweeps(
    celsius: Reals, omega: Reals, parts: list[Reals], noise: float, rng: np.random.Generator
) -> Measurement:
    stiffness = np.concatenate(parts)
    error = rng.normal(size=len(stiffness)) + 1j * rng.normal(size=len(stiffness))
    return Measurement(
        np.tile(omega, len(celsius)),
        stiffness * (1.0 + noise * error),
        conditions={"temperature": np.repeat(celsius, len(omega))},
        name="made",
    )


LAB = np.linspace(-50.0, 100.0, 21)
"""Temperatures of a laboratory's series, 7.5 K apart."""
SCATTER = 0.002
"""Noise of each point of theirs, as one specimen that stays in its clamps shows it."""


def _polymer() -> tuple[Reals, Reals]:
    """Rates and weights in MPa of a polymer at 25 degC: a broad glass, and a transition."""
    log_tau = np.arange(-15.0, 12.0, 1.0 / 3.0)
    transition = np.exp(-0.5 * ((log_tau - 3.5) / 2.0) ** 2)
    weights = 4000.0 * transition / transition.sum()
    weights[log_tau < 1.0] += 4500.0 / np.sum(log_tau < 1.0)
    return 10.0 ** -log_tau[::-1], weights[::-1]


def laboratory(relaxing: bool, rng: np.random.Generator) -> Series:
    """21 temperatures from glass to rubber: Arrhenius below 10 degC, WLF above, each level off."""
    rates, weights = _polymer()
    theta = np.concatenate([[250.0, 0.0], weights])
    away = LAB - 25.0
    log_a = -LN10 * 13.0 * away / np.maximum(90.0 + away, 1.0)
    kelvin, knee = LAB + KELVIN, 283.15
    at_knee = LN10 * 13.0 * 15.0 / 75.0
    glass = at_knee + 180.0 / GAS_CONSTANT * (1.0 / kelvin - 1.0 / knee)
    log_a = np.where(kelvin < knee, glass, log_a) + 0.05 * LN10 * rng.normal(size=21)
    log_b = np.zeros(21)
    if not relaxing:
        omega = 2.0 * np.pi * np.geomspace(0.1, 100.0, 10)
        material = Continuum(tuple(rates.tolist()))
        parts = [
            np.exp(b) * material.respond(theta, Points(np.log(omega) + a)).value
            for a, b in zip(log_a, log_b, strict=True)
        ]
        return Series(_sweeps(LAB, omega, parts, SCATTER, rng), log_a, log_b, {})
    relaxation, time = Relaxation(tuple(rates.tolist())), np.geomspace(0.01, 10.0, 10)
    tests = []
    for celsius, a, b in zip(LAB, log_a, log_b, strict=True):
        modulus = np.exp(b) * relaxation.respond(theta, Points(a - np.log(time))).value.real
        modulus = modulus * (1.0 + SCATTER * rng.normal(size=len(time)))
        tests.append(TimeTest.of_relaxation(time, modulus, unit="MPa", temperature=float(celsius)))
    return Series(tests, log_a, log_b, {})


@dataclass(frozen=True, eq=False)
class Found:
    """Factors of a tool at all levels, beside the truth.

    Attributes
    ----------
    off : ndarray, shape (m,)
        Difference of ln a, the level of reference left out.
    held_a, held_b : ndarray of bool
        Whether the interval holds the truth; of b at levels that the data tell.
    determined : int
        Levels whose factor is determined.
    constants : mapping
        Whether the interval of a law's constant holds it.
    seconds : float
        Processor time.
    """

    off: Reals
    held_a: NDArray[np.bool_]
    held_b: NDArray[np.bool_]
    determined: int
    constants: dict[str, bool]
    seconds: float


def ours(series: Series, vertical: bool = True) -> Found:
    """What springpot says."""
    began = process_time()
    curve = springpot.mastercurve(series.data, reference=_reference(series), vertical=vertical)
    seconds = process_time() - began
    at = curve.factors.reference
    levels = [level for i, level in enumerate(curve.levels) if i != at]
    a, b = (np.delete(each - each[at], at) for each in (series.log_a, series.log_b))
    ends = np.log([[one.a, one.a_low, one.a_high, one.b_low, one.b_high] for one in levels]).T
    held: dict[str, bool] = {}
    for law in curve.laws:
        names = [parameter.name for parameter in law.law.element.parameters]
        if set(names) == set(series.constants):
            rows = zip(names, law.low, law.high, strict=True)
            held = {n: bool(low <= series.constants[n] <= high) for n, low, high in rows}
    return Found(
        ends[0] - a,
        (ends[1] <= a) & (a <= ends[2]),
        (ends[3] <= b) & (b <= ends[4]),
        sum(level.determined for level in levels),
        held,
        seconds,
    )


def _reference(series: Series) -> float:
    """The level at which the laws of the series have their constants."""
    if isinstance(series.data, Measurement) and len(series.log_a) == 5:
        return 30.0
    if len(series.log_a) == len(LAB):
        return 25.0
    return 20.0


def by_power_laws(series: Series) -> Found:
    """Neighbours laid over one another by y = p x^q + r, as pyvisco does with storage or modulus.

    Each of a pair is fitted where their moduli overlap, and the mean distance in ln x is the shift.
    """
    curves = []
    if isinstance(series.data, Measurement):
        celsius = series.data.conditions["temperature"]
        for level in np.unique(celsius):
            here = celsius == level
            curves.append((series.data.omega[here], series.data.storage[here]))
    else:
        curves = [(1.0 / test.time, test.response / test.loading.value[-1]) for test in series.data]
    began = process_time()
    steps = [_laid_over(*pair) for pair in pairwise(curves)]
    log_a = np.concatenate([[0.0], np.cumsum(steps)])
    seconds = process_time() - began
    at = int(np.argmin(np.abs(LAB - 25.0)))
    off = np.delete(log_a - log_a[at] - (series.log_a - series.log_a[at]), at)
    none = np.zeros(0, dtype=np.bool_)
    return Found(off, none, none, 0, {}, seconds)


def _laid_over(cold: tuple[Reals, Reals], hot: tuple[Reals, Reals]) -> float:
    """Ln a of the hotter less that of the colder."""
    low, high = max(cold[1].min(), hot[1].min()), min(cold[1].max(), hot[1].max())
    if not low < high:
        # Without an overlap end meets end.
        return float(np.log(cold[0].min() / hot[0].max()))
    shared, places = np.linspace(low, high, 20), []
    for x, y in (cold, hot):
        near = (y >= low) & (y <= high)
        # One beyond on either side, so that there is a curve.
        near = near | np.roll(near, 1) | np.roll(near, -1)
        places.append(_inverse(np.log(x[near]), y[near], shared))
    return float(np.mean(places[0] - places[1]))


def _inverse(log_x: Reals, y: Reals, at: Reals) -> Reals:
    """Ln x at which a power law with an offset has the values `at`; a line where none is found."""

    def law(log_x: Reals, p: float, q: float, r: float) -> Reals:
        return np.asarray(p * np.exp(q * log_x) + r)

    slope, offset = np.polyfit(log_x, y, 1)
    line = (at - offset) / slope
    if len(y) < 4:
        return np.asarray(line)
    try:
        (p, q, r), _ = curve_fit(law, log_x, y, (np.ptp(y), 0.2, y.min()), maxfev=5000)
    except RuntimeError:
        return np.asarray(line)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.log((at - r) / p) / q
    return np.asarray(np.where(np.isfinite(found), found, line))


def by_processes(series: Series) -> Found:
    """What the PyPI package `mastercurves` says of storage, or of the modulus."""
    import master_curves

    curve = springpot.mastercurve(series.data, reference=25.0, vertical=False)
    answer = master_curves.theirs(curve, "storage", vertical=False)
    at = curve.factors.reference
    off = np.delete(answer.log_a - (series.log_a - series.log_a[at]), at)
    held = np.abs(off) <= np.delete(answer.reach, at)
    return Found(off, held, np.zeros(0, dtype=np.bool_), 0, {}, answer.seconds)


SHORT: dict[str, Callable[[np.random.Generator], Series]] = {
    "curved, 2 decades, 0.5 % of noise": partial(curved, 0.005, 2.0),
    "curved, 2 decades, 2 % of noise": partial(curved, 0.02, 2.0),
    "curved, 1 decade, 0.5 % of noise": partial(curved, 0.005, 1.0),
    "curved, 1 decade, 2 % of noise": partial(curved, 0.02, 1.0),
    "WLF, no b, 1 % of noise": partial(of_law, "WLF"),
    "Arrhenius, no b, 1 % of noise": partial(of_law, "Arrhenius"),
    "power law, n = 0": partial(power_law, 0.0),
    "power law, n = 1": partial(power_law, 1.0),
    "power law, n = -0.6": partial(power_law, -0.6),
    "power law, n = -1.5": partial(power_law, -1.5),
}
LONG: dict[str, Callable[[np.random.Generator], Series]] = {
    "sweeps at 21 temperatures": partial(laboratory, False),
    "relaxations at 21 temperatures": partial(laboratory, True),
}


def share(held: list[NDArray[np.bool_]], rng: np.random.Generator) -> Interval | None:
    """Share of intervals that hold the truth, with its 95 % interval over series drawn anew.

    Those of one series share the error of its level of reference.
    """
    means = np.array([np.mean(each) for each in held if len(each)])
    if not len(means):
        return None
    again = means[rng.integers(len(means), size=(DRAWS, len(means)))].mean(axis=1)
    low, high = np.percentile(100.0 * again, [2.5, 97.5])
    return Interval(100.0 * float(means.mean()), float(low), float(high))


def coverage(series: int, seed: int) -> Table:
    """How often intervals of short series hold the truth."""
    rows = []
    for number, (name, draw) in enumerate(SHORT.items()):
        found = [ours(draw(np.random.default_rng([seed, number, i]))) for i in range(series)]
        rng = np.random.default_rng([seed, number])
        constants = {key for one in found for key in one.constants}
        each = [
            f"{key} {100.0 * np.mean([one.constants[key] for one in found if one.constants]):.0f}"
            for key in sorted(constants)
        ]
        of_a = share([one.held_a for one in found], rng)
        of_b = share([one.held_b for one in found], rng)
        rows.append((name, of_a, of_b, ", ".join(each) or None))
        print(*rows[-1], flush=True)
    note = (
        f"{series} series of each kind, seed {seed}. In per cent, with a 95 % interval over series."
        " Constants: of the law that the series was made with, where it is shown."
    )
    heads = ("series", "intervals of a that hold", "of b", "of constants")
    return Table("Master curves: how often 95 % intervals hold the truth", heads, rows, note)


def of_21(series: int, seed: int) -> Table:
    """How far the tools are off at 21 temperatures."""
    tools: dict[str, Callable[[Series], Found]] = {
        "springpot": ours,
        "springpot --no-vertical": partial(ours, vertical=False),
        "neighbours by power laws": by_power_laws,
    }
    try:
        import mastercurves  # noqa: F401
    except ImportError:
        print("mastercurves is not installed: it is left out")
    else:
        tools["mastercurves"] = by_processes
    rows = []
    for number, (name, draw) in enumerate(LONG.items()):
        for tool, ask in tools.items():
            made = [draw(np.random.default_rng([seed, 100 + number, i])) for i in range(series)]
            found = [ask(one) for one in made]
            most = np.array([np.max(np.abs(one.off)) for one in found]) / LN10
            rms = float(np.sqrt(np.mean([np.mean(one.off**2) for one in found]))) / LN10
            of_a = share([one.held_a for one in found], np.random.default_rng([seed, number]))
            seconds = float(np.median([one.seconds for one in found]))
            within = f"{int(np.sum(most <= 0.3))}/{series}"
            rows.append(
                (name, tool, rms, float(np.median(most)), float(most.max()), within, of_a, seconds)
            )
            print(*rows[-1], flush=True)
    note = (
        f"{series} series, seed {seed}; 0.2 % of noise, no vertical factor, levels that are 0.05"
        " decades off their law. Off: difference of log10 a from the truth, at the worst"
        " of the levels of a series (median and largest of the series). Within: series of which"
        " every level is within 0.3 decades. Held: 95 % intervals of a that hold the truth, in per"
        " cent. Neighbours by power laws: the way of pyvisco, written anew."
    )
    heads = ("series", "tool", "off (rms)", "worst (median)", "worst", "within", "held", "seconds")
    return Table("Master curves of 21 temperatures", heads, rows, note)


def main() -> None:
    """Both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--series", type=int, default=40)
    parser.add_argument("--seed", type=int, default=25)
    parser.add_argument("--only", choices=("coverage", "temperatures"))
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "master_curves")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    if asked.only != "coverage":
        long = asking(__doc__, of_21(asked.series, asked.seed))
        save_table(long, asked.out, "temperatures", ("md", "csv"))
    if asked.only != "temperatures":
        short = asking(__doc__, coverage(asked.series, asked.seed))
        save_table(short, asked.out, "coverage", ("md", "csv"))


if __name__ == "__main__":
    main()
