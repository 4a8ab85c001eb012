"""What stands behind a file's name chooses a part and columns."""

import pytest

from springpot.errors import DataError
from springpot.measurement.reader import Choice, file_and_choice


@pytest.mark.parametrize(
    ("text", "name", "part"),
    [
        ("a.csv", "a.csv", ""),
        ("a.csv#2", "a.csv", "2"),
        ("a.csv# sheet one ", "a.csv", "sheet one"),
        ("a#b.csv#2", "a#b.csv", "2"),
    ],
)
def test_a_part_stands_behind_the_last_mark(text, name, part):
    assert file_and_choice(text) == (name, Choice(part))


@pytest.mark.parametrize("text", ["a.csv#", "a.csv# "])
def test_a_mark_alone_chooses_nothing(text):
    with pytest.raises(DataError, match="give the number or name of a part"):
        file_and_choice(text)


def test_a_file_that_is_there_goes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.csv#2", "b.csv?c"):
        (tmp_path / name).write_text("")
        assert file_and_choice(name) == (name, Choice())
    assert file_and_choice("a.csv#2#3") == ("a.csv#2", Choice("3"))
