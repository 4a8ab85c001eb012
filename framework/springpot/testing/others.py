"""The contracts of an optimiser and of a reader.

An optimiser is tried on a problem with four parameters whose answer is known. A reader never
crashes, whatever a file holds, and what it writes it reads back.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from springpot.errors import SpringpotError
from springpot.identification.problem import Objective, Problem, watched
from springpot.identification.runs import (
    BatchedOptimiser,
    Optimiser,
    Run,
    options_of,
    run,
    run_batch,
)
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import HEAD
from springpot.measurement.reader import Choice, Reader
from springpot.measurement.signals import Signals
from springpot.measurement.units import Units
from springpot.rheology.points import Real

from ..numerics import ALIKE
from .networks import (
    CONTRACT,
    SAMPLE,
    complaints,
    kept_random_state,
    name_and_summary,
    sample_measurement,
)

TRUTH = np.array([600.0, 400.0, 150.0, 0.6])
"""Those of the paper, section 5.1, in kN/m and s."""

EQUAL = Objective("sample", "plain squares", lambda data: np.full(data.stiffness.shape, 1.0 + 1.0j))


def check_optimiser(
    optimiser: type[Optimiser], *, skip: Collection[str] = (), deadline: float = CONTRACT.deadline
) -> list[str]:
    """What is wrong with an optimiser, as plain sentences.

    Aspects: ``words`` (name and card), ``options`` (frozen, documented, plain values), ``budget``
    (runs to its end without a fault), ``repeatable`` (same seed, same bits; the process-wide random
    state has no part in it), ``box`` (no point outside), ``improves``, ``faults`` (an error of the
    model is not swallowed), ``gradient`` (used if, and only if, the card says so) and ``batch`` (as
    single runs).

    Parameters
    ----------
    optimiser : type of Optimiser
        The class; its default instance is tried.
    skip : collection of str
        Aspects to leave out.
    deadline : float
        Seconds that all aspects together may take: one that hangs is named then.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(optimiser.name, optimiser.card.summary),
        "options": lambda: _options(optimiser),
        "budget": lambda: _budget(optimiser()),
        "repeatable": lambda: _repeatable(optimiser()),
        "box": lambda: _box(optimiser()),
        "improves": lambda: _improves(optimiser()),
        "faults": lambda: _faults(optimiser()),
        "gradient": lambda: _gradient(optimiser()),
        "batch": lambda: _batch(optimiser()),
    }
    return complaints(aspects, skip, deadline)


def sample_problem() -> Problem:
    """Exact data of the sample model at 14 frequencies, in kN/m."""
    omega = 2.0 * np.pi * np.arange(0.5, 14.0)
    data = Measurement(
        omega, SAMPLE.stiffness(TRUTH, omega), units=Units("kN/m", "mm"), name="sample"
    )
    return Problem.of(SAMPLE, data, EQUAL, 1000.0)


def _run(
    optimiser: Optimiser, budget: int, seed: int = CONTRACT.seed, problem: Problem | None = None
) -> Run:
    return run(optimiser, problem or sample_problem(), budget, np.random.default_rng(seed))


def _options(optimiser: type[Optimiser]) -> Iterator[str]:
    made = optimiser()
    if not is_dataclass(made):
        yield (
            "it is no dataclass, so that its options cannot be listed: decorate it with"
            " @dataclass(frozen=True)"
        )
        return
    # Called for what it raises: options that are no plain values cannot be kept with a trial.
    options_of(made)
    described = "".join(kind.__doc__ or "" for kind in optimiser.__mro__)
    for option in fields(made):
        # A dataclass without a docstring is given its signature for one: only a described name
        # counts.
        if not re.search(rf"(?m)^.*\b{option.name}\b.* : ", described):
            yield f"option {option.name} is not described in the docstring"
        try:
            setattr(made, option.name, getattr(made, option.name))
        except FrozenInstanceError:
            continue
        yield (
            f"option {option.name} can be changed: decorate the class with @dataclass(frozen=True)"
        )


def _budget(optimiser: Optimiser) -> Iterator[str]:
    for budget in (1, 2, 9, 57):
        outcome = _run(optimiser, budget)
        if outcome.failed:
            yield (
                f"with a budget of {budget} it ends as '{outcome.status}' after"
                f" {outcome.evaluations} evaluations"
            )


def _same(one: Run, other: Run) -> bool:
    # By their bytes: the same to the last bit, which comparing numbers would not tell of nan or of
    # -0.0.
    same_end = one.theta.tobytes() == other.theta.tobytes()
    return same_end and one.status == other.status and one.trace == other.trace


def _repeatable(optimiser: Optimiser) -> Iterator[str]:
    runs = []
    # Two states of the process, one generator: only what draws from elsewhere differs.
    for seed in (1, 2):
        with kept_random_state():
            np.random.seed(seed)  # noqa: NPY002
            runs.append(_run(optimiser, 150))
    if not _same(*runs):
        yield "two runs with the same generator differ: every random number must come from rng"
    depends = _run(optimiser, 150, seed=1).trace != _run(optimiser, 150, seed=2).trace
    if depends and not optimiser.card.stochastic:
        yield "it depends on the generator, but its card says stochastic=False"
    if not depends and optimiser.card.stochastic:
        yield "it does not depend on the generator: say stochastic=False on its card"


def _box(optimiser: Optimiser) -> Iterator[str]:
    low, high = np.full(4, np.inf), np.full(4, -np.inf)

    def watch(x: Real) -> None:
        np.fmin(low, x.min(axis=0), out=low)
        np.fmax(high, x.max(axis=0), out=high)

    problem = watched(sample_problem(), watch)
    outcome = _run(optimiser, CONTRACT.long, problem=problem)
    if outcome.failed:
        yield f"the run ends as '{outcome.status}'"
    # Rounding may put a point that was meant for the edge a little beyond it.
    room = ALIKE * (problem.upper - problem.lower)
    for i, name in enumerate(problem.space.names):
        if low[i] < problem.lower[i] - room[i]:
            yield (
                f"it asks for {name} = {low[i]:.6g} below the box,"
                f" which begins at {problem.lower[i]:.6g}"
            )
        if high[i] > problem.upper[i] + room[i]:
            yield (
                f"it asks for {name} = {high[i]:.6g} above the box,"
                f" which ends at {problem.upper[i]:.6g}"
            )


def _improves(optimiser: Optimiser) -> Iterator[str]:
    problem = sample_problem()
    centre = float(problem.evaluate(0.5 * (problem.lower + problem.upper)))
    # Of three, as one run of a search by chance may be unlucky.
    best = min(_run(optimiser, CONTRACT.long, seed).best for seed in (1, 2, 3))
    if not best < CONTRACT.better * centre:
        yield (
            f"the best of three runs of {CONTRACT.long} evaluations is {best / centre:.2g} of the"
            " value at the box's centre"
        )


def _faults(optimiser: Optimiser) -> Iterator[str]:
    calls = 0

    def fail(x: Real) -> None:
        nonlocal calls
        calls += 1
        if calls > 5:
            raise ZeroDivisionError("the model fails")

    outcome = _run(optimiser, CONTRACT.long, problem=watched(sample_problem(), fail))
    # Some end by themselves before the sixth call, and have met no error.
    if not outcome.status.startswith("failed: ZeroDivisionError") and calls > 5:
        yield f"an error of the model is swallowed: the run ends as '{outcome.status}'"


def _gradient(optimiser: Optimiser) -> Iterator[str]:
    used = _run(optimiser, CONTRACT.long).gradients > 0
    if used != optimiser.card.gradient:
        does = "does not use"
        if used:
            does = "uses"
        yield f"it {does} derivatives, but its card says gradient={optimiser.card.gradient}"


def _batch(optimiser: Optimiser) -> Iterator[str]:
    if isinstance(optimiser, BatchedOptimiser) != optimiser.card.batched:
        yield "its card must say batched=True if, and only if, it is a BatchedOptimiser"
    if not isinstance(optimiser, BatchedOptimiser):
        return
    seeds = range(3)
    together: list[Any] = run_batch(
        optimiser, sample_problem(), 130, [np.random.default_rng(s) for s in seeds]
    )
    for seed, one in zip(seeds, together, strict=True):
        if not _same(one, _run(optimiser, 130, seed)):
            yield f"run {seed + 1} of a batch of three differs from the same run alone"


TABLE = b"frequency [Hz],storage [kN/m],loss [kN/m]\n"
PIECES = (
    *(bytes([i]) for i in (0, 9, 10, 13, 44, 59, 34, 35, 255)),
    b"1",
    b"-2.5",
    b"1e999",
    b"nan",
    b"[",
    b"{",
    TABLE,
)
EXTRAS = ("sd", "conditions", "repeat", "harmonics", "labels")


def check_reader(
    reader: Reader, samples: Sequence[Path | bytes] = (), *, skip: Collection[str] = ()
) -> list[str]:
    """What is wrong with a reader, as plain sentences.

    Aspects: ``words``, ``samples`` (they are recognised and read), ``garbage`` (random bytes and
    damaged samples are read or refused in one line, never a crash), ``choice`` (a part or column
    that the file does not have is refused, not passed over) and ``round-trip`` (what ``text``
    writes is recognised and read back as the same bits; columns that the format cannot hold are
    refused, never dropped).

    Parameters
    ----------
    reader : Reader
        The reader.
    samples : sequence of Path or bytes
        Files in its format, or their content; needed where it cannot write one itself.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    given = [_content(sample) for sample in samples]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "sample.dat"
        aspects = {
            "words": lambda: name_and_summary(reader.name, reader.summary),
            "samples": lambda: _samples(reader, given, path),
            "garbage": lambda: _garbage(reader, given, path),
            "choice": lambda: _choice(reader, given, path),
            "round-trip": lambda: _round_trip(reader, path),
        }
        return complaints(aspects, skip)


def _content(sample: Path | bytes) -> bytes:
    if isinstance(sample, bytes):
        return sample
    return Path(sample).read_bytes()


def _actions(reader: Reader) -> list[tuple[str, type, Callable[[Path, Choice], Any]]]:
    actions: list[tuple[str, type, Callable[[Path, Choice], Any]]] = [
        ("read", Measurement, reader.read)
    ]
    if reader.signals is not None:
        actions.append(("signals", Signals, reader.signals))
    return actions


def _samples(reader: Reader, samples: list[bytes], path: Path) -> Iterator[str]:
    if not samples and reader.text is None:
        yield "it writes no files and there are no samples: give at least one"
    for i, sample in enumerate(samples):
        path.write_bytes(sample)
        if not 0.0 < reader.recognises(sample[:HEAD]) <= 1.0:
            yield f"sample {i + 1} is not recognised"
        refused = []
        for name, expected, action in _actions(reader):
            try:
                if not isinstance(action(path, Choice()), expected):
                    yield f"{name} of sample {i + 1} gives no {expected.__name__}"
            except SpringpotError as error:
                refused.append(f"{name}: {error}")
        # A file of signals is no table, nor the other way round: one of the two is enough.
        if len(refused) == len(_actions(reader)):
            yield f"sample {i + 1} is refused: {'; '.join(refused)}"


def _files(samples: list[bytes]) -> Iterator[bytes]:
    rng = np.random.default_rng(CONTRACT.seed)
    # An empty file, as an export that was interrupted leaves it.
    yield b""
    for _ in range(CONTRACT.random_files):
        yield rng.bytes(int(rng.integers(1, 2000)))
        yield b"".join(PIECES[i] for i in rng.integers(0, len(PIECES), 30))
    for sample in [whole[: CONTRACT.damaged] for whole in samples if whole]:
        for _ in range(CONTRACT.random_files):
            # Cut off, then with bytes that are wrong: what a broken transfer and a broken disk make
            # of a file.
            yield sample[: rng.integers(len(sample))]
            damaged = bytearray(sample)
            for place in rng.integers(len(sample), size=3):
                damaged[place] = rng.integers(256)
            yield bytes(damaged)


def _garbage(reader: Reader, samples: list[bytes], path: Path) -> Iterator[str]:
    samples = samples or [_text(reader, sample_measurement()) or TABLE]
    # The same fault would be told for dozens of random files.
    seen = set()
    for content in _files(samples):
        path.write_bytes(content)
        for says in _complaints_about(reader, content, path):
            if says not in seen:
                seen.add(says)
                yield f"{says} (a file that begins {content[:30]!r})"


def _complaints_about(reader: Reader, content: bytes, path: Path) -> Iterator[str]:
    try:
        confidence = reader.recognises(content[:HEAD])
        if not 0.0 <= confidence <= 1.0:
            yield f"recognises gives {confidence!r}, not a number from 0 to 1"
    except Exception as error:
        yield f"recognises raises {type(error).__name__}"
    for name, expected, action in _actions(reader):
        try:
            if not isinstance(action(path, Choice()), expected):
                yield f"{name} gives no {expected.__name__}"
        except SpringpotError as error:
            # The line is all that a user gets to see.
            if "\n" in str(error) or not str(error):
                yield f"{name} must refuse in one line that says why"
        except Exception as error:
            yield f"{name} raises {type(error).__name__}, not DataError"


def _choice(reader: Reader, samples: list[bytes], path: Path) -> Iterator[str]:
    asked = {
        "part": Choice(part="no such part"),
        "column": Choice(columns={"no such column": "Hz"}),
    }
    for sample in [*samples, _text(reader, sample_measurement())][:1]:
        path.write_bytes(sample)
        for what, choice in asked.items():
            try:
                reader.read(path, choice)
            except SpringpotError:
                continue
            yield f"a {what} that the file does not have is passed over: refuse it with DataError"


def _text(reader: Reader, measurement: Measurement) -> bytes:
    if reader.text is None:
        return b""
    return reader.text(_bare(measurement)).encode()


def _bare(measurement: Measurement) -> Measurement:
    # Conditions are an extra: a format of frequency, storage and loss alone is a format.
    return replace(measurement, conditions={})


def _versions() -> Iterator[tuple[str, Measurement]]:
    full, n = sample_measurement(), len(sample_measurement())
    bare, rng = _bare(full), np.random.default_rng(CONTRACT.seed)
    yield "plain data", bare
    # Up to e^500, and down to its inverse: as text they need all their digits, and an exponent.
    yield (
        "numbers of any size",
        replace(bare, stiffness=bare.stiffness * np.exp(rng.uniform(-500, 500, n))),
    )
    yield "standard deviations", replace(bare, sd=bare.stiffness / 7)
    yield "amplitude and temperature", full
    yield "repeats", replace(bare, repeat=np.arange(n))
    yield (
        "harmonics",
        replace(bare, harmonics=(rng.normal(size=(n, 2)) * (1 + 2j)).astype(np.complex128)),
    )
    # With a comma and quotation marks, which part a cell in two where they are not guarded.
    yield (
        "labels",
        replace(bare, labels={"specimen": np.array([f"{i}, or 'so'" for i in range(n)])}),
    )


def _round_trip(reader: Reader, path: Path) -> Iterator[str]:
    if reader.text is None:
        return
    for what, measurement in _versions():
        try:
            text = reader.text(measurement)
        except SpringpotError as error:
            # Only what the format was not made for may be refused.
            if what in ("plain data", "numbers of any size"):
                yield f"{what} cannot be written: {error}"
            continue
        path.write_bytes(text.encode())
        if not reader.recognises(text.encode()[:HEAD]) > 0:
            yield f"{what}: what it writes is not recognised"
        for name in _differences(measurement, reader.read(path, Choice())):
            yield f"{what}: {name} is not read back as the same bits"


def _differences(one: Measurement, other: Measurement) -> Iterator[str]:
    if one.units.stiffness != other.units.stiffness:
        yield "the unit"
    for name in ("omega", "stiffness", *EXTRAS):
        a, b = getattr(one, name), getattr(other, name)
        pairs = [(a, b)]
        if name in ("conditions", "labels"):
            pairs = [(a.get(key), b.get(key)) for key in {*a, *b}]
        for left, right in pairs:
            if (left is None) != (right is None) or (
                left is not None and not np.array_equal(left, right)
            ):
                yield name
