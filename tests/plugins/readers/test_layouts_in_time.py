"""Every layout of docs/readers.md holds for tests in time as for sweeps, to the last number."""

import io
import re

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.registry import open_in_time, open_measurement

TIME = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
COLD, WARM = 900.0 / TIME**0.25, 400.0 / TIME**0.5
MOVED = np.array([0.0, 1.0, 2.0, 1.0, -1.0])
PULLED = 3.0 * MOVED + 0.5


def lines(*columns, separator=","):
    table = [[f"{value:.12g}" for value in column] for column in columns]
    return "\n".join(separator.join(row) for row in zip(*table, strict=True))


ONE, PAIR = lines(TIME, COLD), lines(TIME, COLD, WARM)
TWICE = lines(TIME, COLD, TIME, WARM)
BELOW = "\n".join(
    f"{t:.12g},{e:.12g},{label}"
    for label, values in (("{0}", COLD), ("{1}", WARM))
    for t, e in zip(TIME, values, strict=True)
)


def opened(folder, text, said="", name="test.csv"):
    path = folder / name
    if isinstance(text, bytes):
        path.write_bytes(text)
    else:
        path.write_text(text, encoding="utf-8")
    return open_in_time(f"{path}{said}")


def are_both(tests, temperatures=(None, None), unit="Pa"):
    assert len(tests) == 2
    for test, values, temperature in zip(tests, (COLD, WARM), temperatures, strict=True):
        np.testing.assert_allclose(test.time, TIME, rtol=1e-10)
        np.testing.assert_allclose(test.response, values, rtol=1e-10)
        assert (test.kind, test.units.stiffness) == ("relaxation", unit)
        assert test.temperature == (None if temperature is None else pytest.approx(temperature))


AT_TEMPERATURES = {
    "in the titles": f"t [s],E(t) 20 °C [Pa],E(t) 40 °C [Pa]\n{PAIR}",
    "in the titles behind the unit": f"time (s),G(t) (Pa) at 20 °C,G(t) (Pa) at 40 °C\n{PAIR}",
    "above the titles": f",20 °C,40 °C\nt [s],E(t) [Pa],E(t) [Pa]\n{PAIR}",
    "above, cells merged, own times": f"20 °C,,40 °C,\nt [s],E(t) [Pa],t [s],E(t) [Pa]\n{TWICE}",
    "its unit in the first cell": f"T [°C],20,40\nt [s],E(t) [Pa],E(t) [Pa]\n{PAIR}",
    "units in a row of their own": f",T = 20 °C,T = 40 °C\nt,E(t),E(t)\ns,Pa,Pa\n{PAIR}",
    "blocks with names": (
        f"T = 20 °C\nt [s],E(t) [Pa]\n{ONE}\n\nT = 40 °C\nt [s],E(t) [Pa]\n{lines(TIME, WARM)}"
    ),
    "blocks with names once": f"t [s],E(t) [Pa]\n20 °C\n{ONE}\n40 °C\n{lines(TIME, WARM)}",
    "in a column": "t [s],relaxation [Pa],T [°C]\n" + BELOW.format(20, 40),
    "in a column with its unit": "t [s],relaxation [Pa],T\n" + BELOW.format("20 °C", "40 °C"),
    "in a column, in kelvin": "t [s],relaxation [Pa],T [K]\n" + BELOW.format(293.15, 313.15),
}


@pytest.mark.parametrize("layout", AT_TEMPERATURES)
def test_curves_at_several_temperatures_are_tests(tmp_path, layout):
    are_both(opened(tmp_path, AT_TEMPERATURES[layout]), (20.0, 40.0))


def test_numbers_above_curves_are_temperatures_where_the_user_says_so(tmp_path):
    text = f",20,40\nt [s],E(t) [Pa],E(t) [Pa]\n{PAIR}"
    are_both(opened(tmp_path, text))
    are_both(opened(tmp_path, text, "?curves=temperature[degC]"), (20.0, 40.0))


OF_SPECIMENS = {
    "titles with names": f"t [s],G_A [Pa],G_B [Pa]\n{PAIR}",
    "repeats": f"t [s],G(t)_1 [Pa],G(t)_2 [Pa]\n{PAIR}",
    "own times": f"t [s],G(t) [Pa],t [s],G(t) [Pa]\n{TWICE}",
    "own times, copies counted": f"t [s],G(t) [Pa],t [s].1,G(t) [Pa].1\n{TWICE}",
    "names above": f"pad A,,pad B,\nt [s],G(t) [Pa],t [s],G(t) [Pa]\n{TWICE}",
    "names below each other": "t [s],relaxation [Pa],specimen\n" + BELOW.format("A", "B"),
    "a set below each other": "t [s],relaxation [Pa],Set\n" + BELOW.format(1, 2),
    "sets with times that fall": "t [s],relaxation [Pa],Set\n"
    + "\n".join([*BELOW.format(1, 2).split("\n")[4::-1], *BELOW.format(1, 2).split("\n")[:4:-1]]),
    "segment and point": "point,t [s],G(t) [Pa]\n"
    + "\n".join(
        f"{k}|{i},{t:.12g},{v:.12g}"
        for k, values in ((1, COLD), (2, WARM))
        for i, (t, v) in enumerate(zip(TIME, values, strict=True))
    ),
}


@pytest.mark.parametrize("order", [[2, 1, 0, 3, 4], [1, 0, 2, 3, 4], [3, 4, 0, 1, 2]])
def test_pairs_of_digitised_curves_are_tests_whatever_the_order_of_their_points(tmp_path, order):
    """Numbers above the pairs were taken for their first row, and X and Y for no numbers."""
    pairs = lines(TIME[order], COLD[order], TIME[::-1], WARM[::-1])
    said = "?X=time[s],Y=relaxation[Pa]"
    are_both(opened(tmp_path, f"20,,40,\nX,Y,X,Y\n{pairs}", said))


def test_runs_that_a_column_tells_apart_are_not_sorted_into_one(tmp_path):
    rows = "10,900,1\n20,800,1\n40,700,1\n1,400,2\n2,300,2\n4,200,2\n"
    first, second = opened(tmp_path, f"t [s],relaxation [Pa],Set\n{rows}")
    np.testing.assert_allclose(first.time, [10.0, 20.0, 40.0])
    np.testing.assert_allclose(second.time, [1.0, 2.0, 4.0])


def test_runs_that_cover_the_same_times_are_not_sorted_into_one(tmp_path):
    text = f"t [s],E(t) [Pa]\n{ONE}\n{lines(TIME, WARM)}"
    with pytest.raises(DataError, match="the time does not rise"):
        opened(tmp_path, text)


@pytest.mark.parametrize("layout", OF_SPECIMENS)
def test_curves_of_several_specimens_are_tests(tmp_path, layout):
    are_both(opened(tmp_path, OF_SPECIMENS[layout]))


def test_records_side_by_side_are_tests(tmp_path):
    names = "time [s],displacement [mm],force [N],time [s],displacement [mm],force [N]"
    rows = lines(TIME, MOVED, PULLED, TIME, MOVED, 2.0 * PULLED)
    first, second = opened(tmp_path, f"A,,,B,,\n{names}\n{rows}")
    np.testing.assert_allclose(second.response, 2.0 * first.response)
    assert (first.provenance["part"], second.provenance["part"]) == ("A", "B")


RELAXATIONS = {
    "t [s],relaxation [kPa]": 1.0,
    "t [s],E [kPa]": 1.0,
    "time [s],G [kPa]": 1.0,
    "time [s],modulus [kPa]": 1.0,
    "time [ms],relaxation modulus [kPa]": 1e-3,
    "Zeit / min,Relaxationsmodul / kPa": 60.0,
    "Time_s_,Relaxation_modulus_kPa_": 1.0,
    "Time..s.,Relaxation.modulus..kPa.": 1.0,
    "t,E_relax\ns,kPa": 1.0,
    "Time,Relaxation\n,modulus\n[s],[kPa]": 1.0,
    "# t [s],G(t) [kPa]": 1.0,
    "t [s],G(t) [10³ Pa]": 1.0,
}


@pytest.mark.parametrize("names", RELAXATIONS)
def test_names_and_units_of_a_relaxation_are_known(tmp_path, names):
    [test] = opened(tmp_path, f"{names}\n{ONE}\n")
    assert (test.kind, test.units.stiffness) == ("relaxation", "kPa")
    np.testing.assert_allclose(test.time, RELAXATIONS[names] * TIME, rtol=1e-10)
    np.testing.assert_allclose(test.response, COLD, rtol=1e-10)


CREEPS = {
    "creep [1/kPa]": "kPa",
    "compliance [1/Gpa]": "GPa",
    "J(t) [Pa^-1]": "Pa",
    "J [1/MPa]": "MPa",
    "Creep compliance (mm^2/N)": "N/mm^2",
    "D(t) [cm^2/dyne]": "dyn/cm^2",
    "Nachgiebigkeit [mm/N]": "N/mm",
}


@pytest.mark.parametrize("name", CREEPS)
def test_a_compliance_is_one_over_the_unit_of_its_modulus(tmp_path, name):
    [test] = opened(tmp_path, f"time [s],{name}\n{ONE}\n")
    assert (test.kind, test.units.stiffness) == ("creep", CREEPS[name])
    np.testing.assert_allclose(test.response, COLD, rtol=1e-10)


@pytest.mark.parametrize(
    ("names", "kind"), [("t,G", "relaxation"), ("time,E", "relaxation"), ("t,J", "creep")]
)
def test_a_letter_against_time_needs_no_unit(tmp_path, names, kind):
    [test] = opened(tmp_path, f"{names}\n{ONE}\n")
    assert test.kind == kind
    np.testing.assert_allclose(test.response, COLD, rtol=1e-10)


@pytest.mark.parametrize("modulus", ["E [MPa]", "E", "relaxation modulus [Pa]"])
def test_a_record_without_units_stands_before_a_modulus_computed_from_it(tmp_path, modulus):
    rows = lines(TIME, MOVED, PULLED, COLD)
    [test] = opened(tmp_path, f"time,strain,stress,{modulus}\n{rows}")
    np.testing.assert_allclose(test.response, PULLED)


def test_a_prefix_that_case_leaves_open_is_asked_for(tmp_path):
    with pytest.raises(DataError, match=r"\[1/mpa\].*did you mean \[1/MPa\] or \[1/mPa\]"):
        opened(tmp_path, f"time [s],compliance [1/mpa]\n{ONE}\n")


AS_WRITTEN = {
    "decimal commas": "t [s];G(t) [Pa]\n" + ONE.replace(",", ";").replace(".", ","),
    "decimal commas between tabs": "t [s]\tG(t) [Pa]\n"
    + lines(TIME, COLD, separator="\t").replace(".", ","),
    "decimal commas between tabs, in hundreds": "t [s]\tG(t) [Pa]\n0,500\t1070,268\n"
    "1,000\t900,000\n2,000\t756,806\n4,000\t636,396\n8,000\t535,134",
    "exponents of Fortran": "t [s],G(t) [Pa]\n" + lines(TIME, COLD).replace("\n", "D+00\n"),
    "logarithms": f"log10 t [s],lg(G(t) / Pa)\n{lines(np.log10(TIME), np.log10(COLD))}",
    "natural logarithms": f"ln t [s],ln G(t) [Pa]\n{lines(np.log(TIME), np.log(COLD))}",
    "deviations": "t [s],G(t) [Pa]\n" + ONE.replace("\n", " ± 3\n") + " ± 3",
    "deviations in a column": f"t [s],G(t) [Pa],±\n{lines(TIME, COLD, 0 * COLD + 3)}",
    "mean and deviation": f"t [s],G(t)_mean [Pa],G(t)_std [Pa]\n{lines(TIME, COLD, 0 * COLD)}",
    "rows counted": "t [s],G(t) [Pa]\n"
    + "\n".join(f"{i},{row}" for i, row in enumerate(ONE.split("\n"), 1)),
    "on its side": f"t [s],{','.join(f'{t:.12g}' for t in TIME)}\n"
    f"G(t) [Pa],{','.join(f'{v:.12g}' for v in COLD)}\n"
    f"stress [Pa],{','.join(f'{v:.12g}' for v in COLD)}",
    "thousands": "t [s];G(t) [Pa]\n0.5;1,070.27\n1.0;900.0\n2.0;756.81\n4.0;636.4\n8;535.14",
    "remarks": "t [s],G(t) [Pa],comment\n" + ONE.replace("\n", ",\n", 4) + ",ok",
    "rows apart": "t [s],G(t) [Pa]\n\n" + ONE.replace("\n", "\n\n"),
}


@pytest.mark.parametrize("style", AS_WRITTEN)
def test_numbers_are_read_however_they_are_written(tmp_path, style):
    [test] = opened(tmp_path, AS_WRITTEN[style])
    np.testing.assert_allclose(test.time, TIME, rtol=1e-9)
    np.testing.assert_allclose(
        test.response, COLD, rtol=1e-4 if "hundreds" in style or style == "thousands" else 1e-9
    )
    assert (test.kind, test.units.stiffness) == ("relaxation", "Pa")


def test_the_base_of_a_mere_log_is_asked_for(tmp_path):
    text = f"log t [s],log G(t) [Pa]\n{lines(np.log10(TIME), np.log10(COLD))}"
    with pytest.raises(DataError, match=r"base 10 or e\?.*\?log=10'"):
        opened(tmp_path, text)
    [test] = opened(tmp_path, text, "?log=10")
    np.testing.assert_allclose(test.response, COLD, rtol=1e-9)


def workbook(sheets):
    from openpyxl import Workbook

    book, stream = Workbook(), io.BytesIO()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(stream)
    return stream.getvalue()


def test_a_sheet_of_a_workbook_is_a_temperature_or_a_specimen(tmp_path):
    head = [["t [s]", "G(t) [Pa]"]]
    cold, warm = (
        [*head, *map(list, zip(TIME.tolist(), values.tolist(), strict=True))]
        for values in (COLD, WARM)
    )
    book = workbook({"20 °C": cold, "40 °C": warm})
    are_both(opened(tmp_path, book, name="a.xlsx"), (20.0, 40.0))
    book = workbook({"Paramètres": [["Matériau", "x"]], "pad 1": cold, "pad 2": warm})
    tests = opened(tmp_path, book, name="b.xlsx")
    are_both(tests)
    assert [test.provenance["part"] for test in tests] == ["pad 1", "pad 2"]
    [second] = opened(tmp_path, book, "#pad 2", name="b.xlsx")
    np.testing.assert_allclose(second.response, WARM)


def test_names_in_row_two_and_units_in_row_three_of_a_sheet(tmp_path):
    rows = zip(TIME.tolist(), PULLED.tolist(), MOVED.tolist(), strict=True)
    head = [["A"] * 3, ["Temps d'essai", "Force standard", "Allongement"], ["s", "N", "mm"]]
    [test] = opened(tmp_path, workbook({"A": [*head, *map(list, rows)]}), name="a.xlsx")
    np.testing.assert_allclose(test.response, PULLED)
    assert (test.kind, test.units.stiffness) == ("history", "N/mm")


def test_a_workbook_whose_names_nobody_knows_asks_for_its_columns_as_text_does(tmp_path):
    numbers = [*map(list, zip(TIME.tolist(), COLD.tolist(), WARM.tolist(), strict=True))]
    for names in ([], [["aa", "bb", "cc"]]):
        book = workbook({"about": [["Operator", "x"]], "pad 1": [*names, *numbers]})
        path = tmp_path / "a.xlsx"
        path.write_bytes(book)
        with pytest.raises(DataError, match=r"of a test in time '.*time\[s\].*relaxation\[Pa\]'"):
            open_measurement(path)
        [test] = open_in_time(f"{path}?1=time[s],2=relaxation[kPa]")
        np.testing.assert_allclose(test.response, COLD)
        swept = open_measurement(f"{path}?1=omega[rad/s],2=storage[Pa],3=loss[Pa]")
        np.testing.assert_allclose(swept.stiffness, COLD + 1j * WARM)
    both = workbook({"pad 1": numbers, "pad 2": [[t, w, c] for t, c, w in numbers]})
    are_both(opened(tmp_path, both, "?1=time[s],2=relaxation[Pa]", name="b.xlsx"))


def test_curves_side_by_side_of_two_names_are_read_by_the_hint_as_it_is_printed(tmp_path):
    path = tmp_path / "digitised.csv"
    rows = [f"{t},{c},{t},{w}" for t, c, w in zip(TIME, COLD, WARM, strict=True)]
    path.write_text("\n".join(["cold,,warm,", "X,Y,X,Y", *rows]), encoding="utf-8")
    with pytest.raises(DataError, match=r"columns X, Y; .*of a test in time '(.*?)'") as refused:
        open_measurement(path)
    hint = re.search(r"in time '(.*?)'", str(refused.value))
    assert hint is not None
    tests = open_in_time(hint[1])
    assert [test.provenance["part"] for test in tests] == ["cold", "warm"]
    for test, values in zip(tests, (COLD, WARM), strict=True):
        np.testing.assert_allclose(test.response, values)


def test_rows_of_one_time_are_left_out_by_one_rule(tmp_path):
    tied = "t [s],G(t) [Pa]\n1,5\n1,6\n2,4\n3,3\n"
    reptate = "Mw=2;T=20;\nt G\n1 5\n1 6\n2 4\n3 3\n"
    for text, name in ((tied, "a.csv"), (reptate, "a.gt")):
        [test] = opened(tmp_path, text, name=name)
        assert (test.time.tolist(), test.response.tolist()) == ([1, 2, 3], [5, 4, 3])
        assert test.provenance["note time"].startswith(
            "1 of 4 rows have the time of the row before"
        )


def test_a_unit_that_is_one_over_another_is_said_as_any_other(tmp_path):
    path = tmp_path / "creep.csv"
    path.write_text("Time,Creep Compliance\n1,2e-6\n2,3e-6\n4,4e-6\n8,5e-6\n16,6e-6\n")
    (test,) = open_in_time(f"{path}?time=s,compliance=1/kPa")
    (in_pascal,) = open_in_time(f"{path}?time=s,compliance=1/Pa")
    assert (test.units.stiffness, in_pascal.units.stiffness) == ("kPa", "Pa")


def as_sweep(folder, text):
    path = folder / "test.csv"
    path.write_text(text, encoding="utf-8")
    return open_measurement(str(path))


LONG = np.geomspace(0.1, 100.0, 9)
ROUND = np.array([0.0, 0.6, 1.0, 0.4, -0.5, -1.1, -0.4, 0.5, 1.2, 0.6, -0.2])


@pytest.mark.parametrize("ending", ["", ", "])
def test_a_loop_without_names_and_time_is_opened_by_its_hint(tmp_path, ending):
    """Load against displacement, as digitised; each line may end in a comma."""
    text = "\n".join(f"{x:.12g}, {2.0 * x + 0.3:.12g}{ending}" for x in ROUND)
    with pytest.raises(DataError, match=r"goes back and forth, as a displacement") as asked:
        as_sweep(tmp_path, text)
    hint = re.search(r"'\S*(\?1=displacement\[mm\],2=force\[N\],rate=100\[Hz\])'", str(asked.value))
    assert hint is not None
    [test] = opened(tmp_path, text, hint[1])
    np.testing.assert_allclose(test.loading.value, ROUND, atol=1e-15)
    np.testing.assert_allclose(test.loading.time, 0.01 * np.arange(len(ROUND)), atol=1e-15)
    np.testing.assert_allclose(test.response, 2.0 * ROUND + 0.3)


def test_a_loop_with_names_and_no_time_is_opened_by_its_hint(tmp_path):
    """Names that are spelt as nobody else does; the units below them tell which is which."""
    lines = [f"{x:.12g},{2.0 * x + 0.3:.12g}" for x in ROUND]
    text = "\n".join(["Top Ram Travle ,Top Ram Froce", "mm,kN", *lines])
    with pytest.raises(DataError, match=r"of a loop say how many samples") as asked:
        as_sweep(tmp_path, text)
    hint = re.search(
        r"'\S*(\?1=displacement\[mm\],2=force\[kN\],rate=100\[Hz\])'", str(asked.value)
    )
    assert hint is not None
    [test] = opened(tmp_path, text, hint[1])
    np.testing.assert_allclose(test.loading.value, ROUND, atol=1e-15)
    np.testing.assert_allclose(test.response, 2.0 * ROUND + 0.3)


@pytest.mark.parametrize("name", ["Pd (µm)", "Penetration depth [µm]", "Indentation (µm)"])
@pytest.mark.parametrize("pressed", ["Fn (µN)", "Normal force [µN]"])
def test_an_indenter_names_its_depth_and_its_normal_force(tmp_path, name, pressed):
    lines = [f"{t / 10:.1f}\t{x:.12g}\t{2.0 * x + 0.3:.12g}" for t, x in enumerate(ROUND)]
    [test] = opened(tmp_path, "\n".join([f"Time (s)\t{name}\t{pressed}", *lines]))
    assert test.units.stiffness == "uN/um"
    np.testing.assert_allclose(test.loading.value, ROUND, atol=1e-15)
    np.testing.assert_allclose(test.response, 2.0 * ROUND + 0.3)


@pytest.mark.parametrize(
    ("way", "told"), [(-1.0, "the gap at first contact less each gap"), (1.0, "opens it as a test")]
)
def test_a_height_that_falls_while_it_presses_is_no_displacement(tmp_path, way, told):
    """Read as it stands its stiffness would be negative."""
    lines = [f"{t / 10:.1f};{t * t};{20.0 + way * t / 50:.2f}" for t in range(12)]
    with pytest.raises(DataError, match=told):
        opened(tmp_path, "\n".join(["t in s;Fn in N;h in mm", *lines]))


@pytest.mark.parametrize(
    "said", ["1=displacement[mm],2=force[N]", "1=strain[-],2=stress[Pa]", "x=displacement[mm],y=N"]
)
def test_a_loop_whose_time_nobody_says_is_asked_for_its_rate(tmp_path, said):
    text = lines(ROUND, 2.0 * ROUND)
    if said.startswith("x"):
        text, said = f"x,y\n{text}", "x=displacement[mm],y=force[N]"
    with pytest.raises(DataError, match=r"without their time.*rate=1000\[Hz\]"):
        opened(tmp_path, text, f"?{said}")
    [test] = opened(tmp_path, text, f"?{said},rate=50[Hz]")
    np.testing.assert_allclose(test.loading.time, 0.02 * np.arange(len(ROUND)), atol=1e-15)


@pytest.mark.parametrize(
    "title",
    [
        "time_from_loading_s",
        "time since loading [s]",
        "Zeit ab Lastbeginn (s)",
        "time after step/s",
    ],
)
def test_a_time_may_say_from_when_it_counts(tmp_path, title):
    text = f"{title},stress_Pa,strain_frac\n" + lines(LONG, 0.0 * LONG + 2.0, 0.1 * LONG**0.3)
    [test] = opened(tmp_path, text)
    np.testing.assert_allclose(test.time, LONG)
    np.testing.assert_allclose(test.response, 0.1 * LONG**0.3)


def test_a_row_of_gaps_above_the_numbers_is_none_of_names(tmp_path):
    text = "NaN,NaN,0\nNaN,0,0.25\n" + lines(LONG**-0.3, 0.0 * LONG + 0.1, LONG)
    with pytest.raises(DataError, match="3 columns of numbers without names"):
        as_sweep(tmp_path, text)
    [test] = opened(tmp_path, text, "?1=stress[Pa],2=strain[-],3=time[s]")
    np.testing.assert_allclose(test.response[-len(LONG) :], LONG**-0.3)


@pytest.mark.parametrize(
    "title", ["stretch", "Stretch ratio [-]", "λ", "lambda (-)", "拉伸比", "Streckverhältnis"]
)
def test_a_stretch_is_one_more_than_the_strain(tmp_path, title):
    pulled, clock = 1.0 + np.abs(ROUND), 0.1 * np.arange(len(ROUND))
    text = f"time [s];{title};Nominal stress [kPa]\n{lines(clock, pulled, ROUND, separator=';')}"
    [test] = opened(tmp_path, text.replace(".", ","))
    np.testing.assert_allclose(test.loading.value, pulled - 1.0, atol=1e-12)
    assert test.units.amplitude == "-"
    assert "one more than the strain" in test.provenance["note stretch"]


def test_a_stretch_may_be_said_and_may_be_a_length(tmp_path):
    pulled = 1.0 + np.abs(ROUND)
    said = "?1=stretch[-],2=stress[kPa],rate=10[Hz]"
    [test] = opened(tmp_path, lines(pulled, ROUND), said)
    np.testing.assert_allclose(test.loading.value, pulled - 1.0, atol=1e-12)
    text = f"time [s],Stretch (mm),Force (N)\n{lines(0.1 * np.arange(len(ROUND)), pulled, ROUND)}"
    [test] = opened(tmp_path, text)
    np.testing.assert_allclose(test.loading.value, pulled)
    assert test.units.amplitude == "mm"


@pytest.mark.parametrize("unit", ["N_mm2", "N_per_mm2", "N_mm^2", "MPa"])
def test_a_stroke_within_a_name_may_be_an_underscore(tmp_path, unit):
    text = f"t_s,strain_pct,stress_{unit}\n" + "\n".join(f"{i},{0.1 * i},{i}" for i in range(9))
    [test] = opened(tmp_path, text)
    assert test.loading.value[-1] == pytest.approx(0.008)
    assert (test.response[-1], test.force_unit in ("N/mm^2", "MPa")) == (8.0, True)
