"""What an explanation pays for its parameters, and what it leaves to others that look the same."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_data import AMPLITUDES, KELVIN, SWEEP, design, exact, hidden, measured

import springpot
from soaked import soaked
from springpot.diagnosis import examine
from springpot.diagnosis.evidence import Evidence, Explanation
from springpot.diagnosis.experiment import actions, planned_sweep
from springpot.diagnosis.grown import Grown
from springpot.diagnosis.marginal import _refund
from springpot.identification import Window, shown
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.numerics import orthonormal
from springpot.registry import plugins
from springpot.report.ladder_text import doubt_text
from springpot.rheology.points import real_form

WARM = design(8, temperatures=(15.0, 25.0, 35.0))
NARROW = design(60, 0.1, 100.0)


def examined(data, model=KELVIN.name):
    library = list(plugins().items("effect"))
    return examine(data, springpot.parse_model(model), library, np.random.default_rng(0))


@pytest.mark.soak
@pytest.mark.parametrize("effect", ["arrhenius-shift", "wlf-shift"])
def test_a_parameter_that_the_data_do_not_determine_costs_next_to_nothing(effect):
    """Over 20 K the free volume's second constant is anyone's guess.

    Neither law may be called unlikely for it.
    """
    chances = examined(hidden(KELVIN, WARM, effect, 3000.0)).evidence.effects
    assert chances["arrhenius-shift"] + chances["wlf-shift"] > 0.9
    assert min(chances["arrhenius-shift"], chances["wlf-shift"]) > 0.05


@pytest.mark.soak
def test_a_richer_effect_that_has_become_a_simpler_one_pays_all_the_same():
    chances = examined(hidden(KELVIN, AMPLITUDES, "friction", 3000.0)).evidence.effects
    assert chances["friction"] > 0.8
    assert chances["elasto-sliding"] < 0.1


@pytest.mark.parametrize(
    ("model", "effect", "whole"),
    [
        ("fractional-kelvin-voigt", "relaxation-mode", False),
        ("kelvin", "relaxation-mode", True),
        ("fractional-kelvin-voigt", "parallel-dashpot", True),
    ],
)
def test_one_part_more_of_a_broad_spectrum_may_be_another_shape_of_it(model, effect, whole):
    base, part = springpot.parse_model(model), plugins().effect(effect)
    grown = Grown((part,), SimpleNamespace(model=base + part), 0.0)
    assert grown.broadens_an_order is not whole
    assert Explanation(grown, 1.0).one_spectrum is not whole


def parameter(model, name):
    return next(p for p in springpot.parse_model(model).parameters if p.name == name)


def inside(value, ends):
    low, high = ends
    return low < value < high


def test_a_time_shows_within_the_measured_ones():
    window = Window.of(measured(SWEEP, exact(KELVIN, SWEEP)))
    tau = parameter("kelvin + relaxation-mode", "relaxation-mode.tau")
    fastest, slowest = 1.0 / SWEEP.omega.max(), 1.0 / SWEEP.omega.min()
    times = (fastest / 10, 2 * fastest, slowest / 2, slowest * 10)
    assert [inside(x, shown(tau, window)) for x in times] == [False, True, True, False]


def test_an_order_shows_away_from_its_bounds():
    window = Window.of(measured(SWEEP, exact(KELVIN, SWEEP)))
    alpha = parameter("kelvin + parallel-springpot", "parallel-springpot.alpha")
    assert [inside(x, shown(alpha, window)) for x in (0.0, 0.5, 1.0)] == [False, True, False]


def resonant(at, hertz=12.0, zeta=0.05, stiffness=3000.0):
    r = at.omega / (2.0 * np.pi * hertz)
    return 1.0 / (1.0 / exact(KELVIN, at) + 1.0 / (stiffness * (1.0 - r**2 + 2j * zeta * r)))


@pytest.fixture(scope="module")
def rungs():
    """The model alone, and with the resonance that is there."""
    data = measured(NARROW, resonant(NARROW), level=0.003)
    return springpot.discover(data, KELVIN.name, accept=["frame-resonance"]).steps


@pytest.mark.soak
def test_what_looks_like_a_resonance_may_be_another_narrow_feature(rungs):
    case = rungs[0].case
    for each in (Evidence.of(case.search), case.evidence):
        explained = sum(one.probability for one in each.explanations)
        assert each.nothing + each.unknown + explained == pytest.approx(1.0)
        assert each.effects["frame-resonance"] == pytest.approx(7.0 / 3.0 * each.narrow)


def test_the_doubt_about_a_narrow_effect_is_not_its_partners():
    effects = [plugins().effect(name) for name in ("inertia", "frame-resonance")]
    pair = Explanation(SimpleNamespace(names=("a", "b"), effects=effects), 0.8)
    data = measured(SWEEP, exact(KELVIN, SWEEP))
    search = SimpleNamespace(base=SimpleNamespace(fit=SimpleNamespace(measurement=data)))
    chances = Evidence(search, 0.0, 0.2, (pair,), frozenset({"b"})).without_unknown()
    assert chances.effects == pytest.approx({"a": 1.0, "b": 0.7})
    assert chances.narrow == pytest.approx(0.3)


def test_what_the_unknown_leaves_goes_to_nothing_and_to_all_else_alike():
    one = Explanation(SimpleNamespace(names=("a",), effects=[]), 0.5)
    chances = Evidence(None, 0.3, 0.2, (one,)).without_unknown()
    assert (chances.nothing, chances.unknown) == (pytest.approx(0.375), 0.0)
    assert chances.explanations[0].probability == pytest.approx(0.625)


@pytest.mark.soak
def test_a_mass_beside_a_resonance_is_as_sure_as_without():
    truth = resonant(NARROW) - 0.02 * NARROW.omega**2
    diagnosis = springpot.diagnose(measured(NARROW, truth, level=0.003), KELVIN.name)
    found = {c.effect: c for c in diagnosis.candidates if c.verdict == "missing"}
    assert {"inertia", "frame-resonance"} <= set(found)
    assert found["inertia"].probability > 0.9 > found["frame-resonance"].probability
    assert diagnosis.says.endswith("or another narrow feature")


@pytest.mark.soak
def test_a_rung_of_a_resonance_says_that_it_may_be_something_else(rungs):
    assert "another narrow feature" in doubt_text(rungs[-1])


@pytest.mark.soak_cases("20")
@pytest.mark.parametrize("row", [20, soaked(35)])
def test_one_wrong_point_is_no_resonance(row):
    data = measured(NARROW, exact(KELVIN, NARROW), seed=2)
    stiffness = data.stiffness.copy()
    stiffness[row] *= 1.2 - 0.1j
    diagnosis = springpot.diagnose(replace(data, stiffness=stiffness), KELVIN.name)
    assert diagnosis.verdict != "effect-missing"
    assert any("set aside" in note for note in diagnosis.notes)


def test_the_likeliest_explanations_are_compared_not_those_of_best_fit():
    case = examined(hidden(KELVIN, SWEEP, "inertia", 300.0))
    for name, refit in case.evidence.likeliest_with().items():
        with_it = [one for one in case.evidence.explanations if name in one.names]
        likeliest = max(with_it, key=lambda one: one.probability)
        assert len(refit.model.effects) == len(likeliest.names)


@pytest.mark.soak
def test_a_force_of_noise_weighs_more_at_a_smaller_amplitude():
    case = examined(hidden(KELVIN, AMPLITUDES, "friction", 3000.0))
    found = case.evidence.likeliest_with()
    plan = [a for a in actions(case.search.base.fit.measurement) if "amplitude" in a.action]
    smaller = min(plan, key=lambda a: a.action["amplitude"][0])
    usual = replace(smaller, points=replace(smaller.points, amplitude=np.full(20, 0.75)))
    tiny = replace(smaller, points=replace(smaller.points, amplitude=np.full(20, 1e-9)))
    truth = found["friction"]
    made = SweepPart(truth.fit.measurement, noise=real_form(truth.noise.sd))
    quiet, loud = (planned_sweep(action, made, truth) for action in (usual, tiny))
    sizes = [
        np.tile(np.abs(truth.model.stiffness(truth.theta, part.points)), 2)
        for part in (quiet, loud)
    ]
    level = np.median(truth.noise.sd.real / np.abs(truth.stiffness))
    np.testing.assert_allclose(quiet.sd[:20], level * sizes[0][:20])
    np.testing.assert_allclose(loud.sd / sizes[1], 0.75e9 * quiet.sd / sizes[0])


def test_a_matrix_on_which_the_usual_algorithm_gives_up_has_a_basis_all_the_same(monkeypatch):
    def gives_up(*_, **__):
        raise np.linalg.LinAlgError("SVD did not converge")

    columns = np.random.default_rng(3).standard_normal((12, 4))
    usual = orthonormal(columns)
    monkeypatch.setattr(np.linalg, "svd", gives_up)
    again = orthonormal(columns)
    np.testing.assert_allclose(again @ again.T, usual @ usual.T, atol=1e-12)


def test_where_slopes_have_no_value_the_full_price_stands():
    refit = SimpleNamespace(fit=SimpleNamespace(jacobian_u=np.array([[1.0, np.nan]])))
    assert _refund(SimpleNamespace(), SimpleNamespace(refit=refit)) == 0.0
