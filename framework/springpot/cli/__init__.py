"""The command line ``springpot``: every command is a small module that is loaded when it is called."""

from __future__ import annotations

import os
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
    # The matrices of a fit are small: threads only wait for one another, a factor of twenty on a busy machine.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    try:
        from .faults import exit_code
        from .group import run
    except KeyboardInterrupt:
        sys.exit(130)
    sys.exit(exit_code(lambda: run(sys.argv[1:] if arguments is None else list(arguments))))
