"""The command to go on with: what changed the meaning of the data goes along."""

from __future__ import annotations

from typing import Any

import click
from click.core import ParameterSource

from springpot import writing

MEANING = (
    "geometry",
    "fix",
    "bounds",
    "tie",
    "exclude",
    "own",
    "share",
    "specimen",
    "population",
    "effects",
    "effect",
    "without",
    "along",
    "accuracy",
    "robust",
    "seed",
)
"""Options by which the same files give another answer; those of outputs are none."""


def suggested(verb: str, *words: object) -> str:
    """A command of springpot with the options of this one that it takes and that change its answer.

    Parameters
    ----------
    verb : str
        See `springpot.writing.suggested`.
    *words : object
        Data and options that follow from the answer.
    """
    return writing.suggested(verb, *words, *kept_by(verb))


def kept_by(verb: str) -> list[str]:
    """Options, with their values, that were given to this command and that another takes too."""
    context = click.get_current_context(silent=True)
    if context is None:
        return []
    group = context.find_root().command
    other = group.get_command(context, verb) if isinstance(group, click.Group) else None
    taken = {each.name for each in other.params} if other is not None else set()
    words: list[str] = []
    for option in context.command.params:
        name = option.name or ""
        given = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if name in MEANING and name in taken and given:
            words += _words(option.opts[-1], context.params[name])
    return words


def _words(option: str, value: Any) -> list[str]:
    values = value if isinstance(value, (tuple, list)) else [value]
    return [word for each in values for word in (option, str(each))]
