"""Every format for solvers: parsed back, it gives K within the printed digits.

What it cannot hold it refuses.
"""

from __future__ import annotations

import csv
import io
import json
import re
from typing import ClassVar

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.registry import parse_model, plugins
from springpot.rheology import Real
from springpot.solvers import Handoff, Prony
from springpot.solvers.exporting import exported
from springpot.testing import PluginContract

WRITERS = {writer.name: writer for writer in plugins().items("writer")}
OMEGA = np.geomspace(1.0, 300.0, 40)
SERIES = Prony(
    12.5,
    0.0,
    np.array([31.25, 4.125e-3, 127.0]),
    np.array([1.2345678e-3, 0.25, 7.0]),
    (1.0, 300.0),
    0.0043,
)


def handoff(prony: Prony = SERIES, **changes) -> Handoff:
    whole = {
        "unit": "MPa",
        "is_modulus": True,
        "poisson": 0.49,
        "letter": "E",
        "bulk": "relaxing",
        **changes,
    }
    return Handoff(prony, "fractional-zener", {"k": "3 MPa"}, **whole)


def own_handoff(name: str) -> Handoff:
    """A modulus that needs no conversion, or a stiffness for formats of dampers."""
    if WRITERS[name].damper:
        return handoff(is_modulus=False)
    return handoff(letter=WRITERS[name].modulus or "E")


def k_of(equilibrium: float, viscosity: float, pairs: list[tuple[float, float]]) -> Real:
    s = 1j * OMEGA
    return (
        equilibrium
        + viscosity * s
        + sum(weight * s * time / (1 + s * time) for weight, time in pairs)
    )


def numbers(text: str) -> list[float]:
    return [float(part) for part in text.split(",")]


def read_json(text: str):
    whole = json.loads(text)
    return k_of(
        whole["equilibrium"],
        whole["viscosity"],
        [(t["weight"], t["time_s"]) for t in whole["terms"]],
    )


def read_csv(text: str):
    rows = list(
        csv.reader(io.StringIO("".join(line for line in text.splitlines(True) if line[0] != "#")))
    )[1:]
    terms = [(float(weight), float(time)) for name, weight, time in rows if name.isdigit()]
    others = {name.split()[0]: float(weight) for name, weight, _ in rows if not name.isdigit()}
    return k_of(others["spring"], others.get("dashpot", 0.0), terms)


def read_python(text: str):
    room: dict = {}
    exec(compile(text, "exported", "exec"), room)
    return room["stiffness"](OMEGA)


def abaqus_materials(text: str) -> dict[str, dict[str, list[list[float]]]]:
    """Data lines by keyword line, of each material."""
    materials: dict[str, dict[str, list[list[float]]]] = {}
    for line in text.splitlines():
        if line.startswith("*MATERIAL, NAME="):
            material = materials.setdefault(line.partition("=")[2], {})
        # Of the whole model, before its materials.
        elif line.startswith("*PHYSICAL CONSTANTS"):
            assert not materials
        elif line.startswith("*") and not line.startswith("**"):
            rows = material.setdefault(line, [])
        elif not line.startswith("**"):
            rows.append(numbers(line))
    return materials


def read_abaqus(text: str):
    """*ELASTIC is instantaneous; lines are g, k, tau relative to it."""
    material = abaqus_materials(text)["SPRINGPOT"]
    [[modulus, poisson]] = material["*ELASTIC, MODULI=INSTANTANEOUS"]
    assert poisson == 0.49
    terms = material["*VISCOELASTIC, TIME=PRONY"]
    assert all(g == k for g, k, _ in terms)
    assert sum(g for g, _, _ in terms) < 1
    return k_of(
        modulus * (1 - sum(g for g, _, _ in terms)),
        0.0,
        [(modulus * g, tau) for g, _, tau in terms],
    )


def read_abaqus_frequency(text: str, omega: Real):
    """G'' = G_inf w Re g*, G' = G_inf (1 - w Im g*): w g* tabled against f, or g* = g1* f^-a."""
    material = abaqus_materials(text)["SPRINGPOT_FREQUENCY"]
    [[modulus, _]] = material["*ELASTIC, MODULI=LONG TERM"]
    f = omega / (2 * np.pi)
    if "*VISCOELASTIC, FREQUENCY=FORMULA" in material:
        [[real, imaginary, a, *bulk]] = material["*VISCOELASTIC, FREQUENCY=FORMULA"]
        assert bulk == [real, imaginary, a]
        g = omega * (real + 1j * imaginary) * f**-a
    else:
        rows = np.array(material["*VISCOELASTIC, FREQUENCY=TABULAR"])
        assert np.array_equal(rows[:, :2], rows[:, 2:4])
        g = np.interp(f, rows[:, 4], rows[:, 0]) + 1j * np.interp(f, rows[:, 4], rows[:, 1])
    return modulus * (1 - g.imag) + 1j * modulus * g.real


def read_ansys(text: str):
    modulus = float(re.search(r"^MP,EX,1,(.+)$", text, re.M)[1])
    tables = re.split(r"^TB,PRONY,1,1,(\d+),(?:SHEAR|BULK)$", text, flags=re.M)[1:]
    assert len(tables) == 4
    assert tables[1] == tables[3]
    constants: dict[int, float] = {}
    for start, rest in re.findall(r"^TBDATA,(\d+),(.+)$", tables[1], re.M):
        constants.update(enumerate(numbers(rest), int(start)))
    flat = [constants[i] for i in range(1, 2 * int(tables[0]) + 1)]
    terms = list(zip(flat[::2], flat[1::2], strict=True))
    return k_of(
        modulus * (1 - sum(g for g, _ in terms)), 0.0, [(modulus * g, tau) for g, tau in terms]
    )


def read_opensees(text: str):
    made = [line.split()[1:] for line in text.splitlines() if line.startswith("uniaxialMaterial")]
    return opensees({int(tag): (kind, [float(x) for x in rest]) for kind, tag, *rest in made})


def read_openseespy(text: str):
    made: dict[int, tuple[str, list[float]]] = {}

    class Ops:
        @staticmethod
        def uniaxialMaterial(kind: str, tag: int, *rest: float) -> None:
            made[tag] = (kind, [float(x) for x in rest])

    exec(compile(text, "exported", "exec"), {"ops": Ops})
    return opensees(made)


def opensees(made: dict[int, tuple[str, list[float]]]):
    kind, parts = made[100]
    assert kind == "Parallel"
    spring, dashpot, terms = 0.0, 0.0, []
    for tag in parts:
        kind, rest = made[int(tag)]
        if kind == "Elastic":
            spring += rest[0]
        elif kind == "Viscous":
            assert rest[1] == 1
            dashpot += rest[0]
        else:
            assert (kind, rest[2:]) == ("Maxwell", [1, 1])
            terms.append((rest[0], rest[1] / rest[0]))
    return k_of(spring, dashpot, terms)


def read_ls_dyna(text: str):
    """Fields of ten signs: G, beta, K, beta; the term without decay is the long-term one."""
    lines = text.splitlines()
    card = lines.index("$#      gi     betai        ki    betaki")
    rows = [
        [float(line[i : i + 10]) for i in range(0, 40, 10)]
        for line in lines[card + 1 : lines.index("*END")]
    ]
    young = [2 * (1 + 0.49) * g for g, *_ in rows]
    assert all(
        k == pytest.approx(e / (3 * (1 - 2 * 0.49)), rel=1e-4)
        for e, (_, _, k, _) in zip(young, rows, strict=True)
    )
    assert all(row[1] == row[3] for row in rows)
    assert rows[0][1] == 0
    return k_of(
        young[0], 0.0, [(e, 1 / row[1]) for e, row in zip(young[1:], rows[1:], strict=True)]
    )


def read_nastran(text: str):
    """Tables of K' and GE against f in Hz, straight between their points."""
    tables: dict[int, list[float]] = {}
    number = 0
    for line in text.splitlines():
        assert line.startswith("$") or all(len(field) <= 8 for field in line.split(","))
        if line.startswith("TABLED1,"):
            number = int(line.split(",")[1])
            tables[number] = []
        elif line.startswith(",") and number:
            tables[number] += [
                real(field) for field in line.split(",") if field not in ("", "ENDT")
            ]
    assert "PBUSHT,100,K,101\n,,GE,102\n" in text
    (f, k), (g, loss) = ((tables[n][::2], tables[n][1::2]) for n in (101, 102))
    at = OMEGA / (2 * np.pi)
    return np.interp(at, f, k) * (1 + 1j * np.interp(at, g, loss))


def real(field: str) -> float:
    """Nastran's 1.5-3 is 1.5e-3."""
    return float(re.sub(r"(?<=[\d.])([-+])", r"e\1", field))


def read_comsol(text: str):
    rows = dict(re.findall(r"^(\w+) ([-+.\deE]+)", text, re.M))
    terms = [
        (float(rows[f"G_{i}"]), float(rows[f"tau_{i}"])) for i in range(1, len(SERIES.times) + 1)
    ]
    return k_of(float(rows["G_inf"]), float(rows.get("eta", 0.0)), terms)


def read_fmu(text: str):
    """The constants in the C file, of which each list has one number more."""
    lists = {
        name: [float(x) for x in body.split(",")][:-1]
        for name, body in re.findall(r"(W|TAU)\[N \+ 1\] = {(.*)}", text)
    }
    return k_of(
        float(re.search(r"KE = (.*);", text)[1]),
        0.0,
        list(zip(lists["W"], lists["TAU"], strict=True)),
    )


DIGITS = {"ls-dyna": 5e-5, "nastran": 1e-3}
"""What fields of a fixed width hold, and what straight lines between points leave."""
READ = {
    name.removeprefix("read_").replace("ls_dyna", "ls-dyna"): function
    for name, function in globals().items()
    if name.startswith("read_") and name != "read_abaqus_frequency"
}


def reading(name: str):
    """As the contract asks for it; its frequencies are those of the readers here."""

    def read(text: str, omega: Real):
        assert np.array_equal(omega, OMEGA)
        return READ[name](text)

    return read


class TestWriters(PluginContract):
    plugin = "springpot_plugins.writers"
    reads: ClassVar = {name: reading(name) for name in READ}


@pytest.mark.parametrize("name", WRITERS)
def test_parsed_back_it_is_the_same_material(name: str):
    text = WRITERS[name].written(own_handoff(name))
    np.testing.assert_allclose(
        READ[name](text), SERIES.stiffness(OMEGA), rtol=DIGITS.get(name, 1e-7)
    )


@pytest.mark.parametrize("name", [name for name, writer in WRITERS.items() if writer.dashpot])
def test_a_dashpot_comes_back_too(name: str):
    series = Prony(0.0, 2.5, SERIES.weights, SERIES.times, SERIES.band, 0.01)
    text = WRITERS[name].written(handoff(series, is_modulus=False, unit="kN/m"))
    np.testing.assert_allclose(
        READ[name](text), series.stiffness(OMEGA), rtol=DIGITS.get(name, 1e-7)
    )


@pytest.mark.parametrize("name", WRITERS)
def test_the_first_lines_say_what_it_is(name: str):
    head = " ".join(WRITERS[name].written(own_handoff(name)).splitlines()[:8])
    for word in (
        "fractional-zener",
        "k = 3 MPa",
        "0.159155 to 47.7465 Hz",
        "0.43 %",
        "MPa",
        "long-term 12.5",
        "instantaneous",
    ):
        assert word in head


@pytest.mark.parametrize("name", [name for name, writer in WRITERS.items() if writer.solid])
@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"is_modulus": False, "unit": "kN/m"}, "needs a modulus"),
        ({"poisson": None}, "--poisson"),
        ({"letter": ""}, "--modulus shear, young or bulk"),
        ({"letter": "K", "bulk": "constant"}, "--bulk relaxing"),
        ({"poisson": 0.5}, "--poisson"),
        ({"prony": Prony(0.0, 0.0, SERIES.weights, SERIES.times, SERIES.band, 0.01)}, "liquid"),
        ({"prony": Prony(1.0, 2.0, SERIES.weights, SERIES.times, SERIES.band, 0.01)}, "--dashpot"),
    ],
)
def test_what_a_card_of_a_solid_cannot_hold_is_refused(name: str, changes: dict, says: str):
    with pytest.raises(ModelError, match=says) as told:
        WRITERS[name].written(handoff(**changes))
    assert "\n" not in str(told.value)


def test_a_modulus_is_no_damper():
    with pytest.raises(ModelError, match="needs a stiffness"):
        WRITERS["nastran"].written(handoff())


def test_more_terms_than_a_card_holds_are_refused():
    many = Prony(1.0, 0.0, np.ones(20), np.geomspace(1e-3, 10, 20), SERIES.band, 0.01)
    with pytest.raises(ModelError, match="17 terms beside"):
        WRITERS["ls-dyna"].written(handoff(many))


def test_fractional_parameters_keep_their_power_of_time():
    given = Handoff(
        SERIES, "fractional-maxwell", {"c": "60 kN s^alpha/m", "alpha": "0.55 -"}, "kN/m", False
    )
    text = WRITERS["comsol"].written(given)
    assert 'c 60[kN*s^0.55/m] "' in text
    assert 'alpha 0.55 "' in text


def test_the_python_file_follows_a_history():
    room: dict = {}
    exec(compile(WRITERS["python"].written(handoff()), "exported", "exec"), room)
    t = np.linspace(0.0, 2.0, 4001)
    found = room["respond"](t, 3.0 * t)
    ramp = 3.0 * (
        SERIES.equilibrium * t[-1]
        + np.sum(SERIES.weights * SERIES.times * -np.expm1(-t[-1] / SERIES.times))
    )
    assert found[-1] == pytest.approx(ramp, rel=1e-9)


def test_a_heading_cannot_break_out_of_its_comment():
    evil = Handoff(SERIES, 'x"""', {"k": "1"}, "MPa", True, 0.49, letter="E")
    exec(compile(WRITERS["python"].written(evil), "exported", "exec"), {})


GIVEN = ["k=400", "c=60", "alpha=0.55"]


def test_a_model_with_its_parameters():
    found = exported("fractional-maxwell", "json", band="1Hz:48Hz", values=GIVEN, unit="kN/m")
    assert found.handoff.prony.error < 0.005
    assert len(found.handoff.prony.times) <= 5
    omega = 2 * np.pi * np.geomspace(1, 48, 50)
    s = (1j * omega) ** 0.55
    np.testing.assert_allclose(
        found.handoff.prony.stiffness(omega), 1 / (1 / 400 + 1 / (60 * s)), rtol=0.008
    )


@pytest.mark.soak_cases(
    "fractional-zener-values0-TABULAR-0.002",
    "fractional-kelvin-values1-FORMULA-1e-07",
    "springpot-values2-FORMULA-2e-05",
)
@pytest.mark.parametrize(
    ("expression", "values", "law", "within"),
    [
        ("fractional-zener", ["k1=2", "k2=30", "c=0.5", "alpha=0.6"], "TABULAR", 2e-3),
        ("fractional-kelvin", ["k=2", "c=0.5", "alpha=0.6"], "FORMULA", 1e-7),
        ("springpot", ["c=0.5", "alpha=0.3"], "FORMULA", 2e-5),
        ("zener", None, "TABULAR", 2e-3),
    ],
)
def test_abaqus_has_the_model_itself_at_frequencies(expression, values, law, within):
    """No Prony series stands between them: its error, of half a per cent, is not in the table."""
    model = parse_model(expression)
    theta = (
        2.0 + np.arange(len(model.names))
        if values is None
        else [float(v.partition("=")[2]) for v in values]
    )
    given = [f"{name}={value}" for name, value in zip(model.names, theta, strict=True)]
    text = exported(
        expression,
        "abaqus",
        band="0.1Hz:100Hz",
        values=given,
        unit="MPa",
        poisson=0.49,
        modulus="young",
        bulk="relaxing",
    ).text
    assert f"*VISCOELASTIC, FREQUENCY={law}" in text
    omega = 2 * np.pi * np.geomspace(0.1, 100, 77)
    exact = model.stiffness(np.asarray(theta), omega)
    assert np.abs(read_abaqus_frequency(text, omega) / exact - 1).max() < within
