"""What every export of a study shares.

Its trials by problem and optimiser, as other tools number them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from springpot.errors import OutputError

from .rows import CellRow, ProblemRow, TrialRow
from .store import Store


@dataclass(frozen=True)
class Export:
    """What was written.

    Parameters
    ----------
    folder : Path
        Where.
    files : tuple of Path
        The files.
    trials, left_out : int
        Trials in them, and those without a value that are not.
    hint : str
        How to open it.
    """

    folder: Path
    files: tuple[Path, ...]
    trials: int
    left_out: int
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Block:
    """The trials of one optimiser on one problem, as other tools number them.

    Parameters
    ----------
    cell : CellRow
        Problem and optimiser.
    folder : str
        Folder of the optimiser, different for each.
    function : int
        Number of the problem, counted from 1 in the order of the study.
    dimension : int
        Parameters searched.
    best : float
        Smallest objective known of the problem.
    trials : tuple of TrialRow
        Those with a value.
    """

    cell: CellRow
    folder: str
    function: int
    dimension: int
    best: float
    trials: tuple[TrialRow, ...]

    @property
    def name(self) -> str:
        """Data set, model and objective in one word."""
        return function_name(self.cell.problem)


def created(folder: Path) -> Path:
    """The folder, made if it is missing.

    Raises
    ------
    OutputError
        If it cannot be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror or error}") from error
    return folder


def blocks(store: Store) -> Iterator[Block]:
    """Every cell of a study that has a trial with a value, one at a time."""
    cells = {cell.id: cell for cell in store.cells()}
    # From 1 on in the order of the study, as other tools number functions; the store's own numbers
    # have gaps.
    numbers = {
        number: i for i, number in enumerate(dict.fromkeys(c.problem.id for c in cells.values()), 1)
    }
    folders = _folders([cell.label for cell in cells.values()])
    bests = store.bests()
    for number, rows in store.trials():
        # What failed has no value, for which these formats have no word: it is counted by
        # `left_out`.
        sound = tuple(row for row in rows if row.trace)
        if number in cells and sound:
            cell, dimension = cells[number], len(sound[0].theta)
            folder, problem = folders[cell.label], cell.problem.id
            yield Block(cell, folder, numbers[problem], dimension, bests[problem], sound)


def left_out(store: Store) -> int:
    """Trials without a value, which other tools have no way to tell of."""
    shown = {cell.id for cell in store.cells()}
    return sum(not row.trace for number, rows in store.trials() if number in shown for row in rows)


def function_name(problem: ProblemRow) -> str:
    """Data set, model and objective in one word."""
    return slug(f"{problem.dataset}_{problem.model}_{problem.objective}")


def slug(text: str) -> str:
    """`text` as a file name."""
    return "".join(c if c.isalnum() or c in "-_." else "-" for c in text)


def _folders(labels: list[str]) -> dict[str, str]:
    """A folder name for each label, no two the same even where file systems ignore case."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for label in dict.fromkeys(labels):
        # Labels that differ in a sign only may become the same name.
        name, n = slug(label), 1
        # Two labels must not share a folder where upper and lower case are one.
        while name.lower() in taken:
            n += 1
            name = f"{slug(label)}-{n}"
        taken.add(name.lower())
        names[label] = name
    return names
