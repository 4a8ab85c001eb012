"""Names that others choose for files and data sets.

Which are taken, and that a file lies where its name says.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from springpot.errors import DataError

_NAME = re.compile(r"\w(?:[\w.+=,() -]{0,98}[\w)])?")
"""Letters and digits of any language, and signs without a meaning to file systems and shells."""


def is_name(text: str) -> bool:
    """Whether this may name a file or a data set."""
    return _NAME.fullmatch(text) is not None


def inside(folder: Path, name: str) -> Path:
    """The file of that name in `folder`; parts of a name are joined by ``/``.

    Raises
    ------
    DataError
        If the name has other signs than those allowed, or leads out of the folder, by a link too.
    """
    parts = name.split("/")
    if not all(map(is_name, parts)):
        raise DataError(
            f"'{name:.80}' names no file: use letters, digits and . _ + - = , ( ) and blanks"
        )
    path = folder.joinpath(*parts)
    # Resolved, since a link within the folder may lead anywhere. One that leads to itself stays,
    # and opens nothing.
    if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder)):
        raise DataError(f"{path} leads out of its folder; put the file itself there")
    return path
