"""What one ramp cannot tell: a part of the rig met on the way, or a specimen that stiffens.

The displacement passes each place once, at one speed. A force that a part of the rig adds from
there on and one of the specimen itself are the same to it, but for the shape that each was given.
"""

from __future__ import annotations

from collections.abc import Sequence

from springpot.diagnosis.result import Candidate
from springpot.rheology.effect import Layer
from springpot.thresholds import SEARCH

from .residuals_of_tests import InTimePart, TestPart


def beside_one_ramp(
    parts: Sequence[TestPart], candidates: Sequence[Candidate], leading: Sequence[str]
) -> str:
    """The specimen that is not linear, beside leading effects of one ramp that are none of it.

    Empty where there are more tests, another kind of test, or no such specimen that helps.
    """
    if len(parts) != 1 or not isinstance(parts[0], InTimePart) or parts[0].test.kind != "startup":
        return ""
    own = [each for each in candidates if each.physics.layer is Layer.MATERIAL]
    best = next((each for each in own if each.delta_bic > SEARCH.decisive), None)
    if best is None or {each.effect for each in own} & {*leading}:
        return ""
    return (
        f", or a specimen that is not linear ({best.effect}: {best.over_floor:.2g} x), which one"
        " ramp does not tell apart: ramp at another rate, or back"
    )
