"""A study that is run as a program of its own."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from runpy import run_module

from springpot.errors import StudyError


def main(study: object, arguments: Sequence[str] | None = None) -> None:
    """Run a study as a program.

    What ``springpot run`` does with the path of the script that declares it.

    Raises
    ------
    StudyError
        If the running program is not that script, so that workers could not find what it defines.
    """
    script = getattr(sys.modules["__main__"], "__file__", None)
    if script is None or getattr(sys.modules["__main__"], "study", None) is not study:
        raise StudyError("call study.main() in the script that declares it as study = Study(...)")
    # As the user wrote it where that is the script: the command is told in the report, to be
    # repeated elsewhere.
    written = script
    if Path(sys.argv[0]).resolve() == Path(script).resolve():
        written = sys.argv[0]
    if arguments is None:
        arguments = sys.argv[1:]
    sys.argv = ["springpot", "run", written, *arguments]
    # The command stands above this room and is started like any other program, not imported.
    run_module("springpot", run_name="__main__")
