"""Files as laboratories keep them.

Several tests in one job, flags, old workbooks, names that are told apart.
"""

import io

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import FILE_UNITS

from .samples import OMEGA, STIFFNESS, number

xlwt = pytest.importorskip("xlwt")


def old_workbook(sheets):
    """The bytes of an .xls with these sheets."""
    book = xlwt.Workbook()
    for title, rows in sheets.items():
        sheet = book.add_sheet(title)
        for i, row in enumerate(rows):
            for j, value in enumerate(row):
                sheet.write(i, j, value)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


SWEEP = [
    ["Frequency - 1"],
    ["Angular frequency", "Temperature", "Storage modulus", "Loss modulus"],
    ["rad/s", "°C", "Pa", "Pa"],
    *([w, 20.5, k.real, k.imag] for w, k in zip(OMEGA.tolist(), STIFFNESS.tolist(), strict=True)),
]


def test_an_old_workbook_opens_with_what_its_first_sheet_says(folder):
    found = folder.open(
        old_workbook({"Details": [["Sample name", "a gel"]], "Frequency - 1": SWEEP}), name="a.xls"
    )
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-12)
    np.testing.assert_array_equal(found.conditions["temperature"], 20.5)
    assert found.provenance["sample"] == "a gel"


def rheocompass(intervals):
    """A RheoCompass export of (titles, units, rows) for each interval."""
    lines = ["Project:\tgels", "Test:\tjob", "", "Result:\tjob 1", ""]
    for i, (titles, units, rows) in enumerate(intervals, 1):
        lines += [
            f"Interval and data points:\t{i}\t{len(rows)}",
            "\t".join(["Interval data:", "Point No.", *titles]),
        ]
        lines += ["\t" * (len(titles) + 1), "\t".join(["", "", *units])]
        lines += ["\t".join(["", str(k), *map(str, row)]) for k, row in enumerate(rows, 1)] + [""]
    return "\n".join(lines).encode("utf-16")


MODULI = ("Angular Frequency", "Storage Modulus", "Loss Modulus", "Loss Factor", "Status")
UNITS = ("[rad/s]", "[Pa]", "[Pa]", "[1]", "")
ROWS = [
    [number(w), number(k.real), number(k.imag), number(k.imag / k.real), "TruStrain™"]
    for w, k in zip(OMEGA, STIFFNESS, strict=True)
]


def clipped(row):
    """The row as the instrument writes it where tan delta is beyond its limit."""
    return [row[0], number(float(row[2]) / 20000), row[2], "20000.000", "ME-,taD,TruStrain™"]


def test_what_the_instrument_takes_back_is_left_out_and_told(folder):
    content = rheocompass([(MODULI, UNITS, [clipped(ROWS[0]), clipped(ROWS[1]), *ROWS[2:]])])
    found = folder.open(content)
    np.testing.assert_allclose(found.stiffness, STIFFNESS[2:], rtol=1e-10)
    assert "2 of 5 rows" in found.provenance["note clipped"]
    assert "ME- (2), taD (2)" in found.provenance["note status"]
    assert "TruStrain" not in found.provenance["note status"]
    assert len(folder.open(content, "?status=ignore")) == 5


def test_clipped_values_are_told_without_a_status_column(folder):
    rows = [clipped(ROWS[0])[:4], clipped(ROWS[1])[:4], *(row[:4] for row in ROWS[2:])]
    found = folder.open(rheocompass([(MODULI[:4], UNITS[:4], rows)]))
    assert len(found) == 3


def test_a_zero_beside_large_moduli_was_not_measured(folder):
    """A program's word for a negative one; beside small ones it is rounded."""
    row = "{},{},{}\n".format
    falling = "frequency [Hz],G' [Pa],G'' [Pa]\n" + row(10, 0, 4.73) + row(5, 0.46, 0.47)
    falling += row(2, 0.27, 0.29) + row(1, 0.2, 0.2) + row(0.5, 0.01, 0.02) + row(0.2, 0, 0.01)
    found = folder.open(falling)
    np.testing.assert_allclose(found.stiffness.real, [0.46, 0.27, 0.2, 0.01, 0])
    assert "1 of 6 rows" in found.provenance["note clipped"]
    assert "0 beside large ones" in found.provenance["note clipped"]
    liquid = "frequency [Hz],G' [Pa],G'' [Pa]\n" + row(1, 0, 1) + row(2, 0, 2) + row(3, 0, 3)
    assert len(folder.open(liquid)) == 3


def test_rows_at_a_limit_and_a_zero_are_told_together(folder):
    row = "{},{},{}\n".format
    text = "frequency [Hz],G' [Pa],G'' [Pa]\n" + row(10, 0, 4.73) + row(5, 0.46, 0.47)
    text += row(2, 0.27, 0.29) + row(1, 0.2, 0.2) + row(0.5, 1e-6, 0.02) + row(0.2, 5e-7, 0.01)
    told = folder.open(text).provenance["note clipped"]
    assert "3 of 6 rows" in told
    assert "(0 beside large ones, or tan delta at its limit)" in told
    assert len(folder.open(text, "?status=ignore")) == 6


def test_when_nothing_was_measured_it_says_what_to_type(folder):
    content = rheocompass([(MODULI, UNITS, [clipped(row) for row in ROWS])])
    with pytest.raises(DataError, match=r"5 of 5 rows .* '.*\?status=ignore'"):
        folder.open(content)
    assert "kept as you said" in folder.open(content, "?status=ignore").provenance["note clipped"]


def test_a_raw_phase_near_180_degrees_is_told(folder):
    header = "omega [rad/s],G' [Pa],G'' [Pa],Raw phase [deg]\n"
    text = header + "1,100,10,5\n10,100,12,80\n30,100,15,165\n60,90,20,176\n"
    found = folder.open(text)
    assert "2 of 4 rows, from 4.77 Hz on" in found.provenance["note raw phase"]


PRESHEAR = (
    ("Time", "Shear Rate", "Shear Stress", "Viscosity"),
    ("[s]", "[1/s]", "[Pa]", "[Pa·s]"),
    [[1, 10, 20, 2], [2, 10, 21, 2.1]],
)


def test_a_pre_shear_does_not_keep_the_sweep_from_opening(folder):
    content = rheocompass([PRESHEAR, (MODULI, UNITS, ROWS)])
    np.testing.assert_allclose(folder.open(content).stiffness, STIFFNESS, rtol=1e-10)
    first, second = folder.parts(content)
    assert not first.usable
    assert first.says.startswith("steady flow, no dynamic test")
    assert (second.usable, second.name) == (True, "job 1 interval 2")


def test_a_part_that_lacks_a_unit_does_not_keep_the_rest_from_opening(folder):
    bare = (MODULI, ("", "", "", "", ""), ROWS)
    content = rheocompass([(MODULI, UNITS, ROWS), bare, (MODULI, UNITS, ROWS)])
    found = folder.open(content)
    assert sorted(set(found.labels["step"])) == ["job 1 interval 1", "job 1 interval 3"]
    assert "left out: " in found.provenance["note job 1 interval 2"]
    assert "have no unit" in found.provenance["note job 1 interval 2"]
    # By itself it is in units of its own.
    assert folder.open(content, "#2").units.stiffness == FILE_UNITS


def test_a_segment_without_moduli_in_the_same_columns(folder):
    sweep = "\n".join(
        f"1|{i},{10 + i},{w},{k.real},{k.imag},37"
        for i, (w, k) in enumerate(zip(OMEGA, STIFFNESS, strict=True), 1)
    )
    creep = "\n".join(f"2|{i},{20 + i}, , , ,37" for i in range(1, 9))
    text = f',t in s,f in Hz,G\' in Pa,"G"" in Pa",T in °C\n{sweep}\n{creep}\n'
    np.testing.assert_allclose(folder.open(text).stiffness, STIFFNESS, rtol=1e-10)
    assert [part.usable for part in folder.parts(text)] == [True, False]


@pytest.mark.parametrize(
    ("header", "says", "typed"),
    [
        (
            "strain [%],G' [Pa],G'' [Pa]",
            r"missing frequency .* open '[^']*\?frequency=1\[Hz\]'$",
            "?frequency=1[Hz]",
        ),
        (
            "Time [s],Relaxation modulus [Pa],Temperature [°C]",
            "a relaxation test in time, no dynamic test$",
            "",
        ),
        (
            "Time [s],Creep compliance [1/Pa],Temperature [°C]",
            "creep in time, no dynamic test$",
            "",
        ),
    ],
)
def test_a_hint_leads_to_right_data_or_is_not_given(folder, header, says, typed):
    text = f"{header}\n1,200,30\n2,190,31\n"
    with pytest.raises(DataError, match=says):
        folder.open(text)
    if typed:
        np.testing.assert_allclose(folder.open(text, typed).frequency, 1.0)


@pytest.mark.parametrize("header", ["a,b,c", "f [Hz],one,two", "time [s],G' [Pa],something"])
def test_a_hint_that_is_typed_as_it_stands_gives_no_numbers(folder, header):
    """Which column is what only the user knows.

    An example with numbers of columns would be typed as it stands.
    """
    text = f"{header}\n1,2,3\n2,3,4\n"
    with pytest.raises(DataError) as caught:
        folder.open(text)
    hint = str(caught.value).partition("?")[2].partition("'")[0]
    with pytest.raises(DataError):
        folder.open(text, "?" + hint)


def stiffness_table(header, *columns):
    rows = "\n".join(
        ",".join(number(v) for v in row) for row in zip(OMEGA / (2 * np.pi), *columns, strict=True)
    )
    return f"{header}\n{rows}\n"


LOSS, STORAGE = STIFFNESS.imag, STIFFNESS.real


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("Frequency [Hz],Effective stiffness [kN/m],Loss factor", (STORAGE, LOSS / STORAGE)),
        ("Frequency [Hz],K_eff [kN/m],Damping ratio [%]", (STORAGE, 50 * LOSS / STORAGE)),
        (
            "Frequenz [Hz],Effektive Steifigkeit [kN/m],Dämpfungsgrad [-]",
            (STORAGE, LOSS / STORAGE / 2),
        ),
        ("Frequency [Hz],Effective stiffness [kN/m],h_eq", (STORAGE, LOSS / STORAGE / 2)),
        (
            "Frequency [Hz],Dynamic stiffness [kN/m],Damping coefficient [kN s/m]",
            (abs(STIFFNESS), LOSS / OMEGA),
        ),
        (
            "Frequency [Hz],Storage stiffness [kN/m],Damping coefficient [N s/mm]",
            (STORAGE, LOSS / OMEGA),
        ),
        ("Frequency [Hz],Effective stiffness [kN/m],c_eq [kN*s/m]", (STORAGE, LOSS / OMEGA)),
    ],
)
def test_the_words_of_bearings_and_dampers(folder, header, columns):
    found = folder.open(stiffness_table(header, *columns))
    in_kilonewton = {"kN/m": 1.0, "N/m": 1e-3}[found.units.stiffness]
    np.testing.assert_allclose(found.stiffness * in_kilonewton, STIFFNESS, rtol=1e-9)


def test_a_stiffness_that_may_be_either_is_asked_for(folder):
    text = stiffness_table("Frequency [Hz],Stiffness [kN/m],Loss factor", STORAGE, LOSS / STORAGE)
    with pytest.raises(
        DataError, match=r"missing storage \[unit\] or magnitude \[unit\]; if Stiffness"
    ):
        folder.open(text)
    found = folder.open(text, "?Stiffness=storage[kN/m]")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)


def test_a_damping_coefficient_beyond_the_whole_stiffness(folder):
    text = stiffness_table(
        "Frequency [Hz],Dynamic stiffness [kN/m],Damping coefficient [kN s/m]",
        LOSS / 2,
        LOSS / OMEGA,
    )
    with pytest.raises(DataError, match="more than the whole dynamic stiffness"):
        folder.open(text)


SWEEP_TEXT = "omega [rad/s],G' [Pa],G'' [Pa]\n1,200,30\n2,190,31\n"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gel_20C.csv", "temperature=20[degC]"),
        ("gel -10 °C.csv", "temperature=-10[degC]"),
        ("PI1000k_T=35_FS.csv", "temperature=35[degC]"),
        ("gel_293.15K.csv", "temperature=293.15[K]"),
        ("gel_25degC run.csv", "temperature=25[degC]"),
    ],
)
def test_a_temperature_in_the_name_is_offered_and_not_taken(folder, name, said):
    found = folder.open(SWEEP_TEXT, name=name)
    assert "temperature" not in found.conditions
    offered = found.provenance["note temperature"].partition("?")[2].rstrip("'")
    assert offered == said
    taken = folder.open(SWEEP_TEXT, f"?{offered}", name=name)
    assert "note temperature" not in taken.provenance
    expected = 20.0 if "293" in name else float(said.partition("=")[2].partition("[")[0])
    np.testing.assert_allclose(taken.conditions["temperature"], expected)


@pytest.mark.parametrize(
    "name", ["PS5K.csv", "frequency-sweep_BB_280524-1.csv", "v2.csv", "C20.csv", "gel_10Hz.csv"]
)
def test_other_numbers_in_a_name_are_no_temperatures(folder, name):
    assert "note temperature" not in folder.open(SWEEP_TEXT, name=name).provenance


def test_a_number_in_which_several_names_differ_is_offered(folder):
    for number_ in ("145", "160"):
        folder.write(SWEEP_TEXT, name=f"ps{number_}_data.csv")
    note = folder.open(SWEEP_TEXT, name="ps130_data.csv").provenance["note temperature"]
    assert "?temperature=130[degC]'" in note
    for name in ("run10.csv", "run11.csv", "run12.csv"):
        folder.write(SWEEP_TEXT, name=name)
    assert "note temperature" not in folder.open(SWEEP_TEXT, name="run11.csv").provenance


@pytest.mark.parametrize(
    ("stem", "said"),
    [("foam_-10", "-10"), ("foam_-25", "-25"), ("foam_20", "20"), ("ps-130", "130")],
)
def test_a_minus_is_a_sign_unless_it_joins_two_words(folder, stem, said):
    for other in ("foam_-25", "foam_-10", "foam_5", "foam_20", "ps-130", "ps-145", "ps-160"):
        folder.write(SWEEP_TEXT, name=f"{other}.csv")
    note = folder.open(SWEEP_TEXT, name=f"{stem}.csv").provenance["note temperature"]
    assert f"'{said}' in its name" in note
    assert f"?temperature={said}[degC]'" in note


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("?G'=kPa", "'G' [Pa]' is in kPa as you said; the file says Pa"),
        ("?3=storage[Pa],2=loss[Pa]", "'G' [Pa]' is loss as you said; its name says storage"),
        ("?frequency=1[Hz]", "'omega [rad/s]' is not used as omega, as you said"),
    ],
)
def test_what_is_overruled_is_told(folder, said, told):
    text = SWEEP_TEXT.replace("omega [rad/s]", "omega [rad/s]")
    assert told in folder.open(text, said).provenance["note columns"]


def test_a_constant_goes_before_a_column(folder):
    np.testing.assert_allclose(folder.open(SWEEP_TEXT, "?frequency=1[Hz]").frequency, 1.0)


@pytest.mark.parametrize(("title", "first"), [("run", "a"), ("set", "1"), ("Probe", "x y")])
def test_rows_of_several_runs_are_never_together_without_a_word(folder, title, first):
    values = [first, first, "2", "2"]
    rows = [f"{w},200,30,{v}" for w, v in zip((1, 2, 1, 2), values, strict=True)]
    text = "\n".join([f"omega [rad/s],G' [Pa],G'' [Pa],{title}", *rows]) + "\n"
    note = folder.open(text).provenance["note together"]
    choice = note.partition("'")[2].rstrip("'")
    assert len(folder.open(text, choice)) == 2


def test_a_loss_that_is_negative_is_told(folder):
    few = folder.open("omega [rad/s],G' [Pa],G'' [Pa]\n1,200,30\n2,190,31\n3,180,-1\n")
    assert "negative in 1 of 3 rows" in few.provenance["note loss"]
    most = folder.open("omega [rad/s],G' [Pa],G'' [Pa]\n1,200,-30\n2,190,-31\n3,180,1\n")
    assert "sign of the force" in most.provenance["note loss"]


def test_other_names_beside_springpots_own_are_known_too(folder):
    found = folder.open(
        "frequency [Hz],storage [Pa],loss [Pa],strain [%],T [°C]\n1,2,3,0.5,20\n2,3,4,0.5,20\n"
    )
    assert found.conditions["amplitude"].tolist() == [0.5, 0.5]
    assert found.conditions["temperature"].tolist() == [20.0, 20.0]
