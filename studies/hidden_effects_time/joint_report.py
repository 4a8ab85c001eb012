"""What the diagnosis of several tests says, beside what is true, for each hidden thing.

Question: is what is missing from several tests of one specimen named, be it of the material, of one
rig, of one signal or of the calibration between them? Measure: shares of drawn cases whose named
class holds the truth, and of confident errors. What would answer it: the goals of the study of
sweeps, 98 % in the class from a chi-square of 60, at most 2 % flagged of nothing and 1 %
confidently wrong.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from paper.asking import question
from springpot.registry import parse_model
from springpot.timetests import diagnose

from .joint import GROUPS, TOGETHER, JointCase
from .judge import DETECTED, NAMED

SEVERAL = 2.0
"""Times the noise from which an error is plainly more than noise."""


@dataclass(frozen=True)
class JointVerdict:
    """One case, counted.

    Attributes
    ----------
    tests, where : tuple of str
        All tests, and those that have what is hidden.
    visible : float
        Chi-square that the base model cannot take.
    verdict, missing : str, tuple of str
        What was said.
    before, after : float
        Error over the floor, of the base model and with the best effect.
    right : bool
        Whether the class that was named holds the truth.
    """

    index: int
    tests: tuple[str, ...]
    base: str
    group: str
    hidden: str
    where: tuple[str, ...]
    visible: float
    verdict: str
    missing: tuple[str, ...]
    before: float
    after: float
    right: bool
    seconds: float

    @property
    def flagged(self) -> bool:
        """Whether something is said to be missing."""
        return self.verdict in ("effect-missing", "unexplained")

    @property
    def wrong(self) -> bool:
        """Whether it is sure of what is not true.

        A wrong name, or nothing where something is plain.
        """
        if self.verdict == "effect-missing":
            return not self.right
        return self.verdict == "adequate" and self.visible >= NAMED

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    @classmethod
    def from_dict(cls, kept: dict[str, Any]) -> JointVerdict:
        """Back from plain data."""
        listed = {name: tuple(kept[name]) for name in ("tests", "where", "missing")}
        return cls(**{**kept, **listed})


def judged(case: JointCase, index: int, effects: Sequence[Any]) -> JointVerdict:
    """Diagnose one case."""
    began = process_time()
    found = diagnose(case.tests, parse_model(case.specimen.base), effects)
    seconds = process_time() - began
    after = found.error.over_floor
    if found.best is not None:
        after = found.best.over_floor
    return JointVerdict(
        index=index,
        tests=case.specimen.tests,
        base=case.specimen.base,
        group=case.group,
        hidden=case.found.name,
        where=case.found.where,
        visible=case.visible,
        verdict=found.verdict,
        missing=found.leading,
        before=found.error.over_floor,
        after=after,
        right=bool(case.truth & set(found.leading)),
        seconds=seconds,
    )


HEADERS = (
    "cases",
    "visible",
    "flagged",
    "class holds the truth",
    "confidently wrong",
    "adequate at 2 x the noise",
    "members",
)


def counted(rows: Sequence[JointVerdict]) -> list[str]:
    """One row of the table; "visible" are those of a chi-square of 60 and more."""
    plain = [row for row in rows if row.hidden and row.visible >= NAMED]
    inside = [row for row in plain if row.group != "outside"]
    named = [len(row.missing) for row in inside if row.missing]
    return [
        str(len(rows)),
        str(len(plain)),
        share(plain, lambda row: row.flagged),
        share(inside, lambda row: row.right),
        share(rows, lambda row: row.wrong),
        share(rows, lambda row: row.verdict == "adequate" and row.before >= SEVERAL),
        f"{np.mean(named):.2f}" if named else "-",
    ]


def share(rows: Sequence[JointVerdict], which: Callable[[JointVerdict], bool]) -> str:
    """How many of some rows, printed."""
    if not rows:
        return "-"
    return f"{100.0 * np.mean([which(row) for row in rows]):.1f} %"


def strata(rows: Sequence[JointVerdict]) -> Iterator[tuple[str, list[JointVerdict]]]:
    """Rows of one kind.

    By what is hidden, by which tests, and by each effect in one test or in all.
    """
    for group in GROUPS:
        yield group, [row for row in rows if row.group == group]
    for tests in TOGETHER:
        yield " + ".join(tests), [row for row in rows if row.tests == tests]
    for name, where in sorted({(row.hidden, row.where) for row in rows if row.hidden}):
        own = [row for row in rows if (row.hidden, row.where) == (name, where)]
        yield f"{name} in {', '.join(where)}", own


def write_joint(rows: Sequence[JointVerdict], folder: Path, seed: int) -> None:
    """README.md, figures.json and strata.csv."""
    hidden = [row for row in rows if row.hidden]
    inside = [row for row in hidden if row.group != "outside" and row.visible >= NAMED]
    seen = [row for row in hidden if row.visible >= DETECTED]
    clean = [row for row in rows if not row.hidden]
    outside = [row for row in hidden if row.group == "outside" and row.visible >= NAMED]
    figures = [
        ("the class that is named holds the truth (chi-square >= 60)", inside, lambda r: r.right),
        ("confidently wrong", rows, lambda r: r.wrong),
        ("nothing missing, yet flagged", clean, lambda r: r.flagged),
        ("nothing missing, called inconclusive", clean, lambda r: r.verdict == "inconclusive"),
        ("something missing is detected (chi-square >= 30)", seen, lambda r: r.flagged),
        ("outside the library: flagged (chi-square >= 60)", outside, lambda r: r.flagged),
        ("outside the library: given a name", outside, lambda r: r.verdict == "effect-missing"),
    ]
    seconds = float(np.median([row.seconds for row in rows]))
    tables = [[name, *counted(own)] for name, own in strata(rows) if own]
    lines = [
        "# Hidden effects of several tests of one specimen",
        "",
        question(__doc__),
        "",
        (
            f"`python studies/hidden_effect_time.py --joint --cases {len(rows)} --seed {seed}`:"
            " sweeps, relaxation and creep of one specimen, computed outside springpot, with an"
            " effect of the material, of one rig, of one signal, of the calibration between the"
            " tests, one that the library lacks, or none. Confidently wrong is a wrong name, or"
            ' "adequate" at a chi-square of 60 or more.'
        ),
        "",
        "| | figure | cases |",
        "|---|---:|---:|",
        *(f"| {name} | {share(own, which)} | {len(own)} |" for name, own, which in figures),
        f"| processor time of a diagnosis, median, s | {seconds:.2f} | {len(rows)} |",
        "",
        f"| hidden | {' | '.join(HEADERS)} |",
        f"|---|{'---:|' * len(HEADERS)}",
        *(f"| {' | '.join(row)} |" for row in tables),
        "",
    ]
    (folder / "README.md").write_text("\n".join(lines), encoding="utf-8")
    kept = {name: {"value": share(own, which), "cases": len(own)} for name, own, which in figures}
    (folder / "figures.json").write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")
    with (folder / "strata.csv").open("w", newline="", encoding="utf-8") as table:
        csv.writer(table, lineterminator="\n").writerows([("hidden", *HEADERS), *tables])
