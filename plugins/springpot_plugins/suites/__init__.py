"""The built-in suites of problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial

from springpot.hooks import hookimpl
from springpot.measurement import DataSet, Measured, Suite

SUITES = {
    "springpot-60": "60 problems of 2 to 14 parameters: sweeps, steps, records, joint tests and"
    " populations; exact, noisy and measured",
    "springpot-hard-20": "20 problems that a seed draws and of whose 64 descents none arrives",
    "springpot-rugged-20": "20 problems of 8 to 14 parameters that a seed draws and of whose 1,024"
    " descents of four kinds none arrives",
}


@hookimpl
def springpot_suites() -> Iterable[Suite]:
    """Nothing of them is read or computed before it is used."""
    return tuple(
        Suite(name, summary, partial(_problems, name), partial(_measured, name))
        for name, summary in SUITES.items()
    )


def _problems(name: str) -> tuple[DataSet, ...]:
    from .described import loaded

    return loaded(name)


def _measured(name: str) -> Mapping[str, Measured]:
    from .described import measured

    return measured(name)
