"""Long records: worked on block by block, and mapped files give their memory back."""

from pathlib import Path

import numpy as np
import pytest

from springpot.measurement import steady as record
from springpot.measurement.steady import BLOCK, MendedSignals

STATUS = Path("/proc/self/status")


def mapped_memory():
    """Bytes of mapped files that are in memory."""
    lines = STATUS.read_text().splitlines() if STATUS.exists() else []
    found = next((line for line in lines if line.startswith("RssFile")), None)
    if found is None:
        pytest.skip("this system does not say how much memory mapped files take")
    return 1024 * int(found.split()[1])


def test_a_mapped_record_needs_no_more_memory_than_a_few_blocks(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "FORGET", 2 * BLOCK)
    rows = 40 * BLOCK
    for name in "txf":
        np.arange(rows, dtype=float).tofile(tmp_path / name)
    # As arrays of numpy's own class, which is how they come from the evaluation.
    channels = [np.asarray(np.memmap(tmp_path / name, dtype=float, mode="r")) for name in "txf"]
    long = MendedSignals(*channels, name="long")
    before, peak, total = mapped_memory(), 0, 0.0
    for time, both in long.blocks():
        total += float(time.sum() + both.sum())
        peak = max(peak, mapped_memory() - before)
    assert total == 3 * rows * (rows - 1) / 2
    assert peak < 0.3 * 3 * 8 * rows


def test_a_record_lasts_from_its_first_sample_to_its_last():
    time, still = np.array([1.0, 2.0, 4.5]), np.zeros(3)
    assert MendedSignals(time, still, still, name="short").span == 3.5
