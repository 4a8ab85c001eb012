"""What is asked of a prediction, and what is told of a parameter at its bound."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.distributions import student
from springpot.errors import DataError
from springpot.identification import fitting, prediction
from springpot.identification.uncertainty import RANK, Uncertainty
from springpot.measurement import Units
from springpot.rheology.parameters import Dimension, Parameter

SWEEP = SimpleNamespace(omega=np.array([1.0, 2.0]))


@pytest.mark.parametrize(
    ("given", "omega"),
    [
        ({"frequency": [1.0, 0.0]}, [2.0 * np.pi, 0.0]),
        ({"omega": [1.0, 0.0]}, [1.0, 0.0]),
        ({"omega": 3.0}, [3.0]),
        ({}, [1.0, 2.0]),
    ],
)
def test_frequencies_are_asked_for_in_hertz_or_radians(given, omega):
    given = {"frequency": None, "omega": None} | given
    np.testing.assert_array_equal(prediction._rate(SWEEP, **given), omega)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"frequency": [1.0], "omega": [1.0]}, "not both"),
        ({"frequency": "fast"}, "are numbers"),
        ({"frequency": [[1.0]]}, "finite and not negative"),
        ({"omega": [-1.0]}, "finite and not negative"),
        ({"omega": [np.inf]}, "finite and not negative"),
        ({"sweep": None}, "tests in time have none"),
    ],
)
def test_what_are_no_frequencies_is_refused(given, says):
    given = {"sweep": SWEEP, "frequency": None, "omega": None} | given
    with pytest.raises(DataError, match=says):
        prediction._rate(**given)


@pytest.mark.parametrize(
    ("lower", "upper", "side", "says"),
    [
        (0.0, np.inf, 0, None),
        (0.0, np.inf, -1, "k is zero as far as these data show: a model without it fits as well"),
        (0.0, np.inf, 1, "k has grown without limit: its element is rigid as far as these data"),
        (2.0, 5.0, -1, "k rests on its bound 2 kN/m: the data ask for more than the model allows"),
        (2.0, 5.0, 1, "k rests on its bound 5 kN/m: the data ask for more than the model allows"),
        (0.0, 5.0, 1, "k rests on its bound 5 kN/m"),
        (-1.0, np.inf, -1, "k rests on its bound -1 kN/m"),
    ],
)
def test_a_parameter_at_its_bound_is_told(lower, upper, side, says):
    parameter = Parameter("k", "k", Dimension(1), lower, upper)
    fit = SimpleNamespace(
        model=SimpleNamespace(parameters=(parameter,)),
        measurement=SimpleNamespace(units=Units("kN/m", "mm")),
    )
    found = list(fitting._bounds(SimpleNamespace(fit=fit, at_bound=np.array([side]))))
    assert len(found) == (says is not None)
    if says:
        assert found[0].startswith(says)


@pytest.mark.parametrize(
    ("theta", "at", "lower", "upper", "interval"),
    [
        (2.0, -1, 2.0, 99.0, (2.0, 2.0 + 1.0)),
        (2.0, -1, 2.0, 2.5, (2.0, 2.5)),
        (9.0, 1, 2.0, 9.0, (8.0, 9.0)),
        (9.0, 1, 8.5, 9.0, (8.5, 9.0)),
        (3.0, 1, 0.0, np.inf, (3.0 / (1.0 + 1.0 / 3.0), np.inf)),
        (3.0, 1, 2.9, np.inf, (2.9, np.inf)),
    ],
)
def test_on_a_bound_the_whole_tail_lies_on_one_side(monkeypatch, theta, at, lower, upper, interval):
    """A slope of 5, of which others make up for 3: so far as four tell it, that is one here."""
    side = student(2.0 * 0.95 - 1.0, 7)
    fit = SimpleNamespace(
        theta=np.array([theta, 1.0]),
        jacobian_u=np.array([[0.0, 2.0], [0.0, 0.0]]),
        model=SimpleNamespace(box=(np.array([lower]), np.array([upper]))),
    )
    own = SimpleNamespace(
        fit=fit,
        at_bound=np.array([at, 0]),
        _free=np.array([1]),
        level=0.95,
        freedom=7,
        scale=4.0 / side,
        eliminated=None,
        memory=0.0,
    )
    own._reach = lambda i: Uncertainty._reach(own, i)
    module = "springpot.identification.uncertainty"
    monkeypatch.setattr(f"{module}._linear_slope", lambda fit, i: np.array([3.0, 4.0]))
    assert Uncertainty._one_sided(own, 0) == pytest.approx(interval)
    # What others make up for but for rounding tells nothing.
    monkeypatch.setattr(f"{module}._linear_slope", lambda fit, i: np.array([3.0, 2.0 * RANK]))
    low, high = Uncertainty._one_sided(own, 0)
    assert (low, high) == (lower, upper)


def test_what_rests_on_a_bound_may_be_elsewhere_in_bands_too():
    """A mass of 0.02 kg is lost in the noise below 20 Hz, and is 3 kN/m at 60 Hz."""
    model, hertz = springpot.parse_model("zener + inertia"), np.geomspace(0.5, 20.0, 12)
    theta = np.array([50e3, 300e3, 10e3, 0.02])
    rng = np.random.default_rng(7)
    scatter = 1.0 + 0.005 * (rng.normal(size=12) + 1j * rng.normal(size=12))
    k = scatter * model.stiffness(theta, 2.0 * np.pi * hertz)
    fit = springpot.identify(springpot.Measurement(2.0 * np.pi * hertz, k), model)
    assert fit["inertia.m"].low == 0.0
    there = fit.predict(frequency=[60.0])
    truth = model.stiffness(theta, np.array([120.0 * np.pi])).real
    assert there.low.real < truth < there.high.real
    # One way alone: a mass is never negative.
    assert there.storage - there.low.real > 5.0 * (there.high.real - there.storage)


def test_a_quantity_reaches_to_the_end_of_what_rests_on_a_bound():
    fit = springpot.identify("artificial-hidden", "kelvin", bounds={"k": (10.0, 50.0)})
    (at_rest,) = (row for row in fit.quantities.rows if row.name == "crossover stiffness")
    for known in (fit["k"], at_rest.value):
        assert known.low < 40.0
        assert known.high == pytest.approx(50.0)
