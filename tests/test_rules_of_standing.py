"""How a fit stands beside noise, any material and a longer search."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot import loading
from springpot.comparison.result import ONLY_NOISE
from springpot.errors import DataError
from springpot.identification.problem import relative_objective
from springpot.measurement import Units
from springpot.rheology.parameters import Dimension
from springpot.thresholds import VERDICT
from springpot.timetests import comparing


@cache
def fitted():
    """Twelve points of a spring and a dashpot, a hundredth off."""
    omega = np.geomspace(0.1, 10.0, 12)
    off = 1.0 + 0.01 * np.cos(7.0 * omega)
    return springpot.identify(springpot.Measurement(omega, (3.0 + 0.5j * omega) * off), "kelvin")


@pytest.fixture
def judged(monkeypatch):
    """What a comparison says of the model: an error of 2 % beside noise of 1 %."""
    error = SimpleNamespace(relative_rms=0.02, noise_floor=0.01, noise_source="estimated")
    said = SimpleNamespace(error=error, says=ONLY_NOISE, fails=False, unclear=False)
    asked = SimpleNamespace(judgements=[said])
    monkeypatch.setattr(comparing, "compare_sweeps", lambda data, models, rng: asked)
    monkeypatch.setattr(comparing, "lowest_error", lambda *given: 0.005)
    return said


def fit(error=0.02, **more):
    """The fit, as if its error were so large."""
    found = SimpleNamespace(
        **{
            name: getattr(fitted(), name)
            for name in ("uncertainty", "fit", "seed", "measurement", "model", "theta")
        }
    )
    found.relative_rms = error
    vars(found).update(more)
    return found


@pytest.mark.parametrize(
    ("error", "noise", "good"),
    [(0.0299, 0.01, True), (0.0301, 0.01, False), (0.0301, 0.03, True), (0.046, 0.03, False)],
)
def test_a_search_stopped_short_half_again_above_what_its_model_reaches(judged, error, noise, good):
    judged.error.noise_floor = noise
    found = comparing.standing_of(fit(error))
    assert found.good_enough is good
    assert ("this model reaches 2 % on these data" in found.says) is not good
    assert (found.noise_floor, found.material_floor) == (noise, 0.005)


@pytest.mark.parametrize("fault", ["fails", "unclear"])
def test_a_model_that_fails_or_may_is_none_that_a_longer_search_mends(judged, fault):
    setattr(judged, fault, True)
    for error in (0.02, 9.0):
        found = comparing.standing_of(fit(error))
        assert (found.good_enough, found.says) == (False, ONLY_NOISE)


def test_another_objective_may_leave_a_larger_error(judged):
    other = replace(fitted().fit, objective=replace(relative_objective(), name="another"))
    assert comparing.standing_of(fit(9.0, fit=other)).good_enough


def test_of_too_few_numbers_nothing_is_said(judged, monkeypatch):
    few = SimpleNamespace(dof=VERDICT.fewest_spare - 1)
    assert comparing.standing_of(fit(fit=few)) is None

    def refused(*given):
        raise DataError("too few")

    monkeypatch.setattr(comparing, "compare_sweeps", refused)
    assert comparing.standing_of(fit()) is None


def test_what_specimens_differ_by_is_not_called_noise(judged, monkeypatch):
    kept = SimpleNamespace(scatter=lambda fit: 0.031)
    monkeypatch.setattr(comparing, "Specimens", SimpleNamespace(of=lambda data: kept))
    found = comparing.standing_of(fit())
    assert found.says == "what is left is that specimens differ by 3.1 %"
    kept.scatter = lambda fit: None
    assert comparing.standing_of(fit()).says == ONLY_NOISE


@pytest.mark.parametrize(("promise", "good"), [("3%,20mrad", True), ("0.3%,20mrad", False)])
def test_a_fit_is_good_enough_within_what_the_instrument_promises(promise, good):
    test = fitted().measurement
    wavy = test.stiffness * (1.0 + 0.01 * np.cos(np.linspace(0.0, 9.0, 12)))
    data = springpot.Measurement(test.omega, wavy, sd=np.full(12, 1e-4 * (1.0 + 1.0j)))
    found = springpot.identify(data, "kelvin", accuracy=promise).standing
    assert found.good_enough == good
    assert found.says.startswith("within what the instrument promises") == good


@pytest.mark.parametrize("fails", [True, False])
def test_tests_in_time_stand_by_their_own_judgement(monkeypatch, fails):
    error = SimpleNamespace(noise_floor=0.01, noise_source="estimated", material_floor=0.02)
    said = SimpleNamespace(error=error, fails=fails, says="as it is")
    monkeypatch.setattr(comparing, "judgement_of", lambda found, delta, floor: said)
    monkeypatch.setattr(comparing.RankedInTime, "of", lambda identified: identified)
    monkeypatch.setattr(comparing, "material_floor", lambda identified: 0.02)
    found = comparing.standing_of(SimpleNamespace(uncertainty=None))
    assert (found.good_enough, found.says, found.material_floor) == (not fails, "as it is", 0.02)


def test_what_a_user_states_is_in_the_units_of_the_stiffness():
    """A mass in kg and a time in s, a stiffness and a force as they are given."""
    known = loading.stated("coulomb-friction", {"friction.F": 3.0}, "kN/m", "--unit")
    assert known.theta == pytest.approx([3.0])
    known = loading.stated("kelvin", {"k": 3.0, "c": 0.5}, "kN/m", "--unit")
    assert known.theta == pytest.approx([3.0, 0.5])
    assert (known.units.stiffness, known.units.amplitude) == ("kN/m", "m")
    assert loading._factor(known.units, Dimension(1, 0, 1)) == 1.0
    assert loading._factor(known.units, Dimension(1, 2)) == 1000.0
    assert loading.stated("kelvin", {"k": 3.0, "c": 0.5}, None, "--unit").units == Units()
