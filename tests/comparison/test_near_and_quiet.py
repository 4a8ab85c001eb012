"""The first sentence where a model's error is that of noise and it is not called adequate."""

import numpy as np
import pytest

import springpot
from springpot.comparison import Ranking
from springpot.comparison.result import Judgement
from springpot.misfit.residual_tests import one_of

OMEGA = np.geomspace(1.0, 100.0, 21)


def first(monkeypatch, noise, why):
    """What a ranking with a near best model says, by the size of noise and the test's finding."""
    scatter = noise * np.random.default_rng(1).normal(size=(2, len(OMEGA)))
    stiffness = (3.0 + 0.3j) * (1.0 + scatter[0] + 1j * scatter[1])
    data = springpot.Measurement(OMEGA, stiffness, units=springpot.Units("kPa", "-"))
    ranking = springpot.compare(data)
    monkeypatch.setattr(Judgement, "says", property(lambda self: why))
    return Ranking(
        ranking.data,
        ranking.judgements,
        ranking.harmonics,
        ranking.notes,
        ranking.one_test,
        ranking.ladder,
        [],
        list(ranking.judgements[:1]),
        ranking.skipped,
    ).says


WHY = (
    "error 0.7 x the noise floor; an amplitude that a fit has not seen is "
    "predicted to 1.7 x the noise"
)


@pytest.mark.soak
def test_a_small_noise_is_not_called_a_bad_measurement(monkeypatch):
    assert first(monkeypatch, 0.005, WHY).endswith(f"is as near as any linear material: {WHY}")


@pytest.mark.soak
def test_a_large_one_is(monkeypatch):
    assert first(monkeypatch, 0.3, WHY).endswith("is no good measurement: repeat it")


@pytest.mark.parametrize(("name", "article"), [("amplitude", "an"), ("temperature", "a")])
def test_what_was_left_out_has_its_article(name, article):
    assert one_of(name) == f"{article} {name}"
