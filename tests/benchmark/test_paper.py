"""Tables for a paper: columns, rows and digits are chosen, LaTeX floats with caption and label."""

import pytest

from springpot.benchmark import Interval, Table
from springpot.benchmark.commands.tables import captioned, for_paper
from springpot.errors import StudyError
from springpot.report.page import to_latex

TABLE = Table(
    "race",
    ("optimiser", "budget", "ERT"),
    [
        ("pso-paper", 2000, Interval(1234.5678, 1000.1234, 2000.5678)),
        ("cma-es", 2000, None),
        ("native", 500, 0.0123456),
    ],
)


def test_columns_come_in_the_order_asked_for_and_rows_by_their_values():
    part = for_paper(TABLE, ("ERT", "optimiser"), ("optimiser=native", "optimiser=pso-paper"))
    assert part.columns == ("ERT", "optimiser")
    assert [row[1] for row in part.rows] == ["pso-paper", "native"]
    assert for_paper(TABLE, rows=("budget=500", "optimiser=native")).rows == [TABLE.rows[2]]
    assert for_paper(TABLE) == Table(TABLE.title, TABLE.columns, TABLE.rows)


def test_digits_round_numbers_and_both_ends_of_intervals():
    part = for_paper(TABLE, digits=2)
    assert part.rows[0] == ("pso-paper", 2000, Interval(1200.0, 1000.0, 2000.0))
    assert part.rows[2][2] == 0.012
    assert part.rows[1][2] is None


def test_a_caption_is_escaped_and_a_label_stands_as_it_is():
    latex = captioned(to_latex(TABLE), "90 % of it & more", "tab:race_1")
    assert latex.startswith(
        "\\begin{table}\n\\centering\n\\caption{90 \\% of it \\& more}\n\\label{tab:race_1}\n%"
    )
    assert latex.endswith("\\end{tabular}\n\\end{table}\n")
    assert captioned(to_latex(TABLE), None, None) == to_latex(TABLE)


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"columns": ("speed",)}, "no column 'speed': it has optimiser, budget, ERT"),
        ({"rows": ("optimiser=sgd",)}, "no row with optimiser=sgd"),
        ({"rows": ("optimiser",)}, "HEADING=VALUE"),
    ],
)
def test_what_is_not_there_is_told(choice, says):
    with pytest.raises(StudyError, match=says):
        for_paper(TABLE, **choice)
