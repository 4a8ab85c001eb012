"""Draws images/way.svg, the way of the data through the house, from the names of its modules.

``python docs/make_way.py`` makes it anew; ``tests/test_site.py`` keeps it as it stands here, and
its modules true.
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import NamedTuple

TARGET = Path(__file__).resolve().parent / "images" / "way.svg"
WIDTH, HEIGHT = 1000, 860
ROOMS_LEFT, ROOM_WIDTH, ROOM_HEIGHT, STEP = 30, 630, 78, 104
SIDE_LEFT, SIDE_WIDTH = 710, 260


class Room(NamedTuple):
    """A place on the way: what it is called, what becomes of the data there, and its modules."""

    title: str
    says: str
    modules: str


ROOMS = [
    Room(
        "Files and data sets",
        "the format is recognised, columns and units are read",
        "springpot_plugins/readers/  springpot_plugins/datasets/",
    ),
    Room(
        "measurement",
        "a sweep or a test in time, with its noise; signals become harmonics",
        "measurement/opening.py  measurement.py  timetest.py  signals.py",
    ),
    Room(
        "identification",
        "the model's parameters, with intervals",
        "identification/fitting.py  native.py  uncertainty.py",
    ),
    Room(
        "misfit",
        "how far the model is off, beside which noise and which material floor, and where",
        "misfit/floor.py  material.py  residual_tests.py  where.py",
    ),
    Room(
        "diagnosis",
        "which effects are missing: scan, search, evidence, verdict, next experiment",
        "diagnosis/examination.py  scan.py  search.py  evidence.py  verdict.py  experiment.py",
    ),
    Room(
        "ladder, comparison, superposition",
        "rung by rung to the noise floor; models beside each other; sweeps on one curve",
        "diagnosis/ladder.py  comparison/comparing.py  superposition/curve.py",
    ),
    Room(
        "report",
        "words, tables, pictures, pages and JSON of a result",
        "report/text.py  views.py  answers.py",
    ),
    Room("Command line, Python", "what was asked is answered", "cli/group.py  api.py"),
]
"""From above to below. A module without a folder lies in the folder that was named before it."""


class Side(NamedTuple):
    """What stands beside the way, from one room to another."""

    title: str
    says: tuple[str, ...]
    modules: tuple[str, ...]
    first: int
    last: int


SIDES = [
    Side(
        "rheology",
        ("models, effects: K with its exact", "derivatives, and force in time"),
        ("rheology/model.py", "rheology/effect.py"),
        0,
        1,
    ),
    Side(
        "timetests",
        ("the same four steps, where a test", "in time is among the data"),
        tuple(f"timetests/{name}.py" for name in ("fitting", "score", "diagnosis", "discovery")),
        2,
        5,
    ),
    Side(
        "guests",
        (
            "the race, structures, solvers and",
            "the workbench: they use the core,",
            "which knows none of them",
        ),
        ("benchmark/  structure/", "solvers/  web/"),
        6,
        7,
    ),
]


def top(room: int) -> int:
    """Where a room begins, in pixels from above."""
    return 24 + room * STEP


def box(left: int, above: int, width: int, height: int, kind: str) -> str:
    """A rectangle with round corners."""
    return f'<rect class="{kind}" x="{left}" y="{above}" width="{width}" height="{height}" rx="8"/>'


def line(left: int, base: int, text: str, kind: str) -> str:
    """A line of text."""
    return f'<text class="{kind}" x="{left}" y="{base}">{escape(text)}</text>'


def arrow(x: int, start: int, end: int) -> str:
    """An arrow downwards."""
    return f'<path class="arrow" d="M{x} {start} V{end - 10}" marker-end="url(#tip)"/>'


def picture() -> str:
    """The picture as SVG."""
    parts = [box(0, 0, WIDTH, HEIGHT, "paper")]
    for number, room in enumerate(ROOMS):
        above = top(number)
        outside = number in (0, len(ROOMS) - 1)
        parts += [
            box(ROOMS_LEFT, above, ROOM_WIDTH, ROOM_HEIGHT, "outside" if outside else "room"),
            line(ROOMS_LEFT + 16, above + 24, room.title, "title"),
            line(ROOMS_LEFT + 16, above + 45, room.says, "says"),
            line(ROOMS_LEFT + 16, above + 66, room.modules, "module"),
        ]
        if number:
            parts.append(arrow(ROOMS_LEFT + ROOM_WIDTH // 2, above - STEP + ROOM_HEIGHT, above))
    for side in SIDES:
        above, height = top(side.first), (side.last - side.first) * STEP + ROOM_HEIGHT
        parts.append(box(SIDE_LEFT, above, SIDE_WIDTH, height, "side"))
        parts.append(line(SIDE_LEFT + 14, above + 24, side.title, "title"))
        words = [(text, "says") for text in side.says]
        words += [(name, "module") for name in side.modules]
        for row, (text, kind) in enumerate(words):
            parts.append(line(SIDE_LEFT + 14, above + 45 + 20 * row, text, kind))
        for room in range(max(side.first, 1), side.last + 1):
            joined = top(room) + ROOM_HEIGHT // 2
            start = ROOMS_LEFT + ROOM_WIDTH
            parts.append(f'<path class="beside" d="M{start} {joined} H{SIDE_LEFT}"/>')
    return HEAD + "\n".join(parts) + "\n</svg>\n"


HEAD = f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}"
 width="{WIDTH}" height="{HEIGHT}" role="img">
<title>The way of the data: from a file to an answer</title>
<style>
text {{ font-family: sans-serif; fill: #1c2733 }}
.title {{ font-size: 16px; font-weight: bold }}
.says {{ font-size: 14px }}
.module {{ font-family: monospace; font-size: 11.5px; fill: #4a5968 }}
.paper {{ fill: #ffffff }}
.room {{ fill: #e6f0fa; stroke: #3b6ea5 }}
.outside {{ fill: #eef5e9; stroke: #5c8a3a }}
.side {{ fill: #fbf3e2; stroke: #b07d2b }}
.arrow {{ stroke: #3b6ea5; stroke-width: 2; fill: none }}
.beside {{ stroke: #b07d2b; stroke-width: 1.5; stroke-dasharray: 4 3; fill: none }}
</style>
<defs><marker id="tip" markerUnits="userSpaceOnUse" markerWidth="10" markerHeight="10"
 refX="0" refY="5" orient="auto"><path d="M0 0 L10 5 L0 10 z" fill="#3b6ea5"/></marker></defs>
"""

if __name__ == "__main__":
    TARGET.write_text(picture(), encoding="utf-8")
