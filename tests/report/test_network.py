"""SVG and PNG pictures: well-formed, escaped, and no two labels over each other."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

from springpot.registry import plugins
from springpot.rheology import (
    Node,
    chain,
    dashpot,
    drawing,
    mass,
    parallel,
    series,
    spring,
    springpot,
)
from springpot.rheology.drawing import SVG as ROOM, Label, marks, network_svg, size, sketch
from springpot.rheology.model import Family

SVG = "{http://www.w3.org/2000/svg}"
NETWORKS = [
    item.build(3).network if isinstance(item, Family) else item.network
    for item in plugins().items("model")
]
NETWORKS.append(
    chain(
        parallel(mass("inertia.m"), series(spring("mounting-compliance.k"), springpot())), dashpot()
    )
)


def labels(node: Node) -> list[Label]:
    part = sketch(node)
    return [mark for mark in marks(part, 0.0, 0.0, size(part).width) if isinstance(mark, Label)]


@pytest.mark.parametrize("node", NETWORKS)
def test_labels_do_not_overlap(node: Node):
    drawn = labels(node)
    for i, a in enumerate(drawn):
        for b in drawn[:i]:
            apart_x = abs(a.x - b.x) >= ROOM.letter * (len(a.text) + len(b.text)) / 2
            assert apart_x or abs(a.y - b.y) >= 14, (a, b)


@pytest.mark.parametrize("node", NETWORKS)
def test_svg_holds_every_label_inside_its_frame(node: Node):
    root = ElementTree.fromstring(network_svg(node))
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    texts = list(root.iter(f"{SVG}text"))
    assert [text.text for text in texts] == [label.text for label in labels(node)]
    for text in texts:
        half = ROOM.letter * len(text.text or "") / 2
        assert half <= float(text.attrib["x"]) <= width - half
        assert 0 < float(text.attrib["y"]) < height


def test_names_are_escaped():
    svg = network_svg(spring("<k&1>"))
    assert "&lt;k&amp;1&gt;" in svg
    assert [text.text for text in ElementTree.fromstring(svg).iter(f"{SVG}text")] == ["<k&1>"]


@pytest.mark.parametrize("kind", drawing.DRAWN)
def test_a_symbol_reaches_as_far_to_either_side_and_its_lines_join_it(kind):
    marks = [mark for mark in drawing.DRAWN[kind](100.0, 50.0) if hasattr(mark, "points")]
    across = [x for mark in marks for x, _ in mark.points]
    assert (min(across), max(across)) == (78.0, 122.0)
    body = [mark for mark in marks if getattr(mark, "closed", False)]
    for block in body:
        sides = [x for x, _ in block.points]
        assert min(sides) + max(sides) == 200.0
        ends = {x for mark in marks if mark is not block for x, _ in mark.points}
        assert {min(sides), max(sides)} <= ends
