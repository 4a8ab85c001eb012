"""A page of the workbench in a real browser, for the tests that use one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from chromium import CHROMIUM
from springpot.web import Workbench

playwright = pytest.importorskip(
    "playwright.sync_api", reason="the extra 'browser' is not installed"
)
IN_A_BROWSER = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no Chromium here: 'apt-get install chromium'"
)

PATIENCE = 120_000
"""Milliseconds for an answer.

A machine of many tests is slow, and what is lost for good is still seen.
"""
RANKING = "**/api/ranking*"
LOOK = 20
"""Milliseconds between looks at what cannot be waited for otherwise."""
# Any name is nowhere: whatever the page asks of another machine fails, and is seen among its
# requests.
CUT = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--disable-gpu"]
Open = Callable[..., Any]
# Of what a finger can choose, the label that belongs to it counted: whatever is smaller
# (WCAG 2.5.5).
SMALL = """() => [...document.querySelectorAll(
    "a[href], button, input, select, summary, [role=option]")]
    .filter((target) => target.checkVisibility({ visibilityProperty: true }) && target.offsetWidth)
    .map((target) => [target, target.closest("label") ?? target])
    .filter((both) => both.every((target) => {
        const box = target.getBoundingClientRect();
        return Math.min(box.width, box.height) < 44;
    }))
    .map(([target]) => target.id || target.outerHTML)"""


# Words that are cut, but for the name of the data, which is before a button is.
CUT_SHORT = """() => [...document.querySelectorAll("body *:not(svg *, h1, .hidden, .plots)")]
    .filter((each) => each.checkVisibility({ visibilityProperty: true }) && each.textContent.trim())
    .filter((each) => ["hidden", "clip"].includes(getComputedStyle(each).overflowX))
    .filter((each) => each.scrollWidth > each.clientWidth + 1
        || each.scrollHeight > each.clientHeight + 1)
    .map((each) => `${each.id || each.className}: ${each.textContent}`)"""


def _unless_at_rest(route: Any) -> None:
    """Hold what is asked for while nobody waits: each test would pay for it."""
    if '"quiet":true' not in (route.request.post_data or ""):
        route.continue_()


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
        self.page.on(
            "console", lambda said: self.faults.append(said.text) if said.type == "error" else None
        )
        self.page.route(RANKING, _unless_at_rest)
        self.page.goto(bench.address)

    def rests(self) -> None:
        """From now on other models are ranked while nobody waits, as for a person."""
        self.page.unroute(RANKING)

    def done(self) -> None:
        """Wait until nothing is read or computed any more.

        The page is busy from the very event that asks for it.
        """
        self.page.locator("body:not([aria-busy])").wait_for(state="attached")

    def drop(self, name: str, content: bytes, **more: bytes) -> None:
        """Drop a file on the page as a hand does, or several at once."""
        self.page.locator("#model-body #judge").wait_for()
        self.page.evaluate(
            """(dropped) => {
                const files = new DataTransfer();
                for (const [name, text] of dropped) files.items.add(new File([text], name));
                const drop = { dataTransfer: files, bubbles: true, cancelable: true };
                document.body.dispatchEvent(new DragEvent("drop", drop));
            }""",
            [[name, text.decode()] for name, text in {name: content, **more}.items()],
        )

    def name(self, model: str) -> None:
        """Name a model, whatever the page is doing."""
        self.page.fill("#expression", model)
        self.page.press("#expression", "Enter")

    def open(self, name: str, content: bytes, model: str) -> None:
        """Name a model and drop a file that is judged by it, and by nothing before."""
        self.name(model)
        self.drop(name, content)
        self.shows(model)

    def judge(self, model: str) -> None:
        """Name a model, and wait for its answer."""
        self.name(model)
        self.shows(model)

    def shows(self, expression: str) -> None:
        """Wait for the answer on a model."""
        playwright.expect(self.page.locator("#verdict")).to_contain_text(
            f"{expression}:", timeout=PATIENCE
        )
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
            self.page.locator("#done:not(:empty)").wait_for()
            if self.page.locator(
                "#done a"
            ).count():  # it took long: the browser wants another click
                self.page.click("#done a")
        return found.value.suggested_filename, Path(found.value.path()).read_bytes()

    def reads(self, selector: str) -> str:
        """Text of an element."""
        text: str = self.page.inner_text(selector)
        return text

    @contextmanager
    def held(self, task: str) -> Iterator[None]:
        """Whatever the page asks of this task is only sent when this ends.

        A server as slow as one likes.
        """
        waiting: list[Any] = []
        pattern = f"**/api/{task}*"
        self.page.route(pattern, lambda route: waiting.append(route))
        yield
        for _ in range(PATIENCE // LOOK):
            if waiting:
                break
            self.page.wait_for_timeout(LOOK)
        assert waiting, f"the page did not ask for {task}"
        self.page.unroute(pattern)
        for route in waiting:
            with suppress(playwright.Error):  # the page may have taken it back
                route.continue_()

    def violations(self) -> list[str]:
        """What axe-core finds."""
        return violations_on(self.page)

    def close(self) -> None:
        """Nothing went wrong, and nothing left this machine."""
        assert self.page.evaluate(CUT_SHORT) == []
        assert self.faults == []
        assert [
            url
            for url in self.requests
            if not url.startswith(("http://127.0.0.1:", "data:", "blob:"))
        ] == []
        self.context.close()


def violations_on(page: Any) -> list[str]:
    """What axe-core finds on a page, one line each."""
    axe = pytest.importorskip("axe_core_python.base", reason="the extra 'browser' is not installed")
    page.evaluate(axe.AXE_SCRIPT)
    found = page.evaluate("() => axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa'] })")
    return [f"{one['id']}: {one['nodes'][0]['html'][:160]}" for one in found["violations"]]


def tab_to(here: Page, name: str, start: str = "") -> set[str]:
    """Go on with Tab until something of that id, label or kind has the focus.

    All that had it on the way.
    """
    if start:
        here.page.locator(f"#{start}").focus()
    seen: set[str] = set()
    for _ in range(80):
        here.page.keyboard.press("Tab")
        focused = here.page.evaluate(
            "() => { const at = document.activeElement; "
            "return [at.id, at.ariaLabel, at.dataset.leave]; }"
        )
        seen |= {str(one) for one in focused}
        if name in focused:
            return seen
    raise AssertionError(f"Tab does not lead to {name}: {seen}")
