"""Small rules that all rooms share, each at both sides of its edge."""

from __future__ import annotations

import json
import os
import resource
import signal
import stat
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from springpot import (
    api,
    constraints,
    distributions as own,
    files,
    limits,
    numerics,
    plain_data,
    processes,
    writing as numbers,
)
from springpot.api import library
from springpot.errors import DataError, ModelError, OptionError, OutputError, SpringpotError
from springpot.measurement import Measurement, Units
from springpot.measurement.timetest import TimeTest
from springpot.registry import parse_model

X = np.array([0.01, 0.5, 2.0, 7.0, 30.0])


def test_chances_and_quantiles(stays):
    sums = [
        own.f_sum_sf(value, np.array(k), np.array(nu))
        for value in (1.0, 9.0, 40.0)
        for k, nu in (([3.0], [6.0]), ([2.0, 5.0], [8.0, 30.0]), ([1.0, 1.0], [4.5, 1e6]))
    ]
    students = [
        own.student(level, dof)
        for level in (0.5, 0.95, 0.999, 1.0 - 1e-9)
        for dof in (-1, 0, 0.5, 1, 1.9, 2, 2.9, 3, 4.5, 10, 1e3, np.inf)
    ]
    stays(
        {
            "chi-square": [own.chi2_sf(X, 3.0), own.chi2_quantile([0.1, 0.9], 3.0)],
            "F": [own.f_sf(X, 2.0, 5.0), own.f_quantile([0.1, 0.9], 2.0, 5.0)],
            "density": [own.f_log_density(X, first, 5.0) for first in (1.0, 2.0, 40.0)],
            "gamma": own.gamma_sf(X, 2.5),
            "normal": [own.normal_quantile([0.1, 0.9]), own.normal_sf(X)],
            "sums": np.array(sums)[:, None].tolist(),
            "student": np.array(students)[:, None].tolist(),
        },
        within=1e-6,
    )


def test_numbers_in_words(stays):
    given = (0.0, 1.0, -1.0, 1234.5, 99995.0, 99994.9, 999999.5, 1e6, 0.001, 9.9994e-4, 9.9996e-4,
             1e-7, -2.34567e-9, 1e-101, 1e150, np.inf, -np.inf, np.nan, None)  # fmt: skip
    places = [(1.26, -1), (1.24, 0), (-0.001, -2), (-0.001, -5), (1234567.0, 2), (1e6, 3),
              (0.00012, -6), (0.00012, -5), (0.00012, -3), (np.inf, 0), (0.0, -3)]  # fmt: skip
    stays(
        {
            "numbers": [[numbers.number(value, d) for d in (1, 2, 4)] for value in given],
            "exponents": [numbers.exponent_of(value, 2) for value in given[:-4]],
            "places": [numbers.at_place(value, place) for value, place in places],
            "counted": [numbers.counted(count, "point") for count in (0, 1, 2)],
        }
    )


def test_least_squares_without_negative_weights():
    matrix = np.array([[1.0, 0.9, 0.0], [0.0, 0.5, 1.0], [1.0, 0.0, 1.0], [0.3, 0.2, 0.1]])
    weights, left = numerics.non_negative(matrix, matrix @ np.array([2.0, 0.0, 1.0]))
    np.testing.assert_allclose(weights, [2.0, 0.0, 1.0], atol=1e-12)
    assert left == pytest.approx(0.0, abs=1e-20)
    weights, left = numerics.non_negative(np.eye(3), np.array([1.0, -2.0, 3.0]))
    np.testing.assert_allclose(weights, [1.0, 0.0, 3.0])
    assert left == pytest.approx(4.0)


def test_memory_may_grow_by_so_much_and_a_hard_limit_stays(monkeypatch):
    asked = []
    monkeypatch.setattr(processes, "address_space", lambda: 1000)
    monkeypatch.setattr(resource, "setrlimit", lambda kind, ends: asked.append(ends))
    for hard, wanted in ((-1, 1000 + 3 * 2**20), (2000, 2000), (2**40, 1000 + 3 * 2**20)):
        monkeypatch.setattr(resource, "getrlimit", lambda kind, hard=hard: (-1, hard))
        processes.limit_memory(3)
        assert asked.pop() == (wanted, hard)
    monkeypatch.setattr(processes, "address_space", lambda: None)
    processes.limit_memory(3)
    assert asked == []


def test_a_timer_that_runs_is_a_changed_setting():
    before = processes.settings()
    signal.setitimer(signal.ITIMER_VIRTUAL, 1000.0)
    try:
        assert processes.settings() != before
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    assert processes.settings() == before
    assert before[1] == (False,) * len(processes.TIMERS)


@pytest.mark.parametrize(
    ("status", "cause"),
    [
        (0, "the process ended with exit code 0"),
        (3 << 8, "the process ended with exit code 3"),
        (9, "the process was ended by SIGKILL"),
        (60, "the process was ended by signal 60"),
    ],
)
def test_how_a_process_ended(status, cause):
    assert processes.cause_of(status) == cause


@pytest.mark.soak
def test_a_copy_answers_in_time_or_is_ended():
    done = processes.elsewhere(lambda report: report(b"a" * 200_000), 20.0)
    assert (len(done.message), done.late) == (200_000, False)
    assert done.cause == "the process ended with exit code 0"

    def hangs(report):
        report(b"begun")
        signal.pause()

    late = processes.elsewhere(hangs, 2.0)
    assert (late.message, late.late) == (b"begun", True)
    assert late.cause == "the process was ended by SIGKILL"

    def quiet(report):
        report(json.dumps([os.getsid(0) == os.getpid(), os.read(0, 1).decode()]).encode())

    assert json.loads(processes.elsewhere(quiet, 20.0).message) == [True, ""]
    had = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    assert signal.SIGINT not in had


def test_children_that_run_are_ended_and_those_that_ended_are_collected(tmp_path):
    listing = tmp_path / "children"
    listing.write_text("12 7\n")
    assert processes.children_of(listing) == [12, 7]
    assert processes.children_of(tmp_path / "none") == []
    gone = os.fork()
    if gone == 0:
        os._exit(0)
    os.waitid(os.P_PID, gone, os.WEXITED | os.WNOWAIT)
    runs = os.fork()
    if runs == 0:
        signal.pause()
        os._exit(0)
    known = os.fork()
    if known == 0:
        signal.pause()
        os._exit(0)
    others = set(processes.children_of()) - {gone, runs, known}
    try:
        assert processes.end_children({known, *others}) == 1
        assert set(processes.children_of()) & {gone, runs, known} == {known}
    finally:
        processes.end_group(known)
        os.waitpid(known, 0)


@pytest.mark.parametrize(
    ("value", "plain"),
    [
        (1.0, 1.0),
        (1e150, 1e150),
        (1.1e150, None),
        (-1.1e150, None),
        (np.nan, None),
        (1 + 2j, [1.0, 2.0]),
        ({1: (np.float64(2.0), None)}, {"1": [2.0, None]}),
        (np.array([[1, 2], [3, 4]]), [[1, 2], [3, 4]]),
        (True, True),
    ],
)
def test_plain_data_holds_finite_numbers_alone(value, plain):
    assert plain_data.jsonable(value) == plain


def test_what_a_file_declares_is_of_its_kind():
    holds = plain_data._DECLARED
    right = {"str": "a", "str | None": None, "bool": True, "int": 3, "float": 2,
             "float | None": 2.5, "tuple[str, ...]": ("a",), "dict[str, float]": {"a": 1},
             "tuple[tuple[str, ...], ...]": (("a",), ("b", "c")),
             "Mapping[str, str]": {"a": "b"}}  # fmt: skip
    wrong = {"str": 1, "str | None": 1, "bool": 1, "int": True, "float": "a",
             "float | None": "a", "tuple[str, ...]": (1,), "dict[str, float]": {"a": "b"},
             "tuple[tuple[str, ...], ...]": ((),), "Mapping[str, str]": {"a": 1}}  # fmt: skip
    assert [holds[name](value) for name, value in right.items()] == [True] * len(right)
    assert [holds[name](value) for name, value in wrong.items()] == [False] * len(wrong)


def test_a_file_is_read_up_to_its_size_and_not_beyond(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"x" * 2048)
    assert len(files.bytes_of(path, 2048)) == 2048
    with pytest.raises(DataError, match="at most 1 KiB are read in one piece"):
        files.bytes_of(path, 2047)
    assert [files._size(most) for most in (1 << 20, (1 << 20) - 1, 64 << 20)] == [
        "1 MiB",
        "1023 KiB",
        "64 MiB",
    ]
    path.write_bytes(b"ab\xff")
    with pytest.raises(DataError, match=r"\(byte 2\)"):
        files.text_in(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[1e150, -1e150, 2]", ""),
        ("[1.1e150]", "is no number that can be used"),
        ("[NaN]", "is no number that can be used"),
        ("[" + "1" * 160 + "]", "is no number that can be used"),
        ("[" * 5000 + "]" * 5000, "nested too deeply"),
    ],
)
def test_json_holds_numbers_that_can_be_used(text, says):
    if not says:
        assert files.json_of(text, finite=True) == [1e150, -1e150, 2]
        return
    with pytest.raises(ValueError, match=says):
        files.json_of(text, finite=True)


def test_json_and_toml_are_bounded(monkeypatch):
    monkeypatch.setattr(files, "FILES", files.FILES._replace(containers=3))
    assert files.json_of('[[], {"a": 1}]') == [[], {"a": 1}]
    with pytest.raises(ValueError, match="more than 3 lists and objects"):
        files.json_of("[[], [], {}]")
    assert files.toml_of("a = 1.5\nb.c = 2") == {"a": 1.5, "b": {"c": 2}}
    with pytest.raises(ValueError, match="is no finite number"):
        files.toml_of("a = inf")
    assert files.toml_of("a" + ".b" * 40 + " = 1")
    with pytest.raises(ValueError, match="nested too deeply"):
        files.toml_of("a" + ".b" * 50 + " = 1")


def test_limits_hold_in_an_own_process_and_its_main_thread_alone():
    assert limits.limited(lambda: 3, 1e-9, 1) == 3
    with limits.own_process():
        assert limits.limited(lambda: 4, 10.0, 1 << 32) == 4

        def loops():
            while True:
                pass

        with pytest.raises(limits.OverTime):
            limits.limited(loops, 0.05, 1 << 32)
        assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
        before = resource.getrlimit(resource.RLIMIT_AS)
        grown = limits.limited(lambda: resource.getrlimit(resource.RLIMIT_AS)[0], 5.0, 1 << 30)
        assert abs(grown - limits.address_space() - (1 << 30)) < 1 << 26
        assert resource.getrlimit(resource.RLIMIT_AS) == before
    assert not limits._own


OMEGA = np.geomspace(1.0, 10.0, 8)
DATA = Measurement(
    OMEGA, 5.0 + 1j * OMEGA, labels={"batch": np.array(list("aabbccab"))},
    conditions={"current": np.ones(8)}, units=Units("kN/m", "mm"), name="made",
)  # fmt: skip


def answer(ask):
    try:
        return ask()
    except SpringpotError as error:
        return f"{type(error).__name__}: {error}"


def test_words_of_constraints(stays):
    model = parse_model("kelvin")
    pairs = ("k=2", " k = 2.5 ", "k=", "=2", "k", "k=a", "k=1=2")
    bounds = ("k=0:200", "k=:2", "k=1:", "k=:", "k=3", "k=a:b")
    owns = ("k:batch", "k,c:batch", "k", "*", "k,:batch", "k:", ":batch")
    optimisers = (
        "least-squares", "pso-paper", "pso-paper:particles=7", "pso-paper:particles=7,",
        "pso-paper:particles=a", "pso-paper:flies=7", "pso-paper:particles", "nobody",
        "pso-paper:neighbourhood=global", "pso-paper:neighbourhood=all",
        "least-squares:method=dogbox", "least-squares:method=newton",
    )  # fmt: skip
    found = {
        "values": [answer(lambda text=text: constraints.values_of([text])) for text in pairs],
        "bounds": [answer(lambda text=text: constraints.bounds_of([text])) for text in bounds],
        "own": [answer(lambda text=text: constraints.own_of([text])) for text in owns],
        "optimisers": [
            answer(lambda text=text: repr(constraints.optimiser_of(text))) for text in optimisers
        ],
        "own values": [
            answer(lambda given=given: constraints.own_values(model, DATA.units, given, "start"))
            for given in (None, {"k": 2}, {"k": "a"}, {"m": 1.0}, "k=2")
        ],
        "held": [
            answer(lambda more=more: constraints.constrained(model, DATA.units, *more).names)
            for more in (
                ({"k": 2.0}, None),
                (None, {"k": (0.0, 2.0)}),
                (None, {"k": (0.0,)}),
                (None, {"k": "05"}),
                (None, {"k": 3.0}),
                ({"x": 2.0}, None),
            )
        ],
    }
    for own_by in (
        {},
        {"k": "batch"},
        {"*": "batch"},
        {"k": "current"},
        {"k": "none"},
        {"x": "batch"},
    ):
        asked = answer(lambda own_by=own_by: constraints.owning(model, [DATA], own_by))
        if not isinstance(asked, str):
            grown, tests = asked
            asked = [grown.names, tests[0].conditions, dict(tests[0].provenance)]
        found[f"owning {own_by}"] = asked
    inertia = parse_model("material")
    found["of material"] = answer(lambda: constraints.owning(inertia, [DATA], {"k": "batch"}))
    again = Measurement(
        np.tile(OMEGA, 2), np.tile(5.0 + 1j * OMEGA, 2), repeat=np.arange(16) // 4,
        conditions={"current": np.repeat([1.0, 2.0], 8)},
    )  # fmt: skip
    found["repeats"] = constraints.owning(model, [again], {"k": "current"})[1][0].repeat
    stays(found)


def test_what_users_hand_over_is_a_list(stays):
    relaxed = TimeTest.of_relaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.5], "kPa")
    again = replace(DATA, stiffness=1.01 * DATA.stiffness)
    model = parse_model("kelvin")
    effects = library(only=["inertia", "time-delay"])
    stays(
        {
            "listed": [api._listed("ab"), api._listed(3), api._listed([1, 2])],
            "tests": [len(api._tests(DATA)), len(api._tests([DATA, relaxed]))],
            "joined": [len(each) for each in api._tests([DATA, again])],
            "none": answer(lambda: api._tests([])),
            "number": answer(lambda: api._tests([3])),
            "models": [api._model("kelvin").name, api._model(model).name, api._judged(None).name],
            "no model": answer(lambda: api._model(3)),
            "shown": api._shown(np.zeros(40)),
            "effects": [each.name for each in effects],
            "without": [each.name for each in library(only=["inertia"], without=())],
            "no effect": answer(lambda: library(only=["inertia"], without="inertia")),
            "unknown": answer(lambda: library(only=["nothing"])),
            "no name": answer(lambda: api._effect(3, [])),
            "several": answer(
                lambda: api.predict(api.identify(DATA, "kelvin"), [relaxed, relaxed])
            ),
            "no fit": answer(lambda: api.predict(3, relaxed)),
            "both": answer(lambda: api.mastercurve([DATA, relaxed])),
        }
    )
    assert api._effect("inertia", effects) is effects[0]


def test_outputs_and_inputs_of_a_run_are_kept_apart(tmp_path):
    one, two, link = (tmp_path / name for name in ("one.csv", "two.csv", "link.csv"))
    one.write_text("1")
    link.symlink_to(one)
    with files.one_run():
        files.keep_input(one)
        with pytest.raises(OutputError):
            files.require_writable(link)
        files.keep_output(two)
        with pytest.raises(OutputError, match="another output of this command goes there"):
            files.keep_output(two)
        files.keep_output("/dev/null")
        files.keep_output("/dev/null")
    files.keep_output(two)
    files.keep_output(two)
    assert files.require_writable(link) == link
    with pytest.raises(OutputError, match="it is a folder"):
        files.require_writable(tmp_path)
    with pytest.raises(OutputError):
        files.require_writable(tmp_path / "none" / "a.csv")
    files.write_text(link, "new")
    assert one.read_text() == "new"
    assert link.is_symlink()
    assert stat.S_IMODE(one.stat().st_mode) & 0o600 == 0o600


def test_errors_are_told_by_kind():
    for kind in (DataError, ModelError, OptionError, OutputError):
        assert issubclass(kind, SpringpotError)


def test_a_row_is_named_by_labels_and_conditions_alike():
    table = Measurement(
        np.array([1.0, 2.0]),
        np.array([1.0 + 1j, 2.0 + 1j]),
        conditions={"batch": np.array([2.0, 3.0])},
        labels={"specimen": np.array(["a", "b"])},
    )
    assert constraints._words(table, "batch, specimen") == ["2/a", "3/b"]
    with pytest.raises(DataError, match=r"no column 'lot' \(there are: batch, specimen\)"):
        constraints._words(table, "lot")


@pytest.mark.parametrize("columns", ["batch/number", "batch,number"])
def test_numbers_that_come_again_in_each_batch_are_counted_through(columns):
    table = Measurement(
        np.arange(1.0, 5.0),
        np.full(4, 1.0 + 1j),
        conditions={"number": np.array([1.0, 2.0, 1.0, 2.0])},
        labels={"batch": np.array(["a", "a", "b", "b"])},
    )
    found = constraints._numbered(table, columns)
    assert found.conditions[columns].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert ("batch" in found.conditions) is ("/" in columns)


@pytest.mark.parametrize(
    ("share", "own"), [((), ["k", "c", "inertia.m"]), ("c", ["k", "inertia.m"])]
)
def test_factors_of_levels_are_no_level_s_once_more(share, own):
    """Every parameter of each level: but for those that levels share, or have already."""
    omega = np.geomspace(1.0, 10.0, 4)
    data = Measurement(omega, omega + 1j, conditions={"batch": np.repeat([1.0, 2.0], 2)})
    effects = {"free-shift": True, "inertia": False}
    model = SimpleNamespace(
        name="made",
        material=None,
        needs=frozenset(),
        names=["k", "c", "free-shift.a_1", "inertia.m"],
        bases={},
        named_effects=lambda: [
            (SimpleNamespace(by_levels=by), name) for name, by in effects.items()
        ],
        owning=lambda names, column: (names, column),
    )
    found, _ = constraints.owning(model, [data], {"*": "batch"}, share)
    assert found == (own, "batch")


def test_a_free_spectrum_takes_no_value_of_its_lines_and_effects_around_it_do():
    model = parse_model("material + inertia")
    name = model.names[-1]
    assert constraints.own_value(model, DATA.units, name, 2.0) > 0.0
    for line in ("K_e", "c"):
        with pytest.raises(ModelError, match=f"{line} of a free spectrum goes with its lines"):
            constraints.own_value(model, DATA.units, line, 2.0)
    # Another model's parameter of that name is one.
    assert constraints.own_value(parse_model("kelvin"), DATA.units, "c", 2.0) > 0.0
