"""Starts read off the data, for any network: a scan of its shapes by variable projection.

A network is linear in the gain of each branch of its outermost composition: stiffnesses of parallel
branches add, compliances of branches in series add. So only the shapes need a search, the gains
being projected out (G. H. Golub and V. Pereyra, 1973, doi:10.1137/0710036; the Jacobian is that of
L. Kaufman, 1975, doi:10.1007/BF01932995).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.measurement import Measurement
from springpot.numerics import AT_ONCE, ROUNDING, SMALLEST
from springpot.rheology.nodes import GRADIENT, Chain, Node, Parallel, Renamed, Series, Shift
from springpot.rheology.parameters import Coordinates, Parameter
from springpot.rheology.points import Complex, Points, Real

if TYPE_CHECKING:
    from springpot.rheology.model import Model

LEAST_GAIN = 1e-7
"""Smallest share of the data that a branch is given; a logarithm cannot start at zero."""


@dataclass(frozen=True, eq=False)
class Branches:
    """The branches of a network's outermost composition.

    Parameters
    ----------
    compliance : bool
        Whether their compliances add, rather than their stiffnesses.
    gains : ndarray, shape (m, p)
        Power of stiffness of each parameter, in the row of the branch it belongs to.
    owner : ndarray of int, shape (p,)
        Branch of each parameter, or -1 for those of the measurement chain or of a frequency shift.
    """

    compliance: bool
    gains: Real
    owner: NDArray[np.intp]

    @classmethod
    def of(cls, network: Node) -> Branches:
        """The branches of `network`, seen through measurement chain and frequency shift."""
        powers = np.array([float(p.unit.stiffness) for p in network.parameters])
        node = network
        while isinstance(node, Renamed | Chain | Shift):
            # Chains and shifts act on the whole: the sum of branches stands inside them, as the
            # first child.
            if isinstance(node, Renamed):
                node = node.node
            else:
                node = node.children[0]
        if isinstance(node, Parallel | Series):
            sizes = [len(child.parameters) for child in node.children]
            owner = np.full(len(powers), -1)
            owner[: sum(sizes)] = np.repeat(np.arange(len(sizes)), sizes)
            gains = np.where(owner == np.arange(len(sizes))[:, None], powers, 0.0)
            if np.all(np.any(gains != 0.0, axis=1)):
                return cls(isinstance(node, Series), gains, owner)
        # No sum, or a branch without a stiffness to scale it by: then the network has one gain as a
        # whole.
        return cls(False, powers[None, :], np.zeros(len(powers), dtype=np.intp))

    @cached_property
    def leaders(self) -> NDArray[np.intp]:
        """The first stiffness of each branch, which its gain stands for."""
        scaled = self.gains != 0.0
        leaders: NDArray[np.intp] = np.argmax(scaled, axis=1)[np.any(scaled, axis=1)]
        return leaders

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """The other parameters, which give the branches their shapes."""
        return np.setdiff1d(np.arange(len(self.owner)), self.leaders)

    @cached_property
    def _steps(self) -> Real:
        """Derivative of ln theta by the logarithm of the leader of its branch, shape (m, p)."""
        if not len(self.leaders):
            return self.gains
        return self.gains / self.gains[np.arange(len(self.gains)), self.leaders][:, None]

    def shaped(self, v: Real, log: NDArray[np.bool_]) -> Real:
        """Search coordinates (..., p) of shapes (..., d) at unit gain."""
        base = np.zeros(len(log))
        base[self.leaders] = ~log[self.leaders]
        u: Real = np.matmul(v, self._places) + base
        return u

    @cached_property
    def _places(self) -> Real:
        """Where the shape coordinates go, shape (d, p)."""
        return np.eye(len(self.owner))[self.free]

    def shape(self, u: Real, log: NDArray[np.bool_]) -> Real:
        """Shapes (..., d) of search coordinates (..., p)."""
        if not len(self.leaders):
            return u
        led = np.where(log[self.leaders], u[..., self.leaders], 0.0)
        return self._moved(u, np.matmul(-led, self._steps), log)[..., self.free]

    def scaled(self, u: Real, log_gain: Real, log: NDArray[np.bool_]) -> Real:
        """Search coordinates (..., p) with the branches' gains (..., m) multiplied in."""
        return self._moved(u, np.matmul(log_gain, self.gains), log)

    def _moved(self, u: Real, change: Real, log: NDArray[np.bool_]) -> Real:
        # The exponent is zero where it is not asked for: it could overflow there.
        return np.where(log, u + change, u * np.exp(np.where(log, 0.0, change)))

    def shares(self, theta: Real, value: Complex, by_theta: Complex) -> Complex:
        """What each branch adds to K, or to 1/K, shape (r, m, n).

        K is homogeneous of degree one in the stiffnesses, so that by Euler's theorem a branch's
        share of it is the derivative by the logarithm of the branch's gain.
        """
        shares: Complex = np.matmul(self.gains * theta[:, None, :], by_theta)
        if self.compliance:
            shares /= (value * value)[:, None, :]
        return shares


@lru_cache(maxsize=128)
def branches_of(model: Model) -> Branches:
    """The branches of a model's network, found once."""
    return Branches.of(model.network)


def interleaved(values: Complex) -> Real:
    """Real and imaginary parts in turn along the last axis."""
    return np.ascontiguousarray(values).view(np.float64)


def plane_data(stiffness: Complex, weights: Complex, compliance: bool) -> tuple[Real, Real]:
    """Data and weights (B, 2n) in the plane in which the branches add."""
    if not compliance:
        return interleaved(stiffness), interleaved(weights)
    # 1/K mixes the parts of K, so both get the mean of their weights; d(1/K) = -dK / K^2.
    size = np.abs(weights) * np.abs(stiffness) ** 2 / np.sqrt(2.0)
    return interleaved(1.0 / stiffness), np.repeat(size, 2, axis=-1)


def non_negative(matrix: Real, right: Real) -> tuple[Real, Real]:
    """Minimise x M x - 2 b x with every x at least `LEAST_GAIN`.

    Parameters
    ----------
    matrix : ndarray, shape (..., m, m)
        M, with a unit diagonal.
    right : ndarray, shape (..., m)
        b.

    Returns
    -------
    x : ndarray, shape (..., m)
        The minimum.
    inverse : ndarray, shape (..., m, m)
        Inverse of M among those x that are not held at the least value, zero elsewhere.
    """
    inverse = _inverse(matrix)
    x: Real = np.matmul(inverse, right[..., None])[..., 0]
    # Mostly all gains are positive at once; only the others need a search for those to be held.
    wrong = (x < LEAST_GAIN).any(axis=-1)
    if wrong.any():
        x[wrong], inverse[wrong] = _held(matrix[wrong], right[wrong], x[wrong])
    return x, inverse


def _held(matrix: Real, right: Real, x: Real) -> tuple[Real, Real]:
    """The same for those (r, m) of which some x have to be held at the least.

    All that are on the wrong side change it at once, until none is (block pivoting: Portugal,
    Júdice and Vicente 1994, doi:10.1090/S0025-5718-1994-1250776-4); where that goes round in
    circles the last of them alone, which never does.
    """
    free, unit, m = x >= LEAST_GAIN, np.eye(x.shape[-1]), x.shape[-1]
    for turn in range(3 * m):
        inner = free[:, :, None] & free[:, None, :]
        inverse = np.where(inner, _inverse(np.where(inner, matrix, unit)), 0.0)
        least = np.where(free, 0.0, LEAST_GAIN)
        x = least + _times(inverse, right - _times(matrix, least))
        wrong = np.where(free, x < LEAST_GAIN, right - _times(matrix, x) > ROUNDING)
        if not wrong.any():
            break
        if turn >= m:
            wrong &= np.cumsum(wrong[:, ::-1], axis=1)[:, ::-1] == 1
        free = free ^ wrong
    return np.maximum(x, LEAST_GAIN), inverse


def _times(matrix: Real, x: Real) -> Real:
    """Products of matrices (r, m, m) and vectors (r, m)."""
    product: Real = np.matmul(matrix, x[..., None])[..., 0]
    return product


def _inverse(matrix: Real) -> Real:
    """Inverse of matrices with a unit diagonal."""
    m = matrix.shape[-1]
    if m == 1:
        return np.ones_like(matrix)
    if m > 2:
        try:
            # Branches of nearly one shape: so little on the unit diagonal is no more than rounding.
            return np.asarray(np.linalg.inv(matrix + 1e-15 * np.eye(m)), dtype=float)
        except np.linalg.LinAlgError:  # two branches of one shape
            return np.asarray(np.linalg.inv(matrix + 1e-11 * np.eye(m)), dtype=float)
    inverse = np.empty_like(matrix)
    # Of two branches the inverse is a formula.
    off = matrix[..., 0, 1]
    inverse[..., 0, 0] = inverse[..., 1, 1] = 1.0 / (1.0 - off * off + 1e-15)
    inverse[..., 0, 1] = inverse[..., 1, 0] = -off * inverse[..., 0, 0]
    return inverse


def project(shares: Real, target: Real) -> tuple[Real, Real, Real]:
    """Non-negative gains that bring the weighted shares closest to the weighted target.

    The shares are (r, m, q), the target is (r or 1, q).

    Returns
    -------
    gains : ndarray, shape (r, m)
        Their gains.
    residual : ndarray, shape (r, q)
        What is left.
    inverse : ndarray, shape (r, m, m)
        Inverse of the Gram matrix of the shares whose gains are not held at their least value.
    """
    # Normal equations of a few branches: what they lose in digits the descent in all parameters
    # brings back.
    gram = np.matmul(shares, shares.transpose(0, 2, 1))
    m = gram.shape[-1]
    # All columns and the target get length one, so that the least gain is a share of the data.
    unit = 1.0 / np.sqrt(gram.reshape(-1, m * m)[:, :: m + 1] + SMALLEST)
    units = unit[:, :, None] * unit[:, None, :]
    size = np.sqrt((target * target).sum(axis=1, keepdims=True))
    right = np.matmul(shares, target[:, :, None])[:, :, 0] * unit
    x, inverse = non_negative(gram * units, right / size)
    gains = x * size * unit
    residual = np.matmul(gains[:, None, :], shares)[:, 0] - target
    return gains, residual, inverse * units


SHAPES = (1, 16, 64, 192, 320)
"""Shapes scanned for 0, 1, 2, 3 and more free parameters of shape."""
NEIGHBOURS = 4
"""Nearest shapes that a shape must beat to come first: so the starts lie in different valleys."""


def low_discrepancy(count: int, dimension: int, offset: Real | float = 0.0) -> Real:
    """Points (count, dimension) that fill the unit cube evenly.

    Multiples of powers of a generalised golden ratio.

    See M. Roberts, The unreasonable effectiveness of quasirandom sequences (2018). `offset` moves
    all (modulo 1).
    """
    # The root of r^(d + 1) = r + 1: each step brings it nearer by a factor of three or more.
    ratio = 2.0
    for _ in range(40):
        ratio = (1.0 + ratio) ** (1.0 / (dimension + 1.0))
    steps = ratio ** -np.arange(1.0, dimension + 1.0)
    return (0.5 + np.arange(1, count + 1)[:, None] * steps + offset) % 1.0


def thinned(log_omega: Real, most: int) -> NDArray[np.intp]:
    """At most `most` rows (and the two ends) spread evenly over the frequencies.

    Whatever the order of conditions.
    """
    n = len(log_omega)
    if n <= most:
        return np.arange(n)
    picks = np.floor(low_discrepancy(most, 1)[:, 0] * n).astype(np.intp)
    # The two ends stay: without them fewer frequencies would be seen than were measured.
    ends = np.array([0, n - 1])
    return np.sort(np.argsort(log_omega, kind="stable")[np.unique(np.concatenate([picks, ends]))])


def shape_count(branches: Branches) -> int:
    """How many shapes are scanned."""
    return SHAPES[min(len(branches.free), len(SHAPES) - 1)]


@dataclass(frozen=True, eq=False)
class Shapes:
    """The scanned shapes of a network.

    Parameters
    ----------
    v : ndarray, shape (Q, d)
        Shape coordinates.
    responses : ndarray, shape (m, Q, 2n)
        What each branch adds at unit gain, real and imaginary parts interleaved.
    compliance : bool
        Whether compliances add.
    neighbours : ndarray of int, shape (Q, j)
        The nearest other shapes of each.
    """

    v: Real
    responses: Real
    compliance: bool
    neighbours: NDArray[np.intp]

    @classmethod
    def of(
        cls,
        network: Node,
        branches: Branches,
        points: Points,
        coordinates: Coordinates,
        offset: float = 0.0,
    ) -> Shapes:
        """Scan the shapes of `network` at `points`."""
        # A shape is the same at any stiffness: the gains are found by linear algebra, for each data
        # set by itself.
        unit = coordinates.at_unit_stiffness()
        # Evenly and not at random: as few shapes as these would else leave gaps.
        cube = low_discrepancy(shape_count(branches), len(branches.free), offset)
        low, high = _spread(unit, points)
        v = low[branches.free] + cube * (high - low)[branches.free]
        with np.errstate(all="ignore"):
            theta = unit.theta(branches.shaped(v, unit.log), unit.size)
            response = network.respond(theta, points, GRADIENT)
            shares = branches.shares(theta, response.value, response.by_theta)
        return cls(
            v, interleaved(np.swapaxes(shares, 0, 1)), branches.compliance, _nearest(*cube.shape)
        )

    def best(self, stiffness: Complex, weights: Complex, keep: int) -> tuple[Real, Real]:
        """The best few shapes for every data set.

        Parameters
        ----------
        stiffness, weights : ndarray of complex, shape (B, n)
            Data and the weights of their real and imaginary parts.
        keep : int
            Shapes wanted.

        Returns
        -------
        v : ndarray, shape (B, s, d)
            Shape coordinates, best first; s is `keep` or the number of shapes if that is less.
        gains : ndarray, shape (B, s, m)
            Gains of the branches at unit stiffness.
        """
        keep = min(keep, len(self.v))
        # In blocks, as Gram matrices of many data sets would not fit into memory at once.
        step = max(1, AT_ONCE // (len(self.v) * len(self.responses) ** 2))
        target, weight = plane_data(stiffness, weights, self.compliance)
        blocks = [slice(i, i + step) for i in range(0, len(stiffness), step)]
        chosen = [self._chosen(target[block], weight[block], keep) for block in blocks]
        if len(chosen) == 1:
            return chosen[0]
        v, gains = (np.concatenate(parts) for parts in zip(*chosen, strict=True))
        return v, gains

    def _chosen(self, target: Real, weight: Real, keep: int) -> tuple[Real, Real]:
        square = weight * weight
        total = (square * target * target).sum(axis=1)
        matrix, right, norm = self._normal(square, square * target)
        # By the size of the data, so that the misfit is a share of them.
        right /= np.sqrt(total)[:, None, None]
        x = non_negative(matrix, right)[0]
        # From the Gram matrix alone: the residuals of every shape at every point need not be
        # formed.
        bent = np.matmul(matrix, x[..., None])[..., 0]
        misfit = 1.0 + (x * (bent - 2.0 * right)).sum(axis=-1)
        chosen = _ranked(np.where(np.isfinite(misfit), misfit, np.inf), self.neighbours, keep)
        gains = (
            np.take_along_axis(x / norm, chosen[:, :, None], axis=1) * np.sqrt(total)[:, None, None]
        )
        return self.v[chosen], gains

    @np.errstate(over="ignore", invalid="ignore")  # shapes beyond what numbers hold are ranked last
    def _normal(self, square: Real, moment: Real) -> tuple[Real, Real, Real]:
        """Gram matrices (B, Q, m, m) of unit diagonal, right sides, norms (B, Q, m) divided out."""
        m = len(self.responses)
        matrix = np.empty((len(square), len(self.v), m, m))
        right = np.empty(matrix.shape[:-1])
        for i, one in enumerate(self.responses):
            right[..., i] = moment @ one.T
            for j, other in enumerate(self.responses[: i + 1]):
                matrix[..., i, j] = matrix[..., j, i] = square @ (one * other).T
        norm = np.sqrt(np.diagonal(matrix, axis1=-2, axis2=-1) + SMALLEST)
        matrix /= norm[..., :, None] * norm[..., None, :]
        return matrix, right / norm, norm


def _spread(unit: Coordinates, points: Points) -> tuple[Real, Real]:
    """Range of each search coordinate over which shapes are drawn."""
    lower, upper = (bound[0] for bound in unit.bounds)
    # Half the band on either side of its middle: a time outside of it would not show.
    reach = 0.5 * float(np.ptp(points.log_omega))
    times = [_time_power(parameter) for parameter in unit.parameters]
    # A stiffness lies within a factor of 30 of |K|; what has a time in its unit may lie anywhere in
    # the band too.
    width = np.log(30.0) + reach * np.minimum(times, 1.0)
    low = np.where(unit.log, np.maximum(lower, -width), np.where(np.isfinite(lower), lower, -1.0))
    high = np.where(unit.log, np.minimum(upper, width), np.where(np.isfinite(upper), upper, 1.0))
    # An order begins a little inside its range: at its ends a springpot is a spring or a dashpot.
    edge = np.where(unit.log, 0.0, 0.03 * (high - low))
    return low + edge, high - edge


def _time_power(parameter: Parameter) -> float:
    time = parameter.unit.time
    # An order that is yet to be found: the middle of what it may be.
    if isinstance(time, str):
        return 0.5
    return abs(time)


class Grid:
    """Points and search coordinates, compared by what they hold.

    So that data sets on one grid share its scan.
    """

    def __init__(self, points: Points, coordinates: Coordinates) -> None:
        self.points = points
        self.coordinates = coordinates
        columns = (points.log_omega, points.amplitude, points.temperature, *points.columns.values())
        # By their bytes, as arrays neither have a hash nor compare as a whole.
        contents: list[bytes | None] = []
        for column in columns:
            if column is None:
                contents.append(None)
            else:
                contents.append(column.tobytes())
        self._key = (
            *contents,
            points.reference_temperature,
            coordinates.log_omega,
            coordinates.amplitude,
        )

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Grid) and self._key == other._key


@lru_cache(maxsize=64)
def shapes_of(model: Model, grid: Grid, offset: float) -> Shapes:
    """The scanned shapes of a model on a grid, evaluated once."""
    return Shapes.of(model.network, branches_of(model), grid.points, grid.coordinates, offset)


@lru_cache(maxsize=64)
def _nearest(count: int, dimension: int) -> NDArray[np.intp]:
    """The nearest shapes of each, (Q, j), on the torus so that an offset changes nothing."""
    if count <= NEIGHBOURS or dimension == 0:
        return np.empty((count, 0), dtype=np.intp)
    # Nearness is told in the cube that the shapes were drawn from: all its sides are alike.
    cube = low_discrepancy(count, dimension)
    gap = np.abs(cube[:, None, :] - cube[None, :, :])
    distance = np.sum(np.minimum(gap, 1.0 - gap) ** 2, axis=-1)
    # The nearest of all is each shape itself.
    return np.argsort(distance, axis=1)[:, 1 : NEIGHBOURS + 1]


def _ranked(misfit: Real, neighbours: NDArray[np.intp], keep: int) -> NDArray[np.intp]:
    """The best shapes, (B, keep), best first.

    Those better than all their neighbours, then the rest.
    """
    key = misfit
    if keep > 1 and neighbours.shape[1]:
        # The misfit is a share of the data: ten more puts a shape behind all that beat their
        # neighbours.
        key = misfit + np.where(misfit <= misfit[:, neighbours].min(axis=-1), 0.0, 10.0)
    best = _lowest(key, keep)
    order = np.argsort(np.take_along_axis(key, best, axis=1), axis=1, kind="stable")
    return np.take_along_axis(best, order, axis=1)


def _lowest(key: Real, keep: int) -> NDArray[np.intp]:
    """Columns (B, keep) of the lowest keys, in any order."""
    if keep >= key.shape[1]:
        return np.argsort(key, axis=1)
    # The few best need not wait until all the others are in order too.
    return np.argpartition(key, keep - 1, axis=1)[:, :keep]


DECADES = 5.0
"""How far below and above the natural size of the data the size of an effect is tried."""
BEYOND = 0.7
"""Decades beyond the measured times and amplitudes to which an effect's own are tried."""
EDGE = 1e-3
"""Share of its range within which a bounded parameter counts as at its bound."""


@dataclass(frozen=True)
class Window:
    """Natural sizes of a measurement.

    Where its stiffness, time and amplitude lie, and how far they reach.
    """

    stiffness: float
    time: float
    amplitude: float
    time_decades: float
    amplitude_decades: float

    @classmethod
    def of(cls, measurement: Measurement) -> Window:
        """The window of a measurement."""
        log_omega = np.log10(measurement.omega)
        amplitude = np.log10(
            np.maximum(measurement.conditions.get("amplitude", np.ones(1)), SMALLEST)
        )
        return cls(
            float(np.exp(np.mean(np.log(measurement.magnitude)))),
            float(10.0 ** -np.mean(log_omega)),
            float(10.0 ** np.mean(amplitude)),
            float(np.ptp(log_omega)),
            float(np.ptp(amplitude)),
        )


def settings(parameters: tuple[Parameter, ...], window: Window, count: int) -> Real:
    """Quasi-random settings (count, q) of an effect's parameters, over all that is physical.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import Window, settings
    >>> effect = springpot.plugins().effect("inertia")
    >>> settings(effect.element.parameters, Window.of(springpot.read("artificial-hidden")), 3).shape
    (3, 1)
    """
    unit = low_discrepancy(count, len(parameters))
    columns: dict[str, Real] = {}
    # Last those whose unit hangs on an order: its value must be there before theirs has a size.
    for u, parameter in sorted(
        zip(unit.T, parameters, strict=True), key=lambda pair: isinstance(pair[1].unit.time, str)
    ):
        columns[parameter.name] = _setting(parameter, u, window, columns)
    grid = np.empty(unit.shape)
    # An effect with a factor for each level has no parameters before it knows the levels.
    for place, parameter in enumerate(parameters):
        grid[:, place] = columns[parameter.name]
    return grid


def _setting(parameter: Parameter, u: Real, window: Window, done: dict[str, Real]) -> Real:
    natural: Real | float = _natural(parameter, window, done.get(str(parameter.unit.time)))
    if parameter.scale == "linear" and parameter.upper < inf and parameter.lower > -inf:
        return parameter.lower + (parameter.upper - parameter.lower) * u
    # What may have either sign has no logarithm: half the settings go to each side, by decades of
    # the size.
    if parameter.scale == "linear":
        sign = np.where(u < 0.5, -1.0, 1.0)
        reach = np.abs(2.0 * u - 1.0)
        return np.clip(
            sign * natural * 10.0 ** (DECADES * (reach - 1.0)), parameter.lower, parameter.upper
        )
    decades = _reach(parameter, window)
    return np.clip(
        natural * 10.0 ** (decades * (2.0 * u - 1.0)),
        max(parameter.lower, SMALLEST),
        parameter.upper,
    )


def _natural(parameter: Parameter, window: Window, order: Real | None = None) -> Any:
    """The size of a parameter in the units of the data; by its order, where it hangs on one."""
    unit = parameter.unit
    size = unit.size(window.stiffness, window.time, window.amplitude, order)
    return size * parameter.typical


def _reach(parameter: Parameter, window: Window) -> float:
    """Decades to either side of the natural size in which a positive parameter is tried."""
    unit = parameter.unit
    # A plugin's may have a power of time that hangs on an order and no stiffness: it may lie as far
    # off.
    if isinstance(unit.time, str):
        return DECADES
    away = 0.5 * abs(unit.time) * window.time_decades
    away += 0.5 * abs(unit.amplitude) * window.amplitude_decades
    if unit.stiffness:
        # So far off that it is small where it does the most, too: as omega^3 that is far from the
        # middle of a wide sweep.
        return max(DECADES, away + 0.5 * DECADES)
    if unit.amplitude or unit.time:
        # A rate lies anywhere between the lowest frequency and amplitude, and the highest.
        return away + BEYOND
    return 1.5


def shown(parameter: Parameter, window: Window) -> tuple[float, float]:
    """Where the data would show a parameter: further off its effect has become a simpler one.

    Parameters
    ----------
    parameter : Parameter
        One of an effect's own.
    window : Window
        Where and how far the data reach.

    Returns
    -------
    tuple of float
        The ends of the range; empty where its unit depends on another parameter.

    Examples
    --------
    >>> from springpot.identification import Window, shown
    >>> from springpot.rheology import relaxation_time
    >>> low, high = shown(relaxation_time(), Window(1.0, 0.1, 1.0, 2.0, 0.0))
    >>> round(low, 4), round(high, 4)
    (0.01, 1.0)
    """
    unit = parameter.unit
    if parameter.scale == "linear":
        room = EDGE * (parameter.upper - parameter.lower)
        return parameter.lower + room, parameter.upper - room
    # Its size hangs on an order that is not known here: nothing is said of it.
    if isinstance(unit.time, str):
        return inf, -inf
    natural = _natural(parameter, window)
    decades = 1.0 + BEYOND
    if not unit.stiffness:
        decades = _reach(parameter, window)
    reach = 10.0 ** (decades - BEYOND)
    return natural / reach, natural * reach
