"""The choice of an optimiser: rules learnt from half of springpot-60 and tried on the other half.

    python studies/suite_choice.py learn     learns the rules anew (plugins/.../auto.toml)
    python studies/suite_choice.py           says how near `auto` came to the virtual best

Trials are those of the archive of suite_race. Where the rules are others than before, `auto` is
raced again: springpot run results/suite_race/suite_race.zip --optimiser auto, and
studies/suite_repeated.py without its store.

Question: does a choice by features that cost at most 5 % of the budget come near the best optimiser
of each problem on problems from which nothing was learnt? Measure: expected running time over that
of the virtual best, the quickest optimiser of each problem, as a geometric mean over the unseen
half. What would answer it: at most 1.25; and less than the best single optimiser's.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields
from itertools import cycle, permutations, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.benchmark import Table, save_table
from springpot.benchmark.plan import problem_of, reference_of
from springpot.benchmark.statistics import expected_running_time
from springpot.identification.problem import Problem
from springpot.identification.recorder import Recorder
from springpot.rheology import Real
from springpot_plugins.optimisers import auto
from springpot_plugins.optimisers.auto import NEGLIGIBLE, Auto, Seen, Watched, leaf, looked
from springpot_plugins.optimisers.leastsquares import LeastSquares
from suite import SUITE, TARGET, plan, sweeps
from suite_repeated import BUDGET, FAILED, RACE, Trials, archived, halves

ROOT = Path(__file__).parents[1]
RULES = ROOT / "plugins" / "springpot_plugins" / "optimisers" / "auto.toml"
OWN = Auto.name
KINDS = tuple(
    {"method": method, "logarithmic": logarithmic}
    for method in ("trf", "dogbox")
    for logarithmic in (True, False)
)
"""Descents that are tried."""
SAME = ("least-squares", "least-squares-alternating", "optimagic-scipy-ls-dogbox")
"""Who makes no other descents than these, and has no turn beside them."""
LENGTHS = (30, 50, 80, 120, 200, 400)
"""Evaluations after which one is ended."""
TURNS = (0.1, 0.2, 0.3, 0.45)
"""Shares of the budget for which descents and the chosen optimiser take turns."""
TRIED, TRIED_IN_TIME = 30, 8
"""Descents of each kind on each problem, and on those with tests in time."""
DRAWN = 40
"""Runs of descents that are put together from those."""
DRAWS = 5
"""Looks at each problem, from different points."""
DEEPEST, FEWEST = 2, 4
"""Questions that the tree asks at most, and problems that are left to the least of its leaves."""
RANKED = 4
"""Optimisers of a leaf, of which the first that is installed is chosen."""
EXTRAS = ("dfo-", "minion-", "minuit-", "nevergrad-", "optimagic-", "pymoo-")

Order = tuple[int, ...]


def training() -> list[tuple[str, Problem, float]]:
    """Name, problem and target of those that are learnt from."""
    half, found = halves()[0], []
    for case in plan().cases:
        source = case.source
        if source.name in half and source.best is not None:
            problem = problem_of(source, source.model_of(case.model), case.objective)
            goal = source.best + TARGET * (reference_of(problem) - source.best)
            found.append((source.name, problem, goal))
    return found


def looks(budget: int) -> dict[str, list[Seen]]:
    """What is seen of each problem, from several draws."""
    limit = int(Auto().share * budget)
    with np.errstate(all="ignore"):
        return {
            name: [
                looked(Recorder(problem, budget), limit, np.random.default_rng(draw))
                for draw in range(DRAWS)
            ]
            for name, problem, _ in training()
        }


Bank = dict[str, Real]
"""By problem (kinds, n, 2): evaluations of a descent, and those at which it met the target."""


def bank() -> Bank:
    """Single descents of every kind."""
    found: Bank = {}
    for name, problem, goal in training():
        count = TRIED if name in sweeps() else TRIED_IN_TIME
        found[name] = np.array(
            [
                [_descent(problem, goal, kind, np.random.default_rng(i)) for i in range(count)]
                for kind in KINDS
            ]
        )
    return found


def _descent(
    problem: Problem, goal: float, kind: Mapping[str, Any], rng: np.random.Generator
) -> tuple[float, float]:
    run = Recorder(problem, max(LENGTHS))
    watched = Watched(run, max(LENGTHS), kind["logarithmic"])
    start = run.lower + rng.random(run.dimension) * (run.upper - run.lower)
    with np.errstate(all="ignore"), suppress(Exception):
        LeastSquares(tolerance=NEGLIGIBLE, **kind).descend(watched, start)
    return run.evaluations, next((at for at, value in run.trace if value <= goal), np.inf)


def expected(runs: Real, order: Order, longest: int) -> float:
    """Expected evaluations until descents in this order, over and over, meet the target."""
    total, open_still = 0.0, 1.0
    for kind in order:
        met = runs[kind, :, 1] <= longest
        spent = np.where(met, runs[kind, :, 1], np.minimum(runs[kind, :, 0], longest))
        total += open_still * float(spent.mean())
        open_still *= 1.0 - float(met.mean())
    return total / (1.0 - open_still) if open_still < 1.0 else np.inf


def rotation(known: Bank, budget: int) -> tuple[Order, int]:
    """The order of kinds, each at most once, and the length that take least on all problems."""
    orders = [o for n in range(1, len(KINDS) + 1) for o in permutations(range(len(KINDS)), n)]

    def level(way: tuple[Order, int]) -> float:
        times = [min(expected(runs, *way), FAILED * budget) for runs in known.values()]
        return float(np.mean(np.log10(times)))

    return min(product(orders, LENGTHS), key=level)


def put_together(runs: Real, order: Order, longest: int, budget: int) -> Real:
    """Evaluations (n,) at which runs of such descents meet the target, infinite if they do not."""
    rng, hits = np.random.default_rng(0), np.full(DRAWN, np.inf)
    for i in range(DRAWN):
        spent = 0.0
        for kind in cycle(order):
            taken, met = runs[kind, rng.integers(runs.shape[1])]
            if spent + met <= budget and met <= longest:
                hits[i] = spent + met
            spent += max(1.0, min(taken, longest))
            if np.isfinite(hits[i]) or spent >= budget:
                break
    return hits


def cost(first: Real, own: Real, share: float, budget: int) -> float:
    """Expected running time of descents for a share of the budget, then in turns with another.

    Parameters
    ----------
    first, own : ndarray, shape (n,) and (m,)
        Evaluations at which descents and the other alone meet the target.
    share : float
        Of the budget, a turn.
    budget : int
        Evaluations of a trial.
    """
    limit, turn = Auto().share * budget, share * budget
    first, own = first[:, None], own[None, :]
    with np.errstate(invalid="ignore"):
        # It begins anew with each of its turns, of which it has the first.
        late = np.where(own <= turn, limit + own, np.inf)
        more = first + np.ceil((first - limit) / turn) * turn
    hits = np.where(first <= limit, first, np.fmin(late, more)).ravel()
    hits = np.where(hits <= budget, hits, np.inf)
    return min(expected_running_time(hits, np.full(len(hits), budget)), FAILED * budget)


def learnt(trials: Trials, budget: int) -> dict[str, Any]:
    """The rules."""
    known = bank()
    order, longest = rotation(known, budget)
    rules: dict[str, Any] = {"longest": longest, "turn": TURNS[0]}
    rules["descents"] = [KINDS[kind] for kind in order]
    # What is seen hangs on the descents.
    write(rules | {"tree": auto.rules()["tree"]})
    seen, problems = looks(budget), list(known)
    alone = {p: put_together(known[p], order, longest, budget) for p in problems}
    names = [name for name in next(iter(trials.values())) if name not in (OWN, *SAME)]
    best = np.inf
    for turn in TURNS:
        costs = np.log10(
            [[cost(alone[p], trials[p][name][0], turn, budget) for name in names] for p in problems]
        )
        level, tree = _tree(costs, [seen[p] for p in problems], names)
        if level < best:
            best, rules["turn"], rules["tree"] = level, turn, tree
    return rules


def _tree(costs: Real, seen: list[list[Seen]], names: list[str]) -> tuple[float, dict[str, Any]]:
    """Mean cost on problems that are left out one by one, and the tree from all of them."""
    keys = [each.name for each in fields(Seen)]
    # Each look at a problem is a row; all of a problem have its costs.
    owner = np.repeat(np.arange(len(seen)), DRAWS)
    rows = np.array([list(each.to_dict().values()) for looks in seen for each in looks])

    def grown(which: NDArray[np.bool_], depth: int) -> dict[str, Any]:
        return _grown(rows[which], costs[owner][which], owner[which], keys, names, depth)

    def left_out(depth: int) -> float:
        """Mean cost of each problem by the rules that are learnt without it."""
        total = 0.0
        for problem in range(len(seen)):
            tree, mine = grown(owner != problem, depth), rows[owner == problem]
            picks = [leaf(tree, dict(zip(keys, row, strict=True)))[0][0] for row in mine]
            total += float(np.mean([costs[problem, names.index(pick)] for pick in picks]))
        return total / len(seen)

    # As many questions as pay on problems that were left out.
    levels = [left_out(depth) for depth in range(DEEPEST + 1)]
    depth = int(np.argmin(levels))
    return levels[depth], grown(np.ones(len(rows), dtype=bool), depth)


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


def told(trials: Trials, budget: int) -> Table:
    """The table: each optimiser, and the choice, on both halves."""
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
    return Table("How near to the virtual best", columns, rows, note)


def main() -> None:
    """Learn, or say how well what was learnt chooses."""
    race = archived(RACE)
    if "learn" not in sys.argv:
        save_table(told(race, BUDGET), RACE.parent, "selector")
        return
    write(learnt(race, BUDGET))


def write(rules: Mapping[str, Any]) -> None:
    """Keep the rules where `auto` reads them."""
    text = f"# Learnt by studies/suite_choice.py from {len(halves()[0])} problems of {SUITE}.\n\n"
    text += f"longest = {rules['longest']}\nturn = {rules['turn']}\n"
    for kind in rules["descents"]:
        text += f'\n[[descents]]\nmethod = "{kind["method"]}"\n'
        text += f"logarithmic = {str(kind['logarithmic']).lower()}\n"
    RULES.write_text(f"{text}\n{toml(rules['tree'])}", encoding="utf-8")
    auto.rules.cache_clear()


if __name__ == "__main__":
    main()
