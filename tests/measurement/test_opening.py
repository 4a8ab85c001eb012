"""Opening a file: whatever its reader says, the user sees which file it was and what to type."""

from pathlib import Path

import pytest

from springpot.errors import DataError, SpringpotError
from springpot.measurement import DataSet, Reader, open_measurement, opening
from springpot.measurement.opening import Suite
from springpot.measurement.reader import Choice


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


def nothing():
    raise AssertionError("is opened")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dampr.csv", "there is no such file or data set: did you mean damper.csv?"),
        ("damper", "there is no such file or data set: did you mean damper.csv?"),
        ("other/thing", "there is no such file"),
        ("other\\thing", "there is no such file"),
        ("thing.csv", "there is no such file"),
        (
            "nist-rubbr",
            "is neither a file nor a registered data set: did you mean nist-rubber, rubber?",
        ),
        ("xyzzy", "is neither a file nor a registered data set: see 'springpot list datasets'"),
        ("nist-rubber#2", "'#' and '?' are for files; choose from a data set by nist-rubber@"),
        ("rubber?x=y", "'#' and '?' are for files; choose from a data set by rubber@"),
        ("", "is neither a file nor a registered data set: see"),
    ],
)
def test_a_name_of_nothing_is_answered_with_the_nearest(tmp_path, monkeypatch, text, says):
    monkeypatch.chdir(tmp_path)
    Path("damper.csv").write_text("anything")
    known = [DataSet("nist-rubber", "of a rubber", nothing, aliases=("rubber",))]
    with pytest.raises(DataError) as caught:
        open_measurement(text, known, [])
    assert says in str(caught.value)
    assert ("did you mean" in str(caught.value)) is ("did you mean" in says)


@pytest.mark.parametrize("loaded", [(), [1], ("text",), None])
def test_a_data_set_that_gives_no_measurement_is_named(loaded):
    with pytest.raises(DataError, match=r"gives .* which is no measurement"):
        DataSet("own", "of a laboratory", lambda: loaded).tests()


def test_problems_of_a_suite_are_looked_for_by_what_they_do_not_share():
    names = ("made/wlf-shift", "made/payne", "made/creep")
    problems = tuple(DataSet(name, "made up", nothing) for name in names)
    suite = Suite("made", "some problems", lambda: problems, dict)
    assert suite.problem("made/payne") is problems[1]
    with pytest.raises(SpringpotError, match=r"did you mean made/payne\?$"):
        suite.problem("made/pain")
    with pytest.raises(SpringpotError, match="see 'springpot list suites made'"):
        suite.problem("made/xyzzy")


def test_what_cannot_be_read_is_told_with_the_reason(tmp_path):
    known = [Reader("mine", "reads", lambda head: 1.0, nothing)]
    reasons = {
        "folder": "this is a folder",
        "none.csv": "there is no such file$",
        "dampr.csv": "did you mean .*damper.csv",
        "damper.csv/x": "cannot be read: Not a directory",
        "empty.csv": "the file is empty",
        "a\0b": "cannot be read: ",
    }
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "damper.csv").write_text("anything")
    for name, says in reasons.items():
        with pytest.raises(DataError, match=says):
            opening.pick_reader(tmp_path / name, known)


def test_of_a_page_of_html_it_is_said_what_it_is(tmp_path):
    page, text = tmp_path / "a.xls", tmp_path / "a.csv"
    page.write_bytes(b"\xef\xbb\xbf\r\n <html>")
    text.write_bytes(b"words")
    readers = [Reader(name, "reads", lambda head: 0.0, nothing) for name in ("one", "two")]
    with pytest.raises(DataError, match=r"HTML or XML.* \(readers: one, two\)"):
        opening.pick_reader(page, readers)
    with pytest.raises(DataError, match=r"it takes columns .* \(readers: none\)"):
        opening.pick_reader(text, [])


def test_remarks_alone_tell_no_reader_anything(tmp_path):
    long = tmp_path / "long.csv"
    long.write_bytes(b"# a remark\n" * 20_000 + b"omega,storage,loss\n" + b"1,2,3\n" * 20_000)
    assert opening.read_head(long).startswith(b"omega,storage,loss")
    assert len(opening.read_head(long)) == opening.HEAD


def test_who_names_the_columns_means_signals(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("anything")
    table = Reader("table", "reads", lambda head: 1.0, nothing)
    record = Reader(
        "record", "reads", lambda head: 0.5, nothing, signals=lambda path, choice: choice.columns
    )
    named = Choice(columns={"time": "t"})
    assert opening._signals_by(path, named, [table, record]) == named.columns
    with pytest.raises(DataError, match="these are no signals against time"):
        opening._signals_by(path, Choice(), [table, record])
    surer = Reader(
        "surer", "reads", lambda head: 1.0, nothing, signals=lambda path, choice: "by itself"
    )
    assert opening._signals_by(path, named, [surer, record]) == "by itself"
