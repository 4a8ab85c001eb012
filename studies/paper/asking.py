"""A table below the question that its study asks."""

from __future__ import annotations

from dataclasses import replace

from springpot.benchmark import Study, Table

FIRST = "Question: "
"""With what the paragraph of a script's head begins that states it."""


def asking(head: str | None, table: Table) -> Table:
    """The same table, which says first what the head of its script asks.

    Raises
    ------
    ValueError
        If the head asks nothing.
    """
    for paragraph in (head or "").split("\n\n"):
        if paragraph.strip().startswith(FIRST):
            return replace(table, asks=" ".join(paragraph.split()))
    raise ValueError("a study states its question in its head")


def asked(study: Study, table: Table) -> Table:
    """The same table, which says first what its study asks."""
    heads = ("Question", "Measure", "What would answer it")
    parts = (f"{head}: {said}" for head, said in zip(heads, study.asks, strict=True))
    return replace(table, asks=" ".join(parts))
