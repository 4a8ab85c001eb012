"""Which rungs of an automatic ladder stay when not all of the misfit is explained."""

from types import SimpleNamespace

import pytest

from springpot.diagnosis import discovery
from springpot.diagnosis.discovery import _explained


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
