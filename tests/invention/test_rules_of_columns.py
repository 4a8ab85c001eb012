"""What tells again what is known, and what was held: rules of columns, at both sides of edges."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.invention import inventing
from springpot.measurement import Measurement
from springpot.thresholds import INVENTION

OMEGA = np.geomspace(1.0, 100.0, 12)


def measured(omega=OMEGA, **given):
    return Measurement(omega, 3.0 + 1.0j * np.sqrt(omega), **given)


@pytest.mark.parametrize(
    ("values", "lengths"),
    [
        ([1.0, np.e], [0.0, 1.0]),
        ([-1.0, -np.e], [0.0, 1.0]),
        ([-2.0, 1.0], [-1.0, 0.5]),
        ([0.0, 4.0], [0.0, 1.0]),
        ([0.0, -4.0], [0.0, -1.0]),
        ([0.0, 0.0], [0.0, 0.0]),
    ],
)
def test_lengths_are_logarithms_or_shares_of_the_largest(values, lengths):
    np.testing.assert_allclose(inventing._lengths(np.array(values)), lengths)


@pytest.mark.parametrize(("repeats", "steps"), [(3, True), (2, False)])
def test_what_goes_with_the_frequency_is_a_step_at_each_or_a_smooth_course(repeats, steps):
    omega = np.tile(OMEGA[:4], repeats)
    found = inventing._of_frequency(measured(omega))
    if steps:
        np.testing.assert_array_equal(found, np.tile(np.eye(4), repeats))
        return
    # Anything smooth over the logarithm is a sum of these, from end to end.
    x = np.log(omega)
    course = 1.0 + 2.0 * x - 0.3 * x**2
    assert np.abs(course - found.T @ np.linalg.lstsq(found.T, course, rcond=None)[0]).max() < 1e-9
    assert found[:2, 0].tolist() == [1.0, -1.0]


@pytest.mark.parametrize(("count", "shapes"), [(4, 3), (5, 0)])
def test_runs_have_steps_of_their_own_where_each_has_three_rows(count, shapes):
    label = np.array([f"run {i % count}" for i in range(12)])
    found = inventing._of_runs(measured(labels={"run": label}))
    assert found.shape == (shapes, 12)
    for i, shape in enumerate(found, 1):
        np.testing.assert_array_equal(shape, label == f"run {i}")
    assert inventing._of_runs(measured()).shape == (0, 12)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_column_follows_others_where_they_leave_next_to_nothing_of_its_spread(share):
    rng = np.random.default_rng(4)
    known = [np.ones(30), rng.normal(size=30)]
    basis, _ = np.linalg.qr(np.column_stack([*known, rng.normal(size=30)]))
    column = 2.0 + 3.0 * known[1]
    # What is left is counted by the rows that nothing known has taken.
    left = basis[:, 2] * np.sqrt(28.0) * share * INVENTION.repeated * np.std(column)
    assert inventing._follows(column + left, known) == (share < 1.0)


@pytest.mark.parametrize(("rows", "enough"), [(4, True), (3, False)])
def test_of_too_few_rows_anything_would_follow(rows, enough):
    known = [np.ones(rows), np.arange(float(rows))]
    assert inventing._follows(5.0 + known[1], known) is enough


@pytest.mark.parametrize(("held", "was"), [(7, True), (6, False)])
def test_a_column_was_held_where_most_rows_share_it_with_another_frequency(held, was):
    column = np.arange(12.0) + 100.0
    column[:held] = 50.0
    assert inventing._was_held(measured(), column) is was
    # With rows of the same frequency alone nothing was held.
    assert not inventing._was_held(measured(np.repeat(OMEGA[:6], 2)), np.repeat(np.arange(6.0), 2))
