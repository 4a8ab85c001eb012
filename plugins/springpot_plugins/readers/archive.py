"""What a workbook must be before openpyxl may see it: an archive of bounded size and depth."""

from __future__ import annotations

import zipfile
import zlib
from contextlib import suppress
from pathlib import Path
from typing import IO, Any
from xml.parsers.expat import ExpatError, ParserCreate

from springpot.errors import DataError
from springpot.measurement import budget_of

_MOST_ENTRIES = 10_000
"""Files in a workbook: one has some ten, and a list of millions would take long to read."""
_DEEPEST = 100
"""Elements of XML within one another: a sheet has six, its charts some thirty."""


def check_archive(path: Path) -> None:
    """Refuse what is no workbook, or would take long to unpack or to parse.

    Raises
    ------
    DataError
        If the file is no workbook, unpacks to far too much, or holds XML nested too deeply.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _check_sizes(entries, budget_of(path).memory)
            for entry in entries:
                with archive.open(entry) as stream:
                    _check_depth(stream)
    except (
        zipfile.BadZipFile,
        OSError,
        ValueError,
        NotImplementedError,
        EOFError,
        RuntimeError,
        zlib.error,
    ) as error:
        raise DataError(f"no readable Excel file: {error}") from None


def _check_sizes(entries: list[zipfile.ZipInfo], most: int) -> None:
    if not any(entry.filename.startswith("xl/") for entry in entries):
        raise DataError("a zip archive without an Excel workbook; unpack it, or save it as .xlsx")
    size = sum(entry.file_size for entry in entries)
    # Before anything is unpacked: a small archive may hold terabytes of zeros.
    if size > most or len(entries) > _MOST_ENTRIES:
        raise DataError(
            f"the workbook unpacks to {size} bytes; save the one sheet that matters, or CSV"
        )


def _check_depth(stream: IO[bytes]) -> None:
    """Refuse elements nested without end.

    A tree of them is built and freed within C, where no clock is heard.
    """
    depth = 0

    def enter(name: str, attributes: Any) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise DataError("the workbook is nested too deeply; save it anew, or as CSV")

    def leave(name: str) -> None:
        nonlocal depth
        depth -= 1

    parser = ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = enter, leave
    # A picture ends it at its first byte, and what is broken as it will end openpyxl.
    with suppress(ExpatError):
        parser.ParseFile(stream)
