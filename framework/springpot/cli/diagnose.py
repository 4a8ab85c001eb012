"""``springpot diagnose``: which physical effect is missing from a model."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from springpot.writing import accepting, with_model

from . import timetests
from .common import (
    DATA,
    accuracy_option,
    complete_data,
    geometry_option,
    json_option,
    judged_option,
    known_from,
    known_options,
    library_from,
    library_options,
    of_each,
    opened,
    opened_together,
    print_json,
    seed_option,
    verbose_option,
    window,
    with_rows,
)
from .hints import Waiting, suggested

if TYPE_CHECKING:
    from springpot.diagnosis.result import Diagnosis
    from springpot.measurement.opening import Test


@click.command(
    "diagnose", epilog="Example: springpot diagnose damper.csv --model fractional-maxwell"
)
@click.argument(
    "data", type=DATA, nargs=-1, required=True, metavar="DATA...", shell_complete=complete_data
)
@judged_option
@known_options
@library_options
@accuracy_option
@seed_option
@geometry_option
@verbose_option
@json_option
def command(
    data: tuple[str, ...],
    model: str | None,
    accuracy: str | None,
    seed: int | None,
    geometry: str | None,
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> int:
    """Where a model fails on DATA, which effect is missing, how sure that is, what to measure next.

    Without --model any linear passive material is judged: what is missing then is no part of the
    material.

    Each DATA is a file or a registered data set and gets its own answer; with several, --json
    prints one line of JSON for each. One that cannot be used is named on stderr, and the others are
    still answered. Tests in time are judged together, on their raw signals, and so are specimens:
    sweeps of which each has parameters of its own (--own, --population file).
    """
    from springpot.constraints import asks_for_all
    from springpot.registry import parse_model

    expression = None
    if model is not None:
        expression = parse_model(model)
    known = known_from(options)
    arguments = {"model": expression, "seed": seed or 0, **known}
    arguments |= {"accuracy": accuracy, **library_from(options)}
    tests = timetests.named_tests(data, geometry)
    if tests is None and asks_for_all(known["own"], known["share"]):
        tests = [opened_together(data, geometry)]

    def shown(*named: str) -> Shown:
        if as_json:
            return partial(_json, line=len(named) < len(data))
        return partial(_text, verbose=verbose, named=named, model=model)

    found: list[Diagnosis] = []

    def answer(name: str) -> None:
        if name != data[0] and not as_json:
            print()
        # Opened here: data that cannot be used end their own answer, not the others'.
        found.append(_answer([opened(name, geometry)], arguments, shown(name)))

    if tests is None:
        code = of_each(data, answer)
        _differences(found, as_json)
        return code
    _answer(tests, arguments, shown(*data))
    return 0


Shown = Callable[["Diagnosis", "Sequence[Test]"], None]


def _answer(tests: Sequence[Test], arguments: dict[str, Any], shown: Shown) -> Diagnosis:
    from springpot.api import diagnose
    from springpot.diagnosis.result import within
    from springpot.measurement.opening import together

    with Waiting() as waiting:
        progress = within(together(test.name for test in tests), waiting.told)
        diagnosis: Any = diagnose(tests, **arguments, progress=progress)
    shown(diagnosis, tests)
    answered: Diagnosis = diagnosis
    return answered


def _differences(found: Sequence[Diagnosis], as_json: bool) -> None:
    """What the answers say together; beside JSON, which has a line for each, on stderr."""
    from springpot.diagnosis.notes import unlike
    from springpot.report.text import wrapped

    says = unlike(found)
    if says:
        print("\n" + wrapped(f"note: {says}", window()), file=sys.stderr if as_json else sys.stdout)


def _json(diagnosis: Diagnosis, tests: Sequence[Test], line: bool) -> None:
    print_json(diagnosis, line)


def _text(
    diagnosis: Diagnosis,
    tests: Sequence[Test],
    verbose: bool,
    named: Sequence[str],
    model: str | None,
) -> None:
    """The answer, and the command that goes on from it."""
    from springpot.diagnosis.result import of_data
    from springpot.measurement.opening import sweep_of
    from springpot.report.told import told

    diagnosis = replace(diagnosis, steps=of_data(diagnosis.steps, *named, *with_model(model)))
    # At once: what is there stays, even where the rest is interrupted.
    print(told(diagnosis, window(), data=sweep_of(tests), verbose=verbose), flush=True)
    right_way = timetests.turned_data(tests, named)
    if following := _next_command(diagnosis, named, model, right_way):
        word = "next"
        if following.split()[1] == "discover":
            word = diagnosis.onward
        print(f"\n{word}: {following}", flush=True)


def _next_command(
    diagnosis: Diagnosis, named: Sequence[str], model: str | None, right_way: Sequence[str]
) -> str:
    """The command that goes on from an answer; empty where only a measurement does."""
    judged = with_model(model)
    # Before all else: of a force that counts the other way every other answer is wrong.
    if diagnosis.turns and list(right_way) != list(named):
        return suggested("diagnose", *right_way, *judged)
    # Before any effect: what sets several tests apart is none, and would be mended by a wrong one.
    # One of several specimens has no level of its own.
    if diagnosis.one_test and len(named) == 1:
        return suggested("diagnose", with_rows(named[0], diagnosis.one_test), *judged)
    # What cannot be fitted beside any material is accepted beside a model that has a name.
    if model is None and diagnosis.offered in diagnosis.left_out and len(named) == 1:
        return suggested("compare", *named)
    if diagnosis.offered:
        return suggested("discover", *named, *judged, *accepting([diagnosis.offered]))
    # Of any material that is adequate the question is left which model has the fewest parameters.
    if diagnosis.verdict == "adequate" and model is None and len(named) == 1:
        return suggested("compare", *named)
    return ""
