"""An outlying point: told where it was measured, in its file's words, and the row to leave out."""

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot import Measurement, Units
from springpot.misfit.error import point_in_words
from springpot.misfit.material import split_in_words
from springpot.misfit.outliers import Outlier

OMEGA = np.array([1.0, 10.0, 100.0, 1.0, 10.0, 100.0])
MODULUS = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) * (1.0 + 0.5j)
GEL = Units("Pa", "%", clock="rad/s", letter="G")


@pytest.mark.parametrize(
    ("conditions", "words"),
    [
        ({}, "10 rad/s"),
        ({"temperature": [20.0] * 6}, "10 rad/s"),
        ({"temperature": [20.0] * 3 + [40.0] * 3}, "10 rad/s, 40 degC"),
        ({"amplitude": [0.1] * 3 + [2.0] * 3}, "10 rad/s, 2 %"),
        (
            {"temperature": [20.0] * 3 + [40.0] * 3, "amplitude": [0.1] * 3 + [2.0] * 3},
            "10 rad/s, 40 degC, 2 %",
        ),
    ],
)
def test_a_point_is_told_by_frequency_and_by_what_varies(conditions, words):
    data = Measurement(
        OMEGA, MODULUS, conditions={k: np.array(v) for k, v in conditions.items()}, units=GEL
    )
    assert point_in_words(data, 4) == words


def test_its_row_is_that_of_the_whole_measurement_and_leaves_it_out():
    data = Measurement(OMEGA, MODULUS, units=GEL)
    point = Outlier(
        OMEGA[4] / (2 * np.pi), 12.0, 0.08 + 0j, "10 rad/s", complex(MODULUS[4]), "|G*|"
    )
    told = point.counted_in(data)
    assert str(told) == "10 rad/s, row 5 (8 % of |G*|, 12 sd)"
    assert told.place.says == "a single point at 10 rad/s, row 5, stands out by 12 sd"
    assert MODULUS[4] not in data.excluding(row=told.row).stiffness
    assert "row" not in str(point.counted_in(Measurement(OMEGA, MODULUS * 2, units=GEL)))


@pytest.mark.soak
def test_one_frequency_is_told_as_such():
    """A modulus that falls with amplitude: nothing is known of springs, dashpots and masses."""
    rng = np.random.default_rng(4)
    strain = np.geomspace(0.01, 10.0, 16)
    modulus = (1.0 + 4.0 / (1.0 + strain)) * (1.0 + 0.3j)
    noise = 0.01 * (rng.normal(size=16) + 1j * rng.normal(size=16))
    data = Measurement(
        np.full(16, 10.0),
        modulus * (1.0 + noise),
        conditions={"amplitude": strain},
        units=GEL,
        name="gel",
    )
    diagnosis = springpot.diagnose(data, "kelvin")
    assert "all points have one frequency, 10 rad/s" in str(diagnosis)
    assert "all points have one frequency" in diagnosis._repr_html_()
    frequency_only = {"inertia", "series-spring", "parallel-springpot", "time-delay"}
    assert not [
        each.effect
        for each in diagnosis.candidates
        if each.verdict == "missing" and each.effect in frequency_only
    ]
    omega = np.geomspace(1.0, 100.0, 16)
    of_many = springpot.diagnose(
        Measurement(omega, (1.0 + 0.03j * omega) * (1.0 + noise), units=GEL), "kelvin"
    )
    assert of_many.verdict == "adequate"
    assert not any("all points have" in note for note in of_many.notes)


@pytest.mark.parametrize(
    ("left", "celsius", "says"),
    [
        (0.0, (20.0, 20.0), "no part of the material"),
        (0.0, (20.0, 40.0), "no part of such a one"),
        (72.0, (20.0, 20.0), "is, at least in part, no part of the material"),
    ],
)
def test_words_on_the_material_agree_with_the_errors_beside_them(left, celsius, says):
    """The noise was estimated from the very fit that fails.

    So that its sum of squares is what noise leaves.
    """
    data = Measurement([1.0, 2.0], [1j, 2j], conditions={"temperature": celsius})
    fit = SimpleNamespace(dof=72, measurement=data)
    base = SimpleNamespace(model=springpot.parse_model("kelvin"), rss=72.0 + left, fit=fit)
    refit = SimpleNamespace(rss=72.0, fit=SimpleNamespace(dof=72), floor=0.1)
    floor = SimpleNamespace(refit=refit, relative_rms=0.21, chance=1e-4)
    assert says in split_in_words(base, floor)
