"""Whether repeats differ by chance alone."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, average_repeats
from springpot.misfit.frame import DRAWS
from springpot.misfit.residual_tests import repeats_structure, sets_apart


def repeated(seed=3):
    """Eight points, some measured twice and some three times, in no order."""
    point, repeat = (
        np.repeat(np.arange(8), [2, 3] * 4),
        np.concatenate([np.arange(c) for c in [2, 3] * 4]),
    )
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(point))
    k = 100.0 + rng.standard_normal(20) + 1j * (10.0 + rng.standard_normal(20))
    return average_repeats(Measurement(1.0 + point[order], k, repeat=repeat[order]))


def test_simulated_repeats_lose_their_own_means(monkeypatch):
    """By hand with the same draws.

    The chance of the drift of the deviations, each point's mean taken away.
    """
    data, n = repeated(), 20
    noise = np.random.default_rng(7).standard_normal((DRAWS, 2, n))
    for point in range(8):
        rows = data.group == point
        noise[:, :, rows] -= noise[:, :, rows].mean(axis=-1, keepdims=True)
    off = data.deviations()
    sample = np.concatenate([np.array([[off.real, off.imag]]), noise])
    sample /= np.sqrt(np.mean(sample**2, axis=-1, keepdims=True))
    slow, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, n), 4))
    size = np.sum((sample @ slow) ** 2, axis=(1, 2))

    def one_by_one(*given):
        raise AssertionError("thousands of simulated rows are summed together, not in a loop")

    monkeypatch.setattr(np, "apply_along_axis", one_by_one)
    found = repeats_structure(data, np.random.default_rng(7))
    assert found.parts["drift"] == pytest.approx(np.mean(size >= size[0]), abs=2e-3)


MODEL = springpot.parse_model("fractional-zener")
SWEEP = np.geomspace(0.5, 300.0, 30)
ALONG = np.linspace(-1.0, 1.0, 30)


def three_runs(error, seed=0):
    """A sweep measured three times with noise of 0.5 % and a relative error (30,) of each run."""
    rng = np.random.default_rng(seed)
    omega, repeat = np.tile(SWEEP, 3), np.repeat([1, 2, 3], 30)
    noise = 0.005 * (rng.normal(size=90) + 1j * rng.normal(size=90))
    off = np.concatenate([error(rng) for _ in range(3)])
    stiffness = MODEL.stiffness(np.array([100.0, 400.0, 60.0, 0.5]), omega) * (1.0 + noise + off)
    return Measurement(omega, stiffness, repeat=repeat)


def specimen(rng):
    """Another piece of the same material: its own size, temperature and age."""
    gain, slope, bend = rng.normal(size=3)
    return 0.04 * gain + 0.02 * slope * ALONG + 0.01 * bend * ALONG**2 + 0.01j * slope


def going_on(rng):
    """An error that holds for two points or three."""
    cover = np.exp(-0.5 * ((ALONG[:, None] - ALONG) / 0.15) ** 2) + 1e-9 * np.eye(30)
    return 0.01 * np.linalg.cholesky(cover) @ (rng.normal(size=30) + 1j * rng.normal(size=30))


@pytest.mark.soak_cases("1")
@pytest.mark.parametrize("seed", range(2))
def test_replicates_of_several_specimens_are_no_reason_for_doubt(seed):
    data = three_runs(specimen, seed)
    apart = sets_apart(average_repeats(data))
    assert apart.curves > 0.9
    assert springpot.diagnose(data, MODEL.name).verdict == "adequate"


@pytest.mark.soak_cases("0")
@pytest.mark.parametrize("seed", range(2))
def test_an_error_that_goes_on_from_point_to_point_in_each_run_is_noise_with_a_memory(seed):
    """Runs differ by it, so that no model is to blame; what all runs share still is a misfit."""
    data = three_runs(going_on, seed)
    found = springpot.diagnose(data, MODEL.name)
    assert found.verdict == "adequate"
    assert any("neighbouring points of a sweep go together" in note for note in found.notes)
    assert not any("measured again" in note for note in found.notes)


def test_a_mass_is_named_in_noise_with_a_memory_that_repeats_tell():
    data = three_runs(going_on)
    shared = replace(data, stiffness=data.stiffness - 5e-4 * data.omega**2)
    assert springpot.diagnose(shared, MODEL.name).leading[0] == "inertia"


def test_one_slow_curve_over_all_rows_is_a_drift_and_curves_of_runs_are_none():
    drift = 0.1 * np.linspace(0.0, 1.0, 90) ** 2
    rows = iter(np.split(drift, 3))
    creeping = sets_apart(average_repeats(three_runs(lambda rng: next(rows))))
    assert creeping.one_curve
    assert creeping.drift > 0.75
    steps = iter([0.05, -0.1, 0.05])
    jumping = sets_apart(
        average_repeats(
            three_runs(lambda rng: np.full(30, next(steps)) + 0.03 * ALONG * rng.normal())
        )
    )
    assert not jumping.one_curve


@pytest.mark.suite_cases("gains1-False")
@pytest.mark.parametrize(
    ("gains", "told"), [((0.03, 0.0, -0.01), True), ((0.0, 0.03, -0.01), False)]
)
def test_runs_that_go_one_way_are_said_to_drift_if_they_are_one_specimen(gains, told):
    """Three specimens stand in one order or the other by chance.

    It is a word in a note, and no verdict.
    """
    rng = np.random.default_rng(3)
    omega = np.tile(np.geomspace(1.0, 300.0, 40), 3)
    gain = 1.0 + np.repeat(gains, 40)
    real, imaginary = 0.004 * rng.normal(size=(2, 120))
    stiffness = (50.0 + 8.0 * (1j * omega) ** 0.5) * gain * (1.0 + real + 1j * imaginary)
    data = springpot.Measurement(
        omega, stiffness, repeat=np.repeat([1, 2, 3], 40), units=springpot.Units("kN/m", "mm")
    )
    found = springpot.diagnose(data, "fractional-kelvin")
    notes = " ".join(found.notes)
    assert found.verdict == "adequate"
    assert "each run was given a gain of its own" in notes
    assert ("if they are one specimen, it drifts" in notes) is told


@pytest.mark.soak
@pytest.mark.parametrize(("shared", "verdict"), [(0.012, "unexplained"), (0.0, "adequate")])
def test_errors_that_neighbours_share_are_seen_in_repeats_and_in_their_mean_together(
    shared, verdict
):
    """Neither alone is beyond chance; of the product of two chances it is."""
    rng = np.random.default_rng(11)
    omega = np.geomspace(1.0, 300.0, 40)
    x = np.log(omega)
    alike = np.exp(-0.5 * ((x[:, None] - x[None, :]) / 0.4) ** 2) + 1e-9 * np.eye(40)
    smooth = np.linalg.cholesky(alike) @ rng.normal(size=(40, 8))
    runs = []
    for number in range(4):
        error = shared * (smooth[:, 2 * number] + 1j * smooth[:, 2 * number + 1])
        real, imaginary = 0.02 * rng.normal(size=(2, 40))
        runs.append((50.0 + 8.0 * (1j * omega) ** 0.5) * (1.0 + error + real + 1j * imaginary))
    data = springpot.Measurement(
        np.tile(omega, 4),
        np.concatenate(runs),
        repeat=np.repeat(np.arange(4), 40),
        units=springpot.Units("kN/m", "mm"),
    )
    found = springpot.diagnose(data, "fractional-kelvin")
    assert found.verdict == verdict
    assert ("goes on from point to point" in found.says) is (verdict == "unexplained")


def test_one_specimen_that_drifts_is_not_taken_for_several():
    """Four runs, one after another, while the stiffness settles.

    With a gain of each run the drift were hidden.
    """
    drifts, specimens = 0, 0
    for seed in range(20):
        rng = np.random.default_rng([17, seed])
        omega, repeat = np.tile(np.geomspace(1.0, 100.0, 20), 4), np.repeat(np.arange(4), 20)
        noise = 0.005 * (rng.standard_normal(80) + 1j * rng.standard_normal(80))
        stiffness = 1e4 * omega**0.3 * (1.0 + 0.2j) * (1.0 + noise)
        settling = 1.0 + 0.04 * np.exp(-np.arange(80) / 30.0)
        gains = 1.0 + 0.02 * rng.standard_normal(4)[repeat]
        drifts += (
            average_repeats(Measurement(omega, stiffness * settling, repeat=repeat)).own_gain == 0.0
        )
        specimens += (
            average_repeats(Measurement(omega, stiffness * gains, repeat=repeat)).own_gain > 0.0
        )
    assert drifts >= 18
    assert specimens >= 18


def test_two_specimens_at_four_temperatures_are_not_taken_for_one_that_drifts():
    """A specimen has one gain at all of them, which costs less than a gain of each run."""
    specimens, drifts = 0, 0
    for seed in range(20):
        rng = np.random.default_rng([18, seed])
        omega, repeat = np.tile(np.geomspace(1.0, 100.0, 20), 8), np.repeat(np.arange(2), 80)
        held = {"temperature": np.tile(np.repeat([0.0, 20.0, 40.0, 60.0], 20), 2)}
        noise = 0.005 * (rng.standard_normal(160) + 1j * rng.standard_normal(160))
        stiffness = 1e4 * omega**0.3 * (1.0 + 0.2j) * (1.0 + noise)
        gains = 1.0 + 0.02 * np.array([1.0, -1.0])[repeat]
        settling = 1.0 + 0.08 * np.exp(-np.arange(160) / 30.0)
        found = [
            average_repeats(Measurement(omega, stiffness * of, conditions=held, repeat=repeat))
            for of in (gains, settling)
        ]
        specimens += found[0].own_gain > 0.0
        drifts += found[1].own_gain == 0.0
    assert specimens >= 18
    assert drifts >= 18


def test_repeats_at_a_floor_of_force_do_not_drift():
    """Where K is small the same force is more of it: in order of frequency repeats calm down."""
    omega = np.repeat(np.geomspace(0.1, 100.0, 30), 3)
    stiffness, repeat = 80.0 * 1j * omega / (1.0 + 1j * omega), np.tile([1, 2, 3], 30)
    chances = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        noise = 0.4 * (rng.normal(size=90) + 1j * rng.normal(size=90))
        data = springpot.Measurement(omega, stiffness + noise, repeat=repeat)
        chances.append(repeats_structure(average_repeats(data), rng).p_value)
    # Of twelve chances none is below 0.01 but once in nine times, and these draws are fixed.
    assert min(chances) > 0.01
