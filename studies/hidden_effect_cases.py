"""Measurements with a hidden physical effect and a known truth, for testing any diagnosis tool.

``draw_case(seed)`` gives a measurement in the frequency domain, ``draw_signal_case(seed)`` records
of force and displacement. Both are deterministic and know nothing of springpot. Write some of them
to a folder:

    python studies/hidden_effect_cases.py FOLDER --cases 40 --seed 0
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from hidden_effects.cases import Case, Hidden, draw_case
from hidden_effects.signals import SignalCase, draw_signal_case

__all__ = ["Case", "Hidden", "SignalCase", "draw_case", "draw_signal_case"]


def main() -> None:
    """Write cases as CSV files and their truth as JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    with (asked.folder / "truth.jsonl").open("w", encoding="utf-8") as truth:
        for seed in range(asked.seed, asked.seed + asked.cases):
            case = draw_case(seed)
            case.to_csv(asked.folder / f"{seed:06d}.csv")
            truth.write(json.dumps(case.summary()) + "\n")


if __name__ == "__main__":
    main()
