"""One engine: the constants of a law are those of a model with it, whichever command asks.

Where not, it is said.
"""

from dataclasses import replace

import numpy as np
import pytest
from sweeps import C1, C2, LOG_A, REFERENCE, TEMPERATURES, material, measured, simple

import springpot
from springpot.identification import fit
from springpot.identification.lack_of_fit import beyond_its_pole
from springpot.superposition import laws
from springpot.superposition.factors import Rows, factors_of
from springpot.superposition.known import allowed_shifts
from springpot.superposition.simplicity import each_alone


def wlf_of(curve):
    (law,) = [one for one in curve.laws if one.law.name == "WLF"]
    return law


def constants(parameters):
    found = [parameters[f"wlf-shift.{name}"] for name in ("C1", "C2")]
    return np.array([[each.value, each.low, each.high] for each in found])


def without_lift(i, omega):
    return material(omega * np.exp(LOG_A[i]))


def off_the_law(i, omega):
    """Each level is off the law by itself, as real materials are, by far more than its scatter."""
    return material(omega * np.exp(LOG_A[i] + 0.3 * np.sin(2.0 * i)))


@pytest.mark.parametrize("sweep", [without_lift, off_the_law, simple])
def test_a_shift_alone_has_one_answer_in_all_commands(sweep):
    """With `simple` the missing vertical factors bend the shift; then too it is one answer."""
    data = measured(sweep, seed=3)
    law = wlf_of(springpot.mastercurve(data, vertical=False))
    ours = np.column_stack([law.values, law.low, law.high])
    np.testing.assert_allclose(
        ours, constants(springpot.identify(data, "material + wlf-shift").parameters), rtol=2e-3
    )


def test_diagnose_gives_the_constants_of_the_curve():
    data = measured(without_lift, seed=3)
    law = wlf_of(springpot.mastercurve(data, vertical=False))
    found = constants(springpot.diagnose(data, "material + wlf-shift").parameters)
    width = law.high - law.low
    np.testing.assert_allclose(found[:, 0], law.values, atol=0.1 * width.max(), rtol=0.02)
    assert np.all(np.abs(np.log((found[:, 2] - found[:, 1]) / width)) < np.log(1.5))


def test_vertical_factors_have_one_answer_too():
    data = measured(simple)
    law = wlf_of(springpot.mastercurve(data))
    found = constants(
        springpot.identify(data, "material + wlf-shift + free-vertical-shift").parameters
    )
    np.testing.assert_allclose(found, np.column_stack([law.values, law.low, law.high]), rtol=0.01)


def test_it_is_said_where_a_model_without_vertical_factors_has_another_law():
    data = measured(simple)
    (note,) = [note for note in springpot.mastercurve(data).notes if "no vertical factors" in note]
    c1 = springpot.identify(data, "material + wlf-shift").parameters["wlf-shift.C1"]
    assert f"C1 {c1.value:.4g}" in note
    plain = springpot.mastercurve(measured(without_lift, noise=0.01, seed=1))
    assert not [note for note in plain.notes if "no vertical factors" in note]


def test_a_law_that_its_levels_depart_from_is_known_as_nearly_as_they_scatter():
    """Ten times the points a level would else shrink an interval that never held the truth."""
    few, many = (
        constants(
            springpot.identify(measured(off_the_law, points=n), "material + wlf-shift").parameters
        )
        for n in (13, 52)
    )
    for found in (few, many):
        assert np.all((found[:, 1] <= [C1, C2]) & (found[:, 2] >= [C1, C2]))
    assert (many[0, 2] - many[0, 1]) > 0.7 * (few[0, 2] - few[0, 1])


@pytest.mark.parametrize("sweep", [without_lift])
def test_constants_hold_the_truth_as_often_as_they_say(sweep):
    """12 series: 95 % of 12 intervals of C1, less three standard deviations of that count."""
    held = []
    for seed in range(12):
        law = wlf_of(springpot.mastercurve(measured(sweep, noise=0.01, seed=seed), vertical=False))
        held.append(law.low[0] <= C1 <= law.high[0])
    assert np.mean(held) >= 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / 12)


def test_a_law_that_shifts_sweeps_apart_which_have_moduli_in_common_is_refused():
    """As WLF far below the glass transition: near its pole it goes through a hundred decades."""
    data = measured(simple)
    curve = springpot.mastercurve(data)
    rows = Rows.of(curve.fit)
    own = each_alone(data, rows.number, curve.fit.objective)
    allowed = allowed_shifts(rows, factors_of(rows), own)
    assert allowed.broken_by(curve.factors.log_a) == ""
    steep = curve.factors.log_a.copy()
    steep[0] += np.log(10.0) * 108.0
    assert "moduli in common" in allowed.broken_by(steep)
    assert "0 degC and 15 degC apart by" in allowed.broken_by(steep)
    assert "endless" in allowed.broken_by(np.where(np.arange(5) == 0, np.inf, steep))


def test_a_law_beyond_its_pole_is_told_with_the_model():
    """C2 = 31 K from 30 degC: a kelvin below the coldest level, where it shifts by 735 decades."""
    data = measured(simple)
    best = fit(springpot.parse_model("material + wlf-shift"), data)
    assert list(beyond_its_pole(best)) == []
    frozen = best.theta.copy()
    frozen[-2:] = 24.5, 31.0
    (note,) = beyond_its_pole(replace(best, theta=frozen))
    assert "0 to 0 degC" in note
    assert "none of a material" in note


def test_the_reference_of_the_laws_is_that_of_the_curve():
    moved = wlf_of(springpot.mastercurve(measured(simple), reference=60.0))
    at_30 = wlf_of(springpot.mastercurve(measured(simple)))
    # C2 and C1 C2 carry over from one reference to another: C2' = C2 + T' - T, C1' C2' = C1 C2.
    assert moved.values[1] == pytest.approx(at_30.values[1] + 30.0, rel=0.01)
    assert moved.values.prod() == pytest.approx(at_30.values.prod(), rel=0.01)
    assert TEMPERATURES[REFERENCE] == 30.0
    assert {law.name for law in laws.LAWS} >= {"WLF", "VFT", "Arrhenius"}
