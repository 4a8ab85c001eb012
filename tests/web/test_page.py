"""The page in a real browser, with the network cut: the README's story by mouse, by keyboard and on a phone."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from springpot.report.html import report_html
from springpot.web import Workbench
from springpot.web.answers import ladder_of
from springpot.web.datatext import measured_in
from springpot.web.state import State, digest_of

playwright = pytest.importorskip("playwright.sync_api", reason="the extra 'browser' is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here: 'apt-get install chromium'")

PATIENCE = 300_000
MODEL = "fractional-maxwell"
COST_OF_A_PREVIEW = """() => {
    const timed = (work) => {
        const begun = performance.now();
        work();
        return performance.now() - begun;
    };
    // Takes a frame at 60 Hz on the machine on which this was written: a slower one is slower at both.
    const frame = () => {
        let sum = 0;
        for (let i = 0; i < 500_000; i += 1) sum += Math.exp(Math.sin(i));
        return sum;
    };
    const middle = (times) => times.sort((a, b) => a - b)[Math.floor(times.length / 2)];
    const previews = [], yardsticks = [];
    for (const option of document.querySelectorAll("#effects li")) {
        previews.push(timed(() => {
            option.dispatchEvent(new PointerEvent("pointerenter", { pointerType: "mouse" }));
            document.body.getBoundingClientRect();
        }));
        yardsticks.push(timed(frame));
    }
    return [middle(previews), middle(yardsticks)];
}"""
Open = Callable[..., Any]


class Page:
    """A page of the workbench, and every request that it made."""

    def __init__(self, context: Any, bench: Workbench) -> None:
        self.requests: list[str] = []
        self.faults: list[str] = []
        self.context, self.bench = context, bench
        context.on("request", lambda request: self.requests.append(request.url))
        self.page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", lambda said: self.faults.append(said.text) if said.type == "error" else None)
        self.page.goto(bench.address)

    def done(self) -> None:
        """Wait until nothing is computed any more."""
        self.page.locator("body:not([aria-busy])").wait_for(state="attached")

    def drop(self, name: str, content: bytes) -> None:
        """Drop a file on the page as a hand does."""
        self.page.locator("#model-body #judge").wait_for()
        self.page.evaluate(
            """([name, text]) => {
                const files = new DataTransfer();
                files.items.add(new File([text], name));
                const drop = { dataTransfer: files, bubbles: true, cancelable: true };
                document.body.dispatchEvent(new DragEvent("drop", drop));
            }""",
            [name, content.decode()],
        )

    def judge(self, model: str) -> None:
        """Name a model."""
        self.done()
        self.page.fill("#expression", model)
        self.page.press("#expression", "Enter")
        self.shows(model)

    def shows(self, expression: str) -> None:
        """Wait for the answer on a model."""
        playwright.expect(self.page.locator("#verdict")).to_contain_text(f"{expression}:", timeout=PATIENCE)
        self.done()

    def error(self) -> float:
        """Of the present rung, as a share of |K|."""
        told = re.search(r"([\d.]+) %", self.page.inner_text("#rungs li.last"))
        assert told is not None
        return float(told[1]) / 100

    def download(self, kind: str) -> tuple[str, bytes]:
        """What a button of the leaving dialog gives."""
        with self.page.expect_download() as found:
            self.page.click(f'[data-leave="{kind}"]')
        return found.value.suggested_filename, Path(found.value.path()).read_bytes()

    def reads(self, selector: str) -> str:
        """Text of an element."""
        text: str = self.page.inner_text(selector)
        return text

    def violations(self) -> list[str]:
        """What axe-core finds."""
        axe = pytest.importorskip("axe_core_python.base", reason="the extra 'browser' is not installed")
        self.page.evaluate(axe.AXE_SCRIPT)
        found = self.page.evaluate("() => axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa'] })")
        return [f"{one['id']}: {one['nodes'][0]['html'][:160]}" for one in found["violations"]]

    def close(self) -> None:
        """Nothing went wrong, and nothing left this machine."""
        assert self.faults == []
        assert [url for url in self.requests if not url.startswith(("http://127.0.0.1:", "data:", "blob:"))] == []
        self.context.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        # Any name is nowhere: whatever the page asks of another machine fails, and is seen among its requests.
        cut = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--disable-gpu"]
        running = driver.chromium.launch(executable_path=CHROMIUM, args=cut)
        yield running
        running.close()


@pytest.fixture
def page(browser: Any, bench: Workbench) -> Iterator[Open]:
    opened: list[Page] = []

    def open_page(width: int = 1280, height: int = 800, **settings: Any) -> Page:
        context = browser.new_context(viewport={"width": width, "height": height}, **settings)
        opened.append(Page(context, bench))
        return opened[-1]

    yield open_page
    for one in opened:
        one.close()


def test_the_readme_story_by_mouse(page: Open, damper: bytes):
    here = page()
    here.drop("damper.csv", damper)
    here.shows("material")
    assert here.reads("#facts") == "14 points, 1 sweep"
    here.judge(MODEL)
    before = here.error()
    assert here.violations() == []

    # Preview: a dashed curve and an error, from what is in the page, without a trace.
    asked = len(here.requests)
    here.page.hover("#effect-inertia")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.page.locator("#plot-residual .line.preview").count() == 2
    assert "0.57" in here.page.text_content("#plot-ladder .ghost")
    assert "specimen-inertia" in here.reads("#effect-details")
    here.page.mouse.move(640, 300)
    assert here.page.locator("#plot-view .line.preview").count() == 0
    assert [url for url in here.requests[asked:] if "/api/" in url] == []
    assert here.error() == before

    here.page.click("#effect-inertia")
    here.shows(f"{MODEL} + inertia")
    after = here.error()
    assert before > 0.05 > 0.01 > after
    assert "adequate" in here.reads("#verdict")
    assert here.page.locator("#plot-ladder .rung-mark.accepted").count() == 2
    assert here.violations() == []

    here.page.keyboard.press("Control+z")
    here.shows(MODEL)
    assert here.error() == before
    here.page.click("#redo")
    here.shows(f"{MODEL} + inertia")

    here.page.click("button[aria-label='branch from fractional-maxwell']")
    here.shows(MODEL)
    here.page.hover("#effect-specimen-inertia")
    here.page.click("#effect-specimen-inertia")
    here.shows(f"{MODEL} + specimen-inertia")
    assert "+ inertia" in here.reads("#beside")
    assert here.page.locator("#plot-view .line.beside").count() == 2
    here.page.click(".branches button:text-is('Branch A')")
    here.shows(f"{MODEL} + inertia")

    here.page.reload()
    here.shows(f"{MODEL} + inertia")
    assert here.error() == after
    assert here.page.locator(".branches > span").count() == 2
    leave_with_everything(here, after)


def leave_with_everything(here: Page, error: float) -> None:
    """Take each thing along, and open it."""
    here.page.click("#leave")
    assert here.violations() == []
    name, content = here.download("json")
    answer = json.loads(content)
    assert answer["schema"] == "springpot.discovery/1"
    last = answer["steps"][-1]
    assert last["relative_rms"] == pytest.approx(error, rel=0.01)

    # That it gives these numbers when it is run, is tested where no browser is needed.
    _, content = here.download("script")
    compile(content, "again.py", "exec")
    assert b"accept=['inertia']" in content

    _, content = here.download("curves")
    rows = list(csv.reader(io.StringIO(content.decode())))
    assert "with inertia storage [kN/m]" not in rows[0]
    assert {"frequency [Hz]", "omega [rad/s]", "model storage [kN/m]"} <= set(rows[0])
    _, content = here.download("data")
    assert content.startswith(b"# name: damper")
    _, content = here.download("command")
    assert content.decode() == here.reads("#command-line").rstrip("\n") + "\n"
    assert "--accept inertia" in content.decode()
    name, content = here.download("report")
    assert name == "damper-report.html"
    assert b"fractional-maxwell + inertia" in content
    for plot in ("plot-view", "plot-residual", "plot-ladder"):
        _, content = here.download(f"{plot}-svg")
        assert b"<svg" in content
        assert b"var(--" not in content
        _, content = here.download(f"{plot}-png")
        assert content.startswith(b"\x89PNG")
        assert len(content) > 2000
    name, content = here.download("session")
    session = json.loads(content)
    assert session["schema"] == "springpot.session/1"
    opens_again(here, content)


def opens_again(here: Page, session: bytes) -> None:
    """The session gives the same page in another browser."""
    other = Page(here.context.browser.new_context(), here.bench)
    other.drop("damper-session.json", session)
    other.shows(f"{MODEL} + inertia")
    assert other.reads("#rungs") == here.reads("#rungs")
    assert other.reads("#beside") == here.reads("#beside")
    assert other.reads("#verdict") == here.reads("#verdict")
    other.close()


def test_the_story_by_keyboard_alone(page: Open, damper: bytes):
    here = page()
    press = here.page.keyboard.press
    here.page.locator("#paste-first").focus()
    here.page.keyboard.insert_text(damper.decode())
    press("Tab")
    press("Enter")
    here.shows("material")

    press("/")
    here.page.keyboard.type("fractional-maxwell")
    press("Tab")
    focused = here.page.evaluate("() => document.activeElement.innerText")
    assert focused.startswith(MODEL)
    press("Enter")
    here.shows(MODEL)

    here.page.locator("#expression").focus()
    seen = set()
    for _ in range(60):  # the list is within reach of Tab, and so is all that lies before it
        press("Tab")
        seen.add(here.page.evaluate("() => document.activeElement.id"))
        if "effects" in seen:
            break
    assert {"judge", "view", "plane", "plot-view", "effects"} <= seen
    press("ArrowDown")
    first = here.page.get_attribute("#effects", "aria-activedescendant")
    assert here.page.get_attribute(f"#{first}", "aria-selected") == "true"
    assert here.page.locator("#plot-view .line.preview").count() == 2
    press("ArrowDown")
    assert here.page.get_attribute("#effects", "aria-activedescendant") != first
    press("ArrowUp")
    press("Enter")
    here.shows(f"{MODEL} + {first.removeprefix('effect-')}")
    press("Control+z")
    here.shows(MODEL)

    here.page.locator("#plot-view").focus()
    press("ArrowRight")
    assert "1.00 Hz" in here.reads("#readout")
    press("Space")
    here.done()
    assert "1 left out" in here.reads("#facts")
    assert here.page.locator("#plot-view .mark.out").count() == 2
    outline = here.page.evaluate("() => getComputedStyle(document.activeElement).outlineWidth")
    assert outline == "3px"


def test_a_phone_in_the_dark(page: Open, damper: bytes):
    here = page(390, 844, has_touch=True, is_mobile=True, color_scheme="dark")
    here.drop("damper.csv", damper)
    here.judge(MODEL)
    assert here.page.evaluate("() => document.documentElement.scrollWidth") <= 390
    assert here.violations() == []
    here.page.tap("#effect-inertia")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.error() > 0.05
    here.page.tap("#accept")
    here.shows(f"{MODEL} + inertia")
    assert here.error() < 0.01


def test_a_preview_costs_less_than_a_frame_and_a_slider_little_more(page: Open, damper: bytes):
    here = page()
    here.drop("damper.csv", damper)
    here.judge(MODEL)
    preview, yardstick = here.page.evaluate(COST_OF_A_PREVIEW)
    assert preview < yardstick, "ms for a preview with its layout, and for a frame's worth of work"
    before = here.page.get_attribute("#plot-view .line.model.storage", "d")
    slider = here.page.locator("[aria-label='move k']")
    slider.focus()
    here.page.keyboard.press("ArrowRight")
    here.page.locator("#plot-view .line.edited").first.wait_for(state="attached")
    assert "edited" in here.reads("#edited-says")
    assert here.page.get_attribute("#plot-view .line.model.storage", "d") == before
    here.page.click("#fit")
    playwright.expect(here.page.locator("#edited-says")).to_contain_text("fitted within these")
    here.done()
    here.page.click("#reset")
    assert here.page.locator("#plot-view .line.edited").count() == 0


def test_what_is_open_refused_or_cancelled_is_told(page: Open, damper: bytes):
    here = page()
    here.drop(
        "mine.csv", b"frequency [Hz],storage,loss\n" + b"".join(b"%d,%d,%d\n" % (i, 9 + i, i) for i in range(1, 9))
    )
    here.page.locator("#question").wait_for()
    here.page.select_option("#asked-0", "kPa")
    here.page.select_option("#asked-1", "kPa")
    here.page.click("text=Open with these")
    here.shows("material")
    assert "kPa" in here.reads("#data-body table")
    before = here.reads("#verdict")

    here.page.evaluate("() => document.querySelector('#open-data').click()")
    here.page.set_input_files("#file-more", {"name": "bad.csv", "mimeType": "text/csv", "buffer": b"hello\nworld\n"})
    here.page.locator("#data .error").wait_for()
    assert here.reads("#data .error").startswith("bad.csv: ")
    assert here.reads("#verdict") == before  # nothing was lost by it

    here.judge(MODEL)
    here.page.click("#rank")
    here.page.locator("#work").wait_for()
    here.page.hover("#effect-inertia")  # what was answered before can be looked at meanwhile
    assert here.page.locator("#plot-view .line.preview").count() == 2
    here.page.click("#cancel")
    here.done()
    assert here.reads("#verdict").startswith(f"{MODEL}:")
    here.page.click("#leave")
    here.page.keyboard.press("Escape")
    assert here.page.locator("#redo").get_attribute("title") == "there is nothing to redo"


def test_a_set_of_several_temperatures_and_the_race(page: Open):
    here = page()
    here.page.locator("#dataset-first option[value=nist-srm2491]").wait_for(state="attached")
    here.page.select_option("#dataset-first", "nist-srm2491")
    here.page.click("text=Open set")
    here.shows("material")
    assert here.page.locator("#key .swatch").count() == 6
    here.page.select_option("#view", "master-curve")
    playwright.expect(here.page.locator("#plot-view .label").first).to_contain_text(
        "reduced frequency", timeout=PATIENCE
    )
    here.done()
    here.page.click("text=Choose rows")
    here.page.locator("text=temperature 0 °C").click()
    here.done()
    assert "16 left out" in here.reads("#facts")
    here.page.click("#tab-race")
    playwright.expect(here.page.locator("#studies")).to_contain_text("springpot run STUDY.py")
    assert here.violations() == []


def test_a_lost_server_is_told_and_the_page_stays(browser: Any, damper: bytes):
    running = Workbench().start()
    context = browser.new_context()
    here = Page(context, running)
    here.drop("damper.csv", damper)
    here.shows("material")
    running.close()
    here.page.locator("#lost").wait_for()
    here.page.hover("#effect-inertia")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    context.close()


def test_the_report_is_the_page_with_its_hovers_and_needs_no_server(browser: Any, damper: bytes, tmp_path: Path):
    pytest.importorskip("matplotlib")
    measurement = replace(measured_in("damper.csv", damper)[0], name="</script><script>alert(1)</script>")
    ladder = ladder_of(State(digest_of(damper.decode()), MODEL, ("inertia",)), measurement)
    (tmp_path / "report.html").write_text(report_html(ladder, measurement, ["springpot", "<b>"]), encoding="utf-8")
    context = browser.new_context(offline=True)
    page, faults = context.new_page(), []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    page.goto((tmp_path / "report.html").as_uri())
    assert measurement.name in page.inner_text("main")
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
    assert page.inner_text("#verdict").startswith(f"{MODEL}: effect-missing"), "a report accepts nothing"
    assert faults == []
    context.close()
