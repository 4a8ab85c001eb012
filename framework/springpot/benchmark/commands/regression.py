"""``springpot regression``: the accuracy gate for continuous integration."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from springpot.cli.common import FOLDER, INPUT, POSITIVE, F, Output, emit, json_option

if TYPE_CHECKING:
    from springpot.benchmark.gate.regression import Gate


def _shared(command: F) -> F:
    """Add the arguments that both commands have."""
    out, text = Path("results"), "Where results and baselines are."
    for add in (
        click.option(
            "--workers", type=POSITIVE, metavar="N", help="Processes; one for each core by default."
        ),
        click.option(
            "--out", type=FOLDER, default=out, show_default=True, metavar="DIR", help=text
        ),
        click.option(
            "--baseline", type=Output(""), metavar="FILE", help="By default OUT/NAME/baseline.json."
        ),
        click.argument("studies", nargs=-1, type=INPUT, metavar="[STUDY.py|STORE]..."),
    ):
        command = add(command)
    return command


@click.group("regression", epilog="Example: springpot regression check studies/gate.py --json")
def command() -> None:
    """Has an optimiser become worse since the baseline was made? For continuous integration."""


@command.command("update", epilog="Example: springpot regression update studies/gate.py")
@_shared
@json_option
def _update(
    studies: tuple[Path, ...], baseline: Path | None, out: Path, workers: int | None, as_json: bool
) -> None:
    """Run each STUDY.py afresh, or take the trials of a STORE, and write its baseline: commit it.

    Without arguments, every study that has a baseline.
    """
    from springpot.benchmark.gate.regression import known_scripts, update
    from springpot.files import require_writable

    _require_one(studies, baseline)
    # Told before the studies are run; a new one may lie in a folder that is yet to be made.
    if baseline is not None and baseline.exists():
        require_writable(baseline)
    files = [update(study, baseline, out, workers) for study in studies or known_scripts(out)]
    emit({"schema": "springpot.files/1", "files": files}, as_json, lambda: print(*files, sep="\n"))


@command.command("check", epilog="Example: springpot regression check studies/gate.py")
@_shared
@click.option("--seed", type=int, metavar="N", help="Instead of the study's own.")
@click.option(
    "--level",
    type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    metavar="P",
    help="Chance of a false alarm anywhere in the study; 0.01 by default.",
)
@json_option
def _check(
    studies: tuple[Path, ...],
    baseline: Path | None,
    out: Path,
    workers: int | None,
    seed: int | None,
    level: float | None,
    as_json: bool,
) -> int:
    """Run each STUDY.py afresh, or take the trials of a STORE, and compare with its baseline.

    Exit code 1 and a sentence for each optimiser and data set that got worse; 2 if there is no
    baseline. Without arguments, every study that has a baseline.
    """
    from springpot.benchmark.gate.baseline import LEVEL
    from springpot.benchmark.gate.regression import check, known_scripts

    _require_one(studies, baseline)
    level = level or LEVEL
    gates = [
        check(study, baseline, out, workers, seed, level) for study in studies or known_scripts(out)
    ]
    passed = all(gate.passed for gate in gates)
    result = {
        "schema": "springpot.regression/1",
        "passed": passed,
        "gates": [asdict(gate) for gate in gates],
    }
    emit(result, as_json, lambda: _show(gates))
    # The exit code is what a pipeline of CI sees.
    return int(not passed)


def _require_one(studies: tuple[Path, ...], baseline: Path | None) -> None:
    # One file cannot be the baseline of several studies.
    if baseline is not None and len(studies) != 1:
        raise click.UsageError("--baseline needs exactly one study", click.get_current_context())


def _show(gates: list[Gate]) -> None:
    for gate in gates:
        for line in gate.regressions:
            print(f"worse: {line}")
        for note in gate.notes:
            print(f"note: {note}")
        for line in gate.seen:
            print(f"seen: {line}")
        outcome = "nothing got worse"
        if not gate.passed:
            outcome = f"{len(gate.regressions)} got worse"
        print(f"{gate.baseline}: {gate.cells} comparisons, {outcome}")
