"""The command line ``springpot``: every command is a small module that is loaded when it is called."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import NoReturn


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of this process.
    """
    try:
        from .faults import exit_code
        from .group import run
    except KeyboardInterrupt:
        sys.exit(130)
    sys.exit(exit_code(lambda: run(sys.argv[1:] if arguments is None else list(arguments))))
