"""The panels of the workbench inside a page that has no server.

Every rung of a ladder with all its previews.

The ES modules and style sheets that every page shares, read once.
"""

from __future__ import annotations

import base64
import hashlib
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from springpot.writing import Html, tag

from ..text import to_json


def assets_in(package: str, folder: str) -> dict[str, bytes]:
    """Content of each file in a folder of a package, by name."""
    return {
        item.name: item.read_bytes()
        for item in (files(package) / folder).iterdir()
        if item.is_file()
    }


@cache
def modules() -> dict[str, bytes]:
    """Content of each shared module and style sheet, by name."""
    return assets_in("springpot.report.interactive", "modules")


ORDER = (
    "dom.js",
    "numbers.js",
    "plot.js",
    "views.js",
    "zoom.js",
    "pointing.js",
    "spots.js",
    "hero.js",
    "compare.js",
    "ladder.js",
    "spark.js",
    "missing.js",
    "report.js",
)
"""Each imports only from those before it."""
STYLES = ("panels.css", "report.css")
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./([\w.]+)";$', re.M)
EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.M)


@dataclass(frozen=True)
class PageParts:
    """Parts of a page that belong together.

    Parameters
    ----------
    body : Html
        Stands where the panels are to be; their data and their program.
    style : str
        Rules for the style sheet of the page.
    policy : str
        What a Content-Security-Policy must allow as ``script-src``: this program and no other.
    """

    body: Html
    style: str
    policy: str


def bench_of(given: dict[str, Any]) -> PageParts:
    """The panels of a report.

    Parameters
    ----------
    given : dict
        ``scene``, see `PageScene.to_dict`; ``rungs``, see `rungs`; ``excluded``: rows that no model
        was fitted to.
    """
    program = "\n".join(['"use strict";', "const modules = {};", *map(_as_function, ORDER)])
    style = "\n".join(modules()[name].decode() for name in STYLES)
    # In a script only its own end tag means anything; within JSON every < may be written by its
    # number.
    escaped = to_json(given, None).replace("<", "\\u003c")
    data = tag("script", Html(escaped), type="application/json", id="given")
    body = Html(f"{tag('div', id='bench')}{data}{tag('script', Html(program))}")
    # By its digest: a script that slipped in with the data would have another, and no browser would
    # run it.
    return PageParts(body, style, f"'{_digest(program)}'")


def _as_function(name: str) -> str:
    """A module as a function whose result is what it exports.

    One inline script cannot hold several modules.
    """
    source = modules()[name].decode()
    names = [name for _, name in EXPORT.findall(source)]
    # Imports become look-ups in what the modules before it have left, exports what is returned.
    source = EXPORT.sub(r"\1", IMPORT.sub(r'const \1 = modules["\2"];', source))
    return f'modules["{name}"] = (() => {{\n{source}\nreturn {{ {", ".join(names)} }};\n}})();'


def _digest(text: str) -> str:
    """As a Content-Security-Policy names what it allows inline."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
