"""By which numbers models are put in order: chance, size, evidence, distance."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

import springpot
from springpot.comparison import rank
from springpot.comparison.comparing import _outdone, chance_beside, spends_most
from springpot.comparison.result import at_noise, best_of, grouped
from springpot.measurement import Measurement, Units


def fitted(rss=0.0, dof=20, parameters=3, points=20, noise_dof=np.inf, **given):
    fit = SimpleNamespace(dof=dof, measurement=[0.0] * points)
    noise = SimpleNamespace(dof=noise_dof, source=given.pop("source", "estimated"))
    given = {"relative_rms": 0.01, "floor": 0.01, "error_dof": dof} | given
    given["error"] = given["relative_rms"]
    return SimpleNamespace(
        rss=rss, fit=fit, dof=dof, numbers=2 * points, noise_dof=noise_dof,
        theta=[0.0] * parameters, noise=noise, **given,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("gain", "dof", "floor_rss", "floor_dof", "value", "spare"),
    [
        pytest.param(30.0, 20, 8.0, 10, 30.0, 10, id="in units of the noise"),
        pytest.param(30.0, 20, 30.0, 10, 10.0, 10, id="where a material leaves more, of that"),
        pytest.param(6.0, 12, 3.0, 0, 2.0, 12, id="a material that leaves no number"),
        pytest.param(4.0, 10, 5.0, 10, 4.0, 1, id="no more lines than parameters"),
        pytest.param(-2.0, 20, 8.0, 10, 0.0, 10, id="no gain"),
    ],
)
def test_the_chance_of_a_gain_is_that_of_chi_square(gain, dof, floor_rss, floor_dof, value, spare):
    found, floor = fitted(floor_rss + gain, dof), fitted(floor_rss, floor_dof)
    assert chance_beside(found, floor) == pytest.approx(stats.chi2.sf(value, spare), rel=1e-9)


def test_most_is_spent_beyond_as_many_parameters_as_numbers_are_left():
    assert not spends_most(fitted(parameters=12, points=12))
    assert spends_most(fitted(parameters=13, points=12))


def judged(delta_bic, parameters, points=20, at_noise=False, computed=False):
    ranked = fitted(parameters=parameters, points=points)
    return SimpleNamespace(delta_bic=delta_bic, ranked=ranked, at_noise=at_noise, computed=computed)


def test_a_model_is_outdone_by_a_richer_one_that_is_better_by_more_than_ten():
    one = judged(12.0, 3)
    assert _outdone(one, [one, judged(1.0, 4)])
    assert not _outdone(one, [one, judged(2.0, 4)])
    assert not _outdone(one, [one, judged(0.0, 3)])
    assert not _outdone(one, [one, judged(0.0, 2)])


def test_at_the_noise_none_is_outdone_by_one_that_spends_most_of_the_numbers():
    greedy = judged(0.0, 21)
    assert not _outdone(judged(12.0, 3, at_noise=True), [greedy])
    assert _outdone(judged(12.0, 3, at_noise=True), [judged(0.0, 20)])
    assert _outdone(judged(12.0, 3), [greedy])


def test_of_computed_data_no_model_is_outdone():
    assert not _outdone(judged(100.0, 3, computed=True), [judged(0.0, 4)])


def test_the_best_has_the_least_criterion():
    rows = [judged(2.0, 3), judged(0.0, 5), judged(1.0, 1)]
    assert best_of(rows) is rows[1]


def curve(level, weight=10.0):
    both = np.full(4, weight * level)
    return SimpleNamespace(ranked=SimpleNamespace(curve=np.concatenate([both.real, both.imag])))


def test_curves_less_than_two_deviations_apart_are_one_group_by_its_first():
    """Over four points a step of 0.09 in the storage, in units of 0.1, is 1.8 deviations."""
    rows = [curve(level) for level in (1.0, 1.09, 1.18, 1.09j)]
    assert grouped(rows) == ((rows[0], rows[1]), (rows[2],), (rows[3],))


@pytest.mark.parametrize(
    ("given", "answer"),
    [
        pytest.param({}, True, id="at the floor"),
        pytest.param({"relative_rms": 0.03}, False, id="beyond it"),
        pytest.param({"relative_rms": 1e-14, "floor": 1e-16}, True, id="arithmetic"),
        pytest.param({"dof": 2}, False, id="few numbers"),
        pytest.param({"dof": 2, "relative_rms": 1e-14}, True, id="few numbers of arithmetic"),
    ],
)
def test_an_error_is_as_large_as_noise_makes_it(given, answer):
    found = fitted(**({"noise_dof": 40} | given))
    assert at_noise(found) is answer


def test_what_is_too_large_for_noise_is_not_at_the_noise():
    large = {"relative_rms": 0.5, "floor": 0.5, "noise_dof": 40}
    assert not at_noise(fitted(**large))
    assert at_noise(fitted(**large, source="given"))
    # The search whose error is printed may leave less than the fit by the noise.
    searched = fitted(**large)
    searched.error = 0.01
    assert at_noise(searched)


def at_one_frequency(names, library=(), celsius=None):
    rng = np.random.default_rng(5)
    strain = np.geomspace(0.001, 1.0, 16)
    scatter = 0.01 * (rng.normal(size=16) + 1j * rng.normal(size=16))
    modulus, conditions = np.full(16, 900.0 + 120.0j), {"amplitude": strain}
    if celsius is not None:
        heat = np.exp(60e3 / 8.314 * (1.0 / (celsius + 273.15) - 1.0 / 313.15))
        along = (0.6j * np.pi * heat) ** 0.8
        modulus, conditions = 1e6 + 5e6 * along / (1.0 + along), {"temperature": celsius}
    omega = np.full(16, 2.0 * np.pi)
    data = Measurement(
        omega, modulus * (1.0 + scatter), conditions=conditions, units=Units("Pa", "-"), name="one"
    )
    models = [springpot.parse_model(name) for name in names]
    effects = [springpot.registry.plugins().effect(name) for name in library]
    return rank(data, models, effects, np.random.default_rng(0))


ONE_FREQUENCY = "at one frequency any two parameters do the same"


@pytest.mark.soak
def test_at_one_frequency_a_linear_model_of_two_parameters_is_fitted_and_of_three_is_not():
    names = ("kelvin", "zener", "kelvin + gain-error", "kelvin + payne")
    ranking = at_one_frequency(names)
    assert {one.model.name for one in ranking.judgements} == {"kelvin", "kelvin + payne"}
    assert [tuple(one) for one in ranking.skipped] == [
        ("zener", ONE_FREQUENCY),
        ("kelvin + gain-error", ONE_FREQUENCY),
    ]


@pytest.mark.soak
def test_with_an_accepted_shift_of_times_one_frequency_is_a_sweep():
    celsius = np.linspace(-20.0, 100.0, 16)
    ranking = at_one_frequency(("fractional-zener",), ("arrhenius-shift",), celsius)
    assert ranking.best.model.name == "fractional-zener + arrhenius-shift"
    assert ranking.skipped == ()
