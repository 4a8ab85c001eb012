"""A fuzzer of structure.

Files whose parts are repeated, nested, padded and widened, rather than spoilt byte by byte.

What takes a machine is seldom a wrong byte; it is a right one a million times. Seeds are the small
files of every layout that the readers' tests are made of.
"""

from __future__ import annotations

import io
import signal
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from opening_cost import Cost, cost_of, parts_cost
from readers.test_fuzz import SEEDS

SHEET = "xl/worksheets/sheet1.xml"
PADDING = (
    b" ",
    b"\t",
    b"\n",
    b"\r\n",
    b"\0",
    b"#",
    b"# x\n",
    b",",
    b";",
    b'"',
    b"0",
    b"-",
    b"x",
    b"\xc2\xa0",
    b"=",
    b"_",
)
BRACKETS = (
    (b"[", b"]"),
    (b"(", b")"),
    (b"{", b"}"),
    (b'"', b'"'),
    (b'{"Procedure":', b"}"),
    (b"<c><is>", b"</is></c>"),
)
HANGS = 4.0
"""Times its budget after which a reading that could not be ended is broken off from outside."""


def often(rng: np.random.Generator, unit: int, most: int) -> int:
    """How often to say `unit` bytes: of all orders of magnitude, within so many bytes."""
    return max(1, min(int(2 ** rng.uniform(1, 21)), most // max(unit, 1)))


def span(content: bytes, rng: np.random.Generator) -> slice:
    """A part of a file: a few bytes, or some whole lines."""
    start = int(rng.integers(0, max(len(content), 1)))
    if rng.random() < 0.5:
        return slice(start, start + int(rng.integers(1, 40)))
    first = content.rfind(b"\n", 0, start) + 1
    last = first
    for _ in range(int(rng.integers(1, 8))):
        last = content.find(b"\n", last) + 1 or len(content)
    return slice(first, last)


def repeat(content: bytes, rng: np.random.Generator, most: int) -> bytes:
    """A part, again and again."""
    part = span(content, rng)
    piece = content[part]
    return content[: part.start] + piece * often(rng, len(piece), most) + content[part.stop :]


def nest(content: bytes, rng: np.random.Generator, most: int) -> bytes:
    """A part within brackets within brackets, which may not close."""
    part = span(content, rng)
    opening, closing = BRACKETS[rng.integers(len(BRACKETS))]
    depth = often(rng, len(opening) + len(closing), most)
    closed = closing * (depth if rng.random() < 0.7 else 0)
    return content[: part.start] + opening * depth + content[part] + closed + content[part.stop :]


def pad(content: bytes, rng: np.random.Generator, most: int) -> bytes:
    """Much of nothing: at one place, or behind every line."""
    filling = PADDING[rng.integers(len(PADDING))]
    if rng.random() < 0.3:
        lines = content.split(b"\n")
        return (filling * often(rng, len(filling) * len(lines), most) + b"\n").join(lines)
    place = int(rng.integers(0, len(content) + 1)) if rng.random() < 0.7 else 0
    return content[:place] + filling * often(rng, len(filling), most) + content[place:]


def widen(content: bytes, rng: np.random.Generator, most: int) -> bytes:
    """Every line more often beside itself."""
    separator = (b",", b";", b"\t", b" ")[rng.integers(4)]
    lines = content.split(b"\n")[: int(rng.integers(2, 40))]
    times = often(rng, sum(map(len, lines)) + len(lines), most)
    return b"\n".join(separator.join([line] * times) for line in lines)


OPERATIONS: dict[str, Callable[[bytes, np.random.Generator, int], bytes]] = {
    "repeat": repeat,
    "nest": nest,
    "pad": pad,
    "widen": widen,
}


def _in_workbook(content: bytes, change: Callable[[bytes], bytes]) -> bytes:
    """A workbook with its sheet changed, so that it is still a workbook."""
    stream = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(content)) as old,
        zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for entry in old.infolist():
            inner = old.read(entry)
            new.writestr(entry.filename, change(inner) if entry.filename == SHEET else inner)
    return stream.getvalue()


def _compressed(content: bytes, change: Callable[[bytes], bytes]) -> bytes:
    """A MATLAB file with its elements changed and packed again, so that it is still one."""
    packed = zlib.compress(change(content[128:]))
    return content[:128] + (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed


def changed(
    name: str, content: bytes, change: Callable[[bytes], bytes], rng: np.random.Generator
) -> bytes:
    """The file of a reader after a change: of what is packed in it, where it is packed."""
    if name == "excel":
        return _in_workbook(content, change)
    if name == "signals-mat" and rng.random() < 0.7:
        return _compressed(content, change)
    return change(content)


def made(operation: str, rng: np.random.Generator, most: int) -> tuple[str, bytes]:
    """A reader's name and a file in its format after one to three operations, the first given."""
    name = sorted(SEEDS)[rng.integers(len(SEEDS))]
    more = [list(OPERATIONS)[i] for i in rng.integers(0, len(OPERATIONS), rng.integers(0, 3))]

    def change(content: bytes) -> bytes:
        for each in (operation, *more):
            content = OPERATIONS[each](content, rng, most)[: 2 * most]
        return content

    return name, changed(name, SEEDS[name], change, rng)


@contextmanager
def broken_off(seconds: float) -> Iterator[None]:
    """Break off what the budget could not.

    The clock is the processor's, the alarm heard even within a pattern.
    """

    def ring(*_: object) -> None:
        raise TimeoutError(f"still reading after {seconds:.0f} s")

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def costs(path: Path, content: bytes, seconds: float) -> list[Cost]:
    """What it costs to open such a file, and to list its parts."""
    path.write_bytes(content)
    with broken_off(HANGS * seconds):
        return [cost_of(path), parts_cost(path)]
