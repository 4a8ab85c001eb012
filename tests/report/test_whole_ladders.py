"""What is told of rankings, ladders of several tests and specimens, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from test_whole_report import MODEL, OMEGA, THETA, UNITS, levels, noisy

import springpot
from springpot.identification.result import Value
from springpot.registry import parse_model
from springpot.report import figures as of_populations, fit_text, html, ladder_text
from springpot.report.interactive import answers, scene
from springpot.report.text import as_text

pyplot = pytest.importorskip("matplotlib.pyplot")


def error(rms=0.0123, floor=0.005, material=0.006):
    return SimpleNamespace(
        relative_rms=rms, noise_floor=floor, noise_source="estimated", material_floor=material
    )


def judged(name, bic=0.0, floor=0.005):
    return SimpleNamespace(
        model=parse_model(name), error=error(floor=floor), delta_bic=bic, free_parameters=3,
        parameters={"k": Value(3.0, 2.9, 3.1, "kPa"), "n": Value(0.5, 0.1, 0.9, "-")},
    )  # fmt: skip


def ranked(adequate, near, following, others=0, verdict="adequate", groups=None):
    last = SimpleNamespace(
        model=parse_model("kelvin + inertia + friction"), examined=None, alike=[], accepted=""
    )
    first = SimpleNamespace(
        material_floor=0.02, alike=["inertia", "mounting"], accepted="inertia",
        model=parse_model("kelvin + inertia"), examined=None,
    )  # fmt: skip
    ladder = SimpleNamespace(
        steps=[first, last], verdict=verdict, diagnosis=SimpleNamespace(says="something is missing")
    )
    every = [*adequate, *near, *following]
    return SimpleNamespace(
        data="made", says="in a sentence", best=every[0], ladder=ladder, adequate=adequate,
        near=near, next=following, judgements=every + [None] * others, notes=("a note",),
        groups=groups or [(one,) for one in (*adequate, *near)], handy=None,
    )  # fmt: skip


def test_words_of_a_ranking(stays, monkeypatch):
    monkeypatch.setattr(ladder_text, "accepted_name", lambda step: step.accepted)
    names = ("kelvin + inertia", "maxwell + inertia", "springpot + inertia", "spring")
    same = [judged(name) for name in names]
    many = [judged(f"kelvin-{n}") for n in range(2, 12)]
    cases = {
        "adequate": ranked(same[:1], same[1:2], same[2:3], 1),
        "alike": ranked(same, [], [], groups=[tuple(same)]),
        "near": ranked([], [judged("spring", 12.3456, 0.0)], [], 0, "missing"),
        "many": ranked([], many, [], groups=[tuple(many)]),
    }
    stays(
        {
            name: as_text(ladder_text.ranking_document(case), 140).splitlines()
            for name, case in cases.items()
        }
    )


def step(test="", rms=0.08, tests=()):
    return SimpleNamespace(test=test, relative_rms=rms, tests=tests)


def test_the_fall_of_an_error_is_that_of_the_test_missed_first():
    def fall(*steps):
        return ladder_text._fall(
            SimpleNamespace(steps=steps, diagnosis=SimpleNamespace(error=error()))
        )

    last = [SimpleNamespace(name=n, relative_rms=0.01, noise_floor=0.004) for n in ("a", "b")]
    assert fall(step()) == "error 8.00 % -> 8.00 %, nothing accepted, 16 x floor"
    assert fall(step(), step(rms=0.01)) == "error 8.00 % -> 1.00 %, 2.0 x floor"
    one = "error of a 8.00 % -> 1.00 %, 2.0 x floor"
    assert fall(step("a"), step("a", 0.01)) == one
    other = "error of a 8.00 % -> 1.00 %, 2.5 x floor; of b 3.00 %, 6.0 x floor"
    assert fall(step("a"), step("b", 0.03, last)) == other


def population(groups=None, relative=True):
    return SimpleNamespace(
        mean=Value(3.0, 2.9, 3.1, "kPa"), between=Value(0.05, 0.03, 0.09, "-"), groups=groups,
        relative=relative, limits=None if groups else (2.6, 3.4), compared={},
    )  # fmt: skip


def test_words_of_specimens_and_of_uncertainty(stays, monkeypatch):
    for room in (fit_text, of_populations):
        monkeypatch.setattr(room, "specimens_of", lambda found: range(len(found) * 6))
    batch = Value(0.02, 0.01, 0.05, "-")
    budget = {"k": {"noise": 0.03, "geometry": 0.04}, "c": {"noise": 0.5, "geometry": 1e-18}}
    value = {"k": Value(2.0, 1.9, 2.1, "kPa"), "c": Value(-5.0, -6.0, -4.0, "kPa s")}
    cases = {
        "none": {},
        "flat": {"k": population(), "n": population(relative=False)},
        "nested": {"k": population(batch), "n": population()},
    }
    shown = {}
    for name, populations in cases.items():
        fit = SimpleNamespace(
            populations=populations, budget=budget if populations else {}, parameters=value,
            model=SimpleNamespace(names=("k", "c"), origins=("k", "x")),
        )  # fmt: skip
        parts = [*of_populations.population_passages(fit), fit_text._budget(fit)]
        shown[name] = as_text(parts, 140).splitlines()
        few = fit_text._few(fit)
        shown[f"{name}, listed"] = [few, list(fit_text._listed(fit, False))]
        assert fit_text._listed(fit, True) == value
    stays(shown)


def proposed(**action):
    return SimpleNamespace(action=action, separates=["inertia", "friction", "unknown"])


def test_where_a_proposed_experiment_measures(stays):
    k = MODEL.stiffness(THETA, OMEGA)
    data = levels("amplitude", {0.1: k, 0.3: k, 0.7: k})
    warm = levels("temperature", {0.0: k, 30.0: k, 50.0: k})
    found = [
        scene.proposed_points(action, each)
        for each, action in (
            (data, {"omega": [1.0, 100.0]}),
            (data, {"omega": [1.0, 100.0, 1.0], "amplitude": [0.2, 0.4, 0.6]}),
            (warm, {"omega": [1.0, 100.0], "temperature": [25.0]}),
        )
    ]
    stays([[at.log_omega, at.amplitude, at.temperature, *at.columns.values()] for at in found])
    along = answers._along(found[0], {"omega": [1.0]})
    assert along.log_omega[[0, -1]] == pytest.approx([0.0, np.log(100.0)])
    assert len(along.log_omega) == answers.DRAWN.rival
    assert answers._along(found[1], {"omega": [], "amplitude": []}) is found[1]


@pytest.mark.parametrize(
    "action", [{"omega": [1.0, 9.0]}, {"omega": [1.0], "mass": [2.0]}, {"omega": []}, None]
)
def test_rivals_are_drawn_where_the_experiment_tells_them_apart(action, monkeypatch, stays):
    data = levels("amplitude", dict.fromkeys((0.1, 0.2, 0.3), MODEL.stiffness(THETA, OMEGA)))
    models = {name: parse_model(f"kelvin + {name}") for name in ("inertia", "friction")}
    grown = {
        name: answers.Preview(name, model, model.theta(**dict.fromkeys(model.names, 2.0)), True)
        for name, model in models.items()
    }
    advice = None if action is None else proposed(**action)
    case = SimpleNamespace(diagnosis=SimpleNamespace(next_experiment=advice, error=error()))
    last = SimpleNamespace(case=case)
    monkeypatch.setattr(answers, "grown_by_each", lambda case, names: list(grown.values())[:1])
    ladders = (
        SimpleNamespace(undecided=last, steps=[last]),
        SimpleNamespace(undecided=last, steps=[last, None]),
    )
    found = [answers._next(ladder, grown, data) for ladder in ladders]
    assert (found[0] is None) is (action in (None, {"omega": []}))
    stays(found)


def test_what_can_be_done_with_an_answer(monkeypatch):
    k = noisy(MODEL.stiffness(THETA, OMEGA), 1)
    data = springpot.Measurement(OMEGA, k, units=UNITS)
    base = SimpleNamespace(model=MODEL, theta=THETA, data=data, noise=None)
    for exclude, words in (((3,), "row 3"), ((3, 5), "rows 3, 5")):
        steps = [
            SimpleNamespace(split="", exclude=(row,), turns="", says="it stands out")
            for row in exclude
        ]
        diagnosis = SimpleNamespace(steps=steps)
        (act,) = answers.acted(SimpleNamespace(base=base, tests=[data], diagnosis=diagnosis))
        assert act.name == f"without {words}"
        assert act.exclude == tuple(row - 1 for row in exclude)
        (used,) = act.used
        assert len(used) == len(data) - len(exclude)
        assert ("stands out" in act.says) is (len(exclude) == 1)


def page_ladder(verdict, steps, classes=(), advice=None):
    return SimpleNamespace(
        verdict=verdict, steps=steps,
        diagnosis=SimpleNamespace(classes=classes, next_experiment=advice),
    )  # fmt: skip


def test_what_is_open_on_the_page(monkeypatch, stays):
    monkeypatch.setattr(html, "accepted_name", lambda step: step.accepted)
    first = SimpleNamespace(alike=[], accepted="")
    sure = SimpleNamespace(alike=["inertia"], accepted="inertia")
    unsure = SimpleNamespace(alike=["inertia", "mounting", "gain"], accepted="inertia")
    ladders = [
        page_ladder("adequate", [first, sure]),
        page_ladder("adequate", [first, unsure], [["x", "y"]]),
        page_ladder("missing", [first, sure], [["x", "y"], ["z"]]),
        page_ladder("missing", [first, unsure], [["x", "y"]]),
    ]
    stays([[str(part) for part in html._classes(ladder)] for ladder in ladders])


@pytest.mark.parametrize("foretold", [0.0005, 0.9, None, np.inf])
def test_no_mark_of_a_ladder_lies_beyond_its_axes(foretold):
    def rung(name, rms, predicted):
        return SimpleNamespace(
            model=parse_model(name), accepted=None, relative_rms=rms, predicted_error=predicted,
            noise_floor=0.01, material_floor=0.02,
        )  # fmt: skip

    steps = (rung("kelvin", 0.05, None), rung("kelvin + inertia", 0.01, foretold))
    axes = pyplot.figure().subplots()
    ladder_text.draw_ladder(axes, SimpleNamespace(steps=steps))
    low, high = axes.get_ylim()
    marks = np.concatenate([np.ravel(line.get_ydata()) for line in axes.lines])
    pyplot.close()
    told = marks[np.isfinite(marks)]
    assert low < told.min()
    assert told.max() < high
