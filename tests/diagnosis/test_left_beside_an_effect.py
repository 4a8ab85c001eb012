"""What an effect that is found leaves, and whether it is named: gains of sweeps, richer twins."""

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot import Diagnosis, Measurement
from springpot.diagnosis.verdict import leading_names, left_of

OMEGA = np.tile(2.0 * np.pi * np.geomspace(0.3, 30.0, 9), 4)
AMPLITUDE = np.repeat([0.2, 0.9, 4.2, 20.0], 9)
S = 1j * OMEGA


@pytest.fixture(scope="module")
def gains_of_sweeps() -> Diagnosis:
    noise = np.random.default_rng(4).normal(scale=0.01, size=(2, len(OMEGA)))
    gain = np.repeat([1.0, 1.03, 0.99, 1.04], 9)
    measured = gain * (10.0 + 0.1 * S - 1e-3 * OMEGA**2) * (1.0 + noise[0] + 1j * noise[1])
    data = Measurement(OMEGA, measured, conditions={"amplitude": AMPLITUDE})
    return springpot.diagnose(data, "kelvin", only=("inertia", "intrinsic-nonlinearity"))


@pytest.mark.soak
def test_no_effect_of_the_amplitude_is_named_for_the_gains_of_sweeps(gains_of_sweeps):
    assert gains_of_sweeps.leading == ("inertia",)
    assert "what is left looks like a gain of its own at each amplitude" in gains_of_sweeps.says


@pytest.mark.soak
def test_the_gains_of_sweeps_beside_an_effect_can_be_split_off(gains_of_sweeps):
    (step,) = gains_of_sweeps.steps
    assert step.split == "amplitude"


def test_a_name_is_not_withheld_for_curves_that_need_more_parameters():
    def grown(name: str) -> SimpleNamespace:
        effect = SimpleNamespace(name=name, narrow=False)
        refit = SimpleNamespace(log_evidence=50.0, relative_rms=0.005)
        return SimpleNamespace(names=(name,), effects=[effect], beyond_physics=[], refit=refit)

    tried = [grown(name) for name in ("friction", "slider", "power", "crosstalk", "payne")]
    search = SimpleNamespace(
        grown=tried, gain=100.0, base=SimpleNamespace(relative_rms=0.02), confounded=[]
    )
    likely = [0.95, 0.02, 0.02, 0.005, 0.005]
    explanations = [
        SimpleNamespace(names=each.names, probability=chance)
        for each, chance in zip(tried, likely, strict=True)
    ]
    evidence = SimpleNamespace(search=search, explanations=explanations)
    assert leading_names(search, evidence, "unexplained") == ["friction"]


@pytest.mark.parametrize(
    ("error", "chance", "says"),
    [
        (0.018, 0.0001, "; 1.8 x is left, which no effect explains"),
        (0.018, 0.5, "; 1.8 x is left without a pattern: some points may be bad"),
        (0.013, 0.5, ""),
        (0.011, 0.0001, ""),
    ],
)
def test_what_named_effects_leave_stands_in_the_headline(error, chance, says):
    best = SimpleNamespace(error=error, relative_rms=error, floor=0.01, error_dof=40)
    best.noise = SimpleNamespace(dof=40)
    search = SimpleNamespace(best=best, left=SimpleNamespace(p_value=chance))
    assert left_of(SimpleNamespace(rest=None, search=search)) == says
