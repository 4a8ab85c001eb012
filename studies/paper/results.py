"""A finished study's trials, and what is commonly read off them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from springpot import Measurement, Model, open_measurement, parse_model
from springpot.benchmark import Store
from springpot.benchmark.summary import TrialRow
from springpot.errors import SpringpotError
from springpot.rheology.points import Complex


@dataclass(frozen=True)
class Results:
    """Trials of a study by data set, model and optimiser.

    Parameters
    ----------
    trials : dict
        From (data set, model, optimiser) to the trials in order, without the failed ones.
    """

    trials: dict[tuple[str, str, str], list[TrialRow]]

    @classmethod
    def of(cls, path: Path) -> Results:
        """The trials kept in the store at `path`."""
        with Store(path) as store:
            found = {
                (cell.problem.dataset, cell.problem.model, cell.label): [
                    row for row in rows if row.best is not None
                ]
                for cell, rows in store.raced()
            }
        return cls(found)

    def of_cell(self, dataset: str, model: str, optimiser: str) -> list[TrialRow]:
        """The trials of one cell in the order of their numbers."""
        return self.trials.get((dataset, model, optimiser), [])

    def best(self, dataset: str, model: str, optimiser: str | None = None) -> TrialRow | None:
        """The trial with the smallest objective, of one optimiser or of all."""
        cells = [
            group
            for (d, m, o), group in self.trials.items()
            if (d, m) == (dataset, model) and optimiser in (None, o)
        ]
        return best_of([trial for group in cells for trial in group])


def best_of(trials: Sequence[TrialRow]) -> TrialRow | None:
    """The trial with the smallest objective."""
    return min(trials, key=lambda trial: trial.best or 0.0, default=None)


def relative_rms(model: str | Model, theta: Mapping[str, float], data: Measurement) -> float:
    """Root mean square of |K - K_m| / |K_m|."""
    return float(np.sqrt(np.mean(np.abs(gap(model, theta, data) / data.magnitude) ** 2)))


def absolute_rms(model: str | Model, theta: Mapping[str, float], data: Measurement) -> float:
    """Root of the paper's objective, eq.

    (44), over that of K = 0: what the paper minimises, as a relative number.
    """
    squares = np.sum(np.abs(gap(model, theta, data)) ** 2)
    return float(np.sqrt(squares / np.sum(data.magnitude**2)))


def sd_rms(model: str | Model, theta: Mapping[str, float], data: Measurement) -> float:
    """Root mean square of the differences of K' and K'' over their given standard deviations."""
    assert data.sd is not None
    apart = gap(model, theta, data)
    parts = [(apart.real / data.sd.real) ** 2, (apart.imag / data.sd.imag) ** 2]
    return float(np.sqrt(np.mean(parts)))


def gap(model: str | Model, theta: Mapping[str, float], data: Measurement) -> Complex:
    """K less the measured one, (n,)."""
    found = parse_model(model) if isinstance(model, str) else model
    return np.asarray(found.stiffness(found.vector(dict(theta)), data.points) - data.stiffness)


def percent(error: float) -> str:
    """A relative error for a title."""
    return f"{100 * error:.2g} %" if error > 1e-5 else "below 0.001 %"


def available(name: str) -> bool:
    """Whether a data set is registered and can be opened here."""
    try:
        open_measurement(name)
    except SpringpotError:
        return False
    return True
