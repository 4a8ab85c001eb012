"""Time signals as CSV, MATLAB, TDMS and RepTate LAOS: the same test gives the same stiffness."""

import datetime
import io

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Budget
from springpot.registry import signals_to_measurement

from . import samples
from .samples import MOVED, PULLED, TIME

EXPECTED = 3 * np.exp(0.5j)


def check(path, unit, said=""):
    found = signals_to_measurement([f"{path}{said}"])
    np.testing.assert_allclose(found.omega, [2.0], rtol=1e-6)
    np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-5)
    assert found.units.stiffness == unit


def csv(header, separator=",", decimal="."):
    return f"{header}\n{samples.rows((TIME, MOVED, PULLED), separator, decimal)}\n"


CASES = {
    "signals-csv": (lambda: csv("Zeit [s];Weg [mm];Kraft [kN]", ";", ","), "kN/mm"),
    "signals-mat": (samples.mat, "kN/mm"),
    "signals-tdms": (samples.tdms, "kN/mm"),
    "reptate-laos": (samples.laos, "Pa"),
}


@pytest.mark.parametrize("name", CASES)
def test_each_format_is_recognised_and_read_without_options(folder, name):
    content, unit = CASES[name][0](), CASES[name][1]
    assert folder.reader(content) == name
    check(folder.write(content), unit)


@pytest.mark.parametrize(
    "header",
    [
        "temps (s),déplacement (mm),force (N)",
        "time / s,displacement / mm,force / N",
        "Tiempo [s],Desplazamiento [mm],Fuerza [N]",
        "Tempo [s],Spostamento [mm],Forza [N]",
        "Time,Displacement,Load\ns,mm,N",
        "Time,Displacement,Load\n[s],[mm],[N]",
    ],
)
def test_channels_in_other_languages_and_units_in_a_row(folder, header):
    check(folder.write(csv(header)), "N/mm")


def test_a_missing_unit_is_asked_for(folder):
    path = folder.write(csv("time,disp,force"))
    with pytest.raises(DataError, match=r"there is no unit; .*\?time=s,displacement=mm,force=N'"):
        signals_to_measurement([path])
    check(path, "kN/mm", "?time=s,disp=mm,force=kN")


def test_unknown_channels_are_asked_for(folder):
    path = folder.write(csv("time [s],ch1,ch2"))
    with pytest.raises(
        DataError,
        match=r"no signals against time.*NAME=time\[s\],NAME=displacement\[mm\],NAME=force\[N\]",
    ):
        signals_to_measurement([path])
    with pytest.raises(DataError, match="no column of displacement and force"):
        signals_to_measurement([f"{path}?time=s"])
    check(path, "N/mm", "?ch1=displacement[mm],3=force[N]")


def test_matlab_matrix_and_structure(folder):
    path = folder.write(samples.mat(data=np.column_stack([TIME, MOVED, PULLED])))
    with pytest.raises(DataError, match=r"NAME=time\[s\],NAME=displacement\[mm\],NAME=force\[N\]"):
        signals_to_measurement([path])
    check(path, "N/mm", "?1=time[s],2=displacement[mm],3=force[N]")
    check(folder.write(samples.mat(run={"t_s": TIME, "x_mm": MOVED, "F_N": PULLED})), "N/mm")


def test_matlab_of_other_versions_or_broken(folder):
    with pytest.raises(DataError, match="save it with -v7"):
        signals_to_measurement([folder.write(b"MATLAB 7.3 MAT-file".ljust(200))])
    content = samples.mat()
    for cut in (130, 200, len(content) - 10):
        with pytest.raises(DataError, match=r"cut off|no readable MATLAB file|no vectors"):
            signals_to_measurement([folder.write(content[:cut])])


def test_a_matlab_file_that_unpacks_to_far_too_much(folder, monkeypatch):
    from springpot_plugins.readers import signals_binary

    content = samples.mat()
    monkeypatch.setattr(signals_binary, "budget_of", lambda path: Budget(1.0, len(content)))
    with pytest.raises(DataError, match="unpacks to too much"):
        signals_to_measurement([folder.write(content)])


@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
@pytest.mark.parametrize("packed", [False, True])
def test_matlab_arrays_are_those_that_scipy_reads(kind, packed):
    from scipy.io import loadmat, savemat

    from springpot_plugins.readers.signals_binary import arrays_in

    values = np.arange(1, 25).reshape(2, 3, 4).astype(kind)
    stream = io.BytesIO()
    run = {"long_name_of_a_field": values[0], "b": values[0, 0, :2], "word": "text"}
    savemat(
        stream,
        {"cube": values, "one": values[0, 0, :1], "run": run, "word": "text"},
        do_compression=packed,
    )
    found = arrays_in(stream.getvalue(), 1 << 20)
    truth = loadmat(stream)
    assert set(found) == {"cube", "one", "run.long_name_of_a_field", "run.b"}
    np.testing.assert_array_equal(found["cube"], truth["cube"])
    np.testing.assert_array_equal(found["one"], truth["one"])
    np.testing.assert_array_equal(found["run.b"], truth["run"]["b"][0, 0])
    assert found["cube"].dtype == np.float64


def test_tdms_without_units_or_with_a_sampling_interval(folder):
    path = folder.write(samples.tdms(units=False))
    with pytest.raises(DataError, match="there is no unit"):
        signals_to_measurement([path])
    check(path, "N/mm", "?time=s,displacement=mm,force=N")
    check(folder.write(samples.tdms(clock=True)), "kN/mm")


def test_tdms_that_is_cut_off(folder):
    content = samples.tdms()
    for cut in (4, 30, 100, len(content) // 2):
        with pytest.raises(DataError):
            signals_to_measurement([folder.write(content[:cut])])


def test_laos_with_angle_and_torque_and_without_names(folder):
    content = samples.laos("#time\tq\tTorque\n#s\trad\tN-m")
    check(folder.write(content), "N m/rad")
    check(folder.write(samples.laos("")), "Pa")


def machine(titles, units, columns, separator="\t", decimal=","):
    """An export of a test machine: a report, names, units, numbers, and another table below."""
    head = (
        f"MTS793|MPT|DEU\n\nBediener\t\tZeit:\t33,8\ts\nPrüfer :\tKh\n\n{separator.join(titles)}\n"
    )
    body = samples.rows(columns, separator, decimal)
    below = f"Datenerfassung\t\tZeit:\t99\ts\n{titles[0]}\n7\n"
    return f"{head}{separator.join(units)}\n{body}\n\n{below}".encode("latin-1")


def test_prefixes_of_channels_sensor_numbers_and_a_second_table(folder):
    titles = (
        "Datum",
        "Laufzeit",
        "Ch 1 Kraft Sollwert",
        "Ch 1 Kraft",
        "Ch 1 Weg",
        "1944 B",
        "1281068",
    )
    day = np.full_like(TIME, 41883.0)
    columns = (day, TIME, 9 * PULLED, PULLED, MOVED, 5 * MOVED, 7 * MOVED)
    path = folder.write(machine(titles, ("d", "s", "kN", "kN", "mm", "mm", "mm"), columns))
    check(path, "kN/mm")
    found = signals_to_measurement([f"{path}?1944 B=displacement[mm]"])
    np.testing.assert_allclose(found.stiffness, [EXPECTED / 5], rtol=1e-5)
    notes = " ".join(found.provenance.values())
    assert "displacement is '1944 B' as you said, not 'Ch 1 Weg'" in notes
    assert "the table ends above line" in notes


def test_volts_beside_calibrated_channels(folder):
    text = csv("Time [s],Force [V],Displacement [V]").splitlines()
    rows = [
        f"{line},{moved!r},{pulled!r}"
        for line, moved, pulled in zip(text[1:], MOVED.tolist(), PULLED.tolist(), strict=True)
    ]
    content = (
        "\n".join(["Time [s],Force [V],Displacement [V],Displacement [mm],Force [kN]", *rows])
        + "\n"
    )
    check(folder.write(content), "kN/mm")
    with pytest.raises(DataError, match=r"unknown unit \[V\] for displacement"):
        signals_to_measurement([folder.write(csv("Time [s],Displacement [V],Force [kN]"))])


@pytest.mark.soak_cases("%m/%d/%Y %I:%M:%S.%f %p")
@pytest.mark.parametrize(
    "style",
    ["%d.%m.%Y %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%fZ", "%H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p"],
)
def test_timestamps_with_and_without_a_date(folder, style):
    start = datetime.datetime(2014, 9, 1, 13, 25, 39)
    stamps = [
        (start + datetime.timedelta(seconds=t)).strftime(style) for t in np.round(TIME, 6).tolist()
    ]
    rows = [
        f"{stamp};{q!r};{u!r}"
        for stamp, q, u in zip(stamps, MOVED.tolist(), PULLED.tolist(), strict=True)
    ]
    found = signals_to_measurement(
        [folder.write("\n".join(["Timestamp;Disp [mm];Force [N]", *rows]) + "\n")]
    )
    np.testing.assert_allclose(found.omega, [2.0], rtol=1e-4)
    np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-3)


def test_a_force_that_counts_the_other_way(folder):
    path = folder.write(f"t [s],x [mm],F [N]\n{samples.rows((TIME, MOVED, -PULLED))}\n")
    assert "storage and loss are negative" in " ".join(
        signals_to_measurement([path]).provenance.values()
    )
    check(path, "N/mm", "?F=-N")


def test_a_unit_that_the_file_says_otherwise_is_told(folder):
    path = folder.write(csv("time [s],x [mm],F [N]"))
    found = signals_to_measurement([f"{path}?F=kN"])
    assert "'F [N]' is in kN as you said; the file says N" in " ".join(found.provenance.values())
