"""Descents within the box: they keep to it, count all they look at, and agree on the optimum."""

from __future__ import annotations

import numpy as np
import pytest

from paper_problems import artificial
from springpot.identification import BoundedDescent, Recorder, minima_in_box, scanned_starts

MODELS = [
    "springpot",
    "fractional-kelvin",
    "fractional-maxwell",
    "fractional-kelvin4",
    "fractional-zener",
]


@pytest.mark.parametrize("model", MODELS)
def test_descents_end_at_the_truth_of_exact_data_and_agree(model):
    problem = artificial(model)
    minima = minima_in_box(problem)
    scale = float(np.sum(problem.measurement.magnitude**2))
    assert (np.diff(minima) >= 0).all()
    assert minima[4] < 1e-15 * scale


def test_every_scanned_shape_is_counted_and_none_before_its_turn(rng):
    """After few evaluations a run must not know the best of the shapes that it has not counted."""
    problem = artificial("fractional-zener")
    count = len(scanned_starts(problem, rng))
    early = []
    for seed in range(20):
        recorder = Recorder(problem, 10**6)
        BoundedDescent(recorder).from_scan(np.random.default_rng(seed), 4)
        assert recorder.evaluations > count
        scan = [(number, value) for number, value in recorder.trace if number <= count]
        early.append(scan[-1][0])
    assert np.median(early) > count / 5


def test_points_stay_in_the_box(rng):
    problem = artificial("fractional-maxwell")
    diary: list = []
    recorder = Recorder(problem, 10**6, diary=diary)
    BoundedDescent(recorder).from_scan(rng, 4)
    points = np.concatenate([np.atleast_2d(page) for page, _ in diary])
    assert (points >= problem.lower * (1 - 1e-12)).all()
    assert (points <= problem.upper * (1 + 1e-12)).all()
