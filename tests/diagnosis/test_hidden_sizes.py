"""Every effect, hidden in data at three sizes.

Barely visible, plain (all of both in the soak), and large.

A size is the chi-square that the best base model leaves on noise-free data: the three mean the same
for all effects.
"""

from functools import cache

import numpy as np
import pytest
from hidden_data import (
    AMPLITUDES,
    KELVIN,
    MAXWELL,
    SLOW,
    SWEEP,
    TEMPERATURES,
    WARM,
    WARM_FLUID,
    hidden,
)

import springpot
from soaked import soaked

PLACES = {
    (KELVIN, SWEEP): (
        "parallel-dashpot parallel-springpot relaxation-mode diffusion hysteretic-loss inertia"
        " basset series-spring series-dashpot series-springpot retardation-mode time-delay"
        " phase-error filter-mismatch fixture-resonance specimen-inertia specimen-inertia-fixed"
    ),
    (MAXWELL, SWEEP): "parallel-spring",
    (KELVIN, AMPLITUDES): (
        "friction elasto-sliding power-law-damper dead-zone cubic-stiffness payne "
        "intrinsic-nonlinearity self-heating backlash crosstalk"
    ),
    (KELVIN, SLOW): "cubic-damping",
    (KELVIN, TEMPERATURES): "arrhenius-shift wlf-shift vertical-shift",
    (WARM_FLUID, TEMPERATURES): "entropic-spring",
    (WARM, TEMPERATURES): "arrhenius-dashpot arrhenius-springpot rig-drag",
}
"""A base and a design on which each effect can be seen.

Gain and clock errors are absorbed by every base.
"""
WHERE = {effect: place for place, names in PLACES.items() for effect in names.split()}


@cache
def diagnosed(effect, chi2, seed=5):
    base, at = WHERE[effect]
    return springpot.diagnose(hidden(base, at, effect, chi2, seed, just=True), base.name)


PLAIN = (
    "inertia",
    "series-spring",
    "time-delay",
    "friction",
    "arrhenius-shift",
    "parallel-dashpot",
)
"""One of each composition; at the smaller sizes the others are in the soak."""
BARELY = ("inertia", "series-spring", "friction")
"""Asked at the smallest size by another test too."""
FEW_POINTS = ("self-heating", "rig-drag")
"""Seen in sweeps of six points only, where structure looks most like scatter.

In the soak also these.
"""
MORE_OF_FEW_POINTS = ("cubic-damping", "entropic-spring", "arrhenius-dashpot")

KINDS = (
    "parallel-springpot",
    "retardation-mode",
    "specimen-inertia",
    "cubic-stiffness",
    "backlash",
)
"""One of every law and of every place in the chain, together with the others.

Counted are also those that test_discovery.py, test_equivalence_classes.py and test_unknown.py find
as large.
"""


def some(*effects):
    """All effects, of which only these are tried outside the soak."""
    return [name if name in effects else soaked(name) for name in WHERE]


@pytest.mark.soak
@pytest.mark.parametrize("effect", some(*BARELY, *FEW_POINTS))
def test_a_barely_visible_effect_is_noticed_and_not_ruled_out(effect):
    # At this size the draw decides too: of 12 each, power-law-damper and arrhenius-dashpot are
    # inconclusive in 4, inertia in none.
    diagnosis = diagnosed(effect, 30.0)
    assert diagnosis.verdict in ("effect-missing", "unexplained", "inconclusive")
    assert effect not in [c.effect for c in diagnosis.candidates if c.verdict == "absent"]


@pytest.mark.soak
@pytest.mark.parametrize("effect", some("series-spring", "friction", "arrhenius-shift"))
def test_a_plain_effect_is_in_the_first_class(effect):
    diagnosis = diagnosed(effect, 120.0)
    assert diagnosis.verdict == "effect-missing"
    assert effect in diagnosis.best.alike
    assert diagnosis.best.effect == effect or diagnosis.best.probability < 0.95


@pytest.mark.soak_cases(
    "arrhenius-shift",
    "backlash",
    "cubic-stiffness",
    "friction",
    "inertia",
    "parallel-springpot",
    "retardation-mode",
    "rig-drag",
    "self-heating",
    "series-spring",
    "specimen-inertia",
    "time-delay",
)
@pytest.mark.parametrize("effect", some(*PLAIN, *FEW_POINTS, *KINDS))
def test_a_large_effect_is_in_the_first_class(effect):
    diagnosis = diagnosed(effect, 1000.0)
    assert diagnosis.verdict == "effect-missing"
    assert effect in diagnosis.best.alike
    assert diagnosis.best.effect == effect or diagnosis.best.probability < 0.95


@pytest.mark.soak_cases(
    "inertia",
    "series-spring",
    "friction",
    "self-heating",
    "arrhenius-shift",
    "backlash",
    "cubic-stiffness",
    "parallel-springpot",
    "retardation-mode",
    "rig-drag",
    "specimen-inertia",
    "time-delay",
)
@pytest.mark.parametrize("effect", some(*PLAIN, *FEW_POINTS, *KINDS))
def test_a_large_effect_brings_the_error_to_the_floor(effect):
    diagnosis = diagnosed(effect, 1000.0)
    own = next(c for c in diagnosis.candidates if c.effect == effect)
    degrees = 2 * len(WHERE[effect][1].omega)
    fitted = np.sqrt(1.0 - (len(WHERE[effect][0].truth) + len(own.parameters)) / degrees)
    assert 0.9 < own.error_after / (diagnosis.error.noise_floor * fitted) < 1.1
    assert 0.9 * fitted < diagnosis.best.error_after / diagnosis.error.noise_floor < 1.1


MISSED_SIZE = {
    "elasto-sliding": (
        "the linearised error is twice the realised one: its curve depends strongly on F / k"
    ),
    "payne": "the linearised error is half as much again as the realised one",
}


@pytest.mark.suite_cases("inertia")
@pytest.mark.parametrize(
    "effect",
    [
        (
            soaked(e, marks=[pytest.mark.xfail(strict=False, reason=MISSED_SIZE[e])])
            if e in MISSED_SIZE
            else e
        )
        for e in (
            "inertia",
            "series-spring",
            "time-delay",
            "friction",
            "self-heating",
            "arrhenius-shift",
            *MISSED_SIZE,
        )
    ],
)
def test_predicted_and_realised_error_agree(effect):
    candidate = diagnosed(effect, 1000.0).best
    assert candidate.predicted_error == pytest.approx(candidate.error_after, rel=0.2)


@pytest.mark.soak
@pytest.mark.parametrize(
    "effect",
    ["inertia", "friction", "series-spring", *FEW_POINTS, *map(soaked, MORE_OF_FEW_POINTS)],
)
def test_truthful_standard_deviations_are_believed(effect):
    """However much is missing: the noise is as said, and nothing is doubtful."""
    for chi2 in (30.0, 1000.0):
        error = diagnosed(effect, chi2).error
        assert error.noise_source == "given"
        assert not error.doubt


@pytest.mark.soak_cases("4-3-inertia-m-0.00022")
@pytest.mark.parametrize(("effect", "parameter", "truth"), [("inertia", "m", 2.2e-4)])
@pytest.mark.parametrize(("draws", "least"), [(4, 3), soaked(12, 9)])
def test_intervals_cover_the_truth(effect, parameter, truth, draws, least):
    """Ninety-five per cent intervals: of 4, fewer than 3 happens once in 70.

    Of 12, fewer than 9 once in 400.
    """
    base, at = WHERE[effect]
    covered = 0
    for seed in range(draws):
        diagnosis = springpot.diagnose(hidden(base, at, effect, 1000.0, seed=100 + seed), base.name)
        own = next(c for c in diagnosis.candidates if c.effect == effect)
        value = own.parameters[parameter]
        # kN/m over (rad/s)^2 is Mg; kN/m times mm is N.
        factor = {"kg": 1000.0, "N": 1.0}[value.unit]
        covered += value.low <= factor * truth <= value.high
    assert covered >= least
