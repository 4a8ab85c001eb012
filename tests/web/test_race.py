"""The second page: studies that were run in the folder of the workbench."""

from __future__ import annotations

from pathlib import Path

import pytest

from springpot.benchmark import Study, run_study
from springpot.errors import DataError
from springpot.web.studies import report_of, studies, study


def test_a_study_is_told_with_its_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    assert studies() == []
    told = ["artificial-fractional-zener"], ["own"], ["relative"], ["native", "nlopt-sbplx"]
    run_study(Study("small", *told, repetitions=2, budget=100), engine="serial", quiet=True)
    (found,) = studies()
    assert (found["name"], found["cells"], found["done"], found["failed"]) == ("small", 2, 4, 0)
    assert found["total"] == 2 * 2
    report = report_of("small")
    assert report["name"] == "small-report.html"
    assert "nlopt-sbplx" in report["text"]
    tables = study("small")["tables"]
    assert any("native" in cell for table in tables for row in table["rows"] for cell in row)
    assert all(isinstance(cell, str) for table in tables for row in table["rows"] for cell in row)


@pytest.mark.parametrize("name", ["../secret", "/etc", "", "small"])
def test_no_name_leads_out_of_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DataError, match="no study"):
        study(name)


def test_a_broken_store_is_told_of_and_hides_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results" / "broken"
    folder.mkdir(parents=True)
    (folder / "broken.sqlite").write_bytes(b"no database")
    (found,) = studies()
    assert found["name"] == "broken"
    assert found["says"]
