"""Every file that once took the machine is refused in one line, or read.

Within the budget of its size in springpot's
own process, and by bounded sizes in anybody else's.
"""

import hostile
import pytest
from opening_cost import READERS, cost_of, parts_cost

from springpot import files
from springpot.errors import DataError
from springpot.measurement import Measurement, open_measurement, within_budget
from springpot.registry import signals_to_measurement

READ = {"blank_lines", "comments", "xml_bomb"}
"""Files of which something may be made."""
SIZES = {"compressed_zeros": 0.4, "zip_bomb": 0.4}
"""Of those that cost more to pack than to refuse.

What is left unpacks to twice the memory that is allowed.
"""


@pytest.fixture
def short(monkeypatch):
    """A small part of the time, so that the tests are done sooner; all else as it is."""
    monkeypatch.setattr(files, "FILES", files.FILES._replace(seconds=0.2))
    # A step within a library, which nothing interrupts, is no shorter for that; on a busy one it
    # took four seconds. Without a budget these files take 20 to 1000 times it.
    monkeypatch.setattr("opening_cost.ALLOWED_TIMES", 100)
    monkeypatch.setattr(files, "FILES", files.FILES._replace(bytes_a_second=100e6))


@pytest.mark.soak_cases(
    "long_header",
    "comments",
    "compressed_zeros",
    "dense_workbook",
    "many_columns",
    "many_columns_of_a_table",
    "many_intervals",
    "many_results",
    "many_rows",
    "many_steps",
    "quotes",
    "small_tables",
    "wide_curves",
    "xml_bomb",
    "zip_bomb",
)
@pytest.mark.parametrize("make", hostile.FILES, ids=lambda make: make.__name__)
@pytest.mark.usefixtures("short")
def test_a_hostile_file_takes_no_more_than_its_budget(make, tmp_path):
    path = make(tmp_path, SIZES.get(make.__name__, 1.0))
    opened, listed = cost_of(path), parts_cost(path)
    assert not opened.fault
    assert not listed.fault
    if make.__name__ not in READ:
        assert opened.said


@pytest.mark.soak_cases("many_columns_of_a_table")
@pytest.mark.parametrize(
    "name", ["many_columns_of_a_table", "small_tables", "many_steps", "many_intervals"]
)
def test_in_a_users_own_python_sizes_are_bounded(name, tmp_path, monkeypatch):
    """The files that took longest; fewer tables than in earnest, so that the test is quick."""
    monkeypatch.setattr("springpot_plugins.readers.blocks.MOST_TABLES", 100)
    path = getattr(hostile, name)(tmp_path, 0.02)
    with pytest.raises(DataError, match=r"save those that matter alone") as refused:
        open_measurement(path, (), READERS)
    assert str(path) in str(refused.value)


def test_a_workbook_has_no_more_cells_than_are_read_of_all_sheets(tmp_path, monkeypatch):
    monkeypatch.setattr("springpot_plugins.readers.grid.MOST_CELLS", 10_000)
    path = hostile.dense_workbook(tmp_path, 0.008)
    with pytest.raises(DataError, match="more than 10000 cells"):
        open_measurement(path, (), READERS)


def test_a_workbook_is_nested_no_deeper_than_workbooks_are(tmp_path):
    """A deep tree is freed within C, where no clock is heard: it must not be built."""
    path = hostile.nested_workbook(tmp_path, 0.001)
    with pytest.raises(DataError, match="nested too deeply"):
        open_measurement(path, (), READERS)


def test_a_text_is_no_longer_than_is_read_in_one_piece(tmp_path, monkeypatch):
    path = hostile.many_rows(tmp_path, 0.001)
    monkeypatch.setattr("springpot.files.bytes_of.__defaults__", (1 << 10,))
    with pytest.raises(DataError, match=r"rows\.csv is too large: at most 1 KiB"):
        open_measurement(path, (), READERS)


@pytest.mark.parametrize(
    "make", [hostile.fifo, hostile.device, hostile.linked_device], ids=lambda m: m.__name__
)
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


@pytest.mark.soak
def test_a_table_of_hundred_thousand_rows_is_no_hostile_file(tmp_path):
    path = hostile.many_rows(tmp_path, 0.05)
    found = open_measurement(path, (), READERS)
    assert isinstance(found, Measurement)
    assert len(found) == 100_000
