"""A study's tables, computed anew from its exported trials by other hands: numpy, no springpot.

    python recomputed.py EXPORT TABLES

EXPORT holds trials.csv and traces.csv of ``springpot export --format csv``, TABLES the CSV tables
that ``springpot run`` wrote. Every cell is compared but the ends of bootstrap intervals, which hang
on random numbers, and times. Prints how many cells agree; exit code 1 if any does not.
"""

from __future__ import annotations

import csv
import sys
from itertools import combinations
from math import comb, erfc, exp, factorial, gamma, inf, isclose, sqrt
from pathlib import Path

import numpy as np

WHO = ("dataset", "model", "objective", "optimiser")
DECADES = 10.0 ** np.arange(-0.5, -8.01, -0.5)


def rows_of(path):
    csv.field_size_limit(10**7)
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def number(text):
    return float(text) if text else None


class Race:
    """All trials: arrays (optimisers, repetitions) for each problem."""

    def __init__(self, folder):
        trials, traces = rows_of(folder / "trials.csv"), rows_of(folder / "traces.csv")
        self.budget = int(trials[0]["budget"])
        self.optimisers = list(dict.fromkeys(row["optimiser"] for row in trials))
        self.problems = list(dict.fromkeys(tuple(row[w] for w in WHO[:3]) for row in trials))
        self.cells = {}
        for row in trials:
            self.cells.setdefault(tuple(row[w] for w in WHO), []).append(row)
        self.points = {}
        for row in traces:
            key = (*(row[w] for w in WHO), row["repetition"])
            self.points.setdefault(key, []).append((int(row["evaluations"]), float(row["best"])))
        row = next(row for row in trials if row["target"])
        best, reference = float(row["f_best"]), float(row["reference"])
        self.target = float(f"{(float(row['target']) - best) / (reference - best):.6g}")
        self.marks = [m for m in (100, 500, 2000, 8000, 40000, 200000, 10**6) if m < self.budget]
        self.marks = [*self.marks[-3:], self.budget]

    def trace(self, row):
        """Evaluations and excesses of a trial, at its improvements and at some others."""
        points = self.points.get((*(row[w] for w in WHO), row["repetition"]), [])
        if not row["best"] or not points:
            return np.empty(0), np.empty(0)
        at, values = np.array(points).T
        best, reference = float(row["f_best"]), float(row["reference"])
        return at, np.maximum(values - best, 0.0) / (reference - best)

    def excess(self, row, mark):
        at, values = self.trace(row)
        known = values[at <= mark]
        return known[-1] if len(known) else inf

    def array(self, problem, function):
        cells = [self.cells[*problem, name] for name in self.optimisers]
        return np.array([[function(row) for row in cell] for cell in cells])

    def hits(self, problem):
        return self.array(problem, lambda row: float(row["hit"]) if row["hit"] else inf)

    def spent(self, problem):
        return self.array(problem, lambda row: float(row["evaluations"]))

    def reached(self, problem, mark):
        found = self.array(problem, lambda row: self.excess(row, mark))
        return np.maximum(found, self.target)

    def area(self, problem):
        return self.array(problem, self.area_of)

    def area_of(self, row):
        at, values = self.trace(row)
        lasting = np.diff(np.append(at, self.budget + 1))
        return (
            lasting
            @ (np.log10(np.clip(values, self.target, 1)) / np.log10(self.target))
            / (self.budget)
        )

    def dimension(self, problem):
        # Names of parameters hold colons, too.
        return max(row["theta"].count('": ') for name in self.optimisers
                   for row in self.cells[*problem, name])  # fmt: skip


def ranks(values):
    """Ranks of an array as a whole, ties sharing their mean."""
    flat = np.asarray(values).ravel()
    below = (flat[:, None] > flat).sum(axis=1)
    return (below + ((flat[:, None] == flat).sum(axis=1) + 1) / 2).reshape(np.shape(values))


def wilson(successes, n):
    z = 1.959963984540054
    rate, wide = successes / n, 1 + z * z / n
    centre = (rate + z * z / (2 * n)) / wide
    half = z / wide * sqrt(rate * (1 - rate) / n + z * z / (4 * n * n))
    return rate, centre - half if successes else 0.0, centre + half if successes < n else 1.0


def middle(values):
    """Median; of two with an infinity the infinity."""
    ordered = sorted(values)
    if not ordered:
        return None
    low, high = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
    return low if low == high else (low + high) / 2


def quartile(values, share):
    return sorted(values)[max(0, int(np.ceil(share * len(values))) - 1)]


def running_time(hits, spent):
    good = np.isfinite(hits)
    return np.where(good, hits, spent).sum() / good.sum() if good.any() else inf


def chance(a, b):
    return (np.sum(a[:, None] < b) + 0.5 * np.sum(a[:, None] == b)) / (len(a) * len(b))


def holm(p):
    adjusted, worst = np.empty(len(p)), 0.0
    for step, i in enumerate(sorted(range(len(p)), key=lambda i: p[i])):
        worst = max(worst, min(1.0, p[i] * (len(p) - step)))
        adjusted[i] = worst
    return adjusted


def signed_rank(gaps):
    """Two-sided p by all signs that chance could give (Pratt), or the normal approximation."""
    order = ranks(np.abs(gaps))[gaps != 0]
    positive = order[gaps[gaps != 0] > 0].sum()
    least = min(positive, order.sum() - positive)
    if len(order) > 50:
        return erfc((order.sum() / 2 - least) / sqrt((order**2).sum() / 2))
    # In how many ways twice a sum comes about, one rank after the other.
    ways = np.ones(1)
    for rank in np.rint(2 * order).astype(int):
        ways = np.pad(ways, (0, rank)) + np.pad(ways, (rank, 0))
    return min(1.0, 2 * ways[: round(2 * least) + 1].sum() / ways.sum())


def mann_whitney(a, b):
    n, m = len(a), len(b)
    both = np.concatenate([a, b])
    u = ranks(both)[:n].sum() - n * (n + 1) / 2
    ties = np.unique(both, return_counts=True)[1]
    variance = n * m / 12 * (n + m + 1 - (ties**3 - ties).sum() / ((n + m) * (n + m - 1)))
    if variance <= 0:
        return 1.0
    z = (abs(u - n * m / 2) - 0.5) / sqrt(variance)
    return min(1.0, max(erfc(z / sqrt(2)), 2 / comb(n + m, n)))


def pairwise(k, test):
    pairs = list(combinations(range(k), 2))
    table = np.eye(k)
    for (i, j), p in zip(pairs, holm([test(i, j) for i, j in pairs]), strict=True):
        table[i, j] = table[j, i] = p
    return table


def friedman(blocks):
    """By chi squared of k - 1 degrees of freedom, whose tail is summed by hand."""
    within = np.array([ranks(block) for block in blocks])
    n, k = within.shape
    tied = sum((c**3 - c).sum() for c in (np.unique(b, return_counts=True)[1] for b in within))
    if not np.ptp(within):
        return 1.0
    x = 12 / (n * k * (k + 1)) * (within.sum(axis=0) ** 2).sum() - 3 * n * (k + 1)
    x /= 2 * (1 - tied / (n * k * (k * k - 1)))
    a = 1.0 if k % 2 else 0.5
    tail = exp(-x) if k % 2 else erfc(sqrt(x))
    while a < (k - 1) / 2:
        tail += x**a * exp(-x) / gamma(a + 1)
        a += 1
    return max(tail, 1 / factorial(k) ** (n - 1))


def summary(race):
    for problem in race.problems:
        for i, name in enumerate(race.optimisers):
            rows = race.cells[*problem, name]
            good = [row for row in rows if row["best"]]
            hits, spent = race.hits(problem)[i], race.spent(problem)[i]
            errors = [number(row["parameter_error"]) for row in good if row["parameter_error"]]
            oracles = [number(row["oracle"]) for row in good if row["oracle"]]
            rate, low, high = wilson(np.isfinite(hits).sum(), len(rows))
            yield (*problem, name), {
                "trials": len(rows), "failed": len(rows) - len(good),
                "success": rate, "success low": low, "success high": high,
                "evaluations to target": middle(hits),
                "expected running time": running_time(hits, spent),
                "parameter error": middle(errors), "objective reached": middle(
                    [number(row["best"]) for row in good]), "noise-free objective": middle(oracles),
            }  # fmt: skip


def progress(race):
    targets = np.append(DECADES[1.01 * race.target < DECADES], race.target)
    for problem in race.problems:
        for name in race.optimisers:
            told = {}
            for mark in race.marks:
                values = [race.excess(row, mark) for row in race.cells[*problem, name]]
                for end, share in (("", 0.5), (" low", 0.25), (" high", 0.75)):
                    told[f"excess at {mark}{end}"] = quartile(values, share)
                told[f"targets at {mark}"] = np.mean(np.array(values)[:, None] <= targets)
            yield (*problem, name), told


def blocks_of(race, problems, mark):
    reached = [race.reached(problem, mark) for problem in problems]
    return reached, np.array([ranks(r).mean(axis=1) for r in reached])


def ranking(race, mark):
    reached, blocks = blocks_of(race, race.problems, mark)
    means = np.mean([ranks(block) for block in blocks], axis=0)
    p = pairwise(len(means), lambda i, j: signed_rank(blocks[:, i] - blocks[:, j]))
    return reached, blocks, means, p


def ranks_table(race):
    k = len(race.optimisers)
    for mark in race.marks:
        _, blocks, means, p = ranking(race, mark)
        least = min(1.0, 2 ** (1 - len(blocks)) * k * (k - 1) / 2)
        for i, name in enumerate(race.optimisers):
            alike = [race.optimisers[j] for j in np.argsort(means, kind="stable")
                     if j != i and p[i, j] > 0.05]  # fmt: skip
            told = {"mean rank": means[i], "least p": least, "p of Friedman": friedman(blocks)}
            if least <= 0.05:
                told["not told from"] = ", ".join(alike)
            yield ("all problems", str(mark), name), told


def pairs(race):
    for mark in race.marks:
        reached, _, means, p = ranking(race, mark)
        order = np.argsort(means, kind="stable")
        for i, j in combinations(order, 2):
            chances = [chance(values[i], values[j]) for values in reached]
            key = str(mark), race.optimisers[i], race.optimisers[j]
            yield key, {"chance to end below": np.mean(chances), "p (Holm)": p[i, j]}


def choice(race):
    for problem in race.problems:
        for mark in race.marks:
            reached = race.reached(problem, mark)
            k, n = reached.shape
            means, hits = ranks(reached).mean(axis=1), race.hits(problem)
            hits = np.where(hits <= mark, hits, inf)
            spent = np.minimum(race.spent(problem), mark)
            times = [running_time(*each) for each in zip(hits, spent, strict=True)]
            p = pairwise(k, lambda i, j, r=reached: mann_whitney(r[i], r[j]))[np.argmin(means)]
            others = [i for i in range(k) if i != np.argmin(means)]
            alike = [int(np.argmin(means)), *(i for i in others if p[i] > 0.05)]
            alike.sort(key=lambda i: (times[i], means[i]))
            worse = sorted((i for i in others if p[i] <= 0.05), key=lambda i: means[i])
            first = alike[0]
            rate, low, high = wilson(np.isfinite(hits[first]).sum(), n)
            values = [
                race.excess(row, mark) for row in race.cells[*problem, race.optimisers[first]]
            ]
            dataset, model, objective = problem
            yield (model, dataset, objective, str(mark)), {
                "use": race.optimisers[first], "success": rate, "success low": low,
                "success high": high, "expected running time": times[first],
                "excess": quartile(values, 0.5),
                "as good": ", ".join(race.optimisers[i] for i in alike[1:]),
                "next": race.optimisers[worse[0]] if worse else None,
                "chance against next": chance(reached[first], reached[worse[0]]) if worse else None,
            }  # fmt: skip


def profiles(race):
    hits = np.concatenate([race.hits(problem).T for problem in race.problems])
    size = np.concatenate(
        [np.full(race.hits(p).shape[1], race.dimension(p) + 1.0) for p in race.problems]
    )
    best = hits.min(axis=1)
    for i, name in enumerate(race.optimisers):
        told = {f"{s:g} (d+1)": np.mean(hits[:, i] / size <= s)
                for s in (10, 30, 100, 300, 1000, 3000, 10000)}  # fmt: skip
        for ratio in (1, 2, 5, 10, 30, 100):
            solved = np.isfinite(hits[:, i]) & (hits[:, i] <= ratio * best)
            told[f"{ratio:g} x best"] = solved.mean()
        yield (name,), told


def anytime(race):
    areas = np.array([race.area(problem).mean(axis=1) for problem in race.problems])
    places = np.mean([ranks(-row) for row in areas], axis=0)
    for i, name in enumerate(race.optimisers):
        told = {"area over the curve": areas[:, i].mean(), "mean rank by area": places[i]}
        yield (name,), told | {"problems": len(race.problems)}


def shown(level):
    """A level as a table has it."""
    return f"{level:.4g}"


def attainment(race):
    levels = [level for level in (1e-1, 1e-2, 1e-4) if level > 1.01 * race.target] + [race.target]
    for name in race.optimisers:
        for level in levels:
            told = {}
            for mark in race.marks:
                # A row for each problem, whose trials need not be as many as another's.
                shares = [
                    np.mean([race.excess(row, mark) <= level for row in race.cells[*problem, name]])
                    for problem in race.problems
                ]
                told[f"by {mark}"] = np.mean(shares)
            yield (name, shown(level)), told


def sensitivity(race):
    def places(problems):
        blocks = blocks_of(race, problems, race.budget)[1]
        means = np.round(np.mean([ranks(block) for block in blocks], axis=0), 9)
        return means, [1 + sum(other < mean for other in means) for mean in means]

    means, whole = places(race.problems)
    parts = [[p for p in race.problems if p != left] for left in race.problems]
    models = [p[1] for p in race.problems]
    for model in dict.fromkeys(models):
        if 1 < models.count(model) < len(models):
            parts.append([p for p in race.problems if p[1] != model])
    without = [places(part)[1] for part in parts]
    for i, name in enumerate(race.optimisers):
        moved = [each[i] for each in without]
        yield (name,), {"mean rank": means[i], "place": whole[i], "best": min(moved),
                        "worst": max(moved)}  # fmt: skip


TABLES = {
    "summary": (("data set", "model", "objective", "optimiser"), summary),
    "progress": (("data set", "model", "objective", "optimiser"), progress),
    "ranks": (("problems", "budget", "optimiser"), ranks_table),
    "pairs": (("budget", "optimiser", "against"), pairs),
    "choice": (("model", "data set", "objective", "budget"), choice),
    "profiles": (("optimiser",), profiles),
    "anytime": (("optimiser",), anytime),
    "attainment": (("optimiser", "excess"), attainment),
    "sensitivity": (("optimiser",), sensitivity),
}


def same(text, value):
    if value is None or isinstance(value, str):
        return text == (value or "")
    return bool(text) and (
        float(text) == value or isclose(float(text), value, rel_tol=1e-7, abs_tol=1e-12)
    )


def compared(export, tables):
    """Cells that agree, and those that do not, in words."""
    race, agree, wrong = Race(export), 0, []
    for name, (keys, compute) in TABLES.items():
        shown = {tuple(row[key] for key in keys): row for row in rows_of(tables / f"{name}.csv")}
        for key, told in compute(race):
            for column, value in told.items():
                text = shown[key][column]
                if same(text, value):
                    agree += 1
                else:
                    wrong.append(f"{name}, {key}, {column}: {text}, here {value}")
    return agree, wrong


if __name__ == "__main__":
    agreeing, differing = compared(Path(sys.argv[1]), Path(sys.argv[2]))
    print(*differing[:20], sep="\n")
    print(f"{agreeing} cells agree, {len(differing)} do not")
    sys.exit(bool(differing))
