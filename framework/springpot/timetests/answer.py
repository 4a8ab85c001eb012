"""What a diagnosis of tests in time says: its error, its sentence, and which effect to add."""

from __future__ import annotations

from collections.abc import Sequence

from springpot.diagnosis.result import Candidate, Verdict
from springpot.misfit.error import Error
from springpot.misfit.where import Where

from .information_criterion import HINT, PLAINLY, Left
from .residuals_of_tests import Part
from .scatter import Scatter, times_noise
from .sizes import rms

NAN = float("nan")


def error_of(parts: Sequence[Part], left: Left, noise: Sequence[Scatter]) -> Error:
    """The error of a model beside the noise, of the test that it misses most."""
    errors = []
    for part, residual, scatter in zip(parts, left.residuals, noise, strict=True):
        error = rms(residual * part.relative_sd)
        ratio = times_noise(residual, scatter.size)
        floor = 0.0
        # A fit that leaves nothing at all says nothing of the noise.
        if ratio:
            floor = error / ratio
        # Of few samples the presumed noise is believed as it is: its size is one, to the last bit.
        source = "residual"
        if scatter.size == 1.0:
            source = "signal"
        # Of no material: none was looked for.
        told = Error(error, floor, source, "", NAN, NAN, noise_memory=scatter.memory)
        errors.append((ratio, told))
    # A model is as good as it is for the test that it misses most.
    return max(errors, key=lambda each: each[0])[1]


def leading_of(candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """The effects that should be added, which the tests cannot tell apart; empty if none should.

    The class of the first, where the evidence for it is beyond doubt.
    """
    # By evidence alone: the first of several candidates always fits best, which is no proof.
    if not candidates or candidates[0].delta_bic <= PLAINLY:
        return ()
    return candidates[0].alike


def sentence(
    error: Error, verdict: Verdict, candidates: Sequence[Candidate], where: Sequence[Where]
) -> str:
    """The verdict in one sentence."""
    size = f"the error is {error.over_floor:.2g} x the noise"
    # Where it fails is the best advice there is, as long as nobody knows what is missing.
    place = ""
    if where:
        place = f"; {where[0].says}"
    names = " or ".join(leading_of(candidates))
    if verdict == "adequate":
        return f"{size}: nothing is missing that these tests could show"
    if verdict == "inconclusive":
        hint = "what is left is hardly noise alone"
        if candidates and candidates[0].delta_bic > HINT:
            hint = f"{candidates[0].effect} would help a little"
        return f"{size}: {hint}, which may be chance; measure longer or repeat it{place}"
    if not names:
        return (
            f"{size}, and no known effect explains it:"
            f" something is missing that is not in the library{place}"
        )
    after = f"{candidates[0].over_floor:.2g} x with it"
    if verdict == "unexplained":
        helps = f"{names} helps ({after}) but is not all"
        return f"{size}, and no single known effect explains it: {helps}{place}"
    return f"{size}; missing is {names}: {after}{place}"
