"""Any linear passive material from tests in time: its spectrum by non-negative least squares, what surrounds it too.

A relaxation is linear in the weights of the lines, a creep is not: Gauss-Newton steps serve both, whose weights come
from non-negative least squares and the parameters of effects from what these leave (Golub & Pereyra 2003,
doi:10.1088/0266-5611/19/2/201).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.identification.coordinates import Coordinates
from springpot.identification.material import PER_DECADE, non_negative
from springpot.rheology import Continuum, Model, Real

from .parts import InTimePart, Part

SLOWER, FASTER = 1.0, 0.5
"""Decades beyond the times of the tests: what relaxes more slowly is a spring there, and of what is gone before the
first sample, but for a few per cent, any amount could have been."""
WITHIN = 3.0
"""Rates over one a step at which relaxation beside a straight motion is still told from a dashpot."""
STEPS = 60
"""A relaxation alone takes two, a creep or an effect around the material ten to thirty."""
STILL = 1e-7
"""Relative drop of the sum of squares below which a step changes nothing that is printed."""
SHORTEST = 1e-6
"""Share of a step below which none goes downhill."""
LONGEST = 1.0
"""Of a step of a searched coordinate, most of which are logarithms: beyond a factor of e no slope holds."""


def spectral(
    model: Model, parts: Sequence[Part], reference: float, coordinates: Coordinates
) -> tuple[Model, Real, int]:
    """A material with the lines that tests in time show, and its parameters.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    parts : sequence of Part
        The tests, each with its weight.
    reference : float
        Temperature in kelvin at which shifts are one.
    coordinates : Coordinates
        Of the parameters of the effects alone.

    Returns
    -------
    model : Model
        With the lines that carry weight.
    theta : ndarray, shape (p,)
        K_e, c, the weights, and the effects' parameters.
    evaluations : int
        Spent.

    Raises
    ------
    ModelError
        If the model cannot be followed in these tests.
    """
    search = _Search(model, parts, reference, coordinates)
    weights, u, cost = search.start()
    for _ in range(STEPS):
        value, by_weights, by_u = search.slopes(weights, u)
        better = search.step(weights, u, value, by_weights, by_u, cost)
        if better is None:
            break
        drop = cost - better[2]
        weights, u, cost = better
        if drop <= STILL * cost:
            break
    kept = weights[2:] > 0.0
    rates = tuple(search.rates[kept].tolist())
    theta = np.concatenate([weights[:2], weights[2:][kept], search.own(u)])
    return replace(model, material=Continuum(rates)), theta, search.evaluations


LEAST = 1e-9
"""Share of the stiffness that a line keeps while others are sought: a thousandth of the best transducer's noise."""


class _Search:
    """Residuals of tests by the weights of a lattice of lines and by the effects' coordinates."""

    def __init__(self, model: Model, parts: Sequence[Part], reference: float, coordinates: Coordinates) -> None:
        self.parts, self.reference = list(parts), reference
        self.coordinates, self.size = coordinates, coordinates.size[0]
        seen = [_seen(part) for part in parts]
        low, high = min(each[0] for each in seen), max(each[1] for each in seen)
        decades = np.log10(high / low) + SLOWER + FASTER
        self.rates = np.geomspace(low * 10.0**-SLOWER, high * 10.0**FASTER, int(PER_DECADE * decades) + 2)
        self.model = replace(model, material=Continuum(tuple(self.rates.tolist())))
        self.count = 2 + len(self.rates)
        self.bounds = coordinates.bounds()
        self.evaluations = 0

    def own(self, u: Real) -> Real:
        """Parameters of the effects at u."""
        return self.coordinates.theta(u, self.size)

    def start(self) -> tuple[Real, Real, float]:
        """All lines alike, as stiff together as what was measured, and effects of their natural size."""
        stiffness = float(np.exp(np.mean([np.log(_typical(part)) for part in self.parts])))
        u = np.where(self.coordinates.log, 0.0, 0.5)
        for share in (1.0, 1e-2, 1e-4):
            # Effects that are far too large hide the material: smaller ones may be nearer.
            small = np.where(self.coordinates.log, u + np.log(share), u)
            weights = np.full(self.count, stiffness / self.count)
            cost = self.cost(weights, small)
            if np.isfinite(cost):
                return weights, small, cost
        raise ModelError(f"{self.model.name} cannot be followed in these tests")

    def cost(self, weights: Real, u: Real) -> float:
        """Sum of squares; endless where the model cannot be followed."""
        try:
            value = self._residual(weights, u)[0]
        except SpringpotError:
            return np.inf
        return float(value @ value)

    def _residual(self, weights: Real, u: Real) -> tuple[Real, Real]:
        self.evaluations += 1
        # A line of no weight at all has no place among the times of the creep, and so no slope there.
        least = LEAST * weights.sum()
        theta = np.concatenate([weights[:2], np.maximum(weights[2:], least), self.own(u)])
        found = [part.residual(self.model, theta, self.reference) for part in self.parts]
        return np.concatenate([each.value for each in found]), np.concatenate([each.by_theta for each in found])

    def slopes(self, weights: Real, u: Real) -> tuple[Real, Real, Real]:
        """Residuals (m,), and their derivatives by the weights (m, w) and by u (m, q)."""
        value, by_theta = self._residual(weights, u)
        by_own = np.ascontiguousarray(by_theta[:, self.count :].T)
        return value, by_theta[:, : self.count], self.coordinates.carry(by_own, self.own(u), self.size).T

    def step(
        self, weights: Real, u: Real, value: Real, by_weights: Real, by_u: Real, cost: float
    ) -> tuple[Real, Real, float] | None:
        """A better place, or None where none is found on the way to that of the linear problem."""
        basis = np.linalg.qr(by_u)[0] if by_u.shape[1] else by_u
        target = by_weights @ weights - value

        def beside(each: Real) -> Real:
            rest: Real = each - basis @ (basis.T @ each)
            return rest

        wanted = non_negative(beside(by_weights), beside(target))[0]
        move = np.linalg.lstsq(by_u, target - by_weights @ wanted, rcond=1e-8)[0] if len(u) else u
        move = np.clip(move, -LONGEST, LONGEST)
        share = 1.0
        while share > SHORTEST:
            there = np.clip(u + share * move, self.bounds[0][0], self.bounds[1][0])
            nearer = weights + share * (wanted - weights)
            found = self.cost(nearer, there)
            if found < cost:
                return nearer, there, found
            share *= 0.3
        return None


def _seen(part: Part) -> tuple[float, float]:
    """Angular frequencies between which a part tells something."""
    if isinstance(part, InTimePart):
        slowest, fastest = part.test.seen
        # Within a step of a record the motion is straight, and that tells of what relaxes in it.
        return slowest, fastest if part.test.kind in ("relaxation", "creep") else WITHIN * fastest
    return float(part.test.omega.min()), float(part.test.omega.max())


def _typical(part: Part) -> float:
    """Typical size of K."""
    if not isinstance(part, InTimePart):
        return float(np.exp(np.mean(np.log(part.test.magnitude))))
    test = part.test
    imposed, answered = float(np.abs(test.loading.value).max()), float(np.abs(test.response).max())
    return answered / imposed if test.control == "displacement" else imposed / max(answered, 1e-300)
