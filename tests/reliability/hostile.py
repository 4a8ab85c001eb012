"""Files that would take a machine: each a function of its size, written to a folder.

``size`` is 1 for the file that was found to do harm, and a share of it where a test needs only to
see the rule.
"""

from __future__ import annotations

import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

NAMES = "frequency [Hz],storage [kN/m],loss [kN/m]\n"
ROWS = "".join(f"{i},{2 * i},{3 * i}\n" for i in range(1, 11))


def _text(folder: Path, name: str, *pieces: str, more: Iterable[str] = ()) -> Path:
    path = folder / name
    with path.open("w", encoding="utf-8") as stream:
        stream.writelines(pieces)
        stream.writelines(more)
    return path


def compressed_zeros(folder: Path, size: float) -> Path:
    """A MATLAB file of one megabyte whose one matrix unpacks to a gigabyte of zeros."""
    count = int(125e6 * size)
    name = b"t_s\0\0\0\0\0"
    body = (
        struct.pack("<IIII", 6, 8, 6, 0)
        + struct.pack("<IIii", 5, 8, 1, count)
        + struct.pack("<II", 1, 3)
        + name
    )
    head = (
        struct.pack("<II", 14, len(body) + 8 + 8 * count) + body + struct.pack("<II", 9, 8 * count)
    )
    packer = zlib.compressobj(9)
    pieces, zeros = [packer.compress(head)], bytes(1 << 20)
    left = 8 * count
    while left > 0:
        pieces.append(packer.compress(zeros[:left]))
        left -= len(zeros)
    packed = b"".join([*pieces, packer.flush()])
    path = folder / "zeros.mat"
    mark = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    path.write_bytes(mark + struct.pack("<II", 15, len(packed)) + packed)
    return path


def blank_lines(folder: Path, size: float) -> Path:
    """Thirty thousand blank lines, and a table below them."""
    return _text(folder, "blank.csv", "\n" * int(30_000 * size), NAMES, ROWS)


def long_header(folder: Path, size: float) -> Path:
    """A header of fifty megabytes."""
    title = "a condition of some name [mm],"
    return _text(folder, "header.csv", title * int(50e6 * size / len(title)), NAMES, ROWS)


def one_word(folder: Path, size: float) -> Path:
    """A header of one word of fifty megabytes."""
    return _text(folder, "word.csv", "x" * int(50e6 * size), ",", NAMES, ROWS)


def many_columns(folder: Path, size: float) -> Path:
    """A million columns."""
    count = int(1e6 * size)
    return _text(
        folder,
        "wide.csv",
        ",".join(f"c{i}" for i in range(count)),
        "\n",
        ",".join(["1"] * count),
        "\n",
    )


def many_columns_of_a_table(folder: Path, size: float) -> Path:
    """A million further columns beside those of a measurement."""
    count = int(1e6 * size)
    more = ",".join(f"c{i}" for i in range(count))
    rows = "".join(f"{i},{2 * i},{3 * i},{','.join(['1'] * count)}\n" for i in range(1, 4))
    return _text(folder, "beside.csv", NAMES.strip(), ",", more, "\n", rows)


def small_tables(folder: Path, size: float) -> Path:
    """Thirty thousand small tables, one below the other."""
    return _text(folder, "tables.csv", f"step\n{NAMES}1,2,3\n2,3,4\n\n" * int(30_000 * size))


def many_rows(folder: Path, size: float) -> Path:
    """Two million rows."""
    thousand = [f".{i:03d},{200 + 1e-4 * i:.4f},{50 + 1e-5 * i:.5f}" for i in range(1000)]
    blocks = ("".join(f"{k}{row}\n" for row in thousand) for k in range(1, int(2000 * size) + 1))
    return _text(folder, "rows.csv", NAMES, more=blocks)


def long_signals(folder: Path, size: float) -> Path:
    """A gigabyte of time signals, 5 Hz, sampled a thousand times a second: nothing hostile."""
    phase = 10.0 * np.pi * np.arange(1000) / 1000
    second = [f".{i:03d},{np.sin(p):.6f},{3 * np.sin(p + 0.5):.6f}" for i, p in enumerate(phase)]
    blocks = ("".join(f"{k}{row}\n" for row in second) for k in range(int(37_000 * size)))
    return _text(folder, "signals.csv", "time [s],displacement [mm],force [kN]\n", more=blocks)


SHEET = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
)


def _workbook(folder: Path, name: str, sheet: Callable[[zipfile.ZipFile], None]) -> Path:
    """A workbook of openpyxl's with another sheet in place of its own."""
    import openpyxl

    plain, path = folder / f"plain-{name}", folder / name
    openpyxl.Workbook().save(plain)
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.infolist():
            if not entry.filename.endswith("sheet1.xml"):
                new.writestr(entry.filename, old.read(entry))
        sheet(new)
    plain.unlink()
    return path


def dense_workbook(folder: Path, size: float) -> Path:
    """A workbook of 0.65 MB with some three million cells."""

    def write(book: zipfile.ZipFile) -> None:
        row = "<row>" + "<c><v>1</v></c>" * 100 + "</row>"
        with book.open("xl/worksheets/sheet1.xml", "w") as stream:
            stream.write(SHEET.encode())
            for _ in range(int(300 * size)):
                stream.write((row * 100).encode())
            stream.write(b"</sheetData></worksheet>")

    return _workbook(folder, "dense.xlsx", write)


def zip_bomb(folder: Path, size: float) -> Path:
    """A workbook whose sheet unpacks to a gigabyte of blanks."""

    def write(book: zipfile.ZipFile) -> None:
        with book.open("xl/worksheets/sheet1.xml", "w", force_zip64=True) as stream:
            stream.write(SHEET.encode())
            for _ in range(int(1000 * size)):
                stream.write(b" " * 1_000_000)

    return _workbook(folder, "bomb.xlsx", write)


def nested_workbook(folder: Path, size: float) -> Path:
    """A workbook of 30 kB with a million cells, each within the one before."""

    def write(book: zipfile.ZipFile) -> None:
        depth = int(1e6 * size)
        cells = "<row>" + "<c><is>" * depth + "</is></c>" * depth + "</row>"
        book.writestr("xl/worksheets/sheet1.xml", f"{SHEET}{cells}</sheetData></worksheet>")

    return _workbook(folder, "nested.xlsx", write)


def xml_bomb(folder: Path, size: float) -> Path:
    """A workbook whose sheet defines entities of entities: a billion laughs."""

    def write(book: zipfile.ZipFile) -> None:
        levels = max(2, int(9 * size))
        entities = '<!ENTITY a0 "ha">' + "".join(
            f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, levels + 1)
        )
        sheet = SHEET.replace("?>", f"?><!DOCTYPE worksheet [{entities}]>", 1)
        cell = (
            f'<row><c t="inlineStr"><is><t>&a{levels};</t></is></c></row></sheetData></worksheet>'
        )
        book.writestr("xl/worksheets/sheet1.xml", sheet + cell)

    return _workbook(folder, "laughs.xlsx", write)


def deep_json(folder: Path, size: float) -> Path:
    """A TRIOS export nested a hundred thousand deep."""
    depth = int(100_000 * size)
    return _text(
        folder, "deep.json", '{"Experiment": ', '{"Procedure": ' * depth, "1", "}" * depth, "}"
    )


def many_results(folder: Path, size: float) -> Path:
    """A TRIOS export of thirty thousand results."""
    header = '{"A": {"DisplayName": "Angular frequency", "Unit": {"Name": "rad/s"}}}'
    one = '{"DataSet": {"ColumnHeaders": ' + header + ', "Rows": [{"A": 1.0}]}}'
    return _text(
        folder,
        "results.json",
        '{"Experiment": {"Results": [',
        ",".join([one] * int(30_000 * size)),
        "]}}",
    )


def many_steps(folder: Path, size: float) -> Path:
    """A TRIOS text of thirty thousand steps."""
    step = (
        "[step]\nsweep\nStorage modulus,Loss modulus,Angular frequency\nPa,Pa,rad/s\n1,2,3\n2,3,4\n"
    )
    return _text(folder, "steps.txt", "Filename,a gel\n", step * int(30_000 * size))


def many_intervals(folder: Path, size: float) -> Path:
    """A RheoCompass text of thirty thousand intervals."""
    names = "Angular Frequency\tStorage Modulus\tLoss Modulus\n\t\t\n[rad/s]\t[Pa]\t[Pa]\n"
    return _text(
        folder,
        "intervals.txt",
        "Test:\ta gel\n",
        f"Interval:\t1\n{names}1\t2\t3\n" * int(30_000 * size),
    )


def wide_curves(folder: Path, size: float) -> Path:
    """Curves side by side, twenty thousand of them."""
    count = int(20_000 * size)
    names = ",".join(f"G' {i} C [Pa],G'' {i} C [Pa]" for i in range(count))
    rows = "".join(f"{w},{','.join(['1'] * 2 * count)}\n" for w in (1, 2))
    return _text(folder, "curves.csv", "f [Hz],", names, "\n", rows)


def quotes(folder: Path, size: float) -> Path:
    """Quotes that are opened in every line and closed in none."""
    return _text(folder, "quotes.csv", NAMES, '"1,2,3\n' * int(300_000 * size))


def comments(folder: Path, size: float) -> Path:
    """A million comments of one key above a table."""
    return _text(folder, "comments.csv", "# key: value\n" * int(1e6 * size), NAMES, ROWS)


def brackets(folder: Path, size: float) -> Path:
    """Titles of nothing but opened brackets."""
    return _text(folder, "brackets.csv", "a" + " [(" * int(20_000 * size), ",", NAMES, ROWS)


def blanks_in_a_line(folder: Path, size: float) -> Path:
    """Titles parted by a hundred thousand blanks each."""
    blank = " " * int(100_000 * size)
    return _text(
        folder,
        "blanks.txt",
        blank.join(["", "time", "[s]", "displacement", "[mm]", "force", "x"]),
        "\n",
        ROWS,
    )


def zero_bytes(folder: Path, size: float) -> Path:
    """A sparse file of two gigabytes of zeros."""
    path = folder / "sparse.dat"
    with path.open("wb") as stream:
        stream.truncate(int(2e9 * size))
    return path


def random_bytes(folder: Path, size: float) -> Path:
    """Twenty megabytes of noise."""
    path = folder / "noise.dat"
    path.write_bytes(np.random.default_rng(1).bytes(int(20e6 * size)))
    return path


def fifo(folder: Path, size: float) -> Path:
    """A pipe that nobody writes into."""
    path = folder / "pipe"
    os.mkfifo(path)
    return path


def device(folder: Path, size: float) -> Path:
    """A device that never ends."""
    return Path("/dev/zero")


def linked_device(folder: Path, size: float) -> Path:
    """A link to a device."""
    path = folder / "link.csv"
    path.symlink_to("/dev/zero")
    return path


FILES: tuple[Callable[[Path, float], Path], ...] = (
    compressed_zeros,
    blank_lines,
    fifo,
    device,
    linked_device,
    long_header,
    one_word,
    many_columns,
    many_columns_of_a_table,
    dense_workbook,
    zip_bomb,
    xml_bomb,
    nested_workbook,
    small_tables,
    many_steps,
    many_intervals,
    many_results,
    deep_json,
    many_rows,
    wide_curves,
    quotes,
    comments,
    brackets,
    blanks_in_a_line,
    zero_bytes,
    random_bytes,
)
