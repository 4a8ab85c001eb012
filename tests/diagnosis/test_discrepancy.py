"""What a model leaves: its size, fixed in Hz or moving with temperature, causal or not."""

from dataclasses import replace

import numpy as np
import pytest
from hidden_data import TEMPERATURES, WARM, design, measured

import springpot
from springpot.measurement import Measurement
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.residual_causes import causal_evidence, discrepancy, log_shift_of

LEVEL = 0.005
CELSIUS = (0.0, 20.0, 40.0, 60.0)


def decades(s):
    return np.log10(np.abs(s) / (2 * np.pi))


def shift_at(celsius):
    """Ln a_T of 40 kJ/mol about 20 degC."""
    return 40.0 / 8.314e-3 * (1.0 / (celsius + 273.15) - 1.0 / 293.15)


def left(off, temperatures=(), points=45, seed=1, level=LEVEL, sd=1.0):
    """A model of K = 100 + 40 s_r^0.4, and data that differ from it by the share `off(s, s_r)`."""
    f, t = np.meshgrid(np.geomspace(0.1, 100.0, points), temperatures or [20.0], indexing="ij")
    w, log_shift = 2 * np.pi * f.ravel(), shift_at(t.ravel())
    reduced = 1j * w * np.exp(log_shift)
    modelled = 100.0 + 40.0 * reduced**0.4
    rng = np.random.default_rng(seed)
    noise = level * np.abs(modelled) * (rng.normal(size=len(w)) + 1j * rng.normal(size=len(w)))
    data = Measurement(
        w,
        modelled * (1.0 + off(1j * w, reduced)) + noise,
        conditions={"temperature": t.ravel()} if temperatures else {},
    )
    slopes = np.array([np.ones(len(w)), reduced**0.4, 40.0 * reduced**0.4 * np.log(reduced)])
    weights = (1.0 + 1.0j) / (sd * level * np.abs(modelled))
    frame = NoiseFrame(data, modelled, weights, slopes)
    return frame, log_shift if temperatures else None


def says(off, temperatures=(), **given):
    frame, log_shift = left(off, temperatures, **given)
    return " | ".join(discrepancy(frame, log_shift))


CAUSAL = {
    "resonance": lambda s, r: 0.05 / (1 + 0.1 * s / 75 + (s / 75) ** 2),
    "inertia": lambda s, r: -5e-4 * np.abs(s) ** 2 / (100.0 + 40.0 * r**0.4),
    "reflected wave": lambda s, r: 0.1 * np.exp(-0.02 * s),
}
NOT_CAUSAL = {
    "gain step between ranges": lambda s, r: 0.05 * (np.abs(s) > 30.0),
    "gain drift over the sweep": lambda s, r: 0.05 * np.sin(2.0 * decades(s)),
    "ripple of the gain": lambda s, r: 0.03 * np.sin(6.0 * np.pi * decades(s)),
    "phase error": lambda s, r: 0.03j + 0 * s,
}


@pytest.mark.parametrize("temperatures", [(), CELSIUS])
@pytest.mark.parametrize("name", CAUSAL)
def test_what_a_material_or_a_rig_can_do_is_causal(name, temperatures):
    assert "consistent with causality" in says(CAUSAL[name], temperatures)


@pytest.mark.soak
@pytest.mark.parametrize("temperatures", [(), CELSIUS])
@pytest.mark.parametrize("name", NOT_CAUSAL)
def test_what_no_linear_material_can_do_is_not(name, temperatures):
    assert "it is not causal" in says(NOT_CAUSAL[name], temperatures)


@pytest.mark.soak
def test_a_resonance_too_narrow_for_the_points_is_not_called_a_breach():
    said = says(lambda s, r: 0.02 / (1 + 0.02 * s / 75 + (s / 75) ** 2))
    assert said
    assert "not causal" not in said


@pytest.mark.soak
@pytest.mark.parametrize("sd", [0.5, 1.0, 2.0])
def test_noise_is_no_breach_even_where_its_size_is_misstated(sd):
    said = [says(lambda s, r: 0 * s, seed=seed, sd=sd) for seed in range(20)]
    assert not any("causal" in sentence for sentence in said)
    if sd >= 1.0:
        assert not any(said)


@pytest.mark.soak_cases(
    "<lambda>-moves along the frequency with temperature0",
    "<lambda>-moves along the frequency with temperature1",
    "<lambda>-same frequencies at all temperatures0",
)
@pytest.mark.parametrize(
    ("off", "word"),
    [
        (
            lambda s, r: 0.03 * np.sin(6.0 * np.pi * decades(s)),
            "same frequencies at all temperatures",
        ),
        (
            lambda s, r: 0.03 * np.sin(6.0 * np.pi * decades(r)),
            "moves along the frequency with temperature",
        ),
        (lambda s, r: 0.2 * s / (30.0 + s), "same frequencies at all temperatures"),
        (lambda s, r: 0.2 * r / (30.0 + r), "moves along the frequency with temperature"),
    ],
)
def test_fixed_and_moving_are_told_apart(off, word):
    assert word in says(off, CELSIUS)
    assert word not in says(off)


@pytest.mark.soak
def test_what_is_the_same_either_way_is_not_told():
    """A constant neither moves nor stays; a pattern at one temperature only does neither."""
    for off in (
        lambda s, r: 0.03j + 0 * s,
        lambda s, r: 0.05 * np.sin(6 * np.pi * decades(s)) * (np.abs(r / s) > 2),
    ):
        said = says(off, CELSIUS)
        assert "it stays" not in said
        assert "it moves" not in said


def test_the_size_is_that_beyond_the_noise():
    assert says(lambda s, r: 0.05 / (1 + 0.1 * s / 75 + (s / 75) ** 2)).startswith(
        "what is left is about 7.5 % of |G*| beyond the noise"
    )
    ripple = says(lambda s, r: 0.03 * np.sqrt(2) * np.sin(6.0 * np.pi * decades(s)), level=0.02)
    assert ripple.startswith(("what is left is about 2.", "what is left is about 3"))


def test_the_evidence_does_not_depend_on_units():
    frame, _ = left(CAUSAL["resonance"])
    n = len(frame.measurement)
    tenfold = NoiseFrame(
        Measurement(frame.measurement.omega, 10 * frame.measurement.stiffness),
        10 * frame.model_stiffness,
        frame.weights / 10,
        frame.jacobian * 10,
    )
    x, rows = np.log(frame.measurement.omega), [np.arange(n)]
    assert causal_evidence(tenfold, x, rows) == pytest.approx(
        causal_evidence(frame, x, rows), rel=1e-6
    )
    assert causal_evidence(replace(frame), x, rows) > 10.0


def test_the_shift_of_a_fitted_model():
    data = measured(TEMPERATURES, WARM.stiffness(WARM.truth, TEMPERATURES), level=1e-4)
    fitted = fitted_to_floor(springpot.parse_model(WARM.name), data)
    kelvin = TEMPERATURES.kelvin
    wanted = 40.0 / 8.314462618e-3 * (1.0 / kelvin - 1.0 / data.reference_temperature)
    np.testing.assert_allclose(log_shift_of(fitted), wanted, rtol=1e-2, atol=1e-3)
    at = design(24)
    plain = fitted_to_floor(
        springpot.parse_model("fractional-kelvin"),
        measured(at, 100.0 + 40.0 * (1j * at.omega) ** 0.4),
    )
    assert log_shift_of(plain) is None


def test_two_shifts_of_one_name_have_their_own_parameters():
    model = springpot.parse_model("fractional-kelvin + wlf-shift + wlf-shift")
    data = measured(TEMPERATURES, WARM.stiffness(WARM.truth, TEMPERATURES), level=1e-4)
    fitted = fitted_to_floor(model, data)
    own = dict(zip(model.names, fitted.theta, strict=True))
    away = TEMPERATURES.kelvin - data.reference_temperature
    wanted = [
        -np.log(10.0) * own[f"{name}.C1"] * away / (own[f"{name}.C2"] + away)
        for name in ("wlf-shift", "wlf-shift#2")
    ]
    np.testing.assert_allclose(log_shift_of(fitted), sum(wanted), rtol=1e-9)


@pytest.mark.soak
def test_what_is_not_causal_may_be_an_ideal_hysteretic_loss():
    assert "ideal hysteretic damping) is not causal either" in says(
        lambda s, r: 3j / (100.0 + 40.0 * r**0.4)
    )


def test_one_frequency_is_no_ground_for_a_word_on_causality():
    w = np.full(20, 10.0)
    data = Measurement(
        w, np.full(20, 110.0 + 10j), conditions={"amplitude": np.geomspace(0.1, 1.0, 20)}
    )
    frame = NoiseFrame(
        data, np.full(20, 100.0 + 10j), np.full(20, 1.0 + 1.0j), np.zeros((0, 20), dtype=complex)
    )
    [said] = discrepancy(frame)
    assert said.startswith("what is left is about 9 % of |G*|")
