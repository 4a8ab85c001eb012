"""What the verdicts of all cases amount to.

Question: is the effect that is missing from a test in time found and named, and nothing where
nothing is missing? Measure: shares of drawn cases, by the chi-square that the base model misses
beyond noise. What would answer it: the goals of the study of sweeps, 99 % detected from a
chi-square of 30 and 98 % in the class that is named from 60, at most 2 % flagged of nothing.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from paper.asking import question

from .judge import DETECTED, NAMED, NEAR_FLOOR, Verdict


def share(of: Sequence[Verdict], which: Callable[[Verdict], bool]) -> float:
    """Share of some verdicts; not a number where there are none."""
    return float(np.mean([which(each) for each in of])) if of else float("nan")


def near(value: float) -> bool:
    """Whether an error over the floor is one."""
    return NEAR_FLOOR[0] <= value <= NEAR_FLOOR[1]


def figures(verdicts: Sequence[Verdict]) -> list[tuple[str, float, int]]:
    """Each figure with its name and the cases behind it."""
    clean = [each for each in verdicts if not each.hidden]
    inside = [each for each in verdicts if each.hidden and not each.outside]
    seen = [each for each in inside if each.visible >= DETECTED]
    plain = [each for each in inside if each.visible >= NAMED]
    unknown = [each for each in verdicts if each.outside and each.visible >= NAMED]
    return [
        (
            "something missing is detected (chi-square >= 30)",
            share(seen, lambda v: v.flagged),
            len(seen),
        ),
        (
            "the true effect is in the class that is named (chi-square >= 60)",
            share(plain, lambda v: v.right),
            len(plain),
        ),
        (
            "the true effect stands first by name (chi-square >= 60)",
            share(plain, lambda v: v.missing[:1] == (v.hidden,)),
            len(plain),
        ),
        ("nothing missing, yet flagged", share(clean, lambda v: v.flagged), len(clean)),
        (
            "nothing missing, called inconclusive",
            share(clean, lambda v: v.verdict == "inconclusive"),
            len(clean),
        ),
        (
            "members of the class, mean (chi-square >= 60)",
            float(np.mean([len(v.missing) for v in plain])) if plain else float("nan"),
            len(plain),
        ),
        (
            "error over floor in 0.95 to 1.05 with the best effect (chi-square >= 60)",
            share(plain, lambda v: near(v.after)),
            len(plain),
        ),
        (
            "the same with the true model, fitted from the truth",
            share(plain, lambda v: near(v.oracle)),
            len(plain),
        ),
        (
            "outside the library: flagged (chi-square >= 60)",
            share(unknown, lambda v: v.flagged),
            len(unknown),
        ),
        (
            "outside the library: explained by one effect of the library",
            share(unknown, lambda v: v.verdict == "effect-missing"),
            len(unknown),
        ),
        (
            "processor time of a diagnosis, median, s",
            float(np.median([v.seconds for v in verdicts])),
            len(verdicts),
        ),
        (
            "processor time of a diagnosis, mean, s",
            float(np.mean([v.seconds for v in verdicts])),
            len(verdicts),
        ),
    ]


def by_effect(verdicts: Sequence[Verdict]) -> list[list[str]]:
    """One row for each hidden effect in each kind of test."""
    rows = []
    inside = [each for each in verdicts if each.hidden]
    for kind, name in sorted({(each.kind, each.hidden) for each in inside}):
        own = [each for each in inside if (each.kind, each.hidden) == (kind, name)]
        plain = [each for each in own if each.visible >= NAMED]
        named = "-" if own[0].outside else _percent(share(plain, lambda v: v.right))
        first = (
            "-"
            if own[0].outside
            else _percent(share(plain, lambda v: v.missing[:1] == (v.hidden,)))
        )
        flagged = _percent(share(plain, lambda v: v.flagged))
        rows.append([kind, name, str(len(own)), str(len(plain)), flagged, named, first])
    return rows


def _percent(value: float) -> str:
    return "-" if np.isnan(value) else f"{100.0 * value:.1f} %"


def _shown(name: str, value: float) -> str:
    return f"{value:.2f}" if "mean" in name or "time" in name else _percent(value)


HEADERS = ("test", "hidden", "cases", "visible", "flagged", "in class", "first")


def write_tables(verdicts: Sequence[Verdict], folder: Path, seed: int, read: bool = False) -> None:
    """README.md, figures.json and by_effect.csv; of motions that were `read` with noise or not."""
    option, drawn = ("--read ", "records, their motion read with noise,") if read else ("", "tests")
    found = figures(verdicts)
    rows = by_effect(verdicts)
    lines = [
        "# Hidden effects of tests in time",
        "",
        question(__doc__),
        "",
        (
            f"`python studies/hidden_effect_time.py {option}--cases {len(verdicts)} --seed {seed}`:"
            f" {len(verdicts)} {drawn} drawn anew, computed by inversion of Laplace transforms,"
            " with one hidden effect, none, or one that the library lacks. Chi-square is what the"
            " base model misses beyond noise; below 30 nothing can be expected to be seen."
        ),
        "",
        "| | figure | cases |",
        "|---|---:|---:|",
        *(f"| {name} | {_shown(name, value)} | {count} |" for name, value, count in found),
        "",
        "Visible: chi-square of 60 or more.",
        "",
        f"| {' | '.join(HEADERS)} |",
        "|---|---|---:|---:|---:|---:|---:|",
        *(f"| {' | '.join(row)} |" for row in rows),
        "",
    ]
    (folder / "README.md").write_text("\n".join(lines), encoding="utf-8")
    kept = {name: {"value": value, "cases": count} for name, value, count in found}
    (folder / "figures.json").write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")
    with (folder / "by_effect.csv").open("w", newline="", encoding="utf-8") as table:
        csv.writer(table, lineterminator="\n").writerows([HEADERS, *rows])
