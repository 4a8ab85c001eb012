"""Where a report's plots put things: by hand."""

import re

import numpy as np
import pytest

from springpot.benchmark import plot
from springpot.benchmark.plot import (
    PLOT,
    Pen,
    PlotAxis,
    Ranked,
    _steps,
    _tick,
    critical_differences,
    key,
)


def test_an_axis_is_cut_at_its_ends():
    even = PlotAxis("x", 2.0, 10.0)
    np.testing.assert_allclose(
        even.place(np.array([0.0, 2.0, 4.0, 10.0, 11.0])), [0, 0, 0.25, 1, 1]
    )
    decades = PlotAxis("x", 0.1, 1000.0, logarithmic=True)
    np.testing.assert_allclose(
        decades.place(np.array([0.0, 0.1, 1.0, 100.0, 1e9])), [0, 0, 0.25, 0.75, 1]
    )


def test_numbers_stand_at_decades_or_at_six_even_places():
    assert PlotAxis("x", 0.0, 10.0).ticks() == [0, 2, 4, 6, 8, 10]
    assert PlotAxis("x", 1.0, 1000.0, logarithmic=True).ticks() == [1, 10, 100, 1000]
    assert PlotAxis("x", 0.5, 500.0, logarithmic=True).ticks() == [1, 10, 100]
    most = plot.PLOT.ticks
    assert len(PlotAxis("x", 1.0, 10.0**most, logarithmic=True).ticks()) == most + 1
    every_other = PlotAxis("x", 1.0, 10.0 ** (most + 1), logarithmic=True).ticks()
    assert every_other[:2] == [1, 100]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (0.001, "0.001"), (0.0001, "1e-4"), (10000.0, "10000"),
        (1e5, "1e5"), (1e-12, "1e-12"), (1e12, "1e+12"), (-200.0, "-200"),
    ],
)  # fmt: skip
def test_a_number_at_an_axis_is_short(value, text):
    assert _tick(value) == text


def test_a_step_line_keeps_only_the_corners():
    across, down = np.array([0.0, 1.0, 2.0, 3.0]), np.array([5.0, 5.04, 2.0, 2.0])
    assert _steps(across, down) == "0.0 5.0H2.0V2.0H3.0"


ROWS = [Ranked("a", 1.0, 1.0, 1.5), Ranked("b", 2.0, 1.5, 2.5), Ranked("c", 3.0, 2.5, 3.0)]


def numbers(svg, of, *names):
    """The attributes of each element of a kind."""
    found = re.findall(rf"<{of} [^>]*>", str(svg))
    return [[float(re.search(rf'\b{n}="([-\d.]+)"', e)[1]) for n in names] for e in found]


@pytest.mark.parametrize("cliques", [[], [(0, 1)], [(0, 1), (1, 2)]])
def test_ranks_fill_the_room_between_the_names_and_the_bars(cliques):
    svg = critical_differences(ROWS, cliques, "ranks")
    right = PLOT.width - 7.0 * len(cliques) - 8.0 - 12.0
    places = np.linspace(PLOT.names, right, 3)
    circles = [[x, 4.0 + PLOT.row * (i + 0.5)] for i, x in enumerate(places)]
    np.testing.assert_allclose(numbers(svg, "circle", "cx", "cy"), circles, atol=0.051)
    lines = numbers(svg, "line", "x1", "y1", "x2", "y2")
    intervals = [line for line in lines if line[1] == line[3]]
    # A rank is as wide as half of the room.
    half = 0.25 * (right - PLOT.names)
    wanted = [[0, half], [half, 3 * half], [3 * half, 4 * half]]
    np.testing.assert_allclose(
        [[line[0] - PLOT.names, line[2] - PLOT.names] for line in intervals], wanted, atol=0.051
    )
    bars = [line for line in lines if line[0] > right + 1.0]
    assert len(bars) == len(cliques)
    for i, (bar, (first, last)) in enumerate(zip(bars, cliques, strict=True)):
        place = right + 12.0 + 7.0 * i
        ends = [place, 4.0 + PLOT.row * (first + 0.2), place, 4.0 + PLOT.row * (last + 0.8)]
        np.testing.assert_allclose(bar, ends, atol=0.051)
    height = PLOT.row * 3 + 34.0
    assert f'viewBox="0 0 {PLOT.width:g} {height:g}"' in str(svg)
    bold = re.findall(r'<text [^>]*font-weight="600"[^>]*>([^<]*)<', str(svg))
    assert bold == ["a"]


def test_a_long_name_is_not_cut_off():
    """The picture grows by it; the room for the ranks stays."""
    long = Ranked("optimagic-scipy-truncated-newton", 1.0, 1.0, 1.5)
    svg = critical_differences([long, *ROWS[1:]], [], "ranks")
    width = float(re.search(r'viewBox="0 0 ([\d.]+) ', str(svg))[1])
    (end,) = {float(x) for x in re.findall(r'<text x="([\d.]+)" [^>]*text-anchor="end"', str(svg))}
    assert end - 7.0 * len(long.label) >= 0.0
    circles = numbers(svg, "circle", "cx")
    room = PLOT.width - PLOT.names - 8.0 - 12.0
    assert circles[-1][0] - circles[0][0] == pytest.approx(room, abs=0.11)
    assert circles[-1][0] == pytest.approx(width - 20.0, abs=0.06)


def test_lines_that_look_alike_are_grey_and_have_one_entry():
    pens = [Pen(i) for i in range(24)]
    looks = {tuple(pen.look.items()) for pen in pens}
    assert len(looks) == 22
    assert {pen.colour for pen in pens[21:]} == {plot.GREY}
    told = str(key([f"n{i}" for i in range(24)], pens))
    assert told.count('class="key"') == 22
    assert "each of n21, n22, n23" in told
    assert "each of" not in str(key(["n0", "n1"], pens[:2]))


@pytest.mark.parametrize(("count", "told"), [(4, 4), (6, 6), (30, 6)])
def test_at_most_six_ranks_stand_at_the_axis(count, told):
    rows = [Ranked(str(i), float(i), float(i), float(i)) for i in range(1, count + 1)]
    lines = numbers(critical_differences(rows, [], "ranks"), "line", "x1", "y1", "x2", "y2")
    assert sum(line[1] != line[3] for line in lines) == told
