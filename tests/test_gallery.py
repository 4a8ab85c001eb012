"""The gallery: every report that the page shows is made by the command that stands beside it."""

from __future__ import annotations

import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"


@pytest.fixture(scope="module")
def gallery():
    spec = spec_from_file_location("make_gallery", DOCS / "make_gallery.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.soak
def test_the_page_shows_what_is_made(gallery):
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"\]\(gallery/([\w.]+)\)[^|]*\| `springpot ([^`]*)` \|", page))
    assert rows.pop("race.html") == "run studies/optimiser_comparison.py"
    assert rows == {name: f"{command} {name}" for name, command in gallery.MADE.items()}


@pytest.mark.soak
def test_a_report_is_made_as_a_user_makes_it(gallery, tmp_path):
    made = gallery.make(["mastercurve.svg"], tmp_path)
    assert [path.name for path in made] == ["mastercurve.svg", "race.html"]
    assert all(path.stat().st_size > 10_000 for path in made)
