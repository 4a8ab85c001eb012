"""How far the values of a file can be told apart bounds their noise from below."""

import numpy as np
import pytest

from springpot import Measurement
from springpot.measurement import at_least_rounding, scatter


def measured(storage, loss):
    return Measurement(np.arange(1.0, 4.0), np.array(storage) + 1j * np.array(loss))


def test_few_digits_bound_the_noise():
    data = measured([102.8, 141.4, 185.0], [73.25, 85.91, 91.84])
    sd = at_least_rounding(np.full(3, 1e-9 + 1e-9j), data)
    assert sd.real == pytest.approx(0.1 / np.sqrt(12))
    assert sd.imag == pytest.approx(0.01 / np.sqrt(12))


def test_full_digits_leave_the_noise_as_it_is():
    values = np.random.default_rng(0).uniform(1.0, 2.0, (2, 3))
    sd = np.full(3, 1e-3 + 2e-3j)
    assert np.array_equal(at_least_rounding(sd, measured(*values)), sd)


def test_a_loss_of_zero_has_no_last_digit():
    sd = at_least_rounding(np.full(3, 1e-3 + 1e-3j), measured([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]))
    assert sd.imag == pytest.approx(1e-3)


def test_noise_rises_to_the_upper_end_the_lower_end_or_both():
    rises = np.array(list(scatter._rises(np.linspace(-1.0, 3.0, 9))))
    slope = np.diff(rises, axis=1)
    up, down = np.all(slope > 0.0, axis=1), np.all(slope < 0.0, axis=1)
    both = np.all(slope[:, :4] < 0.0, axis=1) & np.all(slope[:, 4:] > 0.0, axis=1)
    assert up.sum() == down.sum() == both.sum() == len(rises) / 3
    np.testing.assert_allclose(rises.min(axis=1), 1.0)
    assert not list(scatter._rises(np.zeros(9)))


def test_noise_of_what_shakes_a_mass_grows_with_the_square_of_the_frequency():
    """A thousandth of K far below, thirty times as much at the upper end."""
    omega = np.geomspace(1.0, 300.0, 60)
    data = Measurement(omega, (100.0 + 40.0j) * omega**0.2)
    size = 1e-3 * np.hypot(1.0, 30.0 * (omega / omega[-1]) ** 2 * (omega / omega[-1]) ** -0.2)
    rng = np.random.default_rng(3)
    noise = size * data.magnitude * (rng.standard_normal(60) + 1j * rng.standard_normal(60))
    told, _ = scatter.robust_noise_shape(data, noise, np.arange(60), uneven=True)
    np.testing.assert_allclose(told.real / data.magnitude / size, 1.0, atol=0.5)
    even, _ = scatter.robust_noise_shape(data, noise, np.arange(60))
    assert np.max(even.real / data.magnitude) < 5.0 * np.min(even.real / data.magnitude)


@pytest.mark.parametrize("louder", ["one sweep", "warm"])
def test_noise_may_be_larger_in_one_sweep_or_grow_with_the_temperature(louder):
    """Of five sweeps the third four times as much, or the last four times as much as the first."""
    omega, celsius = np.tile(np.geomspace(1.0, 100.0, 15), 5), np.repeat(np.arange(5.0), 15)
    data = Measurement(omega, (9.0 + 3.0j) * omega**0.1, conditions={"temperature": celsius})
    size = 0.01 * np.where(celsius == 2.0, 4.0, 1.0)
    if louder == "warm":
        size = 0.01 * np.hypot(1.0, 4.0 * (celsius / 4.0) ** 2)
    rng = np.random.default_rng(4)
    noise = size * data.magnitude * (rng.standard_normal(75) + 1j * rng.standard_normal(75))
    told, _ = scatter.robust_noise_shape(data, noise, np.arange(75), uneven=True)
    np.testing.assert_allclose(told.real / data.magnitude / size, 1.0, atol=0.6)


def with_coherence(coherence, n=120):
    """A stiffness that scatters by 8 % below 25 rad/s, where coherence is low, then by 0.4 %."""
    rng, omega = np.random.default_rng(2), np.linspace(1.0, 100.0, n)
    spread = np.where(omega < 25.0, 0.08, 0.004)
    exact = 50.0 + 10.0 * (1j * omega) ** 0.5
    told = {} if coherence is None else {"coherence": coherence(spread)}
    off = exact * spread * (rng.normal(size=n) + 1j * rng.normal(size=n))
    return Measurement(omega, exact + off, conditions=told), off, spread


def test_coherence_tells_how_the_noise_goes():
    data, off, spread = with_coherence(lambda spread: 1.0 / (1.0 + 40.0 * spread**2))
    sd, turn = scatter.robust_noise_shape(data, off, np.arange(len(off)))
    assert turn is None
    relative = sd.real / data.magnitude
    assert relative[0] / relative[-1] == pytest.approx(spread[0] / spread[-1], rel=0.25)


@pytest.mark.parametrize("wrong", [lambda spread: 0.9 + 0.0 * spread, lambda spread: 1.0 + spread])
def test_what_is_no_coherence_tells_nothing(wrong):
    data, off, _ = with_coherence(wrong)
    without, *_ = with_coherence(None)
    rows = np.arange(len(off))
    mine = scatter.robust_noise_shape(data, off, rows)[0]
    np.testing.assert_allclose(mine, scatter.robust_noise_shape(without, off, rows)[0])


def test_given_noise_is_raised_where_the_data_scatter_otherwise():
    rng, omega = np.random.default_rng(3), np.geomspace(1.0, 100.0, 40)
    exact = 50.0 + 10.0 * (1j * omega) ** 0.5
    given = 0.005 * np.abs(exact) * (1.0 + 1.0j)
    uneven = given.real * (0.5 * rng.normal(size=40) + 1.5j * rng.normal(size=40))
    even = given.real * (rng.normal(size=40) + 1j * rng.normal(size=40))
    data = Measurement(omega, exact + uneven, sd=given)
    noise = scatter.Noise(given, np.inf, "given")
    assert scatter.beside_given(noise, data, even, 60.0) is noise
    # What was given too large may hold what neighbours share.
    assert scatter.beside_given(noise, data, 0.3 * even, 60.0) is noise
    raised = scatter.beside_given(noise, data, uneven, 60.0)
    np.testing.assert_array_equal(raised.sd.real, given.real)
    assert np.median(raised.sd.imag / given.imag) == pytest.approx(1.5, rel=0.2)
    assert raised.overruled
    assert "go otherwise than the data's own scatter" in raised.doubt
