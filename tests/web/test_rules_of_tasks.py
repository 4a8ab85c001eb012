"""What the workbench does with an answer that is there: nothing is fitted."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Measurement, Units
from springpot.rheology.grammar import LONGEST
from springpot.web import folders, launch, leaving, tasks, trying
from springpot.web.sessions import Specimen, State

OMEGA = np.geomspace(0.1, 100.0, 12)
SWEEP = Measurement(OMEGA, (1.0 + 0.3j) * OMEGA**0.4, units=Units("kPa", "%"), name="sweep")
TEXT = tasks.text_of(SWEEP)


def quiet(stage):
    return None


@pytest.mark.parametrize(
    ("kind", "name", "key"),
    [
        ("command", "my-sweep.txt", "text"),
        ("script", "my-sweep.py", "text"),
        ("data", "my-sweep-used.csv", "text"),
        ("curves", "my-sweep-curves.csv", "text"),
        ("plan", "my-sweep-plan.csv", "text"),
        ("report", "my-sweep-report.html", "text"),
        ("replay", "my-sweep-replay.gif", "base64"),
        ("nothing", None, None),
    ],
)
def test_each_thing_that_one_leaves_with_has_its_name(kind, name, key, monkeypatch):
    """Command, script and data come at once: they need no fits."""
    climbed = []
    monkeypatch.setattr(tasks, "_ladder", lambda *given: climbed.append(given))
    for each in ("curves_csv", "plan_csv", "report", "replay"):
        monkeypatch.setattr(leaving, each, lambda *given, each=each: each)
    state = {"data": "a", "model": "kelvin"}
    if name is None:
        with pytest.raises(DataError, match="nothing called 'nothing' to leave with"):
            tasks.leave(quiet, kind, state, TEXT, "my-sweep.csv", False)
        return
    found = tasks.leave(quiet, kind, state, TEXT, "my-sweep.csv", False)
    assert (found["name"], set(found)) == (name, {"name", key})
    made = {"curves": "curves_csv", "plan": "plan_csv", "report": "report", "replay": "replay"}
    assert len(climbed) == (kind in made)
    if kind in made:
        assert found[key] == made[kind]


@pytest.mark.parametrize("column", ["temperature", "amplitude"])
def test_sweeps_are_shifted_by_temperature_where_there_is_one(column, monkeypatch):
    asked = []
    master = SimpleNamespace(to_dict=dict)
    monkeypatch.setattr(tasks, "mastercurve", lambda data, column: asked.append(column) or master)
    columns = {"amplitude": OMEGA} | ({column: OMEGA} if column == "temperature" else {})
    data = Measurement(OMEGA, SWEEP.stiffness, conditions=columns)
    found = tasks.mastered(quiet, {"data": "a", "model": "kelvin"}, tasks.text_of(data))
    assert (found["column"], asked) == (column, [column])


def test_the_ladders_asked_for_last_are_kept(monkeypatch):
    climbed = []
    monkeypatch.setattr(tasks, "_ladders", type(tasks._ladders)())
    monkeypatch.setattr(
        tasks,
        "ladder_of",
        lambda state, data, told, begun, fitted: climbed.append(begun) or state.key,
    )
    states = [
        State.of({"data": "a", "model": "kelvin", "seed": i}) for i in range(tasks.LADDERS + 1)
    ]
    for state in (*states[:-1], states[0], states[-1]):
        assert tasks._ladder(state, TEXT, quiet) == state.key
    assert len(climbed) == len(states)
    kept = [states[i].key for i in (*range(2, tasks.LADDERS), 0, tasks.LADDERS)]
    assert list(tasks._ladders) == kept


@pytest.mark.parametrize("count", [trying.FEW, 7 * trying.FEW])
def test_a_first_look_is_at_rows_evenly_of_all(count):
    omega = np.geomspace(0.1, 100.0, count)
    state = State.of({"data": "a", "model": "kelvin"})
    model, (used,) = trying.looked_at(state, Measurement(omega, omega + 1j))
    assert model.name == "kelvin"
    assert len(used) == trying.FEW
    assert used.omega[[0, -1]].tolist() == omega[[0, -1]].tolist()
    steps = np.diff(np.searchsorted(omega, used.omega))
    assert steps.max() - steps.min() <= 1


@pytest.mark.parametrize("celsius", [None, 20.0])
def test_a_plan_has_a_row_for_each_point_with_what_is_to_be_set(celsius):
    told = {} if celsius is None else {"temperature": np.full(12, celsius)}
    data = Measurement(
        OMEGA, SWEEP.stiffness, units=Units("kPa", "%"),
        conditions={"amplitude": np.full(12, 0.5), **told},
    )  # fmt: skip
    advice = SimpleNamespace(action={"omega": [2.0 * np.pi, 4.0 * np.pi]}, says="why")
    ladder = SimpleNamespace(undecided=SimpleNamespace(next_experiment=advice))
    lines = leaving.plan_csv(ladder, data).splitlines()
    head, *rows = [line for line in lines if "why" not in line]
    assert len(rows) == len(lines) - 2
    known = ["frequency [Hz]", "temperature [degC]", "amplitude [%]", "storage [kPa]", "loss [kPa]"]
    assert [name for name in known if name in head] == [
        name for name in known if celsius is not None or "temperature" not in name
    ]
    cells = [[float(cell) for cell in row.split(",") if cell] for row in rows]
    expected = [[1.0, 20.0, 0.5], [2.0, 20.0, 0.5]]
    if celsius is None:
        expected = [[1.0, 0.5], [2.0, 0.5]]
    assert np.allclose(cells, expected)
    for asked, says in (
        (None, "no further measurement is proposed"),
        (SimpleNamespace(action={}), "no further measurement is proposed"),
        (SimpleNamespace(action={"factor": [3.0]}), "told in words"),
    ):
        ladder.undecided.next_experiment = asked
        with pytest.raises(DataError, match=says):
            leaving.plan_csv(ladder, data)


def test_rows_of_other_tests_stand_where_they_stood_as_long_as_there_are_any():
    assert folders._moved([1, 2, 3], [1, 2]) == [0, 1, None]
    assert folders._moved([1, 2], [1, 2, 3]) == [0, 1]


@pytest.mark.parametrize(
    ("value", "number"),
    [(2, 2.0), (0.5, 0.5), (True, 7.0), (np.nan, 7.0), (np.inf, 7.0), ("2", 7.0), (None, 7.0)],
)
def test_a_number_of_a_page_is_finite_and_no_word(value, number):
    assert trying._number(value, 7.0) == number


@pytest.mark.parametrize("more", [0, 1])
def test_a_law_may_be_as_long_as_a_formula(more):
    state, text = State("x", "kelvin"), "my-law = parallel: -m*omega^2"
    text = text.replace("=", "=" + " " * (LONGEST + more - len(text)))
    if more:
        with pytest.raises(DataError, match="at most"):
            trying.with_law(state, text)
    else:
        trying.with_law(state, text)


@pytest.mark.parametrize(("levels", "told"), [(1, 0), (6, 6), (7, 0)])
def test_a_column_was_set_where_it_has_two_rows_at_each_level(levels, told):
    column = np.append(np.arange(levels), np.zeros(12 - levels)) * 10.0
    held = Measurement(OMEGA, SWEEP.stiffness, conditions={"temperature": column})
    assert len(leaving._levels(held)) == told


@pytest.mark.parametrize(
    ("kind", "sources", "tests", "excluded", "says"),
    [
        ("script", 1, 1, (0,), "a.py"),
        ("script", 2, 2, (), "a.py"),
        ("script", 1, 2, (0,), "rows of several tests"),
        ("command", 1, 1, (0,), "a.txt"),
        ("command", 1, 2, (), "a.txt"),
        ("command", 1, 2, (0,), "rows of several tests"),
        ("command", 2, 2, (), "one command takes one file"),
        ("plan", 1, 1, (), "told in words"),
        ("song", 1, 1, (0,), "nothing called 'song'"),
        ("song", 1, 2, (0,), "nothing called 'song'"),
    ],
)
def test_rows_of_several_tests_leave_by_no_script_and_no_command(
    kind, sources, tests, excluded, says, monkeypatch
):
    monkeypatch.setattr(leaving, "script", lambda state, *files: f"reads {len(files)}")
    monkeypatch.setattr(leaving, "command", lambda state, file: f"reads {file}")
    files = [{"name": name, "choice": ""} for name in ("a.csv", "b.csv")[:sources]]
    data = Specimen(tuple(files))
    vars(data)["tests"] = (None,) * tests
    monkeypatch.setattr(tasks, "_opened", lambda text: data)
    monkeypatch.setattr(tasks.State, "of", lambda state: State("x", excluded=excluded))
    if "." not in says:
        with pytest.raises(DataError, match=says):
            tasks.leave(None, kind, {}, "", "", False)
        return
    text = {"script": f"reads {sources}", "command": "reads a.csv\n"}[kind]
    assert tasks.leave(None, kind, {}, "", "", False) == {"name": says, "text": text}


@pytest.mark.parametrize(
    ("asked", "known"), [("near@x=1", True), ("alias", True), ("far", False), ("file.csv", False)]
)
def test_a_page_opens_the_data_sets_that_are_here_and_no_file(asked, known, monkeypatch):
    near = SimpleNamespace(name="near", aliases=("alias",), remote=False)
    far = SimpleNamespace(name="far", aliases=(), remote=True)
    items = SimpleNamespace(items=lambda word: [near, far])
    monkeypatch.setattr(tasks, "plugins", lambda: items)
    monkeypatch.setattr(tasks, "open_measurement", lambda name: f"points of {name}")
    monkeypatch.setattr(tasks, "_understood", lambda data, source: data)
    if known:
        assert tasks.dataset(quiet, asked) == f"points of {asked}"
    else:
        with pytest.raises(DataError, match="no registered data set"):
            tasks.dataset(quiet, asked)


@pytest.mark.parametrize(("error", "told"), [(OSError(), 0), (ValueError(), 1), (None, 1)])
def test_only_a_connection_that_cannot_be_taken_passes_without_a_word(error, told):
    words = []
    launch._told_once(SimpleNamespace(default_exception_handler=words.append), {"exception": error})
    assert len(words) == told


@pytest.mark.parametrize(("kernel", "runs"), [(None, False), ("ipykernel", True), ("marimo", True)])
@pytest.mark.parametrize("extra", [True, False])
def test_a_cell_shows_a_page_where_a_kernel_runs_and_has_the_extra(
    kernel, runs, extra, monkeypatch
):
    monkeypatch.setattr(launch, "find_spec", lambda name: name if extra else None)
    for name in ("ipykernel", "marimo"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    if kernel:
        module = SimpleNamespace(running_in_notebook=lambda: True)
        monkeypatch.setitem(sys.modules, kernel, module)
    assert launch._in_notebook() is (runs and extra)
    # A program that imports marimo is no notebook of it.
    imported = SimpleNamespace(running_in_notebook=lambda: False)
    monkeypatch.setitem(sys.modules, "marimo", imported)
    assert launch._in_notebook() is (kernel == "ipykernel" and extra)


def test_a_column_of_words_that_was_split_is_drawn_by_its_levels():
    """What the answer offers, a factor for each bush of its own, is drawn once it is accepted."""
    omega = np.tile(np.geomspace(1.0, 50.0, 6), 2)
    stiff = np.repeat([1.0, 1.3], 6) * (40.0 + 3j * omega)
    data = Measurement(omega, stiff, labels={"bush": np.repeat(["left", "right"], 6)})
    state = State("0" * 64, "kelvin", ("free-vertical-shift:bush",))
    (seen,) = trying.leveled(state, [data])
    assert seen.conditions["bush"].tolist() == 6 * [1.0] + 6 * [2.0]
    assert trying.bound(state, data).names[-1] == "free-vertical-shift:bush.b_2"
    drawn = trying.scene_of(state, data).points.need("bush")
    assert set(drawn.tolist()) == {1.0, 2.0}
