"""A page that needs nothing else: its style sheet, panels of the workbench, and its tables."""

from __future__ import annotations

import base64
import csv
import hashlib
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from io import StringIO
from math import isfinite, isinf, isnan
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeAlias

from springpot.errors import OutputError
from springpot.files import require_writable, write_text, write_with
from springpot.identification.value import Value
from springpot.writing import DIGITS, Html, guarded, number as digits, tag, wide_table

from .canvas import CANVAS
from .text import halved, to_json

if TYPE_CHECKING:
    from springpot.identification.result import Identification


@dataclass(frozen=True)
class Interval:
    """An estimate with its 95 % interval.

    Examples
    --------
    >>> from springpot.benchmark.statistics import wilson
    >>> rate = wilson(18, 20)
    >>> rate.value, round(rate.low, 2), round(rate.high, 2)
    (0.9, 0.7, 0.97)
    """

    value: float
    low: float
    high: float


Entry: TypeAlias = str | int | float | Interval | None


@dataclass(frozen=True)
class Table:
    """Rows under a heading.

    Parameters
    ----------
    title : str
        One line above it.
    columns : tuple of str
        Headings.
    rows : sequence of tuples
        Texts, numbers, `Interval` or None (nothing to say).
    note : str
        What the columns mean.
    asks : str
        What it is to answer, for those who read it above the table.
    """

    title: str
    columns: tuple[str, ...]
    rows: Sequence[tuple[Entry, ...]]
    note: str = ""
    asks: str = ""


def number(value: float) -> str:
    """Four significant digits; powers of ten below 0.001 and from a million on.

    Whole numbers as they are.
    """
    if isinstance(value, int):
        return str(value)
    if isnan(value):
        return "–"
    if isinf(value):
        return str(value).replace("inf", "∞")
    # Zero is neither large nor small: it has no power of ten.
    if value and not CANVAS.plain[0] <= abs(value) < CANVAS.plain[1]:
        return f"{value:.3e}"
    # With four digits it would be a power of ten, which is harder to compare down a column.
    if abs(value) >= 10.0**DIGITS:
        return f"{value:.0f}"
    return f"{value:.4g}"


def text(entry: Entry) -> str:
    """An entry as people read it."""
    if entry is None:
        return "–"
    if isinstance(entry, Interval):
        return f"{number(entry.value)} [{number(entry.low)}, {number(entry.high)}]"
    if isinstance(entry, str):
        return entry
    return number(entry)


def to_markdown(table: Table) -> str:
    """The table in GitHub's Markdown."""
    lines = [f"# {table.title}", ""]
    if table.asks:
        lines += [table.asks, ""]
    lines.append(_pipes(table.columns))
    rules = {True: "---:", False: "---"}
    lines.append(_pipes([rules[numeric] for numeric in _numeric(table)]))
    lines += [_pipes([text(entry) for entry in row]) for row in table.rows]
    if table.note:
        lines += ["", table.note]
    return "\n".join(lines) + "\n"


def _pipes(cells: Sequence[str]) -> str:
    return "| " + " | ".join(_markdown_cell(cell) for cell in cells) + " |"


def _markdown_cell(cell: str) -> str:
    # The backslash goes first: the one that hides a bar must not be hidden itself.
    escaped = cell.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")
    # A line break would end the row.
    return " ".join(escaped.split())


def to_csv(table: Table) -> str:
    """The table for programs.

    Numbers in full, an interval as three columns, nothing as an empty field.
    """
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    # A column has the same fields in all rows, whichever of them hold an interval.
    wide = [
        any(isinstance(row[i], Interval) for row in table.rows) for i in range(len(table.columns))
    ]
    heads: list[str] = []
    for column, is_wide in zip(table.columns, wide, strict=True):
        heads.append(column)
        if is_wide:
            heads += [f"{column} low", f"{column} high"]
    writer.writerow([guarded(name) for name in heads])
    for row in table.rows:
        values: list[str] = []
        for entry, is_wide in zip(row, wide, strict=True):
            values += _fields(entry, is_wide)
        writer.writerow(values)
    return stream.getvalue()


def _fields(entry: Entry, wide: bool) -> tuple[str, ...]:
    if isinstance(entry, Interval):
        return tuple(_field(value) for value in (entry.value, entry.low, entry.high))
    if wide:
        return (_field(entry), "", "")
    return (_field(entry),)


def _field(entry: str | float | None) -> str:
    if entry is None:
        return ""
    # NumPy's floats are floats that name their type when asked for all their digits.
    if isinstance(entry, float):
        return repr(float(entry))
    return guarded(str(entry))


_LATEX = {sign: rf"\{sign}" for sign in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "∞": r"$\infty$",
    "–": "--",
    "±": r"$\pm$",
    "|": r"\textbar{}",
}


def to_latex(table: Table) -> str:
    """The table for a paper, with booktabs."""
    sides = {True: "r", False: "l"}
    layout = "".join(sides[numeric] for numeric in _numeric(table))
    lines = [
        f"% {table.title}",
        rf"\begin{{tabular}}{{{layout}}}",
        r"\toprule",
        _ampersands(table.columns),
        r"\midrule",
    ]
    lines += [_ampersands([text(entry) for entry in row]) for row in table.rows]
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"]) + "\n"


def escaped_latex(words: str) -> str:
    """Text in which no sign commands LaTeX."""
    return "".join(_LATEX.get(character, character) for character in words)


def _ampersands(cells: Sequence[str]) -> str:
    return " & ".join(_latex_cell(cell) for cell in cells) + r" \\"


def _latex_cell(cell: str) -> str:
    escaped = escaped_latex(cell)
    # A row that begins with a bracket would be read as the optional argument of the line break
    # before it.
    if escaped.startswith("["):
        return "{" + escaped + "}"
    return escaped


def element_of(table: Table) -> Html:
    """Its columns and rows, as an element of a page."""
    pairs = zip(table.columns, _numeric(table), strict=True)
    numbers = [column for column, numeric in pairs if numeric]
    rows = ([text(entry) for entry in row] for row in table.rows)
    return wide_table(table.columns, rows, numbers)


def to_html(table: Table) -> str:
    """The table as a page of its own."""
    above, below = (tag("p", words) if words else "" for words in (table.asks, table.note))
    return page(table.title, tag("h1", table.title), above, element_of(table), below)


def _numeric(table: Table) -> list[bool]:
    """Whether a column holds numbers, and so stands flush right."""
    columns = range(len(table.columns))
    return [
        bool(table.rows) and not any(isinstance(row[i], str) for row in table.rows) for i in columns
    ]


FORMATS: dict[str, tuple[str, Callable[[Table], str]]] = {
    "md": ("md", to_markdown),
    "csv": ("csv", to_csv),
    "latex": ("tex", to_latex),
    "html": ("html", to_html),
}
"""Name of a format to its file suffix and writer."""


def save_table(
    table: Table, folder: Path, stem: str, formats: Sequence[str] = tuple(FORMATS)
) -> list[Path]:
    """Write a table to files ``stem.SUFFIX`` in a folder, one for each format.

    Raises
    ------
    OutputError
        If one of them cannot be written.
    """
    written = []
    for name in formats:
        suffix, write = FORMATS[name]
        written.append(write_text(folder / f"{stem}.{suffix}", write(table)))
    return written


_FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
"""What the name of a sheet cannot hold."""
LONGEST = 31
"""Letters of the name of a sheet."""

ENDINGS = {".csv", ".xlsx", *(f".{suffix}" for suffix, _ in FORMATS.values())}
"""Of files, by which the format of a table is chosen."""


def write_parameters(path: str | Path, fits: Sequence[Identification]) -> Path:
    """Write the parameters of fits to a file; see `write_values`."""
    rows: list[tuple[tuple[str, ...], Value]] = []
    for fit in fits:
        # One fit is named in the title.
        data = (fit.name,) if len(fits) > 1 else ()
        rows += [((*data, name), value) for name, value in fit.parameters.items()]
    heads = ("data", "parameter") if len(fits) > 1 else ("parameter",)
    title = fits[0].model.name
    if len(fits) == 1:
        title = f"{title} fitted to {fits[0].name}"
    return write_values(Path(path), title, heads, rows)


def check_table_path(path: Path) -> None:
    """Refuse a file whose ending tells no format, before time is spent on what goes there.

    Raises
    ------
    OutputError
        If it has none of `ENDINGS`, or the place cannot be written.
    """
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(sorted(ENDINGS))
        raise OutputError(f"{path}: the ending tells the format of a table: one of {known}")
    require_writable(path)


def write_values(
    path: Path,
    title: str,
    heads: Sequence[str],
    rows: Iterable[tuple[tuple[str, ...], Value]],
) -> Path:
    """Write values to a file, in the format of its ending.

    For people (.md, .tex, .html) with the digits that the interval justifies; for programs (.csv,
    .xlsx) in full, with both ends.

    Parameters
    ----------
    path : Path
        The file.
    title : str
        One line above the table.
    heads : sequence of str
        Headings of the names.
    rows : iterable
        Names and values.

    Raises
    ------
    OutputError
        If the ending tells no format, or the file cannot be written.
    """
    check_table_path(path)
    rows, suffix = list(rows), path.suffix.lower()
    if suffix in (".csv", ".xlsx"):
        table = _in_full(title, heads, rows)
        if suffix == ".csv":
            return write_text(path, to_csv(table))
        return write_workbook(path, [("springpot", [table.columns, *table.rows])])
    write = {f".{ending}": writer for ending, writer in FORMATS.values()}[suffix]
    return write_text(path, write(_for_people(title, heads, rows)))


def _in_full(
    title: str, heads: Sequence[str], rows: Iterable[tuple[tuple[str, ...], Value]]
) -> Table:
    columns = (*heads, "value", "half_width", "low", "high", "unit")
    return Table(title, columns, [(*names, *_numbers(value)) for names, value in rows])


def _numbers(value: Value) -> tuple[Entry, ...]:
    ends = [end if isfinite(end) else None for end in (value.low, value.high)]
    half = None if None in ends else 0.5 * (value.high - value.low)
    return (value.value, half, *ends, value.unit)


def _for_people(
    title: str, heads: Sequence[str], rows: Iterable[tuple[tuple[str, ...], Value]]
) -> Table:
    columns = (*heads, "value", "± (95 %)", "unit")
    cells = [(*names, *_words(value), value.unit) for names, value in rows]
    return Table(title, columns, cells)


def _words(value: Value) -> tuple[str, str]:
    if value.fixed:
        return digits(value.value), "fixed"
    if not (isfinite(value.low) and isfinite(value.high)):
        return digits(value.value), "open"
    return halved(value.value, value.low, value.high)


def require_openpyxl() -> None:
    """Check that workbooks can be written.

    Raises
    ------
    OutputError
        If openpyxl is not installed.
    """
    try:
        import openpyxl  # noqa: F401
    except ImportError:
        raise OutputError(
            "an Excel table needs openpyxl: pip install 'springpot[instruments]'"
        ) from None


def write_workbook(path: Path, sheets: Iterable[tuple[str, Sequence[Sequence[Entry]]]]) -> Path:
    """Write an Excel workbook, each sheet by its name and its rows, the first of which is bold.

    Raises
    ------
    OutputError
        If openpyxl is not installed, or the file cannot be written.
    """
    require_openpyxl()
    return write_with(path, lambda stream: _fill(sheets, stream))


def _fill(sheets: Iterable[tuple[str, Sequence[Sequence[Entry]]]], stream: IO[bytes]) -> None:
    from openpyxl import Workbook
    from openpyxl.styles import Font

    book = Workbook()
    book.remove(book.active)
    taken: set[str] = set()
    for name, rows in sheets:
        page = book.create_sheet(_title(name, taken))
        for number, row in enumerate(rows, 1):
            for column, value in enumerate(row, 1):
                cell = page.cell(number, column)
                if isinstance(value, str):
                    # Control signs cannot stand in a workbook.
                    cell.value = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f]", " ", value)
                    # Text stays text, whatever sign it begins with.
                    cell.data_type = "s"
                elif isinstance(value, int | float) and isfinite(value):
                    cell.value = value
                if number == 1:
                    cell.font = Font(bold=True)
        page.freeze_panes = "B2"
        # As wide as most names are.
        page.column_dimensions["A"].width = 24
    book.save(stream)


def _title(name: str, taken: set[str]) -> str:
    """A name that a sheet can have, and no other has."""
    stem = _FORBIDDEN.sub(" ", name).strip("' ")[:LONGEST] or "test"
    title, number = stem, 2
    while title.casefold() in taken:
        end = f" {number}"
        title, number = f"{stem[: LONGEST - len(end)]}{end}", number + 1
    taken.add(title.casefold())
    return title


STYLE = """
:root { color-scheme: light; --ink: #222; --quiet: #666; --line: #ddd;
  --mark: #0072b2; --soft: #f4f6f8; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff; font: 16px/1.5 system-ui, sans-serif;
  overflow-wrap: anywhere; }
main { max-width: 1060px; margin: 0 auto; padding: 24px 16px 64px; }
h1 { font-size: 1.7em; line-height: 1.2; margin: 0 0 4px; }
h2 { font-size: 1.25em; margin: 40px 0 8px; padding-top: 12px; border-top: 1px solid var(--line); }
h3 { font-size: 1em; margin: 20px 0 4px; }
p, ul { margin: 6px 0; max-width: 46em; }
li { margin: 4px 0; }
.quiet { color: var(--quiet); font-size: 0.92em; }
.verdict { background: var(--soft); border-left: 4px solid var(--mark); padding: 10px 14px;
  margin: 14px 0; }
.facts { display: flex; flex-wrap: wrap; gap: 10px; margin: 14px 0; }
.fact { flex: 1 1 150px; border: 1px solid var(--line); border-radius: 6px; padding: 8px 12px; }
.fact b { display: block; font-size: 1.25em; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 8px 24px; }
figure { margin: 8px 0; min-width: 0; }
figure img { width: 100%; height: auto; display: block; }
.alone { max-width: 680px; }
figcaption { font-size: 0.92em; color: var(--quiet); }
.scroll { overflow-x: auto; max-width: 100%; }
table { border-collapse: collapse; font-size: 0.92em; margin: 8px 0; }
th, td { text-align: left; vertical-align: top; padding: 4px 14px 4px 0;
  border-bottom: 1px solid var(--line); overflow-wrap: normal; }
th { font-weight: 600; white-space: nowrap; }
td.number, th.number { text-align: right; white-space: nowrap; }
td:nth-child(-n+2) { white-space: nowrap; }
.physics { min-width: 16em; }
.whole { white-space: nowrap; margin-right: 0.5em; }
details { margin: 8px 0; }
summary { cursor: pointer; font-weight: 600; }
code, pre { font: 0.9em/1.45 ui-monospace, monospace; }
pre { background: var(--soft); padding: 10px 12px; white-space: pre-wrap; }
.key { display: inline-block; margin-right: 14px; white-space: nowrap; }
.key i { display: inline-block; width: 12px; height: 12px; margin-right: 5px;
  vertical-align: -1px; }
@media (max-width: 760px) {
  main { padding-top: 16px; }
  .pair { grid-template-columns: minmax(0, 1fr); }
  thead { display: none; }
  table, tbody, tr { display: block; }
  tr { border-bottom: 1px solid var(--line); padding: 6px 0; }
  td, td.number { display: grid; grid-template-columns: 9em minmax(0, 1fr); border: 0;
    padding: 1px 0; text-align: left; white-space: normal; overflow-wrap: anywhere; }
  td::before { content: attr(data-label); color: var(--quiet); }
  .physics { min-width: 0; }
}
@media print { h2 { break-after: avoid; } figure { break-inside: avoid; } }
"""


POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
"""What a browser may load for the page: nothing that is not in it."""


def page(title: str, *body: str, style: str = "", script: str = "") -> Html:
    """A whole document.

    Parameters
    ----------
    title : str
        Of the window.
    *body : str
        Its parts, one below the other.
    style : str
        Rules beside those of every page.
    script : str
        What the policy of the page allows as ``script-src``; without it no script runs, whatever
        stands in the page.
    """
    # In the page itself, as a file has no server to send it: even what was not escaped could not
    # run.
    policy = POLICY
    if script:
        policy = f"{POLICY}; script-src {script}"
    head = tag(
        "head",
        # First: a browser reads on with it from here.
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", title),
        tag("style", Html(STYLE + style)),
    )
    return Html(
        f"<!doctype html>\n{tag('html', head, tag('body', tag('main', *body)), lang='en')}\n"
    )


def assets_in(package: str, folder: str) -> dict[str, bytes]:
    """Content of each file in a folder of a package, by name."""
    return {
        item.name: item.read_bytes()
        for item in (files(package) / folder).iterdir()
        if item.is_file()
    }


@cache
def modules() -> dict[str, bytes]:
    """Content of each shared module and style sheet, by name."""
    return assets_in("springpot.report.interactive", "modules")


ORDER = (
    "dom.js",
    "numbers.js",
    "plot.js",
    "views.js",
    "zoom.js",
    "pointing.js",
    "spots.js",
    "hero.js",
    "compare.js",
    "ladder.js",
    "spark.js",
    "missing.js",
    "report.js",
)
"""Each imports only from those before it."""
STYLES = ("panels.css", "report.css")
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./([\w.]+)";$', re.M)
EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.M)


@dataclass(frozen=True)
class PageParts:
    """Parts of a page that belong together.

    Parameters
    ----------
    body : Html
        Stands where the panels are to be; their data and their program.
    style : str
        Rules for the style sheet of the page.
    policy : str
        What a Content-Security-Policy must allow as ``script-src``: this program and no other.
    """

    body: Html
    style: str
    policy: str


def bench_of(given: dict[str, Any]) -> PageParts:
    """The panels of a report.

    Parameters
    ----------
    given : dict
        ``scene``, see `PageScene.to_dict`; ``rungs``, see `rungs`; ``excluded``: rows that no model
        was fitted to.
    """
    program = "\n".join(['"use strict";', "const modules = {};", *map(_as_function, ORDER)])
    style = "\n".join(modules()[name].decode() for name in STYLES)
    # In a script only its own end tag means anything; within JSON every < may be written by its
    # number.
    escaped = to_json(given, None).replace("<", "\\u003c")
    data = tag("script", Html(escaped), type="application/json", id="given")
    body = Html(f"{tag('div', id='bench')}{data}{tag('script', Html(program))}")
    # By its digest: a script that slipped in with the data would have another, and no browser would
    # run it.
    return PageParts(body, style, f"'{_digest(program)}'")


def _as_function(name: str) -> str:
    """A module as a function whose result is what it exports.

    One inline script cannot hold several modules.
    """
    source = modules()[name].decode()
    names = [name for _, name in EXPORT.findall(source)]
    # Imports become look-ups in what the modules before it have left, exports what is returned.
    source = EXPORT.sub(r"\1", IMPORT.sub(r'const \1 = modules["\2"];', source))
    return f'modules["{name}"] = (() => {{\n{source}\nreturn {{ {", ".join(names)} }};\n}})();'


def _digest(text: str) -> str:
    """As a Content-Security-Policy names what it allows inline."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
