"""Storage and loss that do not stand beside each other.

In rows of their own, one below the other, in wide tables.
"""

import io
import re

import numpy as np
import pytest

import springpot
from springpot.errors import DataError

OMEGA = np.logspace(-1.0, 2.0, 8)
G = 1000.0 + 500.0 * np.sqrt(1j * OMEGA)
DEG = 180.0 / np.pi
FREQUENCIES, WARM = np.array([25.0, 10.0, 1.0, 0.1]), np.array([-10.0, 4.4, 21.1])
E = (5000.0 + 100.0 * np.outer(1.0 / (WARM + 20.0), FREQUENCIES)) * np.exp(0.3j + 0.01j * WARM)[
    :, None
]


def in_rows(names=("G'", "G''"), parts=(G.real, G.imag), more="", of_name=("", "")):
    """One value in each row, storage and loss by turns."""
    lines = []
    for i, omega in enumerate(OMEGA):
        for name, values, last in zip(names, parts, of_name, strict=True):
            lines.append(f"{omega:.17g},{name},{values[i]:.17g}{more}{last}")
    return "\n".join(lines) + "\n"


def wide(values, names="temperature [degC],25 Hz,10 Hz,1 Hz,0.1 Hz"):
    rows = [",".join(f"{x:.12g}" for x in [t, *row]) for t, row in zip(WARM, values, strict=True)]
    return "\n".join([names, *rows]) + "\n"


def is_sweep(found, unit="Pa"):
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-10)
    np.testing.assert_allclose(found.stiffness, G, rtol=1e-10)
    assert found.units.stiffness == unit


def is_table(found):
    assert len(found) == E.size
    for kelvin, frequency, value in zip(
        found.conditions["temperature"], found.frequency, found.stiffness, strict=True
    ):
        i, j = np.argmin(abs(WARM - kelvin)), np.argmin(abs(FREQUENCIES - frequency))
        assert value == pytest.approx(E[i, j], rel=1e-9)
    assert found.units.stiffness == "MPa"


@pytest.mark.parametrize(
    "text",
    [
        "omega [rad/s],quantity,value [Pa]\n" + in_rows(),
        "omega [rad/s],variable,value [Pa]\n" + in_rows(("Storage modulus", "Loss modulus")),
        "omega [rad/s],type,modulus [Pa]\n" + in_rows(("storage", "loss")),
        "omega [rad/s],type,value\n" + in_rows(("G' [Pa]", "G'' [Pa]")),
        "omega [rad/s],what,value,unit\n"
        + in_rows(("Storage modulus", "Loss modulus"), more=",Pa"),
        "omega [rad/s],what,value [Pa]\n"
        + in_rows(("|G*|", "phase [deg]"), (abs(G), np.angle(G) * DEG)),
        "omega [rad/s],what,value,unit\n"
        + in_rows(("|G*|", "phase angle"), (abs(G), np.angle(G) * DEG), of_name=(",Pa", ",deg")),
    ],
)
def test_a_value_in_each_row(folder, text):
    found = folder.open(text)
    is_sweep(found)
    assert "in columns of their own" in found.provenance["note layout"]


def test_a_row_of_storage_may_stand_far_from_its_loss(folder):
    lines = in_rows().splitlines()
    is_sweep(
        folder.open(
            "omega [rad/s],quantity,value [Pa]\n" + "\n".join(lines[::2] + lines[1::2]) + "\n"
        )
    )


def test_conditions_of_rows_are_kept_and_what_differs_within_a_point_is_told(folder):
    lines = [
        f"{i},{line},{t}"
        for t in (20, 40)
        for i, line in enumerate(in_rows().splitlines(), 100 * t)
    ]
    found = folder.open(
        "id,omega [rad/s],quantity,value [Pa],temperature [degC]\n" + "\n".join(lines) + "\n"
    )
    np.testing.assert_allclose(found.conditions["temperature"], np.repeat([20.0, 40.0], len(OMEGA)))
    np.testing.assert_allclose(found.stiffness, np.tile(G, 2), rtol=1e-10)
    assert ": 'id'" in found.provenance["note layout"]


def test_units_of_values_in_rows_are_asked_for_by_a_command_that_works(folder):
    text = "omega,quantity,value\n" + in_rows()
    note = folder.open(text).provenance["note units"]
    asked = re.search(r"data\.txt(\?[^']+)'", note)
    assert asked, note
    is_sweep(folder.open(text, asked[1]))


def test_values_that_could_be_several_columns_are_not_guessed(folder):
    text = "omega [rad/s],quantity,first,second\n" + in_rows(more=",1.5", of_name=("", "3"))
    says = folder.complaint(text)
    assert "call it value" in says
    assert "first, second" in says
    is_sweep(folder.open(text.replace("first", "value [Pa]")))


def test_words_that_are_no_quantities_do_not_turn_a_table(folder):
    lines = [
        f"{w:.17g},{s},{g.real:.17g},{g.imag:.17g}"
        for s in ("soft", "stiff")
        for w, g in zip(OMEGA, G, strict=True)
    ]
    found = folder.open("omega [rad/s],sample,G' [Pa],G'' [Pa]\n" + "\n".join(lines) + "\n")
    assert len(found) == 2 * len(OMEGA)
    assert "note layout" not in found.provenance


def column(values):
    return "\n".join(f"{w:.17g},{g:.17g}" for w, g in zip(OMEGA, values, strict=True)) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        f"omega [rad/s],G' [Pa]\n{column(G.real)}\nomega [rad/s],G'' [Pa]\n{column(G.imag)}",
        f"omega,G'\nrad/s,Pa\n{column(G.real)}\nomega,G''\nrad/s,Pa\n{column(G.imag)}",
        (
            f"Storage modulus\nomega [rad/s],y [Pa]\n{column(G.real)}\n"
            f"Loss modulus\nomega [rad/s],y [Pa]\n{column(G.imag)}"
        ),
        (
            f"omega [rad/s],|G*| [Pa]\n{column(abs(G))}\n"
            f"omega [rad/s],tan delta\n{column(G.imag / G.real)}"
        ),
    ],
)
def test_a_block_of_storage_above_one_of_loss(folder, text):
    is_sweep(folder.open(text))
    assert folder.parts(text) == ()


def test_blocks_at_other_frequencies_are_not_put_together(folder):
    other = column(G.imag).replace(f"{OMEGA[0]:.17g}", "0.5")
    shifted = "\n".join(f"{1.01 * w:.17g},1" for w in OMEGA)
    says = folder.complaint(
        f"omega [rad/s],G' [Pa]\n{column(G.real)}\nomega [rad/s],G'' [Pa]\n{shifted}\n"
    )
    assert "different omega" in says
    assert "same values" in says
    found = folder.open(f"omega [rad/s],G' [Pa]\n{column(G.real)}\nomega [rad/s],G'' [Pa]\n{other}")
    assert len(found) == len(OMEGA) - 1
    assert "left out" in found.provenance["note rows"]


ANGLE = np.angle(E) * DEG
BLOCKS = f"|E*| [MPa]\n{wide(abs(E))}\nphase angle [deg]\n{wide(ANGLE)}"
BESIDE = (
    ",|E*| [MPa],,,,phase [deg],,,\nT [degC],25 Hz,10 Hz,1 Hz,0.1 Hz,25 Hz,10 Hz,1 Hz,0.1 Hz\n"
    + wide(np.hstack([abs(E), ANGLE]), "").lstrip()
)


@pytest.mark.parametrize(
    "text",
    [
        BLOCKS,
        BLOCKS.replace("|E*| [MPa]", "Dynamic modulus |E*| (MPa)").replace(
            "phase angle [deg]", "Phase angle (°)"
        ),
        BLOCKS.replace(
            "temperature [degC],25 Hz,10 Hz,1 Hz,0.1 Hz", "T [degC] \\ f [Hz],25,10,1,0.1"
        ),
        BLOCKS.replace(
            "temperature [degC],25 Hz,10 Hz,1 Hz,0.1 Hz", "Temp (°C),Frequency (Hz)\n,25,10,1,0.1"
        ),
        BESIDE,
        f"|E*| [MPa]\n{wide(abs(E))}\nloss factor\n{wide(np.tan(np.angle(E)))}",
    ],
)
def test_columns_that_go_by_frequency(folder, text):
    is_table(folder.open(text))


def test_columns_that_go_by_temperature(folder):
    def turned(values):
        return (
            "\n".join(
                ",".join(f"{x:.12g}" for x in [f, *row])
                for f, row in zip(FREQUENCIES, values.T, strict=True)
            )
            + "\n"
        )

    names = "frequency [Hz],-10 °C,4.4 °C,21.1 °C\n"
    is_table(
        folder.open(f"|E*| [MPa]\n{names}{turned(abs(E))}\nphase [deg]\n{names}{turned(ANGLE)}")
    )


@pytest.mark.parametrize("text", [BLOCKS, BESIDE])
def test_numbers_above_columns_are_asked_for(folder, text):
    text = text.replace(" Hz", "")
    asked = re.search(r"data\.txt(\?[^']+)'", folder.complaint(text))
    assert asked
    assert "go by 25, 10, 1" in folder.complaint(text)
    is_table(folder.open(text, asked[1]))


def test_a_second_question_keeps_the_answer_to_the_first(folder):
    text = BLOCKS.replace("temperature [degC],25 Hz,10 Hz,1 Hz,0.1 Hz", "T,25,10,1,0.1")
    text, said = text.replace(" [deg]", ""), ""
    for _ in range(2):
        with pytest.raises(DataError) as asked:
            folder.open(text, said)
        said = re.search(r"data\.txt(\?[^']+)'", str(asked.value))[1]
    is_table(folder.open(text, said))


def test_a_sample_that_is_called_like_a_unit_is_a_label(folder):
    lines = in_rows(("Storage modulus", "Loss modulus")).splitlines()
    text = "sample,omega [rad/s],what,Result (Pa)\n" + "".join(f"A,{line}\n" for line in lines)
    found = folder.open(text)
    is_sweep(found)
    assert set(found.labels["sample"]) == {"A"}


def test_rows_of_storage_alone_name_what_lacks(folder):
    lines = in_rows().splitlines()
    says = folder.complaint("omega [rad/s],quantity,value [Pa]\n" + "\n".join(lines[::2]) + "\n")
    assert "all rows of 'quantity' say G'; add rows of what lacks" in says
    is_sweep(folder.open("omega [rad/s],quantity,value [Pa]\n" + "\n".join(lines) + "\n"))


def test_a_word_among_the_values_is_named(folder):
    text = "omega [rad/s],quantity,value [Pa]\n" + in_rows()
    first, *others = text.splitlines()
    spoilt = [first, f"{others[0].rpartition(',')[0]},below", *others[1:]]
    says = folder.complaint("\n".join(spoilt) + "\n")
    assert "'value [Pa]' holds 'below', which is no number" in says
    assert "call it value" not in says
    is_sweep(folder.open(text))


def test_curves_that_were_read_off_at_frequencies_of_their_own_are_refused(folder):
    def beside(factor):
        rows = [
            f"{w:.9g},{g.real:.17g},{factor * w:.9g},{g.imag:.17g}"
            for w, g in zip(OMEGA, G, strict=True)
        ]
        return "omega [rad/s],G' [Pa],omega [rad/s],G'' [Pa]\n" + "\n".join(rows) + "\n"

    says = folder.complaint(beside(1.05))
    assert "'omega [rad/s]' stands twice, with 0.1 and 0.105 in one row" in says
    assert len(folder.open(beside(1.05), re.search(r"data\.txt(\?[^']+)'", says)[1])) == len(OMEGA)
    assert len(folder.open(beside(1.0))) == len(OMEGA)
    fortran = re.sub(r"(?<=[0-9])(?=[,\n])", "D+00", beside(1.0))
    assert "D+00" in fortran
    assert len(folder.open(fortran)) == len(OMEGA)


def test_frequencies_in_place_of_quantities_beside_named_ones(folder):
    bare = ",".join(f"{f:g} Hz" for f in FREQUENCIES)
    angles = ",".join(f"phase {f:g} Hz [deg]" for f in FREQUENCIES)
    text = wide(np.hstack([abs(E), ANGLE]), f"T [degC],{bare},{angles}")
    shown = re.search(r"as in '(.+?) 25 Hz (.+?)'", folder.complaint(text))
    named = ",".join(f"{shown[1]} {f:g} Hz {shown[2]}" for f in FREQUENCIES)
    is_table(folder.open(text.replace(bare, named)))


def test_what_a_part_leaves_open_names_the_file(folder):
    names = ",".join(f"|E*| {f:g} Hz [MPa],phase {f:g} Hz" for f in FREQUENCIES)
    text = f"T [degC],{names}\n4,1,2,3,4,5,6,7,8\n20,1,2,3,4,5,6,7,8\n"
    for part in folder.parts(text):
        assert f"open '{folder.path / 'data.txt'}?phase=deg'" in part.says


@pytest.mark.parametrize(
    ("alone", "values", "lacks", "others"),
    [
        ("|E*| [MPa]", abs(E), "phase [deg]", ANGLE),
        ("phase [deg]", ANGLE, "|E*| [MPa]", abs(E)),
        ("tan delta [-]", E.imag / E.real, "|E*| [MPa]", abs(E)),
        ("storage [MPa]", E.real, "loss [MPa]", E.imag),
        ("loss [MPa]", E.imag, "storage [MPa]", E.real),
    ],
)
def test_one_quantity_alone_names_the_other_which_mends_it(folder, alone, values, lacks, others):
    text = f"{alone}\n{wide(values)}"
    assert f"add below it a line '{lacks}', and a table with the same names" in folder.complaint(
        text
    )
    is_table(folder.open(f"{text}{lacks}\n{wide(others)}"))


@pytest.mark.parametrize(
    ("alone", "lacks"),
    [
        ("J' [1/MPa]", "J'' [1/MPa]"),
        ("J'' [1/MPa]", "J' [1/MPa]"),
        ("eta' [Pa s]", "eta'' [Pa s]"),
        ("eta'' [Pa s]", "eta' [Pa s]"),
    ],
)
def test_half_a_compliance_or_viscosity_names_its_other_half(folder, alone, lacks):
    text = f"{alone}\n{wide(abs(E))}"
    assert f"add below it a line '{lacks}'" in folder.complaint(text)
    assert len(folder.open(f"{text}{lacks}\n{wide(abs(E))}")) == E.size


def test_a_wide_table_of_nobody_knows_what_shows_how_to_write_it(folder):
    says = folder.complaint(wide(abs(E)))
    shown = re.search(r"a line '([^']+)', below it '([^']+),\.\.\.' .* a line '([^']+)'", says)
    assert shown, says
    assert "temperature [degC]" in shown[2]
    assert "25 Hz" in shown[2]
    is_table(folder.open(f"{shown[1]}\n{wide(abs(E))}{shown[3]}\n{wide(ANGLE)}"))


def test_the_frequency_in_titles_does_not_lack(folder):
    titles = ",".join(f"|E*| {f:g} Hz [MPa]" for f in FREQUENCIES)
    says = folder.complaint(wide(abs(E), f"T [degC],{titles}"))
    assert "missing phase [deg] or loss_factor [-]" in says
    assert "missing frequency" not in says


def test_the_same_in_a_workbook(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for line in io.StringIO(BLOCKS):
        book.active.append([_cell(cell) for cell in line.strip().split(",")])
    book.save(tmp_path / "ampt.xlsx")
    is_table(springpot.read(tmp_path / "ampt.xlsx"))
    book.active.delete_rows(1)
    book.save(tmp_path / "unnamed.xlsx")
    with pytest.raises(DataError, match="which quantity they hold"):
        springpot.read(tmp_path / "unnamed.xlsx")


def _cell(text):
    try:
        return float(text)
    except ValueError:
        return text


@pytest.mark.parametrize("size", ["|G*| [Pa]", "|eta*| [Pa s]"])
def test_a_size_without_phase_and_frequency_names_both(folder, size):
    rows = "".join(f"{t},{1000 + t}\n" for t in range(20, 26))
    says = folder.complaint(f"temperature [degC],{size}\n{rows}")
    assert "missing frequency [Hz] or omega [rad/s], and phase [deg] or loss_factor [-]" in says
    assert "columns phase [deg] and frequency [Hz]" in says
    # What it says works: the angle in a column, the frequency in either way.
    angled = "".join(f"{t},{1000 + t},30\n" for t in range(20, 26))
    said = re.search(r"data\.txt(\?[^']+)'", says)[1]
    assert len(folder.open(f"temperature [degC],{size},phase [deg]\n{angled}", said)) == 6


def test_a_size_without_phase_is_not_mended_by_the_loss(folder):
    says = folder.complaint("omega [rad/s],|G*| [Pa]\n1,2\n2,3\n3,4\n")
    assert "missing phase [deg] or loss_factor [-]; export the phase angle" in says
    assert "loss [unit]" not in says


def of_specimens(parts):
    """Storage and loss of specimens, 1000 and 100 times their numbers; no loss of the first."""
    lines = ["frequency [Hz],sample,quantity,value [Pa]"]
    for number, name in enumerate(parts, 1):
        for hertz in (1, 2, 4):
            lines.append(f"{hertz},{name},G',{1000 * number}")
            if number > 1:
                lines.append(f"{hertz},{name},G'',{100 * number}")
    return "\n".join(lines) + "\n"


def test_the_storage_of_a_specimen_without_a_loss_is_not_put_beside_that_of_another(folder):
    found = folder.open(of_specimens("ABC"))
    assert found.labels["sample"].tolist() == ["B"] * 3 + ["C"] * 3
    np.testing.assert_allclose(found.storage, 10.0 * found.loss)


def test_rows_without_a_word_do_not_hide_the_specimens(folder):
    both = of_specimens("ABC") + "1,A,G'',100\n2,A,G'',100\n4,A,G'',100\n8,C,,7\n"
    assert sorted(set(folder.open(both).labels["sample"])) == ["A", "B", "C"]


@pytest.mark.parametrize("more", ["", "2,tan(delta),0.1\n"])
def test_values_that_nothing_tells_apart_are_not_paired_by_their_order(folder, more):
    text = (
        f"frequency [Hz],quantity,value [Pa]\n1,G',10\n1,G',20\n1,G'',2\n2,G',11\n2,G'',1\n{more}"
    )
    with pytest.raises(
        DataError, match=r"at frequency \[Hz\] 1 there are 2 values of G' \[Pa\] and 1 of G''"
    ):
        folder.open(text)


@pytest.mark.parametrize("second", ["storage Modulus,30,Pa", "Storage modulus,0.03,kPa"])
def test_a_quantity_by_two_names_or_in_two_units_is_told(folder, second):
    text = (
        "frequency [Hz],what,value,unit\n"
        f"1,Storage modulus,10,Pa\n1,Loss,1,Pa\n2,{second}\n2,Loss,2,Pa\n"
    )
    with pytest.raises(DataError, match="are both storage; call it by one name, in one unit"):
        folder.open(text)


@pytest.mark.parametrize("names", [["remark"], []])
def test_remarks_beside_some_rows_of_a_sheet_lose_none_of_them(tmp_path, names):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["omega [rad/s]", "quantity", "value [Pa]", *names])
    for i, (omega, value) in enumerate(zip(OMEGA.tolist(), G.tolist(), strict=True)):
        book.active.append([omega, "G'", value.real, "slipped" if i == 1 else None])
        book.active.append([omega, "G''", value.imag])
    book.save(tmp_path / "sheet.xlsx")
    is_sweep(springpot.read(tmp_path / "sheet.xlsx"))
