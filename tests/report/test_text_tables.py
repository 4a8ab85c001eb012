"""Tables as text."""

from springpot.report.text import TextTable, cut, indented, paragraphs, width


def test_columns_line_up():
    table = TextTable(("name", "size"), [["α", "1"], ["long name", "23"]], frozenset({"size"}))
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
    TextTable(("name",), [["[red]not markup[/red]"]]).show()
    assert "[red]not markup[/red]" in capsys.readouterr().out


def test_a_long_name_is_cut_to_its_place():
    assert cut("as it is", 8) == "as it is"
    assert cut("too long by far", 8) == "too lon…"


def test_sentences_are_broken_and_tables_stay_as_they_are():
    table = TextTable(("a long name of a column", "size"), [["x", "1"]]).plain()
    told = paragraphs(["one two three", "", table], 8)
    assert told == f"one two\n  three\n\n{table}"
