"""What was imposed along a course that is smooth and not steady, without its noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from math import comb, log
from typing import Any

import numpy as np

from springpot.rheology.points import Real

from ..numerics import DIFFERENCE, NEGLIGIBLE, PRINTED, SMALLEST, rms
from .imposed import ORDER, SHORTEST, Loading, imposed_noise, is_white
from .rounding import is_even
from .steady_start import goes_with

BENDS = 4
"""Differences of a course that are as good as noise: those that a mass feels are two less."""


def smoothed(loading: Loading, response: Real) -> tuple[Loading, dict[str, str]]:
    """A motion that is smooth without white noise that nothing answers to, and a note on it.

    What is left is its expectation, given what was read: a fit to that is not bent by the noise, as
    one to what was read is (regression calibration: Carroll, Ruppert, Stefanski and Crainiceanu
    2006, Measurement Error in Nonlinear Models, chapter 4).

    Parameters
    ----------
    loading : Loading
        As it was recorded.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, np.random.default_rng(1).normal(size=(2, 400))
    >>> moved = np.sin(t**2)
    >>> read = Loading(t, moved + 0.01 * noise[0], sampled=True)
    >>> course, _ = smoothed(read, 2.0 * moved + 0.02 * noise[1])
    >>> float(np.std(course.value - moved).round(3))
    0.002
    """
    value = loading.value
    few = len(value) < SHORTEST * BENDS
    if few or not loading.sampled or loading.before or not is_even(loading.time):
        return loading, {}
    rough = imposed_noise(value)
    # Of a sine of three samples two thirds of what half the order leaves; of noise as much.
    if rough <= max(0.5 * imposed_noise(value, ORDER // 2), NEGLIGIBLE * rms(value)):
        return loading, {}
    spline = likeliest(value)
    course, answer = spline.course(value), spline.course(response)
    left, rest = value - course, response - answer
    noise = float(np.std(left))
    if not is_white(left):
        return loading, {}
    stiffness = float(np.std(answer)) / max(float(np.std(course)), SMALLEST)
    if goes_with(rest, left, stiffness):
        return loading, {}
    share = 100.0 * noise / rms(course)
    says = f"smooth, with {share:.2g} % of white noise that nothing answers to: taken off"
    return replace(loading, value=course, unfelt=(noise, spline.freedom)), {"motion": says}


def answer_to_unfelt(loading: Loading, response: Real) -> Real:
    """Variance (n,) of what is answered to the error of a smooth course, by its cosine transform.

    The course has that part of the noise which so many numbers follow. That is answered to as the
    response (n,) goes with place, speed and acceleration, also where the course itself is gone.
    """
    (noise, numbers), course = loading.unfelt, loading.recorded.value
    turns = np.pi * np.arange(len(course)) / len(course)
    inner = course[1:-1]
    speed, push = 0.5 * (course[2:] - course[:-2]), course[2:] - 2.0 * inner + course[:-2]
    columns = np.column_stack([inner, speed, push, np.ones_like(inner)])
    spring, dashpot, mass, _ = np.linalg.lstsq(columns, response[1:-1], rcond=None)[0]
    squares = (spring - mass * (2.0 - 2.0 * np.cos(turns))) ** 2 + (dashpot * np.sin(turns)) ** 2
    return np.asarray((noise * _passed(len(course), numbers)) ** 2 * squares, dtype=np.float64)


def followed(loading: Loading, noise: Real) -> Real:
    """What a course has of noise (n,) in the motion: all of what was not taken off.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(size=400)
    >>> float(np.std(followed(Loading(noise, noise, unfelt=(1.0, 40.0)), noise)).round(1))
    0.3
    """
    from scipy.fft import dct, idct

    if not loading.unfelt[1]:
        return noise
    passed = _passed(len(noise), loading.unfelt[1])
    return np.asarray(idct(passed * dct(noise, norm="ortho"), norm="ortho"))


def _passed(count: int, numbers: float) -> Real:
    """Share (n,) of a cosine transform that a spline of so many numbers follows."""
    return np.asarray(1.0 / (1.0 + (np.arange(count) / numbers) ** (2 * BENDS)))


@dataclass(frozen=True, eq=False)
class Spline:
    """A penalised spline of samples that are evenly apart.

    Its coefficients' differences are white noise, of the variance that samples have over `weight`
    (Eilers and Marx 1996, doi:10.1214/ss/1038425655).

    Parameters
    ----------
    count, apart : int
        Samples, and how many of them two knots are apart.
    weight : float
        Of the squares of the differences of its coefficients.
    """

    count: int
    apart: int
    weight: float

    @cached_property
    def _columns(self) -> Any:
        return _columns(self.count, self.apart)

    @cached_property
    def _factor(self) -> Real:
        from scipy.linalg import cholesky_banded

        bands = self._columns[1]
        return np.asarray(cholesky_banded(bands[0] + self.weight * bands[1], lower=True))

    def coefficients(self, value: Real) -> Real:
        """Those (p,) of values (n,)."""
        from scipy.linalg import cho_solve_banded

        return np.asarray(cho_solve_banded((self._factor, True), self._columns[0].T @ value))

    def course(self, value: Real) -> Real:
        """The spline at the samples (n,), of values there."""
        return np.asarray(self._columns[0] @ self.coefficients(value))

    def improbability(self, value: Real) -> float:
        """Minus twice the logarithm of the likelihood of values (n,), but for a constant.

        Free of the polynomials that are not penalised (Patterson and Thompson 1971).
        """
        found = self.coefficients(value)
        squares = float(np.sum((value - self._columns[0] @ found) ** 2))
        squares += self.weight * float(np.sum(np.diff(found, BENDS) ** 2))
        spare = self.count - BENDS
        size = spare * log(max(squares, SMALLEST) / spare)
        size += 2.0 * float(np.sum(np.log(self._factor[0])))
        return size - (len(found) - BENDS) * log(self.weight)

    @property
    def freedom(self) -> float:
        """Numbers that it is worth: the trace of what makes it of the values."""
        more = replace(self, weight=self.weight * (1.0 + DIFFERENCE))
        rise = 2.0 * float(np.sum(np.log(more._factor[0] / self._factor[0])))
        return float(self._factor.shape[1] - rise / DIFFERENCE)


@lru_cache(maxsize=2)
def _columns(count: int, apart: int) -> tuple[Any, Real]:
    """B-splines (n, p) at samples, and the bands (2, 2 BENDS, p) of what squares come to.

    Those of the values, and those of the differences of coefficients.
    """
    from scipy.interpolate import BSpline

    degree = 2 * BENDS - 1
    size = (count - 2) // apart + 1 + degree
    at = np.arange(count) / apart
    columns = BSpline.design_matrix(at, np.arange(-degree, size + 1.0), degree)
    gram, bands = columns.T @ columns, np.zeros((2, degree + 1, size))
    for k in range(degree + 1):
        bands[0, k, : size - k] = gram.diagonal(k)
    factors = [(-1.0) ** i * comb(BENDS, i) for i in range(BENDS + 1)]
    for i, one in enumerate(factors):
        for k, other in enumerate(factors[i:]):
            bands[1, k, i : size - BENDS + i] += one * other
    return columns, bands


def likeliest(value: Real) -> Spline:
    """The spline of evenly sampled values (n,) by its likelihood.

    Its knots are as far apart as the likeliest one follows anything.

    Examples
    --------
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=400)
    >>> round(likeliest(np.sin(np.arange(400) / 10.0) + noise).freedom)
    52
    """
    from scipy.optimize import minimize_scalar

    apart, far = 1, 2
    while far > 1:
        tried = partial(Spline, len(value), apart)
        best = minimize_scalar(
            lambda size, tried=tried: tried(np.exp(size)).improbability(value),
            bounds=(log(NEGLIGIBLE), -log(NEGLIGIBLE)),
            method="bounded",
            options={"xatol": PRINTED},
        )
        found = tried(float(np.exp(best.x)))
        # A weight goes with the distance of two knots to the power of what is penalised.
        far = int(found.weight ** (0.5 / BENDS))
        if BENDS * far * apart >= len(value):
            break
        apart *= far
    return found
