"""The contracts of optimisers, objectives, data sets, readers and plugins find what they should."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import threading
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.identification import BatchedOptimiser, BudgetSpent, Card, Objective, Optimiser
from springpot.measurement import DataSet, Measurement, Reader, Units
from springpot.processes import can_copy
from springpot.testing import (
    check_dataset,
    check_objective,
    check_optimiser,
    check_plugin,
    check_reader,
    networks,
)
from springpot.testing.networks import kept_random_state
from springpot.testing.others import _batch

pytest_plugins = ["pytester"]


def says(found: list[str], sentence: str) -> bool:
    return any(sentence in complaint for complaint in found) and not any(
        "\n" in complaint for complaint in found
    )


# Optimisers ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Good(Optimiser):
    """Random points.

    Parameters
    ----------
    block : int
        Points at once.
    """

    block: int = 10
    name: ClassVar[str] = "good-optimiser"
    card: ClassVar[Card] = Card("random points")

    def minimise(self, problem, budget, rng):
        while True:
            problem.batch(self.draw(problem, rng))

    def draw(self, problem, rng):
        return problem.lower + rng.random((self.block, problem.dimension)) * (
            problem.upper - problem.lower
        )


class Crashing(Good):
    def minimise(self, problem, budget, rng):
        raise RuntimeError("not\nhere")


class Tossing(Good):
    def draw(self, problem, rng):
        return super().draw(problem, np.random)


class Reseeding(Good):
    def minimise(self, problem, budget, rng):
        random.seed(1)
        super().minimise(problem, budget, rng)


class Stubborn(Good):
    def minimise(self, problem, budget, rng):
        super().minimise(problem, budget, np.random.default_rng(3))


class Straying(Good):
    def draw(self, problem, rng):
        return 1.5 * super().draw(problem, rng)


class Idle(Good):
    def minimise(self, problem, budget, rng):
        problem(0.5 * (problem.lower + problem.upper) * (1 + 1e-6 * rng.random()))


class Swallowing(Good):
    def minimise(self, problem, budget, rng):
        try:
            super().minimise(problem, budget, rng)
        except ZeroDivisionError:
            return


class Sly(Good):
    def minimise(self, problem, budget, rng):
        problem.gradient(0.5 * problem.upper)
        super().minimise(problem, budget, rng)


class Carrying(BatchedOptimiser):
    """A batch in which the runs disturb each other."""

    name: ClassVar[str] = "carrying"
    card: ClassVar[Card] = Card("random points", batched=True)

    def minimise_batch(self, problems, budget, rngs):
        while True:
            points = np.stack([rngs[0].random((5, 4)) for _ in rngs])
            problems.batch(points * problems.problem.upper)


class Changeable(Optimiser):
    name: ClassVar[str] = "changeable"
    card: ClassVar[Card] = Card("random points")
    minimise = Good.minimise
    draw = Good.draw
    block = 10


@dataclass
class Thawed(Good.__bases__[0]):
    size: int = 1
    name: ClassVar[str] = "thawed"
    card: ClassVar[Card] = Card("random points")
    block = 10
    minimise = Good.minimise
    draw = Good.draw


@dataclass(frozen=True)
class Opaque(Good):
    """With an option method that is no plain value."""

    method: object = print


OPTIMISERS = {
    Crashing: (
        "budget: with a budget of 1 it ends as 'failed: RuntimeError: not' after 0 evaluations"
    ),
    Tossing: "repeatable: two runs with the same generator differ",
    Reseeding: "changes the process-wide random state",
    Stubborn: "repeatable: it does not depend on the generator: say stochastic=False",
    Straying: "above the box, which ends at 2000",
    Idle: (
        "improves: the best of three runs of 400 evaluations is 1 of the value at the box's centre"
    ),
    Swallowing: "faults: an error of the model is swallowed: the run ends as 'converged'",
    Sly: "gradient: it uses derivatives, but its card says gradient=False",
    Carrying: "batch: run 2 of a batch of three differs from the same run alone",
    Changeable: "options: it is no dataclass",
    Thawed: "options: option size can be changed",
    Opaque: "options: raises StudyError",
}


def test_a_good_optimiser_is_given_no_complaint():
    assert check_optimiser(Good) == []


@pytest.mark.soak_cases("Carrying")
@pytest.mark.parametrize("optimiser", OPTIMISERS)
def test_a_slip_in_an_optimiser_is_one_sentence(optimiser: type[Optimiser], stays):
    found = check_optimiser(optimiser)
    assert says(found, OPTIMISERS[optimiser]), found
    stays(found)


def test_runs_of_a_batch_that_disturb_each_other_are_told():
    assert [complaint[:5] for complaint in _batch(Carrying())] == ["run 1", "run 2", "run 3"]


def test_an_option_without_a_word_of_explanation():
    assert says(check_optimiser(Thawed), "options: option size is not described in the docstring")


@pytest.mark.parametrize(
    ("card", "sentence"),
    [
        (
            Card("random points", stochastic=False),
            "repeatable: it depends on the generator, but its card says",
        ),
        (
            Card("random points", gradient=True),
            "gradient: it does not use derivatives, but its card says gradient=True",
        ),
        (
            Card("random points", batched=True),
            "batch: its card must say batched=True if, and only if,",
        ),
        (Card(""), "words: the summary must be"),
    ],
)
def test_a_card_that_does_not_tell_the_truth(card: Card, sentence: str):
    boastful = type("Boastful", (Good,), {"card": card})
    assert says(check_optimiser(boastful), sentence)


def test_the_end_of_the_budget_may_be_noticed():
    class Tidy(Good):
        def minimise(self, problem, budget, rng):
            try:
                super().minimise(problem, budget, rng)
            except BudgetSpent:
                return

    assert check_optimiser(Tidy) == []


def test_the_process_wide_random_state_is_put_back():
    before, own = np.random.get_state()[1].tolist(), random.getstate()  # noqa: NPY002
    with kept_random_state() as touched:
        assert not touched()
        np.random.random()  # noqa: NPY002
        assert touched()
        random.random()
    assert np.random.get_state()[1].tolist() == before  # noqa: NPY002
    assert random.getstate() == own


# Objectives ---------------------------------------------------------------------------------------

GOOD = Objective("good-objective", "plain squares", lambda data: np.full(len(data), 1 + 1j))


class Biased(Objective):
    def residual(self, stiffness, measurement, weights):
        return super().residual(stiffness, measurement, weights) + 1.0


class Skewed(Objective):
    def derivative(self, by_theta, stiffness, weights):
        return 2.0 * super().derivative(by_theta, stiffness, weights)


class Lifted(Objective):
    def value(self, stiffness, measurement, weights):
        return super().value(stiffness, measurement, weights) + 1.0


OBJECTIVES = {
    "a real weight": (
        replace(GOOD, weights=lambda data: np.ones(len(data))),
        "weights must be complex",
    ),
    "one weight": (
        replace(GOOD, weights=lambda data: np.array([1 + 1j])),
        "weights must be complex, one for each",
    ),
    "a negative weight": (
        replace(GOOD, weights=lambda data: np.full(len(data), 1 - 1j)),
        "finite and not negative",
    ),
    "no weight": (
        replace(GOOD, weights=lambda data: np.zeros(len(data), complex)),
        "all weights are zero",
    ),
    "deviations that must be there": (
        replace(GOOD, weights=lambda data: 1 / data.sd.real + 1j / data.sd.imag),
        "weights: raises AttributeError",
    ),
    "a toss": (
        replace(GOOD, weights=lambda data: np.random.random(len(data)) * (1 + 1j)),  # noqa: NPY002
        "process-wide random",
    ),
    "a bias": (
        Biased("good", "plain squares", GOOD.weights),
        "value: without standard deviations: the value is not",
    ),
    "a lift": (
        Lifted("good", "plain squares", GOOD.weights),
        "the value of perfect data is not zero",
    ),
    "a wrong derivative": (
        Skewed("good", "plain squares", GOOD.weights),
        "derivative is not that of the residuals",
    ),
}


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_good_objective_is_given_no_complaint(logarithmic: bool):
    assert check_objective(replace(GOOD, logarithmic=logarithmic)) == []


@pytest.mark.parametrize("case", OBJECTIVES)
def test_a_slip_in_an_objective_is_one_sentence(case: str):
    objective, sentence = OBJECTIVES[case]
    found = check_objective(objective)
    assert says(found, sentence), found


class Looping(Good):
    def minimise(self, problem, budget, rng):
        while True:
            pass


class Dying(Good):
    def minimise(self, problem, budget, rng):
        os._exit(3)


def test_a_plugin_that_hangs_or_dies_is_named_within_the_time_that_is_told():
    assert can_copy(), "an earlier test left a thread running: no copy could die in our place"
    [hangs] = [says for says in check_optimiser(Looping, deadline=0.5) if "end" in says]
    assert hangs == "budget: does not end: all aspects together may take 0.5 s"
    assert "budget: the process ended with exit code 3" in check_optimiser(Dying)


LET_GO = threading.Event()


class Waiting(Good):
    def minimise(self, problem, budget, rng):
        LET_GO.wait()


def test_a_plugin_that_hangs_is_named_where_threads_run_too(monkeypatch):
    monkeypatch.setattr(networks, "can_copy", lambda: False)
    before = set(threading.enumerate())
    found = check_optimiser(Waiting, deadline=0.5)
    assert "budget: does not end: all aspects together may take 0.5 s" in found
    LET_GO.set()
    for thread in set(threading.enumerate()) - before:
        thread.join()


# Data sets ----------------------------------------------------------------------------------------


def measured(name="good-data", n=5, unit="kN/m"):
    return Measurement(np.arange(1.0, n + 1), np.full(n, 1 + 1j), units=Units(unit), name=name)


DATA = DataSet(
    "good-data",
    "five points of nothing",
    measured,
    licence="CC0-1.0",
    citation="nobody (2024)",
    size=5,
)
DATASETS = {
    "a name with a space": (
        replace(DATA, name="good data"),
        "words: the name 'good data' cannot be typed",
    ),
    "no licence": (replace(DATA, licence=""), "words: there is no licence"),
    "no citation": (replace(DATA, citation=""), "words: there is no citation"),
    "no summary": (replace(DATA, summary="data"), "words: the summary must be"),
    "an unknown kind": (
        replace(DATA, kind="guessed"),
        "words: the kind is 'guessed', not one of measured",
    ),
    "a wrong size": (replace(DATA, size=6), "loads: it loads 5 points where it says 6"),
    "another name": (
        replace(DATA, load=lambda: measured("other")),
        "loads: the measurement is called 'other'",
    ),
    "an unknown unit": (
        replace(DATA, load=lambda: measured(unit="furlong")),
        "loads: raises DataError: data set 'good-data': unknown unit [furlong]",
    ),
    "no measurement": (replace(DATA, load=lambda: None), "gives None, which is no measurement"),
    "a fault": (
        replace(DATA, load=lambda: 1 / 0),
        "'good-data' cannot be loaded: ZeroDivisionError",
    ),
    "noise that changes": (
        replace(
            DATA, load=lambda: replace(measured(), stiffness=np.random.default_rng().random(5) + 1j)
        ),
        "loads: loaded twice, stiffness differs",
    ),
    "a truth without a model": (
        replace(DATA, truth={"k": 1.0}),
        "truth: it gives true parameters but not the model",
    ),
    "a truth of another model": (
        replace(DATA, truth={"k": 1.0}, model="kelvin"),
        "truth: its true parameters are k; kelvin has k, c",
    ),
    "an unknown model": (
        replace(DATA, model="kelvim"),
        "truth: raises ModelError: unknown model 'kelvim'",
    ),
}


def test_a_good_data_set_is_given_no_complaint():
    assert check_dataset(DATA) == []
    assert (
        check_dataset(
            replace(DATA, citation="", kind="artificial", model="kelvin", truth={"k": 1, "c": 2})
        )
        == []
    )


@pytest.mark.parametrize("case", DATASETS)
def test_a_slip_in_a_data_set_is_one_sentence(case: str):
    dataset, sentence = DATASETS[case]
    found = check_dataset(dataset)
    assert says(found, sentence), found


def test_what_is_unavailable_is_not_loaded():
    assert (
        check_dataset(replace(DATA, unavailable="the disk is full", load=lambda: 1 / 0, licence=""))
        == []
    )


# Readers ------------------------------------------------------------------------------------------


def read_json(path, choice):
    if choice:
        raise DataError(f"{path}: there is nothing to choose")
    return read_any(path, choice)


def read_any(path, choice):
    try:
        table = json.loads(path.read_bytes())
        parts = (np.array([float(v) for v in table[key]]) for key in ("omega", "storage", "loss"))
        omega, storage, loss = parts
        return Measurement(
            omega, storage + 1j * loss, units=Units(str(table["unit"])), name=path.stem
        )
    except Exception as error:
        raise DataError(f"{path}: {' '.join(str(error).split())}") from None


def text_json(data):
    if (
        data.conditions
        or data.labels
        or any(part is not None for part in (data.sd, data.repeat, data.harmonics))
    ):
        raise DataError("omega, storage and loss only")
    return lossy(data)


def lossy(data):
    columns = {"omega": data.omega, "storage": data.storage, "loss": data.loss}
    return json.dumps(
        {"unit": data.units.stiffness} | {key: column.tolist() for key, column in columns.items()}
    )


def is_json(head):
    return 0.9 if head.startswith(b"{") else 0.0


def short(data):
    if data.conditions or data.labels or data.sd is not None:
        raise DataError("no")
    return lossy(replace(data, stiffness=data.stiffness.astype(np.complex64)))


READER = Reader("good-json", "columns in JSON", is_json, read_json, text=text_json)
SAMPLE = b'{"unit": "Pa", "omega": [1, 2], "storage": [3, 4], "loss": [5, 6]}'
READERS = {
    "nothing to try it on": (
        replace(READER, text=None),
        [],
        "samples: it writes no files and there are no samples",
    ),
    "a sample that is not recognised": (
        READER,
        [b" " + SAMPLE],
        "samples: sample 1 is not recognised",
    ),
    "a sample that is refused": (READER, [b"{}"], "samples: sample 1 is refused: read: "),
    "a path for a measurement": (
        replace(READER, read=lambda path, choice: path),
        [SAMPLE],
        "samples: read of sample 1 gives no Measurement",
    ),
    "no signals": (
        replace(READER, signals=read_json),
        [SAMPLE],
        "samples: signals of sample 1 gives no Signals",
    ),
    "a crash": (
        replace(READER, read=lambda path, choice: json.loads(path.read_text())),
        [],
        "garbage: read raises UnicodeDecodeError, not DataError",
    ),
    "deaf": (
        replace(READER, read=read_any),
        [],
        "choice: a part that the file does not have is passed over",
    ),
    "too sure": (replace(READER, recognises=lambda head: 2.0), [], "garbage: recognises gives 2.0"),
    "a stumble": (
        replace(READER, recognises=lambda head: head.decode() and 0.5),
        [],
        "garbage: recognises raises",
    ),
    "text that is lost": (
        replace(READER, text=lossy),
        [],
        "standard deviations: sd is not read back",
    ),
    "digits that are lost": (
        replace(READER, text=short),
        [],
        "plain data: stiffness is not read back",
    ),
    "plain data refused": (
        replace(READER, text=lambda data: text_json(replace(data, repeat=np.arange(len(data))))),
        [],
        "round-trip: plain data cannot be written: omega, storage and loss only",
    ),
    "what it does not know again": (
        replace(READER, recognises=lambda head: 0.0),
        [],
        "round-trip: plain data: what it writes is not recognised",
    ),
}


def refuse_without_a_word(path, choice):
    raise DataError("wrong\nin two lines")


def test_a_good_reader_is_given_no_complaint(tmp_path):
    path = tmp_path / "sample.json"
    path.write_bytes(SAMPLE)
    assert check_reader(READER) == []
    assert check_reader(READER, [SAMPLE, path]) == []
    assert check_reader(replace(READER, text=None), [SAMPLE]) == []


@pytest.mark.parametrize("case", READERS)
def test_a_slip_in_a_reader_is_one_sentence(case: str):
    reader, samples, sentence = READERS[case]
    found = check_reader(reader, samples)
    assert says(found, sentence), found


def test_a_refusal_is_one_line_that_says_why():
    found = check_reader(replace(READER, read=refuse_without_a_word, text=None), [SAMPLE])
    assert any("garbage: read must refuse in one line that says why" in line for line in found)


# Whole plugins ------------------------------------------------------------------------------------

PLUGIN = """
from springpot.hooks import hookimpl
from springpot.rheology import Model, spring
from springpot.measurement import DataSet

MODEL = Model("my-model", spring(), {summary!r}, "nobody (2024)")
DATA = DataSet("my-data", "five points of nothing", lambda: None, unavailable="not here")


@hookimpl
def {hook}():
    return [{offered}]
"""
TEST = """
import my_plugin
from springpot.testing import PluginContract


class TestMyPlugin(PluginContract):
    plugin = my_plugin
    {more}
"""


@pytest.fixture
def author(pytester, monkeypatch):
    """Outcome and output of an author's test file."""

    def outcome(hook="springpot_models", offered="MODEL", summary="a single spring", more=""):
        (pytester.path / "my_plugin.py").write_text(
            PLUGIN.format(hook=hook, offered=offered, summary=summary)
        )
        (pytester.path / "test_my_plugin.py").write_text(TEST.format(more=more))
        # An author's environment has not the other plugins of pytest that this one has.
        monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
        found = pytester.runpytest_inprocess("-p", "no:cacheprovider", "-rA", "-q")
        return found.ret, found.stdout.str()

    return outcome


def test_an_author_s_test_file_is_short_and_passes(author, pytester):
    code, out = author()
    assert len((pytester.path / "test_my_plugin.py").read_text().strip().splitlines()) < 10
    assert code == 0, out
    assert "PASSED test_my_plugin.py::TestMyPlugin::test_keeps_its_contract[model my-model]" in out
    assert "3 passed" in out


@pytest.mark.soak_cases(
    "slip0-words: the summary must be one sentence",
    "slip4-'other' is to be skipped but not offered",
)
@pytest.mark.parametrize(
    ("slip", "sentence"),
    [
        ({"summary": ""}, "words: the summary must be one sentence"),
        (
            {"hook": "springpot_model"},
            "there is no hook springpot_model: did you mean springpot_models?",
        ),
        ({"offered": ""}, "it offers nothing that can be checked"),
        ({"offered": "DATA", "hook": "springpot_datasets"}, "everything is unavailable here"),
        ({"more": "skip = {'other': ['words']}"}, "'other' is to be skipped but not offered"),
    ],
)
def test_an_author_s_slip_fails_with_a_sentence(author, slip, sentence):
    code, out = author(**slip)
    assert code == 1, out
    assert sentence in out


def test_what_is_unavailable_beside_something_else_is_skipped(author):
    more = "\n@hookimpl\ndef springpot_datasets():\n    return [DATA]\n"
    code, out = author(offered="MODEL]" + more.rstrip("]\n"))
    assert code == 0, out
    assert "3 passed, 1 skipped" in out
    assert "not here" in out


def test_a_plugin_can_be_checked_without_pytest(tmp_path, monkeypatch):
    (tmp_path / "their_plugin.py").write_text(
        PLUGIN.format(hook="springpot_models", offered="MODEL", summary="")
    )
    monkeypatch.syspath_prepend(tmp_path)
    [found] = check_plugin("their_plugin")
    assert found.startswith("model 'my-model': words: the summary must be one sentence")
    [found] = check_plugin("no_such_plugin")[:1]
    assert found.startswith("ModuleNotFoundError")


def test_importing_the_package_of_contracts_costs_nothing():
    code = "import sys, springpot.testing; print(*sys.modules)"
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"numpy", "pytest", "pluggy", "springpot.registry"} & set(told)
