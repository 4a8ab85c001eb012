"""The contract of a reader.

It never crashes, whatever a file holds, and what it writes it reads back.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from springpot.errors import SpringpotError
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import HEAD
from springpot.measurement.reader import Choice, Reader
from springpot.measurement.signals import Signals

from .networks import CONTRACT, complaints, name_and_summary, sample_measurement

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
