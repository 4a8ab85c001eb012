"""Brings into the site what its pages show from beside the folder `docs`: results, the README.

Pages point to such files as readers of the repository find them (``../results/table1/table1.md``).
In the site they stand below ``repository/``, pages as pages and everything else as it is, together
with what they point to in turn.
"""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePosixPath

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
BESIDE = "repository"
LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<path>[^)#\s:]+)(?P<place>#[^)\s]*)?\)")


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the files beside `docs` that pages point to."""
    waiting = [file.src_uri for file in files.documentation_pages()]
    while waiting:
        page = waiting.pop()
        for link in LINK.finditer(_source(page).read_text(encoding="utf-8")):
            name = _in_site(page, link["path"])
            if name is None or name in files.src_uris or not name.startswith(f"{BESIDE}/"):
                continue
            if _source(name).is_file():
                files.append(File.generated(config, name, abs_src_path=str(_source(name))))
                waiting += [name] if name.endswith(".md") else []
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn the links of a page to where their targets stand in the site.

    Those to folders are words.
    """
    here = page.file.src_uri

    def turned(link: re.Match[str]) -> str:
        name = _in_site(here, link["path"])
        if name is None:
            return link[0]
        if _source(name).is_dir():
            return link["text"]
        path = os.path.relpath(name, PurePosixPath(here).parent)
        return f"[{link['text']}]({path}{link['place'] or ''})"

    return LINK.sub(turned, markdown)


def _source(name: str) -> Path:
    """The file in the repository that has this name in the site."""
    beside = name.removeprefix(f"{BESIDE}/")
    return ROOT / beside if beside != name else ROOT / "docs" / name


def _in_site(page: str, path: str) -> str | None:
    """The name in the site of what a page points to; None where that is in neither place."""
    target = Path(os.path.normpath(_source(page).parent / path))
    if target.is_relative_to(ROOT / "docs"):
        return target.relative_to(ROOT / "docs").as_posix()
    if target.is_relative_to(ROOT) and target.exists():
        return f"{BESIDE}/{target.relative_to(ROOT).as_posix()}"
    return None
