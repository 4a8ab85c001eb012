"""An effect of the rig of one test in time among several is found, and said of which test."""

import numpy as np
import pytest

from springpot import parse_model
from springpot.measurement import TimeTest
from springpot.registry import plugins
from springpot.timetests import diagnose

TIME = np.geomspace(0.01, 100.0, 100)
MATERIAL = {"k": 400.0, "c": 60.0, "alpha": 0.5}


def shown(expression, kind, seed, **effect):
    """A relaxation or a creep test of a model, with noise, named by its kind."""
    model = parse_model(expression)
    theta = model.vector(
        MATERIAL | {f"{expression.split(' + ')[-1]}.{n}": effect[n] for n in effect}
    )
    exact = getattr(model, kind)(theta, TIME)
    record = exact + 0.005 * exact.max() * np.random.default_rng(seed).normal(size=len(TIME))
    make = TimeTest.of_relaxation if kind == "relaxation" else TimeTest.of_compliance
    return make(TIME, record, "kPa", name=kind)


@pytest.mark.soak
@pytest.mark.parametrize(
    ("name", "size"), [("inertia", {"m": 0.5}), ("series-spring", {"k": 1500.0})]
)
def test_what_the_rig_of_the_creep_test_has_is_said_of_it_alone(name, size):
    tests = [
        shown("fractional-maxwell", "relaxation", 2),
        shown(f"fractional-maxwell + {name}", "creep", 3, **size),
    ]
    library = [plugins().effect(each) for each in (name, "test-gain", "finite-ramp")]
    found = diagnose(tests, "fractional-maxwell", library)
    assert found.verdict == "effect-missing"
    assert f"{name}:creep" in found.leading
