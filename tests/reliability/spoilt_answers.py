"""Answers as JSON, each key of which is removed or spoilt: they are loaded or refused in a line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import springpot
from springpot.errors import SpringpotError
from springpot.identification.result import Identification

GONE = object()
DEEP = "so many brackets"
SPOILT: dict[str, Any] = {
    "gone": GONE,
    "null": None,
    "text": "x",
    "list": [],
    "dict": {},
    "below zero": -1,
    "zero": 0,
    "true": True,
    "nan": float("nan"),
    "endless": 10**400,
    "huge": 1e308,
    "deep": DEEP,
    "too long": [1.0] * 7,
    "lists": [[1]],
    "dicts": [{}],
}
"""What is put in the place of a value, by name."""


def places(document: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where values stand; of a list its first and last stand for all."""
    items: dict[Any, Any] = {}
    if isinstance(document, dict):
        items = document
    if isinstance(document, list) and document:
        items = {0: document[0], len(document) - 1: document[-1]}
    for key, value in items.items():
        yield (*path, key)
        yield from places(value, (*path, key))


def changed(document: Any, place: tuple[Any, ...], by: Any) -> Any:
    """A copy of a document with something else, or nothing, in one place."""
    document = deepcopy(document)
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    if by is GONE:
        del inner[place[-1]]
    else:
        inner[place[-1]] = by
    return document


def spoilt(document: Any, place: tuple[Any, ...], by: Any) -> str:
    """The text of a document with something else in one place."""
    return json.dumps(changed(document, place, by)).replace(f'"{DEEP}"', "[" * 100_000)


def fault(path: Path) -> str:
    """What goes wrong when an answer is loaded and used; empty where it is refused in one line."""
    try:
        answer = springpot.load(path)
        str(answer), json.dumps(answer.to_dict(), allow_nan=False), answer._repr_html_()
        if isinstance(answer, Identification):
            answer.predict(frequency=[1.0, 2.0], temperature=_needed(answer))
    except SpringpotError as error:
        if "\n" in str(error):
            return f"several lines: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _needed(answer: Identification) -> float | None:
    return 20.0 if "temperature" in answer.model.needs else None
