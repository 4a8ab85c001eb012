"""What a header says of its numbers is neither lost nor taken for another quantity in silence."""

import re

import numpy as np
import pytest

from springpot.cli.inspection import described
from springpot.errors import DataError
from springpot.registry import open_in_time, open_measurement, parts_of
from springpot.report.inspection import next_step

TIME, MODULUS = (0.5, 1.0, 2.0, 4.0, 8.0), (900.0, 800.0, 700.0, 600.0, 500.0)
MOVED, PULLED = (1.0, 2.0, 3.0, 2.0, 1.0), (30.0, 60.0, 80.0, 50.0, 20.0)


def rows(*columns):
    return "\n".join(",".join(map(str, row)) for row in zip(*columns, strict=True))


def put(folder, names, *columns):
    path = folder / "test.csv"
    path.write_text(f"{names}\n{rows(*columns)}\n".lstrip("\n"), encoding="utf-8")
    return path


def asked(path, opens=open_in_time):
    """What is asked of a file, with the files to open as they are printed."""
    with pytest.raises(DataError) as caught:
        opens(path)
    assert "\n" not in str(caught.value)
    return str(caught.value), re.findall(rf"'({re.escape(str(path))}\?[^']*)'", str(caught.value))


@pytest.mark.parametrize("name", ["log time [s]", "Log Time (s)", "log_time_s", "log(t/s)"])
def test_a_channel_that_is_a_logarithm_is_asked_for_its_base(tmp_path, name):
    path = put(tmp_path, f"{name},G(t) [Pa]", (0, 1, 2, 3, 4), MODULUS)
    says, [hint] = asked(path)
    assert "base 10 or e" in says
    [test] = open_in_time(hint)
    np.testing.assert_allclose(test.time, [1.0, 10.0, 100.0, 1e3, 1e4])


def test_the_base_of_a_logarithm_of_a_channel_is_read_with_its_unit(tmp_path):
    names, logs = "log10 time (min),ln force (N),displacement [mm]", (0.0, 1.0, 2.0)
    [test] = open_in_time(put(tmp_path, names, logs, logs, logs))
    np.testing.assert_allclose(test.time, [60.0, 600.0, 6000.0])
    np.testing.assert_allclose(test.response, np.exp(logs))
    [test] = open_in_time(put(tmp_path, "Logger time [s],G(t) [Pa]", TIME, MODULUS))
    np.testing.assert_allclose(test.time, TIME)


@pytest.mark.parametrize("fill", ["-999", "-9999.0", "-999.25", "−99999"])
def test_a_fill_value_among_positive_ones_is_no_measurement(tmp_path, fill):
    [test] = open_in_time(put(tmp_path, "t [s],G(t) [Pa]", (1, 2, 3), (5, fill, 4)))
    assert test.response.tolist() == [5.0, 4.0]
    assert test.provenance["note rows"].startswith("1 of 3 rows without a measured value")
    columns = (1, 2, 3), (5, fill, 4), (2, fill, 3), (20, fill, 20)
    swept = open_measurement(put(tmp_path, "omega [rad/s],G' [Pa],G'' [Pa],T [degC]", *columns))
    assert swept.stiffness.tolist() == [5 + 2j, 4 + 3j]
    assert swept.conditions["temperature"].tolist() == [20.0, 20.0]


def test_a_force_of_both_signs_may_well_be_minus_999(tmp_path):
    names, forces = "time [s],displacement [mm],force [N]", (30.0, -60.0, -999, 50.0, 20.0)
    [test] = open_in_time(put(tmp_path, names, TIME, MOVED, forces))
    assert test.response.tolist() == list(forces)


def test_a_second_sensor_is_told(tmp_path):
    names = "time [s],displacement [mm],force1 [N],force2 [N]"
    path = put(tmp_path, names, TIME, MOVED, PULLED, MODULUS)
    [test] = open_in_time(path)
    assert test.response.tolist() == list(PULLED)
    assert test.provenance["note spare columns"] == "force is 'force1 [N]', not 'force2 [N]'"
    [other] = open_in_time(f"{path}?4=force[N]")
    assert other.response.tolist() == list(MODULUS)
    assert "note spare columns" not in other.provenance
    twice = put(tmp_path, "f [Hz],G' [Pa],G' [Pa],G'' [Pa]", TIME, MODULUS, PULLED, MOVED)
    told = open_measurement(twice).provenance["note spare columns"]
    assert told == "storage is 'G' [Pa]', not 'G' [Pa]'"


def test_a_modulus_beside_a_stiffness_is_told(tmp_path):
    names = "f [Hz],K' [N/mm],K'' [N/mm],E' [MPa],E'' [MPa],K' [N/m]"
    path = put(tmp_path, names, TIME, MODULUS, PULLED, MOVED, MOVED, TIME)
    told = open_measurement(path).provenance["note spare columns"]
    assert told == "storage is 'K' [N/mm]', not 'E' [MPa]'; loss is 'K'' [N/mm]', not 'E'' [MPa]'"


def test_one_row_of_numbers_is_not_both_hertz_and_radians(tmp_path):
    path = put(tmp_path, "f [Hz],omega [rad/s],G' [Pa],G'' [Pa]", TIME, TIME, MODULUS, PULLED)
    says, hints = asked(path, open_measurement)
    assert "wrong by 2 pi" in says
    in_hertz, in_radians = open_measurement(hints[1]), open_measurement(hints[0])
    np.testing.assert_allclose(in_radians.omega, TIME)
    np.testing.assert_allclose(in_hertz.omega, 2.0 * np.pi * np.array(TIME))


def test_degrees_under_the_unit_of_radians_are_asked_for(tmp_path):
    path = put(tmp_path, "f [Hz],|G*| [Pa],delta [rad]", TIME, MODULUS, (12, 13, 14, 15, 16))
    says, [hint] = asked(path, open_measurement)
    assert "12 rad is more than a cycle" in says
    assert open_measurement(hint).storage[0] == pytest.approx(900.0 * np.cos(np.radians(12.0)))


@pytest.mark.parametrize(
    "names", ["time [s],jaw,stress [MPa]", "time [s],strain rate [1/s],force [N]"]
)
def test_no_unknown_column_is_proposed_as_a_modulus(tmp_path, names):
    says, hints = asked(put(tmp_path, names, TIME, MOVED, PULLED))
    assert "a force without a displacement is no test" in says
    assert all("?NAME=" in hint for hint in hints)


def test_columns_that_nobody_knows_are_not_called_a_displacement(tmp_path):
    says, _ = asked(put(tmp_path, "time [s],G(t)/G(0) [-]", TIME, MODULUS))
    assert "no column of what was measured" in says


def test_a_loop_without_its_time_is_asked_for_the_rate_of_its_samples(tmp_path):
    says, [hint] = asked(put(tmp_path, "displacement [mm],force [N]", MOVED, PULLED))
    assert "without their time" in says
    [test] = open_in_time(hint)
    np.testing.assert_allclose(test.time, 1e-3 * np.arange(5))
    np.testing.assert_allclose(test.response, PULLED)


@pytest.mark.parametrize("names", ["", "X,Y", "aa,bb"])
def test_columns_without_known_names_may_be_a_test_in_time(tmp_path, names):
    path = put(tmp_path, names, TIME, MODULUS)
    _, hints = asked(path, open_measurement)
    hint = hints[-1].replace("NAME", "1", 1).replace("NAME", "2", 1)
    [test] = open_in_time(hint)
    assert (test.kind, test.response.tolist()) == ("relaxation", list(MODULUS))


PARTED = {
    "t [s];G(t) [Pa]\n1,5;1.234\n2,5;1.134": ((1.5, 2.5), (1234.0, 1134.0)),
    "t [s]\tG(t) [Pa]\n1,500\t900.2\n2,500\t800.3": ((1500.0, 2500.0), (900.2, 800.3)),
    "t [s];G(t) [Pa]\n500;1,900\n1000;1,800": ((500.0, 1000.0), (1.9, 1.8)),
}


@pytest.mark.parametrize("text", PARTED)
def test_what_may_part_thousands_is_told(tmp_path, text):
    [test] = open_in_time(put(tmp_path, text))
    assert (tuple(test.time), tuple(test.response)) == PARTED[text]
    assert re.search(r"'1[.,]\d00' is read as|'1.234' is", test.provenance["note thousands"])


def test_decimals_by_one_sign_need_no_note(tmp_path):
    for text in (
        "t [s];G(t) [Pa]\n0,125;1,250\n1,250;0,125",
        "t [s],G(t) [Pa]\n0.5,1.234\n1,1.134",
    ):
        [test] = open_in_time(put(tmp_path, text))
        assert "note thousands" not in test.provenance


def test_a_factor_in_the_name_of_a_channel_is_not_lost(tmp_path):
    path = put(tmp_path, "time [s],displacement [mm],force x1000 [N]", TIME, MOVED, PULLED)
    assert "a displacement without a force" in asked(path)[0]
    path = put(tmp_path, "time [s],displacement [mm],force [10^3 N]", TIME, MOVED, PULLED)
    assert open_in_time(path)[0].units.stiffness == "kN/mm"


def test_the_letter_of_a_modulus_is_no_base_of_its_logarithm(tmp_path):
    path = put(tmp_path, "f [Hz],log E' [MPa],log E'' [MPa]", TIME, MOVED, MOVED)
    says, [hint] = asked(path, open_measurement)
    assert "base 10 or e" in says
    np.testing.assert_allclose(open_measurement(hint).storage, np.power(10.0, MOVED))


@pytest.mark.parametrize(("unit", "near"), [("kg", "kgf"), ("gf", "kgf")])
def test_an_unknown_unit_of_a_record_is_named(tmp_path, unit, near):
    names = f"time [s],displacement [mm],force [{unit}]"
    says, _ = asked(put(tmp_path, names, TIME, MOVED, PULLED))
    assert f"unknown unit [{unit}] for force: did you mean [{near}]" in says


def test_what_is_offered_for_curves_side_by_side_opens_all_of_them(tmp_path):
    names = "20 °C,,,40 °C,,\nf [Hz],E1 [MPa],E2 [MPa],f [Hz],E1 [MPa],E2 [MPa]"
    path = put(tmp_path, names, TIME, MODULUS, PULLED, TIME, PULLED, MOVED)
    _, [hint] = asked(path, open_measurement)
    for each in (hint, f"{path}?E1=storage[MPa],E2=loss[MPa]"):
        opened = open_measurement(each)
        assert opened.conditions["temperature"].tolist() == [20.0] * 5 + [40.0] * 5
        assert opened.stiffness.real.tolist() == [*MODULUS, *PULLED]
    one = open_measurement(f"{path}?2=storage[MPa],3=loss[MPa]")
    assert one.stiffness.real.tolist() == list(MODULUS)
    assert "of which number 2 is taken" in one.provenance["note columns"]


@pytest.mark.parametrize("again", ["Page 2 Lab report\n", "f[Hz] G'[kPa] G\"[kPa] T[C]\n", ""])
def test_the_head_of_a_page_within_a_table_loses_nothing(tmp_path, again):
    names, pages = "Page 1 Lab report\nf[Hz] G'[kPa] G\"[kPa] T[C]\n", "Page 2 Lab report\n"
    first, second, third = (rows((f, f), (9, 8), (4, 3), (20, 20)) for f in (1, 2, 4))
    text = f"{names}{first}\n{pages}{again}{second}\n{again or pages}{names}{third}\n"
    path = put(tmp_path, text.replace(",", " "))
    assert np.unique(open_measurement(path).frequency).tolist() == [1.0, 2.0, 4.0]


def test_frequency_and_temperature_by_their_letters_are_no_channels_of_a_record(tmp_path):
    names = "f(Hz),T(°C),Ddyn(m),Fdyn(N),K(N/m),phase(°)"
    path = put(tmp_path, names, TIME, PULLED, MOVED, MODULUS, MODULUS, PULLED)
    found = open_measurement(path)
    np.testing.assert_allclose(np.abs(found.stiffness), np.divide(MODULUS, MOVED))
    assert found.conditions["amplitude"].tolist() == list(MOVED)
    said = open_measurement(f"{path}?K=magnitude")
    np.testing.assert_allclose(np.abs(said.stiffness), MODULUS)


def test_units_behind_each_number_of_a_record_are_read(tmp_path):
    moved, pulled = ([f"{x} {unit}" for x in xs] for xs, unit in ((MOVED, "mm"), (PULLED, "N")))
    path = put(tmp_path, "Time [s],Disp,Force", TIME, moved, pulled)
    [test] = open_in_time(path)
    assert test.response.tolist() == list(PULLED)
    swept = put(tmp_path, "f,G',G''", [f"{f} Hz" for f in TIME], pulled, pulled)
    swept.write_text(swept.read_text(encoding="utf-8").replace(" N", " kPa"), encoding="utf-8")
    assert open_measurement(swept).frequency.tolist() == list(TIME)
    mixed = put(tmp_path, "Time [s],Disp,Force [kN]", TIME, moved, pulled)
    with pytest.raises(DataError, match=r"'30.0 N' is no number"):
        open_in_time(mixed)


def test_a_title_with_single_blanks_between_blanks_is_one(tmp_path):
    names = "f/Hz   |K|/dB(re 1 N/m)   phi/deg"
    path = put(tmp_path, f"{names}\n 1  40  45\n 2  60  45")
    np.testing.assert_allclose(np.abs(open_measurement(path).stiffness), [100.0, 1000.0])


def test_a_compliance_is_among_what_a_column_may_be(tmp_path):
    path = put(tmp_path, "t [s],J_1_MPa", TIME, PULLED)
    says, hints = asked(path)
    assert "of a compliance that grows" in says
    [test] = open_in_time(hints[-1].replace("NAME", "J_1_MPa"))
    assert test.kind == "creep"


def test_plus_and_minus_count_an_amplitude_from_the_middle(tmp_path):
    names = "f [Hz],Amplitude ± [mm],Keff [N/mm],xi_eff [%]"
    found = open_measurement(put(tmp_path, names, TIME, MOVED, MODULUS, PULLED))
    assert found.conditions["amplitude"].tolist() == list(MOVED)
    np.testing.assert_allclose(found.loss / found.storage, np.multiply(PULLED, 0.02))


def test_what_a_program_says_to_itself_is_no_name_of_a_test(tmp_path):
    names = "***End_of_Header***\nt [s],x [mm],F [N]"
    [test] = open_in_time(put(tmp_path, names, TIME, MOVED, PULLED))
    assert "part" not in test.provenance


def written(folder, ending, names, *columns):
    """A table as text or in a workbook."""
    if ending == "csv":
        return put(folder, ",".join(names), *columns)
    book = pytest.importorskip("openpyxl").Workbook()
    for row in (names, *zip(*columns, strict=True)):
        book.active.append(row)
    book.save(folder / "test.xlsx")
    return folder / "test.xlsx"


@pytest.mark.parametrize("ending", ["csv", "xlsx"])
def test_curves_side_by_side_whose_titles_nobody_knows_are_told_by_their_number(tmp_path, ending):
    names = ["f [Hz]", "K1 [N/mm]", "Loss angle [deg]"] * 2
    path = written(tmp_path, ending, names, TIME, MODULUS, PULLED, TIME, PULLED, MOVED)
    _, hints = asked(path, open_measurement)
    opened = [open_measurement(hint) for hint in hints]
    assert [len(each) for each in opened] == [10, 10]
    result = described(opened[0], parts_of(hints[0]))
    assert "#1" in next_step(result, hints[0])


@pytest.mark.parametrize("ending", ["csv", "xlsx"])
def test_tests_in_time_side_by_side_of_which_only_the_user_knows_open_all(tmp_path, ending):
    path = written(tmp_path, ending, ["A", "B"] * 2, TIME, MODULUS, TIME, PULLED)
    tests = open_in_time(f"{path}?A=time[s],B=relaxation[MPa]")
    assert [test.response.tolist() for test in tests] == [list(MODULUS), list(PULLED)]
