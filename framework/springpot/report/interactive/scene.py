"""What is drawn of data, and K of fitted models there.

At the measured points and on smooth curves between them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.identification.native import FittedModel
from springpot.identification.value import Value
from springpot.measurement.conversion import FILE
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import settings_of, told_apart
from springpot.measurement.opening import Test
from springpot.measurement.replicates import THINNED
from springpot.measurement.units import Units
from springpot.misfit.refit import Refit
from springpot.numerics import evenly, rms
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL, PLANES
from springpot.rheology.points import KELVIN, Complex, Points, Real
from springpot.writing import DIGITS as OF_RESIDUALS

from ..canvas import SWEEPS, DrawnSweep, chosen
from ..residuals import plane_name, plane_of
from ..views import DrawnAxis, axis_of, smooth, sweeps_of


class PageLimits(NamedTuple):
    """How much a page draws."""

    cloud: int
    """Further rows that are drawn as a density: more would look the same."""
    curves: int
    """Points on all smooth curves of one model together, and of its residuals in a plane.

    With thirty previews this keeps an answer below half a MB.
    """
    digits: int
    """Significant digits of what is drawn; a screen shows three."""
    step: int
    """Points of the curve of a test after a step."""
    rival: int
    """Points of a rival's curve: as many as the picture has columns of three pixels."""


DRAWN = PageLimits(cloud=20_000, curves=480, digits=6, step=120, rival=160)


def _words(units: Units) -> dict[str, Any]:
    """What things are called on the page."""
    return {
        "each": "sweep",
        "symbol": units.magnitude.strip("|*"),
        "magnitude": units.magnitude,
        "clock": units.clock,
        "per_hertz": units.on_clock(1.0),
    }


@dataclass(frozen=True, eq=False)
class PageScene:
    """Data as the page draws them.

    Parameters
    ----------
    measurement : Measurement
        All rows, those that are left out among them.
    leveled : Measurement, optional
        The same rows as a model sees them whose levels have parameters of their own: numbered.
    """

    measurement: Measurement
    leveled: Measurement | None = None

    @property
    def seen(self) -> Measurement:
        """The rows as the model sees them."""
        return self.leveled or self.measurement

    @cached_property
    def axis(self) -> DrawnAxis:
        """The column along which the data are drawn."""
        return axis_of(self.measurement)

    @cached_property
    def sweeps(self) -> list[DrawnSweep]:
        """The sweeps that are drawn."""
        measurement = self.measurement
        apart = {*told_apart(measurement), *({FILE} & settings_of(measurement).keys())}
        every = sweeps_of(measurement, self.axis, apart)
        # Of more than can be drawn no row is hidden for the sake of a column that no effect knows.
        if len(every) > SWEEPS.drawn:
            every = sweeps_of(measurement, self.axis)
        return chosen(every)

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """Numbers of the rows that are drawn: all, or evenly many of each sweep."""
        rows = np.concatenate([sweep.rows for sweep in self.sweeps])
        # Evenly along each sweep, its ends among them: a browser draws some thousand marks without
        # a pause.
        return rows[evenly(len(rows), THINNED.points)]

    @cached_property
    def thin(self) -> NDArray[np.int64]:
        """Which of the drawn rows the residuals of a preview are lines through."""
        step = max(1, int(np.ceil(len(self.rows) / DRAWN.curves)))
        return np.arange(0, len(self.rows), step)

    @cached_property
    def points(self) -> Points:
        """Where these rows were measured."""
        return _rows_of(self.seen.points, self.rows)

    @cached_property
    def grids(self) -> list[tuple[Real, Points]]:
        """For each sweep the places of its smooth curve along the axis, and their conditions."""
        whole = [smooth(self.seen, self.axis, sweep) for sweep in self.sweeps]
        # Each preview carries such a curve for each sweep: the page would otherwise grow by
        # megabytes.
        count = sum(len(x) for x, _ in whole)
        step = max(2, int(np.ceil(count / DRAWN.curves)))
        thin = []
        for x, points in whole:
            # With its last point, or a curve would end before its data.
            rows = np.unique(np.append(np.arange(0, len(x), step), len(x) - 1))
            thin.append((x[rows], _rows_of(points, rows)))
        return thin

    def to_dict(self) -> dict[str, Any]:
        """Rows, sweeps and axis, as the page needs them."""
        measurement, rows = self.measurement, self.rows
        sweep_of = np.zeros(len(measurement), dtype=int)
        for number, sweep in enumerate(self.sweeps):
            sweep_of[sweep.rows] = number
        conditions = {
            name: rounded(column[rows]) for name, column in measurement.conditions.items()
        }
        # Places of a diagnosis and planned frequencies are in Hz, whatever the data are told in.
        per_hertz = 1.0
        if self.axis.column == "frequency":
            per_hertz = measurement.units.on_clock(1.0)
        words = _words(measurement.units)
        planes = {
            plane.plane: {
                "name": plane_name(plane, measurement.units),
                "shows": plane.shows,
                "label": plane.label(measurement.units.stiffness).replace("K", words["symbol"]),
            }
            for plane in PLANES
        }
        return {
            "name": measurement.name,
            "count": len(measurement),
            "planes": planes,
            "thin": self.thin.tolist(),
            "units": {
                name: getattr(measurement.units, name) for name in ("stiffness", "amplitude")
            },
            "axis": {
                "column": self.axis.column,
                "label": self.axis.label,
                "logarithmic": self.axis.logarithmic,
                "per_hertz": per_hertz,
            },
            "words": words,
            "cloud": self._cloud(sweep_of),
            "rows": rows.tolist(),
            "x": rounded(self.axis.values[rows]),
            "omega": rounded(measurement.omega[rows]),
            "storage": rounded(measurement.storage[rows]),
            "loss": rounded(measurement.loss[rows]),
            "conditions": conditions,
            "sweep": sweep_of[rows].tolist(),
            "sweeps": [{"label": sweep.label, "points": len(sweep.rows)} for sweep in self.sweeps],
            "grids": [
                {"x": rounded(x), "omega": rounded(np.broadcast_to(points.omega, x.shape))}
                for x, points in self.grids
            ],
        }

    def _cloud(self, sweep_of: NDArray[np.int64]) -> dict[str, Any]:
        """Rows beside those that can be pointed at: as many as make a density."""
        rest = np.setdiff1d(np.arange(len(self.measurement)), self.rows)
        rest = rest[np.isin(rest, np.concatenate([sweep.rows for sweep in self.sweeps]))]
        rest = rest[evenly(len(rest), DRAWN.cloud)]
        columns = (self.axis.values, self.measurement.storage, self.measurement.loss)
        names = ("x", "storage", "loss")
        cloud = {
            name: rounded(column[rest], OF_RESIDUALS)
            for name, column in zip(names, columns, strict=True)
        }
        return {**cloud, "sweep": sweep_of[rest].tolist()}

    def whole(self, base: FittedModel) -> dict[str, Any]:
        """K of a fit at all drawn rows, the noise there, and what errors are shares of."""
        assert isinstance(base, Refit)
        fitted, drawn = base.fit.measurement.magnitude, self.measurement.magnitude[self.rows]
        # The noise is that of the fitted point of nearest |K|, as a share of it: points that are
        # drawn need not be those that were fitted, as repeats are fitted as their mean.
        order = np.argsort(fitted)
        nearest = order[np.clip(np.searchsorted(fitted[order], drawn), 0, len(fitted) - 1)]
        noise = base.noise.sd[nearest] / fitted[nearest] * drawn
        whole = self.curve(base.model, base.theta, np.maximum(noise.real, noise.imag))
        return {"of": self.measurement.units.magnitude, "noise": in_parts(noise), "model": whole}

    def error(self, tests: Sequence[Test], model: Model, theta: Real) -> float:
        """Relative error of a model over the rows of a sweep."""
        (sweep,) = tests
        assert isinstance(sweep, Measurement)
        return relative_error(sweep, model, theta)

    def curve(self, model: Model, theta: Real, sd: Real | None = None) -> dict[str, Any]:
        """K of a model on the smooth curves, and its residuals in each plane.

        Parameters
        ----------
        model : Model
            The model.
        theta : ndarray, shape (p,)
            Its parameters.
        sd : ndarray, shape (n,), optional
            Standard deviation of K at the drawn points. With it K is told there too, and residuals
            at all of them with the width of their noise; else at the thinned ones.
        """
        rows, width = self.thin, np.zeros(len(self.thin))
        if sd is not None:
            rows, width = np.arange(len(self.rows)), sd
        response = model.network.respond(theta, _rows_of(self.points, rows), FULL)
        measured, drawn = self.measurement.stiffness[self.rows[rows]], {}
        planes = {}
        for plane in PLANES:
            # What is no model at some point, or no loss at all, has no residual there.
            with np.errstate(all="ignore"):
                residual, noise = plane_of(plane, measured, response, width)
            planes[plane.plane] = in_parts(residual, OF_RESIDUALS)
            if sd is not None:
                planes[plane.plane]["width"] = rounded(noise, OF_RESIDUALS)
        if sd is not None:
            drawn["points"] = in_parts(response.value)
        curves = [in_parts(model.stiffness(theta, points)) for _, points in self.grids]
        return {**drawn, "curves": curves, "planes": planes}


def relative_error(measurement: Measurement, model: Model, theta: Real) -> float:
    """Root mean square of |K_model - K| / |K| over all rows, K being what was measured."""
    left = measurement.stiffness - model.stiffness(theta, measurement.points)
    return rms(np.abs(left / measurement.stiffness))


def rounded(values: Real, digits: int = DRAWN.digits) -> list[float | None]:
    """Numbers with as many digits as a picture needs; null for what is not finite."""
    values = np.asarray(values, dtype=float)
    finite = np.isfinite(values)
    # Neither zero nor an infinity has a first digit to count from.
    size = np.where(finite & (values != 0.0), np.abs(values), 1.0)
    scale = 10.0 ** (digits - 1 - np.floor(np.log10(size)))
    whole = np.round(np.where(finite, values, 0.0) * scale) / scale
    told: list[float | None] = whole.tolist()
    for i in np.flatnonzero(~finite):
        told[i] = None
    return told


def in_parts(values: Complex, digits: int = DRAWN.digits) -> dict[str, Any]:
    """Storage and loss of complex numbers, rounded."""
    return {"storage": rounded(values.real, digits), "loss": rounded(values.imag, digits)}


def _rows_of(points: Points, rows: NDArray[np.int64]) -> Points:
    log_omega = np.broadcast_to(points.log_omega, (points.log_omega.size,))
    return replace(points.mapped(lambda column: column[rows]), log_omega=log_omega[rows])


def parameters_of(
    model: Model, values: Mapping[str, Value], units: Units, correlation: Real
) -> list[dict[str, Any]]:
    """Parameters of a model in printed units, with the ends that a search respects.

    Of `correlation` (p, p) each tells those with the others that are shown, where they are numbers.
    """
    rows = []
    for parameter, correlated in zip(model.parameters, correlation, strict=True):
        value = values.get(parameter.name)
        # A line of a free spectrum: hundreds of them, none of which anybody would move.
        if value is None:
            continue
        factor, _ = units.of(parameter.unit)
        told = {name: getattr(value, name) for name in ("unit", "value", "low", "high")}
        ends = {"lower": parameter.lower * factor, "upper": parameter.upper * factor}
        names = {"name": parameter.name, "symbol": parameter.symbol, "scale": parameter.scale}
        others = {
            name: round(float(r), 3)
            for name, r in zip(model.names, correlated, strict=True)
            if name in values and name != parameter.name and np.isfinite(r)
        }
        rows.append({**names, **told, **ends, "correlated": others})
    return rows


def proposed_points(action: dict[str, list[float]], measurement: Measurement) -> Points:
    """Where a proposed experiment measures.

    Conditions that it leaves open are as they were on the median.
    """
    omega = np.asarray(action["omega"], dtype=float)
    points = measurement.points

    def level(name: str, column: Real | None) -> Real | None:
        # The model was never told it.
        if column is None:
            return None
        if not action.get(name):
            return np.full(omega.shape, float(np.median(column)))
        given = np.resize(np.asarray(action[name], dtype=float), omega.shape)
        if name == "temperature":
            given = given + KELVIN
        return given

    columns = {name: level(name, column) for name, column in points.columns.items()}
    return replace(
        points,
        log_omega=np.log(omega),
        amplitude=level("amplitude", points.amplitude),
        temperature=level("temperature", points.temperature),
        columns={name: column for name, column in columns.items() if column is not None},
    )
