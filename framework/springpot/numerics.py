"""What is as good as nothing in floating point, how far a search goes, and a few sums of the house.

Rows that are alike, at even places or of one level, what parameters can follow, weights >= 0.

One level for each reason, for the whole house.  Shares are relative to the largest of what is
added, compared or measured.
"""

from __future__ import annotations

from math import log, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ROUNDING = 1e-12
"""Share that sums and products of doubles leave: some thousand times their last digit, 2e-16."""
ALIKE = 1e-9
"""Two results of a solved system or a search within this share of each other are one.

Half the digits of a double are lost where a condition of 1e7 stands between data and result.
"""
NEGLIGIBLE = 1e-6
"""Share that no instrument shows and no printed digit: a thousandth of the best one's noise."""
PRINTED = 1e-4
"""Relative error below the four digits that are printed of an uncertain number."""
SMALLEST = 1e-300
"""Stands for nothing where one divides by it or takes its logarithm; its inverse is a number."""

LARGEST = 1e150
"""Stands for no limit, and for infinity in an answer: its square still is a number."""
ENDLESS = 30.0
"""Of an interval in natural logarithms, thirteen decades to either side: it has no end."""
AT_ONCE = 1_000_000
"""Numbers of a large array that are held at once."""

DIFFERENCE = 1e-6
"""Relative step of a central difference: what is cut off and what is rounded are both 1e-10."""

MOST_STEPS = 60
"""Of a search that ends by itself, mostly in five to thirty: after these it found nothing."""
ENOUGH = 2000
"""Samples of a record that are looked at: more take longer and show no more than is plain already.
"""
HALVINGS = 100
"""Of an interval with a root: beyond them only rounding is left of any."""

REWEIGHTINGS = 6
"""Of a fit by weights that it gives: after four what it finds changes in the third digit only."""

DECADE = log(10.0)
"""In a natural logarithm."""
PER_DECADE = 3
"""Lines of relaxation.

A smooth spectrum is followed to 2 exp(-4.29 * 3) = 5e-6 of K, by the error of the trapezoidal rule,
and nothing tells more of them apart that differ by more than a per cent in K.
"""
BEYOND = 100.0
"""Factor beyond the measured frequencies.

What relaxes further off is a spring or a dashpot to 1 %, squared.
"""
NORMAL = 1.482602218505602
"""Standard deviation of a normal distribution over the median of its absolute values."""
MEDIAN_WORTH, FOURTH_WORTH = 0.37, 0.38
"""Share of the numbers that a median of absolute values uses, and that fourth differences do.

Their variances are 1/0.37 and 1/0.38 of the best one's: neighbouring differences share samples.
"""
FEWEST = 3
"""Numbers that tell how they scatter: beside a mean, or a line through them, one or two are left.
"""
COARSE = 60
"""Samples that show where a course goes: some of more, evenly chosen, are looked at first."""
FAR = 5.0
"""Logarithm beyond which a part is as good as nothing beside another: it is one in 150 of it."""
DEVIATIONS = 2.0
"""Standard deviations beyond which noise goes once in twenty: within them two numbers meet."""
TWO_DEVIATIONS = DEVIATIONS**2
"""Drop of chi-square, or twice that of a log-likelihood, by one number that is two of its standard
deviations: a chance of 5 %.
"""


Real: TypeAlias = "NDArray[np.float64]"
Complex: TypeAlias = "NDArray[np.complex128]"


def rms(values: Real) -> float:
    """Root mean square of values (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import rms
    >>> rms(np.array([1.0, -7.0]))
    5.0
    """
    return sqrt((values**2).mean())


def evenly(count: int, most: int) -> NDArray[np.intp]:
    """Numbers of at most so many of `count` samples, the first and the last among them.

    Examples
    --------
    >>> from springpot.numerics import evenly
    >>> evenly(9, 3), evenly(2, 3)
    (array([0, 4, 8]), array([0, 1]))
    """
    import numpy as np

    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.intp))


def rows_of_levels(number: NDArray[np.intp], count: int) -> list[NDArray[np.intp]]:
    """Rows of each of so many levels, in their order, by the level (n,) that each row is of.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import rows_of_levels
    >>> [rows.tolist() for rows in rows_of_levels(np.array([2, 0, 2]), 3)]
    [[1], [], [0, 2]]
    """
    import numpy as np

    counts = np.bincount(number, minlength=count)
    return np.split(np.argsort(number, kind="stable"), np.cumsum(counts)[:-1])


def set_numbers(*columns: NDArray[Any]) -> NDArray[np.int64]:
    """Number (n,) of the set of values that each row has of some columns (n,), in their order.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import set_numbers
    >>> set_numbers(np.array([5, 5, 1, 5]), np.array([0.2, 0.1, 0.3, 0.2]))
    array([2, 1, 0, 2])
    """
    import numpy as np

    _, number = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    return np.asarray(number.ravel(), dtype=np.int64)


def rows_alike(*columns: NDArray[Any]) -> list[NDArray[np.intp]]:
    """Rows of each set of values that some columns (n,) have together."""
    number = set_numbers(*columns)
    return rows_of_levels(number, int(number.max()) + 1)


def level_means(number: NDArray[np.intp], values: NDArray[Any]) -> Any:
    """Mean of the values (n,) of each level, by the level (n,) that each is of.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import level_means
    >>> level_means(np.array([1, 0, 1]), np.array([2.0, 5.0, 4.0]))
    array([5., 3.])
    """
    import numpy as np

    sums: NDArray[Any] = np.bincount(number, values.real)
    if np.iscomplexobj(values):
        sums = sums + 1j * np.bincount(number, values.imag)
    return sums / np.bincount(number)


def vertex(before: Any, here: Any, after: Any) -> Any:
    """Where the parabola through three equidistant values turns, in steps from the middle one.

    The middle one is the largest or the least of the three; of a flat parabola it is the place.

    Examples
    --------
    >>> from springpot.numerics import vertex
    >>> float(vertex(2.0, 1.0, 4.0)), float(vertex(1.0, 1.0, 1.0))
    (-0.25, 0.0)
    """
    import numpy as np

    bend = before - 2.0 * here + after
    return 0.5 * (before - after) / np.where(bend == 0.0, SMALLEST, bend)


def projected_out(values: Real, basis: Real) -> Real:
    """What of values (m,) or columns (m, c) lies beyond an orthonormal basis (m, r).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import projected_out
    >>> projected_out(np.array([3.0, 4.0]), np.array([[1.0], [0.0]]))
    array([0., 4.])
    """
    return values - basis @ (basis.T @ values)


class Tangent(NamedTuple):
    """What small changes of some amounts make, as a linear step has it.

    Attributes
    ----------
    basis : ndarray, shape (m, r)
        Orthonormal.
    back : ndarray, shape (p, r)
        The change of the amounts that makes each of its directions.
    lost : ndarray, shape (p,)
        Part of each amount, by its size, in changes that make nothing.
    """

    basis: Real
    back: Real
    lost: Real

    @classmethod
    def of(cls, slopes: Real, tolerance: float = ALIKE) -> Tangent:
        """That of slopes (m, p), scaled first, so that the units of the amounts do not matter."""
        import numpy as np
        from scipy.linalg import svd

        size = np.linalg.norm(slopes, axis=0)
        # What changes nothing has a column of nothing.
        size = np.where(size > 0.0, size, 1.0)
        # By singular values of the slopes themselves: parameters of a fit are often nearly
        # dependent, a QR would keep rounding as a direction, and their square half of the digits.
        try:
            u, s, v = np.linalg.svd(slopes / size, full_matrices=False)
        except np.linalg.LinAlgError:
            # The divide-and-conquer algorithm gives up on rare well-formed matrices; the older one
            # does not.
            u, s, v = svd(slopes / size, full_matrices=False, lapack_driver="gesvd")
        good = s > tolerance * s.max(initial=0.0)
        u, s, v = u[:, good], s[good], v[good]
        lost = np.sqrt(np.maximum(1.0 - np.sum(v * v, axis=0), 0.0))
        return cls(u, (v.T / s) / size[:, None], lost)

    def left(self, values: Real) -> Real:
        """What of (m,) or columns (m, c) the amounts cannot make."""
        return projected_out(values, self.basis)

    def step(self, wanted: Real) -> Real:
        """The change of the amounts (p,) that makes something (m,), as nearly as they can."""
        return self.back @ (self.basis.T @ wanted)


def orthonormal(columns: Real, tolerance: float = ALIKE) -> Real:
    """Orthonormal basis of the columns, scaled first, so that their units do not matter."""
    return Tangent.of(columns, tolerance).basis


def non_negative(columns: Real, target: Real) -> tuple[Real, float]:
    """Weights >= 0 of columns (m, q) that come nearest to a target (m,).

    With the sum of squares that is left.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.numerics import non_negative
    >>> weights, left = non_negative(np.eye(2), np.array([3.0, -4.0]))
    >>> weights, left
    (array([3., 0.]), 16.0)
    """
    # Loading a command, or the plugins, must not take their time.
    import numpy as np
    from scipy.optimize import lsq_linear, nnls

    # Columns of one size: the active set is chosen by slopes, which depend on the units otherwise.
    size = np.linalg.norm(columns, axis=0)
    # One whose squares are below any number is none.
    seen = size > 0.0
    size = np.where(seen, size, 1.0)
    scaled = np.where(seen, columns, 0.0) / size
    system, wanted = scaled, target
    if scaled.shape[0] > 2 * scaled.shape[1]:
        # The same problem in as many rows as columns: the active set then moves among small
        # matrices. With the target beside them no basis is needed, which would take twice as long.
        whole: Real = np.array(np.linalg.qr(np.column_stack([scaled, target]), mode="r"))
        system, wanted = whole[:-1, :-1], whole[:-1, -1]
    try:
        weights, _ = nnls(system, wanted)
    except RuntimeError:
        # Where columns are nearly one, the active set may go round in circles; an inner point does
        # not.
        weights = lsq_linear(system, wanted, (0.0, np.inf)).x
    # From the columns themselves: a mass that a spring takes back would leave a difference of large
    # squares.
    with np.errstate(all="ignore"):
        left = target - scaled @ weights
        cost = float(left @ left)
    # What is too large for a number is no fit.
    if not np.isfinite(cost):
        cost = np.inf
    return weights / size, cost
