"""What moved: asks all questions anew and compares with the committed answers.

python tests/golden                 every answer that moved, and where
python tests/golden --verdicts      only verdicts, named classes and sizes of the error
python tests/golden --update        the answers of today become the committed ones
python tests/golden --kind fits     one kind alone: diagnoses, fits, tests-in-time
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from cases import CASES

from answers import asked, cases_of, gist, keep, kept, moved


def answers_of(kind: str) -> dict[str, Any]:
    """All questions of one kind, asked anew; a fault is an answer too."""
    answers = {}
    for case in cases_of(kind):
        with tempfile.TemporaryDirectory() as folder:
            try:
                answers[case.name] = asked(case, Path(folder))
            except Exception as error:
                answers[case.name] = {"fault": f"{type(error).__name__}: {error}"}
    return answers


def main() -> int:
    """Ask, compare, tell; 1 where an answer moved."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kind", choices=list(CASES), action="append")
    parser.add_argument("--verdicts", action="store_true")
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()
    changed = 0
    for kind in options.kind or CASES:
        now = answers_of(kind)
        if options.update:
            keep(kind, now)
            continue
        before = kept(kind)
        for name, answer in now.items():
            old = before.get(name, {})
            pair = (gist(old), gist(answer)) if options.verdicts else (old, answer)
            places = list(moved(*pair))
            changed += bool(places)
            if places:
                print("\n  ".join((f"{kind}: {name}", *places)))
    if not options.update:
        print(f"{changed} answers moved")
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main())
