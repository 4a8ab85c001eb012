"""Quantities that follow from a fit or from data: exact where a formula is known, and covered."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.derived import quantities
from springpot.distributions import student
from springpot.errors import SpringpotError
from springpot.identification.measured_quantities import AROUND, _plateau, linear_limit
from springpot.report.told import told

OMEGA = np.geomspace(0.01, 100.0, 30)
KN = springpot.Units("kN/m", "mm")


def sweep(expression, values, noise=0.0, seed=1, units=None, omega=OMEGA, **conditions):
    """Data of a model whose parameters are known."""
    model, rng = springpot.parse_model(expression), np.random.default_rng(seed)
    size = len(omega)
    scatter = 1.0 + noise * (rng.normal(size=size) + 1j * rng.normal(size=size))
    columns = {name: np.full(size, value) for name, value in conditions.items()}
    return springpot.Measurement(
        omega,
        model.stiffness(model.vector(values), omega) * scatter,
        conditions=columns,
        units=units or springpot.Units(),
    )


def fractional_crossover(k, c, alpha):
    """Where k / (1 + u e^(-i alpha pi/2)), u = k / (c omega^alpha), has equal parts."""
    angle = 0.5 * np.pi * alpha
    u = 1.0 / (np.sin(angle) - np.cos(angle))
    return (k / c / u) ** (1.0 / alpha), k * (1.0 + u * np.cos(angle)) / abs(
        1.0 + u * np.exp(1j * angle)
    ) ** 2


OMEGA_X, G_X = fractional_crossover(100.0, 50.0, 0.6)
EXACT = [
    (
        "maxwell",
        {"k": 100.0, "c": 50.0},
        {
            "crossover frequency": 1.0 / np.pi,
            "crossover modulus": 50.0,
            "zero-shear viscosity": 50.0,
            "mean relaxation time": 0.5,
            "instantaneous modulus": 100.0,
            "loss factor": 1.0 / np.pi,
        },
    ),
    (
        "fractional-maxwell",
        {"k": 100.0, "c": 50.0, "alpha": 0.6},
        {
            "crossover frequency": OMEGA_X / (2.0 * np.pi),
            "crossover modulus": G_X,
            "instantaneous modulus": 100.0,
        },
    ),
    (
        "zener",
        {"k1": 10.0, "k2": 90.0, "c": 30.0},
        {
            "equilibrium modulus": 10.0,
            "instantaneous modulus": 100.0,
            "mean relaxation time": 1.0 / 3.0,
        },
    ),
    (
        "maxwell-2",
        {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.01},
        {"zero-shear viscosity": 30.06, "mean relaxation time": 300.0006 / 30.06},
    ),
    # With a = c1 / c2 its loss factor a u + (1 + a) / u is least at u^2 = (1 + a) / a.
    ("jeffreys", {"c1": 0.1, "k": 3.0, "c2": 0.8}, {"zero-shear viscosity": 0.9, "plateau": 2.7}),
]


@pytest.mark.parametrize(("expression", "values", "expected"), EXACT)
def test_formulas_of_models_are_met(expression, values, expected):
    found = quantities(sweep(expression, values), expression, frequency=1.0)
    for name, value in expected.items():
        assert found[name].value == pytest.approx(value, rel=1e-5), name


def test_a_solid_has_no_viscosity_and_a_power_law_no_time():
    solid = quantities(sweep("kelvin", {"k": 3.0, "c": 1.0}), "kelvin")
    names = {row.name for row in solid}
    assert "equilibrium modulus" in names
    assert not names & {"zero-shear viscosity", "instantaneous modulus", "mean relaxation time"}
    power = quantities(sweep("springpot", {"c": 3.0, "alpha": 0.3}), "springpot")
    assert not any("rest" in row.says for row in power)
    assert any("power of the frequency" in note for note in power.notes)


@pytest.mark.parametrize(
    ("expression", "values", "told"),
    [
        ("springpot", {"c": 7.0, "alpha": 0.22}, False),
        ("maxwell-2", {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.01}, True),
    ],
)
def test_lines_of_a_spectrum_make_no_plateau_by_themselves(expression, values, told):
    """Between two of them the loss factor dips, by less than it is uncertain."""
    names = {row.name for row in quantities(sweep(expression, values, noise=0.02), "material")}
    assert ("plateau" in names) == told


@pytest.mark.soak_cases("plateau-maxwell-2-values2")
@pytest.mark.parametrize(
    ("name", "expression", "values"),
    [
        ("crossover frequency", "fractional-maxwell", {"k": 100.0, "c": 50.0, "alpha": 0.6}),
        ("crossover modulus", "fractional-maxwell", {"k": 100.0, "c": 50.0, "alpha": 0.6}),
        ("plateau", "maxwell-2", {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.01}),
        ("mean relaxation time", "zener", {"k1": 10.0, "k2": 90.0, "c": 30.0}),
        ("|G*|", "zener", {"k1": 10.0, "k2": 90.0, "c": 30.0}),
    ],
)
def test_intervals_are_those_of_the_parameters(name, expression, values):
    """By differences of the whole quantity along each parameter."""
    fit = springpot.identify(sweep(expression, values, noise=0.01), expression)
    logs = []
    for i in range(len(fit.theta)):
        for sign in (-1.0, 1.0):
            theta = fit.theta * np.where(np.arange(len(fit.theta)) == i, 1.0 + sign * 1e-4, 1.0)
            moved = {name: float(value) for name, value in zip(fit.model.names, theta, strict=True)}
            # All that has a formula is a function of the parameters alone.
            exact = springpot.identify(sweep(expression, moved), expression)
            logs.append(np.log(quantities(exact, frequency=1.0)[name].value))
    slopes = (np.array(logs[1::2]) - np.array(logs[::2])) / (2e-4 * fit.theta)
    reach = student(0.95, fit.dof) * np.sqrt(slopes @ fit.covariance @ slopes)
    found = quantities(fit, frequency=1.0)[name]
    assert np.log(found.high / found.value) == pytest.approx(reach, rel=0.01)


@pytest.mark.soak
def test_intervals_cover():
    """Of 80 series: within three deviations of 95 %, from the data as from the model."""
    hits = {"model": 0, "data": 0}
    for seed in range(80):
        data = sweep("fractional-maxwell", {"k": 100.0, "c": 50.0, "alpha": 0.6}, 0.01, seed)
        for model in ("fractional-maxwell", None):
            found = quantities(data, model)["crossover frequency"]
            inside = found.low <= OMEGA_X / (2.0 * np.pi) <= found.high
            hits["data" if model is None else "model"] += inside
    assert all(count >= 0.875 * 80 for count in hits.values()), hits


@pytest.mark.soak
def test_the_linear_limit_is_covered():
    """Of a softening that is not the curve that is fitted."""
    x, rng = np.log(np.geomspace(1e-4, 1.0, 33)), np.random.default_rng(3)
    exact = -np.log1p((np.exp(x) / 0.05) ** 1.2)
    truth, hits = np.log(0.05) + np.log(0.05 / 0.95) / 1.2, 0
    for _ in range(120):
        found = linear_limit(x, exact + 0.01 * rng.normal(size=len(x)))
        assert found is not None
        place, error, dof = found
        hits += abs(place - truth) <= student(0.95, dof) * error
    assert 0.89 * 120 <= hits < 120


def test_a_sweep_of_the_amplitude_says_limit_yield_and_flow():
    strain = np.geomspace(0.1, 100.0, 31)  # in %
    storage = 1000.0 / (1.0 + (strain / 10.0) ** 2)
    loss = 300.0 / (1.0 + strain / 60.0)
    data = springpot.Measurement(
        np.full(31, 6.0),
        storage + 1j * loss,
        conditions={"amplitude": strain},
        units=springpot.Units("Pa", "%"),
    )
    found = quantities(data)
    limit = 10.0 * np.sqrt(0.05 / 0.95)
    assert found["linear limit"].value == pytest.approx(limit, rel=0.02)
    assert found["linear limit"].unit == "%"
    at_limit = abs(950.0 + 300.0j / (1.0 + limit / 60.0)) * 0.01 * limit
    assert found["yield stress"].value == pytest.approx(at_limit, rel=0.02)
    flow = found["flow point"].value
    solid = 1000.0 / (1.0 + (flow / 10.0) ** 2)
    assert solid == pytest.approx(300.0 / (1.0 + flow / 60.0), rel=0.02)
    assert all(row.source == "data" for row in found)


def test_energy_of_a_cycle_is_in_joule():
    """Pi K'' X^2: of 4 kN s/m at 3 mm and 1 Hz."""
    data = sweep("kelvin", {"k": 100.0, "c": 4.0}, units=KN, amplitude=3.0)
    for model in ("kelvin", None):
        found = quantities(data, model, frequency=1.0)["energy of a cycle"]
        expected = np.pi * 4000.0 * 2.0 * np.pi * 0.003**2
        assert (found.value, found.unit) == (pytest.approx(expected, rel=1e-3), "J")


def test_each_row_says_who_says_it_and_whether_it_was_measured():
    data = sweep("maxwell", {"k": 100.0, "c": 50.0}, noise=0.01)
    rows = {row.name: row for row in quantities(data, "maxwell", frequency=1000.0)}
    assert not rows["crossover frequency"].outside
    assert rows["zero-shear viscosity"].outside
    assert rows["loss factor"].outside
    assert {row.source for row in rows.values()} == {"model"}
    with pytest.raises(KeyError, match="crossover frequency"):
        quantities(data)["zero-shear viscosity"]


def test_a_free_spectrum_ends_with_the_data():
    found = quantities(sweep("maxwell", {"k": 100.0, "c": 50.0}, noise=0.01), "material")
    assert found["crossover modulus"].value == pytest.approx(50.0, rel=0.05)
    assert not any(row.outside for row in found)
    assert any("ends with the data" in note for note in found.notes)


def test_the_answer_of_a_kept_fit_is_the_same(tmp_path):
    fit = springpot.identify(sweep("maxwell", {"k": 100.0, "c": 50.0}, 0.01, units=KN), "maxwell")
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again, first = quantities(path, frequency=1.0), quantities(fit, frequency=1.0)
    assert [row.value for row in again] == [row.value for row in first]
    assert "crossover stiffness" in {row.name for row in again}
    answer = json.loads(json.dumps(again.to_dict(), allow_nan=False))
    assert answer["schema"] == "springpot.quantities/1"
    assert answer["quantities"][0]["source"] == "model"
    assert again.to_csv().splitlines()[1].startswith("crossover frequency,")


def test_a_condition_that_the_model_needs_is_asked_for():
    """All but the temperature, which is that at which shifts are one."""
    data = springpot.read("nist-srm2491")
    found = quantities(data, "maxwell + wlf-shift")
    assert {row.at["temperature"] for row in found} == {20.0}
    strained = sweep("kelvin", {"k": 100.0, "c": 2.0}, amplitude=1.0)
    strained = replace(strained, conditions={"amplitude": np.geomspace(1.0, 5.0, len(OMEGA))})
    with pytest.raises(SpringpotError, match="amplitude="):
        quantities(strained, "kelvin + payne")
    fit = springpot.identify(strained, "kelvin + payne")
    assert not fit.quantities.rows
    assert "amplitude=" in fit.quantities.notes[0]


@pytest.mark.soak
@pytest.mark.parametrize("power", [0.8, 2.4])
def test_the_error_of_a_linear_limit_is_what_it_scatters_by(power):
    x, rng = np.log(np.geomspace(1e-4, 1.0, 33)), np.random.default_rng(3)
    exact = -np.log1p((np.exp(x) / 0.05) ** power)
    found = [linear_limit(x, exact + 0.01 * rng.normal(size=len(x))) for _ in range(60)]
    places, errors, _ = np.array(found).T
    assert 0.8 < np.std(places) / np.sqrt(np.mean(errors**2)) < 1.25


@pytest.mark.soak
def test_the_interval_of_a_plateau_holds_the_error_of_its_place():
    x, rng, logs, reach = np.linspace(-2.0, 2.0, 30), np.random.default_rng(3), [], []
    for _ in range(60):
        noise = 0.01 * rng.normal(size=(2, 30))
        storage = 1.0 + 5.0 * x + noise[0]
        loss = storage - 1.0 + 0.2 * (x - 0.3) ** 2 + noise[1]
        measured = SimpleNamespace(storage=storage, loss=loss, at={})
        [found] = _plateau(x, measured, SimpleNamespace(units=springpot.Units()))
        logs.append(np.log(found.value.value))
        reach.append(np.log(found.value.high / found.value.value))
    spread = np.sqrt(np.mean(np.square(reach))) / student(0.95, AROUND - 3)
    assert 0.8 < np.std(logs) / spread < 1.25


def test_what_never_rises_as_the_square_has_no_mean_relaxation_time():
    """Storage of a dashpot held by a springpot rises as omega^1.5: its times have no mean."""
    data = sweep("fractional-solid", {"k": 10.0, "c1": 30.0, "c2": 90.0, "alpha": 0.5})
    names = {each.name for each in quantities(springpot.identify(data, "fractional-solid"))}
    assert "equilibrium modulus" in names
    assert "mean relaxation time" not in names


@pytest.mark.soak
def test_a_place_far_outside_of_a_sweep_overflows_nothing():
    """On the way from scatter, or from far jumps, the power of the amplitude grows without end."""
    rng = np.random.default_rng(1)
    for _ in range(15):
        n = rng.integers(5, 14)
        x = np.sort(rng.uniform(-5.0, 5.0, n)) * rng.choice([1.0, 5.0])
        found = linear_limit(x, rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=n))
        assert found is None or x[0] < found[0] < x[-1]


def test_an_answer_has_the_quantities_of_its_material_alone(tmp_path):
    """A mass and a delay would make crossovers of their own, at no frequency of the material."""
    fit = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    assert fit.quantities.without == ("inertia", "time-delay")
    names = [row.name for row in fit.quantities]
    assert names == ["instantaneous stiffness", "|K|", "loss factor"]
    file = tmp_path / "fit.json"
    file.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    assert springpot.load(file).to_dict()["quantities"] == fit.to_dict()["quantities"]
    short, whole = told(fit), told(fit, verbose=True)
    assert "loss factor" in short
    assert "instantaneous" not in short
    assert "quantity: of the material, without inertia, time-delay; at 1 Hz" in short
    assert "model, outside" in whole


@pytest.mark.soak
def test_a_diagnosis_tells_quantities_of_an_adequate_model_only():
    ladder = springpot.discover("artificial-hidden", "fractional-maxwell + inertia")
    assert ladder.steps[0].diagnosis.quantities is None
    assert "quantities" not in ladder.steps[0].diagnosis.to_dict()
    last = ladder.diagnosis
    assert last.verdict == "adequate"
    assert "loss factor" in str(ladder)
    again = type(last).from_dict(json.loads(json.dumps(last.to_dict())))
    assert again.quantities.rows == last.quantities.rows
    assert again.quantities.without == ("inertia", "time-delay")


def test_a_curve_that_does_not_fall_has_no_limit():
    """No power follows it, and from one step to the next it grew beyond all numbers."""
    storage = np.array([4.4886772, 4.4679704, 4.53676006, 4.51014181, 4.5284023])
    assert linear_limit(np.log(np.geomspace(0.1, 1.0, 5)), storage) is None


def test_of_a_liquid_that_creeps_a_free_spectrum_gives_no_loss_factor():
    """Storage is that of the last of its times, which no share of the spectrum moves."""
    clock = np.geomspace(0.01, 0.03, 30)
    noise = 1.0 + 0.03 * np.random.default_rng(1).normal(size=len(clock))
    creep = springpot.TimeTest.of_compliance(clock, 2.0 * clock * noise, "Pa")
    found = quantities(creep, "material")
    told_of = {row.name: row.value for row in found.rows}
    assert "loss factor" not in told_of
    assert "the loss factor is not bounded by these data" in found.notes
    assert told_of["|G*|"].low < told_of["|G*|"].value < told_of["|G*|"].high
