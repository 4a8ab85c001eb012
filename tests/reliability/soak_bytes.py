"""Files of every format with wrong bytes.

A measurement or a refusal in one line, and no other exception.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from opening_cost import READERS
from readers.test_fuzz import SEEDS, WORDS
from soak import Row

from springpot.errors import DataError
from springpot.measurement import Choice

CASES = 2000
"""Of each reader."""


def spoilt(content: bytes, rng: np.random.Generator) -> bytes:
    """The content with up to eight places changed, cut out or filled with words of the formats."""
    found = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        place = int(rng.integers(0, len(found) + 1))
        word = (
            WORDS[rng.integers(len(WORDS))]
            if rng.random() < 0.5
            else rng.bytes(int(rng.integers(0, 5)))
        )
        found[place : place + int(rng.integers(0, 12))] = word
    return bytes(found[: rng.integers(0, len(found))] if rng.random() < 0.1 else found)


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row for each reader."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "data"
        for reader in READERS:
            cases, faults, read = max(1, round(scale * CASES)), [], 0
            for _ in range(cases):
                path.write_bytes(spoilt(SEEDS[reader.name], rng))
                try:
                    assert 0.0 <= reader.recognises(path.read_bytes()) <= 1.0
                    reader.read(path, Choice())
                    read += 1
                except DataError as error:
                    faults += ["more than one line"] if "\n" in str(error) else []
                except Exception as error:
                    faults.append(f"{type(error).__name__}: {error}")
            said = "; ".join([f"{read} read, the rest refused", *sorted(set(faults))[:3]])
            yield Row(f"{reader.name} with wrong bytes", cases, cases - len(faults), said)
