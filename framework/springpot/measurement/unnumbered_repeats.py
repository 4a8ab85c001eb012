"""Whether a table holds each frequency several times without saying that these are repeats."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.thresholds import VARIED

from .independence import frequency_numbers
from .measurement import Measurement
from .mixed_tests import NOTE as TOGETHER
from .mixed_tests import RUNS, largest_test, told_apart

NOTE = "note repeats"
"""Key of the note in a measurement's provenance."""
ADVICE = (
    "if the sweep was repeated, number the sweeps in a column repeat; their scatter is the noise"
)
"""What a user can do with rows that nothing tells apart."""
FEWEST_FREQUENCIES = 5
"""Fewer that come again are a test that follows something else, such as a setting in time."""
SAME_AMPLITUDE = 0.05
"""Relative range within which amplitudes are one, as where a user chooses rows by an amplitude."""


def again_note(measurement: Measurement) -> dict[str, str]:
    """A note where each frequency stands equally often.

    Under the same conditions, or under other ones of a setting.

    Told and not taken for repeats: a sweep up and down, or one before and one after an ageing,
    looks alike.

    Parameters
    ----------
    measurement : Measurement
        The data.
    """
    numbers = [
        name
        for name in told_apart(measurement)
        if name in measurement.conditions and name not in RUNS
    ]
    if numbers:
        chosen = largest_test(measurement, numbers[0])
        return {
            TOGETHER: (
                f"rows of several tests are together, told apart by {' and '.join(numbers)}; "
                f"choose one by '@{chosen}'"
            )
        }
    number = stands_again(measurement)
    if number is None:
        return {}
    count = np.bincount(number)
    repeated = (
        f"each of {len(count)} frequencies stands {count.min()} times under the same conditions"
    )
    return {NOTE: f"{repeated}: {ADVICE}"}


def stands_again(measurement: Measurement) -> NDArray[np.int64] | None:
    """Number of the frequency of each row (n,).

    Where all come equally often and nothing tells their rows apart.

    None where a frequency comes once, or where a column numbers the repeats or names the runs.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from .unnumbered_repeats import stands_again
    >>> twice = Measurement([1.0, 2.0, 3.0, 4.0, 5.0] * 2, [1j] * 10)
    >>> stands_again(twice)
    array([0, 1, 2, 3, 4, 0, 1, 2, 3, 4])
    """
    number = frequency_numbers(measurement)
    count = np.bincount(number)
    if len(count) < FEWEST_FREQUENCIES or count.min() < 2 or count.min() != count.max():
        return None
    # What names runs, or was set to several values, tells them apart already.
    if (
        measurement.repeat is not None
        or RUNS & set(measurement.conditions)
        or _is_labelled(measurement)
    ):
        return None
    if told_apart(measurement):
        return None
    for name, width in (("temperature", VARIED.temperature_chosen), ("amplitude", SAME_AMPLITUDE)):
        column = measurement.conditions.get(name)
        if column is None:
            continue
        if name == "amplitude":
            column = np.log(column)
        # Each frequency at several temperatures or amplitudes is a set of sweeps, no repeat of one.
        low, high = np.full(len(count), np.inf), np.full(len(count), -np.inf)
        np.minimum.at(low, number, column)
        np.maximum.at(high, number, column)
        if np.max(high - low) > width:
            return None
    return number


def _is_labelled(measurement: Measurement) -> bool:
    """Whether some column of words has several values."""
    return any(len(np.unique(words)) > 1 for words in measurement.labels.values())
