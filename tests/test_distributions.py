"""The distributions are those of scipy.stats, which is only too slow to import."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy import stats

from springpot import distributions as own

X = np.array([1e-3, 0.3, 1.0, 4.0, 40.0, 300.0])
P = np.array([1e-6, 0.01, 0.5, 0.99, 1.0 - 1e-6])


@pytest.mark.parametrize("dof", [1, 2, 7.5, 200])
def test_chi_square(dof):
    np.testing.assert_allclose(own.chi2_sf(X, dof), stats.chi2.sf(X, dof), rtol=1e-12)
    np.testing.assert_allclose(own.chi2_quantile(P, dof), stats.chi2.ppf(P, dof), rtol=1e-10)


@pytest.mark.parametrize(("first", "second"), [(2, 1e6), (2, 3.0), (5.5, 12.25), (40, 300)])
def test_ratios_of_variances(first, second):
    np.testing.assert_allclose(own.f_sf(X, first, second), stats.f.sf(X, first, second), rtol=1e-10)
    np.testing.assert_allclose(
        own.f_quantile(P, first, second), stats.f.ppf(P, first, second), rtol=1e-9
    )
    found = own.f_log_density(X, first, second)
    np.testing.assert_allclose(found, stats.f.logpdf(X, first, second), rtol=1e-8, atol=1e-7)


def test_gamma_and_normal():
    np.testing.assert_allclose(own.gamma_sf(X, 3.0), stats.gamma.sf(X, 3.0), rtol=1e-12)
    np.testing.assert_allclose(own.normal_quantile(P), stats.norm.ppf(P), rtol=1e-12)
    np.testing.assert_allclose(own.normal_sf(X[:4]), stats.norm.sf(X[:4]), rtol=1e-12)


@pytest.mark.soak
def test_a_diagnosis_does_without_the_slow_import():
    script = (
        "import sys, springpot; springpot.diagnose('artificial-hidden', 'fractional-maxwell'); "
        "print('scipy.stats' in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"


@pytest.mark.soak
def test_a_sum_of_f_ratios_of_different_freedom_has_the_chance_that_it_has():
    """Drawn: terms of few and of many degrees of freedom, each with a variance of its own."""
    rng = np.random.default_rng(0)
    k, nu = np.array([3.0, 8.0, 12.0, 5.0]), np.array([6.0, 16.0, 10.0, 30.0])
    above, below = rng.chisquare(k, (20000, 4)), rng.chisquare(nu, (20000, 4)) / nu
    chances = np.array([own.f_sum_sf(value, k, nu) for value in (above / below).sum(axis=1)])
    for level in (0.01, 0.05, 0.2, 0.5):
        assert np.mean(chances < level) == pytest.approx(level, rel=0.2)


def test_one_f_ratio_is_a_sum_of_one():
    for value in (0.5, 1.0, 3.0):
        one = own.f_sum_sf(4.0 * value, np.array([4.0]), np.array([9.0]))
        assert one == pytest.approx(own.f_sf(value, 4.0, 9.0), rel=1e-12)


def test_a_sum_of_squares_of_known_variances_follows_chi_square():
    """Its spread is then that of a chi-square, of which an F has no end below."""
    k, nu = np.array([4.0]), np.array([1e100])
    assert own.f_sum_sf(9.487729, k, nu) == pytest.approx(0.05, rel=1e-6)
    assert own.f_sum_sf(4.0 * 2.866081, k, np.array([20.0])) == pytest.approx(0.05, rel=1e-3)
