"""A page that needs nothing else.

No network, its style sheet inside, no script but one known by its digest.
"""

from __future__ import annotations

from springpot.markup import Html, tag

from .style import STYLE

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
