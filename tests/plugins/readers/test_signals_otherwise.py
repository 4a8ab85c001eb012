"""Time signals as laboratories keep them.

In workbooks, without a clock, with the clock of the wall.
"""

import datetime
import io

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.registry import signals_to_measurement

from . import samples
from .samples import MOVED, PULLED, TIME

EXPECTED = 3 * np.exp(0.5j)
RATE = float(1 / (TIME[1] - TIME[0]))


def check(path, unit, said=""):
    found = signals_to_measurement([f"{path}{said}"])
    np.testing.assert_allclose(found.omega, [2.0], rtol=1e-5)
    np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-4)
    assert found.units.stiffness == unit
    return found


def workbook(sheets):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


NUMBERS = zip(TIME.tolist(), MOVED.tolist(), PULLED.tolist(), strict=True)
CHANNELS = [["Time", "Stroke", "Load"], ["s", "mm", "kN"], *NUMBERS]


class TestWorkbooks:
    @pytest.mark.soak
    def test_the_sheet_that_holds_signals(self, folder):
        content = workbook({"Notes": [["Operator", "Ada"]], "Data": [["rig 2"], [], *CHANNELS]})
        path = folder.write(content, "test.xlsx")
        check(path, "kN/mm")
        check(path, "kN/mm", "#Data")
        check(path, "kN/mm", "#2")
        with pytest.raises(DataError, match="no sheet 'data 3'"):
            check(path, "kN/mm", "#data 3")

    def test_opened_as_data_they_are_one_point(self, folder):
        found = folder.open(workbook({"Data": CHANNELS}), name="test.xlsx")
        np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-4)

    def test_columns_without_known_names_are_said(self, folder):
        path = folder.write(workbook({"Data": [["a", "b", "c"], *CHANNELS[2:]]}), "test.xlsx")
        check(path, "N/mm", "?a=time[s],b=displacement[mm],c=force[N]")

    def test_an_error_names_the_row_of_the_sheet(self, folder):
        rows = [list(row) for row in CHANNELS]
        rows[9][2] = "slipped"
        path = folder.write(workbook({"Data": [["rig 2"], [], *rows]}), "test.xlsx")
        with pytest.raises(DataError, match="line 12, column 'Load': 'slipped' is no number"):
            check(path, "kN/mm")


class TestWithoutAClock:
    TEXT = "Displacement [mm],Force [N]\n" + samples.rows((MOVED, PULLED))

    def test_the_rate_is_asked_for(self, folder):
        path = folder.write(self.TEXT)
        with pytest.raises(DataError, match=r"data\.txt\?rate=1000\[Hz\]'$"):
            check(path, "N/mm")
        found = check(path, "N/mm", f"?rate={RATE!r}[Hz]")
        assert "samples a second" in found.provenance["note data"]
        check(path, "N/mm", f"?rate={RATE / 1000!r} kHz")

    @pytest.mark.parametrize(
        "line",
        [
            "Sample rate: {} Hz",
            "# sampling frequency = {} Hz",
            "Abtastrate [Hz]: {}",
            "Sample Rate,{},Hz",
        ],
    )
    def test_a_header_that_states_it(self, folder, line):
        check(folder.write(line.format(f"{RATE:.12f}") + "\n" + self.TEXT), "N/mm")

    def test_a_rate_is_no_frequency_of_the_test(self, folder):
        """A column of time goes before any rate that the header states."""
        text = "Sample rate: 7 Hz\nTime [s],Displacement [mm],Force [N]\n" + samples.rows(
            (TIME, MOVED, PULLED)
        )
        check(folder.write(text), "N/mm")

    @pytest.mark.parametrize("said", ["fast", "0", "-5[Hz]", "400[s]"])
    def test_what_is_no_rate(self, folder, said):
        with pytest.raises(DataError, match="is no sample rate"):
            check(folder.write(self.TEXT), "N/mm", f"?rate={said}")


@pytest.mark.parametrize(
    ("title", "style"),
    [
        ("Datum/Uhrzeit", "%d.%m.%Y %H:%M:%S.%f"),
        ("Elapsed", "%H:%M:%S.%f"),
        ("Date and time", "%Y-%m-%dT%H:%M:%S.%f"),
    ],
)
def test_the_clock_of_the_wall(folder, title, style):
    begin = datetime.datetime(2024, 3, 1, 8, 5)
    lines = [f"{title};Weg [mm];Kraft [kN]"]
    for second, moved, pulled in zip(TIME.tolist(), MOVED, PULLED, strict=True):
        moment = (begin + datetime.timedelta(seconds=second)).strftime(style)
        lines.append(f"{moment};{moved:.9f};{pulled:.9f}")
    check(folder.write("\n".join(lines)), "kN/mm")


def test_the_hint_for_a_force_that_counts_the_other_way_has_its_unit(folder):
    """A hint typed as it stands must give the right stiffness, not a thousandth of it."""
    path = folder.write(
        "time [s],displacement [mm],force [kN]\n" + samples.rows((TIME, MOVED, -PULLED))
    )
    note = signals_to_measurement([path]).provenance["note data"]
    said = note[note.index("open '") :].removeprefix(f"open '{path}").rstrip("'")
    assert said == "?force=-kN"
    check(path, "kN/mm", said)
