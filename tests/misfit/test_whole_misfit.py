"""All that is said of the misfit of a few small sweeps, to the last digit that machines share."""

import numpy as np
import pytest

import springpot
from springpot.identification.held_material import parameters_of
from springpot.measurement import Measurement, Units
from springpot.misfit import (
    drift_search,
    error,
    floor,
    frame,
    material,
    outliers,
    refit,
    regions,
    residual_causes,
    residual_tests,
    where,
)

OMEGA = 2.0 * np.pi * np.geomspace(0.1, 20.0, 16)
UNITS = Units("kN/m", "mm")


def zener(omega):
    return 50.0 + 1.0 / (1.0 / 200.0 + 1.0 / (6.0j * omega))


def scattered(stiffness, seed=1, level=0.005):
    rng = np.random.default_rng(seed)
    parts = rng.standard_normal((2, len(stiffness)))
    return stiffness * (1.0 + level * (parts[0] + 1j * parts[1]))


def made(stiffness, omega=OMEGA, **given):
    return Measurement(omega, scattered(stiffness), units=UNITS, name="made", **given)


def levels(values, factor, count=8):
    """A short sweep at each level of a condition, its stiffness times a factor of level, omega."""
    omega, value = np.tile(OMEGA[::2], len(values)), np.repeat(values, count)
    return omega, value, zener(omega) * factor(value, omega)


def amplitudes():
    omega, x, k = levels([0.1, 0.3, 1.0, 3.0], lambda x, w: 1.0 + 0.3 / (1.0 + x))
    return made(k, omega, conditions={"amplitude": x})


def temperatures():
    """Shifted by 60 kJ/mol; at the hottest level a mass moves along."""
    celsius = np.repeat([0.0, 20.0, 40.0, 60.0], 8)
    omega = np.tile(OMEGA[::2], 4)
    shifted = omega * np.exp(7217.0 * (1.0 / (celsius + 273.15) - 1.0 / 293.15))
    k = zener(shifted) - 0.004 * omega**2 * (celsius == 60.0)
    return made(k, omega, conditions={"temperature": celsius})


def rounds():
    """Three sweeps one after the other of a specimen that cures."""
    omega, time = np.tile(OMEGA[::2], 3), np.arange(24) * 5.0 + 1.0
    return made(
        zener(omega) * (1.0 + 0.01 * time / (1.0 + 0.01 * time)),
        omega,
        conditions={"time": time},
        provenance={"unit time": "s"},
    )


def held():
    """One frequency held: the first points stand within one period."""
    time = np.array([0.0, 0.2, 0.4, 0.6, *np.arange(2.0, 30.0)])
    k = zener(np.full(32, 6.0)) * np.where(time < 1.0, 0.7, 1.0)
    conditions = {"time": time}
    return made(k, np.full(32, 6.0), conditions=conditions, provenance={"unit time": "s"})


def softening():
    time = np.arange(30.0)
    k = zener(np.full(30, 6.0)) * np.exp(-0.05 * time)
    conditions = {"time": time, "amplitude": np.exp(0.05 * time)}
    return made(k, np.full(30, 6.0), conditions=conditions, provenance={"unit time": "min"})


def currents():
    omega, amperes, k = levels([0.0, 0.5, 1.0], lambda x, w: 1.0 + 0.8 * x)
    return made(k, omega, conditions={"current": amperes})


def again():
    """Rows of one frequency that differ by gain, without a number."""
    omega = np.tile(OMEGA, 2)
    return made(zener(omega) * np.repeat([1.0, 1.06], 16), omega)


def repeated():
    omega, number = np.tile(OMEGA, 3), np.repeat([1, 2, 3], 16)
    return made(zener(omega) * np.array([1.0, 1.01, 0.985])[number - 1], omega, repeat=number)


def with_outliers():
    k = zener(OMEGA)
    k[5] *= 1.2
    k[11] *= 0.9 + 0.05j
    return made(k)


def given(factor):
    k = zener(OMEGA)
    return made(k, sd=factor * 0.005 * np.abs(k) * (1 + 1j))


CASES = {
    "noise": ("zener", lambda: made(zener(OMEGA))),
    "too-simple": ("kelvin", lambda: made(zener(OMEGA))),
    "ripple": ("zener", lambda: made(zener(OMEGA) * (1 + 0.03 * np.sin(4 * np.log(OMEGA))))),
    "delay": ("zener", lambda: made(zener(OMEGA) * np.exp(-2e-3j * OMEGA))),
    "narrow": ("zener", lambda: made(zener(OMEGA) * (1 + 0.1 / (1 - (OMEGA / 30) ** 2 + 0.1j)))),
    "outliers": ("zener", with_outliers),
    "understated": ("zener", lambda: given(0.5)),
    "given": ("kelvin", lambda: given(1.0)),
    "amplitudes": ("zener", amplitudes),
    "temperatures": ("zener + arrhenius-shift", temperatures),
    "unshifted": ("zener", temperatures),
    "rounds": ("zener", rounds),
    "held": ("kelvin", held),
    "softening": ("kelvin", softening),
    "currents": ("zener", currents),
    "again": ("zener", again),
    "repeated": ("zener", repeated),
}


def of_residual(frame, raw):
    """What is found in a residual, and how it is said."""
    shift = None
    rows = outliers.outlying(frame)
    kept = outliers.trimmed(frame)
    return {
        "battery": residual_tests.battery(frame, np.random.default_rng(3)).findings,
        "places": where.where(frame),
        "periodic": where.periodic(frame),
        "discrepancy": residual_causes.discrepancy(frame, shift),
        "column": residual_causes.column_behind(frame),
        "equal rows": residual_causes.equal_rows_behind(frame, raw),
        "course": drift_search.course_behind(frame),
        "outliers": outliers.described(frame, rows),
        "scatter": [kept.variance, kept.dof, np.flatnonzero(kept.kept)],
        "about": floor.scatter_about(frame)[:2],
        "step": residual_causes.step_of(frame),
        "pulling": outliers.pulling([frame]),
        "neighbours": outliers.side_by_side(frame.measurement, rows),
        "one curve": residual_causes._is_one(
            frame, residual_causes._curve(frame, np.log(frame.measurement.omega))
        ),
    }


def of_fit(found):
    """What is known of a fit beside its noise."""
    lowest = material.material_floor(found, np.random.default_rng(4))
    return {
        "theta": found.theta,
        "rss": found.rss,
        "fair": [found.fair_rss, found.log_evidence, found.log_evidence_of_all, found.lines],
        "noise": [found.noise.source, found.noise.dof, found.noise.doubt, found.noise.sd],
        "sizes": [found.relative_rms, found.floor],
        "beyond": [floor.beyond_floor(found), floor.borne_out(found), floor.is_hardly_known(found)],
        "error": material.error_of(found, lowest).to_dict(),
        "starts": found.has_one_minimum,
        "words": [material.split_in_words(found, lowest), *material.beyond_any_material(lowest)],
        "levels": [*material.notes_on_levels(found, []), *material.notes_on_amplitudes(found)],
        "values": {name: value.to_dict() for name, value in parameters_of(found.known).items()},
    }


@pytest.fixture(scope="module", params=list(CASES))
def case(request):
    name, data = CASES[request.param]
    return floor.fitted_to_floor(springpot.parse_model(name), data())


def test_what_is_found_in_a_residual(case, stays):
    stays(of_residual(case.frame(), case.data.raw))


def test_what_is_known_of_a_fit(case, stays):
    stays(of_fit(case))


@pytest.mark.soak_cases("material + inertia")
@pytest.mark.parametrize("name", ["kelvin + inertia", "material", "material + inertia"])
def test_a_fit_with_an_effect_and_what_leaving_out_says_of_it(name, stays):
    data = temperatures()
    with_it, without = (
        floor.fitted_to_floor(springpot.parse_model(each), data)
        for each in (name, name.partition(" + ")[0])
    )
    stays(
        {
            "one minimum": [without.has_one_minimum, with_it.has_one_minimum],
            "gain": refit.prediction_gain(without, with_it),
            "pulling": outliers.pulling([without.frame(), with_it.frame()]),
            "seed": with_it.seed_from(without),
        }
    )


MOVES = [(2.0, 2.0), (2.0, 2.001), (1.0, 1.4), (1.0, 83.0), (9.0, 6.0), (9.0, 0.5), (-1.0, 3.0)]


def test_a_change_from_an_end_to_the_other_in_words(stays):
    stays([drift_search._moved("storage", ends, "Pa") for ends in MOVES])


def test_an_error_in_floors_in_words():
    assert error.over_floor(0.02, 0.04) == "0.500"
    assert error.over_floor(0.02, None) == error.over_floor(0.02, 0.0) == "-"


def spanned(frame, basis):
    """What directions have of the residual and of a fixed vector, whichever way they are turned."""
    along = np.cos(np.arange(frame.size))
    return [list(basis.shape), [np.sum((basis.T @ vector) ** 2) for vector in (frame.rest, along)]]


def test_what_a_residual_is_held_against(case, stays):
    """Directions of each kind, statistics of each test and what they say, blocks, draws."""
    found, rng = case.frame(), np.random.default_rng(5)
    data, sample = found.measurement, found.rest[None]
    bases = {
        name: getattr(found, name)
        for name in ("absorbed", "smooth", "shared", "common", "narrow", "structured", "rough")
    }
    bases |= {f"trend {name}": basis for name, basis in found.trends.items()}
    drawn = found.draws(3, rng)
    axes = where.condition_axes(data, 5)
    answer = {
        "bases": {name: spanned(found, basis) for name, basis in bases.items()},
        "rough": found.rough_dof,
        "draws": [drawn, found.standard(drawn.copy())],
        "tests": {
            test.name: [test.statistic(found, sample), test.statistic(found, 1.5 * drawn)]
            for test in residual_tests.TESTS
        },
        "shapes": [frame.slow_shapes(data), frame.shared_shapes(data), frame.waves(data, 5.0)],
        "spectrum": frame.spectrum(data, sample),
        "curves": residual_causes.causal_evidence(
            found, np.log(data.omega), [np.arange(len(data.omega))]
        ),
        "axes": [[axis.name, axis.level] for axis in axes],
        "words": [where.level_words(data, axis, np.flatnonzero(axis.level == 0)) for axis in axes],
        "folds": {
            name: [np.flatnonzero(fold) for fold in frame.folds_of(data, name)]
            for name in data.conditions
            if name in ("amplitude", "temperature")
        },
        "alone": [
            [level.error, level.variance]
            for name in data.conditions
            if name in ("amplitude", "temperature")
            for level in material.each_alone(case, name)
        ],
        "left out": [
            refit.left_out_error(case, frame.folds_of(data, name))
            for name in data.conditions
            if name in ("amplitude", "temperature") and len(data) < 33
        ],
        "apart": residual_tests.sets_apart(case.data),
    }
    if axes:
        blocks = regions.Blocks(axes)
        threshold = blocks.threshold(0.05, 1.0, np.random.default_rng(1))
        whitened = found.rest[: len(data)]
        answer["blocks"] = [threshold, blocks.regions(2.0 * whitened, 0.8 * threshold)]
    stays(answer, within=2e-3)


def test_waves_and_curves_of_drift(stays):
    pairs = frame._paired_waves(7, 9).reshape(7, 10, 2)
    own = np.sum(pairs**2, axis=(0, 2))
    stays(
        [
            own,
            frame.drift_curves(5),
            frame.drift_shapes(6),
            [frame.near_an_alarm(chance, 500) for chance in (0.5, 0.02, 0.0, 0.005)],
        ]
    )


@pytest.mark.parametrize(
    ("value", "dof", "known", "chance"),
    [(3.841459, 1.0, np.inf, 0.05), (2.0 * 4.102821, 2.0, 10.0, 0.05), (0.0, 3.0, 5.0, 1.0)],
)
def test_chances_of_squares(value, dof, known, chance):
    assert frame.chance_of_squares(value, dof, known) == pytest.approx(chance, rel=1e-5)


def test_blocks_that_touch_are_one():
    """A broad misfit of one side is one region; what is off the other way is another."""
    axis = regions.MeasuredAxis("frequency", np.arange(12))
    blocks = regions.Blocks([axis])
    whitened = np.array([0, 5, 5, 0, 0, -6, -6, -6, 0, 0, 4, 0], dtype=float)
    found = {each.spans[0]: round(each.sigma, 6) for each in blocks.regions(whitened, 3.9)}
    assert found == {
        (1, 3): round(10.0 / np.sqrt(2.0), 6),
        (5, 8): round(-18.0 / np.sqrt(3.0), 6),
        (10, 11): 4.0,
    }
    assert blocks.regions(whitened, 4.0)[-1].spans != ((10, 11),)
    assert regions._neighbours([(1, 3), (0, 2)], [(3, 5), (0, 2)])
    assert not regions._neighbours([(1, 3), (0, 2)], [(4, 5), (0, 2)])
    assert not regions._neighbours([(1, 3), (0, 2)], [(3, 5), (0, 1)])
