"""Tables as text."""

from springpot.report.text import Table, indented, width


def test_columns_line_up():
    table = Table(("name", "size"), [["α", "1"], ["long name", "23"]], frozenset({"size"}))
    assert table.plain().splitlines() == [
        "name       size",
        "---------  ----",
        "α             1",
        "long name    23",
    ]


def test_width_counts_columns_of_a_terminal():
    assert width("K\u0301″") == 2
    assert width("日本") == 4


def test_indented_keeps_empty_lines_empty():
    assert indented("a\n\nb") == "  a\n\n  b"


def test_markup_in_data_is_printed_as_it_is(capsys, monkeypatch):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    Table(("name",), [["[red]not markup[/red]"]]).show()
    assert "[red]not markup[/red]" in capsys.readouterr().out
