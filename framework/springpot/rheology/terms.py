"""Formulas as trees: each part gives its value and its exact slopes by forward differentiation."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..numerics import ALIKE, LARGEST, ROUNDING, SMALLEST
from .points import HALF_PI, Real, power_of_s

FOUR_OVER_PI = 4.0 / np.pi


def slip_fraction(rho: Any) -> tuple[Any, Any]:
    """K / k of a spring in series with a slider, and its derivative by rho.

    Parameters
    ----------
    rho : ndarray
        Slip force over k X; from 1 on the slider sticks and the element is a plain spring, and
        below nothing, which no force is, there is none.
    """
    # Where it sticks there is no loop: any number inside keeps the arc cosine in its range.
    sticks, none = np.real(rho) >= 1.0, np.real(rho) < 0.0
    beta = np.arccos(1.0 - 2.0 * np.where(sticks | none, 0.5, rho))
    value = (beta - 0.5 * np.sin(2.0 * beta) + 1j * np.sin(beta) ** 2) / np.pi
    slope = FOUR_OVER_PI * (np.sin(beta) + 1j * np.cos(beta))
    value, slope = np.where(sticks, 1.0, value), np.where(sticks, 0.0, slope)
    return np.where(none, 0.0, value), np.where(none, 0.0, slope)


LOG_OMEGA = ""
"""Under which a slope by ln omega is kept, beside those by the parameters' names."""

Slopes: TypeAlias = Mapping[str, Any]


class Dual(NamedTuple):
    """A value with its derivatives; what it does not depend on is not named.

    Attributes
    ----------
    value : number or ndarray
        Whatever broadcasts with the points.
    slopes : mapping of str
        Derivatives by parameter, and by ln omega under `LOG_OMEGA`.
    """

    value: Any
    slopes: Slopes


def _times(slopes: Slopes, factor: Any) -> dict[str, Any]:
    return {name: slope * factor for name, slope in slopes.items()}


def _merged(a: Slopes, b: Slopes) -> Slopes:
    if not (a and b):
        return a or b
    merged = dict(a)
    for name, slope in b.items():
        merged[name] = merged[name] + slope if name in merged else slope
    return merged


def _difference(a: Dual, b: Dual) -> Dual:
    return Dual(a.value - b.value, _merged(a.slopes, _times(b.slopes, -1.0)))


def _product(a: Dual, b: Dual) -> Dual:
    # A number, or what was worked out before, is a factor of the other's slopes alone.
    if not a.slopes:
        return Dual(a.value * b.value, _times(b.slopes, a.value))
    if not b.slopes:
        return Dual(a.value * b.value, _times(a.slopes, b.value))
    return Dual(a.value * b.value, _merged(_times(a.slopes, b.value), _times(b.slopes, a.value)))


def _quotient(a: Dual, b: Dual) -> Dual:
    value = a.value / b.value
    if not b.slopes:
        return Dual(value, {name: slope / b.value for name, slope in a.slopes.items()})
    if not a.slopes:
        return Dual(value, _times(b.slopes, -value / b.value))
    return Dual(value, _merged(_times(a.slopes, 1.0 / b.value), _times(b.slopes, -value / b.value)))


def _larger(a: Dual, b: Dual, sign: float = 1.0) -> Dual:
    # By the real parts: a complex step of a derivative must pass through.
    first = sign * np.real(a.value) >= sign * np.real(b.value)
    slopes = {
        name: np.where(first, a.slopes.get(name, 0.0), b.slopes.get(name, 0.0))
        for name in {**a.slopes, **b.slopes}
    }
    return Dual(np.where(first, a.value, b.value), slopes)


JOINED: dict[str, Callable[[Dual, Dual], Dual]] = {
    "+": lambda a, b: Dual(a.value + b.value, _merged(a.slopes, b.slopes)),
    "-": _difference,
    "*": _product,
    "/": _quotient,
    "max": _larger,
    "min": lambda a, b: _larger(a, b, -1.0),
}
"""What joins two parts, with the rule of its derivative."""

CALLED: dict[str, tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]] = {
    "exp": (np.exp, lambda x, value: value),
    "log": (np.log, lambda x, value: 1.0 / x),
    "sqrt": (np.sqrt, lambda x, value: 0.5 / value),
    "tanh": (np.tanh, lambda x, value: 1.0 - value**2),
    "slider": (lambda x: slip_fraction(x)[0], lambda x, value: slip_fraction(x)[1]),
    "abs": (lambda x: x * np.sign(np.real(x)), lambda x, value: np.sign(np.real(x))),
}
"""Functions of one part: value and slope, the slope from argument and value.

A slider leaves of a spring k that slips at the force r k X the share slider(r)."""

OF_REAL = frozenset({"abs", "max", "min", "slider"})
"""Functions that complex numbers have no slope of."""


@dataclass(frozen=True)
class Term:
    """A part of a formula.

    Parameters
    ----------
    place : int
        The sign of the text at which it begins, counted from 1.
    """

    place: int

    @property
    def parts(self) -> tuple[Term, ...]:
        """What it is made of."""
        return ()

    @property
    def real(self) -> bool:
        """Whether it is real wherever parameters and columns are."""
        return all(part.real for part in self.parts)

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """Value and slopes, of what each name stands for."""
        raise AssertionError(f"{type(self).__name__} has no value")

    def walk(self) -> Iterator[Term]:
        """The part itself and all within it, in the order of the text."""
        yield self
        for part in self.parts:
            yield from part.walk()


@dataclass(frozen=True)
class Number(Term):
    """A number; ``R`` has a unit."""

    value: complex
    name: str = ""

    @property
    def real(self) -> bool:
        """Whether it has no imaginary part."""
        return self.value.imag == 0.0

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """The number, which has no slopes."""
        if self.real:
            return Dual(self.value.real, {})
        return Dual(self.value, {})


@dataclass(frozen=True)
class Name(Term):
    """A variable, a column or a parameter."""

    name: str

    @property
    def real(self) -> bool:
        """Whether it is not s = i omega."""
        return self.name != "s"

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """What it stands for."""
        return known[self.name]


@dataclass(frozen=True)
class WorkedOut(Term):
    """A part that no parameter moves, worked out."""

    dual: Dual

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """What it is."""
        return self.dual


@dataclass(frozen=True)
class Joined(Term):
    """Two parts and what joins them: a sign, or one of max and min."""

    sign: str
    left: Term
    right: Term

    @property
    def parts(self) -> tuple[Term, ...]:
        """Both."""
        return (self.left, self.right)

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """Both together."""
        return JOINED[self.sign](self.left.at(known), self.right.at(known))


@dataclass(frozen=True)
class Called(Term):
    """A function of one part."""

    function: str
    inner: Term

    @property
    def real(self) -> bool:
        """Whether it has no imaginary part, as the loop of a slider has."""
        return self.function != "slider" and self.inner.real

    @property
    def parts(self) -> tuple[Term, ...]:
        """The argument."""
        return (self.inner,)

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """The function, and its slope by the chain rule."""
        inner = self.inner.at(known)
        function, slope = CALLED[self.function]
        value = function(inner.value)
        if not inner.slopes:
            return Dual(value, {})
        return Dual(value, _times(inner.slopes, slope(inner.value, value)))


@dataclass(frozen=True)
class Power(Term):
    """A part raised to another, real one."""

    base: Term
    exponent: Term

    @property
    def parts(self) -> tuple[Term, ...]:
        """Base and exponent."""
        return (self.base, self.exponent)

    def at(self, known: Mapping[str, Dual]) -> Dual:
        """d(b^e) = b^e (ln b de + e db / b)."""
        exponent = self.exponent.at(known)
        if isinstance(self.base, Name) and self.base.name == "s":
            return self._of_s(known[LOG_OMEGA].value, exponent)
        base = self.base.at(known)
        whole = self._of_any(base, exponent)
        # NaN is none of these: it stays what it is.
        beyond = np.abs(whole.value) > LARGEST
        if not beyond.any():
            return whole
        # Nor must a solver be drawn further where nothing changes.
        kept = {name: np.where(beyond, 0.0, slope) for name, slope in whole.slopes.items()}
        return Dual(np.where(beyond, LARGEST, whole.value), kept)

    def _of_any(self, base: Dual, exponent: Dual) -> Dual:
        value, under = base.value**exponent.value, base.value
        if not (base.slopes or exponent.slopes):
            return Dual(value, {})
        if not np.all(under):
            # What is nothing to a power has no logarithm, and stays nothing: max(0, X - Xc)^n.
            under = np.where(under == 0.0, 1.0, under)
        slopes = _times(base.slopes, exponent.value * value / under)
        if not exponent.slopes:
            return Dual(value, slopes)
        grown = _times(exponent.slopes, value * np.log(under))
        return Dual(value, _merged(slopes, grown))

    def _of_s(self, log_omega: Any, exponent: Dual) -> Dual:
        # A complex power costs eighty times as much as the real exponentials that it is made of.
        value = power_of_s(exponent.value, log_omega)
        slopes = {LOG_OMEGA: exponent.value * value}
        grown = _times(exponent.slopes, value * (log_omega + HALF_PI))
        return Dual(value, _merged(slopes, grown))


def settled(term: Term, known: Mapping[str, Dual], free: Collection[str]) -> Term:
    """The same formula, of which whatever has no free name is worked out once and for all.

    Parameters
    ----------
    term : Term
        The formula.
    known : mapping of str to Dual
        The other names.
    free : collection of str
        Names that are not known yet.
    """
    if not term.parts:
        return term
    if not any(isinstance(part, Name) and part.name in free for part in term.walk()):
        return WorkedOut(term.place, term.at(known))
    match term:
        case Joined(left=left, right=right):
            return replace(term, left=settled(left, known, free), right=settled(right, known, free))
        case Called(inner=inner):
            return replace(term, inner=settled(inner, known, free))
        case Power(base=base, exponent=exponent):
            return replace(
                term, base=settled(base, known, free), exponent=settled(exponent, known, free)
            )
    return term


def inverse(term: Term) -> Term:
    """One over a part; of what is typed as one over another, that other."""
    match term:
        case Joined(sign="/", left=Number(value=1), right=under):
            return under
    return Joined(term.place, "/", Number(term.place, 1.0 + 0j), term)


Modes: TypeAlias = NDArray[np.inexact[Any]]
"""Real rates, or complex ones of oscillations."""

BLOCK = 4096
"""Samples in work at a time: with some 100 modes they stay in the processor's cache."""
ROWS = 64
"""Parts of a block that are scanned side by side, as long as they are many."""
RUN = 64
"""Evenly spaced samples that are one product of matrices."""
SMALL = 1e-2
"""Below this |r h| the power series of g' is as exact as its closed form."""


def driven(rates: Modes, steps: Modes, changes: Real, mix: Modes, rate_mix: Modes) -> Modes:
    """Sums over modes q_j that follow the same input, without ever holding them all.

    Parameters
    ----------
    rates : ndarray, shape (m,)
        Of the modes, in 1/s.
    steps : ndarray, shape (n,)
        Time from the sample before to each sample, in (reduced) seconds; the first one is of no
        account.
    changes : ndarray, shape (n,) or (n, 3)
        Change of the input from the sample before to each sample, in which it is straight; or three
        columns: that change, and what its rate has of Legendre's P_1 and P_2 there, times the step.
    mix, rate_mix : ndarray, shape (m, c)
        How much of q_j, and of dq_j/dr_j, goes into each of the c outputs.

    Returns
    -------
    ndarray, shape (n, c)
        q @ mix + dq/dr @ rate_mix.
    """
    n, kind = len(steps), np.result_type(rates, steps, changes, mix)
    out = np.zeros((n, mix.shape[1]), dtype=kind)
    if not len(rates):
        return out
    changes = changes.reshape(n, -1)
    # Only modes whose rate is asked for need the second, costlier recursion of the slopes.
    moving = np.flatnonzero(np.any(rate_mix != 0.0, axis=1))
    last, last_slope = np.zeros(len(rates), dtype=kind), np.zeros(len(moving), dtype=kind)
    inner = steps[1:]
    # A few runs are not worth their kernel.
    if n > 4 * RUN and not np.iscomplexobj(inner) and np.ptp(inner) <= ALIKE * np.max(inner):
        return _driven_evenly(rates, float(np.mean(inner)), changes, mix, rate_mix)
    for start in range(0, n, BLOCK):
        part = slice(start, min(start + BLOCK, n))
        ways, step = changes[part].T[..., None], steps[part][:, None]
        decay, gains, gain_slopes = _steps(rates, step, len(ways), moving)
        q = _scan(decay, _summed(gains, ways), last)
        if len(moving):
            # dq/dr obeys the same recursion, driven by the derivatives of its two factors.
            before = np.vstack([last[moving], q[:-1, moving]])
            kicks = _summed(gain_slopes, ways) - step * decay[:, moving] * before
            turned = _scan(decay[:, moving], kicks, last_slope)
            out[part] = turned @ rate_mix[moving]
            last_slope = turned[-1]
        out[part] += q @ mix
        last = q[-1]
    return out


def mean_of_exponential(first: Modes, last: Modes) -> Modes:
    """Mean of exp(y) where y runs linearly from `first` to `last`."""
    return np.exp(first) * _decay(np.ones(1), first - last)[1]


def _summed(gains: Sequence[Modes], ways: Modes) -> Modes:
    """What the shapes of a step (d, n, 1) add to each mode (n, m), each by its gain."""
    total: Modes = gains[0] * ways[0]
    for gain, way in zip(gains[1:], ways[1:], strict=True):
        total = total + gain * way
    return total


def _decay(rates: Modes, step: Modes) -> tuple[Modes, Modes]:
    """What is left of a mode after a step, and how much of a straight change it takes."""
    z = rates * step
    # 1 - exp(-z) as it stands would lose all digits of a slow mode in a short step.
    lost = -np.expm1(-z)
    gain = np.where(np.abs(z) < ROUNDING, 1.0, lost / np.where(z == 0.0, 1.0, z))
    return 1.0 - lost, gain


def _steps(
    rates: Modes, step: Modes, shapes: int, moving: NDArray[np.intp]
) -> tuple[Modes, list[Modes], list[Modes]]:
    """The same as `_step`, worked out once for all steps (n, 1) that are equally long."""
    units = np.round(step[:, 0] / (ROUNDING * np.max(np.abs(step), initial=SMALLEST)))
    _, first, which = np.unique(units, return_index=True, return_inverse=True)
    if 2 * len(first) > len(step):
        return _step(rates, step, shapes, moving)
    decay, *rest = _step(rates, step[first], shapes, moving)
    gains, slopes = ([each[which] for each in of_kind] for of_kind in rest)
    return decay[which], gains, slopes


def _step(
    rates: Modes, step: Modes, shapes: int, moving: NDArray[np.intp]
) -> tuple[Modes, list[Modes], list[Modes]]:
    """The decay (n, m) of a step, the gains of each shape, and the slopes of those by some rates.

    Of a rate with Legendre's P_k the gain is exp(-z/2) i_k(z/2), with the modified spherical Bessel
    function (Abramowitz & Stegun 1964, 10.2): by recursion, whose derivatives need the next one.
    """
    decay, gain = _decay(rates, step)
    gains, slopes = [gain], [_gain_slope(rates[moving], step)]
    if shapes > 1:
        z = rates * step
        one, two, three = _bessel(z, decay, gain)
        gains += [one, two]
        g0, g1, g2, g3 = (each[:, moving] for each in (gain, one, two, three))
        slopes += [
            step * ((g0 + 2.0 * g2) / 6.0 - 0.5 * g1),
            step * ((2.0 * g1 + 3.0 * g3) / 10.0 - 0.5 * g2),
        ]
    return decay, gains, slopes


def _bessel(z: Modes, decay: Modes, gain: Modes) -> list[Modes]:
    """exp(-z/2) i_k(z/2) for k = 1, 2, 3."""
    near = np.abs(z) < 1.0
    far = np.where(near, 1.0, z)
    one = (1.0 + decay - 2.0 * gain) / far
    two = gain - 6.0 * one / far
    found = [one, two, one - 10.0 * two / far]
    # Upwards the recursion loses digits where z is small: there the power series takes over.
    half = 0.5 * z[near]
    lead, square = np.exp(-half), 0.5 * half * half
    for k, each in enumerate(found, start=1):
        lead = lead * half / (2 * k + 1)
        total = np.ones_like(half)
        for j in range(5, 0, -1):
            total *= square / (j * (2 * (k + j) + 1))
            total += 1.0
        each[near] = lead * total
    return found


def _gain_slope(rates: Modes, step: Modes) -> Modes:
    """Derivative of the gain of a straight change by the rate."""
    z = rates * step
    near = np.abs(z) < SMALL
    far = np.where(near, 1.0, z)
    # Its two terms cancel where z is small: there the series takes over.
    closed = (np.exp(-far) - -np.expm1(-far) / far) / far
    series = -0.5 + z / 3.0 - z**2 / 8.0 + z**3 / 30.0 - z**4 / 144.0 + z**5 / 840.0
    return step * np.where(near, series, closed)


def _driven_evenly(rates: Modes, step: float, changes: Real, mix: Modes, rate_mix: Modes) -> Modes:
    """The same where all steps are alike: then what many samples do is one product of matrices.

    Samples are taken in runs of `RUN`. Within a run the outputs are a convolution with a short
    kernel; from run to run only the modes are carried, q and s = dq/dr, by the same recursion with
    longer steps.
    """
    n, (m, outputs) = len(changes), mix.shape
    runs = -(-n // RUN)
    _, gains, gain_slopes = _step(rates, np.array([[step]]), changes.shape[1], np.arange(m))
    # Of a change, k steps later (RUN + 1, m): what is left of q and of s.
    time = step * np.arange(RUN + 1)[:, None]
    fading = np.exp(-rates * time)
    lag = np.arange(RUN) - np.arange(RUN)[:, None]
    kind = np.result_type(rates, changes, mix, rate_mix)
    out = np.zeros((runs, RUN * outputs), dtype=kind)
    q, kicks = np.zeros((2, runs, m), dtype=kind)
    for way, gain, gain_slope in zip(changes.T, gains, gain_slopes, strict=True):
        # Filled up with changes of nothing, so that all runs are equally long.
        moved = np.zeros((runs, RUN), dtype=changes.dtype)
        moved.ravel()[:n] = way
        left, left_slope = gain * fading, (gain_slope - time * gain) * fading
        kernel = left[:RUN] @ mix + left_slope[:RUN] @ rate_mix
        within = np.where((lag >= 0)[..., None], kernel[lag], 0.0)  # (from, to, outputs)
        out = out + moved @ within.reshape(RUN, RUN * outputs)
        # What each run leaves behind by itself.
        q = q + moved @ left[RUN - 1 :: -1][:RUN]
        kicks = kicks + moved @ left_slope[RUN - 1 :: -1][:RUN]
    # And what had gathered before it.
    q = _before(fading[RUN], q)
    s = _before(fading[RUN], kicks - time[RUN] * fading[RUN] * q)
    later, times = fading[1:].T[..., None], time[1:]
    by_q = later * (mix[:, None] - times * rate_mix[:, None])
    out = out + q @ by_q.reshape(m, RUN * outputs)
    out = out + s @ (later * rate_mix[:, None]).reshape(m, RUN * outputs)
    return np.asarray(out.reshape(runs * RUN, outputs)[:n])


def _before(decay: Modes, kicks: Modes) -> Modes:
    """What the recursion q_k = decay q_(k-1) + kicks_k from rest holds before each step, (n, m)."""
    after = _scan(np.broadcast_to(decay, kicks.shape), kicks, np.zeros_like(kicks[0]))
    return np.vstack([np.zeros_like(kicks[:1]), after[:-1]])


def _scan(decay: Modes, kicks: Modes, start: Modes) -> Modes:
    """q_k = decay_k q_(k-1) + kicks_k for each mode, all (n, m)."""
    n, m = kicks.shape
    # A loop over all samples is slow in Python: this one runs over columns only, with all rows in
    # each step.
    columns = -(-n // ROWS)
    shape = (ROWS, columns, m)
    # Filled up with steps that change nothing, so that all rows are equally long.
    factors, q = (
        np.ones((ROWS * columns, m), dtype=kicks.dtype),
        np.zeros((ROWS * columns, m), dtype=kicks.dtype),
    )
    factors[:n], q[:n] = decay, kicks
    factors, q = factors.reshape(shape), q.reshape(shape)
    # Every row on its own first, all rows at once; then what each carries over into the next one.
    for k in range(1, columns):
        q[:, k] += factors[:, k] * q[:, k - 1]
        factors[:, k] *= factors[:, k - 1]
    carried = start
    for row in range(ROWS):
        q[row] += factors[row] * carried
        carried = q[row, -1]
    return q.reshape(-1, m)[:n]
