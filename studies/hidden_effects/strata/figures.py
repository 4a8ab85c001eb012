"""The figures of the further strata, from collected answers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from math import nan

import numpy as np

from hidden_effects.figures import (
    Figure,
    Row,
    accepted,
    answer,
    classed,
    first,
    first_class,
    flagged,
    found,
    mean,
    named,
    same_verdict,
    share,
    sure,
    verdict,
)
from hidden_effects.strata import STRATA

FEW = 0.02
"""False alarms that the goals allow in every stratum."""
NEAR = 1.5
"""A noise floor within this factor of the truth is right."""
SEEN, NAMEABLE, PLAIN = 30.0, 60.0, 120.0
"""Chi-square from which the goals ask for detection, for the class and for the name."""
FAULTS = ("notch", "ripple")
"""Strata for which there are goals of the floor and of the verdict "adequate"."""
VERDICTS = ("adequate", "effect-missing", "unexplained", "inconclusive", "failed")


def strata_table(rows: list[Row]) -> list[Figure]:
    """Every figure of every stratum that has cases."""
    out: list[Figure] = []
    for stratum in STRATA:
        here = [r for r in rows if r["design"] == stratum]
        if here and stratum == "measured":
            out += [*_of_files(stratum, here), *_floor(stratum, here), _time(stratum, here)]
        elif here:
            out += [
                *_plain(stratum, here),
                *_several(stratum, here),
                *_outside(stratum, here),
                *_base(stratum, here),
                *_floor(stratum, here),
            ]
            out += [same_verdict(stratum, here), _time(stratum, here)]
    return [figure for figure in out if figure.n]


def of_kind(rows: list[Row], *kinds: str, least: float = 0.0) -> list[Row]:
    """The rows of some kinds, from a chi-square on."""
    return [r for r in rows if r["kind"] in kinds and r["chi2"] >= least]


def misnamed(row: Row) -> bool:
    """Whether one name is given with confidence, and is wrong."""
    return sure(row) and not named(row)


def floor_ratio(row: Row) -> float:
    """The noise floor found over the true one."""
    found = (answer(row).get("error") or {}).get("noise_floor")
    return float(found) / float(row["floor"]) if found else nan


def without_model(row: Row) -> Row:
    """The row with the answer to the second question, the judgement of any passive material."""
    return row | {
        "answer": row["material_answer"],
        "truth": row["material_truth"],
        "chi2": row["material_chi2"],
        "kind": "one" if row["material_truth"] else "nothing",
        "ladder": None,
    }


def _of_files(d: str, rows: list[Row]) -> list[Figure]:
    """What is the matter with a file is named, or told where it is no effect."""
    clear = of_kind(rows, "one", least=NAMEABLE)
    return [
        share("failed (fault, time-out)", d, rows, lambda r: verdict(r) == "failed", 0.0, "<="),
        share("in first class or told as the cause, chi2 >= 60", d, clear, recognised, 0.95),
        share("confidently wrong", d, clear, _claims_wrongly, 0.01, "<="),
    ]


def recognised(row: Row) -> bool:
    """Whether the first class holds what is hidden, or a note or a proposed step tells the cause.

    Not where something else is called missing.
    """
    found = answer(row)
    if verdict(row) == "effect-missing" and row["truth"]:
        return classed(row)
    if not flagged(row):
        return False
    words = " ".join([*found["notes"], *(step["says"] for step in found["actions"])])
    helps = bool(set(first_class(row)) & set(row["truth"]))
    return helps or any(told in words for told in row["told"])


def _claims_wrongly(row: Row) -> bool:
    """Whether a wrong effect is called missing, or nothing, though it is plain."""
    return verdict(row) in ("effect-missing", "adequate") and not recognised(row)


def _plain(d: str, rows: list[Row]) -> list[Figure]:
    """Nothing or a library effect is missing."""
    nothing, one = of_kind(rows, "nothing"), of_kind(rows, "one")
    return [
        share("failed (fault, time-out)", d, rows, lambda r: verdict(r) == "failed", 0.0, "<="),
        share(
            "nothing missing, yet auto-accepted",
            d,
            _walked(nothing),
            lambda r: bool(accepted(r)),
            0.005,
            "<=",
        ),
        *_found("", d, nothing, one),
    ]


def _walked(rows: Iterable[Row]) -> list[Row]:
    return [r for r in rows if r.get("ladder")]


def _found(head: str, d: str, nothing: list[Row], one: list[Row]) -> list[Figure]:
    """False alarms, detection and names of one question."""
    return [
        share(f"{head}nothing missing, yet flagged", d, nothing, flagged, FEW, "<="),
        share(
            f"{head}nothing missing, called inconclusive",
            d,
            nothing,
            lambda r: verdict(r) == "inconclusive",
        ),
        share(f"{head}detected, chi2 >= 30", d, of_kind(one, "one", least=SEEN), flagged, 0.99),
        share(
            f"{head}in first class, chi2 >= 60",
            d,
            of_kind(one, "one", least=NAMEABLE),
            classed,
            0.98,
        ),
        share(f"{head}first by name, chi2 >= 120", d, of_kind(one, "one", least=PLAIN), named),
        share(f"{head}confident name and wrong", d, [*nothing, *one], misnamed, 0.01, "<="),
    ]


def _several(d: str, rows: list[Row]) -> list[Figure]:
    """Several effects are missing, each plain to see beside the others."""
    hidden = _walked(of_kind(rows, "two", "three"))
    effects = [r | {"effect": name} for r in hidden for name in r["truth"]]
    rungs = [r | {"rung": s} for r in hidden for s in r["ladder"]["steps"] if s["accepted"]]
    return [
        share(
            "several: all accepted by name",
            d,
            hidden,
            lambda r: set(r["truth"]) <= set(accepted(r)),
            0.5 if d == "two" else None,
        ),
        share(
            "several: all accepted, by name or class",
            d,
            hidden,
            lambda r: all(found(r, name) for name in r["truth"]),
        ),
        share(
            "several: exactly these accepted, by name",
            d,
            hidden,
            lambda r: sorted(r["truth"]) == sorted(accepted(r)),
        ),
        share(
            "several: an effect accepted by name", d, effects, lambda r: r["effect"] in accepted(r)
        ),
        share(
            "several: an effect accepted, by name or class",
            d,
            effects,
            lambda r: found(r, r["effect"]),
            0.75 if d == "three" else None,
        ),
        share(
            "several: accepted where no hidden one is in the class",
            d,
            rungs,
            lambda r: not {r["rung"]["accepted"], *r["rung"]["class"]} & set(r["truth"]),
            0.01,
            "<=",
        ),
        mean("several: seconds per ladder", d, (r["ladder_seconds"] for r in hidden)),
    ]


def _outside(d: str, rows: list[Row]) -> list[Figure]:
    """What is missing has no name in a library; correlated noise is no more than told of."""
    every = of_kind(rows, "outside", least=SEEN)
    smooth = [r for r in every if r["detail"] == "correlated"]
    hard = [r for r in every if r["detail"] != "correlated"]
    plain = "outside the library"
    return [
        share(f"{plain}: flagged, chi2 >= 30", d, hard, flagged, 0.97),
        share(f"{plain}: called adequate", d, hard, _adequate, 0.05 if d in FAULTS else None, "<="),
        share(f"{plain}: called unexplained", d, hard, lambda r: verdict(r) == "unexplained"),
        share(f"{plain}: confidently misnamed", d, of_kind(rows, "outside"), misnamed, 0.01, "<="),
        share(f"{plain}: auto-accepted an effect", d, _walked(hard), lambda r: bool(accepted(r))),
        share("correlated noise: flagged", d, smooth, flagged),
        share(
            "correlated noise: an effect auto-accepted",
            d,
            _walked(smooth),
            lambda r: bool(accepted(r)),
        ),
    ]


def _adequate(row: Row) -> bool:
    return verdict(row) == "adequate"


def _base(d: str, rows: list[Row]) -> list[Figure]:
    """The model's spectrum is wrong: asked with that model, and without one."""
    wrong = of_kind(rows, "base")
    asked = [without_model(r) for r in wrong if "material_answer" in r]
    nothing, one = of_kind(asked, "nothing"), of_kind(asked, "one")
    alone = [r for r in wrong if r["detail"] == "alone"]
    plain = "wrong base"
    return [
        share(f"{plain}: flagged", d, wrong, flagged, 0.99),
        share(
            f"{plain}, nothing beside: another effect named with confidence",
            d,
            alone,
            _not_material,
            0.01,
            "<=",
        ),
        share(f"{plain}: confidently misnamed", d, wrong, _not_material, 0.01, "<="),
        share(f"{plain}: what stands beside it in first class", d, _beside(wrong), _beside_classed),
        share("without a model: failed", d, asked, lambda r: verdict(r) == "failed", 0.0, "<="),
        *_found("without a model: ", d, nothing, one),
        share("without a model: floor within 1.5 x of the truth", d, asked, _near),
    ]


def _beside(rows: list[Row]) -> list[Row]:
    return [r for r in rows if r["material_truth"]]


def _beside_classed(row: Row) -> bool:
    return verdict(row) == "effect-missing" and bool(
        set(first_class(row)) & set(row["material_truth"])
    )


def _not_material(row: Row) -> bool:
    """Whether a confident name is neither of the material nor of what stands beside it."""
    return sure(row) and first(row).get("effect") not in row["truth"]


def _near(row: Row) -> bool:
    return 1.0 / NEAR <= floor_ratio(row) <= NEAR


def _floor(d: str, rows: list[Row]) -> list[Figure]:
    rows = [r for r in rows if np.isfinite(r["floor"])]
    return [
        mean("noise floor found / true", d, (floor_ratio(r) for r in rows)),
        share(
            "noise floor within 1.5 x of the truth", d, rows, _near, 0.8 if d in FAULTS else None
        ),
    ]


def _time(d: str, rows: list[Row]) -> Figure:
    return mean(
        "seconds per answer", d, (r["seconds"] for r in rows if r.get("seconds") is not None)
    )


def by_detail(rows: list[Row]) -> list[str]:
    """Lines of a Markdown table: verdicts, floor and first names for every kind of the strata."""
    lines = [
        "| stratum | kind | cases | "
        + " | ".join(VERDICTS)
        + " | floor / true, median | named first |",
        "|---|---|---|" + "---|" * (len(VERDICTS) + 2),
    ]
    for stratum in STRATA:
        here = [r for r in rows if r["design"] == stratum]
        for detail, kind in sorted({(r["detail"], r["kind"]) for r in here}):
            group = [r for r in here if (r["detail"], r["kind"]) == (detail, kind)]
            lines.append(_line(stratum, f"{detail}, {kind}", group))
            asked = [without_model(r) for r in group if "material_answer" in r]
            if asked:
                lines.append(_line(stratum, f"{detail}, without a model", asked))
    return lines


def _line(stratum: str, label: str, rows: list[Row]) -> str:
    counts = Counter(verdict(r) for r in rows)
    ratios = np.array([floor_ratio(r) for r in rows])
    middle = f"{np.median(ratios[np.isfinite(ratios)]):.2f}" if np.isfinite(ratios).any() else ""
    names = Counter(first(r).get("effect", "?") for r in rows if verdict(r) == "effect-missing")
    told = ", ".join(f"{name} x{count}" for name, count in names.most_common(4))
    cells = " | ".join(str(counts[v]) for v in VERDICTS)
    return f"| {stratum} | {label} | {len(rows)} | {cells} | {middle} | {told} |"
