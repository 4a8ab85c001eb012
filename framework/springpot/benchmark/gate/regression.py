"""The accuracy gate: whether any optimiser became worse on any problem since its baseline.

What a study requires of every cell, whatever was before: success, right parameters, time.

What a baseline can see: the smallest change that its trials tell in most cases.
"""

from __future__ import annotations

import json
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import inf, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from springpot.distributions import normal_quantile
from springpot.errors import StudyError
from springpot.rheology.points import Real
from springpot.writing import number, suggested

from ..runner import run_study
from ..statistics import bands
from ..store import Store
from ..study import Study
from ..summary import TrialRow, load_study, store_path
from ..trial import relative_error
from .baseline import (
    EVALUATIONS,
    FACTOR,
    LEVEL,
    SEPARATOR,
    Baseline,
    Goal,
    Sample,
    Successes,
    Verdict,
    baseline_of,
    cell_key,
    drop,
    problem_key,
    reached,
    read_baseline,
    samples_like,
    verdicts,
)


@dataclass(frozen=True)
class Change:
    """What became of one cell, or of one optimiser over all its problems.

    Parameters
    ----------
    who : str
        Optimiser and problem.
    costs : tuple of (Sample, Sample, Verdict), or None
        Before, after, and what is thought of it; none of several problems, whose costs have no
        common scale.
    counts : tuple of (Successes, Successes, Verdict)
        The same of the trials that reached the target.
    """

    who: str
    costs: tuple[Sample, Sample, Verdict] | None
    counts: tuple[Successes, Successes, Verdict]

    @property
    def worse(self) -> bool:
        """Whether costs rose or successes became fewer."""
        return self.counts[2].worse or (self.costs is not None and self.costs[2].worse)

    @property
    def better(self) -> bool:
        """The reverse."""
        return self.counts[2].better or (self.costs is not None and self.costs[2].better)

    def sentence(self, word: str) -> str:
        """What changed for the ``worse`` or the ``better``."""
        told = []
        if self.costs is not None and getattr(self.costs[2], word):
            told.append(_costs_in_words(*self.costs))
        if getattr(self.counts[2], word):
            told.append(self._fewer())
        return f"{self.who} got {word}: {'; '.join(told)}"

    def _fewer(self) -> str:
        before, after, verdict = self.counts
        return f"target reached in {before} before, in {after} after (p = {verdict.p:.1g})"

    def doubtful(self) -> str:
        """A drop of successes that may be chance; empty if there is none."""
        before, after, verdict = self.counts
        if verdict.worse or after.rate >= before.rate:
            return ""
        return f"{self.who}: {self._fewer()}: fewer, but not for certain"


def changes_since(
    before: Baseline, after: dict[str, Sample], level: float, factor: float
) -> list[Change]:
    """Cells by name, then optimisers over all their problems, of which no single one may tell."""
    keys = sorted(after)
    pairs = [(before.samples[key].array(), after[key].array()) for key in keys]
    counts = [(before.samples[key].successes, after[key].successes) for key in keys]
    several = {name: cells for name, cells in by_optimiser(after).items() if len(cells) > 1}
    for cells in several.values():
        counts.append((together(before.samples, cells), together(after, cells)))
    # Judged together: the level is the chance that any of them is reported, not each.
    found = verdicts(pairs, level, factor, counts)
    of_counts = [
        (*count, verdict) for count, verdict in zip(counts, found[len(pairs) :], strict=True)
    ]
    changed = []
    for key, cost, count in zip(keys, found, of_counts, strict=False):
        changed.append(Change(who(key), (before.samples[key], after[key], cost), count))
    for (name, cells), count in zip(several.items(), of_counts[len(keys) :], strict=True):
        # Where a problem of it tells already, all of them together say nothing new.
        if not any(
            change.counts[2].worse
            for key, change in zip(keys, changed, strict=False)
            if key in cells
        ):
            changed.append(Change(f"{name} over {len(cells)} problems", None, count))
    return changed


def by_optimiser(samples: Iterable[str]) -> dict[str, list[str]]:
    """Keys of each optimiser's cells."""
    found: dict[str, list[str]] = {}
    for key in sorted(samples):
        found.setdefault(key.rpartition(SEPARATOR)[2], []).append(key)
    return found


def together(samples: Mapping[str, Sample], keys: Sequence[str]) -> Successes:
    """Successes of several cells."""
    return Successes(
        sum(samples[key].reached for key in keys), sum(len(samples[key].values) for key in keys)
    )


def _costs_in_words(before: Sample, after: Sample, verdict: Verdict) -> str:
    what = "final error"
    if before.measure == EVALUATIONS:
        what = "evaluations to target"
    evidence = "the intervals are apart"
    if verdict.tested:
        evidence = f"p = {verdict.p:.1g}"
    return f"{what} {_in_words(before)} before, {_in_words(after)} after ({evidence})"


def _in_words(sample: Sample) -> str:
    """The median, and how many trials it is of; an infinite one was missed."""
    median = float(np.median(sample.array()))
    middle = f"{median:.4g}"
    if median == inf:
        middle = "missed"
    trials = f"{len(sample.values)} trials"
    missed = sum(value == inf for value in sample.values)
    if missed:
        trials += f", {missed} missed"
    return f"{middle} (median of {trials})"


def who(key: str) -> str:
    """A cell as a sentence begins."""
    dataset, model, objective, optimiser = key.split(SEPARATOR)
    return f"{optimiser} on {dataset} (model {model}, objective {objective})"


MOST = 0.5
"""Share of trials that must meet a requirement where the study names none."""


def broken(store: Store, baseline: Baseline) -> Iterator[tuple[str, str]]:
    """Cells of a store that do not meet what its study requires, each with a sentence.

    Parameters
    ----------
    store : Store
        The trials.
    baseline : Baseline
        What is right: targets, and parameters where no truth is known.
    """
    required: dict[str, float] = json.loads(store.facts().get("requirements", "{}"))
    for cell, rows in store.raced():
        goal = baseline.goals.get(problem_key(cell.problem))
        # A problem that is new has nothing yet that is right.
        if goal is None:
            continue
        for words in _broken(rows, goal, required):
            yield cell_key(cell), words


def _broken(rows: Sequence[TrialRow], goal: Goal, required: Mapping[str, float]) -> Iterator[str]:
    share = required.get("min_success", MOST)
    if "min_success" in required:
        count = reached(rows, goal)
        if count < share * len(rows):
            yield f"reached the target in {count} of {len(rows)} trials: min_success is {share:g}"
    if "max_parameter_error" in required:
        limit = required["max_parameter_error"]
        error = _at(share, [_error(row, goal.parameters) for row in rows])
        # Also what is no number is no success.
        if not error <= limit:
            yield (
                f"{_off(error, share)}: max_parameter_error is"
                f" {limit:g}{_moved(rows, goal.parameters)}"
            )
    if "max_seconds" in required:
        limit = required["max_seconds"]
        spent = _at(share, [_seconds(row) for row in rows])
        if not spent <= limit:
            most = f"{100 * share:.0f} % of its trials"
            yield f"took {number(spent, 3)} s, which {most} keep to: max_seconds is {limit:g}"


def _at(share: float, values: Sequence[float]) -> float:
    """What this share of the values does not exceed."""
    return float(bands(np.array(values), (share,))[0])


def _error(row: TrialRow, right: Mapping[str, float]) -> float:
    """Largest relative error of a parameter; infinite of a trial that failed."""
    if row.theta.keys() != right.keys() or not right:
        return inf
    return relative_error(
        np.array([row.theta[name] for name in right]), np.array(list(right.values()))
    )


def _seconds(row: TrialRow) -> float:
    if row.status.failed:
        return inf
    return row.seconds


def _off(error: float, share: float) -> str:
    most = f"{100 * share:.0f} % of its trials"
    if np.isfinite(error):
        return f"has parameters that are off by up to {error:.3g} in {most}"
    return f"found no parameters in {most}"


def _moved(rows: Sequence[TrialRow], right: Mapping[str, float]) -> str:
    """Parameters of the best trial beside what is right."""
    sound = [row for row in rows if row.best is not None and row.theta.keys() == right.keys()]
    if not sound:
        return ""
    best = min(sound, key=lambda row: row.best or 0.0)
    moved = [
        f"{name} {number(best.theta[name])} for {number(value)}" for name, value in right.items()
    ]
    return f" (its best trial: {', '.join(moved)})"


POWER = 0.8
"""Share of cases in which a change shall be seen.

The usual one (Cohen 1988, Statistical Power Analysis).
"""


def least_rise(before: Real, share: float, factor: float = FACTOR) -> float:
    """Smallest factor of costs that so many trials after would show with the chance `POWER`.

    Infinite if none.

    Parameters
    ----------
    before : ndarray, shape (n,)
        Positive costs, infinite where missed.
    share : float
        Level of this one comparison.
    factor : float
        Rise that does not count yet.
    """
    n = len(before)
    # How often a cost after must exceed one before (Noether 1987,
    # doi:10.1080/01621459.1987.10478478).
    often = 0.5 + float(normal_quantile(POWER) - normal_quantile(share)) * sqrt(
        (2 * n + 1) / (12 * n * n)
    )
    if often >= 1.0:
        return inf
    ratios = np.ones((n, n))
    with np.errstate(invalid="ignore"):
        np.divide(
            before[:, None],
            before,
            out=ratios,
            where=np.isfinite(before[:, None]) | np.isfinite(before),
        )
    return factor * float(np.quantile(ratios, often, method="higher"))


def least_drop_seen(before: Successes, share: float) -> float | None:
    """Highest rate of success after that so many trials would show with the chance `POWER`.

    None if none.

    Parameters
    ----------
    before : Successes
        Those of the baseline.
    share : float
        Level of this one comparison.
    """
    from scipy.special import betaincinv

    n = before.trials
    # The largest count that is still significant: the fewer, the surer.
    low = -1 + bisect_left(
        range(before.count), True, key=lambda count: drop(before, Successes(count, n)) >= share
    )
    if low < 0:
        return None
    # The rate at which so few or fewer come with that chance (the binomial sum as an incomplete
    # beta function).
    return 1.0 - float(betaincinv(n - low, low + 1, POWER))


def smallest_seen(
    costs: Sequence[Real],
    cells: Sequence[Successes],
    together: Successes,
    share: float,
    factor: float,
) -> str:
    """The smallest changes of one optimiser that a baseline shows, in words.

    Parameters
    ----------
    costs : sequence of ndarray, shape (n,) each
        Its costs on each problem.
    cells : sequence of Successes
        Its successes on each.
    together : Successes
        Over all of them.
    share, factor : float
        Level of one comparison and rise that does not count yet.
    """
    rises = [least_rise(each, share, factor) for each in costs]
    words = f"costs {_times(min(rises))}"
    if max(rises) > min(rises):
        words += " to none" if max(rises) == inf else f" to {_times(max(rises))}"
    words += f"; success {_falls(max(cells, key=lambda each: each.rate), share)} on one problem"
    if len(cells) > 1:
        words += f", {_falls(together, share)} over its {len(cells)}"
    return words


def _times(rise: float) -> str:
    if rise == inf:
        return "no rise"
    return f"x{rise:.3g}"


def _falls(before: Successes, share: float) -> str:
    rate = least_drop_seen(before, share)
    if rate is None:
        return f"no fall from {100 * before.rate:.0f} %"
    # Downwards: what lies between is seen less often.
    return f"{100 * before.rate:.0f} -> {int(100 * rate)} %"


NAME = "baseline.json"


@dataclass(frozen=True)
class Gate:
    """What a check came to.

    Parameters
    ----------
    baseline : Path
        What was compared with.
    cells : int
        Problems times optimisers that were compared.
    regressions : tuple of str
        One sentence for each cell that got worse; the gate is passed if there is none.
    notes : tuple of str
        What else is worth knowing: what got better, is new, succeeds less often, or can hardly be
        judged.
    seen : tuple of str
        For each optimiser, the smallest change that this baseline shows in 80 % of cases.
    """

    baseline: Path
    cells: int
    regressions: tuple[str, ...]
    notes: tuple[str, ...]
    seen: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing got worse."""
        return not self.regressions


def update(
    study: Study | str | Path,
    baseline: Path | None = None,
    out: Path = Path("results"),
    workers: int | None = None,
) -> Path:
    """Make or replace a study's baseline.

    Parameters
    ----------
    study : Study, str or Path
        A study or its script, which is run afresh; or a store, folder or name, whose trials are
        taken.
    baseline : Path, optional
        The file; by default ``baseline.json`` in the study's folder of results.
    out : Path
        Folder of all results.
    workers : int, optional
        Processes; by default one for each core.

    Returns
    -------
    Path
        The file written.
    """
    with _fresh(study, out, workers) as store:
        made = baseline_of(store, _script(study))
    return made.write(baseline or out / made.study / NAME)


def check(
    study: Study | str | Path,
    baseline: Path | None = None,
    out: Path = Path("results"),
    workers: int | None = None,
    seed: int | None = None,
    level: float = LEVEL,
    factor: float = FACTOR,
) -> Gate:
    """Compare a study with its baseline.

    Parameters
    ----------
    study : Study, str or Path
        A study or its script, which is run afresh; or a store, folder or name, whose trials are
        taken.
    baseline : Path, optional
        The file; by default ``baseline.json`` in the study's folder of results.
    out : Path
        Folder of all results.
    workers : int, optional
        Processes; by default one for each core.
    seed : int, optional
        Instead of the study's own, to see what noise alone does.
    level : float
        Chance that anything is reported if nothing changed.
    factor : float
        Rise of evaluations or error that is no regression yet.

    Raises
    ------
    StudyError
        If there is no baseline or it was made with other settings or data.
    """
    path = baseline or _baseline_path(study, out)
    before = read_baseline(path)
    with _fresh(study, out, workers, seed) as store:
        return compare(before, store, path, level, factor)


def compare(
    before: Baseline, store: Store, path: Path, level: float = LEVEL, factor: float = FACTOR
) -> Gate:
    """Compare a store's trials with a baseline; see `check`."""
    facts = store.facts()
    # With another budget or target the numbers mean something else, however alike they look.
    for key in ("budget", "target"):
        if float(facts[key]) != before.settings[key]:
            raise StudyError(
                f"{path} was made with a {key} of {before.settings[key]:g}, the study has"
                f" {float(facts[key]):g}: make it again with"
                f" {suggested('regression update', 'STUDY.py')}"
            )
    after = samples_like(store, before)
    judged = changes_since(before, after, level, factor)
    # What is no longer run must not pass: a fault could hide by taking its cell along.
    gone = [
        f"{who(key)} is in the baseline but was not run"
        for key in sorted(set(before.samples) - set(after))
    ]
    required = [f"{who(key)} {words}" for key, words in broken(store, before)]
    return Gate(
        path,
        len(after),
        (*(change.sentence("worse") for change in judged if change.worse), *gone, *required),
        tuple(_notes(before, judged, store)),
        tuple(_seen(before, level, factor)),
    )


def _seen(before: Baseline, level: float, factor: float) -> Iterator[str]:
    """For each optimiser, the smallest change that its trials show."""
    optimisers = by_optimiser(before.samples)
    number = 2 * len(before.samples) + sum(len(keys) > 1 for keys in optimisers.values())
    for name, keys in optimisers.items():
        samples = [before.samples[key] for key in keys]
        words = smallest_seen(
            [sample.array() for sample in samples],
            [sample.successes for sample in samples],
            together(before.samples, keys),
            level / number,
            factor,
        )
        yield f"{name}, in {100 * POWER:.0f} % of cases: {words}"


def _notes(before: Baseline, judged: Sequence[Change], store: Store) -> list[str]:
    notes = [change.sentence("better") for change in judged if change.better]
    notes += [doubt for change in judged if (doubt := change.doubtful())]
    # Or a gate that can never close would be trusted.
    tested = [change.costs[2].tested for change in judged if change.costs is not None]
    few = len(tested) - sum(tested)
    if few:
        notes.append(
            f"{few} of {len(tested)} comparisons have too few trials for a test to ever tell: they"
            " fail only if the intervals are apart; raise the study's repetitions"
        )
    # Told, not failed: a new optimiser has nothing that it could have become worse than.
    new = [key for key in baseline_of(store).samples if key not in before.samples]
    return notes + [
        f"{who(key)} is not in the baseline:"
        f" {suggested('regression update', 'STUDY.py')} takes it up"
        for key in new
    ]


def _is_script(study: Study | str | Path) -> bool:
    return not isinstance(study, Study) and Path(study).suffix == ".py"


def _script(study: Study | str | Path) -> str:
    """Path of a script, from here if it is below."""
    if isinstance(study, Study) or not _is_script(study):
        return ""
    path = Path(study).resolve()
    # The baseline is committed: a path of this machine would say nothing on another.
    if path.is_relative_to(Path.cwd()):
        return path.relative_to(Path.cwd()).as_posix()
    return str(path)


@contextmanager
def _fresh(
    study: Study | str | Path, out: Path, workers: int | None, seed: int | None = None
) -> Iterator[Store]:
    """Results of a study run afresh: kept trials would hide what became of the code since."""
    if not isinstance(study, Study) and not _is_script(study):
        with Store(store_path(study, out)) as store:
            yield store
        return
    # Elsewhere: what a user has run stays as it is.
    with TemporaryDirectory(prefix="springpot-") as scratch:
        # Workers load the script as it stands: what differs from it runs here.
        if isinstance(study, Study) or seed is not None:
            declared = _declared(study)
            if seed is not None:
                declared = replace(declared, seed=seed)
            done = run_study(declared, engine="serial", out=Path(scratch), quiet=True, tables=False)
        else:
            done = run_study(study, workers, out=Path(scratch), quiet=True, tables=False)
        with Store(done.store) as store:
            yield store


def _baseline_path(study: Study | str | Path, out: Path) -> Path:
    if isinstance(study, Study) or _is_script(study):
        return out / _declared(study).name / NAME
    return store_path(study, out).parent / NAME


def _declared(study: Study | str | Path) -> Study:
    if isinstance(study, Study):
        return study
    return load_study(study)


def known_scripts(out: Path = Path("results")) -> list[Path]:
    """Scripts of the studies that have a baseline.

    Raises
    ------
    StudyError
        If there is none.
    """
    baselines = [read_baseline(path) for path in sorted(out.glob(f"*/{NAME}"))]
    # A baseline of a store knows no script, and cannot be run again from here.
    scripts = [Path(baseline.script) for baseline in baselines if baseline.script]
    if not scripts:
        raise StudyError(
            f"there is no baseline under {out}: make one with"
            f" {suggested('regression update', 'STUDY.py')}"
        )
    return scripts
