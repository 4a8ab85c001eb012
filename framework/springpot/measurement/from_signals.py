"""A measurement from the harmonics of one record or several."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from springpot.errors import DataError
from springpot.limits import uncounted
from springpot.thresholds import SIGNALS

from .measurement import Measurement
from .signals import Harmonics, harmonics_of
from .steady import Signals
from .units import (
    ANGLE_UNITS,
    FILE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STRAIN_UNITS,
    TORQUE_UNITS,
    Units,
)


def stiffness_unit(displacement: str, force: str) -> tuple[float, str]:
    """Factor and unit of force over displacement.

    Such as (1.0, ``N/mm``) or (100.0, ``Pa``) for Pa over %.

    Raises
    ------
    DataError
        If the pair makes neither a stiffness, a modulus nor a torsional stiffness.
    """
    linear = force in FORCE_UNITS and displacement in LENGTH_UNITS
    if linear or (force in TORQUE_UNITS and displacement in ANGLE_UNITS):
        return 1.0, f"{force}/{displacement}"
    # Of numbers whose units nobody tells the one over the other is no better known.
    if (force in PRESSURE_UNITS or force == FILE_UNITS) and displacement in STRAIN_UNITS:
        return 1.0 / STRAIN_UNITS[displacement], force
    raise DataError(
        f"[{force}] over [{displacement}] is no stiffness: "
        "give force and length, stress and strain, or torque and angle"
    )


def measurement_from_signals(
    tests: Iterable[Signals],
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
    name: str | None = None,
    provenance: Mapping[str, str] | None = None,
) -> Measurement:
    """One measurement of several tests, a row for each.

    Parameters
    ----------
    tests : iterable of Signals
        Taken one after the other, so that long ones need not be in memory together; all in the same
        units.
    omega, n_harmonics, window
        As in `harmonics_of`, for every test.
    name : str, optional
        Name of the measurement; by default that of the first test.
    provenance : mapping of str to str, optional
        Where the signals come from; notes of the single tests are added.

    Returns
    -------
    Measurement
        With standard deviations, amplitude, harmonics, and the tests' names as the label ``file``;
        rows are in the order of frequency, those of one frequency (to three digits) of amplitude.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import Signals, measurement_from_signals
    >>> t = np.linspace(0.0, 5.0, 2000)
    >>> tests = [
    ...     Signals(t, np.cos(w * t), 2.0 * np.cos(w * t + 0.3), name=f"test {w}")
    ...     for w in (12.0, 6.0)
    ... ]
    >>> measurement_from_signals(tests).omega.round(6)
    array([ 6., 12.])
    """
    evaluated = (
        one_test(test, omega=omega, n_harmonics=n_harmonics, window=window) for test in tests
    )
    return measurement_of_tests(evaluated, name, provenance)


@dataclass(frozen=True, eq=False)
class OneTest:
    """What the signals of one test come to, without the signals.

    Parameters
    ----------
    row : Harmonics
        Its row of a measurement.
    name : str
        What it is called there.
    units : tuple of str
        Of displacement and force.
    notes : tuple of str
        What its reader and its harmonics remark.
    """

    row: Harmonics
    name: str
    units: tuple[str, str]
    notes: tuple[str, ...]


def one_test(
    test: Signals,
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
) -> OneTest:
    """The harmonics of one test; parameters as in `harmonics_of`."""
    # Signals may be read while a reader's time runs: the fit is not its work.
    with uncounted():
        row = harmonics_of(
            test.time,
            test.displacement,
            test.force,
            omega=omega,
            n_harmonics=n_harmonics,
            window=window,
            name=test.name,
        )
    remarks = [value for key, value in test.provenance.items() if key.startswith("note ")]
    notes = (*remarks, *row.notes, *_doubts_of_sign(row, test.force_unit))
    return OneTest(row, PurePath(test.name).stem, (test.displacement_unit, test.force_unit), notes)


def measurement_of_tests(
    tests: Iterable[OneTest], name: str | None = None, provenance: Mapping[str, str] | None = None
) -> Measurement:
    """One measurement with a row for each test; see `measurement_from_signals`.

    Raises
    ------
    DataError
        If there are none, or their units differ.
    """
    rows, names, units, origin = [], [], [], dict(provenance or {})
    for test in tests:
        rows.append(test.row)
        names.append(test.name)
        units.append(test.units)
        if test.notes:
            origin[f"note {test.name}"] = "; ".join(test.notes)
    if not rows:
        raise DataError("no signals given: name at least one file")
    # Amplitudes of one column must have one unit; which one the user wants cannot be guessed.
    if len(set(units)) > 1:
        shown = ", ".join(sorted({f"[{d}] and [{f}]" for d, f in units}))
        raise DataError(f"the signals come in different units ({shown}): convert them first")
    first = name or names[0]
    # To three digits: frequencies are estimated, and those of one setting differ a little.
    ordered = sorted(
        zip(rows, names, strict=True),
        key=lambda pair: (float(f"{pair[0].omega:.3g}"), pair[0].amplitude),
    )
    rows, names = [row for row, _ in ordered], [label for _, label in ordered]
    return _measurement(rows, names, units[0], first, origin)


def _doubts_of_sign(row: Harmonics, force_unit: str) -> list[str]:
    """What to tell of a specimen that gives work away, as only a wrong sign or a drive explains."""
    # With the unit that the force has: typed as it stands, another one would change the stiffness a
    # thousandfold.
    mend = f"if one channel counts the other way, open 'FILE?force=-{force_unit}'"
    # The work of a cycle is pi X^2 K'': its doubt is that of K''.
    doubt = np.pi * row.amplitude**2 * row.sd.imag
    surely = (
        row.stiffness.imag < -SIGNALS.negative * row.sd.imag or row.work < -SIGNALS.negative * doubt
    )
    if surely and row.stiffness.real < -SIGNALS.negative * row.sd.real:
        return [f"storage and loss are negative, as if the force had the wrong sign: {mend}"]
    if surely:
        return [f"the loss is negative, over each cycle the specimen gives work away: {mend}"]
    if row.stiffness.real < -SIGNALS.negative * row.sd.real:
        return [
            "the storage is negative, as above a resonance of a moving mass or with a channel late"
            " by a half cycle"
        ]
    return []


def _measurement(
    rows: list[Harmonics],
    names: list[str],
    units: tuple[str, str],
    name: str,
    provenance: dict[str, str],
) -> Measurement:
    factor, unit = stiffness_unit(*units)
    width = max(len(row.force) for row in rows) - 1
    # Tests at high frequencies afford fewer harmonics: what was not fitted is unknown, and not
    # zero.
    relative = np.full((len(rows), width), complex(np.nan, np.nan))
    for i, row in enumerate(rows):
        relative[i, : len(row.force) - 1] = row.relative
    harmonics = None
    if width:  # with the first alone there are no higher ones
        harmonics = relative
    return Measurement(
        omega=np.array([row.omega for row in rows]),
        stiffness=factor * np.array([row.stiffness for row in rows], dtype=np.complex128),
        sd=factor * np.array([row.sd for row in rows], dtype=np.complex128),
        conditions={"amplitude": np.array([row.amplitude for row in rows])},
        harmonics=harmonics,
        units=Units(unit, units[0]),
        name=name,
        provenance={"method": "least squares of harmonics, eq. (36)-(43)", **provenance},
        labels={"file": np.array(names)},
    )
