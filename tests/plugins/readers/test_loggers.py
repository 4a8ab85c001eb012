"""Time signals of loggers, and jobs in which a sweep follows a rest.

As signals and as tests in time.
"""

import datetime

import numpy as np
import pytest

from springpot.registry import open_in_time, signals_to_measurement

from . import samples
from .samples import MOVED, OMEGA, PULLED, STIFFNESS, TIME

EXPECTED = 3 * np.exp(0.5j)


def signals(header, separator="\t", decimal=","):
    return f"{header}\n{samples.rows((TIME, MOVED, PULLED), separator, decimal)}\n"


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\n"
    "Y_Unit_Label\tMillimeters\tKilonewtons\t\nX_Dimension\tTime\tTime\t\nDelta_X\t0.001\t0.001\t\n"
    "***End_of_Header***\t\t\t\nX_Value\tDisplacement\tForce\tComment"
)
FILES = {
    "catman": (
        signals(
            "CATMAN 5.3\nWerte: 4000\n\nZeit\tMX840_CH_1 Weg\tMX840_CH_2 Kraft\ns\tmm\tkN"
        ).encode("latin-1")
    ),
    "catman with brackets": (
        signals("Zeit  1 - Standardmessrate [s]\tWeg LVDT 2 [mm]\tKraft 50kN [kN]").encode()
    ),
    "labview": signals(LABVIEW, decimal=".").encode(),
    "symbols": signals("t[s]\ts[mm]\tF[kN]").encode(),
    "french": signals("Temps;Dep1;Force1\nsec;mm;kN", ";").encode("latin-1"),
    "japanese": signals("時間(s),変位(mm),荷重(kN)", ",", ".").encode("cp932"),
    "chinese": signals("时间(s),位移(mm),载荷(kN)", ",", ".").encode("gb18030"),
    "russian": signals("Время, с;Перемещение, мм;Усилие, кН", ";").encode("cp1251"),
}


@pytest.mark.soak_cases("chinese", "japanese", "russian", "symbols")
@pytest.mark.parametrize("name", FILES)
def test_signals_of_loggers_open_without_a_word(folder, name):
    path = folder.write(FILES[name])
    found = signals_to_measurement([path])
    np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-5)
    assert found.units.stiffness == "kN/mm"
    (test,) = open_in_time(path)
    assert len(test) == len(TIME)


def test_timestamps_are_a_clock_for_tests_in_time_too(folder):
    began = datetime.datetime(2023, 3, 1, 9)
    stamps = [f"{began + datetime.timedelta(seconds=float(t)):%Y-%m-%d %H:%M:%S.%f}" for t in TIME]
    rows = [f"{stamp},{x:.9g},{f:.9g}" for stamp, x, f in zip(stamps, MOVED, PULLED, strict=True)]
    (test,) = open_in_time(folder.write("\n".join(["Timestamp,LVDT 3 [mm],Load cell [kN]", *rows])))
    np.testing.assert_allclose(test.time, TIME - TIME[0], atol=2e-5)


def test_of_two_sensors_the_one_taken_is_told(folder):
    header = "Zeit [s],Weg links [mm],Kraft [kN],Weg rechts [mm],Kraft Soll [kN]"
    content = f"{header}\n{samples.rows((TIME, MOVED, PULLED, MOVED * 2, PULLED * 0))}\n"
    found = signals_to_measurement([folder.write(content)])
    np.testing.assert_allclose(found.stiffness, [EXPECTED], rtol=1e-5)
    told = " ".join(found.provenance.values())
    assert "displacement is 'Weg links [mm]', not 'Weg rechts [mm]'" in told
    assert "Soll" not in told


@pytest.mark.parametrize(
    "rest", ["\t1\t0.0\t0.01\n" * 3, "\t1\t0.0\t0.01\n" * 4000], ids=["short", "long"]
)
def test_a_sweep_below_a_rest_is_what_a_job_is_opened_for(folder, rest):
    rows = "".join(
        f"\t{w:.9g}\t{k.real:.9g}\t{k.imag:.9g}\n" for w, k in zip(OMEGA, STIFFNESS, strict=True)
    )
    content = (
        "Projekt:\tGel\nTest:\tScherung, Sweep\n\nErgebnis:\tSweep 1\n\n"
        "Abschnitt und Datenpunkte:\t1\t3\nAbschnittsdaten:\tZeit\tScherrate\tSchubspannung\n"
        f"\t[s]\t[1/s]\t[Pa]\n{rest}\n\n"
        "Abschnitt und Datenpunkte:\t2\t5\n"
        "Abschnittsdaten:\tKreisfrequenz\tSpeichermodul\tVerlustmodul\n"
        f"\t[rad/s]\t[Pa]\t[Pa]\n{rows}"
    )
    path = folder.write(content)
    assert open_in_time(path) == ()
    np.testing.assert_allclose(folder.open(content).stiffness, STIFFNESS, rtol=1e-7)
