"""Marginal likelihoods: what a model explains, less what its parameters cost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from springpot.distributions import student
from springpot.identification.intervals import held_costs
from springpot.identification.normal import variance_of
from springpot.identification.starts import Window, shown
from springpot.identification.uncertainty import Uncertainty
from springpot.measurement.independence import distinct_log_omega, telling
from springpot.measurement.measurement import CONDITIONS
from springpot.measurement.mixed_up import sweeps_of
from springpot.misfit.frame import (
    DRIFT_DEGREE,
    LEAST_SEEN,
    NoiseFrame,
    relative_to,
)
from springpot.misfit.refit import Refit
from springpot.rheology.points import Complex, Real
from springpot.thresholds import EVIDENCE, INTERVAL, VERDICT

from ..numerics import ROUNDING, SMALLEST, evenly, orthonormal, projected_out

if TYPE_CHECKING:
    from .grown import Grown, Search

ROW_BY_ROW = "from row to row"
"""How the kinds are called that follow the order of the rows."""
CHAIN = "the measuring chain rather than the material"
"""To what a gain or a phase points that no material has."""
SETTLING_TIMES = (0.03, 0.06, 0.12, 0.25, 0.5, 1.0)
"""Times, in durations of the measurement, in which a rig may settle.

Slower ones are a straight line.
"""
MOST_STEPS = 200
"""Places at which a step is sought at most, evenly over the measured frequencies."""
PLACES = 9
"""Places in its range at which an open parameter is held in turn."""


def harmonic_evidence(refit: Refit) -> float:
    """Log-likelihood of the measured third harmonic, at most 0; 0 where none was measured.

    Parameters
    ----------
    refit : Refit
        A model, fitted.
    """
    data = refit.data.mean
    measured = data.harmonic(3)
    if measured is None:
        return 0.0
    rows = np.flatnonzero(np.isfinite(measured))
    if len(rows) == 0:
        return 0.0
    predicted, radius = refit.model.third_harmonic_range(refit.theta, data.points)
    # Of a size without a phase, sizes are compared.
    shown = np.abs(predicted) if np.isrealobj(measured) else predicted
    # Where no bound is known it may be anything: a fixed price, so that nothing is gained by not
    # predicting.
    if not np.all(np.isfinite(radius)):
        return EVIDENCE.unpredicted_harmonic
    noise: Real = np.hypot(refit.noise.sd.real, refit.noise.sd.imag) / data.magnitude
    sd = noise[rows] + EVIDENCE.least_harmonic
    distance = np.abs(measured[rows] - shown[rows])
    # What only the third harmonic tells of a law, the first leaves open: it may be anything there.
    if np.any(distance > radius[rows] + sd):
        radius = radius + _open_harmonic(refit, predicted)
    # Within the range that a model allows nothing is missed: it is a bound, not a prediction.
    off = np.maximum(distance - radius[rows], 0.0)
    size = np.maximum(np.abs(measured[rows]), np.abs(predicted[rows]))
    # What of a prediction is known: to the noise, and to how far its formula may be off.
    known = np.hypot(sd, EVIDENCE.harmonic_tolerance * size)
    rows_that_count = min(float(len(rows)), EVIDENCE.most_harmonic_rows)
    missed = 0.5 * float(np.mean((off / known) ** 2)) * rows_that_count
    return -missed - _price_of_a_bound(distance / known, radius[rows] / known)


def _open_harmonic(refit: Refit, predicted: Complex) -> Real:
    """How far (n,) the third harmonic may lie from the prediction, as far as parameters are open.

    Along each principal direction of what the data tell of them, to the end of their interval.
    """
    fit, points = refit.fit, refit.data.mean.points
    low, high = refit.model.box
    _, sharpness, directions = np.linalg.svd(fit.jacobian_u, full_matrices=False)
    # Nobody knows less of a parameter than was known beforehand.
    least, reach = 1.0 / np.sqrt(EVIDENCE.vague), student(INTERVAL, np.inf)
    squares = np.zeros(len(predicted))
    for sharp, direction in zip(np.maximum(sharpness, least), directions, strict=True):
        ends = [
            np.clip(fit.from_u(fit.u + sign * reach / sharp * direction), low, high)
            for sign in (-1.0, 1.0)
        ]
        # Where a law gives no number it may give any.
        with np.errstate(all="ignore"):
            moved = [refit.model.third_harmonic_range(end, points)[0] - predicted for end in ends]
            squares += np.nan_to_num(np.max(np.abs(moved), axis=0) ** 2, nan=np.inf)
    return np.asarray(np.sqrt(squares))


def _price_of_a_bound(distance: Real, radius: Real) -> float:
    """What a model pays that only bounds the harmonic, beside one that predicts it.

    0 where there is no room.

    Its size may be any up to the bound, all decades alike, in any phase: the density of that where
    the harmonic was measured, over that of a prediction which is right. Distances (m,) in units of
    what is known of a prediction.
    """
    room = 1.0 + np.log(np.maximum(radius, 1.0))
    price = 2.0 * np.log(np.maximum(np.minimum(distance, radius), 1.0)) + np.log(room)
    # Once and not for each row: what is right in one is right in all. A bound costs no more than to
    # know nothing.
    return min(float(np.mean(price)), -EVIDENCE.unpredicted_harmonic)


@dataclass(frozen=True, eq=False)
class Unknown:
    """One kind of structure without a name in the library.

    Attributes
    ----------
    says : str
        What it would be; empty for structure in general.
    drops : ndarray, shape (places,)
        Drop of the whitened residual sum of squares, at each place at which the shape was tried.
    shapes : int
        How many shapes follow the residual.
    whose : str
        To what such a structure points.
    column : str
        The condition each level of which has a gain of its own; empty for all else.
    """

    says: str
    drops: Real
    shapes: int
    whose: str = CHAIN
    column: str = ""

    @property
    def drop(self) -> float:
        """The largest drop."""
        return float(np.max(self.drops))


def unknowns(frame: NoiseFrame) -> Iterator[Unknown]:
    """Kinds of structure that may be left by a fit, each with what it would explain.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    """
    # With and without what sweeps share: a slow misfit must not pay for a shape at each frequency.
    for basis in (frame.smooth, frame.structured):
        yield Unknown("", _explained(frame, basis), int(basis.shape[1]))
    log_omega = np.log(frame.measurement.omega)
    order = np.arange(len(frame.measurement), dtype=float)
    for along, words in ((log_omega, "along frequency"), (order, ROW_BY_ROW)):
        if np.ptp(along) > 0:
            curves = _creep(along)
            yield _family(frame, curves, f"a gain that changes slowly {words}")
            yield _family(frame, np.multiply(1j, curves), f"a phase that changes slowly {words}")
    yield from _settling(frame, order)
    for name in CONDITIONS:
        curves = _own_levels(frame, name)
        if len(curves):
            # A law of the condition changes K from level to level too.
            whose = f"the measuring chain, or a law of the {name} that no effect has"
            gains = _family(frame, curves, f"a gain of its own at each {name}", whose)
            yield replace(gains, column=name)
            phases = np.multiply(1j, curves)
            yield _family(frame, phases, f"a phase of its own at each {name}", whose)
            # What the same factor of all times changes: K is moved along frequency.
            yield _family(
                frame,
                curves * _slopes(frame),
                f"times of their own at each {name}",
                f"a {name} that was not what the file says, or a law of it that the model lacks",
            )
    yield from _step(frame)


def _stand_by_a_condition(frame: NoiseFrame) -> bool:
    """Whether the levels of a condition follow one another, up or down, in order of the rows."""
    for name in telling(frame.measurement) & set(CONDITIONS):
        steps = np.diff(frame.measurement.levels(name))
        if np.any(steps != 0) and (np.all(steps >= 0) or np.all(steps <= 0)):
            return True
    return False


def _family(frame: NoiseFrame, curves: Real | Complex, says: str, whose: str = CHAIN) -> Unknown:
    basis = frame.beyond(frame.whiten(frame.model_stiffness * curves).T)
    return Unknown(says, _explained(frame, basis), int(basis.shape[1]), whose)


def _slopes(frame: NoiseFrame) -> Complex:
    """Slope of ln K (n,) along ln omega, in each sweep of a fitted model; 0 where there is none."""
    log_stiffness = np.log(relative_to(frame.model_stiffness, frame.measurement))
    slopes = np.zeros(len(log_stiffness), dtype=np.complex128)
    for rows, _ in sweeps_of(frame.measurement):
        # By distinct frequencies: between two points at one there is no slope.
        log_omega, first, place = np.unique(
            np.log(frame.measurement.omega[rows]), return_index=True, return_inverse=True
        )
        if len(log_omega) > 1:
            slopes[rows] = np.gradient(log_stiffness[rows][first], log_omega)[place]
    return slopes


def _own_levels(frame: NoiseFrame, name: str) -> Real:
    """Shapes (m, n) that are one at one level of a condition, else zero, for all but the first.

    No shapes where there are fewer than three levels, or so few points at each that they could
    follow anything.
    """
    column = frame.measurement.conditions.get(name)
    if column is None:
        return np.zeros((0, len(frame.measurement)))
    level = frame.measurement.levels(name)
    count = int(level.max()) + 1
    if count < EVIDENCE.fewest_levels or len(level) < EVIDENCE.points_of_each * count:
        return np.zeros((0, len(level)))
    # Without the first: a gain of all levels is a gain of the whole, which the model follows.
    shapes: Real = (level == np.arange(1, count)[:, None]).astype(np.float64)
    return shapes


def _creep(along: Real) -> Real:
    """Polynomials without their constant, shape (DRIFT_DEGREE, n)."""
    x = 2.0 * (along - along.min()) / np.ptp(along) - 1.0
    return np.polynomial.legendre.legvander(x, DRIFT_DEGREE).T[1:]


def _settling(frame: NoiseFrame, order: Real) -> Iterator[Unknown]:
    """A gain or a phase that settles exponentially from row to row, as a rig that warms up does."""
    x = order / len(order)
    curves = np.exp(-x / np.array(SETTLING_TIMES)[:, None])
    for factor, word in ((1.0, "gain"), (1.0j, "phase")):
        yield Unknown(f"a {word} that settles {ROW_BY_ROW}", _each_alone(frame, factor * curves), 1)


def _each_alone(frame: NoiseFrame, curves: Complex) -> Real:
    """Drop of the sum of squares (m,) by each of some relative changes of K (m, n) alone."""
    columns = frame.whiten(frame.model_stiffness * curves).T
    left = frame.project(columns)
    size = np.linalg.norm(left, axis=0)
    # What the parameters follow all but whole would divide rounding by rounding.
    seen = size > LEAST_SEEN * np.linalg.norm(columns, axis=0)
    drop = (frame.rest @ left) ** 2 / np.where(seen, size, 1.0) ** 2
    return np.where(seen, drop, 0.0)


def _step(frame: NoiseFrame) -> Iterator[Unknown]:
    """A gain that differs between two ranges of frequency."""
    levels = distinct_log_omega(frame.measurement)
    if len(levels) < 4:
        return
    # Two frequencies on each side at least: a step beside a single one is a bad point.
    between = 0.5 * (levels[1:-2] + levels[2:-1])
    between = between[evenly(len(between), MOST_STEPS)]
    drops = _each_alone(
        frame, (np.log(frame.measurement.omega) > between[:, None]).astype(np.complex128)
    )
    hertz = float(np.exp(between[int(np.argmax(drops))])) / (2.0 * np.pi)
    yield Unknown(f"a gain that steps at {frame.measurement.units.at(hertz)}", drops, 1)


def _explained(frame: NoiseFrame, basis: Real) -> Real:
    """Drop of the sum of squares (1,) by all shapes of a basis together."""
    return np.array([np.sum((basis.T @ frame.rest) ** 2)])


Rows: TypeAlias = NDArray[np.int64]


def marginal(search: Search, grown: Grown) -> float:
    """Log of the marginal likelihood of a grown model (Laplace), up to what all models share.

    What an effect's parameters cost is the logarithm of how much narrower the data make them than
    they were. Its size is of unknown order of magnitude, and of unknown sign where physics allows
    both; its parameters are known the better, the more the effect explains: to a relative width of
    one over the square root of the drop in chi-square (MacKay 1992, doi:10.1162/neco.1992.4.3.415).
    One that the data leave less certain than that costs less.
    """
    # Of the model's own parameters: lines of a spectrum come and go with the effect, and are paid
    # in `fair_rss`.
    spent = len(grown.refit.own) - len(search.base.own)
    cost = EVIDENCE.unknown_sign * sum(
        effect.element.parameters[0].lower < 0.0 for effect in grown.effects
    )
    explained = _discounted(search, grown.refit.fair_rss, spent, len(grown.effects))
    return explained + harmonic_evidence(grown.refit) - cost + _refund(search, grown)


def _refund(search: Search, grown: Grown) -> float:
    """What is charged too much for parameters, sizes apart, that the data hardly determine.

    An effect with one that has gone beyond what the data show pays in full: it has become a simpler
    effect. One that the data leave open pays for the share of its range in which the model fits as
    well.
    """
    refit = grown.refit
    # Where slopes have no value nothing is known of the widths, and the full price stands.
    if not np.all(np.isfinite(refit.fit.jacobian_u)):
        return 0.0
    uncertainty = Uncertainty(refit.fit, absolute=True)
    variance = np.where(uncertainty.at_bound != 0, np.inf, variance_of(uncertainty.covariance))
    # Only rivals are worth the refits that tell how far a parameter lies open.
    rival = refit.log_likelihood > search.best.log_likelihood - EVIDENCE.rivals
    kept, shares = [], 0.0
    # Effect by effect: one that has become a simpler one pays in full, whatever its partner does.
    for rows in _extras(search, grown):
        seen = []
        # Those that change nothing first: where one parameter is not seen, the others need no fits.
        for i in sorted(rows, key=lambda i: float(np.linalg.norm(refit.fit.jacobian_u[:, i]))):
            seen.append(_seen(refit, i, rival and bool(variance[i] > EVIDENCE.open)))
            if not seen[-1]:
                break
        else:
            kept.append(rows)
            shares += float(np.sum(np.log(seen)))
    if not kept:
        return 0.0
    nuisances = np.concatenate(kept)
    drop = _drop(search, refit.fair_rss, len(refit.own) - len(search.base.own))
    needed = np.minimum(drop, EVIDENCE.vague * _sharpness(refit, nuisances, uncertainty.at_bound))
    return max(
        0.5 * float(len(nuisances) * np.log1p(drop) - np.sum(np.log1p(needed))) + shares, 0.0
    )


def _sharpness(refit: Refit, rows: Rows, at_bound: Rows) -> Real:
    """How sharply the data determine some parameters together, all others free.

    Principal precisions (q,).

    Where only a combination of them is determined, one direction is sharp and the others are open.
    """
    slopes = np.where(at_bound == 0, refit.fit.jacobian_u, 0.0)
    # Projected, not read off the inverse of the information: that has no value along an open
    # valley.
    others = orthonormal(np.delete(slopes, rows, axis=1))
    left = projected_out(slopes[:, rows], others)
    return np.asarray(np.linalg.svd(left, compute_uv=False) ** 2, dtype=np.float64)


def _extras(search: Search, grown: Grown) -> list[list[int]]:
    """For each effect added, the numbers of its parameters other than its size."""
    sizes = {(each.name, each.element.parameters[0].name) for each in grown.effects}
    mine: dict[str, list[int]] = {}
    for i, parameter in enumerate(grown.refit.model.parameters):
        owner, _, short = parameter.name.rpartition(".")
        if (
            owner
            and parameter.name not in search.base.model.names
            and (owner.partition("#")[0], short) not in sizes
        ):
            mine.setdefault(owner, []).append(i)
    return list(mine.values())


def _seen(refit: Refit, i: int, left_open: bool) -> float:
    """Whether the data show a parameter: one, zero, or the share of its range that they leave open.

    Two temperatures cannot tell two constants of a shift: the fit ends anywhere along a valley, by
    chance.
    """
    if np.linalg.norm(refit.fit.jacobian_u[:, i]) < EVIDENCE.least_influence:
        return 0.0
    parameter = refit.model.parameters[i]
    low, high = shown(parameter, Window.of(refit.fit.measurement))
    if low < float(refit.theta[i]) < high:
        return 1.0
    if not left_open or not low < high:
        return 0.0
    places = np.linspace(low, high, PLACES)
    if parameter.scale == "log":
        places = np.geomspace(low, high, PLACES)
    worse = held_costs(refit.fit, parameter.name, places) - refit.rss
    # A held fit that is better than the free one is another minimum, and says no more than "as
    # well".
    share = float(np.mean(np.exp(-0.5 * np.maximum(worse, 0.0))))
    if share <= EVIDENCE.least_share:
        return 0.0
    return share


def is_a_limit(search: Search, grown: Grown) -> bool:
    """Whether an effect of a fitted model has become a simpler one.

    One of its parameters has gone beyond what the data show, as the stiffness of a slider that is
    friction alone.
    """
    refit = grown.refit
    at_bound = Uncertainty(refit.fit, absolute=True).at_bound
    extras = [i for rows in _extras(search, grown) for i in rows]
    return any(at_bound[i] != 0 or _seen(refit, i, False) == 0.0 for i in extras)


def likeliest_unknown(search: Search) -> Unknown:
    """The kind of structure without a name that explains the data best."""
    return max(_kinds(search), key=lambda kind: _evidence_of(search, kind))


def explaining_unknown(search: Search) -> Unknown | None:
    """The kind of structure without a name that explains all or most of what is seen.

    None without one.

    Without structure some fault still explains best, but nothing that is there.
    """
    if search.structure.p_value >= VERDICT.structure_alarm:
        return None
    kind, frame = likeliest_unknown(search), search.frame
    spare = frame.size - frame.absorbed.shape[1]
    misfit = float(frame.rest @ frame.rest)
    left = misfit - kind.drop
    all_of_it = left < VERDICT.explained * spare
    most_of_it = left - spare < VERDICT.most_of_it * (misfit - spare)
    if all_of_it or most_of_it:
        return kind
    return None


def left_unknown(search: Search) -> Unknown | None:
    """The kind without a name that explains what the best grown model leaves; None without one."""
    best = search.best
    if best is search.base or search.left.p_value >= VERDICT.structure_alarm:
        return None
    beside = replace(search, base=best, frame=best.frame(), structure=search.left, grown=[])
    found = explaining_unknown(beside)
    if found is None or not found.says:
        return None
    return found


def _kinds(search: Search) -> list[Unknown]:
    """Kinds of structure that may be missing here.

    Where repeats differ by what is common to a sweep, each sweep has a gain and a phase of its own:
    that is known already and told of, and to find it again along a condition is no evidence that no
    effect is missing.
    """
    kinds = list(unknowns(search.frame))
    if search.repeats.p_value < VERDICT.beyond_doubt:
        kinds = [kind for kind in kinds if not kind.says]
    return kinds


def fault_beside(search: Search, grown: Grown) -> tuple[Unknown, float] | None:
    """The likeliest fault of the chain beside a grown model, and how much log-evidence it adds.

    None where no fault can be told.
    """
    fitted = grown.refit
    beside = replace(search, base=fitted, frame=fitted.frame(), grown=[])
    faults = [kind for kind in _kinds(beside) if kind.says]
    if _stand_by_a_condition(search.frame):
        faults = [kind for kind in faults if not kind.says.endswith(ROW_BY_ROW)]
    if not faults:
        return None
    kind = max(faults, key=lambda kind: _evidence_of(beside, kind))
    return kind, _evidence_of(beside, kind) - fitted.log_likelihood


def unknown_marginal(search: Search) -> float:
    """Log-evidence of all such kinds together.

    Structure in general has the weight of one common effect; each fault of a measuring chain has
    one of its own, as laboratories meet them one by one.
    """
    kinds = _kinds(search)
    general = sum(not kind.says for kind in kinds)
    # Summed, not the likeliest alone: a few kinds that explain as well are together the more likely
    # cause.
    weights = np.full(len(kinds), EVIDENCE.prior_chain)
    weights[[not kind.says for kind in kinds]] = 1.0 / general
    # Where rows stand by temperature or amplitude, what changes from row to row may as well be
    # theirs.
    if _stand_by_a_condition(search.frame):
        weights[[kind.says.endswith(ROW_BY_ROW) for kind in kinds]] *= float(
            np.exp(-EVIDENCE.as_good)
        )
    evidence = np.array([_evidence_of(search, kind) for kind in kinds]) + np.log(weights)
    return float(logsumexp(evidence))


def _evidence_of(search: Search, kind: Unknown) -> float:
    """Log-evidence of one kind on top of the base model, the mean over its places."""
    frame = search.frame
    misfit = float(frame.rest @ frame.rest)
    each = [
        _discounted(search, search.base.fair(misfit - drop), kind.shapes, 1)
        for drop in kind.drops.tolist()
    ]
    # The mean over the places, not the best of them: where the step is was not known beforehand.
    return float(logsumexp(each)) - float(np.log(len(each)))


def _discounted(search: Search, rss: float, spent: int, effects: int) -> float:
    """Log-evidence of the base with `spent` further parameters that leave this sum of squares.

    Where the scale of the noise is not known, few data that many parameters follow say little: the
    integral over it (Liang et al. 2008, doi:10.1198/016214507000001337, equation 6) counts only
    what the parameters leave free.
    """
    base = search.base
    # The width of what was known before, over that of what is known after, squared: the larger the
    # effect, the wider.
    g = _drop(search, rss, spent)
    price = EVIDENCE.unknown_size * effects
    if base.noise.dof == inf:
        return base.log_likelihood + 0.5 * (g - spent * float(np.log1p(g))) - price
    free = _freedom(search)
    kept = max(free - spent, 0.0)
    ratio = _ratio(search, rss)
    return (
        base.log_likelihood + 0.5 * float(kept * np.log1p(g) - free * np.log1p(g / ratio)) - price
    )


def _drop(search: Search, rss: float, spent: int) -> float:
    """By how much further parameters lower chi-square, in units of the noise that they leave."""
    if search.base.noise.dof == inf:
        return search.base.noise.worth * max(search.base.fair_rss - rss, 0.0)
    return max(_freedom(search) - spent, 0.0) * (_ratio(search, rss) - 1.0)


def _ratio(search: Search, rss: float) -> float:
    """Sum of squares of the base over that of a grown model, at least one; both count repeats."""
    known = _known(search)
    whole = search.base.fair_rss + known
    # What is left of exact data is rounding: less than that, or less than nothing, is no number.
    return max(whole / max(rss + known, ROUNDING**2 * whole, SMALLEST), 1.0)


def _freedom(search: Search) -> float:
    """Numbers that tell of the noise's scale where the base is right."""
    # Without what the lines of a free spectrum follow: of few points they leave little by which to
    # judge a shape.
    followed = len(search.base.own) + search.base.lines
    free = 2 * len(search.base.fit.measurement) - followed
    return _known(search) + search.base.noise.worth * free


def _known(search: Search) -> float:
    """Degrees of freedom of the noise that do not come from the residual."""
    noise = search.base.noise
    if noise.source == "repeats":
        return noise.dof
    # An estimate comes from the very residual that is weighed: it tells nothing beside it.
    return 0.0


def credible(chances: dict[str, float], share: float = EVIDENCE.credible) -> list[str]:
    """The fewest names that hold a share of the probability, the likeliest first."""
    total = sum(chances.values())
    covered, kept = 0.0, []
    # Asked before it is added: the set must hold the share, not stop short of it.
    for name in sorted(chances, key=lambda name: -chances[name]):
        if covered < share * total:
            kept.append(name)
        covered += chances[name]
    return kept
