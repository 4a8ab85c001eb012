"""Single-line changes of the framework, drawn at random: a test of the tests.

A change is one that a tired hand could make: a comparison turned, an operator exchanged, a number
doubled, a condition negated. Text for people, type annotations and docstrings are left alone, for
no test should hang on them.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("framework/springpot")
COPIED = ("framework", "plugins", "studies", "tests", "results", "docs")
PATIENCE = 300.0
"""Seconds for the tests of a room; a change that lets them run on without end is noticed too."""

TURNED: dict[type, type] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


@dataclass(frozen=True)
class Change:
    """A part of one line, and what stands there instead.

    Places count bytes from the line's beginning.
    """

    line: int
    start: int
    stop: int
    before: str
    after: str

    def made(self, text: str) -> str:
        """The text with the change."""
        lines = text.splitlines(keepends=True)
        raw = lines[self.line - 1].encode()
        lines[self.line - 1] = (raw[: self.start] + self.after.encode() + raw[self.stop :]).decode()
        return "".join(lines)


@dataclass(frozen=True)
class Mutant:
    """A change and the file that it is made to, from the root of the repository."""

    path: Path
    change: Change


def drawn(rng: np.random.Generator, count: int) -> Iterator[Mutant]:
    """Changes spread over the rooms: a room at random, then a place in it at random."""
    places = _places()
    rooms = [room for room in sorted(places) if places[room] and tests_of(room)]
    for index in range(count):
        choices = places[rooms[index % len(rooms)]]
        path, change = choices[rng.integers(len(choices))]
        yield Mutant(path, change)


@cache
def _places() -> dict[str, list[tuple[Path, Change]]]:
    """All changes by room."""
    places: dict[str, list[tuple[Path, Change]]] = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        relative = path.relative_to(ROOT)
        found = changes_of(path.read_text(encoding="utf-8"))
        places.setdefault(room_of(relative), []).extend((relative, change) for change in found)
    return places


def room_of(path: Path) -> str:
    """The folder of `tests` that speaks for a file; empty for files beside the rooms."""
    parts = path.relative_to(PACKAGE).parts
    if len(parts) == 1:
        return ""
    return parts[0]


def tests_of(room: str) -> list[str]:
    """What of `tests` belongs to a room."""
    if not room:
        return sorted(str(path.relative_to(ROOT)) for path in (ROOT / "tests").glob("test_*.py"))
    folder = ROOT / "tests" / room
    return [str(folder.relative_to(ROOT))] if folder.is_dir() else []


def changes_of(text: str) -> list[Change]:
    """The changes that a file has room for."""
    found = []
    lines = text.splitlines()
    for node in _executed(ast.parse(text)):
        # Only what stands on one line: a reader sees it as one.
        if node.end_lineno != node.lineno or node.end_col_offset is None:
            continue
        after = _changed(node)
        if after is not None:
            start, stop = node.col_offset, node.end_col_offset
            before = lines[node.lineno - 1].encode()[start:stop].decode()
            found.append(Change(node.lineno, start, stop, before, after))
    return found


def _executed(tree: ast.AST) -> Iterator[ast.expr]:
    """Expressions other than annotations and texts."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.JoinedStr | ast.Raise | ast.ImportFrom | ast.Import):
                continue
            if isinstance(child, ast.expr):
                yield child
            if isinstance(child, ast.AST):
                yield from _executed(child)


def _changed(node: ast.expr) -> str | None:
    """The expression with one thing turned; None where there is nothing to turn."""
    match node:
        case ast.Compare(left, [operator], [right]) if type(operator) in TURNED:
            return ast.unparse(ast.Compare(left, [TURNED[type(operator)]()], [right]))
        case ast.BinOp(left, operator, right) if type(operator) in TURNED and not _textual(node):
            return f"({ast.unparse(ast.BinOp(left, TURNED[type(operator)](), right))})"
        case ast.BoolOp(operator, values):
            return f"({ast.unparse(ast.BoolOp(TURNED[type(operator)](), values))})"
        case ast.UnaryOp(ast.Not(), operand):
            return f"bool({ast.unparse(operand)})"
        case ast.Constant(bool() as value):
            return str(not value)
        case ast.Constant(int() | float() as value):
            return repr(2 * value + (value == 0))
    return None


def _textual(node: ast.BinOp) -> bool:
    """Whether texts are joined, or types."""
    parts = (node.left, node.right)
    return any(isinstance(part, ast.JoinedStr | ast.List | ast.Tuple) for part in parts) or any(
        isinstance(part, ast.Constant) and isinstance(part.value, str | None) for part in parts
    )


class Copy:
    """A copy of the repository in which files are changed and tests run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in COPIED:
            shutil.copytree(
                ROOT / name,
                folder / name,
                ignore=shutil.ignore_patterns("__pycache__", "*.sqlite*"),
            )
        for path in ROOT.glob("*.*"):
            if path.is_file():
                shutil.copy(path, folder)

    def notices(self, mutant: Mutant) -> bool:
        """Whether the tests of the room fail with the change."""
        path = self.folder / mutant.path
        kept = path.read_text(encoding="utf-8")
        path.write_text(mutant.change.made(kept), encoding="utf-8")
        try:
            return not self.passes(room_of(mutant.path))
        finally:
            path.write_text(kept, encoding="utf-8")

    def passes(self, room: str) -> bool:
        """Whether the tests of a room pass."""
        own = os.pathsep.join(str(self.folder / name) for name in ("framework", "plugins"))
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            *tests_of(room),
        ]
        environment = {**os.environ, "PYTHONPATH": own, "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            done = subprocess.run(
                command,
                cwd=self.folder,
                env=environment,
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0
