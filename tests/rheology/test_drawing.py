"""Text pictures: every element and every name appears once, and the wires meet."""

from __future__ import annotations

import numpy as np

from springpot.rheology import (
    Effect,
    Layer,
    Model,
    chain,
    dashpot,
    draw,
    drawing_of,
    mass,
    parallel,
    series,
    spring,
    springpot,
)
from springpot.rheology.drawing import SYMBOLS

ZENER = parallel(spring("k1"), series(spring("k2"), springpot()))


def test_the_zener_network_as_it_should_look():
    assert draw(ZENER).splitlines() == [
        "           k1",
        " ┌────────╱╲╱╲╱────────┐",
        "─┤   k2      c, alpha  ├─",
        " └──╱╲╱╲╱───────◇──────┘",
    ]


def test_symbols_are_counted_and_told_apart():
    network = parallel(
        series(spring("a"), dashpot("b"), springpot("c", "d")), mass("m"), spring("e")
    )
    picture = draw(network)
    for kind, count in {"spring": 2, "dashpot": 1, "springpot": 1, "mass": 1}.items():
        assert picture.count(SYMBOLS[kind]) == count
    for name in "abcdem":
        assert picture.count(name) == 1


def test_upright_wires_join_the_lines_above_and_below():
    network = series(
        spring(),
        parallel(spring(), parallel(dashpot(), series(mass(), springpot())), ZENER),
        mass(),
    )
    lines = draw(network).splitlines()
    grid = np.array([list(line.ljust(max(map(len, lines)))) for line in lines])
    down, up = set("┌┐│├┤┼"), set("└┘│├┤┼")
    for row, column in np.argwhere(np.isin(grid, list(down - set("├┤┼")))):
        assert grid[row + 1, column] in up, (row, column)
    for row, column in np.argwhere(np.isin(grid, list(up - set("├┤┼")))):
        assert grid[row - 1, column] in down, (row, column)


def test_effects_are_drawn_where_they_act():
    model = Model("zener", ZENER, drawing="my own picture")
    assert drawing_of(model) == "my own picture"
    grown = model + Effect("inertia", parallel, mass(), "a mass", Layer.MOVING_PARTS)
    grown = grown + Effect("delay", chain, dashpot("tau"), "a delay", Layer.SIGNAL)
    picture = drawing_of(grown)
    assert "inertia.m" in picture
    assert "delay.tau" in picture
    assert "┄" in picture
