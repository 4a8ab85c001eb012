"""Single-line changes of the framework, drawn at random: a test of the tests.

A change is one that a tired hand could make: a comparison turned, an operator exchanged, a number
doubled, a condition negated. Left alone is what no test should hang on: text for people,
annotations, docstrings, assertions that two lists are of one length, guards against a division by
zero (`x or 1.0`, or next to nothing), tolerances, and settings: numbers with a name of their own,
of which studies say what is best. A setting of none, or of yes or no, is a rule.

The examples in the changed file run first, then the files of tests that name what was changed, then
those with whole answers, which are short and see much.
"""

from __future__ import annotations

import ast
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("framework/springpot")
SMALLEST, TOLERANCE = 1e-100, 1e-4
"""No quantity is as small as the first: it stands where nothing must be divided by zero. What is
compared with less than the second is compared with a tolerance."""
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", "*_cache", "__pycache__", ".hypothesis", "build", "*.sqlite*"
)
MOST, PATIENCE = 300, 6.0
"""Seconds of processor time within which the tests of any room end, and by the clock as many times.

A change that lets them run longer is noticed too.
"""
AMISS = "the tests do not begin, or do not end"

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
    rooms = [room for room in sorted(places) if places[room] and own_tests(room)]
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


def own_tests(room: str) -> list[str]:
    """The files of tests that belong to a room."""
    tests = ROOT / "tests"
    found = (tests / room).rglob("test_*.py") if room else tests.glob("test_*.py")
    return sorted(str(path.relative_to(ROOT)) for path in found)


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
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue
            if isinstance(child, ast.expr):
                if _is_setting(tree, child):
                    continue
                yield child
            if isinstance(child, ast.AST):
                yield from _executed(child)


def _is_setting(parent: ast.AST, node: ast.expr) -> bool:
    """Whether a number other than 0 stands for a name or a field, or is next to nothing."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return _is_setting(parent, node.operand)
    if not isinstance(node, ast.Constant) or type(node.value) not in (int, float) or not node.value:
        return False
    if isinstance(parent, ast.BoolOp) and isinstance(parent.op, ast.Or):
        return node is parent.values[-1]
    if isinstance(parent, ast.Compare) and abs(node.value) < TOLERANCE:
        return True
    if isinstance(parent, ast.Assign):
        first = parent.targets[0]
        named = isinstance(first, ast.Name) and first.id.isupper()
    else:
        named = isinstance(parent, ast.AnnAssign | ast.arguments)
    return named or abs(node.value) < SMALLEST


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


def examples(path: Path) -> list[str]:
    """The test of the examples in a file of the framework, which are the room's own as well."""
    if ">>> " not in (ROOT / path).read_text(encoding="utf-8"):
        return []
    module = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
    return [f"tests/test_docstrings.py::test_examples_run[{module.removesuffix('.__init__')}]"]


def in_order(files: list[str], mutant: Mutant) -> list[str]:
    """Files of tests, those first that are likely to notice a change, and the shorter ones."""
    words = [mutant.path.stem, _function(mutant)]

    def place(file: str) -> tuple[int, bool, int]:
        text = (ROOT / file).read_text(encoding="utf-8")
        named = sum(bool(word and re.search(rf"\b{word}\b", text)) for word in words)
        return -named, "whole" not in file, len(text)

    return sorted(files, key=place)


def _function(mutant: Mutant) -> str:
    """Name of the innermost function with the change, or nothing."""
    line, found = mutant.change.line, ""
    # Level by level: of those around one line the innermost comes last.
    for part in ast.walk(ast.parse((ROOT / mutant.path).read_text(encoding="utf-8"))):
        if isinstance(part, ast.FunctionDef) and part.lineno <= line <= (part.end_lineno or 0):
            found = part.name
    return found


class Copy:
    """A copy of the repository in which files are changed and tests run.

    Attributes
    ----------
    failing : set of str
        Tests that fail on this machine without any change: they would notice whatever is done.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "copy"
        self.failing: set[str] = set()
        self._changes = 0
        shutil.copytree(ROOT, self.folder, ignore=LEFT_OUT)

    def notices(self, mutant: Mutant) -> str:
        """The test of the room that fails with the change; empty where all pass."""
        files = [*examples(mutant.path), *in_order(own_tests(room_of(mutant.path)), mutant)]
        while True:
            # A file that cannot be read stands there by its own name, of no test in it.
            there = [file for file in files if file not in self.failing]
            with self._made(mutant):
                failed = self._run("-x", "--cache-clear", *there)
            if not failed or failed == AMISS:
                return failed
            if not self._run("--last-failed", *there):
                return failed
            self.failing.add(failed)

    @contextmanager
    def _made(self, mutant: Mutant) -> Iterator[None]:
        """The copy with a change."""
        path = self.folder / mutant.path
        before, text = path.stat(), path.read_text(encoding="utf-8")
        path.write_text(mutant.change.made(text), encoding="utf-8")
        # Python keeps what it compiled by the second of the file: no two changes share one.
        self._changes += 1
        os.utime(path, (self._changes, self._changes))
        try:
            yield
        finally:
            path.write_text(text, encoding="utf-8")
            os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))

    def _run(self, *options: str) -> str:
        """The first test that fails, or `AMISS`; nothing where all pass."""
        own = os.pathsep.join(str(self.folder / name) for name in ("framework", "plugins"))
        left_out = [f"--deselect={name}" for name in sorted(self.failing)]
        running = subprocess.Popen(
            [sys.executable, "-m", "pytest", "-q", *left_out, *options],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": own},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=_limit,
        )
        try:
            ended = running.wait(PATIENCE * MOST)
        except subprocess.TimeoutExpired:
            ended = -signal.SIGKILL
        finally:
            # What the tests started ends with them.
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
            running.wait()
        if ended == 0:
            return ""
        known = self.folder / ".pytest_cache" / "v" / "cache" / "lastfailed"
        if ended < 0 or not known.exists():
            return AMISS
        return str(next(iter(json.loads(known.read_text(encoding="utf-8")))))


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (MOST, MOST))
