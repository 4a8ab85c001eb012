"""Laws that are in no library: how often springpot finds them, and how often it invents one.

    python studies/nameless.py [--part leave-one-out|blind|nothing] [--cases 120]
        [--size 0.2,0.005] [--seed 20261125] [-o results/nameless]

Question: is a law that is in no library found, and is none invented where nothing is missing?
Measure: shares of drawn cases in which the curve is back within half the noise, the form is in the
class or first, what is outside the grammar is called so, and a law is invented. What would answer
it: the curve back in 40 of 45 cases at 20 % of K and in 30 at 4 %; the form in the class in 97 %
and first in 85 %; what is outside called so in 95 %; a law invented in at most 0.5 %; 93 to 97 % of
the exponents in their intervals; at most 5 s a case.

Leave one out: each effect of the library is deleted in turn, data are drawn with it, and a law is
sought beside the model that lacks it: does its curve come back to half the noise? Blind: laws of a
generator that shares no code with springpot, beside any material: is the law in the class, and is
what the grammar has not called so? Nothing: data from which nothing is missing. Cases are kept as
they are done: an interrupted run goes on where it stopped.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import re
import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

# Before NumPy: of such small matrices threads only wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import springpot
from nameless_laws.truths import INSIDE, OUTSIDE, grid, material, with_law
from paper.asking import question
from springpot import Effect, Measurement, Units
from springpot.identification import Window, settings

UNITS = Units("kN/m", "mm")
SIZES = ((0.2, 0.005), (0.2, 0.01), (0.08, 0.005), (0.08, 0.01), (0.04, 0.005), (0.04, 0.01))
"""Share by which an effect changes K, and the noise."""
TRIED = 2000
"""Settings of an effect, of which one of the wanted size is taken."""
CLEAR = 400.0
"""Drop of chi-square from which a law should be seen for what it is."""
NEAR = 0.5
"""Distance of a curve from the true one, in standard deviations of the noise, at which it is back.
"""


LAWS: dict[str, dict[str, Callable[[Any], dict[str, float]]]] = {
    "parallel-springpot": {"parallel: c*(i*omega)^a": lambda v: {"a": v["alpha"]}},
    "series-springpot": {"series: 1/(c*(i*omega)^a)": lambda v: {"a": v["alpha"]}},
    "basset": {"parallel: c*(i*omega)^(1 + a)": lambda v: {"a": 0.5}},
    "power-law-slip": {"series: Y/(i*c*(omega*Y)^a)": lambda v: {"a": v["a"]}},
    "hardening-mount": {"series: 1/(k*(1 + (Y/Xc)^n))": lambda v: {"n": 2.0}},
    "friction": {"parallel: i*k*X^(-n)": lambda v: {"n": 1.0}},
    "payne": {
        "parallel: k*(1 + i*h*(X/Xc)^n)/(1 + (X/Xc)^(2*n))": lambda v: {"n": v["m"]},
    },
    "power-law-damper": {
        "parallel: i*c*omega^a*X^n": lambda v: {"a": v["a"], "n": v["a"] - 1.0},
        "parallel: i*c*omega^a*X^(-n)": lambda v: {"a": v["a"], "n": 1.0 - v["a"]},
    },
    "cubic-damping": {"parallel: i*c*omega^a*X^n": lambda v: {"a": 3.0, "n": 2.0}},
    "cubic-stiffness": {
        "parallel: k*X^n": lambda v: {"n": 2.0},
        "parallel: -k*X^n": lambda v: {"n": 2.0},
    },
    "intrinsic-nonlinearity": {"chain: 1 + b*(X^n)": lambda v: {"n": 2.0}},
    "strain-softening": {"chain: 1/(1 + (X/Xc)^n)": lambda v: {"n": v["n"]}},
    "shear-thinning": {"chain: 1/(1 + ((omega*X)/Xc)^n)": lambda v: {"n": v["n"]}},
    "crosstalk": {
        "parallel: k*(1 + i*h)*X^(-n)": lambda v: {"n": 1.0},
        "parallel: -k*(1 - i*h)*X^(-n)": lambda v: {"n": 1.0},
    },
    "vertical-shift": {"chain: (T/T0)^n": lambda v: {"n": v["n"]}},
}
"""Effects that are a law of the grammar, and its exponents from their parameters."""


def noisy(
    rng: np.random.Generator, omega: Any, exact: Any, noise: float, conditions: Any
) -> Measurement:
    """A measurement with noise of both parts in proportion to |K|."""
    draws = rng.normal(size=(2, len(omega))) * noise * np.abs(exact)
    return Measurement(omega, exact + draws[0] + 1j * draws[1], conditions=conditions, units=UNITS)


def left_out(name: str, share: float, noise: float, rng: np.random.Generator) -> dict[str, Any]:
    """One effect, drawn, deleted and sought."""
    effect: Effect = springpot.plugins().effect(name)
    base = springpot.parse_model("fractional-maxwell")
    if "temperature" in effect.needs and effect.plane != "shift":
        base = springpot.parse_model("fractional-maxwell + arrhenius-shift")
    omega, amplitude, _ = grid(rng, column=False)
    conditions = {"amplitude": amplitude}
    if "temperature" in effect.needs:
        conditions = {"temperature": np.repeat(np.linspace(0.0, 45.0, 10), 10)}
    if not effect.needs:
        omega, conditions = 2.0 * np.pi * np.geomspace(0.3, 30.0, 100), {}
    blank = Measurement(omega, 400.0 + 1j * omega, conditions=conditions, units=UNITS)
    values = {"k": 400.0, "c": 60.0, "alpha": 0.5, "arrhenius-shift.Ea": 60.0}
    own = [values[each] for each in base.names]
    plain = base.stiffness(np.array(own), blank.points)
    window = Window.of(replace(blank, stiffness=plain))
    tried = settings(effect.element.parameters, window, TRIED)
    with np.errstate(all="ignore"):
        curves = (base.fixed_at(np.array(own)) + effect).network.respond(tried, blank.points).value
    change = np.sqrt(np.mean(np.abs(curves / plain - 1.0) ** 2, axis=1))
    near = np.argsort(np.abs(np.log(np.where(change > 0, change, 1e-9) / share)))[:5]
    chosen = int(rng.choice(near))
    exact = curves[chosen]
    data = noisy(rng, omega, exact, noise, conditions)
    begun = time.process_time()
    found = springpot.invent(data, base)
    seconds = time.process_time() - begun
    fit = found.ranked[0].grown.refit if found.ranked else found.search.base
    # At all rows: those that were set aside as outliers have a true value too.
    with np.errstate(all="ignore"):
        curve = fit.model.stiffness(fit.theta, data.points)
    off = float(np.sqrt(np.mean(np.abs((curve - exact) / exact) ** 2) / 2.0)) / noise
    law = found.laws[0].text if found.laws else ""
    row = {"effect": name, "share": share, "noise": noise, "verdict": found.verdict, "law": law}
    row |= {"distance": off, "seconds": seconds}
    drawn = dict(zip([p.name for p in effect.element.parameters], tried[chosen], strict=True))
    return row | {
        "exponents": exponents(found, {t: v(drawn) for t, v in LAWS.get(name, {}).items()})
    }


def blind(number: int, rng: np.random.Generator) -> dict[str, Any]:
    """A law of the generator, beside any material."""
    families = (*INSIDE, *OUTSIDE)
    family = families[number % len(families)]
    share, noise = float(rng.choice([0.08, 0.2])), float(rng.choice([0.005, 0.01]))
    omega, amplitude, column = grid(rng, family.column)
    plain = material(rng, omega)
    values = family.draw(rng, column if family.column else amplitude)
    exact = with_law(family, plain, family.law(values, omega, amplitude, column), share)
    conditions = {"P": column} if family.column else {"amplitude": amplitude}
    data = noisy(rng, omega, exact, noise, conditions)
    begun = time.process_time()
    found = springpot.invent(data)
    seconds = time.process_time() - begun
    named = [law.text for law in found.laws[:1]]
    members = [text for law in found.laws[:1] for text in law.alike]
    first, inside = (any(text in family.texts for text in group) for group in (named, members))
    base = found.search.base
    drop = base.rss - len(data) * 2.0
    row = {"family": family.name, "outside": not family.texts, "share": share, "noise": noise}
    row |= {"verdict": found.verdict, "first": first, "in_class": inside, "drop": drop}
    row |= {"law": named[0] if named else "", "class": len(members), "seconds": seconds}
    return row | {"exponents": exponents(found, dict.fromkeys(family.texts, values))}


def exponents(found: Any, truths: Mapping[str, Mapping[str, float]]) -> list[list[Any]]:
    """Name, truth, low and high end of each exponent of the laws of a class that are true.

    The first of them that is told, which is not always the first of the class.
    """
    if found.verdict == "none":
        return []
    for law in found.laws:
        if law.text in truths:
            names = [name for name in law.parameters if re.fullmatch("[an]2?", name)]
            values = truths[law.text]
            if law.text.startswith("parallel: i*k*X^(-n) + k*r"):
                values = {"n": values["n2"], "n2": values["n"]}
            told = [(name, law.parameters[name]) for name in names if name in values]
            return [[name, values[name], value.low, value.high] for name, value in told]
    return []


def nothing(number: int, rng: np.random.Generator) -> dict[str, Any]:
    """A material alone, at amplitudes or with a column."""
    omega, amplitude, column = grid(rng, bool(number % 2))
    conditions = {"P": column} if number % 2 else {"amplitude": amplitude}
    noise = float(rng.choice([0.005, 0.01, 0.02]))
    data = noisy(rng, omega, material(rng, omega), noise, conditions)
    begun = time.process_time()
    found = springpot.invent(data)
    law = found.laws[0].text if found.laws else ""
    seconds = time.process_time() - begun
    return {"verdict": found.verdict, "law": law, "alarm": found.search.alarm, "seconds": seconds}


def effects() -> list[str]:
    """Effects of sweeps that have a law."""
    every = springpot.plugins().items("effect")
    return [
        each.name
        for each in every
        if not each.of_test and not each.by_levels and each.element.parameters
    ]


def cases(
    part: str, count: int, sizes: Any
) -> Iterator[tuple[str, Callable[[np.random.Generator], Any]]]:
    """The cases of a part, each with a key under which it is kept."""
    if part == "leave-one-out":
        for share, noise in sizes:
            for name in effects():
                key = f"{name} {share} {noise}"
                yield key, lambda rng, n=name, s=share, e=noise: left_out(n, s, e, rng)
        return
    draw = {"blind": blind, "nothing": nothing}[part]
    for number in range(count):
        yield str(number), lambda rng, i=number: draw(i, rng)


def run(part: str, count: int, sizes: Any, seed: int, folder: Path) -> list[dict[str, Any]]:
    """All cases of a part, those that are kept already among them."""
    path = folder / f"{part}.jsonl"
    kept = {}
    if path.exists():
        kept = {row["key"]: row for row in map(json.loads, path.read_text().splitlines())}
    for key, draw in cases(part, count, sizes):
        if key in kept:
            continue
        rng = np.random.default_rng([seed, *map(ord, f"{part} {key}")])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kept[key] = {"key": key, **draw(rng)}
        with path.open("a") as file:
            file.write(json.dumps(kept[key]) + "\n")
    return [kept[key] for key, _ in cases(part, count, sizes) if key in kept]


def percent(hits: list[bool]) -> str:
    """A share with the count behind it."""
    return f"{sum(hits)} of {len(hits)} ({np.mean(hits):.3f})" if hits else "0 of 0"


def tables(parts: dict[str, list[dict[str, Any]]]) -> dict[str, list[list[str]]]:
    """What is counted, a table for each part."""
    found: dict[str, list[list[str]]] = {}
    if rows := parts.get("leave-one-out"):
        sizes: dict[tuple[float, float], list[Any]] = defaultdict(list)
        for row in rows:
            sizes[row["share"], row["noise"]].append(row)
        found["leave_one_out"] = [["share of K", "noise", "curve is back"]] + [
            [f"{s:g}", f"{e:g}", percent([r["distance"] <= NEAR for r in group])]
            for (s, e), group in sizes.items()
        ]
    if rows := parts.get("blind"):
        clear = [row for row in rows if row["drop"] >= CLEAR]
        inside = [row for row in clear if not row["outside"]]
        outside = [row for row in clear if row["outside"]]
        found["blind"] = [
            ["question", "answer"],
            ["form in the class", percent([row["in_class"] for row in inside])],
            ["form first", percent([row["first"] for row in inside])],
            [
                "outside the grammar, and called so",
                percent([r["verdict"] == "none" for r in outside]),
            ],
        ]
    if rows := parts.get("nothing"):
        invented = percent([row["verdict"] != "none" for row in rows])
        found["nothing"] = [["question", "answer"], ["a law invented where none is", invented]]
    told = [told for rows in parts.values() for row in rows for told in row.get("exponents", [])]
    if told:
        within = percent([low <= true <= high for _, true, low, high in told])
        found["exponents"] = [["exponents in their 95 % intervals"], [within]]
    seconds = [row["seconds"] for rows in parts.values() for row in rows]
    times = [f"{moment:.1f}" for moment in np.quantile(seconds, [0.5, 0.95, 1.0])]
    found["seconds"] = [["processor time a case [s], median", "95 %", "longest"], times]
    return found


def write(
    found: dict[str, list[list[str]]], counts: dict[str, int], folder: Path, seed: int
) -> None:
    """The tables, and one page of them."""
    done = ", ".join(f"{count} cases of {part}" for part, count in counts.items())
    page = ["# Laws without a name", "", question(__doc__), ""]
    page += [f"`python studies/nameless.py --seed {seed}`: {done}", ""]
    for name, rows in found.items():
        with (folder / f"{name}.csv").open("w", newline="") as file:
            csv.writer(file).writerows(rows)
        page += ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
        page += ["| " + " | ".join(row) + " |" for row in rows[1:]] + [""]
    (folder / "README.md").write_text("\n".join(page))


def main() -> None:
    """Draw, invent, count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = ("leave-one-out", "blind", "nothing")
    parser.add_argument("--part", choices=names, action="append", help="by default all")
    parser.add_argument(
        "--cases", type=int, default=120, help="blind cases, and as many of nothing"
    )
    parser.add_argument(
        "--size",
        type=lambda text: tuple(map(float, text.split(","))),
        action="append",
        metavar="SHARE,NOISE",
        help="of what is left out; by default six",
    )
    parser.add_argument("--seed", type=int, default=20261125)
    parser.add_argument("-o", "--output", type=Path, default=Path("results/nameless"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    parts = {
        part: run(part, options.cases, options.size or SIZES, options.seed, options.output)
        for part in options.part or names
    }
    found = tables(parts)
    counts = {part: len(rows) for part, rows in parts.items()}
    write(found, counts, options.output, options.seed)
    for name, rows in found.items():
        print(name)
        for row in rows:
            print("  " + "  ".join(row))


if __name__ == "__main__":
    main()
