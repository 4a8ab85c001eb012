"""The documentation builds as a site, every page of it.

Nothing in it is broken or asks another host.
"""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote, urlsplit

import pytest

from springpot_plugins.suites import SUITES
from springpot_plugins.suites.described import measured

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
FETCHED = re.compile(r"<(?:script|img|link|iframe)\b[^>]*?(?:src|href)=\"?(https?:|//)[^>]*>")
MADE_WITH_THE_SITE = re.compile(r"gallery/[\w.]+")
"""Reports that 'make site' makes before it builds; tests/test_gallery.py holds their names."""
BESIDE = "repository"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built once; of what it warns only the gallery may be missing."""
    for library in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(library)
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(folder)]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=quiet, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    told = (done.stdout + done.stderr).splitlines()
    assert [line for line in told if not MADE_WITH_THE_SITE.search(line)] == []
    return folder


class Page(HTMLParser):
    """What a page points to, and the places in it that can be pointed to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("href", "src") and value is not None:
                self.links.append(value)
            elif key in ("id", "name") and value:
                self.places.add(value)


def broken(folder: Path) -> Iterator[str]:
    """Links, pictures and places of a site that lead nowhere.

    Pages that were made elsewhere are left out.
    """
    # The page for what is not found is shown from any address, and reports are whole in themselves.
    paths = [
        path for path in folder.rglob("*.html") if path.name not in ("404.html", "report.html")
    ]
    paths = [path for path in paths if "gallery" not in path.parts]
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in paths}
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            lost = (
                target in pages
                and parts.fragment
                and unquote(parts.fragment) not in pages[target].places
            )
            if lost or not target.is_file():
                yield f"{path.relative_to(folder)}: {link}"


@pytest.mark.soak
def test_every_page_is_built_and_can_be_reached(site: Path):
    pages = {path.relative_to(site).with_suffix("").as_posix() for path in site.rglob("*.html")}
    # Reports, if they were made, and what pages show from beside the folder.
    pages = {
        page for page in pages if page != "404" and not page.startswith(("gallery/", f"{BESIDE}/"))
    }
    sources = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    made = {f"suite/{name.partition('/')[2]}" for suite in SUITES for name in measured(suite)}
    assert pages == (sources - {"README"}) | {"index"} | made
    for page in ("suite/shear-wave", "suite/record-jenkins"):
        assert f'href="{page}.html"' in (site / "suite.html").read_text(encoding="utf-8")
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert not [name for name in sources if f"{name}.md" not in navigation]
    assert (site / "schemas" / "identification.json").exists()


@pytest.mark.soak
def test_the_site_asks_no_other_host(site: Path):
    for page in site.rglob("*.html"):
        asked = [
            found[0]
            for found in FETCHED.finditer(page.read_text(encoding="utf-8"))
            if 'rel="' not in found[0]
        ]
        assert asked == [], page


@pytest.mark.soak
def test_no_link_or_picture_of_the_site_is_broken(site: Path):
    assert [link for link in broken(site) if not MADE_WITH_THE_SITE.search(link)] == []
    # Pictures of results were outside the site for long.
    assert "pdms.png" in (site / "real-data.html").read_text(encoding="utf-8")


def test_a_broken_link_is_seen(tmp_path: Path):
    (tmp_path / "one.html").write_text(
        '<h1 id="here"></h1><a href="#here"></a><a href="two.html#there"></a><img src="gone.png">'
        '<a href="two.html"></a><a href="../outside.md"></a><a href="https://example.org/x"></a>',
        encoding="utf-8",
    )
    (tmp_path / "two.html").write_text("<p></p>", encoding="utf-8")
    lost = [line.partition(": ")[2] for line in broken(tmp_path)]
    assert lost == ["two.html#there", "gone.png", "../outside.md"]


ROOMS = ("", ".benchmark", ".solvers", ".structure", ".testing", ".timetests")


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: f"springpot{room}")
def test_the_reference_has_what_a_room_offers(room: str):
    """Constants and unions aside, which have no page of their own."""
    page = (DOCS / "reference.md").read_text(encoding="utf-8")
    entries = set(re.findall(r"^::: (\S+)$", page, re.M))
    for module, members in re.findall(
        r"^::: (\S+)\n    options:\n(?:.*\n)*?      members: \[(.*)\]", page, re.M
    ):
        entries |= {f"{module}.{name.strip()}" for name in members.split(",")}
    offered = importlib.import_module(f"springpot{room}")
    found = {name: getattr(offered, name) for name in dir(offered)}
    absent = []
    for name, thing in found.items():
        if isinstance(thing, ModuleType):
            absent += [name] if thing.__name__ not in entries else []
        elif hasattr(thing, "__qualname__") and f"{thing.__module__}.{name}" not in entries:
            absent.append(name)
    # The installed plugins are reached by their names, not by this function.
    assert set(absent) <= {"plugins"}


@pytest.mark.soak
def test_the_reference_is_written(site: Path):
    reference = (site / "reference.html").read_text(encoding="utf-8")
    for name in (
        "identify",
        "predict",
        "excluding",
        "DataError",
        "rad/s",
        "run_study",
        "TimeTest",
        "check_model",
    ):
        assert name in reference


def way() -> ModuleType:
    """The script that draws the way of the data."""
    spec = spec_from_file_location("make_way", DOCS / "make_way.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_way_of_the_data_is_drawn_from_modules_that_exist():
    script = way()
    assert script.TARGET.read_text(encoding="utf-8") == script.picture()
    shown = [room.modules for room in script.ROOMS] + [
        " ".join(side.modules) for side in script.SIDES
    ]
    absent = []
    for names in shown:
        folder = ""
        for name in names.split():
            folder = name.rpartition("/")[0] or folder
            path = f"{folder}/{name.rpartition('/')[2]}"
            places = [ROOT / "plugins" / path, ROOT / "framework" / "springpot" / path]
            places += [ROOT / "framework" / "springpot" / name]
            absent += [name] if not any(place.exists() for place in places) else []
    assert absent == []


@pytest.mark.soak
def test_the_map_of_the_house_is_true():
    """What the page for contributors calls a file or a folder is one."""
    page = (DOCS / "contributing.md").read_text(encoding="utf-8")
    absent, folder = [], ROOT
    for name in re.findall(r"`([\w./-]+?(?:/|\.py))`", page):
        # A bare name stands beside the one before it.
        path = ROOT / name if "/" in name.rstrip("/") else folder / name
        if not path.exists():
            absent.append(name)
        folder = path if path.is_dir() else path.parent
    assert absent == []
