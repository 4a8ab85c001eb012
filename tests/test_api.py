"""Python users may give names where objects are meant, and one thing where a list is meant."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot import api, timetests
from springpot.diagnosis.in_practice import Accuracy
from springpot.errors import SpringpotError
from springpot.measurement import PROMISED, TimeTest

pytestmark = pytest.mark.usefixtures("asked_once")

DATA, MODEL = "artificial-hidden", "fractional-maxwell"


@pytest.mark.soak
def test_data_by_name_and_as_an_object_are_the_same():
    measured = springpot.read(DATA)
    assert (
        springpot.diagnose(DATA, MODEL).to_dict() == springpot.diagnose(measured, MODEL).to_dict()
    )
    assert np.array_equal(
        springpot.identify(DATA, MODEL).theta, springpot.identify(measured, MODEL).theta
    )


@pytest.mark.usefixtures("asked_once")
def test_one_model_and_one_effect_need_no_list():
    [judged] = springpot.compare(DATA, MODEL).judgements
    assert judged.model.name == MODEL
    ladder = springpot.discover(DATA, springpot.parse_model(MODEL), accept="inertia")
    assert [step.accepted for step in ladder.steps] == [None, "inertia"]


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: springpot.identify("no-such-data", MODEL), "no-such-data"),
        (lambda: springpot.diagnose(DATA, "fractional-maxwel"), "did you mean"),
        (lambda: springpot.identify(DATA, MODEL, optimiser="cmaes"), "cma-es"),
        (lambda: springpot.identify(DATA, MODEL, intervals="bootstrp"), "bootstrap"),
        (lambda: springpot.parse_model("inertia"), "is an effect"),
        (lambda: springpot.parse_model(MODEL) + 3, "an Effect or its name"),
        (
            lambda: springpot.discover(DATA, MODEL, accept=["inertia", "inertia"]),
            "'inertia' already",
        ),
        (
            lambda: springpot.discover(DATA, f"{MODEL} + inertia", accept="inertia"),
            "'inertia' already",
        ),
        (
            lambda: springpot.identify(DATA, MODEL, start="k=1"),
            r'start is a dictionary .* \{"k": 100.0\}, not \'k=1\'',
        ),
        (lambda: springpot.identify(DATA, MODEL, fix=["alpha=0.5"]), "fix is a dictionary"),
        (
            lambda: springpot.identify(DATA, MODEL, fix={"alpha": "half"}),
            "alpha is a number in -, not 'half'",
        ),
        (
            lambda: springpot.diagnose(DATA, MODEL, bounds={"k": 5}),
            r"bounds of k are a lower and an upper end",
        ),
        (
            lambda: springpot.identify(DATA, MODEL, bounds={"k": "0:200"}),
            "such as \\(0, 200\\), not '0:200'",
        ),
        (lambda: springpot.diagnose(DATA, 3), r"'fractional-maxwell', not 3 \(int\)"),
        (lambda: springpot.diagnose(3, MODEL), r"a path or a name, not 3 \(int\)"),
        (lambda: springpot.discover(DATA, MODEL, accept=3), r"its name, not 3 \(int\)"),
        (lambda: springpot.compare(DATA, [MODEL, None]), "not None"),
    ],
)
def test_a_misspelt_name_is_an_error_that_helps(call, word):
    with pytest.raises(SpringpotError, match=word):
        call()


def test_results_show_themselves_in_one_line_and_as_a_table():
    data = springpot.read("nist-srm2491@temperature=20")
    found = springpot.identify(data, "maxwell-2")
    assert repr(data).startswith(
        "<Measurement nist-srm2491@temperature=20: 16 points, 0.1 to 100 rad/s, temp"
    )
    assert repr(found.model) == "<Model maxwell-2: k1, tau1, k2, tau2>"
    assert repr(found).startswith("<Identification maxwell-2 of nist-srm2491@temperature=20: k1 ")
    assert "\n" not in repr(found)
    assert found._repr_html_().count("<tr>") == 10


@pytest.mark.soak
@pytest.mark.usefixtures("asked_once")
def test_no_model_need_be_named():
    assert springpot.diagnose("nist-srm2491@temperature=20").model.name == "material"
    ladder = springpot.discover(DATA, accept="inertia")
    assert ladder.steps[0].case.diagnosis.best.effect == "inertia"
    assert ladder.model.name == "material + inertia"


def test_a_test_in_time_is_read_fitted_judged_and_compared_as_a_sweep_is(tmp_path):
    model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.02, 50.0, 60)
    exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), t)
    noisy = exact * (1.0 + 0.01 * np.random.default_rng(1).normal(size=len(t)))
    path = tmp_path / "relax.csv"
    np.savetxt(
        path, np.column_stack([t, noisy]), delimiter=",", header="time [s],relaxation [kPa]",
        comments="",
    )  # fmt: skip
    test = springpot.read(path)
    assert isinstance(test, springpot.TimeTest)
    fit = springpot.identify(path, "fractional-maxwell", fix={"alpha": 0.5}, exclude="time=..0.03")
    assert fit.model.held == {"alpha": 0.5}
    omega = np.geomspace(0.1, 30.0, 20)
    sweep = springpot.Measurement(
        omega, model.stiffness([400.0, 60.0, 0.5], omega), units=springpot.Units("kPa")
    )
    both = springpot.identify([sweep, test], "fractional-maxwell")
    assert [one.kind for one in both.tests] == ["sweep", "relaxation"]
    assert (
        springpot.diagnose(test, "fractional-maxwell", only=["force-drift"]).verdict == "adequate"
    )
    few = ["series-spring", "force-drift"]
    ladder = springpot.discover(test, "fractional-kelvin", accept=few[0], only=few)
    assert ladder.model.name == "fractional-kelvin + series-spring"
    compared = springpot.compare(test, ["maxwell", "fractional-maxwell"])
    assert compared.best.model.name == "fractional-maxwell"


@pytest.mark.soak
def test_another_test_of_any_kind_is_predicted_from_a_fit(tmp_path):
    import json

    model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.02, 50.0, 60)
    theta = model.theta(k=400.0, c=60.0, alpha=0.5)
    noise = 1.0 + 0.01 * np.random.default_rng(1).normal(size=len(t))
    relaxed = springpot.TimeTest.of_relaxation(t, noise * model.relaxation(theta, t), "kPa")
    omega = np.geomspace(0.1, 30.0, 20)
    sweep = springpot.Measurement(
        omega, model.stiffness(theta, omega), units=springpot.Units("kPa")
    )
    fit = springpot.identify(relaxed, model)
    predicted = springpot.predict(fit, sweep)
    assert predicted.holds
    wider = springpot.predict(fit, sweep, level=0.99)
    assert np.all(wider.high - wider.low > predicted.high - predicted.low)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    assert springpot.predict(springpot.load(path), sweep).value == pytest.approx(predicted.value)
    assert springpot.predict(springpot.identify(sweep, model), relaxed).kind == "relaxation"
    assert predicted.plot(tmp_path / "predicted.png").stat().st_size > 10_000
    with pytest.raises(SpringpotError, match="is no fit"):
        springpot.predict(springpot.diagnose(relaxed, model), sweep)


def test_of_tests_in_time_named_models_are_compared_and_all_that_are_installed_ranked(monkeypatch):
    compared, ranked = [], []
    monkeypatch.setattr(
        timetests, "compare", lambda tests, models, progress: compared.append(models)
    )
    monkeypatch.setattr(
        timetests, "rank", lambda tests, models, library, progress: ranked.append(models)
    )
    relaxation = TimeTest.of_relaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.0], "MPa")
    springpot.compare(relaxation, [MODEL])
    springpot.compare(relaxation)
    [[named]], [every] = compared, ranked
    assert named.name == MODEL
    assert {MODEL, "prony-N"} <= {model.name for model in every}


@pytest.mark.parametrize(
    ("given", "told", "promised"),
    [
        (None, ["2%,5mrad"], Accuracy(0.02, 0.005)),
        (None, ["2%,5mrad", "2%,5mrad"], Accuracy(0.02, 0.005)),
        # Of several instruments none speaks for the others.
        (None, ["2%,5mrad", "1%"], None),
        (None, ["2%,5mrad", ""], None),
        (None, [""], None),
        ("1%,3mrad", ["2%,5mrad"], Accuracy(0.01, 0.003)),
        (Accuracy(0.01, 0.003), ["2%,5mrad"], Accuracy(0.01, 0.003)),
    ],
)
def test_an_instrument_promises_what_the_user_says_or_else_all_of_the_data(given, told, promised):
    tests = [SimpleNamespace(provenance={PROMISED: each} if each else {}) for each in told]
    assert api._promised(given, tests) == promised


def test_every_name_that_a_room_offers_is_there():
    rooms = [m.name for m in walk_packages(springpot.__path__, "springpot.") if m.ispkg]
    assert len(rooms) > 10
    for room in (springpot, *map(import_module, rooms)):
        for name in dir(room):
            assert getattr(room, name, None) is not None or name in vars(room), (room, name)
