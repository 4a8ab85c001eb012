"""Any linear passive material from tests in time, with what surrounds it, and its least error.

A relaxation is linear in the weights of the lines, a creep is not: Gauss-Newton steps serve both,
whose weights come from non-negative least squares and the parameters of effects from what these
leave (Golub & Pereyra 2003, doi:10.1088/0266-5611/19/2/201).

Below the least error lies what a spring, dashpot, springpot or mode may mend, above it what no
material does. It is sought from a fitted model, whose material is set free while its effects go on
from where they are: so it lies below the model's own error from the first step on, and takes a few.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.identification.convex import SPACINGS, ConvexSpectrum, lattice, shown_by
from springpot.identification.leastsquares import REACH
from springpot.identification.material import STILL, is_material
from springpot.identification.material_fit import KEPT
from springpot.identification.result import Identification
from springpot.misfit.material import any_material, is_of_material
from springpot.misfit.residuals_of_tests import (
    InTimePart,
    TestPart,
    parts_of_specimen,
    typical_stiffness,
)
from springpot.numerics import (
    ALIKE,
    DECADE,
    MOST_STEPS,
    NEGLIGIBLE,
    PER_DECADE,
    PRINTED,
    SMALLEST,
    TWO_DEVIATIONS,
    non_negative,
    projected_out,
    rms,
)
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.parameters import Coordinates
from springpot.rheology.points import Real, real_form

from .native import TimeSearch
from .specimen import Scales, tries_of
from .temperatures import StackedResiduals, is_law, lawful, seen_by

BRIEF = 3
"""Steps from each place where an effect of a test may lie.

The material needs two, and the effect one.
"""


def with_rates(model: Model, rates: Sequence[float]) -> Model:
    """The same with these lines, rates in 1/s, in its material."""
    return replace(model, material=Continuum(tuple(rates)))


class FoundLines(NamedTuple):
    """A material with lines (its K_e, c, weights and the effects' parameters in `theta`, (p,)).

    What `untold` says is empty where the tests tell each effect of theirs from another material.
    From where it lies, `again` finds the best for parts that weigh otherwise.
    """

    model: Model
    theta: Real
    evaluations: int
    untold: str
    again: Callable[[Sequence[TestPart]], FoundLines]

    @property
    def spectrum(self) -> ConvexSpectrum:
        """The material alone."""
        return spectrum_of(self.model, self.theta)


def spectrum_of(model: Model, theta: Real) -> ConvexSpectrum:
    """The lines (m,) of a material that has them, K_e, c and weights first in its theta (p,)."""
    assert isinstance(model.material, Continuum), "no other material has lines"
    rates = np.array(model.material.rates)
    return ConvexSpectrum.of(theta[: 2 + len(rates)], rates)


class UntoldError(ModelError):
    """No parameter of an effect of a test can be told, as another material could do the same.

    Attributes
    ----------
    model, theta : Model, ndarray of shape (p,)
        What was fitted nevertheless: it tells whether the effect explains the tests.
    """

    def __init__(self, found: FoundLines) -> None:
        super().__init__(found.untold)
        self.model, self.theta = found.model, found.theta


def spectral(
    model: Model,
    parts: Sequence[TestPart],
    reference: float,
    coordinates: Coordinates,
    seeds: Sequence[Real] = (),
) -> FoundLines:
    """A material with the lines that tests in time show, and its parameters.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    parts : sequence of TestPart
        The tests, each with its weight.
    reference : float
        Temperature in kelvin at which shifts are one.
    coordinates : Coordinates
        Of the parameters of the effects alone.
    seeds : sequence of ndarray, shape (q,)
        Parameters of the effects that are worth a start, beside their natural sizes.

    Returns
    -------
    FoundLines
        With the lines that carry weight.

    Raises
    ------
    ModelError
        If the model cannot be followed in these tests.
    """
    search = MaterialSearch(model, parts, reference, coordinates)
    begun = [(search, search.placed(search.start()))]
    # Seeds of a model that had its laws before know them.
    if not seeds or any(map(is_law, model.effects[-1:])):
        natural = search.own(search.natural)
        seeds = [*seeds, *lawful(model, parts, reference, list(seeds) or [natural])]
    for seed in seeds:
        other = MaterialSearch(model, parts, reference, coordinates, own=seed)
        begun += [(other, start) for start in other.seeded([seed])]
    ends = [(each, each.descended(start, MOST_STEPS)) for each, start in begun]
    # From all lines alike a creep may end anywhere: its own convex form, which knows no effect,
    # tells where it lies. Of many tests those do that all of them are nearest to.
    known, convex = [part.lines for part in parts if part.lines is not None], []
    for lines in known:
        other = MaterialSearch(model, parts, reference, coordinates, lines.beside(known))
        # One that flows cannot have stood under a load that was there before.
        with suppress(ModelError):
            convex.append((other, other.start()))
    for each, start in sorted(convex, key=lambda pair: pair[1].cost)[:KEPT]:
        ends.append((each, each.descended(each.placed(start), MOST_STEPS)))
    return _best(ends, parts)


def descended_from(
    lines: ConvexSpectrum, model: Model, parts: Sequence[TestPart], reference: float, around: Around
) -> FoundLines:
    """A material near a known one, and near those that the convex form of each test tells.

    Parameters
    ----------
    lines : ConvexSpectrum
        The known one.
    model, parts, reference
        As for `spectral`.
    around : Around
        The coordinates of the effects, and the parameters (q,) at which they begin.

    Raises
    ------
    ModelError
        If the model cannot be followed there.
    """
    known = [lines]
    if len(parts) > 1:
        # Each test by what a material leaves of it when it follows that test alone.
        alone = [descended_from(lines, model, [part], reference, around) for part in parts]
        left = [
            rms(part.residual(found.model, found.theta, reference).value)
            for part, found in zip(parts, alone, strict=True)
        ]
        parts = [part.with_scale(max(each, ALIKE)) for part, each in zip(parts, left, strict=True)]
        known += [found.spectrum for found in alone]
    elif parts[0].lines is not None:
        # Of one test without effects the convex form is the answer.
        known = [*known[: len(around.own)], parts[0].lines]
    starts = []
    for each in known:
        lines = each.beside(known)
        search = MaterialSearch(model, parts, reference, around.coordinates, lines, around.own)
        starts += [(search, start) for start in search.seeded([around.own])]
    if not starts:
        raise ModelError(f"{model.name} cannot be followed in these tests")
    # Where a search ends is not told by where it begins; of many tests the nearest will do.
    nearest = sorted(starts, key=lambda each: each[1].cost)[: KEPT + 1]
    ends = [(each, each.descended(start, MOST_STEPS, PRINTED)) for each, start in nearest]
    return _best(ends, parts, spared=False)


class Around(NamedTuple):
    """What surrounds a material: coordinates of its effects, and their parameters (q,)."""

    coordinates: Coordinates
    own: Real


def _best(
    ends: Sequence[tuple[MaterialSearch, MaterialPoint]],
    parts: Sequence[TestPart],
    spared: bool = True,
) -> FoundLines:
    """The best end of searches, with lines at places of their own where they pay.

    Where no line is `spared` wherever they leave less: of an error alone none costs anything.
    """
    evaluations = sum(each.evaluations for each in dict.fromkeys(each for each, _ in ends))
    search, place = min(ends, key=lambda end: end[1].cost)
    # The convex form knows one test and no effect: beside others the lattice is as coarse as at the
    # start.
    known = len(parts) == 1 and not len(place.u)
    if not known and np.any(place.weights[2:]):
        samples = sum(len(part.signal) for part in parts)
        for share in SPACINGS:
            closer, there = search.closer(place, share, spared)
            evaluations += closer.evaluations
            if _pays(place, there, samples) or (not spared and there.cost < place.cost):
                search, place = closer, there
    return search.found(place, evaluations)


VISIBLE = 0.1
"""Share of the signal that an effect of either sign is changed by for the same.

No test is run for less.
"""


class MaterialPoint(NamedTuple):
    """Weights of the lines, coordinates of the effects, and the sum of squares there."""

    weights: Real
    u: Real
    cost: float


def _pays(before: MaterialPoint, after: MaterialPoint, samples: int) -> bool:
    """Whether lines at places of their own explain more than as many places cost (Schwarz)."""
    lines = np.count_nonzero(after.weights[2:])
    return bool(samples * np.log(before.cost / after.cost) > lines * np.log(samples))


class MaterialSearch:
    """Residuals of tests by the weights of a lattice of lines and by the effects' coordinates."""

    def __init__(
        self,
        model: Model,
        parts: Sequence[TestPart],
        reference: float,
        coordinates: Coordinates,
        lines: ConvexSpectrum | None = None,
        own: Real | None = None,
    ) -> None:
        self.parts, self.reference = list(parts), reference
        # A creep is not linear in the weights.
        self.linear = all(
            part.test.control == "displacement" for part in parts if isinstance(part, InTimePart)
        )
        self.coordinates, self.size = coordinates, coordinates.size[0]
        self.bounds = coordinates.bounds
        if own is None:
            own = self.own(self.natural)
        around = model.parameters[len(model.material.parameters) :]
        known = {each.name: float(value) for each, value in zip(around, own, strict=True)}
        # A fixed lattice: of given rates the weights are a convex problem, with one solution.
        self.rates = lattice(seen_by(parts, model, known, reference), PER_DECADE)
        # Lines that are known, or all alike and as stiff as what was measured.
        if lines is None:
            stiffness = typical_stiffness(parts)
            count = 2 + len(self.rates)
            self.weights: Real = np.full(count, stiffness / count)
            # No line is stiffer than its weight, a dashpot is where all is fast.
            self.weights[1] /= float(np.max(self.rates))
        else:
            self.rates, self.weights = lines.among(self.rates)
        self._lined(model)

    def _lined(self, model: Model) -> None:
        """Begin anew with the lines at `rates`."""
        self.count = 2 + len(self.rates)
        self.model = with_rates(model, self.rates.tolist())
        self.together = StackedResiduals(self.model, self.parts, self.reference)
        self.shown = shown_by(self.rates, self.rates)
        self.evaluations = 0
        self.last: tuple[Real, tuple[Real, Real]] | None = None

    def own(self, u: Real) -> Real:
        """Parameters of the effects at u."""
        return self.coordinates.theta(u, self.size)

    @property
    def natural(self) -> Real:
        """Where effects are of their natural size (q,)."""
        # An order begins in the middle, what may be of either sign, such as a drift, at nothing.
        middle = np.where(np.isfinite(self.bounds[0][0]), 0.5, 0.0)
        return np.where(self.coordinates.log, 0.0, middle)

    def start(self) -> MaterialPoint:
        """The lines before any search, with effects of their natural size."""
        u = self.natural
        for share in (1.0, 1e-2, 1e-4):
            # Effects that are far too large hide the material: smaller ones may be nearer.
            small = np.where(self.coordinates.log, u + np.log(share), u)
            cost = self.cost(self.weights, small)
            if np.isfinite(cost):
                return MaterialPoint(self.weights, small, cost)
        raise ModelError(f"{self.model.name} cannot be followed in these tests")

    def seeded(self, seeds: Sequence[Real]) -> list[MaterialPoint]:
        """Starts with these parameters of the effects, all lines alike.

        Those that cannot be followed are none.
        """
        starts = []
        for seed in seeds:
            u = self.coordinates.u(np.asarray(seed, dtype=float).copy(), self.size)
            u = np.clip(u, self.bounds[0][0], self.bounds[1][0])
            starts.append(MaterialPoint(self.weights, u, self.cost(self.weights, u)))
        return [start for start in starts if np.isfinite(start.cost)]

    def placed(self, start: MaterialPoint) -> MaterialPoint:
        """A start with each effect of the tests where it does most good, of its possible places."""
        tests = [part.test for part in self.parts if isinstance(part, InTimePart)]
        scales = Scales.of(self.parts)
        first = self.first_of_tests
        for effect in self.model.of_tests:
            own = slice(first, first + len(effect.element.parameters))
            first = own.stop
            reached = [start]
            # A test that is fitted alone may be none that the effect is seen in.
            seen_in = list(filter(effect.applies_to, tests))
            for values in tries_of(effect, seen_in[0], scales) if seen_in else ():
                theta = self.own(start.u)
                theta[own] = values
                there = self.coordinates.u(theta, self.size)
                begun = MaterialPoint(start.weights, there, self.cost(start.weights, there))
                if np.isfinite(begun.cost):
                    reached.append(self.descended(begun, BRIEF))
            start = min(reached, key=lambda each: each.cost)
        return start

    def closer(
        self, place: MaterialPoint, share: float, spared: bool
    ) -> tuple[MaterialSearch, MaterialPoint]:
        """A lattice closer by this share about the lines that carry, and the best place in it.

        Lines that carry nothing stay where effects are still on their way.
        """
        step = share * DECADE / PER_DECADE
        carry = place.weights[2:] > 0.0
        near = np.log(self.rates[carry])[:, None] + step * np.arange(-4.0, 5.0)
        kept = carry | (spared and len(place.u) > 0)
        search = copy(self)
        logs = np.concatenate([np.log(self.rates[kept]), near.ravel()])
        rates, first = np.unique(np.round(logs, 9), return_index=True)
        before = np.concatenate([place.weights[2:][kept], np.zeros(near.size)])
        search.rates = np.exp(rates)
        search._lined(self.model)
        begun = place._replace(weights=np.concatenate([place.weights[:2], before[first]]))
        return search, search.descended(begun, MOST_STEPS, STILL if spared else PRINTED)

    def found(self, place: MaterialPoint, evaluations: int) -> FoundLines:
        """What is known of this place."""
        weights, u, _ = place
        # Lines without weight are no parameters: intervals would count them.
        kept = weights[2:] > 0.0
        theta = np.concatenate([weights[:2], weights[2:][kept], self.own(u)])
        model = with_rates(self.model, self.rates[kept].tolist())

        def again(parts: Sequence[TestPart]) -> FoundLines:
            search = copy(self)
            search.parts = list(parts)
            search._lined(self.model)
            start = place._replace(cost=search.cost(weights, u))
            end = search.descended(start, MOST_STEPS)
            return search.found(end, search.evaluations)

        return FoundLines(model, theta, evaluations, self.untold(weights, u), again)

    @property
    def first_of_tests(self) -> int:
        """Where the coordinates of effects of tests begin, behind those of effects of the rig."""
        return len(self.model.of_specimen.parameters) - self.count

    def descended(self, place: MaterialPoint, steps: int, still: float = STILL) -> MaterialPoint:
        """Gauss-Newton steps, until one changes nothing that is printed."""
        for _ in range(steps):
            better = self.step(place, *self.slopes(place.weights, place.u))
            if better is None:
                break
            drop = place.cost - better.cost
            place = better
            if drop <= still * place.cost:
                break
        return place

    def cost(self, weights: Real, u: Real) -> float:
        """Sum of squares; endless where the model cannot be followed."""
        try:
            with np.errstate(all="ignore"):
                value = self._residual(weights, u)[0]
                cost = float(value @ value)
        except SpringpotError:
            return np.inf
        if not np.isfinite(cost):
            return np.inf
        return cost

    def theta(self, weights: Real, u: Real) -> Real:
        """Parameters (p,), in which no line weighs nothing.

        A line of no weight at all has no place among the times of the creep, and so no slope there.
        """
        # What is nothing beside K at each rate: one far beyond them may weigh a million times what
        # the tests show of it. Effects may leave nothing to any line.
        beside = np.abs(weights @ self.shown) / np.abs(self.shown[2:])
        least = ALIKE * np.min(beside, axis=1, initial=np.inf)
        return np.concatenate([weights[:2], np.maximum(weights[2:], least), self.own(u)])

    def _residual(self, weights: Real, u: Real) -> tuple[Real, Real]:
        theta = self.theta(weights, u)
        # A step that is taken asks for the slopes of where its cost was asked for.
        if self.last is not None and np.array_equal(self.last[0], theta):
            return self.last[1]
        self.evaluations += 1
        self.last = theta, self.together.residuals(theta)
        return self.last[1]

    def slopes(self, weights: Real, u: Real) -> tuple[Real, Real, Real]:
        """Residuals (m,), and their derivatives by the weights (m, w) and by u (m, q)."""
        value, by_theta = self._residual(weights, u)
        by_own = np.ascontiguousarray(by_theta[:, self.count :].T)
        by_weights = by_theta[:, : self.count]
        if self.linear:
            # A line that has faded before the first sample would weigh as much as it likes there,
            # and be all that a little later or colder test shows.
            size = np.linalg.norm(by_weights, axis=0)
            shown = size > NEGLIGIBLE * size[0]
            # A dashpot has another unit than lines.
            shown[1] = True
            by_weights = np.where(shown, by_weights, 0.0)
        return value, by_weights, self.coordinates.carry(by_own, self.own(u), self.size).T

    def untold(self, weights: Real, u: Real) -> str:
        """Why other lines could have done what an effect of the tests did; empty if none could.

        After a slow ramp, for one, a material relaxes as another one does after a step: a much
        smaller or larger effect leaves the same, the lines being chosen anew.
        """
        if not self.model.of_tests:
            return ""
        value, *slopes = self.slopes(weights, u)
        # What has no slope there takes nothing over.
        by_weights, by_u = (np.where(np.isfinite(each).all(axis=0), each, 0.0) for each in slopes)
        signal = np.concatenate([part.signal for part in self.parts])
        names = [parameter.name for parameter in self.model.parameters[self.count :]]
        for i in range(self.first_of_tests, len(u)):
            effect, others = by_u[:, i], np.delete(by_u, i, axis=1)
            # What may be of either sign has no logarithm, and may be nothing: it moves by what
            # could be seen.
            seen = VISIBLE * rms(signal) / max(rms(effect), SMALLEST)
            amount = 1.0 if self.coordinates.log[i] else seen
            # By a step either way.
            kept, *after = (
                _left(by_weights, others, by_weights @ weights - value - step * amount * effect)
                for step in (0.0, 1.0, -1.0)
            )
            if min(after) - kept < TWO_DEVIATIONS:
                return (
                    f"{names[i]}: another material could have done the same in these tests:"
                    " name a model in place of 'material', or add a test of another kind"
                )
        return ""

    def step(
        self, place: MaterialPoint, value: Real, by_weights: Real, by_u: Real
    ) -> MaterialPoint | None:
        """A better place, or None where none is found on the way to that of the linear problem."""
        weights, u, cost = place
        if not all(np.all(np.isfinite(each)) for each in (by_weights, by_u)):
            # K is a number here and its slope is none, as where a loop closes on itself: no way
            # leads on.
            return None
        # The whole of what the lines explain, not its change: whole weights are what must not fall
        # below zero.
        target = by_weights @ weights - value
        wanted = non_negative(beside_effects(by_u, by_weights), beside_effects(by_u, target))[0]
        move: Real = u
        if len(u):
            move = np.asarray(
                np.linalg.lstsq(by_u, target - by_weights @ wanted, rcond=1e-8)[0], dtype=float
            )
        low, high = self.bounds[0][0], self.bounds[1][0]
        allowed = np.clip(u + np.clip(move, -REACH, REACH), low, high) - u
        if np.any(allowed != move):
            # Lines for the step that is taken, not for the one that was too long.
            move = allowed
            wanted = non_negative(by_weights, target - by_u @ move)[0]
        foretold = value + by_weights @ (wanted - weights) + by_u @ move
        gain = cost - float(foretold @ foretold)
        share = 1.0
        # A share of the way gains twice that share of it at most: less than `STILL` would end the
        # descent, found or not.
        while share > NEGLIGIBLE and 2.0 * share * gain > STILL * cost:
            there = u + share * move
            # Between two sets of weights without a negative one there is none with one.
            nearer = weights + share * (wanted - weights)
            lower = self.cost(nearer, there)
            if lower < cost:
                return MaterialPoint(nearer, there, lower)
            share *= 0.3
        return None


def beside_effects(by_u: Real, each: Real) -> Real:
    """What effects whose derivatives are `by_u` (m, q) leave of something (m, ...)."""
    if not by_u.shape[1]:
        return each
    # Variable projection: what the effects could take up of each line is taken out of it.
    basis = np.linalg.qr(by_u)[0]
    return projected_out(each, basis)


def _left(by_weights: Real, by_u: Real, target: Real) -> float:
    """Sum of squares that the best lines and effects leave of a target (m,)."""
    lines, wanted = beside_effects(by_u, by_weights), beside_effects(by_u, target)
    return float(np.sum((lines @ non_negative(lines, wanted)[0] - wanted) ** 2))


@dataclass(frozen=True)
class TimeFloor:
    """Any linear passive material with the effects of a model.

    Attributes
    ----------
    errors : tuple of float
        The least error in each test, relative to its signal; nan where none can be told.
    """

    errors: tuple[float, ...]

    def beside(self, fits: Sequence[Identification]) -> TimeFloor:
        """The same, lowered by fits with the same effects whose own material is linear and passive.

        Lines stand apart, tests weigh against one another, and a search beside effects may stop
        short: a model that is such a material itself is a bound.
        """
        errors = list(self.errors)
        for fit in fits:
            own = [part.relative_rms for part in fit.parts]
            lower = [not floor <= error for floor, error in zip(errors, own, strict=True)]
            if any(lower) and is_linear(fit):
                errors = np.fmin(errors, own).tolist()
        return TimeFloor(tuple(errors))


def is_linear(fit: Identification) -> bool:
    """Whether the material of a fitted model is a linear passive one, as its error needs it."""
    if is_material(fit.model):
        return True
    return is_of_material(fit.model, fit.theta, fit.covered.rate, fit.relative_rms)


def material_floor(fits: Sequence[Identification]) -> TimeFloor:
    """The least error of any material in the place of a model's own, its effects going on.

    Parameters
    ----------
    fits : sequence of Identification
        Of tests of which one at least is in time, with the same effects; it begins with the best.
    """
    fit = min(fits, key=lambda one: one.cost)
    free = replace(any_material(), effects=fit.model.effects)
    # So that residuals are shares of the signal, as errors are printed.
    parts = [part.with_sd(part.size) for part in parts_of_specimen(fit.data)]
    own = fit.theta[len(fit.model.material.parameters) :]
    around = Around(coordinates_around(free, TimeSearch(free, parts, fit.reference)), own)
    try:
        bands = seen_by(parts, free, fit.model.named(fit.theta), fit.reference)
        lines = as_lines(fit.model, fit.theta, lattice(bands, PER_DECADE))
        found = descended_from(lines, free, parts, fit.reference, around)
    except SpringpotError:
        # Its effects have no law around lines: what remains is whether the model is a bound.
        return TimeFloor((float("nan"),) * len(parts)).beside([fit])
    missed = [part.residual(found.model, found.theta, fit.reference).value for part in parts]
    errors = [rms(each[part.counted]) for each, part in zip(missed, parts, strict=True)]
    return TimeFloor(tuple(errors)).beside([fit])


def coordinates_around(free: Model, search: TimeSearch) -> Coordinates:
    """Search coordinates of the effects around a material, of the sizes that a search has told."""
    effects = free.parameters[len(free.material.parameters) :]
    size, reach = search.sizes
    return Coordinates.of(effects, search.middle, np.array([size]), reach)


def as_lines(model: Model, theta: Real, rates: Real) -> ConvexSpectrum:
    """The material of a model as lines at given rates (m,), as near as any come to its K.

    Raises
    ------
    ModelError
        If its material asks for a condition.
    """
    if isinstance(model.material, Continuum):
        return spectrum_of(model, theta)
    if model.material.needs:
        raise ModelError(f"{model.name}: its material is none of one temperature and amplitude")
    alone = replace(model, effects=())
    stiffness = alone.stiffness(theta[: len(alone.parameters)], rates)
    size = np.abs(stiffness)
    columns = real_form((shown_by(rates, rates) / size).T)
    return ConvexSpectrum.of(non_negative(columns, real_form(stiffness / size))[0], rates)
