"""A user's study script: loaded by path in the command and in every worker, or run as a program."""

from __future__ import annotations

import os
import sys
import traceback
from contextlib import redirect_stdout
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from springpot.errors import SpringpotError, StudyError

from .study import Study


def load_script(path: Path) -> ModuleType:
    """The script as a module, executed once in a process.

    It has the same name everywhere, so that an optimiser defined in it is found again in a worker.

    Raises
    ------
    StudyError
        If it cannot be read or fails, with file and line.
    """
    # Not by Path.resolve, for which a link that leads to itself is a fault.
    path = Path(os.path.realpath(path))
    name = f"springpot_study_{path.stem}"
    loaded = sys.modules.get(name)
    if loaded is not None and loaded.__file__ == str(path):
        return loaded
    if not path.is_file():
        raise StudyError(f"there is no study script {path}: give the path of a Python file")
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise StudyError(f"{path} is no Python file: a study script ends in .py")
    module = module_from_spec(spec)
    # Before it runs, as pickle looks for what it defines under this name.
    sys.modules[name] = module
    # As Python does for a script: files beside it can be imported.
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    try:
        # What a script prints is no part of a command's own output.
        with redirect_stdout(sys.stderr):
            spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise StudyError(_one_line(path, error)) from error
    return module


def _one_line(path: Path, error: BaseException) -> str:
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename == str(path)
    ]
    if isinstance(error, SyntaxError) and error.filename == str(path):
        lines.append(error.lineno)
    line: int | None = 1
    # The last of the script's own lines: the user can mend that one, and not the library it calls.
    if lines:
        line = lines[-1]
    message = str(error)
    if isinstance(error, SyntaxError):
        # Its text would name the file and the line once more.
        message = error.msg
    message = " ".join(message.split())
    if not isinstance(error, SpringpotError):
        message = f"{type(error).__name__}: {message}"
    return f"{path}, line {line}: {message}"


def load_study(path: str | Path) -> Study:
    """The study that a script declares.

    Parameters
    ----------
    path : str or Path
        A Python file with ``study = Study(...)``.

    Raises
    ------
    StudyError
        If the script fails (with file and line) or declares none, or several of which none is
        called ``study``.
    """
    module = load_script(Path(path))
    studies = {name: value for name, value in vars(module).items() if isinstance(value, Study)}
    if "study" in studies:
        return studies["study"]
    if len({id(value) for value in studies.values()}) == 1:
        return next(iter(studies.values()))
    if not studies:
        raise StudyError(f"{path} declares no study: write study = Study(...) in it")
    raise StudyError(f"{path} declares {', '.join(studies)}: call the one to run 'study'")
