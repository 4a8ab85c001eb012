"""How measured points scatter.

Their standard deviations, the shapes that noise has, and what rounding adds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from springpot.distributions import chi2_quantile, effective_share
from springpot.errors import DataError
from springpot.rheology.levels import levels_of
from springpot.rheology.points import Complex, Real
from springpot.thresholds import OUTLIERS, SCATTER, SEARCH, VERDICT

from ..numerics import ALIKE, NEGLIGIBLE, SMALLEST, rows_alike
from .instrument import rounding_step
from .measurement import Measurement

Source = Literal["given", "repeats", "estimated"]

LEAST_RELATIVE = 1e-7
"""No measurement scatters less than this share of |K|; smaller differences are arithmetic."""
STUDENT_DOF = 4.0
"""Degrees of freedom of the tails by which shapes are compared.

Outliers count little, and normal noise is still
judged nearly as well as by its own likelihood."""
STUDENT_ROUNDS = 25
"""Rounds of reweighting for a scale: each takes away a fixed share of what is left to go."""
END_LEVELS = (2.0, 4.0, 8.0)
"""Noise at an end of the frequencies or of a condition, or in one sweep, over that elsewhere.

Rigs are weak where forces are small or masses pull.
"""
END_POWERS = (2, 4)
"""How steeply it rises towards the end: over half of the logarithmic range, or over a quarter."""
COHERENCE = "coherence"
"""Column of the coherence gamma^2 between force and displacement, from 0 to 1."""
FLOOR_LEVELS = 2.0 ** np.arange(-2.0, 10.0)
"""Stiffness or force, in units of the least one, at which the floor equals the other noise.

Amplitudes and temperatures together span three decades of force.
"""


class Along(NamedTuple):
    """Noise whose independent parts go along K and across it, as errors of gain and of phase do.

    Attributes
    ----------
    turn : ndarray of complex, shape (n,)
        Unit numbers by which K is turned to the real axis.
    sd : ndarray of complex, shape (n,)
        Standard deviations along K (real part) and across it (imaginary part).
    """

    turn: Complex
    sd: Complex

    @property
    def of_parts(self) -> Complex:
        """Standard deviations (n,) of K' (real part) and of K'' (imaginary part)."""
        return turned_sd(self.sd, np.conj(self.turn))

    def of(self, rows: NDArray[np.bool_]) -> Along:
        """The same for some of the points, (n,)."""
        return Along(self.turn[rows], self.sd[rows])


def turned_sd(sd: Complex, turn: Complex) -> Complex:
    """Standard deviations of both parts of errors (n,) after they are turned by unit numbers."""
    cos, sin = np.abs(turn.real), np.abs(turn.imag)
    real, imag = np.hypot(sd.real * cos, sd.imag * sin), np.hypot(sd.real * sin, sd.imag * cos)
    return np.asarray(real + 1j * imag, dtype=np.complex128)


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard deviations of the measured points, and how well they are known.

    Parameters
    ----------
    sd : ndarray of complex, shape (n,)
        Of K' (real part) and K'' (imaginary part) of each point.
    dof : float
        Degrees of freedom behind their common scale; infinite where it is known.
    source : {"given", "repeats", "estimated"}
        Where they come from.
    doubt : str
        One sentence where the given ones disagree with the data's own scatter.
    along : Along, optional
        Where the noise along K is of another size than that across it: by these it is weighed.
    memory : float
        Correlation of the errors of neighbouring points of a sweep.
    tails : float
        Degrees of freedom of Student's t by which it is spread; endless where it is normal.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.scatter import Noise
    >>> noise = Noise(np.array([0.1 + 0.2j]), np.inf, "given")
    >>> noise.weights, noise.log_likelihood(4.0, 2)
    (array([10.+5.j]), -2.0)
    """

    sd: Complex
    dof: float
    source: Source
    doubt: str = ""
    along: Along | None = None
    memory: float = 0.0
    tails: float = inf

    @classmethod
    def shaped(cls, sd: Complex, turn: Complex | None, dof: float, source: Source) -> Noise:
        """Noise of some deviations (n,) after a `turn` (n,), which may be none."""
        if turn is None:
            return cls(sd, dof, source)
        along = Along(turn, sd)
        return cls(along.of_parts, dof, source, along=along)

    @property
    def overruled(self) -> bool:
        """Whether other standard deviations were given."""
        return self.source == "estimated" and bool(self.doubt)

    @property
    def weights(self) -> Complex:
        """Reciprocal standard deviations, those of differences that were turned by `turn`."""
        return np.asarray(1.0 / self.parts.real + 1.0j / self.parts.imag, dtype=np.complex128)

    @property
    def parts(self) -> Complex:
        """Standard deviations (n,) of the two parts that are independent."""
        return self.sd if self.along is None else self.along.sd

    def of_whitened(self, values: Real) -> Complex:
        """Differences of K (n,) that whitened values (2n,) stand for."""
        n, parts = len(self.sd), self.parts
        back = values[:n] * parts.real + 1j * values[n:] * parts.imag
        return back if self.turn is None else back * np.conj(self.turn)

    @property
    def turn(self) -> Complex | None:
        """Unit numbers (n,) by which differences are multiplied before they are weighed."""
        return None if self.along is None else self.along.turn

    @property
    def worth(self) -> float:
        """Independent numbers that each point is worth where the misfit is slow."""
        return effective_share(self.memory)

    def log_likelihood(self, rss: float, size: float) -> float:
        """Log-likelihood of a whitened residual sum of squares.

        An unknown scale is integrated or profiled out.
        """
        rss, size = self.worth * rss, self.worth * size
        if self.dof == inf:
            return -0.5 * rss
        # The scale integrated out: a normal whose variance is estimated with so many degrees of
        # freedom is a Student's t.
        if self.source == "repeats":
            return -0.5 * (self.dof + size) * float(np.log1p(rss / self.dof))
        return -0.5 * size * float(np.log(max(rss, SMALLEST)))

    def of(self, rows: NDArray[np.bool_]) -> Noise:
        """The noise of some of the points, (n,)."""
        along = None if self.along is None else self.along.of(rows)
        return replace(self, sd=self.sd[rows], along=along)

    def scaled(self, factor: float) -> Noise:
        """The same shape with every standard deviation multiplied."""
        along = None if self.along is None else self.along._replace(sd=self.along.sd * factor)
        return replace(self, sd=self.sd * factor, along=along)

    def at_least_rounding(self, measurement: Measurement) -> Noise:
        """The same with at least what writing values with few digits rounds away."""
        sd = at_least_rounding(self.parts, measurement, self.turn)
        told = Noise.shaped(sd, self.turn, self.dof, self.source)
        return replace(told, doubt=self.doubt, memory=self.memory, tails=self.tails)


class Scatter(NamedTuple):
    """Squared scatter of each point about its mean or about a smooth curve.

    Attributes
    ----------
    real, imag : ndarray, shape (n,)
        Sums of squared deviations of K' and of K''.
    dof : ndarray, shape (n,)
        Degrees of freedom behind each of them.
    """

    real: Real
    imag: Real
    dof: Real

    @classmethod
    def of(cls, residual: Complex, dof: Real) -> Scatter:
        """Of a residual (n,) with so many degrees of freedom (n,)."""
        return cls(residual.real**2, residual.imag**2, dof)


@dataclass(frozen=True, eq=False)
class Shape:
    """One hypothesis on how the noise depends on the point; its scales are fitted.

    Parameters
    ----------
    real, imag : ndarray, shape (n,)
        Standard deviations of K' and K'' up to a scale.
    tied : bool
        Whether both have the same scale.
    price : float
        Minus twice the log-likelihood by which it must outdo the first shape.
    turn : ndarray of complex, shape (n,), optional
        Unit numbers that turn K to the real axis, where the parts are those along it and across it.
    """

    real: Real
    imag: Real
    tied: bool
    price: float
    turn: Complex | None = None

    def of(self, rows: NDArray[np.int64]) -> Shape:
        """The same for some of the points, (m,)."""
        turn = None if self.turn is None else self.turn[rows]
        return replace(self, real=self.real[rows], imag=self.imag[rows], turn=turn)

    def seen(self, residual: Complex) -> Complex:
        """A residual (n,) by the parts that this shape tells apart."""
        return residual if self.turn is None else residual * self.turn

    def sd(self, scales: Sequence[float] | Real) -> Complex:
        """Standard deviations (n,) by the scales of both parts."""
        return np.asarray(scales[0] * self.real + 1j * scales[1] * self.imag, dtype=np.complex128)

    def fit(self, scatter: Scatter) -> tuple[float, Complex]:
        """Minus twice the log-likelihood plus its price, and the standard deviations (n,)."""
        # Each scale is profiled out: the best one for this shape is known in closed form.
        total = float(np.sum(scatter.dof))
        real = float(np.sum(scatter.real / self.real**2)) / total
        imag = float(np.sum(scatter.imag / self.imag**2)) / total
        scales = 2
        if self.tied:
            real = imag = 0.5 * (real + imag)
            scales = 1
        # Repeats that agree to the last digit would have a logarithm without end.
        real, imag = max(real, SMALLEST), max(imag, SMALLEST)
        logs = 2.0 * float(np.sum(scatter.dof * (np.log(self.real) + np.log(self.imag))))
        cost = total * (np.log(real) + np.log(imag)) + logs
        # As the Bayesian information criterion counts a parameter: by the logarithm of the number
        # of data.
        penalty = scales * np.log(2.0 * max(total, 1.0))
        return float(cost + penalty + self.price), self.sd(np.sqrt([real, imag]))


def _shapes_of(measurement: Measurement) -> Iterator[Shape]:
    """Noise proportional to |K|, to each part by itself or beside a floor of stiffness or force."""
    size = measurement.magnitude
    parts = [
        np.maximum(np.abs(part), NEGLIGIBLE * size)
        for part in (measurement.storage, measurement.loss)
    ]
    yield Shape(size, size, True, 0.0)
    yield Shape(size, size, False, SEARCH.decisive)
    yield Shape(parts[0], parts[1], True, SEARCH.decisive)
    # A load cell's floor is a force: in K it is the larger the smaller the amplitude. Digits and
    # drawn scatter are the same in all of K.
    same = np.ones(len(measurement))
    units = [same, measurement.conditions.get("amplitude", same)]
    if np.ptp(units[1]) == 0.0:
        units = [same]
    for unit in units:
        yield from _beside_floor(size, unit)
    spread = _spread_by_coherence(measurement)
    if spread is not None:
        yield from _beside_floor(size, 1.0 / (size * spread))


def _spread_by_coherence(measurement: Measurement) -> Real | None:
    """Relative standard deviations (n,) of a transfer function, but for the number of averages.

    By the coherence of force and displacement, sqrt((1 - gamma^2) / gamma^2), the same along K and
    across it (Bendat and Piersol 2010, Random Data, eq. 9.89 and 9.91). None where no column tells
    it, or it is the same at all points.
    """
    coherence = measurement.conditions.get(COHERENCE)
    if coherence is None or not np.all((coherence > 0.0) & (coherence <= 1.0)):
        return None
    if np.ptp(coherence) == 0.0:
        return None
    return np.asarray(np.sqrt(np.maximum(1.0 / coherence - 1.0, NEGLIGIBLE)), dtype=float)


def _beside_floor(size: Real, unit: Real) -> Iterator[Shape]:
    """Noise proportional to |K| beside a floor of one size in a unit (n,) of K."""
    least = np.min(size * unit)
    for level in FLOOR_LEVELS:
        floor = np.hypot(size, level * least / unit)
        yield Shape(floor, floor, True, VERDICT.clear_evidence)


def along_k(measurement: Measurement, turn: Complex) -> Shape:
    """Noise of one size along K and of another across it, both proportional to |K|."""
    size = measurement.magnitude
    return Shape(size, size, False, VERDICT.clear_evidence, turn)


def _uneven_shapes_of(measurement: Measurement, turn: Complex | None) -> Iterator[Shape]:
    """Noise of two sizes, or larger at an end of the frequencies, of a condition or in one sweep.

    What the misfit of a wrong model looks like too.
    """
    size = measurement.magnitude
    if turn is not None:
        yield along_k(measurement, turn)
    parts = [
        np.maximum(np.abs(part), NEGLIGIBLE * size)
        for part in (measurement.storage, measurement.loss)
    ]
    yield Shape(size, size, False, VERDICT.clear_evidence)
    yield Shape(parts[0], parts[1], False, VERDICT.clear_evidence)
    for rise in _rises_of(measurement):
        yield Shape(size * rise, size * rise, True, SEARCH.decisive)
    # What shakes a mass: a force that grows with the square of the frequency.
    if np.ptp(measurement.omega) > 0.0:
        yield from _beside_floor(size, 1.0 / measurement.omega**2)


def _rises_of(measurement: Measurement) -> Iterator[Real]:
    """Factors (n,) of noise that is larger in some part of the measurement."""
    yield from _rises(np.log(measurement.omega))
    levels = [levels_of(*column) for column in measurement.conditions.items()]
    for level in levels:
        # By order: of temperatures the next is as far as the last, of amplitudes ten times it.
        yield from _rises(level.astype(np.float64))
    sweeps = rows_alike(*levels, np.zeros(len(measurement)))
    # A single sweep is louder than no other, and points each of its own conditions are no sweeps.
    if 1 < len(sweeps) <= len(measurement) // 3:
        for rows in sweeps:
            for factor in END_LEVELS:
                louder = np.ones(len(measurement))
                louder[rows] = factor
                yield louder


def _rises(along: Real) -> Iterator[Real]:
    """Factors (n,) of noise that is larger towards one end of values (n,), the other or both."""
    # A single value has no ends.
    whole = float(np.ptp(along))
    if whole == 0.0:
        return
    up = (along - along.min()) / whole
    for way in (up, 1.0 - up, np.abs(2.0 * up - 1.0)):
        for power in END_POWERS:
            for level in END_LEVELS:
                yield np.hypot(1.0, level * way**power)


def noise_shape(
    measurement: Measurement, scatter: Scatter, turned: Scatter, turn: Complex, uneven: bool = False
) -> tuple[Complex, Complex | None]:
    """Standard deviations (n,) of the shape that the scatter favours, and its turn if it has one.

    Parameters
    ----------
    measurement : Measurement
        The points, (n,).
    scatter, turned : Scatter
        Of each of them, in K' and K'' and along K and across it.
    turn : ndarray of complex, shape (n,)
        Unit numbers that turn K to the real axis.
    uneven : bool
        Whether it may be larger in some part of the measurement.
    """
    shapes = [*_shapes_of(measurement), along_k(measurement, turn)]
    if uneven:
        shapes += _uneven_shapes_of(measurement, None)
    fits = [(*shape.fit(scatter if shape.turn is None else turned), shape.turn) for shape in shapes]
    _, sd, axes = min(fits, key=lambda fit: fit[0])
    return sd, axes


def robust_noise_shape(
    measurement: Measurement,
    residual: Complex,
    rows: NDArray[np.int64],
    uneven: bool = False,
    turn: Complex | None = None,
    untold: Sequence[int] = (),
) -> tuple[Complex, Complex | None]:
    """Standard deviations (n,), up to a scale, of the shape that a residual favours, and its turn.

    Whatever stands out from it. Where nothing tells the noise of some points, the shape is the one
    that leaves most to them, of all that the residual does not rule out.

    By the likelihood of Student's t (Lange, Little and Taylor 1989, doi:10.2307/2290063): where the
    noise of some points is larger, they must not be set aside as outliers before their noise is
    known.

    Parameters
    ----------
    measurement : Measurement
        The data.
    residual : ndarray of complex, shape (m,)
        The scatter of some of them about slow curves, in the unit of K.
    rows : ndarray of int, shape (m,)
        Which these are.
    uneven : bool
        Whether it may be larger in some part of the measurement, or of another size in K' and K''.
    turn : ndarray of complex, shape (n,), optional
        Unit numbers that turn K of a model to the real axis, where these parts may be those along K
        and across it.
    untold : sequence of int
        Those of which no residual says anything.
    """
    shapes = list(_shapes_of(measurement))
    laws = len(shapes)
    if uneven:
        shapes += _uneven_shapes_of(measurement, turn)
    # Judged at some of the points, and then told for all: a shape is a law of the point, and not of
    # the residual.
    some = [shape.of(rows) for shape in shapes]
    scales = _student_scales(some, residual)
    costs = np.array([_student_cost(*each, residual) for each in zip(some, scales, strict=True)])
    best = int(np.argmin(costs))
    if len(untold) and best < laws:
        # Of them the law alone speaks: of laws that are as good the one of the larger noise, or a
        # point far from all others would be the surest.
        costs -= [shape.price for shape in shapes]
        possible = np.flatnonzero(costs[:laws] < np.min(costs[:laws]) + VERDICT.clear_evidence)
        left = [np.sum(np.log(np.abs(shapes[k].sd(scales[k])[untold]))) for k in possible]
        best = int(possible[np.argmax(left)])
    return shapes[best].sd(scales[best]), shapes[best].turn


def _student_scales(shapes: Sequence[Shape], residual: Complex) -> Real:
    """Scales (s, 2) of both parts by each of some shapes."""
    seen = np.array([shape.seen(residual) for shape in shapes])
    real = np.abs(seen.real / np.array([shape.real for shape in shapes]))
    imag = np.abs(seen.imag / np.array([shape.imag for shape in shapes]))
    tied = np.array([shape.tied for shape in shapes])
    scales = np.empty((len(shapes), 2))
    scales[tied] = _student_scale(np.concatenate([real[tied], imag[tied]], axis=1))[:, None]
    for part, size in enumerate((real, imag)):
        scales[~tied, part] = _student_scale(size[~tied])
    return scales


def _student_scale(size: Real) -> Real:
    """Scale (...) of each row of sizes (..., m), by iterated reweighting."""
    square = size**2
    # A residual of nothing but zeros has a scale as well, or its logarithm would be no number.
    variance = np.maximum(np.mean(square, axis=-1), SMALLEST)
    for _ in range(STUDENT_ROUNDS):
        # Expectation and maximisation: the further off a point lies, the less it counts for the
        # scale.
        weight = (STUDENT_DOF + 1.0) / (STUDENT_DOF + square / variance[..., None])
        variance = np.maximum(np.mean(weight * square, axis=-1), SMALLEST)
    return np.asarray(np.sqrt(variance), dtype=np.float64)


def _student_cost(shape: Shape, scales: Real, residual: Complex) -> float:
    """Minus twice the log-likelihood, with the price of the shape and what a second scale costs."""
    spent = 2
    if shape.tied:
        spent = 1
    cost = student_cost(shape.sd(scales), shape.seen(residual))
    return shape.price + cost + spent * float(np.log(2.0 * len(residual)))


def student_cost(sd: Complex, residual: Complex) -> float:
    """Minus twice the log-likelihood of a residual (n,) by Student's t with deviations (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.scatter import student_cost
    >>> far = np.array([0.1 + 0.1j, 8.0 + 0.1j])
    >>> [round(student_cost(np.full(2, size + size * 1j), far), 1) for size in (1.0, 3.0)]
    [14.2, 13.9]
    """
    total = 0.0
    for part, size in ((residual.real, sd.real), (residual.imag, sd.imag)):
        square = (part / size) ** 2
        tails = (STUDENT_DOF + 1.0) * np.log1p(square / STUDENT_DOF)
        total += float(np.sum(2.0 * np.log(size) + tails))
    return total


def tails_of(values: Real) -> float:
    """Degrees of freedom of the Student's t by which values of variance one are spread.

    The likeliest, and endless where normal ones are as likely: a number more costs what the
    Bayesian information criterion charges.

    Parameters
    ----------
    values : ndarray, shape (m,)
        Their mean square is taken to be one.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.scatter import tails_of
    >>> rng = np.random.default_rng(1)
    >>> tails_of(rng.standard_normal(400))
    inf
    >>> 2.0 < tails_of(rng.standard_t(3.0, 400) / np.sqrt(3.0)) < 5.0
    True
    """
    from scipy.optimize import minimize_scalar

    squares, m = values**2, len(values)

    def cost(inverse: float) -> float:
        free = 1.0 / inverse
        log_constant = gammaln(0.5 * (free + 1.0)) - gammaln(0.5 * free)
        logs = m * (log_constant - 0.5 * np.log(0.5 * (free - 2.0)))
        return float((free + 1.0) * np.sum(np.log1p(squares / (free - 2.0))) - 2.0 * logs)

    # From half a degree on a t has no variance.
    likeliest = minimize_scalar(cost, bounds=(0.0, 0.5), method="bounded")
    if likeliest.fun + np.log(m) < np.sum(squares):
        return float(1.0 / likeliest.x)
    return inf


def checked_noise(noise: Noise, variance: float, dof: float) -> Noise:
    """Noise as stated, with a word of doubt where the data's own scatter disagrees.

    Too small noise is rescaled.

    Parameters
    ----------
    noise : Noise
        As given.
    variance : float
        Of the whitened scatter that neither the model nor structure follows; one if all is well.
    dof : float
        Its degrees of freedom.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.scatter import Noise, checked_noise
    >>> checked_noise(Noise(np.array([0.1 + 0.1j]), np.inf, "given"), 9.0, 40.0).doubt.split(":")[0]
    'the given standard deviations look too small'
    """
    if dof < SCATTER.fewest_to_doubt:
        return noise
    # Standard deviations of the right size leave a variance of one, give or take what chance does
    # with so few.
    low, high = plausible_variance(dof)
    if low < variance < high:
        return noise
    factor = float(np.sqrt(variance))
    # Too large is no proof: errors that neighbours share do not show in the scatter, and may have
    # been meant.
    if factor < 1.0:
        doubt = (
            f"the given standard deviations are {1 / factor:.2g} times the data's own scatter: "
            "too large, or they hold errors that neighbouring points share; they are used as given"
        )
        return replace(noise, doubt=doubt)
    doubt = (
        f"the given standard deviations look too small: the data scatter {factor:.2g} times as"
        " much; the scatter is used instead"
    )
    return replace(noise.scaled(factor), dof=dof, source="estimated", doubt=doubt)


def beside_given(noise: Noise, measurement: Measurement, residual: Complex, dof: float) -> Noise:
    """Given noise, raised where the data scatter decidedly otherwise than it goes.

    As where one part scatters more than the other, though both were given the same. What was given
    larger may hold errors that neighbouring points share, and stays.

    Parameters
    ----------
    noise : Noise
        As given, of the right size for all numbers together.
    measurement : Measurement
        The points, (n,).
    residual : ndarray of complex, shape (n,)
        Their scatter about the model and slow curves, in the unit of K.
    dof : float
        Its degrees of freedom.
    """
    if dof < SCATTER.fewest_to_doubt:
        return noise
    usual, *others = _shapes_of(measurement)
    # Beyond what the best of so many reaches by chance; the usual one is as dear as the others.
    ahead = 2.0 * float(np.log(1 + len(others)))
    given = Shape(noise.sd.real, noise.sd.imag, True, -ahead)
    shapes = [replace(usual, price=SEARCH.decisive), *others, given]
    scales = _student_scales(shapes, residual)
    costs = [_student_cost(*each, residual) for each in zip(shapes, scales, strict=True)]
    best = int(np.argmin(costs))
    own = shapes[best].sd(scales[best])
    sd = np.maximum(noise.sd.real, own.real) + 1j * np.maximum(noise.sd.imag, own.imag)
    if shapes[best] is given or np.array_equal(sd, noise.sd):
        return noise
    more = float(max(np.max(sd.real / noise.sd.real), np.max(sd.imag / noise.sd.imag)))
    doubt = (
        "the given standard deviations go otherwise than the data's own scatter, which is up to"
        f" {more:.2g} times as large: where it is larger, it is used instead"
    )
    return replace(noise, sd=sd, dof=dof, source="estimated", doubt=doubt)


def plausible_variance(dof: float) -> tuple[float, float]:
    """Least and largest variance of scatter whitened by standard deviations of the right size.

    Parameters
    ----------
    dof : float
        Degrees of freedom of the scatter.

    Examples
    --------
    >>> from springpot.measurement.scatter import plausible_variance
    >>> low, high = plausible_variance(40.0)
    >>> round(low, 2), round(high, 2)
    (0.35, 2.11)
    """
    low, high = chi2_quantile([OUTLIERS.rare / 2, 1 - OUTLIERS.rare / 2], dof) / dof
    return float(low), float(high)


def at_least_rounding(
    sd: Complex, measurement: Measurement, turn: Complex | None = None
) -> Complex:
    """Standard deviations (n,), at least what writing values with few digits rounds away.

    Parameters
    ----------
    sd : ndarray of complex, shape (n,)
        Of K' (real part) and K'' (imaginary part).
    measurement : Measurement
        The values as they were written.
    turn : ndarray of complex, shape (n,), optional
        After which `sd` is told.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import at_least_rounding
    >>> written = Measurement([1.0, 2.0], [1.25 + 0.5j, 1.5 + 0.75j])
    >>> at_least_rounding(np.zeros(2, dtype=complex), written).round(4)
    array([0.0029+0.0029j, 0.0029+0.0029j])
    """
    # A number that is rounded lies anywhere within its step: the standard deviation of that is step
    # / sqrt(12).
    digit = rounding_steps(measurement) / np.sqrt(12.0)
    if turn is not None:
        digit = turned_sd(digit, turn)
    # Computed data are exact to single precision at the most: they too get a noise, or weights
    # would be endless.
    size = LEAST_RELATIVE * measurement.magnitude
    parts = [
        np.maximum(np.maximum(part, least), size)
        for part, least in ((sd.real, digit.real), (sd.imag, digit.imag))
    ]
    return np.asarray(parts[0] + 1j * parts[1], dtype=np.complex128)


def rounding_steps(measurement: Measurement) -> Complex:
    """Steps (n,) to which K' (real part) and K'' (imaginary part) were rounded when written.

    Of a column that is the same throughout its one value tells how coarse it may have been written,
    never that it was: an exact 90 ends in a nought as well. It is taken to be written as finely as
    the column beside it.

    Parameters
    ----------
    measurement : Measurement
        The values as they were written.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement.scatter import rounding_steps
    >>> rounding_steps(Measurement([1.0, 2.0], [90.0 + 1.25j, 90.0 + 2.5j])).tolist()
    [(0.01+0.01j), (0.01+0.01j)]
    """
    columns = measurement.storage, measurement.loss
    own = [rounding_step(column) for column in columns]
    finest = np.minimum(*own)
    told = [
        step if np.ptp(column) > 0.0 else finest for column, step in zip(columns, own, strict=True)
    ]
    return np.asarray(told[0] + 1j * told[1], dtype=np.complex128)


def steps_as_written(measurement: Measurement) -> Complex:
    """The same, also of values that were written as a modulus, a phase or a loss factor.

    Parameters
    ----------
    measurement : Measurement
        The values as they were read.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement.scatter import steps_as_written
    >>> written = Measurement([1.0, 2.0], [90.1 * (1.0 + 0.213j), 95.3 * (1.0 + 0.314j)])
    >>> steps_as_written(written).round(3).tolist()
    [(0.1+0.093j), (0.1+0.1j)]
    """
    own, size = rounding_steps(measurement), measurement.magnitude
    angle = np.angle(measurement.stiffness)
    cos, sin = np.abs(np.cos(angle)), np.abs(np.sin(angle))
    storage, loss = (own.real, measurement.storage), (own.imag, measurement.loss)
    modulus = _with_step(size)
    turns = [
        (_with_step(np.degrees(angle)), np.full(len(size), np.pi / 180.0)),
        (_with_step(angle), np.ones(len(size))),
        (_with_step(np.tan(angle)), cos**2),
    ]
    # What was written has few digits, and what follows from it has all of them.
    found, best = own, min(map(_coarseness, (storage, loss)))
    for column, unit in turns:
        turned = column[0] * unit
        by_modulus, by_storage = (
            min(_coarseness(column), _coarseness(other)) for other in (modulus, storage)
        )
        if by_modulus > max(best, by_storage):
            best, real = by_modulus, np.hypot(modulus[0] * cos, size * sin * turned)
            found = real + 1j * np.hypot(modulus[0] * sin, size * cos * turned)
        elif by_storage > best:
            best = by_storage
            found = own.real + 1j * np.hypot(own.real * sin / cos, size * turned / cos)
    return np.asarray(found, dtype=np.complex128)


def _with_step(column: Real) -> tuple[Real, Real]:
    """A column and the rounding step of each value; 0 where one value throughout tells of none."""
    if np.ptp(column) <= ALIKE * np.max(np.abs(column)):
        return np.zeros(len(column)), column
    return rounding_step(column), column


def _coarseness(column: tuple[Real, Real]) -> float:
    """The rounding step of a column's values over these, as a rule."""
    return float(np.median(column[0] / np.maximum(np.abs(column[1]), SMALLEST)))


def with_noise(
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    *,
    symmetric: bool = False,
    displacement: tuple[float, float] = (0.005, 0.01),
) -> Measurement:
    """The measurement with noise on the amplitudes of force and displacement, eq. (53).

    The displacement (q_c, q_s) gives the force by eq. (17); u_c, u_s, q_c, q_s are each multiplied
    by 1 + r level, and eq. (43) turns them back into K' and K''.

    Parameters
    ----------
    measurement : Measurement
        Exact data.
    level : float
        Noise level epsilon, such as 0.01.
    rng : numpy.random.Generator
        Draws r_1 ... r_4 for every frequency, in this order.
    symmetric : bool
        Draw r from (-1, 1); by default from (0, 1), as printed, which shifts all amplitudes
        upwards.
    displacement : tuple of float
        Cosine and sine amplitudes q_c and q_s, in metres in the paper (section 5.1).

    Raises
    ------
    DataError
        If the level is not positive and below 1.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import with_noise
    >>> exact = Measurement(np.ones(3), np.full(3, 2.0 + 1.0j))
    >>> noisy = with_noise(exact, 0.01, np.random.default_rng(1), symmetric=True)
    >>> bool(np.all(np.abs(noisy.stiffness / exact.stiffness - 1.0) < 0.05))
    True
    """
    if not 0 < level < 1:
        raise DataError(f"the noise level must lie between 0 and 1, got {level}")
    least, kind = 0.0, "one-sided as printed, r from (0, 1)"
    if symmetric:
        least, kind = -1.0, "symmetric, r from (-1, 1)"
    r = rng.uniform(least, 1.0, size=(4, len(measurement)))
    qc, qs = displacement
    uc = measurement.storage * qc + measurement.loss * qs
    us = -measurement.loss * qc + measurement.storage * qs
    uc, us, qc_noisy, qs_noisy = (1.0 + level * r) * np.stack(np.broadcast_arrays(uc, us, qc, qs))
    squared = qc_noisy**2 + qs_noisy**2
    storage = (uc * qc_noisy + us * qs_noisy) / squared
    loss = (uc * qs_noisy - us * qc_noisy) / squared
    return replace(
        measurement,
        stiffness=storage + 1j * loss,
        provenance={**measurement.provenance, "noise": f"eq. (53) at {100 * level:g} %, {kind}"},
    )
