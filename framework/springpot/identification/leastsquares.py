"""Levenberg-Marquardt for many problems side by side, and the way of a search for a spectrum.

Every row is a problem of its own with its own damping; rows leave the batch as they converge. There
is no loop over rows, so that one call costs about as much for one start as for twenty. A search for
a spectrum keeps the best lines at a setting, and finds the way to the next one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import ALIKE, NEGLIGIBLE, ROUNDING, SMALLEST
from .normal import Equations, Whole

Rows: TypeAlias = NDArray[np.intp]
Evaluate: TypeAlias = Callable[[Real, Rows], tuple[Real, Real]]

START_DAMPING = 1e-2
SHRINK = 0.05
"""Strongest reduction of the damping after a step that did as foretold."""
FLAT = 1e-13
"""A predicted drop of this share of the objective moves no parameter by 1e-6 of its deviation."""
REACH = 3.0
"""Longest step in one search coordinate: a factor of e^3 for a parameter searched by its logarithm.
"""
AGREE = 3
"""Starts that must end in the same optimum for it to be believed."""

WHOLE = Whole()

TRIED = ("u", "cost", "gradient", "jtj", "residual")


class Residual(NamedTuple):
    """Differences over their noise (m,), and their derivatives by the parameters (m, p)."""

    value: Real
    by_theta: Real

    def freed(self, columns: Real) -> Residual:
        """The same, of noise that has unknown amounts of variance one of some columns (m, k) too.

        Examples
        --------
        >>> one = Residual(np.array([3.0, 4.0]), np.zeros((2, 0)))
        >>> one.freed(np.array([[1e6], [0.0]])).value.round(3)
        array([0., 4.])
        """
        if not columns.shape[1]:
            return self
        basis, size, _ = np.linalg.svd(columns, full_matrices=False)
        lost = basis * (1.0 - 1.0 / np.sqrt(1.0 + size**2))
        value, by_theta = (each - lost @ (basis.T @ each) for each in self)
        return Residual(value, by_theta)


@dataclass(frozen=True)
class Solution:
    """Where the rows ended.

    Attributes
    ----------
    u : ndarray, shape (R, p)
        Search coordinates.
    cost : ndarray, shape (R,)
        Sum of squared residuals.
    jtj : ndarray, shape (R, ...)
        Jacobian times its transpose at `u`, as the equations have it.
    residual : ndarray, shape (R, m)
        Residuals at `u`.
    converged : ndarray of bool, shape (R,)
        Whether the row stopped by itself; false where its team no longer needed it or the
        iterations ran out.
    evaluations : int
        Rows evaluated in all, each with its derivative.
    """

    u: Real
    cost: Real
    jtj: Real
    residual: Real
    converged: NDArray[np.bool_]
    evaluations: int

    @property
    def best(self) -> int:
        """The row that ended lowest; of those that ended alike, one that stopped by itself.

        Its team lets a row go once enough others have stopped: it may lie lower by a rounding.
        """
        alike = self.converged & (self.cost <= self.cost.min() * (1.0 + ALIKE))
        if not alike.any():
            return int(np.argmin(self.cost))
        return int(np.argmin(np.where(alike, self.cost, np.inf)))


@dataclass(frozen=True)
class Effort:
    """How far a fit goes.

    Attributes
    ----------
    negligible : float
        Share of the objective that is not worth a further step.
    hopeless : float
        Objective above which the model is of no interest: what the first steps leave above it is
        not searched further.
    """

    negligible: float = FLAT
    hopeless: float = np.inf

    def of_part(self, share: float) -> Effort:
        """The same for a share of the points."""
        return Effort(self.negligible, self.hopeless * share)


@dataclass
class _State:
    """The rows still at work."""

    rows: Rows
    u: Real
    cost: Real
    gradient: Real
    jtj: Real
    residual: Real
    damping: Real
    growth: Real

    def put(self, better: NDArray[np.bool_], other: tuple[Real, Real, Real, Real, Real]) -> None:
        """Take over the trial wherever it was better."""
        # Mostly all are better: then the trial is taken over as it is, without a copy.
        worse = np.flatnonzero(~better)
        for name, new in zip(TRIED, other, strict=True):
            if len(worse):
                new[worse] = getattr(self, name)[worse]
            setattr(self, name, new)

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Drop the other rows."""
        for name, value in vars(self).items():
            setattr(self, name, value[which])


@dataclass(frozen=True)
class _Rules:
    """The boxes of all rows, and when a row or its team may stop; see `levenberg_marquardt`."""

    lower: Real
    upper: Real
    floors: Real
    team: Rows | None
    flat: float
    alike: float
    equations: Equations

    def of_rows(self, rows: Rows) -> _Rules:
        """Those of the rows still at work."""
        return replace(
            self, lower=self.lower[rows], upper=self.upper[rows], floors=self.floors[rows]
        )


def one_by_one(evaluate: Callable[[Real], tuple[Real, Real]]) -> Evaluate:
    """Residuals and slopes at many places from those at one, where no shape can be stacked."""

    def at_all(u: Real, rows: Rows) -> tuple[Real, Real]:
        pairs = [evaluate(one) for one in u]
        return np.stack([value for value, _ in pairs]), np.stack([slopes for _, slopes in pairs])

    return at_all


def levenberg_marquardt(
    evaluate: Evaluate,
    u0: Real,
    lower: Real,
    upper: Real,
    *,
    floor: Real | float = 0.0,
    team: Rows | None = None,
    iterations: int = 100,
    damping: float = START_DAMPING,
    flat: float = FLAT,
    alike: float = ALIKE,
    equations: Equations = WHOLE,
) -> Solution:
    """Minimise the sum of squared residuals of every row, within its box.

    Parameters
    ----------
    evaluate : callable
        From search points (r, p) and their row numbers (r,) to residuals (r, m) and their
        derivative (r, p, m).
    u0 : ndarray, shape (R, p)
        Starts.
    lower, upper : ndarray, shape (R, p) or (p,)
        The box; infinite where there is none.
    floor : ndarray, shape (R,), or float
        Objective at which nothing but rounding is left.
    team : ndarray of int, shape (R,), optional
        Rows that are starts of one problem: they stop together once one reaches its floor, or once
        `AGREE` of them have converged to the best objective seen.
    iterations : int
        Steps at most.
    damping : float
        Of the first step.
    flat : float
        A row has converged once the drop foretold is this fraction of its objective. Only a step
        that is hardly damped foretells all that is left to gain; a damped one counts from `FLAT`
        on.
    alike : float
        Ends within this fraction of the best objective agree with it.
    equations : Equations
        How the derivative is squared and a step solved for: of levels with parameters of their own
        by its blocks, whose form the derivative then has.

    Returns
    -------
    Solution
        One row for each start.

    Notes
    -----
    Steps are damped in proportion to the diagonal of J J' (D. W. Marquardt, 1963,
    doi:10.1137/0111030); the damping grows as in H. B. Nielsen, Damping parameter in Marquardt's
    method, IMM-REP-1999-05. A variable at a bound towards which the objective falls is frozen for
    the step.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.identification import levenberg_marquardt
    >>> evaluate = lambda u, rows: (u**2 - 2.0, (2.0 * u)[:, :, None])
    >>> starts, lower, upper = np.array([[1.0], [5.0]]), np.zeros(1), np.full(1, 10.0)
    >>> levenberg_marquardt(evaluate, starts, lower, upper).u.round(6)
    array([[1.414214],
           [1.414214]])
    """
    box = np.broadcast_to(lower, u0.shape), np.broadcast_to(upper, u0.shape)
    floors = np.broadcast_to(np.asarray(floor, dtype=float), (len(u0),))
    rules = _Rules(*box, floors, team, flat, alike, equations)
    # Trials may lie where a model overflows: such a step is taken back, and no warning is wanted
    # for it.
    with np.errstate(all="ignore"):
        state = _first(evaluate, np.clip(u0, rules.lower, rules.upper), damping, equations)
        # Rows are written back here as they leave, so that those at work stay packed together.
        ended = _State(**{name: value.copy() for name, value in vars(state).items()})
        converged, steps = _descend(evaluate, state, ended, rules, iterations)
    return Solution(ended.u, ended.cost, ended.jtj, ended.residual, converged, len(u0) + steps)


def _descend(
    evaluate: Evaluate, state: _State, ended: _State, rules: _Rules, iterations: int
) -> tuple[NDArray[np.bool_], int]:
    """Step until all rows have retired to `ended`.

    Says which converged (R,), and how many steps rows took in all.
    """
    converged = np.zeros(len(state.rows), dtype=bool)
    steps, own = 0, rules
    finished = state.cost <= rules.floors
    for _ in range(iterations):
        if finished.any():
            converged[state.rows[finished]] = True
            _retire(state, ended, finished, converged, rules)
        if not len(state.rows):
            break
        steps += len(state.rows)
        # Rows only ever leave: while their number stays, so do they.
        if len(state.rows) != len(own.floors):
            own = rules.of_rows(state.rows)
        finished = _advance(evaluate, state, own)
    if len(state.rows):
        converged[state.rows[finished]] = True
        _store(state, ended)
    return converged, steps


def _first(evaluate: Evaluate, u: Real, damping: float, equations: Equations) -> _State:
    rows = np.arange(len(u))
    residual, jacobian = evaluate(u, rows)
    cost, gradient, jtj = equations.normal(residual, jacobian)
    # So that any finite trial is better than a start without a value.
    cost = np.where(np.isfinite(cost), cost, np.inf)
    return _State(
        rows, u, cost, gradient, jtj, residual, np.full(len(u), damping), np.full(len(u), 2.0)
    )


def _advance(evaluate: Evaluate, state: _State, rules: _Rules) -> NDArray[np.bool_]:
    """One damped step of every row, by its own rules; says which rows are finished."""
    trial = np.minimum(np.maximum(state.u + _step(state, rules), rules.lower), rules.upper)
    step = trial - state.u
    # The drop that the quadratic model foretells for the step as it was cut, not as it was wanted.
    bent = rules.equations.bent(state.jtj, step)
    predicted = -(step * (2.0 * state.gradient + bent)).sum(axis=1)
    residual, jacobian = evaluate(trial, state.rows)
    cost, gradient, jtj = rules.equations.normal(residual, jacobian)
    gain = state.cost - cost
    # A trial whose objective is no number compares as not better, and is taken back.
    better = gain > 0.0
    still = np.abs(step).max(axis=1, initial=0.0) <= ROUNDING
    # A damped step foretells less than is left to gain: only a nearly free one may stop early.
    within = np.where(state.damping <= START_DAMPING, rules.flat, FLAT)
    level = np.abs(predicted) <= within * state.cost
    _damp(state, better, gain / predicted)
    state.put(better, (trial, cost, gradient, jtj, residual))
    finished: NDArray[np.bool_] = still | level | (state.cost <= rules.floors)
    return finished


def _step(state: _State, rules: _Rules) -> Real:
    """The damped Gauss-Newton step, no longer than `REACH`, frozen at bounds."""
    if state.u.shape[1] == 0:
        return np.zeros_like(state.u)
    downhill = -state.gradient
    # A step against a bound would be cut there, and the other variables would have counted on it.
    frozen = ((state.u <= rules.lower) & (downhill < 0.0)) | (
        (state.u >= rules.upper) & (downhill > 0.0)
    )
    step = rules.equations.step(state.jtj, downhill, state.damping, frozen)
    longest = np.abs(step).max(axis=1, keepdims=True, initial=SMALLEST)
    shortened: Real = step * np.minimum(1.0, REACH / longest)
    return shortened


def _damp(state: _State, better: NDArray[np.bool_], ratio: Real) -> None:
    """Less damping the better the quadratic model foretold the drop, ever more after failures."""
    # The cubic and the doubled growth are those of Nielsen (see the notes of
    # `levenberg_marquardt`).
    miss = 2.0 * ratio - 1.0
    trust = np.maximum(1.0 - miss * miss * miss, SHRINK)
    damping = state.damping * np.where(better, trust, state.growth)
    # Some is left in the end, so that a singular matrix still has an inverse.
    state.damping = np.maximum(damping, ROUNDING)
    state.growth = np.where(better, 2.0, 2.0 * state.growth)


def _retire(
    state: _State,
    ended: _State,
    finished: NDArray[np.bool_],
    converged: NDArray[np.bool_],
    rules: _Rules,
) -> None:
    """Store the rows; let go of the finished ones and of team-mates no longer needed."""
    _store(state, ended)
    done = finished
    if rules.team is not None:
        done = done | _done_teams(rules.team, converged, ended.cost, rules)[rules.team[state.rows]]
    state.keep(~done)


def _store(state: _State, ended: _State) -> None:
    for name in ("u", "cost", "jtj", "residual"):
        getattr(ended, name)[state.rows] = getattr(state, name)


def _done_teams(
    team: Rows, converged: NDArray[np.bool_], cost: Real, rules: _Rules
) -> NDArray[np.bool_]:
    """Teams of which one row has reached its floor or enough rows agree on the best objective."""
    teams = int(team.max()) + 1
    # Over rows still at work too: none may be called the best while another is lower.
    best = np.full(teams, np.inf)
    np.minimum.at(best, team, cost)
    agree = converged & (cost <= best[team] * (1.0 + rules.alike))
    votes = np.bincount(team, weights=agree, minlength=teams)
    reached = np.bincount(team, weights=converged & (cost <= rules.floors), minlength=teams)
    return (votes >= AGREE) | (reached > 0)


@dataclass(frozen=True, eq=False)
class Trial:
    """The best spectrum at given parameters of the effects."""

    u: Real
    log_rates: Real
    weights: Real
    cost: float


@dataclass
class Solving:
    """A trial whose weights are solved for, the best of them, and the cost that is foretold."""

    trial: Trial
    best: Trial
    foretold: float = np.inf


@dataclass
class Way:
    """A descent: where it is, the residual and its fall there, and where it goes next.

    It is at rest where a step changes nothing that is printed.
    """

    trial: Trial
    damping: float = 1e-3
    slopes: tuple[Real, Real] = (np.zeros(0), np.zeros((0, 0)))
    better: bool = True
    at_rest: bool = True
    taken: int = 0

    def moves(self, low: Real, high: Real) -> bool:
        """Take the next step in view, and tell whether it is one."""
        # Nearly a Gauss-Newton step at first; what the data do not bear makes it shorter.
        self.ahead = np.clip(self.trial.u + _damped_step(*self.slopes, self.damping), low, high)
        self.at_rest = bool(np.max(np.abs(self.ahead - self.trial.u)) < NEGLIGIBLE)
        return not self.at_rest

    def take(self, other: Trial, still: float) -> None:
        """Go on to the best spectrum there, if it is better."""
        drop = self.trial.cost - other.cost
        self.better, self.at_rest = drop > 0.0, False
        if not self.better:
            # Not better, or no number: a shorter step, nearer to the steepest descent.
            self.damping *= 10.0
            return
        self.trial, self.damping = other, max(0.1 * self.damping, 1e-9)
        self.taken += 1
        self.at_rest = drop <= still * other.cost


def _damped_step(residual: Real, slopes: Real, damping: float) -> Real:
    """A damped Gauss-Newton step (q,), no coordinate of it beyond `REACH`."""
    size = np.linalg.norm(slopes, axis=0)
    # Slopes so small that their squares are zero have no size: divided by less they would drown the
    # damping.
    size = np.maximum(size, ALIKE * max(float(size.max()), 1e-150))
    scaled = slopes / size
    matrix = scaled.T @ scaled + damping * np.eye(len(size))
    step: Real = np.clip(np.linalg.solve(matrix, scaled.T @ residual) / size, -REACH, REACH)
    return step
