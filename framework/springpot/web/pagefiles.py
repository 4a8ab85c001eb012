"""All that the page consists of, read once, so that no name from a browser ever opens a file."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


@cache
def page_files() -> dict[str, tuple[bytes, str]]:
    """Content and media type of each file of the page, by name."""
    found = {}
    for item in (files("springpot.web") / "page").iterdir():
        kind = KINDS.get(item.name[item.name.rfind(".") :])
        if kind is not None:
            found[item.name] = (item.read_bytes(), kind)
    return found
