"""The tables of the main study, computed anew from its archive by other hands: numpy, no springpot.

    python recomputed_suite.py ARCHIVE.zip springpot-60.csv FOLDER

FOLDER holds parts.csv and selector.csv. Prints how many cells agree, and what the choice takes on
unseen problems beside the virtual best, chosen by both trials of each optimiser and by one of them
while the other judges, with bootstrap intervals over problems; exit code 1 if a cell disagrees.
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
CHOICE = "auto"
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
        self.trials = {}
        for row in trials:
            cell = self.cells[int(row["cell"])]
            least, reference = best[cell["problem"]], problems[cell["problem"]]["reference"]
            target = least + fraction * (reference - least)
            trace = traces.get((row["cell"], row["repetition"]), [])
            hit = next((at for at, value in trace if value <= target), np.inf)
            key = problems[cell["problem"]]["dataset"], cell["label"]
            self.trials.setdefault(key, []).append((hit, int(row["evaluations"])))
        self.labels = list(dict.fromkeys(cell["label"] for cell in self.cells))
        self.problems = list(dict.fromkeys(problem["dataset"] for problem in problems))

    def share(self, label, part):
        names = [p for p in self.problems if self.suite[p]["part"] in PARTS[part]]
        hits = [hit for name in names for hit, _ in self.trials[name, label]]
        return wilson(sum(np.isfinite(hit) for hit in hits), len(hits))

    def running_time(self, problem, label):
        trials = self.trials[problem, label]
        arrived = sum(np.isfinite(hit) for hit, _ in trials)
        spent = sum(hit if np.isfinite(hit) else evaluations for hit, evaluations in trials)
        return spent / arrived if arrived else np.inf

    def rivals(self, problem):
        return {name: self.trials[problem, name] for name in self.labels if name != CHOICE}

    def best(self, problem):
        return min(self.running_time(problem, name) for name in self.rivals(problem))

    def best_by_the_other(self, problem):
        """Running time of who was the quickest in the other of two trials."""
        rivals, arrived, spent = self.rivals(problem), 0, 0
        for own in (0, 1):
            name = min(rivals, key=lambda name: rivals[name][1 - own][0])
            hit, evaluations = rivals[name][own]
            arrived += np.isfinite(hit)
            spent += hit if np.isfinite(hit) else evaluations
        return spent / arrived if arrived else FAILED * self.budget

    def over(self, label, problems, best):
        """Running times over the best one's, of the problems that somebody solves."""
        solved = [p for p in problems if np.isfinite(self.best(p))]
        most = FAILED * self.budget
        return np.array([min(self.running_time(p, label), most) / best(p) for p in solved])

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


def mean(ratios):
    return float(np.exp(np.mean(np.log(ratios))))


def told(ratios):
    """Geometric mean with a bootstrap interval."""
    drawn = np.random.default_rng(0).integers(0, len(ratios), (20_000, len(ratios)))
    low, high = np.quantile(np.exp(np.log(ratios)[drawn].mean(axis=1)), [0.025, 0.975])
    return f"{mean(ratios):.2f} [{low:.2f}, {high:.2f}]"


def wilson(successes, n):
    z = 1.959963984540054
    rate, wide = successes / n, 1 + z * z / n
    centre = (rate + z * z / (2 * n)) / wide
    half = z / wide * sqrt(rate * (1 - rate) / n + z * z / (4 * n * n))
    low = centre - half if successes else 0.0
    return rate, low, centre + half if successes < n else 1.0


def tables(race):
    learnt, unseen = race.halves()
    parts, selector = {}, {}
    for label in race.labels:
        parts[label] = [number for part in PARTS for number in race.share(label, part)]
        early, (late, missed) = race.over_best(label, learnt)[0], race.over_best(label, unseen)
        selector[label] = [early, late, missed]
    return {"parts": parts, "selector": selector}


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


if __name__ == "__main__":
    whole = Race(*sys.argv[1:3])
    count, off = compared(tables(whole), sys.argv[3])
    print(f"{count} cells agree, {len(off)} do not", *off, sep="\n")
    for by, chosen in (("both trials", whole.best), ("the other", whole.best_by_the_other)):
        ratios = whole.over(CHOICE, whole.halves()[1], chosen)
        print(f"{CHOICE} on unseen problems over the best chosen by {by}: {told(ratios)}")
    sys.exit(bool(off))
