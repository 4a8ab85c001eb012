"""Errors alike at one frequency of every sweep, or in neighbours along a sweep, are no noise."""

import numpy as np
import pytest
from hidden_data import KELVIN, WARM, design, exact, measured

import springpot
from springpot.diagnosis import examine
from springpot.misfit.error import times

SWEEPS = design(14, 0.1, 100.0, temperatures=(0.0, 15.0, 30.0, 45.0))
DENSE = design(60, 0.1, 100.0)
NOISE = 0.005


def rippled(at, base, waves, size=0.02, **given):
    """A periodic gain error along ln omega, the same in all sweeps."""
    x = np.log(at.omega / at.omega.min()) / np.log(at.omega.max() / at.omega.min())
    return measured(
        at, exact(base, at) * (1.0 + size * np.cos(2.0 * np.pi * waves * x)), level=NOISE, **given
    )


@pytest.mark.soak_cases("6.5-False")
@pytest.mark.parametrize(
    ("waves", "known"),
    [
        (6.5, False),
        *(
            pytest.param(*case, marks=pytest.mark.soak)
            for case in ((4.0, True), (4.0, False), (6.5, True))
        ),
    ],
)
def test_a_ripple_in_all_sweeps_is_not_taken_for_noise(waves, known):
    diagnosis = springpot.diagnose(rippled(SWEEPS, WARM, waves, known=known), WARM.name)
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.error.noise_source == ("given" if known else "estimated")
    assert diagnosis.error.noise_floor == pytest.approx(NOISE * np.sqrt(2.0), rel=0.25)


@pytest.mark.soak
def test_given_deviations_are_not_overruled_by_a_ripple_of_neighbours():
    diagnosis = springpot.diagnose(rippled(DENSE, KELVIN, 6.0, known=True), KELVIN.name)
    assert diagnosis.error.noise_source == "given"
    assert diagnosis.verdict == "unexplained"


@pytest.mark.soak_cases("0", "1")
@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 6))]
)
def test_independent_noise_in_all_sweeps_stays_noise(seed):
    data = measured(SWEEPS, exact(WARM, SWEEPS), seed, level=NOISE, known=False)
    diagnosis = springpot.diagnose(data, WARM.name)
    assert diagnosis.verdict == "adequate"
    assert diagnosis.error.noise_floor == pytest.approx(NOISE * np.sqrt(2.0), rel=0.25)


def frame_resonance(at, base, stiffness=3000.0, hertz=12.0, zeta=0.05):
    r = at.omega / (2.0 * np.pi * hertz)
    return 1.0 / (1.0 / exact(base, at) + 1.0 / (stiffness * (1.0 - r**2 + 2j * zeta * r)))


@pytest.fixture(scope="module")
def resonant():
    """The ladder whose second rung has the resonance that is there."""
    data = measured(DENSE, frame_resonance(DENSE, KELVIN), level=NOISE)
    return springpot.discover(data, KELVIN.name, accept=["frame-resonance"])


@pytest.mark.soak
def test_a_resonance_of_the_frame_is_named_but_never_certain(resonant):
    diagnosis = resonant.steps[0].case.diagnosis
    assert diagnosis.verdict == "effect-missing"
    best = diagnosis.best
    assert best.effect == "frame-resonance"
    assert best.parameters["omega_r"].value == pytest.approx(2.0 * np.pi * 12.0, rel=0.05)
    assert 0.5 < best.probability < 0.9
    assert best.probability + diagnosis.evidence["unknown"] == pytest.approx(1.0, abs=0.05)
    assert any("other narrow features" in note for note in diagnosis.notes)


@pytest.mark.soak
def test_a_resonance_is_not_tried_where_a_common_effect_explains_all():
    truth = exact(KELVIN, DENSE) - 0.02 * DENSE.omega**2
    diagnosis = springpot.diagnose(measured(DENSE, truth, level=NOISE), KELVIN.name)
    assert diagnosis.best.effect == "inertia"
    assert "frame-resonance" not in [candidate.effect for candidate in diagnosis.candidates]


@pytest.mark.soak
def test_an_accepted_effect_never_raises_the_error(resonant):
    """The rung starts from the smaller model: cold starts miss the narrow valley of this effect."""
    before, after = resonant.steps
    assert after.relative_rms < before.relative_rms
    assert after.relative_rms == pytest.approx(after.noise_floor, rel=0.15)


@pytest.mark.parametrize(
    ("ratio", "words"), [(1.04, "1 x"), (3.14, "3.1 x"), (99.4, "99 x"), (151.0, "151 x")]
)
def test_ratios_never_show_a_power_of_ten(ratio, words):
    assert times(ratio) == words


def shared_error(seed, size=0.6, length=4.0):
    """Independent noise, and a weaker error shared along frequency by neighbours of each sweep."""
    rng = np.random.default_rng(seed)
    cover = np.exp(
        -0.5 * (np.subtract.outer(np.arange(14.0), np.arange(14.0)) / length) ** 2
    ) + 1e-9 * np.eye(14)
    root = np.linalg.cholesky(cover)
    stiffness = exact(WARM, SWEEPS)
    error = np.ones(len(stiffness), dtype=complex)
    for celsius in np.unique(SWEEPS.celsius):
        rows = np.flatnonzero(SWEEPS.celsius == celsius)
        error[rows] += size * NOISE * (root @ rng.normal(size=(14, 2))) @ np.array([1.0, 1.0j])
    scatter = (
        NOISE * np.abs(stiffness) * (rng.normal(size=(2, len(stiffness))).T @ np.array([1.0, 1.0j]))
    )
    return springpot.Measurement(
        SWEEPS.omega, stiffness * error + scatter, conditions={"temperature": SWEEPS.celsius}
    )


@pytest.mark.soak
@pytest.mark.parametrize(("size", "most", "least"), [(0.0, 2, 0), (0.6, 8, 6)])
def test_an_error_that_several_neighbours_share_is_seen_along_the_sweep(size, most, least):
    """Its size is 0.6 of that of the independent noise: no point stands out, and no sweep.

    Noise that remembers tells of it as well.
    """
    seen = 0
    for seed in range(8):
        found = examine(
            shared_error(seed, size), springpot.parse_model(WARM.name), [], np.random.default_rng(0)
        ).search
        seen += found.structure.parts["runs"] < 0.02 or found.base.noise.memory > 0.0
    assert least <= seen <= most
