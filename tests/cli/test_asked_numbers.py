"""Numbers, ranges and rows as they are asked for on the command line."""

import click
import pytest

from springpot.cli.common import SPACED, numbers, with_rows
from springpot.cli.predict import _require_one_question
from springpot.writing import in_shell


@pytest.fixture(autouse=True)
def _in_a_command():
    with click.Context(click.Command("predict")):
        yield


def test_numbers_with_commas_stand_as_they_are():
    assert numbers("1,5,10") == [1.0, 5.0, 10.0]
    assert numbers("-3") == [-3.0]
    assert numbers("0") == [0.0]


def test_a_range_is_spaced_by_equal_ratios_with_both_ends():
    found = numbers("0.1..100")
    assert len(found) == SPACED
    assert (found[0], found[-1]) == pytest.approx((0.1, 100.0))
    assert found[1] / found[0] == pytest.approx(1000.0 ** (1.0 / (SPACED - 1)))


@pytest.mark.parametrize(
    "text", ["0..1", "-1..1", "2..2", "3..2", "1..inf", "1..nan", "a..2", "..", "1,b", ""]
)
def test_what_is_none_is_refused(text):
    with pytest.raises(click.UsageError, match="write numbers with commas, or a range"):
        numbers(text)


@pytest.mark.parametrize("asked", [(), (0, 1), (1, 2), (0, 1, 2)])
def test_one_question_at_a_time(asked):
    given = [str(i) if i in asked else None for i in range(3)]
    with pytest.raises(click.UsageError, match="give --frequency"):
        _require_one_question(*given, None)


def test_a_geometry_goes_with_a_history_alone():
    for i in range(3):
        given = [str(i) if i == k else None for k in range(3)]
        _require_one_question(*given, None)
        if i == 2:
            _require_one_question(*given, "a geometry")
            continue
        with pytest.raises(click.UsageError, match="--geometry is that of a --history"):
            _require_one_question(*given, "a geometry")


def test_rows_are_added_to_those_that_are_chosen_already(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a@b.csv").write_text("")
    assert with_rows("c.csv", "x=1") == "c.csv@x=1"
    assert with_rows("c.csv@y=2", "x=1") == "c.csv@y=2,x=1"
    assert with_rows("a@b.csv", "x=1") == "a@b.csv@x=1"
    assert in_shell("a b") == "'a b'"
