"""Where a fit searches: the box of an optimiser, and what is expected before the data speak.

The box is mapped exactly to a model's parameters. Of vertical factors something is known
beforehand: Tikhonov's regularisation with a width that has a meaning, which is Bayes' theorem with
a normal prior of ln b; data that contradict it have their way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from springpot.errors import DataError, ModelError
from springpot.numerics import LARGEST as LARGEST_NUMBER, ROUNDING
from springpot.rheology.levels import Levels
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

if TYPE_CHECKING:
    from springpot.measurement.measurement import Measurement
    from springpot.rheology.effect import Test
    from springpot.rheology.model import Model

TINY = 1e-9
"""Smallest positive value of a searched parameter, as a fraction of its upper bound."""


LARGEST = 1e30
"""Largest number of a measurement, and one over the smallest, that can be fitted.

Of a mass's slope, which goes with
the square of the frequency, the square of the square must still be a number."""


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """A box in the model's search form.

    Parameters
    ----------
    model : Model
        The model whose parameters are sought.
    parameters : tuple of Parameter
        What is searched: the model's published search form, then the parameters of its effects.
    lower, upper : ndarray, shape (d,)
        The box of bounded optimisers.
    expected : ndarray, shape (d,)
        Sizes of the order of the answer (the paper's k-bar, 1 s, 1): where a swarm is born.
    """

    model: Model
    parameters: tuple[Parameter, ...]
    lower: Real
    upper: Real
    expected: Real

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the searched parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    @cached_property
    def lowest(self) -> Real:
        """Limits (d,) that no point leaves, in the box or out of it.

        A positive parameter stays positive.
        """
        tiny = TINY * np.minimum(self.expected, self.upper)
        lowest = np.maximum([p.lower for p in self.parameters], -LARGEST_NUMBER)
        # A lower end of zero is no place for a logarithm.
        return np.where(lowest == 0.0, tiny, lowest)

    @cached_property
    def highest(self) -> Real:
        """Limits (d,) that no point exceeds."""
        return np.array([min(p.upper, LARGEST_NUMBER) for p in self.parameters])

    def _split(self) -> int:
        if self.model.search is None:
            return 0
        return len(self.model.search.parameters)

    def repaired(self, x: Real) -> Real:
        """`x` with the thermodynamic order kinf > k0 restored (section 4 of the paper)."""
        form = self.model.search
        if form is None:
            return x
        return form.repaired(x)

    def theta(self, x: Real) -> Real:
        """Element parameters (..., p) of search points (..., d)."""
        form, q = self.model.search, self._split()
        x = self.repaired(x)
        if form is None:
            return x
        # Without effects nothing is to be joined: this runs at every evaluation.
        if q == x.shape[-1]:
            return form.to_elements(x)
        return np.concatenate([form.to_elements(x[..., :q]), x[..., q:]], axis=-1)

    def jacobian(self, x: Real) -> Real:
        """D theta / d x, shape (..., p, d), the repair of the order included."""
        form, q = self.model.search, self._split()
        d = len(self.parameters)
        full = np.zeros((*x.shape[:-1], d, d))
        full[...] = np.eye(d)
        if form is None:
            return full
        full[..., :q, :q] = form.jacobian(self.repaired(x)[..., :q])
        if form.ordered is not None:
            low, high = form.ordered
            violated = (x[..., high] <= x[..., low])[..., None]
            # There kinf = 1.01 k0 is no variable of its own: what it does, k0 does.
            full[..., low] += np.where(violated, form.margin * full[..., high], 0.0)
            full[..., high] = np.where(violated, 0.0, full[..., high])
        return full

    def from_theta(self, theta: Real) -> Real:
        """Search point (..., d) of element parameters (..., p)."""
        form, q = self.model.search, self._split()
        if form is None:
            return theta
        return np.concatenate([form.from_elements(theta[..., :q]), theta[..., q:]], axis=-1)


def paper_box(
    model: Model, measurement: Measurement, stiffness_scale: float | None = None
) -> SearchSpace:
    """The paper's box of parameters.

    Times in (0, 1) s or the slowest cycle, orders in (0, 1), stiffnesses in (0, 2 k-bar).

    The paper starts its swarm in (0, k-bar) and does not clamp stiffnesses; k-bar may be the very
    answer (its own Maxwell-type example has kinf = k-bar), so bounded optimisers get twice that.

    Parameters
    ----------
    model : Model
        The model to be searched.
    measurement : Measurement
        Fixes the sizes where the paper gives none.
    stiffness_scale : float, optional
        k-bar; by default the measured |K| rounded up to 1, 2 or 5 times a power of ten.

    Raises
    ------
    ModelError
        If the data lack a column that the model needs.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification.space import paper_box
    >>> data = springpot.read("artificial-hidden")
    >>> box = paper_box(springpot.parse_model("fractional-zener"), data)
    >>> dict(zip(box.names, box.upper.tolist()))
    {'k0': 1000.0, 'kinf': 1000.0, 'tau': 1.0, 'alpha': 1.0}
    """
    require_conditions(model, measurement)
    if stiffness_scale is None:
        stiffness_scale = rounded_up(float(np.max(measurement.magnitude)))
    amplitude, reach = measurement.conditions.get("amplitude"), 1.0
    if amplitude is not None:
        reach = float(np.max(amplitude))
    # Slower than the slowest cycle nothing shows; below that the paper's second is kept.
    longest = max(1.0, 1.0 / float(measurement.omega.min()))
    return box_of(model, stiffness_scale, longest, reach)


def box_of(model: Model, scale: float, time: float, reach: float) -> SearchSpace:
    """The same for data of these sizes.

    Parameters
    ----------
    model : Model
        The model to be searched.
    scale, time, reach : float
        Largest stiffness, longest time in s, and largest amplitude.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification.space import box_of
    >>> box_of(springpot.parse_model("kelvin"), 100.0, 1.0, 1.0).upper
    array([200., 200.])
    """
    form, searched = model.search, model.parameters
    if form is not None:
        searched = form.parameters + model.parameters[len(form.parameters) :]
    expected = np.array([_expected(parameter, scale, time, reach) for parameter in searched])
    # Only stiffnesses get twice their size: the paper's own example lies at the end of its box.
    room = np.where([parameter.unit.stiffness != 0 for parameter in searched], 2.0, 1.0)
    upper = np.minimum(room * expected, [parameter.upper for parameter in searched])
    lower = np.array([_lower_end(p, end) for p, end in zip(searched, upper, strict=True)])
    return SearchSpace(model, searched, lower, upper, expected)


def _lower_end(parameter: Parameter, upper: float) -> float:
    # What may have either sign is sought as far on either side.
    if parameter.lower < 0:
        return -upper
    return max(parameter.lower, TINY * upper)


def _expected(parameter: Parameter, scale: float, time: float, reach: float) -> float:
    # An order, such as alpha, has a size of its own: all of what it may be.
    if parameter.scale == "linear" and parameter.upper < np.inf:
        return parameter.upper
    # The power of time is an order that is yet to be found: the middle of what it may be.
    return float(parameter.unit.size(scale, time, reach, 0.5) * parameter.typical)


def rounded_up(value: float) -> float:
    """`value` rounded up to 1, 2 or 5 times a power of ten."""
    # A power of ten comes out of the logarithm with rounding: 1000 must not become 2000.
    power = 10.0 ** np.floor(np.log10(value))
    return float(
        next(
            step * power
            for step in (1.0, 2.0, 5.0, 10.0)
            if step * power >= value * (1.0 - ROUNDING)
        )
    )


def require_effects(model: Model, tests: Sequence[Test]) -> None:
    """Check that some test can have each effect of a model.

    Raises
    ------
    ModelError
        If there is none, as for a ramp in a sweep.
    """
    for effect in model.effects:
        if not any(effect.applies_to(test) for test in tests):
            raise ModelError(
                f"{tests[0].name}: '{effect.name}', an effect of {effect.applies_to}, cannot be"
                " seen in such a test: leave it out"
            )


def require_conditions(model: Model, measurement: Measurement) -> None:
    """Check that the data can have the effects of a model, and have every column that it needs.

    Raises
    ------
    ModelError
        If an effect belongs to other tests, or a column is missing.
    """
    require_effects(model, [measurement])
    require_columns(model, measurement)


def require_columns(model: Model, measurement: Measurement) -> None:
    """Check that the data have every column the model needs.

    Raises
    ------
    ModelError
        If one is missing.
    """
    # Told before anything is fitted, by the name of the column that lacks.
    missing = sorted(model.needs - set(measurement.conditions))
    if missing:
        raise ModelError(
            f"{model.name} needs the column {', '.join(missing)},"
            f" which {measurement.name} does not have"
        )


def require_size(measurement: Measurement) -> None:
    """Check that the numbers of the data can be reckoned with.

    Raises
    ------
    DataError
        If a frequency or a modulus is larger or smaller than any that is measured, by many orders.
    """
    for what, values in (
        ("frequency in rad/s", measurement.omega),
        ("size of storage and loss", measurement.magnitude),
    ):
        beyond = values[(values > LARGEST) | (values < 1.0 / LARGEST)]
        if len(beyond):
            raise DataError(
                f"{measurement.name}: a {what} of {beyond[0]:.3g} cannot be fitted;"
                " is its unit right?"
            )


POWER = 1.0
"""Standard deviation of n in b = (T / Tr)^n.

1 for an ideal rubber (Flory), below 0 for a glass, whose modulus falls
by tenths of a per cent for each kelvin."""
REPEATED = 0.03
"""Standard deviation of ln b of one sweep by itself.

The gap and the grip of a specimen give and slip by some per
cent when the temperature changes."""
ELSEWHERE = float(np.log(2.0))
"""Standard deviation of ln b along other columns: only its order of magnitude is known."""


@dataclass(frozen=True, eq=False)
class Expected:
    """What is known of the effects' parameters before the data speak.

    Attributes
    ----------
    rows : ndarray, shape (r, q)
        The logarithms of the parameters times these are expected to be normal, of unit variance
        about zero; nothing is expected of one whose column is zero.
    unit : float
        Variance of a weighted residual of the data, by which departures are weighed against these.
    moved : ndarray, shape (q,), optional
        By how much the search coordinates, of factors the logarithms, would be others with what
        the evidence did not ask for.
    """

    rows: Real
    unit: float
    moved: Real | None = None

    @property
    def weighted(self) -> Real:
        """Rows (r, q) whose squares stand beside those of the residuals."""
        return np.asarray(np.sqrt(self.unit) * self.rows, dtype=np.float64)

    @property
    def covariance(self) -> Real:
        """Covariance (q, q) of logarithms of which something is expected; zero for others."""
        precision = self.rows.T @ self.rows
        known = np.flatnonzero(np.diag(precision) > 0.0)
        covariance = np.zeros_like(precision)
        covariance[np.ix_(known, known)] = np.linalg.inv(precision[np.ix_(known, known)])
        return covariance

    def of(self, columns: Sequence[int]) -> Expected | None:
        """The same of some of the parameters; none where nothing is expected of them."""
        rows = self.rows[:, list(columns)]
        rows = rows[np.any(rows != 0.0, axis=1)]
        if not len(rows):
            return None
        moved = None if self.moved is None else self.moved[list(columns)]
        return Expected(rows, self.unit, moved)


def expectation(model: Model) -> Real:
    """Rows (r, q) that whiten the logarithms of free vertical factors by what is expected of them.

    Of the parameters of all effects; zero where nothing is expected.

    Every level, that of reference too, has an error of its own, so that no level is trusted before
    the others.
    """
    blocks = np.zeros((0, 0))
    for effect in model.effects:
        element = effect.element
        own = np.zeros((0, len(element.parameters)))
        if isinstance(element, Levels) and not element.logarithmic:
            own = np.linalg.inv(np.linalg.cholesky(_covariance(element)))
        blocks = block_diag(blocks, own)
    return np.asarray(blocks, dtype=np.float64)


def _covariance(element: Levels) -> Real:
    """Of the logarithms of the free vertical factors, one at the reference."""
    free = list(element.free)
    size, along = ELSEWHERE, np.zeros(len(free))
    if element.column == "temperature":
        size = REPEATED
        kelvin = np.array(element.values)
        along = POWER * np.log(kelvin[free] / kelvin[element.reference])
    shared = np.ones((len(free), len(free)))
    return np.asarray(
        np.outer(along, along) + size**2 * (np.eye(len(free)) + shared), dtype=np.float64
    )


def spread_between(element: Levels) -> Real:
    """Expected standard deviation (m, m) of ln b from each level to each other."""
    size, along = ELSEWHERE, np.zeros(len(element.values))
    if element.column == "temperature":
        size, along = REPEATED, POWER * np.log(np.array(element.values))
    return np.asarray(
        np.sqrt(np.subtract.outer(along, along) ** 2 + 2.0 * size**2), dtype=np.float64
    )
