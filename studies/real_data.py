"""Measured data whose physics is known: what the diagnosis finds, and what it cannot tell.

    python studies/real_data.py [NAME ...] [--out results/real_data]

Each set goes through `discover` from one or more models, and once without naming one. The answers
are kept in ``answers/NAME.json`` and ``answers/without_model/NAME.json``; the tables are a pure
function of these files, so that single sets can be run again. A set that is not on this machine is
passed over with a line that says so; its old answers stay. Data are found through
``SPRINGPOT_DATA`` or beside the checkout.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from paper.draw import can_draw
from real_sets import unseen, without_model
from real_sets.answers import answer, save, saved, table
from real_sets.draw import draw
from real_sets.published import published
from real_sets.sets import SETS, RealSet, opened
from springpot import Measurement, discover
from springpot.benchmark import save_table
from springpot.errors import DataError, SpringpotError

ROOT = Path(__file__).resolve().parent.parent


def run(one: RealSet, folder: Path, only_without_model: bool = False) -> bool:
    """Ask the tool about one set; False if the set is not here."""
    try:
        data = opened(one)
    except DataError as error:
        print(f"{one.name}: not on this machine ({error})")
        return False
    without = without_model.ask(one, data)
    without_model.save(without, folder)
    print(f"{one.name}, without a model: {without['last']['says']}", flush=True)
    if not only_without_model:
        _with_models(one, data, folder)
    return True


def _with_models(one: RealSet, data: Measurement, folder: Path) -> None:
    """Ask from each of the set's models, and draw the last."""
    answers = []
    for model in one.models:
        ladder = discover(data, model)
        answers.append(answer(one, data, ladder))
        print(f"{one.name}: {ladder.diagnosis.says}", flush=True)
    if one.accept:
        given = discover(data, one.models[-1], accept=one.accept)
        answers.append(answer(one, data, given, given=True))
        # Where nothing was accepted there is no after.
        ladder = given if len(ladder.steps) == 1 else ladder
    save(answers, folder)
    if one.drawn and can_draw(folder):
        draw(ladder, folder / f"{one.name}.png")


def _unseen(folder: Path) -> None:
    """Ask of each file of other people, and keep what was said so far."""
    answers: list[dict[str, object]] = []
    for one in unseen.FILES:
        answers.append(unseen.ask(one))
        print(f"{one.file}: {answers[-1].get('says', answers[-1].get('skipped'))}", flush=True)
        unseen.save(answers, folder)
    report(folder)


def report(folder: Path) -> None:
    """Write the tables again."""
    answers = list(saved(folder))
    if answers:
        save_table(table(answers), folder, "real_data", ("md", "csv"))
        save_table(published(answers), folder, "published", ("md", "csv"))
    files = unseen.saved(folder)
    if files:
        save_table(unseen.table(files), folder, "unseen", ("md", "csv"))
    without = list(without_model.saved(folder))
    if without:
        save_table(without_model.table(without), folder, "without_model", ("md", "csv"))


def main(arguments: list[str] | None = None) -> None:
    """Run the sets that are asked for, all by default, and report."""
    known = {one.name: one for one in SETS}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"of {', '.join(known)}; all by default"
    )
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "real_data")
    parser.add_argument(
        "--only-without-model", action="store_true", help="ask no model of the set's own"
    )
    parser.add_argument(
        "--unseen", action="store_true", help="ask of the files of other people alone"
    )
    parser.add_argument("--report-only", action="store_true", help="only write the tables again")
    asked = parser.parse_args(arguments)
    if unknown := set(asked.names) - set(known):
        parser.error(f"no set {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    asked.out.mkdir(parents=True, exist_ok=True)
    if asked.unseen:
        _unseen(asked.out)
        return
    for name in () if asked.report_only else asked.names or known:
        run(known[name], asked.out, asked.only_without_model)
        report(asked.out)
    if asked.report_only:
        report(asked.out)


if __name__ == "__main__":
    try:
        main()
    except SpringpotError as error:
        sys.exit(f"error: {error}")
