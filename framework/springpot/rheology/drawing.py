"""Pictures of networks: as text, in box characters, and as self-contained SVG."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple, TypeAlias
from xml.sax.saxutils import escape, quoteattr

from .effect import Stage
from .elements import Continuum
from .levels import Own
from .nodes import Chain, Composition, Mapped, Node, Parallel, Renamed, Series, Shift

if TYPE_CHECKING:
    from .named import NamedNetwork


SYMBOLS = {"spring": "╱╲╱╲╱", "dashpot": "━[┣━", "springpot": "◇", "mass": "█"}
"""Middle of the wire for each kind of element; any other kind is written out in a box."""


@dataclass(frozen=True)
class Leaf:
    """An element in a picture: what it is and the names of its parameters."""

    kind: str
    label: str


@dataclass(frozen=True)
class Row:
    """Parts one after the other."""

    parts: tuple[Sketch, ...]


@dataclass(frozen=True)
class Stack:
    """Parts side by side."""

    parts: tuple[Sketch, ...]


@dataclass(frozen=True)
class Signal:
    """A network seen through something that is no part of it.

    A measurement chain or a frequency shift.
    """

    inner: Sketch
    operation: str
    outer: Leaf


Sketch: TypeAlias = Leaf | Row | Stack | Signal


def sketch(node: Node, prefix: str = "") -> Sketch:
    """What a picture of `node` shows, without any sizes.

    Parameters
    ----------
    node : Node
        Any network.
    prefix : str
        Put before each element's names, with a dot.
    """
    if isinstance(node, Renamed):
        return sketch(node.node, _prefixed(prefix, node.prefix))
    if isinstance(node, Mapped | Own):
        return sketch(node.node, prefix)
    # It has as many parameters as lines: the parts that they stand for are drawn instead.
    if isinstance(node, Continuum):
        own = {"spring": "K_e", "dashpot": "c", "spectrum": "H(r)"}
        return Stack(tuple(Leaf(kind, _prefixed(prefix, label)) for kind, label in own.items()))
    if isinstance(node, Parallel):
        return Stack(tuple(sketch(child, prefix) for child in node.children))
    if isinstance(node, Series):
        return Row(tuple(sketch(child, prefix) for child in node.children))
    # A picture of the specimen and its rig: what a test did to them is no part of it.
    if isinstance(node, Stage):
        return sketch(node.children[0], prefix)
    if isinstance(node, Composition):
        operation = ""
        if isinstance(node, Chain):
            operation = "K·"
        elif isinstance(node, Shift):
            operation = "ω·"
        return Signal(sketch(node.children[0], prefix), operation, _leaf(node.children[1], prefix))
    return _leaf(node, prefix)


def _prefixed(prefix: str, name: str) -> str:
    if not prefix:
        return name
    return f"{prefix}.{name}"


def _leaf(node: Node, prefix: str) -> Leaf:
    while isinstance(node, Renamed | Own):
        if isinstance(node, Renamed):
            prefix = _prefixed(prefix, node.prefix)
        node = node.node
    label = ", ".join(parameter.name for parameter in node.parameters)
    # An element of a plugin need not name its kind: its class does.
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", type(node).__name__).lower()
    return Leaf(getattr(node, "kind", words), _prefixed(prefix, label))


@dataclass(frozen=True)
class _Block:
    """Lines of equal length; the wire enters and leaves at line `wire`."""

    lines: tuple[str, ...]
    wire: int

    @property
    def width(self) -> int:
        return len(self.lines[0])

    def padded(self, above: int, below: int) -> _Block:
        blank = " " * self.width
        return _Block((blank,) * above + self.lines + (blank,) * below, self.wire + above)

    def widened(self, width: int) -> _Block:
        lines = [_centred(line, width, " ") for line in self.lines]
        # The wire goes on to both ends, where the branches are joined.
        lines[self.wire] = _centred(self.lines[self.wire], width, "─")
        return _Block(tuple(lines), self.wire)


def _beside(blocks: Sequence[_Block]) -> _Block:
    # All wires on one line: what stands one after the other is joined by them.
    above = max(block.wire for block in blocks)
    below = max(len(block.lines) - block.wire for block in blocks)
    level = [
        block.padded(above - block.wire, below - len(block.lines) + block.wire) for block in blocks
    ]
    return _Block(
        tuple("".join(lines) for lines in zip(*(block.lines for block in level), strict=True)),
        above,
    )


def _stacked(blocks: Sequence[_Block]) -> _Block:
    # Branches of equal width, so that their rails stand upright.
    width = max(block.width for block in blocks)
    lines: list[str] = []
    wires: list[int] = []
    for block in blocks:
        wires.append(len(lines) + block.wire)
        lines.extend(block.widened(width).lines)
    middle = (wires[0] + wires[-1]) // 2
    left = _rail(len(lines), wires, middle, "┌├└", "┤┼")
    right = _rail(len(lines), wires, middle, "┐┤┘", "├┼")
    ends = [" "] * len(lines)
    ends[middle] = "─"
    drawn = (
        end + a + line + b + end for end, a, line, b in zip(ends, left, lines, right, strict=True)
    )
    return _Block(tuple(drawn), middle)


def _rail(height: int, wires: list[int], middle: int, turns: str, exits: str) -> list[str]:
    """The upright wire that joins the branches at lines `wires` and leaves at line `middle`."""
    rail = [" "] * height
    for i in range(wires[0], wires[-1] + 1):
        rail[i] = "│"
    for i in wires:
        rail[i] = turns[1]
    rail[wires[-1]] = turns[2]
    rail[wires[0]] = turns[0]  # last, as a single wire is both ends
    rail[middle] = exits[0]
    if middle in wires:
        rail[middle] = exits[1]
    return rail


def _element(symbol: str, label: str, wire: str) -> _Block:
    width = max(len(symbol), len(label)) + 4
    return _Block((_centred(label, width, " "), _centred(symbol, width, wire)), 1)


def _centred(text: str, width: int, fill: str) -> str:
    left = (width - len(text)) // 2
    return fill * left + text + fill * (width - len(text) - left)


def _drawn(part: Sketch) -> _Block:
    match part:
        case Leaf():
            return _element(SYMBOLS.get(part.kind, f"[{part.kind}]"), part.label, "─")
        case Row():
            return _beside([_drawn(child) for child in part.parts])
        case Stack():
            return _stacked([_drawn(child) for child in part.parts])
    outer = _element(f"{part.operation}[{part.outer.kind}]", part.outer.label, "┄")
    return _beside([_drawn(part.inner), outer])


def draw(node: Node) -> str:
    """A network as text.

    Parameters
    ----------
    node : Node
        Any network; the parts of a `Mapped` one are labelled with what they are in its published
        parameters.

    Returns
    -------
    str
        Lines without trailing blanks.

    Examples
    --------
    >>> from springpot.rheology import dashpot, draw, parallel, spring
    >>> print(draw(parallel(spring(), dashpot())))
          k
     ┌──╱╲╱╲╱──┐
    ─┤   c     ├─
     └──━[┣━───┘
    """
    block = _drawn(sketch(node))
    lines = [line.rstrip() for line in block.lines]
    return "\n".join(line for line in lines if line)


def drawing_of(model: NamedNetwork) -> str:
    """The text picture of a model: its own, or one drawn from its network.

    Examples
    --------
    >>> import springpot
    >>> from springpot.rheology import drawing_of
    >>> print(drawing_of(springpot.parse_model("fractional-maxwell")))
        k      c, alpha
    ──╱╲╱╲╱───────◇──────
    """
    # Its own shows the bare material: with an effect it would be another network.
    if model.drawing and not model.of_specimen.effects:
        return model.drawing
    return draw(model.network)


class Room(NamedTuple):
    """What a picture leaves for its parts, in px; for each letter of a label too."""

    letter: float
    label_rise: float
    rail: float
    lead: float
    margin: float


SVG = Room(letter=7.4, label_rise=20.0, rail=26.0, lead=14.0, margin=8.0)

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
        max(s.width for s in sizes) + 2 * SVG.rail, middle + sizes[0].up, middle + sizes[-1].down
    )


def _row_size(sizes: Sequence[Size]) -> Size:
    return Size(sum(s.width for s in sizes), max(s.up for s in sizes), max(s.down for s in sizes))


def _leaf_size(leaf: Leaf, operation: str) -> Size:
    inside = SVG.letter * len(operation + leaf.kind) + 16
    if leaf.kind in DRAWN and not operation:
        inside = 44.0
    return Size(max(inside, SVG.letter * len(leaf.label)) + 2 * SVG.lead, SVG.label_rise + 16, 18.0)


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


DRAWN = {"spring": _spring, "dashpot": _dashpot, "springpot": _springpot, "mass": _mass}
"""How each kind of element is drawn, 44 px wide about a centre.

Any other kind is a box with its name.
"""


def _wire(x1: float, x2: float, y: float, dashed: bool = False) -> list[Mark]:
    if x2 <= x1:
        return []
    return [Stroke(((x1, y), (x2, y)), dashed=dashed)]


def _leaf_marks(leaf: Leaf, x: float, y: float, width: float, operation: str) -> list[Mark]:
    centre = x + width / 2
    if leaf.kind in DRAWN and not operation:
        half, symbol = 22.0, DRAWN[leaf.kind](centre, y)
    else:
        # An element that has no symbol is a box with its name.
        text = operation + leaf.kind
        half = (SVG.letter * len(text) + 16) / 2
        symbol = [_box_about(centre, y, half, 13), Label(centre, y, text)]
    leads = _wire(x, centre - half, y, bool(operation)) + _wire(
        centre + half, x + width, y, bool(operation)
    )
    return [*leads, *symbol, Label(centre, y - SVG.label_rise - 3, leaf.label)]


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
    left = x + (width - own.width) / 2 + SVG.rail / 2
    right = left + own.width - SVG.rail
    top = y - wires[-1] / 2
    drawn = _wire(x, left, y) + _wire(right, x + width, y)
    drawn += [Stroke(((rail, top), (rail, top + wires[-1]))) for rail in (left, right)]
    for child, wire in zip(part.parts, wires, strict=True):
        drawn += marks(child, left, top + wire, right - left)
    return drawn


def _picture(node: Node) -> tuple[float, float, list[Mark]]:
    part = sketch(node)
    room = size(part)
    drawn = marks(part, SVG.margin, room.up + SVG.margin, room.width)
    return room.width + 2 * SVG.margin, room.up + room.down + 2 * SVG.margin, drawn


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
