"""Records of displacement and force in other files than tables are tests in time too.

What swings not is told.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.registry import open_in_time, open_measurement, signals_to_measurement

T = np.arange(0.0, 20.0, 0.05)
MOVED, PULLED = np.sin(2.0 * T), 3.0 * np.sin(2.0 * T + 0.5)


def laos(first="omega=2;gamma=1;T=37;"):
    rows = "".join(
        f"{t:.6g}\t{x:.12g}\t{f:.12g}\n" for t, x, f in zip(T, MOVED, PULLED, strict=True)
    )
    return f"{first}\n{rows}"


def test_a_laos_file_is_a_test_in_time(tmp_path):
    path = tmp_path / "film.laos"
    path.write_text(laos())
    [test] = open_in_time(path)
    assert (test.name, test.kind, test.units.stiffness, test.temperature) == (
        "film",
        "history",
        "Pa",
        37.0,
    )
    np.testing.assert_allclose(test.response, PULLED, rtol=1e-10)
    np.testing.assert_allclose(test.loading.value[-len(T) :], MOVED, atol=1e-10)
    # Step one of the paper still reads it.
    assert signals_to_measurement([path]).stiffness[0] == pytest.approx(
        3.0 * np.exp(0.5j), rel=1e-5
    )


def test_a_minus_of_typographers_is_a_minus(tmp_path):
    path = tmp_path / "film.laos"
    path.write_text(laos("omega=2;gamma=1;T=\u22125;"), encoding="utf-8")
    [test] = open_in_time(path)
    assert test.temperature == -5.0


def test_a_matlab_file_is_a_test_in_time_without_its_gaps(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    pulled = PULLED.copy()
    pulled[7] = np.nan
    savemat(tmp_path / "run.mat", {"t_s": T, "disp_mm": MOVED, "force_kN": pulled})
    [test] = open_in_time(tmp_path / "run.mat")
    assert (test.units.stiffness, len(test)) == ("kN/mm", len(T) - 1)


def test_what_is_said_of_the_whole_test_is_taken(tmp_path):
    path = tmp_path / "film.laos"
    path.write_text(laos())
    [test] = open_in_time(f"{path}?temperature=300[K],control=force")
    assert test.temperature == pytest.approx(26.85)
    assert test.control == "force"
    assert test.response == pytest.approx(MOVED)


def test_what_a_matlab_file_lacks_is_asked_for(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    path = tmp_path / "run.mat"
    savemat(path, {"t": T, "x": MOVED, "F": PULLED})
    assert open_in_time(path) == ()
    with pytest.raises(DataError, match="no unit"):
        open_measurement(path)
    assert len(open_in_time(f"{path}?t=s,x=mm,F=N")) == 1


def test_a_laos_file_is_inspected_and_diagnosed(springpot_command, tmp_path):
    path = tmp_path / "film.laos"
    path.write_text(laos())
    shown = springpot_command("inspect", str(path))
    assert "1 test in time" in shown
    assert f"springpot signals {path} -o" in shown


@pytest.fixture
def springpot_command(capsys):
    from springpot.cli.group import exit_code, run

    # Not by `main`, which takes over Ctrl-C for the rest of its process, and that is the one of all
    # tests.
    def printed(*arguments):
        assert exit_code(lambda: run(list(arguments))) == 0
        return capsys.readouterr().out

    return printed


def test_columns_that_are_called_a_record_open_as_one(tmp_path):
    path = tmp_path / "nameless.txt"
    path.write_text(
        "".join(f"{t:.6g},{x:.9g},{f:.9g}\n" for t, x, f in zip(T, MOVED, PULLED, strict=True))
    )
    found = open_measurement(f"{path}?1=time[s],2=displacement[mm],3=force[N]")
    assert found.stiffness[0] == pytest.approx(3.0 * np.exp(0.5j), rel=1e-5)


def test_a_sweep_is_sent_from_signals_to_inspect(tmp_path):
    path = tmp_path / "sweep.csv"
    path.write_text("omega [rad/s],G' [Pa],G'' [Pa]\n1,2,3\n2,3,4\n3,4,5\n")
    with pytest.raises(DataError, match=f"otherwise springpot inspect {path}"):
        signals_to_measurement([path])


PUSHED = "".join(
    f"{t:.4g},{10 - 0.2 * t:.6g},{0.2 * t:.6g},{0.5 * t + 0.02 * t * t:.8g}\n" for t in T
)


def test_a_single_cycle_about_where_it_begins_does_not_move_one_way(tmp_path):
    path = tmp_path / "cycle.csv"
    t = np.linspace(0.0, 1.0, 41)
    moved = np.sin(2.0 * np.pi * t)
    rows = "".join(f"{a:.4g},{b:.6g},{3.0 * b:.6g}\n" for a, b in zip(t, moved, strict=True))
    path.write_text("time [s],pos [mm],force [N]\n" + rows)
    with pytest.raises(DataError) as refused:
        open_in_time(path)
    assert "no oscillation" not in str(refused.value)
    [test] = open_in_time(f"{path}?2=displacement[mm]")
    assert test.kind == "history"


def test_a_compression_against_the_gap_is_told_as_no_oscillation(tmp_path):
    path = tmp_path / "sweet.csv"
    path.write_text("time [s],gap [mm],way,force [N]\n" + PUSHED)
    with pytest.raises(DataError) as refused:
        open_in_time(path)
    says = str(refused.value)
    assert "moves one way" in says
    assert "no oscillation and has no storage and loss modulus" in says
    assert "relaxation[Pa]" not in says
    # What it says to write works.
    assert "add a column displacement [mm]" in says
    path.write_text("time [s],gap [mm],displacement [mm],force [N]\n" + PUSHED)
    [test] = open_in_time(path)
    assert test.kind == "startup"


def test_a_compression_against_a_distance_is_opened_by_the_command_that_is_shown(tmp_path):
    path = tmp_path / "sweet.csv"
    path.write_text("Time (s),a,Distance (mm),Force (N)\n" + PUSHED)
    with pytest.raises(DataError, match="no oscillation") as refused:
        open_in_time(path)
    command = re.search(r"'([^']+\?3=displacement\[mm\])'", str(refused.value))
    [test] = open_in_time(command[1])
    assert (test.kind, test.units.stiffness) == ("startup", "N/mm")


def test_an_unnamed_distance_that_swings_is_not_called_a_compression(tmp_path):
    path = tmp_path / "rig.csv"
    rows = "".join(f"{t:.6g},{x:.9g},{f:.9g}\n" for t, x, f in zip(T, MOVED, PULLED, strict=True))
    path.write_text("time [s],Distance [mm],force [N]\n" + rows)
    with pytest.raises(DataError, match=r"2=displacement\[mm\]") as refused:
        open_in_time(path)
    assert "oscillation" not in str(refused.value)


def test_a_single_loading_is_sent_from_signals_to_its_commands(tmp_path):
    path = tmp_path / "sweet.csv"
    path.write_text("time [s],a,displacement [mm],force [N]\n" + PUSHED)
    with pytest.raises(DataError, match="which inspect shows"):
        signals_to_measurement([path])
