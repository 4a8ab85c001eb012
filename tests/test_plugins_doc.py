"""docs/plugins.md shows the example distribution as it is, in pieces as short as it promises."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "tests" / "example_plugin"
MODULE = EXAMPLE / "springpot_example.py"
BLOCKS = re.findall(
    r"^```(\w+)\n(.*?)^```$", (ROOT / "docs" / "plugins.md").read_text(), re.M | re.S
)


def quoted(language: str) -> list[str]:
    return [text for tag, text in BLOCKS if tag == language]


def test_every_piece_of_code_is_that_of_the_example():
    paths = [*EXAMPLE.glob("*.py"), Path(__file__).parent / "timetests" / "test_new_kind.py"]
    sources = [path.read_text() for path in paths]
    assert len(quoted("python")) == 10
    for text in quoted("python"):
        assert any(text in source for source in sources), text
    assert quoted("toml") == [(EXAMPLE / "pyproject.toml").read_text()]


@pytest.mark.parametrize(
    "kind", ["models", "effects", "optimisers", "objectives", "datasets", "readers"]
)
def test_one_of_each_kind_is_shown_whole_in_under_thirty_lines(kind: str):
    [text] = [text for text in quoted("python") if f"def springpot_{kind}()" in text]
    assert len([line for line in text.splitlines() if line.strip()]) < 30


def test_nothing_of_the_example_is_left_out_but_its_imports():
    shown = "".join(quoted("python"))
    body = MODULE.read_text().partition("# A model")[2].partition("\n")[2]
    lines = [line for line in body.splitlines() if line.strip() and not line.startswith("#")]
    assert [line for line in lines if line not in shown] == []
