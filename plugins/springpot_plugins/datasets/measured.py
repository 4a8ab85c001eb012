"""Measured data sets that come with a package.

The certified silicone fluid of NIST, SRM 2491, embedded with its uncertainties; and the oscillatory
sets of the package rheopy-rheodata, read from its files without importing it.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import DataSet, Measurement, Units
from springpot.rheology import Real

from ..readers.springpot_csv import parse

NAME = "nist-srm2491"
CITATION = (
    "Schultheisz, Flynn, Leigh: NIST Special Publication 260-147, Table 9; 10.6028/NIST.SP.260-147"
)
_COLUMNS = ("omega [rad/s]", "storage [Pa]", "loss [Pa]", "storage_sd [Pa]", "loss_sd [Pa]")
DOI = "10.6028/NIST.SP.260-147"


def _fluid() -> Measurement:
    # By the package, which may be installed as a zip file.
    text = files(__package__).joinpath(f"{NAME}.csv").read_text(encoding="utf-8")
    return replace(parse(text, NAME), name=NAME)


def _of_nist() -> list[DataSet]:
    """One set of six temperatures, 0 to 50 degC, at 16 frequencies each."""
    return [
        DataSet(
            NAME,
            "polydimethylsiloxane melt, 6 temperatures, 0 to 50 degC, 0.1 to 100 rad/s, with"
            " standard uncertainties",
            _fluid,
            licence="public domain (US government work)",
            citation=CITATION,
            doi=DOI,
            origin="doi.org/10.6028/NIST.SP.260-147",
            test=(
                "small-strain oscillatory shear of a certified reference fluid, 16 frequencies at"
                " each temperature"
            ),
            columns=(*_COLUMNS, "temperature [degC]"),
            fit=(
                "WLF: ln a = -C1 (T - T_R) / (C2 + T - T_R), C1 = 6.64, C2 = 299.4 K, T_R = 25"
                " degC; vertical shift"
            ),
            aliases=("nist-srm2491-pdms",),
            size=96,
            physics=(
                "entangled melt in its terminal zone: a viscous limit at low frequency",
                (
                    "thermorheologically simple: WLF with C1 = 6.64 (natural logarithm), C2 = 299.4"
                    " K at 25 degC (NIST)"
                ),
                "a small vertical shift with density",
            ),
        )
    ]


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


def _of_package(identifier: str) -> Measurement:
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


def _of_rheodata() -> list[DataSet]:
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
            partial(_of_package, identifier),
            licence="MIT",
            citation="Caggioni, community contribution to rheopy-rheodata 0.1.1",
            size=size,
            physics=physics,
            unavailable=missing,
        )
        for identifier, summary, size, physics in sets
    ]


def datasets() -> list[DataSet]:
    """The silicone fluid, and those of rheopy-rheodata where it is installed."""
    return [*_of_nist(), *_of_rheodata()]
