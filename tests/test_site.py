"""The documentation builds as a site, every page of it, and asks no other host for anything."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FETCHED = re.compile(r"<(?:script|img|link|iframe)\b[^>]*?(?:src|href)=\"?(https?:|//)[^>]*>")


def test_the_site_builds_whole_and_asks_nobody(tmp_path: Path):
    for library in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(library)
    command = [
        sys.executable,
        "-m",
        "mkdocs",
        "build",
        "--quiet",
        "--strict",
        "--site-dir",
        str(tmp_path),
    ]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=quiet, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    pages = {
        path.relative_to(tmp_path).with_suffix("").as_posix() for path in tmp_path.rglob("*.html")
    }
    pages = {
        page for page in pages if page != "404" and not page.startswith("gallery/")
    }  # reports, if they were made
    sources = {
        path.relative_to(ROOT / "docs").with_suffix("").as_posix()
        for path in (ROOT / "docs").rglob("*.md")
    }
    assert pages == (sources - {"README"}) | {"index"}
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert not [name for name in sources if f"{name}.md" not in navigation]
    for page in tmp_path.rglob("*.html"):
        asked = [
            found[0]
            for found in FETCHED.finditer(page.read_text(encoding="utf-8"))
            if 'rel="' not in found[0]
        ]
        assert asked == [], page
    reference = (tmp_path / "reference.html").read_text(encoding="utf-8")
    for name in ("identify", "predict", "excluding", "DataError", "rad/s"):
        assert name in reference
    assert (tmp_path / "schemas" / "identification.json").exists()


def test_the_map_of_the_house_is_true():
    """What the page for contributors calls a file or a folder is one."""
    page = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
    absent, folder = [], ROOT
    for name in re.findall(r"`([\w./-]+?(?:/|\.py))`", page):
        # A bare name stands beside the one before it.
        path = ROOT / name if "/" in name.rstrip("/") else folder / name
        if not path.exists():
            absent.append(name)
        folder = path if path.is_dir() else path.parent
    assert absent == []
