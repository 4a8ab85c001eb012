"""The page without a server: one HTML file with every rung of a ladder and all previews, for a colleague."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Sequence
from typing import Any

from springpot.markup import Html, tag
from springpot.report.jsontext import to_json

from .pagefiles import page_files

MODULES = ("dom.js", "numbers.js", "plot.js", "views.js", "compare.js", "ladder.js", "missing.js", "alone.js")
"""In an order in which each imports only from those before it."""
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./([\w.]+)";$', re.M)
EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.M)


def page_alone(scene: dict[str, Any], answers: Sequence[dict[str, Any]], command: str) -> Html:
    """The file as text.

    Parameters
    ----------
    scene : dict
        The data, see `Scene.to_dict`.
    answers : sequence of dict
        One for each rung, schema ``springpot.workbench/1``.
    command : str
        What gives the same on the command line.
    """
    program = "\n".join(['"use strict";', "const modules = {};", *map(_as_function, MODULES)])
    style = page_files()["style.css"][0].decode()
    told = to_json({"scene": scene, "answers": answers, "command": command}, None)
    policy = f"default-src 'none'; script-src '{_digest(program)}'; style-src '{_digest(style)}'; img-src data:"
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", f"{answers[-1]['discovery']['diagnosis']['model']} of {scene['name']}"),
        tag("style", Html(style)),
    )
    # In a script only its own end tag means anything; within JSON every < may be written by its number.
    data = tag("script", Html(told.replace("<", "\\u003c")), type="application/json", id="told")
    body = tag("body", Html('<main id="bench"></main>'), data, tag("script", Html(program)))
    return Html(f"<!doctype html>\n{tag('html', head, body, lang='en')}\n")


def _as_function(name: str) -> str:
    """A module as a function whose result is what it exports: one inline script cannot hold several modules."""
    source = page_files()[name][0].decode()
    names = [found[1] for found in EXPORT.findall(source)]
    source = EXPORT.sub(r"\1", IMPORT.sub(r'const \1 = modules["\2"];', source))
    return f'modules["{name}"] = (() => {{\n{source}\nreturn {{ {", ".join(names)} }};\n}})();'


def _digest(text: str) -> str:
    """As a Content-Security-Policy names what it allows inline."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
