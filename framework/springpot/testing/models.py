"""The contract of a model."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from springpot.identification.material import is_material
from springpot.identification.native import fit
from springpot.rheology.drawing import drawing_of
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Family, Model

from ..numerics import ROUNDING
from .networks import (
    EXACT,
    OMEGA,
    SAMPLE,
    SEED,
    cited,
    complaints,
    derivative,
    name_and_summary,
    network_aspects,
    sample,
    sample_measurement,
)

RATES = (0.03, 1.0, 40.0)
"""Lines [rad/s] below, within and above the frequencies at which a material is checked."""
FOLLOWED = 2e-4
"""Relative error to which lines follow a smooth spectrum at points that are two a decade.

1.1e-4 with the most lines
that a fit allows itself, which leaves a few of the measured numbers over."""


def check_model(
    model: Model | Family, *, passive: bool = False, skip: Collection[str] = ()
) -> list[str]:
    """What is wrong with a model, as plain sentences; of a family, with some of its members.

    Aspects: ``words`` (name, summary, citation, drawing), ``parameters``, ``shapes``,
    ``derivatives`` (exact, by Cauchy's integral), ``finite`` (over the search box), ``units``,
    ``pure``, ``search`` (the search form inverts and keeps the bounds) and ``passive``. Of a
    material whose spectrum the data choose everything is checked with lines in it, whether
    ``passive`` is asked for or not, and ``spectrum``: that a fit follows a network of springs,
    springpots and dashpots.

    Parameters
    ----------
    model : Model or Family
        The model.
    passive : bool
        Also demand that storage and loss are never negative.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    if isinstance(model, Family):
        return _check_family(model, passive, skip)
    if is_material(model):
        return _check_material(model, skip)
    aspects = {
        "words": lambda: _words(model),
        **network_aspects(model),
        "search": lambda: _search(model),
    }
    if passive:
        aspects["passive"] = lambda: _passive(model)
    return complaints(aspects, skip)


def _check_family(family: Family, passive: bool, skip: Collection[str]) -> list[str]:
    sentences = complaints(
        {"words": lambda: name_and_summary(family.name, family.summary, family.aliases)}
    )
    for number in (1, 3):
        expected = f"{family.name.removesuffix('-N')}-{number}"
        member = family.member(expected)
        # A member's name is typed and stored: it must lead back to the same member.
        if member is None or member.base != expected:
            sentences.append(
                f"words: member {number} is called {member and member.base}, not {expected}"
            )
        else:
            sentences += [
                f"{expected}: {says}" for says in check_model(member, passive=passive, skip=skip)
            ]
    return sentences


def _check_material(model: Model, skip: Collection[str]) -> list[str]:
    """The contract with the lines that a fit may choose.

    Without any there is only a spring beside a dashpot.
    """
    lined = replace(model, material=Continuum(RATES))
    aspects = {
        "words": lambda: _words(model),
        **network_aspects(lined),
        "passive": lambda: _passive(lined),
    }
    return complaints({**aspects, "spectrum": lambda: _spectrum(model)}, skip)


def _spectrum(model: Model) -> Iterator[str]:
    """Any network of springs, springpots and dashpots is one of the materials."""
    data = sample_measurement()
    theta = sample(SAMPLE.parameters, np.random.default_rng(SEED), (1,))[0]
    exact = SAMPLE.stiffness(theta, data.points)
    fitted = fit(model, replace(data, stiffness=exact))
    left = np.abs(fitted.model.stiffness(fitted.theta, data.points) / exact - 1.0)
    if not left.max() < FOLLOWED:
        yield (
            f"a spring beside a spring in series with a springpot is followed to {left.max():.1e}"
            " only"
        )
    if np.any(fitted.theta < 0.0):
        yield "a weight of the spectrum is negative"


def _words(model: Model) -> Iterator[str]:
    yield from name_and_summary(model.base, model.summary, model.aliases)
    yield from cited(model.citation)
    if len(drawing_of(model).splitlines()) < 2:
        yield "the drawing is no picture of a network"


def _search(model: Model) -> Iterator[str]:
    form = model.search
    if form is None:
        return
    x = sample(form.parameters, np.random.default_rng(SEED), (4,))
    # Search points keep the order of the form, as they do wherever one is searched.
    if form.ordered:
        x[:, list(form.ordered)] = np.sort(x[:, list(form.ordered)], axis=-1)
    if not np.allclose(form.from_elements(form.to_elements(x)), x, rtol=1e-8):
        yield "from_elements does not undo to_elements"
    numeric = np.stack([derivative(form.to_elements, row, 1e-3) for row in x])
    # Written this way round, a derivative that is no number fails too.
    if not np.max(np.abs(form.jacobian(x) - numeric)) < EXACT * np.max(np.abs(numeric)):
        yield "jacobian is not the derivative of to_elements"
    # In any order: an optimiser knows nothing of the order, and the form has to mend it.
    free = sample(form.parameters, np.random.default_rng(SEED), (50,))
    theta = form.to_elements(form.repaired(free))
    for parameter, values in zip(model.parameters, theta.T, strict=True):
        if np.any(values < parameter.lower) or np.any(values > parameter.upper):
            yield f"a lawful search point gives {parameter.name} beyond its bounds"


def _passive(model: Model) -> Iterator[str]:
    rng = np.random.default_rng(SEED)
    theta = sample(model.parameters, rng, (200,))
    # Orders at the very ends of their range are lawful too.
    for i, parameter in enumerate(model.parameters):
        if parameter.scale == "linear" and np.isfinite(parameter.upper):
            theta[::3, i] = rng.choice([parameter.lower, parameter.upper], len(theta[::3]))
    stiffness = model.stiffness(theta, OMEGA)
    for name, part in (("storage", stiffness.real), ("loss", stiffness.imag)):
        # A loss of zero, as of a spring, is computed to rounding only.
        if np.any(part < -ROUNDING * np.abs(stiffness)):
            yield f"the {name} is negative for lawful parameters"
