"""One engine: the constants of a law are those of a model with it, whichever command asks.

Where not, it is said.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sweeps import C1, C2, LOG_A, REFERENCE, TEMPERATURES, material, measured, simple

import springpot
from springpot.identification import fit
from springpot.identification.free_factors import FactorRows, factors_of
from springpot.identification.known_factors import allowed_shifts, refused_in_words
from springpot.identification.levels_alone import each_alone
from springpot.identification.problem import relative_objective
from springpot.registry import plugins
from springpot.rheology.levels import Levels
from springpot.superposition import laws

pytestmark = pytest.mark.usefixtures("asked_once")


def wlf_of(curve):
    (law,) = [one for one in curve.laws if one.law.name == "WLF"]
    return law


def constants(parameters):
    found = [parameters[f"wlf-shift.{name}"] for name in ("C1", "C2")]
    return np.array([[each.value, each.low, each.high] for each in found])


def without_lift(i, omega):
    return material(omega * np.exp(LOG_A[i]))


def off_the_law(i, omega):
    """Each level is off the law by itself, as real materials are, by far more than its scatter."""
    return material(omega * np.exp(LOG_A[i] + 0.3 * np.sin(2.0 * i)))


@pytest.mark.soak
@pytest.mark.parametrize("sweep", [without_lift, off_the_law, simple])
def test_a_shift_alone_has_one_answer_in_all_commands(sweep):
    """With `simple` the missing vertical factors bend the shift; then too it is one answer."""
    data = measured(sweep, seed=3)
    law = wlf_of(springpot.mastercurve(data, vertical=False))
    ours = np.column_stack([law.values, law.low, law.high])
    np.testing.assert_allclose(
        ours, constants(springpot.identify(data, "material + wlf-shift").parameters), rtol=2e-3
    )


@pytest.mark.soak
def test_diagnose_gives_the_constants_of_the_curve():
    data = measured(without_lift, seed=3)
    law = wlf_of(springpot.mastercurve(data, vertical=False))
    found = constants(springpot.diagnose(data, "material + wlf-shift").parameters)
    width = law.high - law.low
    np.testing.assert_allclose(found[:, 0], law.values, atol=0.1 * width.max(), rtol=0.02)
    assert np.all(np.abs(np.log((found[:, 2] - found[:, 1]) / width)) < np.log(1.5))


@pytest.mark.soak
def test_vertical_factors_have_one_answer_too():
    data = measured(simple)
    law = wlf_of(springpot.mastercurve(data))
    found = constants(
        springpot.identify(data, "material + wlf-shift + free-vertical-shift").parameters
    )
    np.testing.assert_allclose(found, np.column_stack([law.values, law.low, law.high]), rtol=0.01)


@pytest.mark.soak
def test_it_is_said_where_a_model_without_vertical_factors_has_another_law():
    data = measured(simple)
    (note,) = [note for note in springpot.mastercurve(data).notes if "no vertical factors" in note]
    c1 = springpot.identify(data, "material + wlf-shift").parameters["wlf-shift.C1"]
    assert f"C1 {c1.value:.4g}" in note
    plain = springpot.mastercurve(measured(without_lift, noise=0.01, seed=1))
    assert not [note for note in plain.notes if "no vertical factors" in note]


@pytest.mark.soak
def test_a_law_that_its_levels_depart_from_is_known_as_nearly_as_they_scatter():
    """Ten times the points a level would else shrink an interval that never held the truth."""
    few, many = (
        constants(
            springpot.identify(measured(off_the_law, points=n), "material + wlf-shift").parameters
        )
        for n in (13, 52)
    )
    for found in (few, many):
        assert np.all((found[:, 1] <= [C1, C2]) & (found[:, 2] >= [C1, C2]))
    assert (many[0, 2] - many[0, 1]) > 0.7 * (few[0, 2] - few[0, 1])


@pytest.mark.soak_cases("without_lift")
@pytest.mark.parametrize("sweep", [without_lift])
def test_constants_hold_the_truth_as_often_as_they_say(sweep):
    """12 series: 95 % of 12 intervals of C1, less three standard deviations of that count."""
    held = []
    for seed in range(12):
        law = wlf_of(springpot.mastercurve(measured(sweep, noise=0.01, seed=seed), vertical=False))
        held.append(law.low[0] <= C1 <= law.high[0])
    assert np.mean(held) >= 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / 12)


def test_a_law_that_shifts_sweeps_apart_which_have_moduli_in_common_is_refused():
    """As WLF far below the glass transition: near its pole it goes through a hundred decades."""
    data = measured(simple)
    curve = springpot.mastercurve(data)
    rows = FactorRows.of(curve.fit)
    own = each_alone(data, rows.number, curve.fit.objective)
    allowed = allowed_shifts(data, rows.elements[0], factors_of(rows).log_b[rows.number], own)
    assert allowed.broken_by(curve.factors.log_a) == ""
    steep = curve.factors.log_a.copy()
    steep[0] += np.log(10.0) * 108.0
    assert "moduli in common" in allowed.broken_by(steep)
    assert "0 degC and 15 degC apart by" in allowed.broken_by(steep)
    assert "endless" in allowed.broken_by(np.where(np.arange(5) == 0, np.inf, steep))


def test_sweeps_on_a_plateau_may_be_shifted_further_than_they_are_wide():
    """|K| rises there by less than it scatters: what they have in common is their scatter."""
    decades = np.array([0.0, 3.0])
    omega, number = np.tile(np.geomspace(1.0, 30.0, 20), 2), np.repeat([0, 1], 20)
    s = 1j * omega * 10.0 ** (1.0 + decades[number])
    gain = 1.0 + np.random.default_rng(3).normal(0.0, 0.01, 40)
    data = springpot.Measurement(
        omega,
        gain * s / (1.0 + s),
        conditions={"temperature": 20.0 - 10.0 * number},
    )
    levels = Levels("temperature").bound_to(data.points)
    own = each_alone(data, 1 - number, relative_objective())
    allowed = allowed_shifts(data, levels, np.zeros(40), own)
    assert allowed.broken_by(np.log(10.0) * decades[::-1]) == ""


def test_a_law_beyond_its_pole_is_told_with_the_model():
    """C2 = 31 K from 30 degC: a kelvin below the coldest level, where it shifts by 735 decades."""
    data = measured(simple)
    best = fit(springpot.parse_model("material + wlf-shift"), data)
    assert list(refused_in_words(best)) == []
    frozen = best.theta.copy()
    frozen[-2:] = 24.5, 31.0
    (note,) = refused_in_words(replace(best, theta=frozen))
    assert "0 to 0 degC" in note
    assert "none of a material" in note


@pytest.mark.soak
def test_the_reference_of_the_laws_is_that_of_the_curve():
    moved = wlf_of(springpot.mastercurve(measured(simple), reference=60.0))
    at_30 = wlf_of(springpot.mastercurve(measured(simple)))
    # C2 and C1 C2 carry over from one reference to another: C2' = C2 + T' - T, C1' C2' = C1 C2.
    assert moved.values[1] == pytest.approx(at_30.values[1] + 30.0, rel=0.01)
    assert moved.values.prod() == pytest.approx(at_30.values.prod(), rel=0.01)
    assert TEMPERATURES[REFERENCE] == 30.0
    assert {law.name for law in laws.LAWS} >= {"WLF", "VFT", "Arrhenius"}


def factors(parameters):
    found = [value for name, value in parameters.items() if name.startswith("free-shift.")]
    return np.array([[each.value, each.low, each.high] for each in found])


@pytest.mark.soak
def test_free_factors_have_one_answer_in_all_commands():
    """One level scatters more than twice as much: its interval is wider, and no other's."""
    calm = measured(without_lift, noise=0.004, seed=4)
    rough = measured(without_lift, noise=0.01, seed=4)
    there = calm.conditions["temperature"] == 60.0
    data = replace(calm, stiffness=np.where(there, rough.stiffness, calm.stiffness))
    levels = [one for one in springpot.mastercurve(data, vertical=False).levels if one.value != 30]
    ours = np.array([[one.a, one.a_low, one.a_high] for one in levels])
    found = springpot.identify(data, "material + free-shift").parameters
    np.testing.assert_allclose(factors(found), ours, rtol=1e-6)
    by_name = factors(springpot.identify(data, "fractional-zener + free-shift").parameters)
    width = np.log(by_name[:, 2] / by_name[:, 1])
    assert width[3] > 1.5 * width[:3].max()


def frozen(i, omega):
    """Below the glass transition nothing moves any more; above, faster than sweeps overlap."""
    return material(omega * np.exp([9.0, 9.0, 8.9, 5.0, -4.0][i]))


@pytest.mark.soak
def test_a_law_that_no_material_could_follow_is_refused_in_all_commands():
    data = measured(frozen, seed=1)
    curve = springpot.mastercurve(data, vertical=False)
    assert not [law for law in curve.laws if law.law.name == "WLF"]
    found = springpot.identify(data, "material + wlf-shift")
    assert [note for note in found.notes if note.startswith("wlf-shift is refused: it ")]
    (c1,) = [value for name, value in found.parameters.items() if name.endswith("C1")]
    assert (c1.low, c1.high) == (0.0, 200.0)


@pytest.mark.soak
def test_a_law_that_no_material_could_follow_is_not_named_as_missing():
    data = measured(frozen, seed=1)
    named = [one.effect for one in springpot.diagnose(data, "material").candidates]
    assert named[0] != "wlf-shift"


def of_one_time(i, omega):
    """A single Maxwell element beside a spring: its line lies between those of any lattice."""
    celsius = TEMPERATURES[i] - 30.0
    x = omega * np.exp(-np.log(10.0) * 17.44 * celsius / (81.6 + celsius))
    return springpot.parse_model("zener").stiffness(np.array([1.0, 20.0, 3.0]), x)


def cost(data, expression):
    return fit(springpot.parse_model(expression), data).cost


SHARED = Path(__file__).parents[3] / "shared" / "data"
SWEEPS = SHARED / "polystyrene-three-tests"
FILES = {
    "nist": "nist-srm2491",
    "polyisoprene": "reptate-polyisoprene-osc@molar_mass=33.6",
    "tape": "3m-468mp-acrylic-tts",
    "bitumen": "fhwa-ptf-binder-dsr@lane=1",
    "bitumen of lane 5": "fhwa-ptf-binder-dsr@lane=5",
    "rubber": "elastomer-epdm-70-dma-payne@run=tf_015p",
    "polystyrene": [
        f"{SWEEPS}/oscillation_ps{t}_data.csv?temperature={t}[degC],storage=Pa,loss=Pa"
        for t in (130, 145, 160, 175, 190)
    ],
}


def rows_of(found, start):
    one = [value for name, value in found.parameters.items() if name.startswith(start)]
    return np.array([[each.value, each.low, each.high] for each in one])


@pytest.fixture
def shared(monkeypatch):
    """Folders of data sets are read when the plugins are loaded, which happens once."""
    monkeypatch.setenv("SPRINGPOT_DATA", str(SHARED))
    plugins.cache_clear()
    yield
    plugins.cache_clear()


@pytest.mark.soak
@pytest.mark.usefixtures("asked_once")
@pytest.mark.parametrize("name", list(FILES))
def test_measured_files_have_one_answer_in_all_commands(name, shared):
    """Factors of frequency and stiffness, constants, and their intervals, to the last digit."""
    if name != "nist" and not SHARED.is_dir():
        pytest.skip("the data stand beside the project's folder")
    curve = springpot.mastercurve(FILES[name])
    free = springpot.identify(FILES[name], "material + free-shift + free-vertical-shift")
    levels = [one for one in curve.levels if one.value != curve.reference]
    ours = np.array([[one.a, one.a_low, one.a_high] for one in levels])
    np.testing.assert_allclose(rows_of(free, "free-shift."), ours, rtol=1e-9)
    ours = np.array([[one.b, one.b_low, one.b_high] for one in levels])
    np.testing.assert_allclose(rows_of(free, "free-vertical-shift."), ours, rtol=1e-9)
    law = wlf_of(curve)
    found = springpot.identify(FILES[name], "material + wlf-shift + free-vertical-shift")
    ours = np.column_stack([law.values, law.low, law.high])
    np.testing.assert_allclose(rows_of(found, "wlf-shift."), ours, rtol=1e-9)


@pytest.mark.soak
def test_diagnose_tells_the_constants_of_the_curve():
    """Of the model that is judged, and of a law that is proposed."""
    names = ("Arrhenius", "WLF")
    curve = springpot.mastercurve("nist-srm2491", vertical=False)
    laws = {law.law.name: law for law in curve.laws if law.law.name in names}
    answer = springpot.diagnose("nist-srm2491", only=["arrhenius-shift", "wlf-shift"])
    for name, effect in zip(names, ("arrhenius-shift", "wlf-shift"), strict=True):
        (found,) = [each for each in answer.candidates if each.effect == effect]
        ours = np.column_stack([laws[name].values, laws[name].low, laws[name].high])
        theirs = [[v.value, v.low, v.high] for v in found.parameters.values()]
        np.testing.assert_allclose(theirs, ours, rtol=1e-3)


@pytest.mark.suite_cases("wlf-shift-")
@pytest.mark.parametrize("lift", ["", " + free-vertical-shift"])
@pytest.mark.parametrize("law", ["wlf-shift", "arrhenius-shift"])
def test_free_factors_end_no_higher_than_the_laws_that_they_contain(law, lift):
    data = measured(of_one_time, seed=3, points=9)
    free = cost(data, f"material + free-shift{lift}")
    assert free <= cost(data, f"material + {law}{lift}") * (1.0 + 1e-9)


@pytest.mark.soak
def test_free_factors_go_as_far_as_a_law():
    """Sixteen decades from the level of reference: an end of the search there was above the law."""
    celsius, omega = np.linspace(0.0, 100.0, 21), np.geomspace(0.1, 10.0, 7)
    log_a = -np.log(10.0) * 17.44 * celsius / (51.6 + celsius)
    log_a = 1.6 * (log_a - log_a[10])
    clean = np.concatenate([material((1e4 * omega * np.exp(a)) ** 0.2) for a in log_a])
    random = np.random.default_rng(5)
    error = 0.003 * (random.normal(size=len(clean)) + 1j * random.normal(size=len(clean)))
    data = springpot.Measurement(
        np.tile(omega, 21),
        clean * (1.0 + error),
        conditions={"temperature": np.repeat(celsius, 7)},
    )
    assert np.abs(log_a).max() > 12.0 * np.log(10.0)
    free, law = (cost(data, f"material + {name}") for name in ("free-shift", "wlf-shift"))
    assert free <= law * (1.0 + 1e-9)


@pytest.mark.soak
def test_lines_and_factors_come_to_rest_together():
    """Line after factor and factor after line, the error stayed at 1.5 x that of the noise."""
    temperatures, omega = np.linspace(0.0, 100.0, 11), np.geomspace(0.1, 10.0, 9)
    log_a = -np.log(10.0) * 12.0 * (temperatures - 30.0) / (50.0 + temperatures)
    model, theta = springpot.parse_model("zener"), np.array([1.0, 20.0, 3.0])
    clean = np.concatenate([model.stiffness(theta, omega * np.exp(a)) for a in log_a])
    random = np.random.default_rng(3)
    error = 0.005 * (random.normal(size=len(clean)) + 1j * random.normal(size=len(clean)))
    data = springpot.Measurement(
        np.tile(omega, 11),
        clean * (1.0 + error),
        conditions={"temperature": np.repeat(temperatures, 9)},
    )
    least = float(np.sum(np.abs(error) ** 2))
    for expression in ("wlf-shift", "free-shift", "free-shift + free-vertical-shift"):
        assert cost(data, f"material + {expression}") < 1.1 * least
