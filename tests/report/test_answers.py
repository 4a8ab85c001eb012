"""Answers in words: where a model fails, errors beside the floor, and how far parameters moved."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.diagnosis import Ladder
from springpot.diagnosis.result import AsTold
from springpot.measurement import Measurement, Units
from springpot.report import answers
from springpot.report.answers import beside_floor, reference_note, worth_showing
from springpot.report.html import report_html
from springpot.report.ladder_text import change, changes_text
from springpot.report.residuals import set_aside
from springpot.report.text import percent, to_json
from springpot.report.told import told as text_of
from springpot.writing import number

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.usefixtures("unpainted")

OMEGA = 2.0 * np.pi * np.geomspace(0.1, 100.0, 45)


def damper(form=lambda f: 1.0, name="damper", noise=0.005):
    """A fractional Maxwell damper times a `form` of the frequency."""
    s = (1j * OMEGA) ** 0.55 * 60.0
    scatter = np.random.default_rng(7).normal(size=(2, len(OMEGA)))
    exact = 400.0 * s / (400.0 + s) * form(OMEGA / 2.0 / np.pi)
    values = exact * (1.0 + noise * (scatter[0] + 1j * scatter[1]))
    return Measurement(OMEGA, values, units=Units("kN/m", "mm"), name=name)


def page_of(data):
    ladder = springpot.discover(data, "fractional-maxwell")
    return ladder, report_html(ladder, data, ["x"])


def places_of(page):
    """The section on where the model fails."""
    return page.partition("Where the model fails")[2].partition("<h2>")[0]


@pytest.mark.soak_cases("notch", "ripple")
@pytest.mark.parametrize(
    ("form", "words"),
    [
        (lambda f: 1.0 + 0.04 * np.sin(6.0 * np.pi * np.log10(f)), "the misfit swings by about"),
        (
            lambda f: 1.0 - 0.25 * np.exp(-((np.log(f / 12.0) / 0.12) ** 2)),
            "a single point at 11.1 Hz",
        ),
    ],
    ids=["ripple", "notch"],
)
def test_the_report_names_every_place_that_the_diagnosis_names(form, words):
    ladder, page = page_of(damper(form))
    # A notch may look like a narrow resonance, and is told as that or another narrow feature.
    assert ladder.verdict in ("unexplained", "effect-missing")
    assert words in places_of(page)
    assert "noise" not in places_of(page)
    # What the figures leave to no model is drawn nevertheless.
    assert ("Open diamonds" in page) is any(
        place.condition == "single point" for place in ladder.diagnosis.where
    )


@pytest.mark.soak
def test_without_a_place_only_an_adequate_model_leaves_noise():
    ladder, page = page_of(damper())
    assert ladder.verdict == "adequate"
    assert "looks like noise" in places_of(page)
    for verdict in ("unexplained", "effect-missing", "inconclusive"):
        told = replace(ladder.diagnosis, verdict=verdict, where=())
        assert "o single band of frequencies stands out" in text_of(told)
        case = replace(ladder.steps[0].case, diagnosis=told)
        changed = replace(
            ladder,
            steps=(replace(ladder.steps[0], examined=case),),
            diagnosis=told,
            verdict=verdict,
        )
        shown = places_of(report_html(changed, damper(), ["x"]))
        assert "no single band of frequencies stands out" in shown
        assert "looks like noise" not in shown


def superposed(celsius=(5.0, 25.0, 45.0)):
    """A damper whose times follow WLF constants of 8 and 120 K about the middle temperature."""
    temperature = np.repeat(celsius, len(OMEGA))
    above = temperature - celsius[1]
    s = (
        1j * np.tile(OMEGA, len(celsius)) * 10.0 ** (-8.0 * above / (120.0 + above))
    ) ** 0.55 * 60.0
    scatter = np.random.default_rng(5).normal(size=(2, len(temperature)))
    values = (80.0 + 400.0 * s / (400.0 + s)) * (1.0 + 0.01 * (scatter[0] + 1j * scatter[1]))
    omega = np.tile(OMEGA, len(celsius))
    return Measurement(
        omega,
        values,
        conditions={"temperature": temperature},
        units=Units("kN/m", "mm"),
        name="warm",
    )


@pytest.fixture(scope="module")
def warm():
    return springpot.discover(superposed(), "fractional-zener", accept=["wlf-shift"])


@pytest.mark.soak
def test_shift_constants_come_with_their_reference_temperature(warm):
    page = report_html(warm, superposed(), ["x"])
    assert "shift constants refer to T_ref = 25 °C" in text_of(warm)
    assert "shift constants refer to T_ref = 25 °C" in text_of(
        warm.steps[0].case.diagnosis, data=superposed()
    )
    for heading in ("Which effects could it be?", "The model"):
        section = page.partition(f"<h2>{heading}")[2].partition("<h2>")[0]
        assert "Shift constants refer to T_ref = 25 °C" in section


@pytest.mark.parametrize(
    ("expression", "told"),
    [
        ("fractional-zener", False),
        ("fractional-zener + inertia", False),
        ("fractional-zener + rig-drag", False),
        ("fractional-zener + arrhenius-shift", True),
        ("fractional-zener + vertical-shift", True),
        ("fractional-zener + arrhenius-dashpot", True),
    ],
)
def test_a_reference_is_told_only_where_something_refers_to_it(expression, told):
    network = springpot.parse_model(expression).network
    assert bool(reference_note(superposed(), [network])) is told
    assert not reference_note(damper(), [network])


def test_a_reference_is_told_beside_a_factor_of_another_column():
    swept = superposed()
    batch = np.arange(len(swept)) % 2 + 1.0
    data = replace(swept, conditions=swept.conditions | {"batch": batch})
    model = springpot.parse_model("maxwell + arrhenius-shift + free-vertical-shift:batch")
    assert reference_note(data, [model.bound_to(data.points).network])


@pytest.mark.soak
def test_every_forecast_stands_beside_the_floor(warm):
    step, best = warm.steps[1], warm.steps[0].case.diagnosis.candidates[0]
    forecast = (
        f"{percent(step.predicted_error)} ({number(step.predicted_error / step.noise_floor, 2)} x)"
    )
    assert forecast in text_of(warm)
    floor = warm.steps[0].noise_floor
    after = f"{percent(best.error_after, 2)} ({number(best.error_after / floor, 2)} x)"
    assert after in text_of(warm.steps[0].case.diagnosis)
    page = report_html(warm, superposed(), ["x"])
    assert forecast in page
    assert after in page


@pytest.mark.parametrize(
    ("value", "floor", "words"),
    [
        (0.0046, 0.0046, "0.46 % (1.0 x)"),
        (0.44, 0.001, "44 % (440 x)"),
        (0.0046, 0.0, "0.46 %"),
        (None, 0.01, "-"),
        (float("nan"), 0.01, "-"),
    ],
)
def test_an_error_beside_its_floor(value, floor, words):
    assert beside_floor(value, floor, 2) == words


@pytest.mark.parametrize(
    ("beside", "predicted", "reached", "words"),
    [
        (np.nan, np.nan, 0.02, "2.0 % (2.0 x)"),
        (np.nan, 0.03, 0.02, "2.0 % (2.0 x)"),
        (np.nan, 0.03, np.nan, "about 3.0 % (3.0 x)"),
        (0.015, 0.03, 0.02, "1.5 % (1.5 x) beside"),
        (np.nan, np.nan, np.nan, "-"),
    ],
)
def test_the_error_after_an_effect_is_told_as_far_as_it_is_known(beside, predicted, reached, words):
    row = SimpleNamespace(error_beside=beside, predicted_error=predicted, error_after=reached)
    assert answers._after(row, 0.01) == words


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1.091, "by +9.1 %"),
        (0.52, "by -48 %"),
        (12.0, "by a factor of 12.0"),
        (0.01, "by a factor of 0.0100"),
        (1e-4, "fell more than 1000-fold"),
        (8.41e-12, "fell to nothing"),
        (0.0, "fell to nothing"),
        (3e4, "rose more than 1000-fold"),
        (4e9, "rose from nothing"),
        (-2.0, "changed sign"),
        (float("inf"), "rose from nothing"),
    ],
)
def test_moves_beyond_a_thousand_are_told_in_words(ratio, words):
    assert change(ratio) == words


@pytest.mark.soak
def test_what_moved_far_stands_apart_from_what_is_counted(warm):
    step = replace(warm.steps[1], changed={"k2": 8.41e-12, "c": 1.5})
    assert changes_text(step) == "+ wlf-shift changed c by +50 %; k2 fell to nothing"
    assert (
        changes_text(replace(step, changed={"k2": 8.41e-12}))
        == "with + wlf-shift k2 fell to nothing"
    )
    assert changes_text(replace(step, changed={})) == ""
    page = report_html(replace(warm, steps=(warm.steps[0], step)), superposed(), ["x"])
    assert "c by +50 %; k2 fell to nothing" in page


def test_points_that_were_set_aside_are_drawn():
    from springpot.report import canvas, views

    data = damper()
    assert set_aside(data, data) is None
    aside = set_aside(data, data.subset(np.setdiff1d(np.arange(len(data)), [20, 33])))
    np.testing.assert_array_equal(aside.omega, data.omega[[20, 33]])
    with canvas.blank() as figure:
        axes = figure.subplots()
        views.storage_and_loss(axes, views.Scene(data, (), aside))
        drawn = [line for line in axes.lines if line.get_marker() == "D"]
    np.testing.assert_allclose(drawn[0].get_xdata(), data.frequency[[20, 33]])
    np.testing.assert_allclose(drawn[1].get_ydata(), data.loss[[20, 33]])


@pytest.mark.soak
def test_an_effect_that_leaves_the_error_is_not_shown_as_a_suggestion():
    """Its sentence of physics was read as advice, beside an error that stays."""
    ladder = springpot.discover(
        damper(lambda f: 1.0 + 0.04 * np.sin(6.0 * np.pi * np.log10(f))), "fractional-maxwell"
    )
    found = ladder.steps[-1].case.diagnosis
    stays = {"alone": AsTold(found.error.relative_rms), "verdict": "cannot-tell"}
    hopeless = tuple(replace(row, **stays) for row in found.candidates[:3])
    told = replace(found, verdict="unexplained", candidates=hopeless, leading=())
    assert worth_showing(told) == []
    name, says = hopeless[0].effect, hopeless[0].says
    assert says not in text_of(told)
    assert f"{name}: {says}" in " ".join(text_of(told, verbose=True).split())
    assert says not in told._repr_html_()
    assert f">{name}</td>" not in told._repr_html_()
    case = replace(ladder.steps[-1].case, diagnosis=told)
    step = replace(ladder.steps[-1], examined=case)
    page = report_html(replace(ladder, steps=(step,), diagnosis=told), damper(), ["x"])
    # The data of the figures, which programs read, keep all.
    section = page.partition("<h2>Which effects could it be?")[2].partition("<h2>")[0]
    assert told.says[1:] in section
    assert says not in section
    assert told.plot() is not None
    half = replace(hopeless[0], alone=AsTold(0.5 * found.error.relative_rms), delta_bic=20.0)
    kept = replace(told, candidates=(half, *hopeless[1:]))
    assert [row.effect for row in worth_showing(kept)] == [name]
    assert f">{name}</td>" in kept._repr_html_()


def test_a_notebook_shows_exact_data_without_a_ratio_to_no_floor():
    data = damper()
    ladder = springpot.discover(data, "fractional-maxwell", only=["inertia", "time-delay"])
    exact = replace(ladder, steps=[replace(step, noise_floor=0.0) for step in ladder.steps])
    assert 'data-label="x floor"' in ladder._repr_html_()
    assert 'data-label="x floor"' not in exact._repr_html_()
    comparison = springpot.compare(data, ["fractional-maxwell", "kelvin"])
    first = comparison.judgements[0]
    floorless = replace(first)
    vars(floorless).update(error=replace(first.error, noise_floor=0.0))
    page = replace(comparison, judgements=(floorless, *comparison.judgements[1:]))._repr_html_()
    assert 'data-label="x floor">-</td>' in page


def test_two_notes_are_told_and_how_many_more_there_are():
    found = springpot.diagnose(damper(), "fractional-maxwell", only=["inertia"])
    told = text_of(replace(found, notes=("one", "two", "three", "four")))
    assert [f"note: {word}" in told for word in ("one", "two", "three", "four")] == [
        True, True, False, False,
    ]  # fmt: skip
    assert "2 notes more" in told


@pytest.mark.soak
def test_rivals_of_an_accepted_effect_keep_what_tells_them_apart():
    omega, rng = 2.0 * np.pi * np.geomspace(1.0, 50.0, 14), np.random.default_rng(3)
    model = springpot.parse_model("fractional-maxwell + inertia")
    exact = model.stiffness(np.array([400.0, 60.0, 0.55, 0.6e-3]), omega)
    noise = 0.005 * (rng.normal(size=14) + 1j * rng.normal(size=14))
    data = Measurement(omega, exact * (1.0 + noise), units=Units("kN/m", "mm"))
    rivals = ["inertia", "specimen-inertia"]
    ladder = springpot.discover(data, "fractional-maxwell", only=rivals)
    first, last = ladder.steps
    assert sorted(last.alike) == rivals
    assert last.next_experiment is None
    assert first.next_experiment is not None
    assert f"next experiment: {first.next_experiment.says[:40]}" in str(ladder)
    kept = Ladder.from_dict(json.loads(to_json(ladder)))
    assert kept.undecided.next_experiment == first.next_experiment
    assert str(kept) == str(ladder)
