"""Optimisers that do harm, each in a way of its own, and an innocent one beside which they race."""

from __future__ import annotations

import atexit
import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from springpot import Measurement, Units, parse_model
from springpot.benchmark import Study
from springpot.identification import Card, Optimiser, Recorder
from springpot.measurement import DataSet

Deed = Callable[[Recorder, np.random.Generator], object]
DEADLINE = 2.0
"""Seconds: a hundred times what an innocent trial takes on a busy machine."""
LASTING = 600.0


@dataclass(frozen=True)
class Innocent(Optimiser):
    """A (1+1) random walk; its step tells one entrant from another."""

    step: float = 0.3

    name: ClassVar[str] = "innocent"
    card: ClassVar[Card] = Card("random walk")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        room, step = problem.upper - problem.lower, self.step
        x = problem.lower + rng.random(problem.dimension) * room
        best = problem(x)
        while True:
            y = np.clip(
                x + step * room * rng.standard_normal(problem.dimension),
                problem.lower,
                problem.upper,
            )
            value = problem(y)
            if value < best:
                x, best = y, value
            else:
                step *= 0.97


@dataclass(frozen=True)
class Faulty(Innocent):
    """The same, which does something unkind after three evaluations."""

    deed: str = ""

    name: ClassVar[str] = "faulty"

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        if budget > 1:
            for _ in range(3):
                problem(
                    problem.lower + rng.random(problem.dimension) * (problem.upper - problem.lower)
                )
            DEEDS[self.deed](problem, rng)
        super().minimise(problem, budget, rng)


class NoException(BaseException):
    """Nothing that a handler of exceptions catches."""


def throw(error: BaseException) -> Deed:
    def deed(problem: Recorder, rng: np.random.Generator) -> None:
        raise error

    return deed


def eat(problem: Recorder, rng: np.random.Generator) -> None:
    meal = []
    while True:
        meal.append(np.ones(2**24))


def spin(problem: Recorder, rng: np.random.Generator) -> None:
    while True:
        pass


def hold_the_lock(problem: Recorder, rng: np.random.Generator) -> None:
    sum(range(10**13))


def deaf(problem: Recorder, rng: np.random.Generator) -> None:
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    spin(problem, rng)


def dive(problem: Recorder, rng: np.random.Generator) -> None:
    dive(problem, rng)


def overflow(problem: Recorder, rng: np.random.Generator) -> None:
    sys.setrecursionlimit(10**8)
    dive(problem, rng)


def leave_a_program(problem: Recorder, rng: np.random.Generator) -> None:
    subprocess.Popen([sys.executable, "-c", f"import time; time.sleep({LASTING})"])


def leave_a_session(problem: Recorder, rng: np.random.Generator) -> None:
    subprocess.Popen(
        [sys.executable, "-c", f"import time; time.sleep({LASTING})"], start_new_session=True
    )
    time.sleep(LASTING)


def leave_an_orphan(problem: Recorder, rng: np.random.Generator) -> None:
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(LASTING)
        os._exit(0)
    os.wait()


def peek(problem: Recorder, rng: np.random.Generator) -> None:
    """It evaluates where nobody counts, and asks the recorder only for the best."""
    points = problem.lower + rng.random((5000, problem.dimension)) * (problem.upper - problem.lower)
    problem(points[problem.problem.evaluate(points).argmin()])


def leave_a_fork(problem: Recorder, rng: np.random.Generator) -> None:
    if os.fork() == 0:
        time.sleep(LASTING)
        os._exit(0)


def leave_a_thread(problem: Recorder, rng: np.random.Generator) -> None:
    threading.Thread(target=time.sleep, args=(LASTING,), daemon=True).start()


def leave_an_alarm(problem: Recorder, rng: np.random.Generator) -> None:
    signal.signal(signal.SIGALRM, throw_alarm)
    signal.alarm(1)


def leave_a_timer(problem: Recorder, rng: np.random.Generator) -> None:
    signal.signal(signal.SIGALRM, throw_alarm)
    signal.setitimer(signal.ITIMER_REAL, 0.05, 0.01)


def throw_alarm(*_: object) -> None:
    raise TimeoutError("an alarm that somebody left")


def patch_recorder(problem: Recorder, rng: np.random.Generator) -> None:
    Recorder.__call__ = lambda self, x: 0.0  # type: ignore[method-assign]
    time.sleep(0.01)
    raise ValueError("it has patched the recorder and fails")


def close_everything(problem: Recorder, rng: np.random.Generator) -> None:
    os.closerange(3, 256)


def write_everywhere(problem: Recorder, rng: np.random.Generator) -> None:
    for fd in range(256):
        try:
            os.write(fd, b"\0\0\0\4oops")
        except OSError:
            continue


def shout(problem: Recorder, rng: np.random.Generator) -> None:
    for _ in range(100):
        print("{}" * 200)
        os.write(1, b"]" * 200)
        warnings.warn("look at me", stacklevel=1)


def forget_modules(problem: Recorder, rng: np.random.Generator) -> None:
    for name in [name for name in sys.modules if name.startswith(("springpot", "numpy", "pickle"))]:
        del sys.modules[name]


def never_ask(problem: Recorder, rng: np.random.Generator) -> None:
    for _ in range(1000):
        problem(np.full(problem.dimension, np.nan))


def wrong_shape(problem: Recorder, rng: np.random.Generator) -> None:
    problem(np.zeros(problem.dimension + 3))


def swallow(problem: Recorder, rng: np.random.Generator) -> None:
    for _ in range(2000):
        try:
            problem(problem.lower + rng.random(problem.dimension) * (problem.upper - problem.lower))
        except BaseException:
            continue


DEEDS: dict[str, Deed] = {
    "segfault": lambda *_: ctypes.string_at(0),
    "abort": lambda *_: os.abort(),
    "success without a result": lambda *_: os._exit(0),
    "exit code 7": lambda *_: os._exit(7),
    "kill itself": lambda *_: os.kill(os.getpid(), signal.SIGKILL),
    "kill its group": lambda *_: os.killpg(0, signal.SIGKILL),
    "kill its parent": lambda *_: os.kill(os.getppid(), signal.SIGKILL),
    "stop itself": lambda *_: os.kill(os.getpid(), signal.SIGSTOP),
    "sys.exit": throw(SystemExit("enough")),
    "an error": throw(ValueError("out of\nspirits")),
    "Ctrl-C of its own": throw(KeyboardInterrupt()),
    "no exception": throw(NoException("neither")),
    "an end of generators": throw(GeneratorExit()),
    "eat memory": eat,
    "spin": spin,
    "sleep": lambda *_: time.sleep(LASTING),
    "hold the interpreter": hold_the_lock,
    "ignore signals": deaf,
    "recursion": dive,
    "overflow of the stack": overflow,
    "leave a program": leave_a_program,
    "leave a fork": leave_a_fork,
    "leave a session": leave_a_session,
    "leave an orphan": leave_an_orphan,
    "leave a thread": leave_a_thread,
    "leave an alarm": leave_an_alarm,
    "leave a timer": leave_a_timer,
    "clear sys.path": lambda *_: sys.path.clear(),
    "recursion limit": lambda *_: sys.setrecursionlimit(60),
    "raise on rounding": lambda *_: np.seterr(all="raise"),
    "another folder": lambda *_: os.chdir("/"),
    "clear the environment": lambda *_: os.environ.clear(),
    "patch the recorder": patch_recorder,
    "close all files": close_everything,
    "write into all files": write_everywhere,
    "shout": shout,
    "forget modules": forget_modules,
    "evaluate unseen": peek,
    "ask the user": lambda *_: input(),
    "ask for nothing finite": never_ask,
    "a point of another shape": wrong_shape,
    "swallow the end": swallow,
    "hang at exit": lambda *_: atexit.register(time.sleep, LASTING),
}
"""What each does, by name."""

TRUE = frozenset({"budget"})
"""Statuses of a trial whose numbers are right."""
TOLD = frozenset({"error", "invalid", "memory", "timeout", "crash"})


MARK = "SPRINGPOT_TEST_MARK"
"""Environment variable that a process and all its descendants share."""


def left_behind(mark: str) -> list[int]:
    """Processes that were started where `MARK` had this value, and still run."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (process / "environ").read_bytes().split(b"\0"):
                found.append(int(process.name))
        except OSError:
            continue  # it has ended meanwhile, or is somebody else's
    return found


def data() -> DataSet:
    """Noisy data of a fractional Kelvin element that know their truth."""
    truth = {"k": 100.0, "c": 60.0, "alpha": 0.5}
    model = parse_model("fractional-kelvin")
    omega = 2 * np.pi * np.geomspace(0.1, 10.0, 12)
    drawn = np.random.default_rng(5).standard_normal((2, len(omega)))
    stiffness = model.stiffness(model.theta(**truth), omega) * (
        1 + 0.02 * (drawn[0] + 1j * drawn[1])
    )
    measured = Measurement(omega, stiffness, units=Units("kN/m"), name="kelvin")
    return DataSet(
        "kelvin",
        "artificial",
        lambda: measured,
        kind="artificial",
        truth=truth,
        model="fractional-kelvin",
    )


def race(deeds: list[str], repetitions: int = 1) -> Study:
    """Innocent trials among those of faulty optimisers.

    At the beginning, in their midst and at the end.
    """
    faulty = [(f"faulty {deed}", Faulty(deed=deed)) for deed in deeds]
    half = len(faulty) // 2
    entrants = [
        ("innocent 1", Innocent(0.2)),
        *faulty[:half],
        ("innocent 2", Innocent(0.3)),
        *faulty[half:],
        ("innocent 3", Innocent(0.4)),
        ("innocent 4", Innocent(0.5)),
    ]
    return Study(
        "faulty",
        [data()],
        ["own"],
        ["paper"],
        entrants,
        repetitions=repetitions,
        budget=120,
        deadline=DEADLINE,
        memory=512,
    )
