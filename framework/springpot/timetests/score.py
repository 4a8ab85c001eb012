"""The linearised scan: how far each effect would let the error fall, before any is fitted.

Each effect joins the model at a few places of its parameters, and every test says what that
changes in it: how it goes by a size of next to nothing, or, of what is not small, such as a stop
that is met or not, the change as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise, product
from math import prod

import numpy as np

from springpot.diagnosis.scan import PARALLEL
from springpot.errors import SpringpotError
from springpot.identification.result import Identification
from springpot.measurement.timetest import TimeTest
from springpot.misfit.frame import able_to_follow
from springpot.misfit.residuals_of_tests import Residual, TestPart
from springpot.rheology.effect import Effect, on_clock, on_response
from springpot.rheology.model import Model, linear_network, sorted_out
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Real

from ..numerics import NEGLIGIBLE, SMALLEST, Tangent
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
        self.views = [View(part, base) for part in parts]
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
        # A mode too fast for the tests is a dashpot, and its two parameters together make a mass of
        # less than nothing, if they are moved by a million times themselves: that is no step.
        self.tangent = Tangent.of(np.where(free, slopes, 0.0), NEGLIGIBLE)

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
        typical, signed = self.scales.typical(size), size.lower < 0.0
        little, scale = typical * NEGLIGIBLE, 1.0
        powers = np.array([1.0, *(float(bool(each.unit.stiffness)) for each in shape)])
        if np.isinf(effect.vanishes_at):
            little, powers = typical * (1.0 / NEGLIGIBLE), -powers
            # By 1/size, of which such an effect has next to nothing: d/d(1/s) = -s^2 d/ds.
            scale = -(little**2)
        # The size follows by least squares; what shapes the effect, such as a time, is no linear
        # thing and is tried.
        places = self._places(effect, [little])
        # A specimen that swings answers a small mass by large ringing: no linear step leads there.
        for view in self.views:
            if view.swings(effect, places):
                return self._as_they_are(effect, view.ringing(effect, places), exactly=True)
        atoms = []
        for place, (_, slope) in self._grown(effect, places):
            start = np.array([1.0, *place[1:]])
            atoms.append(Atom(effect, start, powers, scale * slope, signed))
        if effect.plane == "compliance":
            # What gives way in series, at sizes to which no small step leads.
            giving = self._places(effect, [typical * share for share in GIVING])
            atoms += self._as_they_are(effect, giving)
        return atoms

    def _places(self, effect: Effect, sizes: list[float]) -> list[tuple[float, ...]]:
        """Places of an effect's parameters: some sizes, and what is worth trying of the others."""
        _, *shape = effect.element.parameters
        grids = [sizes, *(self.scales.values(each) for each in shape)]
        # Of many parameters the last, which shape the least, are tried at one place.
        for i in reversed(range(1, len(grids))):
            if prod(map(len, grids)) > MOST:
                grids[i] = [self.scales.typical(shape[i - 1])]
        return list(product(*grids))

    def _as_they_are(
        self, effect: Effect, places: Iterable[Sequence[float]], exactly: bool = False
    ) -> list[Atom]:
        """An effect at places of its parameters (q,) where no small step tells what it changes."""
        return [
            Atom(effect, np.array(place), np.zeros(len(place)), value, False)
            for place, (value, _) in self._grown(effect, list(places), exactly=exactly)
        ]

    def _grown(
        self,
        effect: Effect,
        places: Sequence[Sequence[float]],
        by_size: bool = True,
        exactly: bool = False,
    ) -> Iterator[tuple[Sequence[float], Residual]]:
        """At each place what an effect changes in all tests (n,), and how by its size (n,).

        That is asked for only `by_size`, as of a clock it takes as long as the change itself.
        """
        if not places:
            return
        model, theta, size = _with_effect(self.base, effect, places)
        by = [size] if by_size else []
        told = [view.changed(effect, model, theta, by, exactly) for view in self.views]
        for place, *each in zip(places, *told, strict=True):
            value = np.concatenate([one.value for one in each])
            slope = np.concatenate([one.by_theta[:, size] for one in each])
            # Where exponentials do not follow how it goes by a size, it is not followed there
            # itself.
            yield place, Residual(np.where(np.isfinite(slope), value, np.nan), slope)

    # --- effects with a law of their own ---

    def _of_law(self, effect: Effect, of_signal: bool) -> list[Atom]:
        """Forces beside the material, and what the measurement chain does to the force."""
        first, *_ = effect.element.parameters
        unit = np.array([float(each.unit.stiffness) for each in effect.element.parameters])
        little = self.scales.typical(first)
        if of_signal:
            little, unit[0] = 0.0, 1.0
        atoms = []
        for place, (column, slope) in self._grown(effect, self._places(effect, [little])):
            if of_signal:
                column, place = slope, (1.0, *place[1:])
            atoms.append(Atom(effect, np.array(place), unit, column, first.lower < 0.0))
        return atoms

    # --- effects of the test ---

    def _of_test(self, effect: Effect) -> list[Atom]:
        asked = [view.quick.test for view in self.views if view.quick is not None]
        test = next((each for each in asked if effect.applies_to(each)), None)
        if test is None:
            return []
        atoms, first = [], effect.element.parameters[0]
        # An effect of the test is tried at several places: a stop that is not met has no slope to
        # follow.
        places, of_record = tries_of(effect, test, self.scales), effect.composition == on_response
        for place, (column, slope) in self._grown(effect, places, by_size=of_record):
            # What is proportional to its size needs one try: the size then follows by least
            # squares.
            linear = of_record and np.allclose(column, place[0] * slope, rtol=1e-6)
            powers = np.zeros(len(place))
            # A limit or a place is what it is, and what reached the specimen hardly goes with the
            # size of its cause: a ramp is another where samples lie within it. A clock nearly does.
            if linear or effect.composition == on_clock:
                powers[0] = 1.0
            signed = linear and first.lower < 0.0
            atoms.append(Atom(effect, np.array(place), powers, column, signed))
        return atoms


@lru_cache(maxsize=256)
def _joined(model: Model, effect: Effect) -> Model:
    """One model for all places of an effect: what it is taken apart into is worked out once."""
    return model + effect


def _with_effect(
    base: Identification, effect: Effect, places: Sequence[Sequence[float]]
) -> tuple[Model, Real, int]:
    """A fitted model with an effect, its parameters (g, p), and which of them is the effect's size.

    They are those of the fit, and at each of g places (q,) those of the effect.
    """
    model = _joined(base.model, effect)
    known = base.model.named(base.theta)
    # The size is the first of what it brings.
    new = [name for name in model.names if name not in known]
    theta = np.tile(model.vector(known | dict.fromkeys(new, 0.0)), (len(places), 1))
    theta[:, [model.names.index(name) for name in new]] = places
    return model, theta, model.names.index(new[0])


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


class View:
    """A test as the scan sees it: what the model leaves of it, and what another changes there.

    What is left is exact; a change goes by fixed exponentials where these follow it.
    """

    def __init__(self, part: TestPart, base: Identification) -> None:
        self.part, self.base = part, base
        self.quick = part if isinstance(part, QuickPart) else None
        self.residual, self.slopes = self._exactly(base.model, base.theta)

    def _exactly(self, model: Model, theta: Real) -> Residual:
        exact = self.part.residual if self.quick is None else self.quick.exactly
        return exact(model, theta, self.base.reference)

    @cached_property
    def _before(self) -> Residual:
        """What is left of the model by exponentials; exactly where they do not follow it."""
        if self.quick is None:
            return Residual(self.residual, self.slopes)
        [nearly] = self.quick.nearly(
            self.base.model, self.base.theta[None], self.base.reference, []
        )
        if np.all(np.isfinite(nearly.value)):
            return nearly
        return Residual(self.residual, self.slopes)

    def changed(
        self, effect: Effect, model: Model, theta: Real, by: Sequence[int], exactly: bool
    ) -> Iterator[Residual]:
        """What the model with an effect changes here (n,) at each theta (g, p), and slopes (n, p).

        Of these those `by` some parameters are always told.
        """
        count, quick = len(self.residual), self.quick
        if not effect.applies_to(self.part.test):
            nothing = Residual(np.zeros(count), np.zeros((count, theta.shape[1])))
            yield from [nothing] * len(theta)
            return
        # A temperature that moves is followed sample by sample.
        warms = (
            quick is not None and quick.test.warmth is not None and "temperature" in effect.needs
        )
        if quick is None or exactly or warms or self._before.value is self.residual:
            for each in theta:
                value, slopes = self._exactly(model, each)
                yield Residual(value - self.residual, slopes)
            return
        for value, slopes in quick.nearly(model, theta, self.base.reference, by):
            yield Residual(value - self._before.value, slopes)

    def swings(self, effect: Effect, places: Sequence[Sequence[float]]) -> bool:
        """Whether a change of K is so steep somewhere that a specimen under a force would swing."""
        if self.quick is None or self.quick.test.control != "force":
            return False
        if not effect.applies_to(self.quick.test):
            return False
        # The last two lie far beyond the test, where no material has a meaning; these are the
        # highest of its band.
        omega = self.quick.omega[[-4, -3]]
        _, slope = _stiffness(self.base, effect, places, self.quick.test, omega)
        steepness = np.diff(np.log(np.abs(slope))) / np.diff(np.log(omega))
        return bool(np.any(steepness > STEEP))

    def ringing(
        self, effect: Effect, places: Sequence[tuple[float, ...]]
    ) -> Iterator[Sequence[float]]:
        """An effect at the sizes at which it balances the rest of what swings in a test."""
        assert self.quick is not None
        # It rings at the frequency at which it balances the rest; a ring of many cycles is met only
        # near its own.
        slow, fast = self.quick.test.seen
        bands = np.geomspace(slow, np.pi * fast, RESONANCES + 1)
        omega = loudest(self.residual, self.quick.t, bands)
        little = [(NEGLIGIBLE, *place[1:]) for place in places]
        value, slope = _stiffness(self.base, effect, little, self.quick.test, omega)
        for place, sizes in zip(places, np.abs(value / slope).tolist(), strict=True):
            for size in sizes:
                yield size, *place[1:]


def _stiffness(
    base: Identification,
    effect: Effect,
    places: Sequence[Sequence[float]],
    test: TimeTest,
    omega: Real,
) -> tuple[Complex, Complex]:
    """K (g, w) of the network with an effect at g places, and dK by its size."""
    model, theta, size = _with_effect(base, effect, places)
    own, there = model.had_by(test)
    network, inner = linear_network(own)
    within = [there[i] for i in inner]
    at = points_at(omega, test.kelvin, base.reference)
    told = network.respond(theta[:, within], at, GRADIENT)
    return told.value, told.by_theta[:, within.index(size)]
