"""The built-in suites of problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from springpot.hooks import hookimpl
from springpot.measurement import DataSet, Measured, Suite

NAME = "springpot-60"


@hookimpl
def springpot_suites() -> Iterable[Suite]:
    """One; nothing is read or computed before it is used."""
    summary = (
        "60 problems of 2 to 14 parameters: sweeps, steps, records, joint tests and populations;"
        " exact, noisy and measured"
    )
    return (Suite(NAME, summary, _problems, _measured),)


def _problems() -> tuple[DataSet, ...]:
    from .described import loaded

    return loaded(NAME)


def _measured() -> Mapping[str, Measured]:
    from .described import measured

    return measured(NAME)
