"""The smoothest spectrum of a material that the data allow, with a band.

The lines of a least-squares spectrum are as sharp as noise makes them; the smooth one among the
spectra that follow the data as well tells more. Tikhonov regularisation with H >= 0 (Honerkamp and
Weese 1989, Macromolecules 22, 4372; Takeh and Shanbhag 2013, Appl. Rheol. 23, 24628): the squared
second differences of H / |K| along ln r join the misfit. The rule for their weight is the
discrepancy principle (Morozov 1966): the largest one whose misfit noise alone explains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import ends_of_draws
from springpot.errors import ModelError
from springpot.numerics import ALIKE, BEYOND, DECADE, non_negative
from springpot.rheology.elements import Continuum, Probe
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Points, Real
from springpot.thresholds import INTERVAL

from .material import is_material
from .native import Fit
from .problem import weighted

PER_DECADE = 8
"""Lines a decade: closer than the eye tells apart, and far closer than data can."""
DRAWS = 100
"""Simulated measurements behind the band: its ends are then uncertain by a sixth of its width."""
WEAKEST, STRONGEST = -12.0, 8.0
"""Decades of the weight of smoothness, in units of the noise's variance, that are searched."""
HALVINGS = 14
"""Of that range: the weight is found to 1e-3 decades."""


@dataclass(frozen=True, eq=False)
class SmoothSpectrum:
    """A regularised relaxation spectrum: K = K_e + c s + integral H(r) s / (s + r) dln r.

    Attributes
    ----------
    rates : ndarray, shape (m,)
        Rates r in rad/s, evenly spaced in ln r.
    density : ndarray, shape (m,)
        H(r) >= 0, in the unit of K.
    low, high : ndarray, shape (m,)
        Ends of the 95 % band that noise makes; what smoothness takes from a sharp peak is not in
        it.
    equilibrium, viscosity : float
        K_e, in the unit of K, and c, in that unit times seconds.
    smoothing : float
        The weight of smoothness.
    seen : tuple of float
        Ends of the reduced frequencies [rad/s] that were measured: beyond them H is little more
        than a guess.
    """

    rates: Real
    density: Real
    low: Real
    high: Real
    equilibrium: float
    viscosity: float
    smoothing: float
    seen: tuple[float, float]

    @property
    def step(self) -> float:
        """Difference of ln r between neighbours.

        Density times step is the weight of a Maxwell element.
        """
        return float(np.log(self.rates[1] / self.rates[0]))

    def within(self, share: float) -> tuple[float, float]:
        """Rates between which so much of the relaxing stiffness lies, as much below as above."""
        # By shares from either side: what lies far out and is hardly there moves the ends little.
        total = np.cumsum(self.density)
        ends = np.interp(
            [0.5 - 0.5 * share, 0.5 + 0.5 * share], total / total[-1], np.log(self.rates)
        )
        return float(np.exp(ends[0])), float(np.exp(ends[1]))

    @property
    def peaks(self) -> NDArray[np.int64]:
        """Numbers of the lines at which H has a peak, the highest first.

        One that was measured and that the band bears out.
        """
        inside = np.flatnonzero((self.rates >= self.seen[0]) & (self.rates <= self.seen[1]))
        peaks = [i for i in inside[1:-1].tolist() if self._stands_out(i)]
        return np.array(sorted(peaks, key=lambda i: -self.density[i]), dtype=np.int64)

    def _stands_out(self, i: int) -> bool:
        """Whether H is a maximum at a line, surely above somewhere on the way to any higher one."""
        if self.density[i] < max(self.density[i - 1], self.density[i + 1]):
            return False
        higher = np.flatnonzero(self.density > self.density[i])
        valleys = [self.high[min(i, j) : max(i, j) + 1].min() for j in higher.tolist()]
        return bool(self.density[i] > 0.0) and all(valley < self.low[i] for valley in valleys)


def regularised(fit: Fit, rng: np.random.Generator, draws: int = DRAWS) -> SmoothSpectrum:
    """The smoothest spectrum that the data allow.

    Where a material stands behind effects these keep their parameters, and K is taken as linear in
    the weights about the fit.

    Parameters
    ----------
    fit : Fit
        Of a model whose spectrum the data choose.
    rng : numpy.random.Generator
        For the simulated noise behind the band.
    draws : int
        Simulated measurements.

    Raises
    ------
    ModelError
        If the model has no spectrum that data choose.
    """
    if not is_material(fit.model):
        raise ModelError(
            f"the spectrum of {fit.model.name} is that of its network: no data choose it"
        )
    system = _System.of(fit)
    # Found once, for the data: each draw of noise would else have a smoothness of its own in the
    # band.
    smoothing = system.smoothing()
    best = system.solve(smoothing, system.target)
    followed = system.columns @ best
    # About the smooth curve, not about the data, which hold one draw of the noise already.
    noise = np.sqrt(system.variance) * rng.standard_normal((draws, len(followed)))
    again = np.array([best, *(system.solve(smoothing, followed + each) for each in noise)])[:, 2:]
    low, high = ends_of_draws(again, INTERVAL)
    # No density lies below zero: the draws may all lie to one side of the curve that the band
    # belongs to.
    low, high = np.minimum(low, best[2:]), np.maximum(high, best[2:])
    ends = float(best[0]), float(best[1])
    return SmoothSpectrum(system.rates, best[2:], low, high, *ends, smoothing, system.seen)


@dataclass(frozen=True, eq=False)
class _System:
    """The linear problem: K_e, c and H at the rates against whitened data.

    Attributes
    ----------
    rates : ndarray, shape (m,)
        In rad/s.
    columns : ndarray, shape (k, 2 + m)
        Derivative of the whitened K by K_e, c and H, in coordinates of the plane that these span.
    target : ndarray, shape (k,)
        Whitened data, as seen in that plane.
    least, most : float
        Sum of squares of the data outside it, and that which noise leaves.
    roughness : ndarray, shape (m, 2 + m)
        Second differences of H / |K|, H being zero beyond the ends.
    variance : float
        Of the noise of the whitened data, from what the least-squares spectrum leaves.
    seen : tuple of float
        Ends of the reduced frequencies, in rad/s.
    """

    rates: Real
    columns: Real
    target: Real
    least: float
    most: float
    roughness: Real
    variance: float
    seen: tuple[float, float]

    @classmethod
    def of(cls, fit: Fit) -> _System:
        """The problem about a least-squares spectrum."""
        material, points, data = (
            fit.model.material,
            fit.measurement.points,
            fit.measurement.stiffness,
        )
        count = len(material.parameters)
        lines, own = fit.theta[:count], fit.theta[count:]
        step = DECADE / PER_DECADE
        low, high = reduced_range(fit.model, fit.theta, points)
        beyond = float(np.log(BEYOND))
        log_rates = np.arange(low - beyond, high + beyond + step, step)
        assert isinstance(material, Continuum)
        # Beside the lines of the fit new ones without weight, by which K changes as it would by
        # their density.
        both = replace(
            fit.model, material=Continuum((*material.rates, *np.exp(log_rates).tolist()))
        )
        theta = np.concatenate([lines, np.zeros(len(log_rates)), own])
        response = both.network.respond(theta, points, GRADIENT)
        weights = _weights(fit)
        slopes = weighted(response.by_theta[: count + len(log_rates)], weights)
        # K is linear in the weights: what the lines of the fit explain is put back, to be explained
        # anew.
        target = weighted(data - response.value, weights) + lines @ slopes[:count]
        columns = np.concatenate([slopes[:2], step * slopes[count:]]).T
        size = np.abs(material.respond(lines, Points(log_rates)).value)
        # Where a channel counts the other way no line has weight, and K is nowhere.
        size[size == 0.0] = np.mean(np.abs(data))
        rounding = weighted(ALIKE * data, weights)
        variance = max(fit.cost / max(fit.dof, 1), float(np.mean(rounding**2)))
        # Reduced once to as many rows as columns, because every halving and every draw solves it
        # again.
        basis, columns = np.linalg.qr(columns)
        inside = basis.T @ target
        outside = target - basis @ inside
        least, most = float(outside @ outside), variance * len(target)
        rough, seen = _roughness(size, step), (float(np.exp(low)), float(np.exp(high)))
        return cls(np.exp(log_rates), columns, inside, least, most, rough, variance, seen)

    def solve(self, smoothing: float, target: Real) -> Real:
        """K_e, c and H (2 + m,), none below zero."""
        rows = np.concatenate([self.columns, np.sqrt(smoothing * self.variance) * self.roughness])
        return non_negative(rows, np.concatenate([target, np.zeros(len(self.roughness))]))[0]

    def smoothing(self) -> float:
        """The largest weight of smoothness whose misfit is no more than noise.

        As many variances as there are data.

        A least-squares spectrum leaves less, as much less as its lines follow of the noise.
        """
        low, high = WEAKEST, STRONGEST
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            off = self.target - self.columns @ self.solve(10.0**middle, self.target)
            # As much smoothing as the data bear without being missed by more than noise.
            if float(off @ off) + self.least <= self.most:
                low = middle
            else:
                high = middle
        return float(10.0**low)


def _weights(fit: Fit) -> Complex:
    """Weights (n,) of K' and K''; of a logarithmic objective those relative to |K|."""
    weights = np.asarray(fit.objective.weighing(fit.measurement), dtype=np.complex128)
    if fit.objective.logarithmic:
        return weights / fit.measurement.magnitude
    return weights


def _roughness(size: Real, step: float) -> Real:
    """Second differences (m, 2 + m) of H over a size (m,), without K_e and c.

    H is zero beyond the ends.
    """
    count = len(size)
    # The integral of the squared second derivative, so that finer lines ask for no other weight.
    bent = -2.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    return np.concatenate([np.zeros((count, 2)), bent / size / step**1.5], axis=1)


def reduced_range(fitted: Model, theta: Real, points: Points) -> tuple[float, float]:
    """Least and largest logarithm of the reduced frequencies that reach a fitted material."""
    probe = Probe([])
    own = theta[len(fitted.material.parameters) :]
    with np.errstate(all="ignore"):
        replace(fitted, material=probe).network.respond(own, points)
    return min(seen[0] for seen in probe.seen), max(seen[1] for seen in probe.seen)
