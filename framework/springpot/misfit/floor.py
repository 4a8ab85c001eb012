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

from springpot.distributions import (
    FittedMemory,
    deviance,
    effective_share,
    f_quantile,
    f_sf,
    fitted_memory,
)
from springpot.identification.searching import STARTS as STARTS_AGAIN
from springpot.measurement.independence import SMOOTH_DEGREE
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import longest_memory, settings_of, sweeps_of
from springpot.measurement.replicates import Averaged, average_repeats, noise_of_repeats
from springpot.measurement.scatter import (
    Noise,
    Scatter,
    beside_given,
    checked_noise,
    noise_shape,
    plausible_variance,
    robust_noise_shape,
    student_cost,
)
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real, real_form
from springpot.thresholds import REPEATS, SCATTER, SEARCH, SIGNALS, VERDICT

from ..numerics import SMALLEST, orthonormal, projected_out
from .frame import (
    ENOUGH_NEIGHBOURS,
    FEWEST_OWN,
    LEAST_LEFT,
    LEAST_SEEN,
    NoiseFrame,
    is_beyond_noise,
    phase_of,
)
from .outliers import MOST_TURNS, Trimmed, trimmed
from .refit import Refit, in_noise, refit

STARTS = 16
"""Starts of a first fit, of whose parameters nothing is known."""
LEAST_RISE = 0.01
"""Relative change of noise over |K| along a sweep from which its shape is not that of |K|."""
ROUNDS = 2
"""Times that the noise is estimated anew about the fit that it gave."""
DIFFERENCES = (2, 3, 4, 5)
"""Orders of the differences.

Of a ripple of 8 points the second leave 59 % and the fifth 26 % of its size. Those of
order k are worth C(2k,k)^2 / C(4k,2k) degrees of freedom each, as neighbouring ones share points.
"""
LEAST_SPARE = 0.4
"""Share of the numbers that a model leaves over before its scatter says anything.

Of nine points a free spectrum, a
filter and a resonance follow the noise to a fiftieth of it."""


class MisfitShapes(NamedTuple):
    """Misfits of s shapes, each of m functions along the points that gain and phase may follow.

    They are known by their products, summed over the points.

    Attributes
    ----------
    along : ndarray, shape (s, m, 2, c)
        With columns, of which the first is the residual.
    squares : ndarray, shape (s, m, 2, m, 2)
        With one another.
    """

    along: Real
    squares: Real

    @classmethod
    def of_sweeps(cls, along: Real, squares: Real) -> MisfitShapes:
        """Shapes of another size in each of l sweeps: so many times as many functions.

        By the sums over each sweep, (l, s, m, 2, c + 2) and (l, s, m, m, 2, 2); the last columns
        are gain and phase.
        """
        apart = np.einsum("lk,lsmtab->slmaktb", np.eye(len(squares)), squares)
        s, lines, m = apart.shape[:3]
        inner = np.moveaxis(along[..., :-2], 0, 1).reshape(s, lines * m, 2, -1)
        return cls(inner, apart.reshape(s, lines * m, 2, lines * m, 2))

    def explained(self, of: slice) -> tuple[Real, NDArray[np.int64]]:
        """Shares (s,) of the residual that gain, phase or both follow beside the other columns.

        And by how many numbers each does.
        """
        along, squares = self.along[:, :, of], self.squares[:, :, of, :, of]
        count = along.shape[1] * along.shape[2]
        rest, beside = np.split(along.reshape(len(along), count, -1), [1], axis=2)
        squares = squares.reshape(-1, count, count)
        # Functions of one size, so that what is hardly seen of one is told by a share.
        size = np.sqrt(np.maximum(np.einsum("sqq->sq", squares), SMALLEST))[:, :, None]
        rest, beside, squares = rest / size, beside / size, squares / size / size.transpose(0, 2, 1)
        # The residual has no part in the other columns: only the functions lose what these follow.
        sizes, ways = np.linalg.eigh(squares - beside @ beside.transpose(0, 2, 1))
        seen = sizes > LEAST_SEEN**2
        told = np.einsum("sqk,sq->sk", ways, rest[:, :, 0]) ** 2
        return np.sum(told / np.where(seen, sizes, np.inf), axis=1), np.sum(seen, axis=1)


def fitted_to_floor(model: Model, measurement: Measurement, seeds: Sequence[Real] = ()) -> Refit:
    """Fit `model` to the averaged data, in units of a noise floor found on the way.

    Repeats tell the noise best; given standard deviations are checked against the data's own
    scatter; without either the scatter about slow curves is taken, which says at most how large the
    noise is.

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
    told = scatter_about(first.frame())
    noise = checked_noise(first.noise, told.variance, told.dof)
    if noise is first.noise:
        noise = _beside_given(first, told)
    else:
        # A notch drags the curve, and all else seems to scatter: that is no reason to doubt what
        # was given.
        told = scatter_about(undragged(first)[0].frame())
        noise = checked_noise(first.noise, told.variance, told.dof)
    noise = replace(noise, memory=told.memory)
    return replace(first, noise=noise) if noise.source == "given" else in_noise(first, noise)


def _beside_given(fitted: Refit, told: ScatterAbout) -> Noise:
    """The noise of a fit as given, or raised where its scatter is larger than what was given."""
    frame, noise = fitted.frame(), fitted.noise
    left = noise.of_whitened(trimmed(frame).left / np.sqrt(_left_over(frame)))
    return beside_given(noise, fitted.data.mean, left, told.dof)


def likelihood_of_all(fitted: Refit) -> float:
    """Log-likelihood of a fit with its own noise, of whatever size, less the price of its numbers.

    Noise of another shape or memory makes the same data more or less likely.
    """
    frame, parts = fitted.frame(), fitted.noise.parts
    cost, _ = deviance(frame.residual[:, None], fitted.noise.memory, frame.links)
    price = (frame.size - fitted.dof) * float(np.log(frame.size))
    return -0.5 * (cost + price) - float(np.sum(np.log(parts.real * parts.imag)))


def beyond_floor(fitted: Refit) -> bool:
    """Whether an error is beyond the noise floor by more than chance.

    The floor of an estimated noise leaves out the few frequencies that are far off, and simulated
    noise has their long tails too: no test sees them, and yet the model does not go through them.
    """
    return is_beyond_noise(_over(fitted), fitted.error_dof, fitted.noise.dof)


def below_floor(fitted: Refit, certain: bool) -> bool:
    """Whether an error is so far below a floor of the data that nothing is told in its units.

    Where an alarm is beyond doubt (`certain`), only if chance does not take it there: then the
    floor is wrong.
    """
    # Where given deviations were smaller, structure passed for scatter: what tests see is there.
    if fitted.noise.source != "estimated" or fitted.noise.overruled:
        return False
    ratio = _over(fitted)
    chance = f_sf(ratio**-2, fitted.noise.dof, fitted.error_dof)
    return bool(ratio < VERDICT.below and (not certain or chance < VERDICT.structure_alarm))


def is_arithmetic(fitted: Refit) -> bool:
    """Whether an error is that of arithmetic, on more points than anything would follow.

    The data were computed.
    """
    return (
        fitted.relative_rms < VERDICT.arithmetic
        and len(fitted.fit.measurement) > VERDICT.fewest_spare
    )


def is_hardly_known(fitted: Refit) -> bool:
    """Whether so few numbers are left over that neither the error nor the floor says anything.

    Of an estimate with three degrees of freedom an error of six floors is still no surprise.
    """
    return min(fitted.fit.dof, fitted.noise.dof) < VERDICT.fewest_spare


def as_given(base: Refit) -> Refit:
    """The fit in units of the given standard deviations, though they were doubted."""
    assert base.data.mean.sd is not None, "only what was given can be doubted"
    given = Noise(base.data.mean.sd, inf, "given", memory=base.noise.memory)
    return in_noise(base, given, STARTS_AGAIN)


def borne_out(best: Refit) -> bool:
    """Whether the scatter about a good model is as large as its noise says."""
    told = scatter_about(best.frame())
    if told.variance >= plausible_variance(told.dof)[1]:
        return False
    return _beside_given(best, told) is best.noise


def _estimated(model: Model, data: Averaged, seeds: Sequence[Real]) -> Refit:
    size, everything = data.mean.magnitude, np.ones(len(data.mean), dtype=bool)
    # Proportional to |K| to begin with: both parts alike, and no frequency outweighs the others.
    first = refit(
        model, data, Noise(np.asarray(size + 1j * size), 1.0, "estimated"), seeds, starts=STARTS
    )
    usual = _in_rounds(first)
    # What noise would nearly explain, of a law that the others allow, is no misfit yet.
    if _over(usual) > VERDICT.misfit and not np.all(telling(usual.frame())):
        cautious = _in_rounds(first, cautious=True)
        if _over(cautious) <= VERDICT.small_rest:
            usual = cautious
    # Before anything is set aside: where a rig is noisier at the ends of its range, these points
    # are no outliers.
    shape = next(_shapes(first, data.mean, everything, uneven=True))
    relative = real_form(shape.parts) / np.concatenate([size, size])
    if np.ptp(relative) < LEAST_RISE * np.min(relative):
        return usual
    # Beside a model that is far off its misfit would be taken for noise that rises where it fails;
    # but noise that does rise is more than what its quiet points tell, and these are not missed.
    risen = _in_rounds(in_noise(first, shape), uneven=True)
    if usual.relative_rms > VERDICT.small_rest * max(usual.floor, risen.floor):
        return usual
    if _over(usual) > VERDICT.small_rest and _misses_where_quiet(usual, shape):
        return usual
    # The first fit was in units of |K|, and where it misses for that the scatter seems to rise.
    return min((risen, usual), key=_cost_of_scatter)


def _over(fitted: Refit) -> float:
    """The error in units of the noise floor."""
    return fitted.relative_rms / fitted.floor


def _misses_where_quiet(fitted: Refit, shape: Noise) -> bool:
    """Whether a fit is far off at that half of the points where a noise of this shape is least."""
    measured = fitted.data.mean
    size = np.abs(shape.parts) / measured.magnitude
    quiet = size <= np.median(size)
    misfit, told = (
        np.sum(np.abs(each / measured.magnitude)[quiet] ** 2)
        for each in (fitted.stiffness - measured.stiffness, fitted.noise.parts)
    )
    return bool(misfit > VERDICT.small_rest**2 * told)


def _in_rounds(fitted: Refit, uneven: bool = False, cautious: bool = False) -> Refit:
    """The fit in units of a noise that is estimated about it, in turns; see `_shapes`."""
    free, data = fitted, fitted.data
    inside = np.ones(len(data.mean), dtype=bool)
    for _ in range(ROUNDS):
        tried = [
            _scaled(fitted, shape) for shape in _shapes(free, data.mean, inside, uneven, cautious)
        ]
        # Each way says at most how large the noise is: of one shape the smaller is the better
        # bound, and of two shapes that under which the scatter without ripples is the likelier.
        best = 0
        if len(tried) > 1:
            best = int(np.argmin([_cost_of_scatter(one[0]) for one in tried]))
        fitted, free, inside = tried[best]
    return fitted


def _cost_of_scatter(fitted: Refit) -> float:
    """Minus twice the log-likelihood of a fit's scatter, whatever stands out of it."""
    frame, noise = fitted.frame(), fitted.noise
    left = noise.of_whitened(trimmed(frame).left / np.sqrt(_left_over(frame)))
    return student_cost(noise.parts, left if noise.turn is None else left * noise.turn)


def _scaled(before: Refit, shape: Noise) -> tuple[Refit, Refit, NDArray[np.bool_]]:
    """The fit in units of a noise of this shape and of the size that the scatter gives it.

    See `undragged`.
    """
    shaped = in_noise(before, shape)
    # The shape first and then its size: what stands out is told beside a fit in units of the right
    # shape.
    free, inside = undragged(shaped)
    variance, dof, memory = scatter_about(free.frame())
    noise = replace(shape.scaled(float(np.sqrt(variance))), dof=dof, memory=memory)
    # Of all points again: those that stand out are left out of the noise, not of the data.
    return in_noise(shaped, noise.at_least_rounding(before.data.mean)), free, inside


def undragged(fitted: Refit) -> tuple[Refit, NDArray[np.bool_]]:
    """The fit to what does not stand out, and which points (n,) that is.

    A notch or a bad point drags the curve, and all else then seems to scatter. Those that stand out
    are found anew beside the curve that is free of them (Rousseeuw 1984, least trimmed squares,
    doi:10.1080/01621459.1984.10477105).
    """
    n = len(fitted.fit.measurement)
    free, followed = fitted, np.ones(n, dtype=bool)
    inside = trimmed(fitted.frame()).kept[:n]
    for _ in range(MOST_TURNS):
        if np.array_equal(inside, followed):
            break
        free, followed = fitted.without(~inside), inside
        # The curve of the others at all points: one that was left out may come back in.
        of_all = replace(fitted, fit=replace(free.fit, measurement=fitted.fit.measurement))
        inside = trimmed(of_all.frame(), followed).kept[:n]
    return free, followed


def sharpened(base: Refit, best: Refit) -> Refit | None:
    """The base model refitted in units of a better model's scatter, where that is much smaller.

    Or where it goes on from point to point or depends on the point otherwise, which beside the
    misfit was not to be seen.

    Where conditions differ from point to point there are no smooth curves whose scatter could be
    taken, and the misfit of a wrong model passes for noise; the scatter about a model that explains
    it cannot.

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
    if base.noise.source != "estimated" or dof < max(
        VERDICT.fewest_spare, LEAST_SPARE * frame.size
    ):
        return None
    everything = np.ones(frame.size, dtype=bool)
    noise = _of_residual(best, Trimmed(frame.rest, everything, float(dof)))
    noise = replace(noise, memory=scatter_about(frame).memory)
    sharper = base.data.floor(noise) < SCATTER.sharper * base.data.floor(base.noise)
    # A misfit hides that neighbours go together, and each is worth less than was thought.
    sharper |= noise.worth < SCATTER.sharper * base.noise.worth
    # Whether noise goes along K or across it only a model that leaves nothing else can tell.
    other_axes = (noise.along is None) != (base.noise.along is None) and not beyond_floor(best)
    if not sharper and not other_axes and not _is_likelier(noise, best):
        return None
    return in_noise(base, noise, STARTS_AGAIN)


def _is_likelier(noise: Noise, fitted: Refit) -> bool:
    """Whether noise of this shape, of whatever size, makes a fit's data decisively likelier.

    And their scatter about slow curves no less likely: a level of one temperature that a model
    leaves is in K' alone, and would pass for noise that is larger there.
    """
    shaped = in_noise(fitted, noise)
    gain = likelihood_of_all(shaped) - likelihood_of_all(fitted)
    return 2.0 * gain >= SEARCH.decisive and _cost_of_scatter(shaped) <= _cost_of_scatter(fitted)


def _shapes(
    free: Refit,
    measurement: Measurement,
    inside: NDArray[np.bool_],
    uneven: bool,
    cautious: bool = False,
) -> Iterator[Noise]:
    """Noise with the dependence on the point that the scatter about slow curves favours.

    Its size comes later.

    Where a ripple or a drift is seen in that scatter, also without it: its storage and its loss
    would be taken for the sizes of the noise in both.

    Parameters
    ----------
    free : Refit
        The fit to the points that do not stand out.
    measurement : Measurement
        All points.
    inside : ndarray of bool, shape (n,)
        Those that do not.
    uneven : bool
        Whether the noise may be larger in some part of the measurement, or of another size in K'
        and K''.
    cautious : bool
        Whether points whose noise nothing tells are to have as much as may be.
    """
    frame = free.frame()
    scatters = [frame.rough]
    left = trimmed(frame).left
    # Within rounding it is the same scatter, and a second fit of the same shape would cost time for
    # nothing.
    if not np.allclose(
        left, frame.rough, atol=1e-6 * float(np.max(np.abs(frame.rough), initial=0.0))
    ):
        scatters.append(left)
    left_of_noise, tell = np.sqrt(_left_over(frame)), telling(frame)
    rows, untold = np.flatnonzero(inside)[tell], np.flatnonzero(inside)[~tell & cautious]
    for scatter in scatters:
        rough = free.noise.of_whitened(scatter / left_of_noise)[tell]
        axes = turn_of(free, measurement)
        sd, turn = robust_noise_shape(measurement, rough, rows, uneven, axes, untold.tolist())
        noise = Noise.shaped(sd, turn, float(max(frame.rough_dof, 1)), "estimated")
        yield noise.at_least_rounding(measurement)


def _left_over(frame: NoiseFrame) -> Real:
    """The share (2n,) of their noise that slow curves leave to the points.

    Curves bow to the ends of a sweep: what they leave there is less than the noise by as much as
    they follow.
    """
    followed = np.sum(frame.absorbed**2, axis=1) + np.sum(frame.structured**2, axis=1)
    return np.asarray(np.maximum(1.0 - followed, LEAST_LEFT), dtype=np.float64)


def telling(frame: NoiseFrame) -> NDArray[np.bool_]:
    """Which points (n,) tell their noise.

    One far from the others, such as the first of frequencies in equal steps, is followed whatever
    its noise: it would seem to have none, and the noise to rise from there.
    """
    tell = np.all(np.reshape(_left_over(frame) > LEAST_LEFT, (2, -1)), axis=0)
    return np.asarray(tell | (not np.any(tell)), dtype=np.bool_)


def turn_of(fitted: Refit, measurement: Measurement) -> Complex:
    """Unit numbers (n,) that turn K of a fitted model to the real axis."""
    # The model's, not the measured one: a point's own error would turn its axes, and of the larger
    # part put the square into the other.
    stiffness = fitted.model.stiffness(fitted.theta, measurement.points)
    return np.asarray(np.conj(phase_of(stiffness, measurement)), dtype=np.complex128)


def _of_residual(fitted: Refit, scatter: Trimmed) -> Noise:
    """Noise of the shape and size of a whitened scatter; points set aside say nothing of it."""
    n = len(scatter.left) // 2
    left = fitted.noise.of_whitened(np.where(scatter.kept, scatter.left, 0.0))
    each: Real = scatter.dof / float(np.sum(scatter.kept)) * scatter.kept.astype(np.float64)
    data = fitted.data.mean
    axes = turn_of(fitted, data)
    plain, turned = (Scatter.of(value, each[:n]) for value in (left, left * axes))
    sd, turn = noise_shape(data, plain, turned, axes)
    return Noise.shaped(sd, turn, scatter.dof, "estimated").at_least_rounding(data)


class ScatterAbout(NamedTuple):
    """What the scatter about a fit tells of whitened noise.

    Attributes
    ----------
    variance, dof : float
        How large it is, and by how many independent numbers that is told.
    memory : float
        Correlation of neighbours in a sweep.
    """

    variance: float
    dof: float
    memory: float = 0.0


def scatter_about(frame: NoiseFrame) -> ScatterAbout:
    """Noise by the scatter that neither the fit nor structure can follow.

    A ripple too fast for the slow curves, or a drift of a measurement whose frequencies were taken
    in random order, would pass for scatter. But neighbours, along a sweep or from row to row, share
    most of it: where their differences vary by much less (von Neumann et al. 1941,
    doi:10.1214/aoms/1177731746), these tell the noise.
    """
    scatter = trimmed(frame)
    found = autoregressive(frame, scatter.kept)
    if found is not None:
        about = ScatterAbout(float(found.new @ found.new) / found.free, float(found.free))
        # What is new with each point is white, or it is a misfit.
        if _by_neighbours(frame.measurement, found.new, about) is about:
            worth = effective_share(found.memory**2)
            return ScatterAbout(about.variance, worth * found.free, found.memory)
    # Where a free spectrum has as many lines as there are numbers, all of the noise is followed:
    # none is left over.
    kept = max(1.0 - frame.absorbed.shape[1] / frame.size, 1.0 / frame.size)
    first = ScatterAbout(scatter.variance, float(max(frame.rough_dof, 1)))
    return _by_neighbours(frame.measurement, frame.rest / np.sqrt(kept), first)


def _by_neighbours(measurement: Measurement, rest: Real, about: ScatterAbout) -> ScatterAbout:
    """The same, if differences of neighbours in whitened values (2n,) do not vary by much less."""
    along_sweeps, n = [sweep.rows for sweep in sweeps_of(measurement)], len(measurement)
    for lines in (along_sweeps, [np.arange(n)]):
        parts = [rest[rows + k] for rows in lines for k in (0, n)]
        for order in DIFFERENCES:
            left = np.concatenate([np.zeros(0), *(np.diff(part, order) for part in parts)])
            power = comb(2 * order, order)
            efficient = len(left) * power**2 / comb(4 * order, 2 * order)
            if efficient < ENOUGH_NEIGHBOURS:
                continue
            near = float(np.mean(left**2)) / power
            # Only where it is smaller beyond chance: the least of several estimates of white noise
            # is too small.
            if near < about.variance * f_quantile(SIGNALS.ruled_out, efficient, about.dof):
                about = ScatterAbout(near, efficient)
    return about


def remembered(base: Refit, gain: float) -> Refit | None:
    """The base model in noise with a memory, if that makes its residual likelier than a rival does.

    Parameters
    ----------
    base : Refit
        The user's model.
    gain : float
        Twice the logarithm of how much likelier the rival is than white noise alone.

    Returns
    -------
    Refit or None
        None where the rival is likelier, or the noise has its memory already.
    """
    if base.noise.memory or base.noise.source == "repeats":
        return None
    frame = base.frame()
    found = autoregressive(frame, trimmed(frame).kept, alone=True)
    if found is None or found.gain < gain:
        return None
    noise = replace(base.noise, memory=found.memory)
    if base.noise.source == "estimated":
        size = float(np.sqrt(found.new @ found.new / found.free))
        noise = replace(noise.scaled(size), dof=effective_share(found.memory**2) * found.free)
    return in_noise(base, noise, STARTS_AGAIN)


def autoregressive(
    frame: NoiseFrame, kept: NDArray[np.bool_], alone: bool = False
) -> FittedMemory | None:
    """Noise with a first-order memory along the sweeps; None where white noise is as likely.

    Or white noise beside one of `_misfits`. A number more costs what the Bayesian information
    criterion charges. What `kept` (2n,) leaves out has a number of its own.
    """
    single = np.arange(frame.size)[:, None] == np.flatnonzero(~kept)
    followed = orthonormal(np.concatenate([frame.absorbed, single], axis=1))
    # By itself where other sweeps show that it is no misfit, and beside all slow structure.
    others = bool(frame.shared.shape[1])
    nothing = [np.zeros((frame.size, 0))] if others or alone else []
    longest = longest_memory(sweeps_of(frame.measurement))
    for curves in (*nothing, frame.structured):
        beside = orthonormal(np.concatenate([followed, curves], axis=1))
        if frame.size - beside.shape[1] < FEWEST_OWN:
            continue
        found = fitted_memory(np.column_stack([beside, frame.residual]), frame.links, longest)
        # Unless other sweeps show that it is not, what is so slow is a misfit.
        told = found.gain > 0.0 and (others or found.likeliest <= longest)
        if told and found.gain > _best_misfit(frame, beside):
            return found
    return None


def _best_misfit(frame: NoiseFrame, followed: Real) -> float:
    """By how much the best misfit raises twice the log-likelihood beside what is followed.

    Of gain or phase or both, with the price of its numbers and of which of all it is.
    """
    rest = projected_out(frame.residual, followed)
    free, tried = frame.size - followed.shape[1], 0
    faults = frame.relative(np.ones((1, frame.size // 2)))
    # A shape is the same in both parts of a point: their sum is taken once for all shapes.
    columns = np.column_stack([rest / max(float(np.linalg.norm(rest)), SMALLEST), followed, faults])
    products = (faults[:, :, None] * columns[:, None, :]).reshape(2, -1, 2, columns.shape[1])
    best = 0.0
    gain, phase, both = slice(0, 1), slice(1, 2), slice(0, 2)
    for shapes in _misfits(frame.measurement, products.sum(axis=0)):
        # As noise itself is told, beside what leaves enough of it.
        if free - 2 * shapes.along.shape[1] < REPEATS.enough:
            continue
        tried += len(shapes.along)
        for part in (gain, phase, both):
            explained, ranks = shapes.explained(part)
            gains = -free * np.log(np.maximum(1.0 - explained, SMALLEST)) - ranks * np.log(free)
            best = max(best, float(np.max(gains)))
    return best - 2.0 * float(np.log(max(tried, 1)))


def _misfits(measurement: Measurement, products: Real) -> Iterator[MisfitShapes]:
    """Shapes that a misfit may have: slow ones, humps and ripples along sweeps.

    Alike in all sweeps, or of another size in each; and those of a column that no effect knows.

    Parameters
    ----------
    measurement : Measurement
        The data.
    products : ndarray, shape (n, 2, c + 2)
        Gain and phase at each point times some columns, of which these two are the last.
    """
    n, together = len(measurement), np.arange(len(measurement))[None]
    x, apart = _side_by_side(measurement)
    products = np.concatenate([products, np.zeros((1, *products.shape[1:]))])
    slow = np.asarray(
        np.polynomial.legendre.legvander(2.0 * x - 1.0, SMOOTH_DEGREE).T, dtype=np.float64
    )
    for lines in (together, apart)[: len(apart)]:
        of_lines = products[lines]
        for degree in range(SMOOTH_DEGREE + 1):
            yield MisfitShapes.of_sweeps(*_summed(slow[None, : degree + 1, lines], of_lines))
        for sums in _along(x[lines], of_lines, apart.shape[1]):
            yield MisfitShapes.of_sweeps(*sums)
    for number in settings_of(measurement).values():
        at_each = (number == np.arange(int(number.max()) + 1)[:, None]).astype(np.float64)
        # At each value of a column a level, a slope or a bend; or one that grows along the column.
        for way in (at_each, (number - np.mean(number))[None]):
            for degree in range(3):
                shapes = (slow[: degree + 1, None, :n] * way).reshape(1, -1, 1, n)
                yield MisfitShapes.of_sweeps(*_summed(shapes, products[together]))


def _side_by_side(measurement: Measurement) -> tuple[Real, NDArray[np.intp]]:
    """Place (n + 1,) of each row along its sweep, from 0 to 1, and the rows (s, m) of each sweep.

    One row more, an empty one, in which sweeps of fewer points end.
    """
    sweeps, n = sweeps_of(measurement), len(measurement)
    x = np.zeros(n + 1)
    lines = np.full((len(sweeps), max(len(rows) for rows, _ in sweeps)), n)
    for line, (rows, along) in zip(lines, sweeps, strict=True):
        line[: len(rows)], x[rows] = rows, along
    x[n] = x[:n].min()
    return (x - x[n]) / max(float(np.ptp(x)), SMALLEST), lines


def _summed(shapes: Real, products: Real) -> tuple[Real, Real]:
    """What `of_sweeps` takes, of a few shapes (s, m, l, j); products (l, j, 2, c + 2)."""
    sums = np.einsum("smlj,ljac->lsmac", shapes, products, optimize=True)
    pairs = shapes[:, :, None] * shapes[:, None]
    return sums, np.einsum("smtlj,ljab->lsmtab", pairs, products[..., -2:], optimize=True)


def _along(x: Real, products: Real, longest: int) -> Iterator[tuple[Real, Real]]:
    """The same of half waves and of humps at places (l, j), all of them by one transform."""
    # Cells a quarter as wide as the points are apart, and as many again thrice behind a sweep.
    cells = 4 * max(longest - 1, 1)
    lines = np.zeros((len(x), cells + 1, *products.shape[2:]))
    np.add.at(lines, (np.arange(len(x))[:, None], np.rint(cells * x).astype(np.int64)), products)
    spectrum = np.fft.rfft(lines, 4 * cells, axis=1)
    # In half waves along a sweep, and twice as fine as these are independent.
    turns = np.arange(4, 2 * longest + 1)
    once, twice, mean = spectrum[:, turns], spectrum[:, 2 * turns, :, -2:], spectrum[:, :1, :, -2:]
    pairs = np.stack([mean + twice, 1j * twice, 1j * twice, mean - twice], axis=2).real
    yield (
        np.stack([once.real, -once.imag], axis=2),
        0.5 * pairs.reshape(*pairs.shape[:2], 2, 2, 2, 2),
    )
    # Humps a quarter of a sweep wide, and each time half as wide, down to half a point; in steps of
    # half of it, at which a transform cut off where they have no part is told.
    many = 32
    while 16 * longest > many:
        omega = 4.0 * np.pi / many * np.arange(many // 2 + 1)
        faded = np.exp(-0.5 * omega**2)[:, None, None]
        part = spectrum[:, : many // 2 + 1]
        sums, squares = (
            np.fft.irfft(each, many, axis=1)[:, : many // 4 + 2, None]
            for each in (np.sqrt(2.0) * faded * part, np.sqrt(faded) * part[..., -2:])
        )
        yield np.sqrt(4.0 * np.pi) * sums, np.sqrt(4.0 * np.pi) * squares[:, :, None]
        many *= 2
