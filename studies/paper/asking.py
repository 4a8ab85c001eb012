"""What a study asks, and tables below it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # a generator that owes springpot nothing states its question too
    from springpot.benchmark import Study, Table

FIRST = "Question: "
"""With what the paragraph of a script's head begins that states it."""


def question(head: str | None) -> str:
    """What the head of a script asks, on one line.

    Raises
    ------
    ValueError
        If the head asks nothing.
    """
    for paragraph in (head or "").split("\n\n"):
        if paragraph.strip().startswith(FIRST):
            return " ".join(paragraph.split())
    raise ValueError("a study states its question in its head")


def asking(head: str | None, table: Table) -> Table:
    """The same table, which says first what the head of its script asks."""
    return replace(table, asks=question(head))


def asked(study: Study, table: Table) -> Table:
    """The same table, which says first what its study asks."""
    heads = ("Question", "Measure", "What would answer it")
    parts = (f"{head}: {said}" for head, said in zip(heads, study.asks, strict=True))
    return replace(table, asks=" ".join(parts))
