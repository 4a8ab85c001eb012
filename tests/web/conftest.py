"""One workbench for all tests of this room, and the README's file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("starlette", reason="the extra 'workbench' is not installed")
pytest.importorskip("uvicorn", reason="the extra 'workbench' is not installed")

import springpot
from springpot.web import Workbench
from springpot.web.sessions import measured_in

if TYPE_CHECKING:
    from browsing import Open

README = Path(__file__).resolve().parents[2] / "README.md"


@pytest.fixture(scope="session")
def damper() -> bytes:
    """The file that the README tells to write."""
    found = re.search(
        r"^```csv damper.csv\n(.*?)^```$", README.read_text(encoding="utf-8"), re.M | re.S
    )
    assert found is not None
    return found[1].encode()


@pytest.fixture(scope="session")
def planned() -> bytes:
    """What the experiment that the README's file asks for would measure: a mass of the rig."""
    rng, frequency = np.random.default_rng(1), np.geomspace(10.0, 480.0, 20)
    model = springpot.parse_model("fractional-maxwell + inertia")
    theta = model.theta(**{"k": 398.3, "c": 60.06, "alpha": 0.5514, "inertia.m": 0.597e-3})
    noise = 1.0 + 0.005 * (rng.normal(size=20) + 1j * rng.normal(size=20))
    k = model.stiffness(theta, 2.0 * np.pi * frequency) * noise
    rows = zip(frequency, k.real, k.imag, strict=True)
    return b"".join(b"%.5g,%.5g,%.5g\n" % row for row in rows)


@pytest.fixture(scope="session")
def named(damper: bytes) -> Iterator[Workbench]:
    """A workbench opened from Python on a measurement and a model.

    Who closes it is the last to use it.
    """
    running = springpot.workbench(
        measured_in("damper.csv", damper)[0], "fractional-maxwell", browser=False
    )
    yield running
    running.close()


@pytest.fixture(scope="session")
def bench() -> Iterator[Workbench]:
    """A workbench without data."""
    running = Workbench().start()
    yield running
    running.close()


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """One Chromium for all tests that need one, with the network cut."""
    from browsing import CHROMIUM, CUT, playwright

    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=CHROMIUM, args=CUT)
        yield running
        running.close()


@pytest.fixture
def page(browser: Any, bench: Workbench) -> Iterator[Open]:
    """Opens pages of the one workbench, each of a person of its own.

    At the end none of them had a fault.
    """
    from browsing import Page

    opened: list[Page] = []

    def open_page(width: int = 1280, height: int = 800, **settings: Any) -> Page:
        context = browser.new_context(viewport={"width": width, "height": height}, **settings)
        opened.append(Page(context, bench))
        return opened[-1]

    yield open_page
    for one in opened:
        one.close()
