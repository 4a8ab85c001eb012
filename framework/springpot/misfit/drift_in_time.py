"""How a specimen changed while it was measured, in numbers and in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.thresholds import COURSE

from .words import plain

SMALL_MOVE = 0.02
"""Relative change that is told as none."""
FOLD = 2.0
"""Ratio from which a change is told in times rather than in per cent."""


@dataclass(frozen=True)
class Course:
    """How a specimen changed while it was measured.

    Attributes
    ----------
    start, end : float
        First and last time, in the unit of the file.
    unit : str
        That unit; empty where the file has none.
    at : str
        The frequency at which the moduli are told, such as ``1 Hz``.
    storage, loss : tuple of float
        At the start and at the end, in the measurement's own unit.
    modulus : str
        That unit.
    mutation : float or None
        Largest relative change of |K| in one period; None where the unit of the time is unknown.
    share : float
        Of the misfit beyond the noise, in chi-square, that slow curves of gain and phase in time
        take, over what each frequency and each level of a condition may have of its own.
    gain : float
        Chi-square that they take, less the price of each of them by the information criterion.
    force_held : bool
        Whether the amplitude only followed the specimen, as the force was held.
    last_round : str
        How to choose the last rows that hold every frequency once, such as ``time=600..720``; empty
        without a sweep. Of a beginning, the rows after it.
    begun : int
        First rows, taken within one period of the start, with which alone the misfit goes; zero
        where the later ones change too.
    """

    start: float
    end: float
    unit: str
    at: str
    storage: tuple[float, float]
    loss: tuple[float, float]
    modulus: str
    mutation: float | None
    share: float
    gain: float
    force_held: bool
    last_round: str
    begun: int = 0

    @property
    def has_ends(self) -> bool:
        """Whether some point was measured at two times, so that a start and an end can be told."""
        return self.end > self.start

    @property
    def ends(self) -> str:
        """What changed, from where to where."""
        when = f"between {plain(self.start, 4)} and {plain(self.end, 4)} {self.unit}".rstrip()
        storage = _moved("storage", self.storage, self.modulus)
        loss = _moved("loss", self.loss, self.modulus)
        return f"{storage}, {loss}, {when} at {self.at}"

    @property
    def headline(self) -> str:
        """The end of the diagnosis's first sentence."""
        if self.begun:
            return (
                f"{self._beginning}, before anything swings steadily,"
                " and differ from all that come later"
            )
        if not self.has_ends:
            return (
                "the specimen changes with time: neither frequency nor what was set is what moves"
                " it; from what to what is not known, as no point was measured again later"
            )
        return f"the specimen changes with time: {self.ends}; frequency is not what moves it"

    @property
    def _beginning(self) -> str:
        """Which rows are of the start."""
        return f"the first {self.begun} points stand within one period of the start ({self.at})"

    @property
    def meaning(self) -> str:
        """What does so."""
        before, after = (
            float(np.hypot(*pair)) for pair in zip(self.storage, self.loss, strict=True)
        )
        if abs(after / before - 1.0) < SMALL_MOVE:
            return "its phase, while |K| stays"
        if after > before:
            return "it cures, sets, ages or dries"
        return "it breaks down, softens, swells or loses its hold"

    @property
    def says(self) -> str:
        """What the misfit goes with, and how much of a change one point holds."""
        if self.begun:
            return (
                f"what is missing goes with the beginning: {self._beginning}; a period must pass"
                " before K is known"
            )
        change = "the specimen changes"
        if self.has_ends:
            change = f"{change} ({self.meaning})"
        taken = (
            "what is missing goes with the time: a slow course of gain and phase takes"
            f" {100 * self.share:.0f} % of the misfit, beyond all that frequency, temperature and"
            f" amplitude could; {change}, or the rig does"
        )
        if self.mutation is None:
            return taken
        quick = "so that each point is of one state"
        if self.mutation > COURSE.largest_mutation:
            quick = "too much for a steady state: measure at a higher frequency"
        size = f"{plain(100 * self.mutation, 2)} % within one period"
        return (
            f"{taken}; |K| changes by at most {size}, {quick} (mutation number,"
            " doi:10.1007/BF00369354)"
        )

    @property
    def advice(self) -> str:
        """What to measure."""
        if self.begun:
            return (
                "begin to take points when some periods have passed, and take them a period apart"
            )
        if self.last_round:
            return (
                "measure until the moduli stand still, or sweep faster than they move; until then"
                " each round is a material of its own: number the rounds in a column"
            )
        return (
            "hold the frequency until storage and loss stand still, and sweep the frequency then;"
            " or sweep several frequencies round and round, each round faster than the moduli move"
        )


def _moved(name: str, ends: tuple[float, float], unit: str) -> str:
    """How one part changed, such as ``storage rises from 12.1 to 1010 Pa (83 times)``."""
    before, after = ends
    if before == after:
        return f"{name} stays at {plain(before)} {unit}"
    verb = "rises"
    if after < before:
        verb = "falls"
    told = f"{name} {verb} from {plain(before)} to {plain(after)} {unit}"
    # What begins below zero has no ratio.
    if min(before, after) <= 0.0:
        return told
    if abs(after / before - 1.0) < SMALL_MOVE:
        return f"{name} stays near {plain(before)} {unit}"
    ratio = max(after / before, before / after)
    if ratio < FOLD:
        return f"{told} (by {plain(100.0 * abs(after / before - 1.0), 2)} %)"
    if verb == "rises":
        return f"{told} ({plain(ratio, 2)} times)"
    return f"{told} (to {plain(100.0 / ratio, 2)} %)"
