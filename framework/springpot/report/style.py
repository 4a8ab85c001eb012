"""The style sheet of a page: one column on a phone, two on a desk, nothing from elsewhere.

A page that needs nothing else.

No network, its style sheet inside, no script but one known by its digest.
"""

from __future__ import annotations

from springpot.writing import Html, tag

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
