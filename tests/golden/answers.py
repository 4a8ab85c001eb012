"""Asks the command line, keeps answers, and tells what of them moved."""

from __future__ import annotations

import contextlib
import io
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cases import CASES, Case

from springpot.cli.group import run

FOLDER = Path(__file__).parent
UNTOLD = ("seconds", "evaluations", "notes", "file", "version")
"""Keys of an answer that may differ between machines, or that tell of the run, not of the data."""
DIGITS = 5


def asked(case: Case, folder: Path) -> dict[str, Any]:
    """The JSON that the command line prints for a case, without times of the run."""
    case.write(folder)
    printed = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(printed):
        run([*case.arguments, "--json"])
    return rounded(json.loads(printed.getvalue()))


def rounded(part: Any) -> Any:
    """A document with its floats to five digits and without what no two machines share."""
    if isinstance(part, dict):
        return {key: rounded(value) for key, value in part.items() if key not in UNTOLD}
    if isinstance(part, list):
        return [rounded(value) for value in part]
    if isinstance(part, float):
        return float(f"{part:.{DIGITS}g}")
    return part


def kept(kind: str) -> dict[str, Any]:
    """The committed answers of one kind by the names of their cases."""
    lines = (FOLDER / f"{kind}.jsonl").read_text().splitlines()
    return {row["case"]: row["answer"] for row in map(json.loads, lines)}


def keep(kind: str, answers: dict[str, Any]) -> None:
    """Write answers of one kind, a line each."""
    rows = [json.dumps({"case": name, "answer": answer}) for name, answer in answers.items()]
    (FOLDER / f"{kind}.jsonl").write_text("\n".join(rows) + "\n")


def cases_of(kind: str) -> list[Case]:
    """All cases of one kind."""
    return list(CASES[kind]())


def moved(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Each place where two documents differ.

    Numbers by more than rounding, in percent where they are near.
    """
    if isinstance(before, dict) and isinstance(after, dict):
        for key in [*before, *(key for key in after if key not in before)]:
            inner = f"{place}.{key}" if place else key
            yield from moved(before.get(key), after.get(key), inner)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from moved(old, new, f"{place}[{_named(old, index)}]")
    elif not same(before, after, 1e-3):
        yield f"{place}: {before!r} -> {after!r}"


def _named(part: Any, index: int) -> str:
    return str(part.get("effect", index)) if isinstance(part, dict) else str(index)


def same(before: Any, after: Any, within: float) -> bool:
    """Whether two leaves are equal, numbers within a relative difference."""
    numbers = (int, float)
    if isinstance(before, numbers) and isinstance(after, numbers):
        return math.isclose(before, after, rel_tol=within, abs_tol=1e-9)
    return bool(before == after)


def gist(answer: dict[str, Any]) -> dict[str, Any]:
    """What must be the same on every machine.

    The verdict, the class that is named, and the sizes of the error.
    """
    said: dict[str, Any] = {"verdict": answer.get("verdict"), "class": named_class(answer)}
    error = answer.get("error", answer)
    for key in ("relative_rms", "noise_floor", "material_floor"):
        said[key] = error.get(key)
    return said


def named_class(answer: dict[str, Any]) -> list[str]:
    """The class of the best candidate where something is said to be missing."""
    candidates = answer.get("candidates") or []
    if answer.get("verdict") != "effect-missing" or not candidates:
        return []
    return sorted(candidates[0]["class"])
