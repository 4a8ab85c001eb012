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
