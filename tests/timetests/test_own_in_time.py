"""Parameters that each test in time, or each temperature, has for itself; sweeps among them."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import springpot
from springpot.constraints import marked, owning
from springpot.errors import DataError
from springpot.measurement import TimeTest
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.timetests.diagnosis import planned_tests

MODEL = springpot.parse_model("zener")
STIFF = (400.0, 440.0, 380.0)
T = np.geomspace(0.01, 10.0, 30)


def theta(k):
    return MODEL.vector({"k1": 50.0, "k2": k, "c": 60.0})


def noisy(values, seed):
    return values * (1.0 + 0.01 * np.random.default_rng(seed).normal(size=len(values)))


@cache
def specimens():
    """A relaxation, a creep test and a sweep, each of a specimen of its own."""
    one, two, three = map(theta, STIFF)
    omega = np.geomspace(0.3, 30.0, 12)
    swept = MODEL.stiffness(three, omega)
    scatter = noisy(np.ones(12), 3) + 1j * (noisy(np.ones(12), 4) - 1.0)
    return (
        TimeTest.of_relaxation(T, noisy(MODEL.relaxation(one, T), 1), "kPa", name="relaxed"),
        TimeTest.of_compliance(T, noisy(MODEL.creep(two, T), 2), "kPa", name="crept"),
        springpot.Measurement(
            omega, swept * scatter, units=springpot.Units("kPa", "-"), name="swept"
        ),
    )


@cache
def fit():
    return springpot.identify(specimens(), "zener", own={"k2": "file"})


@pytest.mark.soak
def test_each_test_has_a_parameter_of_its_own():
    found = fit()
    assert list(found.parameters) == ["k1", "k2_1", "k2_2", "k2_3", "c"]
    for number, stiff in enumerate(STIFF, 1):
        value = found[f"k2_{number}"]
        assert abs(value.value / stiff - 1.0) < 0.03
        assert (value.high - value.low) / value.value < 0.06
    assert list(found.populations["k2"].specimens) == ["relaxed", "crept", "swept"]
    assert all(test.over_floor < 1.3 for test in found.tests)
    # What all share is as well known as by all of them.
    alone = springpot.identify(specimens()[0], "zener")
    ends = [each["c"].high - each["c"].low for each in (found, alone)]
    assert ends[0] < ends[1]


def test_it_is_taken_up_again_and_predicts_one_specimen(tmp_path):
    file = tmp_path / "fit.json"
    file.write_text(json.dumps(fit().to_dict()), encoding="utf-8")
    again = springpot.load(file)
    assert again.to_dict()["specimens"] == fit().to_dict()["specimens"]
    asked = again.predict([1.0], file="crept").stiffness
    np.testing.assert_allclose(
        asked, again.predict([1.0], file=2.0).stiffness, rtol=1e-12, atol=0.0
    )
    exact = MODEL.stiffness(theta(STIFF[1]), np.array([2.0 * np.pi]))
    np.testing.assert_allclose(asked, exact, rtol=0.02)
    with pytest.raises(DataError, match="say file="):
        again.predict([1.0])
    with pytest.raises(DataError, match=r"each file has .* say which, file=\w+ \(of [\w, ]+\)$"):
        springpot.quantities(file)


@pytest.mark.soak
def test_each_temperature_has_its_own():
    warm = [
        TimeTest.of_relaxation(
            T, noisy(MODEL.relaxation(theta(k), T), i), "kPa", temperature=20.0 + 10.0 * (i // 2)
        )
        for i, k in enumerate((400.0, 400.0, 300.0))
    ]
    found = springpot.identify(warm, "zener", own={"k2": "temperature"})
    assert list(found.parameters) == ["k1", "k2_20", "k2_30", "c"]
    assert found["k2_20"].value / found["k2_30"].value == pytest.approx(4.0 / 3.0, rel=0.03)


@pytest.mark.parametrize(
    ("chosen", "own", "says"),
    [
        (
            (0, 1),
            {"k2": "batch"},
            "relaxed has no batch: say it of each test, .*batch=1",
        ),
        ((0, 0), {"k2": "file"}, "relaxed [+] relaxed: one file alone, and nothing is its own"),
        ((0, 1), {"k2": "temperature"}, "relaxed has no temperature"),
    ],
)
def test_what_tells_no_test_from_another_is_refused(chosen, own, says):
    with pytest.raises(DataError, match=says):
        springpot.identify([specimens()[i] for i in chosen], "zener", own=own)


def test_a_batch_is_said_behind_the_file_of_a_record(tmp_path):
    relaxed, _, swept = specimens()
    rows = zip(T.tolist(), relaxed.response.tolist(), strict=True)
    file = tmp_path / "relaxed.csv"
    file.write_text("time [s],relaxation [kPa]\n" + "\n".join(f"{t},{g}" for t, g in rows))
    said = springpot.read(f"{file}?batch=1[-]")
    assert said.marks == {"batch": 1.0}
    assert springpot.read(file).marks == {}
    other = replace(swept, conditions={"batch": np.full(len(swept), 3.0)})
    found = springpot.identify([said, other], "zener", own={"k2": "batch"})
    assert list(found.parameters) == ["k1", "k2_1", "k2_3", "c"]
    # A column tells specimens in the place of their files, beside tests in time as well.
    told = owning(MODEL, [said, other], None, ["k1", "c"], "batch")[0]
    assert told.own == {"k2": "batch"}
    for own, columns in ((None, "batch"), ({"k2": "file"}, "batch,lot")):
        with pytest.raises(DataError, match="one column tells specimens"):
            owning(MODEL, [said, other], own, specimen=columns)
    with pytest.raises(DataError, match="no column 'lot'"):
        springpot.read(f"{file}?lot=1[kg]")


def test_a_sweep_is_planned_of_the_specimen_that_was_swept():
    parts = parts_of_specimen(marked(specimens(), "file"))
    plans = {each.says: each.part for each in planned_tests(parts, fit())}
    swept = [part for says, part in plans.items() if says.startswith("swept: ")]
    assert [set(plan.test.conditions["file"]) for plan in swept] == [{3.0}] * len(swept)
    # As beside a sweep alone: a larger specimen, or none, which nothing of the material is in.
    (empty,) = [part for says, part in plans.items() if "without a specimen" in says]
    rows = np.arange(empty.count())
    shown = empty.answer(fit().model, fit().theta, fit().reference, rows).value
    assert np.abs(shown).max() < 1e-6 * fit().theta[0]


@pytest.mark.soak
def test_all_tests_together_show_what_is_missing():
    """A dashpot beside each specimen, of which each has its own stiffness."""
    whole = springpot.parse_model("zener + parallel-dashpot")
    t = np.linspace(0.0, 4.0, 80)
    way = np.sin(2.0 * np.pi * 0.5 * t * (1.0 + 0.3 * t))
    records = []
    for i, k in enumerate(STIFF):
        values = {"k1": 50.0, "k2": k, "c": 60.0, "parallel-dashpot.c": 3.0}
        force = whole.respond(whole.vector(values), t, way)
        force = force + 0.01 * np.std(force) * np.random.default_rng(i).normal(size=len(t))
        test = TimeTest.of_history(t, way, force, "m", "N", control="displacement")
        records.append(replace(test, name=f"S{i + 1}"))
    found = springpot.diagnose(
        records, "zener", own={"k2": "file"}, only=["parallel-dashpot", "inertia"]
    )
    assert found.verdict == "effect-missing"
    assert found.best.effect == "parallel-dashpot"
