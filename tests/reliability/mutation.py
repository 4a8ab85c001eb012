"""Single-line changes of the framework, drawn at random: a test of the tests.

A change is one that a tired hand could make: a comparison turned, an operator exchanged, a number
doubled, a condition negated. Left alone is what no test should hang on: text for people,
annotations, docstrings, assertions that two lists are of one length, guards against a division by
zero (`x or 1.0`, or next to nothing), and settings: numbers with a name of their own, of which
studies say what is best. A setting of none, or of yes or no, is a rule.

Of a room's tests those run that enter the changed function, the shortest of them before all others,
then those that start processes, as what another process enters is not seen. Which enter what is
noted once for each file of tests, and kept as long as that is the same. The others could notice
only what an earlier test left behind, and what has changed since may enter more: what is noticed is
at least as many.
"""

from __future__ import annotations

import ast
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("framework/springpot")
SMALLEST = 1e-100
"""No quantity is that small: it stands where nothing must be divided by zero."""
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", "*_cache", "__pycache__", ".hypothesis", "build", "*.sqlite*"
)
KEPT = ROOT / "build" / "mutants"
"""Where what tests enter stays for the next seed."""
PATIENCE = 3.0
"""A change that lets tests run that many times as long as without it is noticed too."""
START = 60.0
"""Seconds that an interpreter may need beside them on a busy machine."""

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


@dataclass(frozen=True)
class Room:
    """What the tests of a room do without any change."""

    entered: dict[str, Any]
    failed: list[str] = field(default_factory=list)

    def asked(self, mutant: Mutant) -> list[str]:
        """The tests that may notice: those that enter the changed function or start processes.

        Of both the shortest first. Of what runs as a module is loaded any test of the room may.
        """
        file = str(mutant.path)
        function = _function(mutant)

        def place(name: str) -> tuple[bool, float]:
            each = self.entered[name]
            enters = any(
                path == file and function in (None, told) for path, told in each["entered"]
            )
            return not enters, each["seconds"]

        places = {name: place(name) for name in self.entered}
        chosen = [
            name
            for name, each in self.entered.items()
            if function is None or not places[name][0] or each["started"]
        ]
        return sorted(set(chosen) - set(self.failed), key=lambda name: places[name])


def _function(mutant: Mutant) -> str | None:
    """Qualified name of the innermost function with the change.

    None for what runs as the module is loaded.
    """
    line, name, found = mutant.change.line, "", None
    # Level by level: of those around one line the outermost comes first.
    for part in ast.walk(ast.parse((ROOT / mutant.path).read_text(encoding="utf-8"))):
        if not isinstance(part, ast.FunctionDef | ast.ClassDef):
            continue
        if part.body[0].lineno <= line <= (part.end_lineno or 0):
            name += part.name
            found = name if isinstance(part, ast.FunctionDef) else None
            name += ".<locals>." if found else "."
    return found


def state_of(root: Path, file: str) -> str:
    """A digest of a file of tests, and of what it shares with others."""
    digest, own = sha256(), root / file
    beside = {*(root / "tests").glob("*.py"), *own.parent.glob("*.py")}
    for path in sorted(beside):
        if path == own or not path.name.startswith("test_"):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def kept(path: Path, state: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What is kept of this very state; else what is made now, and kept."""
    if path.exists():
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        if found.pop("state") == state:
            return found
    made = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"state": state, **made}), encoding="utf-8")
    return made


class Copy:
    """A copy of the repository in which files are changed and tests run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "copy"
        self._order, self._notes = folder / "order.json", folder / "notes.json"
        self._rooms: dict[str, Room] = {}
        self._changes = 0
        shutil.copytree(ROOT, self.folder, ignore=LEFT_OUT)

    def notices(self, mutant: Mutant) -> str:
        """The test of the room that fails with the change; empty where all pass."""
        name = room_of(mutant.path)
        left = self.room(name).asked(mutant)
        with self._made(mutant):
            while left:
                failed = self._failing(name, left)
                # What passes when it is asked again failed by chance, as on a busy machine.
                if failed not in left or self._failing(name, [failed]):
                    return failed
                left = left[left.index(failed) + 1 :]
        return ""

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

    def _failing(self, name: str, asked: list[str]) -> str:
        """The first of some tests of a room that fails, or how they ended otherwise; or nothing."""
        self._order.write_text(json.dumps(asked), encoding="utf-8")
        files = sorted({each.partition("::")[0] for each in asked})
        usual = sum(self.room(name).entered[each]["seconds"] for each in asked)
        try:
            self._run(files, PATIENCE * usual + START, "-x", SPRINGPOT_ORDER=str(self._order))
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as fault:
            return next(iter(self._noted()["failed"]), str(fault))
        return ""

    def room(self, name: str) -> Room:
        """The room as it is.

        A test that fails on this machine would notice whatever is done: it is left out.
        """
        if name not in self._rooms:
            entered: dict[str, Any] = {}
            failed: list[str] = []
            for file in own_tests(name):
                path = KEPT / Path(file).with_suffix(".json")
                noted = kept(path, state_of(ROOT, file), partial(self._measured, file))
                entered |= noted["tests"]
                failed += noted["failed"]
            self._rooms[name] = Room(entered, failed)
        return self._rooms[name]

    def _measured(self, file: str) -> dict[str, Any]:
        with suppress(subprocess.CalledProcessError):
            self._run([file], None)
        return self._noted()

    def _noted(self) -> dict[str, Any]:
        """What the tests left in writing; nothing where they ended before their time."""
        if not self._notes.exists():
            return {"tests": {}, "failed": []}
        noted: dict[str, Any] = json.loads(self._notes.read_text(encoding="utf-8"))
        return noted

    def _run(self, files: list[str], patience: float | None, *options: str, **told: str) -> None:
        """Run files of tests; what they started ends with them."""
        self._notes.unlink(missing_ok=True)
        own = os.pathsep.join(
            str(self.folder / name) for name in ("framework", "plugins", "tests/reliability")
        )
        environment = {**os.environ, "PYTHONPATH": own, **told}
        running = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "-p",
                "no:cacheprovider",
                "-p",
                "entered",
                *options,
                *files,
            ],
            cwd=self.folder,
            env={**environment, "SPRINGPOT_NOTES": str(self._notes)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            if code := running.wait(patience):
                raise subprocess.CalledProcessError(code, "pytest")
        finally:
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
            running.wait()
