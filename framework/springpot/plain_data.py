"""Answers as plain data, and back.

Finite numbers only, no library's own types, and what a file cannot hold is told in one line.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cached_property
from math import nan
from typing import Any, Self, TypeVar

from springpot.errors import DataError
from springpot.numerics import LARGEST as LARGEST_NUMBER

T = TypeVar("T")


def jsonable(value: Any) -> Any:
    """`value` in JSON's own types; what is no number that can be used becomes null.

    Arrays become lists and complex numbers a pair ``[real, imaginary]``.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        # Neither nan nor infinity is a word of JSON, and half of all readers refuse them.
        if not abs(value) <= LARGEST_NUMBER:
            return None
        return float(value)
    if isinstance(value, complex):
        return [jsonable(value.real), jsonable(value.imag)]
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [jsonable(item) for item in value]
    # NumPy's arrays and scalars, without importing NumPy for that.
    if hasattr(value, "tolist"):
        return jsonable(value.tolist())
    if hasattr(value, "to_dict"):
        return jsonable(value.to_dict())
    return str(value)


def json_number(value: float | None, missing: float = nan) -> float:
    """A number as JSON tells it, which has null for one that is not finite."""
    if value is None:
        return missing
    return float(value)


def some(rows: Iterable[T]) -> tuple[T, ...]:
    """What was read of a list that is never empty.

    Raises
    ------
    ValueError
        If there is nothing.
    """
    found = tuple(rows)
    if not found:
        raise ValueError("a list is empty that never is")
    return found


def read(kind: type[T], row: Mapping[str, Any], **known: Any) -> T:
    """A result of plain data, each attribute by what its class declares of it.

    Parameters
    ----------
    kind : type
        A dataclass.
    row : mapping
        What its `to_dict` gave, or more. An attribute with a default may be missing.
    **known : object
        Attributes that stand there in another way, or under another name.
    """
    names = vars(sys.modules[kind.__module__])
    for each in fields(kind):  # type: ignore[arg-type]
        never = each.default is MISSING and each.default_factory is MISSING
        if each.name not in known and (never or each.name in row):
            known[each.name] = _read(str(each.type), row[each.name], names)
    return kind(**known)


def _read(declared: str, value: Any, names: Mapping[str, Any]) -> Any:
    """A value as it is declared in a module of these names."""
    if value is None:
        # JSON has no word for a number that is none.
        if declared == "float":
            return nan
        if declared != "Any" and not declared.endswith(" | None"):
            raise ValueError(f"null stands where a {declared} belongs")
        return None
    inner = declared.removesuffix(" | None")
    if inner.startswith("tuple["):
        inner = inner.removeprefix("tuple[").removesuffix(", ...]")
        return tuple(_read(inner, each, names) for each in value)
    for mapping in ("dict[str, ", "Mapping[str, "):
        if inner.startswith(mapping):
            inner = inner.removeprefix(mapping).removesuffix("]")
            return {key: _read(inner, each, names) for key, each in value.items()}
    result: Any = names.get(inner)
    if hasattr(result, "from_dict"):
        return result.from_dict(value)
    return value


class Plain:
    """A dataclass that stands in JSON as it is."""

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas."""
        return dict(jsonable(vars(self)))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Self:
        """What `to_dict` gave."""
        return read(cls, row)


def _texts(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(each, str) for each in value)


def _numbers(values: Iterable[Any]) -> bool:
    return all(isinstance(each, float | int) for each in values)


_DECLARED: dict[str, Callable[[Any], bool]] = {
    "str": lambda value: isinstance(value, str),
    "str | None": lambda value: value is None or isinstance(value, str),
    "bool": lambda value: isinstance(value, bool),
    "int": lambda value: isinstance(value, int) and not isinstance(value, bool),
    "float": lambda value: isinstance(value, float | int),
    "float | None": lambda value: value is None or isinstance(value, float | int),
    "tuple[str, ...]": _texts,
    "Verdict": lambda value: isinstance(value, str),
    "EffectVerdict": lambda value: isinstance(value, str),
    "tuple[tuple[str, ...], ...]": lambda value: all(each and _texts(each) for each in value),
    "dict[str, float]": lambda value: isinstance(value, dict) and _numbers(value.values()),
    "Mapping[str, str]": lambda value: isinstance(value, dict) and _texts(tuple(value.values())),
}
"""What a class declares of a plain attribute, and whether a value is such a one."""


def as_declared(result: T) -> T:
    """A result that was read, after a check that its plain attributes are what its class declares.

    Those of the results within as well; what is no result was made by its own class, and checked.

    Raises
    ------
    ValueError
        If one is not: a file that was changed by hand would fail wherever it is used.
    """
    kind, kept = type(result), vars(result)
    declared = {each.name: each.type for each in fields(result)}  # type: ignore[arg-type]
    # What is else worked out once stands in a file as well.
    for name in kept:
        if isinstance(member := getattr(kind, name, None), cached_property):
            declared[name] = member.func.__annotations__["return"]
    for name, value in kept.items():
        holds = _DECLARED.get(str(declared.get(name)))
        if holds is not None and not holds(value):
            raise ValueError(f"{name} of a {kind.__name__} cannot be {value!r:.40}")
        for part in _parts(value):
            as_declared(part)
    return result


def _parts(value: Any) -> Iterator[Any]:
    """The results that an attribute holds."""
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if not isinstance(value, tuple | list):
        value = (value,)
    yield from (each for each in value if is_dataclass(each) and hasattr(each, "from_dict"))


def alive(part: object, kind: type[T], what: str) -> T:
    """What is behind an answer, where it was asked for in this program.

    Raises
    ------
    DataError
        If there is no such thing behind it: a file holds what was said, and not the fits.
    """
    if not isinstance(part, kind):
        raise DataError(f"{what} of a file, or of tests in time, has no {kind.__name__} behind it")
    return part
