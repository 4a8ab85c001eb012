"""A model: a named network with effects that gives K, its spectrum, and what happens in time.

In time it is its material, what beside it is not linear, and what the signals went through.
Families of models differ in one whole number, such as ``prony-N``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from springpot.errors import ModelError
from springpot.writing import tag

from ..numerics import ALIKE
from .drawing import drawing_of
from .effect import Layer
from .intime import Passive, Traced
from .motion import Between, velocity
from .named import NamedNetwork, Placed
from .nodes import GRADIENT, Chain, Node, Parallel, Series, Shift
from .nonlinear import Law
from .points import ROOM, Points, Real
from .spectrum import Spectrum, blaming, conditions_at, spectrum_of

STEP = 1e-30
"""Of a derivative by complex step, free of rounding (Squire & Trapp 1998,
10.1137/S003614459631241X).
"""


@dataclass(frozen=True, eq=False)
class InTime:
    """A model with its parameters, ready to be asked for what happens in time; see `Model.in_time`.

    Parameters
    ----------
    model : NamedNetwork
        Any `Model` whose parts have a meaning in time.
    theta : ndarray, shape (p,)
        Its parameters.
    reference_temperature : float
        In kelvin.
    temperature : float or ndarray, shape (n,), optional
        In kelvin, one for all times or one for each sample of a history.
    tolerance : float
        Relative error of K for which the spectrum is read.
    eased : bool
        Whether the forces that are not linear were taken off the imposed force before.

    Examples
    --------
    >>> from springpot.rheology import Model, dashpot, series, spring
    >>> maxwell = Model("maxwell", series(spring(), dashpot()))
    >>> value, by_theta = maxwell.in_time([2.0, 8.0]).relaxation([4.0])
    >>> value.round(3), by_theta.round(3)
    (array([0.736]), array([[0.   , 0.092]]))
    """

    model: NamedNetwork
    theta: Real
    temperature: float | Real | None
    reference_temperature: float
    tolerance: float
    eased: bool = False

    def relaxation(self, t: Real) -> Traced:
        """Force over displacement (n,) at t >= 0 after a displacement step, and its derivatives."""
        with self._blaming():
            passive, own = self._linear("relaxation")
            return self._padded(passive.relaxation(_after_step(t)), own)

    def creep(self, t: Real) -> Traced:
        """Displacement over force (n,) at t >= 0 after a force step, and its derivatives."""
        with self._blaming():
            passive, own = self._linear("creep")
            return self._padded(passive.creep(_after_step(t)), own)

    def respond_force(self, t: Real, force: Real, motion: Between | None = None) -> Traced:
        """Displacement (n,) under a force, and its derivatives."""
        t, force = _history(t, force, "force")
        with self._blaming():
            if isinstance(self.temperature, np.ndarray):
                return self._reduced(self._only_material(), t, force, motion, "force")
            passive, own = self._linear("the answer to a force", chain=True)
            traced = self._padded(passive.respond_force(t, force, motion=motion), own)
        return through(traced, sorted_out(self.model)[2], self.theta, t, "under_force")

    def _only_material(self) -> Sequence[Placed]:
        """The effects, where all of them are linear and go by the clock of the material.

        Raises
        ------
        ModelError
            If one stands beside it, or belongs to the signals.
        """
        inside, beside, signals = sorted_out(self.model)
        # What joined after the last shift goes by seconds: under a force both clocks would have to
        # be followed at once.
        last = max(
            (i for i, each in enumerate(inside) if each.effect.composition.kind is Shift),
            default=-1,
        )
        for effect, _, _ in [*inside[last + 1 :], *beside, *signals]:
            raise ModelError(
                f"'{effect.name}' is not followed under a force while the temperature moves:"
                " leave it out"
            )
        return inside

    def respond(self, t: Real, displacement: Real, motion: Between | None = None) -> Traced:
        """Force (n,) for a displacement, and its derivatives.

        Straight between samples, or as a `motion` with these knots has it.
        """
        t, x = _history(t, displacement, "displacement")
        inside, beside, signals = sorted_out(self.model)
        with self._blaming():
            traced = self._materials(inside, t, x, motion)
        return with_laws(traced, beside, signals, self.theta, t, forces_along(t, x))

    def by_clock(self, t: Real, imposed: Real, control: str, moves: Real) -> Real:
        """How the answer changes where the material's clock does.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Time by that clock, rising.
        imposed : ndarray, shape (n,)
            Displacement or force at each.
        control : {"displacement", "force"}
            Which of the two.
        moves : ndarray, shape (n, q)
            By how much each of q changes moves the clock at each sample.

        Returns
        -------
        ndarray, shape (n, q)
            Derivatives of the force or displacement, by complex steps.

        Raises
        ------
        ModelError
            If something in the model has no clock of the material: see `on_its_clock`.
        """
        with self._blaming():
            # A step this small leaves the answer itself untouched: only its imaginary part tells of
            # it.
            respond = _answer(self.on_its_clock(), control)
            columns = []
            for move in moves.T:
                moved = respond(t + 1j * STEP * move, imposed, slopes=False)
                columns.append(moved.value.imag / STEP)
        return np.column_stack(columns)

    def step_rate(self, t: Real, control: str) -> Real:
        """Derivative (n,) of `relaxation` or `creep` by the time t > 0."""
        with self._blaming():
            passive = self.on_its_clock()
            if control == "displacement":
                return passive.relaxation_rate(t)
            return passive.creep_rate(t)

    @property
    def linear(self) -> bool:
        """Whether twice the displacement has twice the force."""
        return self.eased or not sorted_out(self.model)[1]

    def on_its_clock(self) -> Passive:
        """The material alone, which may have a clock of its own.

        Raises
        ------
        ModelError
            If there is a mass, or an effect that is not linear or of the signals: these go by the
            clock on the wall.
        """
        passive, _ = self._linear("a clock of the material")
        # A force on a mass goes by seconds, however fast the material relaxes.
        if passive.inertial:
            raise ModelError(
                f"{self.model.name} has a mass, which does not go by the clock of its material"
            )
        return passive

    def _blaming(self) -> AbstractContextManager[None]:
        temperature = self.temperature
        # A history has no one temperature to look at: that of reference stands for it.
        if isinstance(temperature, np.ndarray):
            temperature = None
        return blaming(
            self.model, self.theta, conditions_at(temperature, self.reference_temperature)
        )

    def _linear(self, what: str, chain: bool = False) -> tuple[Passive, list[int]]:
        """The network in time, and where its parameters stand in theta.

        What the `chain` of the measurement does may be left to `through`.
        """
        _, beside, signals = sorted_out(self.model)
        if chain:
            signals = ()
        if self.eased:
            beside = ()
        # The first that stands in the way is named: one thing to mend at a time.
        for effect, _, _ in [*beside, *signals]:
            kind = "belongs to the signals"
            if beside:
                kind = "is not linear"
            raise ModelError(
                f"{what} has no meaning with '{effect.name}', which {kind}: ask for respond"
            )
        if isinstance(self.temperature, np.ndarray):
            raise ModelError(
                f"{what} is for one temperature: ask for respond with a history of temperatures"
            )
        return self._inside

    @cached_property
    def _inside(self) -> tuple[Passive, list[int]]:
        # Kept, as it is asked several things at one theta: each would take it apart anew.
        network, own = linear_network(self.model)
        return replace(self._passive(network), theta=self.theta[own]), own

    def _passive(self, network: Node, temperature: float | None = None) -> Passive:
        if not isinstance(self.temperature, np.ndarray):
            temperature = self.temperature
        return Passive(
            network,
            self.theta,
            conditions_at(temperature, self.reference_temperature),
            self.tolerance,
        )

    def _materials(
        self, inside: Sequence[Placed], t: Real, x: Real, motion: Between | None
    ) -> Traced:
        if isinstance(self.temperature, np.ndarray):
            return self._reduced(inside, t, x, motion)
        passive, own = self._inside
        return self._padded(passive.respond(t, x, motion=motion), own)

    def _by_its_clock(
        self,
        passive: Passive,
        own: list[int],
        time: Any,
        x: Real,
        motion: Between | None,
        control: str,
        slopes: bool = True,
    ) -> Traced:
        """What answers where its clock shows these times (n,) at the knots of the motion."""
        if motion is not None:
            motion = motion.by_clock(time)
        answer = _answer(replace(passive, theta=self.theta[own]), control)
        traced = answer(time, x, slopes=slopes, motion=motion)
        return self._padded(traced, own) if slopes else traced

    def _padded(self, traced: Traced, own: list[int]) -> Traced:
        # A part knows its own parameters only: their derivatives go back to where they stand in the
        # whole theta.
        by_theta = np.zeros((len(traced.value), len(self.theta)), dtype=traced.by_theta.dtype)
        by_theta[:, own] = traced.by_theta
        return Traced(traced.value, by_theta)

    def _reduced(
        self,
        inside: Sequence[Placed],
        t: Real,
        x: Real,
        motion: Between | None,
        control: str = "displacement",
    ) -> Traced:
        """What temperature moves, in reduced time (seconds / a_T), and what is beside it, in s."""
        shifts = [
            place for place, each in enumerate(inside) if each.effect.composition.kind is Shift
        ]
        # What joined before the last shift goes by the clock of the material, what joined later by
        # that of the test.
        last = shifts[-1] + 1 if shifts else 0
        _refuse_unfollowed(inside, last)
        temperature = np.asarray(self.temperature, dtype=float)
        if temperature.shape != t.shape or not np.all(temperature > 0.0):
            raise ModelError(
                f"a history of {len(t)} samples needs as many temperatures in kelvin,"
                " all above zero"
            )
        network, own = network_of(self.model, inside[:last])
        # A shift factor depends on the temperature alone: any frequency will do.
        at = Points(np.zeros(len(t)), None, temperature, self.reference_temperature)
        moving = [inside[place] for place in shifts]
        laws = [
            (each.own, each.effect.element.respond(self.theta[each.own], at, GRADIENT))
            for each in moving
        ]
        # Factors of several shifts multiply.
        log_shift = sum((law.value.real for _, law in laws), np.zeros(len(t)))
        # Where the shifts are one: what they do is all in the reduced time.
        passive = self._passive(network, self.reference_temperature)
        if control == "force" and replace(passive, theta=self.theta[own]).inertial:
            raise ModelError(
                f"{self.model.name} has a mass, which does not go by the clock of its material"
            )
        traced = self._by_its_clock(passive, own, _reduced_time(t, log_shift), x, motion, control)
        for own_law, law in laws:
            for i, slope in zip(own_law, law.by_theta.real, strict=True):
                # A complex step: exact to rounding, as nothing is subtracted.
                turned = _reduced_time(t, log_shift + 1j * STEP * slope)
                moved = self._by_its_clock(passive, own, turned, x, motion, control, slopes=False)
                traced.by_theta[:, i] = moved.value.imag / STEP
        for effect, _, places in inside[last:]:
            passive = self._passive(effect.element, self.reference_temperature)
            outer = self._by_its_clock(passive, places, t, x, motion, "displacement")
            traced = Traced(traced.value + outer.value, traced.by_theta + outer.by_theta)
        return traced


def _refuse_unfollowed(inside: Sequence[Placed], last: int) -> None:
    """Tell of an effect that a history of temperatures cannot be followed by, or inside.

    `last` is the number of effects up to the last shift.
    """
    for effect, _, _ in inside:
        if "temperature" in effect.needs and effect.composition.kind is not Shift:
            raise ModelError(
                f"a history of temperatures is not followed by '{effect.name}': only shifts are"
            )
    for effect, _, _ in inside[last:]:
        if effect.composition.kind is not Parallel:
            raise ModelError(
                f"a history of temperatures is not followed inside '{effect.name}': leave it out"
            )


def _answer(passive: Passive, control: str) -> Callable[..., Traced]:
    """What answers when the displacement, or the force, is imposed."""
    if control == "displacement":
        return passive.respond
    return passive.respond_force


def forces_along(t: Real, x: Real) -> Callable[[Node, tuple[float, ...]], Law]:
    """The force (n,) of any law beside the material, and its slopes, at its parameters.

    Parameters
    ----------
    t, x : ndarray, shape (n,)
        Times in s and displacements.
    """
    # Laws that are not linear need the speed, which a record does not have.
    moving = velocity(t, x)
    return lambda law, values: law.in_time(t, x, moving, *values)  # type: ignore[attr-defined]


def with_laws(
    traced: Traced,
    beside: Sequence[Placed],
    signals: Sequence[Placed],
    theta: Real,
    t: Real,
    force_of: Callable[[Node, tuple[float, ...]], Law],
) -> Traced:
    """The force (n,) of a material with the forces beside it, as the measurement chain shows it.

    Parameters
    ----------
    traced : Traced
        Force of the material for the displacement, and its derivatives, which are changed.
    beside, signals : sequence of Placed
        Effects that are not linear, and those of the measurement chain; see `sorted_out`.
    theta : ndarray, shape (p,)
        Parameters of the whole model.
    t : ndarray, shape (n,)
        Times in s.
    force_of : callable
        See `forces_along`.
    """
    value, by_theta = traced
    for effect, _, own in beside:
        force, slopes = force_of(effect.element, tuple(theta[own].tolist()))
        value = value + force
        by_theta[:, own] += np.stack(np.broadcast_arrays(*slopes), axis=-1)
    return through(Traced(value, by_theta), signals, theta, t, "in_time")


def through(traced: Traced, signals: Sequence[Placed], theta: Real, t: Real, law: str) -> Traced:
    """What the measurement chain records of an answer, by such a law of each of its effects."""
    # One table, as what the signals go through acts on the answer and on each of its derivatives
    # alike.
    columns = np.column_stack(traced)
    for effect, _, own in signals:
        respond = getattr(effect.element, law, None)
        if respond is None:
            raise ModelError(
                f"the answer to a force has no meaning with '{effect.name}', which belongs to the"
                " signals: ask for respond"
            )
        columns, slopes = respond(t, columns, *theta[own])
        columns[:, [1 + i for i in own]] += np.stack(slopes, axis=-1)
    return Traced(columns[:, 0], columns[:, 1:])


@lru_cache(maxsize=256)
def sorted_out(
    model: NamedNetwork,
) -> tuple[tuple[Placed, ...], tuple[Placed, ...], tuple[Placed, ...]]:
    """The effects from the material outwards.

    Linear ones, those that are not but stand beside, those of signals.

    Those of sweeps alone are in none of them, nor is what a test did: see `at_stage`.

    Raises
    ------
    ModelError
        If an effect has no meaning in time, or stands where its force cannot be told alone.

    Examples
    --------
    >>> import springpot
    >>> from springpot.rheology.model import sorted_out
    >>> groups = sorted_out(springpot.parse_model("kelvin + friction + inertia + gain-error"))
    >>> [[placed.effect.name for placed in group] for group in groups]
    [['inertia'], ['friction'], ['gain-error']]
    """
    inside: list[Placed] = []
    beside: list[Placed] = []
    signals: list[Placed] = []
    for placed in model.placed:
        effect = placed.effect
        if effect.of_test or not effect.in_time:
            continue
        law = getattr(effect.element, "in_time", None)
        linear = effect.layer is not Layer.SIGNAL and "amplitude" not in effect.needs
        if linear and effect.composition.kind in (Parallel, Series, Shift, Chain):
            # Around a nonlinear effect a linear one would share its displacement: no force follows
            # from x alone.
            if beside and effect.composition.kind is not Parallel:
                inner = beside[0].effect.name
                raise ModelError(
                    f"the force of '{inner}' cannot be told alone inside '{effect.name}':"
                    " leave one out"
                )
            inside.append(placed)
        elif law is None:
            raise ModelError(
                f"{model.name} cannot be followed in time: '{effect.name}' has no law there;"
                " leave it out"
            )
        elif effect.layer is Layer.SIGNAL:
            signals.append(placed)
        else:
            beside.append(placed)
    return tuple(inside), tuple(beside), tuple(signals)


@lru_cache(maxsize=256)
def linear_network(model: NamedNetwork) -> tuple[Node, list[int]]:
    """The network of a model with its linear effects only, in time.

    And where its parameters stand in the model's theta.

    Examples
    --------
    >>> import springpot
    >>> from springpot.rheology.model import linear_network
    >>> model = springpot.parse_model("kelvin + friction + inertia")
    >>> network, places = linear_network(model)
    >>> [model.names[place] for place in places]
    ['k', 'c', 'inertia.m']
    """
    return network_of(model, sorted_out(model)[0])


def network_of(model: NamedNetwork, inside: Sequence[Placed]) -> tuple[Node, list[int]]:
    """The same with some of its effects."""
    network, own = model.material, list(range(len(model.material.parameters)))
    for effect, prefix, places in inside:
        network = effect.composition(network, effect.element.with_prefix(prefix))
        own += places
    return network, own


def _reduced_time(t: Real, log_shift: Any) -> Any:
    """Integral of dt / a_T, ln a_T being linear between samples."""
    from .terms import mean_of_exponential

    # In closed form: the trapezoidal rule errs where a_T changes by decades within a step.
    pace = mean_of_exponential(-log_shift[:-1], -log_shift[1:])
    return np.concatenate([[0.0], np.cumsum(np.diff(t) * pace)])


def _after_step(t: Real) -> Real:
    # One time alone is as good as a list of one.
    t = np.atleast_1d(np.asarray(t, dtype=float))
    if t.ndim != 1 or not np.all(np.isfinite(t)):
        raise ModelError("times are a list of numbers in seconds")
    if np.any(t < 0.0):
        raise ModelError(f"the step is at t = 0: there is nothing before, at t = {t.min():g} s")
    return t


def _history(t: Real, values: Real, name: str) -> tuple[Real, Real]:
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or t.shape != values.shape or len(t) < 2:
        raise ModelError(
            f"a history is two lists of the same length, times and {name}, of two samples or more"
        )
    for what, numbers in (("time", t), (name, values)):
        bad = np.flatnonzero(~np.isfinite(numbers))
        if len(bad):
            raise ModelError(
                f"the {what} of sample {bad[0] + 1} is no number: leave that sample out"
            )
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        raise ModelError(
            f"the time does not rise after sample {back[0] + 1} (t = {t[back[0]]:g} s):"
            " sort the samples"
        )
    return t, values


# It shows itself as the network below does, which is shorter than all its fields.
@dataclass(frozen=True, eq=False, repr=False)
class Model(NamedNetwork):
    """A rheological model, possibly grown by effects.

    Parameters
    ----------
    base : str
        Canonical name of the model without effects.
    material : Node
        Its network of elements.
    summary : str
        One sentence on what it describes.
    citation : str
        Source of the equation (DOI where there is one).
    aliases : tuple of str
        Names that other tools use.
    search : SearchForm or None
        The published search parameters, where they differ from the elements'.
    effects : tuple of Effect
        Effects that joined, in the order in which they were added.
    drawing : str
        The network as text, where it is not drawn from the network itself.

    Examples
    --------
    >>> from springpot.rheology import Model, dashpot, parallel, spring
    >>> model = Model("kelvin", parallel(spring(), dashpot()))
    >>> model.stiffness(model.theta(k=2.0, c=0.5), [4.0]).round(6)
    array([2.+2.j])
    """

    def _repr_html_(self) -> str:
        drawn = tag("pre", drawing_of(self), style="line-height: 1.2")
        source = self.summary
        if self.citation:
            source += f" ({self.citation})"
        return tag(
            "div",
            tag("p", tag("b", self.name)),
            drawn,
            tag("p", f"{', '.join(self.names)}: {source}"),
        )

    def spectrum(
        self,
        theta: Real,
        band: tuple[float, float] | None = None,
        *,
        tolerance: float = 1e-6,
        temperature: float | None = None,
        reference_temperature: float = ROOM,
    ) -> Spectrum:
        """The relaxation spectrum.

        K(s) = K_e + c s + m s^2 + sum of w s / (s + r), w >= 0, from the network itself.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        band : (float, float), optional
            Angular frequencies in rad/s between which the sum is to hold; by default two decades
            beyond the model's own relaxation times.
        tolerance : float
            Relative error of K that is aimed at; each factor of ten costs about a quarter term a
            decade.
        temperature, reference_temperature : float, optional
            In kelvin, for models with a temperature effect; by default at the reference
            temperature.

        Returns
        -------
        Spectrum
            With the error that it has, and its derivatives by theta.

        Raises
        ------
        ModelError
            If the model is no relaxing material: it has an effect of the signals, of the amplitude
            or of waves, or a part that no sum of relaxations can follow (a loss that is not causal,
            a mass in series, Basset's layer).

        Notes
        -----
        The weights are H(r) = Im K(r exp(i pi)) / pi on the nodes of the trapezoidal rule in ln r,
        whose error with n terms a decade is 2 exp(-4.29 n); relaxation at single rates is found as
        the poles of K.

        Examples
        --------
        >>> from springpot.rheology import Model, dashpot, series, spring
        >>> found = Model("maxwell", series(spring(), dashpot())).spectrum([2.0, 8.0])
        >>> found.rates, found.weights, found.equilibrium
        (array([0.25]), array([2.]), 0.0)
        """
        return spectrum_of(
            self,
            theta,
            band,
            tolerance=tolerance,
            temperature=temperature,
            reference_temperature=reference_temperature,
        )

    def in_time(
        self,
        theta: Real,
        *,
        temperature: float | Real | None = None,
        reference_temperature: float = ROOM,
        tolerance: float = ALIKE,
    ) -> InTime:
        """The model with its parameters, to be asked for relaxation, creep or any history.

        With exact derivatives. It is the specimen in its rig that answers: what a test did, such as
        a drift, is in what `springpot.timetests.recorded` gives.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        temperature : float or ndarray, shape (n,), optional
            In kelvin; one for each sample of a history lets shift effects follow it in reduced
            time.
        reference_temperature : float
            In kelvin.
        tolerance : float
            Relative error of K, and so of what follows in time; each factor of ten costs a few
            modes.

        Returns
        -------
        InTime
            Its methods return the values and their derivatives (n, p) by the parameters.
        """
        return InTime(
            self, np.asarray(theta, dtype=float), temperature, reference_temperature, tolerance
        )

    def relaxation(self, theta: Real, t: Real, *, temperature: float | None = None) -> Real:
        """Relaxation function: force over displacement after a step of the displacement.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        t : ndarray, shape (n,)
            Time since the step in s, not negative.
        temperature : float, optional
            In kelvin, for models with a temperature effect; by default 293.15 K, where a shift is
            one.

        Returns
        -------
        ndarray, shape (n,)
            In the unit of K. A dashpot and a mass answer with an impulse at t = 0 and add nothing
            after it.

        Raises
        ------
        ModelError
            If the model has an effect that is not linear, belongs to the signals or has no law in
            time.

        Examples
        --------
        >>> from springpot.rheology import Model, dashpot, series, spring
        >>> maxwell = Model("maxwell", series(spring(), dashpot()))
        >>> maxwell.relaxation([2.0, 8.0], [0.0, 4.0]).round(6)
        array([2.      , 0.735759])
        """
        return self.in_time(theta, temperature=temperature).relaxation(t).value

    def creep(self, theta: Real, t: Real, *, temperature: float | None = None) -> Real:
        """Creep function: displacement over force after a step of the force; see `relaxation`.

        With a mass the displacement swings.

        Examples
        --------
        >>> from springpot.rheology import Model, dashpot, parallel, spring
        >>> Model("kelvin", parallel(spring(), dashpot())).creep([2.0, 8.0], [0.0, 4.0]).round(6)
        array([0.     , 0.31606])
        """
        return self.in_time(theta, temperature=temperature).creep(t).value

    def respond(
        self, theta: Real, t: Real, displacement: Real, *, temperature: float | Real | None = None
    ) -> Real:
        """Force for any history of displacement.

        Exact where that is straight between its samples.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        t, displacement : ndarray, shape (n,)
            The history, at any rising times. Before it the displacement was held at its first
            value.
        temperature : float or ndarray, shape (n,), optional
            In kelvin, one for all or one for each sample.

        Returns
        -------
        ndarray, shape (n,)
            Force, at each sample. Friction, sliders, stops and the like are followed as they are;
            signal effects act on the force signal. Velocity and acceleration, which a dashpot and a
            mass feel, are second differences.

        Raises
        ------
        ModelError
            If the history is none, or an effect has no law in time.

        Examples
        --------
        >>> from springpot.rheology import Model, spring
        >>> Model("spring", spring()).respond([2.0], [0.0, 1.0, 2.0], [0.0, 0.5, 0.2])
        array([0. , 1. , 0.4])
        """
        return self.in_time(theta, temperature=temperature).respond(t, displacement).value

    def respond_force(
        self, theta: Real, t: Real, force: Real, *, temperature: float | None = None
    ) -> Real:
        """Displacement for any history of the force; see `respond`.

        Exact where that is straight between its samples.

        Raises
        ------
        ModelError
            As `respond`; also if an effect is not linear, or if a fluid was under force before the
            history began.
        """
        return self.in_time(theta, temperature=temperature).respond_force(t, force).value


@dataclass(frozen=True)
class Family:
    """Models ``prefix-N`` for N = 1, 2, ...

    Parameters
    ----------
    name : str
        As listed, such as ``prony-N``.
    build : callable
        From N to the model called ``prefix-N``.
    summary : str
        One sentence on what the members describe.
    aliases : tuple of str
        Other names, each ending in ``-N``.
    largest : int
        Largest N accepted.
    """

    name: str
    build: Callable[[int], Model]
    summary: str = ""
    aliases: tuple[str, ...] = ()
    largest: int = 50

    def number(self, name: str) -> int | None:
        """N of the member called `name`, or None if it is none of this family's."""
        for pattern in (self.name, *self.aliases):
            match = re.fullmatch(re.escape(pattern[:-1]) + r"([1-9]\d{0,3})", name)
            if match and int(match[1]) <= self.largest:
                return int(match[1])
        return None

    def member(self, name: str) -> Model | None:
        """The member called `name`, or None if it is none of this family's."""
        number = self.number(name)
        if number is None:
            return None
        return self.build(number)


# The maps are functions of the module, so that a fit of a model that has one can be pickled.
