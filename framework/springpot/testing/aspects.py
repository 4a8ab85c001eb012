"""A contract is a set of aspects, functions that yield sentences; running it never raises."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias

import numpy as np

from springpot.processes import can_copy, elsewhere

DEADLINE = 120.0
"""Seconds in which a plugin must have shown all that is asked of it.

The slowest of springpot's own take five.
"""
Aspect: TypeAlias = Callable[[], Iterable[str]]

NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*(-N)?")
SEED = 20240607
"""Of whatever is drawn: a contract that holds once holds again."""
LONGEST = 160
"""Characters of a summary that still fit a listing."""


def complaints(
    aspects: Mapping[str, Aspect], skip: Collection[str] = (), deadline: float = DEADLINE
) -> list[str]:
    """What is wrong, each sentence preceded by its aspect; empty if nothing is.

    It is looked at in a copy of this process, in which a plugin may crash or hang; where threads
    run here, in this process and without a limit.

    Parameters
    ----------
    aspects : mapping of str to callable
        The contract.
    skip : collection of str
        Aspects that are left out.
    deadline : float
        Seconds that all aspects together may take.
    """
    unknown = sorted(set(skip) - set(aspects))
    # A skip that is misspelt would leave its author in the belief that it is one.
    if unknown:
        return [f"skip: there is no aspect '{unknown[0]}': known are {', '.join(aspects)}"]
    wanted = {name: aspect for name, aspect in aspects.items() if name not in skip}
    # Nothing wrong, because nothing was looked at, must not pass.
    if not wanted:
        return ["skip: every aspect is left out, so nothing was checked"]
    if not can_copy():
        return [f"{name}: {says}" for name, aspect in wanted.items() for says in _run(aspect)]
    ended = elsewhere(lambda report: _report(wanted, report), deadline)
    told = [
        json.loads(line) for line in ended.message.splitlines(keepends=True) if line.endswith(b"\n")
    ]
    sentences = [f"{name}: {says}" for name, found in told for says in found]
    # The first that has not answered is the one under way.
    for name in list(wanted)[len(told) :][:1]:
        reason = ended.cause
        if ended.late:
            reason = f"does not end: all aspects together may take {deadline:g} s"
        sentences.append(f"{name}: {reason}")
    return sentences


def _report(wanted: Mapping[str, Aspect], report: Callable[[bytes], object]) -> None:
    for name, aspect in wanted.items():
        report(json.dumps((name, _run(aspect))).encode() + b"\n")


def _run(aspect: Aspect) -> list[str]:
    sentences: list[str] = []
    with kept_random_state() as touched, np.errstate(all="ignore"):
        try:
            sentences.extend(aspect())
        except (Exception, SystemExit) as error:
            # What was said before it stays said; a plugin may also call sys.exit.
            sentences.append(f"raises {type(error).__name__}: {' '.join(str(error).split())}")
        if touched():
            sentences.append(
                "changes the process-wide random state:"
                " draw only from the generator that is handed in"
            )
    return sentences


@contextmanager
def kept_random_state() -> Iterator[Callable[[], bool]]:
    """Put the process-wide random states back at the end.

    Gives a function that tells whether they have changed.
    """
    before = np.random.get_state(legacy=False)  # noqa: NPY002  it is what is watched
    own = random.getstate()

    def touched() -> bool:
        now = np.random.get_state(legacy=False)  # noqa: NPY002
        # As text: the states hold arrays, which have no single answer to whether they are equal.
        return repr(now) != repr(before) or random.getstate() != own

    try:
        yield touched
    finally:
        np.random.set_state(before)  # noqa: NPY002
        random.setstate(own)


def name_and_summary(name: str, summary: str, aliases: Iterable[str] = ()) -> Iterator[str]:
    """Sentences about what users type and read."""
    for word in (name, *aliases):
        if not NAME.fullmatch(word):
            yield (
                f"'{word}' must be lower-case words, digits and hyphens,"
                " such as 'fractional-maxwell'"
            )
    if len(summary.split()) < 2 or "\n" in summary or len(summary) > LONGEST:
        yield (
            f"the summary must be one sentence of at most {LONGEST} characters, not {summary!r:.60}"
        )
    elif summary.endswith("."):
        yield "the summary ends with a full stop, which a listing does not need"


def cited(citation: str) -> Iterator[str]:
    """A sentence if there is no source."""
    if not citation.strip():
        yield (
            "there is no citation: say where the equation or the numbers come from,"
            " with a DOI where there is one"
        )
