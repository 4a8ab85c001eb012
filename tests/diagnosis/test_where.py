"""Where a model fails: along frequency, temperature and amplitude; nothing where there is only noise."""

import numpy as np
import pytest

from springpot.diagnosis.frame import Frame
from springpot.diagnosis.where import MOST, where
from springpot.measurement import Measurement, Units

LEVEL = 0.01


def stiffness(omega):
    """A fractional Kelvin solid by hand."""
    return 100.0 + 40.0 * (1j * omega) ** 0.4


def frame(*, frequencies=20, temperatures=(), amplitudes=(), off=None, seed=1, dof=np.inf, level=LEVEL):
    """A fit whose misfit, relative to the modelled |K|, is `off(f, T, X)`, plus noise; nothing was absorbed."""
    f = np.geomspace(0.1, 100.0, frequencies) if frequencies > 1 else np.array([2.0])
    f, t, x = (c.ravel() for c in np.meshgrid(f, temperatures or [20.0], amplitudes or [1.0], indexing="ij"))
    modelled = stiffness(2 * np.pi * f)
    rng = np.random.default_rng(seed)
    sd = level * np.abs(modelled)
    scale = 1.0 if dof == np.inf else np.sqrt(rng.chisquare(dof) / dof)
    noise = sd * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    misfit = 0.0 if off is None else off(f, t, x) * np.abs(modelled)
    conditions = {"temperature": t} if temperatures else {}
    conditions |= {"amplitude": x} if amplitudes else {}
    data = Measurement(2 * np.pi * f, modelled + misfit + noise, conditions=conditions, units=Units("kN/m", "mm"))
    weights = (1.0 + 1.0j) / (scale * sd)
    return Frame(data, modelled, weights, np.zeros((0, len(f)), dtype=complex), dof)


def says(fit):
    return [place.says for place in where(fit)]


def test_a_misfit_that_changes_sign_with_temperature_is_told_per_temperature():
    """Its mean over the temperatures is nothing."""
    found = says(frame(temperatures=(0.0, 20.0, 40.0, 60.0), off=lambda f, t, x: (t - 30.0) / 100.0))
    assert len(found) == 2
    low, high = sorted(found, key=lambda sentence: "too high" in sentence)
    assert "too low at all frequencies at 40 degC and above" in low
    assert "larger at higher temperatures (9.3 % at 40 degC, 23 % at 60 degC)" in low
    assert "too high at all frequencies at 20 degC and below" in high
    assert "smaller at higher temperatures (42 % at 0 degC, 11 % at 20 degC)" in high


def test_friction_at_one_frequency_is_told_along_the_amplitude():
    amplitudes = tuple(np.geomspace(0.1, 10.0, 20))
    found = says(frame(frequencies=1, amplitudes=amplitudes, off=lambda f, t, x: 0.03j / x - 0.04j))
    low, high = sorted(found, key=lambda sentence: "too high" in sentence)
    assert "loss modulus" in low
    assert "too low at 2 Hz at amplitudes of 0.428 mm and below" in low
    assert "too high at 2 Hz at amplitudes of " in high
    pure = says(frame(frequencies=1, amplitudes=amplitudes, off=lambda f, t, x: 0.2j / x))
    assert any("falling as 1/amplitude (" in sentence for sentence in pure)


def test_the_corner_of_a_plan_in_which_a_model_fails_is_told():
    def off(f, t, x):
        return 0.05 * ((f > 10.0) & (t > 30.0) & (x > 0.5))

    [place] = where(frame(temperatures=(0.0, 20.0, 40.0), amplitudes=(0.1, 0.3, 1.0), off=off))
    assert place.says.startswith(
        "storage modulus 4.7 % of |K| too low above 16.2 Hz at an amplitude of 1 mm at 40 degC"
    )
    assert place.condition == "at an amplitude of 1 mm, at 40 degC"


def test_the_sentence_of_the_issue():
    [found] = says(frame(temperatures=(0.0, 20.0, 40.0), off=lambda f, t, x: 0.12j * (f > 20.0)))
    assert found.startswith("loss modulus 11 % of |K| too low above 23.4 Hz, ")
    assert found.endswith("the same at all temperatures")


def test_a_ripple_fixed_in_hertz_is_not_told_wave_by_wave():
    def off(f, t, x):
        return 0.05 * np.sin(2 * np.pi * 3.0 * np.log10(f))

    for temperatures in ((), (0.0, 20.0, 40.0)):
        found = says(frame(frequencies=45, temperatures=temperatures, off=off))
        assert len(found) <= 2
        assert "swings by about 5" in found[0]
        assert "decades" in found[0]


def test_a_notch_is_no_ripple():
    def notch(f, t, x):
        return -0.2 * np.exp(-((np.log(f / 12.0) / 0.12) ** 2))

    found = says(frame(frequencies=45, off=notch))
    assert all("swings" not in sentence for sentence in found)
    assert found[0].startswith("storage modulus")


def test_few_sentences_however_ragged_the_misfit():
    ragged = np.random.default_rng(3).normal(size=(24, 5))
    fit = frame(frequencies=24, temperatures=(0.0, 10.0, 20.0, 30.0, 40.0), off=lambda f, t, x: 0.3 * ragged.ravel())
    assert 1 <= len(where(fit)) <= MOST + 1


@pytest.mark.parametrize(
    "plan",
    [
        {"frequencies": 40},
        {"frequencies": 40, "dof": 50.0},
        {"frequencies": 1, "amplitudes": tuple(np.geomspace(0.1, 10.0, 20))},
        {"frequencies": 12, "temperatures": (0.0, 10.0, 20.0, 30.0)},
        {"frequencies": 8, "temperatures": (0.0, 20.0, 40.0), "amplitudes": (0.1, 0.3, 1.0), "dof": 80.0},
    ],
)
def test_noise_alone_is_nowhere(plan):
    """Two parts at half a per cent and a ripple at half a per cent: of 60, five or more have a chance of 0.2 %."""
    assert sum(bool(where(frame(seed=seed, **plan))) for seed in range(60)) <= 4
