"""The least error of any linear passive material in tests of which one at least is in time.

Below it lies what a spring, dashpot, springpot or mode may mend, above it what no material does. It
is sought from a fitted model, whose material is set free while its effects go on from where they
are: so it lies below the model's own error from the first step on, and takes a few.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.identification.convex import ConvexSpectrum, lattice, shown_by
from springpot.identification.material import is_material
from springpot.identification.result import Identification
from springpot.misfit.material import any_material, is_of_material
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.numerics import PER_DECADE, non_negative, rms
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.parameters import Coordinates
from springpot.rheology.points import Real, real_form

from .material import Around, descended_from, spectrum_of
from .native import TimeSearch
from .temperatures import seen_by


@dataclass(frozen=True)
class TimeFloor:
    """Any linear passive material with the effects of a model.

    Attributes
    ----------
    errors : tuple of float
        The least error in each test, relative to its signal; nan where none can be told.
    """

    errors: tuple[float, ...]

    def beside(self, fits: Sequence[Identification]) -> TimeFloor:
        """The same, lowered by fits with the same effects whose own material is linear and passive.

        Lines stand apart, tests weigh against one another, and a search beside effects may stop
        short: a model that is such a material itself is a bound.
        """
        errors = list(self.errors)
        for fit in fits:
            own = [part.relative_rms for part in fit.parts]
            lower = [not floor <= error for floor, error in zip(errors, own, strict=True)]
            if any(lower) and is_linear(fit):
                errors = np.fmin(errors, own).tolist()
        return TimeFloor(tuple(errors))


def is_linear(fit: Identification) -> bool:
    """Whether the material of a fitted model is a linear passive one, as its error needs it."""
    if is_material(fit.model):
        return True
    return is_of_material(fit.model, fit.theta, fit.covered.rate, fit.relative_rms)


def material_floor(fits: Sequence[Identification]) -> TimeFloor:
    """The least error of any material in the place of a model's own, its effects going on.

    Parameters
    ----------
    fits : sequence of Identification
        Of tests of which one at least is in time, with the same effects; it begins with the best.
    """
    fit = min(fits, key=lambda one: one.cost)
    free = replace(any_material(), effects=fit.model.effects)
    # So that residuals are shares of the signal, as errors are printed.
    parts = [part.with_sd(part.size) for part in parts_of_specimen(fit.data)]
    own = fit.theta[len(fit.model.material.parameters) :]
    around = Around(coordinates_around(free, TimeSearch(free, parts, fit.reference)), own)
    try:
        bands = seen_by(parts, free, fit.model.named(fit.theta), fit.reference)
        lines = as_lines(fit.model, fit.theta, lattice(bands, PER_DECADE))
        found = descended_from(lines, free, parts, fit.reference, around)
    except SpringpotError:
        # Its effects have no law around lines: what remains is whether the model is a bound.
        return TimeFloor((float("nan"),) * len(parts)).beside([fit])
    missed = [part.residual(found.model, found.theta, fit.reference).value for part in parts]
    errors = [rms(each[part.counted]) for each, part in zip(missed, parts, strict=True)]
    return TimeFloor(tuple(errors)).beside([fit])


def coordinates_around(free: Model, search: TimeSearch) -> Coordinates:
    """Search coordinates of the effects around a material, of the sizes that a search has told."""
    effects = free.parameters[len(free.material.parameters) :]
    size, reach = search.sizes
    return Coordinates.of(effects, search.middle, np.array([size]), reach)


def as_lines(model: Model, theta: Real, rates: Real) -> ConvexSpectrum:
    """The material of a model as lines at given rates (m,), as near as any come to its K.

    Raises
    ------
    ModelError
        If its material asks for a condition.
    """
    if isinstance(model.material, Continuum):
        return spectrum_of(model, theta)
    if model.material.needs:
        raise ModelError(f"{model.name}: its material is none of one temperature and amplitude")
    alone = replace(model, effects=())
    stiffness = alone.stiffness(theta[: len(alone.parameters)], rates)
    size = np.abs(stiffness)
    columns = real_form((shown_by(rates, rates) / size).T)
    return ConvexSpectrum.of(non_negative(columns, real_form(stiffness / size))[0], rates)
