"""A few points that are far off.

They do not raise the noise floor, and what they leave is not called adequate.
"""

from __future__ import annotations

import numpy as np
import pytest
from hidden_data import KELVIN, WARM, design, exact, measured

import springpot
from soaked import soaked
from springpot.measurement import Measurement
from springpot.misfit.floor import fitted_to_floor, undragged
from springpot.misfit.outliers import _chance, outlying

MODEL = springpot.parse_model("fractional-kelvin")
AT = design(40, 0.1, 50.0)
NOISE = 0.005
ORDER = np.arange(len(AT.omega))


def seen_through(factor, seed):
    """The model's K times a factor, with noise of a size that nobody knows."""
    return measured(AT, exact(KELVIN, AT) * factor, seed, NOISE / np.sqrt(2.0), known=False)


def notch(place, depth=0.3):
    x = ORDER - place
    return 1.0 + depth * (-1.0 + 0.6j * x) * np.exp(-0.5 * x**2)


@pytest.mark.soak_cases("20-0", "20-1", "33-0", "33-1", "8-1")
@pytest.mark.parametrize("seed", [0, 1, *map(soaked, (2, 3))])
@pytest.mark.parametrize("place", [8, 20, 33])
def test_a_notch_neither_raises_the_floor_nor_is_called_adequate(place, seed):
    data = seen_through(notch(place), seed)
    base = fitted_to_floor(MODEL, data)
    free, inside = undragged(base)
    assert base.floor == pytest.approx(NOISE, rel=0.3)
    assert not inside[place]
    assert np.sum(~inside) <= 8
    assert (
        np.max(np.abs(free.model.stiffness(free.theta, data.points) / exact(KELVIN, AT) - 1.0))
        < 0.02
    )
    if (place, seed) == (33, 0):
        assert springpot.diagnose(data, MODEL).verdict != "adequate"


@pytest.mark.soak_cases("1", "2", "3")
@pytest.mark.parametrize("seed", range(4))
def test_a_ripple_in_phase_only_does_not_raise_the_floor(seed):
    ripple = 1.0 + 0.06j * np.cos(2.0 * np.pi * ORDER / 8.0)
    assert fitted_to_floor(MODEL, seen_through(ripple, seed)).floor == pytest.approx(NOISE, rel=0.5)


@pytest.mark.soak
def test_noise_alone_leaves_the_fit_as_it_is():
    kept = 0
    for seed in range(20):
        base = fitted_to_floor(MODEL, seen_through(1.0, seed))
        free, inside = undragged(base)
        kept += bool(np.all(inside))
        assert (free is base) == bool(np.all(inside))
        assert base.floor == pytest.approx(NOISE, rel=0.3)
    assert kept >= 18


@pytest.mark.soak
def test_long_tails_are_no_structure():
    """Student's t with three degrees of freedom.

    Far points anywhere are told one by one, and nothing is missing.
    """
    for seed in range(3):
        tails = np.random.default_rng(seed).standard_t(3.0, (2, len(ORDER)))
        factor = 1.0 + NOISE * (tails[0] + 1j * tails[1])
        answer = springpot.diagnose(seen_through(factor, seed), MODEL)
        assert (
            answer.verdict in ("adequate", "inconclusive")
            or "nothing else is missing" in answer.says
        )


@pytest.mark.soak
def test_where_repeats_share_a_disturbance_a_gain_of_each_temperature_is_no_unknown():
    """Three specimens at each of four temperatures, each sweep with a gain of its own.

    The shift is still named.
    """
    rng = np.random.default_rng(5)
    at = design(15, temperatures=(10.0, 25.0, 40.0, 55.0))
    hidden = exact(WARM, at)
    rows = np.tile(np.arange(len(hidden)), 3)
    specimen = np.repeat(np.arange(3), len(hidden))
    sweep = 4 * specimen + np.unique(at.celsius, return_inverse=True)[1][rows]
    gain = 1.0 + 0.02 * rng.normal(size=12)[sweep]
    noise = 0.004 * (rng.normal(size=len(rows)) + 1j * rng.normal(size=len(rows)))
    data = Measurement(
        at.omega[rows],
        hidden[rows] * gain * (1.0 + noise),
        repeat=specimen,
        conditions={"temperature": at.celsius[rows]},
    )
    answer = springpot.diagnose(data, MODEL)
    assert answer.verdict == "effect-missing"
    assert {"arrhenius-shift", "wlf-shift"} & set(answer.classes[0])


def standing_out(off, known=True):
    """The diagnosis of a sweep of 48 points, some of which are off by a share of K."""
    at = design(48)
    factor = np.ones(48)
    factor[list(off)] += list(off.values())
    data = measured(at, exact(KELVIN, at) * factor, 1, 0.007, known=known)
    return springpot.diagnose(data, MODEL, only=["inertia", "friction", "parallel-spring"])


@pytest.mark.soak_cases("False", "True")
@pytest.mark.parametrize("known", [True, False])
def test_one_absurd_point_is_left_out_of_an_adequate_model(known):
    answer = standing_out({20: 0.2}, known)
    assert answer.verdict == "adequate"
    assert "without a single point that stands out by itself" in answer.says
    assert answer.split == ""
    assert answer.where[0].low == pytest.approx(design(48).omega[20] / (2.0 * np.pi))
    assert [step.exclude for step in answer.actions] == [(21,)]
    assert "measure again" in answer.next_experiment.says


@pytest.mark.soak
def test_what_lies_beside_a_bad_reading_tells_it_from_a_resonance():
    answer = standing_out({20: 0.2, 21: 0.024, 19: 0.024})
    assert answer.verdict == "unexplained"
    assert "a single point stands out" in answer.says
    assert "nothing else is missing" in answer.says


def with_bad_points(off, gain, phase, seed, points=60):
    """A sweep with noise in gain and phase, some of its points off by a factor."""
    at, rng = design(points), np.random.default_rng(seed)
    factor = (1.0 + gain * rng.normal(size=points)) * np.exp(1j * phase * rng.normal(size=points))
    factor[list(off)] *= list(off.values())
    return Measurement(at.omega, exact(KELVIN, at) * factor)


def test_two_bad_points_do_not_hide_each_other():
    data = with_bad_points({15: 0.86, 35: 1.14}, 0.014, 0.005, seed=0)
    assert outlying(fitted_to_floor(MODEL, data).frame()).tolist() == [15, 35]


def test_two_bad_points_of_few_do_not_lengthen_the_tails_of_their_neighbours():
    data = with_bad_points({4: 1.0 - 0.06j, 24: 0.94}, 0.003, 0.003, seed=0, points=30)
    assert outlying(fitted_to_floor(MODEL, data).frame()).tolist() == [4, 24]


def test_where_few_numbers_tell_the_scatter_more_is_chance():
    others, off = np.linspace(0.1, 4.0, 12), np.array([24.0])
    assert _chance(others, off, 2, dof=16.0) > 1e-4 > _chance(others, off, 2, dof=1e6)


@pytest.mark.soak
def test_a_bad_end_does_not_hide_another_bad_point():
    data = with_bad_points({50: 1.3, 59: 0.65}, 0.012, 0.012, seed=3)
    answer = springpot.diagnose(data, MODEL, only=["inertia", "friction", "parallel-spring"])
    assert answer.verdict == "adequate"
    assert [step.exclude for step in answer.actions] == [(51,), (60,)]
