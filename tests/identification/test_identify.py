"""`identify` says what was found, in which units, how well it is known, and what to beware of."""

import json

import numpy as np
import pytest
from native_problems import OMEGA, TRUTHS, noisy, setup

import springpot
from springpot.errors import DataError
from springpot.identification import Fit, Uncertainty, fit, identify
from springpot.identification.fitting import notes_on
from springpot.identification.searching import _grown, _without_effects
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model

IN_KILONEWTONS = Units("kN/m", "mm")


def noisy_data(name, level, seed, **columns):
    _, _, data = setup(name)
    measured = noisy(data.stiffness, level, np.random.default_rng(seed))
    return Measurement(OMEGA, measured, units=IN_KILONEWTONS, **columns)


def said(found, *words):
    return any(all(word in note for word in words) for note in found.notes)


@pytest.mark.soak_cases("fractional-kelvin", "fractional-kelvin4")
@pytest.mark.parametrize("name", TRUTHS)
def test_the_dictionary_follows_the_schema(name):
    found = springpot.identify(noisy_data(name, 0.01, 0), name).to_dict()
    assert found["schema"] == "springpot.identification/2"
    assert set(found["parameters"]) == set(TRUTHS[name])
    for parameter, truth in TRUTHS[name].items():
        entry = found["parameters"][parameter]
        assert set(entry) == {"value", "low", "high", "unit"}
        assert entry["low"] < entry["value"] < entry["high"]
        # Four standard deviations at most, of 1 % of noise.
        assert abs(entry["value"] - truth) < entry["high"] - entry["low"]
    assert found["objective"]["name"] == "relative"
    assert 0.005 < found["relative_rms"] < 0.02
    assert found["status"] == "converged"
    assert found["evaluations"] > 10
    assert json.loads(json.dumps(found, allow_nan=False)) == found


@pytest.mark.soak
def test_search_parameters_are_the_published_form():
    _, theta, data = setup("fractional-zener")
    found = springpot.identify(data, "fractional-zener").to_dict()["search_parameters"]
    k1, k2, c, alpha = theta
    values = {name: entry["value"] for name, entry in found.items()}
    assert values == pytest.approx(
        {"k0": k1, "kinf": k1 + k2, "tau": (c / k2) ** (1 / alpha), "alpha": alpha}
    )
    assert springpot.identify(data, "springpot").to_dict()["search_parameters"] == {}


@pytest.mark.soak
def test_search_intervals_cover_the_truth(rng):
    _, theta, data = setup("fractional-maxwell")
    truth = {"k": theta[0], "tau": (theta[1] / theta[0]) ** (1 / theta[2]), "alpha": theta[2]}
    inside = dict.fromkeys(truth, 0)
    for _ in range(150):
        # Not the public one, which also judges how good each fit is.
        found = identify(
            Measurement(OMEGA, noisy(data.stiffness, 0.01, rng)), parse_model("fractional-maxwell")
        )
        for name, entry in found.to_dict()["search_parameters"].items():
            inside[name] += entry["low"] <= truth[name] <= entry["high"]
    assert all(0.89 <= count / 150 <= 1.0 for count in inside.values())


def test_values_come_in_the_units_of_the_data():
    model = parse_model("fractional-maxwell + inertia")
    theta = model.theta(k=400.0, c=150.0, alpha=0.6, inertia__m=0.02)
    data = Measurement(OMEGA, model.stiffness(theta, OMEGA), units=IN_KILONEWTONS)
    found = springpot.identify(data, model).to_dict()["parameters"]
    assert found["inertia.m"]["unit"] == "kg"
    assert found["inertia.m"]["value"] == pytest.approx(20.0, rel=1e-6)
    assert found["c"]["unit"] == "kN s^alpha/m"


def test_given_deviations_are_used_by_default():
    sd = 0.01 * setup("fractional-kelvin")[2].magnitude * (1 + 1j)
    data = noisy_data("fractional-kelvin", 0.01, 1, sd=sd)
    found = springpot.identify(data, "fractional-kelvin")
    assert found.to_dict()["objective"]["name"] == "weighted"
    assert found.uncertainty.absolute
    assert found.fit.cost == pytest.approx(found.fit.dof, rel=0.4)
    assert not said(found, "too narrow")
    tight = noisy_data("fractional-kelvin", 0.01, 1, sd=0.1 * sd)
    assert said(
        springpot.identify(tight, "fractional-kelvin"), "given standard deviations", "too narrow"
    )


@pytest.mark.soak_cases("least-squares-500")
@pytest.mark.parametrize(
    ("optimiser", "budget"), [("least-squares", 500), ("differential-evolution", 4000)]
)
def test_any_optimiser_gives_the_same_answer(optimiser, budget):
    data = noisy_data("fractional-maxwell", 0.01, 2)
    native = springpot.identify(data, "fractional-maxwell")
    other = springpot.identify(
        data, "fractional-maxwell", optimiser=optimiser, budget=budget, seed=1, restarts=2
    )
    assert other.optimiser == optimiser
    assert other.theta == pytest.approx(native.theta, rel=1e-3)
    assert other.evaluations <= 2 * budget
    assert native.fit.cost <= other.fit.cost * (1 + 1e-9)


@pytest.mark.soak_cases("bootstrap", "profile")
@pytest.mark.parametrize("intervals", ["jacobian", "profile", "bootstrap"])
def test_same_seed_same_result(intervals):
    data = noisy_data("fractional-kelvin", 0.02, 3)
    first, second = (
        springpot.identify(data, "fractional-kelvin", seed=5, intervals=intervals).to_dict()
        for _ in range(2)
    )
    for result in (first, second):
        del result["seconds"]
    assert first == second


def test_an_order_at_its_bound_is_named():
    data = Measurement(OMEGA, 400.0 + 150.0j * OMEGA)
    assert said(springpot.identify(data, "fractional-kelvin"), "alpha is 1", "dashpot")
    elastic = Measurement(OMEGA, 400.0 + 0.0j * OMEGA)
    assert said(springpot.identify(elastic, "springpot"), "alpha is 0", "spring")


def test_a_superfluous_parameter_is_named():
    data = noisy_data("fractional-maxwell", 0.01, 2)
    assert said(springpot.identify(data, "fractional-zener"), "k1", "zero", "without it")


def test_a_parameter_at_zero_widens_the_search_form_too():
    found = springpot.identify(
        noisy_data("fractional-maxwell", 0.01, 2), "fractional-zener"
    ).to_dict()
    k0, k1 = found["search_parameters"]["k0"], found["parameters"]["k1"]
    assert k0["high"] == pytest.approx(k1["high"])
    assert k1["high"] > 1.0


def test_a_rigid_element_is_named():
    # In these data there is no spring in series: the best one is infinitely stiff.
    exact = setup("fractional-kelvin")[2]
    found = springpot.identify(exact, "fractional-kelvin + series-spring")
    assert said(found, "series-spring.k", "rigid") or said(
        found, "series-spring.k", "not determined"
    )


def test_weak_and_correlated_parameters_are_named():
    data = noisy_data("fractional-zener", 0.03, 5)
    assert said(springpot.identify(data, "fractional-zener"), "k1 is weakly identified")
    low = Measurement(
        OMEGA[:4],
        parse_model("fractional-zener").stiffness(setup("fractional-zener")[1], OMEGA[:4]),
    )
    assert said(springpot.identify(low, "fractional-zener"), "strongly correlated")
    assert springpot.identify(noisy_data("springpot", 0.001, 0), "springpot").notes == ()


def test_undetermined_parameters_are_named():
    model = parse_model("fractional-maxwell + series-spring")
    data = Measurement(
        OMEGA, parse_model("fractional-maxwell").stiffness(np.array([400.0, 150.0, 0.6]), OMEGA)
    )
    assert said(springpot.identify(data, model), "k and series-spring.k are not determined")


def test_as_many_unknowns_as_data_is_said_and_more_is_an_error():
    data = setup("fractional-zener")[2]
    assert said(
        springpot.identify(data.subset(np.array([0, 13])), "fractional-zener"), "as many parameters"
    )
    with pytest.raises(DataError, match="5 parameters"):
        springpot.identify(data.subset(np.array([0, 13])), "fractional-zener + inertia")


@pytest.mark.parametrize("model", ["spring", "maxwell", "fractional-zener"])
def test_one_point_is_an_error_whatever_the_model(model):
    with pytest.raises(DataError, match="one point"):
        springpot.identify(setup("fractional-zener")[2].subset(np.array([0])), model)


@pytest.mark.soak_cases("bootstrap", "jacobian", "profile")
@pytest.mark.parametrize("intervals", ["jacobian", "profile", "bootstrap"])
def test_intervals_hold_the_estimate_and_agree_between_the_forms(intervals):
    for model in ("fractional-kelvin", "fractional-zener"):
        found = springpot.identify(
            noisy_data("springpot", 0.01, 2), model, intervals=intervals
        ).to_dict()
        inner, outer = found["parameters"], found["search_parameters"]
        for row in [*inner.values(), *outer.values()]:
            low, high = row["low"] or 0.0, np.inf if row["high"] is None else row["high"]
            assert low <= row["value"] <= high
        assert outer["alpha"] == inner["alpha"]
    # The spring is as good as zero: whatever holds for its stiffness holds for k0, which is the
    # same.
    assert outer["k0"]["low"] == inner["k1"]["low"] == 0.0


def test_a_richer_model_is_never_worse_than_the_one_it_contains():
    data = noisy_data("fractional-maxwell", 0.02, 7)
    plain = springpot.identify(data, "fractional-maxwell")
    for effect in ("inertia", "time-delay", "parallel-dashpot", "series-dashpot"):
        richer = springpot.identify(data, f"fractional-maxwell + {effect}")
        assert richer.fit.cost <= plain.fit.cost * (1 + 1e-6)
        assert not said(richer, "search has failed")


def test_a_failed_search_is_repeated_and_reported(monkeypatch):
    # The module is hidden behind the function of the same name.
    import sys

    module = sys.modules["springpot.identification.searching"]
    data = noisy_data("fractional-maxwell", 0.02, 7)
    calls = []

    def lazy(model, measurement, objective=None, **options):
        calls.append(options)
        found = fit(model, measurement, objective, **options)
        if not model.effects:
            return found
        return Fit(
            model, measurement, found.objective, found.theta, found.cost * 10, found.evaluations
        )

    monkeypatch.setattr(module, "fit", lazy)
    found = springpot.identify(data, "fractional-maxwell + inertia")
    assert said(found, "simpler fractional-maxwell fits better", "search has failed")
    assert any(options["starts"] == module.MORE_STARTS for options in calls)


def test_starts_grown_from_a_simpler_model_keep_its_parameters():
    model = parse_model("fractional-maxwell + inertia")
    [part] = _without_effects(model)
    simple = fit(part, setup("fractional-maxwell")[2])
    for start in _grown(simple, model):
        assert start[:3] == pytest.approx(simple.theta)
        assert start[3] > 0


def test_simpler_models_are_compared_when_asked():
    data = noisy_data("fractional-maxwell", 0.01, 2)
    found = springpot.identify(data, "fractional-zener", simpler=["fractional-maxwell"])
    assert found.fit.cost <= springpot.identify(data, "fractional-maxwell").fit.cost * (1 + 1e-6)
    assert not said(found, "search has failed")


def test_notes_are_about_the_interval_they_are_given():
    data = noisy_data("springpot", 0.001, 0)
    known = Uncertainty.of(fit(parse_model("springpot"), data))
    assert any(
        "weakly" in note for note in notes_on(known, known.fit.theta * 0.1, known.fit.theta * 10)
    )


def test_unknown_names_are_one_line():
    data = setup("springpot")[2]
    with pytest.raises(springpot.errors.SpringpotError, match="nonsense"):
        springpot.identify(data, "nonsense")
    with pytest.raises(springpot.errors.SpringpotError, match="optimiser"):
        springpot.identify(data, "springpot", optimiser="nonsense")
