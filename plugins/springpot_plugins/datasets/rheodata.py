"""The oscillatory sets of the package rheopy-rheodata, read from its files without importing it."""

from __future__ import annotations

import csv
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import DataSet, Measurement, Units
from springpot.rheology import Real

INSTALL = "install it with: pip install 'springpot[data]' (or pip install rheopy-rheodata)"
_FREQUENCY = "caggioni_linear_polymer_frequency_sweep"
_AMPLITUDE = "caggioni_linear_polymer_amplitude_sweep"


def _folder() -> Path | None:
    spec = find_spec("rheodata")
    if spec is None or not spec.submodule_search_locations:
        # Not installed, or another module of that name that is no package.
        return None
    return Path(spec.submodule_search_locations[0]) / "datasets"


def _columns(identifier: str) -> dict[str, Real]:
    folder = _folder()
    if folder is None:
        raise DataError(f"data set '{_name(identifier)}' needs rheopy-rheodata: {INSTALL}")
    try:
        with (folder / identifier / "data.csv").open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        return {
            key: np.array([float(row[key]) for row in rows])
            for key in rows[0]
            if key != "sample_id"
        }
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise DataError(
            f"data set '{_name(identifier)}': rheopy-rheodata has changed its file: {error}"
        ) from None


def _load(identifier: str) -> Measurement:
    columns = _columns(identifier)
    n = len(columns["Gp_Pa"])
    # The amplitude sweep was made at 1 rad/s, the frequency sweep at 0.5 % strain (dataset.yaml of
    # the package).
    omega, strain = np.ones(n), np.full(n, 0.5)
    if identifier == _AMPLITUDE:
        strain = columns["strain_pct"]
    else:
        omega = columns["omega_rad/s"]
    return Measurement(
        omega,
        columns["Gp_Pa"] + 1j * columns["Gpp_Pa"],
        conditions={"temperature": np.full(n, 25.0), "amplitude": strain},
        units=Units("Pa", "%", "rad/s", "G"),
        name=_name(identifier),
        provenance={"source": "PyPI package rheopy-rheodata", "set": identifier, "licence": "MIT"},
    )


def _name(identifier: str) -> str:
    return f"rheodata-{identifier.removeprefix('caggioni_').replace('_', '-')}"


def datasets() -> list[DataSet]:
    """The frequency sweep and the amplitude sweep.

    Listed as unavailable where the package is absent.
    """
    fluid = "high-molecular-weight linear polymer in water, 25 degC"
    sets = (
        (_FREQUENCY, f"{fluid}, 0.1 to 100 rad/s at 0.5 % strain", 31, ("linear range",)),
        (
            _AMPLITUDE,
            f"{fluid}, 0.1 to 1000 % strain at 1 rad/s",
            41,
            ("linear up to about 10 % strain",),
        ),
    )
    missing = ""
    if not find_spec("rheodata"):
        missing = f"rheopy-rheodata is not installed; {INSTALL}"
    return [
        DataSet(
            _name(identifier),
            summary,
            partial(_load, identifier),
            licence="MIT",
            citation="Caggioni, community contribution to rheopy-rheodata 0.1.1",
            size=size,
            physics=physics,
            unavailable=missing,
        )
        for identifier, summary, size, physics in sets
    ]
