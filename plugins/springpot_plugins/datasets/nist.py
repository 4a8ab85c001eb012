"""The certified silicone fluid of NIST, SRM 2491, embedded with its uncertainties."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files

from springpot.measurement import DataSet, Measurement

from ..readers.springpot_csv import parse

NAME = "nist-srm2491"
CITATION = (
    "Schultheisz, Flynn, Leigh: NIST Special Publication 260-147, Table 9; 10.6028/NIST.SP.260-147"
)
_COLUMNS = ("omega [rad/s]", "storage [Pa]", "loss [Pa]", "storage_sd [Pa]", "loss_sd [Pa]")
DOI = "10.6028/NIST.SP.260-147"


def _load() -> Measurement:
    # By the package, which may be installed as a zip file.
    text = files(__package__).joinpath(f"{NAME}.csv").read_text(encoding="utf-8")
    return replace(parse(text, NAME), name=NAME)


def datasets() -> list[DataSet]:
    """One set of six temperatures, 0 to 50 degC, at 16 frequencies each."""
    return [
        DataSet(
            NAME,
            "polydimethylsiloxane melt, 6 temperatures, 0 to 50 degC, 0.1 to 100 rad/s, with"
            " standard uncertainties",
            _load,
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
