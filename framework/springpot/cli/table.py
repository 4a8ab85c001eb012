"""The commands: where each lives and its line in ``springpot --help``.

A command is one module with a click command named `command`. Those of the core stand here; a guest
such as the race brings its own as a table of the same kind, named in the entry-point group
``springpot.commands``. Nothing is imported from a command until it is called.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import NamedTuple

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
