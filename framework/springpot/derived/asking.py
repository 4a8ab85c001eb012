"""``springpot.quantities``: what is asked, and who answers it, the data or a model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from springpot.api import Data, identify, read
from springpot.errors import DataError, ModelError
from springpot.identification.fitted_quantities import of_fit, parted, usual
from springpot.identification.measured_quantities import of_amplitude, of_frequency
from springpot.identification.result import Identification
from springpot.identification.value import Quantities
from springpot.loading import load
from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model

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
        Effects of the material that are left out; those of the rig, the signal and the test are.
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
    if fit is not None:
        left = [without] if isinstance(without, str) else without
        return of_fit(fit, fit.name, fit.data, frequency, asked, left)
    sweep = _sweep(data)
    if asked or without:
        names = [*asked]
        if without:
            names.append("without")
        named = ", ".join(f"--{name}" for name in names)
        raise ModelError(f"{named}: data alone know none of it; name a model with --model")
    middle = frequency or usual(sweep.seen, sweep.units.clock)
    rows, notes = parted([*of_frequency(sweep, middle), *of_amplitude(sweep), ALONE])
    return Quantities(sweep.name, "", sweep.units, rows, notes)


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
