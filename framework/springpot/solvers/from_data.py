"""A Prony series of given relaxation times, straight from measured points."""

from __future__ import annotations

import numpy as np

from springpot.errors import ModelError, OptionError
from springpot.measurement.covered import Covered
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.rheology.levels import held
from springpot.rheology.points import Real

from .handoff import Handoff
from .prony import MOST, at_times


def times_of(text: str, per_decade: int = 1) -> Real:
    """Relaxation times in s, evenly over the decades of a range such as ``1e-6:1e6``.

    Raises
    ------
    OptionError
        If it is no range, or holds more than a series has.

    Examples
    --------
    >>> from springpot.solvers.from_data import times_of
    >>> times_of("1e-2:1e1").round(6)
    array([ 0.01,  0.1 ,  1.  , 10.  ])
    """
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = 0.0, 0.0
    if not 0.0 < low < high < np.inf:
        raise OptionError(f"'{text:.40}' is no range of times: write two in s, such as 1e-6:1e6")
    count = int(np.round(per_decade * np.log10(high / low))) + 1
    if count > MOST:
        raise OptionError(
            f"{count} times are more than the {MOST} of a series: narrow --times, or fewer a decade"
        )
    return np.geomspace(low, high, count)


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
