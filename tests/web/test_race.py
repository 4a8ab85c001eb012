"""The second page: studies that were run in the folder of the workbench."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from browsing import IN_A_BROWSER, Open

from springpot.benchmark import Study, run_study
from springpot.errors import DataError
from springpot.web.folders import report_of, studies, study


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
    reached = study("small")["attained"]
    assert set(reached["shares"]) == {"native", "nlopt-sbplx"}
    for shares in reached["shares"].values():
        assert len(shares) == len(reached["evaluations"])
        assert shares == sorted(shares), "what was reached stays reached"
        assert 0.0 <= shares[0] <= shares[-1] <= 1.0
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


COLOURS = "racers => racers.map((racer) => racer.style.borderLeftColor)"


def told(name: str, **costs: int) -> dict[str, Any]:
    """A study as the page is told of it."""
    table = {"title": f"{name}: cost", "columns": ["optimiser", "cost"], "note": ""}
    rows = [[optimiser, str(cost)] for optimiser, cost in costs.items()]
    shares = {optimiser: [0.0, 1.0 / cost, 1.0] for optimiser, cost in costs.items()}
    counts = {"cells": 2, "total": 4, "done": 4, "failed": 0, "started": "today", "says": ""}
    reached = {"evaluations": [1, 10, 100], "shares": shares}
    return {"name": name, **counts, "tables": [{**table, "rows": rows}], "attained": reached}


@pytest.mark.soak
@IN_A_BROWSER
def test_two_studies_stand_side_by_side_and_a_click_sorts_a_table(page: Open):
    """Numbers are sorted by size, up and down; each study has its curves of accuracy."""
    here = page()
    raced = {"one": told("one", swarm=90, native=8), "two": told("two", native=9, swarm=100)}

    def answer(route: Any) -> None:
        asked = route.request.post_data_json.get("name")
        result = raced[asked] if asked else {"studies": list(raced.values())}
        route.fulfill(body=json.dumps({"result": result}) + "\n")

    here.page.route("**/api/race", answer)
    here.page.click("#tab-race")
    here.page.click("text=Tables of one")
    column = here.page.locator("#study td:nth-child(2)")
    column.first.wait_for()
    assert column.all_inner_texts() == ["90", "8"]
    sort = here.page.locator("#study .sort", has_text="cost")
    sort.click()
    assert column.all_inner_texts() == ["8", "90"]
    sort.click()
    assert column.all_inner_texts() == ["90", "8"]
    assert here.page.locator("#plot-attained-one path.line").count() == 2
    here.page.click("text=Put two beside")
    here.page.locator("#plot-attained-two").wait_for()
    assert here.page.locator("#study h2").all_inner_texts()[0] == "one"
    assert here.page.locator("#plot-attained-one").count() == 1
    for name in raced["one"]["attained"]["shares"]:
        colours = here.page.locator("#study .racer", has_text=name).evaluate_all(COLOURS)
        assert len(colours) == 2
        assert len(set(colours)) == 1, "of one colour in both"
    here.page.locator("#study .racer", has_text="swarm").first.hover()
    assert here.page.locator("#plot-attained-one .preview-layer path").count() == 1
    assert here.violations() == []
