"""The native solver against a plain multi-start of SciPy's MINPACK, in the same run.

Ratios, never absolute times.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
from patience import patient

sys.path.insert(0, str(Path(__file__).parents[1] / "identification"))

from native_problems import OMEGA, POINTS, TRUTHS, noisy, random_truths, relative_weights, setup

from springpot.identification import fit, fit_batch
from springpot.measurement import Measurement

FOUR = ("fractional-kelvin4", "fractional-zener")


def multistart(model, data, rng, starts=20):
    """Least squares in log parameters from random starts in the paper's box, up to an exact fit."""
    from scipy.optimize import least_squares

    def residuals(u):
        error = (model.stiffness(np.exp(u), OMEGA) - data.stiffness) / data.magnitude
        return np.concatenate([error.real, error.imag])

    best = None
    for _ in range(starts):
        start = [
            rng.uniform(0.05, 1.0) if name == "alpha" else 1000.0 * rng.random()
            for name in model.names
        ]
        with np.errstate(all="ignore"):
            try:
                found = least_squares(
                    residuals, np.log(start), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15
                )
            except ValueError:
                continue
        best = found if best is None or found.cost < best.cost else best
        if best.cost < 1e-20:
            break
    return np.exp(best.x)


def seconds(call, repeats):
    """Median duration of `call`, which takes the number of the repeat."""
    spent = []
    for i in range(repeats):
        began = perf_counter()
        call(i)
        spent.append(perf_counter() - began)
    return float(np.median(spent))


@patient
def test_single_fits_take_less_time_than_scipy_from_random_starts():
    native, plain = {}, {}
    for name in TRUTHS:
        model, _, data = setup(name)
        native[name] = seconds(
            lambda i, m=model, d=data: fit(m, d, rng=np.random.default_rng(i)), 12
        )
        plain[name] = seconds(
            lambda i, m=model, d=data: multistart(m, d, np.random.default_rng(i)), 6
        )
    print(
        {name: (f"{1e3 * native[name]:.2f} ms", f"{1e3 * plain[name]:.2f} ms") for name in TRUTHS}
    )
    # The reference knows that the data are exact and stops at its first exact fit; it loses all the
    # same.
    assert sum(native.values()) < sum(plain.values())


@pytest.mark.soak
@pytest.mark.parametrize("name", FOUR)
@patient
def test_a_batch_is_ten_times_faster_and_succeeds_more_often(name, rng):
    model, theta, stiffness = random_truths(name, 1000, rng)
    few = 25
    began = perf_counter()
    found, _ = fit_batch(model, POINTS, stiffness, relative_weights(stiffness))
    native = (perf_counter() - began) / len(theta)
    data = [Measurement(OMEGA, row) for row in stiffness[:few]]
    began = perf_counter()
    plain = np.array([multistart(model, one, rng, starts=5) for one in data])
    reference = (perf_counter() - began) / few
    exact = np.max(np.abs(found / theta - 1.0), axis=1) < 1e-6
    assert native < 0.1 * reference
    assert exact.mean() >= 0.999
    assert exact.mean() >= np.mean(np.max(np.abs(plain / theta[:few] - 1.0), axis=1) < 1e-6)


@patient
def test_a_batch_costs_less_than_its_fits_one_by_one(rng):
    model, _, stiffness = random_truths("fractional-maxwell", 400, rng)
    measured = noisy(stiffness, 0.01, rng)
    began = perf_counter()
    fit_batch(model, POINTS, measured, relative_weights(measured))
    together = (perf_counter() - began) / len(measured)
    single = seconds(lambda i: fit(model, Measurement(OMEGA, measured[i])), 40)
    assert together < 0.3 * single


@pytest.mark.parametrize("name", FOUR)
def test_time_of_one_fit(benchmark, name):
    model, theta, data = setup(name)
    assert benchmark(fit, model, data).theta == pytest.approx(theta, rel=1e-6)


@pytest.mark.parametrize("name", FOUR)
def test_time_of_ten_thousand(benchmark, name, rng):
    count = 10_000 if benchmark.enabled else 100
    model, _, stiffness = random_truths(name, count, rng)
    benchmark.pedantic(fit_batch, (model, POINTS, stiffness, relative_weights(stiffness)), rounds=3)
