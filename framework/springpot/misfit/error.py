"""The error of a model between two floors, and how the figures of a misfit stand in a sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.identification.value import in_floors
from springpot.measurement.measurement import Measurement
from springpot.plain_data import Plain, jsonable
from springpot.thresholds import SCATTER
from springpot.writing import number


@dataclass(frozen=True)
class Error(Plain):
    """Error of the model against the noise floor and the material floor, all relative to |K|.

    Of tests in time that of the test which the model misses most, relative to its signal.

    Attributes
    ----------
    relative_rms : float
        Root mean square of |K_model - K| / |K|.
    noise_floor : float
        The same for noise alone.
    noise_source : {"given", "repeats", "estimated", "residual", "signal"}
        Where the noise comes from; of tests in time ``residual``, the upper part of the residual's
        spectrum, or ``signal`` where there are too few samples for one.
    doubt : str
        One sentence where given standard deviations disagree with the data's own scatter.
    material_floor : float
        The least error that any linear passive material reaches beside the model's effects.
    material_chance : float
        That noise alone leaves a residual like that material's. Both are nan where no material was
        looked for.
    noise_memory : float, optional
        Correlation of neighbours in the noise: of tests in time, and of sweeps that show one.
    test : str, optional
        The test of which all of this is told, where there are several.
    """

    relative_rms: float
    noise_floor: float
    noise_source: str
    doubt: str = ""
    material_floor: float = 0.0
    material_chance: float = 1.0
    noise_memory: float | None = None
    test: str = ""

    @property
    def is_hardly_noise(self) -> bool:
        """Whether an error is too large for what is called noise.

        Scatter about models, or of unequal repeats.
        """
        if self.noise_source == "repeats":
            return self.noise_floor > SCATTER.repeats_alike
        return self.noise_source == "estimated" and self.relative_rms > SCATTER.believed

    @property
    def over_floor(self) -> float:
        """The error in noise floors."""
        return in_floors(self.relative_rms, self.noise_floor)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas."""
        row = {**super().to_dict(), "over_floor": jsonable(self.over_floor)}
        if self.noise_memory is None:
            del row["noise_memory"]
        if not self.test:
            del row["test"]
        return row

    @property
    def advice(self) -> str:
        """What to do about noise that is hard to believe."""
        if self.noise_source == "repeats":
            return (
                f"rows that differ by {100 * self.noise_floor:.2g} % are no repeats of each other:"
                " judge them apart"
            )
        return f"noise of {100 * self.noise_floor:.2g} % is no good measurement: repeat it"


def times(ratio: float, beside: float | None = None) -> str:
    """A ratio with two digits, such as ``3.1 x``.

    Whole from a hundred on, never with a power of ten; with a third digit where that tells it from
    another that is told `beside` it.

    Examples
    --------
    >>> from springpot.misfit.error import times
    >>> times(1.03), times(1.03, beside=0.997), times(1.03, beside=3.1), times(1234.5)
    ('1 x', '1.03 x', '1 x', '1234 x')
    """
    # From 99.5 on two digits would be written with a power of ten, which users do not read.
    if ratio >= 99.5:
        return f"{ratio:.0f} x"
    digits = 2 if beside is None or f"{beside:.2g}" != f"{ratio:.2g}" else 3
    return f"{ratio:.{digits}g} x"


def over_floor(error: float, floor: float | None, digits: int = 3) -> str:
    """An error in noise floors, such as ``1.24``; a dash where exact data have no floor.

    Examples
    --------
    >>> from springpot.misfit.error import over_floor
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
    return f"{value:.3g} {measurement.units.of_condition(name)}".removesuffix(" -")
