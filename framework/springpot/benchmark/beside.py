"""A study beside the trials of an archive, as if all had run together."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from springpot.errors import StudyError
from springpot.numerics import ALIKE
from springpot.registry import plugins

from .archive import Archive, ArchivedCell
from .store import Store
from .study import OWN, Study
from .summary import CellRow, ProblemRow

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
    """The store at a path, with the trials of an archive among its own if there is one.

    Raises
    ------
    StudyError
        If there are no results, or the archive is of other problems, budgets or seeds.
    """
    if beside is None:
        with Store(path) as store:
            yield store
        return
    archive = Archive.read(beside)
    # A copy, which is thrown away: what a study has run itself stays its own.
    with TemporaryDirectory(prefix="springpot-") as folder:
        copy = Path(folder) / path.name
        with Store(path) as store:
            rivals = rivals_of(store, archive)
            store.copy_to(copy)
        with Store(copy, write=True) as store:
            _enter(store, archive, rivals)
            yield store


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


def _enter(store: Store, archive: Archive, rivals: Mapping[int, str]) -> None:
    chosen = {i: archive.cells[i] for i in rivals}
    columns = {i: _columns(cell, archive) for i, cell in chosen.items()}
    numbers = store.adopt(columns, rivals, {"beside": _told(archive)})
    trials = archive.trials(rivals)
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


def _told(archive: Archive) -> str:
    facts = archive.facts
    shown = [key for key in ("springpot", "python", "machine", "started") if key in facts]
    parts = [f"{key} {facts[key]}" for key in shown]
    return f"{archive.path.name}, study {facts['name']} ({', '.join(parts)})"


def study_of(path: Path, optimisers: Sequence[str]) -> Study:
    """A study of the problems of an archive, for optimisers that are to be raced beside it.

    Raises
    ------
    StudyError
        If its data are not known here under their names.
    """
    archive = Archive.read(path)
    facts, models = archive.facts, dict[str, list[str]]()
    levels = json.loads(facts.get("noise", "{}"))
    for problem in archive.problems:
        # Levels of noise are made from the data without it.
        name = problem.dataset
        if levels.get(name):
            name = name.rpartition("+")[0]
        expressions = models.setdefault(name, [])
        if problem.model not in expressions:
            expressions.append(problem.model)
    return Study(
        f"{facts['name']}-beside",
        datasets=list(models),
        models=models,
        objectives=_objectives(archive.problems, levels),
        optimisers=list(optimisers),
        repetitions=int(facts["repetitions"]),
        budget=int(facts["budget"]),
        seed=int(facts["seed"]),
        target=float(facts["target"]),
        accuracy=float(facts["accuracy"]),
        stop_at_target="stop at target" in facts,
        noise=sorted(set(levels.values())),
        x0="common" if STARTS in facts else "own",
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
