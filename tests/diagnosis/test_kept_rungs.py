"""Which rungs of an automatic ladder stay when not all of the misfit is explained."""

from types import SimpleNamespace

import pytest

from springpot.diagnosis import discovery
from springpot.diagnosis.discovery import _decisive, _explained


def rung(error, verdict):
    """A rung by its error of prediction in units of the floor and its verdict."""
    case = SimpleNamespace(
        diagnosis=SimpleNamespace(verdict=verdict), search=SimpleNamespace(base=error)
    )
    return SimpleNamespace(relative_rms=0.01 * error, noise_floor=0.01, case=case)


@pytest.mark.parametrize(
    ("rungs", "kept"),
    [
        ([(8.0, "effect-missing"), (1.0, "adequate")], 2),
        ([(8.0, "unexplained"), (3.0, "effect-missing"), (1.0, "adequate")], 3),
        ([(8.0, "unexplained"), (6.0, "unexplained"), (5.0, "unexplained")], 1),
        ([(8.0, "effect-missing"), (3.0, "unexplained"), (2.5, "unexplained")], 2),
        ([(30.0, "unexplained"), (2.3, "unexplained"), (2.2, "unexplained")], 2),
        ([(30.0, "unexplained"), (9.0, "unexplained"), (2.3, "unexplained")], 3),
    ],
    ids=[
        "explained",
        "hidden by one another",
        "curve fitting",
        "last word",
        "shift",
        "shift and another",
    ],
)
def test_what_predicts_the_unseen_better_stays(rungs, kept, monkeypatch):
    monkeypatch.setattr(discovery, "prediction_gain", lambda before, after: after / before)
    assert len(_explained([rung(*each) for each in rungs])) == kept


def test_a_set_of_three_that_was_sought_together_stays():
    rungs = [rung(*each) for each in [(8.0, "unexplained"), (6.0, "unexplained")]]
    rungs += [rung(*each) for each in [(4.0, "effect-missing"), (1.0, "adequate")]]
    assert len(_explained(rungs, [3])) == 4


@pytest.mark.parametrize(
    ("verdict", "by_chain", "accepted"),
    [
        ("unexplained", False, "phase-error"),
        ("unexplained", True, None),
        ("effect-missing", True, "phase-error"),
    ],
)
def test_no_effect_goes_in_for_what_the_measuring_chain_did(
    monkeypatch, verdict, by_chain, accepted
):
    """A gain that drifts along one sweep: a phase error takes most of it, and proves nothing."""
    first = SimpleNamespace(
        effect="phase-error", alike=(), probability=0.02, error_after=0.4, physics="phase-error"
    )
    case = SimpleNamespace(
        diagnosis=SimpleNamespace(
            verdict=verdict,
            candidates=[first],
            leading=["phase-error"],
            error=SimpleNamespace(relative_rms=1.0),
        ),
        course=None,
        evidence=SimpleNamespace(instead=(), likeliest_with=dict, drift=None, one_frequency=False),
        naming=SimpleNamespace(confounded=[], alarm=0.0, gain=100.0),
    )
    monkeypatch.setattr(discovery, "by_chain", lambda evidence: by_chain)
    step = SimpleNamespace(case=case, model=SimpleNamespace(effects=()))
    assert _decisive([step]) == accepted
