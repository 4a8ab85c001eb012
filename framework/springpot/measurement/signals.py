"""Step one of the paper: from signals against time to K' and K'' with their uncertainty.

Equations (36) to (43). The transient with which a test starts is found by variable projection, and
a record in which nothing oscillates is refused: noise may have been taken for an oscillation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from springpot.errors import DataError
from springpot.rheology.points import Complex, Real
from springpot.thresholds import SIGNALS

from ..numerics import ROUNDING
from .fit import GONE, Basis, HarmonicFit, fit_harmonics, refined_frequency
from .steady import (
    MendedSignals,
    Signals,
    Steady,
    coarse_frequency,
    excerpt_span,
    in_order,
    steady_part,
)

STEP = 1.25
"""Ratio of neighbouring time constants.

The fit's second transient column makes up for what lies between them.
"""
LONGEST = 4.0
"""Periods; what dies away more slowly than that is a drift and cannot pass for a harmonic."""


def fit_with_transient(record: MendedSignals, basis: Basis) -> tuple[Basis, HarmonicFit]:
    """Least squares with a decaying transient from the beginning of the part on, if there is one.

    The evidence is what the transient takes from the squared residuals, counted in the noise that
    it leaves near omega: slow noise of the same colour is not mistaken for it.
    """
    from scipy.special import chdtri, fdtri

    # Two sieves, the cheap one first: most records have no transient, and are spared the second
    # fit.
    trial, gain, noise = _strongest(record, basis)
    if np.any(gain > chdtri(1, SIGNALS.transient_alarm) * noise):
        fit = fit_harmonics(record, trial)
        if np.any(gain > fdtri(1, fit.freedom, 1 - SIGNALS.transient_alarm) * fit.noise[:2]):
            return trial, fit
    return basis, fit_harmonics(record, basis)


def unsteady_cycles(fit: HarmonicFit) -> int:
    """How many leading groups of cycles have a stiffness unlike that of the second half.

    Compared with the mean and scatter of the second half (F test); what comes after the first
    steady group is scatter and stays.
    """
    from scipy.special import fdtri

    each = fit.groups[:, 1] / fit.groups[:, 0]
    # A transient dies away, so that the later half is what the first cycles are measured by.
    settled = each[len(each) // 2 :]
    n = len(settled)
    if n < 3 or not np.isfinite(each).all():
        return 0
    centre = settled.mean()
    scatter = float(np.sum(np.abs(settled - centre) ** 2))
    # Computed signals scatter by rounding only, which must not make every cycle an exception.
    variance = max(scatter / (2 * (n - 1)), ROUNDING**2 * float(abs(centre)) ** 2)
    limit = 2 * variance * (1 + 1 / n) * fdtri(2, 2 * (n - 1), 1 - SIGNALS.ruled_out)
    unlike = np.abs(each[: len(each) // 2] - centre) ** 2 > limit
    # Only an unbroken beginning is a transient; what comes later is scatter.
    return int(np.argmin(np.append(unlike, False)))


def _strongest(record: MendedSignals, basis: Basis) -> tuple[Basis, Real, Real]:
    """The basis with the transient that explains most, its gain and the noise variance.

    The variance is (2,), of the channels.

    A transient is linear but for its time constant, so that this alone is searched: each trial is
    one more column, made orthogonal to the rest (variable projection, doi:10.1137/0710036).
    """
    period = 2 * np.pi / basis.omega
    # In a short part even less: what lasts through it cannot be told from level and drift.
    longest = min(LONGEST * period, (basis.stop - basis.start) / 4)
    # By equal ratios: nobody knows beforehand how fast it dies.
    trials = np.exp(np.arange(np.log(period / 16), np.log(longest), np.log(STEP)))
    normal, right, square, count = _normal_equations(record, basis, trials, GONE * longest)
    size = basis.size
    gain, explained = _gains(normal, right, size)
    left = np.maximum(square - explained, ROUNDING**2 * square) + np.finfo(float).tiny
    best = int(np.argmax(np.sum(gain / left, axis=1)))
    noise = np.maximum(left - gain[best], ROUNDING**2 * square) / max(count - size - 2, 1)
    # Too few samples to tell a transient from what the other columns leave.
    if count <= 2 * size:
        return basis, np.zeros(2), np.ones(2)
    return replace(basis, transient=float(trials[best])), gain[best], noise


def _normal_equations(
    record: MendedSignals, basis: Basis, trials: Real, gone: float
) -> tuple[Real, Real, Real, int]:
    """Those of the basis and of transients (t,) of these times, side by side, block by block.

    Products (b + t, b + t) of the columns, theirs (b + t, 2) with the channels, the channels'
    squares (2,), and the number of samples. From the time `gone` on there is no transient.
    """
    total = basis.size + len(trials)
    normal, right, square, count = np.zeros((total, total)), np.zeros((total, 2)), np.zeros(2), 0
    for time, both in record.blocks(basis.start, basis.stop):
        if not len(time):
            continue
        columns, since = basis.columns(time), time - basis.start
        # Later blocks hold nothing of it but rounding.
        if since[0] < gone:
            columns = np.concatenate([columns, np.exp(-since[:, None] / trials)], axis=1)
        have = columns.shape[1]
        normal[:have, :have] += columns.T @ columns
        right[:have] += columns.T @ both
        square += np.sum(both**2, axis=0)
        count += len(time)
    return normal, right, square, count


def _gains(normal: Real, right: Real, size: int) -> tuple[Real, Real]:
    """What each trial takes from the squared residuals, (t, 2).

    Also what the columns before them explain, (2,).
    """
    # Columns of one size: a transient that dies at once is small beside a level, which would cost
    # digits.
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    normal, right = normal / np.outer(scale, scale), right / scale[:, None]
    shared = np.linalg.lstsq(
        normal[:size, :size], np.column_stack([right[:size], normal[:size, size:]]), rcond=1e-13
    )[0]
    remaining = 1 - np.sum(normal[:size, size:] * shared[:, 2:], axis=0)
    reach = right[size:] - normal[size:, :size] @ shared[:, :2]
    # A trial that the other columns can imitate gains nothing.
    gain = np.where(remaining[:, None] > 1e-3, reach**2 / np.maximum(remaining, 1e-3)[:, None], 0.0)
    return gain, np.sum(right[:size] * shared[:, :2], axis=0)


def tried(record: MendedSignals, frequency: bool, part: bool) -> float:
    """Of how many candidates the searched frequency and part are the best, as far as noise has any.

    Parameters
    ----------
    record : MendedSignals
        The signals.
    frequency, part : bool
        Whether these were searched.
    """
    count = 1.0
    # Noise of n samples has about n / 2 oscillations of its own, and a part may begin at any
    # sample.
    if frequency:
        count *= max(0.5 * len(record.time), 1.0)
        if part:
            count *= len(record.time)
    return count


def highest_of_noise(freedom: float, candidates: float) -> float:
    """Quantile of F(2, `freedom`) that the best of so many noise candidates exceeds in 0.1 %.

    Its tail is a power, chance = (1 + 2 F / nu)^(-nu / 2). Solved for F, for the complement of a
    chance of 1e-17 is rounded to one: six million samples have so many candidates.

    Examples
    --------
    >>> from springpot.measurement.signals import highest_of_noise
    >>> round(highest_of_noise(20.0, 1.0), 2), round(highest_of_noise(1e7, 5e13), 1)
    (9.95, 38.5)
    """
    chance = (1.0 - SIGNALS.motion) / candidates
    return 0.5 * freedom * float(np.expm1(-2.0 / freedom * np.log(chance)))


def require_motion(
    record: MendedSignals, basis: Basis, fit: HarmonicFit, candidates: float
) -> None:
    """Refuse a frequency at which the displacement is no more than its noise there (F test, 0.1 %).

    Parameters
    ----------
    record : MendedSignals
        The signals.
    basis : Basis
        What was fitted.
    fit : HarmonicFit
        What it gave.
    candidates : float
        Of how many candidates this one is the best; 1 where the frequency was given.

    Raises
    ------
    DataError
        If the displacement does not oscillate.
    """
    # Variance of cosine and sine together: noise alone makes an amplitude of this size.
    noise = float(fit.noise[0]) * float(np.trace(fit.inverse))
    if abs(fit.amplitude[0, 0]) ** 2 > highest_of_noise(fit.freedom, candidates) * noise:
        return
    if candidates > 1.0:
        raise DataError(
            f"{record.name}: nothing oscillates in this record, the displacement scatters about its"
            " level; where it does, say when and how fast: --window START STOP --frequency HZ"
            " (window, omega in Python)"
        )
    moving = coarse_frequency(record)
    raise DataError(
        f"{record.name}: the displacement does not oscillate at {basis.omega:.4g} rad/s "
        f"({basis.omega / (2 * np.pi):.4g} Hz); give the frequency at which it does, "
        f"{moving:.4g} rad/s ({moving / (2 * np.pi):.4g} Hz), or none"
    )


BENT = 0.05
"""Third harmonic of a displacement, over its first, from which it is told to be no sinusoid."""
LONGER = 4.0
"""Ratio of neighbouring lengths.

A fraction of a cycle over one of them is less than half a cycle over the next.
"""

_ONE_WAY = "a single loading is a test in time, which inspect shows and identify fits"

__all__ = ["Harmonics", "Signals", "harmonics_of"]


@dataclass(frozen=True, eq=False)
class Harmonics:
    """What one test at one frequency says.

    Parameters
    ----------
    omega, omega_sd : float
        Angular frequency in rad/s and its standard deviation (0 where it was given).
    stiffness : complex
        K' + i K'' = U_1 / X_1, force unit over displacement unit; eq. (43).
    sd : complex
        Standard deviations of K' and K'' that should be used.
    sd_residual, sd_cycles : complex
        Two estimates of them: from the residuals' spectrum near omega, and from the scatter between
        cycles (nan with fewer than three).
    displacement, force : ndarray of complex, shape (h,)
        Amplitudes X_n, U_n: the signal is Re X_n exp(i n omega (t - t0)) with t0 the middle of the
        part.
    level, drift, residual : ndarray, shape (2,)
        Mean, change of the mean from the middle to the end, and rms residual, of displacement and
        of force.
    start, stop : float
        The steady part in seconds.
    cycles : float
        How many cycles it holds.
    samples : int
        Complete samples in it.
    notes : tuple of str
        What a user should know.
    """

    omega: float
    omega_sd: float
    stiffness: complex
    sd: complex
    sd_residual: complex
    sd_cycles: complex
    displacement: Complex
    force: Complex
    level: Real
    drift: Real
    residual: Real
    start: float
    stop: float
    cycles: float
    samples: int
    notes: tuple[str, ...] = ()

    @property
    def amplitude(self) -> float:
        """Displacement amplitude |X_1|."""
        return float(abs(self.displacement[0]))

    @property
    def work(self) -> float:
        """Energy taken up in one cycle, the closed integral of force over displacement.

        In the force unit times the displacement unit: pi sum n Im(U_n conj(X_n)), for sinusoids pi
        |X_1|^2 K''.
        """
        order = np.arange(1, len(self.force) + 1)
        return float(np.pi * np.sum(order * (self.force * np.conj(self.displacement)).imag))

    @property
    def relative(self) -> Complex:
        """Force harmonics 2, 3, ...

        Over the first, (U_n / U_1) exp(-i (n - 1) phi) with phi the phase of X_1.

        Time is counted from the maximum of the displacement, as in `Measurement.harmonics`; Coulomb
        friction has 1/3.
        """
        turn = self.displacement[0] / abs(self.displacement[0])
        order = np.arange(1, len(self.force) + 1)
        seen = self.force / turn**order
        return np.asarray(seen[1:] / seen[0])


def harmonics_of(
    time: ArrayLike,
    displacement: ArrayLike,
    force: ArrayLike,
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
    name: str = "signals",
) -> Harmonics:
    """Harmonics of displacement and force by least squares on the steady part of a test.

    Parameters
    ----------
    time : array_like, shape (n,)
        Seconds; irregular sampling, gaps and disorder are fine.
    displacement, force : array_like, shape (n,)
        The channels, nan where a sample is missing.
    omega : float, optional
        Angular frequency in rad/s; estimated from the displacement where not given.
    n_harmonics : int
        How many harmonics of both channels are fitted; fewer where the sampling is too coarse for
        them.
    window : tuple of float, optional
        Start and stop in seconds of the part to use; by default the longest part of constant
        amplitude, from where cycles have the stiffness of the later ones. A decaying transient of
        either channel is fitted along with the harmonics where the residuals show one.
    name : str
        Shown in errors.

    Returns
    -------
    Harmonics
        Complex stiffness, its standard deviation and all amplitudes.

    Raises
    ------
    DataError
        If there is no oscillation (at `omega`, where it is given), not one full cycle, or too few
        samples.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import harmonics_of
    >>> t = np.linspace(0.0, 5.0, 2000)
    >>> moved = 0.5 * np.cos(6.0 * t)
    >>> test = harmonics_of(t, moved, 3.0 * moved + 0.1 * moved**3)
    >>> round(test.omega, 6), round(test.stiffness.real, 6), round(float(test.relative[1].real), 5)
    (6.0, 3.01875, 0.00207)
    """
    clock, moved, pulled = (
        np.asarray(channel, dtype=float) for channel in (time, displacement, force)
    )
    record = in_order(clock, moved, pulled, name)
    if omega is not None and not (np.isfinite(omega) and omega > 0):
        raise DataError(f"{name}: the frequency must be positive, got omega = {omega} rad/s")
    if n_harmonics < 1:
        raise DataError(f"{name}: at least one harmonic is needed, got {n_harmonics}")
    # A frequency of the command is exact; an estimated one is refined once the steady part is
    # known.
    first = omega
    if first is None:
        first = coarse_frequency(record)
    if window is None:
        part = steady_part(record, first)
    else:
        part = _given_part(record, window)
    basis, sd = _basis(record, part, first, omega is None, n_harmonics, trim=window is None)
    notes = (*record.notes, *part.notes)
    if basis.harmonics < n_harmonics:
        notes = (
            *notes,
            f"too few samples for {n_harmonics} harmonics: {basis.harmonics} were fitted",
        )
    # The basis of the fit is that of the steady part; what still decays in it would pass for drift
    # and harmonics.
    basis, fit = fit_with_transient(record, basis)
    if window is None and (unsteady := unsteady_cycles(fit)):
        begin = float(fit.begins[unsteady])
        notes = (
            *notes,
            f"the stiffness settles only at {begin:.4g} s: what comes before was left out",
        )
        basis, fit = fit_with_transient(record, replace(basis, start=begin, transient=0.0))
    require_motion(record, basis, fit, tried(record, omega is None, window is None))
    return _summary(basis, sd, fit, notes, record)


def _given_part(record: MendedSignals, window: tuple[float, float]) -> Steady:
    start, stop = window
    if not start < stop or stop <= record.time[0] or start >= record.time[-1]:
        raise DataError(
            f"{record.name}: the window {start:g} to {stop:g} s holds no samples, "
            f"the record runs from {record.time[0]:g} to {record.time[-1]:g} s"
        )
    # Just past the last sample, as the end of a part lies outside of it.
    return Steady(
        max(start, float(record.time[0])), min(stop, float(np.nextafter(record.time[-1], np.inf)))
    )


def _basis(
    record: MendedSignals, part: Steady, omega: float, refine: bool, harmonics: int, trim: bool
) -> tuple[Basis, float]:
    """The basis of the final fit.

    Frequency refined, part trimmed to whole cycles, harmonics that samples allow.
    """
    # A frequency that was given is exact: it has no deviation and is not refined.
    affordable, sd = _affordable(record, part, omega, harmonics), 0.0
    basis = Basis(omega, part.start, part.stop, affordable)
    if refine:
        basis = replace(basis, harmonics=1)
        # The first harmonic alone leads to the frequency from farther away than all of them
        # together.
        basis, sd = refined_frequency(record, replace(basis, omega=_nested(record, basis)))
        basis = replace(basis, harmonics=affordable)
        basis, sd = refined_frequency(record, basis)
    # The search left the peak that it began at: what it found is another one, or none.
    if not 0.3 * omega < basis.omega < 3 * omega:
        raise DataError(
            f"{record.name}: no frequency found; if it swings, give it with omega (CLI:"
            f" --frequency); {_ONE_WAY}"
        )
    if trim:
        basis = _whole_cycles(basis)
        if refine:
            basis, sd = refined_frequency(record, basis)
    if (basis.stop - basis.start) * basis.omega < 0.95 * 2 * np.pi:
        cycles = (basis.stop - basis.start) * basis.omega / (2 * np.pi)
        raise DataError(
            f"{record.name}: {cycles:.2g} cycles of {basis.omega:.4g} rad/s where one is needed; if"
            " some part of it oscillates, say which and how fast: --window START STOP --frequency"
            f" HZ (window, omega in Python); {_ONE_WAY}"
        )
    return basis, sd


def _nested(record: MendedSignals, basis: Basis) -> float:
    """The frequency refined over longer and longer parts.

    Over all of a long record the first guess is cycles off.
    """
    whole, middle = basis.stop - basis.start, 0.5 * (basis.start + basis.stop)
    length, omega = excerpt_span(record, basis.omega), basis.omega
    while length < 0.5 * whole:
        part = replace(basis, omega=omega, start=middle - 0.5 * length, stop=middle + 0.5 * length)
        omega, length = refined_frequency(record, part)[0].omega, LONGER * length
    return omega


def _affordable(record: MendedSignals, part: Steady, omega: float, harmonics: int) -> int:
    # Complete samples only: a gap tells nothing of a harmonic.
    count = sum(len(time) for time, _ in record.blocks(part.start, part.stop))
    cycles = (part.stop - part.start) * omega / (2 * np.pi)
    # More than two samples for each cycle of the highest harmonic, and several for each unknown.
    most = min(int(count / max(cycles, 1.0) / 2.5), (count - 4) // 6)
    if most < 1:
        raise DataError(
            f"{record.name}: {count} samples in {cycles:.3g} cycles are too few for one harmonic"
        )
    return min(harmonics, most)


def _whole_cycles(basis: Basis) -> Basis:
    """The middle of the part, cut to whole cycles.

    So that unfitted harmonics cannot leak into the fitted ones.
    """
    period = 2 * np.pi / basis.omega
    # Rounding of the frequency must not cost a whole cycle.
    whole = np.floor((basis.stop - basis.start) / period + 0.02)
    if whole < 3:
        # Every sample counts here, and a third of them would be cut.
        return basis
    spare = max(basis.stop - basis.start - whole * period, 0.0)
    start = basis.start + 0.5 * spare
    return replace(basis, start=start, stop=min(start + whole * period, basis.stop))


def _summary(
    basis: Basis, omega_sd: float, fit: HarmonicFit, notes: tuple[str, ...], record: MendedSignals
) -> Harmonics:
    moved, force = fit.amplitude
    if not abs(moved[0]) > 0:
        raise DataError(f"{record.name}: the displacement does not move")
    if not abs(force[0]) > 0:
        raise DataError(f"{record.name}: the force is zero throughout")
    stiffness = complex(force[0] / moved[0])
    by_residual = _propagated(complex(moved[0]), fit)
    by_cycles = _scatter(fit.groups)
    sd, extra = _chosen(by_residual, by_cycles, len(fit.groups), fit.freedom)
    if len(moved) >= 3 and abs(moved[2]) > BENT * abs(moved[0]):
        extra = (
            *extra,
            (
                "the displacement is no sinusoid: its third harmonic is"
                f" {abs(moved[2] / moved[0]):.0%}"
            ),
        )
    # Of computed signals nothing is left over: rounding is the least that any stiffness errs by.
    floor = 4 * np.finfo(float).eps * abs(stiffness)
    # The deviation of omega came from white residuals: slow ones near omega make it as much less
    # sure.
    inflation = 1.0
    if fit.residual[0] > 0:
        inflation = np.sqrt(fit.noise[0]) / fit.residual[0]
    return Harmonics(
        basis.omega,
        float(omega_sd * inflation),
        stiffness,
        complex(max(sd.real, floor), max(sd.imag, floor)),
        by_residual,
        by_cycles,
        moved,
        force,
        fit.level,
        fit.drift,
        fit.residual,
        basis.start,
        basis.stop,
        (basis.stop - basis.start) * basis.omega / (2 * np.pi),
        fit.samples,
        (*notes, *extra),
    )


def _propagated(moved: complex, fit: HarmonicFit) -> complex:
    """Standard deviations of K' and K'' by dK = (dU - K dX) / X.

    What matters is the noise of u - K x near omega, with K turning the displacement's noise: its
    cosine and sine coefficients (a, b) have the covariance of noise times inverse, and the pair is
    the amplitude a - ib.
    """
    # Of U / X by the cosine and the sine coefficient of the force: the pair is a - ib.
    slopes = np.array([1.0, -1j]) / moved
    jacobian = np.stack([slopes.real, slopes.imag])
    covariance = fit.noise[2] * jacobian @ fit.inverse @ jacobian.T
    return complex(*np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def _scatter(groups: Complex) -> complex:
    """Standard deviations of the mean K' and K'' from their scatter between groups of cycles."""
    if len(groups) < 3:
        return complex(np.nan, np.nan)
    # The ratio of each group: a displacement that wanders from cycle to cycle takes its force
    # along.
    each = groups[:, 1] / groups[:, 0]
    root = np.sqrt(len(each))
    return complex(np.std(each.real, ddof=1) / root, np.std(each.imag, ddof=1) / root)


def _chosen(
    by_residual: complex, by_cycles: complex, groups: int, freedom: float
) -> tuple[complex, tuple[str, ...]]:
    """The residuals' estimate, unless cycles scatter more than chance (1 %, F test) allows."""
    if groups < 3:
        return by_residual, ()
    from scipy.special import fdtri

    # Few groups scatter by chance: without a test the larger of two estimates would mostly be too
    # large.
    limit = np.sqrt(fdtri(groups - 1, freedom, 0.99))
    if by_cycles.real <= limit * by_residual.real and by_cycles.imag <= limit * by_residual.imag:
        return by_residual, ()
    larger = complex(max(by_residual.real, by_cycles.real), max(by_residual.imag, by_cycles.imag))
    return larger, (
        "cycles differ by more than the noise within them: their scatter gives the uncertainty",
    )
