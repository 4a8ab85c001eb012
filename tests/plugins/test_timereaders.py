"""Files of tests in time.

The layouts of tables, RheoCompass, TRIOS, MTS and RepTate, and how they are refused.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.registry import open_in_time, open_measurement

SHARED = Path(os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0] or "absent")
ROWS = "".join(f"{t},{3 - t},{t * t}\n" for t in (0.5, 1.0, 1.5, 2.0))


def shared(*parts):
    path = SHARED.joinpath(*parts)
    if not path.exists():
        pytest.skip("the shared data are not here")
    return path


def put(folder, text, name="test.csv", encoding="utf-8"):
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    ("header", "kind", "unit"),
    [
        ("time [s],relaxation [kPa],x", "relaxation", "kPa"),
        ("t [ms],Relaxation Modulus [MPa],x", "relaxation", "MPa"),
        ("time [s],compliance [1/kPa],x", "creep", "kPa"),
        ("Zeit [s],Kriechnachgiebigkeit [1/Pa],x", "creep", "Pa"),
        ("time [s],compliance [mm/N],x", "creep", "N/mm"),
        ("time [s],displacement [mm],force [kN]", "history", "kN/mm"),
        ("time [s],shear strain [%],shear stress [Pa]", "history", "Pa"),
        ("temps [s],angle [rad],couple [N m]", "history", "N m/rad"),
    ],
)
def test_columns_tell_what_was_tested(tmp_path, header, kind, unit):
    [test] = open_in_time(put(tmp_path, f"{header}\n{ROWS}"))
    assert (test.kind, test.units.stiffness, len(test)) == (kind, unit, 4)


def test_time_is_read_in_its_unit_and_decimals_may_have_commas(tmp_path):
    text = "Zeit / min;Relaxationsmodul / kPa\n0,5;3,25\n1,0;2,5\n2,0;2,0\n"
    [test] = open_in_time(put(tmp_path, text))
    assert test.time == pytest.approx([30.0, 60.0, 120.0])
    assert test.response == pytest.approx([3.25, 2.5, 2.0])


def test_what_the_file_leaves_open_is_said_behind_it(tmp_path):
    path = put(tmp_path, "Time\tRelaxation Modulus\n0.2\t30\n0.4\t20\n1\t10\n")
    [test] = open_in_time(path)
    assert test.time == pytest.approx([0.2, 0.4, 1.0])
    assert "seconds are taken; write Time [s]" in test.provenance["note clock"]
    assert "?time=min'" in test.provenance["note clock"]
    assert "?relaxation=Pa'" in test.provenance["note units"]
    [test] = open_in_time(f"{path}?time=s,relaxation=kPa,temperature=320[K],ramp=50[ms]")
    assert (test.units.stiffness, test.rise) == ("kPa", 0.05)
    assert test.temperature == pytest.approx(46.85)
    [same] = open_in_time(f"{path}?1=time[s],2=relaxation[kPa]")
    assert np.array_equal(same.response, test.response)


def test_control_can_be_said(tmp_path):
    path = put(tmp_path, f"time [s],displacement [mm],force [kN]\n{ROWS}")
    [test] = open_in_time(f"{path}?control=force")
    assert test.answered == "displacement"
    with pytest.raises(DataError, match="control is displacement or force, not 'stress'"):
        open_in_time(f"{path}?control=stress")


REFUSED = {
    "time [s],relaxation [Pa]\n1,2\n1,3\n": "does not rise after sample 1",
    "time [s],relaxation [Pa]\n1,2\n2,two\n": "line 3, column 'relaxation",
    "time [s],relaxation [Pa]\n-1,2\n1,3\n": "lies before the load",
    "time [s],relaxation [N]\n1,2\n2,3\n": "no unit of a modulus",
    "time [s],force [N]\n1,2\n2,3\n": "a force without a displacement",
    "time [s],stress [Pa],shear rate [1/s],viscosity [Pa s]\n1,20,1,20\n2,30,1,30\n": (
        "steady flow, neither an osc"
    ),
    "time [s],displacement [mm]\n1,2\n2,3\n": "a displacement without a force",
    "time [s],displacement [mm],force [Pa]\n1,2,1\n2,3,1\n": "units that make no stiffness",
    "time [s],compliance [Pa]\n1,2\n2,3\n": r"unknown unit \[Pa\] for a compliance",
    "time [kg],relaxation [Pa]\n1,2\n2,3\n": r"unknown unit \[kg\] for time",
}


@pytest.mark.parametrize("text", REFUSED)
def test_bad_input_is_one_line_that_names_the_file(tmp_path, text):
    path = put(tmp_path, text)
    with pytest.raises(DataError, match=REFUSED[text]) as caught:
        open_in_time(path)
    assert "\n" not in str(caught.value)
    assert str(caught.value).count(str(path)) >= 1


@pytest.mark.parametrize("gap", ["nan", "", "--"])
def test_a_row_without_a_value_is_left_out_with_a_word(tmp_path, gap):
    path = put(tmp_path, f"time [s],relaxation [Pa]\n1,2\n2,{gap}\n3,1\n")
    [test] = open_in_time(path)
    assert (test.time.tolist(), test.response.tolist()) == ([1.0, 3.0], [2.0, 1.0])
    assert test.provenance["note rows"].startswith("1 of 3 rows without a measured value")


def test_a_part_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(DataError, match="there is no part 7; it has 1"):
        open_in_time(f"{put(tmp_path, f'time [s],relaxation [kPa],x{chr(10)}{ROWS}')}#7")


@pytest.mark.parametrize(
    "text",
    [
        "frequency [Hz],storage [Pa],loss [Pa],time [s]\n1,2,1,0\n2,3,1,5\n",
        "omega,G',G''\n1,2,3\n",
        "some words\n",
        "time [s],temperature [degC]\n1,2\n",
    ],
)
def test_what_is_no_test_in_time_is_left_to_others(tmp_path, text):
    assert open_in_time(put(tmp_path, text)) == ()


def test_names_of_data_sets_are_no_files():
    assert open_in_time("nist-srm2491@temperature=20") == ()


def test_reptate_layouts(tmp_path):
    head = "Mw=23.4;T=-35;chem=PI;"
    [gt] = open_in_time(put(tmp_path, f"{head}\nt G\n0 5\n0.1 3\n1 2\n", "x.gt"))
    assert (gt.kind, gt.temperature, len(gt)) == ("relaxation", -35.0, 2)
    [shear] = open_in_time(put(tmp_path, f"{head}gdot=2;\nt eta\n0.1 1\n1 4\n2 5\n", "x.shear"))
    assert shear.kind == "startup"
    assert shear.response == pytest.approx([2.0, 8.0, 10.0])
    assert shear.loading.value[-1] == pytest.approx(4.0)
    [creep] = open_in_time(
        put(tmp_path, f"{head}stress=10;\nt strain\n0.1 1\n1 4\n2 5\n", "x.creep")
    )
    assert (creep.kind, creep.loading.value[-1]) == ("creep", 10.0)


TRIOS = """Filename,relax.tri
Instrument name,DHR

[step]
Stress relaxation - 1
Step time,Shear stress,Shear strain,Temperature,Relaxation modulus
s,Pa,%,°C,Pa
0.05,80,1.0,25.0,8000
0.1,70,1.0,25.0,7000
1,50,1.0,25.1,5000
10,30,1.0,25.1,3000
"""


def test_a_trios_step(tmp_path):
    [test] = open_in_time(put(tmp_path, TRIOS))
    assert (test.kind, test.units.stiffness) == ("relaxation", "Pa")
    assert test.temperature == pytest.approx(25.05)
    assert test.loading.value.max() == pytest.approx(0.01)
    assert test.provenance["part"] == "Stress relaxation - 1"


def test_rheocompass_intervals_are_tests_with_their_real_ramp():
    tests = open_in_time(shared("rheocompass-flags", "multiple relaxation.csv"))
    assert [(test.kind, len(test)) for test in tests] == [("relaxation", 451), ("relaxation", 155)]
    assert tests[0].rise == pytest.approx(0.1)
    assert tests[0].loading.value.max() == pytest.approx(0.03)
    path = shared("rheocompass-flags", "multiple relaxation.csv")
    assert len(open_in_time(f"{path}#2")) == 1


def test_an_mts_record_with_numbers_for_names():
    [test] = open_in_time(shared("mts-cylinder", "specimen.dat"))
    assert (len(test), test.units.stiffness) == (572, "kN/mm")


def test_sweeps_of_real_instruments_stay_sweeps():
    for parts in (
        ("rheowin-starch-gel", "stress-sweep_500Pa.csv"),
        ("hermes-multi-technique", "normalized.csv"),
    ):
        path = shared(*parts)
        assert open_in_time(path) == ()
        assert len(open_measurement(path)) > 10


def test_a_channel_that_counts_the_other_way_is_turned_by_its_unit(tmp_path):
    path = put(tmp_path, f"time [s],displacement [mm],force [kN]\n{ROWS}")
    [straight], [turned] = open_in_time(path), open_in_time(f"{path}?force=-kN")
    assert turned.response.tolist() == (-straight.response).tolist()
    assert turned.units.stiffness == "kN/mm"


def test_sizes_that_nobody_measures_are_one_line(tmp_path):
    rows = "".join(f"{t}e300,{3 - t}\n" for t in (1.0, 1.5, 2.0))
    with pytest.raises(DataError, match="no measured one: correct its unit"):
        open_in_time(put(tmp_path, f"time [s],relaxation [kPa]\n{rows}"))


@pytest.mark.parametrize(
    ("header", "letter"),
    [
        ("time [s],G(t) [kPa]", "G"),
        ("time [s],E(t) [kPa]", "E"),
        ("time [s],J(t) [1/kPa]", "G"),
        ("time [s],relaxation modulus [kPa]", ""),
        ("time [s],strain [-],shear stress [kPa]", "G"),
        ("time [s],displacement [mm],force [N]", ""),
    ],
)
def test_a_title_tells_which_modulus_a_test_in_time_is_of(tmp_path, header: str, letter: str):
    rows = [[0.1 * i, 1.0 + 0.01 * i, 9.0 - 0.1 * i] for i in range(1, 30)]
    if header.count(",") == 1:
        rows = [[time, value] for time, _, value in rows]
    lines = [header, *(",".join(map(str, row)) for row in rows)]
    [test] = open_in_time(put(tmp_path, "\n".join(lines) + "\n"))
    assert test.units.modulus == letter


@pytest.mark.parametrize("more", ["", " 0 0.1 200"], ids=["two columns", "more of the rheometer"])
def test_a_startup_of_shear_is_never_a_sweep(tmp_path, more):
    rows = "".join(f"{t:.2E} {800 * t**0.8:.6g}{more}\n" for t in np.geomspace(0.25, 180.0, 12))
    path = put(tmp_path, f"gdot=0.1;T=160;\ntime\th\t\ns\tPa-s\t\n{rows}", "my 160-01 shear.shear")
    [test] = open_in_time(path)
    assert (test.kind, test.units.stiffness, test.temperature) == ("startup", "Pa", 160.0)
    # The growth of the viscosity times the rate is the stress.
    assert test.response[0] == pytest.approx(0.1 * 800 * 0.25**0.8, rel=1e-5)
    assert test.loading.value[-1] == pytest.approx(0.1 * 180.0)


def test_a_real_startup_is_one():
    [test] = open_in_time(shared("..", "unseen", "My_dow150-160-01 shear.shear"))
    assert (test.kind, len(test)) == ("startup", 89)


def test_a_ramp_that_is_said_to_take_no_time_is_heeded(tmp_path):
    rows = "".join(f"{t},{1e-3 * t**0.3},10\n" for t in (0.05, 0.5, 2.0, 4.0, 8.0))
    path = put(tmp_path, "time [s],strain [-],stress [Pa]\n" + rows)
    [plain], [stepped] = open_in_time(path), open_in_time(f"{path}?ramp=0[s]")
    assert (plain.rise, stepped.rise) == (0.05, 0.0)


@pytest.mark.parametrize(
    ("header", "clock"),
    [
        ("Mode,Relaxation time (s),Modulus (kPa)", "2=time[s]"),
        ("i,lambda_i (ms),G_i (Pa)", "2=time[ms],3=relaxation[Pa]"),
        ("k,tau_i,g_i", "2=time[s],3=relaxation[Pa]"),
    ],
)
def test_terms_of_a_prony_series_are_no_test_unless_somebody_says_so(tmp_path, header, clock):
    """They were read as a modulus that relaxes, without a word."""
    path = put(tmp_path, f"{header}\n1,0.02,70\n2,0.3,40\n3,5,11\n4,60,2\n")
    with pytest.raises(DataError, match=r"terms of a Prony series.*open '.*\?2=time\[m?s\]'"):
        springpot.read(path)
    [test] = open_in_time(f"{path}?{clock}")
    assert (test.kind, len(test)) == ("relaxation", 4)
