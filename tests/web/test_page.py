"""The page in a real browser, with the network cut.

The README's story by mouse, by keyboard and on a phone.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import IN_A_BROWSER, PATIENCE, Open, Page, playwright, tab_to
from test_state import a_session

import springpot
from springpot.web import Workbench
from springpot.web.sessions import measured_in

pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
COST_OF_A_PREVIEW = """() => {
    const timed = (work) => {
        const begun = performance.now();
        work();
        return performance.now() - begun;
    };
    // Takes a frame at 60 Hz on the machine on which this was written:
    // a slower one is slower at both.
    const frame = () => {
        let sum = 0;
        for (let i = 0; i < 500_000; i += 1) sum += Math.exp(Math.sin(i));
        return sum;
    };
    const middle = (times) => times.sort((a, b) => a - b)[Math.floor(times.length / 2)];
    const previews = [], yardsticks = [];
    for (const option of [...document.querySelectorAll("#effects [role=option]")].slice(0, 9)) {
        previews.push(timed(() => {
            option.dispatchEvent(new PointerEvent("pointerenter", { pointerType: "mouse" }));
            document.body.getBoundingClientRect();
        }));
        yardsticks.push(timed(frame));
    }
    return [middle(previews), middle(yardsticks)];
}"""


def test_the_readme_story_by_mouse(page: Open, damper: bytes, tmp_path: Path):
    here = page()
    here.open("damper.csv", damper, MODEL)
    assert here.reads("#facts") == "14 points, 1 sweep"
    assert "kN sᵅ/m" in here.reads("#model-body"), "powers are raised"
    before = here.error()

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
    a_preview_costs_less_than_a_frame(here)
    the_next_experiment_stands_on_the_same_screen(here)
    a_slider_moves_the_curve_and_leaves_the_fit(here)
    how_parameters_move_together_is_a_table(here, damper, tmp_path)

    here.page.click("#effect-inertia")
    here.shows(f"{MODEL} + inertia")
    after = here.error()
    assert before > 0.05 > 0.01 > after
    assert "adequate" in here.reads("#verdict")
    assert "inertia and specimen-inertia" in here.reads("#still-open")
    assert here.page.locator("#plot-ladder .rung-mark.accepted").count() == 2
    fits_one_screen(here)

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


def a_preview_costs_less_than_a_frame(here: Page) -> None:
    preview, yardstick = here.page.evaluate(COST_OF_A_PREVIEW)
    assert preview < yardstick, "ms for a preview with its layout, and for a frame's worth of work"
    here.page.hover("#verdict")


def the_next_experiment_stands_on_the_same_screen(here: Page) -> None:
    """At 1280 x 800 nothing must be scrolled for, also while both rivals are drawn."""
    here.page.check("#show-plan")
    assert here.page.locator("#plot-view .line.rival").count() == 4
    assert here.page.locator("#plot-view .band").count() >= 4
    assert here.page.locator("#plot-view .station").count() == 20, "where to measure"
    fits_one_screen(here)
    box = here.page.locator("#plan").bounding_box()
    assert box["y"] + box["height"] < 800
    here.page.uncheck("#show-plan")


def fits_one_screen(here: Page) -> None:
    for column in here.page.locator(".column").all():
        assert column.evaluate("column => column.scrollHeight - column.clientHeight") <= 0


def a_slider_moves_the_curve_and_leaves_the_fit(here: Page) -> None:
    fitted = here.page.get_attribute("#plot-view .line.model.storage", "d")
    before = here.reads("#number")
    here.page.locator("[aria-label='move k']").focus()
    here.page.keyboard.press("ArrowRight")
    here.page.locator("#plot-view .line.edited").first.wait_for(state="attached")
    assert "edited" in here.reads("#edited-says")
    assert here.page.locator("#plot-residual .line.edited").count() == 2
    assert here.page.locator("#plot-ladder .ghost circle").count() == 1
    told = here.reads("#edited-says").split("error ")[1]
    assert told in here.reads("#number")
    assert told not in before, "the number follows while the slider moves"
    assert here.page.get_attribute("#plot-view .line.model.storage", "d") == fitted
    here.page.click("#fit")
    playwright.expect(here.page.locator("#edited-says")).to_contain_text("fitted within these")
    here.done()
    here.page.click("#reset")
    assert here.reads("#number") == before
    assert here.page.locator("#plot-view .line.edited").count() == 0


def how_parameters_move_together_is_a_table(here: Page, damper: bytes, folder: Path) -> None:
    here.page.click("#correlations summary")
    cells = here.page.locator("#correlations tbody tr").first.locator("td").all_inner_texts()
    (folder / "moving.csv").write_bytes(damper)
    covariance = springpot.identify(folder / "moving.csv", MODEL).covariance
    size = np.sqrt(np.diag(covariance))
    others = covariance[0, 1:] / (size[0] * size[1:])
    assert cells == ["1", *(f"{r:.2f}" for r in others)]
    assert here.violations() == []
    here.page.click("#correlations summary")


def leave_with_everything(here: Page, error: float) -> None:
    """Take each thing along that is made at once, and open it."""
    here.page.click("#leave")
    assert here.violations() == []
    _, content = here.download("json")
    answer = json.loads(content)
    assert answer["schema"] == "springpot.discovery/2"
    last = answer["steps"][-1]
    assert last["relative_rms"] == pytest.approx(error, rel=0.01)

    # That it gives these numbers when it is run, is tested where no browser is needed.
    _, script = here.download("script")
    compile(script, "again.py", "exec")
    assert b"accept=['inertia']" in script
    here.context.grant_permissions(["clipboard-read", "clipboard-write"])
    here.page.click("[data-copy=script]")
    playwright.expect(here.page.locator("#done")).to_contain_text("clipboard")
    assert here.page.evaluate("() => navigator.clipboard.readText()") == script.decode()

    _, content = here.download("curves")
    rows = list(csv.reader(io.StringIO(content.decode())))
    assert "with inertia storage [kN/m]" not in rows[0]
    assert {"frequency [Hz]", "omega [rad/s]", "model storage [kN/m]"} <= set(rows[0])
    _, content = here.download("data")
    assert content.startswith(b"# name: damper")
    _, content = here.download("command")
    assert content.decode() == here.reads("#command-line").rstrip("\n") + "\n"
    assert "--accept inertia" in content.decode()
    for plot in ("plot-view", "plot-residual", "plot-ladder"):
        _, content = here.download(f"{plot}-svg")
        assert b"<svg" in content
        assert b"var(--" not in content
        _, content = here.download(f"{plot}-png")
        assert content.startswith(b"\x89PNG")
        assert len(content) > 2000
    _, content = here.download("session")
    session = json.loads(content)
    assert session["schema"] == "springpot.session/1"
    opens_again(here, content)


def opens_again(here: Page, session: bytes) -> None:
    """The session gives the same page in another tab without a history."""
    other = Page(here.context.browser.new_context(), here.bench)
    other.drop("damper-session.json", session)
    other.shows(f"{MODEL} + inertia")
    assert other.reads("#rungs") == here.reads("#rungs")
    assert other.reads("#beside") == here.reads("#beside")
    assert other.reads("#verdict") == here.reads("#verdict")
    other.close()


@pytest.mark.soak
def test_one_leaves_with_a_report(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    here.page.click("#leave")
    name, content = here.download("report")
    assert name == "damper-report.html"
    assert b"effect-missing" in content


@pytest.mark.soak
def test_the_story_by_keyboard_alone(page: Open, damper: bytes):
    here = page()
    press = here.page.keyboard.press
    tab_to(here, "paste-first")
    here.page.keyboard.insert_text("# name: damper\n" + damper.decode())
    press("Tab")
    playwright.expect(here.page.locator("button:focus")).to_be_enabled()
    press("Enter")
    here.shows("material")

    press("/")
    here.page.keyboard.type("fractional-maxwell")
    press("Tab")
    focused = here.page.evaluate("() => document.activeElement.innerText")
    assert focused.startswith(MODEL)
    press("Enter")
    here.shows(MODEL)

    seen = tab_to(here, "effects", "expression")
    assert {"judge", "view", "plane", "plot-view"} <= seen
    press("ArrowDown")
    first = here.page.get_attribute("#effects", "aria-activedescendant")
    assert here.page.get_attribute(f"#{first}", "aria-selected") == "true"
    assert here.page.locator("#plot-view .line.preview").count() == 2
    press("ArrowDown")
    assert here.page.get_attribute("#effects", "aria-activedescendant") != first
    press("ArrowUp")
    press("Enter")
    grown = f"{MODEL} + {first.removeprefix('effect-')}"
    here.shows(grown)
    press("Control+z")
    here.shows(MODEL)
    press("Control+Shift+z")
    here.shows(grown)

    here.page.reload()
    here.shows(grown)
    tab_to(here, "leave")
    press("Enter")
    tab_to(here, "json")
    with here.page.expect_download() as found:
        press("Enter")
    assert found.value.suggested_filename == "pasted.json"
    press("Escape")
    tab_to(here, "branch from fractional-maxwell")
    press("Enter")
    here.shows(MODEL)
    assert here.page.locator(".branches > span").count() == 2

    tab_to(here, "plot-view", "expression")
    press("ArrowRight")
    assert "1.00 Hz" in here.reads("#readout")
    outline = here.page.evaluate("() => getComputedStyle(document.activeElement).outlineWidth")
    assert outline == "3px"
    press("Space")
    assert "1 left out" in here.reads("#facts")
    assert here.page.locator("#plot-view .mark.out").count() == 2
    press("Control+z")
    here.shows(MODEL)
    assert "left out" not in here.reads("#facts")


@pytest.mark.soak
def test_a_phone_in_the_dark(page: Open, damper: bytes):
    here = page(390, 844, has_touch=True, is_mobile=True, color_scheme="dark")
    here.open("damper.csv", damper, MODEL)
    assert here.page.evaluate("() => document.documentElement.scrollWidth") <= 390
    assert here.violations() == []
    here.page.tap("#effect-inertia")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.error() > 0.05
    here.page.evaluate("() => document.querySelector('#accept').scrollIntoView(false)")
    assert here.page.locator("#plot-view").bounding_box()["y"] >= 0, "the picture stays in sight"
    here.page.tap("#accept")
    here.shows(f"{MODEL} + inertia")
    assert here.error() < 0.01


@pytest.mark.soak
def test_what_is_open_or_refused_is_told(page: Open):
    here = page()
    rows = b"".join(b"%d,%d,%d\n" % (i, 9 + i, i) for i in range(1, 9))
    here.drop("mine.csv", b"frequency [Hz],storage,loss\n" + rows)
    here.page.locator("#question").wait_for()
    assert "the unit of storage and loss" in here.reads("#question")
    assert here.page.locator("#question select").count() == 1
    here.page.select_option("#asked-0", label="kPa")
    here.page.click("text=Open with these")
    here.shows("material")
    assert "kPa" in here.reads("#data-body table")
    assert here.page.locator("#redo").get_attribute("title") == "there is nothing to redo"
    before = here.reads("#verdict")

    here.page.evaluate("() => document.querySelector('#open-data').click()")
    here.page.set_input_files(
        "#file-more", {"name": "bad.csv", "mimeType": "text/csv", "buffer": b"hello\nworld\n"}
    )
    here.page.locator("#refused").wait_for()
    assert here.reads("#refused").startswith("bad.csv: ")
    assert here.reads("#verdict") == before  # nothing was lost by it
    here.done()
    here.page.fill("#expression", "kelvn")
    here.page.click("#judge")
    playwright.expect(here.page.locator("#refused")).to_contain_text(
        "did you mean kelvin", timeout=PATIENCE
    )
    here.done()
    assert here.reads("#verdict") == before
    assert here.page.locator("#redo").get_attribute("aria-disabled") == "false", (
        "what was refused can be seen again"
    )


@pytest.mark.soak
def test_a_name_without_end_is_cut_before_a_button_is(page: Open, damper: bytes):
    here = page()
    usual = here.page.locator("header").bounding_box()["height"]
    here.open(f"{'W' * 300}.csv", damper, "kelvin")
    assert here.page.locator("header").bounding_box()["height"] == usual


@pytest.mark.soak
def test_what_only_shows_beside_the_first_effect_is_told_with_it(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, "kelvin")
    mass = here.page.locator("#effect-inertia")
    assert mass.locator(".fall").text_content() == "→ 0.57 % beside"
    mass.hover()
    assert "with series-springpot and it" in here.reads("#effect-details")
    alone = here.page.locator("#effect-series-springpot .fall").text_content()
    assert alone is not None
    assert "beside" not in alone


@pytest.mark.soak
def test_ten_thousand_rows_are_drawn_and_a_computation_is_told_and_cancelled(page: Open):
    here = page()
    rng, frequency = np.random.default_rng(5), np.geomspace(0.1, 100.0, 10_000)
    storage = 100.0 * frequency**0.3 * (1 + 0.01 * rng.normal(size=10_000))
    rows = "".join(
        f"{f:.6g},{k:.6g},{0.4 * k:.6g}\n" for f, k in zip(frequency, storage, strict=True)
    )
    here.drop("many.csv", f"frequency [Hz],storage [kPa],loss [kPa]\n{rows}".encode())
    here.page.locator("#facts").wait_for()
    assert here.reads("#facts") == "10000 points, 1 sweep, 1500 of them can be pointed at"
    assert 4 <= here.page.locator("#plot-view .cloud").count() <= 8, "cells, not points"
    here.page.locator("#work").wait_for()
    playwright.expect(here.page.locator("#stage")).not_to_contain_text(
        "computing", timeout=PATIENCE
    )
    # However fast it is, it is not done before the page has been looked at.
    for worker in here.bench._desk._lanes["long"]:
        if worker._process is not None:
            os.kill(worker._process.pid, signal.SIGSTOP)
    assert re.fullmatch(r".+, \d+\.\d s", here.reads("#stage"))
    assert (
        here.page.locator("#rank").get_attribute("title")
        == "wait for the computation, or cancel it"
    )
    here.page.select_option("#view", "cole-cole")  # the page is not held up meanwhile
    assert "G''" in here.page.text_content("#plot-view")
    here.page.click("#cancel")
    here.done()
    assert here.page.locator("#work").is_hidden()
    assert "10000 points" in here.reads("#facts"), "the data stay, whatever was not computed"


@pytest.mark.soak
def test_three_temperatures_and_the_race(
    page: Open, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    here = page()
    here.drop("gel.csv", three_temperatures())
    here.shows("material")
    assert here.reads("#facts") == "18 points, 3 sweeps"
    assert here.page.locator("#key [class*=sweep-]").all_inner_texts() == ["●"] * 3
    assert "● 0 °C" in here.reads("#key")
    assert "● 40 °C" in here.reads("#key")
    here.page.select_option("#view", "master-curve")
    playwright.expect(here.page.locator("#plot-view .label").first).to_contain_text(
        "reduced frequency", timeout=PATIENCE
    )
    here.done()
    here.page.click("text=Choose rows")
    here.page.locator("text=temperature 0 °C").click()
    playwright.expect(here.page.locator("#facts")).to_contain_text("6 left out", timeout=PATIENCE)
    assert here.page.locator("#plot-view .mark.out").count() == 2 * 6
    assert here.page.locator("#rows-0").is_visible(), "the choice stays open, and keeps the focus"
    assert here.page.evaluate("() => document.activeElement.id") == "rows-0"
    monkeypatch.chdir(tmp_path)
    here.page.click("#tab-race")
    playwright.expect(here.page.locator("#studies")).to_contain_text("springpot run STUDY.py")
    assert here.violations() == []


def three_temperatures() -> bytes:
    """A power law that is the same at each temperature but for its time scale."""
    lines = ["frequency [Hz],storage [kPa],loss [kPa],temperature [degC]"]
    for temperature, a in ((0, 8.0), (20, 1.0), (40, 0.2)):
        for i, f in enumerate(np.geomspace(1.0, 50.0, 6)):
            k = (
                100.0
                * (1j * a * f) ** 0.3
                / (1.0 + (1j * a * f) ** 0.3 / 9.0)
                * (1 + 0.003 * (-1) ** (i * (i + 1) // 2))
            )
            lines.append(f"{f:.5g},{k.real:.6g},{k.imag:.6g},{temperature}")
    return "\n".join([*lines, ""]).encode()


@pytest.mark.soak
def test_time_signals_of_several_files_are_one_test(page: Open):
    here = page()
    time = np.arange(0.0, 2.0, 0.0097)
    buffers = []
    for frequency in range(1, 11):
        stiffness = (1j * frequency) ** 0.4
        motion = np.exp(2j * np.pi * frequency * time)
        rows = zip(time, motion.imag, (stiffness * motion).imag, strict=True)
        text = "time [s],displacement [mm],force [kN]\n" + "".join(
            f"{t:.6g},{x:.3g},{f:.3g}\n" for t, x, f in rows
        )
        buffers.append(
            {"name": f"test{frequency}.csv", "mimeType": "text/csv", "buffer": text.encode()}
        )
    here.page.locator("#dataset-first option").nth(1).wait_for(state="attached")
    here.page.set_input_files("#file-first", buffers)
    playwright.expect(here.page.locator("#facts")).to_contain_text("10 points", timeout=PATIENCE)
    assert "kN/mm" in here.reads("#data-body table")
    here.shows("material")
    assert "adequate" in here.reads("#verdict")
    assert here.page.locator("#plot-view .mark").count() == 20


@pytest.mark.soak
def test_a_lost_server_is_told_and_the_page_stays(browser: Any, named: Workbench):
    context = browser.new_context()
    here = Page(context, named)
    here.shows(MODEL)
    named.close()
    here.page.locator("#lost").wait_for()
    here.page.hover("#effect-inertia")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    context.close()


@pytest.mark.soak
@pytest.mark.parametrize("view", [{"view": "of a later version"}, {"plane": 3, "plan": "x"}])
def test_a_session_with_an_unknown_view_is_opened_with_the_usual_one(
    page: Open, damper: bytes, view: dict[str, Any]
):
    here = page()
    session = a_session(measured_in("damper.csv", damper)[0]) | {"view": view}
    here.drop("session.json", json.dumps(session).encode())
    here.shows(f"{MODEL} + inertia")
    assert here.page.locator("#plot-view .mark").count() > 0
    here.page.reload()
    here.shows(f"{MODEL} + inertia")
    assert here.page.input_value("#view") == "storage-loss"


@pytest.mark.soak
def test_after_a_restart_the_printed_address_goes_on_in_the_same_tab(browser: Any, damper: bytes):
    first = Workbench().start()
    context = browser.new_context()
    here, port = Page(context, first), first.port
    here.open("damper.csv", damper, MODEL)
    first.close()
    here.page.locator("#lost").wait_for()
    second = Workbench(port=port).start()
    here.page.goto(second.address)
    here.page.locator("#lost").wait_for(state="hidden")
    here.done()
    assert "token" not in here.page.url
    here.judge("fractional-kelvin")
    context.close()
    second.close()
