"""Pictures of networks as text: springs, dashpots, springpots and masses in box characters."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from .effect import Stage
from .elements import Continuum
from .levels import Own
from .named import NamedNetwork
from .nodes import Chain, Composition, Mapped, Node, Parallel, Renamed, Series, Shift

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
