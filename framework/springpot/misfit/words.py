"""How the figures of a misfit stand in a sentence."""

from __future__ import annotations

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.writing import number


def times(ratio: float) -> str:
    """A ratio with two digits, such as ``3.1 x``.

    Whole from a hundred on, never with a power of ten.
    """
    # From 99.5 on two digits would be written with a power of ten, which users do not read.
    if ratio >= 99.5:
        return f"{ratio:.0f} x"
    return f"{ratio:.2g} x"


def over_floor(error: float, floor: float | None, digits: int = 3) -> str:
    """An error in noise floors, such as ``1.24``; a dash where exact data have no floor.

    Examples
    --------
    >>> from springpot.misfit.words import over_floor
    >>> over_floor(0.024, 0.02), over_floor(0.024, 0.02, 2), over_floor(0.024, 0.0)
    ('1.20', '1.2', '-')
    """
    if floor is None or not floor > 0.0:
        return "-"
    return number(error / floor, digits)


def percent(fraction: float | None) -> str:
    """A share of |K| with three digits, such as ``0.572 %``; a dash where there is none."""
    if fraction is None:
        return "-"
    return f"{100.0 * fraction:.3g} %"


def plain(value: float, digits: int = 3) -> str:
    """A number with few significant digits, written out up to a million: 890, not 8.9e+02."""
    text = f"{value:.{digits}g}"
    # Only large numbers: a small one written out would be a row of zeros.
    if "e+" in text and value < 1e6:
        return f"{float(text):.0f}"
    return text


def point_in_words(measurement: Measurement, row: int) -> str:
    """Where a point was measured: ``50 Hz``, or ``50 Hz, 20 degC, 0.5 mm`` if conditions vary."""
    words = [measurement.units.at(float(measurement.frequency[row]))]
    for name in ("temperature", "amplitude"):
        column = measurement.conditions.get(name)
        if column is not None and len(np.unique(measurement.levels(name))) > 1:
            words.append(with_unit(measurement, name, float(column[row])))
    return ", ".join(words)


def with_unit(measurement: Measurement, name: str, value: float) -> str:
    """A temperature or an amplitude as it is printed."""
    if name == "temperature":
        return f"{value:.3g} degC"
    unit = measurement.units.amplitude
    if unit == "-":
        return f"{value:.3g}"
    return f"{value:.3g} {unit}"
