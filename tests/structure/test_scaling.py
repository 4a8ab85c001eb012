"""A small pad's fit in a full-size damper, and bounds by property modification factors."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.errors import SpringpotError
from springpot.structure import motion_of, steady_of
from springpot.structure.motion import GroundMotion
from springpot.structure.reading import read_structure

pytestmark = pytest.mark.usefixtures("asked_once")

HEAD = """[structure]
mass = 1e4
stiffness = 4e6
damping = 0.02

[[damper]]
storey = 1
"""
SMALL, LARGE = "shear-pads area=20cm^2 gap=5mm", "shear-pads area=400cm^2 gap=20mm pads=2"
G = {"k": 300.0, "c": 40.0, "alpha": 0.5}
"""Of the material, in kPa; K = n A G / h."""
SHAPE_SMALL, SHAPE_LARGE = 20e-4 / 5e-3, 2 * 400e-4 / 20e-3
RECORD = GroundMotion(0.01, np.sin(0.2 * np.arange(80)), "sine")


def damper(unit: str, factor: float, *more: str, effect: str = "", own: str = "") -> str:
    values = ", ".join(
        f"{name} = {v * (1 if name == 'alpha' else factor)}" for name, v in G.items()
    )
    lines = [
        f'model = "fractional-maxwell{effect}"',
        f"parameters = {{ {values}{own} }}",
        f'unit = "{unit}"',
        *more,
    ]
    return HEAD + "\n".join(lines) + "\n"


def stiffness_of(path) -> complex:
    (one,) = read_structure(path).dampers
    return one.stiffness(np.array([2j * np.pi * 3.0]))[0][0]


def test_a_modulus_a_small_pads_stiffness_and_that_of_the_damper_are_one(write):
    """K = n A G / h, whichever of them was fitted."""
    large = f'geometry = "{LARGE}"'
    texts = [
        damper("kN/m", SHAPE_LARGE),
        damper("kPa", 1.0, large),
        damper("MPa", 1e-3, large),
        damper("kN/m", SHAPE_SMALL, large, f'specimen = "{SMALL}"'),
        damper("N/mm", SHAPE_SMALL, large, f'specimen = "{SMALL}"'),
    ]
    found = [stiffness_of(write(text, f"{i}.toml")) for i, text in enumerate(texts)]
    assert found == pytest.approx([found[0]] * len(found), rel=1e-12)


def test_what_depends_on_the_amplitude_is_scaled_at_the_same_strain(write):
    """Friction of 5 kPa is a force that grows with the area, a stroke one with the gap."""
    area_small, area_large = 20e-4, 2 * 400e-4
    large, small = f'geometry = "{LARGE}"', f'specimen = "{SMALL}"'
    own = ', "friction.F" = {}'
    stress = damper("kPa", 1.0, large, effect=" + friction", own=own.format(5.0))
    pad = damper(
        "kN/m", SHAPE_SMALL, large, small, effect=" + friction", own=own.format(5.0 * area_small)
    )
    whole = damper("kN/m", SHAPE_LARGE, effect=" + friction", own=own.format(5.0 * area_large))
    forces = [
        motion_of(read_structure(write(text, "f.toml")), RECORD).force
        for text in (stress, pad, whole)
    ]
    assert np.abs(forces[2]).max() > 5e3 * area_large
    for force in forces[:2]:
        np.testing.assert_allclose(force, forces[2], rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (damper("kPa", 1.0), "is in kPa: give its geometry = 'shear-pads"),
        (damper("kN/m", 1.0, f'geometry = "{LARGE}"'), "give its own geometry too, specimen ="),
        (damper("kN/m", 1.0, f'specimen = "{SMALL}"'), "give both"),
        (damper("kPa", 1.0, 'geometry = "shear-pads area=2cm^2"'), "gap missing"),
        (damper("kPa", 1.0, 'geometry = "cone-plate radius=2cm angle=2deg"'), "N m/rad|torque|N/m"),
        (damper("kN/m", 1.0, "factors = 0.8"), r"the least and the largest, \[0.8, 1.2\]"),
        (damper("kN/m", 1.0, "factors = [1.2, 0.8]"), r"the largest, \[0.8, 1.2\]"),
        (damper("kN/m", 1.0, "factors = [-1, 1]"), "damper 1: factors: -1"),
    ],
)
def test_what_does_not_fit_is_one_line_that_names_the_damper(write, text, says):
    path = write(text, "frame.toml")
    with pytest.raises(SpringpotError, match=says) as told:
        read_structure(path)
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)


def test_bounds_are_the_structure_with_its_dampers_softer_and_stiffer(springpot, write):
    record = write(
        "time [s],acceleration [m/s^2]\n"
        + "".join(f"{t:.2f},{a}\n" for t, a in zip(RECORD.time, RECORD.acceleration, strict=True)),
        "record.csv",
    )
    path = write(damper("kN/m", SHAPE_LARGE, "factors = [0.8, 1.3]"), "frame.toml")
    answer = springpot("simulate", path, "--record", record, "--json").json
    for name, factor in (("lower", 0.8), ("upper", 1.3)):
        alone = write(damper("kN/m", factor * SHAPE_LARGE), f"{name}.toml")
        alone = springpot("simulate", alone, "--record", record, "--json").json
        for part in ("storeys", "dampers", "modes"):
            for bound, other in zip(answer["bounds"][name][part], alone[part], strict=True):
                numbers = {key: value for key, value in other.items() if isinstance(value, float)}
                assert {key: bound[key] for key in numbers} == pytest.approx(numbers, rel=1e-9)
    drifts = [each["storeys"][0]["drift"] for each in (answer["bounds"]["upper"], answer)]
    assert drifts[0] < drifts[1] < answer["bounds"]["lower"]["storeys"][0]["drift"]
    told = springpot("simulate", path, "--record", record).out
    assert "ASCE 7 and 41; unchecked" in told
    many = springpot("simulate", path, "--record", record, "--record", record, "--json").json
    assert many["bounds"]["lower"]["storeys"][0]["drift"]["mean"] == pytest.approx(
        answer["bounds"]["lower"]["storeys"][0]["drift"]
    )
    assert (
        springpot("simulate", path, "--record", record, "--record", record).out.count("unchecked")
        == 2
    )
    steady = springpot("simulate", path, "--frequency", "2,3", "--json").json
    frame = read_structure(path).bounds["upper"]
    assert [point["drift"] for point in steady["bounds"]["upper"]] == pytest.approx(
        np.abs(steady_of(frame, 2 * np.pi * np.array([2.0, 3.0])).drift)
    )
    assert springpot("simulate", path, "--frequency", "2,3").out.count("unchecked") == 2
