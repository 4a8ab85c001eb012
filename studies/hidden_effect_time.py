"""How often the missing effect of a test in time is found.

    python studies/hidden_effect_time.py [--cases 2000] [--seed 20261122]
        [-o results/hidden_effect_time]
    python studies/hidden_effect_time.py --read [--cases 200]
    python studies/hidden_effect_time.py --joint [--cases 200]
    python studies/hidden_effect_time.py --several [--cases 100]

Cases with a hidden effect are drawn, diagnosed and counted.

Each case is a relaxation, creep, recovery, startup or cyclic test of one of seven materials,
computed by numerical inversion of Laplace transforms (nothing of springpot is used), with one
hidden effect, none, or one that the library does not have, and with noise that in a quarter of the
cases has a memory. What springpot says is counted against what is true. With --read each case is
a record whose motion was read with noise, too; with --joint each is two or three tests of one
specimen, of which a sweep may be one; with --several two effects are missing, and automatic
discovery is asked. Cases are kept as they are done: an interrupted run goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from hidden_effects_time import cases, joint, joint_report, several
from hidden_effects_time.judge import Verdict, judged, library
from hidden_effects_time.tables import write_tables


@dataclass(frozen=True)
class Kind:
    """A kind of cases: how one is drawn, judged and taken up again, and how all are counted."""

    judged: Callable[[int, int, Sequence[Any]], Any]
    again: Callable[[dict[str, Any]], Any]
    write: Callable[[Sequence[Any], Path, int], None]
    count: int
    output: Path


SINGLE = Kind(
    lambda seed, index, effects: judged(cases.drawn_case(seed, index), index, effects),
    lambda row: Verdict(**{**row, "missing": tuple(row["missing"])}),
    write_tables,
    2000,
    Path("results/hidden_effect_time"),
)
READ = replace(
    SINGLE,
    judged=lambda seed, index, effects: judged(
        cases.drawn_case(seed, index, read=True), index, effects
    ),
    write=partial(write_tables, read=True),
    count=200,
    output=Path("results/hidden_effect_read"),
)
JOINT = Kind(
    lambda seed, index, effects: joint_report.judged(joint.drawn_case(seed, index), index, effects),
    joint_report.JointVerdict.from_dict,
    joint_report.write_joint,
    200,
    Path("results/hidden_effect_joint"),
)
SEVERAL = Kind(
    lambda seed, index, effects: several.judged(several.drawn_two(seed, index), index, effects),
    several.LadderVerdict.from_dict,
    several.write_several,
    100,
    Path("results/hidden_effect_time_several"),
)


def main() -> None:
    """Draw, diagnose, count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--joint", action="store_true", help="several tests of one specimen")
    which.add_argument("--read", action="store_true", help="the motion is read with noise")
    which.add_argument("--several", action="store_true", help="two effects are missing")
    parser.add_argument("--cases", type=int)
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    chosen = {"read": READ, "joint": JOINT, "several": SEVERAL}
    kind = next((kind for name, kind in chosen.items() if getattr(options, name)), SINGLE)
    count, output = options.cases or kind.count, options.output or kind.output
    output.mkdir(parents=True, exist_ok=True)
    # Effects are tried at places where some make no sense: what overflows there is passed over.
    warnings.simplefilter("ignore", RuntimeWarning)
    kept, effects = output / f"cases-{options.seed}.jsonl", library()
    verdicts = []
    if kept.exists():
        verdicts = [
            kind.again(json.loads(line)) for line in kept.read_text(encoding="utf-8").splitlines()
        ]
    with kept.open("a", encoding="utf-8") as lines:
        for index in range(len(verdicts), count):
            verdicts.append(kind.judged(options.seed, index, effects))
            lines.write(json.dumps(verdicts[-1].to_dict()) + "\n")
            lines.flush()
    kind.write(verdicts[:count], output, options.seed)
    print((output / "README.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
