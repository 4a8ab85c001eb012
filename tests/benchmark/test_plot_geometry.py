"""Where a report's plots put things: by hand."""

import re

import numpy as np
import pytest

from springpot.benchmark.report import plot
from springpot.benchmark.report.plot import (
    NAMES,
    ROW,
    WIDTH,
    PlotAxis,
    Ranked,
    _steps,
    _tick,
    critical_differences,
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
    most = plot.MOST_TICKS
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
    right = WIDTH - 7.0 * len(cliques) - 8.0 - 12.0
    places = np.linspace(NAMES, right, 3)
    circles = [[x, 4.0 + ROW * (i + 0.5)] for i, x in enumerate(places)]
    np.testing.assert_allclose(numbers(svg, "circle", "cx", "cy"), circles, atol=0.051)
    lines = numbers(svg, "line", "x1", "y1", "x2", "y2")
    intervals = [line for line in lines if line[1] == line[3]]
    # A rank is as wide as half of the room.
    half = 0.25 * (right - NAMES)
    wanted = [[0, half], [half, 3 * half], [3 * half, 4 * half]]
    np.testing.assert_allclose(
        [[line[0] - NAMES, line[2] - NAMES] for line in intervals], wanted, atol=0.051
    )
    bars = [line for line in lines if line[0] > right + 1.0]
    assert len(bars) == len(cliques)
    for i, (bar, (first, last)) in enumerate(zip(bars, cliques, strict=True)):
        place = right + 12.0 + 7.0 * i
        ends = [place, 4.0 + ROW * (first + 0.2), place, 4.0 + ROW * (last + 0.8)]
        np.testing.assert_allclose(bar, ends, atol=0.051)
    height = ROW * 3 + 34.0
    assert f'viewBox="0 0 {WIDTH:g} {height:g}"' in str(svg)
    bold = re.findall(r'<text [^>]*font-weight="600"[^>]*>([^<]*)<', str(svg))
    assert bold == ["a"]


@pytest.mark.parametrize(("count", "told"), [(4, 4), (6, 6), (30, 6)])
def test_at_most_six_ranks_stand_at_the_axis(count, told):
    rows = [Ranked(str(i), float(i), float(i), float(i)) for i in range(1, count + 1)]
    lines = numbers(critical_differences(rows, [], "ranks"), "line", "x1", "y1", "x2", "y2")
    assert sum(line[1] != line[3] for line in lines) == told
