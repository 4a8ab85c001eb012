"""Missing effects added one by one to a model of a record, until only noise is left."""

from __future__ import annotations

import numpy as np

from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import discover

EFFECTS = [plugins().effect(name) for name in ("friction", "inertia", "time-delay")]


def test_a_record_with_a_mass_and_friction_names_both():
    model = parse_model("fractional-maxwell + friction + inertia")
    values = {"k": 400.0, "c": 60.0, "alpha": 0.5, "friction.F": 20.0, "inertia.m": 8.0}
    t = np.linspace(0.0, 12.0, 240)
    x = np.sin(0.4 * t**1.5)
    force = model.respond(model.vector(values), t, x)
    scatter = 0.5 * np.random.default_rng(5).normal(size=len(t))
    test = TimeTest.of_history(t, x, force + scatter, "m", "N", control="displacement")
    base = parse_model("fractional-maxwell")
    found = discover([test], base, EFFECTS)
    assert {step.accepted for step in found.steps[1:]} == {"friction", "inertia"}
    assert found.verdict == "adequate"
    sizes = [step.over_floor for step in found.steps]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 3 > 1.3 > sizes[-1]
    named = discover([test], base, EFFECTS, accept=EFFECTS[:2])
    assert [step.accepted for step in named.steps] == [None, "friction", "inertia"]
    assert named.to_dict()["steps"][-1]["model"] == found.model.name or found.steps[1].accepted == "inertia"
