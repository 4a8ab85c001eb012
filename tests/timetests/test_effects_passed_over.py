"""Where all effects that a scan foretold to help miss by far, the others are fitted too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.measurement import Loading
from springpot.misfit.residual_scatter import scatter_of
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import plugins
from springpot.timetests import identify
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.hypotheses import FitResiduals, Hypothesis
from springpot.timetests.native import STARTS
from springpot.timetests.score import TimeScan
from springpot.timetests.screening import left_by_screening

MODEL = springpot.parse_model("zener")
TIME = np.geomspace(0.01, 100.0, 60)
NAMES = ("force-drift", "ageing", "thermal-force")
EFFECTS = [effect for effect in plugins().items("effect") if effect.name in NAMES]


@pytest.fixture(scope="module")
def missed():
    """What a fit leaves of a broad relaxation, and what a scan promises beside it."""
    broad = 50.0 + 400.0 / (1.0 + TIME**0.4)
    noise = np.random.default_rng(1).normal(size=len(TIME))
    test = TimeTest.of_relaxation(TIME, broad + noise, "kPa")
    base, parts = identify(test, MODEL), parts_of_specimen([test])
    before = FitResiduals.by(base.model, base.theta, base.reference, parts)
    return base, before, TimeScan(base, quick_parts(parts)).entries(EFFECTS)


def tried(missed, share: float) -> list[Hypothesis]:
    """One effect that leaves so much of what the model leaves, and noise."""
    base, before, _ = missed
    noise = np.random.default_rng(2).normal(size=len(TIME))
    residuals = tuple(share * each + noise for each in before.residuals)
    scatters = tuple(scatter_of(each) for each in residuals)
    left = replace(before, residuals=residuals, scatters=scatters)
    return [Hypothesis((EFFECTS[0],), base.model + EFFECTS[0], base.theta, left)]


@pytest.mark.parametrize("share", [0.9, 0.1])
def test_what_misses_the_test_has_the_others_fitted(missed, share) -> None:
    """By far, and by a little more than the noise."""
    _, before, entries = missed
    others = left_by_screening(entries, tried(missed, share), before)
    assert {each[0].effect.name for each in others} == {*NAMES} - {EFFECTS[0].name}


def test_what_explains_the_test_has_no_other_fitted(missed) -> None:
    _, before, entries = missed
    assert left_by_screening(entries, tried(missed, 0.0), before) == []


def test_of_few_samples_several_times_the_noise_is_not_explained(missed) -> None:
    """They know their noise too badly for a plain misfit."""
    base, before, entries = missed
    few = 4.3 * np.where(np.arange(25) % 2, 1.0, -1.0)
    worse, left = (
        replace(before, residuals=(each,), scatters=(scatter_of(each),))
        for each in (3.0 * few, few)
    )
    assert not left.misfit
    best = Hypothesis((EFFECTS[0],), base.model + EFFECTS[0], base.theta, left)
    others = left_by_screening(entries, [best], worse)
    assert {each[0].effect.name for each in others} == {*NAMES} - {EFFECTS[0].name}


def test_what_does_not_go_as_its_size_is_tried_at_several() -> None:
    """Friction that holds back nearly all of a load is no start for one that holds back little."""
    time, knots = np.linspace(0.15, 20.0, 40), np.array([0.0, 0.0, 6.3, 6.3, 20.0])
    loading = Loading(knots, np.array([0.0, 1.0, 1.0, 0.0, 0.0]))
    answer = 0.003 * (time**0.7 - np.maximum(time - 6.3, 0.0) ** 0.7)
    test = TimeTest(time, answer, loading, "force")
    base = identify(test, springpot.parse_model("springpot"))
    scan = TimeScan(base, quick_parts(parts_of_specimen([test])))
    [tried] = scan.entries([plugins().effect("bearing-friction")]).values()
    assert len(tried) >= STARTS
    assert min(entry.values[0] for entry in tried[:STARTS]) < 0.25
