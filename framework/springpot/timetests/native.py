"""The native search for the parameters of a model of tests in time, and their intervals.

Where it begins, how it goes down, and how far about the minimum the tests leave the parameters
open: by slopes, profiles and simulated tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.distributions import student
from springpot.errors import SpringpotError
from springpot.identification.convex import start_of
from springpot.identification.intervals import (
    inverse_of,
)
from springpot.identification.leastsquares import (
    Solution,
    levenberg_marquardt,
    one_by_one,
)
from springpot.identification.material import is_material
from springpot.identification.native import NEAR
from springpot.identification.normal import spread_of
from springpot.identification.result import Identification
from springpot.identification.searching import NATIVE
from springpot.identification.task import FLAT_SHAPES
from springpot.identification.uncertainty import ends
from springpot.identification.value import PartResult, spare
from springpot.measurement.covered import Covered
from springpot.measurement.mixed_up import said_of_sign, sign_note
from springpot.measurement.steady_start import lasting
from springpot.measurement.timenoise import said_of_strays
from springpot.measurement.units import Units, one_modulus
from springpot.misfit.residuals_of_tests import (
    InTimePart,
    SweepPart,
    TestPart,
    reach_of,
    typical_stiffness,
)
from springpot.rheology.model import Model
from springpot.rheology.parameters import Coordinates
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, VERDICT

from ..numerics import ALIKE, FAR, MOST_STEPS, rms
from .exponentials import UnfollowedError, quick_parts
from .specimen import Scales, residual_of, tries_of, words_of

QUICK = 20
"""Steps with some of the samples."""
ORDERS = (0.3, 0.5, 0.8)
"""Of springpots, to begin at.

Real ones lie between, and from each of these the search reaches the next.
"""
EDGE = 0.05
"""Share of its range by which a parameter with two ends begins away from them."""
STARTS = 4
"""Places in the parameters of an effect from which a fit begins."""
AFAR = 1e-3
"""Damping at a start."""
ROUGHLY = 1e-5
"""Drop foretold, over the objective, that ends the first part of a search: the last goes on."""
ENDED = {True: "converged", False: "not converged"}


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a search ended.

    Attributes
    ----------
    u : ndarray, shape (p,)
        The best search point.
    parts : sequence of TestPart
        The tests, as they weighed in the end.
    alone : sequence of float
        Error of each over its noise, with parameters of its own.
    evaluations : int
        Of the model, with derivatives.
    converged : bool
        Whether the search came to rest.
    """

    u: Real
    parts: Sequence[TestPart]
    alone: Sequence[float]
    evaluations: int
    converged: bool


class TimeSearch:
    """A model and the tests of a specimen, in the coordinates of the native solver.

    Parameters
    ----------
    model : Model
        What is fitted.
    parts : sequence of TestPart
        To what.
    reference : float
        Temperature in kelvin at which shifts are one.
    seeds : sequence of ndarray, shape (p,)
        Further starts.
    thorough : bool
        Whether starts other than the seeds are tried.
    """

    def __init__(
        self,
        model: Model,
        parts: Sequence[TestPart],
        reference: float,
        seeds: Sequence[Real] = (),
        thorough: bool = True,
    ) -> None:
        self.thorough = thorough
        self.model, self.parts, self.reference, self.seeds = (
            model,
            list(parts),
            reference,
            list(seeds),
        )
        # Set once a model was followed: from then on a fault is one of the parameters, and a search
        # may go on.
        self._followed = False
        self._asked: tuple[Sequence[TestPart], Sequence[TestPart]] = (), ()
        # Between the frequencies that the tests saw: there a springpot's constant hardly hangs on
        # its order.
        middle = float(np.mean([part.log_omega for part in parts]))
        size = typical_stiffness(parts)
        amplitude = reach_of(parts)
        self.sizes, self.middle = (size, amplitude), middle
        self.coordinates = Coordinates.of(model.parameters, middle, np.array([size]), amplitude)
        self.size = self.coordinates.size[0]
        # What goes as a power of time has its natural size at any time of the tests.
        scales = Scales.of(parts)
        times = [
            0 if isinstance(each.unit.time, str) else each.unit.time for each in model.parameters
        ]
        self.far = FAR + 0.5 * np.log(scales.longest / scales.shortest) * np.abs(times)
        self._weights = 0
        if is_material(model):
            self._weights = len(model.material.parameters)

    def starts(self) -> list[Real]:
        """Search points (p,) to begin at."""
        if not self.thorough:
            return [
                self.coordinates.u(np.asarray(theta, dtype=float), self.size)
                for theta in self.seeds
            ]
        # The material first: its start is read off the data, and what a test adds is sought on top
        # of it.
        in_time = [part for part in self.parts if isinstance(part, InTimePart)]
        sweeps = [part.test for part in self.parts if isinstance(part, SweepPart)]
        material = self.model.of_specimen
        begin = list(self.seeds)
        for of_material in start_of(material, [part.apparent for part in in_time], sweeps):
            begin += self._with_effects(of_material, in_time)
        starts = [self.coordinates.u(np.asarray(theta, dtype=float), self.size) for theta in begin]
        return [self.inside(u) for u in starts] or self.natural()

    def _with_effects(self, material: Real, in_time: Sequence[InTimePart]) -> list[Real]:
        """Starts with these of the material, and each effect of tests where it does most good."""
        theta = [np.asarray(material, dtype=float)]
        scales = Scales.of(self.parts)
        for effect in self.model.of_tests:
            # Any test in which it can be seen will do: it is one effect, of one size, in all of
            # them.
            mine = next(part.test for part in in_time if effect.applies_to(part.test))
            places = [np.array(place) for place in tries_of(effect, mine, scales)]
            # One effect at a time: the product of all places of all effects would be hundreds of
            # starts. Without a place for one of them there is no start with all of them.
            if not places:
                return []
            best = theta[0]
            theta = sorted([np.concatenate([best, place]) for place in places], key=self._misfit)
        return theta[:STARTS]

    def _misfit(self, theta: Real) -> float:
        """Sum of squares at a start that may lack the parameters of the last effects."""
        if len(theta) < len(self.model.parameters):
            return 0.0
        value, _ = self.guarded(self.parts, self.coordinates.u(theta, self.size), True)
        return float(np.sum(value**2))

    def natural(self) -> list[Real]:
        """Starts at the natural sizes, for each of a few orders."""
        return [self.inside(np.where(self.coordinates.log, 0.0, order)) for order in ORDERS]

    def inside(self, u: Real) -> Real:
        """A start away from the ends, where nothing would tell the way back."""
        low, high = (bound[0] for bound in self.coordinates.bounds)
        # Read off data, a parameter may have come out as nothing or as endless: it begins anew at
        # its natural size.
        astray = self.coordinates.log & (np.abs(u) > self.far)
        ordinary = np.where(astray, 0.0, u)
        width = np.where(np.isfinite(high - low), high - low, 0.0)
        linear = ~self.coordinates.log & (width > 0.0)
        return np.where(
            linear, np.clip(ordinary, low + EDGE * width, high - EDGE * width), ordinary
        )

    def theta(self, u: Real) -> Real:
        """Parameters (p,) at u (p,), within their bounds."""
        theta = self.coordinates.theta(u, self.size)
        inside: Real = np.clip(theta, *self.model.box)
        # A spectrum has no spring or no dashpot at all: with a trace of a spring a fluid would not
        # creep on and on.
        gone = u[: self._weights] <= self.coordinates.bounds[0][0, : self._weights]
        inside[: self._weights][gone] = 0.0
        return inside

    def residual(
        self, parts: Sequence[TestPart], u: Real, coarse: bool = False
    ) -> tuple[Real, Real]:
        """Residuals (m,) of all parts and their derivative (p, m) by u."""
        theta = self.theta(u)
        value, by_theta = residual_of(parts, self.model, theta, self.reference, coarse)
        return value, self.coordinates.carry(by_theta.T.copy(), theta, self.size)

    def quickly(self, parts: Sequence[TestPart]) -> Sequence[TestPart]:
        """These parts by fixed exponentials; asked again, with all that is known of them."""
        if parts is not self._asked[0]:
            self._asked = parts, quick_parts(parts)
        return self._asked[1]

    def solved(self, parts: Sequence[TestPart], starts: Sequence[Real]) -> tuple[Real, int, bool]:
        """The best search point (p,), evaluations spent, and whether the search came to rest."""
        return self.ended(parts, *self.near(parts, starts))

    def ended(self, parts: Sequence[TestPart], near: Real, spent: int) -> tuple[Real, int, bool]:
        """The same from a point near the best one, where `spent` evaluations have led."""
        # With all samples and exact answers, mostly near enough to the minimum for undamped steps;
        # from a flat end, such as an endless spring, it is a longer way.
        last = self._descend(parts, near[None], False, MOST_STEPS, NEAR)
        return last.u[0], spent + last.evaluations, bool(last.converged[0])

    def near(self, parts: Sequence[TestPart], starts: Sequence[Real]) -> tuple[Real, int]:
        """A search point (p,) near the best one, and evaluations spent.

        By fixed exponentials where they will do.
        """
        quick, further = self.quickly(parts), self.natural() if self.thorough else []
        try:
            # Exponentials show the valley at little cost, whatever the starts; the exact response
            # then has a short way to its bottom.
            u, spent, _, rests = self._best_of(quick, [*starts, *further])
            if rests:
                return u, spent
            last = self._descend(quick, u[None], True, MOST_STEPS, AFAR)
        # A mass that swings or a loss that is not causal is no sum of exponentials.
        except UnfollowedError:
            if quick == list(parts):
                raise
            u, spent, cost, _ = self._best_of(parts, starts)
            count = sum(part.count(coarse=True) for part in parts)
            # A cost is a sum of squares over the noise: one for each number where the model is
            # right. Where it does not agree with that noise other starts are tried too.
            if further and cost > VERDICT.agrees**2 * count:
                u, more, _, _ = self._best_of(parts, [u, *further])
                spent += more
            # A few samples showed the valley: what is judged by all of them ends at their bottom.
            last = self._descend(parts, u[None], False, QUICK, AFAR)
        return last.u[0], spent + last.evaluations

    def _best_of(
        self, parts: Sequence[TestPart], starts: Sequence[Real]
    ) -> tuple[Real, int, float, bool]:
        """Where the best of some starts has led, evaluations spent, its cost, whether it rests."""
        # A few steps from everywhere tell the starts apart; only the best is worth its way to the
        # end.
        quick = self._descend(parts, np.stack(starts), True, QUICK, AFAR)
        best = quick.best
        if not np.isfinite(quick.cost[best]):
            raise UnfollowedError(f"{self.model.name} cannot be followed from any start")
        return quick.u[best], quick.evaluations, quick.cost[best], bool(quick.converged[best])

    def _descend(
        self, parts: Sequence[TestPart], starts: Real, coarse: bool, iterations: int, damping: float
    ) -> Solution:
        return levenberg_marquardt(
            one_by_one(lambda u: self.guarded(parts, u, coarse)),
            starts,
            *self.coordinates.bounds,
            iterations=iterations,
            damping=damping,
            flat=ROUGHLY if coarse else FLAT_SHAPES,
        )

    def guarded(self, parts: Sequence[TestPart], u: Real, coarse: bool) -> tuple[Real, Real]:
        """The residual, endless at parameters at which the model cannot be followed."""
        try:
            with np.errstate(all="ignore"):
                value, slopes = self.residual(parts, u, coarse)
        except SpringpotError:
            # Nothing was ever followed: the fault is the model's, not that of these parameters.
            if not self._followed:
                raise
            count = sum(part.count(coarse) for part in parts)
            # Endless, so that the step is taken back, as any other that led astray.
            return np.full(count, np.inf), np.zeros((len(u), count))
        self._followed = True
        return value, np.nan_to_num(slopes)

    def ratio(self, part: TestPart, u: Real) -> float:
        """Root mean square of a part's residuals over its noise."""
        value = part.over_noise(self.model, self.theta(u), self.reference).value
        return rms(value)

    def scale(self, part: TestPart, u: Real) -> float:
        """How far a part's misfit exceeds its noise, repeated samples counted once.

        Or falls short of it: neighbours of a sparse sweep differ by what bends between them too,
        and tell no more than a bound.
        """
        value = part.over_noise(self.model, self.theta(u), self.reference).value
        square, spare = part.sampled(value), len(value) - len(u)
        bound = isinstance(part, SweepPart) and part.noise is None and part.test.sd is None
        if bound and spare >= VERDICT.enough_spare:
            return max(float(np.sqrt(square * len(value) / spare)), ALIKE)
        return max(1.0, float(np.sqrt(square)))

    def result(self, found: Minimum, seconds: float) -> Identification:
        """The answer where a search ended."""
        theta = self.theta(found.u)
        rows = [
            part_result(part, self.model, theta, self.reference, ratio)
            for part, ratio in zip(found.parts, found.alone, strict=True)
        ]
        units = _units(found.parts)
        covariance = self._covariance(found.u, found.parts)
        slopes = self.coordinates.slopes(theta, self.size)
        low, high = self._interval(theta, covariance, sum(row.points for row in rows))
        return Identification(
            model=self.model,
            theta=theta,
            slopes=slopes,
            spread=covariance,
            units=units,
            reference=self.reference,
            misfit=max(row.relative_rms for row in rows),
            # Samples whose misses are alike were counted once in the covariance already.
            dof=spare(rows, theta),
            covered=Covered.of([part.test for part in found.parts], units),
            words=words_of(self.model, [part.test for part in found.parts]),
            low=low,
            high=high,
            data=tuple(part.test for part in found.parts),
            parts=tuple(rows),
            objective="noise",
            cost=sum(row.points * row.over_floor**2 for row in rows),
            optimiser=NATIVE,
            status=ENDED[found.converged],
            converged=found.converged,
            evaluations=found.evaluations,
            seconds=seconds,
            notes=_doubts(found.parts),
        )

    def _interval(self, theta: Real, covariance: Real, points: int) -> tuple[Real, Real]:
        """Ends (p,) of the 95 % intervals: by factors for what is searched by its logarithm."""
        quantile = student(INTERVAL, max(points - len(theta), 1))
        # The covariance is that of search coordinates: it is carried to what is printed.
        reach = quantile * spread_of(self.coordinates.slopes(theta, self.size), covariance)
        log = self.coordinates.log
        with np.errstate(all="ignore"):
            # What is searched by its logarithm reaches by a factor: d ln theta is d theta over
            # theta.
            reach = np.where(log, reach / np.where(log, theta, 1.0), reach)
        # What the tests do not determine reaches anywhere.
        reach = np.where(np.isfinite(reach), reach, np.inf)
        return ends(theta, reach, log, self.model.box)

    def _covariance(self, u: Real, parts: Sequence[TestPart]) -> Real:
        """Of the search coordinates (p, p).

        Each part weighs as its misfit and the likeness of neighbours allow.
        """
        # Tests are independent of one another: what they tell of the parameters adds up.
        information = np.zeros((len(u), len(u)))
        for part in parts:
            value, slopes = self.residual([part], u)
            if (after := after_many_cycles(part)) is not part:
                _, slopes = self.residual([after], u)
            information += slopes @ slopes.T / part.beside(value, len(u))
        return inverse_of(information)


def part_result(
    part: TestPart, model: Model, theta: Real, reference: float, alone: float
) -> PartResult:
    """How far a model with these parameters is off in one part.

    Parameters
    ----------
    part : TestPart
        The test.
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters.
    reference : float
        Temperature in kelvin at which shifts are one.
    alone : float
        Root mean square of the residuals over their noise with parameters of its own.
    """
    weighted = part.over_noise(model, theta, reference).value
    error, floor, test = part.relative_error(weighted), rms(part.relative_sd), part.test
    return PartResult(test.name, test.kind, len(test), error, floor, rms(weighted), alone)


def after_many_cycles(part: TestPart) -> TestPart:
    """A record of what had gone on, which had for much longer; any other part itself."""
    if not isinstance(part, InTimePart) or not part.test.loading.is_cycled:
        return part
    test = replace(part.test, loading=lasting(part.test.loading))
    return replace(part, test=test, noise=part.sd)


def _doubts(parts: Sequence[TestPart]) -> tuple[str, ...]:
    """Samples that were left out, and tests whose columns seem to count in opposite directions."""
    in_time = [part.test for part in parts if isinstance(part, InTimePart)]
    doubts = [said for test in in_time if (said := said_of_strays(test))]
    doubts += [said for test in in_time if (said := test.said_of_start)]
    for test in in_time:
        noted = {**sign_note(test, f"force=-{test.force_unit}"), **test.provenance}
        doubts += [f"{test.name}: {said}" for said in said_of_sign(noted)]
    return tuple(doubts)


def _units(parts: Sequence[TestPart]) -> Units:
    """Those of all parts; that of them which knows its modulus tells it."""
    letter = one_modulus((part.test.name, part.test.units) for part in parts)
    return replace(parts[0].test.units, letter=letter)
