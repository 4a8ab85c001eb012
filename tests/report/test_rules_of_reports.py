"""Small rules of what is told of a fit, at both sides of their edges."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.identification.value import LOST
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model
from springpot.report import answers, canvas, fit_text, html, invention, ladder_text
from springpot.report.canvas import CANVAS, blank
from springpot.report.inspection import LONG, sweeps_text
from springpot.report.views import DrawnFit, Scene, cole_cole

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


@pytest.mark.parametrize(
    ("good", "source", "told"),
    [(False, "estimated", 1), (True, "estimated", 0), (False, "given", 0)],
)
def test_a_floor_about_a_model_that_is_not_good_enough_may_be_too_high(good, source, told):
    standing = SimpleNamespace(good_enough=good, noise_source=source)
    assert len(fit_text._of_floor(SimpleNamespace(standing=standing))) == told
    assert fit_text._of_floor(SimpleNamespace(standing=None)) == []


@pytest.mark.parametrize("ratio", [0.999, 1.001])
def test_a_parameter_that_moved_far_is_told_in_words(ratio):
    assert ladder_text._in_numbers(LOST * ratio) is (ratio < 1.0)
    assert ladder_text._in_numbers(ratio / LOST) is (ratio > 1.0)


def test_as_many_sweeps_as_are_shown_leave_none():
    level = {"from": 1.0, "to": 2.0}
    sweep = {"points": 3, "frequency": level, "amplitude": None, "temperature": 20.0}
    for more in (0, 1):
        text = sweeps_text([sweep] * (LONG + more), [], Units("Pa", "-"), 80)
        assert ("more; --json has all" in text) is bool(more)


@pytest.mark.parametrize(("count", "drawn"), [(1, 1), (2, CANVAS.smooth)])
def test_a_curve_is_smooth_between_two_places_and_a_point_at_one(count, drawn):
    omega = np.repeat(OMEGA[:count], 2)
    scene = Scene(Measurement(omega, omega + 1j), [DrawnFit(parse_model("kelvin"), np.ones(2))])
    assert len(scene.curves[0][0][0]) == drawn


def test_a_step_on_a_page_tells_the_split_of_both_ends(monkeypatch):
    one, other = (
        SimpleNamespace(model=SimpleNamespace(name=name), split=split)
        for name, split in (("first", "half"), ("last", "all"))
    )
    for judged, told in (
        ({"a": one, "b": other}, ["first: half", "last: all"]),
        ({"a": one}, ["first: half"]),
        ({"a": one, "b": one}, ["first: half"]),
        ({}, []),
    ):
        monkeypatch.setattr(html, "_diagnosed", lambda ladder, judged=judged: judged)
        assert html._splits(SimpleNamespace(steps=["a", "x", "b"])) == told


def test_steps_are_named_without_lines_between_them():
    with blank() as figure:
        axes = figure.subplots()
        ladder_text._names(axes, (SimpleNamespace(accepted="inertia"),) * 2)
    assert [line.get_visible() for line in axes.get_xgridlines()] == [False] * 2
    assert any(line.get_visible() for line in axes.get_ygridlines())


@pytest.mark.parametrize("part", [1.0, 1j])
def test_loss_over_storage_is_drawn_by_decades_only_where_both_are_positive(part):
    size = np.array([1.0, 10.0, 1e3, 1e5])
    for sign, scale in ((1.0, "log"), (-1.0, "linear")):
        k = size * (1.0 + 1.0j - part + sign * part)
        with blank() as figure:
            axes = figure.subplots()
            cole_cole(axes, Scene(Measurement(OMEGA, k), []))
        assert axes.get_xscale() == scale


@pytest.mark.parametrize(("between", "parts"), [(2.1, 2), (1.9, 1)])
def test_a_chain_of_neighbours_is_no_level_where_it_is_as_wide_as_what_lies_between(between, parts):
    chain = np.linspace(0.0, 2.0, 6)
    celsius = np.concatenate([chain, chain[-1] + between + chain])
    found = canvas._split("temperature", celsius, np.tile(np.arange(6.0), 2), np.arange(12))
    assert len(found) == parts


@pytest.mark.parametrize(
    ("after", "told"), [(0.012, " (5.00 % -> 1.20 %)"), (0.05000001, ""), (float("nan"), "")]
)
def test_a_step_tells_an_error_only_where_it_falls(after, told):
    """Of a point that the answer has set aside already it stays what it is."""
    step = SimpleNamespace(says="row 3 stands out", error_after=after, command="do it")
    answer = SimpleNamespace(error=SimpleNamespace(relative_rms=0.05), steps=[step])
    assert list(answers.steps_of(answer).items) == [f"row 3 stands out{told}: do it"]


def test_of_what_was_fitted_nearly_the_reason_is_told_and_not_that_it_was_left_out():
    reasons = {"slack": "name a model", "inertia": "it has no law in time"}
    lines = [str(line) for line in answers.left_out(reasons, ["slack"]).items]
    assert lines == [
        "fitted nearly: slack: name a model",
        "left out: inertia: it has no law in time",
    ]
