"""Models against the same tests in time.

Which of them follows them best, for its number of parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.errors import DataError, SpringpotError
from springpot.registry import parse_model
from springpot.rheology.model import Model

from .fitting import identify
from .residuals_of_tests import Test
from .result import TimeIdentification

SCHEMA = "springpot.comparison-in-time/1"


@dataclass(frozen=True, eq=False)
class TimeComparison:
    """Models against tests in time.

    Attributes
    ----------
    fits : tuple of TimeIdentification
        Best first, by the Bayesian information criterion.
    delta_bic : tuple of float
        By how much that of each exceeds the best one's; 10 is very strong evidence (Kass & Raftery
        1995, doi:10.1080/01621459.1995.10476572).
    left_out : dict of str to str
        Models that cannot be fitted to these tests, and why.
    """

    fits: tuple[TimeIdentification, ...]
    delta_bic: tuple[float, ...]
    left_out: dict[str, str]

    @property
    def best(self) -> TimeIdentification:
        """The fit of the first model."""
        return self.fits[0]

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison-in-time/1``."""
        return {
            "schema": SCHEMA,
            "data": " + ".join(test.name for test in self.best.tests),
            "best": self.best.model.name,
            "models": [
                {
                    "model": fit.model.name,
                    "delta_bic": delta,
                    "relative_rms": fit.relative_rms,
                    "tests": [test.to_dict() for test in fit.tests],
                    "parameters": fit.parameters,
                    "notes": list(fit.notes),
                }
                for fit, delta in zip(self.fits, self.delta_bic, strict=True)
            ],
            "left_out": self.left_out,
        }


def compare(
    tests: Sequence[Test],
    models: Sequence[Model | str],
    progress: Callable[[str], None] | None = None,
) -> TimeComparison:
    """Judge models of tests in time, each fitted to all of them together.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    models : sequence of Model or str
        Those that have no law in time, or lack a condition, are named as left out.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    TimeComparison
        Best first.

    Raises
    ------
    SpringpotError
        If none of the models can be fitted.

    Notes
    -----
    Misses count in units of the noise, or of what the best model leaves where that is more: between
    models that are both far off, precision that none of them can use is no evidence.
    """
    fits: list[TimeIdentification] = []
    left_out: dict[str, str] = {}
    # All expressions first: one that is mistyped is told before minutes are spent on the others.
    parsed = [_parsed(each) for each in models]
    for model in parsed:
        if progress is not None:
            progress(f"fitting {model.name}")
        try:
            fits.append(identify(tests, model))
        except SpringpotError as error:
            # One model that cannot be followed must not keep the others from being compared.
            left_out[model.name] = str(error)
    if not fits:
        raise DataError(next(iter(left_out.values()), "there is no model to compare"))
    # All models were fitted to the same samples.
    points = sum(test.points for test in fits[0].tests)
    # By what the best model leaves, where that is more than noise: see the notes.
    scale = max(1.0, min(fit.power for fit in fits) / points)
    criteria = [fit.power / scale + len(fit.theta) * np.log(points) for fit in fits]
    least = min(criteria)
    ranked = sorted(zip(criteria, fits, strict=True), key=lambda pair: pair[0])
    deltas = tuple(float(criterion - least) for criterion, _ in ranked)
    return TimeComparison(tuple(fit for _, fit in ranked), deltas, left_out)


def _parsed(model: Model | str) -> Model:
    if isinstance(model, str):
        return parse_model(model)
    return model
