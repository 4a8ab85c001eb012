"""The tables of the main study, computed anew from its archive by other hands: numpy, no springpot.

    python recomputed_suite.py RESULTS springpot-60.csv

RESULTS holds suite_race with its archive, parts.csv and selector.csv, and suite_repeated with its
archive and judged.csv. Prints how many cells agree, and what the choice takes on unseen problems
beside the virtual best, by the trials of the race, by further ones, and by one half of these while
the other judges, with bootstrap intervals over problems; exit code 1 if a cell disagrees.
"""

from __future__ import annotations

import csv
import io
import json
import sys
import zipfile
from math import isclose, sqrt
from pathlib import Path

import numpy as np

PARTS = {
    "easy half": ("easy",),
    "hard half": ("hard", "deceptive"),
    "hard": ("hard",),
    "deceptive": ("deceptive",),
}
CHOICE, ALONE = "auto", "least-squares-alternating"
FAILED = 10.0


def rows_of(archive, name):
    with zipfile.ZipFile(archive) as whole, whole.open(name) as stream:
        yield from csv.reader(io.TextIOWrapper(stream, "utf-8", newline=""))


class Race:
    """Hits and cost of all trials, by problem and optimiser."""

    def __init__(self, archive, suite):
        with zipfile.ZipFile(archive) as whole:
            told = json.loads(whole.read("study.json"))
        with Path(suite).open(newline="", encoding="utf-8") as stream:
            self.suite = {row["problem"]: row for row in csv.DictReader(stream)}
        self.budget, fraction = int(told["facts"]["budget"]), float(told["facts"]["target"])
        self.cells, problems = told["cells"], told["problems"]
        rows = rows_of(archive, "trials.csv")
        head = next(rows)
        trials = [dict(zip(head, row, strict=True)) for row in rows]
        traces = {}
        for cell, repetition, at, value, _ in rows_of(archive, "traces.csv"):
            traces.setdefault((cell, repetition), []).append((int(at), float(value)))
        # Known before the race: what the paper's swarm finds outside the box moves nobody's target.
        best = {i: float(self.suite[p["dataset"]]["best"]) for i, p in enumerate(problems)}
        self.trials, self.gradients = {}, {}
        for row in trials:
            cell = self.cells[int(row["cell"])]
            least, reference = best[cell["problem"]], problems[cell["problem"]]["reference"]
            target = least + fraction * (reference - least)
            trace = traces.get((row["cell"], row["repetition"]), [])
            hit = next((at for at, value in trace if value <= target), np.inf)
            key = problems[cell["problem"]]["dataset"], cell["label"]
            self.trials.setdefault(key, []).append((hit, int(row["evaluations"])))
            self.gradients.setdefault(key, []).append(int(row["gradients"] or 0))
        self.labels = list(dict.fromkeys(cell["label"] for cell in self.cells))
        self.problems = list(dict.fromkeys(problem["dataset"] for problem in problems))

    def price(self, name, label):
        """What an evaluation costs if the derivative by each parameter counts as one."""
        graded = np.median(self.gradients[name, label])
        made = np.median([evaluations for _, evaluations in self.trials[name, label]])
        return 1 + int(self.suite[name]["parameters"]) * graded / made

    def charged(self, label, part):
        names = [p for p in self.problems if self.suite[p]["part"] in PARTS[part]]
        return share_over(
            [
                [
                    hit if hit * self.price(name, label) <= self.budget else np.inf
                    for hit, _ in self.trials[name, label]
                ]
                for name in names
            ]
        )

    def share(self, label, part):
        names = [p for p in self.problems if self.suite[p]["part"] in PARTS[part]]
        return share_over([[hit for hit, _ in self.trials[name, label]] for name in names])

    def running_time(self, problem, label):
        return time_of(self.trials[problem, label])

    def rivals(self, problem):
        return {n: each for (p, n), each in self.trials.items() if p == problem and n != CHOICE}

    def best(self, problem):
        return min(map(time_of, self.rivals(problem).values()))

    def best_by_the_other(self, problem):
        """Running time by one half of the trials of who was the quickest by the other half."""
        rivals, judging = self.rivals(problem), []
        for own in (0, 1):
            name = min(rivals, key=lambda name: time_of(rivals[name][own::2]))
            judging += rivals[name][1 - own :: 2]
        return min(time_of(judging), FAILED * self.budget)

    def over(self, label, problems, best, race=None):
        """Running times over the best one's, of the problems that somebody solves."""
        most, found = FAILED * self.budget, []
        for problem in problems:
            # Who was far from the best has its trials of the race only.
            whose = self if (problem, label) in self.trials else race
            if np.isfinite(self.best(problem)):
                found.append(min(whose.running_time(problem, label), most) / best(problem))
        return np.array(found)

    def over_best(self, label, problems):
        """Geometric mean over the virtual best, and how many problems are missed."""
        solved = [p for p in problems if np.isfinite(self.best(p))]
        missed = sum(not np.isfinite(self.running_time(p, label)) for p in solved)
        return mean(self.over(label, problems, self.best)), missed

    def halves(self):
        learnt = []
        for part in ("easy", "hard", "deceptive"):
            learnt += [p for p in self.suite if self.suite[p]["part"] == part][::2]
        return learnt, [p for p in self.suite if p not in learnt]


def time_of(trials):
    """Evaluations until success with restarts."""
    arrived = sum(np.isfinite(hit) for hit, _ in trials)
    spent = sum(hit if np.isfinite(hit) else evaluations for hit, evaluations in trials)
    return spent / arrived if arrived else np.inf


def mean(ratios):
    return float(np.exp(np.mean(np.log(ratios))))


def interval(ratios):
    """Geometric mean with a bootstrap interval."""
    drawn = np.random.default_rng(0).integers(0, len(ratios), (20_000, len(ratios)))
    return mean(ratios), *np.quantile(np.exp(np.log(ratios)[drawn].mean(axis=1)), [0.025, 0.975])


Z = 1.959963984540054
STUDENT = {
    4: 2.7764451051977934,
    9: 2.262157162798205,
    10: 2.228138851986274,
    18: 2.1009220402410382,
    19: 2.0930240544083087,
    24: 2.0638985616280245,
    29: 2.045229642132703,
}
"""Two-sided 5 % point of Student's t, by degrees of freedom: one less than there are problems."""


def wilson(rate, n):
    wide = 1 + Z * Z / n
    centre = (rate + Z * Z / (2 * n)) / wide
    half = Z / wide * sqrt(rate * (1 - rate) / n + Z * Z / (4 * n * n))
    return max(centre - half, 0.0), min(centre + half, 1.0)


def share_over(problems):
    """Share of trials with its interval over problems, by the design effect of a cluster sample."""
    shares = [np.mean(np.isfinite(hits)) for hits in problems]
    k, trials, rate = len(shares), sum(map(len, problems)), float(np.mean(shares))
    all_hit, none_hit = wilson(1.0, k), wilson(0.0, k)
    if rate in (0.0, 1.0):
        return rate, *(all_hit if rate else none_hit)
    independent = rate * (1 - rate) / trials
    effect = max(sum((share - rate) ** 2 for share in shares) / (k * (k - 1)) / independent, 1.0)
    low, high = wilson(rate, trials / effect * (Z / STUDENT[k - 1]) ** 2)
    return rate, min(low, all_hit[0]), max(high, none_hit[1])


def judged(race, more, label):
    """The choice over the best of each problem: three ways to tell the best, on both halves."""
    there = {problem for problem, _ in more.trials}
    for half in race.halves():
        problems = [problem for problem in half if problem in there]
        yield interval(race.over(label, problems, race.best))
        yield interval(more.over(label, problems, more.best, race))
        yield interval(more.over(label, problems, more.best_by_the_other, race))


def tables(race, more):
    learnt, unseen = race.halves()
    parts, selector = {}, {}
    for label in race.labels:
        shares = [*(race.share(label, part) for part in PARTS), race.charged(label, "hard half")]
        parts[label] = [number for share in shares for number in share]
        early, (late, missed) = race.over_best(label, learnt)[0], race.over_best(label, unseen)
        selector[label] = [early, late, missed]
    ways = {name: np.ravel(list(judged(race, more, name))) for name in (CHOICE, ALONE)}
    names = ("suite_race/parts", "suite_race/selector", "suite_repeated/judged")
    return dict(zip(names, (parts, selector, ways), strict=True))


def compared(made, folder):
    """How many cells agree, and those that do not."""
    agree, wrong = 0, []
    for name, own in made.items():
        with (Path(folder) / f"{name}.csv").open(newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))[1:]
        if sorted(row[0] for row in rows) != sorted(own):
            wrong.append((name, "optimisers"))
        for row in rows:
            for i, (written, number) in enumerate(zip(row[1:], own[row[0]], strict=True)):
                if isclose(float(written), number, rel_tol=1e-9, abs_tol=1e-12):
                    agree += 1
                else:
                    wrong.append((name, row[0], i, written, number))
    return agree, wrong


def races(results, suite):
    """The race, and the further trials."""
    names = ("suite_race", "suite_repeated")
    return [Race(Path(results) / name / f"{name}.zip", suite) for name in names]


if __name__ == "__main__":
    made = tables(*races(*sys.argv[1:3]))
    count, off = compared(made, sys.argv[1])
    print(f"{count} cells agree, {len(off)} do not", *off, sep="\n")
    ways = made["suite_repeated/judged"][CHOICE].reshape(-1, 3)[3:]
    for way, told in zip(("the race", "more trials", "others"), ways, strict=True):
        print(f"{CHOICE} on unseen problems by {way}: {told[0]:.2f} [{told[1]:.2f}, {told[2]:.2f}]")
    sys.exit(bool(off))
