"""Finding the noise floor of a measurement together with a first fit of its model.

It is the scatter about slow curves, without ripples, drift and what stands out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import comb, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_quantile, f_quantile, f_sf, gamma_sf
from springpot.measurement import (
    Averaged,
    Measurement,
    Noise,
    Scatter,
    at_least_rounding,
    average_repeats,
    checked_noise,
    noise_of_repeats,
    noise_shape,
    plausible_variance,
    robust_noise_shape,
    rounded_log_omega,
    sweeps_of,
)
from springpot.policy import SCATTER, VERDICT
from springpot.rheology import Complex, Model, Real

from .frame import LEAST_SEEN, Frame, drift_shapes, orthonormal, spectrum, waves
from .refit import Refit, refit

STARTS = 16
"""Starts of a first fit, of whose parameters nothing is known."""
STARTS_AGAIN = 8
"""Starts beside the fit before, in units of another noise: where it is smaller, another minimum may be the least."""
STARTS_RESCALED = 4
"""The same where all of the noise was multiplied by one number, which leaves the minima where they are."""
STARTS_OF_A_ROUND = 2
"""The same where it only changed its shape."""
MOST_TURNS = 10
"""Times that the points which stand out are found anew; nearly all settle in three."""
FINE = 41
"""Periods tried between the neighbours of the strongest one."""
LEAST_WAVE = 1e-9
"""Singular value, beside the largest, below which a direction of a ripple is rounding."""
MOST_RIPPLES = 2
"""Periods that are taken out of the scatter; a third could follow noise."""
SLOWEST_RIPPLE = 16.0
"""Points of the longest period: longer waves are slow structure already."""
SLOW_WAVES = 2
"""Waves along a sweep up to which its polynomials of degree 5 are that structure, however many its points."""
FEWEST_FREE = 20.0
"""Degrees of freedom below which a period would take too many of them."""
NEARLY = 2.0
"""Error over noise floor up to which a model may be right, and its scatter tell where the noise is larger."""
LEAST_RISE = 0.01
"""Relative change of the noise over |K| along a sweep from which its shape is another than that of |K|."""
LEAST_LEFT = 0.1
"""Share of a point's variance that curves leave, from which the rest says anything of it."""
LEAST_KEPT = 0.7
"""Share of the data below which what is left out is no few frequencies any more."""
LEAST_FREE = 0.5
"""Share of the degrees of freedom that must stay, likewise: an estimate from half of them is uncertain by 1.4 x."""
ROUNDS = 2
"""Times that the noise is estimated anew about the fit that it gave."""
TRIMMED_FITS = 6
"""Fits without what stands out, each beside the last: of the notches tried nearly all settle in three."""
DIFFERENCES = (2, 3, 4, 5)
"""Orders of the differences: of a ripple of 8 points the second leave 59 % and the fifth 26 % of its size. Those of
order k are worth C(2k,k)^2 / C(4k,2k) degrees of freedom each, as neighbouring ones share points."""
ENOUGH_NEIGHBOURS = 10
"""Degrees of freedom below which second differences say too little."""
FEWEST_ABOUT_MODEL = 4
"""Degrees of freedom from which the scatter about a model says how large the noise is."""
LEAST_SPARE = 0.4
"""Share of the numbers that a model leaves over before its scatter says anything: of nine points a free spectrum, a
filter and a resonance follow the noise to a fiftieth of it."""


def fitted_to_floor(model: Model, measurement: Measurement, seeds: Sequence[Real] = ()) -> Refit:
    """Fit `model` to the averaged data, in units of a noise floor found on the way.

    Repeats tell the noise best; given standard deviations are checked against the data's own scatter; without
    either the scatter about slow curves is taken, which says at most how large the noise is.

    Parameters
    ----------
    model : Model
        The user's model; it need not be right.
    measurement : Measurement
        The data.
    seeds : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    """
    data = average_repeats(measurement)
    repeated = noise_of_repeats(data)
    # Before what was given: repeats are the only noise that no model and no structure can raise.
    if repeated is not None:
        return refit(model, data, repeated, seeds, starts=STARTS)
    if data.mean.sd is None:
        return _estimated(model, data, seeds)
    return _given(model, data, data.mean.sd, seeds)


def _given(model: Model, data: Averaged, sd: Complex, seeds: Sequence[Real]) -> Refit:
    # Scatter can only be told about some fit: that in units of what was given comes first.
    first = refit(model, data, Noise(sd, inf, "given"), seeds, starts=STARTS)
    noise = checked_noise(first.noise, *scatter_about(first.frame()))
    if noise is first.noise:
        return first
    # A notch drags the curve, and all else seems to scatter: that is no reason to doubt what was given.
    free, _ = undragged(first)
    noise = checked_noise(first.noise, *scatter_about(free.frame()))
    if noise is first.noise:
        return first
    return refit(model, data, noise, [first.theta], starts=STARTS_RESCALED)


def beyond_floor(found: Refit) -> bool:
    """Whether an error is beyond the noise floor by more than chance.

    The floor of an estimated noise leaves out the few frequencies that are far off, and simulated noise has their
    long tails too: no test sees them, and yet the model does not go through them.
    """
    ratio = found.relative_rms / found.floor
    # Floor and error are both uncertain, so F and not chi-square; of many points a slight excess is sure but small.
    chance = f_sf(ratio**2, found.fit.dof, found.noise.dof)
    return bool(ratio > VERDICT.misfit and chance < VERDICT.structure_alarm)


def is_arithmetic(found: Refit) -> bool:
    """Whether an error is that of arithmetic, on more points than anything would follow: the data were computed."""
    return found.relative_rms < VERDICT.arithmetic and len(found.fit.measurement) > VERDICT.fewest_spare


def is_hardly_known(found: Refit) -> bool:
    """Whether so few numbers are left over that neither the error nor the floor says anything.

    Of an estimate with three degrees of freedom an error of six floors is still no surprise.
    """
    return min(found.fit.dof, found.noise.dof) < VERDICT.fewest_spare


def as_given(base: Refit) -> Refit:
    """The fit in units of the given standard deviations, though they were doubted."""
    assert base.data.mean.sd is not None, "only what was given can be doubted"
    return refit(base.model, base.data, Noise(base.data.mean.sd, inf, "given"), [base.theta], starts=STARTS_AGAIN)


def borne_out(best: Refit) -> bool:
    """Whether the scatter about a good model is as large as its noise says."""
    variance, dof = scatter_about(best.frame())
    return variance < plausible_variance(dof)[1]


def _estimated(model: Model, data: Averaged, seeds: Sequence[Real]) -> Refit:
    size, everything = data.mean.magnitude, np.ones(len(data.mean), dtype=bool)
    # Proportional to |K| to begin with: both parts alike, and no frequency outweighs the others.
    first = refit(model, data, Noise(np.asarray(size + 1j * size), 1.0, "estimated"), seeds, starts=STARTS)
    usual = _in_rounds(model, data, first, uneven=False)
    # Beside a model that is far off its misfit would be taken for noise that rises where it fails.
    if usual.relative_rms > NEARLY * usual.floor:
        return usual
    # Before anything is set aside: where a rig is noisier at the ends of its range, these points are no outliers.
    shape = next(_shapes(first, data.mean, everything, uneven=True))
    relative = np.concatenate([shape.sd.real, shape.sd.imag]) / np.concatenate([size, size])
    if np.ptp(relative) < LEAST_RISE * np.min(relative):
        return usual
    return _in_rounds(model, data, refit(model, data, shape, [first.theta], starts=STARTS_OF_A_ROUND), uneven=True)


def _in_rounds(model: Model, data: Averaged, found: Refit, uneven: bool) -> Refit:
    """The fit in units of a noise that is estimated about it, in turns."""
    free, inside = found, np.ones(len(data.mean), dtype=bool)
    for _ in range(ROUNDS):
        # Each way says at most how large the noise is: the smaller one is the better bound.
        tried = [_scaled(model, data, shape, found) for shape in _shapes(free, data.mean, inside, uneven)]
        found, free, inside = min(tried, key=lambda one: data.floor(one[0].noise))
    return found


def _scaled(model: Model, data: Averaged, shape: Noise, before: Refit) -> tuple[Refit, Refit, NDArray[np.bool_]]:
    """The fit in units of a noise of this shape and of the size that the scatter gives it; see `undragged`."""
    shaped = refit(model, data, shape, [before.theta], starts=STARTS_OF_A_ROUND)
    # The shape first and then its size: what stands out is told beside a fit in units of the right shape.
    free, inside = undragged(shaped)
    variance, dof = scatter_about(free.frame())
    sd = at_least_rounding(float(np.sqrt(variance)) * shape.sd, data.mean)
    noise = replace(shape, sd=sd, dof=dof)
    # Of all points again: those that stand out are left out of the noise, not of the data.
    return refit(model, data, noise, [shaped.theta], starts=STARTS_OF_A_ROUND), free, inside


def undragged(fitted: Refit) -> tuple[Refit, NDArray[np.bool_]]:
    """The fit to what does not stand out, and which points (n,) that is.

    A notch or a bad point drags the curve, and all else then seems to scatter. Those that stand out are found anew
    beside the curve that is free of them (Rousseeuw 1984, least trimmed squares, doi:10.1080/01621459.1984.10477105).
    """
    n = len(fitted.fit.measurement)
    free, followed = fitted, np.ones(n, dtype=bool)
    inside = trimmed(fitted.frame()).kept[:n]
    for _ in range(TRIMMED_FITS):
        if np.array_equal(inside, followed):
            break
        free, followed = fitted.without(~inside), inside
        # The curve of the others at all points: one that was left out may come back in.
        of_all = replace(fitted, fit=replace(free.fit, measurement=fitted.fit.measurement))
        inside = trimmed(of_all.frame(), followed).kept[:n]
    return free, followed


def sharpened(base: Refit, best: Refit) -> Refit | None:
    """The base model fitted again in units of the scatter about a better model, where that is much smaller.

    Where conditions differ from point to point there are no smooth curves whose scatter could be taken, and the
    misfit of a wrong model passes for noise; the scatter about a model that explains it cannot.

    Parameters
    ----------
    base, best : Refit
        The user's model and the best grown one.

    Returns
    -------
    Refit or None
        None where the noise is not estimated, or nothing would change.
    """
    frame = best.frame()
    # Without slow curves: where conditions differ from point to point there are none.
    dof = frame.size - int(frame.absorbed.shape[1])
    if base.noise.source != "estimated" or dof < max(FEWEST_ABOUT_MODEL, LEAST_SPARE * frame.size):
        return None
    everything = np.ones(frame.size, dtype=bool)
    noise = _of_residual(best, Trimmed(frame.rest, everything, float(dof)))
    if base.data.floor(noise) > SCATTER.sharper * base.data.floor(base.noise):
        return None
    return refit(base.model, base.data, noise, [base.theta], starts=STARTS_AGAIN)


def _shapes(free: Refit, measurement: Measurement, inside: NDArray[np.bool_], uneven: bool) -> Iterator[Noise]:
    """Noise with the dependence on the point that the scatter about slow curves favours; its size comes later.

    Where a ripple or a drift is seen in that scatter, also without it: its storage and its loss would be taken for
    the sizes of the noise in both.

    Parameters
    ----------
    free : Refit
        The fit to the points that do not stand out.
    measurement : Measurement
        All points.
    inside : ndarray of bool, shape (n,)
        Those that do not.
    uneven : bool
        Whether the noise may be larger at an end of the frequencies, or of another size in each part.
    """
    frame, n = free.frame(), int(np.sum(inside))
    scatters = [frame.rough]
    left = trimmed(frame).left
    # Within rounding it is the same scatter, and a second fit of the same shape would cost time for nothing.
    if not np.allclose(left, frame.rough, atol=1e-6 * float(np.max(np.abs(frame.rough), initial=0.0))):
        scatters.append(left)
    # Curves bow to the ends of a sweep: what they leave there is less than the noise by as much as they follow.
    followed = np.sum(frame.absorbed**2, axis=1) + np.sum(frame.structured**2, axis=1)
    left_of_noise = np.sqrt(np.maximum(1.0 - followed, LEAST_LEFT))
    for scatter in scatters:
        scatter = scatter / left_of_noise
        rough = scatter[:n] / free.noise.weights.real + 1j * scatter[n:] / free.noise.weights.imag
        sd = at_least_rounding(robust_noise_shape(measurement, rough, inside, uneven), measurement)
        yield Noise(sd, float(max(frame.rough_dof, 1)), "estimated")


def _of_residual(found: Refit, scatter: Trimmed) -> Noise:
    """Noise of the shape and size of a whitened scatter; points set aside say nothing of it."""
    weights, n = found.noise.weights, len(scatter.left) // 2
    squares = np.where(scatter.kept, scatter.left, 0.0) ** 2
    each: Real = scatter.dof / float(np.sum(scatter.kept)) * scatter.kept.astype(np.float64)
    parts = Scatter(squares[:n] / weights.real**2, squares[n:] / weights.imag**2, each[:n])
    sd = at_least_rounding(noise_shape(found.data.mean, parts), found.data.mean)
    return Noise(sd, scatter.dof, "estimated")


class Trimmed(NamedTuple):
    """What slow curves leave of a residual, and the frequencies whose scatter is noise.

    Attributes
    ----------
    left : ndarray, shape (2n,)
        The residual without the curves, which are fitted to the kept rows alone.
    kept : ndarray of bool, shape (2n,)
        Rows that are kept.
    dof : float
        Degrees of freedom of what is left in them.
    """

    left: Real
    kept: NDArray[np.bool_]
    dof: float

    @property
    def variance(self) -> float:
        """Of the scatter."""
        return float(np.sum(self.left[self.kept] ** 2)) / self.dof


def trimmed(frame: Frame, kept: NDArray[np.bool_] | None = None) -> Trimmed:
    """The whitened scatter of a fit about slow curves, without the frequencies at which it is far larger.

    Parameters
    ----------
    frame : Frame
        The fit.
    kept : ndarray of bool, shape (n,), optional
        Rows known to be free of what stands out; without them the median over frequencies is the first guess.
    """
    followed = np.concatenate([frame.absorbed, frame.structured], axis=1)
    omega = frame.measurement.omega
    found = trimmed_residual(frame.residual, followed, omega, kept)
    # Only what chance does not explain is taken out: shapes chosen to follow noise make the floor too low.
    drift = frame.relative(drift_shapes(len(frame.measurement)))
    if found.dof >= FEWEST_FREE and _explains(drift, followed, found):
        followed = np.concatenate([followed, drift], axis=1)
        found = trimmed_residual(frame.residual, followed, omega)
    for _ in range(MOST_RIPPLES):
        if found.dof < FEWEST_FREE or (period := _ripple(frame, found)) == 0.0:
            break
        ripple = frame.relative(waves(frame.measurement, period))
        followed = np.concatenate([followed, ripple], axis=1)
        found = trimmed_residual(frame.residual, followed, omega)
    return found


def _explains(columns: Real, followed: Real, scatter: Trimmed) -> bool:
    """Whether columns explain more of a scatter than noise would, by the ratio of variances."""
    rows = scatter.kept
    inner = columns[rows] - followed[rows] @ np.linalg.lstsq(followed[rows], columns[rows], rcond=None)[0]
    kept = np.linalg.norm(inner, axis=0) > LEAST_SEEN * np.linalg.norm(columns[rows], axis=0)
    basis = orthonormal(inner[:, kept])
    # In one sweep of even steps drift is slow structure already: nothing of it is left to explain.
    spent = float(basis.shape[1])
    if spent == 0.0 or scatter.dof <= spent:
        return False
    explained = float(np.sum((basis.T @ scatter.left[rows]) ** 2))
    left = max(float(np.sum(scatter.left[rows] ** 2)) - explained, 1e-300)
    ratio = (explained / spent) / (left / (scatter.dof - spent))
    return bool(f_sf(ratio, spent, scatter.dof - spent) < SCATTER.ripple_alarm)


def _ripple(frame: Frame, scatter: Trimmed) -> float:
    """Period, in points, of a ripple that the scatter holds; zero where the strongest one may be chance.

    Of white noise the power at each of n independent frequencies is a sum of exponentials, one for each part of each
    sweep; a periodic error of the analysis or of a resonance of the chain is not (Fisher 1929,
    doi:10.1098/rspa.1929.0151).
    """
    left = np.where(scatter.kept, scatter.left, 0.0)
    power = spectrum(frame.measurement, left[None])[0]
    lines = 2 * len(sweeps_of(frame.measurement))
    longest = len(power) - 1
    # Slow waves are structure, and told of elsewhere. The spectrum counts in half waves along a sweep.
    first = min(int(np.ceil(2.0 * longest / SLOWEST_RIPPLE)), 2 * SLOW_WAVES)
    if first + 1 >= len(power):
        return 0.0
    peak = first + int(np.argmax(power[first:]))
    mean = float(np.sum(left**2)) / len(frame.measurement)
    # The strongest of so many periods is told: each of them might have been it (Bonferroni).
    chance = longest * float(gamma_sf(power[peak] / mean, lines))
    if chance > SCATTER.ripple_alarm:
        return 0.0
    # A ripple hardly ever has a period of the coarse grid, and one that is off leaves much of it at the ends.
    periods = 2.0 * longest / np.linspace(peak - 1.0, peak + 1.0, FINE)[1:-1]
    return float(periods[np.argmax(_energy_of_ripples(frame, left, periods))])


def _energy_of_ripples(frame: Frame, left: Real, periods: Real) -> Real:
    """Energy (m,) of a whitened scatter along ripples in size and phase of K of some periods (m,), in points."""
    n, energy = len(frame.measurement), np.zeros(len(periods))
    # Sweep by sweep: a ripple of one says nothing of the others, and small matrices are quickly done.
    for rows, _ in sweeps_of(frame.measurement):
        phase = 2.0 * np.pi * np.arange(len(rows)) / periods[:, None]
        waves_of_sweep = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        relative = np.stack([factor * frame.model_stiffness[rows] for factor in (1.0, 1.0j)], axis=-1)
        change = (relative[:, :, None] * waves_of_sweep[:, :, None, :]).reshape(len(periods), len(rows), -1)
        weights = frame.weights[rows][:, None]
        columns = np.concatenate([change.real * weights.real, change.imag * weights.imag], axis=1)
        size = np.linalg.norm(columns, axis=1, keepdims=True)
        axes, sizes, _ = np.linalg.svd(columns / np.where(size > 0.0, size, 1.0), full_matrices=False)
        along = np.einsum("kji,j->ki", axes, np.concatenate([left[rows], left[rows + n]]))
        # The fastest alternation has no sine: its direction is rounding.
        energy += np.sum(along**2 * (sizes > LEAST_WAVE * sizes[:, :1]), axis=1)
    return energy


def trimmed_residual(residual: Real, followed: Real, omega: Real, first: NDArray[np.bool_] | None = None) -> Trimmed:
    """What curves leave of a residual, without the frequencies at which it is far larger.

    An outlier, a notch or line interference is confined to a few frequencies, whatever the sweep; noise is not. The
    curves are fitted anew without them, or they would be drawn towards what is left out; the first guess is the
    median over frequencies, which a notch of a few points does not move.

    Parameters
    ----------
    residual : ndarray, shape (2n,)
        Whitened residual.
    followed : ndarray, shape (2n, q)
        Orthonormal basis of the curves.
    omega : ndarray, shape (n,)
        Angular frequencies.
    first : ndarray of bool, shape (n,), optional
        Rows from which to start; all of them by default.
    """
    # Frequencies that differ by rounding in the file are one.
    _, group = np.unique(rounded_log_omega(omega), return_inverse=True)
    group = np.concatenate([group.ravel(), group.ravel()])
    count = np.bincount(group).astype(float)
    middle = chi2_quantile(0.5, count)
    kept = np.ones(len(count), dtype=bool)
    if first is not None:
        kept[group[: len(omega)][~first]] = False
    for turn in range(MOST_TURNS):
        rows = kept[group]
        left = residual - followed @ np.linalg.lstsq(followed[rows], residual[rows], rcond=None)[0]
        found = Trimmed(left, rows, max(float(np.sum(rows)) - followed.shape[1], 1.0))
        # Curves take their share from every frequency alike.
        squares = np.bincount(group, left**2) * float(np.sum(rows)) / found.dof
        mean = float(np.sum(squares[kept]) / np.sum(count[kept]))
        variance = mean
        if turn == 0 and first is None:
            variance = float(np.median(squares / middle))
        # By the ratio of variances: beside a few numbers that are left over one frequency is easily far larger.
        usual = count * f_quantile(1.0 - SCATTER.outlying_frequency, count, found.dof)
        within = squares <= usual * variance
        # Where a good part of the data would go, these are no few frequencies: what scatters so is the noise. Where
        # sweeps are short, so that each frequency holds a tenth of the data, the curves would soon follow the rest.
        free = float(np.sum(count[within])) - followed.shape[1]
        too_many = np.sum(count[within]) < LEAST_KEPT * len(residual)
        too_many |= free < LEAST_FREE * (len(residual) - followed.shape[1])
        if too_many or (turn > 0 and np.array_equal(within, kept)):
            return found
        kept = within
    return found


def scatter_about(frame: Frame) -> tuple[float, float]:
    """Variance of whitened scatter and its degrees of freedom: what neither the fit nor structure can follow.

    A ripple too fast for the slow curves, or a drift of a measurement whose frequencies were taken in random order,
    would pass for scatter. But neighbours, along a sweep or from row to row, share most of it: where their
    differences vary by much less (von Neumann et al. 1941, doi:10.1214/aoms/1177731746), these tell the noise.
    """
    variance, dof = trimmed(frame).variance, float(max(frame.rough_dof, 1))
    # Where a free spectrum has as many lines as there are numbers, all of the noise is followed: none is left over.
    kept = max(1.0 - frame.absorbed.shape[1] / frame.size, 1.0 / frame.size)
    along_sweeps = [sweep.rows for sweep in sweeps_of(frame.measurement)]
    for lines in (along_sweeps, [np.arange(len(frame.measurement))]):
        parts = [frame.rest[rows + k] for rows in lines for k in (0, len(frame.measurement))]
        for order in DIFFERENCES:
            left = np.concatenate([np.zeros(0), *(np.diff(part, order) for part in parts)])
            power = comb(2 * order, order)
            efficient = len(left) * power**2 / comb(4 * order, 2 * order)
            if efficient < ENOUGH_NEIGHBOURS:
                continue
            near = float(np.mean(left**2)) / power / kept
            # Only where it is smaller beyond chance: the least of several estimates of white noise is too small.
            if near < variance * f_quantile(SCATTER.faster_alarm, efficient, dof):
                variance, dof = near, efficient
    return variance, dof
