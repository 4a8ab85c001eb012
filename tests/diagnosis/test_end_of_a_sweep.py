"""The end of a sweep.

There an effect begins, and there a bad point has neighbours on one side only.
"""

import re

import numpy as np
import pytest

import springpot
from springpot.diagnosis import diagnose

EFFECTS = ("inertia", "time-delay", "series-spring")


def judged(omega, stiffness, noise, rng):
    """What is missing from any material, by the effects that could be at an end."""
    real, imaginary = noise * rng.normal(size=(2, len(omega)))
    data = springpot.Measurement(
        omega, stiffness * (1.0 + real + 1j * imaginary), units=springpot.Units("kN/m", "mm")
    )
    effects = [springpot.plugins().effect(name) for name in EFFECTS]
    return diagnose(data, springpot.parse_model("material"), effects, np.random.default_rng(0))


def set_aside(found):
    return [note for note in found.notes if "set aside" in note]


def rows_set_aside(found):
    return [int(row) for note in set_aside(found) for row in re.findall(r"row (\d+)", note)]


@pytest.fixture(scope="module", params=[21, 31], ids=["7 points a decade", "10 points a decade"])
def lowered_at_its_last_row(request):
    """A gum of which the last row alone is a fifth lower, as if a mass came up there at once."""
    omega = np.geomspace(0.1, 100.0, request.param)
    stiffness = 3.0 * (1j * omega) ** 0.2 + 8.0 * (1j * omega) ** 0.05
    stiffness[-1] -= 0.2 * np.abs(stiffness[-1])
    return judged(omega, stiffness, 0.005, np.random.default_rng(0)), len(omega)


@pytest.mark.soak_cases("10 points a decade", "7 points a decade")
def test_the_row_before_the_one_that_carries_all_is_not_set_aside(lowered_at_its_last_row):
    """The last one may be: alone it is a bad point as well as the beginning of a mass."""
    found, last = lowered_at_its_last_row
    assert set(rows_set_aside(found)) <= {last}


@pytest.mark.soak
def test_a_bad_last_point_beside_a_clear_mass_is_set_aside():
    """The mass is seen at ten rows, with the last and without it."""
    s = 2j * np.pi * np.geomspace(0.1, 55.0, 24)
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (20.0 * s**0.5)) + 3e-3 * s**2
    stiffness[-1] *= 1.2
    found = judged(s.imag, stiffness, 0.003, np.random.default_rng(0))
    assert found.leading == ("inertia",)
    assert found.best.parameters["m"].value == pytest.approx(3.0, rel=0.05)  # 3e-3 kN s2/m in kg
    (note,) = set_aside(found)
    assert "row 24" in note


@pytest.mark.soak
def test_so_is_one_beside_the_end():
    s = 2j * np.pi * np.geomspace(0.1, 55.0, 24)
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (20.0 * s**0.5)) + 3e-3 * s**2
    stiffness[-2] *= 1.2
    found = judged(s.imag, stiffness, 0.003, np.random.default_rng(0))
    assert found.leading == ("inertia",)
    (note,) = set_aside(found)
    assert "row 23" in note
