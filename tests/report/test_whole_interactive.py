"""What the page of a ladder is told: rows, curves, residuals, previews and rivals."""

from __future__ import annotations

import numpy as np
import pytest
from test_whole_report import MODEL, OMEGA, THETA, TIME, UNITS, levels, noisy, relaxed, sweep

import springpot
from springpot.measurement import Loading, TimeTest
from springpot.report import html, page
from springpot.report.interactive import answers, scene

SHORT = 7.0
"""Amplitude of a history, in its own unit."""


def swinging():
    """A history under a displacement, with the response of the model."""
    time = np.linspace(0.0, 20.0, 700)
    wave = SHORT * np.sin(1.3 * time)
    bare = TimeTest(time, time, Loading(time, wave), "displacement", "-", "kPa", name="history")
    value = springpot.measurement.recording.recorded(MODEL, THETA, bare).value
    scatter = np.random.default_rng(8).normal(size=len(time))
    return TimeTest(
        time, value + 0.01 * np.abs(value).max() * scatter, Loading(time, wave),
        "displacement", "-", "kPa", name="history",
    )  # fmt: skip


def crept():
    return TimeTest.of_compliance(TIME, noisy(MODEL.creep(THETA, TIME), 5).real, "kPa")


def heated():
    return levels(
        "temperature",
        {c: MODEL.stiffness(THETA, OMEGA * np.exp(-0.1 * c)) for c in (0.0, 20.0, 40.0)},
    )


def long():
    """More points than a picture has room for."""
    omega = np.geomspace(0.1, 100.0, 3000)
    k = noisy(MODEL.stiffness(THETA, omega), 6)
    return springpot.Measurement(omega, k, units=UNITS, name="long")


SWEEPS = {
    "sweep": sweep,
    "heated": heated,
    "strained": lambda: levels(
        "amplitude", {x: MODEL.stiffness(THETA, OMEGA) + 20j / x for x in (0.1, 0.3, 1.0)}
    ),
    "repeats": lambda: sweep(repeat=np.arange(12) // 6),
    "given": lambda: sweep(sd=np.full(12, 2.0 + 1.0j)),
    "long": long,
}


def plain(answer):
    """A page's columns as arrays, of which only sums are kept where they are long."""
    if isinstance(answer, dict):
        return {name: plain(value) for name, value in answer.items() if name != "discovery"}
    if isinstance(answer, list) and answer and all(isinstance(v, int | float) for v in answer):
        return np.array(answer, dtype=float)
    if isinstance(answer, list):
        return [plain(each) for each in answer]
    return answer


@pytest.mark.parametrize("name", list(SWEEPS))
def test_rows_and_curve_of_a_sweep(name, stays):
    data = SWEEPS[name]()
    page = scene.PageScene(data)
    width = np.full(len(page.rows), 0.5)
    stays(
        plain(
            {
                "page": page.to_dict(),
                "curve": page.curve(MODEL, 1.1 * THETA),
                "whole": page.curve(MODEL, 1.1 * THETA, width),
                "error": scene.relative_error(data, MODEL, 1.1 * THETA),
            }
        )
    )


TESTS = {
    "relaxation": lambda: [relaxed()],
    "creep": lambda: [crept()],
    "history": lambda: [swinging()],
    "both": lambda: [sweep(), relaxed()],
}


@pytest.mark.parametrize("name", list(TESTS))
def test_rows_and_curve_of_tests_in_time(name, stays):
    page = answers.TimeScene(TESTS[name]())
    theta = 1.1 * THETA
    stays(
        plain(
            {
                "page": page.to_dict(),
                "curve": page.curve(MODEL, theta),
                "whole": page.curve(MODEL, theta, whole=True),
            }
        ),
        within=1e-3,
    )


@pytest.mark.soak
def test_rungs_of_a_ladder(stays):
    data = sweep("heavy", 2, 0.02)
    ladder = springpot.discover(data, MODEL, accept="inertia", only=["inertia", "time-delay"])
    page = scene.PageScene(data)
    drawn = answers.rungs(ladder, lambda part: answers.drawn(part, page))
    stays(plain({str(i): rung for i, rung in enumerate(drawn)}), within=1e-3)


def test_a_rung_of_tests_in_time(stays):
    tests = [relaxed()]
    ladder = springpot.discover(tests, MODEL, accept=[], only=["force-drift", "series-spring"])
    stays(plain(answers.drawn(ladder, answers.TimeScene(tests))), within=1e-3)
    # What a page, a report and a further rung ask of sweeps they ask of these.
    (step,) = ladder.steps
    case, drift = step.examined, springpot.plugins().effect("force-drift")
    assert case.grown_with(drift).model.name == f"{MODEL.name} + force-drift"
    with pytest.raises(springpot.errors.ModelError, match="inertia was not fitted beside"):
        case.grown_with(springpot.plugins().effect("inertia"))
    assert (list(case.tests), case.untold, html._diagnosed(ladder)) == (
        tests, None, {step: ladder.diagnosis}
    )  # fmt: skip


def test_a_page_allows_its_own_program_alone():
    parts = page.bench_of({"scene": "</script>"})
    assert "</script>" not in str(parts.body).partition('id="given">')[2].partition("</script>")[0]
    assert parts.policy.startswith("'sha256-")
    assert len(parts.policy) == len("'sha256-'") + 44
    for name in page.ORDER:
        assert f'modules["{name}"] = (() => {{' in str(parts.body)
