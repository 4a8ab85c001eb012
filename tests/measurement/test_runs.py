"""The runs that a user is shown.

What was set parts the rows, what was swept or only wandered does not.
"""

import numpy as np

from springpot import Measurement
from springpot.measurement import mixed_up
from springpot.measurement.mixed_up import runs_of

FREQUENCIES = np.geomspace(1.0, 100.0, 12)


def lengths(omega, **columns):
    """Rows of each sweep."""
    labels = {
        key: np.array(column)
        for key, column in columns.items()
        if np.array(column).dtype.kind == "U"
    }
    repeat = columns.pop("repeat", None)
    conditions = {key: column for key, column in columns.items() if key not in labels}
    data = Measurement(
        omega, np.full(len(omega), 1 + 1j), conditions=conditions, labels=labels, repeat=repeat
    )
    return [len(run.rows) for run in runs_of(data)]


def test_each_temperature_is_a_sweep():
    assert lengths(np.tile(FREQUENCIES, 2), temperature=np.repeat([20.0, 30.0], 12)) == [12, 12]


def test_a_temperature_ramp_at_one_frequency_is_one_sweep():
    assert lengths(np.full(200, 6.28), temperature=np.linspace(-75.0, 50.0, 200)) == [200]


def test_each_amplitude_that_was_set_is_a_sweep():
    assert lengths(np.tile(FREQUENCIES, 2), amplitude=np.repeat([0.1, 1.0], 12)) == [12, 12]


def test_a_strain_that_follows_the_frequency_is_no_further_sweep():
    assert lengths(FREQUENCIES, amplitude=0.1 / FREQUENCIES**0.5) == [12]
    assert lengths(FREQUENCIES, amplitude=np.linspace(0.474, 0.4999, 12)) == [12]


def test_an_amplitude_sweep_is_one_sweep():
    assert lengths(np.full(20, 6.28), amplitude=np.geomspace(0.01, 10.0, 20)) == [20]


def test_runs_are_never_merged():
    omega = np.tile(FREQUENCIES, 2)
    assert lengths(omega, specimen=["a"] * 12 + ["b"] * 12) == [12, 12]
    assert lengths(omega, run=np.repeat([1.0, 2.0], 12)) == [12, 12]
    assert lengths(omega, repeat=np.repeat([1, 2], 12)) == [12, 12]


def test_remarks_on_each_row_part_nothing():
    assert lengths(FREQUENCIES, remark=[f"row {i}" for i in range(12)]) == [12]


def test_every_row_is_in_one_sweep(rng):
    omega = rng.choice(FREQUENCIES, 60)
    data = Measurement(
        omega,
        np.full(60, 1 + 1j),
        conditions={
            "temperature": rng.choice([20.0, 30.0], 60),
            "amplitude": rng.choice([0.1, 1.0], 60),
        },
        labels={"step": rng.choice(np.array(["a", "b"]), 60)},
    )
    rows = np.concatenate([run.rows for run in runs_of(data)])
    assert sorted(rows.tolist()) == list(range(60))


def test_a_run_is_known_by_its_step_and_by_what_tells_it_from_the_others():
    labels = {
        "step": ["1", "1", "2", "2"],
        "batch": ["x", "x", "y", "y"],
        "operator": ["A", "A", "A", "A"],
        "file": ["a", "b", "a", "b"],
    }
    data = Measurement(np.array([1.0, 2.0, 1.0, 2.0]), np.full(4, 1.0 + 1.0j), labels=labels)
    rows = np.array([0, 1])
    assert mixed_up._conditions(data, rows, 2) == {"step": "1", "batch": "x"}
    # Of one run alone there is nothing that it must be told from.
    assert mixed_up._conditions(data, rows, 1) == {"step": "1"}
