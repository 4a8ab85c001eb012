"""What is noise in what a model leaves, how sure that is, and what follows for the verdict."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import springpot
from springpot import parse_model
from springpot.distributions import spectrum_of
from springpot.measurement import Loading, TimeTest, noise_of
from springpot.misfit.coloured_noise import (
    Colour,
    Imposed,
    frequencies,
    motion_test,
    powers_of,
    step_test,
)
from springpot.misfit.residual_scatter import (
    ResidualScatter,
    scatter_of,
    scatter_of_record,
    scatter_of_sweep,
)
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import plugins
from springpot.rheology.effect import SWEEPS
from springpot.timetests import diagnose, identify
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.hypotheses import ScanEntry
from springpot.timetests.score import TimeScan, _different

TIME = np.geomspace(0.01, 100.0, 120)


def noise(seed, size=120, memory=0.0):
    white = np.random.default_rng(seed).normal(size=size + 50)
    return lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white)[50:]


@pytest.mark.parametrize("seed", range(5))
def test_the_corners_that_a_smooth_effect_leaves_of_a_jump_are_misfit(seed):
    """Their spectrum is that of noise with a memory."""
    place = np.arange(120) - 75
    corners = 6.0 * np.sign(place + 0.5) * np.exp(-np.abs(place) / 12.0)
    assert scatter_of(corners + noise(seed)).misfit


@pytest.mark.soak_cases("0.3", "0.6")
@pytest.mark.parametrize("memory", [0.0, 0.3, 0.6])
def test_noise_with_a_memory_has_no_jump(memory):
    assert not any(scatter_of(noise(seed, memory=memory)).misfit for seed in range(40))


def beside_hum(seed, size, height, memory=0.0):
    hum = height * np.sin(1.43 * np.arange(size) + 1.0)
    motion = Imposed((0, 0), False, 0.0, None)
    return scatter_of_record(noise(seed, size, memory) + hum, np.zeros((0, size)), motion, size)


@pytest.mark.parametrize(("size", "memory"), [(25, 0.0), (60, 0.5), (400, 0.0), (400, 0.5)])
def test_a_hum_is_no_noise(size, memory):
    """Read as noise it hides whatever an effect does beside it."""
    found = [beside_hum(seed, size, 30.0, memory) for seed in range(6)]
    assert all(each.misfit for each in found)
    assert np.median([each.size for each in found]) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_a_faint_hum_and_none_are_noise(memory):
    assert not any(beside_hum(seed, 400, 0.2, memory).misfit for seed in range(8))
    assert not any(beside_hum(seed, size, 0.0).misfit for seed in range(8) for size in (25, 60))


@pytest.mark.parametrize("height", [0.0, 3.0])
def test_what_goes_with_the_motion_is_no_noise(height):
    """Of a random motion a stop is missed as quickly as noise with a memory varies."""
    for seed in range(8):
        moved = lfilter([1.0], [1.0, -1.5, 0.85], noise(seed, 200))
        place = moved / moved.std()
        missed = height * np.sign(place) * np.maximum(np.abs(place) - 0.7, 0.0)
        motion = Imposed((0, 0), False, 0.0, powers_of(moved, False))
        left = missed - place * (missed @ place) / 200 + noise(seed + 50, 200, 0.5)
        found = scatter_of_record(left, np.zeros((0, 200)), motion, 200)
        assert found.misfit == (height > 0.0)


@pytest.mark.parametrize("seed", [2, 19, 21, 27])
def test_noise_that_is_larger_where_the_motion_is_quick_is_noise(seed):
    rng = np.random.default_rng(seed)
    moved = np.convolve(rng.normal(size=840), np.hanning(41), "valid")
    quick = np.abs(np.gradient(moved))
    left = rng.normal(size=800) * quick / quick.max()
    spectrum = np.full(800, np.var(left))
    assert motion_test(left, spectrum, powers_of(moved, False))[0] > 0.05


def test_one_sample_far_off_is_no_jump():
    far = [noise(seed, size=200) + 7.0 * (np.arange(200) == 100) for seed in range(40)]
    assert np.mean([scatter_of(residual).misfit for residual in far]) < 0.1


@pytest.mark.parametrize("seed", range(5))
def test_a_ripple_over_a_few_points_of_a_sweep_is_misfit(seed):
    """Of noise that is not known and sixteen points: fewer than a spectrum asks for."""
    ripple = 6.0 * np.sin(2.0 * np.pi * 3.0 * np.arange(16) / 16)
    residual = np.concatenate([ripple, ripple]) + noise(seed, size=32)
    assert scatter_of_sweep(residual, known=False).misfit


def test_noise_that_is_hardly_known_makes_weak_evidence():
    """A residual that is large throughout speaks for more noise too."""
    residual = np.full(20, 2.0)
    known, told = (
        ResidualScatter(1.0, 0.0, 0.0, 1.0),
        ResidualScatter(1.0, 0.0, 0.0, 1.0, worth=4.0),
    )
    gain = [each.deviance(residual) - each.deviance(0.7 * residual) for each in (known, told)]
    assert gain[0] == pytest.approx(40.8)
    assert gain[1] == pytest.approx(24.0 * np.log((4.0 + 80.0) / (4.0 + 39.2)))


def test_a_misfit_that_may_be_chance_is_not_adequate():
    """A hump of a few standard deviations in a relaxation."""
    model = parse_model("fractional-maxwell")
    exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), TIME)
    verdicts = []
    for size in (0.0, 3.0, 6.0):
        hump = size * np.exp(-(((np.arange(120) - 60) / 6.0) ** 2))
        record = exact + 0.01 * exact.max() * (noise(4) + hump)
        found = diagnose(TimeTest.of_relaxation(TIME, record, "kPa"), model, [])
        verdicts.append(found.verdict)
    assert verdicts == ["adequate", "inconclusive", "unexplained"]


def test_the_noise_of_short_records_is_not_too_small_on_average():
    t = np.geomspace(0.01, 100.0, 60)
    powers = []
    for seed in range(60):
        record = t**-0.4 * (1.0 + 0.01 * noise(seed, size=60))
        sd = noise_of(TimeTest.of_relaxation(t, record, "kPa")).sd
        powers.append(np.mean((sd / t**-0.4) ** 2))
    # Larger where a record is too short to tell noise in proportion from a constant one.
    assert 0.0098 < np.sqrt(np.mean(powers)) < 0.011


def test_what_a_good_model_leaves_tells_constant_noise_from_noise_in_proportion():
    t = np.geomspace(0.01, 100.0, 78)
    exact = 24.0 * t**-0.25 + 1.0
    constant = 0
    for seed in range(40):
        misfit = 0.4 * noise(seed, size=78)
        told = noise_of(TimeTest.of_relaxation(t, exact + misfit, "kPa"), misfit, all_noise=True)
        constant += told.absolute > 0.3
    assert constant >= 38


def test_what_gives_in_series_promises_something_in_tests_in_time():
    """A springpot has no limit early; with a spring in series it has, to which no step leads."""
    model = parse_model("springpot + series-spring")
    theta = model.vector({"c": 91.0, "alpha": 0.57, "series-spring.k": 480.0})
    relaxed, crept = model.relaxation(theta, TIME), model.creep(theta, TIME)
    tests = [
        TimeTest.of_relaxation(TIME, relaxed + 0.01 * relaxed.max() * noise(1), "kPa", name="r"),
        TimeTest.of_compliance(TIME, crept + 0.01 * crept.max() * noise(2), "kPa", name="c"),
    ]
    fit = identify(tests, parse_model("springpot"))
    scan = TimeScan(fit, quick_parts(parts_of_specimen(tests)))
    [entry, *_] = scan.entries([plugins().effect("series-spring")])["series-spring"]
    assert entry.drop > 0.2 * float(scan.residual @ scan.residual)


def test_of_two_places_of_one_effect_each_rig_keeps_its_own():
    """That of all rigs may promise as much as that of the sweeps, and cannot be fitted then."""
    effect = plugins().effect("inertia")
    sweeps, direction = replace(effect, applies_to=SWEEPS), np.array([1.0, 0.0])
    entries = [
        ScanEntry(effect, (3.8,), np.ones(3), 354.0, 1.0, direction, True),
        ScanEntry(sweeps, (0.0017,), np.ones(3), 353.0, 1.0, direction, True),
        ScanEntry(sweeps, (0.0018,), np.ones(3), 350.0, 1.0, direction, True),
    ]
    assert _different(entries) == entries[:2]


@pytest.mark.soak
def test_an_effect_that_lowers_next_to_nothing_does_not_help():
    """Three waves in the record of a relaxation, beside which any effect is small."""
    model = parse_model("fractional-maxwell")
    exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), TIME)
    waves = np.sin(2.0 * np.pi * 3.0 * np.arange(120) / 120)
    record = exact + exact.max() * (0.1 * waves + 0.003 * noise(1))
    drifts = [plugins().effect(name) for name in ("force-drift", "finite-ramp")]
    found = diagnose(TimeTest.of_relaxation(TIME, record, "kPa"), model, drifts)
    assert found.verdict == "unexplained"
    assert found.candidates[0].over_floor > 0.9 * found.error.over_floor
    assert not found.leading


def test_a_few_small_samples_do_not_count_for_all_others_where_the_kind_of_noise_is_untold():
    """Most of a start-up lies on its plateau, where noise of either kind looks alike."""
    t = np.linspace(0.05, 15.0, 399)
    exact = 1.0 - np.exp(-2.0 * t)
    loading = Loading(np.array([0.0, 15.0]), np.array([0.0, 15.0]))
    first = []
    for seed in range(20):
        told = noise_of(
            TimeTest(t, exact + 0.002 * noise(seed, size=399), loading, force_unit="kPa")
        )
        first.append(told.sd[0] / 0.002)
    assert np.median(first) > 0.5
    assert np.max(first) < 1.5


def test_less_than_the_noise_is_no_likelier_than_the_noise():
    scatter = scatter_of(noise(1, size=200))
    white = noise(2, size=200)
    half, whole = (scatter.deviance(share * white) for share in (0.5, 1.0))
    assert half == scatter.deviance(np.zeros(200))
    assert whole <= half * 1.2
    assert scatter.deviance(2.0 * white) > 2.0 * half


@pytest.mark.parametrize("at", [100, 480, 880])
def test_a_jump_of_few_samples_of_a_long_record_is_no_noise(at):
    noise = np.random.default_rng(at).normal(size=1000)
    corner = np.linspace(0.0, 4.0, 12)
    noise[at - 12 : at] += corner
    noise[at : at + 12] -= corner[::-1]
    assert scatter_of(noise).misfit


def test_a_channel_that_stands_still_for_a_while_is_no_noise_with_a_memory():
    noise = np.random.default_rng(3).normal(size=120)
    noise[60:70] += np.linspace(2.0, 20.0, 10)
    assert scatter_of(noise).misfit


def test_a_spike_that_fades_as_the_noise_does_is_noise():
    new = np.random.default_rng(4).normal(size=400)
    new[200] = 12.0
    assert scatter_of(lfilter([1.0], [1.0, -0.6], new)).excess < 12.0


def test_a_plateau_of_repeated_digits_is_no_exact_one():
    t = np.linspace(0.0, 40.0, 800)
    noise = 0.2 * np.random.default_rng(1).normal(size=len(t))
    force = np.round(200.0 * -np.expm1(-t / 2.0) + noise)
    test = TimeTest(t, force, Loading(t, t, sampled=True), "displacement", "mm", "N")
    assert noise_of(test).sd.min() >= 1.0 / np.sqrt(12.0)
    found = diagnose(test, parse_model("maxwell"), ())
    assert found.verdict == "adequate"
    assert found.error.relative_rms < 0.003


def test_where_few_samples_are_small_noise_is_not_told_to_vanish():
    t = np.linspace(0.0, 12.0, 260)
    exact, rng = 100.0 * -np.expm1(-t / 2.0), np.random.default_rng(10)
    noise = 0.01 * np.hypot(20.0, exact)
    test = TimeTest(
        t,
        exact + noise * rng.normal(size=len(t)),
        Loading(t, t, sampled=True),
        "displacement",
        "mm",
        "N",
    )
    assert np.all(noise_of(test).sd > 0.4 * noise)


def test_a_film_that_breaks_is_not_called_noise():
    """Of a misfit of half the force neighbours differ by a hundredth: noise has no such memory."""
    time = 0.1 * np.arange(40)
    pulled = 6.0 * (1.0 - np.exp(-2.5 * time)) + 0.75 * time
    pulled[32:] = 0.0
    pulled += np.random.default_rng(1).normal(0.0, 0.01, len(time))
    test = TimeTest.of_history(time, 0.2 * time, pulled, "-", "MPa", control="displacement")
    fit = springpot.identify(test, "kelvin")
    assert fit.relative_rms > 0.3
    assert "nothing is left but noise" not in fit.standing.says


def test_what_dies_away_behind_each_step_of_a_load_is_no_noise_with_a_memory():
    noise = np.random.default_rng(3).normal(size=60)
    missed = (
        noise + np.outer([-1000.0, 1500.0, 2000.0, -1200.0], 1.0 / np.arange(1.0, 16.0)).ravel()
    )
    steps = Imposed((0, 0), False, 0.0, None, (0, 15, 30, 45))
    nothing = np.zeros((0, 60))
    assert not scatter_of_record(missed, nothing, steps._replace(steps=()), 0.0).misfit
    found = scatter_of_record(missed, nothing, steps, 0.0)
    assert found.misfit
    assert found.size < 1.5
    assert not scatter_of_record(noise, nothing, steps, 0.0).misfit


@pytest.mark.parametrize("taken", [1, 3])
def test_samples_on_the_way_of_a_step_are_not_behind_it(taken):
    """A step that takes three is missed on its way, as one that takes none at its instant."""
    residual = np.random.default_rng(3).normal(size=400)
    rows = [row + i for row in range(20, 400, 20) for i in range(taken)]
    residual[rows] += 8.0
    assert step_test(residual, rows)[0] > 0.01


@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_noise_with_a_memory_beside_what_is_known_has_both_spectra_and_one_number(memory):
    omega = frequencies(200)
    known = 5.0 * np.exp(-10.0 * omega)
    colour = Colour.of_memory(2.0, memory, known)
    expected = spectrum_of(omega, 2.0, memory) + known
    np.testing.assert_allclose(colour.spectrum(omega), expected, rtol=0.01)
    assert colour.count == 1
