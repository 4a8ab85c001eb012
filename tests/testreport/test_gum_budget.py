"""The expanded uncertainty holds the truth as often as it says, whatever tests have in common."""

import numpy as np
import pytest
from known_loops import loop

from springpot.testreport import LoopRecord
from springpot.testreport.code import StatedError
from springpot.testreport.deciding import (
    CONFORMING,
    FAILING,
    UNDECIDED,
    BudgetLine,
    ErrorBudget,
    combined,
    decided,
    sensitivity,
)
from springpot.testreport.summary import EvaluatedTest, Told, evaluate

STORAGE, LOSS, STROKE, CYCLES, TESTS = 3.0, 1.0, 10.0, 5, 4
SCATTER = 0.01
ERRORS = (
    StatedError("load cell", "force", 0.01, True, {}, ""),
    StatedError("stroke", "displacement", 0.005, False, {}, ""),
    StatedError("lag", "phase", 0.004, True, {}, ""),
)


def seen(force, way, phase):
    """What a linear specimen is taken for by instruments that are off by so much."""
    stiffness = (STORAGE + 1j * LOSS) * np.exp(1j * phase) * (1 + force) / (1 + way)
    stroke = STROKE * (1 + way)
    values = {"D+": stroke, "D-": -stroke, "K'": stiffness.real, "K''": stiffness.imag}
    values |= {"K_eff": stiffness.real, "W_d": np.pi * stroke**2 * stiffness.imag}
    return values


def drawn(rng):
    """Means of some tests, from cycles that scatter, with errors that they share or not."""
    force, phase = 0.01 * rng.standard_normal(), 0.004 * rng.standard_normal()
    tests = []
    for _ in range(TESTS):
        true = seen(force, 0.005 * rng.standard_normal(), phase)
        means = {}
        for name, value in true.items():
            each = value * (1.0 + SCATTER * rng.standard_normal(CYCLES))
            sd = np.std(each, ddof=1) / np.sqrt(CYCLES)
            means[name] = Told.of(float(each.mean()), float(sd), CYCLES - 1.0, "cycles")
        tests.append(stub(means))
    return tests


def stub(means):
    record = LoopRecord(np.zeros(2), np.zeros(2), np.zeros(2), "mm", "kN", "stub")
    rate = Told.of(1.0, 0.0, np.inf, "noise")
    return EvaluatedTest(record, None, (), (), 1, CYCLES, means, rate, rate, ())


RESULTS = {
    "one": (lambda q: q[0], lambda q: np.eye(TESTS)[0]),
    "mean": (np.mean, lambda q: np.full(TESTS, 1.0 / TESTS)),
    "ratio": (
        lambda q: q[0] / np.mean(q),
        lambda q: np.eye(TESTS)[0] / np.mean(q) - q[0] / (TESTS * np.mean(q) ** 2),
    ),
}


@pytest.mark.soak
@pytest.mark.parametrize("quantity", ["W_d", "K_eff"])
def test_the_expanded_uncertainty_covers_95_of_100_with_errors_that_tests_share(quantity):
    rng, draws = np.random.default_rng(11), 1000
    truth = seen(0.0, 0.0, 0.0)[quantity]
    inside = dict.fromkeys(RESULTS, 0)
    for _ in range(draws):
        tests = drawn(rng)
        values = np.array([test.means[quantity].value for test in tests])
        for name, (result, slopes) in RESULTS.items():
            budget = combined(result(values), tests, quantity, slopes(values), ERRORS)
            expected = 1.0 if name == "ratio" else truth
            inside[name] += abs(budget.value - expected) <= budget.expanded
    for name, count in inside.items():
        assert count / draws == pytest.approx(0.95, abs=0.02), name


def test_what_all_tests_share_cancels_in_a_ratio_and_not_in_a_mean():
    tests = [stub({name: Told.of(value, 0.0, np.inf, "noise") for name, value in
                   seen(0.0, 0.0, 0.0).items()}) for _ in range(TESTS)]  # fmt: skip
    for error, relative in ((ERRORS[0], 0.01), (ERRORS[2], 0.004 * STORAGE / LOSS)):
        values = np.array([test.means["W_d"].value for test in tests])
        mean = combined(values.mean(), tests, "W_d", np.full(TESTS, 1 / TESTS), [error])
        assert mean.standard / mean.value == pytest.approx(relative)
        ratio = combined(1.0, tests, "W_d", RESULTS["ratio"][1](values), [error])
        assert ratio.standard < 1e-12
    own = combined(values.mean(), tests, "W_d", np.full(TESTS, 1 / TESTS), [ERRORS[1]])
    assert own.standard / own.value == pytest.approx(0.005 / np.sqrt(TESTS))


@pytest.mark.soak_cases("force", "phase")
@pytest.mark.parametrize("acts", ["force", "displacement", "phase"])
def test_sensitivities_are_what_such_an_error_does_to_a_record(acts):
    t, x, force, _ = loop("linear")
    small = 1e-3
    omega = evaluate(LoopRecord(t, x, force, "mm", "kN")).frequency.value * 2.0 * np.pi
    later = 0.8 * 10.0 * np.sin(omega * t + small) + 0.05 * 10.0 * omega * np.cos(omega * t + small)
    moved = {
        "force": (x, force * (1 + small)),
        "displacement": (x * (1 + small), force),
        "phase": (x, later),
    }[acts]
    before = evaluate(LoopRecord(t, x, force, "mm", "kN"), (2, 5))
    after = evaluate(LoopRecord(t, *moved, "mm", "kN"), (2, 5))
    error = StatedError("any", acts, 1.0, True, {}, "")
    for name in ("F+", "F-", "F0", "K_eff", "C_eff", "xi_eff", "W_d", "K'", "K''", "eta"):
        change = (after.means[name].value - before.means[name].value) / small
        size = abs(before.means[name].value)
        assert change == pytest.approx(sensitivity(before, name, error), abs=0.01 * size), name


def test_a_guard_band_lets_at_most_one_of_forty_pass_that_is_at_the_limit():
    rng, draws = np.random.default_rng(3), 4000
    verdicts = []
    for value in 1.0 + 0.02 * rng.standard_normal(draws):
        budget = ErrorBudget(float(value), (BudgetLine("any", "B", 0.02, np.inf),))
        verdicts.append(decided(budget, 1.0, np.inf, "expanded"))
        assert decided(budget, 1.0, np.inf, "none") == (CONFORMING if value >= 1.0 else FAILING)
    assert verdicts.count(CONFORMING) / draws == pytest.approx(0.025, abs=0.0075)
    assert verdicts.count(FAILING) / draws == pytest.approx(0.025, abs=0.0075)


def test_the_chance_outside_is_that_of_the_result():
    budget = ErrorBudget(1.0, (BudgetLine("any", "B", 0.1, np.inf),))
    assert budget.outside(1.0, np.inf) == pytest.approx(0.5)
    assert budget.outside(1.0 - 0.196, 1.0 + 0.196) == pytest.approx(0.05, abs=1e-4)
    few = ErrorBudget(1.0, (BudgetLine("any", "A", 0.1, 2.0),))
    assert few.coverage == pytest.approx(4.303, rel=1e-3)
    assert decided(few, 0.8, 1.2, "expanded") == UNDECIDED
    assert ErrorBudget(1.0, ()).outside(0.9, 1.1) == 0.0
