"""A card at an amplitude, with a law of temperature, with sliders: what a solver makes of it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from test_writers import abaqus_materials, read_nastran

import springpot
from springpot.errors import ModelError
from springpot.registry import parse_model
from springpot.rheology import Points
from springpot.solvers.exporting import exported
from springpot.solvers.handoff import shift_law_of

BAND = "0.1Hz:50Hz"
OMEGA = np.geomspace(1.0, 300.0, 40)
"""Those of `read_nastran`."""
SLIDER = {"elasto-sliding.k": 2.0, "elasto-sliding.F": 3.0}
MATERIAL = {"k": 4.0, "c": 0.6, "alpha": 0.3}


def given(values: dict[str, float]) -> list[str]:
    return [f"{name}={value}" for name, value in values.items()]


def at(model, values, omega, amplitude):
    points = Points(np.log(omega), np.full(len(omega), amplitude), None, 293.15)
    return model.stiffness(model.vector(values), points)


EXPRESSION, VALUES = "fractional-maxwell + elasto-sliding", MATERIAL | SLIDER


def test_at_an_amplitude_a_card_holds_the_first_harmonic_there():
    """The series within the error that it states, the table of K itself."""
    # A loss that is the same at all frequencies, without storage that grows, no series follows.
    model, values = parse_model(EXPRESSION), VALUES | {"elasto-sliding.k": 0.2}
    for amplitude in (5.0, 20.0, 80.0):
        told = exported(
            EXPRESSION,
            "json",
            band=BAND,
            values=given(values),
            unit="kN/mm",
            amplitudes=[amplitude],
            terms=6,
        )
        prony = told.handoff.prony
        omega = np.geomspace(*prony.band, 50)
        exact = at(model, values, omega, amplitude)
        off = np.abs(prony.stiffness(omega) / exact - 1.0).max()
        assert off <= 1.05 * prony.error
        assert prony.error < 0.05
        assert f"amplitude of {amplitude:g} mm" in told.text


@pytest.mark.soak
def test_several_amplitudes_are_several_materials_of_one_file():
    model = parse_model(EXPRESSION)
    whole = {"band": BAND, "values": given(VALUES), "unit": "kN/mm", "terms": 3}
    text = exported(EXPRESSION, "nastran", **whole, amplitudes=[1.0, 8.0]).text
    cards = [f"$ {part}" for part in text.split("$ springpot:")[1:]]
    # The reader knows the numbers of the first material only.
    for tag in (100, 101, 102):
        assert f",{tag + 3}" not in cards[0]
        cards[1] = cards[1].replace(f",{tag + 3}", f",{tag}")
    # It reaches beyond the band on one side.
    inside = (2 * np.pi * 0.1 < OMEGA) & (2 * np.pi * 50 > OMEGA)
    for card, amplitude in zip(cards, (1.0, 8.0), strict=True):
        exact = at(model, VALUES, OMEGA, amplitude)[inside]
        np.testing.assert_allclose(read_nastran(card)[inside], exact, rtol=2e-3)
    listed = json.loads(exported(EXPRESSION, "json", **whole, amplitudes=[1.0, 8.0]).text)
    assert [each["parameters"]["amplitude"] for each in listed] == ["1 mm", "8 mm"]
    with pytest.raises(ModelError, match="give one amplitude"):
        exported(EXPRESSION, "python", **whole, amplitudes=[1.0, 8.0])
    told = exported(EXPRESSION, "csv", **whole, amplitudes=[1.0, 8.0]).to_dict()
    assert [each["parameters"]["amplitude"] for each in told["each"]] == ["1 mm", "8 mm"]


def test_what_depends_on_the_amplitude_asks_for_one(springpot):
    asked = ["export-model", EXPRESSION, "--to", "csv", "--band", BAND, "--unit", "kN/mm"]
    asked += [word for value in given(VALUES) for word in ("--set", value)]
    springpot(*asked).is_one_line("give --amplitude")
    assert springpot(*asked, "--amplitude", "1,8", "--terms", "2").out.count("linearised") == 2
    plain = ["export-model", "fractional-maxwell", *asked[2:8]]
    plain += [word for value in given(MATERIAL) for word in ("--set", value)]
    springpot(*plain, "--amplitude", "1").is_one_line("does not know amplitude")


LAWS = {
    "wlf-shift": {"wlf-shift.C1": 8.86, "wlf-shift.C2": 101.6},
    "arrhenius-shift": {"arrhenius-shift.Ea": 60.0},
}
SOLID = {"k1": 1.0, "k2": 10.0, "c": 0.6}


def trs(text: str, celsius: float) -> float:
    """Factor of the times, by the User's Guide of Abaqus 22.7.1."""
    rows = abaqus_materials(text)["SPRINGPOT"]
    if "*TRS, DEFINITION=WLF" in rows:
        [[start, c1, c2]] = rows["*TRS, DEFINITION=WLF"]
        return 10.0 ** (-c1 * (celsius - start) / (c2 + celsius - start))
    [[start, energy]] = rows["*TRS, DEFINITION=ARRHENIUS"]
    constants = text.partition("*PHYSICAL CONSTANTS, ABSOLUTE ZERO=")[2].splitlines()[0]
    zero, gas = map(float, constants.split(", UNIVERSAL GAS="))
    return float(np.exp(energy / gas * (1 / (celsius - zero) - 1 / (start - zero))))


@pytest.mark.parametrize("law", LAWS)
def test_abaqus_shifts_the_times_as_the_model_does(law: str):
    """By a card at the reference temperature, K at any other."""
    expression, values = f"zener + {law}", SOLID | LAWS[law]
    whole = {"band": BAND, "values": given(values), "unit": "MPa", "poisson": 0.3}
    text = exported(expression, "abaqus", **whole, modulus="shear", bulk="relaxing").text
    rows = abaqus_materials(text)["SPRINGPOT"]
    [[young, poisson]] = rows["*ELASTIC, MODULI=INSTANTANEOUS"]
    [[share, _, time]] = rows["*VISCOELASTIC, TIME=PRONY"]
    model, omega = parse_model(expression), np.geomspace(0.1, 100.0, 9)
    for celsius in (5.0, 20.0, 60.0):
        turned = 1j * omega * time * trs(text, celsius)
        shear = young / (2 * (1 + poisson)) * (1 - share + share * turned / (1 + turned))
        warm = Points(np.log(omega), None, np.full(9, celsius + 273.15), 293.15)
        np.testing.assert_allclose(shear, model.stiffness(model.vector(values), warm), rtol=1e-6)
    held = exported(expression, "abaqus", **whole, modulus="shear", temperature=40.0).text
    assert "*TRS" not in held
    json_card = json.loads(exported(expression, "json", **whole).text)
    assert json_card["shift"]["reference_degC"] == pytest.approx(20.0)


@pytest.mark.parametrize("target", ["ansys", "ls-dyna"])
def test_a_law_whose_sign_is_not_sure_is_told_and_left_to_the_user(target: str):
    values = SOLID | LAWS["wlf-shift"]
    whole = {"band": BAND, "unit": "MPa", "poisson": 0.3, "modulus": "shear"}
    text = exported("zener + wlf-shift", target, **whole, values=given(values)).text
    assert "left to you (unchecked here)" in text
    assert "C1 = 8.86" in text
    plain = exported("zener", target, **whole, values=given(SOLID)).text
    assert "unchecked" not in plain


def test_a_law_is_told_by_its_shape_and_one_that_is_another_is_not():
    for text, values, kind in (
        ("zener + cold = shift: exp(-C * (T - Tr) / T)", {"cold.C": 20.0}, "arrhenius"),
        ("zener + vertical-shift", {"vertical-shift.n": 1.0}, None),
        ("zener + wlf-shift + vertical-shift", LAWS["wlf-shift"] | {"vertical-shift.n": 1}, None),
        ("zener", {}, None),
    ):
        name, _, own = text.partition(" + ")
        model = parse_model(name) + springpot.law(own) if "=" in own else parse_model(text)
        law = shift_law_of(model, model.vector(SOLID | values), 293.15)
        assert (law.kind if law else None) == kind
        if kind:
            np.testing.assert_allclose(law.log_factor(np.array([30.0])), -20.0 * 10 / 303.15)


def opensees(text: str, way: np.ndarray, step: float) -> np.ndarray:
    """Forces (t,) of the parallel material by the equations that OpenSees documents."""
    made = {}
    for line in text.splitlines():
        if line.startswith("uniaxialMaterial"):
            _, kind, tag, *rest = line.split()
            made[int(tag)] = (kind, [float(number) for number in rest])
    speed = np.gradient(way, step)
    force = np.zeros(len(way))
    for tag in made[100][1]:
        kind, numbers = made[int(tag)]
        if kind == "Elastic":
            force += numbers[0] * way
        elif kind == "Viscous":
            force += numbers[0] * speed
        else:
            force += {"ElasticPP": elastic_plastic, "BoucWen": bouc_wen}[kind](way, *numbers)
    return force


def elastic_plastic(way, stiffness, strain):
    force, told = 0.0, []
    for before, now in zip(np.append(0.0, way[:-1]), way, strict=True):
        force += stiffness * (now - before)
        force = min(max(force, -stiffness * strain), stiffness * strain)
        told.append(force)
    return np.array(told)


def bouc_wen(way, alpha, k, n, gamma, beta, a, *deltas):
    """Force alpha k x + (1 - alpha) k z, z' = A x' - beta |x'| |z|^(n-1) z - gamma x' |z|^n."""
    assert deltas == (0.0, 0.0, 0.0)
    z, told = 0.0, []
    for before, now in zip(np.append(0.0, way[:-1]), way, strict=True):
        moved = now - before
        z += a * moved - beta * abs(moved) * abs(z) ** (n - 1) * z - gamma * moved * abs(z) ** n
        told.append(alpha * k * now + (1.0 - alpha) * k * z)
    return np.array(told)


WEN = {
    "smooth-hysteresis.k": 2.0,
    "smooth-hysteresis.F": 3.0,
    "smooth-hysteresis.n": 2.0,
    "smooth-hysteresis.beta": 0.6,
}


@pytest.mark.parametrize(
    ("effect", "own", "within"),
    [("elasto-sliding", SLIDER, 2e-3), ("smooth-hysteresis", WEN, 4e-3)],
)
def test_a_slider_of_opensees_has_the_first_harmonic_of_the_model(effect, own, within):
    """Beside a spring and a dashpot, moved by a sine until it repeats itself."""
    expression, values = f"kelvin + {effect}", {"k": 4.0, "c": 0.6} | own
    text = exported(
        expression, "opensees", band=BAND, values=given(values), unit="kN/mm", dashpot=True
    ).text
    model, steps = parse_model(expression), 2000
    turn = np.exp(2j * np.pi * np.arange(3 * steps) / steps)
    for amplitude in (1.0, 4.0):
        force = opensees(text, amplitude * turn.imag, 1.0 / steps)
        seen = np.mean(force[steps:-steps] / turn[steps:-steps]) * 2j / amplitude
        [exact] = at(model, values, np.array([2 * np.pi]), amplitude)
        assert seen == pytest.approx(exact, rel=within)


def test_a_slider_alone_and_the_length_of_its_unit():
    """A force is the stiffness times the length in its unit: of kN/m it is in kN."""
    values = given({"elasto-sliding.k": 2000.0, "elasto-sliding.F": 3.0})
    text = exported("elasto-sliding", "opensees", band=BAND, values=values, unit="kN/m").text
    assert "uniaxialMaterial ElasticPP 2 2000 0.0015\n" in text


def test_dry_friction_without_a_stiffness_has_no_material():
    with pytest.raises(ModelError, match="opensees has no 'friction' beside a series"):
        exported("friction", "opensees", band=BAND, values=["friction.F=3"], unit="kN/m")
