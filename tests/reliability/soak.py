"""The long tests of reliability.

``python tests/reliability/soak.py [PART ...] [--scale X] [--seed N] [--out DIR]``.

A part is a module ``soak_NAME.py`` in this folder with a function ``rows(rng, scale)`` that yields
a `Row` for each promise that it put to the test. ``scale`` is the share of the full number of
cases: 1 in ``make soak``, far less in the test that the soak itself works. The tables go to
``results/soak``; the exit code is 1 if a promise was broken.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterable, Sequence
from datetime import date
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
PREFIX = "soak_"
PATHS = [str(FOLDER), str(FOLDER.parent)]
"""Where the parts find one another, and what all tests share."""


class Row(NamedTuple):
    """A promise, and what came of it.

    Parameters
    ----------
    what : str
        What was done.
    cases : int
        How often.
    held : int
        How often the promise held.
    measured : str
        The worst that was seen, with its unit.
    """

    what: str
    cases: int
    held: int
    measured: str = ""


def parts() -> list[str]:
    """Names of all parts, in the order of the alphabet."""
    return sorted(path.stem.removeprefix(PREFIX) for path in FOLDER.glob(f"{PREFIX}*.py"))


def table(part: str, rows: Iterable[Row], made: str) -> list[str]:
    """The rows as Markdown, under the name of their part and how it was made."""
    lines = [
        f"## {part}",
        "",
        f"Made with {made}.",
        "",
        "| what | cases | held | measured |",
        "|---|---:|---:|---|",
    ]
    lines += [f"| {row.what} | {row.cases} | {row.held} | {row.measured} |" for row in rows]
    return [*lines, ""]


def write(found: dict[str, list[Row]], folder: Path, made: str) -> None:
    """A CSV file for each part, and all that are there as one page.

    Parts made at other times, by another scale or seed, stay as they are and say so.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for part, rows in found.items():
        with (folder / f"{part}.csv").open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(
                [[*Row._fields, "made"], *([*row, made] for row in rows)]
            )
    lines = ["# What `make soak` found", ""]
    for part in sorted(path.stem for path in folder.glob("*.csv")):
        with (folder / f"{part}.csv").open(newline="", encoding="utf-8") as stream:
            read = list(csv.reader(stream))[1:]
        entries = [Row(what, int(cases), int(held), said) for what, cases, held, said, _ in read]
        lines += table(part, entries, read[0][-1])
    (folder / "README.md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def run(part: str, seed: int, scale: float) -> list[Row]:
    """The rows of one part, shown as they come; each part has a random stream of its own."""
    stream = np.random.default_rng([seed, *part.encode()])
    found = []
    start = perf_counter()
    for row in import_module(PREFIX + part).rows(stream, scale):
        found.append(row)
        mark = "held  " if row.held == row.cases else "BROKEN"
        print(
            f"{perf_counter() - start:7.0f} s  {mark}  {part}: {row.what}: "
            f"{row.held} of {row.cases}  {row.measured}"
        )
        sys.stdout.flush()
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the parts; 1 if a promise was broken."""
    asked = argparse.ArgumentParser(description="The long tests of reliability.")
    asked.add_argument(
        "parts", nargs="*", metavar="PART", help=f"of {', '.join(parts())}; all by default"
    )
    asked.add_argument("--scale", type=float, default=1.0, help="share of the full number of cases")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--out", type=Path, default=ROOT / "results" / "soak")
    given = asked.parse_args(arguments)
    if unknown := set(given.parts) - set(parts()):
        asked.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(parts())}")
    made, broken = f"scale {given.scale:g}, seed {given.seed}, on {date.today()}", False
    for part in given.parts or parts():
        found = run(part, given.seed, given.scale)
        # Each as it comes: what brings the next one down takes nothing with it.
        write({part: found}, given.out, made)
        broken |= any(row.held < row.cases for row in found)
    return int(broken)


if __name__ == "__main__":
    # Parts import this module by its name, and must find the same `Row`.
    sys.path[:0] = PATHS
    sys.exit(import_module("soak").main())
