"""What a picture shows: closer and farther, entries hidden, below zero, residuals that fall."""

from __future__ import annotations

from itertools import pairwise
from time import perf_counter

import pytest
from browsing import IN_A_BROWSER, SMALL, Open, Page, playwright

pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
PLACES = """() => [...document.querySelectorAll("#plot-view circle.mark")]
    .map((mark) => mark.getAttribute("cx"))"""
SHORTENED = """() => {
    const claim = document.querySelector("#fails");
    return claim.scrollHeight > claim.clientHeight + 1;
}"""
TOPMOST = """() => {
    const plot = document.querySelector("#plot-residual");
    const marks = [...plot.querySelectorAll(".mark:not(.ghost)")];
    const centre = (mark) => { const box = mark.getBBox(); return box.y + box.height / 2; };
    const zero = plot.querySelector(".line.zero").getBBox().y;
    return Math.max(...marks.map((mark) => Math.abs(centre(mark) - zero)));
}"""
# Of lists to choose from, those whose choice is wider than they are.
CUT = """lists => {
    const pen = document.createElement("canvas").getContext("2d");
    return lists.filter((list) => {
        pen.font = getComputedStyle(list).font;
        return pen.measureText(list.selectedOptions[0].text).width + 16 > list.clientWidth;
    }).map((list) => list.id);
}"""
# Of a ladder whose errors stand close together.
TICKS = """async () => {
    const { Ladder } = await import("/page/ladder.js");
    return Ladder.prototype.ticks(7.5e-6, 1.5e-5)[1];
}"""
BOXES = """() => [...document.querySelectorAll("#effects, #accept, #law, #next, .plot")]
    .map((each) => JSON.stringify(each.getBoundingClientRect()))"""
FRAMES = """() => new Promise((done) => {
    requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)));
})"""


def test_the_claim_is_one_number_one_sentence_one_button(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    assert here.reads("#number .big") == "8.5 ×"
    claim = here.reads("#fails")
    assert claim.startswith("The model's storage stiffness 8.3 %")
    assert claim.endswith("above 36 Hz. Inertia (m = 0.60 kg) would explain it.")
    assert not here.page.evaluate(SHORTENED), "the claim is read whole"
    assert here.page.locator("#plot-residual .mark.ghost").count() == 0
    before = here.page.evaluate(TOPMOST)

    here.page.click("#add")
    here.shows(f"{MODEL} + inertia")
    assert here.reads("#number .big").startswith("0.9")
    assert here.page.locator("#add").is_hidden()
    # On the axis of the first rung, and beside what it left.
    assert here.page.evaluate(TOPMOST) < 0.5 * before
    assert here.page.locator("#plot-residual .mark.ghost").count() == 28
    replayed(here)
    here.page.click("#sigmas")
    assert "data − model) / σ" not in here.page.text_content("#plot-residual")


def replayed(here: Page) -> None:
    """The ladder is looked at from its foot; it stays, and so do undo and redo."""
    here.page.locator("#scrub").press("Home")
    playwright.expect(here.page.locator("#rung-0")).to_have_attribute("aria-current", "step")
    assert here.reads("#number .big") == "8.5 ×"
    assert here.page.locator("#plot-residual .mark.ghost").count() == 0
    assert here.page.locator("#plot-ladder .rung-mark.accepted").count() == 2
    assert here.page.locator("#redo").get_attribute("aria-disabled") == "true"
    here.page.locator("#scrub").press("End")
    assert here.reads("#number .big").startswith("0.9")
    here.page.click("#play")
    for rung in (0, 1):
        shown = here.page.locator(f"#rung-{rung}")
        playwright.expect(shown).to_have_attribute("aria-current", "step")
    assert here.page.locator("#scrub").input_value() == "1"


LIT = "things => things.map((thing) => thing.classList.contains('lit'))"
# Rows that light up for a place, of two temperatures at three frequencies each.
ROWS = """async (levels) => {
    const { spotOf } = await import("/page/spots.js");
    const omega = [1, 10, 100, 1, 10, 100].map((hertz) => hertz * 2 * Math.PI);
    const conditions = { temperature: [20, 20, 20, 40, 40, 40.1] };
    const scene = { rows: [0, 1, 2, 3, 4, 5], omega, conditions };
    return [...spotOf({ from: 5, to: 100 }, { part: "storage", levels }, scene).rows];
}"""


@pytest.mark.soak
def test_sentence_bar_and_points_light_up_together(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    sentences, bars = here.page.locator("#places li"), here.page.locator("#plot-residual .bar")

    def lit() -> tuple[list[bool], list[bool]]:
        groups = here.page.locator("#plot-residual g:has(> .bar)").evaluate_all(LIT)
        return sentences.evaluate_all(LIT)[: bars.count()], groups

    # Where the model is too high, data less model is negative: in words, picture and beside it.
    # A share of |K|, as everywhere: of the loss alone it is another number.
    too_high = "Δ < 0: the model's storage stiffness 8.3 % of |K| too"
    assert sentences.first.inner_text().startswith(too_high)
    assert "Δ = data − model" in here.page.text_content("#plot-residual")
    first = [True, False, False]
    rings = here.page.locator("#plot-view .ring.chosen")
    sentences.first.hover()
    assert lit() == (first, first)
    assert rings.count() == 3, "of storage alone, above 36 Hz"
    here.page.hover("#hero")
    assert lit() == ([False] * 3, [False] * 3)
    bars.first.hover()
    assert lit() == (first, first)
    assert rings.count() == 2, "beside the row under the pointer itself"
    here.page.locator("#plot-view .mark.loss").last.hover(force=True)
    assert "data − model −" in here.reads("#readout")
    assert lit()[0][:2] == [True, True]
    assert lit()[0] == lit()[1]


def test_a_sentence_about_one_temperature_lights_only_its_sweep(page: Open):
    here = page()
    for levels, rows in (
        ({}, [1, 2, 4, 5]),
        ({"temperature": [20, 20]}, [1, 2]),
        ({"temperature": [40, 40.1]}, [4, 5]),
        ({"temperature": [20, 40.1]}, [1, 2, 4, 5]),
        ({"amplitude": [0.1, 0.1], "temperature": [20, 20]}, [1, 2]),
    ):
        assert here.page.evaluate(ROWS, levels) == rows


def test_a_page_is_light(page: Open):
    """All that one load fetches, in bytes as they cross."""
    here = page()
    here.page.locator("#dataset-first option").nth(1).wait_for(state="attached")
    weights = here.page.evaluate(
        "() => performance.getEntries().map((entry) => entry.decodedBodySize || 0)"
    )
    assert len(weights) > 20
    assert 100_000 < sum(weights) <= 350_000


@pytest.mark.soak
def test_a_class_is_one_card_until_what_decides_is_measured(
    page: Open, damper: bytes, planned: bytes
):
    here = page()
    here.open("damper.csv", damper, MODEL)
    card = here.page.locator(".card").first
    assert card.locator("[role=option] .name").all_inner_texts() == ["inertia", "specimen-inertia"]
    assert "told apart by the next experiment" in card.inner_text()
    assert card.locator(".spark circle").count() == 28
    before = here.page.evaluate(BOXES)
    for option in here.page.locator("[role=option]:visible").all():
        option.hover()
        assert here.page.evaluate(BOXES) == before, "nothing moves while one points"
    folded = here.page.locator("[data-shelf='ruled-out'] [role=option]")
    assert folded.count() > 0
    assert not folded.first.is_visible()
    here.page.click("#fold")
    assert folded.first.is_visible()
    assert here.violations() == []
    here.page.click("text=Add its data")
    measured = {
        "name": "next.csv",
        "mimeType": "text/csv",
        "buffer": damper.splitlines(True)[0] + planned,
    }
    here.page.set_input_files("#open-dialog input[type=file]", measured)
    here.page.locator("#facts:has-text('34 points')").wait_for()
    here.done()
    assert here.reads("#verdict").endswith("missing is inertia.")
    assert card.locator("[role=option] .name").all_inner_texts() == ["inertia"]
    assert "Nothing is open" in here.reads("#next-body")


def places_of(here: Page) -> list[str]:
    """Where the points are drawn."""
    found: list[str] = here.page.evaluate(PLACES)
    return found


def by_wheel(here: Page) -> None:
    here.page.hover("#plot-view")
    here.page.mouse.wheel(0, -100)


def by_key(here: Page) -> None:
    here.page.focus("#plot-view")
    here.page.keyboard.press("+")


def by_button(here: Page) -> None:
    here.page.click("button[aria-label='closer (or the wheel)']")


def by_shift_and_drag(here: Page) -> None:
    box = here.page.locator("#plot-view").bounding_box()
    here.page.mouse.move(box["x"] + 200, box["y"] + 80)
    here.page.keyboard.down("Shift")
    here.page.mouse.down()
    here.page.mouse.move(box["x"] + 240, box["y"] + 100)
    here.page.mouse.up()
    here.page.keyboard.up("Shift")


@pytest.mark.soak
def test_a_picture_comes_closer_and_goes_back(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    whole = places_of(here)
    for way in (by_wheel, by_key, by_button):
        way(here)
        here.page.locator("#whole").wait_for()
        closer = places_of(here)
        assert closer != whole, way.__name__
        here.page.focus("#plot-view")
        here.page.keyboard.press("Alt+ArrowRight")
        moved = places_of(here)
        assert moved != closer
        by_shift_and_drag(here)
        assert places_of(here) != moved
        assert here.page.locator("#exclude").is_hidden(), "points are moved, not chosen"
        here.page.keyboard.press("0")
        assert places_of(here) == whole
    by_button(here)
    here.page.click("#whole")
    assert places_of(here) == whole


@pytest.mark.soak
def test_an_entry_of_the_legend_hides_what_it_names(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    assert here.page.locator("#plot-view .mark.loss").count() == 14
    here.page.click("#key button:has(.loss)")
    assert here.page.locator("#plot-view .mark.loss").count() == 0
    assert here.page.locator("#plot-view .mark.storage").count() == 14
    here.page.click("#key button:has(.loss)")
    assert here.page.locator("#plot-view .mark.loss").count() == 14


@pytest.mark.soak
def test_residuals_are_drawn_along_the_rows_of_the_file(page: Open, damper: bytes):
    here = page()
    here.drop("damper.csv", damper)
    here.shows("material")
    along = """() => [...document.querySelectorAll("#plot-residual circle.mark")]
        .map((mark) => Number(mark.getAttribute("cx")))"""
    before = steps(here.page.evaluate(along))
    assert max(before) > 2.0 * min(before), "by the logarithm of the frequency"
    here.page.select_option("#column", "row")
    even = steps(here.page.evaluate(along))
    assert len(even) == 13
    assert max(even) < 1.01 * min(even)
    assert "row of the file" in here.page.locator("#plot-residual .label").first.text_content()


def steps(places: list[float]) -> list[float]:
    """Between neighbours."""
    return [after - before for before, after in pairwise(places)]


@pytest.mark.soak
def test_what_is_negative_is_drawn(page: Open, damper: bytes):
    here = page()
    # As its mass makes it; more is missing from a model that cannot follow, and takes longer.
    below = damper + b"200,-578.2,33.2\n300,-1749.7,27.5\n"
    here.open("below.csv", below, f"{MODEL} + inertia")
    assert here.page.locator("#plot-view .mark.storage").count() == 16
    label = here.reads("#key")
    assert "2 not above zero" in label
    frame = here.page.locator("#plot-view .frame").bounding_box()
    lowest = here.page.locator("#plot-view .mark.storage").last.bounding_box()
    assert frame["y"] < lowest["y"] < frame["y"] + frame["height"]
    bent = last_gap(here)
    assert bent < 0.2, "from -578 to -1750 is less than half a decade"
    here.page.click("#log-y")
    assert here.page.get_attribute("#log-y", "aria-pressed") == "false"
    assert last_gap(here) > 0.5
    assert here.page.locator("#plot-view .mark.storage").count() == 16
    here.page.click("#log-y")
    assert last_gap(here) == bent
    assert last_gap(here, "cx") < 0.1
    here.page.click("#log-x")
    assert last_gap(here, "cx") > 0.3, "200 to 300 Hz of 1 to 300"


def last_gap(here: Page, place: str = "cy") -> float:
    """Between the last two marks of storage, as a share of the way through all of them."""
    marks = here.page.locator("#plot-view circle.mark.storage")
    found: list[float] = marks.evaluate_all(
        "(marks, place) => marks.map((mark) => Number(mark.getAttribute(place)))", place
    )
    gaps = [abs(after - before) for before, after in pairwise(found)]
    return gaps[-1] / sum(gaps)


def test_what_is_empty_shows_no_picture(page: Open):
    here = page()
    here.page.locator("[data-example]").first.wait_for()
    for plot in ("view", "second", "residual", "ladder"):
        assert here.page.locator(f"#plot-{plot}").is_hidden()
    assert here.page.evaluate(TICKS) == ["8.0e-4 %", "0.0010 %", "0.0012 %", "0.0014 %"]


@pytest.mark.soak
def test_whatever_takes_room_all_stands_on_one_screen_and_choices_are_whole(
    page: Open, damper: bytes
):
    """A server that has gone is told above; where there is little room each sentence is a line."""
    here = page(1440, 900)
    here.open("damper.csv", damper, MODEL)
    assert here.page.locator(".bar select:visible").evaluate_all(CUT) == []
    for height, brief in ((900, 0), (800, 1)):
        here.page.set_viewport_size({"width": 1440, "height": height})
        here.page.evaluate("() => document.dispatchEvent(new CustomEvent('lost'))")
        here.page.evaluate(FRAMES)
        assert here.page.locator("#places.brief").count() == brief
        last = here.page.locator("#places li").last.bounding_box()
        assert last["y"] + last["height"] < height
        here.page.evaluate("() => { document.querySelector('#lost').hidden = true; }")


@pytest.mark.soak
def test_an_example_is_an_answered_page_by_one_click(page: Open):
    here = page()
    here.page.click("[data-example='artificial-fractional-zener-noise1']")
    here.shows("kelvin")
    assert here.page.locator(".card").count() > 0


@pytest.mark.soak
def test_a_finger_reads_a_point_and_stays_to_leave_it_out(page: Open, damper: bytes):
    here = page(390, 844, has_touch=True, is_mobile=True)
    here.open("damper.csv", damper, MODEL)
    mark = here.page.locator("#plot-view .mark.storage").nth(5)
    box = mark.bounding_box()
    here.page.touchscreen.tap(box["x"] + 3, box["y"] + 3)
    assert "8.00 Hz" in here.reads("#readout") or "10.0 Hz" in here.reads("#readout")
    assert "left out" not in here.reads("#facts")
    mark.dispatch_event(
        "pointerdown",
        {
            "pointerType": "touch",
            "pointerId": 7,
            "isPrimary": True,
            "button": 0,
            "clientX": box["x"] + 3,
            "clientY": box["y"] + 3,
            "bubbles": True,
        },
    )
    here.page.locator("#facts:has-text('1 left out')").wait_for()


@pytest.mark.soak
def test_whatever_a_finger_can_choose_is_as_wide_and_high_as_one(page: Open, damper: bytes):
    here = page(390, 844, has_touch=True, is_mobile=True)
    here.page.locator("#model-body #judge").wait_for()
    assert here.page.evaluate(SMALL) == []
    here.open("damper.csv", damper, f"{MODEL} + inertia")
    here.page.evaluate("() => document.querySelectorAll('details').forEach((d) => (d.open = true))")
    assert here.page.locator("#rungs .small").count() == 1
    assert here.page.evaluate(SMALL) == []
    for dialog in ("#leave", "#open-data"):
        here.page.evaluate(f"() => document.querySelector('{dialog}').click()")
        here.page.locator("dialog[open]").wait_for()
        assert here.page.evaluate(SMALL) == []
        here.page.keyboard.press("Escape")


@pytest.mark.soak
def test_two_views_stand_side_by_side_with_one_cursor_and_one_preview(page: Open, damper: bytes):
    here = page()
    here.page.set_viewport_size({"width": 1440, "height": 900})
    here.open("damper.csv", damper, MODEL)
    second = here.page.locator("#plot-second")
    assert second.is_hidden()
    here.page.select_option("#second", "cole-cole")
    first, beside = here.page.locator("#plot-view").bounding_box(), second.bounding_box()
    assert beside["y"] == first["y"]
    assert beside["x"] >= first["x"] + first["width"]
    assert "K'' [kN/m]" in second.text_content()
    assert second.locator(".line.model").count() == 1
    here.page.hover("[data-effect=inertia]")
    assert second.locator(".line.preview").count() == 1
    here.page.hover("#plot-view")
    assert second.locator(".cursor-layer > *").count() > 0
    here.page.reload()
    here.shows(MODEL)
    assert second.is_visible()
    assert here.violations() == []
    here.page.set_viewport_size({"width": 390, "height": 844})
    first, below = here.page.locator("#plot-view").bounding_box(), second.bounding_box()
    assert below["y"] >= first["y"] + first["height"]
    here.page.select_option("#second", "")
    assert second.is_hidden()


@pytest.mark.soak
def test_the_spectrum_of_any_material_is_a_view(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, "material")
    here.page.select_option("#view", "spectrum")
    here.page.locator("#plot-view .band.unmeasured").first.wait_for(state="attached")
    assert "rate r [rad/s]" in here.page.text_content("#plot-view")
    assert here.page.locator("#plot-view .line.model").count() == 1
    assert here.reads("#places").startswith("half of the relaxing")
    assert here.page.locator("#plot-residual").is_hidden()
    assert here.violations() == []
    here.judge(MODEL)
    assert here.page.locator("#view [value=spectrum]").is_disabled()
    assert "frequency f [Hz]" in here.page.text_content("#plot-view")


MOVED = """async () => {
    const slider = document.querySelector(".parameter input[type=range]");
    const plot = document.querySelector("#plot-residual");
    const times = [];
    for (let i = 0; i < 40; i += 1) {
        const drawn = new Promise((done) => {
            const seen = new MutationObserver(() => {
                seen.disconnect();
                done(performance.now());
            });
            seen.observe(plot, { subtree: true, childList: true, attributes: true });
        });
        const begun = performance.now();
        slider.value = Number(slider.value) + (i % 2 ? 1 : -1) * Number(slider.step);
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        times.push(await drawn - begun);
        await new Promise((done) => { setTimeout(done, 50); });
    }
    return times.sort((a, b) => a - b);
}"""


@pytest.mark.soak
def test_residuals_follow_a_slider_while_it_moves(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    begun = perf_counter()
    here.judge(f"{MODEL} + inertia")
    answered = 1e3 * (perf_counter() - begun)
    times = here.page.evaluate(MOVED)
    print(f"from a slider to its residuals {times[20]:.1f} ms, the longest {times[-1]:.1f} ms")
    assert times[20] < answered / 5
