"""Smooth hysteresis after Bouc and Wen: a spring that yields gradually, with its exact loop.

The force F z of the element follows the displacement x by z' = (k / F) x' (1 - |z|^n (beta sgn(z
x') + 1 - beta)): k is its stiffness near z = 0 and F the force at which it yields (Wen 1976, J.
Eng. Mech. Div. ASCE 102, 249; Ikhouane and Rodellar 2007, Systems with Hysteresis). It knows no
rate, so that a steady cycle between -X and X is one loop. On its falling half the distance from the
tip is

    int_z^Z dy / (1 + (2 beta - 1) y^n)      while z falls from its greatest value Z to 0, and
    beyond int_0^|z| dy / (1 - y^n)

more, both together 2 k X / F. Integrated by parts, the harmonic F_m of the force is 2 i / (pi m)
times the integral of exp(-i m phi) over z, with cos phi = x / X. Both integrals are done by Gauss's
rule in a variable that is flat at z = 0 and at the tips, where they have roots and powers: they
converge geometrically, to 1e-8 with 24 nodes.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise
from math import copysign, exp, expm1, log, log1p, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.special import betainc, betaln

from ..numerics import ENDLESS, MOST_STEPS, ROUNDING, SMALLEST
from .elements import spring
from .grammar import Formula
from .nodes import FULL, VALUE, Node, Response
from .nonlinear import NEEDS_AMPLITUDE, balanced_series, slip_film
from .parameters import FORCE, PURE, Parameter, stiffness
from .points import FURTHEST, Complex, Points, Real
from .terms import BLOCK

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

Shape: TypeAlias = tuple[float, float, float, float]
"""Stiffness k, yield force F, sharpness n and share beta."""
NODES = 24
"""Nodes on each half of z; the error falls by a factor of ten with every three more."""
FLATNESS = 4
"""Power with which the variable is flat at its ends: then roots at the tips become squares."""
NEWTON_STEPS = 5
"""Four reach rounding from the start below for kX/F from 1e-8 to 1e8 and n from 0.5 to 8."""


class QuadratureRule(NamedTuple):
    """Integration over (0, 1).

    Attributes
    ----------
    log_node : ndarray, shape (q,)
        Logarithms of the nodes.
    weight : ndarray, shape (q,)
        Weights of the whole integral.
    up_to, beyond : ndarray, shape (q, q)
        Weights of the integral from 0 to each node, and from it to 1.
    """

    log_node: Real
    weight: Real
    up_to: Real
    beyond: Real


def flat_rule() -> QuadratureRule:
    """Gauss's rule in t; the node y = I(t; 4, 4), an incomplete beta, is flat at 0 and 1."""
    at, weight = legendre.leggauss(NODES)
    t = 0.5 * (at + 1.0)
    # Near 1 from the distance to 1, or its digits would be lost.
    near_one = np.log1p(-betainc(FLATNESS, FLATNESS, 1.0 - t))
    log_node = np.where(t < 0.5, np.log(betainc(FLATNESS, FLATNESS, t)), near_one)
    log_slope = (FLATNESS - 1) * np.log(t * (1.0 - t)) - betaln(FLATNESS, FLATNESS)
    slope = 0.5 * np.exp(log_slope)
    to_series = (legendre.legvander(at, NODES - 1) * weight[:, None]).T * (
        np.arange(NODES)[:, None] + 0.5
    )
    integrated = np.stack(
        [legendre.legval(at, legendre.legint(one, lbnd=-1)) for one in np.eye(NODES)], axis=1
    )
    up_to = integrated @ to_series * slope
    return QuadratureRule(log_node, weight * slope, up_to, up_to[::-1, ::-1])


RULE = flat_rule()


class Loop(NamedTuple):
    """The falling half of a steady loop at the nodes of both halves of z.

    Attributes
    ----------
    depth : ndarray, shape (..., 1)
        -ln(1 - Z^n) / n: how far the tip has yielded; finite where Z is 1 but for less than
        rounding.
    log_z, unloading, regular, log_part : ndarray, shape (..., q)
        ln |z| at the nodes, the integrands of the way on either side of z = 0, less the part of the
        second that is integrated by hand, and that part.
    share : ndarray, shape (..., 1, q)
        Weight of each node in an integral over z.
    cosine, sine : ndarray, shape (..., 2, q)
        Displacement over its amplitude, and the root of one minus its square.
    """

    depth: Any
    log_z: Any
    unloading: Any
    regular: Any
    log_part: Any
    share: Any
    cosine: Any
    sine: Any


def loop(reach: Any, n: Any, turn: Any) -> Loop:
    """The steady loop.

    Parameters
    ----------
    reach : ndarray, shape (..., 1)
        k X / F, the amplitude over the displacement at which a bilinear spring would yield.
    n, turn : ndarray, shape (..., 1)
        Sharpness of the yielding, and 2 beta - 1.
    """
    depth = _depth(reach, n, turn)
    log_z, unloading, regular = _integrands(depth, n, turn)
    log_part = -np.log(-np.expm1(n * log_z)) / n
    whole = (unloading @ RULE.weight)[..., None]
    way = np.stack([unloading @ RULE.beyond.T, whole + log_part + regular @ RULE.up_to.T], axis=-2)
    # From the tip on, over the amplitude: 0 at one tip and 2 at the other.
    way = way / reach[..., None]
    # The nodes next to the tips, whose weights are next to nothing, may lie beyond them by the
    # rule's error.
    room = way * (2.0 - way)
    room = np.where(np.real(room) > 0.0, room, 0.0)
    share = (np.exp(_log_tip(depth, n)) * RULE.weight)[..., None, :]
    return Loop(depth, log_z, unloading, regular, log_part, share, 1.0 - way, np.sqrt(room))


def _log_tip(depth: Any, n: Any) -> Any:
    return np.log(-np.expm1(-n * depth)) / n


def _integrands(depth: Any, n: Any, turn: Any) -> tuple[Any, Any, Any]:
    """The logarithm of z at the nodes, Z / (1 + turn z^n) and Z (1 - z^(n-1)) / (1 - z^n)."""
    log_tip = _log_tip(depth, n)
    # In logarithms, as Z is one but for less than rounding where the element slides nearly all the
    # way.
    log_z, tip = log_tip + RULE.log_node, np.exp(log_tip)
    unloading = tip / (1.0 + turn * np.exp(n * log_z))
    return log_z, unloading, tip * np.expm1((n - 1.0) * log_z) / np.expm1(n * log_z)


def _depth(reach: Any, n: Any, turn: Any) -> Any:
    """How far the tip has yielded.

    Newton's method in the logarithms of both sides, which are nearly straight.
    """
    log_goal = np.log(2.0 * reach)
    # Of a tip that hardly yields, and of one that slides nearly all the way.
    log_depth = np.minimum(n * np.log(reach) - np.log(n), log_goal)
    # A fixed number of steps, so that all loops go side by side and none waits for a slower one.
    for _ in range(NEWTON_STEPS):
        depth = np.exp(log_depth)
        _, unloading, regular = _integrands(depth, n, turn)
        way = depth + ((unloading + regular) @ RULE.weight)[..., None]
        log_tip, rest = _log_tip(depth, n), np.exp(-n * depth)
        growth = np.exp((1.0 - n) * log_tip) * (1.0 + rest / (1.0 + turn * (1.0 - rest)))
        log_depth = log_depth - (np.log(way) - log_goal) * way / (depth * growth)
    return np.exp(log_depth)


def first_over(reach: Any, n: Any, turn: Any) -> Any:
    """First harmonic over k X, shape (1, ...)."""
    return _first(loop(reach[..., None], n[..., None], turn[..., None]), reach)[None]


def _first(cycle: Loop, reach: Any) -> Any:
    turned = cycle.sine + 1j * cycle.cosine
    return 2.0 / (np.pi * reach) * np.sum(cycle.share * turned, axis=(-2, -1))


def third_over(reach: Any, n: Any, turn: Any) -> Any:
    """Third harmonic over k X, shape (1, ...)."""
    cycle = loop(reach[..., None], n[..., None], turn[..., None])
    turned = (cycle.cosine - 1j * cycle.sine) ** 3
    third = 2j / (3.0 * np.pi * reach) * np.sum(cycle.share * turned, axis=(-2, -1))
    return third[None]


def first_and_slopes(reach: Any, n: Any, turn: Any) -> Any:
    """First harmonic over k X and its derivatives by the three arguments, shape (4, ...).

    They are those of the sums, term by term, so that they belong to the value to rounding.
    """
    a, n, turn = (each[..., None] for each in (reach, n, turn))
    cycle = loop(a, n, turn)
    log_z, power = cycle.log_z, np.exp(n * cycle.log_z)
    # z^n - 1 by expm1: near the tips it is a small difference of nearly equal numbers.
    tip, lost = np.exp(_log_tip(cycle.depth, n)), np.expm1(n * cycle.log_z)
    # Of the integrands and the part done by hand: by ln Z, by n and by the turn.
    slip = cycle.unloading**2 / tip * power
    lower = np.exp((n - 1.0) * log_z)
    # The quotient rule for (1 - z^(n-1)) / (1 - z^n), by ln z.
    above, below = (n - 1.0) * lower * lost, n * np.expm1((n - 1.0) * log_z) * power
    bend = tip * (above - below) / lost**2
    unloading = (cycle.unloading - n * turn * slip, -turn * log_z * slip, -slip)
    regular = (cycle.regular + bend, tip * log_z * lower * np.expm1(log_z) / lost**2, 0.0 * slip)
    by_hand = (-power / lost, -(cycle.log_part + log_z * power / lost) / n, 0.0 * slip)
    # How the tip moves, so that the way from tip to tip stays 2 k X / F.
    odds = 1.0 / np.expm1(np.minimum(n * cycle.depth, FURTHEST))
    pull = [((u + r) @ RULE.weight)[..., None] for u, r in zip(unloading, regular, strict=True)]
    tip_by_n = (cycle.depth * odds - np.log(tip)) / n
    drive = (2.0 + 0.0 * a, -(pull[1] + pull[0] * tip_by_n), -pull[2])
    # By the reach, n and the turn: what each moves by itself, beside what follows from the tip.
    tip_alone = (0.0, tip_by_n, 0.0)
    start_alone = (1.0 - cycle.cosine, 0.0, 0.0)
    slopes = []
    for i, own in enumerate(drive):
        log_tip = odds * own / (1.0 + odds * pull[0]) + tip_alone[i]
        alone = [(0.0, *part[1:])[i] for part in (unloading, regular, by_hand)]
        by_tip = [part[0] * log_tip for part in (unloading, regular, by_hand)]
        u, r, h = (moved + still for moved, still in zip(by_tip, alone, strict=True))
        whole = (u @ RULE.weight)[..., None]
        way = np.stack([u @ RULE.beyond.T, whole + h + r @ RULE.up_to.T], axis=-2)
        way = (way - start_alone[i]) / a[..., None]
        # At a tip the sine is zero, and so is the weight of what is divided by it.
        sine = np.divide(
            cycle.cosine * way, cycle.sine, where=cycle.sine != 0.0, out=np.zeros_like(way)
        )
        moved = log_tip[..., None] * (cycle.sine + 1j * cycle.cosine) + sine - 1j * way
        slopes.append(2.0 / (np.pi * reach) * np.sum(cycle.share * moved, axis=(-2, -1)))
    first = _first(cycle, reach)
    return np.stack([first, slopes[0] - first / reach, slopes[1], slopes[2]])


def _in_blocks(function: Any, arguments: tuple[Any, ...]) -> Any:
    """`function` of arguments that broadcast, a block of loops after the other."""
    shape = np.broadcast_shapes(*(np.shape(each) for each in arguments))
    # All loops in one row, however theta and points are nested.
    flat = [np.broadcast_to(each, shape).ravel() for each in arguments]
    count = max(1, -(-len(flat[0]) // BLOCK))
    parts = zip(*(np.array_split(each, count) for each in flat), strict=True)
    together = np.concatenate([function(*part) for part in parts], axis=-1)
    return together.reshape((*together.shape[:-1], *shape))


class Ways(NamedTuple):
    """The way to a force and back, by q: z where it is negative, else -ln(1 - z).

    Along one straight way of any course the force z, counted in the direction of the motion, goes
    as dz / da = g(z) with a = k |x| / F. Here g is 1 - z^n where the force holds against the motion
    and 1 + (2 beta - 1) |z|^n where it goes with it, so that the way from nothing to z is one
    function Phi(z), the integral of 1/g: z follows from Phi's inverse, and its derivatives by n and
    beta from those of Phi.

    Attributes
    ----------
    way, place : CubicHermiteSpline
        Phi by q, and q by Phi.
    by_n, by_beta : CubicHermiteSpline
        Derivatives of Phi at the same z, by q.
    single : tuple of OneByOne
        All four, for one number at a time.
    """

    way: CubicHermiteSpline
    place: CubicHermiteSpline
    by_n: CubicHermiteSpline
    by_beta: CubicHermiteSpline
    single: tuple[OneByOne, ...]


class OneByOne(NamedTuple):
    """A cubic spline for one number at a time, for which a call of SciPy's takes 7 times as long.

    Attributes
    ----------
    ends : list of float
        Of its m pieces.
    pieces : list of lists
        Four coefficients of each, the highest power first.
    """

    ends: list[float]
    pieces: list[list[float]]

    def __call__(self, at: float) -> float:
        """The value at one place."""
        i = min(max(bisect(self.ends, at) - 1, 0), len(self.pieces) - 1)
        a, b, c, d = self.pieces[i]
        on = at - self.ends[i]
        return ((a * on + b) * on + c) * on + d


def _slopes(q: Real, n: float, beta: float) -> tuple[Real, Real, Real, Real]:
    """1/g, the derivatives of that by n and beta, and dz / dq."""
    ahead = q > 0.0
    size = np.where(ahead, -np.expm1(-np.abs(q)), np.abs(q))
    log_size = np.log(np.maximum(size, SMALLEST))
    power = np.exp(n * log_size)
    share = np.where(ahead, -1.0, 2.0 * beta - 1.0)
    g = np.where(ahead, -np.expm1(n * log_size), 1.0 + share * power)
    g = np.maximum(g, SMALLEST)
    by_n = -share * power * log_size / g**2
    by_beta = np.where(ahead, 0.0, -2.0 * power / g**2)
    return 1.0 / g, by_n, by_beta, np.where(ahead, np.exp(-np.abs(q)), 1.0)


@lru_cache(maxsize=8)
def ways(n: float, beta: float) -> Ways:
    """Phi and its derivatives for one sharpness and one hysteretic share."""
    # Late: it takes a sixth of a second to load, and nothing else of this file needs it.
    from scipy.interpolate import CubicHermiteSpline

    nodes, weights = legendre.leggauss(5)
    # Finer towards no force, where z^n has a kink: the cubics are good to 1e-6 for n from 0.5 to 8.
    graded = np.linspace(0.0, 1.0, 161) ** FLATNESS
    q = np.concatenate([-graded[::-1], ENDLESS * graded[1:]])
    half = 0.5 * np.diff(q)
    inner = q[:-1, None] + half[:, None] * (1.0 + nodes)
    *slopes, stretch = _slopes(inner, n, beta)
    *ends, at_ends = _slopes(q, n, beta)
    splines = []
    for each, end in zip(slopes, ends, strict=True):
        cells = ((each * stretch) @ weights) * half
        value = np.concatenate([[0.0], np.cumsum(cells)])
        splines.append((value - value[len(graded) - 1], end * at_ends))
    (way, rate), by_n, by_beta = splines
    found = (
        CubicHermiteSpline(q, way, rate),
        CubicHermiteSpline(way, q, 1.0 / rate),
        CubicHermiteSpline(q, *by_n),
        CubicHermiteSpline(q, *by_beta),
    )
    return Ways(*found, tuple(OneByOne(each.x.tolist(), each.c.T.tolist()) for each in found))


def yielding_force(
    x: Real, k: float, force: float, n: float, beta: float
) -> tuple[Real, tuple[Real, ...]]:
    """The force (m,) of the element that was at rest at x[0], and its derivatives by all four.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology.hysteresis import yielding_force
    >>> value, _ = yielding_force(np.array([0.0, 1e-3, 9.0, 8.999]), 5.0, 1.0, 1.0, 0.5)
    >>> value.round(4)
    array([0.   , 0.005, 1.   , 0.995])
    """
    theta, table = (k, force, n, beta), ways(n, beta)
    if len(x) < 2:
        return np.zeros(len(x)), tuple(np.zeros((4, len(x))))
    steps = np.diff(x)
    begins, ends = np.array(_ways_of(np.sign(steps))).T
    gone = np.concatenate([[0.0], np.cumsum(np.abs(steps))])
    net = np.concatenate([[0.0], np.cumsum(np.sign(steps))])
    signs = np.where(net[ends] > net[begins], 1.0, -1.0)
    before, by_before = _at_turns(table, signs, gone[ends] - gone[begins], theta)
    which = np.repeat(np.arange(len(begins)), ends - begins)
    way = gone[1:] - gone[begins][which]
    z, by = np.zeros(len(x)), np.zeros((4, len(x)))
    z[1:], by[:, 1:] = _along(table, signs, before, by_before, which, way, theta)
    return force * z, (force * by[0], z + force * by[1], force * by[2], force * by[3])


def yielding_step(
    before: float, way: float, k: float, force: float, n: float, beta: float
) -> float:
    """The force after one more straight way."""
    sign = -1.0 if way < 0.0 else 1.0
    theta, table = (k, force, n, beta), ways(n, beta)
    z, _ = _after(table, sign, before / force, (0.0,) * 4, abs(way), theta)
    return force * z


def _ways_of(directions: Real) -> list[tuple[int, int]]:
    """First and last knot of each way in one direction; where it rests, it goes on as it went."""
    moving = np.flatnonzero(directions)
    turns = moving[1:][directions[moving[1:]] != directions[moving[:-1]]]
    ends = [0, *turns.tolist(), len(directions)]
    return list(pairwise(ends))


def _at_turns(table: Ways, signs: Real, lengths: Real, theta: Shape) -> tuple[Real, Real]:
    """The force over F (w,) where each way begins, and its derivatives (4, w).

    One way after the other, since each begins where the one before has led: a noisy record turns at
    every other sample.
    """
    z, found = 0.0, []
    by: tuple[float, ...] = (0.0,) * 4
    for sign, length in zip(signs.tolist(), lengths.tolist(), strict=True):
        found.append((z, *by))
        z, by = _after(table, sign, z, by, length, theta)
    at = np.array(found).T
    return at[0], at[1:]


def _after(
    table: Ways, sign: float, z: float, by: Sequence[float], length: float, theta: Shape
) -> tuple[float, tuple[float, ...]]:
    """The force over F after a whole way, and its derivatives by all four parameters: `_along`."""
    k, force, n, beta = theta
    way, place, by_n, by_beta = table.single
    start = sign * z
    begin = start if start < 0.0 else min(-log1p(-min(start, 1.0 - SMALLEST)), ENDLESS)
    reached = min(way(begin) + k * length / force, place.ends[-1])
    q = min(max(place(reached), -1.0), ENDLESS)
    slow, slower = _one_over_g(begin, n, beta), _one_over_g(q, n, beta)
    changes = (length / force, -k * length / force**2, by_n(begin) - by_n(q))
    moved = (*changes, by_beta(begin) - by_beta(q))
    ended = -expm1(-q) if q > 0.0 else q
    return sign * ended, tuple(
        (each * slow + sign * more) / slower for each, more in zip(by, moved, strict=True)
    )


def _one_over_g(q: float, n: float, beta: float) -> float:
    """The first of `_slopes`."""
    if q > 0.0:
        g = -expm1(n * log(max(-expm1(-q), SMALLEST)))
    else:
        g = 1.0 + (2.0 * beta - 1.0) * exp(n * log(max(-q, SMALLEST)))
    return 1.0 / max(g, SMALLEST)


def _along(
    table: Ways,
    signs: Real,
    before: Real,
    by_before: Real,
    which: NDArray[np.intp],
    way: Real,
    theta: Shape,
) -> tuple[Real, Real]:
    """The force over F (m,) along ways, and its derivatives (4, m) by all four parameters.

    Each of the samples lies on one of the ways (w,), so far from where that begins.
    """
    k, force, n, beta = theta
    start = signs * before
    turned = -np.log1p(-np.clip(start, 0.0, 1.0 - SMALLEST))
    begin = np.where(start < 0.0, start, np.minimum(turned, ENDLESS))
    reached = table.way(begin)[which] + k * way / force
    q = np.clip(table.place(np.minimum(reached, table.place.x[-1])), -1.0, ENDLESS)
    z = np.where(q > 0.0, -np.expm1(-np.maximum(q, 0.0)), q)
    moved = (signs * by_before * _slopes(begin, n, beta)[0])[:, which]
    moved[0] += way / force
    moved[1] -= k * way / force**2
    moved[2] -= table.by_n(q) - table.by_n(begin)[which]
    moved[3] -= table.by_beta(q) - table.by_beta(begin)[which]
    sign = signs[which]
    return sign * z, sign * moved / _slopes(q, n, beta)[0]


@dataclass(frozen=True)
class Hysteresis(Node):
    """A spring that yields gradually: its first harmonic, exact for a sinusoidal displacement.

    Parameters
    ----------
    free : tuple of Parameter
        Stiffness k, yield force F, sharpness n and share beta.
    """

    free: tuple[Parameter, ...]
    kind: str = "hysteresis"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """k, F, n and beta."""
        return self.free

    @property
    def needs(self) -> frozenset[str]:
        """The amplitude."""
        return frozenset(NEEDS_AMPLITUDE)

    @staticmethod
    def in_time(
        t: Real, x: Real, v: Real, k: float, force: float, n: float, beta: float
    ) -> tuple[Real, tuple[Real, ...]]:
        """Force (n,) and its derivatives for any history, from rest; see `Formula`."""
        return yielding_force(x, k, force, n, beta)

    @staticmethod
    def step(before: float, way: float, k: float, force: float, n: float, beta: float) -> float:
        """The force after one more straight way; see `Formula`."""
        return yielding_step(before, way, k, force, n, beta)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K, the same at all frequencies.

        It is worked out once for each amplitude that was measured.
        """
        # The element knows no rate: points of one amplitude share their loop.
        amplitude, which = np.unique(at.need("amplitude"), return_inverse=True)
        k, force, n, beta = (theta[..., i : i + 1] for i in range(4))
        reach, turn = k * amplitude / force, 2.0 * beta - 1.0
        if depth == VALUE:
            return Response(k * _in_blocks(first_over, (reach, n, turn))[0][..., which])
        first, by_reach, by_n, by_turn = _in_blocks(first_and_slopes, (reach, n, turn))
        slopes = [
            first + reach * by_reach,
            -k * reach / force * by_reach,
            k * by_n,
            2.0 * k * by_turn,
        ]
        value = (k * first)[..., which]
        return Response(value, np.stack(slopes, axis=-2)[..., which], np.zeros_like(value))

    def third_harmonic(self, theta: Real, at: Points) -> Complex:
        """Third harmonic of the force over the displacement amplitude, shape (..., n)."""
        k, force, n, beta = (theta[..., i : i + 1] for i in range(4))
        reach = k * at.need("amplitude") / force
        third: Complex = k * _in_blocks(third_over, (reach, n, 2.0 * beta - 1.0))[0]
        return third


def smooth_hysteresis(
    k: str = "k", force: str = "F", n: str = "n", beta: str = "beta"
) -> Hysteresis:
    """A Bouc-Wen element.

    Stiffness k, yield force F, sharpness n (large: bilinear) and hysteretic share beta.

    beta = 1 with n = 1 is Dahl's friction (1976, doi:10.2514/3.61511), beta = 1/2 unloads with the
    stiffness k; below 1/2 the element could give back more energy than it took (Erlicher and Point
    2004, doi:10.1016/j.crme.2003.10.009), which is fitted to data none the less.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, smooth_hysteresis
    >>> at = Points.at([1.0, 1.0], amplitude=[0.001, 10.0])
    >>> np.abs(smooth_hysteresis().respond(np.array([5.0, 1.0, 1.0, 0.5]), at).value).round(2)
    array([4.99, 0.13])
    """
    free = (
        stiffness(k),
        Parameter(force, "F", FORCE),
        Parameter(n, "n", PURE, 0.5, 8.0, "linear", 1.0),
        Parameter(beta, "β", PURE, 0.1, 1.5, "linear", 0.5),
    )
    return Hysteresis(free)


STAGE = 1.0 - sqrt(0.5)
"""Coefficient of Alexander's two implicit stages (1977, doi:10.1137/0714068).

They are of second order and damp whatever is fast.
"""
BALANCED = balanced_series(spring("k"), slip_film("F", "a"))


def _first_harmonic(at: Points, k: Any, force: Any, exponent: Any) -> Any:
    theta = np.concatenate(np.broadcast_arrays(k, force, exponent), axis=-1)
    response = BALANCED.respond(theta, at, FULL)
    return response.value, np.moveaxis(response.by_theta, -2, 0), response.by_log_omega


def _in_time(
    t: Real, x: Real, v: Real, k: float, force: float, exponent: float
) -> tuple[Real, tuple[Real, ...]]:
    """The force z of z' = k (v - sgn(z) |z / F|^(1/a)) from rest, and its derivatives."""
    power, steps = 1.0 / exponent, np.diff(t)
    speed, held, rest = np.diff(x) / steps, STAGE * steps, (1.0 - STAGE) * steps
    z = _stages(speed, held * k, rest * k, force, power)
    flow, slope, bend = _flow(z, force, power)
    # Of the rate by k, by F and by a, the force being what it is.
    direct = np.stack([speed - flow, k * power * flow / force, k * power**2 * bend])
    whole = 1.0 + held * k * slope
    # The second stage ends the step, and stands on the rates of the first: a line in what was
    # before.
    kept = (1.0 - rest * k * slope[0] / whole[0]) / whole[1]
    added = (rest * direct[:, 0] / whole[0] + held * direct[:, 1]) / whole[1]
    moved = [
        list(accumulate(zip(kept.tolist(), each.tolist(), strict=True), _on_the_line, initial=0.0))
        for each in added
    ]
    return np.append(0.0, z[1]), tuple(np.array(moved))


def _flow(z: Real, force: float, power: float) -> tuple[Real, Real, Real]:
    """Speeds at which forces z flow, and their slopes by z and by the power 1 / a."""
    size = np.abs(z) / force
    speed = np.sign(z) * size**power
    # Of no force at all the speed is nothing, whatever the power.
    bend = speed * np.log(np.maximum(size, SMALLEST))
    return speed, power * size ** (power - 1.0) / force, bend


def _on_the_line(before: float, line: tuple[float, float]) -> float:
    return line[0] * before + line[1]


def _stages(speed: Real, held: Real, rest: Real, force: float, power: float) -> Real:
    """The force at both stages (2, n) of each step."""
    z, stages = 0.0, []
    for v, share, more in zip(speed.tolist(), held.tolist(), rest.tolist(), strict=True):
        first = _flowed(z + share * v, share, force, power)
        rate = v - copysign((abs(first) / force) ** power, first)
        z = _flowed(z + more * rate + share * v, share, force, power)
        stages.append((first, z))
    return np.array(stages).reshape(-1, 2).T


def _flowed(free: float, share: float, force: float, power: float) -> float:
    """The force z of z + share * flow(z) = free, by Halley's method, which spares powers."""
    size = abs(free)
    if size == 0.0:
        return 0.0
    # Either term alone is at most all: the smaller of both ends is just beyond the solution.
    z: float = min(size, force * (size / share) ** (1.0 / power))
    # Of forces smaller than any number of full digits none is left.
    if z < SMALLEST:
        return 0.0
    for _ in range(MOST_STEPS):
        flow = share * (z / force) ** power / size
        # As shares of all, whose squares are numbers; the slope and the bend are those of z times
        # it and its square.
        off, slope, bend = (
            z / size + flow - 1.0,
            z / size + power * flow,
            power * (power - 1.0) * flow,
        )
        change = 2.0 * off * slope / (2.0 * slope * slope - off * bend)
        z -= change * z
        # By so much the flow has changed, and what is left goes as its cube.
        if abs(power * change) ** 3 <= ROUNDING:
            break
    return copysign(z, free)


def yielding_spring(k: str = "k", force: str = "F", exponent: str = "a") -> Formula:
    """A spring before a damper of force F |v|^a: elastic below a force, flowing above it.

    The smaller a, the sharper it yields and the flatter its force lies over the speed; F is the
    force at a speed of one amplitude unit per second. In frequency by the balance of the first
    harmonics, which is up to a tenth off at a = 0.3, and a fifth at 0.1.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, yielding_spring
    >>> at = Points.at([1.0, 1.0], amplitude=[0.001, 10.0])
    >>> yielding_spring().respond(np.array([5.0, 1.0, 0.2]), at).value.round(2)
    array([5.  +0.j  , 0.01+0.19j])
    """
    free = (
        stiffness(k),
        Parameter(force, "F", FORCE),
        Parameter(exponent, "a", PURE, 0.05, 1.0, "linear", 0.3),
    )
    return Formula(
        free,
        _first_harmonic,
        NEEDS_AMPLITUDE,
        "yielding spring",
        in_time=_in_time,
        flows=True,
    )
