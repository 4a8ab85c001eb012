"""Models against the same tests in time, each fitted to all of them: which follows them best."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from springpot.comparison.result import ONLY_NOISE, Comparison, Judgement
from springpot.errors import DataError, SpringpotError
from springpot.identification.result import Identification
from springpot.measurement.opening import together
from springpot.misfit.where import Where
from springpot.misfit.words import times
from springpot.registry import parse_model
from springpot.rheology.model import Model

from .fitting import identify
from .floor import TimeFloor, effects_of, material_floors
from .left import Left
from .residuals_of_tests import (
    Test,
    parts_of_specimen,
)
from .scatter import ResidualScatter
from .verdict import error_of, where_missed

MORE = "what is left is more than noise"
"""What is said of a model that is missed nowhere in particular."""


def compare(
    tests: Sequence[Test],
    models: Sequence[Model | str],
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Judge models of tests in time, each fitted to all of them together.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    models : sequence of Model or str
        Those that have no law in time, or lack a condition, are named as left out.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Comparison
        Best first.

    Raises
    ------
    SpringpotError
        If none of the models can be fitted.

    Notes
    -----
    Misses count in units of the noise, or of what the best model leaves where that is more: between
    models that are both far off, precision that none of them can use is no evidence.
    """
    fits: list[Identification] = []
    left_out: dict[str, str] = {}
    # All expressions first: one that is mistyped is told before minutes are spent on the others.
    parsed = [parse_model(each) if isinstance(each, str) else each for each in models]
    for model in parsed:
        if progress is not None:
            progress(f"fitting {model.name}")
        try:
            fits.append(identify(tests, model))
        except SpringpotError as error:
            # One model that cannot be followed must not keep the others from being compared.
            left_out[model.name] = str(error)
    if not fits:
        raise DataError(next(iter(left_out.values()), "there is no model to compare"))
    # All models were fitted to the same samples.
    points = sum(test.points for test in fits[0].tests)
    # By what the best model leaves, where that is more than noise: see the notes.
    scale = max(1.0, min(fit.cost for fit in fits) / points)
    criteria = [fit.cost / scale + len(fit.theta) * np.log(points) for fit in fits]
    least = min(criteria)
    ranked = sorted(zip(criteria, fits, strict=True), key=lambda pair: pair[0])
    # One noise for all, that about the best model.
    noise = _left(ranked[0][1]).scatters
    floors = material_floors(fits)
    judged = [
        judgement_of(fit, float(value - least), floors[effects_of(fit.model)], noise)
        for value, fit in ranked
    ]
    names = together(test.name for test in fits[0].tests)
    comparison = Comparison(names, tuple(judged), (), (), "", left_out=left_out)
    vars(comparison).update(magnitude="the signal")
    return comparison


def _left(fit: Identification) -> Left:
    return Left.by(fit.model, fit.theta, fit.reference, parts_of_specimen(fit.data))


def judgement_of(
    fit: Identification,
    delta: float,
    floor: TimeFloor,
    noise: Sequence[ResidualScatter] | None = None,
) -> Judgement:
    """One model against the tests that it was fitted to.

    Parameters
    ----------
    fit : Identification
        Of tests of which one at least is in time.
    delta : float
        Its information criterion above that of the best model.
    floor : TimeFloor
        What any material reaches with the same effects.
    noise : sequence of ResidualScatter, optional
        Of each test; by default that about this model.
    """
    parts, left = parts_of_specimen(fit.data), _left(fit)
    if noise is None:
        noise = left.noise
    tests = left.rows(parts, noise, fit.tests)
    error, left = error_of(tests, noise, floor), left.beside(noise)
    where: tuple[Where, ...] = ()
    says = ONLY_NOISE
    if left.misfit:
        where, says = where_missed(parts, left, noise), MORE
    if where:
        says = where[0].says
    known = {
        "model": fit.model,
        "chi_square": fit.cost,
        "degrees_of_freedom": sum(test.points for test in fit.tests) - len(fit.theta),
        "free_parameters": len(fit.theta),
        "fails": left.misfit,
        "unclear": False,
        "says": f"error {times(error.over_floor)} the noise; {says}",
        "parameters": fit.parameters,
        "where": where,
        "by_test": tests,
        "findings": (),
        "notes": fit.notes,
    }
    return Judgement.told(fit, error, delta, known)
