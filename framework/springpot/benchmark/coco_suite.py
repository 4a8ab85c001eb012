"""Post-processing of a COCO export: tells cocopp of springpot's suite, which it does not know.

``python -m springpot.benchmark.coco_suite FOLDER [-o OUTPUT]`` writes cocopp's HTML report.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import chdir
from importlib import import_module
from pathlib import Path
from typing import Any

from springpot.errors import SpringpotError, StudyError
from springpot.writing import suggested

SUITE = "springpot"
NAMES = "functions.txt"
"""File in an export: number and name of each function, a line for each."""


def required(name: str, purpose: str) -> Any:
    """An optional library.

    Raises
    ------
    StudyError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise StudyError(f"{purpose} needs {name}: pip install {name}") from None


def register(names: dict[int, str], dimensions: Sequence[int]) -> None:
    """Make cocopp know the suite.

    Parameters
    ----------
    names : dict of int to str
        Number of each function and its name.
    dimensions : sequence of int
        Those that occur.

    Raises
    ------
    StudyError
        If cocopp is not installed.
    """
    required("six", "cocopp")
    required("cocopp", "a COCO report")
    # cocopp has no door for a further suite: its own table of suites is added to.
    settings: Any = import_module("cocopp.testbedsettings")

    class SpringpotTestbed(settings.GECCOBBOBTestbed):  # type: ignore[misc]
        """Problems of a springpot study."""

        def __init__(self, targets: Any) -> None:
            super().__init__(targets)
            self.__dict__.update(_settings(names, dimensions))

        def filter(self, dsl: Any) -> Any:
            """All data sets: they are of one suite."""
            return dsl

    settings.SpringpotTestbed = SpringpotTestbed
    settings.suite_to_testbed[SUITE] = "SpringpotTestbed"


def _settings(names: dict[int, str], dimensions: Sequence[int]) -> dict[str, Any]:
    # cocopp's captions count on six dimensions, whatever the data have.
    filler = [d for d in (2, 3, 5, 10, 20, 40, 1) if d not in dimensions]
    shown = sorted([*dimensions, *filler[: max(0, 6 - len(dimensions))]])
    of_interest = (min(dimensions), max(dimensions))
    pages = [f"pprldmany_{d:02d}D_noiselessall.svg" for d in sorted(dimensions)]
    return {
        "name": SUITE,
        "short_names": names,
        "reference_algorithm_filename": None,
        "reference_algorithm_displayname": None,
        "first_function_number": min(names),
        "last_function_number": max(names),
        "functions_with_legend": (min(names), max(names)),
        "dimensions_to_display": tuple(shown),
        "goto_dimension": max(dimensions),
        "rldDimsOfInterest": of_interest,
        "tabDimsOfInterest": of_interest,
        "plots_on_main_html_page": pages,
    }


def postprocess(folder: Path, output: Path) -> Any:
    """Write cocopp's report on an export.

    Parameters
    ----------
    folder : Path
        What ``springpot export STUDY --format coco`` wrote.
    output : Path
        Where the report goes.

    Returns
    -------
    dict
        cocopp's data sets by algorithm.

    Raises
    ------
    StudyError
        If `folder` holds no export or cocopp is not installed.
    """
    if not (folder / NAMES).is_file():
        raise StudyError(
            f"{folder} holds no COCO export: write one with"
            f" {suggested('export', 'STUDY', '--format', 'coco')}"
        )
    lines = (folder / NAMES).read_text(encoding="utf-8").splitlines()
    names = {int(number): name for number, _, name in (line.partition(" ") for line in lines)}
    runs = sorted(path for path in folder.iterdir() if path.is_dir() and any(path.glob("*.info")))
    dimensions = sorted(
        {int(path.stem.rpartition("DIM")[2]) for path in folder.glob("*/data_f*/*.dat")}
    )
    register(names, dimensions)
    cocopp: Any = import_module("cocopp")
    folders = [str(path.resolve()) for path in runs]
    output.mkdir(parents=True, exist_ok=True)
    # cocopp takes an output path with a blank in it for two options.
    with chdir(output.parent):
        return cocopp.main(["-o", output.name, *folders])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run as a program."""
    parser = argparse.ArgumentParser(description="cocopp's report on a COCO export of springpot.")
    parser.add_argument("folder", type=Path, help="what springpot export --format coco wrote")
    parser.add_argument(
        "-o", "--output", type=Path, help="where the report goes, by default FOLDER/report"
    )
    given = parser.parse_args(arguments)
    # Without a screen matplotlib would look for one.
    os.environ.setdefault("MPLBACKEND", "Agg")
    try:
        postprocess(given.folder, given.output or given.folder / "report")
    except SpringpotError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
