"""Pictures of networks with the standard symbols, as self-contained SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias
from xml.sax.saxutils import escape, quoteattr

from springpot.rheology.drawing import Leaf, Row, Signal, Sketch, Stack, sketch
from springpot.rheology.nodes import Node

LETTER = 7.4
"""Width allowed for a letter of the labels, in px."""
LABEL_RISE = 20.0
RAIL = 26.0
LEAD = 14.0
MARGIN = 8.0

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Stroke:
    """A line through points, closed to an outline or open."""

    points: tuple[Point, ...]
    closed: bool = False
    dashed: bool = False


@dataclass(frozen=True)
class Label:
    """Text centred about a point."""

    x: float
    y: float
    text: str


Mark: TypeAlias = Stroke | Label


@dataclass(frozen=True)
class Size:
    """Extent of a part: its width, and how far it reaches above and below its wire."""

    width: float
    up: float
    down: float


def size(part: Sketch) -> Size:
    """Room that a part of a picture needs, in px."""
    if isinstance(part, Leaf):
        return _leaf_size(part, "")
    if isinstance(part, Signal):
        return _row_size([size(part.inner), _leaf_size(part.outer, part.operation)])
    sizes = [size(child) for child in part.parts]
    if isinstance(part, Row):
        return _row_size(sizes)
    wires = _wires(sizes)
    middle = wires[-1] / 2
    return Size(
        max(s.width for s in sizes) + 2 * RAIL, middle + sizes[0].up, middle + sizes[-1].down
    )


def _row_size(sizes: Sequence[Size]) -> Size:
    return Size(sum(s.width for s in sizes), max(s.up for s in sizes), max(s.down for s in sizes))


def _leaf_size(leaf: Leaf, operation: str) -> Size:
    inside = LETTER * len(operation + leaf.kind) + 16
    if leaf.kind in SYMBOLS and not operation:
        inside = 44.0
    return Size(max(inside, LETTER * len(leaf.label)) + 2 * LEAD, LABEL_RISE + 16, 18.0)


def _wires(sizes: Sequence[Size]) -> list[float]:
    """Heights of the wires of stacked parts below the first one's."""
    wires = [0.0]
    for above, below in pairwise(sizes):
        wires.append(wires[-1] + above.down + below.up)
    return wires


def _spring(x: float, y: float) -> list[Mark]:
    teeth = [(x - 22, y), (x - 18, y)]
    for i in range(6):
        # Up and down in turn.
        tip = y + 9
        if i % 2 == 0:
            tip = y - 9
        teeth.append((x - 15 + 6 * i, tip))
    return [Stroke((*teeth, (x + 18, y), (x + 22, y)))]


def _about(x: float, y: float, *offsets: tuple[float, float], closed: bool = False) -> Stroke:
    """A stroke through points that lie so far to the right of and below a centre."""
    return Stroke(tuple((x + right, y + down) for right, down in offsets), closed=closed)


def _box_about(x: float, y: float, half: float, height: float) -> Stroke:
    """A rectangle of half that width and half that height."""
    corners = (-half, -height), (half, -height), (half, height), (-half, height)
    return _about(x, y, *corners, closed=True)


def _leads(x: float, y: float, left: float, right: float) -> list[Mark]:
    """Wires from the ends of a symbol to what it leaves free."""
    return [_about(x, y, (-22, 0), (left, 0)), _about(x, y, (right, 0), (22, 0))]


def _dashpot(x: float, y: float) -> list[Mark]:
    into, out = _leads(x, y, -12, 2)
    pot = _about(x, y, (12, -11), (-12, -11), (-12, 11), (12, 11))
    piston = _about(x, y, (2, -8), (2, 8))
    return [pot, into, piston, out]


def _springpot(x: float, y: float) -> list[Mark]:
    rhombus = _about(x, y, (-16, 0), (0, -12), (16, 0), (0, 12), closed=True)
    return [rhombus, *_leads(x, y, -16, 16)]


def _mass(x: float, y: float) -> list[Mark]:
    hatch = [_about(x, y, (10 * i - 15, 12), (10 * i - 5, -12)) for i in range(3)]
    return [_box_about(x, y, 15, 12), *hatch, *_leads(x, y, -15, 15)]


SYMBOLS = {"spring": _spring, "dashpot": _dashpot, "springpot": _springpot, "mass": _mass}
"""How each kind of element is drawn, 44 px wide about a centre.

Any other kind is a box with its name.
"""


def _wire(x1: float, x2: float, y: float, dashed: bool = False) -> list[Mark]:
    if x2 <= x1:
        return []
    return [Stroke(((x1, y), (x2, y)), dashed=dashed)]


def _leaf_marks(leaf: Leaf, x: float, y: float, width: float, operation: str) -> list[Mark]:
    centre = x + width / 2
    if leaf.kind in SYMBOLS and not operation:
        half, symbol = 22.0, SYMBOLS[leaf.kind](centre, y)
    else:
        # An element that has no symbol is a box with its name.
        text = operation + leaf.kind
        half = (LETTER * len(text) + 16) / 2
        symbol = [_box_about(centre, y, half, 13), Label(centre, y, text)]
    leads = _wire(x, centre - half, y, bool(operation)) + _wire(
        centre + half, x + width, y, bool(operation)
    )
    return [*leads, *symbol, Label(centre, y - LABEL_RISE - 3, leaf.label)]


def marks(part: Sketch, x: float, y: float, width: float) -> list[Mark]:
    """Lines and labels of a part whose wire enters at (x, y) and leaves at (x + width, y)."""
    if isinstance(part, Leaf):
        return _leaf_marks(part, x, y, width, "")
    if isinstance(part, Stack):
        return _stack_marks(part, x, y, width)
    own = size(part)
    # In the middle of the room that it is given, with its wire drawn out to both sides.
    x, slack = x + (width - own.width) / 2, (width - own.width) / 2
    drawn = _wire(x - slack, x, y) + _wire(x + own.width, x + own.width + slack, y)
    if isinstance(part, Signal):
        inner = size(part.inner).width
        drawn += marks(part.inner, x, y, inner)
        return drawn + _leaf_marks(part.outer, x + inner, y, own.width - inner, part.operation)
    for child in part.parts:
        step = size(child).width
        drawn += marks(child, x, y, step)
        x += step
    return drawn


def _stack_marks(part: Stack, x: float, y: float, width: float) -> list[Mark]:
    own = size(part)
    # Around the height of the wire that enters: the picture is even above and below.
    wires = _wires([size(child) for child in part.parts])
    left = x + (width - own.width) / 2 + RAIL / 2
    right = left + own.width - RAIL
    top = y - wires[-1] / 2
    drawn = _wire(x, left, y) + _wire(right, x + width, y)
    drawn += [Stroke(((rail, top), (rail, top + wires[-1]))) for rail in (left, right)]
    for child, wire in zip(part.parts, wires, strict=True):
        drawn += marks(child, left, top + wire, right - left)
    return drawn


def _picture(node: Node) -> tuple[float, float, list[Mark]]:
    part = sketch(node)
    room = size(part)
    drawn = marks(part, MARGIN, room.up + MARGIN, room.width)
    return room.width + 2 * MARGIN, room.up + room.down + 2 * MARGIN, drawn


def _svg_line(line: Stroke) -> str:
    kind = "polyline"
    if line.closed:
        kind = "polygon"
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in line.points)
    dash = ""
    if line.dashed:
        dash = ' stroke-dasharray="3 3"'
    return f'<{kind} points="{points}"{dash}/>'


def _svg_label(label: Label) -> str:
    # Escaped: names of elements come from plugins.
    return f'<text x="{label.x:.1f}" y="{label.y:.1f}" dy="0.35em">{escape(label.text)}</text>'


def network_svg(node: Node) -> str:
    """A network as an SVG element that can stand alone or inside an HTML page.

    Parameters
    ----------
    node : Node
        Any network.

    Returns
    -------
    str
        XML text; lines take the colour of the text around them.
    """
    width, height, drawn = _picture(node)
    lines = "\n".join(_svg_line(mark) for mark in drawn if isinstance(mark, Stroke))
    # Text instead of outlines: it can be searched, copied and read aloud.
    labels = "\n".join(_svg_label(mark) for mark in drawn if isinstance(mark, Label))
    named = ", ".join(mark.text for mark in drawn if isinstance(mark, Label))
    # Attributes rather than a style sheet, which would reach every other picture on the page.
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}"'
        f' viewBox="0 0 {width:.1f} {height:.1f}" role="img"'
        f' aria-label={quoteattr(f"network of {named}")}>\n<g fill="none" stroke="currentColor"'
        f' stroke-width="1.4" stroke-linejoin="round">\n{lines}\n</g>\n<g fill="currentColor"'
        ' font-family="sans-serif" font-size="13"'
        f' text-anchor="middle">\n{labels}\n</g>\n</svg>\n'
    )
