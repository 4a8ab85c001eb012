"""A Prony series of given relaxation times, straight from measured points."""

from __future__ import annotations

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.covered import Covered
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.rheology.levels import held
from springpot.rheology.points import Real

from .handoff import Handoff
from .prony import at_times


def series_of(data: Measurement, times: Real, dashpot: bool = False) -> Handoff:
    """The series of given times that misses measured points least, each relative to its own size.

    Parameters
    ----------
    data : Measurement
        At one temperature and one amplitude, or such as do not matter.
    times : ndarray, shape (m,)
        In s; weights are none below zero, so that there is one best series and no start.
    dashpot : bool
        Whether a dashpot may stand beside the terms.

    Raises
    ------
    ModelError
        If a condition changes within the data, or there are fewer numbers than terms.
    """
    # What else stands in further columns a user may know to be one.
    for name, column in ((name, data.conditions.get(name)) for name in CONDITIONS):
        if column is not None and np.ptp(column) > np.max(held(name, column)):
            raise ModelError(
                f"{data.name} has more than one {name}, and a series is that of one: choose one,"
                f" {data.name}@{name}=VALUE, or fit a model with an effect of it"
            )
    if 2 * len(data) < len(times) + 1:
        raise ModelError(f"{len(data)} points do not tell {len(times)} weights: give fewer times")
    covered = Covered.of([data])
    series = at_times(np.log(data.omega), data.stiffness, times, dashpot, covered.rate)
    unit = data.units.stiffness
    return Handoff(
        series,
        f"Prony series of {data.name}",
        {"terms": f"{len(times)}"},
        unit,
        data.units.is_modulus,
        covered=covered.rate,
        remarks=(f"measured: {covered.told(data.units)}; times as given",),
        letter=data.units.modulus,
    )
