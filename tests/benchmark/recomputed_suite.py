"""The tables of the main study, computed anew from its archive by other hands: numpy, no springpot.

    python recomputed_suite.py ARCHIVE.zip springpot-60.csv FOLDER

FOLDER holds parts.csv and selector.csv. Prints how many cells agree; exit code 1 if any does not.
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

    def over_best(self, label, problems):
        """Geometric mean over the virtual best, and how many problems are missed."""
        ratios, missed = [], 0
        for problem in problems:
            rivals = [name for name in self.labels if name != CHOICE]
            best = min(self.running_time(problem, name) for name in rivals)
            if np.isfinite(best):
                own = self.running_time(problem, label)
                missed += not np.isfinite(own)
                ratios.append(min(own, FAILED * self.budget) / best)
        return float(np.exp(np.mean(np.log(ratios)))), missed

    def halves(self):
        learnt = []
        for part in ("easy", "hard", "deceptive"):
            learnt += [p for p in self.suite if self.suite[p]["part"] == part][::2]
        return learnt, [p for p in self.suite if p not in learnt]


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
    count, off = compared(tables(Race(*sys.argv[1:3])), sys.argv[3])
    print(f"{count} cells agree, {len(off)} do not", *off, sep="\n")
    sys.exit(bool(off))
