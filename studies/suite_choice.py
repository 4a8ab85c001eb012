"""The choice of an optimiser: rules learnt from half of springpot-60 and tried on the other half.

    springpot run studies/suite_race.py      races all, `auto` by the rules that there are
    python studies/suite_choice.py learn     learns them anew (plugins/.../optimisers/auto.toml)
    springpot run studies/suite_race.py      races `auto` again, if its rules are others
    python studies/suite_choice.py           says how near it came to the virtual best

Question: does a choice by features that cost at most 5 % of the budget come near the best optimiser
of each problem on problems from which nothing was learnt? Measure: expected running time over that
of the virtual best, the quickest optimiser of each problem, as a geometric mean over the unseen
half. What would answer it: at most 1.25; and less than the best single optimiser's.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot import plugins
from springpot.benchmark import Findings, Store, Table, save_table, store_path
from springpot.benchmark.cases import problem_of
from springpot.benchmark.statistics import expected_running_time
from springpot.identification.recorder import Recorder
from springpot.rheology import Real
from springpot_plugins.optimisers.auto import TURN, Auto, Seen, leaf, looked
from suite import SUITE, plan

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "results"
RULES = ROOT / "plugins" / "springpot_plugins" / "optimisers" / "auto.toml"
OWN, FIRST = Auto.name, "least-squares-alternating"
DRAWS = 5
"""Looks at each problem, from different points."""
DEEPEST, FEWEST = 2, 4
"""Questions that the tree asks at most, and problems that are left to the least of its leaves."""
FAILED = 10.0
"""Budgets that an optimiser is taken to need which never arrives."""
RANKED = 4
"""Optimisers of a leaf, of which the first that is installed is chosen."""
EXTRAS = ("dfo-", "minion-", "minuit-", "nevergrad-", "optimagic-", "pymoo-")

Trials = Mapping[str, Mapping[str, tuple[Real, Real]]]


def trials_of(findings: Findings) -> dict[str, dict[str, tuple[Real, Real]]]:
    """Hitting times and evaluations spent, by problem and optimiser."""
    found: dict[str, dict[str, tuple[Real, Real]]] = {}
    for scores in findings.scores:
        cell = scores.cell
        found.setdefault(cell.problem.dataset, {})[cell.label] = scores.hits, scores.spent
    return found


def halves() -> tuple[list[str], list[str]]:
    """The problems that are learnt from, and those that are not: every second of each part."""
    measured = plugins().find("suite", SUITE).measured
    parts: dict[str, list[str]] = {}
    for name, told in measured.items():
        parts.setdefault(told.part, []).append(name)
    learnt = [name for names in parts.values() for name in names[::2]]
    return learnt, [name for name in measured if name not in learnt]


def looks(budget: int) -> dict[str, list[Seen]]:
    """What is seen of each problem, from several draws."""
    limit, found = int(Auto().share * budget), dict[str, list[Seen]]()
    for case in plan().cases:
        problem = problem_of(case.source, case.source.model_of(case.model), case.objective)
        with np.errstate(all="ignore"):
            found[case.source.name] = [
                looked(Recorder(problem, budget), limit, np.random.default_rng(draw))
                for draw in range(DRAWS)
            ]
    return found


def cost(trials: Trials, problem: str, name: str, budget: int) -> float:
    """Expected running time of descents for a share of the budget, then in turns with another."""
    limit, turn = Auto().share * budget, TURN * budget
    first, spent = trials[problem][FIRST]
    if name == FIRST:
        return min(expected_running_time(first, spent), FAILED * budget)
    own = trials[problem][name][0]
    with np.errstate(invalid="ignore"):
        # Before either arrives, the other has had as many turns.
        late = limit + (np.ceil(own / turn) - 1.0) * turn + own
        more = first + np.ceil((first - limit) / turn) * turn
    hits = np.where(first <= limit, first, np.fmin(late, more))
    hits = np.where(hits <= budget, hits, np.inf)
    return min(expected_running_time(hits, np.full(len(hits), budget)), FAILED * budget)


def learnt(trials: Trials, seen: Mapping[str, list[Seen]], budget: int) -> dict[str, Any]:
    """The tree."""
    training = halves()[0]
    # Descents go on in any case: the rules say who takes turns with them.
    names = [name for name in next(iter(trials.values())) if name not in (OWN, FIRST)]
    costs = np.log10([[cost(trials, p, name, budget) for name in names] for p in training])
    rows = np.array(
        [[list(each.to_dict().values()) for each in seen[problem]] for problem in training]
    )
    keys = [each.name for each in fields(Seen)]
    # Each look at a problem is a row; all of a problem have its costs.
    owner = np.repeat(np.arange(len(training)), DRAWS)
    rows = rows.reshape(-1, len(keys))

    def grown(which: NDArray[np.bool_], depth: int) -> dict[str, Any]:
        return _grown(rows[which], costs[owner][which], owner[which], keys, names, depth)

    def left_out(depth: int) -> float:
        """Mean cost of each problem by the rules that are learnt without it."""
        total = 0.0
        for problem in range(len(training)):
            tree, mine = grown(owner != problem, depth), rows[owner == problem]
            picks = [leaf(tree, dict(zip(keys, row, strict=True)))[0][0] for row in mine]
            total += float(np.mean([costs[problem, names.index(pick)] for pick in picks]))
        return total

    # As many questions as pay on problems that were left out.
    depth = min(range(DEEPEST + 1), key=left_out)
    return grown(np.ones(len(rows), dtype=bool), depth)


def _grown(
    rows: Real, costs: Real, owner: Real, keys: list[str], names: list[str], depth: int
) -> dict[str, Any]:
    order = [names[i] for i in np.argsort(costs.mean(axis=0), kind="stable")]
    # Where no extra is installed, there is one that comes with springpot.
    own = next(name for name in order if not name.startswith(EXTRAS))
    leaf: dict[str, Any] = {"optimisers": list(dict.fromkeys([*order[:RANKED], own]))}
    # The quickest of all problems here is what a question must improve upon.
    best = (float(costs.mean(axis=0).min()) * len(rows) - 1e-9, 0, 0.0)
    for k in range(len(keys) if depth else 0):
        values = np.unique(rows[:, k])
        for limit in 0.5 * (values[1:] + values[:-1]):
            below = rows[:, k] < limit
            if min(len(np.unique(owner[below])), len(np.unique(owner[~below]))) < FEWEST:
                continue
            total = costs[below].sum(axis=0).min() + costs[~below].sum(axis=0).min()
            best = min(best, (float(total), k, float(limit)))
    if best[2] == 0.0:
        return leaf
    _, k, limit = best
    below = rows[:, k] < limit
    sides = {
        side: _grown(rows[here], costs[here], owner[here], keys, names, depth - 1)
        for side, here in (("below", below), ("above", ~below))
    }
    return {"feature": keys[k], "limit": float(f"{limit:.4g}"), **sides}


def toml(tree: Mapping[str, Any], name: str = "tree") -> str:
    """The tree as text."""
    lines = [f"[{name}]"]
    if "feature" not in tree:
        return f"[{name}]\noptimisers = {list(tree['optimisers'])!r}\n".replace("'", '"')
    lines += [f'feature = "{tree["feature"]}"', f"limit = {tree['limit']!r}", ""]
    return "\n".join(lines) + "\n".join(
        toml(tree[side], f"{name}.{side}") for side in ("below", "above")
    )


def ratios(trials: Trials, label: str, problems: list[str], budget: int) -> dict[str, float]:
    """An optimiser's expected running time over the virtual best's, where there is one."""
    found = {}
    for problem in problems:
        times = {name: expected_running_time(*each) for name, each in trials[problem].items()}
        best = min(time for name, time in times.items() if name != OWN)
        if np.isfinite(best):
            found[problem] = min(times[label], FAILED * budget) / best
    return found


def mean(values: Mapping[str, float]) -> float:
    """The geometric one."""
    return float(np.exp(np.mean(np.log(list(values.values())))))


def told(findings: Findings, folder: Path) -> None:
    """The table: each optimiser, and the choice, on both halves."""
    trials, budget = trials_of(findings), findings.scale.budget
    half, unseen = halves()
    labels = list(next(iter(trials.values())))
    rows = []
    for label in labels:
        on = [ratios(trials, label, problems, budget) for problems in (half, unseen)]
        missed = sum(not np.isfinite(trials[p][label][0]).any() for p in on[1])
        rows.append((label, mean(on[0]), mean(on[1]), missed))
    rows.sort(key=lambda row: row[2])
    note = (
        "Expected running time over that of the virtual best of each problem, as geometric means"
        f" over the half that was learnt from ({len(half)} problems) and the unseen one"
        f" ({len(unseen)}), without those that nobody solves; who never arrives is taken to need"
        f" {FAILED:g} budgets. Missed: unseen problems on which it never arrived."
    )
    columns = ("optimiser", "learnt from", "unseen", "missed")
    save_table(Table("How near to the virtual best", columns, rows, note), folder, "selector")


def main() -> None:
    """Learn, or say how well what was learnt chooses."""
    with Store(store_path("suite_race", RESULTS)) as store:
        findings = Findings.of(store)
    if "learn" not in sys.argv:
        told(findings, RESULTS / "suite_race")
        return
    budget = findings.scale.budget
    tree = learnt(trials_of(findings), looks(budget), budget)
    head = f"# Learnt by studies/suite_choice.py from {len(halves()[0])} problems of {SUITE}.\n\n"
    RULES.write_text(head + toml(tree), encoding="utf-8")


if __name__ == "__main__":
    main()
