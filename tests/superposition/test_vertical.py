"""Vertical factors where sweeps are straight, and laws where no law of temperature can be meant."""

import warnings

import numpy as np
import pytest
from sweeps import LOG_A, TEMPERATURES, material, measured, simple

import springpot
from springpot.identification import default_objective, fit
from springpot.identification.free_factors import FactorRows, superposed_fit
from springpot.identification.known_factors import FURTHEST
from springpot.identification.space import Expected
from springpot.rheology import Continuum, Effect, Layer, Levels, Model, chain, shift

pytestmark = pytest.mark.usefixtures("asked_once")

CELSIUS = np.array([20.0, 30.0, 40.0, 50.0, 60.0, 70.0])
STEEP = -0.35 * (CELSIUS - 40.0)
"""Ln a of the straight sweeps: 1.5 decades for ten kelvin, two decades being measured."""


def straight(order, seed=0, ripple=0.01):
    """Sweeps near a power law of this order, only shifted, each rippled by its instrument."""
    omega, model = np.geomspace(0.1, 10.0, 11), springpot.parse_model("fractional-zener")
    parts = []
    for i, log_a in enumerate(STEEP):
        wave = 1.0 + ripple * (-1.0) ** i * np.sin(1.5 * np.log(omega) + i)
        parts.append(
            wave * model.stiffness(np.array([1.0, 30.0, 8.0, order]), omega * np.exp(log_a))
        )
    stiffness, random = np.concatenate(parts), np.random.default_rng(seed)
    noise = random.normal(size=len(stiffness)) + 1j * random.normal(size=len(stiffness))
    return springpot.Measurement(
        np.tile(omega, len(CELSIUS)),
        stiffness * (1.0 + 0.005 * noise),
        conditions={"temperature": np.repeat(CELSIUS, len(omega))},
        name="straight",
    )


@pytest.fixture(scope="module", params=[(0.2, 0), (0.2, 1), (0.3, 1)])
def curve(request):
    return springpot.mastercurve(straight(*request.param))


@pytest.mark.soak
def test_where_a_and_b_are_one_b_stays_what_physics_expects(curve):
    """Free factors would range from 0.75 to 1.4 here, and a be determined at one level of six."""
    assert np.all(np.abs(curve.factors.log_b) < np.log(1.12))
    assert np.all(curve.determined)
    assert np.all(np.abs(curve.factors.log_a - STEEP) <= curve.factors.reach_a + 1e-9)
    assert curve.simplicity.error <= curve.error_without_vertical


@pytest.mark.soak
def test_it_is_said_in_one_line_where_a_and_b_cannot_be_told_apart(curve):
    (note,) = [note for note in curve.notes if "cannot be told apart" in note]
    assert "70 degC" in note.split(":")[0]


@pytest.mark.soak
def test_there_is_a_law_of_the_shift(curve):
    assert "Arrhenius" in {law.law.name for law in curve.laws}


@pytest.mark.soak
@pytest.mark.parametrize("lift", [0.6, 1.5])
def test_data_that_contradict_what_is_expected_have_their_way(lift):
    """A specimen changed before the fourth sweep: its curvature tells the vertical factor."""
    found = springpot.mastercurve(
        measured(lambda i, omega: simple(i, omega) * (1.0 + (lift - 1.0) * (i == 3)))
    )
    free = springpot.mastercurve(measured(simple))
    ratio = np.exp(found.factors.log_b - free.factors.log_b)
    np.testing.assert_allclose(ratio, [1.0, 1.0, 1.0, lift, 1.0], rtol=0.03)
    assert not [note for note in found.notes if "cannot be told apart" in note]


def test_an_open_interval_ends_at_numbers_and_warns_of_nothing():
    def apart(i, omega):
        return material(omega * 10.0 ** (3.0 * (i < 2)))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        levels = springpot.mastercurve(measured(apart, noise=0.003, decades=0.5)).levels
    for level in levels:
        assert 0.0 < level.a_low <= level.a <= level.a_high <= np.exp(FURTHEST) * 1.001


@pytest.mark.soak
def test_no_law_where_the_material_relaxes_more_slowly_when_hot():
    """As a gel that dries: the factors are found, and no activation energy is."""
    drying = springpot.mastercurve(measured(lambda i, omega: material(omega * np.exp(-LOG_A[i]))))
    assert np.all(np.diff(drying.factors.log_a) > 0.0)
    assert [law for law in drying.laws if not law.law.vertical] == []
    (note,) = [note for note in drying.notes if "slowly when hot" in note]
    assert "is the column a temperature" in note
    usual = springpot.mastercurve(measured(simple))
    assert not [note for note in usual.notes if "slowly when hot" in note]


@pytest.mark.soak
def test_nothing_is_said_of_laws_where_temperature_does_nothing():
    """Shifts of one are no sign of drying, whatever the sign of their scatter."""
    notes = [
        springpot.mastercurve(measured(lambda i, omega: material(omega), seed=s)).notes
        for s in range(4)
    ]
    assert not [note for each in notes for note in each if "slowly when hot" in note]


@pytest.mark.soak
def test_constants_at_a_bound_are_not_told():
    """An activated material has no Vogel temperature: its pole would rest at 0 K."""
    kelvin = TEMPERATURES + 273.15
    log_a = 60.0 / 8.31446261815324e-3 * (1.0 / kelvin - 1.0 / 303.15)
    for seed in range(3):
        data = measured(lambda i, omega: material(omega * np.exp(log_a[i])), noise=0.002, seed=seed)
        for law in springpot.mastercurve(data).laws:
            bounds = [(p.lower, p.upper) for p in law.law.element.parameters]
            for value, (lower, upper) in zip(law.values, bounds, strict=True):
                assert lower + 1e-6 < value < upper


def test_what_is_expected_counts_beside_the_data_and_not_in_their_cost():
    """Of a fit: as stiff as may be, the factors are one; weak as may be, those of the data.

    Between, in between.
    """
    model = springpot.parse_model("material + free-vertical-shift")
    data = measured(lambda i, omega: (1.0 + 0.2 * (i == 4)) * material(omega))
    free = fit(model, data)
    count = len(TEMPERATURES) - 1
    sizes = []
    for weight in (1e-6, 2.0, 1e3):
        one = fit(model, data, expected=Expected(weight * np.eye(count), 1.0))
        off = np.abs(one.model.stiffness(one.theta, data.points) / data.stiffness - 1.0)
        assert one.cost == pytest.approx(float(np.sum(off**2)), rel=1e-6)
        sizes.append(float(np.log(one.theta[-1])))
    assert sizes[0] == pytest.approx(float(np.log(free.theta[-1])), rel=1e-4)
    assert 0.02 < sizes[1] < 0.95 * sizes[0]
    assert abs(sizes[2]) < 1e-4


def power_law(seed, power=0.0, points=8, noise=0.003):
    """Exactly straight sweeps at four temperatures.

    ln a and ln b are exact, b a power of the temperature.
    """
    random, kelvin = np.random.default_rng(seed), np.linspace(273.15, 333.15, 4)
    omega = np.tile(np.geomspace(0.1, 10.0, points), 4)
    log_a, log_b = 8000.0 * (1.0 / kelvin - 1.0 / 293.15), power * np.log(kelvin / 293.15)
    stiffness = (
        1e3
        * np.repeat(np.exp(log_b), points)
        * (1j * omega * np.repeat(np.exp(log_a), points)) ** 0.3
    )
    error = random.normal(size=len(omega)) + 1j * random.normal(size=len(omega))
    conditions = {"temperature": np.repeat(kelvin - 273.15, points)}
    return (
        springpot.Measurement(omega, stiffness * (1.0 + noise * error), conditions=conditions),
        log_a,
        log_b,
    )


@pytest.mark.soak_cases("-1.5", "1.0")
@pytest.mark.parametrize("power", [1.0, -1.5])
def test_intervals_on_straight_sweeps_hold_what_the_data_cannot_tell(power):
    """Their curve follows a little of the noise; taken for curvature, that halved the intervals."""
    held = []
    for seed in range(16):
        data, log_a, log_b = power_law(seed, power)
        found = springpot.mastercurve(data)
        factors, at = found.factors, found.factors.reference
        assert [note for note in found.notes if "cannot be told apart" in note]
        others = np.arange(4) != at
        held += (np.abs(factors.log_a - log_a + log_a[at]) <= factors.reach_a)[others].tolist()
        held += (np.abs(factors.log_b - log_b + log_b[at]) <= factors.reach_b)[others].tolist()
    assert np.mean(held) > 0.88


def few(points):
    """Two curved sweeps of very few points."""
    random, omega = np.random.default_rng(3), np.tile(np.geomspace(0.1, 10.0, points), 2)
    celsius = np.repeat([0.0, 40.0], points)
    stiffness = 1e3 * (1.0 + (0.3j * omega * np.exp(-0.05 * (celsius - 20.0))) ** 0.5)
    error = random.normal(size=len(omega)) + 1j * random.normal(size=len(omega))
    return springpot.Measurement(
        omega, stiffness * (1.0 + 0.003 * error), conditions={"temperature": celsius}
    )


@pytest.mark.soak
@pytest.mark.parametrize(
    "data",
    [*(power_law(seed)[0] for seed in (8, 12, 15, 25)), few(3), few(4), measured(simple)],
    ids=range(7),
)
def test_vertical_factors_are_never_worse_than_those_of_one(data):
    sideways = Effect(
        "shift", shift, Levels("temperature", "a", True), "a factor", Layer.TEMPERATURE
    )
    upwards = Effect(
        "vertical", chain, Levels("temperature", "b", False), "a factor", Layer.TEMPERATURE
    )
    model = Model("material", Continuum(), effects=(sideways,))
    alone = fit(model, data, default_objective(data))
    found = FactorRows.of(superposed_fit(model + upwards, data, default_objective(data)))
    assert found.objective <= alone.cost * (1.0 + 1e-9)
    # What is minimised beside the data is never below zero.
    assert found.objective >= found.fit.cost


def test_a_point_a_level_leaves_the_reference_at_one_and_warns_of_nothing():
    data = springpot.Measurement(
        [1.0, 2.0], [1e3 + 2e2j, 8e2 + 1e2j], conditions={"temperature": [0.0, 40.0]}
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = springpot.mastercurve(data, reference="0degC")
    first, second = found.levels
    assert (first.a_low, first.a_high, first.b_low, first.b_high) == (1.0, 1.0, 1.0, 1.0)
    assert first.determined
    assert not second.determined
    assert not [note for note in found.notes if note.startswith("0 degC")]
