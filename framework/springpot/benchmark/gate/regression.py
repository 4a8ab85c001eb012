"""The accuracy gate: whether any optimiser became worse on any problem since its baseline."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from springpot.benchmark.runner import run_study
from springpot.benchmark.script import load_study
from springpot.benchmark.store import Store
from springpot.benchmark.study import Study
from springpot.benchmark.summary import store_path
from springpot.errors import StudyError

from .baseline import Baseline, baseline_of, read_baseline, samples_like
from .changes import Change, by_optimiser, changes_since, together, who
from .difference import FACTOR, LEVEL
from .power import POWER, smallest_seen
from .requirements import broken

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
                f" {float(facts[key]):g}: make it again with springpot regression update"
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
        f"{who(key)} is not in the baseline: springpot regression update takes it up" for key in new
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
            f"there is no baseline under {out}: make one with springpot regression update STUDY.py"
        )
    return scripts
