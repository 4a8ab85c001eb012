"""A study's trials as one file, which another study reads as rivals without running them.

A zip of ``study.json`` (what was run, with which versions, on which machine), ``trials.csv``,
``traces.csv`` (the improvements of every trial) and ``oracles.csv`` (those of the noise-free
objective over all that was evaluated). The same store gives the same bytes, and a study stands
beside the trials of an archive as if all had run together.
"""

from __future__ import annotations

import csv
import json
import re
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from io import StringIO, TextIOWrapper
from itertools import groupby, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import StudyError
from springpot.files import FILES, write_with
from springpot.numerics import ALIKE
from springpot.registry import plugins

from .comparison import JudgingScale, judged, reference_of
from .plan import ASKED, ProblemRow
from .schema import optima_told
from .statistics import goal_of
from .store import Store
from .study import OWN, Study
from .summary import SUFFIX, CellRow, TrialRow
from .trial import Status, TrialResult, contradiction, pack, pack_values

SCHEMA = "springpot.archive/2"
FAULTS = (
    *(KeyError, ValueError, TypeError, IndexError, OSError, EOFError, RuntimeError),
    *(zipfile.BadZipFile, zlib.error, csv.Error),
)
"""What a file that is none, or a damaged one, makes of its reading."""

WHOLE = ("evaluations", "gradients", "batched")
REAL = (
    *("best", "parameter_error", "oracle", "seconds", "processor", "processor_batched"),
    *("reference", "known", "optimum", "covered"),
)
TRIAL = ("cell", "repetition", "status", "truth", *WHOLE, *REAL, "theta", "reason")
LEFT_OUT = ("cells", "optima")
"""Facts that name a store's own rows."""
NOISE = "noise"
ITS_OWN = (*LEFT_OUT, *ASKED, NOISE, "name", "command", "repetitions", "requirements", "beside")
"""Facts that are of one study and of none beside it."""


@dataclass(frozen=True)
class ArchivedCell:
    """One optimiser on one problem, as it was published.

    Parameters
    ----------
    label, optimiser, options, digest : str
        Who, and the digest of what was run.
    problem : int
        Place of its problem in the archive.
    """

    label: str
    optimiser: str
    options: str
    digest: str
    problem: int


@dataclass(frozen=True)
class Archive:
    """What an archive holds, but for its trials.

    Parameters
    ----------
    path : Path
        The file.
    facts : mapping of str to str
        Name, budget, seed, target, versions, machine, command.
    problems : tuple of ProblemRow
        What was raced on.
    cells : tuple of ArchivedCell
        Who on what.
    optima : mapping of int to float
        From which a problem's target was reckoned, by its place, where that was known beforehand.
    """

    path: Path
    facts: Mapping[str, str]
    problems: tuple[ProblemRow, ...]
    cells: tuple[ArchivedCell, ...]
    optima: Mapping[int, float] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path) -> Archive:
        """Open one.

        Raises
        ------
        StudyError
            If it is none, or damaged.
        """
        with _one_line(path), zipfile.ZipFile(path) as whole, whole.open("study.json") as stream:
            told = json.loads(stream.read(FILES.largest))
            if told["schema"] != SCHEMA:
                raise ValueError(f"its schema is {told['schema']:.40}, not {SCHEMA}")
            facts = {str(key): str(value) for key, value in told["facts"].items()}
            for key in ("name", "budget", "seed", "target", "accuracy", "repetitions"):
                facts[key]
            problems = tuple(ProblemRow(id=i, **each) for i, each in enumerate(told["problems"]))
            cells = tuple(ArchivedCell(**each) for each in told["cells"])
            optima = {int(i): float(best) for i, best in dict(told.get("optima", {})).items()}
            for place in (*optima, *(cell.problem for cell in cells)):
                problems[place]
        return cls(path, facts, problems, cells, optima)

    def trials(self, cells: Iterable[int]) -> Iterator[TrialResult]:
        """The trials of some cells, one at a time.

        Raises
        ------
        StudyError
            If the record of one contradicts itself.
        """
        wanted, budget = set(cells), int(self.facts["budget"])
        with _one_line(self.path), zipfile.ZipFile(self.path) as whole:
            rows, traces, oracles = (
                _rows(whole, name) for name in ("trials.csv", "traces.csv", "oracles.csv")
            )
            pages, seen = _Pages(traces), _Pages(oracles)
            head = next(rows)
            for row in rows:
                told = dict(zip(head, row, strict=True))
                key = int(told["cell"]), int(told["repetition"])
                result = _trial(key, told, pages.of(key), seen.of(key))
                if key[0] in wanted:
                    if not result.status.failed and (wrong := contradiction(result, budget)):
                        raise ValueError(f"of trial {key[1]} of {self.cells[key[0]].label} {wrong}")
                    yield result
            if pages.left or seen.left:
                raise ValueError("it has traces of no trial")


def write_archive(store: Store, path: Path, thin: bool = False) -> int:
    """Write a store's study into one file.

    Parameters
    ----------
    store : Store
        The study's.
    path : Path
        The file.
    thin : bool
        Leave out improvements that no curve shows: those kept are the ones that stand at twenty
        evaluation numbers a decade, the one that reached the target, and the last. Hits and
        curves stay as they are, areas and first hits of other targets do not.

    Returns
    -------
    int
        How many trials are in it.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    cells = store.cells()
    numbers = {cell.id: i for i, cell in enumerate(cells)}
    # In the order of the store; each cell by its place in the description.
    trials: list[tuple[int, Sequence[TrialRow]]] = [
        (numbers[cell.id], rows) for cell, rows in store.raced()
    ]
    if thin:
        scale = JudgingScale.of(store)
        trials = [
            (
                numbers[cell.id],
                [_thinned(*each, cell, scale) for each in zip(rows, bests, strict=True)],
            )
            for cell, rows, bests in judged(store)
        ]
    write_with(path, partial(_fill, _description(store, cells), trials))
    return sum(len(rows) for _, rows in trials)


def _thinned(row: TrialRow, best: float, cell: CellRow, scale: JudgingScale) -> TrialRow:
    """A trial with the improvements that a curve over the grid shows."""
    if row.best is None or not row.trace:
        return row
    numbers, values = row.improvements()
    # As the tables judge it.
    goal = goal_of(reference_of(cell.problem, row), best, scale.target)
    shown = np.searchsorted(numbers, scale.grid, side="right") - 1
    hit = np.flatnonzero(values <= goal)[:1]
    kept = np.unique(np.concatenate([shown[shown >= 0], hit, [len(numbers) - 1]]))
    told: dict[str, Any] = {"trace": pack(_pairs(numbers[kept], values[kept]))}
    if row.recommended and (known := row.recommendations()) is not None:
        told["recommended"] = pack_values(known[1][kept])
    if row.seen and (known := row.oracle_trace()) is not None:
        last = np.searchsorted(known[0], scale.grid, side="right") - 1
        rows = np.unique(np.concatenate([last[last >= 0], [len(known[0]) - 1]]))
        told["seen"] = pack(_pairs(known[0][rows], known[1][rows]))
    return replace(row, **told)


def _pairs(numbers: NDArray[np.int64], values: NDArray[np.float64]) -> list[tuple[int, float]]:
    return list(zip(numbers.tolist(), values.tolist(), strict=True))


def _description(store: Store, cells: Sequence[CellRow]) -> str:
    problems = list({cell.problem.id: cell.problem for cell in cells}.values())
    places = {problem.id: i for i, problem in enumerate(problems)}
    facts = store.facts()
    optima = optima_told(facts.get("optima", "{}"))
    told = {
        "schema": SCHEMA,
        "facts": {key: value for key, value in facts.items() if key not in LEFT_OUT},
        "optima": {places[id]: best for id, best in optima.items() if id in places},
        # Each by its place, and not by the number that this store has for it.
        "problems": [
            {key: value for key, value in asdict(problem).items() if key != "id"}
            for problem in problems
        ],
        "cells": [
            asdict(
                ArchivedCell(
                    cell.label, cell.optimiser, cell.options, cell.digest, places[cell.problem.id]
                )
            )
            for cell in cells
        ],
    }
    return json.dumps(told, indent=1, sort_keys=True) + "\n"


def _fill(
    description: str, trials: Sequence[tuple[int, Sequence[TrialRow]]], stream: IO[bytes]
) -> None:
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as whole:
        _put(whole, "study.json", [description])
        for name, head, of in (
            ("trials.csv", [TRIAL], _trial_rows),
            ("traces.csv", [], _trace_rows),
            ("oracles.csv", [], _oracle_rows),
        ):
            _put(whole, name, _text(head, *(of(number, rows) for number, rows in trials)))


def _put(whole: zipfile.ZipFile, name: str, parts: Iterable[str]) -> None:
    # Without the date, the system and the rights of this run: the same trials are the same bytes.
    about = zipfile.ZipInfo(name)
    about.compress_type, about.create_system, about.external_attr = (
        zipfile.ZIP_DEFLATED,
        3,
        0o644 << 16,
    )
    with whole.open(about, "w", force_zip64=True) as stream:
        for part in parts:
            stream.write(part.encode("utf-8"))


def _text(*blocks: Iterable[Sequence[Any]]) -> Iterator[str]:
    """Blocks of rows as CSV, one block at a time in memory."""
    for block in blocks:
        stream = StringIO()
        csv.writer(stream, lineterminator="\n").writerows(block)
        yield stream.getvalue()


def _trial_rows(cell: int, rows: Sequence[TrialRow]) -> Iterator[tuple[Any, ...]]:
    for row in rows:
        truth = "none"
        if row.recommended is not None and row.seen is not None:
            truth = "noisy" if row.recommended else "exact"
        numbers = [getattr(row, name) for name in (*WHOLE, *REAL)]
        # As JSON also the reason: a spreadsheet would take one that begins with = for a formula.
        reason = json.dumps(row.reason)
        yield (
            *(cell, row.repetition, str(row.status), truth, *numbers),
            *(row.theta_text or "", reason),
        )


def _trace_rows(cell: int, rows: Sequence[TrialRow]) -> Iterator[tuple[Any, ...]]:
    for row in rows:
        evaluations, values = row.improvements()
        told: list[Any] = [None] * len(values)
        if row.recommended and (known := row.recommendations()) is not None:
            told = known[1].tolist()
        for point in zip(evaluations.tolist(), values.tolist(), told, strict=True):
            yield (cell, row.repetition, *point)


def _oracle_rows(cell: int, rows: Sequence[TrialRow]) -> Iterator[tuple[Any, ...]]:
    for row in rows:
        if row.seen and (known := row.oracle_trace()) is not None:
            for point in zip(known[0].tolist(), known[1].tolist(), strict=True):
                yield (cell, row.repetition, *point)


@contextmanager
def _one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except FAULTS as error:
        raise StudyError(
            f"{path} is no archive of a study, or damaged: {' '.join(str(error).split())[:120]}"
        ) from error


def _rows(whole: zipfile.ZipFile, name: str) -> Iterator[list[str]]:
    with whole.open(name) as stream, TextIOWrapper(stream, "utf-8", newline="") as text:
        yield from csv.reader(text)


class _Pages:
    """Rows of a file by trial, in the order of the trials."""

    def __init__(self, rows: Iterator[list[str]]) -> None:
        self._groups = groupby(rows, key=lambda row: (int(row[0]), int(row[1])))
        self._next = next(self._groups, None)

    @property
    def left(self) -> bool:
        """Whether there are rows that no trial has asked for."""
        return self._next is not None

    def of(self, key: tuple[int, int]) -> list[list[str]]:
        """The rows of a trial, without its key; none if the next ones are another's."""
        if self._next is None or self._next[0] != key:
            return []
        found = [row[2:] for row in self._next[1]]
        self._next = next(self._groups, None)
        return found


def _trial(
    key: tuple[int, int],
    told: Mapping[str, str],
    trace: Sequence[Sequence[str]],
    oracle: Sequence[Sequence[str]],
) -> TrialResult:
    kept: dict[str, Any] = {name: float(told[name]) if told[name] else None for name in REAL}
    kept |= {name: int(told[name]) for name in WHOLE}
    # Another machine's clock is no measure beside this one's.
    kept |= {"seconds": 0.0, "processor": None, "processor_batched": None}
    kept["trace"] = pack([(int(row[0]), float(row[1])) for row in trace])
    if told["truth"] == "exact":
        kept |= {"recommended": b"", "seen": b""}
    if told["truth"] == "noisy":
        kept["recommended"] = pack_values(np.array([float(row[2]) for row in trace]))
        kept["seen"] = pack([(int(row[0]), float(row[1])) for row in oracle])
    if told["theta"]:
        kept["theta"] = json.loads(told["theta"])
    return TrialResult(*key, Status(told["status"]), str(json.loads(told["reason"])), **kept)


AS_ONE = 500
"""Trials that are entered at once."""
MATCHING = {
    "budget": "evaluations a trial",
    "seed": "seed",
    "target": "target",
    "accuracy": "accuracy",
    "stop at target": "stop at the target",
}
"""What two studies must have in common, and its name."""
STARTS = "common start"


@contextmanager
def opened(path: Path, beside: Path | None = None) -> Iterator[Store]:
    """The store at a path, or of an archive, with the trials of another among its own.

    Raises
    ------
    StudyError
        If there are no results, or the archive is of other problems, budgets or seeds.
    """
    if beside is None and path.suffix != SUFFIX:
        with Store(path) as store:
            yield store
        return
    # A copy, which is thrown away: what a study has run itself stays its own.
    with (
        TemporaryDirectory(prefix="springpot-") as folder,
        Store(_copied(path, Path(folder)), write=True) as store,
    ):
        if beside is not None:
            archive = Archive.read(beside)
            _enter(store, archive, rivals_of(store, archive), _carried(store.facts(), archive))
        yield store


def _copied(path: Path, folder: Path) -> Path:
    """A store that may be written in: a copy of the one at a path, or what an archive holds."""
    copy = folder / f"{path.stem}.sqlite"
    if path.suffix != SUFFIX:
        with Store(path) as store:
            store.copy_to(copy)
        return copy
    archive = Archive.read(path)
    with Store(copy, write=True) as store:
        store.describe(archive.problems, archive.optima, archive.facts)
        _enter(store, archive, {i: cell.label for i, cell in enumerate(archive.cells)}, {})
    return copy


def rivals_of(store: Store, archive: Archive) -> dict[int, str]:
    """Cells of an archive that stand beside a study's own, by their place, with their labels.

    Raises
    ------
    StudyError
        If the two did not race on the same.
    """
    facts, cells = store.facts(), store.cells()
    if mismatch := _mismatch(facts, archive.facts) or _other_problem(cells, archive.problems):
        raise StudyError(f"{archive.path} cannot stand beside {facts['name']}: {mismatch}")
    own = {cell.problem.digest for cell in cells}
    run, labels = {cell.digest for cell in cells}, {cell.label for cell in cells}
    return {
        i: _label(cell.label, labels)
        for i, cell in enumerate(archive.cells)
        # What the study has run itself is not shown twice.
        if cell.digest not in run and archive.problems[cell.problem].digest in own
    }


def _label(label: str, taken: set[str]) -> str:
    if label in taken:
        return f"{label} (archive)"
    return label


def _mismatch(own: Mapping[str, str], archived: Mapping[str, str]) -> str:
    for key, name in MATCHING.items():
        if own.get(key) != archived.get(key):
            return f"its {name} is {archived.get(key, 'none')}, not {own.get(key, 'none')}"
    if (STARTS in own) != (STARTS in archived):
        return "only one of them has a common first point"
    return ""


def _other_problem(cells: Sequence[CellRow], archived: Sequence[ProblemRow]) -> str:
    known = {problem.digest: problem for problem in archived}
    for problem in {cell.problem.id: cell.problem for cell in cells}.values():
        told = f"{problem.dataset}, {problem.model}, {problem.objective}"
        if problem.digest not in known:
            return f"it has no trials of {told} with these data"
        # Neither the weights of an objective nor a model's law are in the digest, but they show
        # here.
        reference = known[problem.digest].reference
        if abs(reference - problem.reference) > ALIKE * abs(problem.reference):
            return f"the objective of {told} is another one there"
    return ""


def _enter(
    store: Store, archive: Archive, labels: Mapping[int, str], facts: Mapping[str, str]
) -> None:
    columns = {i: _columns(archive.cells[i], archive) for i in labels}
    _add(store, archive, store.adopt(columns, labels, facts))


def take_over(store: Store, archive: Archive, anew: Collection[str] = ()) -> None:
    """Enter the trials of an archive whose cells are a study's own: they need not be run again.

    Parameters
    ----------
    store : Store
        The study's.
    archive : Archive
        The published trials.
    anew : collection of str
        Labels of optimisers that are run again, as they are not what they were; what the store
        holds of them is dropped.
    """
    store.forget([cell.id for cell in store.cells() if cell.label in anew])
    own = {cell.digest: cell.id for cell in store.cells() if cell.label not in anew}
    cells = enumerate(archive.cells)
    _add(store, archive, {i: own[cell.digest] for i, cell in cells if cell.digest in own})


def _add(store: Store, archive: Archive, numbers: Mapping[int, int]) -> None:
    trials = archive.trials(numbers)
    while batch := list(islice(trials, AS_ONE)):
        store.add(batch, numbers)


def _columns(cell: ArchivedCell, archive: Archive) -> dict[str, object]:
    """What a store keeps of a cell, its problem by the digest."""
    return {
        "digest": cell.digest,
        "problem": archive.problems[cell.problem].digest,
        "optimiser": cell.optimiser,
        "options": cell.options,
        "budget": int(archive.facts["budget"]),
        "seed": archive.facts["seed"],
    }


def _carried(own: Mapping[str, str], archive: Archive) -> dict[str, str]:
    """Facts of an archive for a study beside it: libraries that only it used, whence it came."""
    facts = {key: value for key, value in archive.facts.items() if key not in ITS_OWN}
    missing = {key: value for key, value in facts.items() if key not in own}
    # Of what both have, always the first; the rest where it is another one.
    always = ("springpot", "python", "machine", "started")
    others = sorted(key for key in facts if own.get(key, facts[key]) != facts[key])
    told = [f"{key} {facts[key]}" for key in dict.fromkeys((*always, *others)) if key in facts]
    come = [f"{archive.path.name}, study {archive.facts['name']} ({', '.join(told)})"]
    come += [each["beside"] for each in (own, archive.facts) if "beside" in each]
    return missing | {"beside": "; ".join(come)}


def study_of(path: Path, optimisers: Sequence[str], only: Sequence[str] = ()) -> Study:
    """A study of the problems of an archive, for optimisers that are to be raced beside it.

    Parameters
    ----------
    path : Path
        The archive.
    optimisers : sequence of str
        Who is raced.
    only : sequence of str
        Names of data; those of all problems by default.

    Raises
    ------
    StudyError
        If its data are not known here under their names, or it has no trials of them.
    """
    archive = Archive.read(path)
    facts, models = archive.facts, dict[str, list[str]]()
    levels = json.loads(facts.get(NOISE, "{}"))
    there = [problem.dataset for problem in archive.problems]
    for name in only:
        if name not in there:
            raise StudyError(f"{path} has no trials of {name!r}")
    problems = [each for each in archive.problems if not only or each.dataset in only]
    for problem in problems:
        # Levels of noise are made from the data without it.
        name = problem.dataset
        if levels.get(name):
            name = name.rpartition("+")[0]
        expressions = models.setdefault(name, [])
        if problem.model not in expressions:
            expressions.append(problem.model)
    return Study(
        "-".join((facts["name"], "beside", *(name.rpartition("/")[2] for name in only))),
        datasets=[_data_of(name, path.parent) for name in models],
        models=models,
        objectives=_objectives(problems, levels),
        optimisers=list(optimisers),
        repetitions=int(facts["repetitions"]),
        budget=int(facts["budget"]),
        seed=int(facts["seed"]),
        target=float(facts["target"]),
        accuracy=float(facts["accuracy"]),
        stop_at_target="stop at target" in facts,
        noise=sorted(set(levels.values())),
        x0="common" if STARTS in facts else "own",
        asks=[facts[key] for key in ASKED if key in facts],
    )


def _data_of(name: str, folder: Path) -> str:
    """Where data are that an archive names: a set, or a file here or beside the archive.

    Whatever is found is compared by its digest before anything is raced.
    """
    stem = re.split("[@#?]", name)[0]
    known = {each for data in plugins().items("data set") for each in (data.name, *data.aliases)}
    if stem in known or plugins().problem(name) or Path(name).name != name:
        return name
    for place in (Path(), folder):
        files = sorted(each for each in place.glob("*.*") if each.stem == stem and each.is_file())
        if files:
            return f"{files[0]}{name[len(stem) :]}"
    raise StudyError(
        f"an archive holds no data: put the file that '{stem}' was read from into this folder or"
        " beside the archive"
    )


def _objectives(problems: Sequence[ProblemRow], levels: Mapping[str, float]) -> list[str]:
    """The objectives of a study of these problems: each its own, where that is what was raced."""
    plain = not any(levels.values())
    # Of a suite each problem has one of its own, and no sense by those of the others.
    if plain and all(problem.objective == _own_objective(problem) for problem in problems):
        return [OWN]
    return list(dict.fromkeys(problem.objective for problem in problems))


def _own_objective(problem: ProblemRow) -> str:
    known = plugins().problem(problem.dataset)
    return known.objective if known else ""
