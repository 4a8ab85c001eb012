"""Tables (Markdown, CSV, JSON) and pictures of the hidden-effect test.

Question: does a diagnosis find what is missing from a measurement, name it where that can be told,
and name nothing where nothing is missing? Measure: shares of drawn cases with their 95 % intervals,
by the chi2 that the base model leaves of the noise-free data. What would answer it: every figure
at its goal, above all 99 % detected from a chi2 of 30, 98 % in the first class from 60, at most 2 %
flagged of nothing and 1 % named with confidence and wrongly.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np

from hidden_effects.figures import (
    DESIGNS,
    Figure,
    Row,
    classed,
    first,
    flagged,
    named,
    share,
    sure,
    table,
    verdict,
)
from hidden_effects.strata.figures import by_detail, strata_table
from paper.asking import question

FURTHER = (
    "`time`: the force is integrated in time and reduced to harmonics; `history`: hysteresis,"
    " ageing, break-in; `noise`: gain and phase scatter apart, a constant force, heavy tails,"
    " correlated, a drift in random row order; `wrong-base`: fractional-kelvin is asked where the"
    " truth is another network, and then no model at all; `notch`, `ripple`: faults of the rig on"
    " noise of unknown size; `replicates`: each with a gain of its own; `rounding`: three"
    " significant digits; `two`, `three`: so many effects, each of a chi2 of 120 or more beside the"
    " others, half in sweeps and half in fields; `measured`: files as instruments write them, with"
    " a ramp, slack, flow, a sign, a drift in time, two calibrations, missing rows or an amplitude"
    " that goes with the frequency, where a cause that is no effect must be told in a note or a"
    " step. The second table counts verdicts for every kind."
)
BINS = (5.0, 15.0, 30.0, 60.0, 120.0, 400.0, 1200.0, np.inf)


def write(rows: list[Row], folder: Path, pictures: bool = True) -> list[Figure]:
    """Write everything into ``folder`` and return the figures."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = sorted(rows, key=lambda r: (r["design"], r["seed"]))
    plain = [r for r in rows if r["design"] in DESIGNS]
    figures = [*table(plain), *strata_table(rows)]
    with (folder / "figures.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(figures[0].to_dict()))
        writer.writeheader()
        writer.writerows(f.to_dict() for f in figures)
    (folder / "figures.json").write_text(
        json.dumps([f.to_dict() for f in figures], indent=1) + "\n", encoding="utf-8"
    )
    strata = stratified(plain)
    (folder / "README.md").write_text(_markdown(rows, figures, strata), encoding="utf-8")
    if not plain:
        return figures
    for by in ("label", "class"):
        _write_confusion(confusion(plain, by), folder / f"confusion_by_{by}.csv")
    if pictures:
        from hidden_effects.pictures import draw

        draw(plain, strata, folder)
    return figures


def stratified(rows: list[Row]) -> list[tuple[str, float, float, list[Figure]]]:
    """Detection, class, name and confident errors of one-effect cases per bin of detectability."""
    out = []
    for design in ("sweep", "field", "signals"):
        for low, high in pairwise(BINS):
            here = [
                r
                for r in rows
                if r["design"] == design and r["kind"] == "one" and low <= r["chi2"] < high
            ]
            if here:
                tests = {"detected": flagged, "in first class": classed, "first by name": named}
                cells = [share(name, design, here, test) for name, test in tests.items()]
                cells.append(
                    share("confident, wrong", design, here, lambda r: sure(r) and not named(r))
                )
                out.append((design, low, high, cells))
    return out


def confusion(rows: list[Row], by: str) -> tuple[list[str], list[str], np.ndarray]:
    """Return truths, answers and counts.

    ``by`` class an answer counts as the truth when that is in its class.
    """
    counts: Counter[tuple[str, str]] = Counter()
    for row in rows:
        if row["kind"] == "two":
            continue
        truth = row["truth"][0] if row["truth"] else "(nothing)"
        said = (
            first(row).get("effect", "?")
            if verdict(row) == "effect-missing"
            else f"({verdict(row)})"
        )
        counts[truth, truth if by == "class" and classed(row) else said] += 1
    truths = sorted({t for t, _ in counts})
    answers = sorted({a for _, a in counts})
    return truths, answers, np.array([[counts[t, a] for a in answers] for t in truths])


def _write_confusion(matrix: tuple[list[str], list[str], np.ndarray], path: Path) -> None:
    truths, answers, counts = matrix
    lines = [",".join(["truth", *answers])]
    lines += [",".join([t, *(str(n) for n in row)]) for t, row in zip(truths, counts, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _markdown(
    rows: list[Row], figures: list[Figure], strata: list[tuple[str, float, float, list[Figure]]]
) -> str:
    plain = [r for r in rows if r["design"] in DESIGNS]
    further = [r for r in rows if r["design"] not in DESIGNS]
    lines = ["# The hidden-effect test", "", question(__doc__), "", *_head(rows)]
    if plain:
        lines += ["", *_figures([f for f in figures if f.design in DESIGNS])]
    if further:
        lines += ["", "## Further strata", "", FURTHER, ""]
        lines += [
            *_figures([f for f in figures if f.design not in DESIGNS]),
            "",
            *by_detail(further),
        ]
    if plain:
        lines += ["", "## One hidden effect, by detectability", "", *_by_detectability(strata)]
        lines += ["", "## By effect, chi2 >= 60", ""]
        lines += ["| effect | design | cases | first class | by name | most frequent other |"]
        lines += ["|---|---|---|---|---|---|", *_by_effect(plain)]
        lines += ["", "Confusion matrices: `confusion_by_label.csv`, `confusion_by_class.csv`."]
    return "\n".join([*lines, ""])


def _head(rows: list[Row]) -> list[str]:
    drawn = sorted(Counter((r["design"], r["kind"]) for r in rows).items())
    seeds = [r["seed"] for r in rows]
    return [
        (
            f"{len(rows)} cases (seeds {min(seeds)} to {max(seeds)}), drawn by"
            " `studies/hidden_effects`,"
        ),
        "which shares no code with the framework: "
        + ", ".join(f"{d} {k} {n}" for (d, k), n in drawn)
        + ".",
        (
            "chi2 is what the best refitted base model leaves of the noise-free data; intervals are"
            " 95 %."
        ),
        (
            "`sweep` is one frequency sweep, `field` amplitude x temperature, `signals` force and"
            " displacement in time."
        ),
    ]


def _figures(figures: list[Figure]) -> list[str]:
    lines = [
        "| figure | design | value | 95 % interval | cases | goal | met |",
        "|---|---|---|---|---|---|---|",
    ]
    for f in figures:
        if f.n:
            goal = "" if f.goal is None else f"{f.better} {f.goal:g}"
            met = {True: "yes", False: "**no**", None: ""}[f.met]
            lines.append(
                f"| {f.name} | {f.design} | {f.value:.3f} | {f.low:.3f}-{f.high:.3f} | {f.n} |"
                f" {goal} | {met} |"
            )
    return lines


def _by_detectability(strata: list[tuple[str, float, float, list[Figure]]]) -> list[str]:
    heads = ["detected", "in first class", "first by name", "confident, wrong"]
    lines = [
        "| design | chi2 | cases | " + " | ".join(heads) + " |",
        "|---|---|---|" + "---|" * len(heads),
    ]
    for design, low, high, cells in strata:
        values = " | ".join(f"{c.value:.2f} ({c.low:.2f}-{c.high:.2f})" for c in cells)
        lines.append(f"| {design} | {low:g}-{high:g} | {cells[0].n} | {values} |")
    return lines


def _by_effect(rows: list[Row]) -> list[str]:
    lines = []
    one = [r for r in rows if r["kind"] == "one" and r["chi2"] >= 60]
    for effect, design in sorted({(r["truth"][0], r["design"]) for r in one}):
        here = [r for r in one if r["truth"][0] == effect and r["design"] == design]
        others = Counter(
            first(r).get("effect", "?") if verdict(r) == "effect-missing" else f"({verdict(r)})"
            for r in here
            if not named(r)
        )
        worst = ", ".join(f"{n} x{c}" for n, c in others.most_common(2))
        cells = (
            f"{np.mean([classed(r) for r in here]):.2f} | {np.mean([named(r) for r in here]):.2f} |"
            f" {worst}"
        )
        lines.append(f"| {effect} | {design} | {len(here)} | {cells} |")
    return lines
