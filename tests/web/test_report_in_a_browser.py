"""The report of a ladder as one opens it: without a server, on any screen."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import IN_A_BROWSER, SMALL, playwright, violations_on

import springpot
from springpot.report.html import report_html
from springpot.web.sessions import measured_in
from unpainted import leave_unpainted

pytest.importorskip("matplotlib")
pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
Shown = Callable[..., Any]


@pytest.fixture(scope="module")
def report(damper: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a ladder of two rungs."""
    data = measured_in("damper.csv", damper)[0]
    only = ["inertia", "specimen-inertia", "time-delay"]
    ladder = springpot.discover(data, MODEL, accept=["inertia"], only=only)
    path = tmp_path_factory.mktemp("report") / "report.html"
    with pytest.MonkeyPatch.context() as patch:
        # Most of the work, and nobody looks at them here.
        leave_unpainted(patch)
        path.write_text(report_html(ladder, data, ["springpot"]), encoding="utf-8")
    return path


@pytest.fixture
def shown(browser: Any, report: Path) -> Iterator[Shown]:
    opened = []

    def show(width: int, height: int = 800, **settings: Any) -> Any:
        context = browser.new_context(
            viewport={"width": width, "height": height}, offline=True, **settings
        )
        opened.append(context)
        page = context.new_page()
        page.goto(report.as_uri())
        return page

    yield show
    for context in opened:
        context.close()


@pytest.mark.soak_cases("390-dark", "1024-light")
@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (390, "dark"), (1024, "light")])
def test_whoever_sees_hears_or_types_can_read_it(shown: Shown, width: int, scheme: str):
    assert violations_on(shown(width, color_scheme=scheme)) == []


@pytest.mark.soak
def test_a_claim_is_not_cut_and_a_finger_can_choose(shown: Shown):
    desk = shown(1024)
    cut = "says => says.scrollHeight > says.clientHeight"
    assert not desk.locator("#verdict").evaluate(cut)
    phone = shown(390, 844, has_touch=True, is_mobile=True)
    assert phone.evaluate(SMALL) == []
    phone.locator("#rung-0").tap()
    assert "Tap one" in phone.inner_text("#missing")


def test_the_ladder_is_played_and_scrubbed(shown: Shown):
    page = shown(1024)
    page.locator("#scrub").press("Home")
    assert page.inner_text("#verdict").startswith(f"{MODEL}: effect-missing")
    assert page.inner_text("#number .big") == "8.5 ×"
    page.locator("#scrub").press("ArrowRight")
    assert page.inner_text("#verdict").startswith(f"{MODEL} + inertia: adequate")
    page.click("#play")
    assert page.locator("#scrub").input_value() == "0"


def test_it_is_the_page_with_its_hovers(browser: Any, report: Path, tmp_path: Path):
    """Without a server and without a network, whatever the data are called."""
    evil = "</script><script>alert(1)</script>"
    escaped = json.dumps(evil).replace("<", "\\u003c")
    told = report.read_text(encoding="utf-8")
    renamed = told.replace('"name": "damper"', f'"name": {escaped}')
    assert renamed != told
    path = tmp_path / "report.html"
    path.write_text(renamed, encoding="utf-8")
    context = browser.new_context(offline=True)
    page, faults = context.new_page(), []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    page.goto(path.as_uri())
    assert page.locator("#plot-ladder .rung-mark.accepted").count() == 2
    assert page.inner_text("#verdict").startswith(f"{MODEL} + inertia: adequate")
    page.click("#rungs button >> nth=0")
    assert page.inner_text("#verdict").startswith(f"{MODEL}: effect-missing")
    page.hover("#effect-inertia")
    assert page.locator("#plot-view .line.preview").count() == 2
    assert "0.57" in page.text_content("#plot-ladder .ghost")
    page.select_option("#plane", "log-complex")
    assert "Δ ln K" in page.text_content("#plot-residual")
    page.click("#effect-inertia")
    assert page.locator("#accept").is_hidden()
    assert page.inner_text("#verdict").startswith(f"{MODEL}: effect-missing"), (
        "a report accepts nothing"
    )
    page.click("#play")
    playwright.expect(page.locator("#rung-0")).to_have_attribute("aria-current", "step")
    playwright.expect(page.locator("#rung-1")).to_have_attribute("aria-current", "step")
    assert faults == []
    context.close()


@pytest.mark.soak
def test_tests_in_time_are_played_each_on_its_own_axes(browser: Any, tmp_path: Path):
    rng, time = np.random.default_rng(5), np.geomspace(0.05, 5.0, 20)
    tests = [
        springpot.TimeTest.of_relaxation(time, (2.0 * np.exp(-time) + 1.0) * noise, name=name)
        for name, noise in zip(("one", "other"), 1.0 + 0.01 * rng.normal(size=(2, 20)), strict=True)
    ]
    only = ["parallel-spring", "parallel-springpot"]
    ladder = springpot.discover(tests, "maxwell", accept=["parallel-spring"], only=only)
    (tmp_path / "report.html").write_text(report_html(ladder, tests, ["springpot"]), "utf-8")
    context = browser.new_context(viewport={"width": 1024, "height": 800}, offline=True)
    page = context.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto((tmp_path / "report.html").as_uri())
    page.select_option("#view", label="other: stress over time")
    page.select_option("#second", label="and one: stress over time")
    page.fill("#scrub", "0")
    assert page.inner_text("#verdict").startswith("maxwell: ")
    page.locator("[data-effect='parallel-spring']").hover()
    assert page.locator("#plot-second .line.preview").count() == 1
    page.click("#play")
    page.wait_for_function("() => document.querySelector('#scrub').value === '1'")
    assert "maxwell + parallel-spring" in page.inner_text("#key")
    assert faults == []
    assert violations_on(page) == []
    context.close()
