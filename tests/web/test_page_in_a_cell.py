"""The page in a cell of a notebook: the same page, asked and answered through the kernel alone."""

from __future__ import annotations

import base64
import queue
import sys
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import pytest

pytest.importorskip("anywidget", reason="the extra 'notebook' is not installed")

from browsing import IN_A_BROWSER, PATIENCE

import springpot
from springpot.web.cell import WorkbenchCell

LOOK = 20
"""Milliseconds between looks at what the kernel says."""

# What a notebook's front end does for a widget: its traits, and messages to the kernel and back.
NOTEBOOK = """async ([program, traits]) => {
    const hearers = [];
    window.fromKernel = (said, part) => {
        const bytes = Uint8Array.from(atob(part), (letter) => letter.charCodeAt(0));
        for (const hear of hearers) hear(said, [new DataView(bytes.buffer)]);
    };
    const model = {
        get: (name) => traits[name],
        set: (name, value) => { traits[name] = value; },
        save_changes: () => toKernel({ session: traits.session }, ""),
        on: (_, hear) => { hearers.push(hear); },
        off: () => {},
        send: (said, _, parts = []) =>
            toKernel(said, btoa(parts.map((part) => String.fromCharCode(...part)).join(""))),
    };
    const file = new Blob([program], { type: "text/javascript" });
    const { default: widget } = await import(URL.createObjectURL(file));
    widget.render({ model, el: document.body });
}"""


class Cell:
    """A cell that shows a widget, its kernel being this test."""

    def __init__(self, page: Any, widget: WorkbenchCell) -> None:
        self.page, self.widget = page, widget
        self.inside = page.frame_locator("iframe")
        self.said: queue.SimpleQueue[tuple[Any, bytes]] = queue.SimpleQueue()
        self.asked: list[dict[str, Any]] = []
        page.expose_function("toKernel", self._hear)
        page.evaluate(NOTEBOOK, [widget._esm, widget.get_state(["page", "files", "height"])])

    def _hear(self, said: dict[str, Any], part: str) -> None:
        if "session" in said:
            self.widget.session = said["session"]
            return
        self.asked.append(said)
        self.widget._handle_custom_msg(said, [base64.b64decode(part)])

    def until(self, seen: Callable[[], bool]) -> None:
        """Pass on what the kernel says until something is seen."""
        for _ in range(PATIENCE // LOOK):
            while not self.said.empty():
                said, part = self.said.get()
                text = base64.b64encode(part).decode()
                self.page.evaluate("([said, part]) => fromKernel(said, part)", [said, text])
            if seen():
                return
            self.page.wait_for_timeout(LOOK)
        raise AssertionError(self.inside.locator("body").inner_text())


@pytest.fixture
def cell(browser: Any, damper: bytes, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cell]:
    """The README's file under too simple a model, where no server has the page's files."""
    given = {"name": "damper.csv", "content": base64.b64encode(damper).decode()}
    said: list[Cell] = []
    monkeypatch.setattr(
        WorkbenchCell, "send", lambda _, told, parts: said[0].said.put((told, b"".join(parts)))
    )
    widget = WorkbenchCell(given, "maxwell")
    page = browser.new_context().new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.route("http://notebook/", lambda route: route.fulfill(body="", content_type="text/html"))
    page.goto("http://notebook/")
    said.append(Cell(page, widget))
    yield said[0]
    page.context.close()
    widget.close()
    assert faults == []


@pytest.mark.soak
@IN_A_BROWSER
def test_the_loop_goes_through_the_kernel_and_python_reads_what_the_page_shows(cell: Cell) -> None:
    """What the page gives up is told to the kernel; what is accepted stands in the widget."""
    typed = cell.inside.locator("#expression")
    cell.until(lambda: any(said.get("path") == "/api/answer" for said in cell.asked))
    asked = next(said["id"] for said in cell.asked if said.get("path") == "/api/answer")
    assert cell.widget.ladder == ("maxwell",)
    typed.fill("fractional-maxwell")
    typed.press("Enter")
    cell.until(lambda: {"id": asked, "gone": True} in cell.asked)
    add = cell.inside.locator("#hero button", has_text="Add inertia")
    cell.until(add.is_visible)
    add.click()
    cell.until(lambda: len(cell.widget.ladder) == 2)
    assert cell.widget.ladder == ("fractional-maxwell", "fractional-maxwell + inertia")
    assert str(cell.widget.model) == "fractional-maxwell + inertia"
    assert cell.widget.excluded == ()


def test_before_there_are_data_python_reads_nothing() -> None:
    """Nothing is shown yet, and closing twice is closing."""
    widget = WorkbenchCell()
    assert (widget.ladder, widget.model, widget.excluded) == ((), None, ())
    widget.close()
    widget.close()


def test_a_notebook_shows_the_page_in_its_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a kernel runs the program."""
    kernel = ModuleType("ipykernel")
    kernel.version_info = (7, 0, 0)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ipykernel", kernel)
    shown = springpot.workbench("artificial-hidden")
    assert isinstance(shown, WorkbenchCell)
    shown.close()
