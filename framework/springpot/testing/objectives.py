"""The contract of an objective."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from springpot.errors import DataError
from springpot.identification.objective import Objective
from springpot.measurement.measurement import Measurement
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex

from .aspects import complaints, name_and_summary
from .derivatives import derivative
from .networks import EXACT, SAMPLE, sample_measurement

THETA = np.array([60.0, 900.0, 300.0, 0.45])


def check_objective(objective: Objective, *, skip: Collection[str] = ()) -> list[str]:
    """What is wrong with an objective, as plain sentences.

    Aspects: ``words``, ``weights`` (finite, not negative, one for each point, with given standard
    deviations and without them; one that needs them refuses with a `DataError`), ``value`` (the sum
    of squared residuals, zero for perfect data) and ``derivative`` (exact).

    Parameters
    ----------
    objective : Objective
        The objective.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(objective.name, objective.summary),
        "weights": lambda: _weights(objective),
        "value": lambda: _value(objective),
        "derivative": lambda: _derivative(objective),
    }
    return complaints(aspects, skip)


def _data(objective: Objective) -> dict[str, Measurement]:
    """Data with standard deviations, and without unless the objective says it needs them."""
    plain = sample_measurement()
    # Different in storage and loss, so that a mix-up of the two shows.
    given: Complex = (0.01 + 0.02j) * plain.stiffness.real.astype(np.complex128)
    data = {"with standard deviations": replace(plain, sd=given)}
    try:
        objective.weights(plain)
    # It needs standard deviations and says so, as it should.
    except DataError:
        return data
    return {"without standard deviations": plain, **data}


def _weights(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = np.asarray(objective.weights(data))
        if weights.shape != data.stiffness.shape or not np.iscomplexobj(weights):
            yield (
                f"{which}: weights must be complex, one for each of the {len(data)} points,"
                f" not {weights!r:.60}"
            )
        elif not np.isfinite(weights).all() or np.any(weights.real < 0) or np.any(weights.imag < 0):
            yield f"{which}: weights must be finite and not negative in K' and in K''"
        elif not np.any(weights):
            yield f"{which}: all weights are zero"
        if not np.array_equal(weights, objective.weights(data)):
            yield f"{which}: two calls give different weights"


def _value(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = objective.weights(data)
        computed = SAMPLE.stiffness(THETA, data.points)
        residual = objective.residual(computed, data, weights)
        if residual.shape != (2 * len(data),):
            yield f"{which}: residuals have the shape {residual.shape}, not ({2 * len(data)},)"
        if not np.allclose(
            objective.value(computed, data, weights), np.sum(residual**2), rtol=1e-12
        ):
            yield f"{which}: the value is not the sum of the squared residuals"
        if not np.allclose(objective.value(data.stiffness.copy(), data, weights), 0.0, atol=1e-20):
            yield f"{which}: the value of perfect data is not zero"


def _derivative(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = objective.weights(data)
        response = SAMPLE.network.respond(THETA, data.points, GRADIENT)
        exact = np.swapaxes(
            objective.derivative(response.by_theta, response.value, weights), -1, -2
        )

        def residual(theta: np.ndarray) -> np.ndarray:
            # Refused at once: the derivative is then differenced along the real axis.
            if np.iscomplexobj(theta):
                raise TypeError("residuals are real parts: no analytic functions")
            computed = SAMPLE.stiffness(theta, data.points)  # noqa: B023  used at once
            return objective.residual(computed, data, weights)  # noqa: B023  used at once

        numeric = derivative(residual, THETA)
        # Times the parameters, for these differ by orders of magnitude.
        if not np.max(np.abs(exact - numeric) * THETA) < EXACT * np.max(np.abs(numeric) * THETA):
            yield f"{which}: derivative is not that of the residuals"
