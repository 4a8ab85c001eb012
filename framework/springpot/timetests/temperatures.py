"""A material at several temperatures: its residuals in many tests at once, and where laws begin.

After a step of the displacement G(t; T) = b (K_e + sum of g_j exp(-r_j t / a)): the lines of all
tests are one matrix, where each test by itself would take the material apart anew. After one of the
force J(t; T) = J(t / a) / b: its retardation times are sought once. A law of temperature moves
times by decades: neither a natural size nor a small step leads to it, and tests of a few decades
show a material over many.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.errors import SpringpotError
from springpot.identification.material import WIDEST
from springpot.identification.native import fit
from springpot.identification.problem import relative_objective
from springpot.measurement.timetest import TimeTest
from springpot.misfit.residuals_of_tests import InTimePart, TestPart
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Continuum, Probe, Relaxation
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL, GRADIENT, VALUE, Chain, Node, Response, Shift
from springpot.rheology.points import KELVIN, ROOM, Points, Real
from springpot.superposition.laws import SHOWN, after_steps, by_one_number

from ..numerics import NEGLIGIBLE


@dataclass(frozen=True)
class CreepKernel(Continuum):
    """What a material shows at the time t = 1 / omega after a step of the force: 1 / J(t), real."""

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """One over the creep compliance, which is a stiffness that factors and shifts act upon."""
        time = np.exp(-at.log_omega)
        material = Model("material", Continuum(self.rates))
        in_time = material.in_time(theta, tolerance=NEGLIGIBLE)
        crept, flown = in_time.creep(time), np.zeros(len(time))
        if depth == FULL:
            flown = time * in_time.step_rate(time, "force")
        square = crept.value**2
        return Response(
            (1.0 / crept.value).astype(np.complex128),
            (-crept.by_theta.T / square).astype(np.complex128),
            (flown / square).astype(np.complex128),
        )


WITH: dict[str, type[Continuum]] = {"relaxation": Relaxation, "creep": CreepKernel}
"""What a material shows after the step of a kind of test."""


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
    crept : bool
        Whether the steps were of the force, so that the model answers with 1 / J.
    """

    network: Node
    places: list[int]
    at: Points
    measured: Real
    weight: Real
    rows: NDArray[np.intp]
    crept: bool

    def answer(self, theta: Real) -> tuple[Real, Real]:
        """The response over the step (n,), and its derivatives by these parameters (p, n)."""
        found = self.network.respond(theta[self.places], self.at, GRADIENT)
        value, by_theta = found.value.real, found.by_theta.real
        if self.crept:
            return 1.0 / value, -by_theta / value**2
        return value, by_theta


class StackedResiduals:
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
        alike: dict[tuple[str, tuple[int, ...]], list[tuple[InTimePart, int]]] = {}
        for part in parts:
            places = _of_one_step(model, part)
            if places is not None and isinstance(part, InTimePart):
                kind = part.test.kind, tuple(places)
                alike.setdefault(kind, []).append((part, self.count))
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
            answer, slopes = each.answer(theta)
            value[each.rows] = (answer - each.measured) * each.weight
            by_theta[each.rows[:, None], each.places] = (slopes * each.weight).T
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
    if not isinstance(part, InTimePart) or part.test.kind not in WITH:
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
    kind = group[0][0].test.kind
    shown = replace(own, material=WITH[kind](own.material.rates))
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
    return Steps(shown.network, places, at, measured, weight, where, kind == "creep")


def is_law(effect: Effect) -> bool:
    """Whether an effect shifts by the temperature alone."""
    return effect.plane == "shift" and effect.needs == {"temperature"}


def told_by_steps(model: Model, parts: Sequence[TestPart], reference: float) -> dict[str, float]:
    """Parameters of a model's laws of temperature, as steps laid over one another tell them.

    Parameters
    ----------
    model : Model
        Any, with its effects.
    parts : sequence of TestPart
        Tests; those after a step of one kind are laid over one another. Nothing is told where they
        are of one temperature.
    reference : float
        Temperature in kelvin at which shifts are one.
    """
    laws = tuple(effect for effect in model.effects if effect.needs == {"temperature"})
    told: dict[str, float] = {}
    tests = [part.test for part in parts if isinstance(part.test, TimeTest)]
    for kind in SHOWN:
        alike = [test for test in tests if test.kind == kind and test.temperature is not None]
        if not laws or len({test.temperature for test in alike}) < 2:
            continue
        try:
            material, points = after_steps(alike)
        except SpringpotError:
            # What is not positive after its step is laid over nothing.
            continue
        lawful = Model("material", material, effects=laws)
        points = replace(points, reference=reference)
        found = fit(lawful, points, by_one_number(relative_objective()))
        told |= found.model.named(found.theta)
    return {name: told[name] for name in model.names if name in told}


def lawful(
    model: Model, parts: Sequence[TestPart], reference: float, seeds: Sequence[Real]
) -> list[Real]:
    """Seeds (q,) of the effects around any material, with their laws of temperature as steps tell.

    None where steps tell nothing.
    """
    told = told_by_steps(model, parts, reference)
    if not told:
        return []
    around = model.parameters[len(model.material.parameters) :]
    return [
        np.array([told.get(each.name, value) for each, value in zip(around, seed, strict=True)])
        for seed in seeds
    ]


def seen_by(
    parts: Sequence[TestPart], model: Model, known: Mapping[str, float], reference: float
) -> list[tuple[float, float]]:
    """Between which reduced angular frequencies each test tells of the material.

    Parameters
    ----------
    parts : sequence of TestPart
        The tests.
    model : Model
        The material with its effects, whose laws of temperature shift the frequencies.
    known : mapping of str to float
        Parameters of these laws.
    reference : float
        Temperature in kelvin at which shifts are one.
    """
    laws = tuple(each for each in model.effects if is_law(each))
    bands = [part.resolved for part in parts]
    if not laws:
        return bands
    probe = Probe([])
    shifted = replace(model, material=probe, effects=laws)
    theta = np.array([known[parameter.name] for parameter in shifted.parameters])
    for part, band in zip(parts, bands, strict=True):
        celsius = np.unique(part.conditions["temperature"])[[0, -1, 0, -1]]
        log_omega = np.repeat(np.log(band), 2)
        at = Points(log_omega, None, celsius + KELVIN, reference)
        with np.errstate(all="ignore"):
            shifted.network.respond(theta, at)
    ends = np.array(probe.seen)
    # A setting under which nothing can be measured is none to lay lines for.
    if not np.all(np.isfinite(ends)) or np.ptp(ends) > WIDEST:
        return bands
    return [(float(low), float(high)) for low, high in np.exp(ends)]
