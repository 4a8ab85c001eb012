"""The recursion in time against what it replaces: a direct convolution with the relaxation function."""

from __future__ import annotations

from time import perf_counter

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.rheology.recursion import driven

SAMPLES, ROWS = 100_000, 40


def seconds(task) -> float:
    """The best of three."""
    times = []
    for _ in range(3):
        start = perf_counter()
        task()
        times.append(perf_counter() - start)
    return min(times)


@pytest.mark.slow
def test_the_recursion_is_a_thousand_times_a_direct_convolution():
    """Both sum the same 30 exponentials over 100,000 samples; the convolution's time is that of 40 of its rows."""
    rng = np.random.default_rng(1)
    rates, weights = np.geomspace(1e-3, 1e3, 30), rng.uniform(0.5, 1.5, 30)
    step = 0.01
    changes = rng.normal(size=SAMPLES)
    steps = np.full(SAMPLES, step)
    mix = weights[:, None]
    gain = -np.expm1(-rates * step) / (rates * step)
    kernel = np.exp(-np.outer(np.arange(SAMPLES) * step, rates)) @ (weights * gain)
    some = np.linspace(1, SAMPLES - 1, ROWS).astype(int)

    def direct() -> np.ndarray:
        return np.array([kernel[: k + 1] @ changes[k::-1] for k in some])

    found = driven(rates, steps, changes, mix, np.zeros_like(mix))[:, 0]
    np.testing.assert_allclose(found[some], direct(), rtol=1e-8, atol=1e-8 * np.abs(found).max())
    recursion = seconds(lambda: driven(rates, steps, changes, mix, np.zeros_like(mix)))
    convolution = seconds(direct) * SAMPLES / ROWS
    print(f"recursion {1e3 * recursion:.1f} ms, direct convolution {convolution:.2f} s")
    assert convolution > 40 * recursion


@pytest.mark.slow
def test_derivatives_cost_a_few_times_the_force():
    model = parse_model("fractional-zener")
    theta = np.array([1.0, 3.0, 2.0, 0.6])
    t = np.linspace(0.0, 10.0, 1000)
    x = np.sin(t)
    at = model.in_time(theta, tolerance=1e-6)
    whole = seconds(lambda: at.respond(t, x))
    print(f"1,000 samples with derivatives by 4 parameters, spectrum included: {1e3 * whole:.1f} ms")
    spectrum = seconds(lambda: model.spectrum(theta, (0.1, 300.0)))
    assert whole < 30 * spectrum
