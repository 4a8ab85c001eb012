"""Makes the pictures of docs/workbench.md.

``python tests/web/pictures.py``, where Chromium and Pillow are.
"""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import springpot

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from chromium import CHROMIUM  # noqa: E402

IMAGES = ROOT / "docs" / "images"
COLOURS = 128
MODEL = "fractional-maxwell"


def damper() -> bytes:
    found = re.search(
        r"^```csv damper.csv\n(.*?)^```$",
        (ROOT / "README.md").read_text(encoding="utf-8"),
        re.M | re.S,
    )
    assert found is not None
    return found[1].encode()


def unexplained() -> bytes:
    """What no effect of a specimen is.

    Above 5 Hz the instrument is in another range, and its gain is 5 % larger.
    """
    rng, frequency = np.random.default_rng(1), np.geomspace(0.5, 50.0, 60)
    model = springpot.parse_model(MODEL)
    exact = model.stiffness(model.theta(k=400.0, c=60.0, alpha=0.55), 2 * np.pi * frequency)
    gain = np.where(frequency > 5.0, 1.05, 1.0)
    noise = 0.004 * (rng.normal(size=60) + 1j * rng.normal(size=60))
    rows = zip(frequency, exact * gain * (1 + noise), strict=True)
    lines = (f"{f:.5g},{k.real:.5g},{k.imag:.5g}\n" for f, k in rows)
    return ("frequency [Hz],storage [kN/m],loss [kN/m]\n" + "".join(lines)).encode()


def relaxation() -> bytes:
    """What relaxes as a power of time, as no single Maxwell element does."""
    rng, time = np.random.default_rng(1), np.geomspace(0.1, 100.0, 40)
    rows = zip(time, 300.0 * time**-0.2 * (1.0 + 0.005 * rng.normal(size=40)), strict=True)
    return ("time [s],relaxation [kPa]\n" + "".join(f"{t:.6g},{g:.6g}\n" for t, g in rows)).encode()


def keep(page: Any, name: str) -> None:
    """A picture of few colours, of which a page has no more."""
    page.wait_for_timeout(700)
    picture = (
        Image.open(io.BytesIO(page.screenshot()))
        .convert("RGB")
        .quantize(COLOURS, dither=Image.Dither.NONE)
    )
    picture.save(IMAGES / f"workbench-{name}.png", optimize=True)
    print(name, (IMAGES / f"workbench-{name}.png").stat().st_size)


def main() -> None:
    bench = springpot.workbench(browser=False)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])

        def opened(name: str, content: bytes, model: str = "", **settings: Any) -> Any:
            context = browser.new_context(
                **{"viewport": {"width": 1440, "height": 900}, **settings}
            )
            page = context.new_page()
            page.goto(bench.address)
            page.locator("#dataset-first option").nth(1).wait_for(state="attached")
            if not name:
                return page
            page.set_input_files(
                "#file-first", {"name": name, "mimeType": "text/csv", "buffer": content}
            )
            if model:
                page.locator("#effects [role=option]").first.wait_for()
                page.locator("body:not([aria-busy])").wait_for()
                page.fill("#expression", model)
                page.press("#expression", "Enter")
                answered(page, model)
            return page

        def answered(page: Any, model: str) -> None:
            page.locator(f"#verdict:has-text('{model}:')").wait_for()
            page.locator("body:not([aria-busy])").wait_for()
            page.evaluate("() => document.activeElement.blur()")

        keep(opened("", b""), "empty")
        page = opened("damper.csv", damper(), MODEL)
        keep(page, "answered")
        page.hover("#effect-inertia")
        keep(page, "hovered")
        page.mouse.move(640, 780)
        page.check("#show-plan")
        keep(page, "plan")
        page.uncheck("#show-plan")
        page.click("#effect-inertia")
        answered(page, f"{MODEL} + inertia")
        page.mouse.move(640, 780)
        keep(page, "adequate")
        page.fill("#scrub", "0")
        keep(page, "replay")
        page.evaluate("() => document.dispatchEvent(new CustomEvent('lost'))")
        keep(page, "lost")
        page = opened("relax.csv", relaxation(), "maxwell")
        page.hover("#effect-parallel-springpot")
        keep(page, "in-time")
        keep(opened("two-ranges.csv", unexplained(), MODEL), "unexplained")
        page = opened("notes.csv", b"hello\nworld\n")
        page.locator("#refused").wait_for()
        keep(page, "refused")
        phone = {"viewport": {"width": 390, "height": 844}, "has_touch": True}
        page = opened("damper.csv", damper(), MODEL, **phone)
        page.tap("#effect-inertia")
        page.locator("#compare").scroll_into_view_if_needed()
        page.evaluate("() => scrollTo(0, 0)")
        keep(page, "phone")
        page = opened("damper.csv", damper(), MODEL, color_scheme="dark")
        page.hover("#effect-inertia")
        keep(page, "dark")
        browser.close()
    bench.close()


if __name__ == "__main__":
    main()
