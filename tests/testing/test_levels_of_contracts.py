"""What is at a level is beyond it: contracts ask for less."""

from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.rheology import Continuum, Model, Parameter, stiffness
from springpot.testing import effects, others

FREE = Model("any", Continuum(), "any linear passive material at all", "Ferry 1980, ch. 3")


@pytest.mark.parametrize(("level", "told"), [(0.5, True), (np.nextafter(0.5, 1.0), False)])
def test_a_spectrum_follows_a_springpot_to_less_than_the_level(monkeypatch, level, told):
    exact = effects.SAMPLE.stiffness

    def half_too_stiff(model, data):
        model = SimpleNamespace(stiffness=lambda theta, points: 1.5 * data.stiffness)
        return SimpleNamespace(model=model, theta=np.array([1.0, 0.0]))

    monkeypatch.setattr(effects, "fit", half_too_stiff)
    monkeypatch.setattr(effects, "CONTRACT", effects.CONTRACT._replace(followed=level))
    # Powers of two, so that half too stiff is half to the last bit.
    sample = SimpleNamespace(
        parameters=effects.SAMPLE.parameters,
        stiffness=lambda theta, points: 2.0 ** np.round(np.log2(np.abs(exact(theta, points)))) + 0j,
    )
    monkeypatch.setattr(effects, "SAMPLE", sample)
    found = list(effects._spectrum(FREE))
    assert (
        found
        == ["a spring beside a spring in series with a springpot is followed to 5.0e-01 only"][
            : int(told)
        ]
    )


def test_an_order_is_lawful_at_both_ends_of_its_range_and_tried_there():
    """Whole ranges of other parameters have no end that is tried."""
    tried = []
    parameters = (
        stiffness("k"),
        Parameter("a", "a", stiffness().unit, 0.2, 0.8, typical=0.5, scale="linear"),
        Parameter("b", "b", stiffness().unit, 0.1, 7.0, typical=1.0),
    )
    asked = SimpleNamespace(
        parameters=parameters,
        stiffness=lambda theta, omega: tried.append(theta) or np.ones((len(theta), 3), complex),
    )
    assert list(effects._passive(asked)) == []
    (theta,) = tried
    assert set(theta[::3, 1]) == {0.2, 0.8}
    assert not set(theta[:, 2]) & {0.1, 7.0}
    assert np.all((theta[:, 1] >= 0.2) & (theta[:, 1] <= 0.8))


@pytest.mark.parametrize(
    ("null", "typical", "near"),
    [
        (0.0, 8.0, 8.0 * effects.CONTRACT.nearly),
        (np.inf, 0.25, 0.25 / effects.CONTRACT.nearly),
        (np.inf, 0.0, 1.0 / effects.CONTRACT.nearly),
        (3.0, 8.0, 3.0 + 3.0 * effects.CONTRACT.nearly),
    ],
)
def test_an_effect_is_asked_for_a_little_beside_where_it_vanishes(null, typical, near):
    """By its typical size, or at infinity so many times it."""
    kelvin, asked = parse_model("kelvin"), []
    size = Parameter("x", "x", stiffness().unit, typical=typical, scale="linear")
    count = len(kelvin.parameters)

    def responds(theta, points):
        asked.append(theta.copy())
        return kelvin.stiffness(theta[:, :count], points)

    grown = SimpleNamespace(parameters=(*kelvin.parameters, size), stiffness=responds)
    effect = SimpleNamespace(
        element=SimpleNamespace(parameters=(size,)), vanishes_at=null, by_levels=False
    )
    assert list(effects._vanishes(effect, kelvin, grown)) == [
        "at its typical size it changes nothing"
    ]
    np.testing.assert_allclose(asked[-1][:, count], near, rtol=1e-12, atol=0.0)


@pytest.mark.parametrize(("calls", "told"), [(5, False), (6, True)])
def test_a_model_fails_an_optimiser_from_the_sixth_call_on(monkeypatch, calls, told):
    """Some end by themselves before, and have met no error."""

    def ends_well(optimiser, budget, problem):
        for _ in range(calls):
            with suppress(ZeroDivisionError):
                problem(np.ones(2))
        return SimpleNamespace(status="converged")

    monkeypatch.setattr(others, "_run", ends_well)
    monkeypatch.setattr(others, "watched", lambda problem, watcher: watcher)
    assert bool(list(others._faults(None))) is told
