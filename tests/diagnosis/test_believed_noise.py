"""What only scatter calls noise is not believed beyond a tenth of the stiffness.

No model is good beside it.
"""

import numpy as np
import pytest

import springpot

OMEGA = np.logspace(0, 2, 24)
TRUE = 100.0 + 5j * OMEGA


def measured(level, sd=False):
    rng = np.random.default_rng(2)
    noise = level * np.abs(TRUE) / np.sqrt(2)
    stiffness = TRUE + noise * (rng.normal(size=len(OMEGA)) + 1j * rng.normal(size=len(OMEGA)))
    return springpot.Measurement(
        OMEGA, stiffness, sd=noise * (1 + 1j) if sd else None, name="noisy"
    )


@pytest.mark.soak_cases("0.3-True-True", "0.4-False-False")
@pytest.mark.parametrize(
    ("level", "sd", "good"), [(0.02, False, True), (0.4, False, False), (0.3, True, True)]
)
def test_no_verdict_is_good_beside_noise_that_nobody_believes(level, sd, good):
    data = measured(level, sd)
    diagnosis = springpot.diagnose(data, "kelvin")
    assert (diagnosis.verdict == "adequate") == good
    assert any("no good measurement" in note for note in diagnosis.notes) == (not good)
    [judged] = springpot.compare(data, ["kelvin"]).judgements
    assert judged.unclear == (not good)
    assert springpot.identify(data, "kelvin").standing.good_enough == good


def test_noise_with_a_memory_in_one_sweep_may_as_well_be_a_misfit():
    rng, model, omega = (
        np.random.default_rng(3),
        springpot.parse_model("zener"),
        np.geomspace(0.1, 100.0, 40),
    )
    scatter = rng.normal(size=(40, 2)) @ [1.0, 1j]
    for row in range(1, 40):
        scatter[row] = 0.6 * scatter[row - 1] + 0.8 * scatter[row]
    exact = model.stiffness(model.theta(k1=50.0, k2=90.0, c=90.0), omega)
    data = springpot.Measurement(omega, exact * (1.0 + 0.01 * scatter))
    found = springpot.diagnose(data, model, effects=["inertia", "time-delay"])
    assert found.verdict == "inconclusive"
    assert found.error.noise_memory == pytest.approx(0.6, abs=0.2)
    assert any("noise comes otherwise and a misfit does not" in note for note in found.notes)
    # Of what may not be missing at all nothing says what it is.
    assert found.split == ""
