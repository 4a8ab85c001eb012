"""Specimens as a population: means and scatter hold what their intervals promise."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.special import ndtr

import springpot
from springpot.errors import DataError
from springpot.identification.population import of_one

LEVELS = [str(i) for i in range(24)]


def drawn(between: float, own: float, rng: np.random.Generator, count: int = 24) -> np.ndarray:
    """Logarithms about one, of so many specimens, each with an error of its own."""
    return 1.0 + between * rng.standard_normal(count) + own * rng.standard_normal(count)


@pytest.mark.suite_cases("3")
@pytest.mark.parametrize("count", [3, 8, 24])
def test_intervals_hold_mean_and_scatter(count: int, rng: np.random.Generator) -> None:
    held, draws = np.zeros(2), 400
    for _ in range(draws):
        found = of_one(
            drawn(0.05, 0.02, rng, count), 4e-4 * np.eye(count), False, LEVELS[:count], "-"
        )
        held += [
            found.mean.low <= 1.0 <= found.mean.high,
            found.between.low <= 0.05 <= found.between.high,
        ]
    share = held / draws
    assert 0.92 <= share[0] <= 0.985
    assert share[1] >= 0.92


def test_errors_alone_are_no_scatter(rng: np.random.Generator) -> None:
    flagged = 0
    for _ in range(200):
        found = of_one(drawn(0.0, 0.02, rng), 4e-4 * np.eye(24), False, LEVELS, "-")
        flagged += found.between.low > 0.0
    assert flagged <= 0.06 * 200


def test_a_vague_specimen_is_drawn_to_the_mean_and_a_sure_one_is_not() -> None:
    value, error = np.array([0.9, 1.0, 1.1, 1.5]), np.diag([1e-8, 1e-8, 1e-8, 0.25])
    found = of_one(value, error, False, LEVELS[:4], "-")
    assert found.specimens["0"] == pytest.approx(0.9, abs=1e-3)
    assert abs(found.specimens["3"] - found.mean.value) < 0.1


def test_an_error_that_all_share_moves_the_mean_and_is_no_scatter() -> None:
    value = np.linspace(-1e-3, 1e-3, 6)
    shared = of_one(value, 0.01 * np.ones((6, 6)) + 1e-6 * np.eye(6), False, LEVELS[:6], "-")
    assert shared.between.value < 0.01
    assert shared.mean.high - shared.mean.low > 0.4


@pytest.mark.soak
def test_a_fit_tells_its_population(rng: np.random.Generator) -> None:
    omega, batch = np.tile(np.geomspace(1.0, 100.0, 10), 8), np.repeat(np.arange(1.0, 9.0), 10)
    k = 100.0 * np.exp(0.06 * rng.standard_normal(8))
    exact = k[batch.astype(int) - 1] + 2.0j * omega
    noise = 1.0 + 0.003 * (rng.standard_normal(80) + 1j * rng.standard_normal(80))
    data = springpot.Measurement(omega, exact * noise, conditions={"batch": batch})
    fit = springpot.identify(data, "kelvin", own={"*": "batch"})
    answer = fit.to_dict()
    assert set(answer["population"]) == {"k", "c"}
    between = answer["population"]["k"]["between"]
    assert between["low"] < np.std(np.log(k), ddof=1) < between["high"]
    assert answer["population"]["c"]["between"]["low"] == 0.0
    assert answer["specimens"]["3"]["k"] == pytest.approx(k[2], rel=0.01)
    assert "8 specimens" in str(fit)
    assert "k_1" not in str(fit)


@pytest.mark.soak
def test_two_specimens_are_no_population() -> None:
    omega, batch = np.tile(np.geomspace(1.0, 100.0, 10), 2), np.repeat([1.0, 2.0], 10)
    data = springpot.Measurement(omega, batch + 0.1j * omega, conditions={"batch": batch})
    fit = springpot.identify(data, "kelvin", own={"k": "batch"})
    assert not fit.populations
    assert "population" not in fit.to_dict()
    assert any("2 specimens do not tell" in note for note in fit.notes)


@pytest.mark.parametrize(("count", "told"), [(3, "6.3 times"), (5, "2.9 times"), (6, "")])
def test_what_few_specimens_cannot_tell_is_told(count: int, told: str) -> None:
    """Of a normal scatter: the ends of its interval by chi-square."""
    omega = np.tile(np.geomspace(1.0, 100.0, 6), count)
    number = np.arange(1.0, count + 1).repeat(6)
    data = springpot.Measurement(
        omega, 9.0 + number + 0.1j * omega, conditions={"batch": number, "temperature": number * 10}
    )
    notes = springpot.identify(data, "kelvin", own={"k": "batch"}).notes
    found = [note for note in notes if "specimens tell little" in note]
    assert [told in note for note in found] == [True] * bool(told)
    # Temperatures are no specimens.
    warm = springpot.identify(data, "kelvin", own={"k": "temperature"}).notes
    assert not any("specimens" in note for note in warm)


@pytest.mark.suite_cases("8-0.02")
@pytest.mark.parametrize(("count", "own"), [(3, 0.0), (8, 0.02), (24, 0.05)])
def test_limits_hold_a_share_of_specimens_at_their_confidence(
    count: int, own: float, rng: np.random.Generator
) -> None:
    """95 % of all specimens lie within them in 95 % of cases, whatever errors the values have."""
    held = 0
    for _ in range(400):
        error = own**2 * np.eye(count)
        found = of_one(drawn(0.05, own, rng, count), error, False, LEVELS[:count], "-")
        ends = (np.array(found.limits) - 1.0) / 0.05
        held += ndtr(ends[1]) - ndtr(ends[0]) >= 0.95
    assert 0.92 <= held / 400 <= 0.985


def test_specimens_that_are_files_have_the_names_of_these(
    tmp_path, rng: np.random.Generator
) -> None:
    omega, files = np.geomspace(1.0, 100.0, 8), []
    for name, k in zip(("soft", "hard", "old"), (90.0, 110.0, 100.0), strict=True):
        scatter = 1.0 + 0.002 * (rng.standard_normal(8) + 1j * rng.standard_normal(8))
        exact = (k + 2.0j * omega) * scatter
        files.append(springpot.Measurement(omega, exact, name=name))
    fit = springpot.identify(files, "kelvin", own={"*": "file"})
    (tmp_path / "fit.json").write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    for each in (fit, springpot.load(tmp_path / "fit.json")):
        specimens = each.to_dict()["specimens"]
        assert list(specimens) == ["soft", "hard", "old"]
        assert specimens["hard"]["k"] == pytest.approx(110.0, rel=5e-3)


def test_a_specimen_is_asked_for_by_its_name(rng: np.random.Generator) -> None:
    omega, pad = np.tile(np.geomspace(1.0, 100.0, 6), 3), np.repeat(["new", "old", "worn"], 6)
    k = np.repeat([100.0, 110.0, 90.0], 6)
    exact = (k + 2.0j * omega) * (1.0 + 0.003 * rng.standard_normal(18))
    data = springpot.Measurement(omega, exact, labels={"pad": pad})
    fit = springpot.identify(data, "kelvin", own={"*": "pad"})
    for number, name in enumerate(("new", "old", "worn"), 1):
        named, numbered = (fit.predict(frequency=1.0, pad=each) for each in (name, number))
        assert named.storage == numbered.storage
    assert fit.predict(frequency=1.0, pad="old").storage == pytest.approx(110.0, rel=0.01)
    with pytest.raises(DataError, match="has no 'wron': there are worn"):
        fit.predict(frequency=1.0, pad="wron")


def test_parameters_named_one_after_the_other_are_all_each_level_s_own() -> None:
    model = springpot.parse_model("kelvin + inertia").owning(["k"], "pad")
    for name in ("inertia.m", "c"):
        model = model.owning([name], "pad")
    assert model.own == {"k": "pad", "c": "pad", "inertia.m": "pad"}


@pytest.mark.soak
def test_a_figure_has_a_row_for_each_specimen(tmp_path, rng: np.random.Generator) -> None:
    omega, pad = np.tile(np.geomspace(1.0, 100.0, 6), 4), np.repeat(list("abcd"), 6)
    k = np.repeat([100.0, 104.0, 98.0, 101.0], 6)
    exact = (k + 2.0j * omega) * (1.0 + 0.003 * rng.standard_normal(24))
    data = springpot.Measurement(omega, exact, labels={"pad": pad})
    figure = springpot.identify(data, "kelvin", own={"*": "pad"}).plot()
    panel = next(axes for axes in figure.axes if axes.get_xlabel() == "k [Pa]")
    assert [each.get_text() for each in panel.get_yticklabels()] == list("abcd")
    assert len(panel.collections[0].get_segments()) == 4
