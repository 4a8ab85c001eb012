"""Opening a file: whatever its reader says, the user sees which file it was and what to type."""

import pytest

from springpot.errors import DataError
from springpot.measurement import Reader, open_measurement


def refusal(tmp_path, message):
    """What a user sees of a reader that refuses with `message`."""

    def read(path, choice):
        raise DataError(message)

    path = tmp_path / "damper.csv"
    path.write_text("anything")
    with pytest.raises(DataError) as caught:
        open_measurement(path, (), [Reader("mine", "refuses", lambda head: 1.0, read)])
    return str(caught.value).replace(str(path), "PATH")


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("no column of force", "PATH: no column of force"),
        ("line 3: 'x' is no number", "PATH, line 3: 'x' is no number"),
        ("column 'f': there is no unit", "PATH, column 'f': there is no unit"),
        ("if it is Hz, open 'FILE?frequency=Hz'", "PATH: if it is Hz, open 'PATH?frequency=Hz'"),
        ("damper: no measured points", "PATH: no measured points"),
        ("damper.csv: time stands still", "PATH: time stands still"),
    ],
)
def test_the_file_is_named_once_and_in_the_hint(tmp_path, message, shown):
    assert refusal(tmp_path, message) == shown


def test_a_reader_that_names_the_file_is_left_alone(tmp_path):
    path = tmp_path / "damper.csv"
    assert refusal(tmp_path, f"{path}: wrong") == "PATH: wrong"
