"""Master curves side by side with the PyPI package `mastercurves`: factors, uncertainty and time.

    python studies/master_curves.py [--out results/master_curves]

Question: are shift factors nearer to the truth than those of `mastercurves`, with intervals that
hold it, and in less time? Measure: differences of ln a from published or exact factors, how many
95 % intervals hold these, and processor time. What would answer it: on each set that has such
factors, a root mean square difference below 0.05 and below both of that package's, all in less
time.

Four measured sets whose factors are published or known from practice, and one made of a fractional
Zener model with 1 % of noise, whose factors are exact. `mastercurves` superposes one curve at a
time, so that it is asked twice, with ln K' and with ln K''; it begins at the coldest sweep, as its
default bounds of a shift (0.01 to 1 from one sweep to the next) ask. A set that is not on this
machine is passed over. Needs `pip install springpot[benchmark]`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

import springpot
from paper.asking import asking
from paper.draw import can_draw
from real_sets.sets import use_shared_data
from springpot import Measurement
from springpot.benchmark import Interval, Table, save_table
from springpot.errors import DataError
from springpot.superposition import MasterCurve

ROOT = Path(__file__).resolve().parent.parent
Z95 = 1.96
LIFT = (0.5, 2.0)
"""Bounds of a vertical factor from one sweep to the next for `mastercurves`.

Its own are those of a shift.
"""
LN10 = float(np.log(10.0))
CHAIN = 14.65 / 33.6
"""Kelvin by which chains of 33.6 kg/mol have a lower glass transition than long ones (RepTate)."""

Reals = NDArray[np.float64]
Law = Callable[[Reals], Reals]


def nist(celsius: Reals) -> Reals:
    """Ln a of NIST SP 260-147: C1 = 6.64 (natural logarithm), C2 = 299.4 K at 25 degC."""
    return -6.64 * (celsius - 25.0) / (299.4 + celsius - 25.0)


def reptate(celsius: Reals) -> Reals:
    """Ln a of RepTate's polyisoprene, T0 = -35 degC: log10 a = -C1 (T - T0) / (C2 + T).

    T is in degC. C1 = 8.772 and C2 = 114.03 degC are those of long chains: C2 counts from 0 degC,
    so that the constant of Williams, Landel and Ferry at -35 degC is 79.03 K. A vertical factor rho
    T is part of the convention.
    """
    return -LN10 * 8.772 * (celsius + 35.0 + CHAIN) / (114.03 + CHAIN + celsius)


MADE_C1, MADE_C2, MADE_T = 8.0, 120.0, 30.0


def made_law(celsius: Reals) -> Reals:
    """Ln a of the artificial set."""
    return -LN10 * MADE_C1 * (celsius - MADE_T) / (MADE_C2 + celsius - MADE_T)


def made() -> Measurement:
    """Nine temperatures, 13 points in two decades each, 1 % noise; b = T / Tr."""
    model, theta = springpot.parse_model("fractional-zener"), np.array([1.0, 30.0, 2.0, 0.6])
    celsius, omega = np.linspace(0.0, 80.0, 9), np.geomspace(0.1, 10.0, 13)
    lift = (celsius + 273.15) / (MADE_T + 273.15)
    log_a = made_law(celsius)
    clean = [
        b * model.stiffness(theta, omega * np.exp(a)) for a, b in zip(log_a, lift, strict=True)
    ]
    random = np.random.default_rng(1)
    noise = 1.0 + 0.01 * (random.normal(size=117) + 1j * random.normal(size=117))
    conditions = {"temperature": np.repeat(celsius, 13)}
    return Measurement(
        np.tile(omega, 9), np.concatenate(clean) * noise, conditions=conditions, name="made"
    )


@dataclass(frozen=True)
class Set:
    """One set of sweeps.

    Parameters
    ----------
    name : str
        In the tables.
    opened : callable
        Gives the data.
    law : callable or None
        Ln a that is published, or exact.
    source : str
        Where it is from.
    """

    name: str
    opened: Callable[[], Measurement]
    law: Law | None = None
    source: str = ""


SETS = (
    Set("made", made, made_law, "exact"),
    Set("NIST SRM 2491", lambda: springpot.read("nist-srm2491"), nist, "NIST SP 260-147"),
    Set("acrylic tape", lambda: springpot.read("3m-468mp-acrylic-tts")),
    Set(
        "polyisoprene",
        lambda: springpot.read("reptate-polyisoprene-osc@molar_mass=33.6"),
        reptate,
        "RepTate",
    ),
    Set("bitumen", lambda: springpot.read("fhwa-ptf-binder-dsr@lane=1")),
)


@dataclass(frozen=True, eq=False)
class Answer:
    """Factors of one tool.

    Attributes
    ----------
    tool : str
        Which.
    celsius : ndarray, shape (m,)
        Temperatures.
    log_a, reach : ndarray, shape (m,)
        Ln a with one at the first reference of springpot, and half-widths of 95 % intervals of ln
        a.
    seconds : float
        Processor time on one thread: wall time would be that of the machine's other work.
    """

    tool: str
    celsius: Reals
    log_a: Reals
    reach: Reals
    seconds: float


def ours(curve: MasterCurve, seconds: float) -> Answer:
    """What springpot says."""
    factors = curve.factors
    name = "springpot" if curve.vertical else "springpot, shift alone"
    return Answer(name, factors.levels, factors.log_a, factors.reach_a, seconds)


def theirs(curve: MasterCurve, part: str, vertical: bool) -> Answer:
    """What `mastercurves` says of storage or loss.

    Factors are given between neighbours and multiplied.
    """
    from mastercurves import MasterCurve as Rival
    from mastercurves.transforms import Multiply

    data, levels = curve.data, curve.factors.levels
    nearest = np.argmin(np.abs(data.conditions["temperature"][:, None] - levels), axis=1)
    x, y = [], []
    for i in range(len(levels)):
        rows = np.flatnonzero((nearest == i) & (getattr(data, part) > 0.0))
        rows = rows[np.argsort(data.omega[rows], kind="stable")]
        x.append(np.log(data.omega[rows]))
        y.append(np.log(getattr(data, part)[rows]))
    began = process_time()
    rival = Rival()
    rival.add_data(x, y, levels.tolist())
    rival.add_htransform(Multiply())
    if vertical:
        rival.add_vtransform(Multiply(bounds=LIFT))
    rival.superpose()
    seconds = process_time() - began
    a, sd = (
        np.asarray(rival.hparams[0], dtype=float),
        np.asarray(rival.huncertainties[0], dtype=float),
    )
    log_a = np.log(a) - np.log(a[curve.factors.reference])
    # An uncertainty is that of one sweep beside the one before it; from the reference on they add
    # up.
    passed = np.cumsum((sd / a) ** 2)
    reach = Z95 * np.sqrt(np.abs(passed - passed[curve.factors.reference]))
    how = f"mastercurves, {part}" + ("" if vertical else ", shift alone")
    return Answer(how, levels, log_a, reach, seconds)


def answers(one: Set) -> Iterator[tuple[MasterCurve, Answer]]:
    """All tools on one set, each with and without vertical factors."""
    data = one.opened()
    springpot.mastercurve(data)  # the first call imports and warms up
    for vertical in (True, False):
        began = process_time()
        curve = springpot.mastercurve(data, vertical=vertical)
        yield curve, ours(curve, process_time() - began)
        for part in ("storage", "loss"):
            yield curve, theirs(curve, part, vertical)


def off(
    answer: Answer, law: Law | None, reference: float
) -> tuple[float | None, float | None, str | None]:
    """Rms and largest difference from a law in ln a, and how many intervals hold it."""
    if law is None:
        return None, None, None
    truth = law(answer.celsius) - law(np.array([reference]))
    away = np.abs(answer.log_a - truth)
    free = answer.celsius != reference
    held = int(np.sum((away <= answer.reach)[free]))
    return (
        float(np.sqrt(np.mean(away[free] ** 2))),
        float(away[free].max()),
        f"{held}/{int(free.sum())}",
    )


def run() -> tuple[Table, Table, dict[str, MasterCurve]]:
    """Both tables and our curves."""
    summary, factors, curves = [], [], {}
    for one in SETS:
        try:
            found = list(answers(one))
        except DataError as error:
            print(f"{one.name}: not on this machine ({error})")
            continue
        curves[one.name] = found[0][0]
        for curve, answer in found:
            free = answer.celsius != curve.reference
            error = curve.simplicity.error if answer.tool.startswith("springpot") else None
            rms, most, held = off(answer, one.law, curve.reference)
            reach = float(np.median(answer.reach[free]))
            summary.append((one.name, answer.tool, error, rms, most, held, reach, answer.seconds))
            print(*summary[-1], flush=True)
            for t, log_a, width in zip(answer.celsius, answer.log_a, answer.reach, strict=True):
                ends = (float(np.exp(each)) for each in (log_a, log_a - width, log_a + width))
                said = (
                    None
                    if one.law is None
                    else float(np.exp(one.law(t) - one.law(curve.reference)))
                )
                factors.append((one.name, answer.tool, round(float(t), 1), Interval(*ends), said))
    columns = (
        "set",
        "tool",
        "error",
        "off (rms)",
        "off (most)",
        "held",
        "half-width",
        "CPU seconds",
    )
    note = (
        "Error: of the curve relative to |K|, root mean square. Off: difference of ln a from what"
        " is published (NIST SP 260-147; RepTate with its vertical factor) or, of the made set,"
        " exact. Held: how many 95 % intervals hold that. Half-width: median of the intervals of ln"
        " a; mastercurves gives uncertainties from one sweep to the next, which are added up in"
        " squares from the reference on."
    )
    first = Table("Master curves: two tools side by side", columns, summary, note)
    heads = ("set", "tool", "temperature [degC]", "a with 95 % interval", "published or exact")
    return first, Table("Master curves: factors", heads, factors), curves


def main() -> None:
    """Run all sets and write tables and figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "master_curves")
    folder = parser.parse_args().out
    use_shared_data()
    folder.mkdir(parents=True, exist_ok=True)
    summary, factors, curves = run()
    save_table(asking(__doc__, summary), folder, "summary", ("md", "csv"))
    save_table(asking(__doc__, factors), folder, "factors", ("md", "csv"))
    if can_draw(folder):
        for name, curve in curves.items():
            curve.plot(folder / f"{name.replace(' ', '-').lower()}.png")


if __name__ == "__main__":
    main()
