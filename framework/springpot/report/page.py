"""A page that needs nothing else: its style sheet, and panels of the workbench without a server.

No network, one column on a phone and two on a desk, no script but one known by its digest. The ES
modules and style sheets that every page shares are read once; a ladder stands there with every rung
and all its previews.
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

from .text import to_json

STYLE = """
:root { color-scheme: light; --ink: #222; --quiet: #666; --line: #ddd;
  --mark: #0072b2; --soft: #f4f6f8; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff; font: 16px/1.5 system-ui, sans-serif;
  overflow-wrap: anywhere; }
main { max-width: 1060px; margin: 0 auto; padding: 24px 16px 64px; }
h1 { font-size: 1.7em; line-height: 1.2; margin: 0 0 4px; }
h2 { font-size: 1.25em; margin: 40px 0 8px; padding-top: 12px; border-top: 1px solid var(--line); }
h3 { font-size: 1em; margin: 20px 0 4px; }
p, ul { margin: 6px 0; max-width: 46em; }
li { margin: 4px 0; }
.quiet { color: var(--quiet); font-size: 0.92em; }
.verdict { background: var(--soft); border-left: 4px solid var(--mark); padding: 10px 14px;
  margin: 14px 0; }
.facts { display: flex; flex-wrap: wrap; gap: 10px; margin: 14px 0; }
.fact { flex: 1 1 150px; border: 1px solid var(--line); border-radius: 6px; padding: 8px 12px; }
.fact b { display: block; font-size: 1.25em; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 8px 24px; }
figure { margin: 8px 0; min-width: 0; }
figure img { width: 100%; height: auto; display: block; }
.alone { max-width: 680px; }
figcaption { font-size: 0.92em; color: var(--quiet); }
.scroll { overflow-x: auto; max-width: 100%; }
table { border-collapse: collapse; font-size: 0.92em; margin: 8px 0; }
th, td { text-align: left; vertical-align: top; padding: 4px 14px 4px 0;
  border-bottom: 1px solid var(--line); overflow-wrap: normal; }
th { font-weight: 600; white-space: nowrap; }
td.number, th.number { text-align: right; white-space: nowrap; }
td:nth-child(-n+2) { white-space: nowrap; }
.physics { min-width: 16em; }
.whole { white-space: nowrap; margin-right: 0.5em; }
details { margin: 8px 0; }
summary { cursor: pointer; font-weight: 600; }
code, pre { font: 0.9em/1.45 ui-monospace, monospace; }
pre { background: var(--soft); padding: 10px 12px; white-space: pre-wrap; }
.key { display: inline-block; margin-right: 14px; white-space: nowrap; }
.key i { display: inline-block; width: 12px; height: 12px; margin-right: 5px;
  vertical-align: -1px; }
@media (max-width: 760px) {
  main { padding-top: 16px; }
  .pair { grid-template-columns: minmax(0, 1fr); }
  thead { display: none; }
  table, tbody, tr { display: block; }
  tr { border-bottom: 1px solid var(--line); padding: 6px 0; }
  td, td.number { display: grid; grid-template-columns: 9em minmax(0, 1fr); border: 0;
    padding: 1px 0; text-align: left; white-space: normal; overflow-wrap: anywhere; }
  td::before { content: attr(data-label); color: var(--quiet); }
  .physics { min-width: 0; }
}
@media print { h2 { break-after: avoid; } figure { break-inside: avoid; } }
"""


POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
"""What a browser may load for the page: nothing that is not in it."""


def page(title: str, *body: str, style: str = "", script: str = "") -> Html:
    """A whole document.

    Parameters
    ----------
    title : str
        Of the window.
    *body : str
        Its parts, one below the other.
    style : str
        Rules beside those of every page.
    script : str
        What the policy of the page allows as ``script-src``; without it no script runs, whatever
        stands in the page.
    """
    # In the page itself, as a file has no server to send it: even what was not escaped could not
    # run.
    policy = POLICY
    if script:
        policy = f"{POLICY}; script-src {script}"
    head = tag(
        "head",
        # First: a browser reads on with it from here.
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", title),
        tag("style", Html(STYLE + style)),
    )
    return Html(
        f"<!doctype html>\n{tag('html', head, tag('body', tag('main', *body)), lang='en')}\n"
    )


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
