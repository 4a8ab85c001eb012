"""Quantities of a fit: those of its material, and those that its sweeps say by themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from springpot.errors import DataError
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test
from springpot.rheology.effect import Layer
from springpot.rheology.points import KELVIN

from ..material import is_material
from ..prediction import Known
from .from_data import of_amplitude
from .from_model import REACH, OfModel
from .quantity import Quantities, Quantity


def of_fit(
    known: Known,
    name: str,
    tests: Iterable[Test],
    frequency: float | None = None,
    asked: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
) -> Quantities:
    """Those of the material, then those that sweeps of the amplitude say by themselves.

    Parameters
    ----------
    known : Known
        The fit.
    name : str
        Of the data.
    tests : iterable of tests
        What it was fitted to.
    frequency : float, optional
        In Hz, of |K|, loss factor and energy.
    asked : mapping of str to float, optional
        Conditions; by default the reference temperature, and what was the same in all tests.
    without : sequence of str
        Effects that are left out beside those of the rig, the signal and the test.

    Raises
    ------
    SpringpotError
        If the model depends on a condition that was not the same in all tests, or knows none of
        what is asked for.
    """
    # First: which level is meant must be said before anything that depends on it.
    level = known.of_specimen.at_level(asked or {})
    conditions, of = _conditions(known, asked or {}), known.model.name
    known, left = _of_material(level, without)
    low, high = known.covered.rate
    free = is_material(known.model)
    band = float(np.log(low)), float(np.log(high))
    if not free:
        band = band[0] - REACH, band[1] + REACH
    model = OfModel(known, conditions, band, limits=not free)
    found = list(model.quantities())
    at = model.at(frequency or usual((low, high), known.units.clock))
    sweeps = [of_amplitude(test) for test in tests if isinstance(test, Measurement)]
    rows, notes = parted([*_lacking(found, free), *found, *at, *chain.from_iterable(sweeps)])
    rows = tuple(replace(row, at=known.named(row.at)) for row in rows)
    return Quantities(name, of, known.units, rows, notes, left)


def parted(told: Iterable[Quantity | str]) -> tuple[tuple[Quantity, ...], tuple[str, ...]]:
    """Quantities, and the notes among them."""
    whole = list(told)
    rows = tuple(each for each in whole if isinstance(each, Quantity))
    return rows, tuple(each for each in whole if isinstance(each, str))


def in_short(known: Known, name: str, tests: Iterable[Test]) -> Quantities:
    """Those that a fit has where nothing is asked; none where a condition would have to be."""
    try:
        return of_fit(known, name, tests)
    except DataError as error:
        return Quantities(name, known.model.name, known.units, (), (str(error),))


def usual(seen: tuple[float, float], clock: str) -> float:
    """A frequency in Hz to be asked for: one where it was measured, else the middle."""
    unit = 1.0 if clock == "rad/s" else 2.0 * np.pi
    low, high = (rate / unit for rate in seen)
    asked = 1.0
    if not low <= 1.0 <= high:
        middle = float(np.sqrt(low * high))
        step = 10.0 ** np.floor(np.log10(middle))
        asked = float(np.clip(round(middle / step) * step, low, high))
    return asked * unit / (2.0 * np.pi)


def _conditions(known: Known, asked: Mapping[str, float]) -> dict[str, float]:
    """What is asked for, checked and completed by what was the same in all tests."""
    low, high = known.covered.rate
    wanted = dict(asked)
    if "temperature" in known.model.needs:
        least, most = known.covered.conditions.get("temperature", (0.0, 0.0))
        # Where shifts are one, to which their constants refer.
        if least < most:
            wanted.setdefault("temperature", round(known.reference - KELVIN, 2))
    answer = known.predict(omega=[float(np.sqrt(low * high))], **wanted)
    conditions = {name: float(column[0]) for name, column in answer.conditions.items()}
    for name, (least, most) in known.covered.conditions.items():
        if least == most:
            conditions.setdefault(name, least)
    return conditions


def _of_material(known: Known, without: Sequence[str]) -> tuple[Known, tuple[str, ...]]:
    """A fit without what is not the material's, and the names of all that is left out."""
    # A mass or a delay would make crossovers of its own.
    outer = [each.name for each in known.model.effects if each.layer > Layer.TEMPERATURE]
    left = tuple(dict.fromkeys([*without, *outer]))
    return known.without(without).without(name for name in outer if name not in without), left


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
