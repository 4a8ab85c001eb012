"""What a diagnosis says beside its verdict: second effects, harmonics, predictions, intervals."""

from dataclasses import replace

import numpy as np
import pytest
from hidden_data import KELVIN, ZENER, design, exact, measured

import springpot
from springpot.diagnosis import examine
from springpot.identification import fit, held_costs, profile
from springpot.registry import plugins

pytestmark = pytest.mark.usefixtures("asked_once")

WIDE = design(60, 0.05, 150.0)
STEPS = design(10, 0.1, 50.0, temperatures=(-10.0, 5.0, 20.0, 35.0, 50.0))


def two():
    """A mass and a delay that together hide from any one effect."""
    k = exact(ZENER, WIDE)
    mass = 0.4 * np.abs(k[-1]) / WIDE.omega.max() ** 2
    return (k - mass * WIDE.omega**2) * np.exp(-1j * WIDE.omega * 2.5e-4), mass


@pytest.mark.soak
def test_what_stands_beside_the_leading_effect_is_named_with_its_rivals():
    stiffness, _ = two()
    diagnosis = springpot.diagnose(measured(WIDE, stiffness, level=0.004), ZENER.name)
    assert diagnosis.best.effect in ("inertia", "time-delay", "filter-mismatch")
    named = diagnosis.says.partition("missing is ")[2]
    assert "inertia" in named
    assert "time-delay" in named
    assert "beside it" in named


def mass_in(stiffness):
    data = measured(WIDE, stiffness, level=0.004)
    diagnosis = springpot.diagnose(data, ZENER.name, only=["inertia", "time-delay"])
    return next(each for each in diagnosis.candidates if each.effect == "inertia").parameters["m"]


@pytest.mark.soak
def test_an_interval_is_as_wide_as_the_misfit_that_its_model_leaves():
    """Alone the mass is fitted to data that a delay has bent.

    The misfit, not the noise, says how uncertain it is.

    No width makes up for the bias itself, of a third of the mass: that is what the structure left
    over tells.
    """
    bent, mass = two()
    value, right = mass_in(bent), mass_in(exact(ZENER, WIDE) - mass * WIDE.omega**2)
    assert right.low < 1e3 * mass < right.high
    assert value.high - value.low > 5.0 * (right.high - right.low)
    assert value.value == pytest.approx(1e3 * mass, rel=0.4)


def with_harmonics(second, third):
    data = measured(WIDE, exact(KELVIN, WIDE), level=0.003)
    shares = np.random.default_rng(3).normal(size=(len(data), 2, 2)) @ np.array([1.0, 1.0j]) * 0.003
    return replace(data, harmonics=shares + np.array([second, third]))


@pytest.mark.soak
def test_a_harmonic_that_nothing_makes_is_not_passed_over():
    diagnosis = springpot.diagnose(with_harmonics(0.08, 0.0), KELVIN.name)
    assert "harmonics that this model does not make" in diagnosis.says
    assert any("harmonic 2 is 8" in note for note in diagnosis.notes)


@pytest.mark.soak
def test_harmonics_of_noise_are_passed_over():
    diagnosis = springpot.diagnose(with_harmonics(0.0, 0.0), KELVIN.name)
    assert "harmonics" not in diagnosis.says
    assert not any("harmonic" in note for note in diagnosis.notes)


def shifted():
    a_t = np.exp(9000.0 * (1.0 / STEPS.kelvin - 1.0 / STEPS.reference))
    return measured(STEPS, 60.0 + 40.0 * (1j * STEPS.omega * a_t) ** 0.4, level=0.005)


@pytest.mark.soak
def test_the_model_that_predicts_is_the_one_that_is_proposed():
    diagnosis = springpot.diagnose(shifted(), "fractional-kelvin")
    (note,) = [note for note in diagnosis.notes if "leaving out one temperature" in note]
    assert f"fractional-kelvin + {diagnosis.best.effect} predicts it better" in note


@pytest.mark.soak
def test_effects_that_change_nothing_are_not_called_alike():
    """Beside the true effect every other one vanishes, and all curves are one.

    That makes them no class.
    """
    library = list(plugins().items("effect"))
    case = examine(
        shifted(), springpot.parse_model("fractional-kelvin"), library, np.random.default_rng(0)
    )
    frame, base = case.search.frame, case.search.base
    alone = {grown.names[0]: grown.refit for grown in case.search.grown if len(grown.effects) == 1}
    for group in case.diagnosis.classes[1:]:
        for name in group if len(group) > 1 else ():
            moved = frame.whiten(alone[name].stiffness - base.stiffness)
            assert np.sqrt(np.mean(moved**2)) > 0.3


def test_a_held_parameter_costs_what_its_profile_says():
    data = measured(WIDE, exact(KELVIN, WIDE), level=0.01)
    found = fit(springpot.parse_model("fractional-kelvin"), data)
    ends = np.array(profile(found, "alpha"))
    fitted = float(found.theta[found.model.names.index("alpha")])
    costs = held_costs(found, "alpha", np.array([ends[0], fitted, ends[1]]))
    assert costs == pytest.approx(found.cost + np.array([1.96**2, 0.0, 1.96**2]), rel=1e-3)


@pytest.mark.soak
def test_the_next_experiment_settles_the_more_open_question():
    """The mass is certain.

    What stands beside it is not, and it is that which a measurement should tell.
    """
    stiffness, _ = two()
    diagnosis = springpot.diagnose(measured(WIDE, stiffness, level=0.004), ZENER.name)
    beside = {each.effect: each for each in diagnosis.candidates if each.says.startswith("beside ")}
    assert len(beside) >= 2
    assert set(diagnosis.next_experiment.separates) <= set(beside)
    for each in beside.values():
        assert each.delta_bic > 10.0
        # What accepting it alone leaves; what both leave is told in words.
        assert each.error_after > 2.0 * diagnosis.error.noise_floor
        assert each.says.endswith("% is left with both")


def test_a_floor_below_that_of_the_model_alone_is_explained(monkeypatch):
    """If a better model scatters less than the judged, identify and diagnose tell two floors."""
    from types import SimpleNamespace

    from springpot.diagnosis import notes
    from springpot.misfit.floor import ScatterAbout

    def told(variance, source="estimated"):
        monkeypatch.setattr(notes, "scatter_about", lambda frame: ScatterAbout(variance, 10.0))
        noise = SimpleNamespace(source=source, memory=0.0)
        base = SimpleNamespace(noise=noise, floor=0.01, frame=lambda: None, model="kelvin")
        return list(notes._of_floor(SimpleNamespace(base=base)))

    [says] = told(25.0)
    assert "about kelvin alone" in says
    assert says.endswith("it looks like 5 %")
    assert told(1.1) == []
    assert told(25.0, "repeats") == []
