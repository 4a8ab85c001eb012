"""Output files: written whole or not at all.

So that a crash or a full disk never leaves half a result.

A link is followed, a device or pipe is written to, and no output replaces a file that the same run
reads or writes.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO

from springpot.errors import OutputError


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
