"""``springpot simulate``: a structure with identified dampers under a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.cli.common import (
    DATA,
    INPUT,
    emit,
    figure_option,
    json_option,
    numbers,
    of_each,
)

if TYPE_CHECKING:
    from springpot.structure.frame import Frame
    from springpot.structure.motion import GroundMotion


@click.command(
    "simulate",
    epilog="Example: springpot simulate frame.toml --record artificial:3.0 --figure drift.png",
)
@click.argument("structure", type=INPUT, metavar="STRUCTURE.toml")
@click.option(
    "--record",
    "records",
    type=DATA,
    multiple=True,
    metavar="FILE",
    help="CSV, PEER's AT2 or artificial:PEAK; repeat, or give a folder or pattern, for many.",
)
@click.option(
    "--frequency", "-f", metavar="HZ", help="Steady state instead: numbers with commas, or 0.5..10."
)
@click.option(
    "--draws",
    type=click.IntRange(min=0),
    default=40,
    show_default=True,
    help="Of uncertain parameters.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of all random numbers.",
)
@figure_option("drifts, loops and energy")
@click.option(
    "--next-experiment",
    "further",
    is_flag=True,
    help="Which test of a damper would narrow the band of the drift most.",
)
@json_option
def command(
    structure: Path,
    records: tuple[str, ...],
    frequency: str | None,
    draws: int,
    seed: int,
    figure: Path | None,
    further: bool,
    as_json: bool,
) -> int:
    """Drift, force, energy and damping of a frame or oscillator whose dampers were identified.

    STRUCTURE.toml has [structure] with mass [kg], stiffness [N/m] and damping, and a [[damper]] for
    each kind with fit = 'FIT.json' (of 'springpot identify --json') or a model with parameters. The
    band of the drift carries what is not known of the dampers. Of many records mean and envelope
    are told too. With --frequency the ground shakes with 1 m/s^2 at each frequency instead.
    """
    from springpot.structure.reading import records_meant

    if (not records) == (frequency is None):
        raise click.UsageError("give a --record or a --frequency")
    if further and not records:
        raise click.UsageError("--next-experiment is for a --record")
    if not records:
        _steady(structure, str(frequency), figure, as_json)
        return 0
    meant = records_meant(records)
    # One file by its name is one answer; a folder is many, whatever it holds.
    if list(records) == meant[:1]:
        _one(structure, meant[0], (draws, seed, further), figure, as_json)
        return 0
    return _many(structure, meant, (draws, seed, further), figure, as_json)


def _one(
    structure: Path, record: str, asked: tuple[int, int, bool], figure: Path | None, as_json: bool
) -> None:
    """The motion under one record."""
    import numpy as np

    from springpot.structure.answers import described
    from springpot.structure.motion import simulate
    from springpot.structure.reading import read_record, read_structure
    from springpot.structure.shown import show_motion

    draws, seed, further = asked
    # One generator for the record and the draws: one seed repeats both.
    rng = np.random.default_rng(seed)
    frame, shaken = read_structure(structure), read_record(record, rng)
    simulation = simulate(frame, shaken, rng, draws)
    if figure is not None:
        from springpot.structure.shown import figure_motion

        figure_motion(simulation, figure)
    result = described(simulation) | _further(frame, [shaken], further)
    emit(result, as_json, lambda: show_motion(result, figure))


def _further(frame: Frame, records: list[GroundMotion], wanted: bool) -> dict[str, Any]:
    """What could be measured next, where that is asked for."""
    if not wanted:
        return {}
    from springpot.structure.answers import further_tests

    return {"next_experiment": further_tests(frame, records).to_dict()}


def _many(
    structure: Path,
    records: list[str],
    asked: tuple[int, int, bool],
    figure: Path | None,
    as_json: bool,
) -> int:
    """The motion under each of many records; one that cannot be used stops none of the others."""
    import numpy as np

    from springpot.errors import SpringpotError
    from springpot.structure.answers import RecordSuite, described_suite
    from springpot.structure.motion import Simulation, simulate
    from springpot.structure.reading import read_record, read_structure
    from springpot.structure.shown import show_suite

    draws, seed, further = asked
    frame, rng = read_structure(structure), np.random.default_rng(seed)
    done: list[Simulation] = []
    refused: dict[str, str] = {}

    def one(name: str) -> None:
        try:
            # The same draws under each, so that a mean has a band too.
            record = read_record(name, rng)
            done.append(simulate(frame, record, np.random.default_rng(seed), draws))
        except SpringpotError as error:
            refused[name] = str(error)
            raise

    worst = of_each(records, one)
    if not done:
        return worst
    suite = RecordSuite(done, refused)
    if figure is not None:
        from springpot.structure.shown import figure_suite

        figure_suite(suite, figure)
    shaken = [each.motion.record for each in done]
    result = described_suite(suite) | _further(frame, shaken, further)
    emit(result, as_json, lambda: show_suite(result, figure))
    return worst


def _steady(structure: Path, frequency: str, figure: Path | None, as_json: bool) -> None:
    """The steady state at each frequency in Hz."""
    import numpy as np

    from springpot.structure.answers import described_steady
    from springpot.structure.frame import steady_of
    from springpot.structure.reading import read_structure
    from springpot.structure.shown import show_steady

    steady = steady_of(read_structure(structure), 2.0 * np.pi * np.array(numbers(frequency)))
    if figure is not None:
        from springpot.structure.shown import figure_steady

        figure_steady(steady, figure)
    result = described_steady(steady)
    emit(result, as_json, lambda: show_steady(result, figure))
