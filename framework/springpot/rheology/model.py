"""A model: a named network with effects that gives K, its spectrum, and what happens in time.

Families of models that differ in one whole number, such as ``prony-N``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springpot.writing import tag

from ..numerics import ALIKE
from .drawing import drawing_of
from .history import InTime
from .named import NamedNetwork
from .points import ROOM, Real
from .spectrum import Spectrum, spectrum_of


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
