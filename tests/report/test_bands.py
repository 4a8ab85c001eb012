"""Noise in the planes of residuals: each sweep is held against its own."""

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model
from springpot.report import canvas, residuals, views
from springpot.report.residuals import draw_plane
from springpot.report.views import SHARED, DrawnFit, Scene, alike
from springpot.rheology.nodes import PLANES

pytest.importorskip("matplotlib")

HERTZ = np.geomspace(0.1, 30.0, 14)
CELSIUS = (0.0, 20.0, 40.0)
STIFFNESS, COMPLIANCE, LOG, _ = PLANES
WARM = DrawnFit(
    parse_model("fractional-zener + arrhenius-shift"), np.array([20.0, 400.0, 60.0, 0.5, 120.0])
)


def _scene(share=0.01, fits=(WARM,)):
    """Three temperatures whose noise is the same share of |K| throughout, or one share for each."""
    temperature = np.repeat(CELSIUS, len(HERTZ))
    omega = 2.0 * np.pi * np.tile(HERTZ, len(CELSIUS))
    blank = Measurement(
        omega, np.ones(len(omega), complex), conditions={"temperature": temperature}
    )
    exact = WARM.at(blank.points)
    sd = np.repeat(np.broadcast_to(share, 3), len(HERTZ)) * np.abs(exact) * (1.0 + 1.0j)
    given = {"sd": sd, "conditions": {"temperature": temperature}, "units": Units("kN/m", "mm")}
    return Scene(Measurement(omega, exact, **given), list(fits))


def _drawn(draw, scene):
    """Colour and largest half-width of each band."""
    from matplotlib.colors import to_hex

    with canvas.blank() as figure:
        axes = figure.subplots()
        draw(axes, scene)
        return {
            to_hex(band.get_facecolor()[0]).upper(): np.max(band.get_paths()[0].vertices[:, 1])
            for band in axes.collections
        }


@pytest.mark.parametrize("plane", [STIFFNESS, COMPLIANCE], ids=lambda plane: plane.plane)
def test_each_sweep_has_its_own_band_where_they_differ(plane):
    scene = _scene()
    found = _drawn(lambda axes, shown: draw_plane(axes, shown, plane), scene)
    size = scene.measurement.magnitude ** (1.0 if plane is STIFFNESS else -1.0)
    wanted = {
        scene.data_colour(i).upper(): 0.02 * float(np.max(size[sweep.rows]))
        for i, sweep in enumerate(scene.sweeps)
    }
    assert len(wanted) == 3
    assert found.keys() == wanted.keys()
    for colour, half in wanted.items():
        assert found[colour] == pytest.approx(half)


def test_one_band_where_all_sweeps_have_the_same():
    for draw in (lambda axes, scene: draw_plane(axes, scene, LOG), views.residual):
        assert list(_drawn(draw, _scene())) == [SHARED]


def test_the_per_cent_view_tells_quiet_sweeps_from_noisy_ones():
    found = _drawn(views.residual, _scene((0.01, 0.03, 0.09)))
    assert sorted(found.values()) == pytest.approx([2.0, 6.0, 18.0])


def test_without_noise_there_is_no_band():
    data = _scene().measurement
    bare = Scene(Measurement(data.omega, data.stiffness, conditions=data.conditions), [WARM])
    assert _drawn(views.residual, bare) == {}
    assert _drawn(lambda axes, scene: draw_plane(axes, scene, STIFFNESS), bare) == {}


def test_bands_are_compared_only_where_they_overlap():
    x = np.array([1.0, 2.0, 3.0])
    assert alike([(x, np.ones(3)), (x + 1.0, 1.4 * np.ones(3))])
    assert not alike([(x, np.ones(3)), (x + 1.0, 1.6 * np.ones(3))])
    assert alike([(x, np.ones(3)), (x + 9.0, 99.0 * np.ones(3))])
    assert alike([(x, np.ones(3))])


@pytest.mark.soak
@pytest.mark.parametrize("count", [1, 2])
def test_residuals_coloured_by_temperature_come_with_a_key(monkeypatch, count):
    kept = []

    def keep(figure, path):
        kept.append([text.get_text() for legend in figure.legends for text in legend.get_texts()])

    monkeypatch.setattr(residuals, "finished", keep)
    data = _scene().measurement
    scatter = np.random.default_rng(3).normal(size=(2, len(data)))
    noisy = Measurement(
        data.omega,
        data.stiffness * (1 + 0.01 * (scatter[0] + 1j * scatter[1])),
        units=data.units,
        conditions=data.conditions,
    )
    models = ["fractional-zener", "fractional-zener + arrhenius-shift"][-count:]
    residuals.figure_compared(springpot.compare(noisy, models), "unused.png")
    assert {"0 °C", "20 °C", "40 °C"} <= set(kept[0])
