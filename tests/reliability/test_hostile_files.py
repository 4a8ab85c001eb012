"""Every file that once took the machine is refused in one line, or read, within the budget of its size."""

import hostile
import pytest
from opening_cost import READERS, cost_of, parts_cost

from springpot.errors import DataError
from springpot.measurement import Measurement, budget, open_measurement, within_budget
from springpot.registry import signals_to_measurement

READ = {"blank_lines", "comments", "xml_bomb"}
"""Files of which something may be made."""
SIZES = {"compressed_zeros": 0.4, "zip_bomb": 0.4}
"""Of those that cost more to pack than to refuse: what is left unpacks to twice the memory that is allowed."""


@pytest.fixture
def short(monkeypatch):
    """A small part of the time, so that the tests are done sooner; all else as it is."""
    monkeypatch.setattr(budget, "SECONDS", 0.2)
    # A step within a library, which nothing interrupts, is no shorter for that; on a busy one it took four seconds.
    # Without a budget these files take 20 to 1000 times it.
    monkeypatch.setattr("opening_cost.ALLOWED_TIMES", 100)
    monkeypatch.setattr(budget, "BYTES_A_SECOND", 100e6)


@pytest.mark.parametrize("make", hostile.FILES, ids=lambda make: make.__name__)
@pytest.mark.usefixtures("short")
def test_a_hostile_file_takes_no_more_than_its_budget(make, tmp_path):
    path = make(tmp_path, SIZES.get(make.__name__, 1.0))
    opened, listed = cost_of(path), parts_cost(path)
    assert not opened.fault
    assert not listed.fault
    if make.__name__ not in READ:
        assert opened.said


@pytest.mark.parametrize("make", [hostile.fifo, hostile.device, hostile.linked_device], ids=lambda m: m.__name__)
def test_what_is_no_regular_file_is_refused_everywhere(make, tmp_path):
    path = make(tmp_path, 1.0)
    for action in (
        lambda: open_measurement(path, (), READERS),
        lambda: open_measurement(f"{path}#2", (), READERS),
        lambda: open_measurement(f"{path}@temperature=20", (), READERS),
        lambda: signals_to_measurement([path]),
        lambda: within_budget(path, path.read_bytes),
    ):
        with pytest.raises(DataError, match="pipe or device"):
            action()


def test_a_table_of_hundred_thousand_rows_is_no_hostile_file(tmp_path):
    path = hostile.many_rows(tmp_path, 0.05)
    found = open_measurement(path, (), READERS)
    assert isinstance(found, Measurement)
    assert len(found) == 100_000
