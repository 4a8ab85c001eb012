"""Are the rivals only badly set? Every method tuned with the same effort, on other problems.

    python studies/suite_tuned.py [--tries 12] [--workers 2] [--out results]

Question: does the order of methods without derivatives hang on their settings? Each gets the same
number of settings to try, its defaults first and then draws from the ranges that its literature
uses; all are raced on problems of one half of springpot-60, and the one with the largest mean area
over the convergence curve is kept. Measure: that area and the share of trials at the target on
problems of the other half. What would answer it: the same order tuned as untuned.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from paper.asking import asking
from springpot import plugins
from springpot.benchmark import Findings, Store, Study, Table, run_study, save_table, store_path
from springpot.benchmark.plan import stream_of
from springpot.benchmark.statistics import Interval, mean_interval, mean_ranks, wilson_over
from springpot.report.page import Entry
from suite import sweeps
from suite_repeated import halves

NAME = "suite_tuned"
BUDGET, REPEATS = 2000, 2
Draw = Callable[[np.random.Generator], Mapping[str, Any]]
SPACES: dict[str, Draw] = {
    "cma-es": lambda rng: {
        "sigma": round(float(rng.uniform(0.05, 0.6)), 3),
        "population": int(rng.integers(6, 40)),
        "growth": float(rng.choice([1.0, 1.5, 2.0, 3.0])),
    },
    "differential-evolution": lambda rng: {
        "strategy": str(rng.choice(["best1bin", "rand1bin", "currenttobest1bin", "best2bin"])),
        "population": int(rng.integers(4, 20)),
        "mutation": (0.3, round(float(rng.uniform(0.4, 1.2)), 3)),
        "recombination": round(float(rng.uniform(0.3, 1.0)), 3),
    },
    "pso-paper": lambda rng: {
        "particles": int(rng.integers(8, 50)),
        "instances": 1000,
        "individuality": round(float(rng.uniform(0.5, 2.5)), 3),
        "sociality": round(float(rng.uniform(0.5, 2.5)), 3),
        "inertia_first": round(float(rng.uniform(0.5, 1.0)), 3),
        "inertia_last": round(float(rng.uniform(0.0, 0.5)), 3),
        "clamp": round(float(10.0 ** rng.uniform(-1.5, 0.5)), 3),
    },
    "spso-2011": lambda rng: {
        "particles": int(rng.integers(8, 60)),
        "informed": int(rng.integers(2, 6)),
        "inertia": round(float(rng.uniform(0.5, 0.85)), 3),
        "pull": round(float(rng.uniform(0.8, 1.6)), 3),
    },
    "l-shade": lambda rng: {
        "population": int(rng.integers(4, 25)),
        "archive": round(float(rng.uniform(1.0, 3.0)), 2),
        "elite": round(float(rng.uniform(0.05, 0.25)), 3),
        "memory": int(rng.integers(3, 10)),
    },
    "dual-annealing": lambda rng: {
        "temperature": round(float(10.0 ** rng.uniform(0.0, 4.0)), 3),
        "visit": round(float(rng.uniform(1.2, 2.9)), 3),
        "accept": round(float(rng.uniform(-50.0, -5.0)), 3),
        "restart_ratio": float(f"{10.0 ** rng.uniform(-6, -1):.2g}"),
    },
}
"""How a setting of each is drawn."""


def settings(name: str, tries: int) -> list[tuple[str, Any]]:
    """An optimiser by its defaults, then by drawn settings, each with its label."""
    kind, rng = plugins().find("optimiser", name), np.random.default_rng(stream_of(1, NAME, name))
    drawn = [kind(**SPACES[name](rng)) for _ in range(tries - 1)]
    return [(name, kind()), *((f"{name} #{i}", each) for i, each in enumerate(drawn, 1))]


def race(name: str, problems: Sequence[str], entrants: Sequence[tuple[str, Any]]) -> Study:
    """A race of settings on some problems."""
    return Study(
        f"{NAME}_{name}",
        datasets=list(problems),
        models=["own"],
        objectives=["own"],
        optimisers=list(entrants),
        repetitions=REPEATS,
        budget=BUDGET,
        stop_at_target=True,
    )


def raced(study: Study, workers: int | None, out: Path) -> Findings:
    """What came of a study, which goes on where it stopped."""
    run_study(study, workers, out=out, quiet=True, tables=False)
    with Store(store_path(study, out)) as store:
        return Findings.of(store)


def areas(findings: Findings) -> dict[str, Any]:
    """Area over the curve of each problem (n,), by label."""
    return {
        label: np.array([race.of_trials("area")[i].mean() for race in findings.races])
        for i, label in enumerate(findings.races[0].labels)
    }


def table(findings: Findings, chosen: Mapping[str, tuple[str, Any]]) -> Table:
    """Every method untuned and tuned on the unseen problems."""
    found = areas(findings)
    labels = list(found)
    columns = np.array([found[label] for label in labels]).T
    means = mean_interval(columns, np.random.default_rng(stream_of(0, NAME, "areas")))
    # Whose defaults were the best of its settings stays as it is.
    kept = {name: f"{name} tuned" if f"{name} tuned" in labels else name for name in SPACES}
    places = {
        "untuned": [labels.index(name) for name in SPACES],
        "tuned": [labels.index(kept[name]) for name in SPACES],
    }
    rows: list[tuple[Entry, ...]] = []
    for kind, where in places.items():
        ranks = mean_ranks(-columns[:, where])
        for name, i, rank in zip(SPACES, where, ranks, strict=True):
            options = _changed(chosen[name][1]) if kind == "tuned" else "defaults"
            success = _success(findings, labels[i])
            rows.append((name, kind, means[i], success, float(rank), options))
    rows.sort(key=lambda row: (str(row[1]) == "tuned", float(str(row[4]))))
    note = (
        f"Area over the convergence curve with a bootstrap 95 % interval over {len(columns)} unseen"
        f" problems, share of trials at the target by {BUDGET} evaluations with one for further"
        " problems like these, mean rank by the area among the untuned and among the tuned. Each"
        " method was tuned with the same number of settings on problems of the other half of the"
        " suite. The trials are not archived: the study runs them anew, from its seeds."
    )
    heads = ("optimiser", "settings", "area", "success", "mean rank", "options")
    return Table("Tuned with the same effort", heads, rows, note)


def _success(findings: Findings, label: str) -> Interval | None:
    return wilson_over([s.hits for s in findings.scores if s.cell.label == label])


def _changed(optimiser: Any) -> str:
    default = type(optimiser)()
    told = {key: value for key, value in vars(optimiser).items() if value != getattr(default, key)}
    return ", ".join(f"{key}={value}" for key, value in told.items()) or "defaults"


def main(arguments: Sequence[str] | None = None) -> None:
    """Tune on one half, race on the other."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tries", type=int, default=12)
    parser.add_argument("--every", type=int, default=3, help="take every so manieth problem")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--out", type=Path, default=Path("results"))
    given = parser.parse_args(arguments)
    learnt, unseen = ([name for name in half if name in sweeps()] for half in halves())
    candidates = {name: settings(name, given.tries) for name in SPACES}
    every = [entrant for each in candidates.values() for entrant in each]
    tuning = areas(raced(race("tuning", learnt[:: given.every], every), given.workers, given.out))
    chosen = {
        name: max(each, key=lambda entrant: float(tuning[entrant[0]].mean()))
        for name, each in candidates.items()
    }
    entrants = [candidates[name][0] for name in SPACES]
    entrants += [(f"{name} tuned", chosen[name][1]) for name in SPACES if _tuned(chosen[name][1])]
    found = raced(race("race", unseen[:: given.every], entrants), given.workers, given.out)
    folder = given.out / NAME
    folder.mkdir(parents=True, exist_ok=True)
    whole = asking(__doc__, table(found, chosen))
    for path in save_table(whole, folder, "tuned", ("md", "csv")):
        print(path)


def _tuned(optimiser: Any) -> bool:
    return _changed(optimiser) != "defaults"


if __name__ == "__main__":
    main()
