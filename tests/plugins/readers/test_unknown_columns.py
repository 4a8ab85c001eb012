"""Columns that are amplitude and temperature, those that are not, and questions about the rest."""

import re

import numpy as np
import pytest

import springpot
from springpot.errors import DataError

HERTZ = np.array([1.0, 2.0, 5.0, 10.0, 20.0, 50.0])
STORAGE, LOSS = 100 * HERTZ**0.2, 30 * HERTZ**0.2
K = STORAGE + 1j * LOSS
FIRST = "Frequency [Hz];Storage stiffness [N/mm];Loss stiffness [N/mm]"


def sweep(head, *columns):
    """A table with these further columns."""
    columns = [np.broadcast_to(column, HERTZ.shape) for column in (HERTZ, STORAGE, LOSS, *columns)]
    rows = [";".join(f"{value:.10g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([head, *rows, ""])


def notes_of(measured):
    return {key: value for key, value in measured.provenance.items() if key.startswith("note ")}


def commands_in(text):
    """What a hint says behind the name of the file."""
    return re.findall(r"'[^'?]*(\?[^']*)'", text)


@pytest.mark.parametrize(
    ("title", "amplitude"),
    [
        ("Ampl. (mm)", 2.0),
        ("Ampl [mm]", 2.0),
        ("strain amplitude [%]", 2.0),
        ("disp. amplitude [mm]", 2.0),
        ("Disp. Ampl. / mm", 2.0),
        ("Weg-Amplitude [mm]", 2.0),
        ("Peak amplitude [mm]", 2.0),
        ("Amplitude zero-to-peak [mm]", 2.0),
        ("Amplitude p-p [mm]", 1.0),
        ("Amplitude pk-pk [mm]", 1.0),
        ("Amplitude peak-to-peak [mm]", 1.0),
        ("Ampl. pp (mm)", 1.0),
        ("amplitude_pp [mm]", 1.0),
        ("Amplitude (mm) p-p", 1.0),
        ("Amplitude [mm p-p]", 1.0),
        ("p-p displacement [mm]", 1.0),
        ("Amplitude Spitze-Spitze [mm]", 1.0),
    ],
)
def test_what_people_call_the_amplitude_is_one_and_from_peak_to_peak_half_of_it(
    folder, title, amplitude
):
    found = folder.open(sweep(f"{FIRST};{title}", 2.0))
    np.testing.assert_array_equal(found.conditions["amplitude"], amplitude)
    assert list(found.conditions) == ["amplitude"]
    assert ("note amplitude" in found.provenance) == (amplitude == 1.0)


@pytest.mark.parametrize(
    "title",
    [
        *(
            "T sample [degC]",
            "T_sample [°C]",
            "Sample temperature [°C]",
            "Temp. sample [°C]",
            "Specimen temp. [°C]",
        ),
        *(
            "Probentemperatur [°C]",
            "T Probe [°C]",
            "T (°C)",
            "Temperature (sample) [°C]",
            "specimen temperature / °C",
        ),
        *("Température échantillon [°C]", "Temperatur [Grad C]"),
    ],
)
def test_what_people_call_the_temperature_is_one(folder, title):
    found = folder.open(sweep(f"{FIRST};{title}", 23.5))
    np.testing.assert_array_equal(found.conditions["temperature"], 23.5)
    assert list(found.conditions) == ["temperature"]


@pytest.mark.parametrize(
    "title", ["Ampl. [mm]", "Amplitude p-p [mm]", "T_sample [degC]", "T [degC]"]
)
def test_such_a_column_is_known_beside_springpots_own_names(folder, title):
    found = folder.open(sweep(f"frequency [Hz];storage [N/mm];loss [N/mm];{title}", 2.0))
    assert list(found.conditions) == ["amplitude" if title.startswith("Ampl") else "temperature"]


@pytest.mark.parametrize(
    "title",
    [
        *(
            "oven temperature [degC]",
            "Ofentemperatur [°C]",
            "temperature rise [K]",
            "set temperature [degC]",
        ),
        *(
            "t_sample [s]",
            "phase amplitude [deg]",
            "Amplitude rms [mm]",
            "gap [mm]",
            "peak strain [%]",
            "T set [°C]",
        ),
        *("stress peak-to-peak [Pa]", "strain PP-GF30 [N]"),
    ],
)
def test_what_is_something_else_stays_so(folder, title):
    found = folder.open(sweep(f"{FIRST};{title}", 2.0))
    assert not {"temperature", "amplitude"} & set(found.conditions)


@pytest.mark.parametrize(
    "other", ["set temperature", "oven temperature", "chamber temperature", "T set", "T (oven)"]
)
@pytest.mark.parametrize(
    "measured", ["temperature", "T", "sample temperature", "T_sample", "Temperature (sample)"]
)
@pytest.mark.parametrize("order", [1, -1])
def test_the_measured_temperature_wins_wherever_it_stands(folder, other, measured, order):
    titles, values = [f"{other} [°C]", f"{measured} [°C]"][::order], [50.0, 48.5][::order]
    found = folder.open(sweep(";".join([FIRST, *titles]), *values))
    np.testing.assert_array_equal(found.conditions["temperature"], 48.5)
    assert 50.0 in [values[0] for values in found.conditions.values()], (
        "the other one keeps a name of its own"
    )


def test_a_second_amplitude_in_another_unit_does_not_take_the_place_of_the_first(folder):
    found = folder.open(sweep(f"{FIRST};Amplitude [mm];Strain [%]", 0.5, 7.0))
    np.testing.assert_array_equal(found.conditions["amplitude"], 0.5)
    np.testing.assert_array_equal(found.conditions["strain"], 7.0)
    assert found.units.amplitude == "mm"


@pytest.mark.parametrize(
    ("title", "role", "value", "unit"),
    [
        ("Foo [mm]", "amplitude", 2.0, "mm"),
        ("Foo, µm", "amplitude", 2.0, "um"),
        ("Foo [mm pk-pk]", "amplitude", 1.0, "mm"),
        ("Hub p-p [mm]", "amplitude", 1.0, "mm"),
        ("Foo=1 [mm]", "amplitude", 2.0, "mm"),
        ("Foo [%]", "amplitude", 2.0, "%"),
        ("Foo [°C]", "temperature", 2.0, ""),
        ("oven temperature [degC]", "temperature", 2.0, ""),
        ("Foo [K]", "temperature", -271.15, ""),
    ],
)
@pytest.mark.parametrize("first", [FIRST, "frequency [Hz];storage [N/mm];loss [N/mm]"])
def test_a_column_that_nobody_knows_is_offered_and_the_offer_works(
    folder, first, title, role, value, unit
):
    content = sweep(f"{first};{title}", 2.0)
    note = folder.open(content).provenance[f"note column of {role}"]
    assert f"if '{title}' is the {role}" in note
    (typed,) = commands_in(note)
    found = folder.open(content, typed)
    np.testing.assert_allclose(found.conditions[role], value)
    assert list(found.conditions) == [role]
    assert found.units.amplitude == (unit or "-")
    assert not [key for key in notes_of(found) if key.startswith("note column")]


def test_an_offer_says_again_what_was_said_before(folder):
    content = sweep("frequency;storage [N/mm];loss [N/mm];Foo [mm]", 2.0)
    (typed,) = commands_in(
        folder.open(content, "?frequency=Hz").provenance["note column of amplitude"]
    )
    found = folder.open(content, typed)
    np.testing.assert_allclose(found.frequency, HERTZ)
    np.testing.assert_array_equal(found.conditions["amplitude"], 2.0)


def test_who_ignores_a_column_is_not_asked_again_and_does_not_keep_it(folder):
    found = folder.open(sweep(f"{FIRST};Foo [mm]", 2.0), "?Foo=ignore")
    assert not found.conditions
    assert not notes_of(found)


@pytest.mark.parametrize(
    ("titles", "values"),
    [
        ("Amplitude [mm];Foo [mm]", (1.0, 2.0)),
        ("temperature [degC];T set [°C]", (20.0, 21.0)),
        ("gap [mm]", (2.0,)),
        ("specimen thickness [mm]", (2.0,)),
        ("humidity [%]", (50.0,)),
        ("temperature rise [K]", (2.0,)),
        ("static strain [%]", (2.0,)),
        ("Foo [mm]", (-2.0,)),
        ("Foo [°C]", (-300.0,)),
    ],
)
def test_nothing_is_asked_where_the_condition_is_known_or_the_column_cannot_be_it(
    folder, titles, values
):
    assert not notes_of(folder.open(sweep(f"{FIRST};{titles}", *values)))


def test_of_curves_side_by_side_none_is_offered_since_its_name_would_keep_them_together(folder):
    titles = [
        "f [Hz]",
        "Foo [mm]",
        "G' 20 °C [Pa]",
        "G'' 20 °C [Pa]",
        "G' 40 °C [Pa]",
        "G'' 40 °C [Pa]",
    ]
    rows = [f"{f};2;{f + 9};{f};{f + 5};{f}" for f in HERTZ]
    found = folder.open("\n".join([";".join(titles), *rows, ""]))
    assert len(found) == 2 * len(HERTZ)
    assert "note column of amplitude" not in found.provenance


def test_an_offer_is_not_written_into_a_file(folder, tmp_path):
    springpot.write_measurement(
        folder.open(sweep(f"{FIRST};Foo [mm]", 2.0)), tmp_path / "written.csv"
    )
    assert "note" not in (tmp_path / "written.csv").read_text(encoding="utf-8")
    assert not notes_of(springpot.read(tmp_path / "written.csv"))


@pytest.mark.parametrize("unit", ["Grad", "grad", "GRAD", "grd", "°", "deg.", "Deg", "gon"])
def test_a_phase_in_the_words_of_german_test_benches(folder, unit):
    per_turn = {"gon": 400.0}.get(unit, 360.0)
    head = f"f [Hz];Dynamic stiffness [N/mm];Phase [{unit}]"
    rows = [
        f"{f};{abs(k):.12g};{np.angle(k) / (2 * np.pi) * per_turn:.12g}"
        for f, k in zip(HERTZ, K, strict=True)
    ]
    np.testing.assert_allclose(folder.open("\n".join([head, *rows, ""])).stiffness, K, rtol=1e-9)


@pytest.mark.parametrize(
    "titles",
    [
        *(
            "dyn. stiffness K' [N/mm];K'' [N/mm]",
            "Dyn. Steifigkeit K' [N/mm];Dyn. Steifigkeit K'' [N/mm]",
        ),
        *("dyn. stiffness (K') [N/mm];dyn. stiffness (K'') [N/mm]", "c_dyn' [N/mm];c_dyn'' [N/mm]"),
        *(
            "Kdyn storage [N/mm];Kdyn loss [N/mm]",
            "Complex modulus E' [N/mm^2];Complex modulus E'' [N/mm^2]",
        ),
    ],
)
def test_a_symbol_with_primes_says_which_part_of_a_dynamic_stiffness(folder, titles):
    np.testing.assert_allclose(folder.open(sweep(f"f [Hz];{titles}")).stiffness, K, rtol=1e-9)


@pytest.mark.parametrize(
    ("head", "unit"),
    [
        ("f [Hz];K1 [N/mm];K2 [N/mm]", "N/mm"),
        ("Frequency, Hz;K1, N/mm;K2, N/mm", "N/mm"),
        ("f [Hz];K1;K2", "N/mm"),
        ("f [Hz];my storage;my loss", "Pa"),
        ("clock [Hz];G1 [kPa];G2 [kPa]", "kPa"),
        ("f [Hz];K' [kN/m];K2", "kN/m"),
        ("f;E1;E2\nHz;MPa;MPa", "MPa"),
        ("f [Hz];part one [MPa];part two [MPa]", "MPa"),
    ],
)
def test_a_hint_for_moduli_is_a_whole_command_that_says_what_it_assumes(folder, head, unit):
    content = sweep(head)
    with pytest.raises(DataError) as caught:
        folder.open(content)
    assert "NAME" not in str(caught.value)
    assert "UNIT" not in str(caught.value)
    typed = commands_in(str(caught.value))[0]
    found = folder.open(content, typed)
    np.testing.assert_allclose(found.stiffness, K, rtol=1e-9)
    np.testing.assert_allclose(found.frequency, HERTZ)
    assert found.units.stiffness == unit


def test_an_angle_beside_a_storage_is_proposed_as_the_phase(folder):
    content = sweep("f [Hz];K' [N/mm];x [°]")
    with pytest.raises(DataError, match="is phase") as caught:
        folder.open(content)
    (typed,) = commands_in(str(caught.value))
    np.testing.assert_allclose(
        folder.open(content, typed).loss, STORAGE * np.tan(np.radians(LOSS)), rtol=1e-9
    )


def negative(folder, head, part, rows):
    """The notes of a sweep in which one part is negative in these rows."""
    columns = [STORAGE.copy(), LOSS.copy()]
    columns[part][rows] *= -1
    lines = [
        ";".join(f"{value:.10g}" for value in row) for row in zip(HERTZ, *columns, strict=True)
    ]
    return notes_of(folder.open("\n".join([head, *lines, ""])))


@pytest.mark.parametrize(
    ("head", "name"),
    [
        ("f [Hz];G' [Pa];G'' [Pa]", "G''"),
        ("f [Hz];storage modulus [Pa];loss modulus [Pa]", "loss modulus"),
        (FIRST, "loss stiffness"),
    ],
)
def test_a_negative_loss_is_told_by_the_name_of_the_file(folder, head, name):
    assert negative(folder, head, 1, [1])["note loss"].startswith(
        f"{name} negative in 1 of 6 rows: "
    )


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (
            [4, 5],
            "storage stiffness negative in 2 of 6 rows, from 20 Hz on: the inertia of the rig",
        ),
        ([0], "storage stiffness negative in 1 of 6 rows, not at the highest frequencies"),
        (
            [3, 5],
            "storage stiffness negative in 2 of 6 rows, with positive ones at higher frequencies",
        ),
        ([0, 1, 2, 3], "storage stiffness negative in 4 of 6 rows; check the sign of the force"),
        (range(6), "storage stiffness negative in 6 of 6 rows: the inertia of the rig"),
    ],
)
def test_a_negative_storage_is_told_for_what_it_is(folder, rows, says):
    found = negative(folder, FIRST, 0, list(rows))
    assert found["note storage"].startswith(says)
    assert "note loss" not in found


def test_what_inertia_does_is_told_in_the_clock_of_the_file(folder):
    found = negative(folder, "omega [rad/s];G' [Pa];G'' [Pa]", 0, [5])
    assert found["note storage"].startswith("G' negative in 1 of 6 rows, from 50 rad/s on: ")


@pytest.mark.parametrize(
    ("factor", "says"), [(1.0, "from 20 Hz on: the inertia"), (0.1, "from 2 Hz on: the inertia")]
)
def test_inertia_begins_at_each_temperature_where_the_specimen_is_soft_enough(folder, factor, says):
    """A soft specimen is outweighed from a lower frequency on.

    Signs alternate only where sweeps are mixed.
    """
    lines = ["f [Hz];G' [Pa];G'' [Pa];T [degC]"]
    for celsius, first in ((20.0, 20.0), (60.0, 20.0 * factor)):
        sign = np.where(first > HERTZ, 1.0, -1.0)
        table = np.column_stack([HERTZ, sign * STORAGE, LOSS, np.full(len(HERTZ), celsius)])
        lines += [";".join(f"{value:.10g}" for value in row) for row in table]
    assert says in notes_of(folder.open("\n".join([*lines, ""])))["note storage"]


@pytest.mark.parametrize(
    ("title", "scale"), [("Coherence [-]", 1.0), ("γ²", 1.0), ("Kohärenz [%]", 100.0)]
)
def test_coherence_is_known_by_its_names(tmp_path, title, scale):
    path = tmp_path / "chirp.csv"
    rows = [f"{f},{10 + f},{f},{scale * (0.99 - 0.01 * f)}" for f in range(1, 6)]
    path.write_text("\n".join([f"f [Hz],K' [N/mm],K'' [N/mm],{title}", *rows]), encoding="utf-8")
    told = springpot.read(path).conditions["coherence"]
    np.testing.assert_allclose(told, 0.99 - 0.01 * np.arange(1, 6))
