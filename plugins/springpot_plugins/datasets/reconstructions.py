"""Curves computed from the parameters printed in Tables 3 to 6: reconstructions, no measurements.

The paper shows its measured points only in figures. What a fitted model gives at frequencies of our
choice says nothing about scatter or about what the model missed; these sets serve to repeat the
paper's arithmetic.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from springpot.measurement import DataSet, Measurement, Units
from springpot.rheology import Real

from ..models import fluids, paper

_PAPER = "Parameters identification of fractional models of viscoelastic dampers and fluids"
_MAKRIS = "Makris (1992), PhD dissertation, State University of New York at Buffalo, eq. (54)"
DAMPER_HZ = np.linspace(1.0, 50.0, 50)
"""Our grid: Figures 7 to 10 reach about 50 Hz."""
MAKRIS = {"c0": 15.0, "tau": 0.3 ** (1.0 / 0.6), "ratio": 0.6, "q": 1.0}
"""C0 = 15 kN s/m, lambda = 0.3 s^0.6, r = 0.6, q = 1."""
TABLE_3 = {
    "kelvin": ("fractional-kelvin", {"k": 23.098, "c": 23.098, "alpha": 0.5110}),
    "maxwell": ("fractional-maxwell", {"k": 1402.79, "c": 20.663, "alpha": 0.5822}),
    "kelvin4": ("fractional-kelvin4", {"k1": 1196.2, "k2": 0.5337, "c": 19.022, "alpha": 0.6049}),
    "zener": ("fractional-zener", {"k1": 0.04804, "k2": 1364.19, "c": 20.402, "alpha": 0.5856}),
}
TABLE_4 = {
    "maxwell": ("fractional-maxwell", {"k": 85931.0, "c": 2060.9, "alpha": 0.7500}),
    "standard": ("fractional-kelvin4", {"k1": 92931.0, "k2": 0.0, "c": 2129.4, "alpha": 0.7369}),
    "zener": ("fractional-zener", {"k1": 0.0, "k2": 88898.4, "c": 2067.8, "alpha": 0.7301}),
}
TABLE_5 = {
    "0.1mrad-maxwell": ("fractional-maxwell", {"k": 80614.7, "c": 2038.84, "alpha": 0.7544}),
    "1mrad-maxwell": ("fractional-maxwell", {"k": 87876.0, "c": 2095.16, "alpha": 0.7470}),
    "10mrad-maxwell": ("fractional-maxwell", {"k": 85931.0, "c": 2060.90, "alpha": 0.7500}),
    "0.1mrad-standard": (
        "fractional-kelvin4",
        {"k1": 80362.8, "k2": 168.4, "c": 1999.2, "alpha": 0.7595},
    ),
    "1mrad-standard": (
        "fractional-kelvin4",
        {"k1": 96591.5, "k2": 187.4, "c": 2172.0, "alpha": 0.7325},
    ),
    "10mrad-standard": (
        "fractional-kelvin4",
        {"k1": 92931.0, "k2": 0.0, "c": 2129.4, "alpha": 0.7369},
    ),
}
TABLE_6 = (
    (63.0, 80614.7, 2038.8, 0.7544),
    (50.0, 75925.2, 1992.2, 0.7676),
    (43.0, 68786.9, 1941.9, 0.8009),
    (28.0, 60248.8, 1885.1, 0.8033),
    (20.0, 52960.2, 1843.2, 0.8229),
    (10.0, 40452.7, 1793.3, 0.8602),
    (5.0, 30474.4, 1781.8, 0.8937),
)
"""Highest frequency in Hz, E in Pa, eta in Pa s^alpha, alpha."""
_MODELS = {model.base: model for model in (*paper.MODELS, *fluids.MODELS)}


def fluid_hz(highest: float) -> Real:
    """Our grid of 30 frequencies, evenly spaced in the logarithm, from 0.3 Hz to `highest`."""
    return np.geomspace(0.3, highest, 30)


def _computed(
    name: str, model: str, truth: dict[str, float], hertz: Real, unit: str, source: str
) -> Measurement:
    omega = 2.0 * np.pi * hertz
    known = _MODELS[model]
    # A branch of zero stiffness is what Table 4 prints; 1/0 is the limit that is wanted.
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = known.stiffness(known.vector(truth), omega)
    origin = {
        "source": f"reconstruction from {source}, not measured",
        "model": model,
        "grid": "chosen by us",
    }
    # A stiffness moves by a length, a modulus by a strain.
    moved = "-"
    if "m" in unit:
        moved = "mm"
    return Measurement(omega, stiffness, units=Units(unit, moved), name=name, provenance=origin)


def _dataset(
    name: str, model: str, truth: dict[str, float], hertz: Real, unit: str, source: str
) -> DataSet:
    name = f"reconstruction-{name}"
    return DataSet(
        name,
        f"computed from {model} with the parameters of {source} at frequencies of our choice; not"
        " measured",
        partial(_computed, name, model, truth, hertz, unit, source),
        kind="reconstruction",
        licence="none needed",
        citation=f"{source}; {_PAPER}",
        size=len(hertz),
        truth=dict(truth),
        model=model,
        stiffness_scale=None,
    )


def datasets() -> list[DataSet]:
    """The damper of Makris and the silicone fluid, from every row of Tables 3 to 6."""
    sets = [_dataset("makris-1992", "makris", MAKRIS, DAMPER_HZ, "kN/m", _MAKRIS)]
    sets += [
        _dataset(f"makris-table3-{key}", model, truth, DAMPER_HZ, "kN/m", "Table 3")
        for key, (model, truth) in TABLE_3.items()
    ]
    for number, table in ((4, TABLE_4), (5, TABLE_5)):
        sets += [
            _dataset(
                f"pdms-table{number}-{key}", model, truth, fluid_hz(63.0), "Pa", f"Table {number}"
            )
            for key, (model, truth) in table.items()
        ]
    for row, (highest, modulus, eta, alpha) in enumerate(TABLE_6, 1):
        truth = {"k": modulus, "c": eta, "alpha": alpha}
        name, source = f"pdms-table6-{row}", f"Table 6, row {row}"
        sets.append(_dataset(name, "fractional-maxwell", truth, fluid_hz(highest), "Pa", source))
    return sets
