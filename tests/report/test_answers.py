"""Answers in words: where a model fails, errors beside the floor, and how far parameters moved."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, Units
from springpot.report.answers import diagnosis_text
from springpot.report.html import report_html

pytest.importorskip("matplotlib")

OMEGA = 2.0 * np.pi * np.geomspace(0.1, 100.0, 45)


def damper(form=lambda f: 1.0, name="damper", noise=0.005):
    """A fractional Maxwell damper times a `form` of the frequency."""
    s = (1j * OMEGA) ** 0.55 * 60.0
    scatter = np.random.default_rng(7).normal(size=(2, len(OMEGA)))
    exact = 400.0 * s / (400.0 + s) * form(OMEGA / 2.0 / np.pi)
    values = exact * (1.0 + noise * (scatter[0] + 1j * scatter[1]))
    return Measurement(OMEGA, values, units=Units("kN/m", "mm"), name=name)


def page_of(data):
    ladder = springpot.discover(data, "fractional-maxwell")
    return ladder, report_html(ladder, data, ["x"])


def places_of(page):
    """The section on where the model fails."""
    return page.partition("Where the model fails")[2].partition("<h2>")[0]


@pytest.mark.parametrize(
    ("form", "words"),
    [
        (lambda f: 1.0 + 0.04 * np.sin(6.0 * np.pi * np.log10(f)), "The misfit swings by about"),
        (lambda f: 1.0 - 0.25 * np.exp(-((np.log(f / 12.0) / 0.12) ** 2)), "A single point at"),
    ],
    ids=["ripple", "notch"],
)
def test_the_report_names_every_place_that_the_diagnosis_names(form, words):
    ladder, page = page_of(damper(form))
    assert ladder.verdict == "unexplained"
    assert words in places_of(page)
    assert "noise" not in places_of(page)


def test_without_a_place_only_an_adequate_model_leaves_noise():
    ladder, page = page_of(damper())
    assert ladder.verdict == "adequate"
    assert "looks like noise" in places_of(page)
    for verdict in ("unexplained", "effect-missing", "inconclusive"):
        told = replace(ladder.diagnosis, verdict=verdict, where=())
        assert "o single band stands out" in diagnosis_text(told)
        case = replace(ladder.steps[0].case, diagnosis=told)
        changed = replace(ladder, steps=(replace(ladder.steps[0], case=case),), diagnosis=told, verdict=verdict)
        shown = places_of(report_html(changed, damper(), ["x"]))
        assert "No single band stands out" in shown
        assert "noise" not in shown
