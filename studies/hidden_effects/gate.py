"""A small fixed part of the hidden-effect test, for continuous integration.

A test hands in its own ``answer(case) -> dict`` and compares ``gate(answer)`` with the committed baseline:

    from hidden_effects.gate import gate
    figures = gate(answer)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hidden_effects.cases import Case, draw_case
from hidden_effects.figures import classed, flagged, named, sure

GATE_SEEDS = tuple(range(100_000, 100_060))


def gate(answer: Callable[[Case], dict[str, Any]], seeds: tuple[int, ...] = GATE_SEEDS) -> dict[str, float]:
    """Return the counts that must not get worse, as shares."""
    rows = []
    for seed in seeds:
        case = draw_case(seed)
        rows.append(case.summary() | {"answer": answer(case)})

    def part(test: Callable[[dict[str, Any]], bool], *kinds: str, least: float = 0.0) -> float:
        here = [r for r in rows if r["kind"] in kinds and r["chi2"] >= least]
        return sum(test(r) for r in here) / len(here)

    return {
        "detected, chi2 >= 30": part(flagged, "one", "two", least=30.0),
        "false alarms": part(flagged, "nothing"),
        "in first class, chi2 >= 60": part(classed, "one", least=60.0),
        "first by name, chi2 >= 120": part(named, "one", least=120.0),
        "confident and wrong": part(lambda r: sure(r) and not named(r), "nothing", "one"),
        "outside, flagged": part(flagged, "outside", least=30.0),
        "outside, confidently misnamed": part(sure, "outside"),
    }
