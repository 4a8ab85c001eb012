"""A model whose parameters are known, and how well, whatever tests they were found from.

What it says of another test than the measured one, and how surely.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from difflib import get_close_matches
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.distributions import student
from springpot.errors import DataError, ModelError
from springpot.lazy import Drawn
from springpot.measurement.covered import Covered, between
from springpot.measurement.measurement import Measurement, points_at
from springpot.measurement.rows import Moduli
from springpot.measurement.units import Units
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Complex, Points, Real, held
from springpot.thresholds import INTERVAL
from springpot.writing import LISTED, NAMED, listed, suggested, table, tag

from ..numerics import NEGLIGIBLE, ROUNDING, SMALLEST, rows_of_levels
from .kept import called
from .normal import Bordered, Covariance, spread_of

SCHEMA = "springpot.prediction/2"
AT_REST = (-80.0, -160.0, -320.0, -640.0)
"""Logarithms of the angular frequency on the way to rest.

A springpot of order 0.05 has fallen by 14 decades at the
last, and beyond -700 the frequency itself is no number."""
KNOWN_TO_EFFECTS = ("amplitude", "temperature")
"""Conditions that effects of a library may need."""
FAR_KELVIN = 150.0
"""Further than this above all measured temperatures, a number is rather one in kelvin.

The laws of temperature hold
for about 100 K above the glass transition (Williams, Landel and Ferry 1955,
doi:10.1021/ja01619a008).
"""
UNDETERMINED = 1e12
"""Variance of a coordinate that the tests do not determine: a million natural sizes."""


@dataclass(frozen=True, eq=False)
class Prediction(Moduli, Drawn):
    """What a fitted model says of a test, with a band.

    Its picture has K' and K'' with their bands.

    Its columns are named as those of a `Measurement`.

    Attributes
    ----------
    model : str
        The model expression.
    omega : ndarray, shape (n,)
        Angular frequency in rad/s; may be zero.
    stiffness : ndarray of complex, shape (n,)
        K' + i K'' in ``units.stiffness``.
    low, high : ndarray of complex, shape (n,)
        Ends of the bands of K' (real part) and of K'' (imaginary part); infinite where the data say
        nothing. The band is that of the model's curve: it holds the uncertainty of the parameters,
        not the scatter of a new test.
    conditions : mapping of str to ndarray, shape (n,)
        ``temperature`` in degC, ``amplitude`` in ``units.amplitude``, others by name.
    units : Units
        Those of the measurement that was fitted.
    level : float
        Probability of the band.
    covered : Covered
        What was measured.
    words : mapping of str to sequence of str
        What the levels of numbered conditions are called.
    """

    model: str
    omega: Real
    stiffness: Complex
    low: Complex
    high: Complex
    conditions: Mapping[str, Real] = field(default_factory=dict)
    units: Units = field(default_factory=Units)
    level: float = 0.95
    covered: Covered = field(default_factory=Covered)
    words: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "conditions", dict(self.conditions))

    @cached_property
    def outside(self) -> NDArray[np.bool_]:
        """Whether each point lies outside of the measured frequencies or conditions, shape (n,)."""
        return self.covered.outside(self.omega, self.conditions)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What else one should know."""
        # A band knows the uncertainty of the parameters only, and nothing of a model that fails out
        # there.
        remark = self.covered.remark(self.omega, self.conditions, self.units)
        return tuple(filter(None, [remark]))

    @property
    def loss_factor(self) -> Real:
        """Tan delta = K'' / K', shape (n,)."""
        # K' is zero at a resonance: tan delta is infinite there, and no fault.
        with np.errstate(all="ignore"):
            return self.loss / self.storage

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.prediction/2``; a band without an end has None."""
        return {
            "schema": SCHEMA,
            "model": self.model,
            "level": self.level,
            "unit": self.units.stiffness,
            "points": [
                {**dict(zip(self._headers(), row, strict=True)), "outside_measured": outside}
                for row, outside in zip(self.rows(), self.outside.tolist(), strict=True)
            ],
            "measured": self.covered.to_dict(),
            "notes": list(self.notes),
        }

    def _headers(self) -> tuple[str, ...]:
        ends = ("storage_low", "storage_high", "loss_low", "loss_high")
        return ("frequency", "omega", *self.conditions, "storage", "loss", *ends)

    @property
    def places(self) -> dict[str, list[float | str]]:
        """The conditions of each point: a number, or what a numbered level is called."""
        told = self.conditions.items()
        return {name: called(self.words, name, column.tolist()) for name, column in told}

    def rows(self) -> Iterator[tuple[float | str, ...]]:
        """Frequency, omega, conditions, K', K'' and the ends of their bands, point by point."""
        ends = [self.low.real, self.high.real, self.low.imag, self.high.imag]
        before, after = [self.frequency, self.omega], [self.storage, self.loss, *ends]
        columns = [column.tolist() for column in before], [column.tolist() for column in after]
        yield from zip(*columns[0], *self.places.values(), *columns[1], strict=True)

    def __repr__(self) -> str:
        return f"<Prediction of {self.model}: {len(self)} points, [{self.units.stiffness}]>"

    def _repr_html_(self) -> str:
        rows = [[c if isinstance(c, str) else f"{c:.4g}" for c in row] for row in self.rows()]
        title = f"{self.model}, [{self.units.stiffness}], band of {100 * self.level:.0f} %"
        notes = tag("ul", *(tag("li", note) for note in self.notes))
        return tag("div", tag("p", tag("b", title)), table(self._headers(), rows), notes)


@dataclass(frozen=True, eq=False, kw_only=True)
class Known:
    """A model with its parameters and how well they are known.

    Attributes
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters, in `units`.
    slopes : ndarray, shape (p, q)
        Their derivative by the coordinates in which their uncertainty is told; where levels have
        parameters of their own, level by level (G, r, r).
    spread : ndarray, shape (q, q), or Bordered
        Covariance of these; infinite variance where the tests say nothing.
    leanings : ndarray, shape (p, b), optional
        Moves of theta by one standard deviation away from each bound that a parameter rests on,
        of which the covariance knows nothing: it may go one way alone.
    units : Units
        Of the tests that they were fitted to.
    reference : float
        Temperature in kelvin at which shifts are one.
    misfit : float
        Relative error that the fit itself has.
    dof : float
        Degrees of freedom behind the covariance.
    covered : Covered
        What the fitted tests measured.
    sweep : Measurement, optional
        The sweep that was fitted, where it stands alone: its frequencies and conditions are meant
        where none are given.
    words : mapping of str to sequence of str
        What the levels of a numbered column are called, in the order of their numbers.
    """

    model: Model
    theta: Real
    slopes: Real
    spread: Covariance
    leanings: Real | None = None
    units: Units
    reference: float
    misfit: float = 0.0
    dof: float = 1.0
    covered: Covered = field(default_factory=Covered)
    sweep: Measurement | None = None
    words: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def _told(self) -> dict[str, Any]:
        """What is known, by name."""
        return {each.name: getattr(self, each.name) for each in fields(Known)}

    def of_level(self, number: int) -> Known:
        """What is known of one of the levels that have parameters of their own."""
        assert isinstance(self.spread, Bordered), "levels have parameters of their own"
        model, places = self.model.of_any_level, self.spread.layout.places[number]
        told = {"model": model, "theta": self.theta[places], "slopes": self.slopes[number]}
        # Where levels have parameters of their own nothing is told of bounds.
        told["leanings"] = None
        return Known(**{**self._told(), **told, "spread": self.spread.of_levels[number]})

    def at_level(self, conditions: Mapping[str, ArrayLike]) -> Known:
        """What is known of the level that conditions name; itself where levels have nothing own.

        Raises
        ------
        DataError
            If they do not say which level is meant, or name none.
        """
        if not self.model.own:
            return self
        (column,) = set(self.model.own.values())
        if column not in conditions:
            names = self.words.get(column) or self.model.level_values[column]
            raise DataError(
                f"each {column} has parameters of its own: say which, {column}={names[0]}"
                f" (of {listed(names, LISTED)})"
            )
        at = points_at(
            np.zeros(1), {column: _numbers(self, column, conditions[column])}, self.reference
        )
        number = int(self.model.levels(at)[0])
        if isinstance(self.spread, Bordered):
            return self.of_level(number)
        places = self.model.places[number]
        told = {"model": self.model.of_any_level, "theta": self.theta[places]}
        if self.leanings is not None:
            told["leanings"] = self.leanings[places]
        return Known(**{**self._told(), **told, "slopes": self.slopes[places]})

    def named(self, at: Mapping[str, float | str]) -> dict[str, float | str]:
        """Conditions, where levels of the data have names by these."""
        return {name: called(self.words, name, [value])[0] for name, value in at.items()}

    @property
    def of_specimen(self) -> Known:
        """The model without what the tests did themselves: a drift does not go into another one."""
        model = self.model.of_specimen
        kept = list(range(len(model.parameters)))
        return Known(**{**self._told(), **self._of(model, kept)})

    def _of(self, model: Model, kept: list[int]) -> dict[str, Any]:
        """What changes where a part of the model is left, with some of its parameters."""
        told = {"model": model, "theta": self.theta[kept], "spread": self.spread}
        if self.leanings is not None:
            told["leanings"] = self.leanings[kept]
        slopes = self.slopes
        if isinstance(self.spread, Bordered) and len(kept) < len(self.theta):
            slopes, told["spread"] = self.spread.layout.matrix(slopes), self.spread.dense()
        # Of levels the slopes are those of each, and all are kept.
        return {**told, "slopes": slopes[kept] if slopes.ndim == 2 else slopes}

    @property
    def theta_covariance(self) -> Real:
        """Covariance (p, p) of the parameters; what the tests leave open has a huge variance."""
        if isinstance(self.spread, Bordered):
            return np.nan_to_num(self.spread.carried(self.slopes).dense(), posinf=UNDETERMINED)
        # An endless variance times a slope of zero would be no number.
        spread = np.nan_to_num(self.spread, nan=0.0, posinf=UNDETERMINED)
        return self.slopes @ spread @ self.slopes.T

    def ways(self, sd: Real, by_theta: Real) -> tuple[Real, Real]:
        """Standard deviations (n,) downwards and up, of what goes with theta by `by_theta` (n, p).

        Parameters
        ----------
        sd : ndarray, shape (n,)
            What the covariance says of either way.
        by_theta : ndarray, shape (n, p)
            The derivatives.
        """
        if self.leanings is None:
            return sd, sd
        moves = by_theta @ self.leanings
        down, up = (np.linalg.norm(np.maximum(each, 0.0), axis=1) for each in (-moves, moves))
        return np.hypot(sd, down), np.hypot(sd, up)

    def without(self, names: Iterable[str]) -> Known:
        """The same without some of its effects, such as those of the rig that it was tested in.

        Raises
        ------
        ModelError
            If it has none of that name.
        """
        model = self.model
        for name in names:
            model = model - name
        places = {name: i for i, name in enumerate(self.model.names)}
        return replace(self, **self._of(model, [places[name] for name in model.names]))

    def predict(
        self,
        frequency: ArrayLike | None = None,
        *,
        omega: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        amplitude: ArrayLike | None = None,
        level: float = INTERVAL,
        **columns: ArrayLike,
    ) -> Prediction:
        """What the model says of another test, with a band.

        Parameters
        ----------
        frequency : array_like, shape (n,), optional
            In Hz; zero gives the limit at rest. Without it and `omega` the measured ones of a
            sweep.
        omega : array_like, shape (n,), optional
            Angular frequency in rad/s instead.
        temperature : array_like, one or (n,), optional
            In degC; constants of shifts refer to the reference temperature of the fit.
        amplitude : array_like, one or (n,), optional
            In the amplitude unit of the data.
        level : float
            Probability of the band.
        **columns : array_like, one or (n,)
            Other conditions by name.

        Returns
        -------
        Prediction
            With omega, storage, loss, low and high, in the unit of the data.

        Raises
        ------
        DataError
            If the columns cannot be, or one that the model needs is missing.
        ModelError
            If the model knows nothing of a condition whose change is asked for.
        """
        given = {"temperature": temperature, "amplitude": amplitude, **columns}
        wanted = {name: column for name, column in given.items() if column is not None}
        rate = _rate(self.sweep, frequency, omega)
        conditions = _conditions(self, wanted, rate)
        count = max([len(rate), *(len(column) for column in conditions.values())])
        try:
            rate = np.broadcast_to(rate, count)
            conditions = {n: np.broadcast_to(column, count) for n, column in conditions.items()}
        except ValueError:
            lengths = ", ".join(f"{len(column)} of {name}" for name, column in conditions.items())
            raise DataError(
                f"give one value or as many as frequencies: there are {len(rate)}, and {lengths}"
            ) from None
        # By the linear law of error propagation, as the intervals of the parameters are.
        value, down, up = _value_and_ways(self, rate, conditions)
        times = student(level, self.dof)
        low, high = (
            _of_parts(value.real + s * sd.real, value.imag + s * sd.imag)
            for s, sd in ((-times, down), (times, up))
        )
        units = self.units
        # Told in the frequencies in which it was asked.
        if omega is not None:
            units = replace(units, clock="rad/s")
        elif frequency is not None:
            units = replace(units, clock="Hz")
        name, covered = self.model.name, self.covered
        band = value, low, high
        return Prediction(name, rate, *band, conditions, units, level, covered, self.words)


def _rate(sweep: Measurement | None, frequency: ArrayLike | None, omega: ArrayLike | None) -> Real:
    """Angular frequencies (n,) that are asked for; the measured ones where none are."""
    if frequency is not None and omega is not None:
        raise DataError("give frequency [Hz] or omega [rad/s], not both")
    if frequency is None and omega is None:
        if sweep is None:
            raise DataError("give frequency [Hz] or omega [rad/s]: tests in time have none")
        return sweep.omega
    given = omega
    if given is None:
        given = frequency
    try:
        column = np.atleast_1d(np.asarray(given, dtype=float))
    except (TypeError, ValueError):
        raise DataError("frequency [Hz] and omega [rad/s] are numbers") from None
    if column.ndim != 1 or not (np.all(np.isfinite(column)) and np.all(column >= 0.0)):
        raise DataError("frequencies are a list of numbers, finite and not negative")
    if omega is None:
        return column * 2.0 * np.pi
    return column


def _conditions(known: Known, given: Mapping[str, ArrayLike], rate: Real) -> dict[str, Real]:
    """Conditions that are asked for, each as a column of one value or one for each point."""
    model, data = known.model, known.sweep
    own = {name: _numbers(known, name, column) for name, column in given.items()}
    for name, column in own.items():
        if not np.all(np.isfinite(column)):
            raise DataError(f"{name} must be finite numbers")
        _check_condition(known, name, column)
    for name in sorted(model.needs - set(own)):
        if name not in known.covered.conditions:
            raise DataError(f"{model.name} needs {name}: say {name}=...")
        measured = np.array(known.covered.conditions[name])
        # At the measured frequencies each point has its own; elsewhere only what was the same for
        # all is known.
        if data is not None and len(rate) == len(data) and np.array_equal(rate, data.omega):
            own[name] = data.conditions[name]
        elif float(np.ptp(measured)) <= float(held(name, measured).max()):
            own[name] = np.array([float(np.mean(measured))])
        else:
            span = known.covered.span(name, known.units)
            raise DataError(f"{model.name} depends on {name}, measured at a {span}: say {name}=...")
    return own


def _numbers(known: Known, name: str, given: ArrayLike) -> Real:
    """A column (n,) of what is asked for: numbers, or what levels of the data are called."""
    words = list(known.words.get(name, ()))
    if not words or not isinstance(given, str):
        try:
            return np.atleast_1d(np.asarray(given, dtype=float))
        except (TypeError, ValueError):
            raise DataError(f"{name} must be finite numbers") from None
    if given not in words:
        near = get_close_matches(given, words)
        close = [*near, *(word for word in words if word not in near)]
        raise DataError(f"{name} has no '{given:.40}': there are {listed(close, NAMED)}")
    return np.array([1.0 + words.index(given)])


def _check_condition(known: Known, name: str, column: Real) -> None:
    """Refuse what would give a wrong number without a word."""
    if name == "temperature":
        reference = known.reference - KELVIN
        _, warmest = known.covered.conditions.get(name, (reference, reference))
        if np.any(column < -KELVIN):
            raise DataError(
                f"temperature={column.min():g} is below the absolute zero of -273.15 degC"
            )
        if np.any(column > warmest + FAR_KELVIN):
            raise DataError(
                f"temperature={column.max():g} looks like kelvin: give it in degC, as in the data"
            )
    require_known(known.model, known.covered, name, column)


def require_known(model: Model, covered: Covered, name: str, column: Real) -> None:
    """Check that a condition is one that the model knows, or was measured.

    There the fit holds without knowing it.

    Raises
    ------
    ModelError
        If it is neither.
    """
    if name in model.needs:
        return
    span = "was not measured"
    if name in covered.conditions:
        if name not in covered.beyond(np.ones(len(column)), {name: column}):
            return
        span = f"was {between(*covered.conditions[name])}"
    hint = ""
    # Any other column is known to effects that are given its name.
    if name in KNOWN_TO_EFFECTS:
        hint = f", one that '{suggested('list effects')}' says needs it"
    raise ModelError(
        f"{model.name} does not know {name}, which {span}: fit a model with an effect of it{hint}"
    )


def _value_and_ways(
    known: Known, rate: Real, conditions: Mapping[str, Real]
) -> tuple[Complex, ...]:
    """K (n,), and the standard deviations of its parts downwards and up; at rest all are limits."""
    with np.errstate(divide="ignore"):
        log_omega = np.log(rate)
    still = ~np.isfinite(log_omega)
    found = _at(known, np.where(still, AT_REST[0], log_omega), conditions)
    if not np.any(still):
        return found
    # At rest K may be zero, which limits approach but never reach: so little is none.
    slowest = np.where(still, np.log(max(known.covered.rate[0], SMALLEST)), log_omega)
    tiny = ROUNDING * float(np.min(np.abs(_at(known, slowest, conditions)[0])))
    for place in AT_REST:
        nearer = _at(known, np.where(still, place, log_omega), conditions)
        # A limit that is no number further out keeps the last one that was.
        good = still & np.isfinite(nearer[0])
        found = tuple(np.where(good, *both) for both in zip(nearer, found, strict=True))
    return tuple(_without_rounding(each, still, tiny) for each in found)


def _without_rounding(values: Complex, still: NDArray[np.bool_], tiny: float) -> Complex:
    """Parts at rest that are no more than rounding are zero."""
    parts = [
        np.where(still & (np.abs(part) < tiny), 0.0, part) for part in (values.real, values.imag)
    ]
    return _of_parts(*parts)


def _of_parts(real: Real, imaginary: Real) -> Complex:
    """Both parts as they are: times i an infinite one would make the other no number."""
    whole = np.empty(np.shape(real), dtype=np.complex128)
    whole.real, whole.imag = real, imaginary
    return whole


def _at(known: Known, log_omega: Real, conditions: Mapping[str, Real]) -> tuple[Complex, ...]:
    # At the reference of the fit: constants of shifts mean something there only.
    points = points_at(log_omega, conditions, known.reference)
    if isinstance(known.spread, Bordered):
        return _at_levels(known, points, log_omega, conditions)
    with np.errstate(all="ignore"):
        value = known.model.stiffness(known.theta, points)
        # At rest a derivative may be no number: what does not move K there adds nothing to the
        # band.
        by_theta = np.nan_to_num(known.model.jacobian(known.theta, points))
        by_u = by_theta @ known.slopes
    parts = []
    for by, moved in ((by_u.real, by_theta.real), (by_u.imag, by_theta.imag)):
        sd = spread_of(by, known.spread, NEGLIGIBLE * np.abs(value)[:, None])
        parts.append(known.ways(sd, moved))
    return value, *(_of_parts(*both) for both in zip(*parts, strict=True))


def _at_levels(
    known: Known, points: Points, log_omega: Real, conditions: Mapping[str, Real]
) -> tuple[Complex, ...]:
    """The same, each point by what is known of its level."""
    number = known.model.levels(points)
    found = np.empty((3, len(number)), dtype=np.complex128)
    for level, rows in enumerate(rows_of_levels(number, len(known.model.places))):
        if len(rows):
            some = {name: column[rows] for name, column in conditions.items()}
            found[:, rows] = _at(known.of_level(level), log_omega[rows], some)
    return tuple(found)
