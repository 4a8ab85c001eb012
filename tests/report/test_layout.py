"""The style of pages in a browser: nothing runs out of its box."""

import json
import re
import shutil
import subprocess

import pytest

from springpot.markup import Html, tag
from springpot.report.style import STYLE

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
MEASURE = """
const out = [...document.querySelectorAll('.fact')].map(card => {
  const range = document.createRange(); range.selectNodeContents(card);
  return range.getBoundingClientRect().right - card.getBoundingClientRect().right; });
document.body.setAttribute('data-over', JSON.stringify(out));
"""


def cards(width):
    """The facts of a report whose main column has this width in pixels."""
    accepted = Html("".join(tag("span", name, class_="whole") for name in ("+ series-springpot", "+ time-delay")))
    facts = [("error", "44.0 %"), ("end", "0.914 %"), ("floor (estimated)", "0.892 %"), ("against", "1.0 × floor")]
    shown = [tag("div", tag("b", value), word, class_="fact") for word, value in (*facts, ("accepted", accepted))]
    return f"<style>{STYLE}</style><div style='width:{width}px'>{tag('div', *shown, class_='facts')}</div>"


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
@pytest.mark.parametrize("width", [1028, 358])
def test_a_long_name_stays_in_its_card(tmp_path, width):
    page = tmp_path / "cards.html"
    page.write_text(f"<!doctype html><body>{cards(width)}<script>{MEASURE}</script></body>", encoding="utf-8")
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
    done = subprocess.run([*command, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=600)
    [found] = re.findall(r'data-over="(\[[^"]*\])"', done.stdout)
    over = json.loads(found)
    assert len(over) == 5
    assert max(over) < 0.0


def test_cards_may_grow_with_what_they_hold():
    [cards_rule] = re.findall(r"^\.facts \{([^}]*)\}", STYLE, re.MULTILINE)
    assert "flex-wrap: wrap" in cards_rule  # columns of a grid would be as wide as the narrowest card
