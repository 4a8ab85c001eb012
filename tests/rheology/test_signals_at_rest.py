"""What the measurement chain does to a force that sets off at once: before, it was at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.measurement import TimeTest
from springpot.numerics import DIFFERENCE
from springpot.registry import parse_model, plugins
from springpot.rheology.nonlinear import delay, one_filter
from springpot.timetests import identify

T = np.linspace(0.0, 2.0, 101)
SETS_OFF = np.column_stack([np.sin(3.0 * T)])


@pytest.mark.parametrize("tau", [0.03, 0.25, -0.03, -0.25])
def test_the_slope_of_a_delay_is_that_of_what_is_late(tau):
    later, earlier = (delay(T, SETS_OFF, tau + step)[0][:, 0] for step in (DIFFERENCE, -DIFFERENCE))
    (slope,) = delay(T, SETS_OFF, tau)[1]
    inner = np.abs(slope - (later - earlier) / (2.0 * DIFFERENCE))
    # Straight between samples it has the slope of one side, here that of both.
    assert np.max(inner) < 0.2


@pytest.mark.parametrize("law", [delay, one_filter])
def test_a_small_lag_leaves_the_first_sample_where_it_is(law):
    (slope,) = law(T, SETS_OFF, 0.0)[1]
    little = (law(T, SETS_OFF, 1e-4)[0] - SETS_OFF)[:, 0] / 1e-4
    assert slope[0] == little[0] == 0.0
    np.testing.assert_allclose(slope[1:-1], little[1:-1], atol=0.3)


@pytest.mark.parametrize(
    ("effect", "value"),
    [("time-delay", 0.02), ("gain-error", 0.1), ("filter-mismatch", 0.01)],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_chain_records_the_same_force_whichever_channel_was_imposed(effect, value, sign):
    model, t = parse_model(f"zener + {effect}"), np.linspace(0.0, 4.0, 1601)
    theta = np.array([200.0, 300.0, 30.0, sign * value])
    force = 300.0 * np.sin(2.0 * np.pi * t) + 80.0 * np.sin(9.0 * t)
    answer = model.in_time(theta).respond_force(t, force)
    back = model.respond(theta, t, answer.value)
    # Of its first instants a late channel shows nothing: until the material has forgotten them.
    inner = slice(800, -40)
    np.testing.assert_allclose(back[inner], force[inner], atol=0.01 * np.max(force))
    step = np.array([0.0, 0.0, 0.0, 1e-4 * value])
    more, less = (model.respond_force(theta + way * step, t, force) for way in (1.0, -1.0))
    slope = (more - less) / (2.0 * step[-1])
    scale = np.max(np.abs(slope))
    assert np.max(np.abs(slope - answer.by_theta[:, -1])[inner]) < 0.01 * scale


def test_a_chain_without_a_law_under_a_force_is_named():
    known = plugins().effect("gain-error")
    element = replace(known.element, under_force=None)
    model = parse_model("zener") + replace(known, name="of-a-plugin", element=element)
    force = np.sin(3.0 * T)
    with pytest.raises(ModelError, match="of-a-plugin"):
        model.respond_force([200.0, 300.0, 30.0, 0.1], T, force)
    noisy = 0.01 * force + 1e-4 * np.random.default_rng(1).normal(size=len(T))
    test = TimeTest.of_history(T, noisy, force, "mm", "N", control="force")
    with pytest.raises(ModelError, match="of-a-plugin"):
        identify(test, model)
