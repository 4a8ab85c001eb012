"""A Prony series of as few terms as a tolerance on a band needs, and an isotropic solid from it.

Solvers take such a series instead of a fractional model. One measured modulus leaves a second one
open. Either Poisson's ratio stays constant, and all moduli relax in proportion, or the bulk modulus
does, as that of rubber nearly does (Tschoegl, Knauss & Emri 2002, doi:10.1023/A:1014411503170).
With a constant bulk modulus the shear modulus of a tensile test follows from 1 / E(s) = 1 / (3
G(s)) + 1 / (9 K) at every s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.units import MODULUS_WORDS
from springpot.numerics import FAR, REWEIGHTINGS, SMALLEST, non_negative
from springpot.rheology.points import Complex, Real, real_form
from springpot.rheology.rational import Rational
from springpot.rheology.spectrum import MOST_TERMS, Spectrum

IN_VAIN = 6
"""Terms that do not help after which no more are tried.

One in every third of a decade of a band of two.
"""
WORTH = 0.9
"""Share of the error that a term must leave at most to have helped.

Of a springpot each leaves a quarter.
"""
PER_DECADE = 16
"""Frequencies a decade at which the error is fitted and measured.

Beyond 12 it changes in the third digit only.
"""


@dataclass(frozen=True, eq=False)
class Prony:
    """K = equilibrium + viscosity s + sum of weights s tau / (1 + s tau), weights non-negative.

    Attributes
    ----------
    equilibrium, viscosity : float
        Long-term stiffness, and a dashpot beside it where one was asked for.
    weights, times : ndarray, shape (m,)
        Stiffness and relaxation time in s of each term, shortest time first.
    band : tuple of float
        Angular frequencies in rad/s between which it stands for the model.
    error : float
        Largest |dK| / |K| there.
    """

    equilibrium: float
    viscosity: float
    weights: Real
    times: Real
    band: tuple[float, float]
    error: float

    @property
    def instantaneous(self) -> float:
        """Stiffness at once, that of the dashpot apart."""
        return self.equilibrium + float(self.weights.sum())

    def stiffness(self, omega: Real | float) -> Complex:
        """Complex stiffness at omega in rad/s, shape (n,)."""
        s = 1j * np.atleast_1d(np.asarray(omega, dtype=float))
        turned = np.outer(s, self.times)
        terms: Complex = (turned / (1.0 + turned)) @ self.weights
        return self.equilibrium + self.viscosity * s + terms


def prony_of(
    spectrum: Spectrum,
    *,
    tolerance: float | None = None,
    terms: int | None = None,
    dashpot: bool = False,
    times: Real | None = None,
) -> Prony:
    """The Prony series of fewest terms within a tolerance, or the best one with a number of terms.

    Parameters
    ----------
    spectrum : Spectrum
        Of the model, for the band that is wanted.
    tolerance : float, optional
        Largest |dK| / |K| on the band; 0.5 % if neither is given.
    terms : int, optional
        Number of terms.
    dashpot : bool
        Whether a dashpot may stand beside the terms.
    times : ndarray, shape (m,), optional
        Relaxation times in s that are given; their weights follow by non-negative least squares.

    Returns
    -------
    Prony
        Two terms a decade hold 0.5 % of a springpot, three 0.03 %.

    Raises
    ------
    ModelError
        If the tolerance needs more terms than `MOST_TERMS` or no terms hold it, as those of a
        dashpot that may not stand beside them, or if their number is not 1 to `MOST_TERMS`.

    Examples
    --------
    >>> from springpot.rheology import Model, springpot
    >>> from springpot.solvers import prony_of
    >>> exact = Model("springpot", springpot()).spectrum([1.0, 0.5], (0.1, 10.0))
    >>> series = prony_of(exact, tolerance=0.01)
    >>> len(series.times), series.error < 0.01
    (4, True)
    """
    grid = _grid(spectrum.band)
    # Less its mass, which no series of relaxations can follow.
    target = spectrum.stiffness(np.exp(grid)) + spectrum.mass * np.exp(2.0 * grid)
    # A classical model is its own series: then nothing is fitted that is already known.
    exact = None if times is not None else _exact(spectrum, dashpot)
    through = _Through(grid, target, dashpot, spectrum.band, exact, spectrum.viscosity > 0.0)
    return through.series(tolerance, terms, times)


def prony_through(
    stiffness: Callable[[Real], Complex],
    band: tuple[float, float],
    *,
    tolerance: float | None = None,
    terms: int | None = None,
    dashpot: bool = False,
    times: Real | None = None,
) -> Prony:
    """The Prony series through a complex stiffness of which no spectrum is known.

    Such as that of a model at one amplitude; see `prony_of`.

    Parameters
    ----------
    stiffness : callable
        From angular frequencies (n,) in rad/s to K.
    band : tuple of float
        Angular frequencies in rad/s between which it is followed.
    tolerance, terms, dashpot, times
        As of `prony_of`.
    """
    grid = _grid(band)
    return _Through(grid, stiffness(np.exp(grid)), dashpot, band).series(tolerance, terms, times)


def _grid(band: tuple[float, float]) -> Real:
    low, high = np.log(band)
    return np.linspace(low, high, max(12, int(PER_DECADE * (high - low) / np.log(10.0))))


@dataclass(frozen=True, eq=False)
class _Through:
    """What a series is to follow: K (n,) at ln omega (n,), and the series where it is known."""

    grid: Real
    target: Complex
    dashpot: bool
    band: tuple[float, float]
    exact: Prony | None = None
    viscous: bool = False

    def series(self, tolerance: float | None, terms: int | None, times: Real | None) -> Prony:
        """With given times, with a number of terms, or with as few as a tolerance needs."""
        if times is not None:
            return at_times(self.grid, self.target, times, self.dashpot, self.band)
        if terms is not None and not 1 <= terms <= MOST_TERMS:
            raise ModelError(f"a Prony series has 1 to {MOST_TERMS} terms, not {terms}")
        wanted = 0.005 if tolerance is None else tolerance
        if terms is None and not 0.0 < wanted < 1.0:
            raise ModelError(f"a tolerance is a share of K above 0 and below 1, not {wanted:g}")
        if terms is None:
            return self._within(wanted)
        if self.exact and len(self.exact.times) <= terms:
            return self.exact
        return self._of(terms)

    def _of(self, count: int) -> Prony:
        return _fitted(self.grid, self.target, count, self.dashpot, self.band)

    def _within(self, wanted: float) -> Prony:
        """As few terms as the tolerance needs."""
        least, better = np.inf, 0
        # From one term up: a solver carries every term through all its steps.
        for count in range(1, MOST_TERMS + 1):
            if self.exact and len(self.exact.times) <= count:
                return self.exact
            series = self._of(count)
            if series.error <= wanted:
                return series
            if series.error < WORTH * least:
                least, better = series.error, count
            if count - better >= IN_VAIN and not self.exact:
                break
        if self.viscous and not self.dashpot:
            raise ModelError(
                f"terms alone follow its dashpot no nearer than {100 * least:.2g} %: let a dashpot"
                " stand beside them (--dashpot) where the format has one, or widen the tolerance"
            )
        raise ModelError(
            f"{count} terms hold {100 * least:.2g} %, not {100 * wanted:g} %: widen the tolerance"
            " or narrow the band"
        )


def _exact(spectrum: Spectrum, dashpot: bool) -> Prony | None:
    """The spectrum itself, where nothing in it but what a Prony series may have."""
    if spectrum.viscosity > 0.0 and not dashpot:
        return None
    order = np.argsort(-spectrum.rates)
    times, weights = 1.0 / spectrum.rates[order], spectrum.weights[order]
    return Prony(
        spectrum.equilibrium, spectrum.viscosity, weights, times, spectrum.band, spectrum.error
    )


def _fitted(
    grid: Real, target: Complex, count: int, dashpot: bool, band: tuple[float, float]
) -> Prony:
    """Times by least squares from even ones, weights inside it by non-negative least squares."""
    from scipy.optimize import least_squares

    # For given times the weights follow by linear least squares (variable projection): only times
    # are searched.
    s = 1j * np.exp(grid)
    lawson = np.ones(len(grid))
    width = (grid[-1] - grid[0]) / count
    # Evenly over the decades to begin with; the descent moves them.
    u = grid[0] + width * (np.arange(count) + 0.5)
    best: Prony | None = None
    for _ in range(REWEIGHTINGS):
        share = np.sqrt(lawson) / np.abs(target)

        # Its share is bound here, as the next round has another.
        def off(u: Real, share: Real = share) -> Real:
            amounts = _weights(s, u, target, share, dashpot)
            missed = share * (_columns(s, u, dashpot) @ amounts - target)
            return real_form(missed)

        reach = (grid[0] - FAR, grid[-1] + FAR)
        u = least_squares(off, u, bounds=reach, x_scale=0.3, xtol=1e-6, ftol=1e-6, max_nfev=40).x
        series, error = _series(s, u, target, share, dashpot, band)
        if best is None or series.error < best.error:
            best = series
        # Lawson: weights grow where the error is largest, so that least squares tend to the least
        # largest error.
        lawson = lawson * error / max(error.mean(), SMALLEST)
        # No point is let go altogether, or its error would grow unseen.
        lawson = np.maximum(lawson / lawson.mean(), 1e-3)
    assert best is not None
    # A solver would carry a term without weight through all its steps for nothing.
    kept = best.weights > 0.0
    return replace(best, weights=best.weights[kept], times=best.times[kept])


def _series(
    s: Complex,
    u: Real,
    target: Complex,
    share: Real,
    dashpot: bool,
    band: tuple[float, float],
) -> tuple[Prony, Real]:
    """The series with terms of these rates e^u (m,), and its relative error (n,)."""
    amounts = _weights(s, u, target, share, dashpot)
    error = np.abs(_columns(s, u, dashpot) @ amounts / target - 1.0)
    # By falling rates: the shortest time first.
    order = np.argsort(-u)
    viscosity = float(amounts[1]) if dashpot else 0.0
    weights, times = amounts[-len(u) :][order], np.exp(-u[order])
    return Prony(float(amounts[0]), viscosity, weights, times, band, float(error.max())), error


def at_times(
    grid: Real, target: Complex, times: Real, dashpot: bool, band: tuple[float, float]
) -> Prony:
    """The series of given times by non-negative least squares; those without weight stay too.

    Parameters
    ----------
    grid, target : ndarray, shape (n,)
        Natural logarithms of angular frequencies in rad/s, and K there.
    times : ndarray, shape (m,)
        In s.
    dashpot : bool
        Whether one may stand beside the terms.
    band : tuple of float
        Between which angular frequencies it stands for K.
    """
    times = np.sort(np.asarray(times, dtype=float))
    s, share = 1j * np.exp(grid), 1.0 / np.abs(target)
    series, _ = _series(s, -np.log(times), target, share, dashpot, band)
    return replace(series, times=times)


def _columns(s: Complex, u: Real, dashpot: bool) -> Complex:
    """K of each unit amount: spring, dashpot and terms."""
    head = [np.ones_like(s)]
    if dashpot:
        head.append(s)
    return np.column_stack([*head, s[:, None] / (s[:, None] + np.exp(u))])


def _weights(s: Complex, u: Real, target: Complex, share: Real, dashpot: bool) -> Real:
    # Over |K|, so that what counts is the relative error at each frequency.
    columns = share[:, None] * _columns(s, u, dashpot)
    return non_negative(real_form(columns), real_form(share * target))[0]


BULKS = ("constant", "relaxing")
RUBBERY = 0.45
"""Poisson's ratio above which the bulk modulus is taken to be constant, where nobody says."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Shear and bulk modulus of an isotropic solid.

    Attributes
    ----------
    shear, bulk : Prony
        The moduli in time; that of a constant bulk modulus has no terms.
    poisson : float
        Poisson's ratio at once; it is that at any time where both moduli relax in proportion.
    measured : {"G", "E", "K"}
        Which modulus was.
    constant : bool
        Whether the bulk modulus is.
    """

    shear: Prony
    bulk: Prony
    poisson: float
    measured: str
    constant: bool

    @property
    def young(self) -> float:
        """Young's modulus at once, E = 2 (1 + nu) G."""
        return 2.0 * (1.0 + self.poisson) * self.shear.instantaneous

    def poisson_beside(self, shear: float) -> float:
        """Poisson's ratio where the shear modulus has this value: (3 K - 2 G) / (6 K + 2 G)."""
        if not self.constant:
            return self.poisson
        bulk = self.bulk.equilibrium
        return (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)

    def shear_of(self, measured: Complex) -> Complex:
        """Complex shear modulus (n,) where the measured one is `measured` (n,)."""
        own, soft = _to_shear(self.measured, self.poisson, self.bulk.equilibrium, self.constant)
        return measured / (own + soft * measured)

    @property
    def says(self) -> str:
        """What was measured and what was taken for the rest, in one line."""
        bulk = "the bulk modulus relaxes as it does, with a constant Poisson's ratio"
        if self.constant:
            bulk = f"the bulk modulus is constant, {self.bulk.equilibrium:.9g}"
        return (
            f"told by the {MODULUS_WORDS[self.measured]};"
            f" Poisson's ratio {self.poisson:.6g} at once; {bulk}"
        )


def solid_of(prony: Prony, measured: str, poisson: float, bulk: str | None = None) -> Solid:
    """The solid whose measured modulus is this series.

    Parameters
    ----------
    prony : Prony
        Of the measured modulus, without a dashpot.
    measured : {"G", "E", "K"}
        Which one that is.
    poisson : float
        Poisson's ratio at once, above -1 and below 0.5.
    bulk : {"constant", "relaxing"}, optional
        What the bulk modulus does; constant above nu = 0.45 if nobody says, unless it was measured
        itself.

    Raises
    ------
    ModelError
        If a bulk modulus that was measured to relax is to be constant.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.solvers import Prony, solid_of
    >>> shear = Prony(1.0, 0.0, np.array([2.0]), np.array([0.1]), (1.0, 10.0), 0.0)
    >>> solid_of(shear, "G", 0.25).young
    7.5
    """
    constant = bulk == "constant"
    if bulk is None:
        constant = poisson > RUBBERY and measured != "K"
    if constant and measured == "K":
        raise ModelError("the bulk modulus was measured, and relaxes: give --bulk relaxing")
    whole = _share_of_shear(measured, poisson) * prony.instantaneous
    ratio = 2.0 * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson))
    shear = beside_a_spring(prony, *_to_shear(measured, poisson, ratio * whole, constant))
    none = np.zeros(0)
    volume = replace(prony, equilibrium=ratio * whole, weights=none, times=none)
    if not constant:
        volume = replace(
            shear, equilibrium=ratio * shear.equilibrium, weights=ratio * shear.weights
        )
    return Solid(shear, volume, poisson, measured, constant)


def young_of(solid: Solid) -> Prony:
    """The series of Young's modulus."""
    if not solid.constant:
        return beside_a_spring(solid.shear, 0.5 / (1.0 + solid.poisson), 0.0)
    return beside_a_spring(solid.shear, 1.0 / 3.0, 1.0 / (9.0 * solid.bulk.equilibrium))


def _share_of_shear(measured: str, poisson: float) -> float:
    """G over the measured modulus, of an elastic solid."""
    to_shear = {
        "G": 1.0,
        "E": 0.5 / (1.0 + poisson),
        "K": 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson),
    }
    return to_shear[measured]


def _to_shear(measured: str, poisson: float, bulk: float, constant: bool) -> tuple[float, float]:
    """The a and b of G = M / (a + b M) for the measured modulus M."""
    # 1 / G = 3 / E - 1 / (3 K).
    if constant and measured == "E":
        return 3.0, -1.0 / (3.0 * bulk)
    return 1.0 / _share_of_shear(measured, poisson), 0.0


def beside_a_spring(prony: Prony, own: float, soft: float) -> Prony:
    """The Prony series of M / (own + soft M), exactly, for the series M.

    A spring of 1 / soft in series with M / own.

    A negative `soft` takes such a spring away, which M must have in it. There are as many terms as
    before: one rate between each two of M, and one before the slowest (or beyond the fastest, where
    a spring is taken away).
    """
    equilibrium = prony.equilibrium / (own + soft * prony.equilibrium)
    if soft == 0.0 or not len(prony.times):
        return replace(prony, equilibrium=equilibrium, weights=prony.weights / own)
    if prony.viscosity:
        raise ModelError(
            "no series beside a dashpot is converted with a constant bulk modulus: give --bulk"
            " relaxing"
        )
    # As a compliance the spring of the bulk is one term more.
    series = Rational.known((prony.equilibrium, 0.0), 1.0 / prony.times, prony.weights)
    compliance = series.inverse().times(own, np.zeros(0))
    there = compliance.beside(Rational.power(0, soft, np.zeros(0))).inverse()
    rates, weights, *_ = there.lines
    return replace(prony, equilibrium=float(there.ends[0]), weights=weights, times=1.0 / rates)
