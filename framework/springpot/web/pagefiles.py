"""All that the page consists of, read once, so that no name from a browser ever opens a file."""

from __future__ import annotations

from functools import cache

from springpot.report.interactive.assets import assets_in, modules

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


@cache
def page_files() -> dict[str, tuple[bytes, str]]:
    """Content and media type of each file of the page by name, modules of reports included."""
    files = modules() | assets_in("springpot.web", "page")
    kinds = {name: KINDS.get(name[name.rfind(".") :]) for name in files}
    # A file of no known kind is no part of the page, such as one that an editor left behind.
    return {name: (files[name], kind) for name, kind in kinds.items() if kind is not None}
