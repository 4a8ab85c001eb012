"""Least squares of offset, drift, harmonics and transient to two channels, block by block.

Equations (36) to (41) of the paper. The spectral density of the residuals near the test frequency
tells what noise does to a fitted harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from springpot.rheology.points import Complex, Real

from .steady import MendedSignals

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
    deviance = np.sum(kept) * np.log(levels) - (kept @ np.log(ratio)) * SLOPES
    likeliest = np.argmin(deviance + 0.5 * SLOPES**2, axis=1)
    return np.asarray(levels[np.arange(len(levels)), likeliest])


GONE = 80.0
"""Time constants after which a transient is below rounding."""
GROUPS = 64
"""Whole cycles are gathered into at most this many groups, each fitted by itself as well."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Offset, drift, the cosines and sines of the harmonics, and a decaying transient.

    Parameters
    ----------
    omega : float
        Angular frequency in rad/s.
    start, stop : float
        The part of the record that is fitted, in seconds.
    harmonics : int
        How many harmonics.
    transient : float
        Time constant in seconds of a transient that decays from `start` on; 0 for none.
    """

    omega: float
    start: float
    stop: float
    harmonics: int
    transient: float = 0.0

    @property
    def size(self) -> int:
        """Number of columns."""
        return 2 + 2 * self.harmonics + 2 * (self.transient > 0)

    @property
    def slow(self) -> list[int]:
        """Columns of drift and transient, which belong to the part as a whole."""
        return [1, *range(2 + 2 * self.harmonics, self.size)]

    def columns(self, time: Real) -> Real:
        """Columns of the fit at the times (m,), shape (m, size).

        1, drift, cos 1, sin 1, cos 2, ..., transient and its change with the time constant.
        """
        # From the middle of the part: level, drift and phase then hardly depend on one another.
        middle, half = 0.5 * (self.start + self.stop), 0.5 * (self.stop - self.start)
        # Powers of one turn: a cosine and a sine for each harmonic would cost as many times more.
        turns = np.exp(1j * self.omega * (time - middle))
        powers = np.cumprod(np.broadcast_to(turns[:, None], (len(time), self.harmonics)), axis=1)
        flat = powers.view(np.float64)
        parts = [np.ones((len(time), 1)), ((time - middle) / half)[:, None], flat]
        if self.transient > 0:
            age = np.minimum((time - self.start) / self.transient, GONE)[:, None]
            # The second makes the fit linear in a small change of the time constant, which thus
            # need not be exact.
            parts += [np.exp(-age), age * np.exp(-age)]
        return np.concatenate(parts, axis=1)

    def frequency_column(self, columns: Real, coefficients: Real) -> Real:
        """Derivative (m,) of the fitted signal by omega, for one channel's coefficients (size,)."""
        half = 0.5 * (self.stop - self.start)
        order = np.arange(1, self.harmonics + 1)
        cosines, sines = slice(2, 2 + 2 * self.harmonics, 2), slice(3, 2 + 2 * self.harmonics, 2)
        turned = columns[:, cosines] @ (order * coefficients[sines]) - columns[:, sines] @ (
            order * coefficients[cosines]
        )
        # The drift column times half the length is the time from the middle.
        return np.asarray(half * columns[:, 1] * turned)


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """Harmonics of both channels with their covariance.

    Parameters
    ----------
    amplitude : ndarray of complex, shape (2, h)
        Complex amplitudes X of displacement and force: the signal is Re X exp(i h omega t), X = q_c
        - i q_s.
    level, drift : ndarray, shape (2,)
        Mean, and its change from the middle to the end.
    inverse : ndarray, shape (2, 2)
        Inverse normal matrix of the first cosine and sine.
    noise : ndarray, shape (3,)
        Variance per sample near omega, see `LocalSpectrum`: of displacement, of force, and of what
        moves the stiffness K, the force less K times the displacement.
    freedom : float
        Its degrees of freedom.
    residual : ndarray, shape (2,)
        Root mean square of the residuals.
    groups : ndarray of complex, shape (g, 2)
        First-harmonic amplitudes of groups of whole cycles.
    begins : ndarray, shape (g,)
        When each group begins, in seconds.
    samples : int
        Complete samples in the part.
    """

    amplitude: Complex
    level: Real
    drift: Real
    inverse: Real
    noise: Real
    freedom: float
    residual: Real
    groups: Complex
    begins: Real
    samples: int


def refined_frequency(record: MendedSignals, basis: Basis, rounds: int = 10) -> tuple[Basis, float]:
    """The basis at the best-fitting frequency, and that frequency's standard deviation.

    Variable projection: the harmonics are linear, so that only omega is iterated (Gauss-Newton).
    """
    # Of the displacement alone: it is what was imposed, and has the cleaner frequency.
    coefficients = _solve(*_moments(record, basis, None))[:, 0]
    width, variance = 1.0 / (basis.stop - basis.start), 0.0
    for _ in range(rounds):
        normal, right, square, count = _moments(record, basis, coefficients)
        solution = _solve(normal, right, square, count)[:, 0]
        # A longer step would leave the peak: beyond one over the length another one begins.
        coefficients, step = solution[:-1], float(np.clip(solution[-1], -width, width))
        # What is left of the squares, without a second pass through the record.
        squares = max(float(square[0, 0] - solution @ right[:, 0]), 0.0)
        left = squares / max(count - len(solution), 1)
        # Rounding alone may turn the sign, where the frequency is next to undetermined.
        variance = left * max(float(np.linalg.pinv(normal)[-1, -1]), 0.0)
        basis = replace(basis, omega=basis.omega + step)
        # Well within its own standard deviation no step is worth another round.
        if abs(step) < max(1e-10 * width, 1e-3 * np.sqrt(variance)):
            break
    return basis, float(np.sqrt(variance))


def _moments(
    record: MendedSignals, basis: Basis, coefficients: Real | None
) -> tuple[Real, Real, Real, int]:
    """Normal matrix, right-hand sides, squares and count over the part."""
    size = basis.size + (coefficients is not None)
    normal, right, square, count = np.zeros((size, size)), np.zeros((size, 2)), np.zeros((2, 2)), 0
    for time, both in record.blocks(basis.start, basis.stop):
        columns = basis.columns(time)
        if coefficients is not None:
            columns = np.column_stack([columns, basis.frequency_column(columns, coefficients)])
        # Sums alone are kept, so that a record of any length is read in blocks.
        normal += columns.T @ columns
        right += columns.T @ both
        square += both.T @ both
        count += len(time)
    return normal, right, square, count


def _solve(normal: Real, right: Real, *_: object) -> Real:
    # Columns of very different size (the frequency's grows with amplitude and duration) are scaled
    # first.
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    solution: Real = np.linalg.lstsq(
        normal / np.outer(scale, scale), right / scale[:, None], rcond=1e-13
    )[0]
    return solution / scale[:, None]


def fit_harmonics(record: MendedSignals, basis: Basis) -> HarmonicFit:
    """Least squares at a known frequency over the part that `basis` covers."""
    groups, period = _groups(basis)
    # Groups of cycles are fitted by themselves too: their scatter says what the residuals' spectrum
    # may miss.
    edges: Real = basis.start + period * np.arange(groups + 1, dtype=float)
    size = basis.size
    normal, right = np.zeros((groups, size, size)), np.zeros((groups, size, 2))
    for time, both in record.blocks(basis.start, basis.stop):
        columns = basis.columns(time)
        cuts = np.searchsorted(time, edges[1:-1]).tolist()
        for g, (low, high) in enumerate(zip([0, *cuts], [*cuts, len(time)], strict=True)):
            if high > low:
                normal[g] += columns[low:high].T @ columns[low:high]
                right[g] += columns[low:high].T @ both[low:high]
    total = normal.sum(axis=0)
    solution = _solve(total, right.sum(axis=0))
    # A group with a gap may hold fewer samples than unknowns.
    enough = normal[:, 0, 0] >= 2 * size
    inverse = _inverse(total)
    noise, freedom, residual, samples = _residuals(record, basis, solution, inverse)
    return HarmonicFit(
        amplitude=_amplitudes(solution[: 2 + 2 * basis.harmonics]),
        level=solution[0],
        drift=solution[1],
        inverse=inverse[2:4, 2:4],
        noise=noise,
        freedom=freedom,
        residual=residual,
        groups=_group_amplitudes(normal[enough], right[enough], basis, solution),
        begins=np.asarray(edges[:-1][enough], dtype=float),
        samples=samples,
    )


def _groups(basis: Basis) -> tuple[int, float]:
    # Each group holds a whole cycle at least: less than that hardly tells cosine, sine and mean
    # apart.
    cycles = max(1, int((basis.stop - basis.start) * basis.omega / (2 * np.pi) + 0.05))
    groups = min(cycles, GROUPS)
    return groups, (basis.stop - basis.start) / groups


def _amplitudes(solution: Real) -> Complex:
    """Complex amplitudes (2, h) from coefficients (size, 2)."""
    return np.asarray((solution[2::2] - 1j * solution[3::2]).T)


def _inverse(normal: Real) -> Real:
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    return np.asarray(
        np.linalg.pinv(normal / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    )


def _group_amplitudes(normal: Real, right: Real, basis: Basis, solution: Real) -> Complex:
    """First harmonics of each group, after the common drift and transient: (g, 2)."""
    # Drift and transient belong to the whole part: a few cycles cannot tell them from the
    # oscillation.
    keep, slow = np.r_[0, 2 : 2 + 2 * basis.harmonics], basis.slow
    right = right - normal[:, :, slow] @ solution[slow]
    pairs = [
        _solve(n[np.ix_(keep, keep)], r[keep])[1:3] for n, r in zip(normal, right, strict=True)
    ]
    stacked = np.reshape(pairs, (-1, 2, 2))
    return np.asarray(stacked[:, 0] - 1j * stacked[:, 1])


def _residuals(
    record: MendedSignals, basis: Basis, solution: Real, inverse: Real
) -> tuple[Real, float, Real, int]:
    """Variance near omega (3,) with its freedom, root mean squares (2,), number of samples."""
    square, count, local = (
        np.zeros((2, 2)),
        0,
        LocalSpectrum(basis.omega, basis.start, basis.stop, basis.size),
    )
    for time, both in record.blocks(basis.start, basis.stop):
        columns = basis.columns(time)
        left = both - columns @ solution
        square += left.T @ left
        count += len(time)
        local.add(time, left, columns)
    moved, force = _amplitudes(solution[:4])[:, 0]
    stiffness: complex = 0.0
    # A displacement that does not move has none; that is told where K is made of both.
    if moved:
        stiffness = force / moved
    # Noise of the displacement and of the force may come and go together: only u - K x counts for
    # K.
    seen = np.array([[1, 0], [0, 1], [-stiffness, 1]])
    noise, freedom = local.density(seen, inverse, square / max(count - basis.size, 1))
    return noise, freedom, np.sqrt(np.diag(square) / max(count, 1)), count
