"""Data at the edge of what can be judged, and input that cannot be.

No crash, one line, nothing invented.
"""

import json
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, design, exact, measured

import springpot
from springpot.diagnosis.search import _forget_narrow, _spread
from springpot.errors import DataError, ModelError, SpringpotError
from springpot.report.text import jsonable


def quiet(diagnosis):
    """Nothing is claimed, and the answer is valid JSON."""
    assert diagnosis.verdict in ("adequate", "inconclusive")
    assert [c.effect for c in diagnosis.candidates if c.verdict == "missing"] == []
    json.dumps(jsonable(diagnosis.to_dict()), allow_nan=False)


@pytest.mark.soak_cases("3-sigma-known", "3-sigma-unknown", "4-sigma-known", "4-sigma-unknown")
@pytest.mark.parametrize("known", [True, False], ids=["sigma-known", "sigma-unknown"])
@pytest.mark.parametrize("points", [3, 4])
def test_three_points_prove_nothing(points, known):
    at = design(points)
    data = measured(at, exact(KELVIN, at), known=known)
    quiet(springpot.diagnose(data, KELVIN.name))
    assert len(springpot.discover(data, KELVIN.name).steps) == 1


@pytest.mark.soak_cases("2")
@pytest.mark.parametrize("points", [1, 2])
def test_fewer_points_are_an_answer_or_one_line(points):
    at = design(points)
    try:
        diagnosis = springpot.diagnose(measured(at, exact(KELVIN, at)), KELVIN.name)
    except SpringpotError as error:
        message = str(error)
    else:
        message = ""
        quiet(diagnosis)
    assert "\n" not in message


@pytest.mark.soak_cases("sigma-known", "sigma-unknown")
@pytest.mark.parametrize("known", [True, False], ids=["sigma-known", "sigma-unknown"])
def test_all_points_at_one_frequency(known):
    at = design(1, low=2.0, high=2.0)
    at = type(at)(np.repeat(at.omega, 20))
    data = measured(at, exact(KELVIN, at), known=known)
    quiet(springpot.diagnose(data, KELVIN.name))
    assert len(springpot.discover(data, KELVIN.name).steps) == 1


@pytest.mark.soak
def test_friction_shows_at_one_frequency_over_amplitudes():
    at = design(1, low=2.0, high=2.0, amplitudes=tuple(np.geomspace(0.1, 3.0, 20)))
    diagnosis = springpot.diagnose(measured(at, exact(KELVIN, at, "friction", 5.0)), KELVIN.name)
    assert diagnosis.verdict == "effect-missing"
    assert "friction" in diagnosis.best.alike


@pytest.mark.soak
def test_negative_loss_is_data_like_any_other():
    """Late force makes the loss of a stiff specimen negative: a delay of the wrong sign."""
    at = SWEEP
    stiffness = (200.0 + 0.2j * at.omega) * np.exp(1j * at.omega * -1.5e-3)
    assert (stiffness.imag < 0).any()
    diagnosis = springpot.diagnose(measured(at, stiffness), "kelvin")
    assert diagnosis.verdict == "effect-missing"
    assert "time-delay" in diagnosis.best.alike
    json.dumps(jsonable(diagnosis.to_dict()), allow_nan=False)


@pytest.mark.soak
def test_noise_that_makes_some_losses_negative_is_still_noise():
    at = SWEEP
    data = measured(at, 200.0 + 0.002j * at.omega, level=0.02)
    assert (data.loss < 0).any()
    quiet(springpot.diagnose(data, "kelvin"))


@pytest.mark.soak
def test_exact_data_need_nothing():
    stiffness = exact(KELVIN, SWEEP)
    quiet(springpot.diagnose(springpot.Measurement(SWEEP.omega, stiffness), KELVIN.name))


@pytest.mark.soak
def test_exact_data_with_something_hidden_name_it():
    stiffness = exact(KELVIN, SWEEP, "inertia", 2e-4)
    diagnosis = springpot.diagnose(springpot.Measurement(SWEEP.omega, stiffness), KELVIN.name)
    assert diagnosis.best.effect == "inertia"


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        ("fractional-kelvin + friction", DataError),
        ("fractional-kelvin + arrhenius-shift", DataError),
        ("fractional-kelvin + gravity", ModelError),
        ("fractional-kelwin", ModelError),
        ("", ModelError),
        ("fractional-kelvin +", ModelError),
    ],
)
def test_models_that_do_not_fit_the_data_are_told_in_one_line(model, kind):
    data = measured(SWEEP, exact(KELVIN, SWEEP))
    with pytest.raises(SpringpotError) as raised:
        springpot.diagnose(data, model)
    assert isinstance(raised.value, DataError | ModelError), kind
    message = str(raised.value)
    assert message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("effect", "says"),
    [("friction", "amplitude"), ("wlf-shift", "temperature"), ("gravity", "gravity")],
)
def test_effects_that_cannot_be_accepted_are_told_in_one_line(effect, says):
    data = measured(SWEEP, exact(KELVIN, SWEEP))
    with pytest.raises(SpringpotError) as raised:
        springpot.discover(data, KELVIN.name, accept=[effect])
    assert says in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.soak
def test_effects_whose_columns_are_missing_are_not_proposed():
    diagnosis = springpot.diagnose(
        measured(SWEEP, exact(KELVIN, SWEEP, "hysteretic-loss", 15.0)), KELVIN.name
    )
    needing = {
        "friction",
        "power-law-damper",
        "payne",
        "self-heating",
        "arrhenius-shift",
        "wlf-shift",
        "rig-drag",
    }
    assert not needing & {c.effect for c in diagnosis.candidates}
    assert not needing & {name for group in diagnosis.classes for name in group}


@pytest.mark.soak
def test_a_grown_model_with_more_parameters_than_numbers_is_not_tried():
    """Two points are four numbers: enough for a model of three, not for one more with two."""
    data = springpot.Measurement(np.array([1.0, 10.0]), np.array([10.0 + 4.0j, 20.0 + 9.0j]))
    quiet(springpot.diagnose(data, "fractional-maxwell"))


@pytest.mark.soak
def test_a_trial_whose_square_is_no_number_ends_nothing():
    """A wave in a specimen, driven at its resonance on the way to a fit, makes a K of 1e192."""
    omega = 2.0 * np.pi * np.geomspace(0.5, 100.0, 40)
    s, rng = 1j * omega, np.random.default_rng(7)
    exact = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.5)) + 6e-4 * s**2
    noisy = exact * (1.0 + 0.01 * (rng.normal(size=40) + 1j * rng.normal(size=40)))
    found = springpot.diagnose(
        springpot.Measurement(omega[::2], noisy[::2], units=springpot.Units("kN/m", "mm"))
    )
    assert (found.verdict, found.best.effect) == ("effect-missing", "inertia")


@pytest.mark.soak
@pytest.mark.parametrize("points", [12, 20, 40])
@pytest.mark.parametrize("model", ["material", "fractional-kelvin"])
def test_computed_data_lack_nothing(points, model):
    """Rounding has a pattern, and no instrument has it."""
    omega = np.geomspace(1.0, 100.0, points)
    diagnosis = springpot.diagnose(
        springpot.Measurement(omega, 100.0 + 20.0 * (1j * omega) ** 0.3), model
    )
    assert diagnosis.verdict == "adequate"


def test_rows_that_were_copied_are_no_repeats():
    rng = np.random.default_rng(3)
    omega = np.geomspace(1.0, 100.0, 20)
    noise = 0.01 * (rng.normal(size=20) + 1j * rng.normal(size=20))
    stiffness = (100.0 + 20.0 * (1j * omega) ** 0.5) * (1.0 + noise)
    data = springpot.Measurement(
        np.tile(omega, 3), np.tile(stiffness, 3), repeat=np.repeat([1, 2, 3], 20)
    )
    error = springpot.diagnose(data, "fractional-kelvin").error
    assert error.noise_source == "estimated"
    assert error.noise_floor == pytest.approx(0.014, rel=0.3)


@pytest.mark.soak
def test_patterns_of_rounding_are_not_told_of():
    hertz = np.geomspace(0.1, 10.0, 12)
    found = springpot.diagnose(
        springpot.Measurement(2.0 * np.pi * hertz, 1e4 * (1j * hertz) ** 0.3)
    )
    assert "is that of arithmetic" in found.says
    assert not [note for note in found.notes if "structure" in note]


@pytest.mark.soak
def test_computed_data_are_exact_beside_their_own_model_only():
    omega = np.geomspace(1.0, 100.0, 20)
    diagnosis = springpot.diagnose(
        springpot.Measurement(omega, 100.0 + 20.0 * (1j * omega) ** 0.3), "kelvin"
    )
    assert diagnosis.verdict != "adequate"


@pytest.mark.soak
def test_where_nothing_of_a_material_is_left_the_answer_is_no_fault():
    """All of K counts the other way: no material has any, and relative changes of it are none."""
    omega = 2.0 * np.pi * np.geomspace(1.0, 50.0, 16)
    loss = 5.0 * omega**0.7 * (1.0 + 0.01 * np.random.default_rng(5).normal(size=16))
    data = springpot.Measurement(omega, 0.01 * omega**2 - 100.0 - 1j * loss)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert springpot.diagnose(data).verdict == "unexplained"


def test_a_change_beyond_all_numbers_is_spread_as_a_small_one_is():
    """What is taken out of a fit may have been held by what is left of it."""
    search = SimpleNamespace(
        frame=SimpleNamespace(whiten=lambda values: np.concatenate([values.real, values.imag]))
    )
    change = np.array([3.0, 4.0j, 0.0])
    assert _spread(search, change) == pytest.approx(49.0 / 25.0)
    assert _spread(search, 1e200 * change) == pytest.approx(49.0 / 25.0)
    assert _spread(search, 0.0 * change) == 0.0


def test_a_narrow_effect_that_no_fit_has_shares_no_prior():
    def score(name, narrow):
        return SimpleNamespace(
            influence=SimpleNamespace(effect=SimpleNamespace(name=name, narrow=narrow))
        )

    scores = [score("broad", False), score("fitted", True), score("resonance", True)]
    search = SimpleNamespace(
        grown=[SimpleNamespace(names=("fitted",))], scan=SimpleNamespace(scores=scores)
    )
    _forget_narrow(search)
    assert [each.influence.effect.name for each in scores] == ["broad", "fitted"]
