"""Parameters as a table in five formats, with the digits that their intervals justify."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.errors import OutputError
from springpot.identification import Value
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model
from springpot.report.fit_text import many_csv, many_text
from springpot.report.page import write_parameters, write_values

pytestmark = pytest.mark.usefixtures("asked_once")

ROWS = [
    (("k",), Value(399.4123, 391.0, 407.8, "kN/m")),
    (("c",), Value(0.05179, 0.0515, 0.0521, "kN s^alpha/m")),
    (("m",), Value(0.5, 0.5, 0.5, "kg", fixed=True)),
    (("tau",), Value(3.0, 0.1, float("inf"), "s")),
]


def written(tmp_path: Path, ending: str) -> str:
    path = write_values(tmp_path / f"table{ending}", "maxwell", ("parameter",), ROWS)
    return path.read_text(encoding="utf-8")


def test_files_in_several_units_have_a_column_for_each() -> None:
    """Never a number under the unit of another file; a cell that a file has not is empty."""
    omega = np.geomspace(0.1, 100.0, 12)
    stiffness = parse_model("kelvin").stiffness(np.array([3.0, 2.0]), omega)
    fits = [
        springpot.identify(
            Measurement(omega, stiffness, units=Units(unit, "m"), name=name), "kelvin"
        )
        for name, unit in (("one", "N/m"), ("two", "kPa"))
    ]
    header, _, first, second = many_text(fits).splitlines()
    for unit in ("k [N/m]", "k [kPa]", "c [N s/m]", "c [kPa s]"):
        assert unit in header
    assert first.split()[-4:] == ["3.0000000", "2.0000000", "-", "-"]
    assert second.split()[-4:] == ["-", "-", "3.0000000", "2.0000000"]
    rows = list(csv.DictReader(StringIO(many_csv(fits))))
    assert [float(row["k [N/m]"] or 0) for row in rows] == pytest.approx([3.0, 0.0])
    assert [float(row["k [kPa]"] or 0) for row in rows] == pytest.approx([0.0, 3.0])


def test_people_read_as_many_digits_as_are_known(tmp_path: Path) -> None:
    text = written(tmp_path, ".md")
    assert "| k | 399 | 8 | kN/m |" in text
    assert "| c | 0.05179 | 0.00030 | kN s^alpha/m |" in text
    assert "| m | 0.5000 | fixed | kg |" in text
    assert "| tau | 3.000 | open | s |" in text
    latex = written(tmp_path, ".tex")
    assert r"$\pm$" in latex
    assert r"k & 399 & 8 & kN/m \\" in latex
    page = written(tmp_path, ".html")
    assert ">399</td>" in page
    assert ">8</td>" in page


def test_programs_read_all_digits_and_both_ends(tmp_path: Path) -> None:
    rows = list(csv.DictReader(written(tmp_path, ".csv").splitlines()))
    assert float(rows[0]["value"]) == 399.4123
    assert float(rows[0]["half_width"]) == pytest.approx(8.4)
    assert (rows[3]["high"], rows[3]["half_width"]) == ("", "")


def test_a_workbook_holds_numbers(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    path = write_values(tmp_path / "table.xlsx", "maxwell", ("parameter",), ROWS)
    rows = list(openpyxl.load_workbook(path).active.iter_rows(values_only=True))
    assert rows[0] == ("parameter", "value", "half_width", "low", "high", "unit")
    assert rows[1][:2] == ("k", 399.4123)
    assert rows[4][4] is None


def test_an_ending_that_tells_no_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.docx.*\.csv"):
        write_values(tmp_path / "table.docx", "maxwell", ("parameter",), ROWS)


def test_several_fits_stand_below_one_another(tmp_path: Path) -> None:
    omega = np.geomspace(1.0, 10.0, 6)
    fits = [
        springpot.identify(springpot.Measurement(omega, k + 1j * omega, name=name), "kelvin")
        for name, k in (("soft", 3.0), ("stiff", 5.0))
    ]
    text = write_parameters(tmp_path / "two.csv", fits).read_text()
    assert [line.split(",")[:2] for line in text.splitlines()] == [
        ["data", "parameter"],
        ["soft", "k"],
        ["soft", "c"],
        ["stiff", "k"],
        ["stiff", "c"],
    ]


def test_the_command_writes_by_the_ending(springpot, damper, tmp_path) -> None:
    path = tmp_path / "table.tex"
    springpot("identify", damper, "-m", "fractional-maxwell", "--table", path)
    assert r"\begin{tabular}" in path.read_text()
    springpot("identify", damper, "-m", "kelvin", "--table", tmp_path / "a.doc").is_one_line("doc")
