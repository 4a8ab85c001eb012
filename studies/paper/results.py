"""A finished study's trials, and what is commonly read off them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from springpot import Measurement, Model, open_measurement, parse_model
from springpot.benchmark import Store
from springpot.errors import SpringpotError


@dataclass(frozen=True)
class Trial:
    """One trial that came to something.

    Parameters
    ----------
    repetition : int
        Its number.
    objective : float
        Smallest value found.
    theta : dict of str to float
        Parameters there.
    """

    repetition: int
    objective: float
    theta: dict[str, float]


@dataclass(frozen=True)
class Results:
    """Trials of a study by data set, model and optimiser.

    Parameters
    ----------
    trials : dict
        From (data set, model, optimiser) to the trials in order, without the failed ones.
    """

    trials: dict[tuple[str, str, str], list[Trial]]

    @classmethod
    def of(cls, path: Path) -> Results:
        """The trials kept in the store at `path`."""
        with Store(path) as store:
            cells = {cell.id: cell for cell in store.cells()}
            found = {}
            for number, rows in store.trials():
                if number in cells:
                    problem = cells[number].problem
                    kept = [
                        Trial(r.repetition, r.best, dict(r.theta))
                        for r in rows
                        if r.best is not None
                    ]
                    found[problem.dataset, problem.model, cells[number].label] = kept
        return cls(found)

    def of_cell(self, dataset: str, model: str, optimiser: str) -> list[Trial]:
        """The trials of one cell in the order of their numbers."""
        return self.trials.get((dataset, model, optimiser), [])

    def best(self, dataset: str, model: str, optimiser: str | None = None) -> Trial | None:
        """The trial with the smallest objective, of one optimiser or of all."""
        cells = [
            group
            for (d, m, o), group in self.trials.items()
            if (d, m) == (dataset, model) and optimiser in (None, o)
        ]
        return best_of([trial for group in cells for trial in group])


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The trial with the smallest objective."""
    return min(trials, key=lambda trial: trial.objective, default=None)


def relative_rms(model: str | Model, theta: dict[str, float], data: Measurement) -> float:
    """Root mean square of |K - K_m| / |K_m|."""
    found = parse_model(model) if isinstance(model, str) else model
    gap = np.abs(found.stiffness(found.vector(theta), data.points) - data.stiffness)
    return float(np.sqrt(np.mean((gap / data.magnitude) ** 2)))


def absolute_rms(model: str | Model, theta: dict[str, float], data: Measurement) -> float:
    """Root of the paper's objective, eq.

    (44), over that of K = 0: what the paper minimises, as a relative number.
    """
    found = parse_model(model) if isinstance(model, str) else model
    gap = np.abs(found.stiffness(found.vector(theta), data.points) - data.stiffness)
    return float(np.sqrt(np.sum(gap**2) / np.sum(data.magnitude**2)))


def sd_rms(model: str | Model, theta: dict[str, float], data: Measurement) -> float:
    """Root mean square of the differences of K' and K'' over their given standard deviations."""
    assert data.sd is not None
    found = parse_model(model) if isinstance(model, str) else model
    gap = found.stiffness(found.vector(theta), data.points) - data.stiffness
    return float(np.sqrt(np.mean([(gap.real / data.sd.real) ** 2, (gap.imag / data.sd.imag) ** 2])))


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
