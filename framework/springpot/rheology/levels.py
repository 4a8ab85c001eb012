"""Factors without a law.

One for each level of a condition, such as each temperature or each water content.

The levels are in the data and not in the model: an effect of this kind is a template until it is
bound to points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .nodes import GRADIENT, VALUE, Node, Response
from .parameters import Parameter
from .points import KELVIN, LARGEST_SHIFT, Points, Real

HELD: Mapping[str, float] = {"amplitude": 0.02, "temperature": 0.5}
"""How nearly a rig holds what was set: amplitudes as a share, temperatures in kelvin.

Rheometers state 1 to 2 % and
0.1 to 0.5 K. Values that lie closer to one another are one level."""
HELD_OTHER = 2e-3
"""The same of other settings, as a share of the largest.

They are written down rather than measured.
"""
WIDEST = float(np.exp(LARGEST_SHIFT))
"""Bound on a factor and its inverse: free factors go as far as any law, which they contain."""


def held(column: str, values: Real) -> Real:
    """How far apart values (n,) of a column may be and be one setting, in its unit (n,)."""
    if column == "temperature":
        return np.full(len(values), HELD[column])
    if column in HELD:
        return HELD[column] * np.abs(values)
    return np.full(len(values), HELD_OTHER * float(np.max(np.abs(values), initial=0.0)))


def levels_of(column: str, values: Real) -> NDArray[np.int64]:
    """Number of the level that each value belongs to, in ascending order.

    Neighbouring values that a rig does not tell apart are one level, unless they drift on and on: a
    level is never wider than twice what is held.

    Parameters
    ----------
    column : str
        Name of the condition.
    values : ndarray, shape (n,)
        Its values; temperatures in kelvin or degC.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import levels_of
    >>> levels_of("temperature", np.array([20.1, 39.9, 20.0, 40.2]))
    array([0, 1, 0, 1])
    """
    # In ascending order neighbours can be compared, and a level grow from its first value on.
    distinct, which = np.unique(values, return_inverse=True)
    room = held(column, distinct)
    number = np.zeros(len(distinct), dtype=np.int64)
    first = 0
    for i in range(1, len(distinct)):
        apart = (
            distinct[i] - distinct[i - 1] > room[i] or distinct[i] - distinct[first] > 2.0 * room[i]
        )
        if apart:
            first = i
        number[i] = number[i - 1] + apart
    return number[which.ravel()]


def level_word(value: float) -> str:
    """A level as part of a parameter's name: -22.5 is ``m22p5``, which is an identifier."""
    return f"{value:.6g}".replace("-", "m").replace("+", "").replace(".", "p")


def level_text(column: str, value: float) -> str:
    """A level as people say it: what was set, not what a sensor printed.

    Examples
    --------
    >>> from springpot.rheology.levels import level_text
    >>> level_text("temperature", 24.98)
    '25 degC'
    """
    if column == "temperature":
        return f"{round(value, 1) + 0.0:g} degC"
    return f"{column} {value:.4g}"


@dataclass(frozen=True)
class Levels(Node):
    """A positive factor for each level of a condition, one at the reference level.

    Between two levels the logarithm of the factor is interpolated; beyond them it stays.

    Parameters
    ----------
    column : str
        The condition: ``"temperature"``, ``"amplitude"`` or any column of the data.
    letter : str
        Name of the factors: ``a`` for shifts of frequency, ``b`` for vertical ones.
    logarithmic : bool
        Whether the node responds with the factor's logarithm, as `shift` asks, or with the factor,
        as `chain` asks.
    values : tuple of float
        The levels in ascending order, temperatures in kelvin. Without any the node is a template
        that changes nothing: `bound_to` gives it the levels of the data.
    reference : int
        Number of the level whose factor is one.
    """

    column: str = "temperature"
    letter: str = "a"
    logarithmic: bool = True
    values: tuple[float, ...] = ()
    reference: int = 0
    kind: str = "free factors"

    def bound_to(self, at: Points) -> Levels:
        """The node with the levels that the points have; itself if it has levels already.

        Raises
        ------
        ValueError
            If the points lack the column.
        """
        if self.values:
            return self
        column = at.need(self.column)
        number = levels_of(self.column, column)
        count = np.bincount(number)
        means = np.bincount(number, column) / count
        target = at.reference_temperature
        if self.column != "temperature":
            # The lower median, as the mean of two levels would be none.
            target = float(np.sort(column)[(len(column) - 1) // 2])
        # One level must be one: a factor of all of them would be the scale of the material once
        # more.
        reference = int(np.argmin(np.abs(means - target)))
        return replace(self, values=tuple(means.tolist()), reference=reference)

    def referred_to(self, value: float) -> Levels:
        """The same levels with the factor one at the level nearest to `value`."""
        return replace(self, reference=int(np.argmin(np.abs(np.array(self.values) - value))))

    @property
    def shown(self) -> tuple[float, ...]:
        """The levels as users write them: temperatures in degC."""
        zero = 0.0
        if self.column == "temperature":
            zero = KELVIN
        return tuple(_as_written(value - zero) for value in self.values)

    @cached_property
    def free(self) -> tuple[int, ...]:
        """Numbers of the levels whose factors are parameters."""
        return tuple(i for i in range(len(self.values)) if i != self.reference)

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        shown = self.shown
        # One decimal where it tells the levels apart: settings are round, what a rig held is not.
        words = [level_word(round(value, 1)) for value in shown]
        if len(set(words)) < len(words):
            words = [level_word(value) for value in shown]
        return tuple(
            Parameter(
                f"{self.letter}_{words[i]}",
                f"{self.letter}({shown[i]:.4g})",
                lower=1.0 / WIDEST,
                upper=WIDEST,
            )
            for i in self.free
        )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The factor of each level but the reference."""
        return self._parameters

    @property
    def needs(self) -> frozenset[str]:
        """The condition."""
        return frozenset({self.column})

    def shares(self, at: Points) -> Real:
        """Share of each free level (q, n) in the logarithm of the factor at the points."""
        column, values = at.need(self.column), np.array(self.values)
        nearest = np.argmin(np.abs(column[None, :] - values[:, None]), axis=0)
        # Within what a rig holds a value is its level, not a place between two.
        settled = np.abs(column - values[nearest]) <= held(self.column, values)[nearest]
        place = np.where(settled, values[nearest], column)
        return np.array(
            [np.interp(place, values, unit) for unit in np.eye(len(values))[list(self.free)]]
        )

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The factor or its logarithm."""
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        if not self.free:
            at.need(self.column)
            # A factor of one, or its logarithm.
            neutral = np.ones(shape, dtype=np.complex128)
            if self.logarithmic:
                neutral = np.zeros(shape, dtype=np.complex128)
            nothing = np.zeros((*shape[:-1], 0, shape[-1]), dtype=np.complex128)
            return Response(neutral, nothing, np.zeros_like(neutral))
        shares = self.shares(at)
        # Linear in the logarithms, in which factors between two levels are interpolated.
        log_factor = np.matmul(np.log(theta), shares)
        by_theta = shares / theta[..., :, None]
        value = log_factor
        if not self.logarithmic:
            value = np.exp(log_factor)
        value = np.broadcast_to(value, shape).astype(np.complex128)
        if depth == VALUE:
            return Response(value)
        if not self.logarithmic:
            by_theta = by_theta * value[..., None, :]
        slopes = np.broadcast_to(by_theta, (*shape[:-1], *by_theta.shape[-2:])).astype(
            np.complex128
        )
        if depth == GRADIENT:
            return Response(value, slopes)
        return Response(value, slopes, np.zeros(shape, dtype=np.complex128))


def free_factors(column: str = "temperature") -> Levels:
    """Shift factors a of the frequency, one for each level of a column, for `shift`.

    Examples
    --------
    >>> from springpot.rheology import Points, free_factors
    >>> at = Points.at([1.0, 1.0, 1.0], temperature=[0.0, 20.0, 40.0])
    >>> [parameter.name for parameter in free_factors().bound_to(at).parameters]
    ['a_0', 'a_40']
    """
    return Levels(column, "a", True)


def free_vertical_factors(column: str = "temperature") -> Levels:
    """Vertical factors b of the stiffness, one for each level of a column, for `chain`.

    Examples
    --------
    >>> from springpot.rheology import Points, free_vertical_factors
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 40.0])
    >>> [parameter.name for parameter in free_vertical_factors().bound_to(at).parameters]
    ['b_40']
    """
    return Levels(column, "b", False)


def _as_written(value: float) -> float:
    # Ten digits: 253.15 - 273.15 is not -20 to the last bit, and what is left of 273.15 - 273.15 is
    # zero.
    if not abs(value) > 1e-9:
        return 0.0
    return float(f"{value:.10g}")
