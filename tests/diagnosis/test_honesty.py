"""Nothing is invented.

Noise alone, noise misjudged, outliers, and structure that no effect of the library has.
"""

from functools import cache

import numpy as np
import pytest
from hidden_data import AMPLITUDES, KELVIN, LEVEL, SWEEP, ZENER, design, exact, hidden, measured

import springpot
from soaked import soaked

FINE = design(60)
WORDS = ("missing", "absent", "cannot-tell")


def text(diagnosis):
    """Everything that is said about the data."""
    return " ".join(
        [diagnosis.error.doubt, *diagnosis.notes, *(w.says for w in diagnosis.where)]
    ).lower()


@pytest.mark.soak
@pytest.mark.parametrize("known", [True, False], ids=["sigma-known", "sigma-unknown"])
@pytest.mark.parametrize(("draws", "flags"), [(8, 1), (24, 2)])
def test_noise_alone_is_seldom_flagged_and_never_accepted(draws, flags, known):
    """Two per cent may be flagged.

    Of 8, more than one, or of 24, more than two, happens about once in eighty.
    """
    ladders = [
        springpot.discover(measured(SWEEP, exact(KELVIN, SWEEP), seed=s, known=known), KELVIN.name)
        for s in range(draws)
    ]
    assert [len(ladder.steps) for ladder in ladders] == [1] * draws
    flagged = [ladder.diagnosis.verdict in ("effect-missing", "unexplained") for ladder in ladders]
    assert sum(flagged) <= flags


@pytest.mark.soak_cases("54")
@pytest.mark.parametrize("seed", [54, 164])
def test_an_unlucky_draw_of_unknown_noise_is_not_accepted_as_an_effect(seed):
    data = measured(SWEEP, exact(KELVIN, SWEEP), seed=seed, known=False)
    assert len(springpot.discover(data, KELVIN.name).steps) == 1


@pytest.mark.soak_cases("fractional-kelvin")
@pytest.mark.parametrize("base", [KELVIN, soaked(ZENER)], ids=lambda b: b.name)
def test_noise_alone_over_amplitudes_is_left_alone(base):
    for seed in range(2):
        ladder = springpot.discover(
            measured(AMPLITUDES, exact(base, AMPLITUDES), seed=seed), base.name
        )
        assert len(ladder.steps) == 1
        assert ladder.verdict in ("adequate", "inconclusive")


@pytest.mark.soak_cases("1-0.5", "1-2.0")
@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in (2, 3))]
)
def test_a_misstated_sigma_is_doubted_and_invents_nothing(factor, seed):
    data = measured(FINE, exact(KELVIN, FINE), seed=seed, said=LEVEL * factor)
    ladder = springpot.discover(data, KELVIN.name)
    assert len(ladder.steps) == 1
    diagnosis = ladder.diagnosis
    assert diagnosis.verdict in ("adequate", "inconclusive")
    assert "small" in diagnosis.error.doubt if factor < 1.0 else "large" in diagnosis.error.doubt
    assert [c.effect for c in diagnosis.candidates if c.verdict == "missing"] == []


@pytest.mark.soak_cases("2.0")
@pytest.mark.parametrize("factor", [2.0, soaked(0.5)])
def test_a_misstated_sigma_hides_no_real_effect(factor):
    data = hidden(KELVIN, FINE, "inertia", 2000.0, seed=2)
    data = springpot.Measurement(data.omega, data.stiffness, sd=data.sd * factor, units=data.units)
    diagnosis = springpot.diagnose(data, KELVIN.name)
    assert diagnosis.verdict == "effect-missing"
    assert "inertia" in diagnosis.best.alike


OUTLIERS = [(10, 40), (3, 57), (29, 30)]


def spoilt(known, rows):
    """Two points off by 15 per cent, one in loss and one in storage."""
    data = measured(FINE, exact(KELVIN, FINE), seed=4, known=known)
    stiffness = data.stiffness.copy()
    stiffness[list(rows)] *= np.array([1.0 + 0.15j, 0.85])
    return springpot.Measurement(data.omega, stiffness, sd=data.sd, units=data.units)


@cache
def ladder_of_spoilt(known, rows):
    """With one rung, its last diagnosis is that of the model itself.

    One examination serves all that is asked.
    """
    return springpot.discover(spoilt(known, rows), KELVIN.name)


@pytest.mark.soak_cases("rows0-True", "rows1-False")
@pytest.mark.parametrize(
    ("rows", "known"),
    [(OUTLIERS[0], True), (OUTLIERS[1], False)]
    + [soaked(rows, known) for rows, known in ((OUTLIERS[0], False), (OUTLIERS[1], True))]
    + [soaked(OUTLIERS[2], known) for known in (True, False)],
)
def test_two_outliers_are_no_missing_effect_and_nothing_is_accepted_for_them(known, rows):
    ladder = ladder_of_spoilt(known, rows)
    assert len(ladder.steps) == 1
    assert [c.effect for c in ladder.diagnosis.candidates if c.verdict == "missing"] == []
    assert ladder.diagnosis.verdict != "effect-missing"


@pytest.mark.soak_cases("rows0")
@pytest.mark.parametrize("rows", [OUTLIERS[0], *map(soaked, OUTLIERS[1:])])
def test_two_outliers_are_named_as_such(rows):
    diagnosis = ladder_of_spoilt(True, rows).diagnosis
    assert "outl" in text(diagnosis) or "single point" in text(diagnosis)


F = FINE.omega / (2.0 * np.pi)
STRANGE = {
    "gain step": np.where(F > 3.0, 1.12, 1.0),
    "notch": 1.0 - 0.15 * np.exp(-0.5 * (np.log(F / 6.0) / 0.12) ** 2),
    "ripple": 1.0 + 0.06 * np.sin(2.0 * np.pi * 1.7 * np.log10(F)),
    "phase ripple": np.exp(0.06j * np.sin(2.0 * np.pi * 1.7 * np.log10(F))),
    "fast ripple": 1.0 + 0.05 * np.sin(2.0 * np.pi * 4.0 * np.log10(F)),
}


def is_shown_and_not_named(diagnosis):
    assert diagnosis.verdict == "unexplained"
    assert [c.effect for c in diagnosis.candidates if c.verdict == "missing"] == []
    assert diagnosis.where


# Here is what nothing else tests: a ripple beside a noise that was said is in
# test_shared_structure.py, a step of the gain in test_unknown.py, and the ladder of a notch below.
# All of them are in the soak.
@pytest.mark.soak_cases("phase ripple-False")
@pytest.mark.parametrize(
    ("kind", "known"),
    [
        (kind, known) if (kind, known) == ("phase ripple", False) else soaked(kind, known)
        for kind in STRANGE
        for known in (True, False)
    ],
)
def test_structure_outside_the_library_is_unexplained_and_shown(kind, known):
    # A notch of three points under noise of unknown size is at the edge: of 14 seeds 10 are
    # unexplained, and 4 name "frame-resonance or another narrow feature".
    data = measured(FINE, exact(KELVIN, FINE) * STRANGE[kind], seed=7, known=known)
    is_shown_and_not_named(springpot.diagnose(data, KELVIN.name))


# Where effects are tried and dropped again, as beside a fast ripple, a ladder costs ten diagnoses.
@pytest.mark.soak
@pytest.mark.parametrize("kind", STRANGE)
def test_structure_outside_the_library_is_not_folded_into_the_model(kind):
    # A step of the gain passes for noise with a memory in some draws: of 24, 5 are inconclusive.
    ladder = springpot.discover(
        measured(FINE, exact(KELVIN, FINE) * STRANGE[kind], seed=7), KELVIN.name
    )
    assert ladder.verdict == "unexplained"
    assert len(ladder.steps) == 1
    is_shown_and_not_named(ladder.diagnosis)


@pytest.mark.soak_cases("None-at2", "friction-at1", "inertia-at0")
@pytest.mark.parametrize(
    ("effect", "at"), [("inertia", SWEEP), ("friction", AMPLITUDES), (None, SWEEP)]
)
def test_every_candidate_has_a_verdict_and_what_is_absent_a_bound(effect, at):
    data = measured(at, exact(KELVIN, at)) if effect is None else hidden(KELVIN, at, effect, 200.0)
    diagnosis = springpot.diagnose(data, KELVIN.name)
    assert diagnosis.candidates
    for candidate in diagnosis.candidates:
        assert candidate.verdict in WORDS
        assert 0.0 <= candidate.probability <= 1.0
        assert candidate.effect in candidate.alike
        assert candidate.says
        if candidate.verdict == "absent":
            assert np.isfinite(candidate.bound)
            assert candidate.bound > 0.0
    missing = [c.effect for c in diagnosis.candidates if c.verdict == "missing"]
    assert missing in ([], [diagnosis.best.effect] if diagnosis.best else [])


@pytest.mark.soak
def test_what_is_absent_would_have_been_seen_at_three_times_its_bound():
    """The bound is a share of |K|.

    The same data with the effect three times as large as its bound show it.
    """
    clean = springpot.diagnose(measured(SWEEP, exact(KELVIN, SWEEP), seed=8), KELVIN.name)
    found = {c.effect: c for c in clean.candidates if c.verdict == "absent"}
    assert "inertia" in found
    reach = np.sqrt(np.mean(np.abs(SWEEP.omega**2 / exact(KELVIN, SWEEP)) ** 2))
    heavy = exact(KELVIN, SWEEP, "inertia", 3.0 * found["inertia"].bound / reach)
    seen = springpot.diagnose(measured(SWEEP, heavy, seed=8), KELVIN.name)
    assert seen.verdict == "effect-missing"
    assert "inertia" in seen.best.alike


@pytest.mark.soak_cases("basset", "series-springpot")
@pytest.mark.parametrize(
    "effect", ["basset", "series-springpot", soaked("inertia"), soaked("parallel-springpot")]
)
def test_free_orders_stay_between_spring_and_dashpot(effect):
    diagnosis = springpot.diagnose(hidden(KELVIN, SWEEP, effect, 1000.0), KELVIN.name)
    orders = [
        v
        for c in diagnosis.candidates
        for n, v in c.parameters.items()
        if n.rpartition(".")[2] == "alpha"
    ]
    assert orders
    for order in orders:
        assert 0.0 <= order.low <= order.value <= order.high <= 1.0


@pytest.mark.soak
def test_what_is_said_has_numbers_and_hertz():
    diagnosis = springpot.diagnose(hidden(KELVIN, SWEEP, "inertia", 1000.0), KELVIN.name)
    assert diagnosis.where
    assert any("Hz" in where.says and "storage" in where.says for where in diagnosis.where)
    assert diagnosis.next_experiment is not None
    assert set(diagnosis.next_experiment.separates) <= set(diagnosis.best.alike)
