"""A small fixed part of the hidden-effect test, for continuous integration.

    python -m hidden_effects.gate

in ``studies/`` writes the baseline; a test runs the same cases and compares.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hidden_effects.cases import Case, draw_case
from hidden_effects.figures import classed, flagged, named, sure

GATE_SEEDS = tuple(range(100_000, 100_060))
BASELINE = Path(__file__).resolve().parents[2] / "results" / "hidden_effect" / "gate.json"
BETTER = {
    "detected, chi2 >= 30": 1,
    "false alarms": -1,
    "in first class, chi2 >= 60": 1,
    "first by name, chi2 >= 120": 1,
    "confident and wrong": -1,
    "outside, flagged": 1,
    "outside, confidently misnamed": -1,
}
"""Each count, and whether more of it is better or worse."""


def gate(
    answer: Callable[[Case], dict[str, Any]], seeds: tuple[int, ...] = GATE_SEEDS
) -> dict[str, dict[str, list[int]]]:
    """Answer the fixed cases: for each figure the seeds that count and those of them that hit."""
    rows = []
    for seed in seeds:
        case = draw_case(seed)
        rows.append(case.summary() | {"answer": answer(case)})

    def part(
        test: Callable[[dict[str, Any]], bool], *kinds: str, least: float = 0.0
    ) -> dict[str, list[int]]:
        here = [r for r in rows if r["kind"] in kinds and r["chi2"] >= least]
        return {"of": [r["seed"] for r in here], "hits": [r["seed"] for r in here if test(r)]}

    return {
        "detected, chi2 >= 30": part(flagged, "one", "two", least=30.0),
        "false alarms": part(flagged, "nothing"),
        "in first class, chi2 >= 60": part(classed, "one", least=60.0),
        "first by name, chi2 >= 120": part(named, "one", least=120.0),
        "confident and wrong": part(lambda r: sure(r) and not named(r), "nothing", "one"),
        "outside, flagged": part(flagged, "outside", least=30.0),
        "outside, confidently misnamed": part(sure, "outside"),
    }


def worse(
    before: dict[str, dict[str, list[int]]], now: dict[str, dict[str, list[int]]]
) -> list[str]:
    """One sentence for each figure that lost cases.

    One case may change sides, since the last bits of arithmetic differ between machines; two may
    not.
    """
    told = []
    for name, sign in BETTER.items():
        old, new = set(before[name]["hits"]), set(now[name]["hits"])
        lost = sorted(old - new if sign > 0 else new - old)
        if len(lost) - len(new ^ old) + len(lost) > 1:
            total = len(now[name]["of"])
            told.append(
                f"{name}: {len(old)} of {total} before, {len(new)} now; worse at seeds {lost}"
            )
    return told


def main() -> None:
    """Write the baseline."""
    from hidden_effect import answer

    found = gate(answer)
    BASELINE.parent.mkdir(parents=True, exist_ok=True)
    BASELINE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    for name, row in found.items():
        print(f"{name:32} {len(row['hits'])} of {len(row['of'])}")


if __name__ == "__main__":
    main()
