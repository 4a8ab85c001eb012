"""A programming error is no answer: each place that may catch one is listed with its reason."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeAlias

import pytest

Names: TypeAlias = dict[str, ast.expr]
ROOT = Path(__file__).parent.parent
_BROAD = """
Exception BaseException ValueError TypeError KeyError IndexError AttributeError LookupError
ArithmeticError RuntimeError NameError AssertionError
"""
BROAD = frozenset(_BROAD.split())
"""What a mistake in a program raises too."""
_PARSERS = """
float int complex str len list map tuple dict set range zip abs min max isinstance iter next
enumerate sorted strip split replace encode decode get append lower upper partition join items sub
json.loads loads urlparse np.asarray np.broadcast_to np.fromiter np.array np.loadtxt np.atleast_1d
np.isfinite nnls Signals datetime toordinal stat exists Path read_bytes read_text iterdir is_file
islice _number ast.parse catch_warnings simplefilter
"""
PARSERS = frozenset(_PARSERS.split())
"""Calls of the language and its libraries that turn text, lists or paths into numbers, and say by
such an error that they are none."""


class Handler(NamedTuple):
    """A place that catches what a mistake raises.

    Parameters
    ----------
    where : str
        The function around it.
    attempt : list of ast.stmt
        What is tried.
    answer : list of ast.stmt
        What is done then; nothing where it is suppressed.
    """

    where: str
    attempt: list[ast.stmt]
    answer: list[ast.stmt]


def broad_handlers(tree: ast.AST, where: str = "", names: Names | None = None) -> Iterator[Handler]:
    """Handlers and suppressions that catch what a mistake raises."""
    if names is None:
        names = named_tuples(tree)
    for node in ast.iter_child_nodes(tree):
        name = where
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            name = node.name
        if isinstance(node, ast.Try):
            for handler in node.handlers:
                if handler.type is None or caught([handler.type], names) & BROAD:
                    yield Handler(name, node.body, handler.body)
        if isinstance(node, ast.With | ast.AsyncWith):
            for item in node.items:
                call = item.context_expr
                suppressed = isinstance(call, ast.Call) and "suppress" in ast.unparse(call.func)
                if suppressed and caught(call.args, names) & BROAD:
                    yield Handler(name, node.body, [])
        yield from broad_handlers(node, name, names)


def named_tuples(tree: ast.AST) -> Names:
    """Tuples that a file gives a name, as some list what they catch."""
    return {
        ast.unparse(target): node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple)
        for target in node.targets
    }


def caught(parts: Iterable[ast.expr], names: Names) -> set[str]:
    """Names of the exceptions, with those of tuples by their name."""
    found: set[str] = set()
    for part in parts:
        if isinstance(part, ast.Starred):
            part = part.value
        part = names.get(ast.unparse(part), part)
        if isinstance(part, ast.Tuple):
            found |= caught(part.elts, names)
        else:
            found.add(ast.unparse(part))
    return found


def passes_on(answer: list[ast.stmt]) -> bool:
    """Whether what was caught goes on as it was, after something was put in order."""
    return bool(answer) and isinstance(answer[-1], ast.Raise) and answer[-1].exc is None


def only_parses(attempt: list[ast.stmt]) -> bool:
    """Whether nothing of the program itself runs in there."""
    calls = [node for part in attempt for node in ast.walk(part) if isinstance(node, ast.Call)]
    # What is done in a block of a context manager may be anything.
    if any(isinstance(node, ast.Yield) for part in attempt for node in ast.walk(part)):
        return False
    names = {ast.unparse(call.func) for call in calls}
    return all(name in PARSERS or name.rpartition(".")[2] in PARSERS for name in names)


def unlisted(text: str, path: str) -> list[str]:
    """Places of a file that take a programming error for an answer."""
    return [
        f"{path}:{handler.where}"
        for handler in broad_handlers(ast.parse(text))
        if not (passes_on(handler.answer) or only_parses(handler.attempt))
    ]


FOREIGN = "a foreign library reads a stranger's bytes, and raises whatever it likes"
STRANGER = "a file or request that a stranger wrote, taken apart key by key; told in one line"
OPTIMISER = "code of an optimiser runs here: whatever it raises is its answer, kept with its name"
PLUGIN = "code of a plugin runs here: whatever it raises is told as the plugin's fault"
CHECK = "a contract test, whose finding is what was raised"
TOP = "the top of a process: what comes this far is told as a fault, with exit code 3 or a status"
CARRIED = "kept here and raised again behind a library that would swallow it"
BOUNDARIES = {
    "framework/springpot/benchmark/archive.py:_one_line": STRANGER,
    "framework/springpot/benchmark/runner.py:close": FOREIGN,
    "framework/springpot/benchmark/fork_server.py:serve": (
        "streams that an optimiser closed or replaced; what it printed is not worth a trial"
    ),
    "framework/springpot/benchmark/trial.py:warm_up": (
        "an optimiser is tried; what it raises its trial tells"
    ),
    "framework/springpot/registry.py:_guarded": PLUGIN,
    "framework/springpot/processes.py:_ask": "a system without this call",
    "framework/springpot/processes.py:kept_surroundings": (
        "what a plugin changed and cannot be put back is told as changed"
    ),
    "plugins/springpot_plugins/optimisers/libraries.py:descend": FOREIGN,
    "plugins/springpot_plugins/optimisers/searches.py:search": FOREIGN,
    "framework/springpot/benchmark/runner.py:_dask": FOREIGN,
    "framework/springpot/benchmark/runner.py:_submit": FOREIGN,
    "framework/springpot/benchmark/fork_server.py:_be_born": TOP,
    "framework/springpot/benchmark/fork_server.py:main": TOP,
    "framework/springpot/benchmark/summary.py:load_script": PLUGIN,
    "framework/springpot/benchmark/supervisor.py:_hear": OPTIMISER,
    "framework/springpot/benchmark/trial.py:_built": OPTIMISER,
    "framework/springpot/benchmark/trial.py:_tried": OPTIMISER,
    "framework/springpot/benchmark/fork_server.py:_results": TOP,
    "framework/springpot/benchmark/fork_server.py:of": (
        "what pickle says of a study that cannot be sent"
    ),
    "framework/springpot/cli/group.py:_exit_code": TOP,
    "framework/springpot/identification/runs.py:_supervised": OPTIMISER,
    "framework/springpot/loading.py:_read": STRANGER,
    "framework/springpot/loading.py:load": STRANGER,
    "framework/springpot/measurement/measurement.py:_array": (
        "what numpy says of values that are no numbers"
    ),
    "framework/springpot/measurement/opening.py:read_head": "a path with a zero byte is no file",
    "framework/springpot/measurement/reader.py:_confidence": PLUGIN,
    "framework/springpot/measurement/reader.py:guarded": PLUGIN,
    "framework/springpot/testing/networks.py:_run": CHECK,
    "framework/springpot/benchmark/gate/baseline.py:read_baseline": STRANGER,
    "framework/springpot/testing/networks.py:_around": CHECK,
    "framework/springpot/testing/effects.py:_columns": CHECK,
    "framework/springpot/testing/others.py:_complaints_about": CHECK,
    "framework/springpot/web/desk.py:perform": STRANGER,
    "framework/springpot/web/server.py:_ask": STRANGER,
    "framework/springpot/web/sessions.py:session_of": STRANGER,
    "framework/springpot/web/sessions.py:of": STRANGER,
    "framework/springpot/web/sessions.py:specimen_of": STRANGER,
    "framework/springpot/web/tasks.py:perform": TOP,
    "plugins/springpot_plugins/datasets/download.py:fetched": FOREIGN,
    "plugins/springpot_plugins/datasets/folders.py:_dataset": STRANGER,
    "plugins/springpot_plugins/datasets/shipped.py:_columns": FOREIGN,
    "plugins/springpot_plugins/optimisers/searches.py:guarded": CARRIED,
    "plugins/springpot_plugins/optimisers/libraries.py:values": CARRIED,
    "plugins/springpot_plugins/optimisers/searches.py:_objective": CARRIED,
    "plugins/springpot_plugins/optimisers/unified.py:_attempt": OPTIMISER,
    "plugins/springpot_plugins/readers/excel.py:check_archive": FOREIGN,
    "plugins/springpot_plugins/readers/excel.py:_sheets": FOREIGN,
    "plugins/springpot_plugins/readers/excel.py:_old_sheets": FOREIGN,
    "plugins/springpot_plugins/readers/signals_binary.py:_of_tdms": FOREIGN,
    "plugins/springpot_plugins/readers/ta_instruments.py:_of_json": STRANGER,
    "framework/springpot/cli/group.py:_table": PLUGIN,
    "framework/springpot/files.py:_is_stdout": "a stream that has no number, as a test's has none",
    "framework/springpot/identification/searching.py:action": OPTIMISER,
    "framework/springpot/files.py:bytes_of": STRANGER,
    "framework/springpot/files.py:toml_in": STRANGER,
    "framework/springpot/limits.py:address_space": "a system without these counters",
    "framework/springpot/measurement/opening.py:tests": PLUGIN,
    "plugins/springpot_plugins/datasets/folders.py:read_manifest": STRANGER,
}
"""Every place that may catch a programming error, and why; a new one needs a reason as good."""


def test_nothing_but_listed_boundaries_takes_a_programming_error_for_an_answer():
    found: set[str] = set()
    for root in ("framework/springpot", "plugins/springpot_plugins"):
        for path in sorted((ROOT / root).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if "except" in text or "suppress" in text:
                found |= set(unlisted(text, str(path.relative_to(ROOT))))
    assert found - set(BOUNDARIES) == set(), (
        "narrow it to springpot's own errors, or to the call that parses"
    )
    assert set(BOUNDARIES) - found == set(), "no longer needed: take it off the list"


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("def f():\n try:\n  scan()\n except (SpringpotError, ValueError):\n  pass", 1),
        ("def f():\n try:\n  scan()\n except:\n  pass", 1),
        ("def f():\n try:\n  scan()\n except SpringpotError:\n  pass", 0),
        ("def f():\n try:\n  x = float(cell)\n except ValueError:\n  pass", 0),
        ("def f():\n with suppress(Exception):\n  scan()", 1),
        ("def f():\n with suppress(OSError):\n  scan()", 0),
        ("FEW = (OSError, *(KeyError,))\ndef f():\n try:\n  scan()\n except FEW:\n  pass", 1),
        ("def f():\n try:\n  write()\n except BaseException:\n  tidy()\n  raise", 0),
    ],
)
def test_the_check_itself_sees_what_is_broad(text: str, count: int):
    assert len(unlisted(text, "f.py")) == count
