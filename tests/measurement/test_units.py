import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import (
    ANGLE_UNITS,
    FREQUENCY_UNITS,
    MODULUS_UNITS,
    Units,
    known_unit,
    near_units,
    normal_unit,
    temperature_in_celsius,
    units,
)
from springpot.rheology import FORCE, Dimension


@pytest.mark.parametrize(
    ("written", "unit", "si"),
    [
        ("kN/m", "kN/m", 1e3),
        ("N/μm", "N/um", 1e6),
        ("kgf/mm", "kgf/mm", 9806.65),
        ("lbf/in", "lbf/in", 175.12683524647636),
        ("N·m/rad", "N m/rad", 1.0),
        ("Nm/rad", "N m/rad", 1.0),
        ("N m^-1", "N/m", 1.0),
        ("N/mm²", "N/mm^2", 1e6),
        ("Mpa", None, None),
        ("MPa", "MPa", 1e6),
        ("mPa", "mPa", 1e-3),
        ("kpa", "kPa", 1e3),
    ],
)
def test_spellings_and_factors(written, unit, si):
    if unit is None:
        with pytest.raises(DataError, match=r"\[MPa\] or \[mPa\]"):
            known_unit(written, MODULUS_UNITS, "storage")
        return
    assert known_unit(written, MODULUS_UNITS, "storage") == unit
    assert MODULUS_UNITS[unit] == pytest.approx(si, rel=1e-12)


def test_an_unknown_unit_names_the_nearest():
    with pytest.raises(DataError, match=r"did you mean \[Hz\]"):
        known_unit("Hzz", FREQUENCY_UNITS, "frequency")


def test_cycles_per_second_and_radians_per_second_are_never_mixed():
    with pytest.raises(DataError):
        known_unit("1/s", FREQUENCY_UNITS, "frequency")


@pytest.mark.parametrize(
    ("value", "unit", "celsius"), [(293.15, "K", 20.0), (68.0, "degF", 20.0), (20.0, "degC", 20.0)]
)
def test_temperatures(value, unit, celsius):
    assert temperature_in_celsius(value, unit) == pytest.approx(celsius)


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("µN.m", "uN m"),
        ("[°C]", "degC"),
        ("rad·s-1", "rad/s"),
        ("mPa.s", "mPa s"),
        ("Pas", "Pa s"),
        ("1/Pa", "1/Pa"),
        ("rad/(N.m)", "rad/N m"),
        ("dyn/cm2", "dyn/cm^2"),
        ("kN*s/m", "kN s/m"),
        ("Nm/rad", "N m/rad"),
        ("", "-"),
    ],
)
def test_one_spelling_of_a_unit(written, unit):
    assert normal_unit(written) == unit
    assert normal_unit(unit) == unit


@pytest.mark.parametrize(
    ("units", "powers", "label"),
    [
        (Units("N/mm", "mm"), {"stiffness": 1, "amplitude": 1, "time": -1}, "N/s"),
        (Units("kN/m", "mm"), {"stiffness": 1, "amplitude": 1, "time": -1}, "N/s"),
        (Units("kPa", "%"), {"stiffness": 1, "amplitude": 1, "time": -1}, "kPa/s"),
        (Units("N/mm", "mm"), {"amplitude": 1, "time": -1}, "mm/s"),
        (Units("kPa", "-"), {"amplitude": 1, "time": -1}, "1/s"),
        (Units("N/mm", "mm"), {"stiffness": 1, "amplitude": -1}, "N/mm^2"),
        (Units("N/mm", "mm"), {"stiffness": 1, "time": 3, "amplitude": -2}, "N s^3/mm^3"),
        (Units("N m/rad", "deg"), {"stiffness": 1, "amplitude": 1}, "N m"),
    ],
)
def test_rates_and_powers_of_lengths_are_written_as_a_person_would(units, powers, label):
    assert units.of(Dimension(**powers))[1] == label


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("10^6 Pa", "MPa"),
        ("1e3 N", "kN"),
        ("Pa x10^6", "MPa"),
        ("10^7 Pa", "10^7 Pa"),
        ("Па", "Pa"),
        ("(1)/(s)", "1/s"),
        ("rad s^-1", "rad/s"),
        ("N/mm2", "N/mm^2"),
    ],
)
def test_powers_of_ten_alphabets_and_brackets_are_units_too(written, unit):
    assert normal_unit(written) == unit


def test_units_that_springpot_does_not_know_stand_behind_with_their_power():
    squared, by_n, once = (("", 2.0),), (("flow.n", 1.0),), (("", 1.0),)
    for known, beyond, label in (
        (Units("N/mm", "mm"), (("K", squared),), "N/mm K^2.0"),
        (Units("N/mm", "mm"), (("amplitude", by_n),), "N/mm mm^n"),
        (Units("kPa", "-"), (("amplitude", by_n), ("time", by_n)), "kPa s^n"),
        (Units("N/mm", "mm"), (("stiffness", once), ("K", once)), "N/mm (N/mm) K"),
    ):
        assert known.of(Dimension(stiffness=1, beyond=beyond)) == (1.0, label)
    assert Units("kPa", "-").of(Dimension(beyond=(("amplitude", by_n),)))[1] == "-"
    assert Units("kPa", "-").of(Dimension(beyond=(("time", by_n),)))[1] == "s^n"


def test_a_torque_against_degrees_keeps_its_size():
    factor, _ = Units("N m/rad", "deg").of(Dimension(stiffness=1, amplitude=1))
    assert factor == pytest.approx(np.pi / 180.0)


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        *((each, "deg") for each in ("Grad", "grad", "grd", "°", "deg.", "Altgrad")),
        ("gon", "gon"),
        ("Neugrad", "gon"),
    ],
)
def test_a_german_degree_is_no_gon(written, unit):
    assert known_unit(written, ANGLE_UNITS, "phase") == unit
    assert {"deg": 360, "gon": 400}[unit] * ANGLE_UNITS[unit] == pytest.approx(2 * np.pi, rel=1e-15)


def test_units_that_differ_in_case_alone_go_before_those_that_look_alike():
    assert near_units("mpa", MODULUS_UNITS) == ["MPa", "mPa"]
    assert near_units("kilopascals", MODULUS_UNITS) == []
    assert "Hz" in near_units("Hzz", FREQUENCY_UNITS)


@pytest.mark.parametrize(
    ("power", "words"),
    [((("", 2.0),), 2.0), ((("first.n", 1.0),), "n"), ((("", 1.0), ("n", -1.0)), "(1-n)")],
)
def test_a_power_is_told_as_a_person_writes_it(power, words):
    assert units._exponent(power) == words


@pytest.mark.parametrize("text", ["mm/mm", "m/m", "in/in", "[mm/mm]"])
def test_a_length_over_the_same_length_is_a_share(text):
    assert normal_unit(text) == "-"


@pytest.mark.parametrize(
    ("stiffness", "amplitude", "expected"),
    [
        ("uN/um", "um", (1.0, "uN")),
        ("kN/mm", "mm", (1.0, "kN")),
        ("kN/m", "mm", (1.0, "N")),
        ("N/mm", "mm", (1.0, "N")),
    ],
)
def test_a_force_is_told_in_the_unit_that_the_file_has_it_in(stiffness, amplitude, expected):
    """Of an indenter in uN, not in millionths of a newton."""
    assert Units(stiffness, amplitude).of(FORCE) == expected
