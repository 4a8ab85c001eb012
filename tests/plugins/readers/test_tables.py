"""Generic tables: names, symbols, units and signs of any kind.

What is left open is asked for, never guessed.
"""

import re

import numpy as np
import pytest

import springpot
from springpot.errors import DataError

from .samples import OMEGA, STIFFNESS, moduli, rows, table

HERTZ = OMEGA / (2 * np.pi)


def same(found, stiffness=STIFFNESS, unit="Pa"):
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-10)
    np.testing.assert_allclose(found.stiffness, stiffness, rtol=1e-10)
    assert found.units.stiffness == unit


HEADERS = [
    "Angular frequency / rad/s,Storage modulus / Pa,Loss modulus / Pa",
    "Angular Frequency (rad/s),Storage Modulus (Pa),Loss Modulus (Pa)",
    "Angular frequency_rad/s,Storage modulus_Pa,Loss modulus_Pa",
    "omega_rad/s,Gp_Pa,Gpp_Pa",
    "omega_rad_s,storage_Pa,loss_Pa",
    "angular_frequency_rad_per_s,storage_modulus_pa,loss_modulus_pa",
    "ω [rad/s],G' [Pa],G'' [Pa]",
    "ω [rad/s],G′ [Pa],G″ [Pa]",
    "ω [rad/s],G' [Pa],G\" [Pa]",
    "w (rad/s),G_prime (Pa),G_double_prime (Pa)",
    "w [1/s],E_stor [Pa],E_loss [Pa]".replace("1/s", "rad s^-1"),
    "ω / rad·s⁻¹,G' / Pa,G'' / Pa",
    "omega [rad s-1],G' [Pa],G'' [Pa]",
    "Storage modulus G' is next,omega [rad/s],G' [Pa],G'' [Pa]".partition(",")[2],
    "Pulsation [rad/s],Module de conservation G' [Pa],Module de perte G'' [Pa]",
    "Fréquence angulaire (rad/s),Module de Stockage (Pa),Module de Perte (Pa)",
    "Kreisfrequenz in rad/s,Speichermodul in Pa,Verlustmodul in Pa",
    "Frecuencia angular [rad/s],Módulo de almacenamiento [Pa],Módulo de pérdida [Pa]",
    "角周波数 [rad/s],貯蔵弾性率 [Pa],損失弾性率 [Pa]",
    "Kreisfrequenz [1/s],Speichermodul [Pa],Verlustmodul [Pa]",
    "Frequenza angolare [rad/s],Modulo di conservazione [Pa],Modulo dissipativo [Pa]",
]


@pytest.mark.parametrize("header", HEADERS)
def test_names_and_units_in_many_spellings(folder, header):
    same(folder.open(table(header)))


@pytest.mark.parametrize(
    "header",
    [
        "Frequency(Hz),Storage Modulus(Pa),Loss Modulus(Pa)",
        "Fréquence [Hz],Module de Stockage [Pa],Module de Perte [Pa]",
        "Frequenz / Hz,Speichermodul / Pa,Verlustmodul / Pa",
        "Frecuencia (Hz),Módulo elástico (Pa),Módulo viscoso (Pa)",
        "Frequenza (Hz),Modulo conservativo (Pa),Modulo viscoso (Pa)",
        "f Hz,G' Pa,G'' Pa",
        "Frequency (f) [Hz],Storage modulus (G') [Pa],Loss modulus (G'') [Pa]",
    ],
)
def test_hertz_becomes_radians(folder, header):
    same(folder.open(table(header, omega=HERTZ)))


@pytest.mark.parametrize(
    ("separator", "decimal"), [(";", ","), ("\t", ","), (",", "."), (" ", "."), ("|", ",")]
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"])
def test_separators_decimals_and_encodings(folder, separator, decimal, encoding):
    header = separator.join(
        ("Fréquence_angulaire[rad/s]", "Module_de_Stockage[Pa]", "Module_de_Perte[Pa]")
    )
    same(folder.open(table(header, separator, decimal).encode(encoding)))


@pytest.mark.parametrize("second", ["Hz, MPa, MPa", "[Hz],[MPa],[MPa]", "(Hz),(MPa),(MPa)"])
def test_units_on_a_second_row(folder, second):
    text = f"f, E_stor, E_loss\n{second}\n{moduli(omega=HERTZ, scale=1e-6)}\n"
    same(folder.open(text), STIFFNESS * 1e-6, "MPa")


@pytest.mark.parametrize(
    ("unit", "scale"), [("mPa", 1e3), ("MPa", 1e-6), ("kPa", 1e-3), ("psi", 1 / 6894.757293168361)]
)
def test_milli_and_mega_stay_apart(folder, unit, scale):
    found = folder.open(table(f"omega [rad/s],G' [{unit}],G'' [{unit}]", scale=scale))
    same(found, STIFFNESS * scale, unit)


@pytest.mark.parametrize(("unit", "meant"), [("mpa", ("MPa", "mPa")), ("MHz-typo", ("Pa",))])
def test_a_unit_of_unclear_case_is_asked_for(folder, unit, meant):
    content = table(f"omega [rad/s],Storage modulus ({unit}),Loss modulus ({unit})")
    with pytest.raises(DataError, match="unknown unit") as caught:
        folder.open(content)
    typed = re.findall(r"open '[^']*(\?[^']*)'", str(caught.value))
    assert [folder.open(content, said).units.stiffness for said in typed] == list(meant)


def test_mega_hertz_is_no_millihertz(folder):
    with pytest.raises(DataError, match="unknown unit"):
        folder.open(table("Frequency (MHz),Storage modulus (Pa),Loss modulus (Pa)"))


def test_magnitude_and_phase_loss_factor_and_viscosity(folder):
    size, angle = np.abs(STIFFNESS), np.degrees(np.angle(STIFFNESS))
    same(folder.open("ω (rad/s);|G*| (Pa);δ (°)\n" + rows((OMEGA, size, angle), ";")))
    same(
        folder.open(
            "ω (rad/s);Complex modulus (Pa);Tan(delta)\n"
            + rows((OMEGA, size, np.tan(np.angle(STIFFNESS))), ";")
        )
    )
    same(
        folder.open(
            "ω (rad/s);|η*| (mPa·s);Phase angle (°)\n"
            + rows((OMEGA, 1e3 * size / OMEGA, angle), ";")
        )
    )


def test_storage_and_loss_go_before_what_follows_from_them(folder):
    size, angle = np.abs(STIFFNESS) * 7, np.degrees(np.angle(STIFFNESS)) / 3
    text = "f (Hz);ω (rad/s);|G*| (Pa);δ (°);G' (Pa);G'' (Pa)\n"
    found = folder.open(
        text + rows((HERTZ, OMEGA, size, angle, STIFFNESS.real, STIFFNESS.imag), ";")
    )
    same(found)
    assert not found.conditions


def test_temperature_strain_and_other_columns(folder):
    text = "omega_rad_s,storage_Pa,loss_Pa,temperature_C,shear_strain_amp,rep,current_A,run\n"
    text += "1,2,3,20,0.01,1,0.5,a\n1,2,3,20,0.01,2,0.6,b\n"
    found = folder.open(text)
    assert found.conditions["temperature"].tolist() == [20, 20]
    assert found.conditions["amplitude"].tolist() == [0.01, 0.01]
    assert found.units.amplitude == "-"
    assert found.repeat.tolist() == [1, 2]
    assert found.labels["run"].tolist() == ["a", "b"]
    assert found.conditions["current_a"].tolist() == [0.5, 0.6]


def test_a_sweep_with_time_angle_and_torque_is_no_time_signal(folder):
    head = "Time (s),Displacement (rad),Torque (N m),omega (rad/s),G' (Pa),G'' (Pa)\n1,1,1,"
    assert folder.open(head + "2,3,4\n").stiffness.tolist() == [3 + 4j]
    head = "omega [rad/s],storage [Pa],loss [Pa],time [s],displacement [rad],torque [N m]\n"
    assert folder.reader(head + "1,2,3,4,5,6\n") == "springpot-csv"


def test_standard_uncertainties(folder):
    head = "omega_rad_s,storage_Pa,loss_Pa,storage_std_unc_Pa,loss_standard_uncertainty_pa\n"
    assert folder.open(head + "1,2,3,0.1,0.2\n").sd[0] == 0.1 + 0.2j


def test_rows_without_a_value_are_left_out_and_counted(folder):
    found = folder.open("omega [rad/s];G' [Pa];G'' [Pa]\n1;2;3\n2;;3\n3;---;1\n4;5;6\n")
    assert found.omega.tolist() == [1, 4]
    assert found.provenance["note rows"].startswith("2 of 4 rows")


def test_the_header_of_a_numpy_text_file(folder):
    same(folder.open("# omega[rad/s] G'[Pa] G''[Pa]\n" + moduli(" ")))


def test_lines_above_the_table_are_kept_where_they_are_known(folder):
    found = folder.open(
        "Sample name: a gel\nGap: 1 mm\n\n" + table("omega [rad/s];G' [Pa];G'' [Pa]", ";")
    )
    assert found.provenance["sample"] == "a gel"
    assert found.provenance["geometry.gap"] == "1 mm"


CLOCK = "it is rad/s, open '{}?frequency=rad/s', or write omega [rad/s] in it"
WITHOUT_UNITS = {
    "frequency": ("Frequency,Storage modulus [Pa],Loss modulus [Pa]", ""),
    "everything": ("f,E_stor,E_loss", "storage=Pa,loss=Pa"),
    "a stiffness in one title alone": ("Freq,Kp,Kpp", "storage=N/mm,loss=N/mm"),
}


@pytest.mark.parametrize("case", WITHOUT_UNITS)
def test_what_a_missing_unit_is_taken_for_is_told_with_the_option_that_mends_it(folder, case):
    header, said = WITHOUT_UNITS[case]
    path = folder.write(table(header))
    found = folder.open(table(header))
    np.testing.assert_allclose(found.omega, OMEGA * 2 * np.pi, rtol=1e-10)
    assert found.provenance["note clock"].endswith(CLOCK.format(path))
    assert f"?{said}'" in found.provenance.get("note units", "?'")
    again = folder.open(table(header), f"?{','.join(filter(None, [said, 'frequency=rad/s']))}")
    np.testing.assert_allclose(again.omega, OMEGA, rtol=1e-10)
    assert not {"note clock", "note units"} & again.provenance.keys()


def test_the_same_file_in_another_unit(folder):
    found = folder.open(table("Frequency,G',G''"), "?frequency=rad/s,G'=MPa,3=MPa")
    same(found, STIFFNESS, "MPa")


BARE = "?1=omega[rad/s],2=storage[Pa],3=loss[Pa]"


@pytest.mark.parametrize("separator", [" ", "\t", ",", ";"])
def test_columns_without_names_are_asked_for(folder, separator):
    with pytest.raises(DataError, match=r"3 columns of numbers without names.*1=omega\[rad/s\]"):
        folder.open(moduli(separator))
    same(folder.open(moduli(separator), BARE))


def test_nothing_behind_the_last_separator_is_no_column(folder):
    """As programs end each line; a gap in one row is none of it."""
    ended = "".join(f"{line},\n" for line in moduli(",").splitlines())
    with pytest.raises(DataError, match="3 columns of numbers without names"):
        folder.open(ended)
    same(folder.open(ended, BARE))


def test_names_that_lack_the_separator_before_each_row_are_names(folder):
    """Not columns of numbers without names, one of them empty."""
    text = "\t".join(("sample A (rad/s)", "run 1", "run 2")) + "\n"
    text += "".join(f"\t{line}\n" for line in moduli("\t").splitlines())
    with pytest.raises(DataError, match=r"among the columns sample A \(rad/s\), run 1, run 2"):
        folder.open(text)
    same(folder.open(text, BARE))


def test_a_row_of_fewer_separators_than_are_empty_in_front_is_told(folder):
    text = "".join(f";;;{line}\n" for line in moduli(";").splitlines())
    with pytest.raises(DataError, match=r"line \d+: 0 cells where the first row has 3"):
        folder.open(text + ";\n")


def test_units_below_names_of_no_meaning_may_leave_one_out(folder):
    """A column of numbers without a unit, as of rows: the others keep theirs."""
    text = "No;w2;w3;w4\n;Hz;kPa;kPa\n1;2;3;4\n2;3;4;5\n3;4;5;6\n"
    found = folder.open(text, "?w2=frequency,w3=storage,w4=loss")
    assert found.units.stiffness == "kPa"
    np.testing.assert_allclose(found.omega, 2.0 * np.pi * np.array([2.0, 3.0, 4.0]))


def test_weights_may_be_left_out_or_named(folder):
    text = rows((OMEGA, STIFFNESS.real, STIFFNESS.imag, 0 * OMEGA + 2, 0 * OMEGA + 3), " ")
    with pytest.raises(DataError, match="weights"):
        folder.open(text)
    same(folder.open(text, BARE))
    assert folder.open(text, BARE + ",4=storage_sd[Pa],5=loss_sd[Pa]").sd[0] == 2 + 3j


def test_a_constant_frequency_can_be_said(folder):
    found = folder.open("G' [Pa];G'' [Pa];Strain [%]\n2;3;1\n4;5;2\n", "?frequency=2[Hz]")
    np.testing.assert_allclose(found.omega, 4 * np.pi)
    assert found.units.amplitude == "%"


def test_several_tables_in_one_file(folder):
    one = table("omega [rad/s];G' [Pa];G'' [Pa]", ";")
    text = "first\n" + one + "\nsecond\n" + one
    assert [part.name for part in folder.parts(text)] == ["first", "second"]
    both = folder.open(text)
    assert len(both) == 10
    assert set(both.labels["step"]) == {"first", "second"}
    assert len(folder.open(text, "@step=second")) == 5
    same(folder.open(text, "#2"))
    same(folder.open(text, "#second"))
    assert len(folder.open(text, "#1-2")) == 10


REFUSED = {
    "shift factors": ("T,log_aT\nC,-\n100,-11.7\n92,-10.9\n", "shift factors, no measurement"),
    "relaxation": ("t,E_relax,T,Set\n10,8097,-49,0\n4,8576,-49,0\n", "a relaxation test in time"),
    "flow": (
        "Shear rate [1/s],Viscosity [Pa.s],Temperature [°C]\n1,2,3\n",
        "steady flow, no dynamic test; give a sweep, a creep or a relaxation of it",
    ),
    "flow by one name": ("Shear Rate,Stress\n1,2\n10,3\n", "steady flow, no dynamic test"),
    "peaks of a damper": (
        "Piston speed [mm/s],Rebound force [N]\n50,310\n100,520\n300,900\n",
        "force over velocity, as of the peaks of many strokes: no dynamic test; give the strokes",
    ),
    "a column by itself": (
        "1\n1.25\n1.5\n1.75\n",
        "a single column of numbers; put what belongs together side by side",
    ),
    "neither": (
        "Zeit [s];Temperatur [°C];Normalkraft [N]\n1;2;3\n",
        r"missing frequency \[Hz\] or omega \[rad/s\], and storage",
    ),
    "no loss": (
        "omega [rad/s];Speichermodul [Pa];Temperatur [°C]\n1;2;3\n",
        r"missing loss \[unit\], phase \[deg\] or loss_factor",
    ),
    "unknown names": (
        "a,b,c\n1,2,3\n4,5,6\n",
        r"columns a, b, c; say which, .*NAME=frequency\[Hz\]",
    ),
    "ragged": (
        "omega (rad/s);G' (Pa);G'' (Pa)\n1;2;3\n1;2;3;4\n",
        "line 3: 4 cells where the header has 3",
    ),
    "two signs": (
        "omega (rad/s);G' (Pa);G'' (Pa)\n1;2,5;3\n2;2.5;3\n",
        "have comma and point; write one decimal sign",
    ),
    "words": ("omega (rad/s);G' (Pa);G'' (Pa)\n1;2;3\n2;about 4;3\n", "'about 4' is no number"),
    "a word with a point": (
        "omega (rad/s);G' (Pa);G'' (Pa)\n1;2,5;3\n2;ca.;3\n",
        "'ca.' is no num",
    ),
    "footer": (
        "omega (rad/s);G' (Pa);G'' (Pa)\n1;2;3\nmean 7\n8\n",
        "below the table is no row of it",
    ),
    "contradiction": ("omega (Hz);G' (Pa);G'' (Pa)\n1;2;3\n", "omega is in rad/s"),
}


@pytest.mark.parametrize("word", ["n.a.", "k.A.", "#WERT!", "#NUM!"])
def test_a_word_for_no_value_leaves_its_row_out(folder, word):
    found = folder.open(f"omega (rad/s);G' (Pa);G'' (Pa)\n1;2,5;3\n2;{word};{word}\n4;5,5;3\n")
    np.testing.assert_array_equal(found.omega, [1.0, 4.0])
    np.testing.assert_array_equal(found.storage, [2.5, 5.5])


def test_a_proposal_says_the_unit_of_the_frequency_too(folder):
    """Typed as it stands it opens the file: nothing else is asked for then."""
    text = "f,K1,K2\n1,100,40\n2,120,50\n"
    with pytest.raises(DataError) as caught:
        folder.open(text)
    said = re.search(r"open '.*(\?.*)'", str(caught.value))
    assert said is not None
    assert folder.open(text, said=said[1]).units.stiffness == "N/mm"


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_gets_one_line(folder, case):
    text, message = REFUSED[case]
    with pytest.raises(DataError, match=message) as caught:
        folder.open(text)
    assert "\n" not in str(caught.value)
    assert "data.txt" in str(caught.value)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("?", "says nothing of a column"),
        ("?frequency", "says nothing of a column"),
        ("?frequency=", "says nothing of a column"),
        ("?frequency=Hz,frequency=Hz", "given twice"),
        ("?temp=20", r"'temp=20' has no unit: open '.*\?temp=20\[degC\]', or with another unit"),
        ("?omega=bananas", "neither a unit nor one of"),
        ("?nothing=Pa", "no column 'nothing'"),
        ("?9=Pa", "no column '9'"),
        ("#", "number or name of a part"),
        ("#2", "no part 2; it has 1"),
        ("#x", "no part is called 'x'"),
    ],
)
def test_slips_in_what_is_said(folder, said, message):
    with pytest.raises(DataError, match=message) as caught:
        folder.open(table("omega [rad/s];G' [Pa];G'' [Pa]", ";"), said)
    assert "\n" not in str(caught.value)


def test_a_file_whose_name_has_the_signs_of_a_choice(folder):
    for name in ("run#2.csv", "is it?x=1.csv", "a#b?c=d@e.csv"):
        same(folder.open(table("omega [rad/s],storage [Pa],loss [Pa]"), name=name))


@pytest.mark.soak
def test_a_hundred_thousand_rows_in_any_separator(folder):
    n = 100_000
    columns = (np.arange(1, n + 1), np.ones(n), np.full(n, 2.5))
    found = folder.open("ω (rad/s);G' (Pa);G'' (Pa)\n" + rows(columns, ";", ","))
    assert len(found) == n
    assert found.stiffness[-1] == 1 + 2.5j


@pytest.mark.parametrize(
    ("row", "header", "says"),
    [
        (
            "2,0,0",
            "frequency [Hz],storage [Pa],loss [Pa]",
            r"line 3, column 'storage \[Pa\]': storage and loss are both zero",
        ),
        ("2,0,0", "freq [Hz],G' [Pa],G'' [Pa]", "line 3, .*both zero.*leave out the row$"),
        (
            "2,1,1",
            "frequency [Hz],storage [Pa],loss [Pa],temperture [degC]",
            r"column 'temperture \[degC\]': .*nearly",
        ),
    ],
)
def test_what_was_not_measured_or_is_misspelt_is_told_with_its_place(tmp_path, row, header, says):
    path = tmp_path / "table.csv"
    extra = ",20" * (header.count(",") - 2)
    path.write_text(f"{header}\n1,3,1{extra}\n{row}{extra}\n3,4,1{extra}\n")
    with pytest.raises(DataError, match=says):
        springpot.read(path)


def test_two_tables_without_titles_one_below_the_other_are_told_what_they_lack(folder):
    """No column 3 is asked for where there are two."""
    blocks = "0.5\t3.07\n1\t7.02\n5\t42.9\n\t\n\t\n0.5\t9.78\n1\t20.7\n5\t20.7\n"
    with pytest.raises(
        DataError, match=r"2 columns of numbers without names.*titles above each.*Hz\]<TAB>G'"
    ) as refused:
        folder.open(blocks)
    assert "3=loss" not in str(refused.value)
    titled = (
        "frequency [Hz]\tG' [Pa]\n0.5\t3.07\n1\t7.02\n\n"
        'frequency [Hz]\tG" [Pa]\n0.5\t9.78\n1\t20.7\n'
    )
    assert folder.open(titled).loss.tolist() == [9.78, 20.7]


@pytest.mark.parametrize(
    "head",
    ["#;omega [rad/s];G' [Pa];G'' [Pa]", "#;omega;G';G''\n;rad/s;Pa;Pa"],
)
def test_a_counter_called_by_the_sign_of_a_comment_moves_no_column(head, folder):
    found = folder.open(f"{head}\n1;0.5;5;2.6\n2;0.8;8;3.1\n3;2;10;3.4\n")
    np.testing.assert_allclose(found.omega, [0.5, 0.8, 2.0])
    np.testing.assert_allclose(found.stiffness, [5 + 2.6j, 8 + 3.1j, 10 + 3.4j])


def test_a_row_of_units_begins_with_that_of_a_strain(folder):
    found = folder.open("Strain;omega;G';G''\n%;rad/s;Pa;Pa\n0.1;0.5;5;0.2\n0.1;0.8;8;0.3\n")
    np.testing.assert_allclose(found.conditions["amplitude"], 0.1)
    assert found.units.amplitude == "%"
