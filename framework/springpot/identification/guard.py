"""A run of an optimiser in a process of its own: whatever it does there ends there, and is told."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from select import select
from time import monotonic
from typing import NoReturn

import numpy as np

from .optimiser import Optimiser
from .problem import Searched
from .record import contradiction
from .run import Run, run

DEADLINE = 300.0
"""Seconds of a run, as in a study."""
MEMORY = 2048
"""MiB that a run may take, as in a study."""


def guarded(optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator) -> Run:
    """`run` in a process of its own; a crash, a hang or a forged record is a run that failed.

    The process is a copy of this one. Where other threads run here, that would not be safe, and the run takes place
    in this process; its record is checked all the same.

    Parameters
    ----------
    optimiser, problem, budget, rng
        As for `run`.
    """
    # A copy holds this thread alone: a lock that another one held would stay locked in it for ever.
    if threading.active_count() > 1 or not hasattr(os, "fork"):
        outcome = run(optimiser, problem, budget, rng)
    else:
        outcome = _elsewhere(optimiser, problem, budget, rng)
    if outcome.failed:
        return outcome
    wrong = contradiction(outcome, problem, budget)
    if wrong:
        return _failure(optimiser, problem, wrong)
    return outcome


def _failure(optimiser: Optimiser, problem: Searched, reason: str) -> Run:
    nowhere = np.full(problem.dimension, np.nan)
    theta = np.full(len(problem.space.model.names), np.nan)
    return Run(optimiser.name, f"failed: {reason}", np.inf, nowhere, theta, 0, 0, 0.0, ())


def _elsewhere(optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator) -> Run:
    from springpot.processes import cause_of, end_group

    answer, report = os.pipe()
    lifeline, alive = os.pipe()
    sys.stdout.flush()  # or both would write what waits there
    # Ctrl-C reaches both: until each has come to where it ends in order, it waits.
    had = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        # A copy and no fresh process: model and data are there without being sent.
        pid = os.fork()
    except OSError:
        signal.pthread_sigmask(signal.SIG_SETMASK, had)
        raise
    if pid == 0:
        os.close(answer)
        os.close(alive)
        _work(optimiser, problem, budget, rng, report, lifeline)
    try:
        os.close(report)
        os.close(lifeline)
        signal.pthread_sigmask(signal.SIG_SETMASK, had)
        message = _read(answer, monotonic() + DEADLINE)
    finally:
        end_group(pid)
        status = os.waitpid(pid, 0)[1]
        os.close(answer)
        os.close(alive)
    if message is None:
        return _failure(optimiser, problem, f"it did not end within {DEADLINE:g} s")
    try:
        outcome = pickle.loads(message)
    except Exception:
        # What was cut short or never was a run tells nothing: how the process ended is told instead.
        outcome = None
    if isinstance(outcome, Run):
        return outcome
    return _failure(optimiser, problem, cause_of(status))


def _read(fd: int, end: float) -> bytes | None:
    """All that is written until the other side closes; None if that takes too long."""
    parts: list[bytes] = []
    while select([fd], [], [], max(0.0, end - monotonic()))[0]:
        part = os.read(fd, 1 << 16)
        if not part:
            return b"".join(parts)
        parts.append(part)
    return None


def _work(
    optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator, report: int, lifeline: int
) -> NoReturn:
    """In the child: run, and send what came of it."""
    from springpot.processes import adopt_orphans, end_children, limit_memory

    code = 1
    try:
        # A group of its own: whatever the optimiser starts can be ended with it, and Ctrl-C does not reach it.
        os.setsid()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        adopt_orphans()
        # What an optimiser prints is no part of the command's own output, and what is typed or piped is not for it.
        os.dup2(2, 1)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        limit_memory(MEMORY)
        # If the process that waits is killed, nobody else would end this one.
        threading.Thread(target=_die_with_parent, args=(lifeline,), daemon=True).start()
        try:
            outcome = run(optimiser, problem, budget, rng)
        except BaseException as error:
            # Nothing interrupts this process from outside: whatever it is, the optimiser raised it.
            outcome = _failure(optimiser, problem, f"{type(error).__name__}: {error}")
        end_children()
        with os.fdopen(report, "wb") as stream:
            pickle.dump(outcome, stream)
        sys.stdout.flush()
        code = 0
    finally:
        # Without the parent's own farewell: its open files and its exit handlers are not this copy's.
        os._exit(code)


def _die_with_parent(lifeline: int) -> None:
    os.read(lifeline, 1)
    os.killpg(0, 9)
