"""What the instrument promises: a misfit may be certain, and small all the same."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np

from springpot.distributions import student
from springpot.errors import OptionError
from springpot.identification.calibration import Calibration, calibration_of
from springpot.identification.native import FittedModel
from springpot.identification.value import Value
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test
from springpot.measurement.units import ANGLE_UNITS, STRAIN_UNITS, Units
from springpot.misfit.error import percent
from springpot.numerics import rms
from springpot.rheology.points import Complex, Real
from springpot.thresholds import INTERVAL

from .result import Candidate, Diagnosis

SOLVED = float(np.sqrt(np.finfo(float).eps))
"""Relative error down to which numbers tell a minimum of squares at all."""


class Misfit(NamedTuple):
    """How far a fitted model lies beside each value of one test.

    Attributes
    ----------
    modulus : ndarray, shape (n,)
        Relative difference of |K|, or of a signal in time to its size.
    phase : ndarray, shape (n,) or (0,)
        Difference of the phase in rad; none of a signal in time.
    """

    modulus: Real
    phase: Real

    @classmethod
    def of_stiffness(cls, model: Complex, measured: Complex) -> Misfit:
        """That of a complex stiffness (n,)."""
        # A model without any stiffness is infinitely far from one that was measured.
        with np.errstate(divide="ignore"):
            off = np.log(model / measured)
        return cls(np.abs(off.real), np.abs(off.imag))


@dataclass(frozen=True)
class Accuracy:
    """What an instrument promises of each value that it tells.

    Attributes
    ----------
    modulus : float
        Relative, of |K| or of a signal.
    phase : float or None
        In rad; without one the modulus and what is at right angles to it are promised alike.
    """

    modulus: float
    phase: float | None = None

    @classmethod
    def of(cls, text: str) -> Accuracy:
        """From text such as ``1%,3mrad``.

        Raises
        ------
        OptionError
            If it is none.

        Examples
        --------
        >>> from springpot.diagnosis.in_practice import Accuracy
        >>> Accuracy.of("2%,5mrad")
        Accuracy(modulus=0.02, phase=0.005)
        """
        found: dict[str, float] = {}
        for part in text.split(","):
            told = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(%|mrad|rad|deg)\s*", part)
            value, unit = told.groups() if told else ("0", "%")
            name, units = (
                ("modulus", STRAIN_UNITS) if unit in STRAIN_UNITS else ("phase", ANGLE_UNITS)
            )
            if float(value) == 0.0 or name in found:
                found.clear()
                break
            found[name] = float(value) * units[unit]
        if "modulus" not in found:
            raise OptionError(
                f"accuracy '{text:.40}' is none: give a share of the modulus and a phase, such as"
                " 1%,3mrad or 2%"
            )
        return cls(found["modulus"], found.get("phase"))

    @property
    def terms(self) -> dict[str, float]:
        """Standard uncertainties of gain and phase of which this is the expanded one."""
        phase = self.modulus if self.phase is None else self.phase
        quantile = student(INTERVAL, np.inf)
        return {"gain": self.modulus / quantile, "phase": phase / quantile}

    def calibration(
        self,
        fit: FittedModel,
        scatter: Real,
        tests: Sequence[Test],
        again: Callable[[Sequence[Test]], Mapping[str, float]],
    ) -> Calibration:
        """What it adds to the uncertainty of parameters, see `calibration_of`."""
        terms = self.terms
        # A test in time has no phase.
        if not any(isinstance(test, Measurement) for test in tests):
            terms = {"gain": terms["gain"]}
        return calibration_of(fit.model, fit.theta, scatter, tests, terms, str(self), again)

    def beside(
        self,
        values: Mapping[str, Value],
        fit: FittedModel,
        tests: Sequence[Test],
        units: Units,
        again: Callable[[Sequence[Test]], Mapping[str, float]],
    ) -> dict[str, Value]:
        """Parameters in printed units, their intervals with it beside the scatter."""
        # The scatter stands in the intervals: only what it adds is asked.
        calibration = self.calibration(fit, np.zeros(len(fit.theta)), tests, again)
        return calibration.beside(values, fit.model, units)

    def holds(self, misfits: Sequence[Misfit]) -> bool:
        """Whether each test is met within what is promised.

        In all but one of each twenty values begun, and on the whole, so that a few that are far off
        are not passed over.
        """
        phase = self.phase
        if phase is None:
            phase = self.modulus
        return all(
            _within(each.modulus, self.modulus) and _within(each.phase, phase) for each in misfits
        )

    def says(self, error: float, otherwise: str) -> str:
        """That a relative error lies within it, and what is to be said without the promise."""
        return (
            f"within what the instrument promises ({self}); a structure of {percent(error)} is"
            f" visible: {otherwise}"
        )

    def __str__(self) -> str:
        if self.phase is None:
            return percent(self.modulus)
        return f"{percent(self.modulus)}, {1e3 * self.phase:.3g} mrad"


USUAL = Accuracy(0.01, 0.003)
"""What a good rheometer promises; most promise less."""


def _within(off: Real, promised: float) -> bool:
    """Whether nearly all values, and their root mean square, are off by no more than promised."""
    if not len(off):
        return True
    # Of few values one may lie beyond: a share of them is no count.
    most = ceil(round((1.0 - INTERVAL) * len(off), 6))
    size = rms(off)
    return int(np.count_nonzero(~(off <= promised))) <= most and size <= promised


def in_practice(
    diagnosis: Diagnosis, misfits: Sequence[Misfit], accuracy: Accuracy | None
) -> Diagnosis:
    """The same, judged by what the instrument promises too.

    Parameters
    ----------
    diagnosis : Diagnosis
        Judged by the noise alone.
    misfits : sequence of Misfit
        That of each test.
    accuracy : Accuracy or None
        What is promised; where that is not known, a misfit that is within what usual instruments
        promise is only called small.
    """
    if diagnosis.verdict == "adequate":
        return diagnosis
    size = percent(diagnosis.error.relative_rms)
    if diagnosis.error.relative_rms <= SOLVED:
        # Data that were computed: what is left is the last digits of the numbers.
        says = f"the error is {size}, as near as numbers tell: nothing is missing"
        return replace(_adequate(diagnosis, says), where=())
    if accuracy is None:
        if not USUAL.holds(misfits):
            return diagnosis
        says = (
            f"small in practice, {size}: if the instrument promises no more than {USUAL}, say so by"
            f" --accuracy 1%,3mrad; as it is, {diagnosis.says}"
        )
        return replace(diagnosis, says=says)
    if not accuracy.holds(misfits):
        return diagnosis
    return _adequate(diagnosis, accuracy.says(diagnosis.error.relative_rms, diagnosis.says))


def _adequate(diagnosis: Diagnosis, says: str) -> Diagnosis:
    """The same with a misfit that proves nothing."""
    return replace(
        diagnosis,
        verdict="adequate",
        says=says,
        candidates=tuple(_open(each) for each in diagnosis.candidates),
        leading=(),
        next_experiment=None,
    )


def _open(candidate: Candidate) -> Candidate:
    """An effect beside a misfit that the instrument may have made: it is not proved by it."""
    if candidate.verdict == "missing":
        return replace(candidate, verdict="cannot-tell")
    return candidate
