"""Names that a browser gave, and files of that name for as long as a reader needs them."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LONGEST = 80
"""Signs of a file's name that are kept."""
UNSAFE = re.compile(r"[^\w.+() -]", re.ASCII)
"""What has a meaning in paths, FILE#PART?COLUMN=UNIT@CONDITION or a terminal is none of these."""


def safe_name(name: str) -> str:
    r"""The last part of a name that a browser gave, with nothing in it that means more than a name.

    Examples
    --------
    >>> names = "../../etc/passwd", "C:\\\\data\\\\my damper.csv", "-rf?x=1"
    >>> [safe_name(name) for name in names]
    ['passwd', 'my damper.csv', '_rf_x_1']
    """
    # Both slashes: the browser may run on another system than this.
    last = re.split(r"[/\\]", name)[-1]
    # The end is kept, where the suffix stands.
    plain = UNSAFE.sub("_", last)[-LONGEST:].strip()
    # A hyphen would begin an option, and a dot hide the file.
    return re.sub(r"^[-.]+", "_", plain) or "data"


@contextmanager
def as_file(name: str, content: bytes) -> Iterator[Path]:
    """A file of that name in a folder of its own, which is the current one meanwhile.

    Errors name just the file.

    Only for worker processes, which do one thing at a time.
    """
    here = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="springpot-") as folder:
        os.chdir(folder)
        try:
            # Relative, within the new folder: no name can lead out of it.
            path = Path(safe_name(name))
            path.write_bytes(content)
            yield path
        finally:
            # Before the folder is removed: no process may stay in what is gone.
            os.chdir(here)
