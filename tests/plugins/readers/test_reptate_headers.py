"""The first line of RepTate's files, and lines that only look like it."""

import numpy as np
import pytest

from springpot.registry import open_in_time, open_measurement
from springpot_plugins.readers.reptate import HEADER


@pytest.mark.parametrize(
    "line", ["Mw=295000; Mn=64000; T=140;", "Mw=295000; Mn=64000; T=140", "T=25;"]
)
def test_the_last_semicolon_may_be_missing(line):
    assert HEADER.match(line)


@pytest.mark.parametrize("line", ["T = 20 °C", "f=1 Hz", "Mw; T=140", ""])
def test_a_line_without_one_heads_any_table(line):
    assert not HEADER.match(line)


def test_blanks_and_tabs_part_the_numbers_of_one_file(tmp_path):
    """Rows with a blank among tabs were taken for remarks above the table, without a word."""
    path = tmp_path / "comb.tts"
    path.write_text("Ma=20;Mb=82;\n#\n0.1 10\t20\n0.2 30\t40\n0.4\t50\t60\n0.8\t70\t80\n")
    data = open_measurement(path)
    np.testing.assert_allclose(data.omega, [0.1, 0.2, 0.4, 0.8])
    np.testing.assert_allclose(data.stiffness, [10 + 20j, 30 + 40j, 50 + 60j, 70 + 80j])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_any_computer_ends_them(tmp_path, end):
    path = tmp_path / "melt.uext"
    path.write_bytes(b"gdot=0.5;T=160\n" + end.join(["1\t10", "2\t30", "4\t50"]).encode())
    [test] = open_in_time(path)
    np.testing.assert_allclose(test.time, [1.0, 2.0, 4.0])
    np.testing.assert_allclose(test.response, [5.0, 15.0, 25.0])
