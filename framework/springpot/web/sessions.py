"""Session files: the data and every ladder of a page, to be opened again.

Read as data that a stranger wrote.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from springpot.errors import DataError
from springpot.inputs import json_of

from .datatext import safe_name
from .state import State, digest_of

SCHEMA = "springpot.session/1"
MOST_BRANCHES, MOST_STATES = 12, 200
"""Branches of a session, and states that undo can go back through."""
HEAD = 400
"""Bytes by which a file is known: the schema stands first."""
LONGEST_KEY, LONGEST_VALUE = 40, 80
"""Signs of the name and of the value of a setting that are kept: a strange file may hold any."""
MOST_VIEW = 40
"""Settings of the page: which view, which planes."""


def is_session(content: bytes) -> bool:
    """Whether a file looks like one, by its first bytes."""
    # Not by its name, which a browser or a mail program may have changed.
    return content[:HEAD].lstrip()[:1] == b"{" and SCHEMA.encode() in content[:HEAD]


def session_of(content: bytes) -> dict[str, Any]:
    """A session with nothing in it but what the page expects.

    Raises
    ------
    DataError
        If it is none, or holds what a page would not have written.
    """
    try:
        given = json_of(content.decode("utf-8-sig"), finite=True)
        if given["schema"] != SCHEMA:
            raise ValueError(f"its schema is {str(given['schema'])[:40]!r}, not {SCHEMA}")
        data = given["data"]
        text = data["text"]
        if not isinstance(text, str):
            raise ValueError("its data are no text")
        # What the file says of it is not believed: states go by the data that are really there.
        digest = digest_of(text)
        branches = [_branch(branch, digest) for branch in list(given["branches"])[:MOST_BRANCHES]]
        if not branches:
            raise ValueError("it has no branch")
        # Which branch lay open may be any number in a strange file: it is kept within those that
        # there are.
        at = int(given.get("branch", 0))
        return {
            "schema": SCHEMA,
            "data": {
                "source": str(data.get("source", "data.csv"))[:200],
                "joined": bool(data.get("joined")),
                "text": text,
            },
            "branches": branches,
            "branch": min(max(at, 0), len(branches) - 1),
            "view": _view(given.get("view", {})),
        }
    except (
        KeyError,
        TypeError,
        ValueError,
        AttributeError,
        RecursionError,
        OverflowError,
        DataError,
    ) as error:
        words = " ".join(str(error).split())[:120]
        raise DataError(
            f"this is no session of the workbench ({words}); open one that it saved"
        ) from None


def _branch(branch: Mapping[str, Any], digest: str) -> dict[str, Any]:
    states = [
        replace(State.of({**state, "data": digest}), data=digest)
        for state in branch["states"][:MOST_STATES]
    ]
    if not states:
        raise ValueError("a branch has no state")
    at = min(max(int(branch.get("at", 0)), 0), len(states) - 1)
    return {
        "name": safe_name(str(branch.get("name", "")))[:40],
        "states": [s.to_dict() for s in states],
        "at": at,
    }


def _view(view: Mapping[str, Any]) -> dict[str, Any]:
    """Words, numbers and switches only."""
    # The page sets what it knows and passes over the rest; neither may be of any size.
    few = list(view.items())[:MOST_VIEW]
    return {
        str(key)[:LONGEST_KEY]: value
        for key, value in few
        if isinstance(value, str | int | float) and len(str(value)) < LONGEST_VALUE
    }
