"""A parameter that a hand has moved is a hypothesis like a cause: seen, held, undone."""

from __future__ import annotations

import pytest
from browsing import IN_A_BROWSER, Open

pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
MOVE = """() => {
    const box = document.querySelector(".parameter input[type=number]");
    box.value = 390;
    box.dispatchEvent(new Event("change", { bubbles: true }));
}"""


@pytest.mark.soak
def test_what_a_hand_has_moved_is_held_on_every_rung_and_undone(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    free = here.error()
    here.page.evaluate(MOVE)
    card = here.page.locator("[data-effect='by hand']")
    card.wait_for()
    assert "hold k = 390" in card.inner_text()
    here.page.hover("[data-effect='by hand']")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.violations() == []

    card.click()
    here.page.locator("#held").wait_for()
    here.shows(MODEL)
    assert here.reads("#held").startswith("k = 390.0 held")
    assert here.error() > free
    assert "k" not in here.page.locator(".parameter .name").all_inner_texts()
    here.page.click("#effect-inertia")
    here.shows(f"{MODEL} + inertia")
    assert here.page.locator("#held").is_visible()
    here.page.click("#leave")
    here.page.locator("dialog[open]:has-text('--fix k=390.0')").wait_for()
    here.page.keyboard.press("Escape")

    here.page.click("#held button")
    here.shows(f"{MODEL} + inertia")
    assert here.page.locator("#held").count() == 0
    for _ in range(3):
        here.page.click("#undo")
    here.shows(MODEL)
    assert here.error() == free
