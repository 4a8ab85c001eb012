"""No cell that a spreadsheet would run gets into a CSV file.

What springpot wrote it reads back as it was.
"""

import csv
import io

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from springpot.measurement import (
    Measurement,
    guarded,
    guarded_line,
    open_measurement,
    unguarded,
    unguarded_line,
)
from springpot.registry import write_measurement
from springpot.report.page import Table, to_csv
from springpot.writing import csv_text
from springpot_plugins.readers import springpot_readers

FORMULAS = (
    "=1+1",
    "+cmd|' /C calc'!A0",
    "-2+3+cmd",
    "@SUM(A1)",
    '=HYPERLINK("http://x","y")',
    "\t=1",
    "＝1+1",
    "'=1",
)
PLAIN = ("-1.5", "+3e-4", "-inf", "1", "", "-", "a=b", "x-y", "it's")
WORDS = st.text(st.sampled_from("=+-@'＝,;\t a1.e\""), max_size=12)


def runs(cell):
    """Whether a spreadsheet would run this."""
    try:
        float(cell)
    except ValueError:
        return len(cell) > 1 and cell[0] in "=+-@\t\r＝＋－＠"
    return False


@pytest.mark.parametrize("cell", FORMULAS)
def test_a_formula_is_made_text_and_back(cell):
    assert not runs(guarded(cell))
    assert unguarded(guarded(cell)) == cell


@pytest.mark.parametrize("cell", PLAIN)
def test_what_is_no_formula_stays(cell):
    assert guarded(cell) == cell
    assert unguarded(cell) == cell


@given(WORDS)
def test_every_word_comes_back(word):
    assert not runs(guarded(word))
    assert unguarded(guarded(word)) == word
    assert unguarded_line(guarded_line(word)) == word


def cells_of(text):
    """All cells that a spreadsheet sees, at whatever sign it parts them, comments too."""
    for separator in ",;\t":
        for row in csv.reader(io.StringIO(text), delimiter=separator):
            yield from row


def test_tables_of_a_study():
    table = Table("t", ["=head", "number"], [[cell, -1.5] for cell in FORMULAS])
    text = to_csv(table)
    assert "-1.5" in text
    assert not [cell for row in csv.reader(io.StringIO(text)) for cell in row if runs(cell)]


def test_rows_as_exports_and_reports_write_them():
    text = csv_text([["dataset", "value"], *([cell, -1.0] for cell in FORMULAS)])
    rows = list(csv.DictReader(io.StringIO(text)))
    assert not [row for row in rows if runs(row["dataset"])]
    assert {row["value"] for row in rows} == {"-1.0"}


@pytest.mark.soak
@given(WORDS, WORDS, WORDS.filter(str.strip))
@settings(max_examples=100, deadline=None)
@example("@\t\"@-..@'.e+", "", 'e,"@')
@example("a", 'x,""=1+1', "b")
def test_a_measurement_is_written_without_formulas_and_read_back(
    tmp_path_factory, label, note, name
):
    path = tmp_path_factory.mktemp("written") / "data.csv"
    labels = np.array([" ".join(label.split()), "b"])
    data = Measurement(
        [1.0, 2.0],
        [-1 + 1j, 2 + 2j],
        labels={"sample": labels},
        name=" ".join(name.split()),
        provenance={"note": note},
    )
    write_measurement(data, path)
    text = path.read_text()
    assert not [cell for row in csv.reader(io.StringIO(text)) for cell in row if runs(cell)]
    found = open_measurement(path, (), springpot_readers())
    assert found.labels["sample"].tolist() == labels.tolist()
    assert found.stiffness.tobytes() == data.stiffness.tobytes()
    assert found.provenance.get("note", "") == " ".join(note.split())


def test_names_of_conditions_and_labels_as_well(tmp_path):
    path = tmp_path / "data.csv"
    data = Measurement(
        [1.0], [1 + 1j], conditions={"=cmd": np.array([3.0])}, labels={"@sum": np.array(["x"])}
    )
    write_measurement(data, path)
    assert not [cell for cell in cells_of(path.read_text()) if runs(cell)]
    found = open_measurement(path, (), springpot_readers())
    assert list(found.conditions) == ["=cmd"]
    assert list(found.labels) == ["@sum"]
