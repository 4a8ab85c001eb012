"""``springpot discover``: add missing effects one by one and watch the error fall."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from springpot.writing import accepting, with_model

from . import timetests
from .common import (
    DATA,
    Output,
    accuracy_option,
    complete_data,
    emit,
    geometry_option,
    is_data,
    json_option,
    judged_option,
    known_from,
    known_options,
    library_from,
    library_options,
    names_of,
    opened,
    opened_together,
    seed_option,
    tell_written,
    verbose_option,
    window,
    with_rows,
)
from .group import INTERRUPTED
from .hints import Waiting, kept_by, suggested

if TYPE_CHECKING:
    from springpot.diagnosis.ladder import Ladder
    from springpot.measurement.opening import Test
    from springpot.rheology.effect import Effect
    from springpot.rheology.model import Model

E = TypeVar("E")

ACCEPT = (
    "Accept this effect, or the law in a file of 'springpot invent -o'; may be given several times."
)


@click.command(
    "discover",
    epilog=(
        "Example: springpot discover damper.csv --model fractional-maxwell --auto --report"
        " damper.html"
    ),
)
@click.argument(
    "words",
    type=DATA,
    nargs=-1,
    required=True,
    metavar="DATA... [EFFECT]...",
    shell_complete=complete_data,
)
@judged_option
@click.option(
    "--accept",
    multiple=True,
    metavar="EFFECT",
    help=ACCEPT,
    shell_complete=names_of("effect"),
)
@click.option(
    "--split",
    metavar="COLUMN",
    help="Give each value of a column a factor of its own, the material being shared.",
)
@click.option(
    "--auto", is_flag=True, help="Let the evidence decide, until nothing significant is left."
)
@click.option(
    "--report",
    type=Output("springpot.report.html:check_report_path"),
    metavar="FILE.html",
    help="Write the whole story as one self-contained page.",
)
@click.option(
    "--figure",
    type=Output("springpot.report.canvas:check_moving_path"),
    metavar="FILE",
    help="Draw the falling error, of tests in time each test with its fits"
    " (.png, .svg, .pdf, or .gif to play it).",
)
@known_options
@library_options
@accuracy_option
@seed_option
@geometry_option
@verbose_option
@json_option
def command(
    words: tuple[str, ...],
    model: str | None,
    accept: tuple[str, ...],
    split: str | None,
    auto: bool,
    report: Path | None,
    figure: Path | None,
    seed: int | None,
    geometry: str | None,
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> int:
    """Add effects that are missing from a model of DATA and show how far each lowers the error.

    Every step shows the error that was predicted and the one that was reached, both beside the
    noise floor and the least error that any material reaches. Without --model discovery begins with
    any linear passive material. Several DATA are tests of one specimen, in time and at frequencies.

    Ctrl-C ends with the answer of the last step that was reached.
    """
    from springpot.constraints import asks_for_all, owning
    from springpot.registry import of_each, parse_model
    from springpot.report.told import told

    data, more = _parted(words)
    accept = (*accept, *more)  # as in: --accept inertia time-delay
    if split is not None:
        accept = (of_each(split).name, *accept)
    _require_one_choice(auto, accept)
    expression = None if model is None else parse_model(model)
    again = again_with(data, model, accept, auto, seed)
    chosen = library_from(options)
    effects = None
    if not auto:
        mine = {effect.name: effect for effect in chosen["effects"]}
        effects = [mine.get(name) or accepted(name, i) for i, name in enumerate(accept, 1)]
    arguments = {"accept": effects, "seed": seed or 0, "accuracy": options.pop("accuracy")}
    known = known_from(options)
    arguments |= {**chosen, **known}
    tests = _tests(data, geometry, specimens=asks_for_all(known["own"], known["share"]))
    ladder, code = _climbed(tests, expression, **arguments)
    if expression is not None:
        # What is drawn has the levels of which parameters are, as the fits have them.
        given = {name: known[name] for name in ("own", "share", "specimen")}
        tests = owning(expression, tests, **given)[1]
    _write(ladder, tests, figure, report, again)
    emit(ladder, as_json, lambda: print(told(ladder, window(), verbose=verbose)))
    # A program that reads the JSON reads nothing else.
    if not as_json:
        tell_written(figure, report)
        print(f"\nnext: {_next(ladder, data, model, tests)}")
    return code


def _parted(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The data, and the effects: what comes behind the first is data where a file is called so."""
    data, effects = [words[0]], []
    for word in words[1:]:
        # A law of `springpot invent -o` is a file too, and an effect.
        if is_data(word) and not word.endswith(".json"):
            data.append(word)
        else:
            effects.append(word)
    return data, effects


def _tests(data: Sequence[str], geometry: str | None, specimens: bool) -> Sequence[Test]:
    """One sweep, tests of one specimen, a test in time among them, or a sweep of each specimen."""
    in_time = timetests.named_tests(data, geometry)
    if in_time is not None:
        return in_time
    if specimens:
        return [opened_together(data, geometry)]
    if len(data) > 1:
        raise click.UsageError(
            "several sweeps are judged one by one; together where a test in time is among them, or"
            " as specimens (--own, --population file)"
        )
    return [opened(data[0], geometry)]


def accepted(name: str, place: int) -> Effect:
    """An effect by its name, by its formula, or the law in a file of ``springpot invent -o``.

    Parameters
    ----------
    name : str
        As the user gave it.
    place : int
        In the order of what is accepted: a law without a name is called by it.
    """
    from springpot.loading import law_of
    from springpot.registry import effect_of

    if name.endswith(".json"):
        return law_of(name, f"law-{place}")
    return effect_of(name, place)


def _write(
    ladder: Ladder,
    tests: Sequence[Test],
    figure: Path | None,
    report: Path | None,
    again: list[str],
) -> None:
    """Write the files that were asked for."""
    if figure is not None:
        ladder.plot(figure)
    if report is not None:
        from springpot.report.html import write_report

        write_report(ladder, tests, report, again)


def _require_one_choice(auto: bool, accept: tuple[str, ...]) -> None:
    """Either the evidence decides, or the user names what is accepted."""
    if auto and accept:
        raise click.UsageError("give --auto or --accept EFFECT, not both")
    if not auto and not accept:
        raise click.UsageError("give --auto, or --accept EFFECT once or more")


def _next(ladder: Ladder, data: Sequence[str], model: str | None, tests: Sequence[Test]) -> str:
    """The command to go on with.

    One test, or one effect more where one is named, or the parameters reached.
    """
    judged = with_model(model)
    diagnosis = ladder.diagnosis
    right_way = timetests.turned_data(tests, data)
    if diagnosis.turns and right_way != list(data):
        return suggested("diagnose", *right_way, *judged)
    # As `diagnose` does: what sets several tests apart is no effect, and the parameters of them all
    # are of none.
    if diagnosis.one_test and len(data) == 1:
        return suggested("diagnose", with_rows(data[0], diagnosis.one_test), *judged)
    taken = [step.accepted for step in ladder.steps if step.accepted]
    # What was dropped again, marked by a hyphen, is not asked for a second time.
    named = [name for name in taken if not name.startswith("-")]
    following = [
        name for name in diagnosis.leading[:1] if name not in named and f"-{name}" not in taken
    ]
    if diagnosis.best is not None:
        following = [diagnosis.best.effect]
    if not following:
        return suggested("identify", *data, *with_model(ladder.model.name))
    return suggested("discover", *data, *judged, *accepting([*named, *following]))


def _climbed(tests: Sequence[Test], model: Model | None, **arguments: Any) -> tuple[Ladder, int]:
    """The ladder, as far as it was waited for, and the exit code that says which."""
    from springpot.api import discover
    from springpot.diagnosis.result import within
    from springpot.measurement.opening import together

    # Ladders as far as they came, so that Ctrl-C costs the step that was under way and no more.
    reached: list[Ladder] = []
    with Waiting() as waiting:
        progress = within(together(test.name for test in tests), waiting.told)
        try:
            arguments |= {"progress": progress, "reached": reached.append}
            ladder: Any = discover(tests, model, **arguments)
            return ladder, 0
        except KeyboardInterrupt:
            if not reached:
                raise
    steps = len(reached[-1].steps)
    print(
        f"springpot: interrupted; the answer is that of step {steps - 1}, the last one reached",
        file=sys.stderr,
    )
    return reached[-1], INTERRUPTED


def again_with(
    data: Sequence[str], model: str | None, accept: Sequence[str], auto: bool, seed: int | None
) -> list[str]:
    """The command that makes the same report again."""
    # There are no effects with --auto.
    chosen = ["--auto"] if auto else accepting(accept)
    # Without one it is nothing that was given, and the random numbers of none are those of 0.
    seeded = ["--seed", "0"] if seed is None else []
    words = [*data, *with_model(model), *chosen, *kept_by("discover"), *seeded]
    return ["springpot", "discover", *words]
