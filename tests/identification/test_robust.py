"""Robust fits: what lies far off counts less, and intervals hold what they promise."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.errors import OptionError
from springpot.identification.robust import TUNED, influence
from springpot.measurement import TimeTest

OMEGA = np.geomspace(0.1, 100.0, 30)
MODEL = springpot.parse_model("fractional-zener")
THETA = MODEL.theta(k1=10.0, k2=40.0, c=20.0, alpha=0.5)


def series(seed: int, share: float) -> springpot.Measurement:
    """1 % noise, and 15 % at some of the points."""
    rng = np.random.default_rng(seed)
    noise = 0.01 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    off = (rng.random(30) < share) * 0.15 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    return springpot.Measurement(OMEGA, MODEL.stiffness(THETA, OMEGA) * (1.0 + noise + off))


@pytest.mark.parametrize("loss", TUNED)
def test_of_normal_noise_95_percent_of_the_efficiency_is_kept(loss: str) -> None:
    x = np.linspace(-9.0, 9.0, 20001)
    chance = np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi) * (x[1] - x[0])
    count, slope = influence(x, loss)
    assert slope @ chance == pytest.approx(np.gradient(count * x, x) @ chance, rel=1e-3)
    efficiency = (slope @ chance) ** 2 / ((count * x) ** 2 @ chance)
    assert efficiency == pytest.approx(0.95, abs=0.002)


@pytest.mark.soak
@pytest.mark.parametrize(("loss", "share"), [("huber", 0.1), ("soft-l1", 0.0)])
def test_intervals_cover_beside_points_that_are_far_off(loss: str, share: float) -> None:
    """Four parameters of 20 series; without outliers no worse than least squares by 5 %."""
    held, squares = 0, np.zeros(2)
    for seed in range(20):
        data = series(seed, share)
        fits = [springpot.identify(data, MODEL, robust=each) for each in (loss, None)]
        held += int(np.sum((fits[0].low <= THETA) & (fits[0].high >= THETA)))
        squares += [float(np.sum(np.log(fit.theta / THETA) ** 2)) for fit in fits]
    assert 0.88 <= held / 80 <= 1.0
    ratio = np.sqrt(squares[0] / squares[1])
    assert ratio < 0.4 if share else ratio < 1.08


def test_what_counts_less_is_told_and_a_kept_fit_is_the_same(tmp_path: Path) -> None:
    data = series(3, 0.1)
    fit = springpot.identify(data, MODEL, robust="huber")
    assert any("count less than half" in note for note in fit.notes)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = springpot.load(path)
    assert again.parameters == fit.parameters
    assert again.covariance == pytest.approx(fit.covariance)
    assert again.objective == "relative, huber"


def test_nothing_lies_off_exact_data() -> None:
    exact = springpot.Measurement(OMEGA, MODEL.stiffness(THETA, OMEGA))
    fit = springpot.identify(exact, MODEL, robust="soft-l1")
    assert fit.theta == pytest.approx(THETA, rel=1e-6)
    assert "soft-l1: no number lies off" in fit.notes


def test_what_robust_is_not_for_is_told() -> None:
    data = series(1, 0.0)
    for options in ({"robust": "tukey"}, {"robust": "huber", "intervals": "profile"}):
        with pytest.raises(OptionError):
            springpot.identify(data, MODEL, **options)
    t = np.geomspace(0.1, 10.0, 20)
    test = TimeTest.of_relaxation(t, 3.0 + 2.0 * np.exp(-t))
    for options in ({"robust": "tukey"}, {"robust": "huber", "optimiser": "cma-es"}):
        with pytest.raises(OptionError):
            springpot.identify(test, "zener", **options)


@pytest.mark.parametrize("loss", list(TUNED))
def test_samples_that_lie_far_off_count_less_in_time_too(loss: str) -> None:
    rng, t = np.random.default_rng(1), np.geomspace(0.02, 50.0, 120)
    model = springpot.parse_model("zener")
    exact = model.relaxation(model.theta(k1=20.0, k2=60.0, c=40.0), t)
    off = []
    for _ in range(2):
        force = exact * (1.0 + 0.01 * rng.normal(size=len(t)))
        force[rng.choice(len(t), 12, replace=False)] *= 1.15
        test = TimeTest.of_relaxation(t, force)
        fits = [springpot.identify(test, model, robust=each) for each in (loss, None)]
        off.append([np.abs(fit.theta / [20.0, 60.0, 40.0] - 1.0).max() for fit in fits])
        assert "numbers count less than half" in fits[0].notes[-1]
    robust, plain = np.mean(off, axis=0)
    assert robust < 0.7 * plain
    # Of what lies on the model nothing is far off.
    fit = springpot.identify(TimeTest.of_relaxation(t, exact), model, robust=loss)
    assert f"{loss}: no number lies off" in fit.notes


def test_each_part_is_weighed_by_itself() -> None:
    """A loss of a thousandth of storage is fitted as nearly as storage is."""
    omega = np.geomspace(0.1, 10.0, 12)
    data = springpot.Measurement(omega, 100.0 + 0.3j * omega)
    fit = springpot.identify(data, "kelvin", objective="relative-each")
    weights = fit.fit.objective.weights(data)
    assert weights.real == pytest.approx(1.0 / data.storage)
    assert weights.imag == pytest.approx(1.0 / np.maximum(data.loss, 1e-3 * np.abs(data.stiffness)))


@pytest.mark.parametrize("loss", list(TUNED))
def test_a_point_far_off_exact_data_counts_nothing(loss: str) -> None:
    omega = np.geomspace(0.1, 10.0, 20)
    stiffness = MODEL.stiffness(THETA, omega)
    stiffness[5] *= 1.3
    fit = springpot.identify(springpot.Measurement(omega, stiffness), MODEL, robust=loss)
    assert fit.theta == pytest.approx(THETA, rel=1e-6)
    assert "count less than half" in fit.notes[0]
