"""What is told of one test beside others.

Its error and its noise, each over the size of what was measured.
"""

import numpy as np
import pytest

from springpot.measurement import Measurement
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.registry import parse_model
from springpot.timetests.native import part_result

OMEGA = np.geomspace(0.1, 100.0, 40)
MODEL = parse_model("kelvin")
THETA = MODEL.vector({"k": 50.0, "c": 3.0})
EXACT = MODEL.stiffness(THETA, OMEGA)


def result_of(sd, stiffness):
    part = SweepPart(Measurement(OMEGA, stiffness, sd=sd, name="sweep"))
    return part_result(part, MODEL, THETA, 293.15, 1.0)


def test_error_and_floor_of_a_sweep_are_the_differences_over_the_magnitude():
    """Of equal noise in each part, the error of both is that times the root of two."""
    noise = np.array([1.0, -1.0])[np.arange(40) % 2] * (1.0 + 1.0j)
    size = np.abs(EXACT)
    found = result_of(0.02 * size * (1.0 + 1.0j), EXACT + 0.03 * size * noise)
    measured = np.abs(EXACT + 0.03 * size * noise)
    assert found.noise_floor == pytest.approx(
        np.sqrt(np.mean(2.0 * (0.02 * size / measured) ** 2)), rel=1e-9
    )
    assert found.relative_rms == pytest.approx(
        np.sqrt(np.mean(2.0 * (0.03 * size / measured) ** 2)), rel=1e-9
    )
    assert found.over_floor == pytest.approx(1.5, rel=1e-9)
    assert found.relative_rms == pytest.approx(found.over_floor * found.noise_floor, rel=1e-9)


def test_a_test_agrees_while_it_leaves_hardly_more_than_with_parameters_of_its_own():
    size = np.abs(EXACT)
    found = result_of(0.02 * size * (1.0 + 1.0j), EXACT + 0.02 * size * (1.0 + 1.0j))
    assert found.agrees
    assert not result_of(0.02 * size * (1.0 + 1.0j), EXACT + 0.2 * size * (1.0 + 1.0j)).agrees
    assert found.to_dict()["over_floor"] == pytest.approx(1.0, rel=1e-9)
