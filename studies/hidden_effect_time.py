"""How often the missing effect of a test in time is found.

    python studies/hidden_effect_time.py [--cases 2000] [--seed 20261122]
        [-o results/hidden_effect_time]

Cases with a hidden effect are drawn, diagnosed and counted.

Each case is a relaxation, creep, recovery, startup or cyclic test of one of seven materials,
computed by numerical inversion of Laplace transforms (nothing of springpot is used), with one
hidden effect, none, or one that the library does not have, and with noise that in a quarter of the
cases has a memory. What springpot says is counted against what is true. Cases are kept as they are
done: an interrupted run goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from hidden_effects_time.cases import drawn_case
from hidden_effects_time.judge import Verdict, judged, library
from hidden_effects_time.tables import write_tables


def done_before(path: Path) -> list[Verdict]:
    """Cases of an earlier run."""
    if not path.exists():
        return []
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [Verdict(**{**row, "missing": tuple(row["missing"])}) for row in rows]


def main() -> None:
    """Draw, diagnose, count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("-o", "--output", type=Path, default=Path("results/hidden_effect_time"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    # Effects are tried at places where some make no sense: what overflows there is passed over.
    warnings.simplefilter("ignore", RuntimeWarning)
    kept = options.output / f"cases-{options.seed}.jsonl"
    verdicts, effects = done_before(kept), library()
    with kept.open("a", encoding="utf-8") as lines:
        for index in range(len(verdicts), options.cases):
            verdicts.append(judged(drawn_case(options.seed, index), index, effects))
            lines.write(json.dumps(verdicts[-1].to_dict()) + "\n")
            lines.flush()
    write_tables(verdicts[: options.cases], options.output, options.seed)
    print((options.output / "README.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
