"""What fingers do on a phone: two come closer, and whatever is told is told to a finger."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from browsing import IN_A_BROWSER, Open, Page

pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
HELD = 700
"""Milliseconds after which a finger has stayed; see modules/pointing.js."""
Touch = Callable[..., None]
XS = "marks => marks.map(mark => Number(mark.getAttribute('cx')))"


@pytest.fixture
def phone(page: Open, damper: bytes) -> Page:
    here = page(390, 844, has_touch=True, is_mobile=True)
    here.open("damper.csv", damper, MODEL)
    return here


@pytest.fixture
def touch(phone: Page) -> Touch:
    """Fingers as the system tells of them."""
    driver: Any = phone.context.new_cdp_session(phone.page)

    def send(kind: str, *places: tuple[float, float]) -> None:
        fingers = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        driver.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": fingers})
        phone.page.evaluate("() => new Promise(requestAnimationFrame)")

    return send


@pytest.mark.soak_cases("#plot-residual")
@pytest.mark.parametrize("plot", ["#plot-view", "#plot-residual"])
def test_two_fingers_that_stay_leave_no_point_out(phone: Page, touch: Touch, plot: str):
    """Each of them on a point, one after the other."""
    boxes = [phone.page.locator(f"{plot} .mark").nth(i).bounding_box() for i in (4, 16)]
    first, second = ((box["x"] + 3, box["y"] + 3) for box in boxes)
    touch("Start", first)
    touch("Start", first, second)
    phone.page.wait_for_timeout(HELD)
    touch("End")
    assert phone.reads("#facts") == "14 points, 1 sweep"


def test_number_and_preview_stay_in_sight_with_the_picture(phone: Page):
    phone.page.tap("#effect-inertia")
    phone.page.evaluate("() => document.querySelector('#next').scrollIntoView(true)")
    assert phone.page.locator("#number").bounding_box()["y"] < 0
    now, plot = (phone.page.locator(each).bounding_box() for each in ("#now", "#plot-view"))
    assert 0 <= now["y"] < now["y"] + now["height"] <= plot["y"]
    assert phone.reads("#now") == "8.5 × → 0.91 × floor with inertia"
    assert "Tap one" in phone.reads("#missing")


@pytest.mark.soak
def test_two_fingers_come_closer_and_move_the_picture(phone: Page, touch: Touch):
    def spread() -> tuple[float, float]:
        found = phone.page.locator("#plot-view .mark.storage").evaluate_all(XS)
        return max(found) - min(found), min(found)

    box = phone.page.locator("#plot-view").bounding_box()
    y = box["y"] + 60
    left, right = box["x"] + 150, box["x"] + 250
    before, _ = spread()
    touch("Start", (left, y))
    touch("Start", (left, y), (right, y))
    touch("Move", (left - 50, y), (right + 50, y))
    closer, start = spread()
    assert closer == pytest.approx(2.0 * before, rel=0.02)
    touch("Move", (left - 20, y), (right + 80, y))
    assert spread() == pytest.approx((closer, start + 30.0), rel=0.02)
    touch("End")
