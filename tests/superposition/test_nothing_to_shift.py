"""What a master curve does not tell is said so.

Flat sweeps, and laws that go through all factors by construction.
"""

import numpy as np
import pytest
from sweeps import TEMPERATURES, material, measured, simple

import springpot
from springpot.report.mastercurve import EXACT
from springpot.report.told import told

pytestmark = pytest.mark.usefixtures("asked_once")


def rubber(i, omega):
    """A plateau whose stiffness alone knows of temperature."""
    return (TEMPERATURES[i] + 273.15) / 303.15 * 1e6 * (1.0 + 0.02j) * np.ones_like(omega)


@pytest.mark.soak_cases("3", "0", "1", "2")
@pytest.mark.parametrize("seed", range(4))
def test_flat_sweeps_have_nothing_to_shift_by(seed):
    curve = springpot.mastercurve(measured(rubber, noise=0.01, seed=seed))
    (note,) = [note for note in curve.notes if "nothing to shift by" in note]
    assert not curve.determined.any() or curve.determined.sum() == 1
    said = [f"{t:g} degC" for t in TEMPERATURES if t != curve.reference]
    assert all(name in note for name in said)
    assert not [note for note in curve.notes if "overlap" in note]
    # The table marks every factor that may be anything; the vertical one is what the plateau tells.
    rows = [line for line in told(curve).splitlines() if "no: flat" in line]
    assert len(rows) == 4
    # As far as any law shifts: e^60.
    assert all("8.8e-27, 1.1e+26" in row for row in rows)
    b = {level.value: level.b for level in curve.levels}
    assert b[60.0] / b[0.0] == pytest.approx(333.15 / 273.15, rel=0.05)
    assert curve._repr_html_().count('data-label="determined">no: flat<') == 4


@pytest.mark.soak
def test_straight_sweeps_that_rise_are_not_called_flat():
    def straight(i, omega):
        return 1e6 * (1j * omega * np.exp(-0.1 * i)) ** 0.05

    curve = springpot.mastercurve(measured(straight, noise=0.005))
    assert not [note for note in curve.notes if "nothing to shift by" in note]


def test_sweeps_with_a_slope_keep_their_factors():
    text = told(springpot.mastercurve(measured(simple)))
    assert "nothing to shift by" not in text
    assert "not determined" not in text
    assert EXACT not in text


@pytest.mark.soak
def test_a_law_with_as_many_constants_as_factors_is_exact_by_construction():
    whole = measured(lambda i, omega: material(omega * np.exp(-0.05 * TEMPERATURES[i])))
    two = whole.subset(whole.conditions["temperature"] < 20.0)
    curve = springpot.mastercurve(two)
    lines = [line for line in told(curve, 200).splitlines() if "cannot-tell" in line]
    assert lines
    for line in lines:
        assert EXACT in line
        assert "e-" not in line.partition(EXACT)[2]
    # In numbers it is what it was.
    assert all(
        law["departure"] < 1e-4
        for law in curve.to_dict()["laws"]
        if law["verdict"] == "cannot-tell"
    )
