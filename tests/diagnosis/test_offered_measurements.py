"""What could be measured next: its points, its effort, and how a promise is put in words."""

import numpy as np
import pytest

from springpot.diagnosis import experiment, experiment as e
from springpot.measurement import Measurement, Units
from springpot.thresholds import EXPERIMENT

OMEGA = np.array([2.0, 4.0, 8.0, 16.0])


def offered(omega=OMEGA, units=None, **conditions):
    given = {} if units is None else {"units": units}
    data = Measurement(omega, 3.0 + 4.0j + 0.0 * omega, conditions=conditions, **given)
    return {action.says: action for action in e.actions(data)}


def one(found, words):
    (action,) = (action for says, action in found.items() if words in says)
    return action


def test_the_same_again_four_times():
    action = one(offered(), "repeat the same measurement four times")
    assert (action.repeats, action.effort, action.scale) == (4, e.WORKED_FOR, 1.0)
    assert action.action == {"repeats": [4.0]}
    np.testing.assert_allclose(np.exp(action.points.log_omega), OMEGA)


@pytest.mark.parametrize(("words", "factor"), [("upwards", 10.0), ("downwards", 0.1)])
def test_a_decade_further(words, factor):
    action = one(offered(), words)
    wanted = factor * np.geomspace(2.0, 16.0, e.ACTION.points)
    np.testing.assert_allclose(action.action["omega"], wanted)
    np.testing.assert_allclose(np.exp(action.points.log_omega), wanted)
    assert action.effort == e.WAITED_FOR


def test_four_times_as_dense_up_to_a_limit():
    action = one(offered(), "more densely: 16 points")
    np.testing.assert_allclose(action.action["omega"], np.geomspace(2.0, 16.0, 16))
    assert action.effort == pytest.approx(1.0 + 16 / 80)
    many = np.geomspace(1.0, 10.0, e.ACTION.most - 1)
    assert one(offered(many), f"more densely: {e.ACTION.most} points")
    assert not [says for says in offered(np.geomspace(1.0, 10.0, e.ACTION.most)) if "dense" in says]


def test_of_a_single_frequency_a_sweep_about_it():
    found = offered(np.full(4, 3.0))
    action = one(found, "measure a sweep of frequencies")
    np.testing.assert_allclose(action.action["omega"], np.geomspace(0.3, 30.0, e.ACTION.points))
    assert not [says for says in found if "wards" in says or "dense" in says]


def test_amplitudes_three_times_beyond_what_was_measured():
    units = Units("N/mm", "mm")
    found = offered(units=units, amplitude=np.array([0.1, 0.1, 0.4, 0.2]))
    for new in (1.2, 0.1 / 3.0):
        action = one(found, f"at the amplitude {new:.3g} mm")
        assert action.action["amplitude"] == pytest.approx([new])
        np.testing.assert_allclose(action.points.amplitude, np.full(e.ACTION.points, new))
        assert action.effort == e.TYPED_IN
    # Elsewhere the amplitude is the usual one.
    np.testing.assert_allclose(one(found, "upwards").points.amplitude, 0.15)
    assert not [says for says in offered() if "amplitude" in says]


@pytest.mark.parametrize(
    ("celsius", "wanted"),
    [
        ([20.0, 20.0, 20.0, 20.0], (40.0, 0.0)),
        ([0.0, 60.0, 30.0, 30.0], (90.0, -30.0)),
        ([0.0, 200.0, 30.0, 30.0], (240.0, -40.0)),
        ([-175.0, -170.0, -172.0, -172.0], (-150.0, -180.0)),
    ],
)
def test_temperatures_half_the_range_further_within_what_a_chamber_reaches(celsius, wanted):
    found = offered(temperature=np.array(celsius))
    new = [action for says, action in found.items() if "degC" in says]
    assert [action.action["temperature"] for action in new] == [[each] for each in wanted]
    for action, each in zip(new, wanted, strict=True):
        np.testing.assert_allclose(action.points.temperature, each + 273.15)


def test_a_larger_specimen_none_and_a_known_mass():
    found = offered(units=Units("N/mm", "mm"))
    larger, empty = one(found, "twice the area"), one(found, "without a specimen")
    assert (larger.scale, larger.action["specimen"], larger.effort) == (2.0, [2.0], e.WORKED_FOR)
    assert (empty.scale, empty.action["specimen"], empty.mass) == (0.0, [0.0], 0.0)
    mass = one(found, "a known mass")
    # As stiff as the specimen at the highest frequency; of N/mm a thousand times as many kg.
    assert mass.mass == pytest.approx(5.0 / 16.0**2)
    assert mass.action["mass"] == pytest.approx([1000.0 * 5.0 / 16.0**2])
    assert "about 20 kg" in mass.says
    assert mass.scale == 0.0
    assert not [says for says in offered(units=Units("Pa")) if "known mass" in says]


SETTLED = EXPERIMENT.settled


@pytest.mark.parametrize(
    ("sigmas", "either"),
    [
        ((SETTLED, 100.0 * SETTLED), True),
        ((0.1 * SETTLED, 0.2 * SETTLED), True),
        ((0.1 * SETTLED, 0.21 * SETTLED), False),
        ((0.99 * SETTLED, 2.5 * SETTLED), False),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_the_promise_is_the_least_or_where_it_depends_the_mean(sigmas, either, turned):
    shares = (0.75, 0.25)
    if turned:
        sigmas, shares = sigmas[::-1], shares[::-1]
    wanted = 0.75 * min(sigmas) + 0.25 * max(sigmas)
    if either:
        wanted = min(sigmas)
    assert experiment.separation(shares, sigmas) == pytest.approx(wanted)
    told = experiment.promise(("a", "b"), shares, sigmas)
    assert told.startswith("it separates a from b by") is either
    if not either:
        right, wrong = ("a", "b") if turned else ("b", "a")
        assert f"if {right} is right it" in told
        assert f"{right} stays possible" in told
        assert ("rules out" in told) is (max(sigmas) >= SETTLED)
        assert f"{wrong} by " in told


def test_more_than_enough_is_worth_no_more():
    assert experiment._enough(2.9 * SETTLED) == pytest.approx(2.9 * SETTLED)
    assert experiment._enough(4.0 * SETTLED) == pytest.approx(3.0 * SETTLED)
    assert experiment._sigmas(1000.0) == "1000 sigma"
    assert experiment._sigmas(1001.0) == "more than 1000 sigma"
