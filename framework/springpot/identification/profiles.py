"""Profiles of the objective along a parameter: its interval, and whether the data tell it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..numerics import ALIKE, PRINTED
from .coordinates import Coordinates
from .leastsquares import WHOLE, Rows, levenberg_marquardt
from .native import Fit
from .normal import Equations
from .uncertainty import Uncertainty, printed_spread
from .value import LOST

IDENTIFIABLE = "identifiable", "practically not", "not at all"
"""Whether data tell a parameter.

Its interval has two ends, three decades apart at most; it has not, though a value fits best or one
end is known; or other parameters make up for whatever it is.
"""
NOTHING = 1e-3
"""Share of the rise at an interval's end that is none: what is left of a search's tolerance."""


def profile(fit: Fit, parameter: str, level: float = INTERVAL) -> tuple[float, float]:
    """Profile-likelihood interval of one parameter: all others are refitted while it is held.

    Parameters
    ----------
    fit : Fit
        The fit.
    parameter : str
        Name of the parameter.
    level : float
        Probability.

    Returns
    -------
    low, high : float
        Where the best objective has risen by the quantile's square; a bound or infinity where it
        never does.

    Notes
    -----
    D. J. Venzon and S. H. Moolgavkar, 1988, doi:10.2307/2347496. Of specimens that were fitted
    together the rise is that of a parameter that scatters as they do (A. Rotnitzky and N. P.
    Jewell, 1990, doi:10.1093/biomet/77.3.485).

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import fit, profile
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> low, high = profile(best, "alpha")
    >>> bool(low < best.theta[best.model.names.index("alpha")] < high)
    True
    """
    found = profiled(Uncertainty.of(fit, level), fit.model.names.index(parameter))
    return found.low, found.high


class Profile(NamedTuple):
    """What the best fits along one parameter tell of it.

    Attributes
    ----------
    low, high : float
        Ends of its interval.
    verdict : str
        One of `IDENTIFIABLE`.
    """

    low: float
    high: float
    verdict: str


def profiled(known: Uncertainty, i: int) -> Profile:
    """The profile of parameter i; see `profile`."""
    fit = known.fit
    rise = known.widening(i) * (allowed_cost(known) - fit.cost)
    path = Path.of(fit, i)
    return path.profile(_first_step(known, i, path.coordinates), fit.cost, rise)


def allowed_cost(known: Uncertainty) -> float:
    """The objective at the ends of a profile's interval."""
    fit = known.fit
    # Nothing is left over from which the scatter could be known: no rise is too much for it.
    if not np.isfinite(known.scale):
        return float("inf")
    # t^2 is F with one degree of freedom: the rise that a single parameter is allowed.
    return fit.cost + (known.quantile * known.scale) ** 2


def held_costs(fit: Fit, parameter: str, values: Real) -> Real:
    """Best objectives with one parameter held at each of some values and all others refitted.

    Parameters
    ----------
    fit : Fit
        The fit.
    parameter : str
        Name of the parameter.
    values : ndarray, shape (m,)
        Where it is held, in SI.

    Returns
    -------
    ndarray, shape (m,)
        The objectives.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import fit, held_costs
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> bool((held_costs(best, "alpha", [0.4, 0.6]) > best.cost).all())
    True
    """
    i = fit.model.names.index(parameter)
    path = Path.of(fit, i)
    places = np.asarray(values, dtype=float) / float(path.coordinates.size[0, i])
    if path.coordinates.log[i]:
        places = np.log(places)
    return path.costs(places)


def _first_step(known: Uncertainty, i: int, plain: Coordinates) -> float:
    """Standard deviation of parameter i in plain coordinates, or a small step if there is none."""
    sd = float(printed_spread(known.fit, known.covariance)[i])
    if not plain.log[i]:
        sd /= float(plain.size[0, i])
    # Any step will do where the Jacobian knows none: the search along the profile doubles it.
    if not np.isfinite(sd) or sd <= 0:
        return 1e-3
    return sd


@dataclass(frozen=True, eq=False)
class Path:
    """The best fits along one parameter.

    The coordinate of the solver for a constant of a springpot mixes it with the order: held there,
    it would move. So the coordinates here are plain: each parameter or its logarithm.

    Parameters
    ----------
    coordinates : Coordinates
        Without pairs.
    u : ndarray, shape (p,)
        The best fit in these.
    i : int
        Number of the parameter.
    evaluate : callable
        Residuals and their slopes by the coordinates, as `levenberg_marquardt` asks for them.
    equations : Equations
        How these are squared.
    """

    coordinates: Coordinates
    u: Real
    i: int
    evaluate: Callable[[Real, Rows], tuple[Real, Real]]
    equations: Equations = WHOLE

    @classmethod
    def of(cls, fit: Fit, i: int) -> Path:
        """That of a parameter of a fit."""
        plain = replace(fit.task.coordinates, pairs=())
        task = replace(fit.task, given=plain)

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            # All places are of the one data set.
            return task.evaluator(np.zeros(len(u), dtype=np.intp))(u, np.arange(len(u)))

        return cls(plain, plain.u(fit.theta, plain.size[0]), i, evaluate, task.equations)

    def profile(self, step: float, cost: float, rise: float) -> Profile:
        """Where the best objective has risen by so much from its least, and what that tells.

        The verdicts are those of Raue et al. 2009, doi:10.1093/bioinformatics/btp358.
        """
        low, high = self.interval(step, cost + rise)
        told = np.isfinite([low, high])
        if log := bool(self.coordinates.log[self.i]):
            told &= np.array([low, high]) > 0.0
        yes, practically, never = IDENTIFIABLE
        if told.all() and not (log and high > LOST * low):
            return Profile(low, high, yes)
        places = self._about()
        moved = np.tile(self.u, (len(places), 1))
        moved[:, self.i] = places
        residual, _ = self.evaluate(moved, np.arange(len(places)))
        alone = np.sum(residual**2, axis=1) - cost > NOTHING * rise
        flat = self.costs(places) - cost <= NOTHING * rise
        # What others make up for, or what nothing shows on either side.
        if np.any(alone & flat) or (flat.all() and not told.any()):
            return Profile(low, high, never)
        return Profile(low, high, practically)

    def _about(self) -> Real:
        """A place on either side: half and twice the parameter, or as far as there is room."""
        ends = np.array([bound[0, self.i] for bound in self.coordinates.bounds()])
        start, reach = float(self.u[self.i]), np.log(2.0)
        if not self.coordinates.log[self.i]:
            reach = max(0.5 * abs(start), 0.1)
        return np.asarray(np.clip(start + reach * np.array([-1.0, 1.0]), *ends))

    def interval(self, step: float, allowed: float) -> tuple[float, float]:
        """Where the best objective has risen to `allowed` on either side, else the bounds."""
        parameter = self.coordinates.parameters[self.i]
        low, high = (self.crossing(sign, step, allowed) for sign in (-1.0, 1.0))
        lower, upper = parameter.lower, parameter.upper
        # Where the objective never rises that far, the interval ends at the bound of the parameter.
        if low is not None:
            lower = max(low, lower)
        if high is not None:
            upper = min(high, upper)
        return lower, upper

    def crossing(self, sign: float, sd: float, allowed: float) -> float | None:
        """Value of the parameter where its profile reaches `allowed` on one side.

        None if it never does.
        """
        limit, upper = self.coordinates.bounds()
        if sign > 0:
            limit = upper
        start = float(self.u[self.i])
        room = abs(float(limit[0, self.i]) - start)
        # Doubled from half a deviation on: an interval may be far longer than the Jacobian says.
        inner, steps = 0.0, sd * 2.0 ** np.arange(-1.0, 12.0)
        if np.isfinite(room):
            steps = np.zeros(1)
            if room > 0.0:
                steps = np.geomspace(min(0.5 * sd, room), room, 16)
        # The coarse way first, then in nine pieces a round.
        for _ in range(4):
            over = np.flatnonzero(self.costs(start + sign * steps) > allowed)
            if not len(over):
                return None
            first = int(over[0])
            outer = float(steps[first])
            if first:
                inner = float(steps[first - 1])
            if outer - inner <= PRINTED * outer:
                break
            steps = np.linspace(inner, outer, 10)[1:]
        end, size = start + sign * outer, float(self.coordinates.size[0, self.i])
        if self.coordinates.log[self.i]:
            end = float(np.exp(end))
        return size * end

    def costs(self, places: Real) -> Real:
        """Best objective with the parameter held at each of `places`."""
        lower, upper = (
            np.repeat(bound, len(places), axis=0) for bound in self.coordinates.bounds()
        )
        # Bounds that meet hold a parameter in place without a solver of its own.
        lower[:, self.i] = upper[:, self.i] = places
        # All places begin at the best fit, and are solved side by side.
        u = np.tile(self.u, (len(places), 1))
        u[:, self.i] = places
        return levenberg_marquardt(
            self.evaluate,
            u,
            lower,
            upper,
            flat=ALIKE,
            iterations=60,
            equations=self.equations,
        ).cost
