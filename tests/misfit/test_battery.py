"""The battery of residual tests: right on noise of every kind, and on structure of every kind."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from soaked import soaked
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.frame import near_an_alarm
from springpot.misfit.residual_tests import TESTS, _one_frequency_in_words, battery

MODEL = springpot.parse_model("fractional-zener")
TRUTH = np.array([100.0, 400.0, 60.0, 0.5])


def scatter(kind, rng, shape):
    """Standardised noise of several kinds, shape (2, n)."""
    if kind == "long tails":
        return rng.standard_t(3, size=shape) / np.sqrt(3.0)
    noise = rng.normal(size=shape)
    if kind == "gain only":
        noise[1] *= 0.1
    if kind == "one noisy sweep":
        noise[:, : shape[1] // 3] *= 3.0
    return noise


def sweeps(kind, seed=0, error=0.0):
    """One sweep of 48 points, or three of 16 at three temperatures; noise of 1 %, size unknown."""
    temperature = np.repeat([0.0, 10.0, 20.0], 16) if kind == "one noisy sweep" else None
    omega = np.geomspace(0.5, 300.0, 48)
    if temperature is not None:
        omega = np.tile(np.geomspace(0.5, 300.0, 16), 3)
    noise = 0.01 * scatter(kind, np.random.default_rng(seed), (2, 48))
    stiffness = MODEL.stiffness(TRUTH, omega) * (1.0 + error + noise[0] + 1j * noise[1])
    conditions = {} if temperature is None else {"temperature": temperature}
    return springpot.Measurement(omega, stiffness, conditions=conditions)


def judged(data):
    return battery(fitted_to_floor(MODEL, data).frame(), np.random.default_rng(1))


@pytest.mark.soak
@pytest.mark.parametrize("kind", ["normal", "long tails", "one noisy sweep", soaked("gain only")])
@pytest.mark.parametrize(("draws", "few", "rare"), [(12, 4, 2), soaked(24, 5, 2), soaked(60, 9, 4)])
def test_chances_on_noise_alone_are_chances(kind, draws, few, rare):
    """Largest counts below 0.05 and below 0.01, but for one run in 1,000 and one in 500."""
    chances = np.array([judged(sweeps(kind, seed)).p_value for seed in range(draws)])
    assert np.sum(chances < 0.05) <= few
    assert np.sum(chances < 0.01) <= rare
    assert 0.25 < np.median(chances) < 0.75


X = np.linspace(-1.0, 1.0, 48)
PATTERNS = {
    "slow": 0.05 * X**3 * (1.0 + 0.5j),
    "ripple": 0.03 * np.cos(np.arange(48) * 2.0 * np.pi / 6.0),
    "single points": np.where(np.arange(48) == 20, 0.2, 0.0),
    "runs": 0.03 * np.sin(9.0 * X),
}


@pytest.mark.soak_cases("single points", "runs", "ripple")
@pytest.mark.parametrize("name", PATTERNS)
def test_structure_of_each_kind_raises_the_alarm_and_is_told(name):
    found = judged(sweeps("normal", 3, PATTERNS[name]))
    assert found.alarm
    assert found.parts.get(name, 0.0) < 0.005
    [told] = [finding for finding in found.findings if finding.test == name]
    assert told.found
    assert told.says


@pytest.mark.parametrize("seed", range(4))
def test_a_ripple_of_the_size_of_an_unknown_noise_is_seen_on_few_points(seed):
    """Four waves on 27 points, as large as the noise.

    It is half of all that is left, and yet not taken for noise.
    """
    omega, rng = np.geomspace(0.5, 300.0, 27), np.random.default_rng(seed)
    waves = 0.014 * np.exp(1j * (2.0 * np.pi * 4.0 * np.linspace(0.0, 1.0, 27) + seed))
    noise = 0.01 * (rng.normal(size=27) + 1j * rng.normal(size=27))
    data = springpot.Measurement(omega, MODEL.stiffness(TRUTH, omega) * (1.0 + waves + noise))
    assert judged(data).parts["ripple"] < 0.002


@pytest.mark.parametrize("single", [1, 2])
def test_sweeps_of_one_point_or_two_stand_beside_long_ones(single):
    """As where a rig could hold one frequency only at its coldest."""
    omega = np.concatenate([np.geomspace(0.5, 300.0, 30), np.geomspace(10.0, 20.0, single)])
    temperature = np.where(np.arange(30 + single) < 30, 20.0, -40.0)
    rng = np.random.default_rng(1)
    noise = 0.01 * (rng.normal(size=30 + single) + 1j * rng.normal(size=30 + single))
    stiffness = MODEL.stiffness(TRUTH, omega) * (1.0 + noise)
    data = springpot.Measurement(omega, stiffness, conditions={"temperature": temperature})
    assert 0.005 < judged(data).p_value <= 1.0


def test_every_test_has_a_sentence_and_a_silent_battery_finds_nothing():
    found = judged(sweeps("normal", 1))
    assert not found.alarm
    assert (
        {finding.test for finding in found.findings}
        == set(found.parts)
        <= {test.name for test in TESTS}
    )
    assert all(finding.says and not finding.found for finding in found.findings)


def test_the_same_generator_gives_the_same_chances():
    data = sweeps("normal", 2)
    assert judged(data).parts == judged(data).parts


OPEN = [(0.004, 2000), (0.009, 2000), (0.005, 20000)]
SETTLED = [(0.0005, 2000), (0.05, 2000), (0.009, 20000)]


@pytest.mark.parametrize(("chance", "draws"), OPEN + SETTLED)
def test_more_is_drawn_only_where_the_verdict_is_open(chance, draws):
    assert near_an_alarm(chance, draws) is ((chance, draws) in OPEN)


def test_an_error_at_one_frequency_is_told_with_its_place():
    """And of one sweep alone, not of several."""
    data = sweeps("normal", 3, PATTERNS["single points"])
    place = data.units.at(float(data.frequency[20]))
    frame = fitted_to_floor(MODEL, data).frame()
    _, says = _one_frequency_in_words(frame)
    assert says.startswith(f"at {place}, with its neighbours or alone, the residual is off by")
    assert says.endswith(" sd")
