"""The contract of a model."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from springpot.rheology import Model, drawing_of
from springpot.rheology.family import Family

from .aspects import SEED, cited, complaints, name_and_summary
from .derivatives import derivative, sample
from .networks import EXACT, OMEGA, network_aspects

MEMBERS = (1, 3)
"""Members of a family that are checked."""


def check_model(model: Model | Family, *, passive: bool = False, skip: Collection[str] = ()) -> list[str]:
    """What is wrong with a model, as plain sentences; of a family, with some of its members.

    Aspects: ``words`` (name, summary, citation, drawing), ``parameters``, ``shapes``, ``derivatives`` (exact, by
    Cauchy's integral), ``finite`` (over the search box), ``units``, ``pure``, ``search`` (the search form inverts and
    keeps the bounds) and ``passive``.

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
    aspects = {"words": lambda: _words(model), **network_aspects(model), "search": lambda: _search(model)}
    if passive:
        aspects["passive"] = lambda: _passive(model)
    return complaints(aspects, skip)


def _check_family(family: Family, passive: bool, skip: Collection[str]) -> list[str]:
    found = complaints({"words": lambda: name_and_summary(family.name, family.summary, family.aliases)})
    for number in MEMBERS:
        expected = f"{family.name.removesuffix('-N')}-{number}"
        member = family.member(expected)
        if member is None or member.base != expected:
            found.append(f"words: member {number} is called {member and member.base}, not {expected}")
        else:
            found += [f"{expected}: {says}" for says in check_model(member, passive=passive, skip=skip)]
    return found


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
    if form.ordered:
        x[:, list(form.ordered)] = np.sort(x[:, list(form.ordered)], axis=-1)
    if not np.allclose(form.from_elements(form.to_elements(x)), x, rtol=1e-8):
        yield "from_elements does not undo to_elements"
    numeric = np.stack([derivative(form.to_elements, row, 1e-3) for row in x])
    if not np.max(np.abs(form.jacobian(x) - numeric)) < EXACT * np.max(np.abs(numeric)):
        yield "jacobian is not the derivative of to_elements"
    free = sample(form.parameters, np.random.default_rng(SEED + 1), (50,))
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
        if np.any(part < -1e-12 * np.abs(stiffness)):
            yield f"the {name} is negative for lawful parameters"
