"""The linear geometry of a fit: what slow structure is, and what fitted parameters can absorb.

With the shapes along sweeps and rows that a residual is held against: slow ones, those that sweeps
share, waves and drifts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from springpot.distributions import (
    Links,
    autoregressive,
    chi2_sf,
    effective_share,
    f_sf,
    prewhitened,
)
from springpot.identification.problem import weighted
from springpot.measurement.independence import HELD_ALIKE, SMOOTH_DEGREE, frequency_numbers, telling
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.mixed_up import sweeps_of, temperatures_differ
from springpot.measurement.scatter import LEAST_RELATIVE, rounding_steps
from springpot.rheology.points import Complex, Real, real_form
from springpot.thresholds import EVIDENCE, REPEATS, VERDICT

from ..numerics import ALIKE, FEWEST, NEGLIGIBLE, SMALLEST, orthonormal, projected_out

if TYPE_CHECKING:
    from springpot.rheology.model import Model


MOST_SHARED = 60
"""Frequencies above which sweeps are dense enough for their neighbours to show what is shared."""
DRIFT_DEGREE = 3
"""Degree of the polynomials by which a gain or a phase may creep from row to row."""
Drawn: TypeAlias = NDArray[np.floating]


def relative_to(stiffness: Complex, measurement: Measurement) -> Complex:
    """What deviations (n,) are relative to: K of a model, the measured one where it has none.

    A material has none where a channel counts the other way.
    """
    return np.where(stiffness == 0.0, measurement.stiffness, stiffness)


def phase_of(stiffness: Complex, measurement: Measurement) -> Complex:
    """K over |K| (n,) of a model."""
    whole = relative_to(stiffness, measurement)
    return np.asarray(whole / np.abs(whole), dtype=np.complex128)


def able_to_follow(
    model: Model, theta: Real, left: Real, slopes: Real, curve: Real
) -> NDArray[np.bool_]:
    """Which parameters (p,) of a fit can follow what it leaves.

    Not those at a bound beyond which the fit would improve. A positive parameter without influence
    has gone to its end (nothing, or rigid) and counts as at a bound.

    Parameters
    ----------
    model : Model
        What was fitted.
    theta : ndarray, shape (p,)
        Its parameters.
    left : ndarray, shape (m,)
        Measured less modelled, over the noise.
    slopes : ndarray, shape (p, m)
        Derivatives of what is modelled, over the noise.
    curve : ndarray, shape (m,)
        What was measured or is modelled, over the noise.
    """
    logs = np.array([parameter.scale == "log" for parameter in model.parameters])
    lower, upper = model.box
    # Per relative change where a parameter is positive, so that its unit does not matter.
    influence = np.linalg.norm(slopes, axis=1) * np.where(logs, theta, 1.0)
    downhill = slopes @ left
    # A search ends near a bound, hardly ever on it.
    room = NEGLIGIBLE * np.where(logs, np.abs(theta), 1.0)
    # Only where the fit pushes against the bound: one that would come back can follow a residual to
    # one side.
    at_lower = (theta <= lower + room) & (downhill < 0)
    at_upper = (theta >= upper - room) & (downhill > 0)
    gone = logs & (influence < NEGLIGIBLE * float(np.linalg.norm(curve)))
    free: NDArray[np.bool_] = ~(at_lower | at_upper | gone)
    return free


def slow_shapes(measurement: Measurement, highest: int = SMOOTH_DEGREE) -> Real:
    """Legendre polynomials along each sweep, to a degree, (m, n), zero outside their sweep."""
    shapes: list[Real] = []
    for rows, x in sweeps_of(measurement):
        # Three points for each polynomial: fewer would let them follow the noise.
        degree = min(highest, max(0, len(np.unique(x)) // 3 - 1))
        span = float(np.ptp(x))
        if span > 0:
            x = 2.0 * (x - x.min()) / span - 1.0
        else:
            x = np.zeros(len(rows))
        for polynomial in np.polynomial.legendre.legvander(x, degree).T:
            shape = np.zeros(len(measurement))
            shape[rows] = polynomial
            shapes.append(shape)
    return np.array(shapes)


def shared_shapes(measurement: Measurement) -> Real:
    """For each frequency of several sweeps a shape (m, n): one there in all sweeps, else zero.

    What errs alike at one frequency in sweep after sweep (a ripple, a notch) is no noise, however
    rough it is. None where fewer than `FEWEST` sweeps share their frequencies, or there are
    so many that neighbours tell more.
    """
    # By frequency, not by order: sweeps may lack single points, or run up and down.
    which = frequency_numbers(measurement)
    count = int(which.max()) + 1
    if count > MOST_SHARED or len(sweeps_of(measurement)) < FEWEST:
        return np.zeros((0, len(measurement)))
    together = which == np.arange(count)[:, None]
    shared: Real = together[together.sum(axis=1) >= FEWEST].astype(np.float64)
    return shared


def spectrum(measurement: Measurement, sample: Drawn) -> Drawn:
    """Energy of whitened residuals (m, 2n) along a cosine and a sine.

    All sweeps and both parts together.

    By least squares, not by a Fourier transform: the two waves of a slow or a fast period are not
    at right angles on few points, and their periods would stand out from noise that has none (Lomb
    1976, doi:10.1007/BF00648343).

    Returns
    -------
    ndarray, shape (m, k)
        At periods of infinity, 2 (k - 1), 2 (k - 1) / 2, ..., 2 points.
    """
    n, orders = len(measurement), [sweep.rows for sweep in sweeps_of(measurement)]
    longest = max(len(rows) for rows in orders)
    energy: Drawn = np.zeros((len(sample), longest + 1), dtype=sample.dtype)
    for rows in orders:
        pairs = _paired_waves(len(rows), longest).astype(sample.dtype)
        for offset in (0, n):
            along = (sample[:, rows + offset] @ pairs).reshape(len(sample), longest + 1, 2)
            energy += np.einsum("ijk,ijk->ij", along, along)
    return energy


@lru_cache(maxsize=64)
def _paired_waves(count: int, longest: int) -> Real:
    """Two orthonormal columns (count, 2 (longest + 1)) for each period.

    What a cosine and a sine span.
    """
    turns = np.pi / longest * np.arange(longest + 1)
    phase = turns[:, None] * np.arange(count)
    axes, sizes, _ = np.linalg.svd(
        np.stack([np.cos(phase), np.sin(phase)], axis=-1), full_matrices=False
    )
    # A constant, and the fastest alternation, have no second wave: its column is rounding.
    axes *= sizes[:, None, :] > 1e-6 * sizes[:, None, :1]
    # Nor has a sweep of a single point.
    pairs = np.zeros((longest + 1, count, 2))
    pairs[..., : axes.shape[-1]] = axes
    return np.asarray(pairs.transpose(1, 0, 2).reshape(count, -1))


def waves(measurement: Measurement, period: float) -> Real:
    """Cosine and sine along every sweep, of a period in points.

    Shape (2 sweeps, n), zero outside their sweep.
    """
    shapes = []
    for rows, _ in sweeps_of(measurement):
        phase = 2.0 * np.pi * np.arange(len(rows)) / period
        for wave in (np.cos(phase), np.sin(phase)):
            shape = np.zeros(len(measurement))
            shape[rows] = wave
            shapes.append(shape)
    return np.array(shapes)


def drift_curves(count: int) -> Real:
    """Slow curves from row to row with their constant, columns (n, q).

    What creeps while a measurement is made.
    """
    curves = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), DRIFT_DEGREE)
    return np.asarray(curves, dtype=np.float64)


def drift_shapes(count: int) -> Real:
    """The same without the constant, which is no drift, as shapes (q, n)."""
    return drift_curves(count).T[1:]


DEALT_ALONE = 8
"""Points of a sweep from which its scatter is dealt out anew by itself."""
FEWEST_OWN = 20.0
"""Degrees of freedom below which a scatter says too little of itself."""
ENOUGH_NEIGHBOURS = 10
"""Degrees of freedom, or neighbours, from which second differences tell the scatter."""
LEAST_LEFT = 0.1
"""Share of a point, a level or a narrow shape that the fitted curves must leave.

Of what they leave less of, the rest is their own noise and says nothing.
"""
MOST_LOCAL = 600
"""Narrow shapes looked at; more points than these have slow structure enough."""
DRAWS = 2000
"""Simulated residuals of noise alone; the chance 0.005 is then known to a third of itself."""
FURTHER = (3, 6)
"""So many times as many draws more while an alarm is open.

With all of them 0.005 is known to a tenth of itself.
"""
SURE = 3.5
"""Standard errors of a chance beyond the edge of the alarms from which no more draws are needed."""
LEAST_SEEN = 1e-3
"""Share of a shape that fitted curves must leave for it to be seen: of less the rest is theirs."""
DRAWN = np.float32
"""Precision of simulated residuals: seven digits of a chance that is known to one."""
ROUNDED = 0.1
"""Share of the noise's variance from which rounding is simulated as such.

Less is lost in the rest of it.
"""


def chance_of_squares(value: float, dof: float, scale_dof: float) -> float:
    """Chance of at least `value` for `dof` squares of unit noise, which may itself be estimated."""
    if scale_dof == inf:
        return float(chi2_sf(value, dof))
    # Chi-square with an estimated unit calls noise structure too often, the more so the fewer data
    # there are.
    return float(f_sf(value / dof, dof, max(scale_dof, 1.0)))


def is_beyond_noise(ratio: float, dof: float, scale_dof: float) -> bool:
    """Whether an error is so many times the noise by more than chance.

    Parameters
    ----------
    ratio : float
        Error over noise.
    dof, scale_dof : float
        Degrees of freedom of either: both are uncertain, so F and not chi-square.
    """
    chance = chance_of_squares(ratio**2 * dof, dof, scale_dof)
    # Of many points a slight excess is sure but small.
    return bool(ratio > VERDICT.misfit and chance < VERDICT.structure_alarm)


def near_an_alarm(chance: float, draws: int) -> bool:
    """Whether so many draws leave it open on which side of an alarm a chance lies.

    All alarms lie between these two: there the verdict must not be left to the seed.
    """
    low, high = VERDICT.accepted, VERDICT.library_alarm
    return low < chance < high + SURE * float(np.sqrt(high / draws))


def beyond(columns: Real, known: Real, least: float = LEAST_SEEN) -> Real:
    """Orthonormal basis (m, q) of what some columns have beyond an orthonormal basis."""
    left = projected_out(columns, known)
    return orthonormal(left[:, np.linalg.norm(left, axis=0) > least], least)


@dataclass(frozen=True, eq=False)
class NoiseFrame:
    """A fit seen in units of the noise.

    Parameters
    ----------
    measurement : Measurement
        The data, repeats averaged.
    model_stiffness : ndarray of complex, shape (n,)
        K of the fitted model.
    weights : ndarray of complex, shape (n,)
        Reciprocal standard deviations of K' and K''.
    jacobian : ndarray of complex, shape (p, n)
        dK/dtheta at the fit.
    scale_dof : float
        Degrees of freedom behind the common scale of the noise; infinite where it is known.
    estimated : bool
        Whether the noise was estimated from the scatter of these very data.
    turn : ndarray of complex, shape (n,), optional
        Unit numbers by which differences of K are multiplied before they are weighed.
    memory : float
        Correlation of the noise of neighbouring points of a sweep.
    tails : float
        Degrees of freedom of Student's t by which known noise is spread; endless if normal.
    """

    measurement: Measurement
    model_stiffness: Complex
    weights: Complex
    jacobian: Complex
    scale_dof: float = inf
    estimated: bool = False
    turn: Complex | None = None
    memory: float = 0.0
    tails: float = inf

    def whiten(self, values: Complex) -> Real:
        """Complex values (..., n) as real ones (..., 2n) in units of the noise."""
        return weighted(values, self.weights, self.turn)

    @cached_property
    def residual(self) -> Real:
        """Whitened residual (2n,): measured minus modelled."""
        return self.whiten(self.measurement.stiffness - self.model_stiffness)

    @cached_property
    def absorbed(self) -> Real:
        """Orthonormal basis (2n, q) of all that the fitted parameters can follow."""
        return orthonormal(self.whiten(self.jacobian).T)

    @property
    def worth(self) -> float:
        """Independent numbers that each point is worth to slow curves."""
        return effective_share(self.memory)

    @property
    def size(self) -> int:
        """Number of real data."""
        return 2 * len(self.measurement)

    @cached_property
    def rest(self) -> Real:
        """Residual (2n,) without what the fitted parameters can follow."""
        return self.project(self.residual[:, None])[:, 0]

    def draws(self, count: int, rng: np.random.Generator) -> Drawn:
        """Residuals (count, 2n) that noise alone would leave, treated as the measured one was.

        See `standard`.

        Where the noise was estimated from the data's own scatter, that scatter is dealt out anew:
        the relative deviations of the points change places and signs, each with its gain and its
        phase, or with its storage and its loss where the noise of these is of unequal size. The
        draws have the tails of the data, and scatter as they do (Freedman and Lane 1983,
        doi:10.1080/07350015.1983.10509354); what they have not is the order. Otherwise draws are
        normal, or have the tails that repeats show; where a good part of the noise is that the
        values were written with few digits, they are written with as many.
        """
        noise: Drawn
        if self._steps is not None:
            noise = self._as_written(self._steps, count, rng)
        elif not self._deals_out:
            parts = rng.standard_normal((count, 2, self.size // 2), dtype=DRAWN)
            if self.tails < inf:
                # Of variance one, as the noise was measured by its variance.
                parts *= np.sqrt((self.tails - 2.0) / rng.chisquare(self.tails, parts.shape))
            noise = self._remembered(parts).reshape(count, self.size)
        else:
            order = self._dealt(count, rng)
            sign = rng.integers(0, 2, order.shape, dtype=np.int8) * np.int8(2) - np.int8(1)
            new = self._deviations.astype(np.complex64)[order] * sign
            noise = self._in_their_places(self._remembered(new))
        # The measured residual has lost what the parameters follow; so must the noise (no refit of
        # each draw needed).
        absorbed = self.absorbed.astype(DRAWN)
        noise -= (noise @ absorbed) @ absorbed.T
        if self.scale_dof == inf or self._deals_out:
            return self.standard(noise)
        # A noise from a few repeats may be too small by chance: each draw is judged by such an
        # estimate of its own.
        scale = np.sqrt(rng.chisquare(self.scale_dof, count) / self.scale_dof).astype(DRAWN)
        return np.asarray(noise / scale[:, None])

    def _remembered(self, new: Any) -> Any:
        """Noise (..., n) of the same size in which a point remembers the one before it.

        Of what is new with each point (..., n), over a sweep.
        """
        if self.memory:
            for rows, _ in sweeps_of(self.measurement):
                new[..., rows] = autoregressive(new[..., rows], self.memory)
        return new

    @cached_property
    def links(self) -> Links:
        """Which numbers (2n,) have one before them in their sweep."""
        lines = [rows for rows, _ in sweeps_of(self.measurement)]
        return Links.of_parts(lines, self.size // 2)

    @property
    def has_mirror(self) -> bool:
        """Whether a draw is as likely with the other sign: what few digits leave out is not."""
        return self._steps is None

    @cached_property
    def _steps(self) -> Complex | None:
        """Rounding steps of K' and K'' (n,), where rounding is a good part of the noise."""
        # Noise that goes along K is told only where it is larger than rounding.
        if self.turn is not None:
            return None
        steps = rounding_steps(self.measurement)
        # Where it is small beside the noise, uniform errors are as good as part of it, and drawing
        # them costs time.
        real, imag = steps.real * self.weights.real, steps.imag * self.weights.imag
        # A uniform error of one step has a twelfth of its square for variance; the mean is over
        # both parts.
        share = 0.5 * float(np.mean(real**2 + imag**2)) / 12.0
        if share < ROUNDED:
            return None
        return steps

    def _as_written(self, steps: Complex, count: int, rng: np.random.Generator) -> Drawn:
        """Whitened residuals (count, 2n) of noisy values of the model.

        Written with as few digits as the data.

        Values that change little from point to point are all rounded the same way: that is no
        structure. Where within its step a value lay, the fit tells as well as its parameters are
        known and no better.
        """
        step = real_form(steps)
        exact = real_form(self.model_stiffness)
        weights = real_form(self.weights)
        n = len(self.measurement)
        # Storage and loss each have their own: the same for both would make one of them too still.
        levels = [self._own_level(np.arange(n) + k, step, weights) for k in (0, n)]
        own = np.concatenate([level * np.abs(self.model_stiffness) for level in levels])
        # About one fit alone, exact values would be rounded alike in every draw, as in the data.
        absorbed = self.absorbed
        followed = rng.standard_normal((count, absorbed.shape[1])) @ absorbed.T
        told = exact + followed / weights
        noise = self._remembered(rng.standard_normal((count, 2, n)))
        values = told + own * noise.reshape(count, self.size)
        coarse = np.flatnonzero(step)
        values[:, coarse] = np.round(values[:, coarse] / step[coarse]) * step[coarse]
        return np.asarray((values - told) * weights, dtype=DRAWN)

    def _own_level(self, rows: NDArray[np.int64], step: Real, weights: Real) -> float:
        """Noise over |K| of some rows beside uniform errors of rounding.

        Together as large as the residual.
        """
        size = np.abs(self.model_stiffness)
        squares = (self.rest[rows] / weights[rows]) ** 2
        free = max(float(len(rows) - np.sum(self.absorbed[rows] ** 2)), 1.0)

        def excess(level: float) -> float:
            variance = level**2 * size**2 + step[rows] ** 2 / 12.0
            return float(np.sum(squares / (variance + SMALLEST))) - free

        # Rounding alone may be as large as the residual: then there is no other noise to be found.
        if excess(LEAST_RELATIVE) <= 0.0:
            return LEAST_RELATIVE
        largest = float(np.sqrt(np.sum(squares / size**2) / free))
        return float(brentq(excess, LEAST_RELATIVE, largest * (1.0 + ALIKE)))

    def standard(self, rest: Drawn) -> Drawn:
        """Residuals (m, 2n) over their own scatter, if the noise is estimated (Student 1908)."""
        if not self._deals_out:
            return rest
        along = rest @ self.structured.astype(rest.dtype)
        # By the scatter beside structure: with it, large structure would make itself small.
        squares = np.einsum("ij,ij->i", rest, rest) - np.einsum("ij,ij->i", along, along)
        variance = squares / self.rough_dof
        return np.asarray(rest / np.sqrt(np.maximum(variance, 1e-30))[:, None])

    def _in_their_places(self, deviations: NDArray[np.complexfloating]) -> Drawn:
        """Whitened residuals (m, 2n) of deviations (m, n) in units of the noise."""
        turned = deviations * self._turned_phase.astype(np.complex64)
        return np.concatenate([turned.real, turned.imag], axis=-1)

    def _dealt(self, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Rows (count, n) in whose order the deviations are dealt out.

        Within sweeps, whose noise may differ in size.

        Sweeps of a few points are dealt out together, or there would be nothing to deal.
        """
        order = np.tile(np.arange(self.size // 2), (count, 1))
        sweeps = [sweep.rows for sweep in sweeps_of(self.measurement)]
        groups = [rows for rows in sweeps if len(rows) >= DEALT_ALONE]
        groups.append(
            np.concatenate([np.zeros(0, np.int64), *(r for r in sweeps if len(r) < DEALT_ALONE)])
        )
        for rows in groups:
            order[:, rows] = rng.permuted(order[:, rows], axis=1)
        return order

    @property
    def _deals_out(self) -> bool:
        """Whether the data's own scatter is the noise, and there is enough of it."""
        return self.estimated and self.rough_dof >= FEWEST_OWN

    @cached_property
    def _phase(self) -> Complex:
        """K over |K| (n,)."""
        return phase_of(self.model_stiffness, self.measurement)

    @cached_property
    def _turned_phase(self) -> Complex:
        """The same as differences of K are weighed."""
        # Parts of unequal size keep theirs: turned with K they would mix.
        if self.turn is None and np.allclose(self.weights.real, self.weights.imag, atol=0.0):
            return self._phase
        return np.ones_like(self._phase)

    @cached_property
    def _deviations(self) -> Complex:
        """Residual of each point in units of its noise (n,), turned with K, as before the fit.

        Slow structure is left in it: the part without has lost of its peaks what the curves follow,
        loses it once more when it is dealt out, and single points stand out where there is nothing
        (measured: 14 instead of 5 % of pure noise below a chance of 0.05). How large structure
        makes the draws is of no matter, as each is brought to units of its own scatter.
        """
        free = max(self.size - self.absorbed.shape[1], 1)
        real, imag = np.reshape(self.rest, (2, -1)) * np.sqrt(self.size / free)
        links = Links.along([rows for rows, _ in sweeps_of(self.measurement)])
        turned = (real + 1j * imag) / self._turned_phase
        return np.asarray(prewhitened(turned, self.memory, links), dtype=np.complex128)

    def project(self, columns: Real) -> Real:
        """Columns (2n, m) without what the fitted parameters can follow."""
        # In this order: the projection as a matrix would have (2n)^2 entries.
        return projected_out(columns, self.absorbed)

    def beyond(self, columns: Real, least: float = 1e-6) -> Real:
        """Orthonormal basis (2n, q) of columns (2n, m) less what the parameters can follow.

        A column of which less than the share `least` is left is one that they can follow: the rest
        is rounding.
        """
        size = np.linalg.norm(columns, axis=0)
        columns = columns[:, size > 0] / size[size > 0]
        return beyond(columns, self.absorbed, least)

    @cached_property
    def smooth(self) -> Real:
        """Orthonormal basis of slow structure that the parameters cannot follow, shape (2n, q).

        Polynomials along each sweep, in magnitude and in phase: what a missing effect looks like,
        whichever it is. Of so high a degree only that some freedom is left to the scatter: where a
        model of many parameters and the polynomials follow all of few points, the noise would seem
        to be nothing.
        """
        free = self.size - self.absorbed.shape[1]
        for degree in range(SMOOTH_DEGREE, -1, -1):
            basis = self.beyond(self.relative(slow_shapes(self.measurement, degree)))
            if free - basis.shape[1] >= REPEATS.enough:
                return basis
        return np.zeros((self.size, 0))

    @cached_property
    def shared(self) -> Real:
        """Orthonormal basis (2n, q) of what all sweeps share at a frequency and is not slow."""
        columns = self.relative(shared_shapes(self.measurement))
        # Without the slow part, so that no freedom is counted twice in `structured`.
        return self.beyond(projected_out(columns, self.smooth))

    @cached_property
    def common(self) -> Real:
        """Orthonormal basis (2n, q) of slow shapes that all sweeps share."""
        shapes = slow_shapes(self.measurement)
        degrees = len(shapes) // max(1, len(sweeps_of(self.measurement)))
        shared = np.array([shapes[i::degrees].sum(axis=0) for i in range(degrees)])
        return self.beyond(self.relative(shared))

    @cached_property
    def narrow(self) -> Real:
        """Unit columns (2n, m) fixed in Hz, alike in all sweeps.

        One to three neighbouring frequencies of a part.
        """
        which, n = frequency_numbers(self.measurement), len(self.measurement)
        distinct = int(which.max()) + 1
        columns = []
        # Six kinds of columns, of one part and one width each; of very many frequencies evenly
        # placed ones.
        most = MOST_LOCAL // 6
        for width in (1, 2, 3):
            starts = np.arange(distinct - width + 1)
            if len(starts) > most:
                starts = np.linspace(0, distinct - width, most).astype(np.int64)
            inside = ((which[:, None] >= starts) & (which[:, None] < starts + width)).astype(float)
            empty = np.zeros((n, len(starts)))
            columns += [np.concatenate([inside, empty]), np.concatenate([empty, inside])]
        whole = np.concatenate(columns, axis=1)
        left = self.project(whole)
        size = np.linalg.norm(left, axis=0)
        # A share: of one that is there in many sweeps a hundredth is as long as a tenth of a point,
        # and holds more of how the parameters bend than of the noise.
        seen = size > LEAST_LEFT * np.linalg.norm(whole, axis=0)
        return np.asarray(left[:, seen] / size[seen], dtype=np.float64)

    @cached_property
    def trends(self) -> dict[str, Real]:
        """For each condition an orthonormal basis (2n, q) of a trend with it, in size and phase.

        Empty if held.
        """
        bases = {}
        for name in CONDITIONS:
            x = self.condition(name)
            bases[name] = np.zeros((self.size, 0))
            if x is not None:
                bases[name] = self.beyond(self.relative(x[None]), LEAST_SEEN)
        return bases

    def condition(self, name: str) -> Real | None:
        """A varying condition about its mean, over its range, on the scale of a slow change of K.

        Shape (n,).
        """
        column = self.measurement.conditions.get(name)
        # At 0 degC throughout as well: nothing is less than a share of zero.
        if column is None or np.ptp(column) <= HELD_ALIKE * np.max(np.abs(column)):
            return None
        x = column
        # Nonlinear effects go with powers of the amplitude, which is measured over decades.
        if name == "amplitude" and np.all(column > 0):
            x = np.log(column)
        return np.asarray((x - np.mean(x)) / np.ptp(x), dtype=np.float64)

    @cached_property
    def structured(self) -> Real:
        """Orthonormal basis (2n, q) of all that would be no noise.

        Slow along a sweep, or alike in all of them.
        """
        return np.concatenate([self.smooth, self.shared], axis=1)

    @cached_property
    def rough(self) -> Real:
        """Residual (2n,) that neither the parameters nor structure can follow.

        Noise, if all is well.
        """
        return projected_out(self.rest, self.structured)

    @property
    def rough_dof(self) -> int:
        """Degrees of freedom of `rough`."""
        return self.size - int(self.absorbed.shape[1]) - int(self.structured.shape[1])

    def relative(self, shapes: Real) -> Real:
        """Shapes (m, n) as changes of magnitude and of phase, whitened, as columns (2n, 2m)."""
        # Relative to K, as faults of gain and phase are and as noise is: one shape serves over
        # decades of |K|.
        columns = [self.whiten(factor * self.model_stiffness * shapes) for factor in (1.0, 1.0j)]
        return np.concatenate(columns).T


FOLDS = 4
"""Levels or bands left out at most, each by itself."""
FEWEST_LEVELS = 4
"""Levels from which two inner ones can be left out between others."""
BANDS = 6
"""Bands into which a swept condition is divided, or the frequency if no condition differs."""


def folds_of(measurement: Measurement, name: str) -> list[NDArray[np.bool_]]:
    """Rows of a few inner levels of a condition, or of inner bands where it was swept.

    Ends would be extrapolated.
    """
    column = measurement.conditions.get(name)
    if column is None or (name == "temperature" and not temperatures_differ(measurement)):
        return []
    level = measurement.levels(name)
    count = int(level.max()) + 1
    if count < FEWEST_LEVELS:
        return []
    if len(level) >= EVIDENCE.points_of_each * count:
        return [level == number for number in _inner(count)]
    # Bands of what moved with the frequency would be bands of the frequency.
    if name not in telling(measurement):
        return []
    return folds_of_bands(level)


def folds_of_bands(number: NDArray[np.int64]) -> list[NDArray[np.bool_]]:
    """Rows of inner bands of frequencies, or of levels, by their numbers (n,).

    None where they are few.
    """
    distinct = int(number.max()) + 1
    # A band of a single frequency is predicted by its neighbours, whatever the model.
    if distinct < 2 * BANDS:
        return []
    band = number * BANDS // distinct
    return [band == each for each in _inner(BANDS)]


def _inner(count: int) -> list[int]:
    """A few of the numbers 1 to count - 2, evenly."""
    return sorted({round(x) for x in np.linspace(1, count - 2, min(FOLDS, count - 2)).tolist()})


def unseen_error(frame: NoiseFrame, sample: Drawn, name: str) -> Real | None:
    """Squared error (m,) of inner levels of a condition in fits without them.

    From residuals (m, 2n) of full fits.

    To first order what a fit without some rows misses of them is (I - H)^-1 times their residual, H
    being their part of the projection on the parameters (Cook and Weisberg, Residuals and Influence
    in Regression, 1982). What those rows alone determine is left out of it: nothing else predicts
    that.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    sample : ndarray, shape (m, 2n)
        Residuals.
    name : str
        Of the condition.

    Returns
    -------
    ndarray or None
        None where too few levels were measured to leave inner ones out.
    """
    folds = folds_of(frame.measurement, name)
    if not folds:
        return None
    total = np.zeros(len(sample))
    for fold in folds:
        rows = np.flatnonzero(np.tile(fold, 2))
        # By the axes of H, not by a refit of each draw: thousands of draws are asked.
        followed = frame.absorbed[rows]
        axes, shares, _ = np.linalg.svd(followed, full_matrices=False)
        seen = 1.0 - shares**2 > LEAST_LEFT
        # Along an axis of which the parameters follow the share h, 1 / (1 - h) of the residual is
        # missed.
        gain = np.where(seen, 1.0 / np.where(seen, 1.0 - shares**2, 1.0), 0.0)
        part = sample[:, rows].astype(np.float64)
        along = part @ axes
        total += np.einsum("ij,ij->i", part, part) + (along**2) @ (gain**2 - 1.0)
    return total
