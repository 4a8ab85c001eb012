"""Several curves in one table: side by side, one below the other; and columns of logarithms."""

import io

import numpy as np
import pytest

from springpot.measurement import Part, parts_as_opened

from .samples import OMEGA, STIFFNESS, rows

HERTZ = OMEGA / (2 * np.pi)
WARM = 0.4 * STIFFNESS
BOTH = np.concatenate([STIFFNESS, WARM])
PAIR = (HERTZ, STIFFNESS.real, STIFFNESS.imag, WARM.real, WARM.imag)
TWICE = (HERTZ, STIFFNESS.real, STIFFNESS.imag, HERTZ, WARM.real, WARM.imag)
NUMBERS, TWICE_NUMBERS = rows(PAIR), rows(TWICE)


def is_both(found, temperatures=None, unit="Pa"):
    np.testing.assert_allclose(found.omega, np.tile(OMEGA, 2), rtol=1e-10)
    np.testing.assert_allclose(found.stiffness, BOTH, rtol=1e-10)
    assert found.units.stiffness == unit
    if temperatures is None:
        assert "temperature" not in found.conditions
    else:
        np.testing.assert_allclose(
            found.conditions["temperature"], np.repeat(temperatures, len(OMEGA))
        )


TITLES = [
    "f [Hz],G' 20 °C [Pa],G'' 20 °C [Pa],G' 40 °C [Pa],G'' 40 °C [Pa]",
    "f (Hz),G' (Pa) at 20 °C,G'' (Pa) at 20 °C,G' (Pa) at 40 °C,G'' (Pa) at 40 °C",
    "f (Hz),G' (20 °C) [Pa],G'' (20 °C) [Pa],G' (40 °C) [Pa],G'' (40 °C) [Pa]",
    "f_Hz,Gp_20C_Pa,Gpp_20C_Pa,Gp_40C_Pa,Gpp_40C_Pa",
    "f [Hz],G' T=20°C [Pa],G'' T=20°C [Pa],G' T=40°C [Pa],G'' T=40°C [Pa]",
    ",20 °C,20 °C,40 °C,40 °C\nf [Hz],G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]",
    ",20 °C,,40 °C,\nf [Hz],G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]",
    "20 °C,,,40 °C,\nf [Hz],G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]",
    "T [°C],20,,40,\nf [Hz],G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]",
    ",T = 20 °C,,T = 40 °C,\nf,G',G'',G',G''\nHz,Pa,Pa,Pa,Pa",
]


@pytest.mark.parametrize("titles", TITLES)
def test_a_curve_for_each_temperature_beside_one_frequency(folder, titles):
    text = f"{titles}\n{NUMBERS}\n"
    is_both(folder.open(text), (20.0, 40.0))
    assert [part.points for part in folder.parts(text)] == [len(OMEGA)] * 2
    second = folder.open(text, "#2")
    np.testing.assert_allclose(second.stiffness, WARM, rtol=1e-10)
    assert set(second.conditions["temperature"]) == {40.0}


def test_numbers_above_curves_are_names_until_the_user_says_more(folder):
    text = f",20,,40,\nf [Hz],Gp [Pa],Gpp [Pa],Gp [Pa],Gpp [Pa]\n{NUMBERS}\n,,,,\n"
    found = folder.open(text)
    is_both(found)
    assert found.provenance["note parts"].endswith("?curves=temperature[degC]' or '?curves=repeat'")
    meant = folder.open(text, "?curves=temperature[degC]")
    is_both(meant, (20.0, 40.0))
    # What was said is not asked for again.
    assert "curves=" not in meant.provenance["note parts"]


def test_moduli_first_then_temperatures(folder):
    columns = (HERTZ, STIFFNESS.real, WARM.real, STIFFNESS.imag, WARM.imag)
    is_both(
        folder.open(
            f",20 °C,40 °C,20 °C,40 °C\nf [Hz],G' [Pa],G' [Pa],G'' [Pa],G'' [Pa]\n{rows(columns)}\n"
        ),
        (20, 40),
    )


@pytest.mark.parametrize(
    ("titles", "names"),
    [
        (
            "Sample A,,,Sample B,,\nf [Hz],G' [Pa],G'' [Pa],f [Hz],G' [Pa],G'' [Pa]",
            ["Sample A", "Sample B"],
        ),
        ("f [Hz],G' [Pa],G'' [Pa],f [Hz],G' [Pa],G'' [Pa]", ["curve 1", "curve 2"]),
        ("f [Hz],G' [Pa],G'' [Pa],f [Hz].1,G' [Pa].1,G'' [Pa].1", ["curve 1", "curve 2"]),
        ("f_A [Hz],G'_A [Pa],G''_A [Pa],f_B [Hz],G'_B [Pa],G''_B [Pa]", ["A", "B"]),
    ],
)
def test_curves_with_frequencies_of_their_own(folder, titles, names):
    text = f"{titles}\n{TWICE_NUMBERS}\n"
    is_both(folder.open(text))
    assert [part.name for part in folder.parts(text)] == names


def test_an_empty_column_between_curves_and_curves_of_unlike_length(folder):
    lines = [
        f"{a},,{b}"
        for a, b in zip(rows(TWICE[:3]).split("\n"), rows(TWICE[3:]).split("\n"), strict=True)
    ]
    text = (
        "f [Hz],G' [Pa],G'' [Pa],,f [Hz],G' [Pa],G'' [Pa]\n"
        + "\n".join(lines)
        + "\n100,2000,300,,,,\n"
    )
    found = folder.open(text)
    assert len(found) == 2 * len(OMEGA) + 1
    assert len(folder.open(text, "#2")) == len(OMEGA)
    assert "note rows" not in found.provenance


def test_names_of_samples_are_no_temperatures(folder):
    is_both(folder.open(f"f [Hz],G'_20 [Pa],G''_20 [Pa],G'_40 [Pa],G''_40 [Pa]\n{NUMBERS}\n"))
    # One sample called 20C may be anything; a row of them is temperatures.
    one = folder.open(f"f [Hz],G' 20C [Pa],G'' 20C [Pa]\n{rows(PAIR[:3])}\n")
    assert "temperature" not in one.conditions


def test_one_temperature_in_the_titles_is_a_condition(folder):
    found = folder.open(
        f"f [Hz],G' (-5,5 °C) [Pa],tan d (-5,5 °C)\n{rows(PAIR[:3])}\n".replace(",", ";").replace(
            ";5 ", ",5 "
        )
    )
    assert set(found.conditions["temperature"]) == {-5.5}


def test_a_temperature_sweep_at_several_frequencies(folder):
    temperature = 10.0 * np.arange(len(OMEGA))
    text = (
        "T [°C],E' 1 Hz [Pa],E'' 1 Hz [Pa],E' 10 Hz [Pa],E'' 10 Hz [Pa]\n"
        + rows((temperature, *PAIR[1:]))
        + "\n"
    )
    found = folder.open(text)
    np.testing.assert_allclose(found.omega, np.repeat([2 * np.pi, 20 * np.pi], len(OMEGA)))
    np.testing.assert_allclose(found.stiffness, BOTH, rtol=1e-10)
    np.testing.assert_allclose(found.conditions["temperature"], np.tile(temperature, 2))


@pytest.mark.parametrize(
    "titles",
    [
        "f [Hz],G' [Pa],G'' [Pa],G' model [Pa],G'' model [Pa]",
        "f [Hz],G' [Pa],G'' [Pa],G'_fit [Pa],G''_fit [Pa]",
    ],
)
def test_a_model_beside_the_measurement_is_no_curve(folder, titles):
    found = folder.open(f"{titles}\n{NUMBERS}\n")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-10)


def test_a_model_is_not_read_in_place_of_a_measurement(folder):
    said = folder.complaint(
        f"f [Hz],G'_exp [Pa],G''_exp [Pa],G'_fit [Pa],G''_fit [Pa]\n{NUMBERS}\n"
    )
    assert "if 'G'_exp [Pa]' is storage [Pa] and 'G''_exp [Pa]' is loss [Pa], open" in said
    assert "\n" not in said


def test_columns_that_are_named_by_number_stay_where_they_are(folder):
    found = folder.open(f"{TITLES[0]}\n{NUMBERS}\n", "?4=storage[Pa],5=loss[Pa]")
    np.testing.assert_allclose(found.stiffness, WARM, rtol=1e-10)


def test_curves_side_by_side_in_a_workbook(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append([None, "20 °C", None, "40 °C", None])
    book.active.append(["f [Hz]", "G' [Pa]", "G'' [Pa]", "G' [Pa]", "G'' [Pa]"])
    for row in zip(*PAIR, strict=True):
        book.active.append([float(value) for value in row])
    stream = io.BytesIO()
    book.save(stream)
    is_both(folder.open(stream.getvalue(), name="book.xlsx"), (20.0, 40.0))


def test_sheets_that_are_called_by_their_temperature(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, values in (("20 °C", STIFFNESS), ("T = 40 °C", WARM)):
        sheet = book.create_sheet(title)
        sheet.append(["f [Hz]", "G' [Pa]", "G'' [Pa]"])
        for row in zip(HERTZ, values.real, values.imag, strict=True):
            sheet.append([float(value) for value in row])
    stream = io.BytesIO()
    book.save(stream)
    is_both(folder.open(stream.getvalue(), name="book.xlsx"), (20.0, 40.0))


@pytest.mark.parametrize("line", ["T = {} °C", "{} °C", "Temperature: {} °C", "# {} °C"])
@pytest.mark.parametrize("repeated", [True, False])
def test_sweeps_one_below_the_other(folder, line, repeated):
    names, parts = "f [Hz],G' [Pa],G'' [Pa]", (rows(PAIR[:3]), rows((HERTZ, WARM.real, WARM.imag)))
    one, two = line.format("20"), line.format("40")
    text = f"{one}\n{names}\n{parts[0]}\n\n{two}\n{names}\n{parts[1]}\n"
    if not repeated:
        text = f"{names}\n{one}\n{parts[0]}\n{two}\n{parts[1]}\n"
    is_both(folder.open(text), (20.0, 40.0))


def test_rows_that_are_numbered_by_segment(folder):
    lines = [
        f"{k}|{i},{row}" for k in (1, 2) for i, row in enumerate(rows(PAIR[:3]).split("\n"), 1)
    ]
    text = 'SegIndex,f in Hz,G\' in Pa,"G"" in Pa"\n' + "\n".join(lines) + "\n"
    assert [part.name for part in folder.parts(text)] == ["segment 1", "segment 2"]
    np.testing.assert_allclose(folder.open(text, "#2").stiffness, STIFFNESS, rtol=1e-10)


def test_the_count_of_rows_without_a_name_above_it(folder):
    lines = "\n".join(f'"{i}",{row}' for i, row in enumerate(rows(PAIR[:3]).split("\n"), 1))
    found = folder.open(f'"f [Hz]","G\' [Pa]","G\'\' [Pa]"\n{lines}\n')
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-10)


def test_names_behind_a_word_that_has_no_column(folder):
    """Numbers at the margin, below names that are not, must not be read one column off."""
    head = (
        "Project:\tp\nTest:\tt\nResult:\tr\nInterval and data points:\t1\t5\n"
        "Temperature:\t25.0 °C\n"
    )
    text = (
        head
        + "Interval data:\tFrequency\tG'\tG''\n\t[Hz]\t[Pa]\t[Pa]\n"
        + rows(PAIR[:3], "\t")
        + "\n"
    )
    assert folder.reader(text) == "rheocompass"
    found = folder.open(text)
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-10)
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-10)
    assert set(found.conditions["temperature"]) == {25.0}


TENS = rows((np.log10(OMEGA), np.log10(STIFFNESS.real), np.log10(STIFFNESS.imag)))
NATURAL = rows((np.log(OMEGA), np.log(STIFFNESS.real), np.log(STIFFNESS.imag)))


@pytest.mark.parametrize(
    ("titles", "numbers"),
    [
        ("log10 ω [rad/s],log10 G' [Pa],log10 G'' [Pa]", TENS),
        ("lg(ω / rad/s),lg(G' / Pa),lg(G'' / Pa)", TENS),
        ("log10(omega [rad/s]),log10(Gp [Pa]),log10(Gpp [Pa])", TENS),
        ("log10(omega) [rad/s],log10(G') [Pa],log10(G'') [Pa]", TENS),
        ("log10 omega,log10 G',log10 G''\nrad/s,Pa,Pa", TENS),
        ("ln ω [rad/s],ln G' [Pa],ln G'' [Pa]", NATURAL),
    ],
)
def test_logarithms_whose_base_is_said(folder, titles, numbers):
    found = folder.open(f"{titles}\n{numbers}\n")
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-9)
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)


def test_logarithms_beside_plain_numbers_and_with_decimal_commas(folder):
    text = rows((OMEGA, np.log10(STIFFNESS.real), np.log10(STIFFNESS.imag)), ";", ",")
    found = folder.open(f"ω [rad/s];log10 G' [Pa];log10 G'' [Pa]\n{text}\n")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)


def test_logarithms_whose_base_is_not_said_are_asked_for(folder):
    text = f"log ω,log G',log G''\n{TENS}\n"
    said = folder.complaint(text)
    assert said.count("\n") == 0
    assert "?log=10,storage=Pa,loss=Pa'" in said
    found = folder.open(text, "?log=10,storage=Pa,loss=Pa")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)
    found = folder.open(f"log ω,log G' [Pa],log G'' [Pa]\n{NATURAL}\n", "?log=e")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)


def test_columns_of_logarithms_are_named_by_the_user(folder):
    found = folder.open(f"{TENS}\n", "?1=log10 omega[rad/s],2=log10 storage[Pa],3=log10 loss[Pa]")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)


def test_a_logarithm_of_no_number_names_its_line(folder):
    said = folder.complaint("log10 f [Hz],log10 G' [Pa],log10 G'' [Pa]\n0,1,1\n1,500,2\n")
    assert "line 3" in said
    assert "\n" not in said


@pytest.mark.parametrize(
    "titles",
    [
        "f,run 1,,run 2,\nHz,G' [Pa],G'' [Pa],G' [Pa],G'' [Pa]",
        "frequency,run 1,run 1,run 2,run 2\n[Hz],Gp (Pa),Gpp (Pa),Gp (Pa),Gpp (Pa)",
    ],
)
def test_a_unit_below_the_name_of_the_frequency_alone(folder, titles):
    is_both(folder.open(f"{titles}\n{NUMBERS}\n"))


def test_parts_that_the_user_has_said_the_unit_of_are_usable(folder):
    numbers = rows((HERTZ, *np.log10(PAIR[1:])))
    text = f"f,run 1,,run 2,\nf,log G',log G'',log G',log G''\n{numbers}\n"
    parts = folder.parts(text)
    assert [(part.usable, part.asks) for part in parts] == [(False, True)] * 2
    opened = folder.open(text, "?log=10,frequency=Hz,storage=Pa,loss=Pa")
    assert [part.usable for part in parts_as_opened(parts, opened)] == [True, True]


def test_a_part_that_is_no_dynamic_test_is_never_usable(folder):
    text = f"f,run 1,,run 2,\nHz,G',G'',G',G''\n{NUMBERS}\n"
    creep = Part("creep", 2, False, "creep in time, no dynamic test")
    parts = parts_as_opened([*folder.parts(text), creep], folder.open(text, "?storage=Pa,loss=Pa"))
    assert [part.usable for part in parts] == [True, True, False]
