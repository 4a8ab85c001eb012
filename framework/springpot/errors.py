"""Errors that a user can mend; each is one line and ends a command with exit code 2."""

from __future__ import annotations

from .terminal_safe import plain

LONGEST_REASON = 300
"""Signs of a reason that are kept: the message of an error may hold whole arrays."""


class SpringpotError(Exception):
    """Something the user gave cannot be used: one line that says what, where and how to mend it."""

    def __str__(self) -> str:
        # Names of files and words in them come from strangers, and an error ends on a terminal.
        return plain(super().__str__())


class DataError(SpringpotError):
    """A file, data set or column cannot be used."""


class ModelError(SpringpotError):
    """A model, effect or expression is unknown or does not fit the data."""


class PluginError(SpringpotError):
    """A plugin is missing, faulty or clashes with another."""


class OutputError(SpringpotError):
    """A result cannot be written where it was wanted, or a library needed for it is missing."""


class OptionError(SpringpotError):
    """An option of an optimiser or of a run is out of its range."""


class StudyError(SpringpotError):
    """A study, its script or its store cannot be used."""
