"""The answer of a diagnosis of tests in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from springpot.rheology.effect import Effect

from .information_criterion import HINT, PLAINLY, Left
from .residuals_of_tests import Part
from .result import TimeIdentification
from .scatter import Scatter, times_noise
from .sizes import rms
from .where import Place

if TYPE_CHECKING:
    from springpot.rheology.model import Model

SCHEMA = "springpot.diagnosis-in-time/1"


@dataclass(frozen=True)
class TimeError:
    """The error of a model beside the noise, of the test that it misses most.

    Attributes
    ----------
    relative_rms, noise_floor : float
        Root mean square of the residual and of the noise, each over that of the signal.
    over_floor : float
        Their ratio.
    memory : float
        Correlation of neighbouring samples of the noise.
    noise_source : str
        ``residual``: the upper part of the residual's spectrum; ``signal`` where there are too few
        samples for one.
    """

    relative_rms: float
    noise_floor: float
    over_floor: float
    memory: float
    noise_source: str

    @classmethod
    def of(cls, parts: Sequence[Part], left: Left, noise: Sequence[Scatter]) -> TimeError:
        """That of a fit."""
        errors = []
        for part, residual, scatter in zip(parts, left.residuals, noise, strict=True):
            error = rms(residual * part.relative_sd)
            ratio = times_noise(residual, scatter.size)
            floor = 0.0
            # A fit that leaves nothing at all says nothing of the noise.
            if ratio:
                floor = error / ratio
            # Of few samples the presumed noise is believed as it is: its size is one, to the last
            # bit.
            source = "residual"
            if scatter.size == 1.0:
                source = "signal"
            errors.append(cls(error, floor, ratio, scatter.memory, source))
        # A model is as good as it is for the test that it misses most.
        return max(errors, key=lambda each: each.over_floor)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "relative_rms": self.relative_rms,
            "noise_floor": self.noise_floor,
            "over_floor": self.over_floor,
            "noise_memory": self.memory,
            "noise_source": self.noise_source,
        }


@dataclass(frozen=True)
class TimeCandidate:
    """One effect, added to the model.

    Attributes
    ----------
    effect : str
        Its name.
    alike : tuple of str
        Effects that these tests cannot tell from it.
    probability : float
        Against all others that were fitted, and against nothing missing.
    delta_bic : float
        By how much the Bayesian information criterion falls; above 10 is very strong evidence.
    over_floor : float
        Error after it was added, over the noise: of the worst test.
    parameters : dict
        Those of the effect, as printed.
    verdict : str
        ``missing``: it brings the error to the noise, and no other effect does; ``absent``: nothing
        speaks for it; ``cannot-tell``: anything else, also because a rival explains more.
    says : str
        Its physics.
    physics : Effect
        The effect itself.
    """

    effect: str
    alike: tuple[str, ...]
    probability: float
    delta_bic: float
    over_floor: float
    parameters: dict[str, dict[str, Any]]
    verdict: str
    says: str
    physics: Effect = field(repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "effect": self.effect,
            "class": [self.effect, *self.alike],
            "probability": self.probability,
            "delta_bic": self.delta_bic,
            "over_floor": self.over_floor,
            "parameters": self.parameters,
            "verdict": self.verdict,
            "says": self.says,
        }


def best_of(candidates: Sequence[TimeCandidate]) -> TimeCandidate | None:
    """The effect that should be added, if any.

    The first, where the evidence for it is beyond doubt.
    """
    # By evidence alone: the first of several candidates always fits best, which is no proof.
    if not candidates or candidates[0].delta_bic <= PLAINLY:
        return None
    return candidates[0]


def missing_of(candidates: Sequence[TimeCandidate]) -> tuple[str, ...]:
    """That effect and those that the tests cannot tell from it; empty where nothing is missing."""
    best = best_of(candidates)
    if best is None:
        return ()
    return (best.effect, *best.alike)


@dataclass(frozen=True, eq=False)
class TimeDiagnosis:
    """What is missing from a model of tests in time.

    Attributes
    ----------
    base : TimeIdentification
        The model without further effects.
    verdict : str
        ``adequate``: nothing is missing that these tests could show; ``effect-missing``: one effect
        brings the error to the noise; ``unexplained``: something is missing, and no single effect
        that is known explains it; ``inconclusive``: one would help, or what is left is more than
        noise, but not beyond chance.
    candidates : tuple of TimeCandidate
        Best first.
    where : tuple of Place
        Where the records are missed, the worst first.
    error : TimeError
        Of the base beside the noise.
    classes : tuple of tuple of str
        Effects that these tests cannot tell apart.
    best_fit : TimeIdentification
        The model with the best effect, where one is missing; else the base.
    notes : tuple of str
        What is doubted of the tests themselves: a channel that seems to count the other way.
    left_out : dict of str to str
        Effects that could not be fitted, and why.
    """

    base: TimeIdentification
    verdict: str
    candidates: tuple[TimeCandidate, ...]
    where: tuple[Place, ...]
    error: TimeError
    classes: tuple[tuple[str, ...], ...]
    best_fit: TimeIdentification
    notes: tuple[str, ...] = ()
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """The model that was judged."""
        return self.base.model

    @property
    def best(self) -> TimeCandidate | None:
        """The effect that should be added, if any.

        The first that is missing, or that helps most beyond doubt.
        """
        return best_of(self.candidates)

    @property
    def missing(self) -> tuple[str, ...]:
        """The effects that may be missing, which these tests cannot tell apart.

        Empty where nothing is.
        """
        return missing_of(self.candidates)

    @property
    def says(self) -> str:
        """One sentence."""
        size = f"the error is {self.error.over_floor:.2g} x the noise"
        # Where it fails is the best advice there is, as long as nobody knows what is missing.
        place = ""
        if self.where:
            place = f"; {self.where[0].says}"
        best = self.best
        if self.verdict == "adequate":
            return f"{size}: nothing is missing that these tests could show"
        if self.verdict == "inconclusive":
            hint = "what is left is hardly noise alone"
            if self.candidates and self.candidates[0].delta_bic > HINT:
                hint = f"{self.candidates[0].effect} would help a little"
            return f"{size}: {hint}, which may be chance; measure longer or repeat it{place}"
        if best is None:
            return (
                f"{size}, and no known effect explains it:"
                f" something is missing that is not in the library{place}"
            )
        names = " or ".join(self.missing)
        if self.verdict == "unexplained":
            helps = f"{names} helps ({best.over_floor:.2g} x with it) but is not all"
            return f"{size}, and no single known effect explains it: {helps}{place}"
        return f"{size}; missing is {names}: {best.over_floor:.2g} x with it{place}"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.diagnosis-in-time/1``."""
        return {
            "schema": SCHEMA,
            "data": " + ".join(test.name for test in self.base.tests),
            "model": self.base.model.name,
            "error": self.error.to_dict(),
            "tests": [test.to_dict() for test in self.base.tests],
            "verdict": self.verdict,
            "where": [place.to_dict() for place in self.where],
            "candidates": [candidate.to_dict() for candidate in self.candidates],
            "classes": [list(names) for names in self.classes],
            "says": self.says,
            "notes": list(self.notes),
            "left_out": self.left_out,
        }

    def __repr__(self) -> str:
        return f"<TimeDiagnosis {self.base.model.name}: {self.verdict}, {self.says}>"
