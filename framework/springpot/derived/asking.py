"""``springpot.quantities``: what is asked, and who answers it, the data or a model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from springpot.api import Data, identify, read
from springpot.errors import DataError, ModelError
from springpot.identification.material import is_material
from springpot.identification.prediction import Known
from springpot.identification.result import Identification
from springpot.loading import load
from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model

from .from_data import of_amplitude, of_frequency
from .from_model import REACH, OfModel
from .quantity import Quantities, Quantity

ALONE = (
    "limits at rest, zero-shear viscosity and mean relaxation time are those of a model:"
    " identify one, or name it"
)


def quantities(
    data: Identification | Data,
    model: Model | str | None = None,
    *,
    frequency: float | None = None,
    temperature: float | None = None,
    amplitude: float | None = None,
    without: str | Sequence[str] = (),
    **columns: float,
) -> Quantities:
    """Quantities that follow from a fit or from data, each with its 95 % interval.

    Crossover, plateau, moduli at rest and of fast changes, zero-shear viscosity, mean relaxation
    time, |K|, loss factor and energy of a cycle; linear limit, yield and flow point of sweeps of
    the amplitude. A fitted model says them all but the last three, which are the data's; without a
    model the data say what lies within them. Each row tells which it was.

    Parameters
    ----------
    data : Identification, Measurement, str, Path, or a sequence of data
        A fit, the JSON file of one, or data as for `springpot.read`.
    model : Model or str, optional
        Fitted to data.
    frequency : float, optional
        In Hz, of |K|, loss factor and energy; by default one, or the middle of the measured range.
    temperature, amplitude : float, optional
        In degC and the amplitude unit of the data, where the model depends on them.
    without : str or sequence of str
        Effects that are left out, such as those of the rig.
    **columns : float
        Other conditions that the model depends on.

    Returns
    -------
    Quantities
        A row for each; ``answer["crossover frequency"]`` is the first of that name.

    Raises
    ------
    SpringpotError
        If the data cannot be read, or the model needs a condition.

    Examples
    --------
    >>> import springpot
    >>> fit = springpot.identify("reconstruction-pdms-table4-maxwell", "fractional-maxwell")
    >>> found = springpot.quantities(fit, frequency=1.0)
    >>> [row.name for row in found][:2], found["loss factor"].unit
    (['crossover frequency', 'crossover modulus'], '-')
    """
    given = {"temperature": temperature, "amplitude": amplitude, **columns}
    asked = {name: value for name, value in given.items() if value is not None}
    fit = data if isinstance(data, Identification) else _kept(data)
    if fit is not None and model is not None:
        raise ModelError(f"{fit.name} is fitted by {fit.model.name} already: leave out --model")
    if fit is None and model is not None:
        fit = identify(data, model)  # type: ignore[arg-type]
    notes: list[str] = []
    if fit is not None:
        left = [without] if isinstance(without, str) else without
        rows = list(_of_fit(fit, fit.of_specimen.without(left), frequency, asked, notes))
        return Quantities(fit.name, fit.model.name, fit.units, tuple(rows), tuple(notes))
    sweep = _sweep(data)
    if asked or without:
        names = [*asked]
        if without:
            names.append("without")
        named = ", ".join(f"--{name}" for name in names)
        raise ModelError(f"{named}: data alone know none of it; name a model with --model")
    middle = frequency or _usual(sweep.seen, sweep.units.clock)
    rows = [*of_frequency(sweep, middle), *of_amplitude(sweep, notes)]
    return Quantities(sweep.name, "", sweep.units, tuple(rows), (*notes, ALONE))


def _kept(data: Data) -> Identification | None:
    """The fit that a JSON file holds; none where it is data."""
    if not isinstance(data, str | Path) or not str(data).endswith(".json"):
        return None
    try:
        found = load(data)
    except DataError:
        return None
    if not isinstance(found, Identification):
        raise DataError(f"{data} holds another answer, and no fit")
    return found


def _sweep(data: Identification | Data) -> Measurement:
    """A single sweep, of which points say something without a model."""
    found = read(data) if isinstance(data, str | Path) else data
    if isinstance(found, Measurement):
        return found
    raise DataError("tests in time, and several, say their quantities by a model: name one")


def _usual(seen: tuple[float, float], clock: str) -> float:
    """A frequency in Hz to be asked for: one where it was measured, else the middle."""
    unit = 1.0 if clock == "rad/s" else 2.0 * np.pi
    low, high = (rate / unit for rate in seen)
    asked = 1.0
    if not low <= 1.0 <= high:
        middle = float(np.sqrt(low * high))
        step = 10.0 ** np.floor(np.log10(middle))
        asked = float(np.clip(round(middle / step) * step, low, high))
    return asked * unit / (2.0 * np.pi)


def _of_fit(
    fit: Identification,
    known: Known,
    frequency: float | None,
    asked: Mapping[str, float],
    notes: list[str],
) -> Iterator[Quantity]:
    """Those of the model, and those that its sweeps of the amplitude say by themselves."""
    low, high = known.covered.rate
    # Checked, and completed by what was the same in all tests, as of a prediction.
    answer = known.predict(omega=[float(np.sqrt(low * high))], **asked)
    conditions = {name: float(column[0]) for name, column in answer.conditions.items()}
    for name, (least, most) in known.covered.conditions.items():
        if least == most:
            conditions.setdefault(name, least)
    free = is_material(known.model)
    band = float(np.log(low)), float(np.log(high))
    if not free:
        band = band[0] - REACH, band[1] + REACH
    model = OfModel(known, conditions, band, limits=not free)
    found = list(model.quantities())
    notes += _lacking(found, free)
    yield from found
    yield from model.at(frequency or _usual((low, high), known.units.clock))
    for test in fit.data:
        if isinstance(test, Measurement):
            yield from of_amplitude(test, notes)


def _lacking(found: Sequence[Quantity], free: bool) -> Iterator[str]:
    """What a model has none of."""
    names = {row.name for row in found}
    if "crossover frequency" not in names:
        where = "in the measured range" if free else "within three decades of the measured range"
        yield f"no crossover {where}"
    if free:
        yield "a free spectrum ends with the data: it has no limits at rest or of fast changes"
    elif not any("rest" in row.says for row in found):
        yield "at rest the model follows a power of the frequency: neither modulus nor viscosity"
    if "mean relaxation time" not in names and not free:
        yield "the model has no mean relaxation time that is finite"
