"""A structure under many records: the mean and the envelope of what is largest under each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from springpot.rheology.points import Real

from .motion import Motion, Simulation, band_of

LARGEST: dict[str, Callable[[Motion], Real]] = {
    "drift": lambda motion: motion.peak_drift,
    "damper_force": lambda motion: motion.peak_storey_force,
    "axial_force": lambda motion: motion.peak_axial_force,
    "stroke": lambda motion: motion.peak_stroke,
    "energy": lambda motion: motion.work[-1],
}
"""What is told of each record: of each storey the first two, of each entry of dampers the rest."""


@dataclass(frozen=True, eq=False)
class RecordSuite:
    """A structure under many records.

    Parameters
    ----------
    simulations : sequence of Simulation
        Under one record each, with the same draws of its dampers.
    refused : mapping of str to str
        Records that could not be used, with the reason.
    """

    simulations: Sequence[Simulation]
    refused: dict[str, str] = field(default_factory=dict)

    def largest(self, name: str) -> Real:
        """One of `LARGEST` under each record, shape (r, k)."""
        return np.array([LARGEST[name](each.motion) for each in self.simulations])

    def mean(self, name: str) -> Real:
        """Mean over the records (k,)."""
        return np.asarray(self.largest(name).mean(axis=0))

    def envelope(self, name: str) -> Real:
        """Largest under any record (k,)."""
        return np.asarray(self.largest(name).max(axis=0))

    def worst(self, name: str) -> list[str]:
        """Names (k,) of the records of the envelope."""
        names = [each.motion.record.name for each in self.simulations]
        return [names[i] for i in self.largest(name).argmax(axis=0)]

    @property
    def bounds(self) -> dict[str, RecordSuite]:
        """The same at each end of the dampers' factors; nothing where they have none."""
        return {
            name: RecordSuite([each.bounds[name] for each in self.simulations])
            for name in self.simulations[0].bounds
        }

    def bands(self) -> dict[str, tuple[Real, Real]]:
        """Ends (n,) of the bands of the drifts' mean and of their envelope.

        Every record has the same draws of the dampers, so that each draw has its mean.
        """
        drifts = np.array([each.drifts for each in self.simulations])
        return {
            "mean": band_of(drifts.mean(axis=0), self.mean("drift")),
            "envelope": band_of(drifts.max(axis=0), self.envelope("drift")),
        }
