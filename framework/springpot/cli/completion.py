"""What the shell offers behind TAB.

Names of models, effects, optimisers, objectives, and data sets beside files.

bash and zsh learn it by ``eval "$(_SPRINGPOT_COMPLETE=bash_source springpot)"`` (zsh_source), fish
by ``_SPRINGPOT_COMPLETE=fish_source springpot | source``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import click
from click.shell_completion import CompletionItem

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def names_of(word: str) -> Completer:
    """Completes the names of one kind of things."""

    def complete(
        context: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [CompletionItem(name) for name in _beginning(_names(word), incomplete)]

    return complete


def model_expression(
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


def data(
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
