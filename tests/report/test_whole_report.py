"""Every page, figure and table of small results: what a reader sees of them."""

import re
from dataclasses import replace

import numpy as np
import pytest

import springpot
from remembered import remember
from springpot.errors import SpringpotError
from springpot.lazy import draw
from springpot.measurement import Measurement, TimeTest, Units
from springpot.registry import parse_model, plugins
from springpot.report import figures
from springpot.report.canvas import blank
from springpot.report.fit_text import many_csv, many_text
from springpot.report.html import report_html
from springpot.report.residuals import VIEWS
from springpot.report.told import shown, told
from springpot.report.views import DrawnFit, Scene, residual, storage_and_loss
from springpot.rheology.drawing import network_svg
from springpot.rheology.model import Family

pyplot = pytest.importorskip("matplotlib.pyplot")

MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
OMEGA, TIME = 2.0 * np.pi * np.geomspace(0.2, 20.0, 12), np.geomspace(0.02, 50.0, 30)
UNITS = Units("kPa", "-")


def noisy(values, seed, size=0.004):
    scatter = np.random.default_rng(seed).normal(size=(2, len(values)))
    return values * (1.0 + size * (scatter[0] + 1j * scatter[1]))


def sweep(name="sweep", seed=1, mass=0.0, **more):
    k = noisy(MODEL.stiffness(THETA, OMEGA) - mass * OMEGA**2, seed)
    return Measurement(OMEGA, k, units=UNITS, name=name, **more)


def levels(column, k):
    """Three sweeps at levels of a column."""
    values = np.concatenate([noisy(each, 3 + i) for i, each in enumerate(k.values())])
    conditions = {column: np.repeat(list(k), 12)}
    return Measurement(np.tile(OMEGA, 3), values, conditions=conditions, units=UNITS, name=column)


def relaxed(seed=4):
    return TimeTest.of_relaxation(TIME, noisy(MODEL.relaxation(THETA, TIME), seed).real, "kPa")


DETERMINED = ("inertia", "time-delay", "gain-error", "parallel-spring")
ON_A_LADDER = (*DETERMINED, "specimen-inertia", "fixture-resonance", "phase-error")


def results():
    """One of each kind, and of some kinds several."""
    heavy = sweep("heavy", 2, 0.02)
    fit = springpot.identify(sweep(), MODEL)
    strains = levels(
        "amplitude", {x: MODEL.stiffness(THETA, OMEGA) + 20j / x for x in (0.1, 0.3, 1.0)}
    )
    heated = levels(
        "temperature",
        {c: MODEL.stiffness(THETA, OMEGA * np.exp(-0.1 * c)) for c in (0.0, 20.0, 40.0)},
    )
    crept = noisy(MODEL.creep(THETA, TIME), 5).real
    creep = TimeTest.of_compliance(TIME, crept, "kPa")
    return {
        "measured": heavy,
        "fit": fit,
        "fit of strains": springpot.identify(strains, "fractional-maxwell + friction"),
        "fit in time": springpot.identify(relaxed(), MODEL),
        "fit of both": springpot.identify([sweep(), relaxed()], MODEL),
        "fit of material": springpot.identify(sweep(), "material"),
        "prediction": fit.predict(frequency=[0.1, 1.0, 100.0]),
        "two points": fit.predict(frequency=[0.0, 3.0], level=0.8),
        "foretold": springpot.predict(fit, creep),
        "sweep foretold": springpot.predict(springpot.identify(relaxed(), MODEL), sweep()),
        # Of effects that are determined, however a machine rounds.
        "diagnosis": springpot.diagnose(sweep("light", 2, 0.001), MODEL, only=DETERMINED),
        "ladder": springpot.discover(heavy, MODEL, accept="inertia", only=ON_A_LADDER),
        "comparison": springpot.compare(heavy, [MODEL, "kelvin", "fractional-maxwell + inertia"]),
        "master curve": springpot.mastercurve(heated, vertical=False),
        "master curve both ways": springpot.mastercurve(heated),
    }


@pytest.fixture(scope="module")
def known():
    with pytest.MonkeyPatch.context() as patch:
        # The first rung of the ladder is the diagnosis.
        remember(patch)
        return results()


NAMES = [
    "measured",
    "fit",
    "fit of strains",
    "fit in time",
    "fit of both",
    "fit of material",
    "prediction",
    "two points",
    "foretold",
    "sweep foretold",
    "diagnosis",
    "ladder",
    "comparison",
    "master curve",
    "master curve both ways",
]
SECONDS = re.compile(r"\b[\d.]+ m?s\b")


def words(text):
    """A page without its pictures, numbers of version and times."""
    text = re.sub(r"<svg.*?</svg>|<script.*?</script>|<style.*?</style>", "", text, flags=re.S)
    return [line for line in SECONDS.sub("#", text).splitlines() if line.strip()]


def answer(ask):
    """What is answered, or why nothing is."""
    try:
        return ask()
    except (SpringpotError, TypeError) as error:
        return str(error)


@pytest.mark.soak_cases("measured")
@pytest.mark.parametrize("name", NAMES)
def test_words_of(name, known, stays):
    found = {str(width): words(told(known[name], width)) for width in (60, 140)}
    found["verbose"] = answer(lambda: words(told(known[name], verbose=True)))
    stays({**found, "notebook": words(shown(known[name]))})


@pytest.mark.soak_cases("fit of both", "comparison")
@pytest.mark.parametrize("name", NAMES)
def test_figures_of(name, known, stays):
    whole = answer(lambda: draw(known[name]))

    def onto():
        figure, axes = pyplot.subplots()
        draw(known[name], axes=axes)
        return figure

    stays({"whole": whole, "onto": answer(onto)}, within=1e-3)
    pyplot.close("all")


def seen(name):
    """Data that are drawn along another axis each, and models beside them."""
    soft, light = DrawnFit(MODEL, THETA, "soft"), DrawnFit(MODEL, 0.5 * THETA)
    heavy = DrawnFit(parse_model("fractional-maxwell + inertia"), np.append(THETA, 0.02))
    k, up = MODEL.stiffness(THETA, OMEGA), np.linspace(0.1, 1.0, 12)
    held = Measurement(np.full(12, 6.28), k, conditions={"amplitude": up}, units=UNITS)
    hot = {c: k * np.exp(-0.01 * c) for c in (0.0, 20.0, 40.0)}
    return {
        "heavy": lambda: (sweep("heavy", 2, 0.02, sd=0.01 * k), [heavy]),
        "several": lambda: (replace(sweep(), units=replace(UNITS, clock="rad/s")), [soft, light]),
        "strains": lambda: (held, [soft]),
        "heated": lambda: (levels("temperature", hot), []),
        "heated twice": lambda: (levels("temperature", hot), [soft, light]),
    }[name]()


@pytest.mark.soak_cases("heated twice")
@pytest.mark.parametrize("name", ["heavy", "several", "strains", "heated", "heated twice"])
def test_all_views_of(name, stays):
    scene = Scene(*seen(name))
    drawings = [("storage and loss", storage_and_loss), ("residual", residual), *VIEWS]
    with blank(11.0, 10.5) as figure:
        for axes, (title, draw_view) in zip(figure.subplots(3, 2).flat, drawings, strict=True):
            draw_view(axes, scene)
            axes.set_title(title.partition(":")[0])
        figures.headed(figure, scene)
    stays({"views": figure}, within=1e-3)


def test_page_of_a_ladder(known, stays, unpainted):
    page = report_html(known["ladder"], known["measured"], ["springpot", "discover"])
    body = page.partition("<h2>")[2].partition("To repeat")[0]
    stays(words(body))


def test_tables_of_many(known, stays):
    fits = [known[name] for name in ("fit", "fit in time", "fit of both")]
    stays({"text": words(many_text(fits)), "csv": words(many_csv(fits))}, within=1e-3)


def test_networks(stays):
    models = [
        each.build(3) if isinstance(each, Family) else each for each in plugins().items("model")
    ]
    stays({each.name: network_svg(each.network).splitlines() for each in models})
