"""A fit in a user's hands: printed parameters, residuals, predictions, pictures, files, pickles."""

from __future__ import annotations

import copy
import json
import pickle

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError, OptionError, OutputError, SpringpotError
from springpot.identification import Identification
from springpot.registry import plugins
from springpot.report.text import percent, to_json
from springpot.rheology.model import Family

pytestmark = pytest.mark.usefixtures("asked_once")

MODEL = "fractional-maxwell + inertia + time-delay"
TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5, "inertia.m": 0.6, "time-delay.tau": 4e-4}


@pytest.fixture(scope="module")
def fit() -> Identification:
    return springpot.identify("artificial-hidden", MODEL)


@pytest.fixture(scope="module")
def warm() -> Identification:
    return springpot.identify("nist-srm2491", "fractional-maxwell + wlf-shift")


def test_parameters_come_as_they_are_printed(fit: Identification):
    assert fit["inertia.m"].unit == "kg"
    assert fit.theta[3] == pytest.approx(
        fit["inertia.m"].value / 1000.0
    )  # kN/m data hold a mass in Mg
    for name, truth in TRUTH.items():
        value = fit.parameters[name]
        assert value.low < value.value < value.high
        assert value.value == pytest.approx(truth, rel=0.02)
    with pytest.raises(ModelError, match="no parameter 'mass': it has k, c"):
        fit["mass"]


def test_covariance_is_in_the_same_units(fit: Identification):
    sd = np.sqrt(np.diag(fit.covariance))
    for name, one in zip(fit.model.names, sd, strict=True):
        value = fit[name]
        assert one == pytest.approx(
            (value.high - value.low) / 2.0 / fit.uncertainty.quantile, rel=0.03
        )


def test_residuals_and_floor_explain_the_error(fit: Identification):
    data = fit.measurement
    assert np.allclose(fit.predict().stiffness + fit.residuals, data.stiffness)
    assert fit.noise_floor == pytest.approx(fit.relative_rms, rel=0.1)
    assert fit.standing is not None
    assert fit.standing.good_enough
    assert f"noise floor of {percent(fit.noise_floor, 2)}" in fit._repr_html_()


def test_a_prediction_is_the_model_with_a_band_that_holds_the_truth(fit: Identification):
    frequency = np.array([0.7, 5.0, 60.0])
    found = fit.predict(frequency=frequency)
    exact = fit.model.stiffness(np.array([400.0, 60.0, 0.5, 0.6e-3, 4e-4]), 2.0 * np.pi * frequency)
    for part, low, high, truth in (
        (found.storage, found.low.real, found.high.real, exact.real),
        (found.loss, found.low.imag, found.high.imag, exact.imag),
    ):
        assert np.all((low < part) & (part < high))
        # Two bands wide: each holds the truth in 95 of 100 fits only.
        assert np.all(np.abs(part - truth) < high - low)
    same = fit.predict(omega=2.0 * np.pi * frequency)
    assert np.array_equal(same.stiffness, found.stiffness)
    wider = fit.predict(frequency=frequency, level=0.99)
    assert np.all(wider.high.real > found.high.real)


@pytest.mark.soak
def test_the_band_is_the_scatter_of_fits_to_new_noise(rng: np.random.Generator):
    omega = 2.0 * np.pi * np.geomspace(0.5, 50.0, 20)
    model = springpot.parse_model("fractional-maxwell")
    exact = model.stiffness(model.theta(k=400.0, c=60.0, alpha=0.5), omega)
    predicted, widths = [], []
    for _ in range(40):
        noise = 0.02 * np.abs(exact) * (rng.normal(size=20) + 1j * rng.normal(size=20))
        found = springpot.identify(springpot.Measurement(omega, exact + noise), model).predict(
            100.0
        )
        predicted.append(found.storage[0])
        widths.append(found.high.real[0] - found.low.real[0])
    # 1.99 standard deviations either way at 37 degrees of freedom; of 40 draws the scatter is known
    # to 11 %.
    assert np.mean(widths) / (2 * 2.03) == pytest.approx(np.std(predicted, ddof=1), rel=0.35)


@pytest.mark.parametrize(
    ("expression", "at_rest"),
    [("fractional-kelvin", "k"), ("fractional-zener", "k1"), ("fractional-maxwell", None)],
)
def test_at_rest_only_springs_carry(expression: str, at_rest: str | None):
    omega = np.geomspace(0.1, 100.0, 20)
    model = springpot.parse_model(expression)
    own = {"k": 100.0, "k1": 100.0, "k2": 300.0, "c": 60.0, "alpha": 0.4}
    data = springpot.Measurement(
        omega, model.stiffness(model.vector({n: own[n] for n in model.names}), omega)
    )
    [value] = springpot.identify(data, model).predict(frequency=0.0).stiffness
    assert value == pytest.approx(0.0 if at_rest is None else own[at_rest], rel=1e-6)


def test_constants_of_a_shift_refer_to_the_fit_not_to_the_prediction(warm: Identification):
    measured = warm.measurement
    rows = measured.conditions["temperature"] == 50.0
    found = warm.predict(omega=measured.omega[rows], temperature=50.0)
    assert np.allclose(found.stiffness, (measured.stiffness - warm.residuals)[rows])
    assert found.conditions["temperature"].tolist() == [50.0] * int(rows.sum())


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"frequency": 1.0, "omega": 2.0}, "not both"),
        ({"frequency": [-1.0]}, "not negative"),
        ({"frequency": "fast"}, "numbers"),
        ({"frequency": 1.0, "temperature": 20.0}, "does not know temperature"),
        ({"frequency": [1.0, 2.0], "water": [1.0, 2.0, 3.0]}, "does not know water"),
    ],
)
def test_the_wrong_question_is_refused(fit: Identification, asked: dict[str, object], says: str):
    with pytest.raises(SpringpotError, match=says):
        fit.predict(**asked)


@pytest.mark.parametrize(
    ("temperature", "says"),
    [(293.15, "looks like kelvin"), (-300.0, "absolute zero"), (None, "say temperature=")],
)
def test_temperatures_are_in_celsius_and_are_not_guessed(
    warm: Identification, temperature: float, says: str
):
    with pytest.raises(DataError, match=says):
        warm.predict(frequency=1.0, temperature=temperature)


@pytest.mark.soak
def test_what_the_data_do_not_determine_is_called_so(rng: np.random.Generator):
    omega = np.geomspace(1.0, 10.0, 12)
    spring = 100.0 * (1.0 + 0.01 * (rng.normal(size=12) + 1j * rng.normal(size=12)))
    found = springpot.identify(springpot.Measurement(omega, spring), "maxwell-2")
    assert not all(value.determined for value in found.parameters.values())
    assert "determined" in found._repr_html_()
    assert found.predict(omega=3.0).storage[0] == pytest.approx(100.0, rel=0.02)


def test_a_prediction_beyond_the_data_says_so(fit: Identification):
    assert fit.predict(frequency=[1.0, 10.0]).notes == ()
    assert "beyond the measured 0.5 to 100 Hz" in fit.predict(frequency=500.0).notes[0]


@pytest.mark.soak
def test_all_that_can_be_drawn_is_drawn_alone_and_on_given_axes(fit: Identification, tmp_path):
    figure = pytest.importorskip("matplotlib.figure").Figure
    compared = springpot.compare("artificial-hidden", "fractional-maxwell")
    for thing in (fit.measurement, fit, fit.predict([1.0, 10.0]), compared):
        axes = figure().subplots()
        assert thing.plot(ax=axes) is axes
        assert axes.lines
        assert axes.get_legend() is not None
        assert thing.plot(tmp_path / "picture.svg").stat().st_size > 1000
        with pytest.raises(OutputError, match="not both"):
            thing.plot("x.png", ax=axes)
    assert fit.plot()._repr_png_().startswith(b"\x89PNG")


def test_print_is_the_text_of_the_command_line(fit: Identification, capsys):
    from springpot.cli.group import run

    run(["identify", "artificial-hidden", "--model", MODEL])
    assert str(fit) == capsys.readouterr().out.rstrip("\n")
    assert "\n" not in repr(fit)


def test_results_survive_pickle_and_copy(fit: Identification):
    diagnosis = springpot.diagnose("artificial-hidden", "fractional-maxwell", only=["inertia"])
    for again in (pickle.loads(pickle.dumps(fit)), copy.deepcopy(fit), copy.copy(fit)):
        assert again.to_dict() == fit.to_dict()
        assert np.array_equal(again.predict(3.0).low, fit.predict(3.0).low)
    # As text: an error that is not known is nan, which equals nothing.
    assert repr(pickle.loads(pickle.dumps(diagnosis)).to_dict()) == repr(diagnosis.to_dict())
    for model in plugins().items("model"):
        if not isinstance(model, Family):
            assert pickle.loads(pickle.dumps(model)).names == model.names


# What a user knows beforehand.


def test_what_is_held_leaves_the_fit_and_stays_in_the_answer():
    found = springpot.identify("artificial-hidden", MODEL, fix={"alpha": 0.5, "inertia.m": 0.6})
    assert found.model.names == ("k", "c", "time-delay.tau")
    assert list(found.parameters) == list(TRUTH)
    assert (found["inertia.m"].value, found["inertia.m"].unit, found["inertia.m"].fixed) == (
        0.6,
        "kg",
        True,
    )
    assert found["c"].unit == "kN s^0.5/m"
    free = springpot.identify("artificial-hidden", MODEL)
    assert found.fit.cost >= free.fit.cost
    assert found.fit.dof == free.fit.dof + 2
    assert found["k"].high - found["k"].low < free["k"].high - free["k"].low


def test_a_bound_holds_and_is_named_where_the_fit_rests_on_it():
    found = springpot.identify("artificial-hidden", MODEL, bounds={"k": (0.0, 200.0)})
    assert found["k"].value == pytest.approx(200.0)
    assert "k rests on its bound 200 kN/m" in found.notes[0]
    inside = springpot.identify("artificial-hidden", MODEL, bounds={"k": (300.0, 500.0)})
    free = springpot.identify("artificial-hidden", MODEL)
    assert inside["k"].value == pytest.approx(free["k"].value, rel=1e-6)
    assert inside["k"].low == pytest.approx(free["k"].low, rel=1e-3)


def test_held_stiffnesses_are_found_to_be_right():
    found = springpot.identify("artificial-hidden", MODEL, fix={"k": 400.0, "c": 60.0})
    for name in ("alpha", "inertia.m", "time-delay.tau"):
        assert found[name].value == pytest.approx(TRUTH[name], rel=0.03)


def test_a_start_leads_to_the_optimum_that_it_is_near():
    model = springpot.parse_model("maxwell-2")
    omega = np.geomspace(0.01, 100.0, 25)
    data = springpot.Measurement(omega, model.stiffness(np.array([100.0, 0.1, 50.0, 10.0]), omega))
    found = springpot.identify(data, model, start={"tau1": 9.0, "tau2": 0.11})
    assert found.fit.cost < 1e-15
    with pytest.raises(OptionError, match="draws its own starts"):
        springpot.identify(data, model, optimiser="cma-es", start={"tau1": 9.0})


@pytest.mark.soak
def test_diagnosis_and_discovery_know_what_is_held_and_left_out():
    known = {"fix": {"alpha": 0.5}, "exclude": "frequency=..0.6"}
    ladder = springpot.discover(
        "artificial-hidden", "fractional-maxwell", accept="inertia", **known
    )
    assert ladder.model.held == {"alpha": 0.5}
    assert "alpha" not in ladder.model.names
    assert len(ladder.steps[0].case.search.base.data.raw) < len(springpot.read("artificial-hidden"))
    assert "alpha" not in ladder.steps[-1].parameters


@pytest.mark.parametrize(
    ("known", "says"),
    [
        ({"fix": {"beta": 1.0}}, "no free parameter 'beta'"),
        ({"fix": {"alpha": 1.5}}, "cannot be 1.5"),
        ({"fix": {"alpha": 0.5}, "bounds": {"alpha": (0.0, 1.0)}}, "not both"),
        ({"bounds": {"k": (5.0, 1.0)}}, "no room between 5 and 1"),
        ({"fix": {"k": 1.0, "c": 1.0, "alpha": 0.5}}, "nothing is left"),
        ({"exclude": "frequency=0.."}, "nothing would be left"),
        ({"exclude": "frequency"}, "write conditions as"),
        ({"optimiser": "pso-paper:partcles=4"}, "no option 'partcles': it has particles"),
        ({"optimiser": "pso-paper:particles=many"}, "particles is a number such as 20"),
        ({"objective": "weighted"}, "no standard deviations to weigh by"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(known: dict[str, object], says: str):
    with pytest.raises(SpringpotError, match=says) as caught:
        springpot.identify("artificial-hidden", "fractional-maxwell", **known)
    assert "\n" not in str(caught.value)


# Files.


@pytest.mark.soak
def test_every_answer_is_loaded_as_it_was_written(fit: Identification, tmp_path):
    path = tmp_path / "answer.json"
    ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept="inertia")
    for answer in (
        fit,
        springpot.identify(
            "artificial-hidden", MODEL, fix={"alpha": 0.5}, bounds={"k": (0.0, 390.0)}
        ),
        springpot.identify("nist-srm2491@temperature=20", "fractional-zener"),
        springpot.identify("artificial-hidden", "material + inertia"),
        ladder.diagnosis,
        ladder,
        springpot.compare("artificial-hidden", "fractional-maxwell"),
    ):
        path.write_text(to_json(answer), encoding="utf-8")
        again = springpot.load(path)
        assert to_json(again) == to_json(answer)
        if isinstance(answer, Identification):
            assert isinstance(again, Identification)
            assert np.array_equal(again.predict(3.0).low, answer.predict(3.0).low)
            assert np.array_equal(again.residuals, answer.residuals)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("nothing", "is no JSON"),
        ("[1, 2]", "no schema"),
        ('{"schema": "springpot.run/1"}', "springpot.run/1"),
        (
            '{"schema": "springpot.identification/2", "model": "zener"}',
            "damaged or of an older version",
        ),
        ("[" * 100_000, "is no JSON"),
    ],
)
def test_what_cannot_be_loaded_is_told_in_one_line(tmp_path, text: str, says: str):
    path = tmp_path / "answer.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=says):
        springpot.load(path)
    # A table of an old spreadsheet in its place.
    path.write_bytes("Prüfbericht;Temperatur [°C]".encode("cp1252"))
    with pytest.raises(DataError, match=r"is no JSON \(.*\): give the output of a command"):
        springpot.load(path)
    with pytest.raises(DataError, match="cannot be read"):
        springpot.load(tmp_path / "none.json")


def test_numbers_of_a_list_stand_in_one_line():
    text = to_json(
        {"words": ["a\n[\n1\n]", "b"], "numbers": [1.0, None, -2e-7], "rows": [[1, 2], [3, 4]]}
    )
    assert json.loads(text) == {
        "words": ["a\n[\n1\n]", "b"],
        "numbers": [1.0, None, -2e-7],
        "rows": [[1, 2], [3, 4]],
    }
    assert '"numbers": [1.0, null, -2e-07]' in text
