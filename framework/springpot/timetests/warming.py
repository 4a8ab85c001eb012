"""A test during which the temperature moved: shifts follow it in reduced time, sample by sample."""

from __future__ import annotations

import numpy as np

from springpot.measurement.imposed import Loading
from springpot.measurement.timetest import TimeTest
from springpot.rheology.intime import Traced
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Real

SUDDEN = 1e-6
"""Share of the time to the next sample that a step takes.

It is a ramp here, whose error is of that size.
"""


def warming(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None,
    at: Real | None,
    tolerance: float,
    loading: Loading | None = None,
) -> Traced:
    """The response of a model to the loading of a test whose temperature moved.

    `loading` is what reached the specimen, where that is another. The other parameters and the
    returns are those of `predicted`; the temperature is straight between samples and held before
    and after them, and the reference is its mean by default.

    Raises
    ------
    ModelError
        If something else than a shift feels the temperature.
    """
    assert test.warmth is not None
    assert test.kelvin is not None
    if at is None:
        at = test.time
    if loading is None:
        loading = test.loading
    if reference is None:
        reference = test.kelvin
    # A history in reduced time is one value at each time: a step becomes a very short ramp.
    loading = _gradual(loading, test.time)
    # All samples take part, whichever are asked for: between them the temperature may turn.
    grid = np.union1d(np.union1d(loading.time, test.time), at)
    kelvin = np.interp(grid, test.time, test.warmth) + KELVIN
    inside = model.in_time(
        theta, temperature=kelvin, reference_temperature=reference, tolerance=tolerance
    )
    imposed = np.interp(grid, loading.time, loading.value)
    if test.control == "displacement":
        answer = inside.respond(grid, imposed)
    else:
        answer = inside.respond_force(grid, imposed)
    rows = np.searchsorted(grid, at)
    return Traced(answer.value[rows], answer.by_theta[rows])


def _gradual(loading: Loading, samples: Real) -> Loading:
    """The loading with ramps in place of its steps."""
    time = loading.time.copy()
    for i in np.flatnonzero(np.diff(time) == 0.0):
        later = np.concatenate([samples[samples > time[i]], time[time > time[i]]])
        wait = 1.0
        if len(later):
            wait = float(later.min()) - time[i]
        time[i + 1] += SUDDEN * wait
    return Loading(time, loading.value)
