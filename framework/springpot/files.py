"""Files: written whole or not at all, read within limits of size, time and memory.

A crash or a full disk never leaves half a result. A link is followed, a device or pipe is written
to, and no output replaces a file that the same run reads or writes.

A regular file of a bounded size is read whole; what never ends or must be waited for is refused
before it is opened. A reader refuses what is beyond sizes that are bounded: bytes of text, columns,
tables, cells, what an archive unpacks to. In a process of springpot's own it is limited as well: to
`FILES.times` the file's size plus `FILES.spare` of memory, and to `FILES.seconds` plus the time for
its size of the processor. What ends for want of these ends in one line.
"""

from __future__ import annotations

import json
import os
import re
import stat
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from io import BytesIO
from math import isfinite
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO, Any, NamedTuple, TypeVar

from springpot.errors import DataError, OutputError
from springpot.limits import OverTime, limited
from springpot.numerics import LARGEST as LARGEST_NUMBER
from springpot.writing import suggested


@dataclass(frozen=True)
class _Run:
    """Files of one command: device and number of each that is read, the places of its outputs."""

    inputs: set[tuple[int, int]] = field(default_factory=set)
    outputs: set[Path] = field(default_factory=set)


_RUN: ContextVar[_Run | None] = ContextVar("run", default=None)
"""None where nobody runs a command."""


@contextmanager
def one_run() -> Iterator[None]:
    """Let nothing that is written meanwhile replace what `keep_input` or `keep_output` named."""
    token = _RUN.set(_Run())
    try:
        yield
    finally:
        _RUN.reset(token)


def keep_input(path: str | Path) -> None:
    """Let no output of this run replace this file, if it is one.

    Raises
    ------
    OutputError
        If one of those named before would.
    """
    run = _RUN.get()
    found = _found(Path(path))
    if run is None or found is None or not stat.S_ISREG(found.st_mode):
        return
    run.inputs.add((found.st_dev, found.st_ino))
    # Named within another file, it may be known only now.
    if _target(Path(path)) in run.outputs:
        require_writable(path)


def keep_output(path: str | Path) -> None:
    """Let no other output of this run go to the same file.

    Raises
    ------
    OutputError
        If one goes there already, by whatever name or link.
    """
    run = _RUN.get()
    # Devices and pipes take one after the other.
    if run is None or _is_stream(Path(path)):
        return
    target = _target(Path(path))
    if target in run.outputs:
        raise OutputError(
            f"cannot write {path}: another output of this command goes there; give another name"
        )
    run.outputs.add(target)


def require_writable(path: str | Path) -> Path:
    """`path`, after a check that a file can be put there; called before long work, not after it.

    Raises
    ------
    OutputError
        If its folder does not exist or is read-only, the file is read-only or an input of this run,
        or the path is a folder.
    """
    path = Path(path)
    target = _target(path)
    folder = target.parent
    if target.is_dir():
        raise OutputError(f"cannot write {path}: it is a folder, give a file name in it")
    if _found(target) is None and target.is_symlink():
        raise OutputError(f"cannot write {path}: it is a link to itself")
    if not folder.is_dir():
        raise OutputError(f"cannot write {path}: there is no folder {folder}, create it first")
    found, run = _found(target), _RUN.get()
    if run and found is not None and (found.st_dev, found.st_ino) in run.inputs:
        raise OutputError(
            f"cannot write {path}: it is read by this very command; give another name"
        )
    if found is not None and not os.access(target, os.W_OK):
        raise OutputError(f"cannot write {path}: no permission to write to it")
    # Nothing is put beside a device.
    if not _is_stream(target) and not os.access(folder, os.W_OK):
        raise OutputError(f"cannot write {path}: no permission to write in {folder}")
    return path


def write_with(path: str | Path, fill: Callable[[IO[bytes]], object]) -> Path:
    """Replace the file at `path` by what `fill` writes, in one step.

    A device or pipe gets it written.

    Parameters
    ----------
    path : str or Path
        Where the file will be; where it is a link, what the link points to.
    fill : callable
        Writes into a binary stream.

    Raises
    ------
    OutputError
        If the file cannot be written, or this run reads it; what was there before stays.
    """
    path = require_writable(path)
    target = _target(path)
    try:
        if _is_stream(target):
            _pour(target, fill)
        else:
            _replace(target, fill)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def write_text(path: str | Path, text: str) -> Path:
    """Replace the file at `path` by `text` in UTF-8, in one step; see `write_with`."""
    return write_with(path, lambda stream: stream.write(text.encode()))


def _replace(target: Path, fill: Callable[[IO[bytes]], object]) -> None:
    # Beside the target: a rename is only one step within one file system.
    with NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}.", delete=False) as draft:
        try:
            fill(draft)
            draft.flush()
            # Before the rename: or a crash could leave the new name on a file whose content never
            # reached the disk.
            os.fsync(draft.fileno())
            os.chmod(draft.name, _mode(target))
            os.replace(draft.name, target)
        except BaseException:
            # Whatever ended it, even Ctrl-C: no half draft stays beside the user's files.
            Path(draft.name).unlink(missing_ok=True)
            raise


def _pour(target: Path, fill: Callable[[IO[bytes]], object]) -> None:
    # Whole first: formats such as PDF go back in what they have written, and a pipe cannot.
    whole = BytesIO()
    fill(whole)
    if not _is_stdout(target):
        target.write_bytes(whole.getvalue())
        return
    # Opened anew, a file would be written from its beginning, over what was printed.
    sys.stdout.flush()
    with os.fdopen(os.dup(1), "wb") as stream:
        stream.write(whole.getvalue())


def _target(path: Path) -> Path:
    """Where the links end; a device or pipe by the name that was given."""
    # What /dev/stdout points to has no name of its own where it is a pipe.
    if _is_stream(path):
        return path
    return Path(os.path.realpath(path))


def _is_stream(path: Path) -> bool:
    """Whether `path` is written to instead of replaced.

    No file or folder, or where the text of this run goes.
    """
    found = _found(path)
    if found is None or stat.S_ISDIR(found.st_mode):
        return False
    return not stat.S_ISREG(found.st_mode) or _is_stdout(path)


def _is_stdout(path: Path) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(1))
    # Nothing there, or standard output is closed.
    except (OSError, ValueError):
        return False


def _found(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except (OSError, ValueError):
        return None


def _mode(path: Path) -> int:
    """Permissions of the file that is replaced, or what the umask gives a new one."""
    if path.exists():
        return path.stat().st_mode & 0o777
    # The mask can only be read by setting it.
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


class FileLimits(NamedTuple):
    """What a file may hold and cost, so that none takes the machine with it."""

    largest: int
    """Bytes of a file that is read in one piece.

    A table of two million rows, a fit to a million points.
    """
    largest_toml: int
    """Bytes of a description that somebody wrote by hand; its reader is a slow one."""
    containers: int
    """Lists and objects of a file of JSON: each takes thirty times the memory of its brackets."""
    seconds: float
    """Of processor time for any file.

    The largest instrument export among the tests takes a tenth of it.
    """
    bytes_a_second: float
    """For each of which there is one more second: text is parsed at two to four times this rate."""
    times: int
    """Bytes of memory for each of a file: a table needs about seven while its cells are text."""
    spare: int
    """Bytes of memory for any file: libraries that a reader imports, and an archive that
    unpacks.
    """


FILES = FileLimits(
    largest=64 << 20,
    largest_toml=1 << 18,
    containers=1_000_000,
    seconds=5.0,
    bytes_a_second=10e6,
    times=10,
    spare=200 << 20,
)
_DEEP_KEY = re.compile(r"""(?:\.\s*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')\s*){50}""")
"""A dotted name of more than fifty parts.

The memory of Python's reader grows with the square of their number.
"""


def require_regular(path: Path) -> None:
    """Refuse what has no end or must be waited for.

    What is not there at all is found when it is opened.

    Raises
    ------
    DataError
        If the path is a pipe, a socket or a device.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise DataError(
            f"{path}: a pipe or device, no regular file; save what comes from it, and open that"
        )


def bytes_of(path: Path, most: int = FILES.largest) -> bytes:
    """All bytes of a regular file.

    Parameters
    ----------
    path : Path
        As the user named it.
    most : int
        Bytes that it may have.

    Raises
    ------
    DataError
        If it is a pipe or device, larger than that, or cannot be read; the line names it.
    """
    require_regular(path)
    try:
        with path.open("rb") as stream:
            # Not by the size that the system tells, which a file of the system itself has none of.
            content = stream.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"{path} cannot be read: {reason}") from None
    if len(content) > most:
        raise DataError(
            f"{path} is too large: at most {_size(most)} are read in one piece;"
            " save what matters alone"
        )
    return content


def _size(most: int) -> str:
    if most >= 1 << 20:
        return f"{most >> 20} MiB"
    return f"{most >> 10} KiB"


def text_in(path: Path, most: int = FILES.largest) -> str:
    """The text of a regular file in UTF-8, without the mark that spreadsheets put before it.

    Raises
    ------
    DataError
        As `bytes_of`, or if it is no text.
    """
    try:
        return bytes_of(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path} is no text in UTF-8 (byte {error.start}); save it as such"
        ) from None


def json_of(text: str, finite: bool = False) -> Any:
    """What a text of JSON holds.

    Parameters
    ----------
    text : str
        The text.
    finite : bool
        Whether all numbers must be such as a float holds, as in all that springpot writes; a
        program of an instrument may write NaN.

    Raises
    ------
    ValueError
        If it is none, too deeply nested, or of too many parts.
    """
    # Counted before anything is made of them; those within words count as well, which no answer has
    # a million of.
    if text.count("[") + text.count("{") > FILES.containers:
        raise ValueError(f"more than {FILES.containers} lists and objects")
    try:
        if finite:
            return json.loads(text, parse_float=_usable, parse_int=_whole, parse_constant=_usable)
        return json.loads(text)
    # Nested brackets are read by recursion.
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _finite(word: str) -> float:
    value = float(word)
    if not isfinite(value):
        raise ValueError(f"{word:.20} is no finite number")
    return value


def _usable(word: str) -> float:
    value = float(word)
    # Nor is what is no number below anything.
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"{word:.20} is no number that can be used")
    return value


def _whole(word: str) -> int:
    # As a float first: Python refuses to read longer whole numbers at all.
    _usable(word)
    return int(word)


def toml_of(text: str) -> dict[str, Any]:
    """What a text of TOML holds.

    Raises
    ------
    ValueError
        If it is none, too deeply nested, or a number in it is not finite.
    """
    if _DEEP_KEY.search(text):
        raise ValueError("nested too deeply")
    try:
        return tomllib.loads(text, parse_float=_finite)
    # Nested brackets are read by recursion.
    except RecursionError:
        raise ValueError("nested too deeply") from None


def toml_in(path: Path) -> dict[str, Any]:
    """What a description in TOML holds.

    Raises
    ------
    DataError
        As `text_in`, or if it is no TOML.
    """
    try:
        return toml_of(text_in(path, FILES.largest_toml))
    except ValueError as error:
        raise DataError(f"{path} is no TOML: {error}") from None


T = TypeVar("T")

MOST_COLUMNS = 10_000
"""Of a table: a sheet of Excel can have 16,384, and each is asked for its meaning."""
MOST_CELLS = 1_000_000
"""Of a workbook, whose cells take a thousand times as long as those of a text."""
MOST_TABLES = 10_000
"""Below one another in one file, each of which is a part that can be chosen."""


@dataclass(frozen=True)
class Budget:
    """What reading one file may take.

    Parameters
    ----------
    seconds : float
        Of processor time.
    memory : int
        Bytes, beyond what the process had before.
    """

    seconds: float
    memory: int


def budget_of(path: Path) -> Budget:
    """What reading this file may take."""
    try:
        size = path.stat().st_size
    except (OSError, ValueError):
        size = 0
    return Budget(FILES.seconds + size / FILES.bytes_a_second, FILES.times * size + FILES.spare)


def within_budget(path: Path, action: Callable[[], T]) -> T:
    """What `action` gives, which reads the file; ended when it takes more than the file is worth.

    In a process that is not springpot's own it is called, and no more: see `springpot.limits`.

    Raises
    ------
    DataError
        If the file is a pipe or device, or time or memory ended.
    """
    require_regular(path)
    budget = budget_of(path)
    try:
        return limited(action, budget.seconds, budget.memory)
    except OverTime:
        spent = f"more than {budget.seconds:.1f} s of processor time"
    except MemoryError:
        spent = f"more than {budget.memory >> 20} MiB of memory"
    raise DataError(
        f"{path}: reading it was ended: it takes {spent}, too much for its size; save only the"
        f" table that matters, in several files if need be ({suggested('signals', 'FILE')} reads"
        " time signals of any length)"
    )
