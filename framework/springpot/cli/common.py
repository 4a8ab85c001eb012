"""What commands share: options, the choice between text and JSON, and what the shell completes.

bash and zsh learn to complete names and files behind TAB by
``eval "$(_SPRINGPOT_COMPLETE=bash_source springpot)"`` (zsh_source), fish by
``_SPRINGPOT_COMPLETE=fish_source springpot | source``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stdout
from functools import partial
from importlib import import_module
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from .group import BAD_INPUT, FAULT, INTERRUPTED, exit_code

if TYPE_CHECKING:
    from springpot.measurement.covered import OtherTest
    from springpot.measurement.measurement import Measurement
    from springpot.measurement.timetest import TimeTest

    T = TypeVar("T", Measurement, TimeTest, TimeTest | OtherTest)


F = TypeVar("F", bound=Callable[..., Any])

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def names_of(word: str) -> Completer:
    """Completes the names of one kind of things."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [CompletionItem(name) for name in _beginning(_names(word), incomplete)]

    return complete


def complete_expression(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Completes the last part of an expression: a model, or behind ``+`` an effect."""
    before, plus, last = incomplete.rpartition("+")
    if not plus:
        return [CompletionItem(name) for name in _beginning(_names("model"), last.strip())]
    # The shell replaces the whole word: what was typed before comes back with each offer.
    return [
        CompletionItem(f"{before.strip()} + {name}")
        for name in _beginning(_names("effect"), last.strip())
    ]


def complete_data(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Completes data sets, and lets the shell complete files."""
    return [
        *(CompletionItem(name) for name in _beginning(_names("data set"), incomplete)),
        CompletionItem(incomplete, type="file"),
    ]


def _names(word: str) -> list[str]:
    # Only when TAB is pressed: every command imports this module.
    from springpot.registry import plugins

    return plugins().names(word)


def _beginning(names: Iterable[str], start: str) -> list[str]:
    return sorted(name for name in names if name.startswith(start))


FOLDER = click.Path(path_type=Path)
"""Where a command puts files, or finds those of earlier ones."""
POSITIVE = click.IntRange(min=1)

SPACED = 25
"""Points of a range, evenly spaced in the logarithm.

Eight and more for each decade of a usual sweep.
"""


def _files_meant(text: str) -> list[str]:
    """Names that a file may have where a part, columns and rows may be chosen behind it.

    It may hold such marks itself.
    """
    return [text[:i] for i in (*(i for i, sign in enumerate(text) if sign in "#?@"), len(text))]


def is_data(text: str) -> bool:
    """Whether there is a file of that name, whatever is chosen of it."""
    from springpot.measurement.reader import is_file

    return any(is_file(name) and Path(name).is_file() for name in _files_meant(text))


class _Input(click.Path):
    """What a command reads, which no output of it replaces."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value, after the file that it names has been remembered."""
        from springpot.files import keep_input

        for name in _files_meant(str(value)):
            keep_input(name)
        # Whether it can be a file is told by who reads it.
        return self.coerce_path_result(value)


class Output(click.Path):
    """A file that a command writes, and nothing else of it.

    Parameters
    ----------
    check : str
        The module and the function in it by which a path that cannot be written is told, before
        time is spent on what goes there; empty where the command does that itself.
    """

    def __init__(self, check: str = "springpot.files:require_writable") -> None:
        super().__init__(path_type=Path)
        self.check = check

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path, after a check that no other output goes there and that this one can."""
        from springpot.files import keep_output

        keep_output(value)
        path = super().convert(value, param, ctx)
        if self.check:
            module, _, name = self.check.partition(":")
            getattr(import_module(module), name)(path)
        return path


FILE, FIGURE = Output(), Output("springpot.report.canvas:check_figure_path")
TABLE = Output("springpot.report.page:check_table_path")
DATA, INPUT = _Input(path_type=str), _Input(path_type=Path)
"""What is read: data as a user names them, and any other file."""


OUTPUT = "springpot.output"
"""Where a command with ``--json`` finds its own output among what its context knows."""


def figure_option(what: str) -> Callable[[F], F]:
    """Add ``--figure FILE``; `what` is drawn."""
    text = f"Draw {what} (.png, .svg or .pdf)."
    return click.option("--figure", type=FIGURE, metavar="FILE", help=text)


def results_option(text: str) -> Callable[[F], F]:
    """The folder in which a study's results are, ``--out``."""
    return click.option(
        "--out", type=FOLDER, default=Path("results"), show_default=True, metavar="DIR", help=text
    )


def at_place(command: F) -> F:
    """Add ``--amplitude`` and ``--at``: under which conditions a model is asked."""
    for add in (
        click.option(
            "--at",
            "others",
            multiple=True,
            metavar="COLUMN=VALUE",
            help="Another column that the model depends on: batch=2, file=pad-1.",
        ),
        click.option(
            "--amplitude", "-a", type=float, metavar="X", help="In the amplitude unit of the data."
        ),
    ):
        command = add(command)
    return command


def json_option(command: F) -> F:
    """Add ``--json``; with it, standard output holds what `print_json` prints and nothing else."""
    text = "Print JSON instead of text."
    return click.option("--json", "as_json", is_flag=True, callback=_json_alone, help=text)(command)


def _json_alone(context: click.Context, parameter: click.Parameter, wanted: bool) -> bool:
    """Let what anybody else prints, such as a plugin that is being tried, go to standard error."""
    if wanted:
        # Kept before it is turned away: `print_json` has to find it again.
        context.meta[OUTPUT] = sys.stdout
        context.with_resource(redirect_stdout(sys.stderr))
    return wanted


def print_json(result: Any, line: bool = False) -> None:
    """Print `result` as JSON, at once: what is there stays, even where the rest is interrupted.

    On a `line` where it is one of several answers, as programs read a stream of them.
    """
    from springpot.report.text import to_json

    print(
        to_json(result, None if line else 2),
        file=click.get_current_context().meta.get(OUTPUT, sys.stdout),
        flush=True,
    )


data_argument = click.argument("data", type=DATA, metavar="DATA", shell_complete=complete_data)
"""DATA: a file or the name of a registered data set."""


MODEL = "Model expression such as 'fractional-maxwell + inertia'; see 'springpot list models'."
COMPLETED: dict[str, Any] = {"shell_complete": complete_expression}


model_option = click.option(
    "--model", "-m", "model", metavar="EXPR", required=True, help=MODEL, **COMPLETED
)
judged_option = click.option(
    "--model",
    "-m",
    "model",
    metavar="EXPR",
    help=f"{MODEL} Without it any linear passive material is judged.",
    **COMPLETED,
)


def seed_option(command: F) -> F:
    """Add ``--seed N``."""
    text = "Seed of all random numbers; the same seed gives the same bits."
    return click.option("--seed", type=click.IntRange(min=0), metavar="N", help=text)(command)


geometry_option = click.option(
    "--geometry",
    metavar="TEXT",
    help="Of damper or specimen, such as 'shear-pads area=200cm^2 gap=10mm':"
    " stiffness becomes modulus, or back.",
)


def opened(data: str, geometry: str | None = None, quiet: bool = False) -> Measurement:
    """The measurement that DATA names, seen through a geometry if one is given.

    What the reader doubts or left out goes to stderr, unless `quiet`.
    """
    from springpot.registry import open_measurement

    measured = open_measurement(data)
    if not quiet:
        for key, value in measured.provenance.items():
            if key.startswith("note "):
                note_to_stderr(measured.name, value)
    return seen_through(measured, geometry)


def opened_together(data: Sequence[str], geometry: str | None = None) -> Measurement:
    """All DATA as one measurement, a file each."""
    from springpot.measurement.conversion import joined

    measured = [opened(name, geometry) for name in data]
    return joined(measured) if len(measured) > 1 else measured[0]


def seen_through(test: T, geometry: str | None) -> T:
    """A test seen through a geometry, if one is given."""
    if geometry is None:
        return test
    from springpot.errors import OptionError
    from springpot.measurement.covered import OtherTest

    if isinstance(test, OtherTest):
        raise OptionError(f"{test.name}: a geometry is for stiffness, not for {test.kind}")
    from springpot.measurement.conversion import through
    from springpot.measurement.geometry import parse_geometry

    return through(test, parse_geometry(geometry))


def of_each(data: Sequence[str], answer: Callable[[str], object]) -> int:
    """Answer each of many files.

    One that cannot be used is told in its line, and stops none of the others.

    Parameters
    ----------
    data : sequence of str
        As the user named them.
    answer : callable
        Answers one of them.

    Returns
    -------
    int
        The worst exit code: 2 where one could not be used. Once interrupted, or where nobody reads
        on, the rest is not wanted either, and the code is that.
    """
    worst = 0
    for i, name in enumerate(data):
        code = exit_code(partial(_answered, answer, name))
        if code == INTERRUPTED:
            print(f"interrupted: {i} of {len(data)} are done", file=sys.stderr)
        if code not in (0, BAD_INPUT, FAULT):
            return code
        worst = max(worst, code)
    return worst


def _answered(answer: Callable[[str], object], name: str) -> int:
    answer(name)
    return 0


def note_to_stderr(name: str, note: str) -> None:
    """What is doubted of data, broken at words where people read it.

    In a file or pipe one line each.
    """
    from springpot.report.text import wrapped

    line = f"note: {name}: {note}"
    # Programs that search a log want each note in one line.
    if sys.stderr.isatty():
        line = wrapped(line, window())
    print(line, file=sys.stderr)


def known_options(command: F) -> F:
    """Add what a user knows beforehand: its values, bounds, whose own it is, and rows."""
    # A decorator that is applied last is listed first: hence the last option of the help stands
    # first.
    for option in (
        click.option(
            "--exclude",
            multiple=True,
            metavar="WHERE",
            help="Leave out rows: frequency=40..60, row=3.",
        ),
        click.option(
            "--bounds",
            multiple=True,
            metavar="NAME=LOW:HIGH",
            help="Keep a parameter within: k1=0:200.",
        ),
        click.option(
            "--tie",
            multiple=True,
            metavar="TIE",
            help="A parameter by others, 'k2 = 2*k1', or an order, 'tau1 < tau2'.",
        ),
        click.option(
            "--own",
            multiple=True,
            metavar="NAMES:COLUMN",
            help="Parameters that each level has for itself: k,c:batch; each file without COLUMN.",
        ),
        click.option(
            "--share",
            metavar="NAMES",
            help="Parameters that all specimens share; every other one is their own.",
        ),
        click.option(
            "--specimen",
            metavar="COLUMNS",
            help="Columns whose levels are the specimens, in the place of files: batch,number.",
        ),
        click.option(
            "--population",
            metavar="COLUMN",
            help="Every parameter is each specimen's own: mean and scatter over COLUMN, file,"
            " or batch/specimen.",
        ),
        click.option(
            "--fix", multiple=True, metavar="NAME=VALUE", help="Hold a parameter, in printed units."
        ),
    ):
        command = option(command)
    return command


def library_options(command: F) -> F:
    """Add what chooses the effects that may be named."""
    named: dict[str, Any] = {"shell_complete": names_of("effect"), "multiple": True}
    for option in (
        click.option("--without", metavar="EFFECT", help="Leave this effect out.", **named),
        click.option(
            "--effects",
            metavar="A,B",
            help="Effects that may be named; without it all that are installed.",
        ),
        click.option(
            "--effect",
            multiple=True,
            metavar="LAW",
            help="Look for a law of your own too: 'my-mass = parallel: -m*omega^2'.",
        ),
    ):
        command = option(command)
    return command


def library_from(options: dict[str, Any]) -> dict[str, Any]:
    """The arguments ``effects``, ``only`` and ``without``, taken out of a command's options."""
    from springpot.registry import plugins
    from springpot.rheology.typed import law

    # Here, so that what is no law is told before the data are opened. Without a name of its own it
    # is called by its number.
    own = [law(text, f"law-{i}") for i, text in enumerate(options.pop("effect"), 1)]
    only, without = options.pop("effects"), options.pop("without")
    if only is not None:
        only = [name.strip() for name in only.split(",")]
    mine = {effect.name for effect in own}
    for name in (*(only or ()), *without):
        if name not in mine:
            plugins().effect(name)
    return {"effects": own, "only": only, "without": without}


def known_from(options: dict[str, Any]) -> dict[str, Any]:
    """The arguments ``fix``, ``bounds`` and ``exclude``, taken out of a command's options."""
    from springpot.constraints import EVERY, bounds_of, own_of, values_of

    own, column = own_of(options.pop("own")), options.pop("population")
    if column is not None:
        own[EVERY] = column
    return {
        "fix": values_of(options.pop("fix")),
        "bounds": bounds_of(options.pop("bounds")),
        "tie": options.pop("tie"),
        "own": own,
        "share": (options.pop("share") or "").replace(",", " ").split(),
        "specimen": options.pop("specimen"),
        "exclude": options.pop("exclude"),
    }


accuracy_option = click.option(
    "--accuracy",
    metavar="TEXT",
    help="What the instrument promises of modulus and phase, such as '1%,3mrad': intervals hold it,"
    " and a misfit within it is no verdict on the model.",
)
verbose_option = click.option(
    "--verbose", "-v", is_flag=True, help="Everything that was found, not only what leads."
)


def window() -> int:
    """Columns of the terminal; a usual window where the text goes elsewhere."""
    from springpot.writing import NARROWEST, USUAL, WIDEST

    return max(NARROWEST, min(get_terminal_size((USUAL, USUAL)).columns, WIDEST))


def tell_written(*paths: Path | None, above: str = "\n") -> None:
    """Name the files that were asked for, each with what stands `above` it."""
    for path in filter(None, paths):
        print(f"{above}written: {path}")


def notes_of(notes: Iterable[str]) -> str:
    """Notes below an answer, broken at words to fit the window."""
    from springpot.report.text import wrapped

    return "\n".join(wrapped(f"note        {note}", window(), " " * 12) for note in notes)


def with_rows(named: str, chosen: str) -> str:
    """Data as a user named them, of which only the rows that have a condition are wanted."""
    from springpot.measurement.reader import is_file

    # A file may have an @ in its name; in what is no file it begins the conditions that were asked
    # for already.
    if "@" in named and not is_file(named):
        return f"{named},{chosen}"
    return f"{named}@{chosen}"


@contextmanager
def own_stdout(quiet: bool = False) -> Iterator[None]:
    """Let whatever foreign code prints go to standard error, or nowhere.

    Standard output is the command's own.
    """
    # What was printed before belongs to the command, and is written while that is where it goes.
    sys.stdout.flush()
    # Compiled code writes to the file descriptor, past `sys.stdout`.
    kept = os.dup(1)
    if quiet:
        other = os.open(os.devnull, os.O_WRONLY)
    else:
        other = os.dup(2)
    os.dup2(other, 1)
    try:
        with ExitStack() as stack:
            if quiet:
                # `sys.stdout` need not write to the descriptor: the demonstration, for one, keeps
                # what is printed.
                stack.enter_context(redirect_stdout(stack.enter_context(open(os.devnull, "w"))))
            yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(other)


def emit(result: Any, as_json: bool, show: Callable[[], None], line: bool = False) -> None:
    """Print `result` as JSON, or let `show` print it as text.

    Parameters
    ----------
    result : object
        What JSON is made of: dictionaries, lists, numbers, or an object with `to_dict`.
    as_json : bool
        The value of ``--json``.
    show : callable
        Prints the same for people.
    line : bool
        Whether it is one of several answers, each of which is a line, as programs read a stream of
        them.
    """
    if as_json:
        print_json(result, line)
    else:
        show()


def numbers(text: str) -> list[float]:
    """The numbers of ``1,5,10``, or those of a range ``0.1..100``.

    Raises
    ------
    click.UsageError
        If there are none.
    """
    from numpy import geomspace, nan

    first, dots, last = text.partition("..")
    try:
        if not dots:
            return [float(part) for part in text.split(",")]
        low, high = float(first), float(last)
    except ValueError:
        # Refused below, as a range that does not rise is.
        low = high = nan
    if not 0.0 < low < high < float("inf"):
        advice = "write numbers with commas, or a range such as 0.1..100"
        raise click.UsageError(f"'{text}': {advice}")
    spaced: list[float] = geomspace(low, high, SPACED).tolist()
    return spaced
