"""What disturbs one test and is no effect: something that slips at an instant, a single frequency.

White noise has no lines; the largest of m ordinates of its periodogram is known (Fisher 1929,
doi:10.1098/rspa.1929.0151), and here each is held against those around it, as noise may have a
memory and a misfit is slow. What no effect of the library makes is something that slips or lets go
at one instant of one test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from springpot.identification.leastsquares import levenberg_marquardt, one_by_one
from springpot.identification.result import Identification
from springpot.measurement.imposed import ORDER, imposed_noise
from springpot.measurement.instrument import (
    LINE,
    at_mains,
    is_even,
    of_a_motion,
    over_neighbours,
    periodogram,
)
from springpot.misfit.coloured_noise import UPPER
from springpot.misfit.error import plain
from springpot.misfit.residual_scatter import TAILS, ResidualScatter, edge_of, rougher, scatter_of
from springpot.misfit.residuals_of_tests import InTimePart, Residual, TestPart
from springpot.rheology.points import Real

from ..numerics import ALIKE, MOST_STEPS, SMALLEST, Tangent, rms
from .hypotheses import FitResiduals, delta_bic
from .native import ROUGHLY, TimeSearch

SHOWN = 0.5
"""Share of a jump by which its two samples at least differ, beside what their neighbours do."""
BESIDE = 3
"""Such neighbours on either side."""


class Jump(NamedTuple):
    """What slips or lets go at one instant of one test, or a sample that is off.

    Attributes
    ----------
    number, row : int
        Which test, and the first sample behind it, or the one that is off.
    left : list of ndarray, shape (m,)
        The residual of each test without it, the model having made way for it.
    moved : ndarray, shape (p,)
        By how much the parameters have.
    places : int
        At how many it might have been.
    alone : bool
        Whether only that sample is off.
    """

    number: int
    row: int
    left: list[Real]
    moved: Real
    places: int
    alone: bool = False


def likeliest_jump(
    residuals: Sequence[tuple[Real, Real]],
    weights: Sequence[Real | None],
    noise: Sequence[ResidualScatter],
) -> Jump:
    """The jump beside a model that makes its tests likeliest.

    Parameters
    ----------
    residuals : sequence of (ndarray (m,), ndarray (m, p))
        Of each test over the noise of its signal, and their slopes by the parameters, which make
        way for the jump.
    weights : sequence of ndarray, shape (m,), or None
        One over that noise; None for a test whose numbers do not follow one another in time.
    noise : sequence of ResidualScatter
        In the residuals.
    """
    # By its memory alone, which a jump at any place is brought to white by in one sweep.
    noise = [replace(each, colour=None) for each in noise]
    white = [each.whitened(value) for each, (value, _) in zip(noise, residuals, strict=True)]
    slopes = [
        np.column_stack([each.whitened(column) for column in by_theta.T])
        for each, (_, by_theta) in zip(noise, residuals, strict=True)
    ]
    tangent, value = Tangent.of(np.concatenate(slopes)), np.concatenate(white)
    missed = tangent.left(value)
    rows = [slice(*ends) for ends in pairwise(np.cumsum([0, *map(len, white)]).tolist())]
    followed = [i for i, weight in enumerate(weights) if weight is not None]
    places = sum(len(white[i]) for i in followed)
    # None is better than one that is not there.
    best, found, column = -np.inf, Jump(0, 0, [], np.zeros(0), places), np.zeros(len(value))
    for i, which in product(followed, (0, 1)):
        told = np.asarray(weights[i]), noise[i], missed[rows[i]], tangent.basis[rows[i]]
        drops, columns = (_jumps, _strays)[which](*told)
        k = int(np.argmax(drops))
        # The choice of its place costs as much as two numbers.
        gain = float(drops[k]) - 2.0 * float(np.log(places))
        if drops[k] > 0.0 and gain > best:
            best, found = gain, Jump(i, k, [], np.zeros(0), places, alone=which == 1)
            column = np.zeros(len(value))
            column[rows[i]] = columns(k)
    alone = tangent.left(column)
    height = float(alone @ missed) / max(float(alone @ alone), SMALLEST)
    moved = tangent.step(value - height * column)
    left = [value - by_theta @ moved for value, by_theta in residuals]
    if best > -np.inf:
        moves = slice(found.row, found.row + 1 if found.alone else None)
        left[found.number][moves] -= height * np.asarray(weights[found.number])[moves]
    return found._replace(left=left, moved=-moved)


def _strays(
    weight: Real, scatter: ResidualScatter, missed: Real, basis: Real
) -> tuple[Real, Callable[[int], Real]]:
    """By how much the sum of squares of a test falls without each of its samples (m,).

    And the whitened column (m,) of one of them, which is a jump there and one back at the next.
    """
    at, after = _whitened_jumps(weight, scatter)
    back = np.append((after - at)[1:], 0.0)

    def onto(columns: Real) -> Real:
        """Products (m, c) of each with columns (m, c)."""
        later = np.vstack([columns[1:], 0.0 * columns[:1]])
        return np.asarray(at[:, None] * columns + back[:, None] * later, dtype=float)

    drops = _drops(at**2 + back**2, onto(missed[:, None]), onto(basis))

    def column(k: int) -> Real:
        one = np.zeros(len(at) + 1)
        one[k : k + 2] = at[k], back[k]
        return one[:-1]

    return drops, column


def _whitened_jumps(weight: Real, scatter: ResidualScatter) -> tuple[Real, Real]:
    """What is left of a jump over white noise at its first sample, and at those behind it (m,)."""
    # Behind a jump each sample differs from its forerunner by as much as before: only the noise's
    # memory is left of it.
    after, at = scatter.whitened(weight), weight / scatter.size
    at[1:] /= np.sqrt(1.0 - scatter.memory**2)
    return at, after


def _drops(alone: Real, fall: Real, taken: Real) -> Real:
    """By how much a sum of squares falls with each column (m,), the model making way for it."""
    left = alone - np.sum(taken**2, axis=1)
    return np.where(left > ALIKE * alone, fall[:, 0] ** 2 / np.maximum(left, SMALLEST), 0.0)


def _jumps(
    weight: Real, scatter: ResidualScatter, missed: Real, basis: Real
) -> tuple[Real, Callable[[int], Real]]:
    """By how much the sum of squares of a test falls with a jump before each sample (m,).

    And the whitened column (m,) of one of them.
    """
    at, after = _whitened_jumps(weight, scatter)
    alone = at**2 + np.append(np.cumsum((after**2)[::-1])[::-1][1:], 0.0)
    fall = _from_each(at, after, missed[:, None])
    drops = _drops(alone, fall, _from_each(at, after, basis))
    edge = edge_of(len(drops))
    drops[:edge] = drops[len(drops) - edge + 1 :] = 0.0

    def column(k: int) -> Real:
        return np.concatenate([np.zeros(k), at[k : k + 1], after[k + 1 :]])

    return drops, column


def _from_each(at: Real, after: Real, columns: Real) -> Real:
    """Products (m, c) of a whitened jump before each sample with columns (m, c)."""
    later = np.cumsum((after[:, None] * columns)[::-1], axis=0)[::-1]
    return np.asarray(at[:, None] * columns + np.vstack([later[1:], 0.0 * later[:1]]), dtype=float)


class Slip(NamedTuple):
    """A jump that is in no library, as a story of all tests.

    Attributes
    ----------
    says : str
        Which.
    left : FitResiduals
        What it leaves of them.
    places : int
        At how many samples it might have been.
    shown : bool
        Whether the two samples beside it differ as it says.
    aside : tuple of (int, int, float), optional
        Of a sample that is off by itself: the number of its test and its own, and by how
        many times the noise it is off.
    """

    says: str
    left: FitResiduals
    places: int
    shown: bool = True
    aside: tuple[int, int, float] | None = None

    def delta(self, before: FitResiduals, noise: Sequence[ResidualScatter]) -> float:
        """By how much the Bayesian information criterion falls, its place one of all samples."""
        # One that leaves more than noise is not the whole story: what has a name goes before it.
        if self.left.misfit or not self.shown:
            return -np.inf
        # Over even noise, as all other stories, and over noise that grows: the less is sure.
        stories = [(before, self.left, noise), _evened(before, self.left, noise)]
        told = [
            delta_bic(old, replace(new, count=old.count + 1), scatters)
            for old, new, scatters in stories
        ]
        return min(told) - 2.0 * float(np.log(max(self.places, 1)))


def _evened(
    before: FitResiduals, after: FitResiduals, noise: Sequence[ResidualScatter]
) -> tuple[FitResiduals, FitResiduals, list[ResidualScatter]]:
    """What two stories leave, and its noise, over the size that this has in each part of a test.

    Where the noise grows on the way, its largest swings are no jumps.
    """
    sizes = [rougher(value) for value in after.residuals]
    evened = [
        scatter if np.all(size == 1.0) else scatter_of(value / size)
        for scatter, value, size in zip(noise, after.residuals, sizes, strict=True)
    ]
    return _over(before, sizes), _over(after, sizes), evened


def _over(left: FitResiduals, sizes: Sequence[Real]) -> FitResiduals:
    """What is left of each test over the size (m,) of its noise there."""

    def divided(values: Sequence[Real]) -> tuple[Real, ...]:
        return tuple(value / size for value, size in zip(values, sizes, strict=True))

    return replace(
        left,
        residuals=divided(left.residuals),
        rounded=divided(left.rounded),
        noise_answer=divided(left.noise_answer),
    )


def slip_beside(parts: Sequence[TestPart], base: Identification, before: FitResiduals) -> Slip:
    """What slipped or let go in one test beside the model, if that is what it was."""
    search = TimeSearch(base.model, parts, base.reference, [base.theta], thorough=False)
    weights = [
        np.where(part.counted, 1.0 / part.sd, 0.0) if isinstance(part, InTimePart) else None
        for part in parts
    ]
    ends = np.cumsum([0, *(len(part.measured) for part in parts)]).tolist()

    def jumped(value: Real, slopes: Real) -> tuple[list[Residual], Jump]:
        residuals = [Residual(value[i:j], slopes[:, i:j].T) for i, j in pairwise(ends)]
        return residuals, likeliest_jump(residuals, weights, before.noise)

    def beside(u: Real) -> tuple[Real, Real]:
        """Residuals (m,) but for a jump of any height where it does most, and slopes (p, m)."""
        value, slopes = search.guarded(parts, u, False)
        if not np.all(np.isfinite(value)):
            return value, slopes
        _, jump = jumped(value, slopes)
        column, weight = np.zeros(len(value)), weights[jump.number]
        if weight is not None:
            moves = slice(jump.row, jump.row + 1 if jump.alone else len(weight))
            column[ends[jump.number] : ends[jump.number + 1]][moves] = weight[moves]
        column /= max(float(np.linalg.norm(column)), SMALLEST)
        return value - column * (column @ value), slopes - np.outer(slopes @ column, column)

    [u] = search.starts()
    # Where the tests are missed the model makes way by more than one linear step.
    if before.misfit:
        bounds, asked = search.coordinates.bounds, one_by_one(beside)
        u = levenberg_marquardt(asked, u[None], *bounds, iterations=MOST_STEPS, flat=ROUGHLY).u[0]
    residuals, jump = jumped(*search.guarded(parts, u, False))
    scatters = [part.scatter(value) for part, value in zip(parts, jump.left, strict=True)]
    part, (value, slopes) = parts[jump.number], residuals[jump.number]
    name, when = part.test.name, f"{part.at[jump.row]:.3g} s"
    says, aside = f"a jump in {name} at {when}, as of what slips or lets go", None
    if jump.alone:
        off = (value + slopes @ jump.moved - jump.left[jump.number])[jump.row]
        off = float(abs(off) / scatters[jump.number].size)
        aside = jump.number, jump.row, off
        says = f"the sample of {name} at {when}, off by {off:.2g} x the noise"
    # Its size is one number, and the choice of its place costs as much as two.
    left = replace(
        before,
        count=before.count + 3,
        residuals=tuple(jump.left),
        scatters=tuple(scatters),
    )
    return Slip(says, left, jump.places, _is_shown(value + slopes @ jump.moved, jump), aside)


def _is_shown(story: Real, jump: Jump) -> bool:
    """Whether what the model misses (m,) jumps there by itself, as far as noise lets it be seen.

    A bend may be missed like a jump, from where on the model lies beside the test: at it neighbours
    differ little.
    """
    if jump.alone or jump.row == 0 or len(story) <= ORDER:
        # None was found, or nothing tells the noise, or nothing beside it has moved.
        return jump.alone or jump.row > 0
    height = float((story - jump.left[jump.number])[jump.row])
    steps = np.sign(height) * np.diff(story)
    row = jump.row - 1
    around = np.concatenate([steps[max(row - BESIDE, 0) : row], steps[row + 1 : row + 1 + BESIDE]])
    # A step holds the noise of two samples.
    noise = np.sqrt(2.0) * imposed_noise(story)
    return bool(steps[row] - np.median(around) > SHOWN * abs(height) - TAILS * noise)


def lines_in(part: TestPart, residual: Real) -> Iterator[str]:
    """The strongest line in a residual (m,) over the noise, in words; nothing where there is none.

    Sought where a misfit of a model does not reach, and at the frequencies of the mains. One that a
    specimen may have made of its motion, as friction makes its harmonics, may be its own.
    """
    if not isinstance(part, InTimePart) or len(part.at) < LINE.fewest or not is_even(part.at):
        return
    missed = residual * part.sd
    power, omega = periodogram(missed)
    hertz = omega / (2.0 * np.pi * float(np.mean(np.diff(part.at))))
    of_mains = at_mains(hertz)
    sought = np.where((omega > UPPER * np.pi) | of_mains, over_neighbours(power), 0.0)
    top = int(np.argmax(sought))
    # The largest of m: each might have been it.
    if len(power) * np.exp(-sought[top]) > LINE.rare:
        return
    share = power[max(0, top - LINE.wide) : top + LINE.wide + 1].sum() / power.sum()
    size = np.sqrt(2.0 * share) * rms(missed - missed.mean())
    whose = "the hum of the mains" if of_mains[top] else "a vibration, or the hum of a device"
    loading = part.test.loading
    own, _ = of_a_motion(np.interp(part.at, loading.time, loading.value))
    beside = "or a harmonic of the motion" if own[top] else "no part of the specimen"
    yield (
        f"what is left of {part.test.name} holds a line at {plain(float(hertz[top]), 3)} Hz,"
        f" {plain(float(size), 2)} {part.unit} in amplitude: {whose}, {beside}"
    )
