"""A discovery as a moving picture."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, TimeTest
from springpot.registry import parse_model
from springpot.report import result_plots
from springpot.report.canvas import blank
from springpot.report.views import Scene

images = pytest.importorskip("PIL.Image")
pytest.importorskip("matplotlib")

MODEL = parse_model("kelvin + inertia")


@pytest.fixture(scope="module")
def ladder():
    omega = 2.0 * np.pi * np.geomspace(0.5, 30.0, 12)
    exact = MODEL.stiffness(MODEL.theta(**{"k": 300.0, "c": 5.0, "inertia.m": 0.01}), omega)
    noise = np.random.default_rng(3).normal(size=(2, 12)) * 0.005
    data = Measurement(omega, exact * (1.0 + noise[0] + 1j * noise[1]), name="pad")
    return springpot.discover(data, "kelvin", accept=["inertia"])


@pytest.mark.soak
def test_each_step_stands_still_and_the_way_between_is_short(ladder, tmp_path, monkeypatch):
    """Two steps and the frames between them, played for ever."""
    monkeypatch.setattr(result_plots, "REPLAY", result_plots.REPLAY._replace(frames=2))
    played = images.open(ladder.plot(tmp_path / "replay.gif"))
    assert played.n_frames == result_plots.REPLAY.frames + 1
    lasting = []
    for frame in range(played.n_frames):
        played.seek(frame)
        lasting.append(played.info["duration"])
    assert (lasting[0], lasting[-1]) == (result_plots.REPLAY.hold, result_plots.REPLAY.hold)
    assert set(lasting[1:-1]) == {result_plots.REPLAY.between}
    assert played.info["loop"] == 0


@pytest.mark.soak
def test_a_passage_goes_from_one_curve_to_the_next(ladder):
    """Where it begins it is the fit before, where it ends the fit itself."""
    [stage] = result_plots.Replay(ladder).played
    before, after = stage.fits
    points = stage.data.points
    for share, expected in ((0.0, before), (1.0, after)):
        way = result_plots.OnTheWay(after.model, after.theta, "", before, share)
        np.testing.assert_allclose(way.at(points), expected.at(points), rtol=1e-12)
    half = result_plots.OnTheWay(after.model, after.theta, "", before, 0.5)
    middle = 0.5 * (before.at(points) + after.at(points))
    np.testing.assert_allclose(half.at(points), middle, rtol=1e-12)


@pytest.mark.soak
def test_a_test_in_time_is_played_as_a_sweep_is(tmp_path, monkeypatch):
    """Over its own axes; half way the curve lies between both fits, and so does what is left."""
    monkeypatch.setattr(result_plots, "REPLAY", result_plots.REPLAY._replace(frames=2))
    time = np.geomspace(0.05, 5.0, 16)
    noise = 1.0 + 0.01 * np.random.default_rng(5).normal(size=16)
    test = TimeTest.of_relaxation(time, (2.0 * np.exp(-time) + 1.0) * noise, name="relaxation")
    found = springpot.discover(test, "maxwell", accept=["parallel-spring"])
    assert (
        images.open(found.plot(tmp_path / "replay.gif")).n_frames == result_plots.REPLAY.frames + 1
    )
    [stage] = result_plots.Replay(found).played
    with blank() as figure:
        curve, left = figure.subplots(1, 2)
        stage.curve(curve, 1, 0.5)
        stage.residual(left, 1, 0.5)
    assert curve.get_xlabel() == "t [s]"
    _, drawn = curve.get_lines()
    np.testing.assert_allclose(drawn.get_ydata(), np.mean(stage.curves, axis=0)[0])
    [points] = left.get_lines()
    np.testing.assert_allclose(points.get_ydata(), np.mean(stage.left, axis=0)[0])
    assert np.max(np.abs(stage.left[0])) > 10.0 > np.max(np.abs(stage.left[1]))


@pytest.mark.soak
def test_several_tests_are_played_beside_one_another():
    """Each of them, in their order; further ones below."""
    rng, time = np.random.default_rng(5), np.geomspace(0.05, 5.0, 16)
    tests = [
        TimeTest.of_relaxation(time, (2.0 * np.exp(-time) + rise) * noise, name=f"at-{rise}")
        for rise, noise in zip((1.0, 3.0), 1.0 + 0.01 * rng.normal(size=(2, 16)), strict=True)
    ]
    found = springpot.discover(tests, "maxwell", accept=["parallel-spring"], only=["friction"])
    stage = result_plots.Replay(found)
    assert [one.name for one in stage.played] == ["at-1.0", "at-3.0"]
    assert stage.at(1, 0.5).size == (14 * 100, 5 * 100)
    assert result_plots._mosaic(4, 2) == [
        ["curve 0", "curve 1", "ladder"],
        ["residual 0", "residual 1", "ladder"],
        ["curve 2", "curve 3", "ladder"],
        ["residual 2", "residual 3", "ladder"],
    ]


def test_each_way_begins_after_one_fit_and_ends_on_the_next():
    """Never beyond it, slowly at both ends."""
    moments = list(result_plots._moments(3))
    assert moments[0] == (0, 1.0, result_plots.REPLAY.hold)
    for step in (1, 2):
        shares = [share for at, share, _ in moments if at == step]
        assert shares[-1] == 1.0
        assert all(0.0 < one < after <= 1.0 for one, after in itertools.pairwise(shares))
        assert shares[0] + shares[-2] == pytest.approx(1.0)
        assert shares[0] < 1.0 / result_plots.REPLAY.frames


def test_what_is_nothing_has_no_place_among_decades():
    omega = np.array([1.0, 2.0, 4.0])
    data = springpot.Measurement(omega, np.array([3.0, 2.0 + 0.5j, 9.0 + 1.0j]))
    with blank() as figure:
        axes = figure.subplots()
        stage = SimpleNamespace(data=data, _scene=lambda step, share: Scene(data, []))
        result_plots.PlayedSweeps.curve(stage, axes, 0, 1.0)
    assert axes.get_ylim() == pytest.approx(
        (0.5 / result_plots.LADDER.room, 9.0 * result_plots.LADDER.room)
    )
