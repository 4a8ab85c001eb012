"""What is said beside a master curve: of factors that are not determined, and of repeats."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.identification.free_factors import FactorRows, Factors
from springpot.identification.known_factors import KnownFactors
from springpot.identification.levels_alone import FEW, Alone
from springpot.rheology.levels import level_text
from springpot.thresholds import SUPERPOSITION

WHY = {
    "no overlap": (
        "the sweeps do not overlap with the rest; their factors are not determined, as many fit"
        " alike: the interval goes from where they would begin to overlap"
    ),
    "flat": (
        "storage and loss are flat within their scatter, so that there is nothing to shift by:"
        " any factor a fits"
    ),
    "too few points": (
        f"sweeps of fewer than {FEW} frequencies;"
        " their factors are known to no better than a decade"
    ),
    "at the end of the search": (
        "the search ended at the end of its range; the factors are not determined"
    ),
    "wide": (
        "the sweeps overlap too little or are too straight;"
        " their factors are known to no better than a decade"
    ),
}
"""What is said of the levels whose factor is not determined, by its reason."""


def undetermined(factors: Factors, known: KnownFactors) -> list[str]:
    """One sentence for each reason for which factors are not determined."""
    reasons = np.array(known.reason)
    notes = []
    for reason, why in WHY.items():
        there = factors.levels[reasons == reason].tolist()
        if there:
            notes.append(
                f"{', '.join(level_text(factors.column, value) for value in there)}: {why}"
            )
    return notes


def not_told_apart(factors: Factors, told: NDArray[np.bool_]) -> list[str]:
    """A sentence for levels at which a shift does what a vertical factor would do as well."""
    if np.all(told):
        return []
    names = ", ".join(level_text(factors.column, value) for value in factors.levels[~told].tolist())
    return [
        f"{names}: a and b cannot be told apart, as the sweeps are nearly straight: b is taken as"
        " near to 1 as the data allow, and the interval of a holds for such a b"
    ]


def vertical_range(factors: Factors, told: NDArray[np.bool_]) -> list[str]:
    """A sentence where the data ask for vertical factors that physics does not explain."""
    if factors.column != "temperature":
        return []
    span = float(np.exp(np.ptp(factors.log_b[told])))
    if span < SUPERPOSITION.vertical_range:
        return []
    return [
        f"the vertical factors range over a factor of {span:.2g}, more than density and rubber"
        " elasticity explain: the data contradict smaller ones, as a changed geometry, a slip or a"
        " failure of superposition would"
    ]


def repeats_in_words(rows: FactorRows, own: Alone) -> list[str]:
    """A sentence where repeated sweeps differ, which no curve can follow."""
    scatter = own.repeats
    far = np.flatnonzero(scatter > SUPERPOSITION.repeats_differ)
    if not len(far):
        return []
    names = ", ".join(rows.named(i) for i in far.tolist())
    return [
        f"repeated sweeps differ by up to {100.0 * scatter.max():.2g} % ({names}),"
        " which no curve can follow"
    ]
