"""What of an ordered residual is noise, white or with a memory, and what is too slow to be either.

A model that lacks something leaves a misfit that is smooth over many samples. Noise of a filtered
transducer has a memory too, of a few samples. So the noise is read from the upper part of the
residual's spectrum alone, as an autoregression of first order, and what lies above its continuation
at low frequencies is misfit. Fitted by Whittle's likelihood (Whittle 1953, doi:10.1007/BF02590998)
of the cosine transform, which fades no sample: what is missed at an end counts as all else does.

Noise neither repeats with the motion that was imposed nor knows where the specimen is: what does is
misfit. But noise of the imposed channel is answered by a model and was never felt by the specimen.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view as windows
from numpy.typing import NDArray

from springpot.distributions import (
    autoregressive,
    chi2_sf,
    effective_share,
    normal_score,
    normal_sf,
    prewhitened,
    spectrum_of,
)
from springpot.measurement.instrument import LINE
from springpot.measurement.scatter import tails_of
from springpot.measurement.timenoise import FEWEST as FEWEST_OF_SCATTER
from springpot.rheology.points import Real
from springpot.thresholds import SIGNALS, WHERE

from ..numerics import (
    FOURTH_WORTH,
    MEDIAN_WORTH,
    NORMAL,
    SMALLEST,
    projected_out,
    rms,
)
from .coloured_noise import (
    LEVEL,
    SLOWEST,
    UPPER,
    Colour,
    Imposed,
    colour_of,
    fisher_test,
    frequencies,
    motion_test,
    period_test,
    step_test,
    transformed,
)
from .frame import chance_of_squares

FEWEST = 40
"""Samples below which a spectrum tells nothing.

Then the noise of the signal is believed, and taken as white.
"""
MEMORIES = np.linspace(0.0, 0.7, 36)
"""Correlations of neighbours that are tried.

Beyond 0.7 what is alike over five samples and more is no noise.
"""
GROUPS = 4
"""Octaves below the upper part, each with a size of its own where there is a misfit."""
TENFOLD = 6.0
"""Rise of twice the log of the likelihood ratio that noise alone reaches ten times less often.

Of simulated records of noise, 40 to 1,000 samples with memories from 0 to 0.6, one in a hundred
exceeds 12 and one in a thousand 18."""
PARTS = 16
"""Parts of a record of which each alone may be missed."""
NEIGHBOURS, ROUGHER = 15, 2.0
"""Samples of which the differences of neighbours tell whether the noise is larger there, and ratio
to the usual ones from which it is."""
TAILS = 3.0
"""Standard deviations of noise to which a sample is cut before a jump is looked for: one that is
further off, and not in the middle of others, is an outlier."""
EFFICIENT = 18.0 / 35.0
"""Efficiency of second differences (von Neumann et al. 1941, doi:10.1214/aoms/1177731746)."""


@dataclass(frozen=True)
class ResidualScatter:
    """Noise in a residual.

    Attributes
    ----------
    size : float
        Standard deviation, in units of the residual.
    memory : float
        Correlation of neighbouring samples; that of samples k apart is its k-th power.
    excess : float
        Twice the logarithm by which a misfit beside the noise is likelier than noise alone.
    local : float
        Chance that noise alone would miss some part of the record as much as the worst one is.
    worth : float
        Independent numbers that tell the size; endless where it is known, or read from what is
        left.
    colour : Colour or None
        Its spectrum, where that of a first-order memory is plainly another.
    """

    size: float
    memory: float
    excess: float
    local: float
    worth: float = np.inf
    colour: Colour | None = None

    @property
    def presumed(self) -> bool:
        """Whether it is what the signal tells, of which few samples change no bit."""
        return self.size == 1.0

    @property
    def chance(self) -> float:
        """That noise alone leaves so much, as a whole or in some part."""
        return min(float(10.0 ** (-max(self.excess, 0.0) / TENFOLD)), self.local)

    @property
    def misfit(self) -> bool:
        """Whether there is plainly more than noise."""
        return self.chance < SIGNALS.ruled_out

    @property
    def doubtful(self) -> bool:
        """Whether there may well be more than noise."""
        return self.chance < WHERE.levels_differ

    def chance_of(self, residual: Real, other: ResidualScatter) -> float:
        """That noise of this size leaves as much as a residual (n,), in which there is `other`.

        The size is hardly known better than from a record as long as this one.
        """
        count = min(each.independent_squares(len(residual)) for each in (self, other))
        squares = count * times_noise(residual, self.size) ** 2
        return chance_of_squares(squares, count, min(self.worth, count))

    def independent_squares(self, count: int) -> float:
        """So many of the squares of `count` samples are independent (Satterthwaite 1946)."""
        if self.colour is None:
            return count * effective_share(self.memory**2)
        spectrum = self.colour.spectrum(frequencies(count))
        return float(np.sum(spectrum)) ** 2 / float(np.sum(spectrum**2))

    def squares(self, residual: Real, *stories: ResidualScatter) -> float:
        """As `deviance`; where it may as well be noise of another story's colour, over that noise.

        Each story is one of the noise that some fit leaves, and excuses nothing if that is misfit.
        """
        least, n = self.deviance(residual), len(residual)
        for own in stories:
            if own.colour is not None and not own.misfit:
                # The likelihood of a wider noise is less by the determinant, and each number of its
                # spectrum has a price.
                here, there = (each.spectrum(n) for each in (self, own))
                wider = float(np.sum(np.log(there / here))) + own.colour.count * np.log(n)
                least = min(least, float(own.deviance(residual) + max(wider, 0.0)))
        return least

    def spectrum(self, count: int) -> Real:
        """Variance of each number of the cosine transform of `count` samples."""
        if self.colour is None:
            return spectrum_of(frequencies(count), self.size, self.memory)
        return self.colour.spectrum(frequencies(count))

    def deviance(self, residual: Real) -> float:
        """Minus twice the logarithm of the likelihood of a residual (n,), but for a constant.

        That of Student where the size of the noise is itself uncertain: then a residual that is
        large throughout speaks for more noise too. What is less than the noise is no likelier than
        the noise: there is nothing left to explain.
        """
        squares = max(float(np.sum(self.whitened(residual) ** 2)), float(len(residual)))
        if np.isinf(self.worth):
            return squares
        return (len(residual) + self.worth) * float(np.log1p(squares / self.worth))

    def whitened(self, residual: Real) -> Real:
        """A residual of which noise would leave independent numbers of variance one."""
        if self.colour is not None:
            return transformed(residual) / np.sqrt(self.spectrum(len(residual)))
        return np.asarray(prewhitened(residual, self.memory) / self.size, dtype=float)


def scatter_of(
    residual: Real, usual: float = 0.0, worth: float = 0.0, beside: Real | None = None
) -> ResidualScatter:
    """The noise in a residual over its presumed noise.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Of one test, sample after sample.
    usual : float
        Excess that is no misfit, as of rounding that repeats itself.
    worth : float
        Independent numbers that tell the presumed noise, if others than these do.
    beside : ndarray, shape (m,), optional
        Variance that there may be beside the noise, at frequencies of its cosine transform.

    Returns
    -------
    ResidualScatter
        Of few samples: white noise of the presumed size.
    """
    residual = residual[_unrepeated(residual)]
    n = len(residual)
    if n < FEWEST:
        worth = max(0.5 * MEDIAN_WORTH * n, worth)
        chance = chance_of_squares(float(residual @ residual), n, worth)
        return ResidualScatter(1.0, 0.0, 0.0, chance, worth)
    power, omega = powers(residual)
    alone, above = _fitted(power), _fitted(power, upper=True)
    # Three stories: noise alone at all frequencies, noise above and something smooth below, or
    # noise and one jump. The likeliest one is believed.
    excess = 2.0 * max(_gain_of_smooth_misfit(residual), _gain_of_jump(residual))
    found = ResidualScatter(*alone, excess - usual, _chance_of_worst_part(residual, above[1]))
    if found.doubtful:
        colours = [_colour_beside(residual, power, spectrum_of(omega, *above))]
        if beside is not None:
            colours.append(Colour.of_memory(*above, beside))
        told = [_coloured(residual, colour, found, usual) for colour in colours if colour]
        # Another colour may excuse what a memory does not, and accuses of nothing.
        coloured = max(told, key=lambda each: each.chance, default=found)
        if coloured.chance > found.chance:
            return coloured
    return replace(found, size=above[0], memory=above[1]) if found.misfit else found


def scatter_of_record(
    residual: Real, rounded: Real, imposed: Imposed, worth: float, followed: float = 0.0
) -> ResidualScatter:
    """The same of a record: noise does not go with the motion, as rounding does.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Over the presumed noise.
    rounded : ndarray, shape (z, n)
        Errors of rounding, of a channel with few values.
    imposed : Imposed
        The motion.
    worth : float
        Independent numbers that tell the presumed noise.
    followed : float
        So many of the numbers a model has followed.
    """
    power = float(np.mean(residual**2))
    if len(rounded) and power > 0.0:
        # What rounding leaves of a motion that repeats itself has lines too; beside noise they are
        # as much weaker as its share of the variance.
        share = min(float(np.mean(rounded**2)) / power, 1.0)
        lines = float(np.mean([scatter_of(row).excess for row in rounded]))
        found = scatter_of(residual, share**2 * max(lines, 0.0), worth)
        # Where digits repeat they err less than elsewhere, and if they are most of what is left no
        # part is missed by that.
        return replace(found, local=1.0) if share > 0.5 else found
    found, chance, rest = scatter_of(residual, 0.0, worth, imposed.unfelt), 1.0, residual
    if imposed.steps and len(residual) >= FEWEST:
        stepped, calm = step_test(residual, imposed.steps)
        if stepped < min(found.chance, SIGNALS.ruled_out):
            found = replace(scatter_of(calm, worth=worth), local=stepped)
    if not (imposed.coarse or found.misfit):
        found = _beside_lines(residual, found, imposed.period, worth, followed)
    if power > 0.0 and imposed.period[1]:
        chance, rest = period_test(residual, imposed.period)
    elif imposed.powers and power > 0.0 and not found.misfit:
        chance, rest = motion_test(residual, found.spectrum(len(residual)), imposed.powers)
    if chance >= found.chance:
        return found
    # What goes with the motion is no noise: that is what does not.
    if chance < SIGNALS.ruled_out:
        found = scatter_of(rest, worth=worth)
    return replace(found, local=chance)


def _colour_beside(residual: Real, power: Real, memory: Real) -> Colour | None:
    """The colour of the noise in a residual (n,) with these powers; None where it has none.

    It must go on where the misfit may be, at least as well as the spectrum (n,) of a memory with
    whatever is beyond it there.
    """
    colour = colour_of(residual, MEMORIES)
    if colour is None:
        return None
    omega = frequencies(len(power))
    upper = omega > UPPER * np.pi
    spectrum = colour.spectrum(omega)
    scale = float(np.mean(power[upper] / spectrum[upper]))
    # Where it is said to go on there is no less: but for the slowest, which a model has followed.
    below = power[SLOWEST // 4 : 2 * SLOWEST] / (scale * spectrum[SLOWEST // 4 : 2 * SLOWEST])
    if 1.0 - chi2_sf(float(below.sum()), len(below)) < WHERE.levels_differ:
        return None
    coloured, plain = (
        _log_likelihood(power, noise) + _gain_by_octaves(power / noise)
        for noise in (scale * spectrum, memory)
    )
    # What goes on where a misfit may be needs no size of its own for each octave there.
    if 2.0 * (plain - coloured) > GROUPS * np.log(len(power)):
        return None
    return replace(colour, variance=scale * colour.variance)


def _coloured(
    residual: Real, colour: Colour, plain: ResidualScatter, usual: float
) -> ResidualScatter:
    """The same where noise has another spectrum than that of a first-order memory."""
    spectrum = colour.spectrum(frequencies(len(residual)))
    # White in time as in frequency: with no delay, a misfit stays where it is.
    white = transformed(transformed(residual) / np.sqrt(spectrum), back=True)
    # Where a first-order memory makes all of it likelier, that is the story without a misfit.
    alone = max(_likeliest(residual)[0] - _log_likelihood(powers(residual)[0], spectrum), 0.0)
    smooth = _gain_by_octaves(transformed(residual / rougher(residual)) ** 2 / spectrum)
    excess = 2.0 * (max(smooth, _gain_of_jump(white)) - alone) - usual
    # What is missed in one part of a record is no noise of all of it.
    found = replace(plain, excess=excess, colour=colour)
    if colour.beside is not None:
        # What is known to be there, and slow, is not of one size in each part.
        found = replace(found, local=max(plain.local, _chance_of_worst_part(white, 0.0)))
    if not found.misfit:
        # All that is left is noise.
        scale = float(np.mean(transformed(residual) ** 2 / spectrum))
        colour = replace(colour, variance=scale * colour.variance)
    size = float(np.sqrt(np.mean(colour.spectrum(frequencies(len(residual))))))
    return replace(found, size=size, colour=colour)


def scatter_of_sweep(residual: Real, known: bool, followed: float = 0.0) -> ResidualScatter:
    """The noise in the residual (2 n,) of a sweep, K' then K'', over its standard deviations.

    A sweep is too short for a spectrum. Its standard deviations are believed where they are
    `known`, or where there are too few points; else the noise is what neighbours differ by, in
    fourth differences. A misfit is told by its size, and whatever the size of the noise is by
    neighbours that are missed alike (Durbin & Watson 1950, doi:10.1093/biomet/37.3-4.409), and by
    one period that holds most of it.
    """
    halves, count = residual.reshape(2, -1), len(residual)
    power = float(residual @ residual) / count
    apart, worth = 1.0, 0.5 * MEDIAN_WORTH * count
    told = not known and count >= 2 * FEWEST_OF_SCATTER
    if told:
        apart = max(float(np.sqrt(np.mean(np.diff(halves, 4) ** 2) / 70.0)), SMALLEST)
        worth = FOURTH_WORTH * count
    if known:
        worth = np.inf
    alike = float(np.sum(halves[:, 1:] * halves[:, :-1])) / max(count * power, SMALLEST)
    smooth = float(normal_sf(alike * np.sqrt(count)))
    # Three chances to be missed, of which the worst one is told.
    ripple, _ = fisher_test(halves, followed=followed)
    large = chance_of_squares(count * power / apart**2, count, worth)
    local = min(1.0, 3.0 * min(large, smooth, ripple))
    # Where nothing is missed all that is left is noise: of few points, whose neighbours tell hardly
    # more than its order, at least as much.
    if not known and local >= SIGNALS.ruled_out:
        least = apart
        if told:
            least, worth = SMALLEST, np.inf
        apart = max(float(np.sqrt(power)), least)
    return ResidualScatter(apart, 0.0, 0.0, local, worth)


def _beside_lines(
    residual: Real,
    noise: ResidualScatter,
    period: tuple[int, int],
    worth: float,
    followed: float,
) -> ResidualScatter:
    """The noise without lines that go with no motion, as of a hum: they are none.

    Sought where no misfit of a model reaches, and between the harmonics of a motion.
    """
    n = len(residual)
    rest, first, size = residual, 1.0, np.sqrt(noise.spectrum(n))
    omega = np.pi * np.arange(1, n) / n
    sought = omega > np.pi * min(UPPER, SLOWEST / n)
    if period[1]:
        motion = 2.0 * np.pi * period[0] / period[1]
        sought &= np.abs(omega - motion * np.round(omega / motion)) > LINE.wide * np.pi / n
    for _ in range(PARTS):
        white = transformed(transformed(rest) / size, back=True)
        chance, line = fisher_test(white[None], sought, followed)
        if chance >= SIGNALS.ruled_out:
            break
        first = min(first, chance)
        # It lies between two of these frequencies.
        near = line + np.pi / n * np.linspace(-1.0, 1.0, 2 * PARTS + 1)
        waves = np.exp(1j * np.multiply.outer(near, np.arange(n)))
        turn = waves[int(np.argmax(np.abs(waves @ white)))]
        basis = np.linalg.qr(np.column_stack([turn.real, turn.imag]))[0]
        rest = projected_out(rest, basis)
    if first >= SIGNALS.ruled_out:
        return noise
    own = scatter_of(rest, worth=worth)
    if n < FEWEST:
        # What the signal tells of its noise holds the line.
        return replace(own, size=min(times_noise(rest, 1.0), 1.0), local=min(own.local, first))
    # A faint line makes the error no larger than chance may.
    return replace(own, local=min(own.local, own.chance_of(residual, own)))


def times_noise(residual: Real, size: float) -> float:
    """Root mean square of a residual over noise of that size, where there is noise."""
    power = float(np.sum(residual**2)) / np.count_nonzero(_unrepeated(residual))
    return float(np.sqrt(power)) / size


def _unrepeated(residual: Real) -> NDArray[np.bool_]:
    """Which samples do not repeat the one before to the last bit; all, where too few would be left.

    A channel at its limit carries no noise, and a model that knows the limit leaves the same number
    all along there: beside these samples the others would look as if they were missed by more than
    is usual.
    """
    new = np.concatenate([[True], np.diff(residual) != 0.0])
    if np.count_nonzero(new) < FEWEST:
        return np.ones(len(residual), dtype=bool)
    return new


def powers(residual: Real) -> tuple[Real, Real]:
    """Squares of the cosine transform of a residual (n,), and its frequencies in radians a sample.

    Of white noise each is its variance in the mean. The record goes on as its own mirror image: no
    jump between its ends leaks into all frequencies, and nothing has to be faded. To a first-order
    autoregression it is nearly the transform to independent numbers (Ahmed, Natarajan & Rao 1974,
    doi:10.1109/T-C.1974.223784).
    """
    return transformed(residual) ** 2, frequencies(len(residual))


def _gain_of_smooth_misfit(residual: Real) -> float:
    """By how much something smooth beside the noise is likelier than noise alone.

    It has a size for each octave below the upper part, and must earn them.
    """
    # Where the noise is plainly larger its slow part is too.
    even = residual / rougher(residual)
    power, omega = powers(even)
    noise = spectrum_of(omega, *_fitted(power, upper=True))
    return _gain_by_octaves(power / noise) + _log_likelihood(power, noise) - _likeliest(even)[0]


def _gain_by_octaves(ratio: Real) -> float:
    """By how much powers (n,) over those of noise are likelier with a size for each octave.

    Of the octaves below the upper part.
    """
    omega = frequencies(len(ratio))
    edges = UPPER * np.pi * 0.5 ** np.arange(GROUPS, -1.0, -1.0)
    # A mean that is missed belongs to the lowest.
    edges[0] = -1.0
    likely = 0.0
    for low, high in pairwise(edges):
        band = (omega > low) & (omega <= high)
        if band.any():
            # Less than noise there is by chance alone.
            factor = max(1.0, float(np.mean(ratio[band])))
            of_band = np.full(np.count_nonzero(band), factor)
            likely += _log_likelihood(ratio[band], of_band) + 0.5 * float(np.sum(ratio[band]))
    return likely


def _gain_of_jump(residual: Real) -> float:
    """By how much one jump beside the noise is likelier than noise alone, all its numbers paid.

    Its place costs ln n, and each of the four coefficients half as much (Schwarz 1978,
    doi:10.1214/aos/1176344136). Noise with a memory keeps a single large number for a while: that
    story has a place and a size, too, and is noise (an innovation outlier, Fox 1972,
    doi:10.1111/j.2517-6161.1972.tb00912.x).
    """
    even, price = _standardised(residual), float(np.log(len(residual)))
    (alone, _), (jump, memory) = _likeliest(even), _likeliest(_without_jump(even))
    new = even[1:] - memory * even[:-1]
    largest = int(np.argmax(np.abs(new)))
    calm = even.copy()
    calm[largest + 1 :] -= new[largest] * memory ** np.arange(len(even) - 1 - largest)
    return jump - 3.0 * price - max(alone, _likeliest(calm)[0] - 1.5 * price)


def _likeliest(residual: Real) -> tuple[float, float]:
    """Log likelihood of a residual that is all noise with a memory, and that memory."""
    power, omega = powers(residual)
    fitted = _fitted(power)
    return _log_likelihood(power, spectrum_of(omega, *fitted)), fitted[1]


def _without_jump(residual: Real) -> Real:
    """A residual (n,) less a straight line on either side of its plainest jump.

    A jump is where the mean of some samples differs from that of as many before them: of what
    slips, lets go or stands still a smooth model leaves a corner there, whose spectrum is that of
    noise with a memory. Such means are Haar's wavelets at every place (Percival & Walden 2000,
    doi:10.1017/CBO9780511841040).
    """
    n, sums = len(residual), np.concatenate([[0.0], np.cumsum(residual)])
    plainest, at, beside = -1.0, 0, 0
    for width in LEVEL * 2 ** np.arange(int(np.log2(n / LEVEL))):
        first = max(int(width), edge_of(n))
        jumps = sums[first + width : n + 1 - first + width] - 2.0 * sums[first : n + 1 - first]
        jumps += sums[first - width : n + 1 - first - width]
        best = int(np.argmax(np.abs(jumps)))
        if jumps[best] ** 2 / width > plainest:
            plainest, at, beside = jumps[best] ** 2 / width, first + best, int(width)
    straight = np.linalg.qr(np.vander(np.arange(beside), 2))[0]
    taken = residual.copy()
    for side in (slice(at - beside, at), slice(at, at + beside)):
        taken[side] = projected_out(residual[side], straight)
    return taken


def edge_of(n: int) -> int:
    """Samples at either end of n in which no jump is looked for.

    How a test began and ended has other causes.
    """
    return max(LEVEL, n // PARTS)


def rougher(residual: Real) -> Real:
    """How many times larger than usual the noise is at each sample (n,); 1 where it is not plain.

    By the second differences of neighbours, which a smooth misfit hardly has; few samples tell
    nothing of it.
    """
    if len(residual) < FEWEST:
        return np.ones(len(residual))
    bends = np.abs(np.diff(residual, 2))
    usual = float(np.median(bends))
    if not usual > 0.0:
        return np.ones(len(residual))
    beside = np.pad(bends, NEIGHBOURS // 2 + 1, mode="reflect")
    around = np.median(windows(beside, NEIGHBOURS), axis=1)
    return np.where(around > ROUGHER * usual, around / usual, 1.0)


def _standardised(residual: Real) -> Real:
    """A residual without what noise of one size and normal tails cannot do.

    Over its own size where neighbours differ plainly more than usual, and no sample is further off
    than `TAILS` where its neighbours are not.
    """
    # A sample beside plainly larger noise may belong to it.
    near = np.pad(rougher(residual), NEIGHBOURS // 2, mode="edge")
    even = residual / windows(near, NEIGHBOURS).max(axis=1)
    return _cut(even)


def _cut(even: Real) -> Real:
    """Values (n,), of which none is further off than `TAILS` where its neighbours are not."""
    limit = TAILS * NORMAL * float(np.median(np.abs(even)))
    level = np.median(windows(np.pad(even, LEVEL // 2, mode="reflect"), LEVEL + 1), axis=1)
    return np.asarray(np.clip(even, np.minimum(level, 0.0) - limit, np.maximum(level, 0.0) + limit))


def _fitted(power: Real, upper: bool = False) -> tuple[float, float]:
    """Size and memory that make the powers (n,) likeliest, or the upper part of them."""
    first, cosines, logs = _of_memories(len(power), upper)
    # Of each memory the best size is known in closed form, so that a grid of one number is enough;
    # one over a spectrum is a straight line over the cosine.
    along = (1.0 + MEMORIES**2) * power[first:].mean() - 2.0 * MEMORIES * np.mean(
        power[first:] * cosines
    )
    squares = np.maximum(along / (1.0 - MEMORIES**2), SMALLEST)
    best = int(np.argmin(logs + np.log(squares)))
    return float(np.sqrt(squares[best])), float(MEMORIES[best])


@lru_cache(maxsize=64)
def _of_memories(count: int, upper: bool) -> tuple[int, Real, Real]:
    """Number of the first frequency, the cosines of all, and each memory's mean log spectrum."""
    omega = frequencies(count)
    first = int(np.count_nonzero(omega <= UPPER * np.pi)) if upper else 0
    logs = [float(np.mean(np.log(spectrum_of(omega[first:], 1.0, each)))) for each in MEMORIES]
    return first, np.cos(omega[first:]), np.array(logs)


def _log_likelihood(power: Real, spectrum: Real) -> float:
    """Of squares of normal numbers with these variances, but for a constant."""
    return -0.5 * float(np.sum(np.log(spectrum) + power / spectrum))


def _chance_of_worst_part(residual: Real, memory: float) -> float:
    """Chance that noise alone makes the worst part so large, against the usual size of all."""
    chance = _by_parts(residual, memory)
    if chance >= WHERE.levels_differ:
        return chance
    # Noise of long tails may excuse a part, and accuses of nothing.
    even = autoregressive(_with_normal_tails(prewhitened(residual, memory)), memory)
    return max(chance, _by_parts(even, memory))


def _with_normal_tails(new: Real) -> Real:
    """What is new with each sample (n,), each as rare as it is and the tails normal.

    A misfit is large in some parts, and tails are long in all: they are told of each part over its
    own size, without the worst.
    """
    parts = np.array_split(new, PARTS)
    sizes = np.maximum([rms(part) for part in parts], SMALLEST)
    parts.pop(int(np.argmax(sizes)))
    others = np.concatenate([part / max(rms(part), SMALLEST) for part in parts])
    # Few samples tell of no tails: one that is off by itself tells nothing of its part either.
    return _cut(normal_score(new / np.median(sizes), tails_of(others)))


def _by_parts(residual: Real, memory: float) -> float:
    """The same of noise with normal tails."""
    white = residual[1:] - memory * residual[:-1]
    # Squares of neighbours are correlated by the square of their memory: so many of them are
    # independent.
    alike = effective_share(memory**2)
    # A short bump is smooth, and hardly there in what is new with each sample: so both are looked
    # at.
    return min(1.0, 2.0 * _worst_part(white, 0.0, 1.0), 2.0 * _worst_part(residual, memory, alike))


def _worst_part(values: Real, memory: float, worth: float) -> float:
    """Chance of the worst part, where each sample is worth that share of an independent one."""
    usual = NORMAL * float(np.median(np.abs(values)))
    if usual == 0.0:
        return 1.0
    # The usual size is a median, and so as uncertain as that of fewer samples.
    count = worth * len(values)
    of_part = count / PARTS
    chances = []
    for part in np.array_split(values / usual, PARTS):
        size, usual_worth = float(np.mean(part**2)), MEDIAN_WORTH * count
        # Neighbours share a misfit, not the noise: where they bend more than elsewhere, the noise
        # is larger.
        bends = np.diff(part, 2)
        rough = float(bends @ bends) / max(len(bends), 1) / (6.0 - 8.0 * memory + 2.0 * memory**2)
        if rough > 1.0:
            size, usual_worth = size / rough, EFFICIENT * of_part
        chances.append(chance_of_squares(of_part * size, of_part, usual_worth))
    return PARTS * min(chances)
