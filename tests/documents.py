"""Documents that a user hands over, changed in structure: values, types, keys and lengths."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np

HUGE = 10**400
NOT_FINITE = float("nan")
VALUES = (
    *(True, -4, 0, 1, 20_000, 2.5, -1e-300, 1e300, HUGE, NOT_FINITE, float("inf")),
    *(
        "",
        "x",
        "nan",
        "material",
        "fit.json",
        [],
        {},
        [[]],
        [1.0],
        {"a": 1},
        [NOT_FINITE, "x", None],
        None,
    ),
)
"""What may stand where something else belongs; TOML has no None."""


def paths_of(document: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where each part of a document stands; of a long list its ends."""
    if at:
        yield at
    if isinstance(document, dict):
        for key, value in document.items():
            yield from paths_of(value, (*at, key))
    elif isinstance(document, list) and document:
        for i in {0, len(document) - 1}:
            yield from paths_of(document[i], (*at, i))


def changed(document: Any, at: tuple[Any, ...], what: Any) -> Any:
    """The document with a place replaced: by a value, or by what a word of `WAYS` makes of it."""
    made = deepcopy(document)
    place = made
    for step in at[:-1]:
        place = place[step]
    if not isinstance(what, str) or what not in WAYS:
        place[at[-1]] = what
    elif what == "<gone>":
        del place[at[-1]]
    elif what == "<renamed>" and isinstance(place, dict):
        place[f"{at[-1]}x"] = place.pop(at[-1])
    elif what == "<longer>" and isinstance(place[at[-1]], list):
        place[at[-1]] = place[at[-1]] * 2
    elif what == "<shorter>" and isinstance(place[at[-1]], list):
        place[at[-1]] = place[at[-1]][:1]
    return made


WAYS = ("<gone>", "<renamed>", "<longer>", "<shorter>")


def every_change(document: Any) -> Iterator[tuple[str, Any]]:
    """All changes of one place, each with its name."""
    for at in paths_of(document):
        for what in (*WAYS, *VALUES):
            yield f"{'.'.join(map(str, at))} = {what!r:.40}", changed(document, at, what)


def some_changes(document: Any, rng: np.random.Generator, count: int) -> Iterator[tuple[str, Any]]:
    """Changes of one or two places, drawn at random."""
    for _ in range(count):
        made, names = document, []
        for _ in range(rng.integers(1, 3)):
            places = list(paths_of(made))
            if not places:
                break
            at, what = (
                places[rng.integers(len(places))],
                (*WAYS, *VALUES)[rng.integers(len(WAYS) + len(VALUES))],
            )
            made = changed(made, at, what)
            names.append(f"{'.'.join(map(str, at))} = {what!r:.40}")
        yield "; ".join(names), made


def toml_text(document: dict[str, Any]) -> str:
    """A document of plain values as TOML."""
    return "".join(f"{_word(key)} = {_toml(value)}\n" for key, value in document.items())


def _word(key: str) -> str:
    return json.dumps(key)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_word(key)} = {_toml(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if value is None:
        return '"none"'
    return repr(value)
