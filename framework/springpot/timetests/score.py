"""The linearised scan: how far each effect would let the error fall, before any is fitted.

A small amount of an effect changes K by a known amount at all frequencies. Both are sums of the
same exponentials, and what each exponential answers to the loading of a test is worked out once:
the change of the record is a product of two matrices. What is not small, such as a stop that is met
or not, is tried at a few places as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from itertools import pairwise, product
from math import prod

import numpy as np

from springpot.diagnosis.scan import PARALLEL
from springpot.errors import SpringpotError
from springpot.identification.result import Identification
from springpot.measurement.opening import Test
from springpot.measurement.recording import Clock, at_loading, is_eased, reached, recorded
from springpot.misfit.frame import Tangent, able_to_follow
from springpot.misfit.residuals_of_tests import Residual, TestPart
from springpot.rheology.effect import Effect, acting, on_clock, on_response
from springpot.rheology.model import Model, linear_network, sorted_out
from springpot.rheology.named import Placed
from springpot.rheology.nodes import GRADIENT, Node
from springpot.rheology.nonlinear import Law
from springpot.rheology.points import Complex, Points, Real

from ..numerics import NEGLIGIBLE, SMALLEST
from .exponentials import QuickPart, points_at
from .hypotheses import Atom, ScanEntry
from .specimen import MOST, Scales, stepped, tries_of

STEEP = 1.2
"""Power of omega from which a change of K makes a specimen under a force swing.

It is then never small: dashpots have 1, Basset's layer 1.5, a mass 2.
"""
GIVING = (0.3, 1.0, 3.0, 10.0)
"""Of the natural size of what gives way in series: sizes at which it is tried as it is.

K saturates there, which no
small step foretells."""
RESONANCES = 12
"""Bands of frequency in each of which an effect that makes the specimen swing is tried."""


class TimeScan:
    """A fitted model, its tests, and what each of many effects would change.

    Parameters
    ----------
    base : Identification
        The fit.
    parts : sequence of TestPart
        Its tests.
    """

    def __init__(self, base: Identification, parts: Sequence[TestPart]) -> None:
        self.base, self.model, self.theta = base, base.model, base.theta
        self.views = [
            View(part, base) if isinstance(part, QuickPart) else ExactView(part, base)
            for part in parts
        ]
        self.scales = Scales.of(parts)
        # One long row for all tests: an effect must explain them together, with one size.
        self.residual = np.concatenate([view.residual for view in self.views])
        slopes = np.concatenate([view.slopes for view in self.views])
        # A parameter that a fit has led beyond all sizes has slopes that are no numbers: it takes
        # nothing over.
        slopes = np.where(np.isfinite(slopes).all(axis=0), slopes, 0.0)
        # Nor does one that its bound holds.
        signal = np.concatenate([part.signal for part in parts])
        free = able_to_follow(self.model, self.theta, -self.residual, slopes.T, signal)
        self.tangent = Tangent.of(np.where(free, slopes, 0.0))

    def entries(self, effects: Iterable[Effect]) -> dict[str, list[ScanEntry]]:
        """For each effect what the scan says at each place, the best first.

        Those that make no sense in these tests have none.
        """
        return self._scored(self._all_atoms(effects))

    def _all_atoms(self, effects: Iterable[Effect]) -> list[Atom]:
        atoms: list[Atom] = []
        own = {effect.name for effect in self.model.effects}
        for effect in effects:
            # What the model has already is not missing from it.
            if effect.name in own or effect.by_levels:
                continue
            try:
                with np.errstate(all="ignore"):
                    atoms += self._atoms(effect)
            except SpringpotError:
                # It has no law in time, or these tests lack a condition that it needs.
                continue
        return [atom for atom in atoms if np.all(np.isfinite(atom.column))]

    def _scored(self, atoms: Sequence[Atom]) -> dict[str, list[ScanEntry]]:
        if not atoms:
            return {}
        columns = np.column_stack([atom.column for atom in atoms])
        given = columns
        whole = np.linalg.norm(columns, axis=0)
        # Only what the model's own parameters cannot take over speaks for an effect.
        columns = self.tangent.left(columns)
        left = np.linalg.norm(columns, axis=0)
        # Nothing where the fit has come to rest; where it has not, what is left to its own
        # parameters is no effect's.
        missed = self.tangent.left(self.residual)
        fall, before = -columns.T @ missed, float(missed @ missed)
        entries: dict[str, list[ScanEntry]] = {}
        for k, atom in enumerate(atoms):
            if not left[k] > NEGLIGIBLE * whole[k]:
                continue
            # Least squares with one unknown; the sum of squares falls by amount times fall.
            amount = float(fall[k] / left[k] ** 2)
            drop = 0.0
            # Less than nothing of an effect makes no sense, however much it would help.
            if amount > 0.0 or atom.signed:
                drop = amount * float(fall[k])
            # The model makes way for the effect: its fit then begins where both together lead.
            theta = self._stepped(self.residual + amount * given[:, k])
            entry = ScanEntry(
                atom.effect,
                atom.at(amount),
                theta,
                drop,
                _as_tried(atom, amount),
                columns[:, k] / left[k],
                bool(atom.powers.any()),
                before - drop,
            )
            entries.setdefault(atom.effect.name, []).append(entry)
        return {name: _different(each) for name, each in entries.items()}

    def _stepped(self, residual: Real) -> Real:
        """The model's own parameters after the linear step that such a residual asks for."""
        return stepped(self.model, self.theta, -self.tangent.step(residual))

    def _atoms(self, effect: Effect) -> list[Atom]:
        if effect.of_test:
            return self._of_test(effect)
        if not effect.in_time:
            return self._of_network(effect)
        inside, _, signals = sorted_out(self.model + effect)
        if effect.name in {each.effect.name for each in inside}:
            return self._of_network(effect)
        return self._of_law(effect, effect.name in {each.effect.name for each in signals})

    # --- effects of the network ---

    def _of_network(self, effect: Effect) -> list[Atom]:
        size, *shape = effect.element.parameters
        # The size follows by least squares; what shapes the effect, such as a time, is no linear
        # thing and is tried.
        places = list(product(*(self.scales.values(each) for each in shape)))
        endless = np.isinf(effect.vanishes_at)
        little = self.scales.typical(size) * NEGLIGIBLE
        scale = 1.0
        if endless:
            little = self.scales.typical(size) * (1.0 / NEGLIGIBLE)
            # By 1/size, of which such an effect has next to nothing: d/d(1/s) = -s^2 d/ds.
            scale = -(little**2)
        values = np.array([[little, *place] for place in places])
        change = _Change(self.base, effect, values)
        # A specimen that swings answers a small mass by large ringing: no linear step leads there.
        swinging = [view for view in self.views if isinstance(view, View) and view.swings(change)]
        if swinging:
            return self._swinging(effect, places, swinging[0])
        whole = np.concatenate([view.of_change(change, scale) for view in self.views])
        if "temperature" in effect.needs and any(view.warms for view in self.views):
            whole = self._while_it_warms(effect, values / [NEGLIGIBLE, *np.ones(len(shape))])
        powers = np.array(
            [float(bool(parameter.unit.stiffness)) for parameter in effect.element.parameters]
        )
        powers[0] = 1.0
        if endless:
            powers = -powers
        start = values.copy()
        start[:, 0] = 1.0
        signed = size.lower < 0.0
        atoms = [
            Atom(effect, each, powers, column, signed)
            for each, column in zip(start, whole.T, strict=True)
        ]
        if effect.plane == "compliance":
            atoms += self._giving(effect, places)
        return atoms

    def _giving(self, effect: Effect, places: Sequence[tuple[float, ...]]) -> list[Atom]:
        """What gives way in series, at sizes to which no small step leads."""
        typical = self.scales.typical(effect.element.parameters[0])
        values = np.array([[typical * share, *place] for share in GIVING for place in places])
        change = _Change(self.base, effect, values)
        whole = np.concatenate([view.of_step(change) for view in self.views])
        still = np.zeros(values.shape[1])
        return [
            Atom(effect, each, still, column, False)
            for each, column in zip(values, whole.T, strict=True)
        ]

    def _swinging(
        self, effect: Effect, places: Sequence[tuple[float, ...]], view: View
    ) -> list[Atom]:
        """An effect at the sizes at which it balances the rest of what swings in a test."""
        # It rings at the frequency at which it balances the rest.
        omega = view.loudest
        at = points_at(omega, view.part.test.kelvin, self.base.reference)
        stiffness = np.abs(stiffness_of(self.base, at, view.part.test))
        atoms = []
        for place in places:
            next_to_nothing = np.array([[NEGLIGIBLE, *place]])
            change = _Change(self.base, effect, next_to_nothing)
            slope = change(at, view.part.test)[0]
            for size in stiffness / np.abs(slope):
                values = np.array([size, *place])
                column = self._as_it_is(effect, values)
                atoms.append(Atom(effect, values, np.zeros(len(values)), column, False))
        return atoms

    def _while_it_warms(self, effect: Effect, places: Real) -> Real:
        """Columns (n, g) of what follows a temperature that moves, sample by sample.

        No change of K at one temperature tells them.
        """
        # From a little, which is linear still and far above what an answer is off by, to twice as
        # much: without the effect the answer goes another way.
        slopes = []
        for size, *shape in places:
            some, more = (
                self._as_it_is(effect, np.array([share * size, *shape])) for share in (1e-3, 2e-3)
            )
            slopes.append((more - some) / (1e-3 * size))
        return np.column_stack(slopes)

    def _as_it_is(self, effect: Effect, values: Real) -> Real:
        """The change of all residuals for an effect of that size."""
        model, theta = _with_effect(self.base, effect, values)
        return np.concatenate([view.with_model(model, theta) for view in self.views])

    # --- effects with a law of their own ---

    def _of_law(self, effect: Effect, of_signal: bool) -> list[Atom]:
        """Forces beside the material, and what the measurement chain does to the force."""
        atoms = []
        grids = [self.scales.values(each) for each in effect.element.parameters]
        unit = np.array([float(each.unit.stiffness) for each in effect.element.parameters])
        if of_signal:
            grids[0] = [0.0]
            unit[0] = 1.0
        else:
            grids[0] = [self.scales.typical(effect.element.parameters[0])]
        # Of many parameters the last, which shape the least, are tried at one place.
        for i in reversed(range(len(grids))):
            if prod(map(len, grids)) > MOST:
                grids[i] = [self.scales.typical(effect.element.parameters[i])]
        signed = effect.element.parameters[0].lower < 0.0
        for place in product(*grids):
            values = np.array(place)
            column = np.concatenate([view.of_law(effect, values, of_signal) for view in self.views])
            start = np.where(values == 0.0, 1.0, values)
            atoms.append(Atom(effect, start, unit, column, signed))
        return atoms

    # --- effects of the test ---

    def _of_test(self, effect: Effect) -> list[Atom]:
        tests = [
            view.part.test
            for view in self.views
            if isinstance(view, View) and effect.applies_to(view.part.test)
        ]
        if not tests:
            return []
        atoms = []
        # An effect of the test is tried at several places: a stop that is not met has no slope to
        # follow.
        for place in tries_of(effect, tests[0], self.scales):
            values = np.array(place)
            if effect.composition == on_response:
                by_view = [view.of_record(effect, values) for view in self.views]
                column = np.concatenate([each for each, _ in by_view])
                linear = all(straight for _, straight in by_view)
            else:
                column = np.concatenate([view.of_course(effect, values) for view in self.views])
                linear = False
            powers = np.zeros(len(values))
            # A limit or a place is what it is, and what reached the specimen hardly goes with the
            # size of its cause: a ramp is another where samples lie within it. A clock nearly does.
            if linear or effect.composition == on_clock:
                powers[0] = 1.0
            atoms.append(
                Atom(
                    effect,
                    values,
                    powers,
                    column,
                    linear and effect.element.parameters[0].lower < 0.0,
                )
            )
        return atoms


def _with_effect(base: Identification, effect: Effect, values: Real) -> tuple[Model, Real]:
    """A fitted model with an effect, and its parameters.

    Those of the fit, and `values` (q,) of the effect.
    """
    model = base.model + effect
    known = base.model.named(base.theta)
    new = [name for name in model.names if name not in known]
    return model, model.vector(known | dict(zip(new, values.tolist(), strict=True)))


def _as_tried(atom: Atom, amount: float) -> float:
    """The amount of what goes by its size alone is always its own."""
    if atom.powers.any():
        return 1.0
    return abs(amount)


def _rating(entry: ScanEntry) -> tuple[float, float]:
    """The largest drop first, to three digits, and of those the one tried as it is wanted."""
    drop = float(f"{entry.drop:.3g}")
    return -drop, abs(float(np.log(max(entry.amount, SMALLEST))))


def _different(entries: list[ScanEntry]) -> list[ScanEntry]:
    """The best first, those behind that are another of the same rigs once more.

    Of what goes as its size they are left out: a fit from any of them is the same.
    """
    kept: list[ScanEntry] = []
    again: list[ScanEntry] = []
    for entry in sorted(entries, key=_rating):
        alike = [other.direction for other in kept if other.effect is entry.effect]
        if all(abs(float(entry.direction @ direction)) < PARALLEL for direction in alike):
            kept.append(entry)
        elif not entry.as_its_size:
            again.append(entry)
    return kept + again


def loudest(residual: Real, t: Real, edges: Real) -> Real:
    """Angular frequencies (b,) at which a residual (n,) has most power, in each of b bands.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        What is left of a record.
    t : ndarray, shape (n,)
        Times of its samples in s, evenly spaced or not.
    edges : ndarray, shape (b + 1,)
        Between which angular frequencies in rad/s the bands lie.

    Returns
    -------
    ndarray, shape (b,)
        One a band, in rad/s.

    Examples
    --------
    >>> t = np.linspace(0.0, 100.0, 400)
    >>> loudest(np.exp(-t / 50.0) * np.sin(3.1 * t), t, np.array([1.0, 2.0, 4.0]))[1].round(1)
    np.float64(3.1)
    """
    found = []
    for low, high in pairwise(edges.tolist()):
        # Two to a line's width; n samples tell no more than n numbers.
        count = min(int(2.0 * (high - low) * np.ptp(t) / np.pi) + 2, len(t))
        omega = np.linspace(low, high, count)
        power = np.abs(np.exp(-1j * np.multiply.outer(omega, t)) @ residual)
        found.append(omega[np.argmax(power)])
    return np.array(found)


class _Change:
    """dK by the size of an effect (g, n), for g places of its parameters, at any points."""

    def __init__(self, base: Identification, effect: Effect, values: Real) -> None:
        self.whole = base.model + effect
        self.theta = np.stack([_with_effect(base, effect, place)[1] for place in values])
        # Its size is the first of what it brings.
        known = set(base.model.names)
        self.size = next(i for i, name in enumerate(self.whole.names) if name not in known)

    def __call__(self, at: Points, test: Test) -> Complex:
        """The change of what a test in time shows."""
        network, places = shown_in(self.whole, test)
        if self.size not in places:
            return np.zeros((len(self.theta), len(at.log_omega)), dtype=np.complex128)
        return network.respond(self.theta[:, places], at, GRADIENT).by_theta[
            :, places.index(self.size), :
        ]

    def stiffness(self, at: Points, test: Test) -> Complex:
        """K with the effect (g, n), as a test in time shows it."""
        network, places = shown_in(self.whole, test)
        return network.respond(self.theta[:, places], at).value


def shown_in(model: Model, test: Test) -> tuple[Node, list[int]]:
    """The network whose K a test in time shows, and where its parameters stand in theta.

    A test in time follows K by exponentials: forces beside the material and what the chain does
    have no part in it.
    """
    own, places = model.had_by(test)
    network, inner = linear_network(own)
    return network, [places[i] for i in inner]


def stiffness_of(base: Identification, at: Points, test: Test) -> Complex:
    """K of a fitted model as a test shows it."""
    network, places = shown_in(base.model, test)
    return network.respond(base.theta[places], at).value


class View:
    """A test in time as the scan sees it.

    Some of its samples, and what fixed exponentials answer there.
    """

    def __init__(self, part: QuickPart, base: Identification) -> None:
        self.part, self.base, self.quick = part, base, part
        self.t, self.weight = self.quick.t, self.quick.weight
        # The exact answer once, for what is left; only the changes go by fixed exponentials.
        answer = part.answer(base.model, base.theta, base.reference, part.rows)
        seen = self.quick.seen
        # Of samples that are not counted too, as their neighbours' rates go by them; only at the
        # instant of a step it may be endless.
        self.value = np.where(np.isfinite(answer.value), answer.value, 0.0)
        self.residual = (
            np.where(seen, answer.value - part.test.response[self.quick.rows], 0.0) * self.weight
        )
        self.slopes = np.where(seen[:, None], answer.by_theta, 0.0) * self.weight[:, None]

    @property
    def warms(self) -> bool:
        """Whether its temperature moves."""
        return self.part.test.warmth is not None

    @cached_property
    def at(self) -> Points:
        """The frequencies of the exponentials, at its temperature."""
        return points_at(self.quick.omega, self.part.test.kelvin, self.base.reference)

    @cached_property
    def stiffness(self) -> Complex:
        """K at the frequencies of the exponentials."""
        return stiffness_of(self.base, self.at, self.part.test)

    @cached_property
    def amounts(self) -> Real:
        """The model itself as amounts of the exponentials (b,)."""
        answer = self.stiffness
        # To a force a specimen answers with a displacement, by its compliance.
        if self.part.test.control != "displacement":
            answer = 1.0 / answer
        return self.quick.followed(answer[None])[:, 0]

    @cached_property
    def followed(self) -> bool:
        """Whether the exponentials follow the model; one that swings under a force they do not."""
        return bool(np.all(np.isfinite(self.amounts)))

    @cached_property
    def loudest(self) -> Real:
        """Angular frequencies (b,) at one of which it rings, if it does.

        A ring of many cycles is met only near its own.
        """
        slow, fast = self.part.test.seen
        return loudest(self.residual, self.t, np.geomspace(slow, np.pi * fast, RESONANCES + 1))

    def swings(self, change: _Change) -> bool:
        """Whether a change of K is so steep that a specimen under a force would swing."""
        if self.part.test.control != "force":
            return False
        # The last two lie far beyond the test, where no material has a meaning; these are the
        # highest of its band.
        omega = self.quick.omega[[-4, -3]]
        at = points_at(omega, self.part.test.kelvin, self.base.reference)
        sizes = np.abs(change(at, self.part.test))
        steepness = np.log(sizes[:, 1] / sizes[:, 0]) / np.log(omega[1] / omega[0])
        return bool(np.any(steepness > STEEP))

    def of_change(self, change: _Change, scale: float) -> Real:
        """Columns (n, g) for a change of K."""
        if not self.followed:
            slopes = [self._exact(change.whole, theta).by_theta for theta in change.theta]
            return np.column_stack([each[:, change.size] for each in slopes]) * scale
        by_size = change(self.at, self.part.test) * scale
        if self.part.test.control == "force":
            by_size = -by_size / self.stiffness**2
        return (self.quick.answers @ self.quick.followed(by_size)) * self.weight[:, None]

    def of_step(self, change: _Change) -> Real:
        """Columns (n, g) for a K that is another altogether."""
        if not self.followed:
            return np.column_stack([self.with_model(change.whole, each) for each in change.theta])
        before, after = self.stiffness, change.stiffness(self.at, self.part.test)
        if self.part.test.control == "force":
            before, after = 1.0 / before, 1.0 / after
        return (self.quick.answers @ self.quick.followed(after - before)) * self.weight[:, None]

    def of_course(self, effect: Effect, values: Real) -> Real:
        """The change of the residuals when the specimen's loading or its clock is another."""
        test = self.part.test
        if not effect.applies_to(test):
            return np.zeros(len(self.t))
        if not self.followed:
            return self.with_model(*_with_effect(self.base, effect, values))
        place = [Placed(effect, "", list(range(len(values))))]
        if at_loading(place):
            loading, _ = reached(place, values, test, self.t)
            time = self.t
        else:
            clock = Clock(place, values, test.start)
            loading, time = clock.turned(test.loading, self.t), clock.at(self.t)
        answer = self.quick.answers_to(loading, time, self.amounts[:, None])[:, 0]
        return (answer - self.quick.answers @ self.amounts) * self.weight

    def with_model(self, model: Model, theta: Real) -> Real:
        """The change of the residuals with another model."""
        answer = recorded(model, theta, self.part.test, self.base.reference, self.t, NEGLIGIBLE)
        # At the instant of a step, of weight nothing, the answer may be endless: their product
        # would be no number.
        return np.where(self.weight > 0.0, answer.value - self.value, 0.0) * self.weight

    def _exact(self, model: Model, theta: Real) -> Residual:
        """The residuals (n,) of another model, exactly, and their slopes (n, p)."""
        answer = recorded(model, theta, self.part.test, self.base.reference, self.t, NEGLIGIBLE)
        counts = self.weight > 0.0
        missed = np.where(counts, answer.value - self.part.test.response[self.part.rows], 0.0)
        slopes = np.where(counts[:, None], answer.by_theta, 0.0)
        return Residual(missed * self.weight, slopes * self.weight[:, None])

    def of_law(self, effect: Effect, values: Real, of_signal: bool) -> Real:
        """The column of a force beside the material, or the slope of what the chain does to it."""
        test = self.part.test
        if not effect.applies_to(test):
            return np.zeros(len(self.t))
        if not of_signal and is_eased(test):
            return self.of_course(effect, values)
        name = {"displacement": "in_time", "force": "under_force"}[test.control]
        law = getattr(effect.element, name, None)
        if len(test.loading.jumps[0]) or law is None:
            raise SpringpotError(f"{effect.name} has no law here")
        if of_signal:
            return self._of_signal(law, values) * self.weight
        return self.quick.force_of(effect, values) * self.weight

    def _of_signal(self, law: Callable[..., Law], values: Real) -> Real:
        t, value = self.t, self.value
        more = int(self.part.test.loading.before > 0)
        if more:
            # What had gone on before was no rest: one sample before the record as it went then.
            t, value = (np.append(2.0 * each[0] - each[1], each) for each in (t, value))
        return np.asarray(law(t, value[:, None], *values)[1][0][more:])

    def of_record(self, effect: Effect, values: Real) -> tuple[Real, bool]:
        """An effect's column at the stage of the record, and whether it goes as its size."""
        if not effect.applies_to(self.part.test):
            return np.zeros(len(self.t)), True
        value, slopes, _ = acting(effect.element, values, self.quick.record, self.value)
        change = value - self.value
        # What is proportional to its size needs one try: the size then follows by least squares.
        straight = np.allclose(change, values[0] * slopes[0], rtol=1e-6)
        return change * self.weight, straight


class ExactView:
    """A test of which the answer of a model is a formula, as at frequencies."""

    warms = False
    """It has one temperature for each row."""

    def __init__(self, part: TestPart, base: Identification) -> None:
        self.part, self.base = part, base
        self.residual, self.slopes = part.residual(base.model, base.theta, base.reference)

    def of_change(self, change: _Change, scale: float) -> Real:
        """Columns (m, g) for a change of K: the exact slope by the size of the effect."""
        slopes = [self._residual(change.whole, theta).by_theta for theta in change.theta]
        return scale * np.column_stack([each[:, change.size] for each in slopes])

    def of_step(self, change: _Change) -> Real:
        """Columns (m, g) for a K that is another altogether."""
        return np.column_stack([self.with_model(change.whole, theta) for theta in change.theta])

    def of_course(self, effect: Effect, values: Real) -> Real:
        """Nothing."""
        return np.zeros(len(self.residual))

    def with_model(self, model: Model, theta: Real) -> Real:
        """The change of the residuals with another model."""
        return self._residual(model, theta).value - self.residual

    def _residual(self, model: Model, theta: Real) -> Residual:
        return self.part.residual(model, theta, self.base.reference)

    def of_law(self, effect: Effect, values: Real, of_signal: bool) -> Real:
        """The column of an effect that is not linear: its first harmonic."""
        return self.with_model(*_with_effect(self.base, effect, values))

    def of_record(self, effect: Effect, values: Real) -> tuple[Real, bool]:
        """Nothing: what a test in time did is in no other."""
        return np.zeros(len(self.residual)), True
