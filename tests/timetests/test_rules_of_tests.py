"""Small rules of tests in time, with values by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import nnls

from springpot.errors import ModelError
from springpot.measurement import Loading, Measurement, TimeTest
from springpot.misfit.residuals_of_tests import COARSE, part_of
from springpot.registry import parse_model
from springpot.timetests import exponentials, hypotheses as left, material, specimen


def scatter(size=1.0, memory=0.0):
    def squares(residual, *stories):
        return float(np.sum(np.asarray(residual) ** 2)) / size**2

    return SimpleNamespace(
        size=size,
        memory=memory,
        whitened=lambda residual: np.asarray(residual) / size,
        deviance=squares,
        squares=squares,
    )


def of(*residuals, rounded=None, noise_answer=0.0, lines=0, count=3):
    residuals = [np.array(each, dtype=float) for each in residuals]
    none = [np.zeros((0, len(each))) for each in residuals]
    known = {"rounded": none if rounded is None else [np.array(rounded, dtype=float)]}
    seen = {"scatters": [scatter()] * len(residuals), "lines": lines, "count": count}
    fitted = SimpleNamespace(residuals=residuals, **seen, **known)
    fitted.squares = lambda noise, *others: left.FitResiduals.squares(fitted, noise, *others)
    answer = np.zeros(len(residuals[0]))
    answer[0] = np.sqrt(noise_answer)
    fitted.noise_answer = [answer, *[np.zeros(len(each)) for each in residuals[1:]]]
    fitted.squares_of_imposed = lambda noise: left.FitResiduals.squares_of_imposed(fitted, noise)
    return fitted


@pytest.mark.parametrize(
    ("size", "errors", "alike"),
    [
        (1.0, None, 1.0),
        # 0.955 of 2, and 0.045 of 0.36 over 0.045, of 2.
        (1.0, [[0.3, 0.3, 0.0, 0.0]], (0.955 * 2.0 + 0.36) / 2.0),
        # In units of half: changes of 2, errors of 0.6, of which 0.18 is the share.
        (0.5, [[0.3, 0.3, 0.0, 0.0]], (0.82 * 8.0 + 0.18 * 5.76 / 0.18) / 8.0),
        # All of it, where rounding errs by more than the noise.
        (1.0, [[3.0, 3.0, 0.0, 0.0]], 36.0 / 4.5 / 2.0),
        (1.0, [[0.3, -0.3, 0.0, 0.0]], 1.0),
    ],
)
def test_rounding_that_errs_alike_counts_a_sample_less(size, errors, alike):
    base, other = of([1.0, 1.0, 5.0, 5.0], rounded=errors), of([0.0, 0.0, 5.0, 5.0])
    assert left._alike(base, other, [scatter(size)]) == pytest.approx(alike)


def test_samples_are_counted_once_whose_noise_is_alike():
    noise = [scatter(memory=0.5), scatter()]
    assert left.independent_samples([np.zeros(30), np.zeros(7)], noise) == pytest.approx(17.0)
    assert left.independent_samples([np.zeros(3)], noise[:1]) == 2.0


def test_a_criterion_falls_by_squares_less_the_price_of_parameters():
    base, other = of([3.0, 1.0, 0.0]), of([1.0, 1.0, 0.0], count=5)
    fall = left.delta_bic(base, other, [scatter()])
    assert fall == pytest.approx(8.0 - 2.0 * np.log(3.0))
    # What the specimen never felt is no evidence; to answer more to it is no merit.
    noise_answer = of([3.0, 1.0, 0.0], noise_answer=5.0)
    beyond = (8.0 - 5.0) ** 2 / (4.0 * 5.0)
    assert left.delta_bic(noise_answer, other, [scatter()]) == pytest.approx(fall - 8.0 + beyond)
    all_of_it = of([3.0, 1.0, 0.0], noise_answer=9.0)
    assert left.delta_bic(all_of_it, other, [scatter()]) == pytest.approx(fall - 8.0)
    # What goes with the difference of two answers may do so by chance, whichever is the larger.
    more = of([1.0, 1.0, 0.0], noise_answer=5.0, count=5)
    by_chance = 8.0**2 / (4.0 * 5.0)
    assert left.delta_bic(base, more, [scatter()]) == pytest.approx(fall - 8.0 + by_chance)
    little = of([1.0, 1.0, 0.0], noise_answer=1.0, count=5)
    assert left.delta_bic(base, little, [scatter()]) == pytest.approx(fall)
    # A line of a free spectrum takes one from the sum of squares, where nothing is.
    lined = of([1.0, 1.0, 0.0], lines=3, count=5)
    assert left.delta_bic(base, lined, [scatter()]) == pytest.approx(fall - 3.0)


def even(n, control="displacement"):
    time = np.arange(float(n))
    wave = np.sin(time)
    return part_of(TimeTest(time, wave, Loading(time, wave), control, "mm", "N"))


def test_a_long_test_is_looked_at_in_sixty_places_first():
    assert even(COARSE).thin.tolist() == list(range(COARSE))
    thin = even(COARSE + 1).thin
    assert len(thin) == COARSE
    assert (thin[0], thin[-1]) == (0, COARSE)
    assert even(10 * COARSE).thin[[0, 1, -1]].tolist() == [0, 10, 10 * COARSE - 1]
    time = np.r_[0.0, np.geomspace(1e-3, 1e3, 200)]
    test = TimeTest(time, np.ones(201), Loading.step(), "displacement", "mm", "N")
    thin = part_of(test).thin
    assert thin[0] == 1
    assert thin[-1] == 200
    # Ten a decade: every third or fourth of thirty-three.
    assert set(np.diff(thin)) <= {3, 4}


@pytest.mark.parametrize(
    ("slope", "log", "told"),
    [
        # Lines take up all of the effect but its third entry, which is moved by a factor of e.
        (1.99, True, True),
        (2.01, True, False),
        # What has no logarithm moves by a tenth of the signal, whatever its slope.
        (1.0, False, False),
        (1e6, False, False),
        # K is a number and its slope is none.
        (np.inf, True, False),
    ],
)
def test_an_effect_is_untold_where_lines_do_what_it_did(slope, log, told):
    by_weights = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    weights, value = np.array([50.0, 50.0]), np.array([0.0, 0.0, 0.3])
    by_u = np.array([[3.0], [-2.0], [slope]])
    search = SimpleNamespace(
        model=SimpleNamespace(
            of_tests=True, parameters=[SimpleNamespace(name=name) for name in "abc"]
        ),
        count=2,
        first_of_tests=0,
        parts=[SimpleNamespace(signal=np.array([400.0]))],
        coordinates=SimpleNamespace(log=np.array([log])),
        slopes=lambda w, u: (value, by_weights, by_u),
    )
    found = material.MaterialSearch.untold(search, weights, np.zeros(1))
    # Against it the row is off by 0.3 - slope, with it by 0.3 + slope: the nearer counts.
    nearer = np.isinf(slope) or (slope - 0.3) ** 2 - 0.09 < material.TWO_DEVIATIONS
    if log:
        assert bool(found) == nearer
    else:
        assert bool(found) == told
    if found:
        assert found.startswith("c: another material could have done the same")
    search.model.of_tests = False
    assert material.MaterialSearch.untold(search, weights, np.zeros(1)) == ""


def test_a_material_as_lines_is_nearest_in_shares_of_its_stiffness():
    model, rates = parse_model("fractional-zener"), np.geomspace(0.01, 100.0, 9)
    theta = model.theta(k1=3.0, k2=400.0, c=60.0, alpha=0.6)
    found = material.as_lines(model, theta, rates)
    s = 1j * rates[:, None]
    exact = model.stiffness(theta, rates)
    columns = np.hstack([np.ones_like(s), s, s / (s + rates)]) / np.abs(exact)[:, None]
    matrix = np.concatenate([columns.real, columns.imag])
    target = np.concatenate([exact.real, exact.imag]) / np.tile(np.abs(exact), 2)
    amounts, _ = nnls(matrix, target)
    np.testing.assert_allclose(found.amounts, amounts, rtol=1e-6, atol=1e-9)
    # Lines of its own are told as they are.
    zener = parse_model("zener")
    own = material.as_lines(zener, zener.theta(k1=5.0, k2=7.0, c=0.7), np.array([0.1, 10.0, 50.0]))
    np.testing.assert_allclose(own.amounts, [5.0, 0.0, 0.0, 7.0, 0.0], atol=1e-9)
    asking = replace(zener, material=SimpleNamespace(needs=frozenset({"amplitude"})))
    with pytest.raises(ModelError, match="its material is none of one temperature"):
        material.as_lines(asking, np.zeros(3), rates)


@pytest.mark.parametrize("missed", [0.0, 3.0])
def test_a_fit_that_leaves_nothing_says_nothing_of_the_noise(missed, monkeypatch):
    monkeypatch.setattr(left, "replace", lambda row, **more: more)
    monkeypatch.setattr(left, "times_noise", lambda residual, size: float(residual[0]) / size)
    fitted = SimpleNamespace(residuals=[np.array([missed, -missed])])
    part = SimpleNamespace(relative_error=lambda residual: 0.01 * float(residual[0]))
    told = SimpleNamespace(over_floor=2.0, over_floor_alone=5.0)
    [row] = left.FitResiduals.rows(fitted, [part], [scatter(1.5)], [told])
    ratio = missed / 1.5
    assert row == {
        "relative_rms": pytest.approx(0.01 * missed),
        "noise_floor": pytest.approx(0.01 * missed / ratio if missed else 0.0),
        "over_floor": ratio,
        "over_floor_alone": pytest.approx(2.5 * ratio),
    }


def test_the_reference_is_the_measured_temperature_in_the_middle():
    time = np.array([1.0, 2.0])
    steps = [
        TimeTest.of_relaxation(time, time, temperature=celsius) for celsius in (90.0, None, 20.0)
    ]
    hot = {"temperature": np.array([50.0, 50.0])}
    sweeps = [Measurement(time, time + 1j, conditions=each) for each in (hot, {})]
    assert specimen.reference_of([*steps, *sweeps]) == pytest.approx(50.0 + 273.15)
    assert specimen.reference_of([steps[1], sweeps[1]]) == specimen.ROOM


def test_another_noise_of_a_part_is_none_of_its_test():
    """A robust fit weighs by a noise of its own: the sweep that it tells of stays as it was."""
    sweep = Measurement([1.0, 2.0], [3.0 + 1.0j, 4.0 + 2.0j], sd=[0.1 + 0.2j] * 2)
    for part in (part_of(sweep, np.full(4, 0.5)), part_of(sweep).with_sd(np.full(4, 0.5))):
        assert part.test is sweep
        assert part.sd.tolist() == [0.5] * 4
    assert part_of(sweep).sd.tolist() == [0.1, 0.1, 0.2, 0.2]


def test_a_search_by_exponentials_looks_at_no_sample_that_an_exact_fit_leaves_out():
    """A spike of the electronics would else draw the search where nothing is."""
    t = np.linspace(0.0, 4.0, 201)
    response = np.sin(2.0 * np.pi * t) + 0.01 * np.random.default_rng(2).normal(size=len(t))
    response[77] += 2.0
    part = part_of(TimeTest.of_history(t, np.sin(2.0 * np.pi * t + 0.3), response, "mm", "N"))
    assert part.strays.tolist() == [77]
    (quick,) = exponentials.quick_parts([part])
    assert quick.weight[77] == 0.0
    np.testing.assert_array_equal(quick.weight > 0.0, part.counted)
