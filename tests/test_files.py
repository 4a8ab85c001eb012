"""Output files are written whole or not at all."""

import os
import stat
import subprocess
import sys
import threading

import pytest

from springpot.errors import OutputError
from springpot.files import keep_input, one_run, require_writable, write_text, write_with


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


def test_a_device_is_written_to_and_stays_one():
    write_text("/dev/null", "gone")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with pytest.raises(OutputError, match="No space left on device"):
        write_text("/dev/full", "too much")


def test_a_pipe_is_written_to(tmp_path):
    pipe = tmp_path / "pipe.txt"
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_text(pipe, "through")
    reader.join(10)
    assert read == [b"through"]
    assert pipe.is_fifo()


@pytest.mark.parametrize("there", [True, False], ids=["of a file", "of none yet"])
def test_a_link_is_followed(tmp_path, there):
    (tmp_path / "elsewhere").mkdir()
    file, link = tmp_path / "elsewhere" / "file.txt", tmp_path / "link.txt"
    if there:
        file.write_text("old")
    link.symlink_to(file)
    write_text(link, "new")
    assert link.is_symlink()
    assert file.read_text() == "new"
    assert os.listdir(file.parent) == ["file.txt"]


def test_a_link_to_itself_is_told(tmp_path):
    link = tmp_path / "link.txt"
    link.symlink_to(link)
    with pytest.raises(OutputError, match="a link to itself"):
        write_text(link, "new")


def test_what_is_printed_stays_where_standard_output_is_named_as_output(tmp_path):
    log = tmp_path / "log.txt"
    log.write_text("before\n")
    program = (
        "from springpot.files import write_text\nprint('first')\n"
        "write_text('/dev/stdout', 'table\\n')\nprint('last')"
    )
    with log.open("a") as stream:
        subprocess.run([sys.executable, "-c", program], stdout=stream, check=True)
    assert log.read_text() == "before\nfirst\ntable\nlast\n"


@pytest.mark.parametrize("name", ["in.csv", "link.csv", "hard.csv", "../in/in.csv"])
def test_an_input_of_the_run_is_never_replaced(tmp_path, name):
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "in.csv").write_text("data")
    (folder / "link.csv").symlink_to("in.csv")
    os.link(folder / "in.csv", folder / "hard.csv")
    with one_run():
        keep_input(folder / "in.csv")
        with pytest.raises(OutputError, match="read by this very command"):
            require_writable(folder / name)
        write_text(folder / "out.csv", "result")
    assert (folder / "in.csv").read_text() == "data"
    # In a user's own Python a file may be read and written again.
    keep_input(folder / "in.csv")
    write_text(folder / "in.csv", "new")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to any file")
def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path):
    path = tmp_path / "kept.txt"
    path.write_text("kept")
    path.chmod(0o444)
    with pytest.raises(OutputError, match="no permission"):
        write_text(path, "new")
