"""A test in time followed by a fixed set of exponentials, as a search needs it a thousand times.

The exact response reads the spectrum of the network anew for each parameter vector. Here the
exponentials stay where they are; what each answers to the loading is worked out once, and a model
is the amounts of them that follow its K at some frequencies: two products of small matrices, with
the derivatives. That is good to a part in a thousand or better, so that a search which ends here is
finished by a few exact steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.identification.convex import answers_of
from springpot.measurement.imposed import Loading
from springpot.measurement.recording import (
    Clock,
    Record,
    at_loading,
    at_stage,
    at_work,
    indices,
    reached,
    shown,
    spread,
)
from springpot.misfit.residuals_of_tests import InTimePart, Residual, TestPart
from springpot.rheology.effect import on_clock
from springpot.rheology.intime import Traced
from springpot.rheology.model import (
    Model,
    forces_along,
    linear_network,
    sorted_out,
    through,
    with_laws,
)
from springpot.rheology.named import Placed
from springpot.rheology.nodes import GRADIENT, Node
from springpot.rheology.nonlinear import Law
from springpot.rheology.points import Complex, Points, Real, real_form

from ..numerics import ALIKE, DIFFERENCE, ENOUGH, PRINTED, evenly, rms

if TYPE_CHECKING:
    from springpot.measurement.timetest import TimeTest

PER_DECADE = 4
"""Exponentials a decade: a part in a thousand of a springpot's response, or better."""
FREQUENCIES = 8
"""Frequencies a decade at which K is followed."""
BEYOND = 10.0
"""Factor by which the times of the exponentials reach beyond those of the test."""
NEAR = 3.0
"""The same of the frequencies: what happens further out is not in the record."""
SHARP = 30.0
"""By how much further both reach up where a displacement is imposed.

Its steps are sharper than its samples near.
"""
FOLLOWED = 0.1
"""Share of K that the exponentials may miss.

What they cannot follow, such as a loss that is not causal or the swing
of a mass, is left to the exact response."""
FAR = 1e30
"""Factor beyond the test's frequencies where dashpot and mass are all that is left.

There they are read off.
"""
CLOSE = 0.05
"""How nearly K must go there as omega or omega squared."""


class UnfollowedError(ModelError):
    """The exponentials cannot follow a model."""


def points_at(omega: Real, kelvin: float | None, reference: float) -> Points:
    """Points at one temperature in kelvin."""
    temperature = None
    if kelvin is not None:
        temperature = np.full(len(omega), kelvin)
    return Points(np.log(omega), None, temperature, reference)


@dataclass(frozen=True, eq=False)
class QuickPart(InTimePart):
    """A test in time, followed by fixed exponentials; see `InTimePart`.

    Parameters
    ----------
    known : tuple of ndarray
        Angular frequencies (w,) and |K| (w,) near them, by which K is weighed.
    """

    known: tuple[Real, Real] = (np.ones(1), np.ones(1))

    @cached_property
    def rows(self) -> NDArray[np.intp]:
        """Numbers of the samples that are looked at."""
        return evenly(len(self.test), ENOUGH)

    @cached_property
    def t(self) -> Real:
        """Their times."""
        return self.test.time[self.rows]

    @cached_property
    def weight(self) -> Real:
        """One over the noise; as many samples as are left out count with the others."""
        # So that a test of a million samples outweighs one of a thousand as much as it would with
        # all of them.
        more = np.sqrt(len(self.test) / len(self.rows))
        return np.where(self.counted[self.rows], more, 0.0) / (self.scale * self.sd[self.rows])

    @cached_property
    def times(self) -> Real:
        """Of the exponentials, in s."""
        slow, fast = self.band
        decades = np.log10(fast / slow) + 2.0 * np.log10(BEYOND)
        return np.geomspace(1.0 / (BEYOND * fast), BEYOND / slow, int(PER_DECADE * decades) + 2)

    @property
    def band(self) -> tuple[float, float]:
        """Angular frequencies between which the record tells something."""
        slow, fast = self.test.seen
        if self.test.control == "displacement":
            fast *= SHARP
        return slow, fast

    @cached_property
    def omega(self) -> Real:
        """Angular frequencies at which K is followed, and two far beyond."""
        slow, fast = self.band
        decades = np.log10(fast / slow) + 2.0 * np.log10(NEAR)
        band = np.geomspace(slow / NEAR, fast * NEAR, int(FREQUENCIES * decades) + 4)
        return np.append(band, [FAR * fast, 10.0 * FAR * fast])

    @cached_property
    def share(self) -> Real:
        """By which K, or 1/K under a force, is weighed at each frequency."""
        size = np.exp(
            np.interp(np.log(self.omega[:-2]), np.log(self.known[0]), np.log(self.known[1]))
        )
        # Each frequency counts by its relative miss: of K here, of 1/K under a force.
        if self.test.control == "displacement":
            return 1.0 / size
        return size

    @cached_property
    def answers(self) -> Real:
        """What a spring, dashpot, mass and each exponential answer to the loading: (n, 3 + m)."""
        return self.answers_to(self.with_fewer_knots.loading, self.t)

    @cached_property
    def with_fewer_knots(self) -> TimeTest:
        """The test under fewer knots of a motion of which far more were recorded than it needs.

        An exact answer knows them all.
        """
        test, loading = self.test, self.test.loading
        # The samples that are looked at are among them, so that these need no knots of their own.
        shown = evenly(len(test), 4 * (len(self.rows) - 1) + 1)
        count, before = len(loading.time), loading.before
        if len(shown) == len(test) or not loading.sampled or count != before + len(test):
            return test
        # How it had gone on until then is as fine.
        kept = np.append(np.arange(0, before, len(test) // len(shown)), before + shown)
        coarse = replace(
            loading,
            time=loading.time[kept],
            value=loading.value[kept],
            before=int(np.searchsorted(kept, before)),
        )
        course = coarse.motion
        if course is None or len(loading.jumps[0]):
            return test
        between = course.at(loading.time)
        missed = between.value[np.searchsorted(between.time, loading.time)] - loading.value
        if rms(missed) > PRINTED * rms(loading.value - loading.value.mean()):
            return test
        return replace(test, loading=coarse)

    def answers_to(self, loading: Loading, t: Real, mix: Real | None = None) -> Real:
        """The same for another loading, or by another clock.

        With a mix of amounts (3 + m, c), those of mixtures.
        """
        return np.nan_to_num(answers_of(loading, self.test.control, self.times, t, mix))

    @cached_property
    def solver(self) -> tuple[Real, Real]:
        """What the exponentials are at the frequencies (2 w, b), and its inverse (b, 2 w)."""
        s = 1j * self.omega[:-2, None]
        turned = s * self.times
        one, nothing = np.ones_like(s), np.zeros_like(s)
        if self.test.control == "displacement":
            # A mode too fast for the test is a dashpot, unless a step has no speed.
            dashpot = nothing if len(self.test.loading.jumps[0]) else s
            # A spring, no mass, then Maxwell elements: in the order of `answers_of`.
            columns = np.hstack([one, dashpot, nothing, turned / (1.0 + turned)])
        else:
            # Under a force the compliances: spring, dashpot, no mass, then Kelvin elements.
            columns = np.hstack([one, 1.0 / s, nothing, 1.0 / (1.0 + turned)])
        columns = columns * self.share[:, None]
        basis = real_form(columns)
        size = np.linalg.norm(basis, axis=0)
        # What has no column here is taken off before.
        size[size == 0.0] = 1.0
        # Neighbouring exponentials are alike: without a limit their amounts would grow against one
        # another.
        return basis, np.linalg.pinv(basis / size, rcond=1e-7) / size[:, None]

    def followed(self, change: Complex, surely: bool | NDArray[np.bool_] = True) -> Real:
        """Amounts (b, g) of the exponentials that follow K or 1/K (g, w).

        Numbers that are none where they cannot, of those that they must `surely` (g,).
        """
        asked, ends = self._asked(change)
        basis, inverse = self.solver
        amounts: Real = inverse @ asked
        missed = np.linalg.norm(basis @ amounts - asked, axis=0)
        # Of a mass alone nothing but rounding is left to be followed.
        whole = np.linalg.norm(change[:, :-2] * self.share, axis=1)
        good = missed <= FOLLOWED * np.linalg.norm(asked, axis=0) + ALIKE * whole
        # What was taken off K comes back as amounts of dashpot and mass.
        amounts[1:3] += ends
        return np.where(good | np.logical_not(surely), amounts, np.nan)

    def _asked(self, change: Complex) -> tuple[Real, Real]:
        """What exponentials should follow (2 w, g), dashpots and masses (2, g) being taken off K.

        These feel velocity and acceleration, which exponentials would have to be infinitely fast
        for.
        """
        ends = np.zeros((2, len(change)))
        here = change[:, :-2]
        if self.test.control == "displacement":
            far, omega = change[:, -2:], self.omega[-2:]
            with np.errstate(all="ignore"):
                # At ten times the frequency the force of a dashpot is ten times as large, that of a
                # mass a hundred times.
                pace = np.stack(
                    [
                        far[:, 1].imag / far[:, 0].imag / 10.0,
                        far[:, 1].real / far[:, 0].real / 100.0,
                    ]
                )
            dashpot_and_mass = np.stack(
                [far[:, 0].imag / omega[0], -far[:, 0].real / omega[0] ** 2]
            )
            ends = np.where(np.abs(pace - 1.0) < CLOSE, dashpot_and_mass, 0.0)
            s = 1j * self.omega[:-2]
            here = here - ends[0][:, None] * s - ends[1][:, None] * s**2
        wanted = here * self.share
        return np.concatenate([wanted.real, wanted.imag], axis=1).T, ends

    @cached_property
    def record(self) -> Record:
        """What laws are told."""
        return Record.of(self.test, self.t)

    @cached_property
    def force_of(self) -> Callable[[Node, tuple[float, ...]], Law]:
        """Forces (n,) of laws beside the material; where a scan looks again they are known."""
        return lru_cache(maxsize=256)(forces_along(self.t, self.record.imposed))

    @classmethod
    def of(cls, part: InTimePart) -> QuickPart:
        """A part, weighed by the stiffness that its record amounts to."""
        # Relative misses need a size of K before any model is known: the record itself gives it,
        # roughly.
        made = part.apparent
        alike = part.test, part.scale, part.noise, part.worth, part.told
        if made is None:
            return cls(*alike)
        return cls(*alike, (made.omega, made.magnitude))

    def with_scale(self, scale: float) -> QuickPart:
        """The same with larger noise; what is known already is kept."""
        if scale == self.scale:
            return self
        # Their answers are most of the work; of all that is known the weight alone goes by it.
        other = replace(self, scale=scale)
        known = {name: value for name, value in vars(self).items() if name != "weight"}
        vars(other).update(known | vars(other))
        return other

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        return len(self.rows)

    def residual(
        self, model: Model, theta: Real, reference: float, coarse: bool = False
    ) -> Residual:
        """Predicted less measured, over the noise."""
        if self.test.warmth is not None and "temperature" in model.needs:
            raise UnfollowedError("the temperature moves")
        return self.missed(self.recorded(model, theta, reference), self.rows, self.weight)

    def nearly(
        self, model: Model, theta: Real, reference: float, by: Sequence[int]
    ) -> Iterator[Residual]:
        """The same of each of many thetas (g, p), at the mean of a temperature that moves.

        What would take time to be followed is followed only `by` some of its parameters. Numbers
        that are none stand where exponentials follow no model, or not its slopes.
        """
        there, places = model.had_by(self.test)
        asked = [i for i, place in enumerate(places) if place in by]
        for answer in self._recorded(there, theta[:, places], reference, asked, surely=True):
            yield self.missed(spread(answer, places, theta.shape[1]), self.rows, self.weight)

    def exactly(self, model: Model, theta: Real, reference: float) -> Residual:
        """The same by the exact response."""
        answer = self.answer(model, theta, reference, self.rows)
        return self.missed(answer, self.rows, self.weight)

    def recorded(self, model: Model, theta: Real, reference: float) -> Traced:
        """What the test records of a model, nearly.

        Raises
        ------
        UnfollowedError
            If these exponentials cannot follow the model.
        """
        # An effect that this test cannot have, such as a limit of force in creep, leaves it as it
        # is.
        there, places = model.had_by(self.test)
        every = range(len(places))
        [answer] = self._recorded(there, theta[None, places], reference, every, surely=False)
        return spread(answer, places, len(theta))

    def _recorded(
        self, model: Model, theta: Real, reference: float, by: Sequence[int], surely: bool
    ) -> Iterator[Traced]:
        """The same of a model all of whose effects the test has, at each theta (g, p)."""
        mine, _ = at_work(model, self.test)
        network, places = linear_network(model)
        inner = [i for i, place in enumerate(places) if place in by]
        value, by_theta, _ = network.respond(theta[:, places], self._points(reference), GRADIENT)
        # Value and derivatives go through the same two matrices, side by side.
        mixes = self._amounts(value, by_theta[:, inner], surely)
        courses = self._courses(mine, theta, mixes, by)
        for values, (both, moved, columns) in zip(theta, courses, strict=True):
            slopes = np.zeros((len(self.t), len(values)))
            slopes[:, [places[i] for i in inner]] = both[:, 1:]
            if moved:
                slopes[:, moved] = columns
            answer = self._with_laws(model, values, Traced(both[:, 0], slopes))
            yield shown(mine, values, self.record, *answer)

    def _with_laws(self, model: Model, theta: Real, traced: Traced) -> Traced:
        """An answer with the forces beside the material, as the measurement chain shows it."""
        _, beside, signals = sorted_out(model)
        if at_work(model, self.test)[1]:
            beside = ()
        if not beside and not signals:
            return traced
        # Steps have no speed, and laws of a force ask for displacements.
        forced = self.test.control == "force"
        if len(self.test.loading.jumps[0]) or (beside and forced):
            raise ModelError(f"{model.name} has no answer to a step or a force")
        if forced:
            return through(traced, signals, theta, self.t, "under_force")
        return with_laws(traced, beside, signals, theta, self.t, self.force_of)

    def _points(self, reference: float) -> Points:
        return points_at(self.omega, self.test.kelvin, reference)

    def _amounts(self, value: Complex, by_theta: Complex, surely: bool) -> Real:
        """Amounts of the exponentials at each theta, beside their derivatives (b, g, 1 + q).

        Of K (g, w) and its derivatives (g, q, w).
        """
        if self.test.control == "force":
            # Under a force the exponentials add up to 1/K, and d(1/K) = -dK / K^2.
            by_theta = -by_theta / value[:, None] ** 2
            value = 1.0 / value
        whole = np.concatenate([value[:, None], by_theta], axis=1)
        must = np.full(whole.shape[:2], surely)
        must[:, 0] = True
        amounts = self.followed(whole.reshape(-1, whole.shape[2]), must.ravel())
        if not surely and not np.all(np.isfinite(amounts[:, 0])):
            raise UnfollowedError("no sum of exponentials follows the model")
        return amounts.reshape(len(amounts), *whole.shape[:2])

    def _courses(
        self, mine: Sequence[Placed], theta: Real, mixes: Real, by: Sequence[int]
    ) -> Iterator[tuple[Real, list[int], Real]]:
        """At each theta the answers (n, c), and the slopes (n, q) by what moves the loading."""
        moving = indices([*at_loading(mine), *at_stage(mine, on_clock)])
        moved = [i for i in moving if i in by]
        if moved or (theta[:, moving] != theta[0, moving]).any():
            for i, values in enumerate(theta):
                both, columns = self._course(mine, values, mixes[:, i], by)
                yield both, moved, columns
            return
        # One loading and one clock for all of them.
        whole, columns = self._course(mine, theta[0], mixes.reshape(len(mixes), -1), by)
        every = whole.reshape(len(whole), *mixes.shape[1:])
        for i in range(len(theta)):
            yield every[:, i], moved, columns

    def _course(
        self, mine: Sequence[Placed], theta: Real, mix: Real, by: Sequence[int]
    ) -> tuple[Real, Real]:
        """Answers (n, c) to what reached the specimen by its clock, and slopes (n, q) by these."""
        loads, clocks = at_loading(mine), at_stage(mine, on_clock)
        if not loads and not clocks:
            # Nothing was moved: what was worked out once will do.
            return self.answers @ mix, np.zeros((len(self.t), 0))
        loading, slopes = reached(mine, theta, self.with_fewer_knots, self.t)

        def at(load: Loading, values: Real, amounts: Real) -> Real:
            if not clocks:
                return self.answers_to(load, self.t, amounts)
            clock = Clock(clocks, values, self.test.start)
            return self.answers_to(clock.turned(load, self.t), clock.at(self.t), amounts)

        both, alone = at(loading, theta, mix), mix[:, :1]
        columns = [
            at(slope, theta, alone)[:, 0]
            for index, slope in zip(indices(loads), slopes, strict=True)
            if index in by
        ]
        for index in indices(clocks):
            if index not in by:
                continue
            # A clock bends time for all exponentials at once, which has no closed derivative here.
            step = DIFFERENCE * max(abs(float(theta[index])), DIFFERENCE)
            more = at(loading, theta + step * (np.arange(len(theta)) == index), alone)[:, 0]
            columns.append((more - both[:, 0]) / step)
        # An effect all of whose parameters are held has none.
        return both, np.column_stack([np.zeros((len(self.t), 0)), *columns])


def quick_parts(parts: Sequence[TestPart]) -> list[TestPart]:
    """All tests as a search sees them; at frequencies the exact answer is a formula already."""
    # One that is quick already is a part in time too, by inheritance: it stays as it is.
    return [QuickPart.of(part) if type(part) is InTimePart else part for part in parts]
