"""Output files are written whole or not at all."""

import os

import pytest

from springpot.errors import OutputError
from springpot.files import require_writable, write_text, write_with


def test_replaces_the_file_and_leaves_nothing_beside_it(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(0o640)
    assert write_text(path, "naïve") == path
    assert path.read_text(encoding="utf-8") == "naïve"
    assert path.stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_new_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").write_text("")
    write_text(tmp_path / "new", "")
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "usual").stat().st_mode


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_what_was_there_survives_a_failure(tmp_path, error):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail(stream):
        stream.write(b"half")
        raise error

    with pytest.raises(error):
        write_with(path, fail)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_full_disk_is_told_in_one_line(tmp_path):
    def fail(stream):
        raise OSError(28, "No space left on device")

    with pytest.raises(OutputError, match=r"cannot write .*a\.txt: No space left on device"):
        write_with(tmp_path / "a.txt", fail)


def test_an_impossible_place_is_told_before_any_work(tmp_path):
    with pytest.raises(OutputError, match="is a folder"):
        require_writable(tmp_path)
    with pytest.raises(OutputError, match="there is no folder"):
        require_writable(tmp_path / "no" / "a.txt")
