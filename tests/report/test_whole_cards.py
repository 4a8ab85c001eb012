"""All that is told of files, of what is installed and of laws that were found."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.cli.inspection import described
from springpot.cli.timetests import described as described_in_time
from springpot.identification import Optimiser
from springpot.measurement import Loading, Measurement, OtherTest, TimeTest, Units
from springpot.measurement.reader import Part
from springpot.registry import effect_of, parse_model, plugins
from springpot.report import invention, plugin_cards
from springpot.report.inspection import in_time_text, inspected_text, parts_text
from springpot.report.text import as_text

OMEGA, TIME = 2.0 * np.pi * np.geomspace(0.2, 20.0, 12), np.geomspace(0.02, 50.0, 30)
KINDS = {
    "models": ("kelvin", "prony-N"),
    "optimisers": ("native", "random-search"),
    "effects": ("inertia", "friction", "wlf-shift"),
    "datasets": ("artificial-hidden",),
    "objectives": ("paper",),
    "writers": ("abaqus",),
    "readers": ("springpot-csv", "signals-csv", "time-table"),
}


@dataclass(frozen=True)
class Chosen(Optimiser):
    """One with options of every kind."""

    needed: int
    given: float = 0.5
    listed: list = field(default_factory=lambda: [1, 2])


@pytest.mark.parametrize("kind", KINDS)
def test_cards_of(kind, stays):
    shown = plugin_cards.KINDS[kind]
    known = {item.name: item for item in shown.all(plugins())}
    stays(
        {
            name: [
                plugin_cards.card(shown.describe(known[name])).splitlines(),
                [plugin_cards.cell(shown.describe(known[name])[key]) for key in shown.columns],
            ]
            for name in KINDS[kind]
            if name in known
        }
    )
    assert shown.find(plugins(), KINDS[kind][0]) == known[KINDS[kind][0]]


def test_an_option_without_a_default_is_listed_too():
    assert plugin_cards.options(Chosen) == {"needed": None, "given": 0.5, "listed": [1, 2]}


def levels(*celsius, **more):
    """Sweeps at temperatures."""
    told = {"temperature": np.repeat(celsius, 12), "amplitude": np.tile(OMEGA, len(celsius))}
    k = np.tile((100.0 + 20.0j) * OMEGA**0.3, len(celsius))
    sweeps = {"units": Units("kPa", "%"), "name": "heated", "conditions": told}
    return Measurement(np.tile(OMEGA, len(celsius)), k, **(sweeps | more))


def files():
    """Measurements and their parts."""
    steps = np.repeat(["first", "second"], 12)
    noted = {"note parts": "3", "note x": "a long remark " * 8, "file": "f.csv"}
    parts = [Part("first", 12), Part("second", 12), Part("bad", 3, False, "has no force, it seems")]
    once = Measurement(OMEGA, (1.0 + 2.0j) * OMEGA, units=Units("N/mm", "mm", "rad/s"), name="one")
    told = {"note together": "12 rows each; choose one by '@batch=a'; or all"}
    return {
        "one": (once, ()),
        "heated": (levels(0.0, 20.0, 40.0), ()),
        "held": (levels(20.1, 20.3, labels={"step": steps}, provenance=noted), parts),
        "many": (levels(*np.arange(60.0)), ()),
        "mixed": (
            levels(
                20.0, 20.0, labels={"batch": np.repeat(["a", "b"], 12)}, provenance=told,
                sd=np.full(24, 1.0 + 1.0j),
            ),
            (),
        ),
    }  # fmt: skip


@pytest.mark.parametrize("name", ["one", "heated", "held", "many", "mixed"])
def test_what_a_file_holds(name, stays):
    data, parts = files()[name]
    found = described(data, parts)
    spec = "data.csv@temperature=20" if name == "mixed" else "data.csv"
    stays(
        {
            str(width): inspected_text(found, data.units, spec, width).splitlines()
            for width in (40, 100)
        }
    )


def test_parts_that_cannot_be_opened(stays):
    rows = [
        {"number": 1, "name": "n" * 60, "points": 7, "usable": True, "says": "fine"},
        {"number": 2, "name": "short", "points": 12345, "usable": False, "says": "no force " * 9},
    ]
    stays([parts_text(rows, width).splitlines() for width in (60, 200)])


class Own(OtherTest):
    """A kind that springpot does not know."""

    kind, quantity, unit = "own", "x", "dB"
    at, sd, stiffness, answer, subset = TIME, TIME, 1.0, None, None

    def __init__(self, **given):
        for name, value in {"name": "own", "units": Units("Pa", "-"), **given}.items():
            object.__setattr__(self, name, value)

    measured = 3.0 * TIME


def test_what_tests_in_time_hold(stays):
    swings = TimeTest.of_history(TIME, np.sin(TIME), 3.0 * np.sin(TIME + 0.4), "mm", "N")
    ramp = TimeTest(
        TIME, TIME**-0.3, Loading.step(0.02, 0.3), "displacement", "-", "kPa", temperature=21.57
    )
    warm = TimeTest(
        TIME, TIME**0.3, Loading.step(5.0), "force", "-", "kPa",
        warmth=np.linspace(20.0, 30.0, 30), provenance={"note a": "b" * 90},
    )  # fmt: skip
    others = Own(temperature=None, provenance={}), Own(temperature=21.57, provenance={"file": "f"})
    told = {}
    for name, tests in {"swings": [swings], "steps": [ramp, warm], "others": others}.items():
        told[name] = in_time_text(described_in_time(tests), tests, "d.csv", 70).splitlines()
    stays(told)


def found_law(plane="parallel", like=(), causal=True, passive=True, text="parallel: k*X^(-n)"):
    return SimpleNamespace(
        text=text, probability=0.625, error_after=0.0042, causal=causal, passive=passive,
        like=like, parameters={"k": "3 kN/m", "n": "0.5"}, says="the law in words", plane=plane,
    )  # fmt: skip


def invented(data, laws, effect="", verdict="class"):
    """What was found beside a spring and a dashpot; the law is half of a friction."""
    model, theta = parse_model("kelvin"), np.array([100.0, 20.0])
    grown = parse_model(f"kelvin + {effect}") if effect else model
    more = np.append(theta, np.full(len(grown.names) - 2, 0.5))
    best = SimpleNamespace(
        model=grown, theta=more, fit=SimpleNamespace(measurement=data),
        stiffness=grown.stiffness(more, data.points),
    )  # fmt: skip
    ranked = [SimpleNamespace(grown=SimpleNamespace(refit=best), effect=effect_of(effect))]
    base = SimpleNamespace(model=model, theta=theta, data=SimpleNamespace(raw=data))
    error = SimpleNamespace(
        relative_rms=0.123, noise_floor=0.005, noise_source="repeats", material_floor=0.006
    )
    experiment = SimpleNamespace(says="measure more") if verdict != "none" else None
    return SimpleNamespace(
        search=SimpleNamespace(base=base), ranked=ranked if laws else [], laws=laws, model=model,
        error=error, data="made", tried=17, verdict=verdict, says="in a sentence",
        next_experiment=experiment, notes=("a note",),
    )  # fmt: skip


@pytest.mark.parametrize(("verdict", "count"), [("class", 3), ("law", 1), ("none", 1), ("none", 0)])
def test_words_of_an_invention(verdict, count, stays):
    laws = [found_law(like=("payne", "wlf")), found_law(passive=False), found_law(causal=False)]
    found = invented(levels(20.0), laws[:count], "friction", verdict)
    stays([as_text(invention.invention_document(found), width).splitlines() for width in (60, 160)])


@pytest.mark.parametrize(
    ("plane", "effect", "celsius"),
    [
        ("parallel", "friction", (20.0,)),
        ("series", "mounting-compliance", (20.0,)),
        ("other", "arrhenius-shift", (20.0, 30.0)),
        ("", "", (20.0,)),
    ],
)
def test_pictures_of_an_invention(plane, effect, celsius, stays):
    pytest.importorskip("matplotlib")
    data = levels(*celsius)
    laws = [found_law(plane, text="k*X^(-n) " * 12)] if plane else []
    stays(invention.figure_invention(invented(data, laws, effect or "friction")))
