"""Readers of measurement files: chosen by what a file holds, never by its name alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from .measurement import Measurement
from .signals import Signals


@dataclass(frozen=True)
class Choice:
    """What a user says about a file beside its name: ``FILE#PART?COLUMN=MEANING,...``.

    Parameters
    ----------
    part : str
        Which of several steps, sweeps or sheets: a number (``2``), numbers (``2-4``) or a part of
        their names; all that can be used by default.
    columns : mapping of str to str
        What the file leaves open: by a column's name, title or number its unit (``frequency=Hz``),
        its meaning (``3=loss [Pa]``), or a constant (``frequency=1 [Hz]``).

    Examples
    --------
    >>> from springpot.measurement import Choice
    >>> bool(Choice()), Choice("2", {"frequency": "Hz"}).columns["frequency"]
    (False, 'Hz')
    """

    part: str = ""
    columns: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def __bool__(self) -> bool:
        return bool(self.part or self.columns)


@dataclass(frozen=True)
class Part:
    """One step, sweep or sheet of a file.

    Parameters
    ----------
    name : str
        As the file calls it.
    points : int
        Number of its rows.
    usable : bool
        Whether it is a dynamic test, so that it can be opened.
    says : str
        What it holds, or what it lacks.
    asks : bool
        Whether it opens once the user says what the file leaves open.
    """

    name: str
    points: int
    usable: bool = True
    says: str = ""
    asks: bool = False


def parts_as_opened(parts: Sequence[Part], measurement: Measurement) -> list[Part]:
    """The parts of a file.

    Those that ask for something are usable where they opened with what the user says.

    Parameters
    ----------
    parts : sequence of Part
        As the file alone tells of them.
    measurement : Measurement
        What was opened of the file.
    """
    if "note parts" not in measurement.provenance:
        return list(parts)
    made = []
    for part in parts:
        if part.asks and f"note {part.name}" not in measurement.provenance:
            part = replace(part, usable=True, says="")
        made.append(part)
    return made


@dataclass(frozen=True)
class Reader:
    """One file format.

    Parameters
    ----------
    name : str
        Shown by ``springpot list readers``.
    summary : str
        One sentence on the format.
    recognises : callable
        From the first bytes of a file to a confidence between 0 (not mine) and 1 (surely mine).
    read : callable
        From a path and a `Choice` to the measurement. Its `DataError` need not name the file: the
        name is put before the message (``line 3: ...``), and in the place of ``'FILE`` in a hint
        (``open 'FILE?storage=Pa'``).
    signals : callable, optional
        From a path and a `Choice` to the displacement and force against time, for formats that hold
        such signals.
    text : callable, optional
        From a measurement to the text of a file in this format that reads back as the same bits.
    parts : callable, optional
        From a path to the `Part` s of a file, in order, for formats that hold several.
    """

    name: str
    summary: str
    recognises: Callable[[bytes], float]
    read: Callable[[Path, Choice], Measurement]
    signals: Callable[[Path, Choice], Signals] | None = None
    text: Callable[[Measurement], str] | None = None
    parts: Callable[[Path], Sequence[Part]] | None = None
