"""A frame, a code, a session that was changed by hand is refused in one line, or can be used."""

from __future__ import annotations

import contextlib
import io
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from spoilt_answers import DEEP, SPOILT, changed, places, spoilt

from springpot.cli.group import exit_code, run
from springpot.errors import SpringpotError
from springpot.testreport.code import read_code

ONE_IN = 7
"""The suite spoils each so many a place and way, the soak all of them."""

DAMPER = {
    "model": "maxwell",
    "parameters": {"k": 20.0, "c": 5.0},
    "unit": "kN/m",
    "storey": 1,
    "count": 4,
    "slope": 30,
}
FRAME = {
    "structure": {"storeys": 2, "mass": 1e5, "stiffness": [8e7, 7e7], "damping": 0.02},
    "damper": [DAMPER],
}
CODE = tomllib.loads(Path(__file__).parents[2].joinpath("docs/codes/isolator.toml").read_text())
SESSION = {
    "schema": "springpot.session/1",
    "data": {"source": "damper.csv", "joined": False, "text": "frequency [Hz],storage,loss\n"},
    "branches": [
        {"name": "A", "at": 0, "states": [{"model": "maxwell", "accepted": [], "excluded": [1]}]}
    ],
    "branch": 0,
    "view": {"view": "phase", "plane": "loss", "sigmas": 1},
}


def written(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{json.dumps(key)} = {written(v)}' for key, v in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(written, value))}]"
    if value == DEEP:
        return "[" * 2000 + "]" * 2000
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def as_toml(document: Any, place: tuple[Any, ...], by: Any) -> str:
    """The text of a TOML document with something else in one place."""
    # TOML has no null.
    whole = changed(document, place, "" if by is None else by)
    return "\n".join(f"{key} = {written(value)}" for key, value in whole.items())


def simulated(text: str, folder: Path) -> None:
    """The command, as a user would give it."""
    (folder / "frame.toml").write_text(text, encoding="utf-8")
    said = io.StringIO()
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(said),
    ):
        code = exit_code(lambda: run(["simulate", "frame.toml", "--frequency", "1"]))
    assert code in (0, 2), said.getvalue()
    assert said.getvalue().count("\n") == code // 2, said.getvalue()


def read(text: str, folder: Path) -> None:
    """A code is read, or refused in one line."""
    path = folder / "code.toml"
    path.write_text(text, encoding="utf-8")
    refused(lambda: read_code(path))


def opened(text: str, folder: Path) -> None:
    """A session is opened, or refused in one line."""
    sessions = pytest.importorskip("springpot.web.sessions")
    refused(lambda: sessions.session_of(text.encode()))


def refused(action: Callable[[], object]) -> None:
    """Whatever is raised is one line for a user."""
    said = ""
    try:
        action()
    except SpringpotError as error:
        said = str(error)
    assert "\n" not in said


KINDS: dict[str, tuple[Any, Callable[..., str], Callable[[str, Path], None]]] = {
    "frame": (FRAME, as_toml, simulated),
    "code": (CODE, as_toml, read),
    "session": (SESSION, spoilt, opened),
}


@pytest.mark.soak_cases("code-7")
@pytest.mark.parametrize("one_in", [ONE_IN, pytest.param(1, marks=pytest.mark.soak)])
@pytest.mark.parametrize("kind", KINDS)
def test_a_spoilt_document_is_refused_in_one_line_or_can_be_used(kind, one_in, tmp_path):
    document, write, use = KINDS[kind]
    ways = [(place, name) for place in places(document) for name in SPOILT]
    assert len(ways) > 200
    for place, name in ways[::one_in]:
        try:
            use(write(document, place, SPOILT[name]), tmp_path)
        except Exception as error:
            raise AssertionError(f"{place} {name}: {type(error).__name__}: {error}") from error


@pytest.mark.parametrize("parameter", ["k", "c"])
def test_a_damper_without_stiffness_is_refused(parameter, tmp_path, capsys):
    """A part in series with one that gives no force is no number."""
    none = {**DAMPER, "parameters": {**DAMPER["parameters"], parameter: 0.0}}
    text = as_toml({**FRAME, "damper": [none]}, ("damper", 0, "count"), 4)
    (tmp_path / "frame.toml").write_text(text, encoding="utf-8")
    with contextlib.chdir(tmp_path):
        assert exit_code(lambda: run(["simulate", "frame.toml", "--frequency", "1"])) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f"{parameter} = 0" in told
    assert "has no stiffness" in told
