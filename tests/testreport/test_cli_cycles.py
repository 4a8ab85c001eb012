"""``springpot cycles``: tables, files and figures of records."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from known_loops import loop

from springpot.testreport import deciding


@pytest.fixture
def record(write):
    """A record with its temperature, and a name that a spreadsheet would run."""
    t, x, force, _ = loop("coulomb", per_cycle=60, cycles=5)
    rows = np.column_stack([t, x, force, 20.0 + t])
    text = "time [s],displacement [mm],force [kN],temperature [degC]\n"
    return write(text + "".join(",".join(f"{cell:.8g}" for cell in row) + "\n" for row in rows))


@pytest.fixture
def bare(write):
    """The same loop without its time."""
    _, x, force, _ = loop("coulomb", per_cycle=60, cycles=5)
    rows = "".join(f"{a:.8g},{b:.8g}\n" for a, b in zip(x, force, strict=True))
    return write(f"displacement [mm],force [kN]\n{rows}", "=loop.csv")


def test_a_row_for_each_quantity_and_what_it_comes_from(springpot, record):
    told = springpot("cycles", record)
    assert told.code == 0, told.err
    for word in ("5 cycles", "mean 2..4", "95 % interval", "K_eff", "kN/mm", "energy of the run"):
        assert word in told.out
    answer = springpot("cycles", record, "--cycles", "1..3", "--json").json
    assert answer["schema"] == "springpot.cycles/1"
    (test,) = answer["tests"]
    assert (test["mean"]["first"], test["mean"]["last"]) == (1, 3)
    assert test["mean"]["values"]["K_eff"]["value"] == pytest.approx(0.5, rel=1e-3)
    assert test["mean"]["values"]["T"]["value"] == pytest.approx(20.0 + 1.5 / 1.3, abs=0.01)
    assert test["units"]["W_d"] == "kN mm"
    assert len(test["cycles"]) == 5


def test_loops_without_time_give_what_needs_none(springpot, bare):
    answer = springpot("cycles", bare, "--json").json
    (test,) = answer["tests"]
    assert test["frequency"] is None
    assert "C_eff" not in test["units"]
    assert test["mean"]["values"]["W_d"]["value"] == pytest.approx(80.0, rel=2e-3)
    assert any("no time" in note for note in test["notes"])


@pytest.mark.soak
def test_files_have_a_row_for_each_cycle_and_run_nothing(springpot, record, bare, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    path, text = tmp_path / "report.xlsx", tmp_path / "report.csv"
    assert springpot("cycles", record, bare, "-o", path).code == 0
    book = openpyxl.load_workbook(path)
    assert len(book.sheetnames) == 3
    page = book["=loop"]
    assert page["A2"].value == 1
    assert page["A7"].value == "mean 2..4"
    assert (page.freeze_panes, page.column_dimensions["A"].width) == ("B2", 24)
    assert [page[place].font.bold for place in ("A1", "B1", "A2")] == [True, True, False]
    assert all(cell.data_type != "f" for row in book["tests"].rows for cell in row)
    assert springpot("cycles", record, bare, "-o", text).code == 0
    cells = [cell for row in csv.reader(text.open(encoding="utf-8")) for cell in row]
    assert "'=loop" in cells
    assert not any(cell.startswith("=") for cell in cells)


def test_a_figure_shows_the_loops(springpot, record, tmp_path, undrawn):
    assert springpot("cycles", record, "--figure", tmp_path / "loops.png").code == 0
    (figure,) = undrawn
    axes = figure.axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["ellipse", "backbone"]
    ellipse, backbone = axes.lines[-2:]
    x, y = ellipse.get_data()
    area = abs(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))
    assert area == pytest.approx(80.0, rel=2e-3)
    assert backbone.get_ydata() == pytest.approx([-5.0, 5.0], rel=1e-3)


@pytest.mark.parametrize(("words", "says"), [
    (("--cycles", "ten"), "3..10"),
    (("-o", "report.doc"), ".xlsx or .csv"),
    (("--cycles", "7..9"), "5 whole cycles"),
])  # fmt: skip
def test_what_cannot_be_is_one_line(springpot, record, words, says):
    assert springpot("cycles", record, *words).is_one_line(says)


def test_a_chance_is_told_as_far_as_tails_are_known():
    told = [
        deciding.chance(value) for value in (9.9e-5, 1e-4, 0.5, 0.996, 1.0 - 1e-4, 1.0 - 9.9e-5)
    ]
    assert told == ["< 0.01 %", "0.01 %", "50 %", "99.60 %", "99.99 %", "> 99.99 %"]
