"""Levels of several columns as specimens, and specimens that are of batches."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError, OptionError
from springpot.identification.population import of_one

LEVELS = [str(i) for i in range(24)]
BATCH = np.repeat(np.arange(3), 8)
LETTERS = [("A", "B", "C")[i] for i in BATCH]
OMEGA = np.geomspace(1.0, 100.0, 8)


@pytest.mark.soak
@pytest.mark.parametrize("batches", [0.0, 0.01, 0.04])
def test_of_24_specimens_in_3_batches_the_mean_is_covered(batches: float) -> None:
    """At least .93 and at most .97 in the long run, whatever batches differ by.

    Of 400 draws three deviations lie within .033 of that.
    """
    rng, held, squares = np.random.default_rng(5), 0, np.zeros(2)
    for _ in range(400):
        own = 0.03 * rng.standard_normal(24) + 0.01 * rng.standard_normal(24)
        value = (batches * rng.standard_normal(3))[BATCH] + own
        found = of_one(value, 1e-4 * np.eye(24), False, LEVELS, "-", LETTERS)
        assert found.groups is not None
        held += found.mean.low <= 0.0 <= found.mean.high
        squares += np.array([found.between.value, found.groups.value]) ** 2 / 400
    assert 0.92 <= held / 400 <= 0.98
    components = np.sqrt(squares)
    assert components[0] == pytest.approx(0.03, rel=0.05)
    if batches > 0.03:
        assert components[1] == pytest.approx(batches, rel=0.2)


def test_a_mean_that_takes_batches_for_nothing_is_too_sure() -> None:
    """Why they are asked for: 24 specimens of 3 batches are not 24 specimens."""
    rng, held = np.random.default_rng(6), 0
    for _ in range(200):
        value = (0.04 * rng.standard_normal(3))[BATCH] + 0.03 * rng.standard_normal(24)
        found = of_one(value, 1e-6 * np.eye(24), False, LEVELS, "-")
        held += found.mean.low <= 0.0 <= found.mean.high
    assert held / 200 < 0.75


def test_a_specimen_is_drawn_to_its_batch() -> None:
    value = np.array([1.0, 1.01, 1.02, 2.0, 2.01, 2.02])
    error = np.diag([1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 0.25])
    found = of_one(value, error, False, LEVELS[:6], "-", list("AAABBB"))
    assert found.specimens["5"] == pytest.approx(2.005, abs=0.01)


def test_a_specimen_that_is_sure_stays_where_its_batch_is_drawn_to_the_others() -> None:
    """Batches that do not differ have one mean; each specimen is what it was measured to be."""
    value = 1.0 + 0.1 * np.random.default_rng(1).standard_normal(24)
    found = of_one(value, 1e-10 * np.eye(24), False, LEVELS, "-", LETTERS)
    assert found.groups is not None
    assert found.groups.value < 0.02
    assert list(found.specimens.values()) == pytest.approx(value.tolist(), abs=1e-5)


@pytest.mark.soak
def test_batches_are_compared_as_often_right_as_is_said() -> None:
    """All three differences at once within their intervals in 95 % of 400 draws."""
    rng, held, pairs = np.random.default_rng(7), 0, (("A", "B"), ("A", "C"), ("B", "C"))
    shift = np.log([1.0, 1.08, 1.08])
    for _ in range(400):
        value = shift[BATCH] + 0.04 * rng.standard_normal(24) + 0.02 * rng.standard_normal(24)
        found = of_one(value, 4e-4 * np.eye(24), True, LEVELS, "N/m", LETTERS)
        truths = zip(pairs, (1.08, 1.08, 1.0), strict=True)
        held += all(found.compared[i].low <= true <= found.compared[i].high for i, true in truths)
    assert 0.93 <= held / 400 <= 0.99
    assert found.compared["A", "B"].unit == "-"


def test_batches_that_differ_are_told_apart_by_name(data: springpot.Measurement) -> None:
    fit = springpot.identify(data, "kelvin", own={"*": "batch/number"}, share="c")
    compared = fit.to_dict()["population"]["k"]["compared"]
    assert [(row["first"], row["second"]) for row in compared] == [
        ("A", "B"),
        ("A", "C"),
        ("B", "C"),
    ]
    assert compared[1]["low"] > 1.05
    assert "C against A" in str(fit)
    assert list(fit.to_dict()["specimens"])[:2] == ["A/1", "A/2"]


@pytest.fixture(scope="module")
def data() -> springpot.Measurement:
    """Twelve Kelvin solids of three batches, numbered in each; the batches have words."""
    rng, model = np.random.default_rng(4), springpot.parse_model("kelvin")
    parts, size = [], len(OMEGA)
    for shift in (-0.05, 0.0, 0.05):
        for _ in range(4):
            k = 100.0 * np.exp(shift + 0.01 * rng.standard_normal())
            noise = 1.0 + 0.003 * (rng.normal(size=size) + 1j * rng.normal(size=size))
            parts.append(model.stiffness(model.theta(k=k, c=2.0), OMEGA) * noise)
    return springpot.Measurement(
        np.tile(OMEGA, 12),
        np.concatenate(parts),
        conditions={"number": np.tile(np.repeat([1.0, 2.0, 3.0, 4.0], size), 3)},
        labels={"batch": np.repeat(["A", "B", "C"], 4 * size)},
    )


def test_a_fit_tells_both_scatters(data: springpot.Measurement, tmp_path) -> None:
    fit = springpot.identify(data, "kelvin", own={"*": "batch/number"}, share="c")
    population = fit.populations["k"]
    assert population.groups is not None
    assert population.between.low < 0.01 < population.between.high < 0.03
    assert population.groups.value == pytest.approx(0.05, rel=0.3)
    assert list(fit.populations) == ["k"]
    assert fit["c"].value == pytest.approx(2.0, rel=0.01)
    assert "6 is B/2" in " ".join(fit.notes)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = springpot.load(path)
    assert again.populations["k"].groups == population.groups


def test_several_columns_tell_the_specimens(data: springpot.Measurement) -> None:
    """Numbers that come again in each batch are twelve specimens, and no four."""
    shared = springpot.identify(data, "kelvin", specimen="batch,number")
    assert any("12 specimens" in note for note in shared.notes)
    own = springpot.identify(data, "kelvin", specimen="batch,number", share=["c"])
    assert len([name for name in own.parameters if name.startswith("k_")]) == 12
    assert own["c"].value == pytest.approx(2.0, rel=0.01)
    # The scatter of specimens, not that of the points, says how well a mean is known.
    points = springpot.identify(data, "kelvin")
    assert shared["k"].high - shared["k"].low > 1.5 * (points["k"].high - points["k"].low)


def test_files_of_batches_are_specimens_as_numbered_ones_are(data: springpot.Measurement) -> None:
    """As levels of their own: they are not said to share what each has for itself."""
    numbered = springpot.identify(data, "kelvin", own={"*": "batch/number"})
    files = springpot.identify(data, "kelvin", specimen="batch,number", own={"*": "batch/file"})
    assert not any("intervals follow" in note for note in files.notes)
    assert files.uncertainty.specimens is None
    for name, one in numbered.populations.items():
        other = files.populations[name]
        assert (other.mean.low, other.mean.high) == pytest.approx((one.mean.low, one.mean.high))
        assert other.between.value == one.between.value
    assert files.low == pytest.approx(numbered.low)


def test_what_cannot_be_is_one_line(data: springpot.Measurement) -> None:
    for error, told, options in (
        (DataError, "no column 'day'", {"specimen": "batch,day"}),
        (ModelError, "no free parameter 'q'", {"share": "q"}),
        (ModelError, "own, or shared", {"share": "k", "own": {"k": "batch"}}),
        (OptionError, "one level above", {"own": {"*": "lab/batch/number"}}),
    ):
        with pytest.raises(error, match=told):
            springpot.identify(data, "kelvin", **options)
