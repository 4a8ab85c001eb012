"""The recursion in time against what it replaces.

A direct convolution with the relaxation function.
"""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from patience import patient

from springpot.measurement import TimeTest
from springpot.registry import parse_model
from springpot.rheology.rational import Lines, Rational
from springpot.rheology.terms import driven
from springpot.timetests import identify

SAMPLES = 100_000
MOST_EIGENVALUE_PROBLEMS = 11
ROWS = {"even": 40, "uneven": 4}


def seconds(task) -> float:
    """Processor time, the best of three: what else the machine does is not counted."""
    times = []
    for _ in range(3):
        start = process_time()
        task()
        times.append(process_time() - start)
    return min(times)


@pytest.mark.soak_cases("uneven-1000")
@pytest.mark.slow
@pytest.mark.parametrize(("sampling", "least"), [("even", 20), ("uneven", 1000)])
def test_the_recursion_against_a_direct_convolution(sampling: str, least: float):
    """Both sum the same 30 exponentials over 100,000 samples.

    The convolution's time is that of a few of its rows.

    With even steps a convolution may tabulate the relaxation function once and is one product a
    sample; with uneven ones each pair of samples has its own.
    """
    rng = np.random.default_rng(1)
    rates, weights = np.geomspace(1e-3, 1e3, 30), rng.uniform(0.5, 1.5, 30)
    changes, mix = rng.normal(size=SAMPLES), weights[:, None]
    uneven = sampling == "uneven"
    steps = rng.uniform(0.005, 0.015, SAMPLES) if uneven else np.full(SAMPLES, 0.01)
    gain = -np.expm1(-np.outer(steps, rates)) / np.outer(steps, rates)
    t = np.cumsum(steps)
    table = np.exp(-np.outer(t - t[0], rates)) @ (weights * gain[0])
    some = np.linspace(1, SAMPLES - 1, ROWS[sampling]).astype(int)

    def row(k: int) -> float:
        if not uneven:
            return table[: k + 1] @ changes[k::-1]
        fade = np.exp(-np.outer(t[k] - t[: k + 1], rates)) * gain[: k + 1]
        return fade @ weights @ changes[: k + 1]

    def direct() -> np.ndarray:
        return np.array([row(k) for k in some])

    found = driven(rates, steps, changes, mix, np.zeros_like(mix))[:, 0]
    np.testing.assert_allclose(found[some], direct(), rtol=1e-8, atol=1e-8 * np.abs(found).max())
    recursion = seconds(lambda: driven(rates, steps, changes, mix, np.zeros_like(mix)))
    convolution = seconds(direct) * SAMPLES / len(some)
    print(f"{sampling}: recursion {1e3 * recursion:.1f} ms, direct convolution {convolution:.2f} s")
    assert convolution > least * recursion


@pytest.mark.slow
def test_derivatives_cost_a_few_times_the_force():
    model = parse_model("fractional-zener")
    theta = np.array([1.0, 3.0, 2.0, 0.6])
    t = np.linspace(0.0, 10.0, 1000)
    x = np.sin(t)
    at = model.in_time(theta, tolerance=1e-6)
    whole = seconds(lambda: at.respond(t, x))
    print(
        f"1,000 samples with derivatives by 4 parameters, spectrum included: {1e3 * whole:.1f} ms"
    )
    spectrum = seconds(lambda: model.spectrum(theta, (0.1, 300.0)))
    assert whole < 30 * spectrum


@pytest.mark.slow
@patient
def test_an_identification_costs_a_few_curves():
    """A thousand points of relaxation, with start, intervals and noise floor.

    A curve has its derivatives.
    """
    model = parse_model("fractional-maxwell")
    theta, t = np.array([400.0, 60.0, 0.5]), np.geomspace(0.01, 1000.0, 1000)
    scatter = 1.0 + 0.01 * np.random.default_rng(0).normal(size=len(t))
    test = TimeTest.of_relaxation(t, model.relaxation(theta, t) * scatter, "kPa")
    whole = seconds(lambda: identify(test, model))
    curve = seconds(lambda: model.in_time(theta, tolerance=1e-6).relaxation(t))
    print(
        f"identification from 1,000 points of relaxation: {1e3 * whole:.1f} ms, "
        f"one curve {1e3 * curve:.1f} ms"
    )
    assert whole < 100 * curve


@patient
def test_the_compliance_of_forty_lines_costs_a_few_eigenvalue_problems():
    """Of as many unknowns; seven by the middle way, sixteen by Newton's steps and bisection."""
    rng = np.random.default_rng(3)
    rates, weights = np.geomspace(1e-6, 1e6, 40), rng.uniform(0.5, 1.5, 40)
    slopes = np.zeros((40, 1))
    lines = Lines(rates, weights, slopes, slopes)
    of = Rational(np.array([1.0, 1.0, 0.0]), np.zeros((3, 1)), lines)
    matrix = rng.normal(size=(40, 40))
    matrix = matrix @ matrix.T

    def ten_times(task) -> float:
        return seconds(lambda: [task() for _ in range(10)])

    found, reference = ten_times(of.inverse), ten_times(lambda: np.linalg.eigvalsh(matrix))
    print(f"compliance of 40 lines: {1e2 * found:.2f} ms, {found / reference:.1f} of eigvalsh")
    assert found < MOST_EIGENVALUE_PROBLEMS * reference
