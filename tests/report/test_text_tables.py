"""Tables as text."""

from dataclasses import replace

from springpot.report.text import (
    Listing,
    Prose,
    TextTable,
    as_html,
    as_text,
    cut,
    indented,
    width,
    wrapped,
)


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
    table = TextTable(("a long name of a column", "size"), [["x", "1"]])
    document = [Prose("one two three"), Prose(), Listing([]), table]
    assert as_text(document, 8) == f"one two\n  three\n\n{table.plain()}"
    assert as_html(document).startswith("<div><p>one two three</p><div")


def test_a_narrow_window_goes_without_spare_columns_and_cuts_names_last():
    table = TextTable(("name", "size", "note"), [["a long name of a test", "1", "more"]], cuts=True)
    assert table.fitted(30).headers == ["name", "size", "note"]
    spare = replace(table, spare=("note",), legend={"note": "what is said", "size": "in mm"})
    assert spare.fitted(30).headers == ["name", "size"]
    assert "note: what is said" not in spare.as_text(30)
    assert spare.as_text(20).splitlines()[-2:] == ["a long name o…  1", "size: in mm"]
    assert "note: what is said" in spare.as_html()


def test_a_number_and_its_per_cent_stay_on_one_line():
    text = "would have been seen from this size on: inertia (0.78 %), time-delay (1.3 %), x (4 %)"
    for columns in range(20, 90):
        broken = wrapped(text, columns)
        assert not any(line.lstrip().startswith("%") for line in broken.splitlines())
        assert " ".join(broken.split()) == text
