"""A folder that is watched: rows join as files grow, half a line waits, the ladder stays."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import pytest
from browsing import IN_A_BROWSER, Open

from springpot.diagnosis.result import silent
from springpot.errors import DataError, OptionError
from springpot.measurement.measurement import Measurement
from springpot.web import Workbench
from springpot.web.folders import WATCHED, seen_in, watched
from springpot.web.sessions import data_of, text_of
from springpot.web.tasks import look


@pytest.fixture
def lines(damper: bytes) -> list[bytes]:
    return damper.splitlines(keepends=True)


def held(folder: Path, base: str = "", before: str = "") -> tuple[dict[str, Any], Any]:
    return watched(str(folder), "", base, before)


def test_rows_of_several_files_are_one_sweep(tmp_path: Path, lines: list[bytes]):
    (tmp_path / "b.csv").write_bytes(lines[0] + b"".join(lines[8:]))
    (tmp_path / "a.csv").write_bytes(b"".join(lines[:8]))
    told, data = held(tmp_path)
    assert (told["files"], told["waits"]) == (["a.csv", "b.csv"], [])
    assert (len(data), data.repeat) == (14, None)
    assert watched(str(tmp_path), told["signature"], "", "") == (
        {"folder": tmp_path.name, "signature": told["signature"]},
        None,
    )


def test_rows_left_out_are_found_again_when_an_earlier_file_grows(
    tmp_path: Path, lines: list[bytes]
):
    (tmp_path / "a.csv").write_bytes(b"".join(lines[:4]))
    (tmp_path / "b.csv").write_bytes(lines[0] + b"".join(lines[8:11]))
    _, before = held(tmp_path)
    (tmp_path / "a.csv").write_bytes(b"".join(lines[:6]))
    told, now = held(tmp_path, before=text_of(before))
    assert told["rows"] == [0, 1, 2, 5, 6, 7]
    assert (now.omega[told["rows"]] == before.omega).all()


def test_a_last_line_without_an_end_waits_until_nobody_writes_on(
    tmp_path: Path, lines: list[bytes]
):
    file = tmp_path / "a.csv"
    file.write_bytes(b"".join(lines[:9])[:-3])
    assert len(held(tmp_path)[1]) == 7
    long_ago = time.time() - WATCHED.settled - 1.0
    os.utime(file, (long_ago, long_ago))
    assert len(held(tmp_path)[1]) == 8


@pytest.mark.parametrize("half", [b"", b"frequency [H", b"hello\n", b"\0\1\2"])
def test_what_cannot_be_read_yet_is_one_line(tmp_path: Path, lines: list[bytes], half: bytes):
    (tmp_path / "a.csv").write_bytes(b"".join(lines))
    (tmp_path / "b.csv").write_bytes(half)
    told, data = held(tmp_path)
    assert len(data) == 14
    (line,) = told["waits"]
    assert "b.csv" in line
    assert "\n" not in line


def test_files_of_other_programs_are_passed_over(tmp_path: Path):
    for name in (".a.csv.swp", "~$a.xlsx"):
        (tmp_path / name).write_bytes(b"1")
    (tmp_path / "older").mkdir()
    assert seen_in(tmp_path, 0.0) == []


def test_what_the_open_data_hold_already_joins_once(tmp_path: Path, lines: list[bytes]):
    (tmp_path / "a.csv").write_bytes(b"".join(lines[:10]))
    _, first = held(tmp_path)
    (tmp_path / "a.csv").write_bytes(b"".join(lines))
    _, data = held(tmp_path, base=text_of(first))
    assert isinstance(data, Measurement)
    assert (len(data), data.repeat) == (14, None)


def _warm(lines: list[bytes]) -> bytes:
    return b"".join(line.replace(b",", b",293,", 1) for line in lines)


def test_what_a_reader_asks_is_answered_behind_the_folder(tmp_path: Path, lines: list[bytes]):
    (tmp_path / "a.csv").write_bytes(b"frequency,T,storage,loss\n" + _warm(lines[1:]))
    assert held(tmp_path)[1] is None
    spec = f"{tmp_path}?frequency=Hz,temperature=K,storage=kN/m,loss=kN/m"
    told = look(silent, spec)
    assert told["files"] == ["a.csv"]
    assert len(data_of(told["text"])) == 14


def test_a_folder_that_is_none_is_said_at_once(tmp_path: Path):
    with pytest.raises(OptionError, match="no such folder"):
        Workbench(watch=str(tmp_path / "gone"))
    with pytest.raises(DataError, match="cannot be watched"):
        watched(str(tmp_path / "gone"), "", "", "")


@pytest.mark.soak
@IN_A_BROWSER
def test_new_rows_drift_in_and_the_ladder_stays(
    page: Open, bench: Workbench, tmp_path: Path, lines: list[bytes], planned: bytes, monkeypatch
):
    monkeypatch.setattr(bench._behind, "_folder", str(tmp_path))
    monkeypatch.setattr(bench._behind, "_model", "fractional-maxwell")
    file = tmp_path / "a.csv"
    file.write_bytes(b"".join(lines[:12]))
    here = page()
    here.shows("fractional-maxwell")
    file.write_bytes(b"".join(lines) + b"60,2")
    (tmp_path / "b.csv").write_bytes(b"frequency [Hz],sto")
    here.page.locator("#facts:has-text('14 points')").wait_for()
    assert "fractional-maxwell:" in here.reads("#verdict")
    assert here.reads("#watched").startswith(f"Watching {tmp_path.name}: 14 points, 1 file; waits:")
    assert "Measure here next" in here.reads("#decided")
    assert here.page.locator("#odds path").count() > 0
    assert here.violations() == []
    (tmp_path / "c.csv").write_bytes(lines[0] + planned)
    here.page.locator("#decided:has-text('Decided: inertia is missing')").wait_for()
    assert "now inertia > 0.99" in here.page.get_attribute("#odds", "aria-label")
