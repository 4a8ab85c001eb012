"""The paper's artificial data, section 5.1.

Five models at 14 frequencies, exact and with the noise of eq. (53).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from springpot.errors import DataError
from springpot.measurement import DataSet, Measurement, Units, with_noise

from ..models.paper import MODELS

SEED = 2017
"""Seed of the registered noisy sets; `artificial` draws others.

Any number would do: results name these sets.
"""
FREQUENCIES = np.arange(0.5, 14.0, 1.0)
"""0.5 to 13.5 Hz in steps of 1 Hz."""
SCALE = 1000.0
"""k-bar in kN/m."""
_THREE = {"k": 400.0, "c": 150.0, "alpha": 0.6}
_FOUR = {"k1": 600.0, "k2": 400.0, "c": 150.0, "alpha": 0.6}
TRUTH = {
    "springpot": {"c": 150.0, "alpha": 0.6},
    "fractional-kelvin": _THREE,
    "fractional-maxwell": _THREE,
    "fractional-kelvin4": _FOUR,
    "fractional-zener": _FOUR,
}
CITATION = (
    "Parameters identification of fractional models of viscoelastic dampers and fluids, section 5.1"
)


def artificial(
    model: str,
    level: float = 0.0,
    *,
    symmetric: bool = False,
    seed: int | np.random.Generator = SEED,
) -> Measurement:
    """Artificial data of one of the paper's models in kN/m.

    Parameters
    ----------
    model : str
        One of `TRUTH`.
    level : float
        Noise level of eq. (53), such as 0.01; 0 for exact data.
    symmetric : bool
        Noise of both signs instead of the one-sided noise as printed.
    seed : int or numpy.random.Generator
        Where the noise comes from; the registered sets use `SEED`.

    Raises
    ------
    DataError
        If the paper has no such model.
    """
    if model not in TRUTH:
        raise DataError(
            f"there are no artificial data of '{model}': the paper has {', '.join(TRUTH)}"
        )
    known = next(item for item in MODELS if item.base == model)
    omega = 2.0 * np.pi * FREQUENCIES
    exact = Measurement(
        omega,
        known.stiffness(known.vector(TRUTH[model]), omega),
        units=Units("kN/m", "mm"),
        name=f"artificial-{model}{_suffix(level, symmetric)}",
        provenance={"source": "computed, section 5.1", "model": model},
    )
    if level == 0:
        return exact
    return with_noise(exact, level, np.random.default_rng(seed), symmetric=symmetric)


def _suffix(level: float, symmetric: bool) -> str:
    if not level:
        return ""
    # The noise that the paper prints is what its name says without a word; the other kind says so.
    kind = "noise"
    if symmetric:
        kind = "symmetric"
    return f"-{kind}{100 * level:g}"


def _dataset(model: str, level: float, symmetric: bool) -> DataSet:
    noise = "without noise"
    if level:
        kind = "one-sided as printed"
        if symmetric:
            kind = "both signs"
        noise = f"with {100 * level:g} % noise of eq. (53), {kind}, seed {SEED}"
    return DataSet(
        f"artificial-{model}{_suffix(level, symmetric)}",
        f"computed from {model} at 14 frequencies from 0.5 to 13.5 Hz, {noise}",
        partial(artificial, model, level, symmetric=symmetric),
        kind="artificial",
        licence="none needed",
        citation=CITATION,
        size=len(FREQUENCIES),
        truth=dict(TRUTH[model]),
        model=model,
        stiffness_scale=SCALE,
    )


def datasets() -> list[DataSet]:
    """Five models, exact and with noise of 1 % and 2 %, one-sided and symmetric."""
    variants = [(0.0, False), (0.01, False), (0.02, False), (0.01, True), (0.02, True)]
    return [_dataset(model, level, symmetric) for model in TRUTH for level, symmetric in variants]
