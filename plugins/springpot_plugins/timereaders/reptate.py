"""RepTate's files of tests in time: keys in the first line, then two columns.

``.gt`` holds t and G(t); ``.shear`` has the key ``gdot`` and holds t and the growth of the
viscosity, which times the rate is the stress of a startup, and perhaps further columns; ``.creep``
has the key ``stress`` and holds t and the strain. All in s, Pa and Pa s.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import Choice, Loading, TimeReader, TimeTest
from springpot.rheology import Real

from ..readers.grid import is_number, lines_of
from ..readers.reptate import CLOCKS, first_line
from ..readers.text import head_text, text_of
from .tables import without_ties

STEPS = {"gt", "g(t)"}
"""Names that may stand above the second column of a relaxation."""


def recognises(head: bytes) -> float:
    """High for a first line of keys above two columns of numbers, or with the rate of a startup."""
    text = head_text(head)
    keys = first_line(text)
    if not keys or keys.keys() & CLOCKS:
        return 0.0
    widths = {len(line.split()) for line in lines_of(text)[1:40] if _is_row(line)}
    # A sweep of RepTate has the same first line above three columns, but nothing that is sheared at
    # one rate; what stands behind the first two columns of a startup is the rheometer's.
    return 0.96 * (widths == {2} or ("gdot" in keys and bool(widths) and min(widths) >= 2))


def read(path: Path, choice: Choice) -> list[TimeTest]:
    """The test in a file.

    Raises
    ------
    DataError
        If a row is none, or the rate or stress is no number.
    """
    if choice.columns or choice.part:
        raise DataError(
            f"{path}: RepTate's columns have their meaning by the format; leave out what follows"
            " the name"
        )
    text = text_of(path)
    keys, rows = first_line(text), _rows(text, path)
    temperature = None
    if "T" in keys:
        temperature = _number(keys, "T", path)
    origin = {"format": "RepTate", **{f"reptate.{key}": value for key, value in keys.items()}}
    rows = rows[without_ties(rows[:, 0], origin)]
    t, y = rows[:, 0], rows[:, 1]
    given = {"temperature": temperature, "name": path.stem, "provenance": origin}
    if "gdot" in keys:
        rate = _number(keys, "gdot", path)
        ramp = Loading(np.array([0.0, t[-1]]), np.array([0.0, rate * t[-1]]))
        # The file holds the growth of the viscosity, which times the rate is the stress.
        return [TimeTest(t, y * rate, ramp, letter="G", **given)]  # type: ignore[arg-type]
    if "stress" in keys:
        if keys.get("rec", "0") not in ("0", ""):
            origin["note recovery"] = (
                "the strain that came back once the stress was taken away, read as the creep"
                " without its flow: the recoverable compliance"
            )
        step = Loading.step(_number(keys, "stress", path))
        return [TimeTest(t, y, step, "force", letter="G", **given)]  # type: ignore[arg-type]
    return [replace(TimeTest.of_relaxation(t, y, "Pa", **given), letter="G")]  # type: ignore[arg-type]


def _is_row(line: str) -> bool:
    cells = line.split()
    return len(cells) > 1 and all(map(is_number, cells))


def _rows(text: str, path: Path) -> Real:
    lines = [line for line in lines_of(text)[1:] if _is_row(line)]
    rows = np.array([[float(cell) for cell in line.split()[:2]] for line in lines])
    if len(rows) < 2:
        raise DataError(f"{path}: a RepTate file without two columns of numbers")
    # A step at t = 0 has no value there that a finite sum could have.
    return rows[rows[:, 0] > 0.0]


def _number(keys: dict[str, str], key: str, path: Path) -> float:
    try:
        return float(keys[key])
    except ValueError:
        raise DataError(f"{path}: {key}={keys[key]:.20} in the first line is no number") from None


READER = TimeReader(
    "time-reptate", "RepTate .gt, .shear and .creep: relaxation, startup, creep", recognises, read
)
