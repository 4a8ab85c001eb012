"""The style of pages in a browser: nothing runs out of its box."""

import json
import re
import subprocess

import pytest

from chromium import CHROMIUM
from springpot.report.page import STYLE
from springpot.writing import Html, tag

MEASURE = """
const out = [...document.querySelectorAll('.fact')].map(card => {
  const range = document.createRange(); range.selectNodeContents(card);
  return range.getBoundingClientRect().right - card.getBoundingClientRect().right; });
document.body.setAttribute('data-over', JSON.stringify(out));
"""


def cards(width):
    """The facts of a report whose main column has this width in pixels."""
    accepted = Html(
        "".join(
            tag("span", name, class_="whole") for name in ("+ series-springpot", "+ time-delay")
        )
    )
    facts = [
        ("error", "44.0 %"),
        ("end", "0.914 %"),
        ("floor (estimated)", "0.892 %"),
        ("against", "1.0 × floor"),
    ]
    shown = [
        tag("div", tag("b", value), word, class_="fact")
        for word, value in (*facts, ("accepted", accepted))
    ]
    return (
        f"<style>{STYLE}</style>"
        f"<div style='width:{width}px'>{tag('div', *shown, class_='facts')}</div>"
    )


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_a_long_name_stays_in_its_card(tmp_path):
    page = tmp_path / "cards.html"
    shown = "".join(cards(width) for width in (1028, 358))
    page.write_text(
        f"<!doctype html><body>{shown}<script>{MEASURE}</script></body>", encoding="utf-8"
    )
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    done = subprocess.run(
        [*command, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=600
    )
    [found] = re.findall(r'data-over="(\[[^"]*\])"', done.stdout)
    over = json.loads(found)
    assert len(over) == 2 * 5
    assert max(over) < 0.0
