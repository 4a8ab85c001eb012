"""What must not change an answer.

The order of rows, the unit of stiffness, the day, the size of the set.
"""

import json
from functools import cache

import numpy as np
import pytest
from hidden_data import AMPLITUDES, KELVIN, SWEEP, Design, design, exact, hidden, measured

import springpot
from soaked import soaked
from springpot.measurement import replicates
from springpot.measurement.replicates import THINNED
from springpot.report.text import jsonable

CASES = {"inertia": SWEEP, "friction": AMPLITUDES}
ONE = ["friction", soaked("inertia")]
"""For what is the same code with amplitudes as without."""


@cache
def data(effect, known=True):
    return hidden(KELVIN, CASES[effect], effect, 300.0, seed=9, known=known)


@cache
def diagnosed(measurement):
    """A measurement is itself and no other.

    `data` gives the same one each time, and it is diagnosed once.
    """
    return springpot.diagnose(measurement, KELVIN.name)


@cache
def discovered(effect):
    return springpot.discover(data(effect), KELVIN.name)


def strict(result):
    return json.dumps(jsonable(result.to_dict()), allow_nan=False, sort_keys=True)


def close(one, other, factor=None):
    """The same ranking, classes and figures.

    `factor` says how the parameters of an effect have changed.
    """
    assert one.verdict == other.verdict
    assert one.error.relative_rms == pytest.approx(other.error.relative_rms, rel=1e-6)
    assert one.error.noise_floor == pytest.approx(other.error.noise_floor, rel=1e-6)
    assert one.best.effect == other.best.effect
    assert set(one.best.alike) == set(other.best.alike)
    assert one.best.probability == pytest.approx(other.best.probability, abs=1e-3)
    assert one.best.delta_bic == pytest.approx(other.best.delta_bic, rel=1e-4)
    assert one.best.error_after == pytest.approx(other.best.error_after, rel=1e-5)
    for name, value in one.best.parameters.items():
        assert value.value * (factor or {}).get(name, 1.0) == pytest.approx(
            other.best.parameters[name].value, rel=1e-3
        )


@pytest.mark.soak_cases("friction", "inertia")
@pytest.mark.parametrize("effect", CASES)
def test_shuffled_rows_give_the_same_answer(effect):
    ordered = data(effect)
    shuffled = ordered.subset(np.random.default_rng(3).permutation(len(ordered)))
    close(diagnosed(ordered), diagnosed(shuffled))


@pytest.mark.soak_cases("N/m-friction")
@pytest.mark.parametrize("effect", ONE)
@pytest.mark.parametrize("unit", ["N/m", soaked("N/mm")])
def test_another_unit_of_stiffness_changes_nothing_but_the_moduli(effect, unit):
    ordered = data(effect)
    gain = {"N/m": 1000.0, "N/mm": 1.0}[unit]
    scaled = springpot.Measurement(
        ordered.omega,
        ordered.stiffness * gain,
        sd=ordered.sd * gain,
        conditions=ordered.conditions,
        units=springpot.Units(unit, "mm"),
    )
    one, other = diagnosed(ordered), diagnosed(scaled)
    same = {"kg", "N"}
    close(one, other, {n: 1.0 if v.unit in same else gain for n, v in one.best.parameters.items()})
    assert {v.unit for v in one.best.parameters.values()} <= same | {"kN/m", "-", "s", "rad"}


@pytest.mark.soak_cases("friction")
@pytest.mark.parametrize("effect", ONE)
def test_a_gain_of_ten_multiplies_the_moduli_only(effect):
    ordered = data(effect)
    strong = springpot.Measurement(
        ordered.omega,
        ordered.stiffness * 10.0,
        sd=ordered.sd * 10.0,
        conditions=ordered.conditions,
        units=ordered.units,
    )
    one, other = diagnosed(ordered), diagnosed(strong)
    close(
        one,
        other,
        {name: 10.0 for name, v in one.best.parameters.items() if v.unit in ("kg", "N", "kN/m")},
    )


@pytest.mark.soak
def test_a_gain_of_ten_multiplies_the_moduli_only_where_the_noise_is_unknown():
    ordered = data("inertia", known=False)
    strong = springpot.Measurement(ordered.omega, ordered.stiffness * 10.0, units=ordered.units)
    close(diagnosed(ordered), diagnosed(strong), {"m": 10.0})


@pytest.mark.soak
@pytest.mark.parametrize("effect", ONE)
def test_the_same_seed_gives_the_same_bits(effect):
    again = springpot.diagnose(data(effect), KELVIN.name, seed=0)
    assert again is not diagnosed(data(effect))
    assert strict(again) == strict(diagnosed(data(effect)))


@pytest.mark.soak
def test_another_seed_gives_the_same_verdict_and_class():
    found = [diagnosed(data("friction")), springpot.diagnose(data("friction"), KELVIN.name, seed=1)]
    assert len({d.verdict for d in found}) == 1
    assert len({d.best.effect for d in found}) == 1


@pytest.mark.soak
def test_the_same_seed_gives_the_same_ladder():
    again = springpot.discover(data("inertia"), KELVIN.name, seed=0)
    assert again is not discovered("inertia")
    assert strict(again) == strict(discovered("inertia"))


@pytest.mark.soak
def test_a_ladder_begins_with_the_diagnosis_of_its_model():
    assert strict(discovered("inertia").steps[0].case.diagnosis) == strict(
        diagnosed(data("inertia"))
    )


@pytest.mark.soak
def test_results_are_strict_json_of_the_agreed_form():
    diagnosis = diagnosed(data("inertia"))
    found = json.loads(strict(diagnosis))
    assert found["schema"] == "springpot.diagnosis/2"
    assert {
        "data",
        "model",
        "error",
        "verdict",
        "where",
        "candidates",
        "classes",
        "next_experiment",
    } <= set(found)
    assert {"relative_rms", "noise_floor", "noise_source"} <= set(found["error"])
    for candidate in found["candidates"]:
        assert {"effect", "class", "probability", "delta_bic", "score", "verdict"} <= set(candidate)
        assert {"predicted_error", "error_after", "parameters", "says"} <= set(candidate)
        assert candidate["effect"] in candidate["class"]
        for value in candidate["parameters"].values():
            assert {"value", "low", "high", "unit"} <= set(value)
    assert all(0.0 <= c["probability"] <= 1.0 for c in found["candidates"])
    experiment = found["next_experiment"]
    assert experiment is None or {"says", "separates", "expected_separation_sigma"} <= set(
        experiment
    )


@pytest.mark.soak
def test_a_ladder_is_strict_json_of_the_agreed_form():
    found = json.loads(strict(discovered("inertia")))
    assert found["schema"] == "springpot.discovery/2"
    assert {"steps", "verdict", "diagnosis"} <= set(found)
    for step in found["steps"]:
        assert {"model", "accepted", "relative_rms", "noise_floor", "predicted_error"} <= set(step)


@pytest.mark.soak_cases("10-10-0.3", "20000-100-0.2")
@pytest.mark.parametrize(
    ("points", "kept", "within"),
    [
        (10, 10, 0.3),
        (20_000, 100, 0.2),
        pytest.param(20_000, THINNED.points, 0.02, marks=pytest.mark.soak),
    ],
)
def test_few_and_very_many_points(points, kept, within, monkeypatch):
    """Of very many a part is diagnosed.

    Here a small one, which takes a second and not half a minute.
    """
    monkeypatch.setattr(replicates, "THINNED", replicates.THINNED._replace(points=kept))
    at = design(points)
    stiffness = exact(KELVIN, at, "inertia", 3e-4)
    diagnosis = springpot.diagnose(measured(at, stiffness, level=0.01, just=True), KELVIN.name)
    assert diagnosis.verdict == "effect-missing"
    assert "inertia" in diagnosis.best.alike
    assert diagnosis.best.error_after == pytest.approx(0.01 * np.sqrt(2.0), rel=within)


@pytest.mark.soak
def test_repeats_tell_the_noise():
    at = Design(np.tile(SWEEP.omega, 4))
    data = measured(
        at,
        exact(KELVIN, at, "inertia", 3e-4),
        known=False,
        repeat=np.repeat(np.arange(4), len(SWEEP.omega)),
    )
    diagnosis = diagnosed(data)
    assert diagnosis.error.noise_source == "repeats"
    assert diagnosis.error.noise_floor == pytest.approx(0.01 * np.sqrt(2.0), rel=0.15)
    assert "inertia" in diagnosis.best.alike
