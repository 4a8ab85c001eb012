"""All that is read out of small signals, tests and sweeps, as numbers and as words."""

import numpy as np
import pytest

from springpot.errors import SpringpotError
from springpot.measurement import (
    Measurement,
    TimeTest,
    Units,
    geometry,
    harmonics_of,
    independence,
    instrument,
    mixed_up,
    noise_of,
    replicates,
    scatter,
    units,
)
from springpot.measurement.conversion import through
from springpot.measurement.covered import Covered
from springpot.measurement.mixed_up import exchange_note, material_misfit, sign_note
from springpot.measurement.opening import select, without
from springpot.measurement.recording import Record
from springpot.measurement.replicates import again_note, stands_again


def answer(ask):
    """What is answered, or why nothing is."""
    try:
        return ask()
    except SpringpotError as error:
        return str(error)


# Signals -----------------------------------------------------------------------------------------


def swinging(n=400, cycles=7.3, noise=0.002, third=0.0, seed=1, uneven=False):
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 2.0 * np.pi * cycles / 5.0, n)
    if uneven:
        t = np.sort(rng.uniform(0.0, t[-1], n))
    turn = np.exp(1j * (5.0 * t + 0.7))
    q = 2.0 * turn.real + 0.3 + 0.01 * t
    u = ((600.0 + 240.0j) * turn).real + 5.0 - 0.2 * t + third * (turn**3).real
    return t, q + 2.0 * noise * rng.normal(size=n), u + 600.0 * noise * rng.normal(size=n)


def starting():
    """The rig starts up, and another frequency follows."""
    t, q, u = swinging(n=900, cycles=15.0)
    grow = np.clip((t - 2.0) / 4.0, 0.0, 1.0)
    return t, q * grow, u * grow


def switched():
    first, second = swinging(cycles=8.0), swinging(cycles=3.0, seed=4)
    return tuple(
        np.concatenate([a, b + (a[-1] + 0.03) * (i == 0)])
        for i, (a, b) in enumerate(
            zip(first, (second[0], 0.3 * second[1], 0.3 * second[2]), strict=True)
        )
    )


def decaying():
    t, q, u = swinging()
    return t, q, u + 300.0 * np.exp(-3.0 * t)


SIGNALS = {
    "clean": (swinging(noise=0.0), {}),
    "noisy": (swinging(), {}),
    "loud": (swinging(noise=0.3), {}),
    "given": (swinging(), {"omega": 5.0}),
    "third": (swinging(third=60.0), {"n_harmonics": 5}),
    "uneven": (swinging(uneven=True), {}),
    "short": (swinging(n=60, cycles=1.6), {}),
    "starting": (starting(), {}),
    "switched": (switched(), {}),
    "decaying": (decaying(), {}),
    "window": (swinging(), {"window": (2.0, 7.0)}),
    "other way": ((swinging()[0], swinging()[1], -swinging()[2]), {}),
    "still": ((np.arange(50.0), np.zeros(50), np.ones(50)), {}),
}


@pytest.mark.parametrize("case", list(SIGNALS))
def test_harmonics_of_signals(case, stays):
    channels, options = SIGNALS[case]
    found = answer(lambda: harmonics_of(*channels, **options))
    if not isinstance(found, str):
        found = [found, found.amplitude, found.work, answer(lambda: found.relative)]
    stays(found)


# Tests in time -----------------------------------------------------------------------------------

CLOCK = np.linspace(0.0, 10.0, 81)
HELD = np.minimum(CLOCK / 0.4, 1.0)
ANSWER = 5.0 * np.exp(-CLOCK / 3.0) * HELD + 0.01 * np.random.default_rng(2).normal(size=81)


def history(way, force, **options):
    return TimeTest.of_history(CLOCK, way, force, "mm", "N", **options)


def in_time():
    late = CLOCK[1:]
    warm = np.linspace(20.0, 30.0, 81)
    return {
        "relaxation": TimeTest.of_relaxation(late, 7.0 / (1.0 + late), "kPa", rise=0.02),
        "creep": TimeTest.of_compliance(late, 1.0 - np.exp(-late), "MPa", temperature=25.0),
        "held": history(HELD, ANSWER),
        "startup": history(0.5 * CLOCK, ANSWER),
        "history": history(np.sin(CLOCK), np.cos(CLOCK) + 0.1 * ANSWER, temperature=warm),
        "recovery": history(ANSWER, np.where(CLOCK < 4.0, HELD, 0.0), control="force"),
        "long creep": history(1.0 + np.log1p(CLOCK), np.full(81, 3.0)),
        "turned": history(np.sin(CLOCK), -np.sin(CLOCK + 0.2)),
        "strained": TimeTest.of_history(CLOCK, 100.0 * HELD, ANSWER, "%", "kPa", rise=0.3),
    }


@pytest.mark.parametrize("case", list(in_time()))
def test_what_a_test_in_time_is(case, stays):
    test = in_time()[case]
    noise, rough = noise_of(test), noise_of(test, 0.01 * ANSWER[-len(test) :], all_noise=True)
    stays(
        {
            "kind": [test.kind, test.control, test.answered, test.rise, test.start, len(test)],
            "units": [test.response_unit, test.loading_unit, test.units, test.words],
            "seen": [test.seen, test.duration, test.kelvin],
            "loading": [test.loading.time, test.loading.value, test.loading.jumps],
            "noise": [noise, noise.floor, rough, rough.floor],
            "half": answer(lambda: test.subset(test.time > 3.0).response),
            "sign": sign_note(test, "mark"),
            "record": answer(lambda: Record.of(test)),
            "in N/mm": answer(lambda: test.in_units(Units("N/mm", "mm")).response),
            "seen through": [
                answer(lambda name=name: through(test, geometry.parse_geometry(name)).response)
                for name in GEOMETRIES[:2]
            ],
        }
    )


# Units and geometries ----------------------------------------------------------------------------

GEOMETRIES = (
    "shear-pads area=200cm^2 gap=10mm pads=2",
    "annular-dashpot inner-diameter=20mm outer-diameter=24mm length=50mm",
    "annular-dashpot inner_radius=10mm outer_radius=12mm length=50mm closed=yes",
    "parallel-plates diameter=40mm gap=1mm",
    "cone-plate radius=20mm angle=2deg",
    "torsion-bar length=40mm width=10mm thickness=2mm",
    "constants stress=3/m^3 strain=20",
    "shear-pads area=200cm^2",
    "shear-pads area=200 gap=10mm",
    "parallel-plates radius=0mm gap=1mm",
    "square-pads area=1m^2",
)


def test_units_and_their_spellings(stays):
    tables = {name: getattr(units, name) for name in dir(units) if name.endswith("_UNITS")}
    spelt = (
        "kN per mm",
        "n/mm",
        "Pa s",
        "KPa",
        "dyn/cm2",
        "Newton",
        "µm",
        "°C",
        "cps",
        "N·m",
        "1/s",
    )
    pairs = (("kN/m", "mm"), ("MPa", "-"), ("N m/rad", "rad"), ("lbf/in", "in"), ("Pa", "mm"))
    stays(
        {
            **tables,
            "normal": [units.normal_unit(text) for text in spelt],
            "near": [units.near_units(text, units.FORCE_UNITS) for text in ("n", "KN", "lb")],
            "known": [
                answer(lambda text=text: units.known_unit(text, units.LENGTH_UNITS, "the gap"))
                for text in ("mm", "Millimetre", "kg", "")
            ],
            "pairs": [
                answer(lambda pair=pair: [Units(*pair).at(3.14159), Units(*pair).magnitude])
                for pair in pairs
            ],
            "warm": [
                answer(lambda unit=unit: units.temperature_in_celsius(300.0, unit))
                for unit in ("K", "degF", "degC", "R")
            ],
            "clock": [Units("Pa", "-", clock="rad/s").on_clock(2.0), Units("Pa", "-").at(0.5)],
        }
    )


def test_geometries_and_what_is_seen_through_them(stays):
    omega = np.array([1.0, 10.0])
    stiff = Measurement(
        omega,
        np.array([3.0 + 1.0j, 5.0 + 2.0j]),
        sd=np.array([0.1 + 0.2j, 0.2 + 0.1j]),
        conditions={"amplitude": np.array([0.1, 0.2])},
        units=Units("kN/m", "mm"),
        name="damper",
    )
    torque = Measurement(omega, stiff.stiffness, units=Units("N m/rad", "rad"), name="torque")
    found = {}
    for text in GEOMETRIES:
        specimen = answer(lambda text=text: geometry.parse_geometry(text))
        found[text] = specimen
        if isinstance(specimen, str):
            continue
        rows = []
        for data in (stiff, torque):
            seen = answer(lambda data=data, specimen=specimen: data.as_modulus(specimen, "kPa"))
            back = seen
            if not isinstance(seen, str):
                back = seen.as_stiffness(specimen).stiffness
            rows.append([seen, back])
        found[text] = {
            "words": geometry.words_of(specimen),
            "factors": [specimen.stress_factor, specimen.strain_factor, specimen.shape],
            "seen": [
                [part if isinstance(part, str) else _told(part) for part in row] for row in rows
            ],
        }
    stays(found)


def _told(part):
    if isinstance(part, np.ndarray):
        return part
    return [part.stiffness, part.sd, part.conditions, str(part.units), part.provenance]


# Sweeps ------------------------------------------------------------------------------------------

OMEGA = np.geomspace(0.5, 60.0, 9)


def zener(omega):
    return 50.0 + 1.0 / (1.0 / 200.0 + 1.0 / (6.0j * omega))


def made(stiffness, omega, seed=1, level=0.01, **given):
    rng = np.random.default_rng(seed)
    parts = rng.standard_normal((2, len(omega)))
    noisy = stiffness * (1.0 + level * (parts[0] + 1j * parts[1]))
    return Measurement(omega, noisy, units=Units("kPa", "-"), name="made", **given)


def sweeps():
    twice, thrice = np.tile(OMEGA, 2), np.tile(OMEGA, 3)
    strain = np.repeat([0.1, 0.2, 0.4], 9)
    celsius = np.repeat([0.0, 20.02, 40.0], 9) + np.tile([0.0, 0.01, -0.01], 9)
    held = np.full(14, 6.0)
    return {
        "one": made(zener(OMEGA), OMEGA),
        "repeats": made(
            zener(thrice) * np.repeat([1.0, 1.02, 0.99], 9), thrice, repeat=np.repeat([1, 2, 3], 9)
        ),
        "again": made(zener(twice) * np.repeat([1.0, 1.1], 9), twice),
        "strains": made(zener(thrice) / (1.0 + strain), thrice, conditions={"amplitude": strain}),
        "celsius": made(zener(thrice), thrice, conditions={"temperature": celsius}),
        "follows": made(zener(OMEGA), OMEGA, conditions={"amplitude": 1.0 / OMEGA}),
        "current": made(
            zener(twice),
            twice,
            conditions={"current": np.repeat([0.5, 1.0], 9)},
            labels={"batch": np.repeat(["a", "b"], 9)},
        ),
        "held": made(
            zener(held), held, conditions={"time": np.arange(14.0)}, provenance={"unit time": "min"}
        ),
        "exchanged": made(1j * zener(OMEGA).conj(), OMEGA),
        "rounded": made(np.round(zener(OMEGA), -1), OMEGA, level=0.0),
        "given": made(zener(OMEGA), OMEGA, sd=np.full(9, 1.0 + 0.5j)),
        "negative": made(-zener(OMEGA), OMEGA),
    }


@pytest.mark.parametrize("case", list(sweeps()))
def test_what_a_sweep_holds(case, stays):
    data = sweeps()[case]
    mean = replicates.average_repeats(data)
    noise = answer(lambda: replicates.noise_of_repeats(mean))
    even = np.ones(len(data), dtype=bool)
    residual = data.stiffness - zener(data.omega)
    stays(
        {
            "runs": [[run.name, run.rows, run.conditions] for run in mixed_up.runs_of(data)],
            "sweeps": mixed_up.sweeps_of(data),
            "settings": mixed_up.settings_of(data),
            "together": mixed_up.tests_together(data),
            "temperatures": mixed_up.temperatures_differ(data),
            "mean": [mean.mean.stiffness, mean.deviations(), mean.own_gain],
            "noise": noise,
            "thin": replicates.thinned(data).omega,
            "again": [again_note(data), stands_again(data)],
            "exchanged": [exchange_note(data), material_misfit(data.omega, data.stiffness)],
            "numbers": independence.frequency_numbers(data),
            "distinct": independence.distinct_log_omega(data),
            "one": independence.at_one_frequency(data),
            "telling": independence.telling(data),
            "moved": independence.moved_along(data),
            "steadied": independence.steadied(data).conditions,
            "spread": {
                name: answer(lambda name=name: independence.spread_of(data, name))
                for name in data.conditions
                if name in ("amplitude", "temperature")
            },
            "shape": scatter.robust_noise_shape(data, residual, even)[0],
            "uneven": scatter.robust_noise_shape(data, residual, even, True)[0],
            "rounding": [
                instrument.rounding_step(data.storage),
                scatter.at_least_rounding(np.full(len(data), 1e-9 + 1e-9j), data),
            ],
            "levels": {name: data.levels(name) for name in data.conditions},
            "first half": answer(lambda: select(data, {"omega": "..5"}).omega),
            "rows": answer(lambda: without(data, {"row": "2..4"}).omega),
            "rows of one": [mixed_up.largest_test(data, name) for name in data.labels],
        }
    )


def test_noise_that_is_checked(stays):
    known = scatter.Noise(np.full(4, 0.1 + 0.2j), np.inf, "given")
    wide = [scatter.plausible_variance(dof) for dof in (2.0, 10.0, 100.0)]
    checked = [
        scatter.checked_noise(known, variance, 20.0) for variance in (0.2, 0.9, 1.0, 2.0, 9.0)
    ]
    stays({"wide": wide, "checked": checked, "likely": known.log_likelihood(3.0, 8)})


def test_what_was_covered(stays):
    found = sweeps()
    both = Covered.of([found["strains"], found["celsius"], in_time()["relaxation"]])
    omega = np.array([0.4, 0.5, 30.0, 61.0])
    conditions = {
        "temperature": np.array([-1.0, 20.0, 40.3, 41.0]),
        "amplitude": np.array([0.05, 0.1, 0.4, 0.5]),
    }
    stays(
        {
            "kept": both.to_dict(),
            "read": Covered.read(both.to_dict()),
            "beyond": both.beyond(omega, conditions),
            "outside": both.outside(omega, conditions),
            "remark": both.remark(omega, conditions, Units("kPa", "-")),
            "none": both.remark(omega[1:2], {}, Units("kPa", "-")),
            "told": [both.told(Units("kPa", "-")), both.told(Units("kPa", "-", clock="rad/s"))],
        }
    )
