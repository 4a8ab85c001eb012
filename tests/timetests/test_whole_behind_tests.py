"""What stands behind results of tests in time: weights, exponentials, scans, spectra, places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_whole_timetests import (
    CLOCK,
    DIAGNOSES,
    FITS,
    MAXWELL,
    MODEL,
    SOFT,
    STEPS,
    THETA,
    WAY,
    crept,
    examined,
    fitted,
    noise,
    relaxed,
    shaken,
    swept,
)

from springpot.identification import convex
from springpot.measurement import Loading, TimeTest, instrument
from springpot.measurement.imposed import imposed_noise
from springpot.measurement.mixed_up import sign_note
from springpot.misfit import residual_scatter as scatter, where_in_time as where
from springpot.misfit.residuals_of_tests import part_of, parts_of_specimen
from springpot.registry import plugins
from springpot.timetests import exponentials, material
from springpot.timetests.disturbances import lines_in
from springpot.timetests.hypotheses import FitResiduals, noise_answer
from springpot.timetests.score import TimeScan
from springpot.timetests.specimen import Scales, tries_of

CREPT = MAXWELL.creep(SOFT, STEPS)
MADE = {
    "relaxed": relaxed,
    "crept": crept,
    "shaken": shaken,
    "swept": swept,
    "other way": lambda: replace(shaken(), response=-shaken().response),
    "warm": lambda: replace(relaxed(), temperature=40.0),
    "under a force": lambda: TimeTest(
        CLOCK,
        0.02 * np.roll(WAY, 3) + 0.001 * noise(120, 7),
        Loading(CLOCK, WAY),
        "force",
        "mm",
        "N",
        name="pulled",
    ),
    "in steps": lambda: replace(crept(), response=np.round(crept().response, 3)),
}


@pytest.mark.parametrize("name", list(MADE))
def test_a_test_as_numbers(name, stays):
    test = MADE[name]()
    part = part_of(test)
    model, theta = (MODEL, THETA) if name in ("shaken", "other way") else (MAXWELL, SOFT)
    theta = 1.05 * theta
    left = part.residual(model, theta, 293.15)
    missed = part.measured - part.answer(model, theta, 293.15, np.arange(len(part.measured))).value
    found = {
        "part": [
            part.at, part.rate, part.measured, part.sd, part.size, part.stiffness, part.reach,
            part.quantity, part.unit, part.judged, part.conditions, part.log_omega, part.resolved,
            part.counted, part.relative_sd, part.signal, part.thin, part.count(), part.count(True),
        ],
        "residual": left,
        "judged": [
            part.neighbours(missed), part.sampled(missed), part.rounded(missed),
            part.places(missed), list(lines_in(part, missed)),
        ],
        "spectrum": part.lines,
        "felt": noise_answer(part, model, theta, 293.15),
        "scatter": vars(part.scatter(missed)),
    }  # fmt: skip
    if name != "swept":
        found |= {
            "against": bool(sign_note(test, "force=-N")),
            "apparent": part.apparent and [part.apparent.omega, part.apparent.stiffness],
            "digit": instrument.digit_of(test.response),
            "imposed": len(test.loading.value) > 9 and imposed_noise(test.loading.value),
        }
        scales = Scales.of([part])
        found["tries"] = {
            effect.name: tries_of(effect, test, scales)
            for effect in sorted(plugins().items("effect"), key=lambda each: each.name)
            if effect.of_test and effect.applies_to(test)
        }
        found["sizes"] = {
            parameter.name: [scales.typical(parameter), scales.values(parameter)]
            for parameter in model.parameters
        }
    stays(found, within=1e-3)


def test_quick_tests_follow_by_exponentials(stays):
    parts = parts_of_specimen([relaxed(), crept(), swept()])
    quick = exponentials.quick_parts(parts)
    stays(
        [
            [
                each.t, each.times, each.band, each.omega, each.share, each.weight,
                each.recorded(MAXWELL, SOFT, 293.15), each.count(), each.count(True),
            ]
            for each in quick
            if isinstance(each, exponentials.QuickPart)
        ]
        + [
            [type(each).__name__ for each in quick],
            convex.lattice([part.resolved for part in parts], 3),
        ],
        within=1e-3,
    )  # fmt: skip


SCANNED = ("inertia", "friction", "series-spring", "force-drift", "force-offset", "finite-ramp",
           "parallel-springpot", "time-delay", "stop")  # fmt: skip


@pytest.mark.soak_cases("relaxed", "crept", "swept too", "both")
@pytest.mark.parametrize("case", ["relaxed", "crept", "shaken", "both", "swept too"])
def test_promises_and_what_is_left(case, stays):
    data, _ = FITS[case]
    tests = data() if isinstance(data(), list) else [data()]
    fit = fitted(case)
    parts = exponentials.quick_parts(parts_of_specimen(tests))
    known = {effect.name: effect for effect in plugins().items("effect")}
    effects = [known[name] for name in SCANNED if name in known]
    scanned = TimeScan(fit, parts)
    entries = scanned.entries(effects)
    left = FitResiduals.by(fit.model, fit.theta, fit.reference, parts)
    stays(
        {
            "promises": {
                name: [[one.values, one.drop, one.amount, one.theta] for one in each[:3]]
                for name, each in entries.items()
            },
            "left": [left.chance, left.misfit, left.doubtful, left.squares(left.noise)],
            "felt": [left.squares_of_imposed(left.noise), left.over(left.noise)],
            "floor": material.material_floor([fit]),
            "linear": material.is_linear(fit),
        },
        within=5e-3,
    )


@pytest.mark.soak_cases("drift", "with a sweep")
@pytest.mark.parametrize("case", list(DIAGNOSES))
def test_what_was_tried(case, stays):
    found = examined(case)
    stays(
        {each.effect.name: [each.model.name, each.helps, each.evidence] for each in found.tried},
        within=5e-3,
    )


ROWS = np.arange(60)
RESIDUALS = {
    "white": noise(60, 1),
    "memory": np.convolve(noise(80, 2), 0.8 ** np.arange(20), "valid")[:60],
    "jump": noise(60, 3) + 6.0 * (ROWS > 35),
    "ripple": noise(60, 4) + 3.0 * np.sin(1.1 * ROWS),
    "slope": noise(60, 5) + 0.1 * ROWS,
    "point": noise(60, 6) + 20.0 * (ROWS == 20),
    "grows": noise(60, 7) * (1.0 + 0.1 * ROWS),
    "few": noise(9, 8),
}


@pytest.mark.parametrize("name", list(RESIDUALS))
def test_scatter_of_a_residual(name, stays):
    residual = RESIDUALS[name]
    found = scatter.scatter_of(residual, 1.0)
    stays(
        {
            "scatter": vars(found),
            "without usual": vars(scatter.scatter_of(residual)),
            "judged": [found.chance, found.misfit, found.doubtful, found.deviance(residual)],
            "whitened": found.whitened(residual),
            "sweep": [
                vars(scatter.scatter_of_sweep(residual[: len(residual) // 2 * 2], known))
                for known in (True, False)
            ],
            "size": [scatter.times_noise(residual, 1.0), where.rms(residual)],
            "power": scatter.powers(residual),
            "rounded": instrument.digit_of(np.round(residual, 2)),
        },
        within=1e-3,
    )


@pytest.mark.parametrize("name", ["relaxed", "crept", "shaken", "under a force"])
def test_places_of_a_misfit(name, stays):
    test = MADE[name]()
    n = len(test)
    rows = np.arange(n)
    shapes = {
        "early": 1.0 * (rows < n // 4),
        "late": 1.0 * (rows > 3 * n // 4),
        "all": np.ones(n),
        "middle": 1.0 * (np.abs(rows - n // 2) < n // 6),
        "alternating": (-1.0) ** rows,
        "slope": np.linspace(-1.0, 1.0, n),
        "with it": np.interp(test.time, test.loading.time, test.loading.value),
    }
    stays({key: where.places(test, shape + 0.1 * noise(n, 1)) for key, shape in shapes.items()})


def test_a_start_is_told_by_what_tests_look_like(stays):
    tests = [relaxed(), crept(), shaken()]
    stays(
        [
            [found.omega, found.stiffness]
            for test in tests
            if (found := part_of(test).apparent) is not None
        ]
    )
