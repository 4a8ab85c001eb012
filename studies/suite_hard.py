"""Twenty problems that no descent solves: drawn by a seed, kept by measured features, and raced.

    python studies/suite_hard.py           draws and measures springpot-hard-20, some minutes
    springpot run studies/suite_hard.py    races on it

On the hard half of springpot-60 `auto`, which came after it, reaches every target. Drawn are
problems from the library's own models, effects and tests (`drawn_problems.py`), of them those with
ten parameters or more, ladders of three effects, and what is not smooth. Kept are the first twenty
of which none of 64 descents by exact derivatives, from points uniform in the box, ends at the
target. No trial of a race has a part in this. Raced are the four that reached most targets on
the hard half of springpot-60, the best there without derivatives and residuals, and two that are
well known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count, islice
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drawn_problems import SWEEPS, described, place, searched
from paper.asking import asked
from springpot.benchmark import Findings, Store, Study, save_table
from springpot.benchmark.plan import reference_of
from springpot.benchmark.traits import descents, uniform
from springpot.identification.problem import SpecimenProblem
from springpot.measurement import DataSet
from suite import SUITES, TARGET, measured, plan, write
from suite_race import by_part

SUITE = "springpot-hard-20"
SEED, MANY = 60, 10
PROTOCOLS = SWEEPS
ROUGH = ("elasto-sliding", "backlash", "dead-zone", "friction", "backlash-in-time")
"""Effects of which a force or its derivative jumps."""
FEATURED = 64
RIVALS = (
    *("auto", "least-squares-alternating", "least-squares", "optimagic-scipy-truncated-newton"),
    *("ipop-cma-es", "l-shade", "pso-paper"),
)
PARTS = {"suite": ("hard", "deceptive")}

Sweeps: TypeAlias = Mapping[str, Mapping[str, Any]]
Rule: TypeAlias = Callable[[Mapping[str, Any], DataSet], bool]
"""Whether a problem is kept, by its row of the suite's description and its data."""


def demanding(told: Mapping[str, Any]) -> bool:
    """Whether a problem is a sweep of many parameters, three effects, or corners."""
    effects = told["model"].split(" + ")[1:]
    hard = len(told["truth"]) >= MANY or len(effects) > 2 or any(e in ROUGH for e in effects)
    return hard and told["tests"][0] in PROTOCOLS


def missed(known: DataSet, problem: SpecimenProblem) -> bool:
    """Whether no descent from a uniform point ends where that from the truth does."""
    goal = goal_of(known, problem)
    # Most problems are solved by the first few.
    few = np.array_split(uniform(problem, FEATURED), 8)
    return not any(np.any(descents(problem, points)[1] <= goal) for points in few)


def goal_of(known: DataSet, problem: SpecimenProblem) -> float:
    """The objective that is good enough, by where the descent from the truth ends."""
    best = float(descents(problem, place(known, problem)[None])[1][0])
    return best + TARGET * (reference_of(problem) - best)


def hard(told: Mapping[str, Any], known: DataSet) -> bool:
    """Whether a problem is demanding and no descent solves it."""
    return demanding(told) and missed(known, searched(known))


def kept(suite: str, seed: int, rule: Rule, sweeps: Sweeps) -> Iterator[dict[str, Any]]:
    """Rows of a suite's description, without end."""
    for number in count(1):
        name = f"drawn-{number}"
        told, known = described(f"{suite}/{name}", seed, number, sweeps)
        if rule(told, known):
            print(number, told["model"], told["tests"], flush=True)
            wide = told.pop("wide")
            box = f"a box {wide:g} times as wide as usual" if wide > 1.0 else "the usual box"
            says = f"Number {number} that seed {seed} draws, in {box}."
            yield {"name": name, **told, "says": says}


def written(value: object) -> str:
    """A value as TOML has it."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f'"{key}" = {each!r}' for key, each in value.items()) + " }"
    return repr(value).replace("'", '"')


def description(suite: str, script: str, sweeps: Sweeps, rows: list[dict[str, Any]]) -> str:
    """The suite as a file."""
    text = f"# The problems of {suite}, as studies/{script}.py drew them. Nothing here may change."
    tests = {f"[protocol.{name}]": {"kind": "sweep", **each} for name, each in sweeps.items()}
    for head, row in (*tests.items(), *(("[[problem]]", row) for row in rows)):
        lines = (f"{key} = {written(value)}" for key, value in row.items() if value is not None)
        text += "\n".join(("\n", head, *lines))
    return text + "\n"


def make(suite: str, script: str, seed: int, rule: Rule, sweeps: Sweeps) -> None:
    """Draw a suite of twenty, and measure it."""
    rows = list(islice(kept(suite, seed, rule, sweeps), 20))
    text = description(suite, script, sweeps, rows)
    (SUITES / f"{suite}.toml").write_text(text, encoding="utf-8")
    write(suite, {}, {})
    measure(suite, {})


def measure(suite: str, ends: Mapping[str, Sequence[Mapping[str, float]]]) -> None:
    """Measure the problems of a suite, also with what is known of where trials ended."""
    found = {
        case.source.name: measured(case, ends.get(case.source.name, ()))
        for case in plan(suite).cases
    }
    write(
        suite,
        found,
        {name: "deceptive" if each.deceptive else "hard" for name, (_, each) in found.items()},
    )


def finish(path: Path, folder: Path) -> None:
    """Write the table by the parts of the suite."""
    with Store(path) as store:
        findings = Findings.of(store)
    save_table(
        asked(study, by_part(findings, SUITE, PARTS, "suite")), folder, "parts", ("md", "csv")
    )


study = Study(
    "suite_hard",
    datasets=[SUITE],
    models=["own"],
    objectives=["own"],
    optimisers=RIVALS,
    repetitions=2,
    budget=8000,
    stop_at_target=True,
    asks=(
        "Does `auto`, which reaches every target of springpot-60, do so on problems that were drawn"
        " to be harder by a rule that does not know of it?",
        "Share of trials within a millionth of the way to the best known value by 8,000"
        " evaluations, with its interval: of `auto`, the three that come after it on the hard"
        " half of springpot-60, and three without derivatives and residuals.",
        "More than 95 %: the suite is still too easy to tell the best apart. No more: where it"
        " misses tells what the next one has to learn.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    make(SUITE, "suite_hard", SEED, hard, PROTOCOLS)
