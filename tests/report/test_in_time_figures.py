"""Pictures of tests in time.

Every axis names its own quantity, and frequencies are those of the data.
"""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from springpot.errors import OutputError
from springpot.measurement import Measurement, TimeTest
from springpot.registry import parse_model
from springpot.timetests import identify, predict_test


def test_every_axis_names_what_it_shows():
    pytest.importorskip("matplotlib")
    from springpot.report.residuals import figure_tests

    model, t, omega = (
        parse_model("maxwell"),
        np.geomspace(0.1, 10.0, 20),
        np.geomspace(0.1, 10.0, 8),
    )
    theta = model.theta(k=2.0, c=3.0)
    sweep = Measurement(omega=omega, stiffness=model.stiffness(theta, omega))
    sweep = replace(
        sweep, units=replace(sweep.units, stiffness="kPa", amplitude="-", clock="rad/s")
    )
    tests = [
        TimeTest.of_relaxation(t, model.relaxation(theta, t), "kPa"),
        TimeTest.of_compliance(t, model.creep(theta, t), "kPa"),
        sweep,
    ]
    axes = figure_tests(identify(tests, model), tests).axes
    labels = [one.get_ylabel() for one in axes]
    # A sweep as one that stands alone.
    swept = "storage, loss modulus [kPa]", "loss factor tan δ [-]"
    assert labels[0::3] == ["stress [kPa]", "strain [-]", swept[0]]
    assert labels[7] == swept[1]
    assert [one.get_xlabel() for one in axes[6:]] == ["angular frequency ω [rad/s]"] * 3


def test_a_sweep_among_tests_in_time_has_the_views_of_one_alone():
    pytest.importorskip("matplotlib")
    model, t, omega = parse_model("maxwell"), np.geomspace(0.1, 10.0, 20), np.geomspace(0.1, 10, 8)
    theta = model.theta(k=2.0, c=3.0)
    sweep = Measurement(omega, model.stiffness(theta, omega))
    crept = TimeTest.of_compliance(t, model.creep(theta, t), "Pa")
    figure = identify([crept, sweep], model).plot(view="loss-factor")
    (axes,) = figure.axes
    (curve,) = (line for line in axes.lines if len(line.get_xdata()) > len(omega))
    k = model.stiffness(theta, curve.get_xdata() * 2.0 * np.pi)
    np.testing.assert_allclose(curve.get_ydata(), k.imag / k.real, rtol=1e-3)
    with pytest.raises(OutputError, match="of one sweep, and among these tests are 0"):
        identify(crept, model).plot(view="loss-factor")


@pytest.mark.parametrize(("decades", "scale"), [(2.0, "log"), (0.5, "linear")])
def test_a_response_of_more_than_a_decade_has_a_logarithmic_axis(decades: float, scale: str):
    pytest.importorskip("matplotlib")
    from springpot.report.residuals import figure_tests

    t = np.geomspace(0.1, 10.0, 20)
    test = TimeTest.of_relaxation(t, 10.0 ** -np.linspace(0.0, decades, 20), "kPa")
    by_log_time, by_time, residual = figure_tests(
        identify(test, parse_model("maxwell")), [test]
    ).axes
    assert [by_log_time.get_xscale(), by_log_time.get_yscale()] == ["log", scale]
    assert [by_time.get_xscale(), by_time.get_yscale()] == ["linear", "linear"]
    assert residual.get_yscale() == "linear"


@pytest.mark.parametrize(("material", "named"), [([0.3, 0.2], True), ([np.nan, np.nan], False)])
def test_a_legend_names_no_floor_that_is_not_drawn(material: list[float], named: bool):
    pytest.importorskip("matplotlib")
    from springpot.report.canvas import blank
    from springpot.report.figures import draw_floors

    with blank() as figure:
        axes = figure.subplots()
        draw_floors(axes, np.array([0.1, 0.1]), np.array(material))
        labels = axes.get_legend_handles_labels()[1]
    assert ("material floor" in labels) is named


def test_a_predicted_record_is_drawn_once_and_any_other_test_along_both_times():
    pytest.importorskip("matplotlib")
    from springpot.report.residuals import figure_prediction

    model, t = parse_model("zener"), np.geomspace(0.1, 10.0, 20)
    theta, swung = model.theta(k1=1.0, k2=2.0, c=3.0), np.linspace(0.0, 6.0, 60)
    step = TimeTest.of_relaxation(t, model.relaxation(theta, t), "kPa")
    fit = identify(step, model)
    force = model.respond(theta, swung, np.sin(3.0 * swung))
    record = TimeTest.of_history(swung, np.sin(3.0 * swung), force, "-", "kPa")
    (once,) = figure_prediction(predict_test(fit, record)).axes
    assert once.get_xscale() == "linear"
    both = figure_prediction(predict_test(fit, step)).axes
    assert [one.get_xscale() for one in both] == ["log", "linear"]
    assert repr(predict_test(fit, step)).startswith("<TestPrediction zener: the prediction of")


@pytest.mark.soak
def test_a_report_has_the_planes_of_a_sweep_among_tests_in_time():
    pytest.importorskip("matplotlib")
    from springpot.report.html import _drawn_tests

    model, t, omega = parse_model("maxwell"), np.geomspace(0.1, 10.0, 20), np.geomspace(0.1, 10, 8)
    theta = model.theta(k=2.0, c=3.0)
    sweep = Measurement(omega, model.stiffness(theta, omega), name="swept")
    tests = [TimeTest.of_compliance(t, model.creep(theta, t), "Pa"), sweep]
    rung = Mock(examined=Mock(base=identify(tests, model)))
    page = "".join(_drawn_tests(Mock(steps=(rung,)), tests))
    assert page.count("<h2>Residual planes of swept</h2>") == 1
    for plane in ("stiffness", "compliance", "log-complex", "shift"):
        assert f"Residual, {plane} · the model" in page
