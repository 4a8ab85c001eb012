"""Output files: written whole or not at all, so that a crash or a full disk never leaves half a result."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO

from springpot.errors import OutputError


def require_writable(path: str | Path) -> Path:
    """`path`, after a check that a file can be put there; called before long work, not after it.

    Raises
    ------
    OutputError
        If its folder does not exist or is read-only, or the path is a folder.
    """
    path = Path(path)
    folder = path.parent
    if path.is_dir():
        raise OutputError(f"cannot write {path}: it is a folder, give a file name in it")
    if not folder.is_dir():
        raise OutputError(f"cannot write {path}: there is no folder {folder}, create it first")
    if not os.access(folder, os.W_OK):
        raise OutputError(f"cannot write {path}: no permission to write in {folder}")
    return path


def write_with(path: str | Path, fill: Callable[[IO[bytes]], object]) -> Path:
    """Replace the file at `path` by what `fill` writes, in one step.

    Parameters
    ----------
    path : str or Path
        Where the file will be.
    fill : callable
        Writes into a binary stream.

    Raises
    ------
    OutputError
        If the file cannot be written; what was there before stays.
    """
    path = require_writable(path)
    try:
        # Beside the target: a rename is only one step within one file system.
        with NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as draft:
            try:
                fill(draft)
                draft.flush()
                # Before the rename: or a crash could leave the new name on a file whose content never reached the
                # disk.
                os.fsync(draft.fileno())
                os.chmod(draft.name, _mode(path))
                os.replace(draft.name, path)
            except BaseException:
                # Whatever ended it, even Ctrl-C: no half draft stays beside the user's files.
                Path(draft.name).unlink(missing_ok=True)
                raise
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def write_text(path: str | Path, text: str) -> Path:
    """Replace the file at `path` by `text` in UTF-8, in one step; see `write_with`."""
    return write_with(path, lambda stream: stream.write(text.encode()))


def _mode(path: Path) -> int:
    """Permissions of the file that is replaced, or what the umask gives a new one."""
    if path.exists():
        return path.stat().st_mode & 0o777
    # The mask can only be read by setting it.
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
