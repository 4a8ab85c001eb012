"""What the JSON of a fit keeps beside what people read, so that it can be taken up again.

Theta and the data.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from math import isfinite
from typing import Any

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.measurement.units import Units
from springpot.rheology.continuum import Continuum
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .estimate import Estimate
from .material import is_material
from .native import Fit
from .problem import Objective
from .uncertainty import Uncertainty


def kept(estimate: Estimate, seed: int) -> dict[str, Any]:
    """Theta and intervals in the measurement's units, what was held or bounded, the measurement."""
    model, rates = estimate.model, None
    # The lines of a spectrum are placed by the data: the name of the model does not tell them.
    if isinstance(model.material, Continuum):
        rates = list(model.material.rates)
    return {
        "theta": estimate.theta.tolist(),
        "low": _finite(estimate.low),
        "high": _finite(estimate.high),
        "held": model.held,
        "bounds": bounds_of(model),
        "rates": rates,
        "absolute": estimate.uncertainty.absolute,
        "converged": estimate.fit.converged,
        "seed": seed,
        "measurement": measurement_to_dict(estimate.measurement),
    }


def _finite(ends: Real) -> list[float | None]:
    return [_finite_or_none(float(end)) for end in ends]


def _finite_or_none(value: float) -> float | None:
    # JSON has no word for infinity.
    if not isfinite(value):
        return None
    return value


def ends_of(kept: Mapping[str, Any], count: int) -> tuple[Real, Real]:
    """Both ends of the intervals of so many parameters, with infinity back in its place.

    Raises
    ------
    ValueError
        If they are not as many.
    """
    low, high = (np.array(kept[name], dtype=float) for name in ("low", "high"))
    if low.shape != (count,) or high.shape != (count,):
        raise ValueError(f"there are {count} parameters, and other intervals")
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def bounds_of(model: Model) -> dict[str, list[float | None]]:
    """Bounds that are narrower than those of physics."""
    if not model.constrained:
        return {}
    # Only what a user narrowed is kept: bounds of physics belong to the model, and may be mended
    # there.
    wide = {p.name: (p.lower, p.upper) for p in model.released().parameters}
    narrow = [p for p in model.parameters if (p.lower, p.upper) != wide[p.name]]
    return {p.name: _finite(np.array([p.lower, p.upper])) for p in narrow}


def measurement_to_dict(data: Measurement) -> dict[str, Any]:
    """A measurement as plain data."""
    columns = {"storage_sd": None, "loss_sd": None, "repeat": None}
    if data.sd is not None:
        columns |= {"storage_sd": data.sd.real.tolist(), "loss_sd": data.sd.imag.tolist()}
    if data.repeat is not None:
        columns |= {"repeat": data.repeat.tolist()}
    return {
        "name": data.name,
        "units": asdict(data.units),
        "omega": data.omega.tolist(),
        "storage": data.storage.tolist(),
        "loss": data.loss.tolist(),
        "storage_sd": columns["storage_sd"],
        "loss_sd": columns["loss_sd"],
        "conditions": {name: _finite(column) for name, column in data.conditions.items()},
        "repeat": columns["repeat"],
        "reference": data.reference,
    }


def measurement_of(kept: dict[str, Any]) -> Measurement:
    """The measurement that `measurement_to_dict` gave.

    Labels, harmonics and provenance are not kept.
    """
    sd = None
    if kept["storage_sd"] is not None:
        sd = np.array(kept["storage_sd"]) + 1j * np.array(kept["loss_sd"])
    repeat, reference = None, kept["reference"]
    if kept["repeat"] is not None:
        repeat = np.array(kept["repeat"])
    if reference is not None:
        reference = float(reference)
    conditions = {
        name: np.array(column, dtype=float) for name, column in kept["conditions"].items()
    }
    return Measurement(
        np.array(kept["omega"], dtype=float),
        np.array(kept["storage"], dtype=float) + 1j * np.array(kept["loss"], dtype=float),
        sd=sd,
        conditions=conditions,
        repeat=repeat,
        units=Units(**kept["units"]),
        name=str(kept["name"]),
        reference=reference,
    )


def fit_of(
    kept: dict[str, Any], model: Model, objective: Objective, cost: float, evaluations: int
) -> Fit:
    """The fit as it was, from what was kept.

    Parameters
    ----------
    kept : dict
        What `kept` gave.
    model : Model
        The model that its expression names.
    objective : Objective
        How the misfit was measured.
    cost : float
        The objective at the end.
    evaluations : int
        Spent on it.
    """
    data = measurement_of(kept["measurement"])
    if is_material(model):
        model = replace(model, material=Continuum(tuple(map(float, kept["rates"]))))
    # As when it was fitted: first what is held, then the levels of the data.
    model = constrained_as(model, kept).bound_to(data.points)
    # Strictly: of a model that has changed since the numbers may mean something else, and it is
    # refused.
    theta = model.vector(dict(zip(model.names, kept["theta"], strict=True)))
    if not all(
        p.lower <= value <= p.upper
        for p, value in zip(model.parameters, theta.tolist(), strict=True)
    ):
        raise ValueError(f"theta {theta.tolist()} is not within the bounds of {model.name}")
    if not cost >= 0.0:
        raise ValueError("the objective has no value")
    return Fit(model, data, objective, theta, cost, evaluations, bool(kept["converged"]))


def constrained_as(model: Model, kept: Mapping[str, Any]) -> Model:
    """The model with what was held, and what was bounded, when it was fitted."""
    bounds = {name: _ends(pair) for name, pair in kept["bounds"].items()}
    return model.holding(kept["held"], bounds)


def uncertainty_of(kept: dict[str, Any], fit: Fit) -> tuple[Uncertainty, Real, Real]:
    """What is known of a fit, and the ends of its intervals, from what was kept."""
    return Uncertainty(fit, bool(kept["absolute"])), *ends_of(kept, len(fit.theta))


def _ends(pair: list[float | None]) -> tuple[float, float]:
    low, high = pair
    if low is None:
        low = -np.inf
    if high is None:
        high = np.inf
    return low, high
