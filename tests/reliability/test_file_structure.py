"""The fuzzer of structure, a little of it; `make soak` has the rest."""

import numpy as np
import pytest
from opening_cost import READERS
from readers.test_fuzz import SEEDS

import structure

CASES = 8
LARGEST = 100_000


@pytest.mark.suite_cases("nest")
@pytest.mark.parametrize("operation", structure.OPERATIONS)
def test_files_of_much_structure_are_read_or_refused_within_their_budget(operation, tmp_path):
    rng = np.random.default_rng([7, *operation.encode()])
    for case in range(CASES):
        name, content = structure.made(operation, rng, LARGEST)
        for cost in structure.costs(tmp_path / "data", content, 1.0):
            assert not cost.fault, (case, name)


def test_what_is_changed_keeps_its_format():
    """Otherwise the fuzzer would only see that files are not recognised."""
    rng = np.random.default_rng(3)
    for reader in READERS:
        same = structure.changed(reader.name, SEEDS[reader.name], lambda content: content, rng)
        assert reader.recognises(same[: 1 << 16]) > 0.0
        grown = [structure.repeat(SEEDS[reader.name], rng, LARGEST) for _ in range(20)]
        assert max(map(len, grown)) > 10_000


def test_a_hang_that_the_budget_cannot_end_is_seen(tmp_path, monkeypatch):
    """A search of a pattern that never ends hears no other thread, but the alarm of this one."""
    import re

    monkeypatch.setattr(structure, "cost_of", lambda path: re.match(r"(a+)+b", "a" * 60))
    with pytest.raises(TimeoutError):
        structure.costs(tmp_path / "data", b"", 0.05)
