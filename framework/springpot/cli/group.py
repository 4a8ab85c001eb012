"""The group of commands, each imported only when it is called.

The commands: where each lives and its line in ``springpot --help``.

A command is one module with a click command named `command`. Those of the core stand here; a guest
such as the race brings its own as a table of the same kind, named in the entry-point group
``springpot.commands``. Nothing is imported from a command until it is called.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NamedTuple

import click

from springpot import __version__
from springpot.errors import PluginError

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


CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


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
    context_settings=CONTEXT,
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
