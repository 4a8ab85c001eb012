"""The group of commands, each imported only when it is called, and what ends one.

A command is one module with a click command named `command`; the table here says where each lives
and its line in ``springpot --help``. Those of the core stand here; a guest such as the race brings
its own as a table of the same kind, named in the entry-point group ``springpot.commands``. Nothing
is imported from a command until it is called. Every error becomes one line on stderr and an exit
code.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NamedTuple

import click

from springpot import __version__
from springpot.errors import (
    LostStream,
    PluginError,
    SpringpotError,
    blamed,
    described,
    plain_streams,
)

GROUP = "springpot.commands"


class Entry(NamedTuple):
    """Where a command lives and what it does, in one line."""

    module: str
    summary: str


CORE: dict[str, Entry] = {
    "list": Entry(
        "springpot.cli.listing",
        "Models, optimisers, effects, data sets or readers that are installed.",
    ),
    "inspect": Entry(
        "springpot.cli.inspection", "What a file or data set holds: sweeps, ranges, units, origin."
    ),
    "signals": Entry(
        "springpot.cli.signals", "Time signals to dynamic stiffness, with its uncertainty."
    ),
    "identify": Entry(
        "springpot.cli.identify", "Parameters of a model from measurements, with their uncertainty."
    ),
    "compare": Entry(
        "springpot.cli.compare", "Models against one noise floor: how far off, where, how sure."
    ),
    "mastercurve": Entry(
        "springpot.cli.mastercurve", "Sweeps on one curve without a model: factors and laws."
    ),
    "diagnose": Entry("springpot.cli.diagnose", "Which physical effect is missing from a model."),
    "discover": Entry(
        "springpot.cli.discover", "Add missing effects one by one and watch the error fall."
    ),
    "invent": Entry(
        "springpot.cli.invent", "A law that is in no library: its formula, its class, its numbers."
    ),
    "predict": Entry(
        "springpot.cli.predict", "Another test, from an identified model, with a band."
    ),
    "init": Entry("springpot.cli.init", "Files to start from: a study, a plugin, a CI workflow."),
}


@cache
def commands() -> dict[str, Entry]:
    """All commands by name: those of the core, then those of the guests that are installed."""
    found = dict(CORE)
    for guest in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        for name, (module, summary) in _table(guest).items():
            # A guest adds commands and takes none away.
            found.setdefault(name, Entry(module, summary))
    return found


def _table(guest: EntryPoint) -> dict[str, tuple[str, str]]:
    """What a guest brings; one that cannot be loaded stands as a command that says why."""
    try:
        return dict(guest.load())
    # A guest is a plugin: whatever it raises is told by its name and must not take the other
    # commands down.
    except Exception as error:
        return {guest.name: ("", f"cannot be loaded: {type(error).__name__}: {error}")}


class LazyGroup(click.Group):
    """A click group that knows its commands by a table instead of importing them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of the table."""
        return list(commands())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, imported now."""
        entry = commands().get(cmd_name)
        if entry is None:
            return None
        # Of a guest that could not be loaded only the reason is there.
        if not entry.module:
            raise PluginError(f"'{cmd_name}' {entry.summary}")
        command: click.Command = import_module(entry.module).command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that the arguments name.

        Raises
        ------
        click.UsageError
            If there is none, with the nearest.
        """
        # Told as every unknown name is, with the nearest that there is.
        if args and args[0] not in commands() and not args[0].startswith("-"):
            hint = f"known are {', '.join(commands())}"
            near = get_close_matches(args[0], commands())
            if near:
                hint = f"did you mean {near[0]}?"
            raise click.UsageError(f"unknown command '{args[0]}': {hint}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands from the table, so that ``--help`` imports none of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, entry.summary) for name, entry in commands().items()])


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    epilog=(
        "'springpot COMMAND --help' shows an example of each. "
        "Exit codes: 0 done, 1 the answer is no, 2 bad input, 3 a fault in springpot."
    ),
)
@click.version_option(__version__, prog_name="springpot", message="%(prog)s %(version)s")
def springpot() -> None:
    """Identify viscoelastic models, find the missing physical effect, race optimisers fairly."""
    # Not above: ``--help`` writes nothing.
    from springpot.files import one_run

    # Before the command's arguments are looked at, among which are its inputs.
    click.get_current_context().with_resource(one_run())


def run(arguments: list[str]) -> int:
    """Run the command that `arguments` name; its exit code."""
    # The shell asks what fits: click's own machinery answers and ends the process.
    if "_SPRINGPOT_COMPLETE" in os.environ:
        springpot.main(arguments, "springpot")
    try:
        with (
            springpot.make_context("springpot", arguments or ["--help"]) as context,
            _located(context),
        ):
            answer: Any = springpot.invoke(context)
    # ``--help`` and ``--version`` end by an exception.
    except click.exceptions.Exit as leave:
        return leave.exit_code
    # Most commands return nothing: they are done, or have raised.
    if not isinstance(answer, int):
        return 0
    return answer


@contextmanager
def _located(context: click.Context) -> Iterator[None]:
    """Give usage errors that click's parser leaves without a command the one that was called."""
    try:
        yield
    except click.UsageError as error:
        name = context.invoked_subcommand
        if (
            error.ctx is None
            and name is not None
            and (command := springpot.get_command(context, name))
        ):
            error.ctx = click.Context(command, context, name)
        raise


# The last two as shells have them: 128 and the number of the signal.
BAD_INPUT, FAULT, INTERRUPTED, BROKEN_PIPE = 2, 3, 130, 141
TRACEBACK = "SPRINGPOT_TRACEBACK"


def exit_code(action: Callable[[], int]) -> int:
    """Run `action`; its exit code, or that of the error it ended in, which is told in one line.

    Nothing that is printed meanwhile can command the terminal.
    """
    with plain_streams():
        code = _exit_code(action)
    # Some library may have swallowed the KeyboardInterrupt; the handler remembers it.
    if _was_interrupted():
        return INTERRUPTED
    return code


def _was_interrupted() -> bool:
    """Whether Ctrl-C was pressed in this process, as its handler (`springpot.cli.CtrlC`) tells."""
    return getattr(signal.getsignal(signal.SIGINT), "pressed", False)


def _exit_code(action: Callable[[], int]) -> int:
    try:
        code = action()
        # Here, where a reader that has gone is still noticed as such.
        sys.stdout.flush()
        return code
    except SpringpotError as error:
        return _say(str(error), BAD_INPUT)
    except click.UsageError as error:
        return _say(_usage(error), BAD_INPUT)
    except click.ClickException as error:
        return _say(error.format_message(), BAD_INPUT)
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has gone; without this, Python complains when it flushes stdout on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return BROKEN_PIPE
    except LostStream as error:
        # What is still waiting to be written would fail again on the way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return _say(str(error.strerror), BAD_INPUT)
    # The last net: a user sees a line, never a traceback.
    except Exception as error:
        return _fault(error)


def _say(text: str, code: int) -> int:
    # A message of many lines, such as a library's, becomes one.
    print(f"springpot: {' '.join(text.split())}", file=sys.stderr)
    return code


def _usage(error: click.UsageError) -> str:
    """Click's message as one line, with the command whose help says more."""
    command = "springpot"
    if error.ctx:
        command = error.ctx.command_path
    if isinstance(error, click.exceptions.NoArgsIsHelpError) and isinstance(
        error.ctx.command, click.Group
    ):
        return (
            f"'{command}' needs one of {', '.join(error.ctx.command.commands)} (see '{command}"
            " --help')"
        )
    text, beside = error.format_message().rstrip("."), ""
    # Who has no model has nothing to type there, and a command that finds one.
    if isinstance(error, click.MissingParameter) and error.param and error.param.name == "model":
        beside = "; 'springpot compare DATA' ranks the models"
    return f"{text[:1].lower()}{text[1:]} (see '{command} --help'{beside})"


def _fault(error: Exception) -> int:
    if _was_interrupted():
        # What a half-imported library makes of Ctrl-C is no fault to be reported.
        return INTERRUPTED
    if os.environ.get(TRACEBACK):
        # Only for who asks: users see one line.
        import traceback

        traceback.print_exception(error)
        return FAULT
    if told := blamed(error):
        return _say(
            f"{told}: leave out what it offers, or uninstall it ({TRACEBACK}=1 shows more)",
            BAD_INPUT,
        )
    return _say(
        f"a fault in springpot or one of its plugins, not in your input: {described(error)} "
        f"(please report it with the traceback that {TRACEBACK}=1 shows)",
        FAULT,
    )
