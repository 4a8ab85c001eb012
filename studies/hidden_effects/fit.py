"""A truth as one formula, and a small least-squares fit of it to noise-free data."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from hidden_effects.bases import Base, Complex, Law, Real, Sweep
from hidden_effects.effects import Effect

LIMITS = {"log": (-60.0, 60.0), "order": (0.0, 1.0), "exponent": (0.05, 2.5), "signed": (-1e3, 1e3)}


@dataclass(frozen=True)
class Network:
    """Base, temperature law and effects; takes one flat array of parameters in that order."""

    base: Base
    law: Law | None = None
    effects: tuple[Effect, ...] = ()
    heating: bool = False
    reference: float = 20.0

    @cached_property
    def ordered(self) -> tuple[tuple[Effect, slice], ...]:
        """The effects from the specimen outwards, with the place of their parameters."""
        start = self.size_of_base + self.heating
        places = []
        for effect in self.effects:
            places.append((effect, slice(start, start + len(effect.parameters))))
            start += len(effect.parameters)
        return tuple(sorted(places, key=lambda pair: pair[0].layer))

    @property
    def size_of_base(self) -> int:
        """Number of parameters of base and law."""
        return len(self.base.parameters) + (len(self.law.parameters) if self.law else 0)

    @property
    def kinds(self) -> list[str]:
        """How every parameter is fitted."""
        law = ["signed" if n == "Ea" else "log" for n in self.law.parameters] if self.law else []
        extra = [kind for effect in self.effects for kind in effect.kinds]
        return [*self.base.kinds, *law, *(["log"] if self.heating else []), *extra]

    def log_shift(self, sweep: Sweep, p: Real, warmer: Real | float = 0.0) -> Real:
        """Return ln a_T per row, for the stated temperature plus ``warmer`` degrees."""
        if self.law is None or sweep.temperature is None:
            return np.zeros(len(sweep))
        own = p[len(self.base.parameters) : self.size_of_base]
        return self.law.log_shift(sweep.temperature + warmer, self.reference, own)

    def reduced(self, sweep: Sweep, p: Real) -> Real:
        """Return omega a_T."""
        return sweep.omega * np.exp(self.log_shift(sweep, p))

    def stiffness(self, sweep: Sweep, p: Real) -> Complex:
        """Return the complex stiffness of the whole at every row."""
        own = p[: len(self.base.parameters)]
        omega = self.reduced(sweep, p)
        if self.heating:
            assert sweep.amplitude is not None
            power = (
                0.5 * sweep.omega * self.base.stiffness(1j * omega, own).imag * sweep.amplitude**2
            )
            omega = sweep.omega * np.exp(self.log_shift(sweep, p, p[self.size_of_base] * power))
        k = self.base.stiffness(1j * omega, own)
        for effect, place in self.ordered:
            k = effect.apply(k, 1j * (omega if effect.layer == 0 else sweep.omega), sweep, p[place])
        return k

    def without_effects(self) -> Network:
        """Return the network of base and law alone."""
        return replace(self, effects=(), heating=False)


@dataclass(frozen=True)
class Coordinates:
    """Physical parameters <-> unbounded search coordinates.

    Logarithms for scales, multiples for signed ones.
    """

    kinds: tuple[str, ...]
    unit: Real

    @classmethod
    def around(cls, kinds: list[str], p: Real) -> Coordinates:
        """Take the size of ``p`` as the unit of every signed parameter."""
        return cls(tuple(kinds), np.where(p == 0.0, 1.0, np.abs(p)))

    def to_search(self, p: Real) -> Real:
        """Return search coordinates."""
        log = np.array([k == "log" for k in self.kinds])
        signed = np.array([k == "signed" for k in self.kinds])
        return np.where(log, np.log(np.where(log, p, 1.0)), np.where(signed, p / self.unit, p))

    def to_physics(self, u: Real) -> Real:
        """Return physical parameters."""
        log = np.array([k == "log" for k in self.kinds])
        signed = np.array([k == "signed" for k in self.kinds])
        return np.where(log, np.exp(np.where(log, u, 0.0)), np.where(signed, u * self.unit, u))


def whiten(k: Complex, sigma: Real) -> Real:
    """Return real and imaginary parts in units of sigma."""
    return np.concatenate([k.real / sigma, k.imag / sigma])


def jacobian(network: Network, at: Coordinates, u: Real, sweep: Sweep, sigma: Real) -> Real:
    """Central differences of the whitened response, one column per parameter."""
    columns = []
    for i in range(u.size):
        step = np.zeros(u.size)
        step[i] = 1e-5
        up, down = (network.stiffness(sweep, at.to_physics(u + d)) for d in (step, -step))
        columns.append(whiten(up - down, sigma) / 2e-5)
    return np.column_stack(columns)


def refit(
    network: Network, start: Real, sweep: Sweep, target: Complex, sigma: Real, evaluations: int = 60
) -> tuple[Real, float]:
    """Fit ``network`` to ``target`` from ``start``.

    Return parameters and the chi-square that is left.
    """
    at = Coordinates.around(network.kinds, start)
    low, high = (np.array(limit) for limit in zip(*(LIMITS[k] for k in network.kinds), strict=True))

    def residual(u: Real) -> Real:
        with np.errstate(all="ignore"):
            r = whiten(network.stiffness(sweep, at.to_physics(u)) - target, sigma)
        return np.clip(np.nan_to_num(r, nan=1e9), -1e9, 1e9)

    def slope(u: Real) -> Real:
        with np.errstate(all="ignore"):
            return np.clip(
                np.nan_to_num(jacobian(network, at, u, sweep, sigma), nan=0.0), -1e12, 1e12
            )

    first = np.clip(at.to_search(start), low + 1e-6, high - 1e-6)
    found = least_squares(
        residual,
        first,
        jac=slope,
        bounds=(low, high),
        ftol=1e-9,
        xtol=1e-10,
        gtol=1e-12,
        max_nfev=evaluations,
    )
    return at.to_physics(found.x), float(2.0 * found.cost)


def linear_loss(basis: Real, change: Real) -> float:
    """Chi-square of ``change`` without its projection on the columns of ``basis`` (first order)."""
    q = np.linalg.qr(basis)[0]
    return float(np.sum((change - q @ (q.T @ change)) ** 2))
