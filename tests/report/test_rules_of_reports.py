"""Small rules of what is told of a fit, at both sides of their edges."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.measurement import Measurement
from springpot.report import fit_text, invention, ladder_text

OMEGA = np.array([1.0, 2.0, 3.0, 4.0])


@pytest.mark.parametrize(
    ("conditions", "needs", "notes"),
    [
        ({}, (), []),
        ({"temperature": np.full(4, 20.0)}, (), []),
        (
            {"temperature": np.array([20.0, 20.0, 30.0, 30.0])},
            (),
            ["temperature was not used: the data have 2 levels"],
        ),
        ({"temperature": np.array([20.0, 20.0, 30.0, 30.0])}, ("temperature",), []),
        (
            {"temperature": np.array([1.0, 9.0, 20.0, 30.0]), "amplitude": OMEGA},
            (),
            ["temperature was not used: the data have 4 levels", "amplitude was not used"],
        ),
        ({"current": OMEGA}, (), []),
    ],
)
def test_a_condition_that_varies_and_is_not_used_is_told(conditions, needs, notes):
    data = Measurement(OMEGA, OMEGA + 1j, conditions=conditions)
    fitted = SimpleNamespace(
        sweep=data, measurement=data, model=SimpleNamespace(needs=frozenset(needs))
    )
    found = fit_text.unused(fitted)
    assert len(found) == len(notes)
    assert all(told.startswith(note) for told, note in zip(found, notes, strict=True))
    fitted.sweep = None
    assert fit_text.unused(fitted) == []


@pytest.mark.parametrize(
    ("causal", "passive", "kind"),
    [
        (True, True, "causal, passive"),
        (True, False, "causal, not passive"),
        (True, None, "causal"),
        (False, True, "not causal"),
        (False, None, "not causal"),
    ],
)
def test_a_law_is_told_as_the_physics_that_it_is(causal, passive, kind):
    """What is not known of a law is not said."""
    law = SimpleNamespace(
        text="k", probability=0.5, error_after=0.01, causal=causal, passive=passive, like=()
    )
    assert invention._row(law)[3] == kind


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1.5, "by +50 %"),
        (0.75, "by -25 %"),
        (0.5, "by a factor of 0.500"),
        (2.0, "by a factor of 2.00"),
        (3.0, "by a factor of 3.00"),
        (-1.0, "changed sign"),
    ],
)
def test_a_change_beyond_half_and_double_is_a_factor(ratio, words):
    assert ladder_text.change(ratio) == words


def test_shares_of_an_uncertainty_have_two_digits_and_rounding_is_none():
    fitted = SimpleNamespace(
        budget={"k": {"scatter": 1.0 / 3.0, "gain": 4.0 / 7.0, "phase": 1e-14}},
        parameters={"k": SimpleNamespace(value=-100.0)},
    )
    table = fit_text._budget(fitted)
    assert table.rows == [["k", "0.33 %", "0.57 %", "0 %", "0.66 %"]]
