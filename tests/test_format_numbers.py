"""Numbers, counts and sizes as they are written everywhere."""

import pytest

from springpot.errors import DataError
from springpot.files import bytes_of, text_in
from springpot.writing import (
    accepting,
    at_place,
    counted,
    exponent_of,
    number,
    suggested,
    with_model,
)

INF = float("inf")


@pytest.mark.parametrize(
    ("value", "digits", "written"),
    [
        (None, 4, "-"),
        (float("nan"), 4, "-"),
        (INF, 4, "inf"),
        (-INF, 4, "-inf"),
        (0.0, 4, "0"),
        (1.0, 4, "1.000"),
        (9.99996, 4, "10.00"),
        (123456.0, 4, "123500"),
        (1234567.0, 4, "1.235e+06"),
        (999999.0, 2, "1.0e+06"),
        (0.00123456, 4, "0.001235"),
        (0.00012345, 4, "1.234e-04"),
        (-2.5, 2, "-2.5"),
        (1e-310, 4, "0.000"),
    ],
)
def test_a_number_has_its_digits(value, digits, written):
    assert number(value, digits) == written


@pytest.mark.parametrize(
    ("value", "place", "written"),
    [
        (0.0123, -2, "0.01"),
        (-0.001, -2, "0.00"),
        (0.001, -4, "0.0010"),
        (0.00001, -4, "0.0000"),
        (0.000001, -5, "0"),
        (0.0, -2, "0"),
        (1234.0, 2, "1200"),
        (INF, 0, "inf"),
    ],
)
def test_a_number_ends_at_its_place(value, place, written):
    assert at_place(value, place) == written


def test_the_first_digit_is_that_after_rounding():
    assert [exponent_of(v, 4) for v in (1.0, 9.9994, 9.9996, 0.0999999, 1e-301)] == [0, 0, 1, -1, 0]


def test_things_are_counted():
    assert [counted(n, "row") for n in (0, 1, 2)] == ["0 rows", "1 row", "2 rows"]


@pytest.mark.parametrize(("most", "said"), [(1 << 10, "1 KiB"), (1 << 20, "1 MiB")])
def test_a_file_may_be_as_large_as_is_said(tmp_path, most, said):
    path = tmp_path / "file"
    path.write_bytes(b"x" * most)
    assert len(bytes_of(path, most)) == most
    path.write_bytes(b"x" * (most + 1))
    with pytest.raises(DataError, match=f"too large: at most {said} are read"):
        bytes_of(path, most)


def test_a_text_begins_behind_the_mark_of_spreadsheets(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"\xef\xbb\xbf1;2")
    assert text_in(path) == "1;2"
    path.write_bytes(b"ab\xff")
    with pytest.raises(DataError, match=r"no text in UTF-8 \(byte 2\)"):
        text_in(path)


def test_commands_are_such_as_a_shell_takes():
    words = [*with_model("a + b"), *accepting(["c", "d"])]
    assert suggested("fit", "my file", *words) == (
        "springpot fit 'my file' --model 'a + b' --accept c --accept d"
    )
    assert with_model(None) == []
