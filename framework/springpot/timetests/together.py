"""Residuals of many tests at once, of any material whose tests differ by their temperature.

After a step of the displacement G(t; T) = b (K_e + sum of g_j exp(-r_j t / a)): the lines of all
tests are one matrix, where each test by itself would take the material apart anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.continuum import Continuum, Relaxation
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT, Chain, Node, Shift
from springpot.rheology.points import ROOM, Points, Real

from .residuals_of_tests import InTimePart, TestPart


class Steps(NamedTuple):
    """Tests that one model answers at once.

    Attributes
    ----------
    network, places : Node, list of int
        The model as a function of 1 / t, and where its parameters stand in theta.
    at : Points
        One over the time since the step, and the temperature, of each sample (n,).
    measured, weight : ndarray, shape (n,)
        The response over the step, and that step over the noise.
    rows : ndarray, shape (n,)
        Where these samples stand among the residuals of all tests.
    """

    network: Node
    places: list[int]
    at: Points
    measured: Real
    weight: Real
    rows: NDArray[np.intp]


class Together:
    """Residuals of tests by the parameters of a model, those alike worked out at once.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    parts : sequence of TestPart
        The tests, each with its weight.
    reference : float
        Temperature in kelvin at which shifts are one.
    """

    def __init__(self, model: Model, parts: Sequence[TestPart], reference: float) -> None:
        self.model, self.reference, self.count = model, reference, 0
        self.others: list[tuple[TestPart, slice]] = []
        alike: dict[tuple[int, ...], list[tuple[InTimePart, int]]] = {}
        for part in parts:
            places = _of_one_step(model, part)
            if places is not None and isinstance(part, InTimePart):
                alike.setdefault(tuple(places), []).append((part, self.count))
            else:
                self.others.append((part, slice(self.count, self.count + part.count())))
            self.count += part.count()
        self.steps = [_steps(model, group, reference) for group in alike.values()]

    def residuals(self, theta: Real) -> tuple[Real, Real]:
        """Residuals (m,) of all tests and their derivatives (m, p)."""
        value, by_theta = np.zeros(self.count), np.zeros((self.count, len(theta)))
        for part, rows in self.others:
            value[rows], by_theta[rows] = part.residual(self.model, theta, self.reference)
        for each in self.steps:
            answer = each.network.respond(theta[each.places], each.at, GRADIENT)
            value[each.rows] = (answer.value.real - each.measured) * each.weight
            by_theta[each.rows[:, None], each.places] = (answer.by_theta.real * each.weight).T
        return value, by_theta


def is_factor(effect: Effect) -> bool:
    """Whether at one temperature an effect is a factor of a material's times or moduli."""
    return (
        effect.needs == {"temperature"}
        and effect.layer == Layer.TEMPERATURE
        and issubclass(effect.composition.kind, Shift | Chain)
    )


def is_material_alone(model: Model, part: TestPart) -> bool:
    """Whether all that a test by itself has of a model is some other material."""
    own = model.had_by(part.test)[0]
    return isinstance(own.material, Continuum) and all(map(is_factor, own.effects))


def _of_one_step(model: Model, part: TestPart) -> list[int] | None:
    """Where in theta the parameters stand that a test after a sudden step has; None of others."""
    if not isinstance(part, InTimePart) or part.test.kind != "relaxation":
        return None
    test = part.test
    sudden = len(test.loading.jumps[0]) == 1 and test.loading.smooth is None
    own, places = model.had_by(test)
    # At one temperature, and nothing was read before the step.
    steady = not own.effects or (test.kelvin is not None and test.warmth is None)
    after = bool(np.all(part.at[part.counted] > test.start))
    if sudden and steady and after and is_material_alone(model, part):
        return places
    return None


def _steps(model: Model, group: Sequence[tuple[InTimePart, int]], reference: float) -> Steps:
    own, places = model.had_by(group[0][0].test)
    assert isinstance(own.material, Continuum)
    shown = replace(own, material=Relaxation(own.material.rates))
    columns = []
    for part, first in group:
        test, rows = part.test, np.flatnonzero(part.counted)
        step = float(test.loading.jumps[1][0])
        columns.append(
            (
                -np.log(test.time[rows] - test.start),
                np.full(len(rows), test.kelvin or ROOM),
                part.measured[rows] / step,
                step / (part.scale * part.sd[rows]),
                first + rows,
            )
        )
    rates, kelvin, measured, weight, where = map(np.concatenate, zip(*columns, strict=True))
    at = Points(rates, None, kelvin, reference)
    return Steps(shown.network, places, at, measured, weight, where)
