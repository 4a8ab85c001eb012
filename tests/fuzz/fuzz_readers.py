"""Coverage-guided fuzzing of one reader.

``python tests/fuzz/fuzz_readers.py READER [SECONDS] [libFuzzer options]``.

Needs the extra ``fuzz`` (atheris). A reader may answer with a measurement or a one-line DataError,
nothing else, and within ten seconds and two gigabytes. Seeds are the small files of every layout
that the tests are made of.
"""

from __future__ import annotations

import io
import sys
import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import atheris
import openpyxl

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "plugins")]

with atheris.instrument_imports(include=["springpot_plugins.readers", "springpot.measurement"]):
    from springpot.errors import DataError
    from springpot.measurement import Choice
    from springpot_plugins.readers import springpot_readers

from readers import samples  # noqa: E402

READERS = {reader.name: reader for reader in springpot_readers()}
CHOICES = (
    Choice(),
    Choice("1"),
    Choice("", {"1": "omega[rad/s]", "2": "storage[Pa]", "3": "loss[Pa]"}),
    Choice("2-3", {"frequency": "Hz", "storage": "MPa"}),
    Choice("", {"frequency": "1 [Hz]"}),
    Choice("", {"log": "10", "storage": "Pa", "loss": "Pa"}),
    Choice("", {"curves": "temperature[degC]", "storage": "Pa", "loss": "Pa"}),
    Choice("", {"1": "time[s]", "2": "displacement[mm]", "3": "force[N]"}),
)
SHEET = "xl/worksheets/sheet1.xml"
_BOOK = samples.xlsx()
SHEETS = (
    samples.table("20 °C\nfrequency [Hz],storage [kN/m],loss [kN/m]"),
    (
        ",20 °C,,40 °C,\n"
        f"f [Hz],G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]\n{samples.rows([samples.OMEGA] * 5)}"
    ),
    f"40 °C\nlog10 f [Hz],G'_A [Pa],tan d_A,G'_B [Pa],tan d_B\n{samples.rows([samples.OMEGA] * 5)}",
)
"""Sheets as their name, which may be a line of numbers as well, and lines of cells."""


def seeds() -> dict[str, list[bytes]]:
    """Files of each format."""
    hertz = samples.table("f, E_stor, E_loss\nHz, MPa, MPa").encode()
    plain = samples.table("frequency [Hz],storage [kN/m],loss [kN/m]").encode()
    wide = samples.table(
        "Kreisfrequenz in rad/s;Speichermodul in Pa;Verlustmodul in Pa", ";", ","
    ).encode("utf-16")
    with zipfile.ZipFile(io.BytesIO(_BOOK)) as archive:
        sheet = archive.read(SHEET)
    few = slice(0, 40)
    arrays = {
        "t_s": samples.TIME[few],
        "disp_mm": samples.MOVED[few],
        "force_kN": samples.PULLED[few],
    }
    signals = samples.rows(list(arrays.values())).encode()
    return {
        "springpot-csv": [plain],
        "signals-csv": [
            b"time [s],displacement [mm],force [N]\n" + signals,
            b"t_s,disp_mm,force_N\n" + signals,
            b"Report\n\nTime\tAxial Displacement\tAxial Force\nSec\tmm\tkN\n"
            + signals.replace(b",", b"\t"),
            b'"Total Time (s)","Position(Linear:Position) (mm)","Load(Linear:Load) (kN)"\n'
            + signals,
        ],
        "rheocompass": [
            samples.rheocompass_short(),
            samples.rheocompass_full(),
            samples.rheoplus(),
        ],
        "trios": [samples.trios(), samples.trios("\t")],
        "trios-lims": [samples.trios_lims()],
        "trios-json": [samples.trios_json(), samples.trios_json(official=False)],
        "malvern": [samples.malvern()],
        "reptate": [samples.reptate(), samples.reptate(True)],
        "reptate-laos": [b"omega=2.0;gamma=1.0;\n" + signals.replace(b",", b"\t")],
        "excel": [
            _BOOK,
            b"\x01" + sheet,
            *(b"\x02" + text.replace(",", "\t").encode() for text in SHEETS),
        ],
        "signals-mat": [
            samples.mat(**arrays),
            samples.mat(False, **arrays),
            samples.mat(False, run=arrays),
        ],
        "signals-tdms": [samples.tdms()],
        "table": [
            hertz,
            plain,
            wide,
            samples.moduli(" ").encode(),
            samples.table(r"$\omega$ [rad/s];J' [1/MPa];J'' [1/MPa]", ";").encode(),
            samples.table("f in Hz;G' in Pa;G\" in Pa", ";", ",").encode("latin-1"),
            *(text.partition("\n")[2].encode() for text in SHEETS),
            samples.table("log ω,log G',ln G''").encode(),
            b"f [Hz],0.1,1,10\nG' [Pa],1 000,2 000,3\nG'' [Pa],1.0D+02,2,3\n",
            (
                b"T = 20 C\nSeg,Storage,Loss,f [Hz]\n,modulus [Pa],modulus [Pa]\n1|1,1,2,3\n"
                b"40 \xc2\xb0C\n2|2,7,8,9\n"
            ),
        ],
    }


def workbook(sheet: bytes) -> bytes:
    """The workbook with other contents of its sheet.

    So that the fuzzer need not find out how zip archives sum up.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(_BOOK)) as old, zipfile.ZipFile(stream, "w") as new:
        for entry in old.infolist():
            new.writestr(entry.filename, sheet if entry.filename == SHEET else old.read(entry))
    return stream.getvalue()


class Sheet:
    """A sheet as from openpyxl, made of lines of cells without the slow way through an archive."""

    def __init__(self, text: str) -> None:
        self.title, _, self.rows = text.partition("\n")

    def reset_dimensions(self) -> None:
        """Nothing is known of its size."""

    def iter_rows(self, values_only: bool) -> Iterator[tuple[object, ...]]:
        """The cells: nothing, numbers, times or words."""
        for line in self.rows.split("\n"):
            yield tuple(map(self.value, line.split("\t")))

    @staticmethod
    def value(cell: str) -> object:
        """What a workbook would hold."""
        if cell[:1] in ("", "@"):
            return datetime(2020, 1, 1) if cell else None
        try:
            return float(cell)
        except ValueError:
            return cell


class Book:
    """A workbook of such sheets."""

    def __init__(self, content: bytes) -> None:
        self.worksheets = [Sheet(text) for text in content.decode("utf-8", "replace").split("\f")]

    def close(self) -> None:
        """Nothing is open."""


def main() -> None:
    """Fuzz until the time is over."""
    assert set(seeds()) == set(READERS), "a reader without seeds"
    name = sys.argv[1]
    reader, folder = READERS[name], Path(tempfile.mkdtemp())
    path = folder / "input"
    warnings.simplefilter("error", RuntimeWarning)
    load = openpyxl.load_workbook

    def one(data: bytes) -> None:
        mark = data[:1] if name == "excel" else b""
        content = {b"\x01": lambda: workbook(data[1:]), b"\x02": lambda: _BOOK}.get(
            mark, lambda: data
        )()
        openpyxl.load_workbook = load if mark != b"\x02" else lambda *_, **__: Book(data[1:])
        assert 0.0 <= reader.recognises(content[: 1 << 16]) <= 1.0
        path.write_bytes(content)
        read = reader.read if reader.signals is None else reader.signals
        choice = CHOICES[len(data) % len(CHOICES)]
        for action in (lambda: read(path, choice), lambda: reader.parts and reader.parts(path)):
            try:
                action()
            except DataError as error:
                if "\n" in str(error):
                    raise ValueError(f"not one line: {error}") from error

    corpus = folder / "corpus"
    corpus.mkdir()
    for i, content in enumerate(seeds()[name]):
        # One of each length, so that each seed meets each choice.
        for more in range(len(CHOICES)):
            (corpus / f"{i}-{more}").write_bytes(content + b"\n" * more)
    seconds = sys.argv[2] if len(sys.argv) > 2 else "60"
    options = [
        "-max_len=20000",
        "-timeout=10",
        "-rss_limit_mb=2048",
        f"-max_total_time={seconds}",
        f"-artifact_prefix={folder}/",
    ]
    atheris.Setup([sys.argv[0], *options, *sys.argv[3:], str(corpus)], one)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
