"""The accuracy gate: whether any optimiser became worse on any problem since its baseline was made."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from springpot.benchmark import Store, Study, load_study, run_study, store_path
from springpot.errors import StudyError

from .baseline import EVALUATIONS, SEPARATOR, Baseline, Sample, baseline_of, read_baseline, samples_like
from .difference import FACTOR, LEVEL, Verdict, verdicts

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
        What else is worth knowing: what got better, is new, or can hardly be judged.
    """

    baseline: Path
    cells: int
    regressions: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing got worse."""
        return not self.regressions


def update(
    study: Study | str | Path, baseline: Path | None = None, out: Path = Path("results"), workers: int | None = None
) -> Path:
    """Make or replace a study's baseline.

    Parameters
    ----------
    study : Study, str or Path
        A study or its script, which is run afresh; or a store, folder or name, whose trials are taken.
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
        A study or its script, which is run afresh; or a store, folder or name, whose trials are taken.
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


def compare(before: Baseline, store: Store, path: Path, level: float = LEVEL, factor: float = FACTOR) -> Gate:
    """Compare a store's trials with a baseline; see `check`."""
    facts = store.facts()
    # With another budget or target the numbers mean something else, however alike they look.
    for key in ("budget", "target"):
        if float(facts[key]) != before.settings[key]:
            raise StudyError(
                f"{path} was made with a {key} of {before.settings[key]:g}, the study has {float(facts[key]):g}: "
                "make it again with springpot regression update"
            )
    after = samples_like(store, before)
    keys = sorted(after)
    pairs = [(before.samples[key].array(), after[key].array()) for key in keys]
    # Judged together: the level is the chance that any of them is reported, not each.
    judged = dict(zip(keys, verdicts(pairs, level, factor), strict=True))
    worse = [
        _sentence(key, "worse", before.samples[key], after[key], verdict)
        for key, verdict in judged.items()
        if verdict.worse
    ]
    # What is no longer run must not pass: a fault could hide by taking its cell along.
    gone = [f"{_who(key)} is in the baseline but was not run" for key in sorted(set(before.samples) - set(after))]
    return Gate(path, len(keys), (*worse, *gone), tuple(_notes(before, after, judged, store)))


def _notes(before: Baseline, after: dict[str, Sample], judged: dict[str, Verdict], store: Store) -> list[str]:
    notes = [
        _sentence(key, "better", before.samples[key], after[key], verdict)
        for key, verdict in judged.items()
        if verdict.better
    ]
    # Or a gate that can never close would be trusted.
    few = sum(not verdict.tested for verdict in judged.values())
    if few:
        notes.append(
            f"{few} of {len(judged)} comparisons have too few trials for a test to ever tell: they fail only if the "
            "intervals are apart; raise the study's repetitions"
        )
    # Told, not failed: a new optimiser has nothing that it could have become worse than.
    new = [key for key in baseline_of(store).samples if key not in before.samples]
    return notes + [f"{_who(key)} is not in the baseline: springpot regression update takes it up" for key in new]


def _sentence(key: str, word: str, before: Sample, after: Sample, verdict: Verdict) -> str:
    what = "final error"
    if before.measure == EVALUATIONS:
        what = "evaluations to target"
    evidence = "the intervals are apart"
    if verdict.tested:
        evidence = f"p = {verdict.p:.1g}"
    return f"{_who(key)} got {word}: {what} {_in_words(before)} before, {_in_words(after)} after ({evidence})"


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


def _who(key: str) -> str:
    dataset, model, objective, optimiser = key.split(SEPARATOR)
    return f"{optimiser} on {dataset} (model {model}, objective {objective})"


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
def _fresh(study: Study | str | Path, out: Path, workers: int | None, seed: int | None = None) -> Iterator[Store]:
    """Results of a study that is run afresh, because a kept trial would hide what became of the code since."""
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
        raise StudyError(f"there is no baseline under {out}: make one with springpot regression update STUDY.py")
    return scripts
