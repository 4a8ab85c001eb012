"""Small rules of commands that run fits, by hand: nothing is fitted."""

from __future__ import annotations

import io
import os
from contextlib import suppress
from types import SimpleNamespace

import click
import pytest

from springpot import api, registry
from springpot.cli import CtrlC, common, compare, diagnose, group, identify, listing, timetests
from springpot.errors import DataError
from springpot.measurement import Loading, TimeTest


class Shown:
    """What is shown while one waits, of which a test notes the words."""

    def __init__(self, words):
        self.words = words

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def told(self, word):
        self.words.append(word)


@pytest.mark.parametrize("optimiser", [None, "pso-paper"])
def test_nothing_moves_on_the_terminal_while_an_optimiser_runs_in_a_copy(optimiser, monkeypatch):
    words = []
    monkeypatch.setattr(identify, "Waiting", lambda: Shown(words))
    monkeypatch.setattr(api, "identify", lambda *_, **__: SimpleNamespace(standing=None))
    tests, model = [SimpleNamespace(name="a")], SimpleNamespace(name="maxwell")
    identify._fitted(tests, model, {"optimiser": optimiser})
    fitting = ["fitting maxwell to a"] * (optimiser is None)
    assert words == [*fitting, "judging maxwell of a"]


@pytest.mark.parametrize(
    ("standing", "figure", "data", "sweep", "lines"),
    [
        (None, None, "a", None, ["told"]),
        (None, "fit.svg", "a", None, ["told", "figure      fit.svg"]),
        (True, None, "a", None, ["told"]),
        (False, None, "a", "a", ["told", "", "next: springpot diagnose a --model maxwell"]),
        (False, None, "ab", None, ["told", "", "next: springpot diagnose a b --model maxwell"]),
        (False, None, "ab", "ab", ["told"]),
    ],
)
def test_a_fit_that_is_not_good_enough_is_followed_by_what_comes_next(
    standing, figure, data, sweep, lines, monkeypatch, capsys
):
    from springpot.report import told

    monkeypatch.setattr(told, "told", lambda fit, width, verbose: "told")
    rated = None if standing is None else SimpleNamespace(good_enough=standing)
    identify._show(SimpleNamespace(standing=rated, sweep=sweep), data, "maxwell", figure, False)
    assert capsys.readouterr().out.splitlines() == lines


def test_an_answer_is_written_at_once():
    class Noted(io.StringIO):
        flushed = 0

        def flush(self):
            self.flushed += 1

    stream = Noted()
    with click.Context(click.Command("any")) as context:
        context.meta[common.OUTPUT] = stream
        common.print_json({"a": 1})
        assert (stream.getvalue(), stream.flushed) == ('{\n  "a": 1\n}\n', 1)
        common.print_json({"a": 1}, line=True)
    assert stream.getvalue().splitlines()[3].replace(" ", "") == '{"a":1}'


@pytest.mark.parametrize(
    ("named", "right_way", "turns", "line"),
    [
        (["a"], ["a"], False, "springpot compare a"),
        (["a", "b"], ["a", "b"], False, ""),
        (["a", "b"], ["a", "b?force=-N"], True, "springpot diagnose a 'b?force=-N'"),
        (["a"], ["a?force=-N"], False, "springpot compare a"),
    ],
)
def test_where_any_material_is_adequate_models_are_compared(named, right_way, turns, line):
    """Of any kind of test; a ranking is of one file."""
    answer = SimpleNamespace(one_test="", offered="", verdict="adequate", turns=turns, left_out={})
    assert diagnose._next_command(answer, named, None, right_way) == line


@pytest.mark.parametrize(
    ("model", "named", "left_out", "line"),
    [
        (None, ["a"], {}, "springpot discover a --accept slack"),
        (None, ["a"], {"slack": "name a model"}, "springpot compare a"),
        (None, ["a", "b"], {"slack": "name a model"}, "springpot discover a b --accept slack"),
        ("zener", ["a"], {}, "springpot discover a --model zener --accept slack"),
    ],
)
def test_what_no_material_can_be_fitted_with_is_not_accepted_beside_it(
    model, named, left_out, line
):
    """Its acceptance would end in an error that asks for a model: one is found first."""
    answer = SimpleNamespace(one_test="", offered="slack", turns=False, left_out=left_out)
    answer.verdict = "effect-missing"
    assert diagnose._next_command(answer, named, model, named) == line


@pytest.mark.parametrize(
    ("adequate", "near", "verb"),
    [
        (["best"], [], "identify swept --model kelvin"),
        ([], ["best"], "diagnose swept"),
        ([], [], "diagnose swept --model kelvin"),
    ],
)
def test_of_an_adequate_model_the_parameters_are_next_of_another_what_it_lacks(
    monkeypatch, adequate, near, verb
):
    monkeypatch.setattr("springpot.comparison.result.Ranking", SimpleNamespace)
    best = SimpleNamespace(fails=False, unclear=False, model=SimpleNamespace(name="kelvin"))
    ranked = SimpleNamespace(one_test="", best=best, adequate=adequate, near=near)
    assert compare._next_command(ranked, "swept", []) == f"springpot {verb}"


def test_whoever_pressed_ctrl_c_is_remembered():
    pressed = CtrlC()
    with pytest.raises(KeyboardInterrupt):
        pressed(2, None)
    assert pressed.pressed


@pytest.mark.parametrize("quiet", [False, True])
def test_what_foreign_code_prints_goes_elsewhere_and_only_that(capfd, quiet):
    print("before")
    with common.own_stdout(quiet):
        if quiet:
            print("foreign")
        os.write(1, b"compiled\n")
        os.write(2, b"told\n")
    print("after")
    os.write(1, b"again\n")
    told = capfd.readouterr()
    assert sorted(told.out.split()) == ["after", "again", "before"]
    assert sorted(told.err.split()) == (["told"] if quiet else ["compiled", "told"])


@pytest.mark.parametrize("temperature", [None, 30.0])
def test_a_test_is_predicted_at_the_temperature_that_is_asked_for(temperature, monkeypatch):
    """That which the file has from sample to sample would go before it."""
    warm = TimeTest([1.0, 2.0], [1.0, 1.0], Loading.step(), "force", "-", "Pa", warmth=[20.0, 21.0])
    monkeypatch.setattr(registry, "open_in_time", lambda spec: (warm,))
    monkeypatch.setattr(timetests, "seen_through", lambda test, geometry: test)
    found = timetests._asked("planned.csv", temperature, None)
    assert (found is warm) is (temperature is None)
    assert (found.temperature, found.warmth is None) == (
        (30.0, True) if temperature else (warm.temperature, False)
    )


@pytest.mark.parametrize(("count", "line"), [(1, False), (2, True)])
def test_of_several_data_each_answer_is_a_line(count, line, monkeypatch):
    asked = []
    monkeypatch.setattr(diagnose, "opened", lambda name, geometry: name)
    monkeypatch.setattr(diagnose.timetests, "named_tests", lambda data, geometry: None)

    def answered(data, given, shown):
        asked.append(shown.keywords.get("line"))
        return SimpleNamespace(verdict="unexplained")

    monkeypatch.setattr(diagnose, "_answer", answered)
    names = [f"{i}.csv" for i in range(count)]
    group.run(["diagnose", *names, "-m", "kelvin", "--json"])
    assert asked == [line] * count


@pytest.mark.parametrize(
    ("kind", "names", "members"),
    [
        ("optimisers", ["lib"], ["one", "two"]),
        ("optimisers", ["other"], None),
        ("optimisers", ["lib", "lib"], None),
        ("optimisers", [], None),
        ("models", ["lib"], None),
    ],
)
def test_the_name_of_a_library_alone_lists_what_it_has(kind, names, members):
    library = SimpleNamespace(name="lib", members=lambda: {"a": "one", "b": "two"})
    installed = SimpleNamespace(items=lambda word: {"optimiser family": [library]}[word])
    assert listing._members(installed, kind, names) == members


@pytest.mark.parametrize("asked", [None, 3])
@pytest.mark.parametrize("name", ["diagnose", "compare", "discover", "invent"])
def test_whoever_names_no_seed_has_the_seed_nothing(name, asked, monkeypatch):
    seeds = []

    def answer(*given, seed, **more):
        seeds.append(seed)
        raise DataError("enough")

    monkeypatch.setattr(api, name, answer)
    more = [] if asked is None else ["--seed", str(asked)]
    if name == "discover":
        more.append("--auto")
    with suppress(DataError):
        group.run([name, "artificial-hidden", *more])
    assert seeds == [asked or 0]
