"""What a discovery and a comparison are to a Python user.

Pictures, texts, things to keep and to go on from.
"""

import copy
import pickle

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError, OutputError
from springpot.registry import plugins
from springpot.report.text import jsonable, to_json

DATA, MODEL = "artificial-hidden", "fractional-maxwell"


@pytest.fixture
def ladder(asked_once):
    return springpot.discover(DATA, MODEL, accept="inertia")


@pytest.fixture
def compared(asked_once):
    return springpot.compare(DATA, [MODEL, f"{MODEL} + inertia"])


@pytest.mark.soak
def test_results_survive_being_kept_and_copied(ladder, compared):
    for result in (ladder, compared, ladder.diagnosis):
        for again in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result), copy.copy(result)):
            assert jsonable(again) == jsonable(result)
    case = pickle.loads(pickle.dumps(ladder.steps[-1].case))
    assert case.search.base.relative_rms == pytest.approx(ladder.steps[-1].relative_rms)


@pytest.mark.soak
def test_what_is_printed_is_the_text_of_the_command_line(ladder, compared, capsys):
    from springpot.cli.group import run

    run(["discover", DATA, "--model", MODEL, "--accept", "inertia"])
    said = capsys.readouterr().out
    assert said.startswith(f"{ladder}\n\nnext: ")
    assert f"next: springpot discover {DATA} --model {MODEL} --accept inertia --accept " in said
    run(["compare", DATA, "--model", MODEL, "--model", f"{MODEL} + inertia"])
    assert capsys.readouterr().out.startswith(f"{compared}\n\nnext: ")
    run(["diagnose", DATA, "--model", MODEL])
    assert capsys.readouterr().out.startswith(f"{ladder.steps[0].case.diagnosis}\n")


@pytest.mark.soak
def test_short_forms_fit_on_a_line(ladder, compared):
    step = ladder.steps[1]
    assert (
        repr(step)
        == f"<Step {MODEL} + inertia: error {step.relative_rms / step.noise_floor:.3g} x floor>"
    )
    for thing in (
        ladder,
        *ladder.steps,
        step.case,
        compared,
        *compared.judgements,
        ladder.diagnosis,
    ):
        assert len(repr(thing)) < 400
        assert "\n" not in repr(thing)


def test_ladder_and_comparison_are_drawn_on_axes_of_the_user(ladder, compared):
    figure = pytest.importorskip("matplotlib.figure").Figure
    for thing in (ladder, compared):
        axes = figure().subplots()
        assert thing.plot(ax=axes) is axes
        assert axes.lines
        with pytest.raises(OutputError, match="not both"):
            thing.plot("x.png", ax=axes)


@pytest.mark.soak
def test_a_diagnosis_is_drawn_with_what_each_effect_leaves(ladder, tmp_path):
    figure = pytest.importorskip("matplotlib.figure").Figure
    diagnosis = ladder.steps[0].case.diagnosis
    axes = figure().subplots()
    assert diagnosis.plot(ax=axes) is axes
    [errors] = [line for line in axes.lines if line.get_label() == "error"]
    assert errors.get_ydata()[0] == pytest.approx(100 * diagnosis.error.relative_rms)
    assert errors.get_ydata()[1] == pytest.approx(100 * diagnosis.best.error_after)
    names = [text.get_text().replace("\n", "") for text in axes.get_xticklabels()]
    assert names[:3] == ["as it is", "+ inertia", "+ time-delay"]
    assert diagnosis.plot(tmp_path / "diagnosis.svg").stat().st_size > 1000
    path = tmp_path / "diagnosis.json"
    path.write_text(to_json(diagnosis), encoding="utf-8")
    assert springpot.load(path).plot(tmp_path / "loaded.png").read_bytes().startswith(b"\x89PNG")


def test_a_grown_model_is_handed_out_fitted_or_as_scanned(ladder):
    case = ladder.steps[0].case
    for candidate in case.diagnosis.candidates:
        try:
            grown = case.grown_with(candidate.physics)
        except ModelError:
            continue
        names = [effect.name for effect in grown.model.effects]
        assert names == [candidate.effect]
        assert len(grown.theta) == len(grown.model.parameters)
        assert set(case.search.base.model.names) < set(grown.model.names)
    best = case.grown_with(case.diagnosis.best.physics)
    assert best.refitted
    after = case.search.base.data.relative_rms(best.model, best.theta)
    assert after == pytest.approx(case.diagnosis.best.error_after)


def test_an_effect_that_the_data_cannot_show_is_refused(ladder):
    effects = {effect.name: effect for effect in plugins().items("effect")}
    with pytest.raises(ModelError, match="temperature"):
        ladder.steps[0].case.grown_with(effects["wlf-shift"])
    with pytest.raises(ModelError, match="only a fit can tell"):
        ladder.steps[0].case.grown_with(effects["free-shift"])
    assert np.all(np.isfinite(ladder.steps[0].case.grown_with(effects["time-delay"]).theta))


def test_a_diagnosis_tells_the_parameters_of_the_model_that_it_judges(ladder, tmp_path):
    first = ladder.steps[0]
    diagnosis = first.case.diagnosis
    assert diagnosis.parameters == first.parameters
    k = diagnosis.parameters["k"]
    assert k.low < k.value < k.high
    assert k.determined
    assert f"fitted: k {k.value:.0f} [" in str(diagnosis)
    assert str(ladder).count("fitted: ") == 0  # a discovery has them in a table already
    assert "; alpha 0." in diagnosis._repr_html_()
    path = tmp_path / "diagnosis.json"
    path.write_text(to_json(diagnosis), encoding="utf-8")
    assert springpot.load(path).parameters == diagnosis.parameters
