"""An isotropic solid from the one modulus that was measured.

Shear and bulk modulus, each as a Prony series.

One measured modulus leaves a second one open. Either Poisson's ratio stays constant, and all moduli
relax in proportion, or the bulk modulus does, as that of rubber nearly does (Tschoegl, Knauss &
Emri 2002, doi:10.1023/A:1014411503170). With a constant bulk modulus the shear modulus of a tensile
test follows from 1 / E(s) = 1 / (3 G(s)) + 1 / (9 K) at every s.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.units import MODULUS_WORDS

if TYPE_CHECKING:
    from springpot.rheology.points import Complex, Real

    from .prony import Prony

BULKS = ("constant", "relaxing")
RUBBERY = 0.45
"""Poisson's ratio above which the bulk modulus is taken to be constant, where nobody says."""
HALVINGS = 100
"""Of an interval with a root: beyond them only rounding is left."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Shear and bulk modulus of an isotropic solid.

    Attributes
    ----------
    shear, bulk : Prony
        The moduli in time; that of a constant bulk modulus has no terms.
    poisson : float
        Poisson's ratio at once; it is that at any time where both moduli relax in proportion.
    measured : {"G", "E", "K"}
        Which modulus was.
    constant : bool
        Whether the bulk modulus is.
    """

    shear: Prony
    bulk: Prony
    poisson: float
    measured: str
    constant: bool

    @property
    def young(self) -> float:
        """Young's modulus at once, E = 2 (1 + nu) G."""
        return 2.0 * (1.0 + self.poisson) * self.shear.instantaneous

    @property
    def young_at_rest(self) -> float:
        """Young's modulus in the long term, from 1 / E = 1 / (3 G) + 1 / (9 K)."""
        return 1.0 / (1.0 / (3.0 * self.shear.equilibrium) + 1.0 / (9.0 * self.bulk.equilibrium))

    def poisson_beside(self, shear: float) -> float:
        """Poisson's ratio where the shear modulus has this value: (3 K - 2 G) / (6 K + 2 G)."""
        if not self.constant:
            return self.poisson
        bulk = self.bulk.equilibrium
        return (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)

    def shear_of(self, measured: Complex) -> Complex:
        """Complex shear modulus (n,) where the measured one is `measured` (n,)."""
        own, soft = _to_shear(self.measured, self.poisson, self.bulk.equilibrium, self.constant)
        return measured / (own + soft * measured)

    @property
    def says(self) -> str:
        """What was measured and what was taken for the rest, in one line."""
        bulk = "the bulk modulus relaxes as it does, with a constant Poisson's ratio"
        if self.constant:
            bulk = f"the bulk modulus is constant, {self.bulk.equilibrium:.9g}"
        return (
            f"measured: {MODULUS_WORDS[self.measured]}; Poisson's ratio {self.poisson:.6g} at once;"
            f" {bulk}"
        )


def solid_of(prony: Prony, measured: str, poisson: float, bulk: str | None = None) -> Solid:
    """The solid whose measured modulus is this series.

    Parameters
    ----------
    prony : Prony
        Of the measured modulus, without a dashpot.
    measured : {"G", "E", "K"}
        Which one that is.
    poisson : float
        Poisson's ratio at once, above -1 and below 0.5.
    bulk : {"constant", "relaxing"}, optional
        What the bulk modulus does; constant above nu = 0.45 if nobody says, unless it was measured
        itself.

    Raises
    ------
    ModelError
        If a bulk modulus that was measured to relax is to be constant.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.solvers import Prony, solid_of
    >>> shear = Prony(1.0, 0.0, np.array([2.0]), np.array([0.1]), (1.0, 10.0), 0.0)
    >>> solid_of(shear, "G", 0.25).young
    7.5
    """
    constant = bulk == "constant"
    if bulk is None:
        constant = poisson > RUBBERY and measured != "K"
    if constant and measured == "K":
        raise ModelError("the bulk modulus was measured, and relaxes: give --bulk relaxing")
    whole = _share_of_shear(measured, poisson) * prony.instantaneous
    ratio = 2.0 * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson))
    shear = beside_a_spring(prony, *_to_shear(measured, poisson, ratio * whole, constant))
    none = np.zeros(0)
    volume = replace(prony, equilibrium=ratio * whole, weights=none, times=none)
    if not constant:
        volume = replace(
            shear, equilibrium=ratio * shear.equilibrium, weights=ratio * shear.weights
        )
    return Solid(shear, volume, poisson, measured, constant)


def young_of(solid: Solid) -> Prony:
    """The series of Young's modulus."""
    if not solid.constant:
        return beside_a_spring(solid.shear, 0.5 / (1.0 + solid.poisson), 0.0)
    return beside_a_spring(solid.shear, 1.0 / 3.0, 1.0 / (9.0 * solid.bulk.equilibrium))


def _share_of_shear(measured: str, poisson: float) -> float:
    """G over the measured modulus, of an elastic solid."""
    to_shear = {
        "G": 1.0,
        "E": 0.5 / (1.0 + poisson),
        "K": 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson),
    }
    return to_shear[measured]


def _to_shear(measured: str, poisson: float, bulk: float, constant: bool) -> tuple[float, float]:
    """The a and b of G = M / (a + b M) for the measured modulus M."""
    # 1 / G = 3 / E - 1 / (3 K).
    if constant and measured == "E":
        return 3.0, -1.0 / (3.0 * bulk)
    return 1.0 / _share_of_shear(measured, poisson), 0.0


def beside_a_spring(prony: Prony, own: float, soft: float) -> Prony:
    """The Prony series of M / (own + soft M), exactly, for the series M.

    A spring of 1 / soft in series with M / own.

    A negative `soft` takes such a spring away, which M must have in it. There are as many terms as
    before: one rate between each two of M, and one before the slowest (or beyond the fastest, where
    a spring is taken away).
    """
    equilibrium = prony.equilibrium / (own + soft * prony.equilibrium)
    if soft == 0.0 or not len(prony.times):
        return replace(prony, equilibrium=equilibrium, weights=prony.weights / own)
    if prony.viscosity:
        raise ModelError(
            "no series beside a dashpot is converted with a constant bulk modulus: give --bulk"
            " relaxing"
        )
    order = np.argsort(-prony.times)
    rates, weights = 1.0 / prony.times[order], prony.weights[order]
    # The denominator has the same poles as M, and between two of them it takes every value once.
    left = own + soft * prony.instantaneous
    before, behind = np.diff(rates, prepend=0.0), np.zeros(len(rates))
    ends = -before, behind
    if soft < 0.0:
        beyond = -soft / left * float(np.sum(weights * rates))
        ends = behind, np.append(before[1:], beyond)
    away = _roots(prony.equilibrium + own / soft, weights, rates, ends)
    gaps = rates - rates[:, None]
    slope = np.sum(weights * rates / (gaps - away[:, None]) ** 2, axis=1)
    new = rates + away
    return replace(
        prony,
        equilibrium=equilibrium,
        weights=(own / (soft**2 * slope * new))[::-1],
        times=1.0 / new[::-1],
    )


def _roots(level: float, weights: Real, rates: Real, ends: tuple[Real, Real]) -> Real:
    """Roots of level + sum of weights x / (x - rates), as distances (m,) from each rate.

    They lie between these ends. Counted from the rate itself, as that of a small term lies next to
    it.
    """
    low, high = ends
    gaps = rates - rates[:, None]
    for _ in range(HALVINGS):
        away = 0.5 * (low + high)
        place = (rates + away)[:, None]
        with np.errstate(all="ignore"):
            value = level + np.sum(weights * place / (away[:, None] - gaps), axis=1)
        # Between two rates it falls from plus to minus without end.
        low, high = np.where(value > 0.0, away, low), np.where(value > 0.0, high, away)
    found: Real = 0.5 * (low + high)
    return found
