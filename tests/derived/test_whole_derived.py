"""Quantities of small cases, from the data as from models, as numbers, words and tables."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.derived import quantities
from springpot.errors import SpringpotError
from springpot.identification import fitted_quantities, measured_quantities, value
from springpot.identification.fitted_quantities import DECADE, FINE, OfModel
from springpot.identification.measured_quantities import curves
from springpot.measurement import TimeTest

OMEGA = np.geomspace(0.05, 60.0, 24)
STRAIN = np.geomspace(0.1, 100.0, 25)
SWEEPS = {
    "fluid": ("maxwell", {"k": 100.0, "c": 50.0}, springpot.Units("kPa", "-"), {}),
    "solid": ("zener", {"k1": 10.0, "k2": 90.0, "c": 30.0}, springpot.Units("kN/m", "mm"), {}),
    "power": ("springpot", {"c": 3.0, "alpha": 0.3}, springpot.Units("Pa", "%", "rad/s"), {}),
    "plateau": (
        "maxwell-2",
        {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.03},
        springpot.Units("kN/m", "mm"),
        {"amplitude": 2.0, "temperature": 20.0},
    ),
}


def sweep(case, seed=1):
    expression, values, units, held = SWEEPS[case]
    model, rng = springpot.parse_model(expression), np.random.default_rng(seed)
    noise = 1.0 + 0.01 * (rng.normal(size=24) + 1j * rng.normal(size=24))
    exact = model.stiffness(model.vector(values), OMEGA)
    conditions = {name: np.full(24, value) for name, value in held.items()}
    return springpot.Measurement(
        OMEGA, exact * noise, conditions=conditions, units=units, name=case
    )


def strained(fall=10.0, units=("Pa", "%")):
    """At two frequencies; each softens and flows at strains of its own."""
    rng, parts = np.random.default_rng(2), []
    for at in (fall, 1.5 * fall):
        noise = 1.0 + 0.003 * rng.normal(size=(2, 25))
        storage = 1000.0 / (1.0 + (STRAIN / at) ** 2) * noise[0]
        parts.append(storage + 300.0j / (1.0 + STRAIN / 60.0) * noise[1])
    return springpot.Measurement(
        np.repeat([6.0, 20.0], 25),
        np.concatenate(parts),
        conditions={"amplitude": np.tile(STRAIN, 2)},
        units=springpot.Units(*units),
        name="strained",
    )


@cache
def fitted(case, expression):
    return springpot.identify(sweep(case), expression)


def whole(answer):
    return {**answer.to_dict(), "text": str(answer), "short": repr(answer), "csv": answer.to_csv()}


@pytest.mark.parametrize("case", list(SWEEPS))
def test_quantities_of_data(case, stays):
    stays(whole(quantities(sweep(case))))


@pytest.mark.parametrize(
    ("fall", "units"), [(10.0, ("Pa", "%")), (0.4, ("N/mm", "mm")), (1e4, ("Pa", "-"))]
)
def test_quantities_of_sweeps_of_the_amplitude(fall, units, stays):
    """Which soften within them, before their beginning, and not at all."""
    stays(whole(quantities(strained(fall, units))))


@pytest.mark.parametrize(
    ("case", "expression"),
    [
        ("fluid", "maxwell"),
        ("solid", "zener"),
        ("power", "springpot"),
        ("plateau", "maxwell-2"),
        ("plateau", "material"),
        ("solid", "kelvin"),
    ],
)
def test_quantities_of_a_model(case, expression, stays):
    stays(whole(quantities(fitted(case, expression))), within=1e-3)


def test_a_model_is_asked_beyond_its_data(stays):
    stays(whole(quantities(fitted("fluid", "maxwell"), frequency=300.0)))


def test_a_model_of_the_amplitude_is_asked_at_one(stays):
    data = strained()
    answer = quantities(data, "kelvin + payne", amplitude=3.0, frequency=2.0)
    stays(whole(answer), within=1e-3)


def test_what_says_nothing_by_itself_is_named():
    t = np.geomspace(0.1, 10.0, 20)
    relaxed = TimeTest.of_relaxation(t, np.exp(-t), "kPa", name="relaxed")
    for data in (relaxed, [sweep("fluid"), sweep("solid")]):
        with pytest.raises(SpringpotError, match="by a model: name one"):
            quantities(data)


@pytest.mark.parametrize(
    ("fall", "says"),
    [
        (1e4, "by less than 5 % up to 100 %: no limit"),
        (0.4, "from 0.1 % on: the linear limit lies"),
    ],
)
def test_where_there_is_no_linear_limit_it_says_on_which_side_it_lies(fall, says):
    assert any(f"storage falls {says}" in note for note in quantities(strained(fall)).notes)


def test_each_set_of_conditions_is_a_curve_of_its_own_however_few_points_it_has():
    """Five temperatures and two ages, five points each; a column that goes on parts nothing."""
    kelvins, ages = np.repeat(np.arange(5.0), 10), np.tile(np.repeat([1.0, 7.0], 5), 5)
    held = {"temperature": 20.0 + kelvins, "age": ages, "clock": np.arange(50.0)}
    omega = np.tile(np.geomspace(1.0, 16.0, 5), 10)
    data = springpot.Measurement(omega, (1.0 + 1.0j) * omega, conditions=held)
    found = list(curves(data, "frequency"))
    assert len(found) == 10
    assert [len(each.x) for each in found] == [5] * 10
    told = {(each.at["temperature"], each.at["age"]) for each in found}
    assert len(told) == 10
    assert all("clock" not in each.at for each in found)


def test_places_are_looked_for_at_so_many_of_each_decade():
    grid = OfModel._grid.fget(SimpleNamespace(band=(1.0, 1.0 + 3.0 * DECADE)))
    assert grid[[0, -1]] == pytest.approx([1.0, 1.0 + 3.0 * DECADE])
    assert 0.9 < np.diff(grid)[0] * FINE / DECADE < 1.0
    assert OfModel._grid.fget(SimpleNamespace(band=(1.0, 1.0))).tolist() == [1.0, 1.0]


def test_limits_are_looked_for_decade_by_decade_as_far_as_any_is(monkeypatch):
    asked = []
    slopes = SimpleNamespace(storage_x=np.ones(3))
    monkeypatch.setattr(fitted_quantities, "_flat", lambda slope: asked.append(slope) or 1 / 0)
    model = SimpleNamespace(
        band=(-2.0, 3.0), known=SimpleNamespace(units=None),
        logs=lambda x: asked.append(x / DECADE) or slopes,
    )  # fmt: skip
    with pytest.raises(ZeroDivisionError):
        list(OfModel._limits(model))
    steps = np.arange(fitted_quantities.FARTHEST + 1)
    np.testing.assert_allclose(asked[0], -2.0 / DECADE - steps)
    np.testing.assert_allclose(asked[1], 3.0 / DECADE + steps)


def test_what_has_no_logarithm_is_on_no_curve():
    n = 12
    k, strain = np.full(n, 3.0 + 1.0j), np.arange(1.0, n + 1.0)
    k[2], k[4], strain[6] = 1.0j, 3.0, 0.0
    data = springpot.Measurement(np.full(n, 6.0), k, conditions={"amplitude": strain})
    (sweep,) = curves(data, "amplitude")
    assert np.exp(sweep.x).tolist() == pytest.approx(strain[[0, 1, 3, 5, *range(7, n)]])


@pytest.mark.parametrize(
    ("low", "high", "hertz"),
    [(0.5, 2.0, 1.0), (1.0, 2.0, 1.0), (0.5, 1.0, 1.0), (20.0, 80.0, 40.0), (0.02, 0.05, 0.03),
     (31.0, 33.0, 31.0), (27.0, 28.0, 28.0)],
)  # fmt: skip
def test_a_round_frequency_where_it_was_measured_is_asked_for(low, high, hertz):
    """That of one, else a round one in the middle, on the clock of the data."""
    seen = (2.0 * np.pi * low, 2.0 * np.pi * high)
    assert fitted_quantities.usual(seen, "Hz") == pytest.approx(hertz)
    assert fitted_quantities.usual((low, high), "rad/s") == pytest.approx(hertz / (2.0 * np.pi))


def test_a_value_by_its_logarithm_has_its_interval_and_one_without_end_is_open():
    found = value.in_logarithm(np.log(3.0), np.log(2.0), "s", 10.0)
    assert (found.value, found.low, found.high) == pytest.approx((30.0, 15.0, 60.0))
    found = value.in_logarithm(np.log(3.0), np.inf, "s")
    assert (found.low, found.high, found.unit) == (0.0, np.inf, "s")


@pytest.mark.parametrize(
    ("units", "factor", "unit"),
    [
        (("kPa", "%"), 0.1, "J/m^3"),
        (("kN/m", "mm"), 1e-3, "J"),
        (("kN/m", "-"), 1.0, "kN/m -^2"),
        (("kPa", "mm"), 1.0, "kPa mm^2"),
    ],
)
def test_the_energy_of_a_cycle_has_the_unit_of_its_sizes(units, factor, unit):
    assert value.energy_unit(springpot.Units(*units)) == (pytest.approx(factor), unit)


@pytest.mark.parametrize(("each", "count"), [(5, 2), (4, 1)])
def test_levels_of_any_column_are_curves_of_their_own_where_each_has_points_enough(each, count):
    omega = np.tile(np.geomspace(1.0, 10.0, each), 2)
    data = springpot.Measurement(
        omega, (3.0 + 1.0j) * omega, conditions={"batch": np.repeat([1.0, 2.0], each)}
    )
    groups = list(measured_quantities._groups(data, {"batch": data.conditions["batch"]}))
    assert [len(rows) for rows in groups] == [2 * each // count] * count


def test_a_crossover_is_looked_for_three_decades_beyond_the_data(monkeypatch):
    """Of a model with a name; a free spectrum ends with what was measured."""
    asked = []
    monkeypatch.setattr(
        fitted_quantities, "OfModel", lambda *given, **more: asked.append(given[2]) or 1 / 0
    )
    fit = springpot.identify("artificial-hidden", "kelvin")
    low, high = np.log(2.0 * np.pi * np.array([0.5, 100.0]))
    for free, beyond in ((False, 3.0 * DECADE), (True, 0.0)):
        monkeypatch.setattr(fitted_quantities, "is_material", lambda model, free=free: free)
        with pytest.raises(ZeroDivisionError):
            fitted_quantities.of_fit(fit, "any", ())
        assert asked.pop() == pytest.approx((low - beyond, high + beyond))
