"""Laws of temperature around a material: where they begin, and what of it the tests then see.

A law moves times by decades: neither a natural size nor a small step leads to it, and tests of a
few decades show a material over many.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from springpot.errors import SpringpotError
from springpot.identification.material import WIDEST
from springpot.identification.material_fit import fit_spectrum
from springpot.identification.problem import relative_objective
from springpot.measurement.timetest import TimeTest
from springpot.rheology.effect import Effect
from springpot.rheology.elements import Probe
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Points, Real
from springpot.superposition.laws import SHOWN, after_steps, by_one_number

from .residuals_of_tests import TestPart


def is_law(effect: Effect) -> bool:
    """Whether an effect shifts by the temperature alone."""
    return effect.plane == "shift" and effect.needs == {"temperature"}


def laws_of(model: Model) -> tuple[Effect, ...]:
    """Its effects that hang on the temperature alone."""
    return tuple(effect for effect in model.effects if effect.needs == {"temperature"})


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
    laws, told = laws_of(model), dict[str, float]()
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
        found = fit_spectrum(lawful, points, by_one_number(relative_objective()))
        told |= dict(zip(found.model.names, found.theta.tolist(), strict=True))
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
