"""What repeats tell of the noise: its axes, its rise along frequency and its tails."""

import numpy as np
import pytest
from scipy.signal import lfilter

import springpot
from springpot.measurement import Measurement, average_repeats
from springpot.measurement.replicates import noise_of_repeats
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.outliers import off_from_repeats
from springpot.misfit.residual_tests import repeats_structure

N = 60
OMEGA = np.geomspace(0.1, 100.0, N)
STIFFNESS = 100.0 + 100.0 * 1j * OMEGA / (1.0 + 1j * OMEGA)


def averaged(errors, count=2):
    """Means of so many repeats with errors (count N,) over |K|."""
    off = np.abs(STIFFNESS) * np.reshape(errors, (count, N))
    data = Measurement(
        np.tile(OMEGA, count),
        np.ravel(STIFFNESS + off),
        repeat=np.repeat(np.arange(count), N),
        name="made",
    )
    return average_repeats(data)


def told_of(errors, count=2):
    """Their noise."""
    return noise_of_repeats(averaged(errors, count))


def normal(rng, count=2):
    return 0.01 * (rng.standard_normal(count * N) + 1j * rng.standard_normal(count * N))


@pytest.mark.parametrize("count", [2, 3, 4])
def test_normal_repeats_have_no_tails(count):
    """A tail is one number more: normal noise is given one in a hundred draws or fewer."""
    rng = np.random.default_rng(5)
    assert [told_of(normal(rng, count), count).tails for _ in range(10)] == [np.inf] * 10


@pytest.mark.parametrize("count", [2, 3, 4])
def test_noise_with_long_tails_is_told_by_repeats(count):
    """Student's t of three degrees of freedom; the mean of more repeats has shorter tails."""
    rng = np.random.default_rng(6)
    found = []
    for _ in range(5):
        errors = rng.standard_t(3.0, (2, count * N)) / np.sqrt(3.0)
        found.append(told_of(0.01 * (errors[0] + 1j * errors[1]), count).tails)
    assert 2.0 < np.median(found) < 3.0 * count


def test_draws_have_the_tails_and_the_variance_of_the_noise():
    """Of variance one, and beyond four deviations far more often than normal noise."""
    flat = np.ones(N, dtype=complex)
    frame = NoiseFrame(
        Measurement(OMEGA, flat, name="made"),
        flat,
        np.full(N, 1.0 + 1.0j),
        np.zeros((0, N), dtype=complex),
        tails=5.0,
    )
    drawn = frame.draws(2000, np.random.default_rng(1))
    assert np.mean(drawn**2) == pytest.approx(1.0, rel=0.03)
    # Student's t of five degrees of freedom and variance one: .0035 beyond four; a normal: .00006.
    assert np.mean(np.abs(drawn) > 4.0) == pytest.approx(0.0035, rel=0.15)


def test_errors_of_gain_among_repeats_are_told_along_k():
    """A gain that scatters by 2 %, a phase by 1 mrad: no noise of storage and loss alone."""
    rng = np.random.default_rng(2)
    phase = STIFFNESS / np.abs(STIFFNESS)
    noise = told_of(
        (0.02 * rng.standard_normal(2 * N) + 0.001j * rng.standard_normal(2 * N))
        * np.tile(phase, 2)
    )
    assert noise.along is not None
    along, across = noise.along.sd.real / np.abs(STIFFNESS), noise.along.sd.imag / np.abs(STIFFNESS)
    assert np.allclose(along, 0.02 / np.sqrt(2.0), rtol=0.25)
    assert np.allclose(across, 0.001 / np.sqrt(2.0), rtol=0.25)


def test_repeats_that_rise_towards_an_end_are_told_so():
    """Eight times the noise at the upper end, as of a rig near its resonance."""
    rng = np.random.default_rng(3)
    rise = 1.0 + 7.0 * np.linspace(0.0, 1.0, N) ** 4
    sd = told_of(normal(rng) * np.tile(rise, 2)).sd.real / np.abs(STIFFNESS)
    assert sd[-1] > 3.0 * sd[N // 2]


def test_repeats_are_still_those_once_a_point_was_set_aside():
    """Not one number of each point, which chance alone would never leave so still."""
    rng = np.random.default_rng(1)
    whole = averaged(normal(rng, 3), 3)
    left = whole.without(np.arange(N) == 7)
    assert len(left.raw) == 3 * (N - 1)
    assert left.apart == pytest.approx(whole.apart[whole.group != 7])
    assert repeats_structure(left, rng).p_value > 0.05


def remembered(rng, count, memory):
    """Errors of 1 % of each run, of which each point keeps a share of the one before it."""
    new = rng.standard_normal((2, count, N))
    new[..., 1:] *= np.sqrt(1.0 - memory**2)
    real, imag = lfilter([1.0], [1.0, -memory], new)
    return 0.01 * (real + 1j * imag).ravel()


@pytest.mark.parametrize("count", [2, 3, 5])
def test_what_goes_on_from_point_to_point_in_each_run_is_the_memory_of_the_noise(count):
    """By R - 1 independent differences of R runs; white runs have none in 98 of 100 draws."""
    rng = np.random.default_rng(8)
    found = [told_of(remembered(rng, count, 0.6), count) for _ in range(8)]
    assert np.mean([noise.memory for noise in found]) == pytest.approx(0.58, abs=0.05)
    assert all(noise.tails == np.inf for noise in found)
    assert sum(told_of(normal(rng, count), count).memory > 0.0 for _ in range(8)) <= 1


def test_repeats_of_unequal_number_in_no_order_tell_the_same_memory():
    rng, count = np.random.default_rng(9), 3
    data = averaged(remembered(rng, count, 0.7), count).raw
    kept = rng.permutation(count * N)[: count * N - 25]
    whole, some = (
        noise_of_repeats(average_repeats(data.subset(rows)))
        for rows in (np.arange(count * N), kept)
    )
    assert whole.memory == pytest.approx(0.66, abs=0.08)
    assert some.memory == pytest.approx(whole.memory, abs=0.15)


@pytest.mark.parametrize(("count", "off"), [(3, [20]), (4, [20, 100]), (2, [])])
def test_a_row_far_from_its_repeats_is_told_without_a_model(count, off):
    """Twelve deviations of each part; of two repeats either may be the one that is off."""
    errors = normal(np.random.default_rng(10), count)
    errors[[20, 100]] += 0.12 + 0.12j
    if count == 3:
        errors[100] -= 0.12 + 0.12j
    assert off_from_repeats(averaged(errors, count).raw).tolist() == off


def test_a_run_that_is_off_as_a_whole_and_long_tails_are_no_single_rows():
    rng = np.random.default_rng(11)
    errors = normal(rng, 4)
    errors[N : 2 * N] *= 6.0
    assert not len(off_from_repeats(averaged(errors, 4).raw))
    tails = 0.01 * (rng.standard_t(5.0, 4 * N) + 1j * rng.standard_t(5.0, 4 * N))
    assert not len(off_from_repeats(averaged(tails, 4).raw))


def test_a_row_that_is_off_among_repeats_is_set_aside_and_told_by_its_number():
    model = springpot.parse_model("zener")
    errors = normal(np.random.default_rng(12), 4)
    errors[140] += 0.15
    stiffness = np.tile(model.stiffness(np.array([100.0, 100.0, 100.0]), OMEGA), 4) * (1.0 + errors)
    data = Measurement(np.tile(OMEGA, 4), stiffness, repeat=np.repeat(np.arange(4), N), name="made")
    found = springpot.diagnose(data, model.name, only=["inertia", "friction", "time-delay"])
    assert found.verdict == "adequate"
    assert [step.exclude for step in found.actions] == [(141,)]
