"""Names without units: an answer in the file's units, with that word and a hint, no refusal."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.measurement import FILE_UNITS, Measurement, TimeTest, Units
from springpot_plugins.readers.springpot_csv import write_csv

OMEGA = np.geomspace(0.1, 100.0, 8)
K = 50.0 + 20.0 * (1j * OMEGA) ** 0.5
TIMES = np.geomspace(0.1, 100.0, 30)


def table(tmp_path, head, *columns):
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path = tmp_path / "mine.csv"
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(
    ("head", "modulus", "letter"),
    [
        ("omega [rad/s],G',G''", True, "G"),
        ("omega,storage,loss", True, ""),
        ("omega [rad/s],K',K''", False, "K"),
        ("omega [rad/s],storage stiffness,loss stiffness", False, "K"),
    ],
)
def test_moduli_or_stiffnesses_by_their_names(tmp_path, head, modulus, letter):
    data = springpot.read(table(tmp_path, head, OMEGA, K.real, K.imag))
    assert isinstance(data, Measurement)
    assert data.units.stiffness == FILE_UNITS
    assert (data.units.is_modulus, data.units.letter) == (modulus, letter)
    np.testing.assert_allclose(data.stiffness, K, rtol=1e-7)
    usual = "Pa" if modulus else "N/mm"
    note = data.provenance["note units"]
    assert "in the file's units" in note
    assert f"mine.csv?storage={usual},loss={usual}'" in note


def test_results_are_told_in_them_and_a_mass_is_in_none_that_nobody_knows(tmp_path):
    data = table(tmp_path, "omega,storage,loss", OMEGA, (K - 1e-3 * OMEGA**2).real, K.imag)
    fit = springpot.identify(data, "fractional-kelvin + inertia")
    units = {name: value.unit for name, value in fit.parameters.items()}
    assert units["k"] == FILE_UNITS
    assert units["c"] == f"{FILE_UNITS} s^alpha"
    assert units["inertia.m"] == f"{FILE_UNITS} s^2"
    assert fit.parameters["inertia.m"].value == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize(
    ("head", "value", "kind"),
    [
        ("time [s],relaxation modulus G(t)", 100.0 / TIMES**0.1, "relaxation"),
        ("time [s],creep compliance J(t)", TIMES**0.1, "creep"),
    ],
)
def test_steps(tmp_path, head, value, kind):
    test = springpot.read(table(tmp_path, head, TIMES, value))
    assert isinstance(test, TimeTest)
    assert (test.kind, test.units.stiffness) == (kind, FILE_UNITS)
    np.testing.assert_allclose(test.response, value, rtol=1e-7)
    assert "the file's units" in test.provenance["note units"]


def test_a_record_of_strain_and_stress_is_a_modulus(tmp_path):
    clock = np.arange(200) / 100.0
    moved = np.sin(2 * np.pi * clock)
    test = springpot.read(table(tmp_path, "time [s],strain,stress", clock, moved, 3 * moved))
    assert (test.units.stiffness, test.units.is_modulus) == (FILE_UNITS, True)


def test_a_record_of_displacement_and_force_is_a_stiffness(tmp_path):
    clock = np.arange(200) / 100.0
    moved = np.sin(2 * np.pi * clock)
    test = springpot.read(table(tmp_path, "time [s],displacement,force", clock, moved, 3 * moved))
    assert isinstance(test, TimeTest)
    assert (test.units.stiffness, test.units.is_modulus) == (FILE_UNITS, False)
    fit = springpot.identify(test, "kelvin")
    assert fit.parameters["k"].value == pytest.approx(3.0, rel=1e-3)


def test_what_must_be_known_is_asked_for_with_all_that_lacks(tmp_path):
    warm = np.full(len(OMEGA), 300.0)
    path = table(tmp_path, "frequency,T,storage,loss", OMEGA, warm, K.real, K.imag)
    asked = "frequency=Hz,temperature=degC,storage=Pa,loss=Pa"
    with pytest.raises(DataError, match=asked):
        springpot.read(path)


def test_a_temperature_colder_in_kelvin_than_any_chamber_is_in_degrees(tmp_path):
    warm = np.repeat([20.0, 120.0], len(OMEGA))
    omega, k = np.tile(OMEGA, 2), np.tile(K, 2)
    sweep = table(tmp_path, "frequency [Hz],T,storage [Pa],loss [Pa]", omega, warm, k.real, k.imag)
    found = springpot.read(sweep)
    np.testing.assert_array_equal(found.conditions["temperature"], warm)
    assert found.provenance["note celsius"].endswith(f"say '{sweep}?temperature=degF'")
    cold = np.full(len(TIMES), 20.0)
    step = springpot.read(table(tmp_path, "t [s],temperature,G [Pa]", TIMES, cold, 1.0 / TIMES))
    assert step.temperature == 20.0
    assert "degC is taken" in step.provenance["note celsius"]
    hot = springpot.read(
        table(tmp_path, "t [s],temperature,G [Pa]", TIMES, cold + 280, 1.0 / TIMES)
    )
    assert hot.temperature is None


def test_a_temperature_in_words_is_in_no_unit(tmp_path):
    path = tmp_path / "warm.csv"
    rows = "".join(f"{t},RT,{1.0 / t}\n" for t in TIMES)
    path.write_text(f"time [s],T,G(t) [Pa]\n{rows}")
    assert springpot.read(path).temperature is None


@pytest.mark.parametrize("head", ["time,relaxation", "time,relaxation modulus [Pa]"])
def test_a_time_without_a_unit_is_in_seconds(tmp_path, head):
    """It was refused; a note says what was taken and how another unit is said."""
    path = table(tmp_path, head, TIMES, 1.0 / TIMES)
    test = springpot.read(path)
    np.testing.assert_allclose(test.time, TIMES, rtol=1e-7)
    assert test.provenance["note clock"].endswith(f"say '{path}?time=min'")
    np.testing.assert_allclose(springpot.read(f"{path}?time=min").time, 60.0 * TIMES, rtol=1e-7)


def test_nothing_is_converted_to_them_or_from_them(tmp_path):
    bare = springpot.read(table(tmp_path, "omega,storage,loss", OMEGA, K.real, K.imag))
    relaxation = TimeTest.of_relaxation(TIMES, 90.0 / TIMES**0.1, "kPa", name="step")
    with pytest.raises(DataError, match=r"file units and .* kPa: say its unit"):
        springpot.identify([bare, relaxation], "kelvin")
    assert Units(FILE_UNITS).factor_to(Units(FILE_UNITS), "one", "other") == 1.0
    assert Units("kN/m").factor_to(Units("N/mm"), "one", "other") == 1.0
    assert Units("MPa").factor_to(Units("kPa"), "one", "other") == pytest.approx(1e3)
    with pytest.raises(DataError, match="a stiffness is no modulus"):
        Units("kN/m").factor_to(Units("kPa"), "one", "other")


def test_they_are_kept_in_a_table_and_in_json(tmp_path):
    bare = springpot.read(table(tmp_path, "omega,storage,loss", OMEGA, K.real, K.imag))
    write_csv(bare, tmp_path / "again.csv")
    again = springpot.read(tmp_path / "again.csv")
    assert again.units == bare.units
    np.testing.assert_allclose(again.stiffness, bare.stiffness)
    fit = springpot.identify(bare, "fractional-kelvin")
    (tmp_path / "fit.json").write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    assert springpot.load(tmp_path / "fit.json").parameters["k"].unit == FILE_UNITS


@pytest.mark.parametrize("head", ["time [s],strain,stress [kPa]", "t_s,gamma,tau_kPa"])
def test_a_strain_beside_a_stress_has_no_unit(tmp_path, head):
    """It was refused, and millimetres were proposed."""
    clock = np.arange(200) / 100.0
    moved = 0.01 * np.sin(2 * np.pi * clock)
    path = table(tmp_path, head, clock, moved, 3 * moved)
    test = springpot.read(path)
    assert (test.units.stiffness, test.units.is_modulus) == ("kPa", True)
    assert "displacement=%'" in test.provenance["note units"]
    assert springpot.identify(test, "kelvin").parameters["k"].value == pytest.approx(3.0, rel=1e-3)
    in_percent = f"{path}?displacement=%"
    fit = springpot.identify(in_percent, "kelvin")
    assert fit.parameters["k"].value == pytest.approx(300.0, rel=1e-3)


def test_a_force_in_a_unit_is_told_in_those_of_the_file_beside_a_displacement_of_none(tmp_path):
    clock = np.arange(200) / 100.0
    moved = np.sin(2 * np.pi * clock)
    test = springpot.read(table(tmp_path, "time_s,displacement,force_N", clock, moved, 3 * moved))
    assert (test.units.stiffness, test.units.is_modulus) == (FILE_UNITS, False)
    assert "displacement=mm'" in test.provenance["note units"]


@pytest.mark.parametrize("unit", ["counts/V", "V/V", "-"])
def test_channels_that_nobody_calibrated_are_offered_the_units_of_the_file(tmp_path, unit):
    head = f"frequency [Hz],magnitude [{unit}],phase [rad]"
    path = table(tmp_path, head, OMEGA / (2.0 * np.pi), np.abs(K), np.angle(K))
    with pytest.raises(DataError) as told:
        springpot.read(path)
    way = str(told.value).rpartition("open '")[2].rstrip("'")
    assert way.endswith("mine.csv?magnitude=file units")
    data = springpot.read(way)
    assert data.units.stiffness == FILE_UNITS
    np.testing.assert_allclose(data.stiffness, K, rtol=1e-7)


def test_of_volts_a_newton_is_offered_to_the_force_alone(tmp_path):
    head = "f [Hz],force amplitude [V],displacement amplitude [V],phase [rad]"
    one = np.ones(len(OMEGA))
    path = table(tmp_path, head, OMEGA, np.abs(K), one, np.angle(K))
    with pytest.raises(DataError, match=r"if it is N, open '.*[?]force_amplitude=N'$") as told:
        springpot.read(path)
    way = str(told.value).rpartition("open '")[2].rstrip("'")
    with pytest.raises(DataError, match=r"if it is mm, open '") as told:
        springpot.read(way)
    data = springpot.read(str(told.value).rpartition("open '")[2].rstrip("'"))
    assert (data.units.stiffness, data.units.amplitude) == ("N/mm", "mm")


def test_a_torque_over_an_angle_is_a_stiffness(tmp_path):
    head = "f [Hz],torque amplitude [mN m],angle amplitude [mrad],phase [rad]"
    moved = np.full(len(OMEGA), 3.0)
    path = table(tmp_path, head, OMEGA / (2.0 * np.pi), 3.0 * np.abs(K), moved, np.angle(K))
    data = springpot.read(path)
    assert data.units.stiffness == "mN m/mrad"
    np.testing.assert_allclose(data.stiffness, K, rtol=1e-6)
    assert data.units.amplitude == "mrad"
    np.testing.assert_allclose(data.conditions["amplitude"], 3.0)
