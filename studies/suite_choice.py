"""The choice of an optimiser: learnt from problems that are drawn, judged on others.

    python studies/suite_choice.py           runs what is missing, and judges
    python studies/suite_choice.py learn     learns the rules of `auto` anew (plugins/.../auto.toml)

Question: does `auto` come near the quickest optimiser of each problem on problems from which
nothing was learnt? Measure: expected running time over that of the virtual best, the quickest
optimiser of each problem, as a geometric mean over problems that another seed draws. What would
answer it: at most 1.25; and less than always the best single optimiser.

Rivals are those that were quickest on a problem of springpot-60, by its race and by further trials.
A trial ends where it is thirty times as long as the quickest so far, and who is five times as slow
after two trials runs no more: neither can be the virtual best. Problems that none of the first
trials solves within a quarter of the budget are left out. What is learnt from is a bank of single
descents, each with its curve, of which every rule is put together by counting.
"""

from __future__ import annotations

import json
import sys
from contextlib import suppress
from dataclasses import dataclass
from itertools import permutations, product
from pathlib import Path
from typing import Literal

import numpy as np

from drawn_problems import best, drawn, searched
from paper.asking import asking
from springpot import plugins
from springpot.benchmark import Table, save_table
from springpot.benchmark.plan import reference_of, stream_of
from springpot.benchmark.statistics import Interval, expected_running_time
from springpot.identification.problem import Problem, SpecimenProblem
from springpot.identification.recorder import BudgetSpent, Recorder
from springpot.identification.runs import Optimiser, run
from springpot.rheology import Real
from springpot_plugins.optimisers import descents
from springpot_plugins.optimisers.descents import NEGLIGIBLE, Auto, LeastSquares, Misfit
from suite_repeated import ALONE, BUDGET, CHOICE, FAILED, PAGE, interval, rewritten

ROOT = Path(__file__).parents[1]
RULES = ROOT / "plugins" / "springpot_plugins" / "optimisers" / "auto.toml"
FOLDER = ROOT / "results" / "suite_choice"
MADE = FOLDER / "made"
"""What was run, a file for each problem."""
LEARNT, HELD = ((1, 43), (2, 33)), (3, 34)
"""Seeds, and how many problems each draws.

The second judged twice before it was learnt from; the third is judged by once.
"""
TARGET = 1e-6
TOLD = "| of problems that"
"""How the line of the page begins that tells of them."""
RIVALS = (
    *("least-squares", "least-squares-alternating", "optimagic-scipy-ls-dogbox"),
    *("optimagic-scipy-truncated-newton", "optimagic-scipy-slsqp", "nlopt-lbfgs"),
)
LATE = ("dfo-ls", "cma-es")
"""Who is tried where all others take long."""
LONG = 1000.0
REPEATED, IN_TIME = 6, 3
"""Trials of each, and with tests in time."""
METHODS: tuple[Literal["trf", "dogbox"], ...] = ("trf", "dogbox")
KINDS = tuple(
    LeastSquares(method, logarithmic, NEGLIGIBLE)
    for method, logarithmic in product(METHODS, (True, False))
)
"""Descents that are tried."""
DESCENTS, DESCENTS_IN_TIME, LONGEST = 12, 4, 200
"""Of each kind on each problem, and evaluations after which one is ended."""
LENGTHS = (80, 120, 200)
"""After which a descent is given up, in evaluations."""
PATIENCE = ((5, 1.0), (5, 0.9999), (8, 0.9999), (5, 0.999))
"""Evaluations within which one must get on, and what may be left of the objective by then."""
SCALES = ("parameters", "logarithms")
"""By which points are drawn uniformly."""
ROUNDS = ((0,), (0, 1))
"""Scales of the points that descents begin at, round after round."""
CUT, SHORT, FAR = 30.0, 500, 5.0
"""Times the quickest at which a trial ends, not before so many evaluations; who is too slow."""
Trials = dict[str, list[tuple[float, int]]]
"""By optimiser: evaluations at which a trial met the target, and that it spent."""


@dataclass(frozen=True)
class Bank:
    """Single descents on one problem.

    Parameters
    ----------
    curves : ndarray, shape (scales, kinds, n, LONGEST)
        Objective at each evaluation, not a number after the last.
    hits, spent : ndarray, shape (scales, kinds, n)
        Evaluations at which each met the target, and that it made.
    """

    curves: Real
    hits: Real
    spent: Real


@dataclass(frozen=True)
class Rules:
    """How descents follow each other.

    Parameters
    ----------
    order : tuple of int
        Kinds in turn.
    longest : int
        Evaluations after which a descent is ended.
    patience, progress : int, float
        It is given up where so many evaluations leave more than this share of the objective.
    rounds : tuple of int
        Scales by which points are drawn, in turn, each for all kinds once.
    """

    order: tuple[int, ...]
    longest: int
    patience: int
    progress: float
    rounds: tuple[int, ...]

    def ended(self, bank: Bank) -> tuple[Real, Real]:
        """Evaluations (scales, kinds, n) of descents that end so, and at which they hit."""
        least = np.fmin.accumulate(bank.curves, axis=-1)
        late, early = least[..., self.patience :], least[..., : -self.patience]
        with np.errstate(invalid="ignore"):
            lost = late > self.progress * early
        first = np.where(lost.any(-1), lost.argmax(-1) + self.patience + 1, self.longest)
        end = np.minimum(first, self.longest)
        hits = np.where(bank.hits <= end, bank.hits, np.inf)
        return np.minimum(hits, np.minimum(bank.spent, end)), hits

    def time(self, bank: Bank) -> float:
        """Expected evaluations until such descents, over and over, meet the target."""
        spent, hits = self.ended(bank)
        total, still = 0.0, 1.0
        for place in product(self.rounds, self.order):
            total += still * float(np.mean(spent[place]))
            still *= 1.0 - float(np.mean(np.isfinite(hits[place])))
        # Without a last digit of rounding.
        return total / (1.0 - still) if still < 1.0 - 1e-12 else np.inf


class Curve(Misfit):
    """Residuals that remember the objective at each evaluation."""

    def __init__(self, problem: Recorder, logarithmic: bool) -> None:
        super().__init__(problem, logarithmic)
        self.values = list[float]()

    def both(self, y: Real) -> tuple[Real, Real]:
        """Both."""
        before = self.problem.evaluations
        residual, jacobian = super().both(y)
        if self.problem.evaluations > before:
            self.values.append(float(residual @ residual))
        return residual, jacobian


def banked(problem: SpecimenProblem, goal: float, count: int) -> Bank:
    """Single descents of every kind from the same points, by either scale."""
    shape = (len(SCALES), len(KINDS), count)
    bank = Bank(np.full((*shape, LONGEST), np.nan), np.full(shape, np.inf), np.zeros(shape))
    for place in product(*map(range, shape)):
        scale, k, i = place
        share = np.random.default_rng([7, i]).random(problem.dimension)
        made = Recorder(problem, LONGEST, goal)
        misfit = Curve(made, KINDS[k].logarithmic)
        with np.errstate(all="ignore"), suppress(Exception, BudgetSpent):
            KINDS[k].descend(misfit, Misfit(made, scale > 0).placed(share))
        bank.curves[place][: len(misfit.values)] = np.minimum(misfit.values, 1e30)
        bank.spent[place] = made.evaluations
        if made.met:
            bank.hits[place] = made.evaluations
    return bank


def time_of(trials: list[tuple[float, int]]) -> float:
    """Expected running time."""
    return float(expected_running_time(*np.array(trials, dtype=float).T))


def raced(name: str, problem: SpecimenProblem, goal: float, repeated: int) -> Trials:
    """The trials of the rivals; those of the first round alone where none of them arrives."""
    trials: Trials = {}
    quickest = np.inf
    for names, count in ((RIVALS, repeated), (LATE, IN_TIME)):
        if names is LATE and quickest <= LONG:
            break
        for repetition in range(count):
            for rival in names:
                mine = trials.setdefault(rival, [])
                if repetition > 1 and np.mean([spent for _, spent in mine]) > FAR * quickest:
                    continue
                hits = [hit for each in trials.values() for hit, _ in each]
                longest = max(SHORT, CUT * min([quickest, *hits]))
                limit = int(min(BUDGET if repetition else BUDGET // 4, longest))
                optimiser = plugins().find("optimiser", rival)()
                mine.append(trial(optimiser, name, problem, goal, limit, repetition))
            if not arrived(trials):
                return trials
            if repetition:
                quickest = min(map(time_of, trials.values()))
    return trials


def arrived(trials: Trials) -> bool:
    """Whether anybody met the target."""
    return any(np.isfinite(hit) for each in trials.values() for hit, _ in each)


def trial(
    optimiser: Optimiser,
    name: str,
    problem: SpecimenProblem,
    goal: float,
    limit: int,
    repetition: int,
) -> tuple[float, int]:
    """Evaluations at which a trial meets the target, and that it spends."""
    rng = np.random.default_rng(stream_of(0, name, repetition))
    done = run(optimiser, problem, limit, rng, goal)
    hit = done.trace[-1][0] if done.trace and done.best <= goal else np.inf
    return hit, done.evaluations


@dataclass(frozen=True)
class Made:
    """What was run on a problem.

    Parameters
    ----------
    name, says : str
        The problem.
    goal : float
        Objective that is good enough.
    trials : dict
        Of the rivals.
    bank : Bank or None
        Where it is learnt from.
    """

    name: str
    says: str
    goal: float
    trials: Trials
    bank: Bank | None

    @property
    def quickest(self) -> float:
        """Expected running time of the virtual best."""
        return min(map(time_of, self.trials.values()))


def made(seed: int, number: int) -> Made:
    """A problem with what was run on it; run if it is missing."""
    path = MADE / f"{seed}-{number}.json"
    pages = path.with_suffix(".npz")
    if not path.exists():
        known = drawn(seed, number)
        problem = searched(known)
        least = best(known, problem)
        goal = least + TARGET * (reference_of(problem) - least)
        swept = isinstance(problem, Problem)
        trials = raced(known.name, problem, goal, REPEATED if swept else IN_TIME)
        found = Made(known.name, known.summary, goal, trials, None)
        MADE.mkdir(parents=True, exist_ok=True)
        if seed != HELD[0] and arrived(trials):
            bank = banked(problem, goal, DESCENTS if swept else DESCENTS_IN_TIME)
            np.savez_compressed(pages, **vars(bank))
        path.write_text(json.dumps(vars(found)), encoding="utf-8")
    told = json.loads(path.read_text(encoding="utf-8"))
    return Made(**told | {"bank": Bank(**np.load(pages)) if pages.exists() else None})


def ratio(time: float, problem: Made) -> float:
    """Over that of the virtual best; who never arrives is taken to need FAILED budgets."""
    return float(min(time, FAILED * BUDGET) / problem.quickest)


def learnt(problems: list[Made]) -> tuple[Rules, Table]:
    """The rules that take least on all problems, and what those take that lack a part of them."""
    tried = [
        Rules(order, longest, *patience, rounds)
        for count in (1, 2, 3)
        for order in permutations(range(len(KINDS)), count)
        for longest, patience, rounds in product(LENGTHS, PATIENCE, ROUNDS)
    ]
    banks = [(each, each.bank) for each in problems if each.bank is not None]
    logs = np.log([[ratio(rules.time(b), p) for p, b in banks] for rules in tried])
    mean, total = logs.mean(axis=1), logs.sum(axis=1)

    def least(which: list[int]) -> Interval:
        return interval(np.exp(logs[which[int(np.argmin(mean[which]))]]))

    everything = range(len(tried))
    others = [logs[np.argmin(total - own), i] for i, own in enumerate(logs.T)]
    rows = [
        ("learnt", least(list(everything))),
        ("learnt from all but the one", interval(np.exp(others))),
        ("from points by one scale", least([i for i in everything if len(tried[i].rounds) == 1])),
        ("none given up early", least([i for i in everything if tried[i].progress == 1.0])),
        ("one kind of descent", least([i for i in everything if len(tried[i].order) == 1])),
    ]
    rows += [
        (name, interval(np.array([ratio(time_of(p.trials[name]), p) for p, _ in banks])))
        for name in RIVALS
    ]
    note = (
        f"Expected running time over that of the virtual best on {len(banks)} problems, as a"
        " geometric mean with a bootstrap 95 % interval over problems: of descents alone, counted"
        f" from the bank, by the best of {len(tried)} rules, or the best that lack a part; and of"
        " each rival, whose trials end where they can no longer be the quickest."
    )
    return tried[int(np.argmin(mean))], Table("What is learnt", ("rules", "ratio"), rows, note)


def judged(problems: list[tuple[int, Made]]) -> tuple[Table, Table]:
    """`auto` and the rivals over the virtual best, on all, and on each problem."""
    rows, logs = list[tuple[str | float, ...]](), list[list[float]]()
    for number, each in problems:
        problem = searched(drawn(HELD[0], number))
        count = len(each.trials[RIVALS[0]])
        own = [trial(Auto(), each.name, problem, each.goal, BUDGET, i) for i in range(count)]
        times = [time_of(own), *(time_of(each.trials[name]) for name in RIVALS)]
        logs.append([ratio(time, each) for time in times])
        first = min(each.trials, key=lambda name: time_of(each.trials[name]))
        rows.append((each.says, *logs[-1][:3], first, each.quickest))
    rows = [rows[i] for i in np.argsort([-each[0] for each in logs], kind="stable")]
    note = (
        "Expected running time over that of the virtual best, as a geometric mean with a bootstrap"
        f" 95 % interval over {len(rows)} problems that seed {HELD[0]} draws and somebody solves."
    )
    values = np.array(logs)
    means = [(n, interval(v)) for n, v in zip((Auto.name, *RIVALS), values.T, strict=True)]
    columns = ("problem", Auto.name, *RIVALS[:2], "quickest", "its expected running time")
    return (
        Table("The choice on problems that it has not seen", ("optimiser", "ratio"), means, note),
        Table("Problem by problem", columns, rows, "Ratios as in judged."),
    )


def write(rules: Rules) -> None:
    """Keep the rules where `auto` reads them; who takes turns stays as it is."""
    kept = descents.rules()
    count = sum(number for _, number in LEARNT)
    text = f"# Learnt by studies/suite_choice.py from {count} drawn problems.\n\n"
    for name in ("longest", "patience", "progress"):
        text += f"{name} = {getattr(rules, name)}\n"
    text += "\n# Learnt from 31 problems of springpot-60, of which some need it.\n"
    names = ", ".join(f'"{name}"' for name in kept["optimisers"])
    text += f"turn = {kept['turn']}\noptimisers = [{names}]\n"
    for scale, kind in product(rules.rounds, (KINDS[i] for i in rules.order)):
        text += f'\n[[descents]]\nbegins = "{SCALES[scale]}"\nmethod = "{kind.method}"\n'
        text += f"logarithmic = {str(kind.logarithmic).lower()}\n"
    RULES.write_text(text, encoding="utf-8")


def main() -> None:
    """Run what is missing; learn, or judge."""
    if "learn" in sys.argv:
        rules, table = learnt([made(seed, i) for seed, count in LEARNT for i in range(count)])
        save_table(table, FOLDER, "learnt")
        write(rules)
        return
    held = [(number, made(HELD[0], number)) for number in range(HELD[1])]
    whole, single = judged([each for each in held if arrived(each[1].trials)])
    save_table(asking(__doc__, whole), FOLDER, "judged")
    figures = {str(name): figure for name, figure in whole.rows}
    cells = [figures[name] for name in (CHOICE, ALONE)]
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8"), TOLD, cells), encoding="utf-8")
    save_table(single, FOLDER, "by_problem")


if __name__ == "__main__":
    main()
