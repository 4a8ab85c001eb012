"""``springpot predict``: what an identified model says of another test, with a band."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.loading import no_fit

from . import timetests
from .common import (
    DATA,
    FILE,
    INPUT,
    at_place,
    emit,
    figure_option,
    geometry_option,
    json_option,
    notes_of,
    numbers,
    tell_written,
)

if TYPE_CHECKING:
    from springpot.identification.prediction import Prediction


@click.command(
    "predict", epilog="Example: springpot predict fit.json --frequency 0.1..100 --temperature 35"
)
@click.argument("fit", type=INPUT, metavar="FIT.json")
@click.option(
    "--frequency",
    "-f",
    metavar="HZ",
    help="In Hz: numbers with commas, or a range such as 0.1..100.",
)
@click.option("--omega", "-w", metavar="RAD/S", help="In rad/s instead.")
@click.option(
    "--history",
    type=DATA,
    metavar="FILE",
    help="A test in time, or a sweep, that is predicted and compared.",
)
@click.option(
    "--temperature",
    "-t",
    type=float,
    metavar="DEGC",
    help="In degC, where the model depends on it.",
)
@at_place
@click.option(
    "--level", type=click.FloatRange(0.0, 1.0, True, True), default=0.95, show_default=True
)
@click.option(
    "-o", "--output", type=FILE, metavar="FILE.csv", help="Write a table that opens again."
)
@figure_option("the prediction")
@geometry_option
@json_option
def command(
    fit: Path,
    frequency: str | None,
    omega: str | None,
    history: str | None,
    temperature: float | None,
    amplitude: float | None,
    others: tuple[str, ...],
    level: float,
    output: Path | None,
    figure: Path | None,
    geometry: str | None,
    as_json: bool,
) -> None:
    """Storage and loss of the model of FIT.json at other frequencies, temperatures or amplitudes.

    FIT.json is what 'springpot identify DATA --model EXPR --json' prints. The band is that of the
    model's curve. With --history another test of the specimen is predicted, in time or at
    frequencies, and it is told whether the prediction holds; where only what is imposed is in FILE,
    the answer to it is given.
    """
    from springpot.constraints import settings_of
    from springpot.errors import DataError
    from springpot.files import write_text
    from springpot.identification.result import Identification
    from springpot.loading import load

    _require_one_question(frequency, omega, history, geometry)
    known = load(fit)
    if not isinstance(known, Identification):
        raise DataError(no_fit(fit))
    if history is not None:
        timetests.predict(known, history, temperature, level, geometry, output, figure, as_json)
        return
    asked: dict[str, Any] = {"temperature": temperature, "amplitude": amplitude, "level": level}
    asked |= settings_of(others)
    if frequency is not None:
        asked["frequency"] = numbers(frequency)
    if omega is not None:
        asked["omega"] = numbers(omega)
    predicted = known.predict(**asked)
    if output is not None:
        write_text(output, table_text(predicted))
    if figure is not None:
        predicted.plot(figure)
    emit(predicted, as_json, lambda: show(predicted))
    if not as_json:
        tell_written(output, figure)


def _require_one_question(
    frequency: str | None, omega: str | None, history: str | None, geometry: str | None
) -> None:
    """Refuse what asks for nothing, or for several things at once."""
    # Hz and rad/s have no common default: a wrong guess would be off by a factor of six, unseen.
    if [frequency, omega, history].count(None) != 2:
        raise click.UsageError("give --frequency (Hz) or --omega (rad/s), or a --history")
    if geometry is not None and history is None:
        raise click.UsageError("--geometry is that of a --history: frequencies have none")


def show(predicted: Prediction) -> None:
    """Print the prediction for people."""
    from springpot.report.text import TextTable, with_interval
    from springpot.writing import number

    unit, given = predicted.units.stiffness, predicted.places
    band = f"{100.0 * predicted.level:g} % band"
    headers = [predicted.units.clock_head, *_conditions(predicted)]
    # The second band has a blank behind it, as two columns of one name would be one.
    storage, loss = (f"{part} [{unit}]" for part in predicted.units.parts)
    headers += [storage, band, loss, f"{band} ", "measured"]
    rows = []
    for i in range(len(predicted)):
        low, high = predicted.low[i], predicted.high[i]
        in_phase = with_interval(predicted.storage[i], low.real, high.real)
        out_of_phase = with_interval(predicted.loss[i], low.imag, high.imag)
        rate = predicted.units.on_clock(float(predicted.frequency[i]))
        at = [rate, *(column[i] for column in given.values())]
        places = [one if isinstance(one, str) else number(one) for one in at]
        rows.append([*places, *in_phase, *out_of_phase, timetests.WHERE[int(predicted.outside[i])]])
    print(f"{predicted.model}\n")
    table = TextTable(headers, rows, frozenset(headers) - {band, f"{band} ", "measured"})
    if not predicted.outside.any():
        table = table.lacking("measured")
    table.show()
    if predicted.notes:
        print(notes_of(predicted.notes))


def _conditions(predicted: Prediction) -> list[str]:
    """The titles of the conditions, of which some are told by name."""
    words = dict.fromkeys(predicted.words, "text")
    told = ((name, predicted.units.of_condition(name)) for name in predicted.conditions)
    return [f"{name} [{words.get(name, unit)}]" for name, unit in told]


def table_text(predicted: Prediction) -> str:
    """A CSV table with units in its header, which opens again as a measurement."""
    from springpot.writing import csv_text

    unit = predicted.units.stiffness
    names = [predicted.units.clock_head, *_conditions(predicted)]
    names += [f"{name} [{unit}]" for name in predicted.units.parts]
    names += [f"{part}_{end} [{unit}]" for part in ("storage", "loss") for end in ("low", "high")]
    names.append("measured [text]")
    table: list[list[object]] = [[*names]]
    for row, outside in zip(predicted.rows(), predicted.outside.tolist(), strict=True):
        # The other of frequency and angular frequency would be one column too many.
        kept = row[predicted.units.clock == "rad/s"], *row[2:]
        table.append([*kept, timetests.WHERE[outside]])
    return csv_text(table)
