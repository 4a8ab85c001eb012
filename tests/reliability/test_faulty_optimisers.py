"""Whatever an optimiser does, it is a status of its own trials; those of others keep their bits."""

from __future__ import annotations

import pytest
from faulty_optimisers import DEEDS, MARK, TOLD, TRUE, left_behind, race

from soaked import soaked
from springpot.benchmark import Store, run_study

QUICK = [deed for deed in DEEDS if deed not in ("spin", "ignore signals", "hold the interpreter")]
"""Those that do not only wait for a deadline once more, and burn the processor meanwhile."""
ALIKE = {
    "abort",
    "exit code 7",
    "kill its group",
    "an end of generators",
    "overflow of the stack",
    "leave a fork",
    "leave a timer",
    "raise on rounding",
    "clear the environment",
    "write into all files",
    "a point of another shape",
}
"""Beside each of these another does the same by other means; all are in the soak."""
DIFFERENT = [deed for deed in QUICK if deed not in ALIKE]


def trials(path):
    """What is kept of every trial but its seconds, by label and repetition."""
    with Store(path) as store:
        labels = {cell.id: cell.label for cell in store.cells()}
        return {
            (labels[number], row.repetition): (
                str(row.status),
                row.reason,
                row.best,
                row.theta_text,
                row.parameter_error,
                row.oracle,
                row.evaluations,
                row.trace,
                row.recommended,
                row.seen,
            )
            for number, rows in store.trials()
            for row in rows
        }


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    return trials(
        run_study(race([], 3), engine="serial", out=folder, quiet=True, tables=False).store
    )


def check(found, undisturbed, deeds, repetitions=3):
    innocent = {key: row for key, row in found.items() if key[0].startswith("innocent")}
    assert innocent == {key: row for key, row in undisturbed.items() if key[1] < repetitions}
    for deed in deeds:
        for repetition in range(repetitions):
            status, reason, best, *_ = found[f"faulty {deed}", repetition]
            assert status in TOLD or (status in TRUE and best > 1e-6), (deed, status, reason)
            assert (reason != "") == (status in TOLD), deed


@pytest.mark.soak_cases("some")
@pytest.mark.parametrize(
    ("deeds", "repetitions"), [(DIFFERENT, 1), soaked(QUICK, 3)], ids=["some", "all"]
)
def test_beside_faulty_optimisers_innocent_ones_keep_their_bits(
    undisturbed, tmp_path, monkeypatch, deeds, repetitions
):
    monkeypatch.setenv(MARK, str(tmp_path))
    outcome = run_study(race(deeds, repetitions), workers=2, out=tmp_path, quiet=True, tables=False)
    found = trials(outcome.store)
    check(found, undisturbed, deeds, repetitions)
    assert "evaluated past the recorder" in found["faulty evaluate unseen", 0][1]
    assert "left 1 process behind" in found["faulty leave an orphan", 0][1]
    assert left_behind(str(tmp_path)) == []
    assert "SIGSEGV" in found["faulty segfault", 0][1]
    assert "exit code 0" in found["faulty success without a result", 0][1]
