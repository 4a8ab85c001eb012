"""Spectral density of residuals near the test frequency: what noise does to a fitted harmonic."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from springpot.rheology.points import Complex, Real

PER_CYCLE = 16
"""Parts of a cycle over which residuals are summed."""
LONGEST = 1024
"""Cycles at the beginning of the part from which the density is read."""
FREEDOM = 40.0
"""Degrees of freedom that the band around omega holds where the record is long enough.

Sd within about 11 %.
"""
FEWEST = 6.0
NARROWEST, WIDEST = 1.25, 5.0
BELOW_NYQUIST = 0.45
"""Of the sampling frequency: at half of it residuals of both signs of the frequency fall together.
"""
LEAST_KEPT = 0.2
"""Share of a line's power that the fit must leave for it to be used."""
SLOPES = np.linspace(-2.0, 2.0, 33)


@dataclass(eq=False)
class LocalSpectrum:
    """Gathers residuals block by block, turned back by omega t and summed over parts of a cycle.

    Parameters
    ----------
    omega : float
        Angular frequency in rad/s.
    start, stop : float
        The part that is fitted, in seconds.
    size : int
        Number of columns of the fit.

    Notes
    -----
    The Fourier transform of those sums is the spectrum around omega, whatever the sampling. The
    columns of the fit are gathered in the same way: they tell how much of each line the fit itself
    has taken out of white noise. Lines are taken from the band omega / b to b omega, over which
    both white noise and a random walk (density proportional to omega^-2) have as mean density the
    one at omega; slower leftovers stay out of it.
    """

    omega: float
    start: float
    stop: float
    size: int
    sums: Complex = field(init=False)
    counts: Real = field(init=False)
    width: float = field(init=False)

    def __post_init__(self) -> None:
        # Of long records a beginning tells the noise as well, and memory stays the same.
        span = min(self.stop - self.start, LONGEST * 2 * np.pi / self.omega)
        bins = max(1, round(PER_CYCLE * span * self.omega / (2 * np.pi)))
        self.sums, self.counts = np.zeros((bins, 2 + self.size), dtype=complex), np.zeros(bins)
        self.width = span / bins

    def add(self, time: Real, left: Real, columns: Real) -> None:
        """Residuals (m, 2) and columns of the fit (m, size) at sorted times (m,)."""
        inside = slice(0, int(np.searchsorted(time, self.start + self.width * len(self.sums))))
        if inside.stop == 0:
            return
        # Rounding can lift a time just before the end into the next bin.
        which = np.minimum(
            ((time[inside] - self.start) / self.width).astype(int), len(self.sums) - 1
        )
        turned = np.concatenate([left[inside], columns[inside]], axis=1)
        turned = turned * np.exp(-1j * self.omega * (time[inside] - self.start))[:, None]
        bins, first = np.unique(which, return_index=True)
        self.sums[bins] += np.add.reduceat(turned, first, axis=0)
        self.counts += np.bincount(which, minlength=len(self.counts))

    def density(self, seen: Complex, inverse: Real, white: Real) -> tuple[Real, float]:
        """Variance per sample near omega and its degrees of freedom.

        Parameters
        ----------
        seen : ndarray of complex, shape (c, 2)
            Combinations of displacement and force whose variance is wanted; a complex factor turns
            the phase.
        inverse : ndarray, shape (size, size)
            Inverse normal matrix of the fit.
        white : ndarray, shape (2, 2)
            Residual covariance over all frequencies, which helps out where the band holds too few
            lines.

        Returns
        -------
        variance : ndarray, shape (c,)
            Of each combination; that of white noise is its ordinary one.
        freedom : float
            Degrees of freedom.
        """
        lines, kept, ratio = self._lines(inverse)
        # Nearest lines first: only as many as are needed, since noise is seldom of one level over
        # all frequencies.
        order = np.argsort(np.abs(np.log(ratio)), kind="stable")
        freedom = 2 * np.cumsum(kept[order])
        reach = np.exp(np.abs(np.log(ratio[order])))
        taken = order[(reach <= NARROWEST) | (freedom - 2 * kept[order] < FREEDOM)]
        power = np.abs(lines[taken] @ seen.T) ** 2 / self.counts.sum()
        near = _levelled(power, kept[taken], ratio[taken])
        everywhere = np.einsum("ci,ij,cj->c", seen, white, seen.conj()).real
        worth = float(np.sum(kept[taken]))
        # Of very short records too few lines are left: the variance over all frequencies stands in
        # for the rest.
        short = max(FEWEST / 2 - worth, 0.0)
        return np.maximum((near + short * everywhere) / (worth + short), 0.0), 2 * (worth + short)

    def _lines(self, inverse: Real) -> tuple[Complex, Real, Real]:
        """Lines (k, 2) in the widest band, share of white noise left in each, omega_k / omega."""
        bins = len(self.sums)
        spectrum = np.fft.fft(self.sums, axis=0)
        ratio = 1 + np.fft.fftfreq(bins, self.width) * 2 * np.pi / self.omega
        per_cycle = self.counts.sum() / (bins * self.width) * 2 * np.pi / self.omega
        band = (
            (ratio >= 1 / WIDEST)
            & (ratio <= min(WIDEST, BELOW_NYQUIST * per_cycle))
            & (np.arange(bins) > 0)
        )
        # What the fit has taken out of each line is put back: the harmonics would else make the
        # noise look smaller.
        fitted = spectrum[band, 2:]
        leverage = np.einsum("ki,ij,kj->k", fitted.conj(), inverse, fitted).real / self.counts.sum()
        kept = np.clip(1 - leverage, 0.0, 1.0)
        # A line that the fit took out almost whole holds only rounding and the harmonics' own
        # errors.
        solid = kept > LEAST_KEPT
        return spectrum[band, :2][solid], kept[solid], ratio[band][solid]


def _levelled(power: Real, kept: Real, ratio: Real) -> Real:
    """Sums over the lines of power (k, c), each raised or lowered to what it would be at omega.

    (c,).

    By the power law that suits each column best: Whittle's likelihood of density proportional to
    ratio^-slope, its level profiled out, with a normal prior of standard deviation one on the slope
    (white noise has slope 0, a random walk 2).
    """
    levels = np.maximum(power.T @ ratio[:, None] ** SLOPES, np.finfo(float).tiny)
    misfit = np.sum(kept) * np.log(levels) - (kept @ np.log(ratio)) * SLOPES + 0.5 * SLOPES**2
    return np.asarray(levels[np.arange(len(levels)), np.argmin(misfit, axis=1)])
