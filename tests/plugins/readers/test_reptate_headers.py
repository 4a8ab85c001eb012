"""The first line of RepTate's files, and lines that only look like it."""

import pytest

from springpot_plugins.readers.reptate import HEADER


@pytest.mark.parametrize(
    "line", ["Mw=295000; Mn=64000; T=140;", "Mw=295000; Mn=64000; T=140", "T=25;"]
)
def test_the_last_semicolon_may_be_missing(line):
    assert HEADER.match(line)


@pytest.mark.parametrize("line", ["T = 20 °C", "f=1 Hz", "Mw; T=140", ""])
def test_a_line_without_one_heads_any_table(line):
    assert not HEADER.match(line)
