"""Figures: what is drawn is what was measured and fitted, and nothing covers anything else."""

from itertools import product

import numpy as np
import pytest

import springpot
from springpot.errors import OutputError
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model
from springpot.report import canvas, figures, views
from springpot.report.figures import beside_floors
from springpot.report.views import DrawnFit, Scene, axis_of, sweeps_of

pytest.importorskip("matplotlib")

OMEGA = 2 * np.pi * np.geomspace(0.1, 100.0, 12)
MAXWELL = DrawnFit(parse_model("fractional-maxwell"), np.array([900.0, 60.0, 0.5]))
KELVIN = DrawnFit(parse_model("fractional-kelvin"), np.array([90.0, 30.0, 0.6]), "the other one")


def _sweep(fit=MAXWELL, **given):
    return Measurement(
        OMEGA, fit.model.stiffness(fit.theta, OMEGA), units=Units("kN/m", "mm"), **given
    )


def _temperatures(count=3):
    data = _sweep()
    levels = np.repeat(np.linspace(0.0, 40.0, count), len(OMEGA))
    return Measurement(
        np.tile(OMEGA, count), np.tile(data.stiffness, count), conditions={"temperature": levels}
    )


@pytest.mark.soak
@pytest.mark.parametrize("suffix", canvas.SUFFIXES)
def test_a_figure_is_written_and_repeatable(tmp_path, suffix):
    draw, data = figures.figure_identification, _sweep(sd=np.full(12, 1.0 + 1.0j))
    path = draw(data, [MAXWELL, KELVIN], tmp_path / f"a{suffix}")
    first = path.read_bytes()
    assert len(first) > 5000
    assert draw(data, [MAXWELL, KELVIN], path).read_bytes() == first


def test_curves_pass_through_the_points_of_a_perfect_fit():
    scene = Scene(_sweep(), [MAXWELL])
    [[(x, stiffness)]] = scene.curves
    at_points = np.interp(np.log(scene.axis.values), np.log(x), np.log(np.abs(stiffness)))
    np.testing.assert_allclose(at_points, np.log(np.abs(scene.measurement.stiffness)), atol=1e-4)


def test_the_residual_is_measured_minus_fitted_in_per_cent():
    data = _sweep()
    shifted = Measurement(data.omega, data.stiffness * 1.02, units=data.units)
    with canvas.blank() as figure:
        axes = figure.subplots()
        views.residual(axes, Scene(shifted, [MAXWELL]))
        drawn = np.hypot(axes.lines[0].get_ydata(), axes.lines[1].get_ydata())
    np.testing.assert_allclose(drawn, 100 * 0.02 / 1.02, rtol=1e-9)


def test_negative_storage_is_drawn_with_crosses_not_dropped():
    heavy = DrawnFit(
        parse_model("fractional-maxwell + inertia"), np.array([900.0, 60.0, 0.5, 0.05])
    )
    data = _sweep(heavy)
    assert (data.storage < 0).any()
    with canvas.blank() as figure:
        axes = figure.subplots()
        views.storage_and_loss(axes, Scene(data, [heavy]))
        crosses = [line for line in axes.lines if line.get_marker() == "x"]
        shown = sum(int(np.isfinite(line.get_ydata()).sum()) for line in crosses)
    assert shown == (data.storage < 0).sum()


@pytest.mark.parametrize(
    ("given", "column", "count"),
    [
        ({}, "frequency", 1),
        ({"temperature": np.linspace(20.0, 20.3, 12)}, "frequency", 1),
        ({"temperature": np.repeat([0.0, 20.0, 40.0], 4)}, "frequency", 3),
        ({"amplitude": np.geomspace(0.1, 1.0, 12)}, "frequency", 1),
    ],
)
def test_sweeps(given, column, count):
    data = _sweep(conditions=given)
    axis = axis_of(data)
    found = sweeps_of(data, axis)
    assert (axis.column, len(found)) == (column, count)
    assert sorted(np.concatenate([sweep.rows for sweep in found])) == list(range(12))


@pytest.mark.parametrize("name", ["amplitude", "temperature"])
def test_at_one_frequency_the_condition_is_the_axis(name):
    data = Measurement(
        np.full(8, 6.28), np.full(8, 1 + 1j), conditions={name: np.linspace(1.0, 60.0, 8)}
    )
    assert axis_of(data).column == name
    assert len(sweeps_of(data, axis_of(data))) == 1


@pytest.mark.soak
def test_a_single_point_can_be_drawn(tmp_path):
    data = _sweep().subset(np.array([3]))
    assert figures.figure_identification(data, [MAXWELL], tmp_path / "a.png").stat().st_size > 1000


def _boxes(figure):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure).draw()
    return [part.get_tightbbox() for part in (*figure.axes, *figure.legends)], figure.bbox


FITS = {"none": [], "one": [MAXWELL], "two": [MAXWELL, KELVIN]}
SWEEPS = {"one": 1, "three": 3, "twelve": 12}
FULLEST = [("one", "twelve"), ("two", "one")]
"""A legend of each kind; all other pairs are in the soak."""


@pytest.mark.soak_cases("one-twelve")
@pytest.mark.parametrize(
    ("fits", "sweeps"),
    [
        case if case in FULLEST else pytest.param(*case, marks=pytest.mark.soak)
        for case in product(FITS, SWEEPS)
    ],
)
def test_nothing_overlaps_and_nothing_is_cut_off(monkeypatch, fits, sweeps):
    data, fits, kept = (
        _temperatures(SWEEPS[sweeps]) if SWEEPS[sweeps] > 1 else _sweep(),
        FITS[fits],
        [],
    )
    monkeypatch.setattr(figures, "finished", lambda figure, path: kept.append(_boxes(figure)))
    figures.figure_identification(data, fits, "unused.png")
    [(boxes, page)] = kept
    for i, box in enumerate(boxes):
        assert box.x0 >= page.x0 - 1, i
        assert box.x1 <= page.x1 + 1, i
        assert box.y0 >= page.y0 - 1, i
        assert box.y1 <= page.y1 + 1, i
        for other in boxes[:i]:
            across = min(box.x1, other.x1) - max(box.x0, other.x0)
            up = min(box.y1, other.y1) - max(box.y0, other.y0)
            assert across <= 1 or up <= 1


@pytest.mark.soak
def test_dollars_in_a_name_are_no_formula(tmp_path):
    data = _sweep(name="$\\frac$ 5$ <b>")
    assert figures.figure_identification(data, [MAXWELL], tmp_path / "a.svg").exists()


def test_what_cannot_be_written_is_told_before_work(tmp_path, monkeypatch):
    with pytest.raises(OutputError, match=r"must end in \.png"):
        canvas.check_figure_path(tmp_path / "a.bmp")
    with pytest.raises(OutputError, match="no folder"):
        canvas.check_figure_path(tmp_path / "no" / "a.png")
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(OutputError, match=r"pip install 'springpot\[figures\]'"):
        canvas.check_figure_path(tmp_path / "a.png")


@pytest.mark.soak
def test_many_points_stay_small(tmp_path):
    omega = np.geomspace(0.1, 1e4, 50_000)
    data = Measurement(omega, MAXWELL.model.stiffness(MAXWELL.theta, omega))
    path = figures.figure_identification(data, [MAXWELL], tmp_path / "a.svg")
    assert path.stat().st_size < 1_000_000
    assert len(data) > views.ENOUGH
    assert views.CANVAS.smooth < views.ENOUGH


@pytest.mark.soak
def test_the_picture_of_a_material_shows_its_spectrum_with_a_band(tmp_path):
    from springpot import identify
    from springpot.report.figures import draw_spectrum, figure_material, in_words

    found = identify(_sweep(), "material")
    with canvas.blank() as figure:
        axes = figure.subplots()
        draw_spectrum(axes, found.spectrum, "kN/m")
    [line] = [line for line in axes.lines if line.get_label().startswith("smoothest")]
    np.testing.assert_array_equal(line.get_ydata(), found.spectrum.density)
    assert "95 % of noise" in [text.get_text() for text in axes.get_legend().get_texts()]
    assert axes.get_ylabel() == "H(r) [kN/m]"
    assert figure_material(found, tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert "rad/s" in in_words(found.spectrum, "kN/m")


def test_residuals_stand_beside_the_material_floor(tmp_path):
    from springpot import compare
    from springpot.report import residuals

    rng = np.random.default_rng(2)
    data = _sweep(
        DrawnFit(parse_model("fractional-maxwell + inertia"), np.array([900.0, 60.0, 0.5, 2e-3]))
    )
    data = Measurement(
        data.omega, data.stiffness * (1 + 0.01 * rng.normal(size=12)), units=data.units
    )
    comparison = compare(data, ["fractional-maxwell"])
    [judged] = comparison.judgements
    with canvas.blank(19.0, 4.0) as figure:
        row = figure.subplots(1, 5)
        residuals._row_of_residuals(
            row, Scene(comparison.measurement, residuals.fits_of(comparison)), judged.error, True
        )
        levels = sorted(
            line.get_ydata()[0] for line in row[0].lines if line.get_linestyle() == "--"
        )
    level = 100.0 * judged.error.material_floor
    assert level > 1.0
    np.testing.assert_allclose(levels, [-level, level])
    assert "material floor" in row[0].get_title(loc="left")


@pytest.mark.soak_cases("maxwell")
@pytest.mark.parametrize("model", ["maxwell", "material"])
def test_the_error_of_a_fit_stands_beside_both_floors(model, monkeypatch):
    """In the picture as in the text."""
    kept = []
    for module in (figures,):
        monkeypatch.setattr(
            module,
            "finished",
            lambda figure, path: kept.append(figure.legends[0].get_title().get_text()),
        )
    found = springpot.identify("artificial-hidden", model)
    found.plot("unused.png")
    assert beside_floors(found).removeprefix(", ") in kept[0].splitlines()
    assert "material floor" in kept[0]


def test_nothing_is_not_negative():
    """What is negative is drawn by its size, and the legend says so; a storage of 0 is none."""
    for storage, said in ((0.0, False), (-1.0, True)):
        for k in (storage + 1j, 1.0 + 1j * storage):
            scene = Scene(Measurement(OMEGA, np.full(12, k)), [])
            labels = [mark.get_label() for mark in figures.marks_of(scene)]
            assert ("negative: its size" in labels) is said


@pytest.mark.parametrize("low", [0.1, 1.0])
@pytest.mark.parametrize(("high", "ticks"), [(200.0, [1, 2, 5, 10, 20, 50, 100, 200]), (400.0, [])])
def test_an_axis_of_few_decades_has_numbers_between_them(low, high, ticks):
    with canvas.blank() as figure:
        axes = figure.subplots()
        axes.set_xlim(low, low * high)
        canvas.logarithmic(axes, "x")
        places = axes.get_xticks() / low
    within = places[(places >= 0.999) & (places <= 1.001 * high)]
    np.testing.assert_allclose(within, ticks or [1, 10, 100])
