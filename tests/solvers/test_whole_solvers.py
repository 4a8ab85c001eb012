"""Series and files of small models, in every format, as numbers and as words."""

import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import springpot
from springpot.errors import SpringpotError
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model, plugins
from springpot.solvers import (
    Handoff,
    Prony,
    Writer,
    exported,
    exporting,
    prony_of,
    solid_of,
    young_of,
)
from springpot.solvers.prony import beside_a_spring

MAXWELL, ZENER = parse_model("fractional-maxwell"), parse_model("fractional-zener")
BURGERS, MASS = parse_model("burgers"), parse_model("fractional-maxwell + inertia")
SPECTRA = {
    "maxwell": MAXWELL.spectrum(MAXWELL.theta(k=400.0, c=60.0, alpha=0.5), (0.5, 50.0)),
    "zener": ZENER.spectrum(ZENER.theta(k1=10.0, k2=3.0, c=5.0, alpha=0.3), (0.1, 10.0)),
    "burgers": BURGERS.spectrum([3.0, 2.0, 5.0, 0.7], (0.1, 20.0)),
    "mass": MASS.spectrum([400.0, 60.0, 0.5, 0.1], (0.5, 20.0)),
}
ASKED = {
    "as usual": {},
    "a dashpot": {"dashpot": True},
    "one term": {"terms": 1},
    "three terms and a dashpot": {"terms": 3, "dashpot": True},
    "coarse": {"tolerance": 0.1},
    "too fine": {"tolerance": 1e-9},
    "nothing": {"tolerance": 0.0},
    "all of it": {"tolerance": 1.0},
    "none": {"terms": 0},
}


def answer(ask):
    """What is answered, or why nothing is."""
    try:
        return ask()
    except SpringpotError as error:
        return str(error)


@pytest.mark.soak_cases("mass", "zener", "maxwell")
@pytest.mark.parametrize("name", list(SPECTRA))
def test_series_of(name, stays):
    asked = {key: each for key, each in ASKED.items() if name == "burgers" or key != "too fine"}
    stays({key: answer(partial(prony_of, SPECTRA[name], **each)) for key, each in asked.items()})


SERIES = Prony(
    12.5, 0.0, np.array([31.25, 4.0, 127.0]), np.array([0.01, 0.25, 7.0]), (1.0, 50.0), 0
)


@pytest.mark.parametrize("measured", ["G", "E", "K"])
def test_solid_of_a_modulus(measured, stays):
    found = {}
    for poisson in (-0.3, 0.2, 0.44, 0.45, 0.46, 0.499):
        for bulk in (None, "constant", "relaxing"):
            solid = answer(partial(solid_of, SERIES, measured, poisson, bulk))
            found[f"{poisson} {bulk}"] = [solid]
            if not isinstance(solid, str):
                at_rest = solid.poisson_beside(solid.shear.equilibrium)
                words = [solid.young, at_rest, solid.says]
                found[f"{poisson} {bulk}"] += [*words, answer(partial(young_of, solid))]
    stays(found)


def test_series_beside_a_spring(stays):
    stays([answer(partial(beside_a_spring, SERIES, a, b)) for a, b in ((1.0, 2.0), (300.0, 50.0))])


def fits(folder):
    """A damper, a shear modulus over temperature, and a joint fit, kept as files."""
    omega = np.geomspace(2.0, 100.0, 16)
    theta = MAXWELL.theta(k=400.0, c=60.0, alpha=0.5)
    k = MAXWELL.stiffness(theta, omega)
    damper = Measurement(omega, k, units=Units("kN/m", "mm"), name="damper")
    rubber = Measurement(
        np.tile(omega, 2),
        np.concatenate([k, MAXWELL.stiffness(theta, 2.0 * omega)]),
        conditions={"temperature": np.repeat([20.0, 10.0], 16)},
        units=Units("MPa", "-", letter="G"),
        name="rubber",
    )
    for data, model in ((damper, MAXWELL.name), (rubber, "fractional-maxwell + arrhenius-shift")):
        fit = springpot.identify(data, model)
        (folder / f"{data.name}.json").write_text(json.dumps(fit.to_dict()), encoding="utf-8")


CARDS = {
    "rubber": ("rubber.json", {"band": "1Hz:10Hz", "temperature": 15.0, "poisson": 0.49}),
    "rubber that relaxes": ("rubber.json", {"band": "0.1rad/s:1e3 rad/s", "poisson": 0.3}),
    "rubber too hot": ("rubber.json", {"band": "1Hz:10Hz", "temperature": 80.0}),
    "young's": ("rubber.json", {"band": "1Hz:10Hz", "modulus": "young", "poisson": 0.4}),
    "damper": ("damper.json", {"band": "1Hz:10Hz", "terms": 2}),
    "stated": (
        "zener",
        {"band": "1Hz:10Hz", "values": ["k1=1", "k2=2", "c=0.1"], "unit": "MPa", "poisson": 0.2}
        | {"modulus": "shear", "bulk": "constant"},
    ),
    "without unit": ("maxwell", {"band": "1Hz:10Hz", "values": ["k=1", "c=0.1"]}),
}
LONGEST = 45
"""Lines of a file that are looked at."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fits")
    fits(folder)
    return folder


@pytest.mark.soak_cases("rubber", "rubber that relaxes", "damper", "rubber too hot")
@pytest.mark.parametrize("card", list(CARDS))
def test_files_of(card, folder, stays, monkeypatch):
    monkeypatch.chdir(folder)
    source, asked = CARDS[card]
    # All formats are handed one series.
    kept = []

    def once(spectrum, **how):
        kept.extend([] if kept else [prony_of(spectrum, **how)])
        return kept[0]

    monkeypatch.setattr(exporting, "prony_of", once)
    found = {}
    for writer in plugins().items("writer"):
        made = answer(partial(exported, source, writer.name, **asked))
        found[writer.name] = made
        if not isinstance(made, str):
            text = re.sub(r"springpot \d+\S*", "springpot", made.text)
            found[writer.name] = [text.splitlines()[:LONGEST], made.outside, made.to_dict()]
    stays(json.loads(json.dumps(found, default=str)), within=1e-3)


def test_terms_at_the_edge_of_what_was_measured_are_within_it():
    card = Handoff(SERIES, "zener", {}, "MPa", True, covered=(1.0 / 7.0, 4.0))
    assert card.outside.tolist() == [True, False, False]
    assert Handoff(SERIES, "zener", {}, "MPa", True).outside.tolist() == [False] * 3


@pytest.mark.parametrize(("equilibrium", "solid"), [(0.5e-2, False), (2e-2, True)])
def test_a_solid_keeps_a_millionth_of_its_modulus(equilibrium, solid):
    series = Prony(equilibrium, 0.0, np.array([1e4]), np.array([1.0]), (1.0, 2.0), 0.0)
    card = Handoff(series, "zener", {}, "MPa", True, 0.3, letter="G")
    writer = Writer("card", lambda handoff: "text", "in two words", ".inp", solid=True)
    found = answer(lambda: writer.written(card))
    assert (found == "text") == solid
    assert solid or "is a liquid on this band (long-term modulus 0.005)" in found


@pytest.mark.parametrize(
    ("more", "writer", "says"),
    [
        ({}, {}, "text"),
        ({"is_modulus": False}, {}, "card needs a modulus, and zener is a stiffness in MPa:"),
        ({"is_modulus": False}, {"solid": False}, "text"),
        ({"letter": ""}, {}, "is a shear, Young's or bulk modulus, which the data do not say"),
        ({"poisson": 0.5}, {}, "a solid needs Poisson's ratio, above -1 and below 0.5"),
        ({"poisson": -1.0}, {}, "a solid needs Poisson's ratio"),
        ({"poisson": -0.99}, {}, "text"),
        ({"poisson": None}, {}, "a solid needs Poisson's ratio"),
        ({}, {"solid": False, "damper": True}, "card needs a stiffness, and zener is a modulus"),
        ({"is_modulus": False}, {"solid": False, "damper": True}, "text"),
        ({"dashpot": 1e-9}, {"solid": False, "dashpot": False}, "card has no dashpot beside"),
        ({"dashpot": 1e-9}, {"solid": False}, "text"),
        ({}, {"dashpot": False}, "text"),
    ],
)
def test_a_format_is_handed_what_it_can_hold(more, writer, says):
    series = replace(SERIES, viscosity=more.pop("dashpot", 0.0))
    known = {"is_modulus": True, "poisson": 0.3, "letter": "G"} | more
    card = Handoff(series, "zener", {}, "MPa", **known)
    made = Writer(
        "card", lambda handoff: "text", "in two words", ".inp", **({"solid": True} | writer)
    )
    assert says in answer(lambda: made.written(card))
