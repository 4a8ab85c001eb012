"""Interface objects against the mechanics that they stand for."""

from math import log, pi

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import quad

import springpot
from springpot.errors import DataError, OptionError
from springpot.measurement import Measurement, Units, parse_geometry, through
from springpot.measurement.geometry import (
    GEOMETRIES,
    AnnularDashpot,
    BondedBlock,
    ConePlate,
    Constants,
    ParallelPlates,
    ShearPads,
    TorsionBar,
    words_of,
)

EXAMPLES = (
    ShearPads(0.02, 0.01, 2),
    BondedBlock(0.02, 0.5, 0.01),
    AnnularDashpot(0.02, 0.025, 0.1),
    AnnularDashpot(0.02, 0.0201, 0.1, closed=True),
    ParallelPlates(0.02, 0.001),
    ConePlate(0.03, 0.035),
    TorsionBar(0.04, 0.012, 0.002),
    Constants(79577.5, 20.0),
)


def test_there_is_an_example_of_every_geometry():
    assert {type(example) for example in EXAMPLES} == set(GEOMETRIES.values())


def test_shear_pads_are_area_over_thickness():
    pads = ShearPads(area=0.02, gap=0.01, pads=2)
    assert pads.shape == pytest.approx(2 * 0.02 / 0.01)
    assert 400.0 * pads.stress_factor == pytest.approx(10_000.0)
    assert 0.005 * pads.strain_factor == pytest.approx(0.5)


def test_a_bonded_block_is_a_column_where_it_is_slender_and_a_squeezed_film_where_it_is_thin():
    """Of a disc, the film is Stefan's: 3 pi R^4 / (2 h^3) times the shear modulus, E / 3."""
    radius = 0.05
    area, edge = pi * radius**2, 2.0 * pi * radius
    slender, thin = BondedBlock(area, edge, 5.0), BondedBlock(area, edge, 1e-5)
    assert slender.shape == pytest.approx(area / 5.0, rel=1e-4)
    assert thin.shape == pytest.approx(pi * radius**4 / (2.0 * 1e-5**3), rel=1e-6)


def test_a_bonded_block_gives_youngs_modulus():
    pressed = Measurement([1.0], [1e6 + 1e5j], units=Units("N/m", "mm"))
    found = pressed.as_modulus(parse_geometry("bonded-block area=100cm^2 perimeter=40cm gap=2cm"))
    # S = 0.01 / (0.4 0.02) = 1.25, so that K = E 4.125 0.01 / 0.02
    assert found.stiffness[0] == pytest.approx((1e6 + 1e5j) / 2.0625)
    assert found.units.letter == "E"


FORCED = [one for one in EXAMPLES if not isinstance(one, Constants | BondedBlock)]
"""Of which stress and strain are those within the material."""


@pytest.mark.parametrize("geometry", FORCED, ids=lambda geometry: geometry.name)
def test_work_of_the_force_is_work_in_the_material_or_less(geometry):
    """Peak stress times strain over the whole volume is at least force times displacement."""
    volume = {
        "shear-pads": lambda g: g.pads * g.area * g.gap,
        "annular-dashpot": lambda g: pi * (g.outer_radius**2 - g.inner_radius**2) * g.length,
        "parallel-plates": lambda g: pi * g.radius**2 * g.gap,
        "cone-plate": lambda g: 2 / 3 * pi * g.radius**3 * g.angle,
        "torsion-bar": lambda g: g.length * g.width * g.thickness,
    }[geometry.name]
    share = 1.0 / (geometry.stress_factor * geometry.strain_factor * volume(geometry))
    uniform = geometry.name in ("shear-pads", "cone-plate")
    assert share == pytest.approx(1.0, rel=1e-12) if uniform else 0.0 < share < 1.0


def test_parallel_plates_have_their_strain_at_the_rim_and_their_stiffness_by_integration():
    plates = ParallelPlates(radius=0.02, gap=0.001)
    assert plates.strain_factor == pytest.approx(20.0)
    torque, _ = quad(lambda r: 2 * pi * r * r * (r / plates.gap), 0, plates.radius)
    assert plates.shape == pytest.approx(torque, rel=1e-10)
    # What a rheometer's file says of its 40 mm plates with 1 mm gap.
    assert plates.stress_factor == pytest.approx(79577.5, rel=1e-6)


def test_a_thin_annulus_is_a_shear_pad():
    radius, gap, length = 0.05, 1e-6, 0.1
    annulus = AnnularDashpot(radius, radius + gap, length)
    pad = ShearPads(2 * pi * radius * length, gap)
    assert annulus.shape == pytest.approx(pad.shape, rel=2e-5)
    assert annulus.strain_factor == pytest.approx(pad.strain_factor, rel=2e-5)
    assert annulus.stress_factor == pytest.approx(pad.stress_factor, rel=1e-12)


def test_an_open_annulus_by_integration():
    annulus = AnnularDashpot(0.02, 0.03, 0.1)
    displacement, _ = quad(lambda r: 1.0 / (2 * pi * r * annulus.length), 0.02, 0.03)
    assert annulus.shape == pytest.approx(1.0 / displacement, rel=1e-10)


@pytest.mark.parametrize("outer", [0.0201, 0.022, 0.03, 0.08])
def test_a_closed_annulus_solves_the_flow_between_piston_and_tube(outer):
    """Unit velocity on the piston, none on the tube and the displaced flux, as linear equations."""
    inner, length = 0.02, 0.1
    geometry = AnnularDashpot(inner, outer, length, closed=True)
    # v(r) = p (r^2 - R_o^2) / 4 + c ln(r / R_o) for unit viscosity; unknown are p, the pressure
    # gradient, and c.
    flux = [quad(lambda r, k=k: 2 * pi * r * _flow(k, r, outer), inner, outer)[0] for k in (0, 1)]
    rows = [[_flow(0, inner, outer), _flow(1, inner, outer)], flux]
    p, c = np.linalg.solve(rows, [1.0, -pi * inner**2])
    shear = p * inner / 2 + c / inner
    force = -2 * pi * inner * length * shear + pi * inner**2 * length * p
    assert geometry.shape == pytest.approx(force, rel=1e-6)
    assert geometry.strain_factor == pytest.approx(-shear, rel=1e-6)


def _flow(which, r, outer):
    return (r * r - outer * outer) / 4 if which == 0 else log(r / outer)


def test_a_narrow_closed_annulus_is_a_slot_with_pressure():
    radius, gap = 0.05, 1e-4
    closed = AnnularDashpot(radius, radius + gap, 0.1, closed=True)
    assert closed.shape == pytest.approx(6 * pi * 0.1 * (radius / gap) ** 3, rel=1e-2)
    # The series for narrow gaps continues the formula.
    just = [
        AnnularDashpot(1.0, np.exp(a), 0.1, closed=True).shape * a**3 for a in (0.01999, 0.02001)
    ]
    assert just[0] == pytest.approx(just[1], rel=1e-5)


@pytest.mark.parametrize(
    ("ratio", "constant", "modulus"),
    [
        (1.0, 0.1406, 0.208),
        (1.5, 0.196, 0.231),
        (2.0, 0.229, 0.246),
        (4.0, 0.281, 0.282),
        (10.0, 0.312, 0.312),
    ],
)
def test_a_torsion_bar_agrees_with_the_table_of_timoshenko_and_goodier(ratio, constant, modulus):
    bar = TorsionBar(length=0.5, width=0.002, thickness=ratio * 0.002)
    assert bar.shape == pytest.approx(constant * ratio * 0.002**4 / 0.5, rel=3e-3)
    assert 1 / bar.stress_factor == pytest.approx(modulus * ratio * 0.002**3, rel=3e-3)


def test_a_cone_is_a_plate_of_even_strain():
    cone = ConePlate(radius=0.03, angle=0.04)
    torque, _ = quad(lambda r: 2 * pi * r * r / cone.angle, 0, cone.radius)
    assert cone.shape == pytest.approx(torque, rel=1e-10)


OMEGA = np.geomspace(1.0, 100.0, 7)
SIZES = st.floats(1e-4, 10.0)


def damper(unit="kN/m", amplitude="mm", scale=1.0):
    stiffness = scale * (400.0 + 30j) * (1j * OMEGA) ** 0.6
    conditions = {
        "amplitude": np.linspace(0.1, 2.0, len(OMEGA)),
        "temperature": np.full(len(OMEGA), 20.0),
    }
    return Measurement(
        OMEGA,
        stiffness,
        sd=0.01 * np.abs(stiffness) * (1 + 1j),
        conditions=conditions,
        units=Units(unit, amplitude),
        name="damper",
    )


def ulps(a, b):
    return float(np.max(np.abs(a - b) / np.spacing(np.abs(b))))


@given(st.sampled_from(EXAMPLES), SIZES, st.sampled_from(["Pa", "MPa", "psi"]))
def test_there_and_back_is_the_same_within_a_rounding(geometry, scale, modulus):
    unit, amplitude = ("N m/rad", "mrad") if geometry.turns else ("kN/m", "mm")
    before = damper(unit, amplitude, scale)
    between = before.as_modulus(geometry, modulus)
    after = between.as_stiffness(geometry, unit, amplitude)
    assert between.units == Units(modulus, "-")
    assert after.units == before.units
    for part in (
        lambda m: m.storage,
        lambda m: m.loss,
        lambda m: m.sd.real,
        lambda m: m.conditions["amplitude"],
    ):
        assert ulps(part(after), part(before)) <= 1.0


def test_units_and_the_amplitude_are_converted():
    measured = damper()
    found = measured.as_modulus(ShearPads(area=0.02, gap=0.01), "kPa")
    np.testing.assert_allclose(found.stiffness, measured.stiffness * 0.01 / 0.02, rtol=1e-14)
    np.testing.assert_allclose(
        found.conditions["amplitude"], measured.conditions["amplitude"] * 1e-3 / 0.01
    )
    np.testing.assert_array_equal(
        found.conditions["temperature"], measured.conditions["temperature"]
    )
    back = found.as_stiffness(ShearPads(area=0.02, gap=0.01))
    assert back.units == Units("N/m", "m")
    assert through(back, ShearPads(0.02, 0.01)).units.is_modulus


def test_damper_and_material_are_one_model():
    pads = ShearPads(area=0.02, gap=0.01)
    model = springpot.parse_model("fractional-maxwell")
    exact = model.stiffness(model.theta(k=400.0, c=150.0, alpha=0.6), OMEGA)
    measured = Measurement(OMEGA, exact, units=Units("kN/m", "mm"), name="exact")
    device = springpot.identify(measured, model).to_dict()["parameters"]
    material = springpot.identify(measured.as_modulus(pads, "kPa"), model).to_dict()["parameters"]
    assert material["k"]["value"] == pytest.approx(device["k"]["value"] / pads.shape, rel=1e-6)
    assert material["c"]["value"] == pytest.approx(device["c"]["value"] / pads.shape, rel=1e-6)
    assert material["alpha"]["value"] == pytest.approx(0.6, rel=1e-6)
    assert (device["k"]["unit"], material["k"]["unit"]) == ("kN/m", "kPa")


@pytest.mark.parametrize(
    ("measured", "geometry", "message"),
    [
        (damper(), ParallelPlates(0.02, 0.001), "torque and angle.*kN/m.*N m/rad"),
        (damper("N m/rad", "rad"), ShearPads(0.02, 0.01), "force and displacement.*N m/rad"),
        (damper(amplitude="%"), ShearPads(0.02, 0.01), "amplitude in m, mm.*not in %"),
        (damper("Pa", "-"), ShearPads(0.02, 0.01), "storage and loss are in Pa"),
    ],
)
def test_what_does_not_fit_is_one_line(measured, geometry, message):
    with pytest.raises(DataError, match=message):
        measured.as_modulus(geometry)


def test_a_damper_is_no_modulus():
    with pytest.raises(DataError, match="kN/m, where Pa"):
        damper().as_stiffness(ShearPads(0.02, 0.01))
    with pytest.raises(DataError, match=r"strain as amplitude, not \[mm\]"):
        damper("Pa", "mm").as_stiffness(ShearPads(0.02, 0.01))


@pytest.mark.parametrize(
    ("text", "geometry"),
    [
        ("shear-pads area=200cm^2 gap=10mm", ShearPads(0.02, 0.01)),
        ("shear-pads area=200 cm², gap=10 mm, pads=2", ShearPads(0.02, 0.01, 2)),
        (
            "annular-dashpot inner-diameter=40mm outer_radius=0.025m length=10cm closed=yes",
            AnnularDashpot(0.02, 0.025, 0.1, True),
        ),
        ("parallel-plates: diameter=40mm gap=1000um", ParallelPlates(0.02, 0.001)),
        ("cone-plate radius=30mm angle=2deg", ConePlate(0.03, np.deg2rad(2))),
        ("torsion-bar length=40mm width=12mm thickness=2mm", TorsionBar(0.04, 0.012, 0.002)),
        ("constants stress=79577.5Pa/(N m) strain=20 1/rad", Constants(79577.5, 20.0)),
    ],
)
def test_geometries_as_text(text, geometry):
    found = parse_geometry(text)
    assert type(found) is type(geometry)
    assert found.stress_factor == pytest.approx(geometry.stress_factor, rel=1e-12)
    assert found.shape == pytest.approx(geometry.shape, rel=1e-12)


@pytest.mark.parametrize("geometry", EXAMPLES, ids=lambda geometry: geometry.name)
def test_what_is_said_of_a_geometry_is_read_again(geometry):
    assert parse_geometry(words_of(geometry)) == geometry


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("shear-pad area=1m^2 gap=1m", "did you mean shear-pads"),
        ("", "known are shear-pads"),
        ("shear-pads area=1m^2", "gap missing"),
        ("shear-pads area=1 gap=1mm", r"area=1 has no unit; write area=1mm\^2"),
        ("shear-pads area=1mm gap=1mm", "area"),
        ("shear-pads area=1m^2 gap=x", "gap is no number"),
        ("shear-pads area=1m^2 gap=1m colour=2", "no 'colour'"),
        ("shear-pads area=1m^2 gap=1m gap=2m", "twice"),
        ("shear-pads area=1m^2 gap=-1m", "gap must be positive"),
        ("shear-pads 1 area=1m^2 gap=1m", "cannot read '1'"),
        ("annular-dashpot inner-radius=2m outer-radius=1m length=1m", "smaller"),
        ("annular-dashpot inner-radius=1m outer-radius=2m length=1m closed=perhaps", "yes or no"),
    ],
)
def test_a_slip_in_a_geometry_is_one_line_that_helps(text, message):
    with pytest.raises(OptionError, match=message) as caught:
        parse_geometry(text)
    assert "\n" not in str(caught.value)


@given(
    st.text(max_size=60)
    | st.tuples(st.sampled_from(list(GEOMETRIES)), st.text(max_size=40)).map(" area=".join)
)
def test_any_text_is_a_geometry_or_one_line(text):
    said = ""
    try:
        assert parse_geometry(text).shape > 0
    except OptionError as error:
        said = str(error)
    assert "\n" not in said


def test_the_public_names():
    pads = springpot.geometry.ShearPads(area=0.02, gap=0.01)
    assert springpot.read("artificial-hidden").as_modulus(pads).units.is_modulus


def test_a_geometry_that_shears_gives_a_shear_modulus_and_takes_no_other():
    pads = parse_geometry("shear-pads area=200cm^2 gap=10mm")
    damper = Measurement([1.0], [100.0 + 50.0j], units=Units("kN/m", "mm"))
    assert damper.as_modulus(pads).units.modulus == "G"
    tension = Measurement([1.0], [1.0 + 0.5j], units=Units("MPa", letter="E"))
    with pytest.raises(DataError, match="is a Young's modulus and shear-pads a shear modulus"):
        tension.as_stiffness(pads)
