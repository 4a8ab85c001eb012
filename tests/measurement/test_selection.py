"""Rows chosen or left out by ranges, and the obvious wrong call refused."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.measurement import Measurement, Units
from springpot.rheology import Points

W = np.array([1.0, 2.0, 4.0, 8.0])
K = np.array([1.0 + 1.0j, 2.0 + 1.0j, 3.0 + 1.0j, 4.0 + 1.0j])
DATA = Measurement(W, K, conditions={"temperature": [-20.0, -10.0, 0.0, 10.0]}, name="four")


@pytest.mark.parametrize(
    ("choice", "rows"),
    [
        ("omega=2..4", [1, 2]),
        ("omega=..2", [0, 1]),
        ("omega=4..", [2, 3]),
        ("omega=4", [2]),
        ("temperature=-20..-10", [0, 1]),
        ("row=2", [1]),
        ("row=2..3", [1, 2]),
        ("omega=2..,temperature=..0", [1, 2]),
    ],
)
def test_ranges_take_their_ends_in(choice: str, rows: list[int]):
    wanted = dict(part.split("=") for part in choice.split(","))
    chosen = springpot.measurement.select(DATA, wanted)
    assert chosen.omega.tolist() == W[rows].tolist()
    left = springpot.measurement.without(DATA, wanted)
    assert sorted([*chosen.omega.tolist(), *left.omega.tolist()]) == W.tolist()
    assert left.name == "four"
    assert left.reference_temperature == DATA.reference_temperature


def test_a_frequency_is_in_hertz():
    assert DATA.excluding(frequency=f"{3 / (2 * np.pi)}..").omega.tolist() == [1.0, 2.0]
    assert len(springpot.read("nist-srm2491@temperature=20,frequency=0.1..1")) == 5


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"omega": "9..12"}, "no omega in 9..12 .there are 1 to 8."),
        ({"omega": "a..b"}, "no number or range such as 1..10"),
        ({"speed": "1..2"}, "no condition 'speed'"),
        ({"row": "5"}, "no row near 5"),
    ],
)
def test_what_is_not_there_is_told(choice: dict[str, str], says: str):
    with pytest.raises(DataError, match=says):
        springpot.measurement.select(DATA, choice)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: Points(W, temperature=170), r"use Points.at\(omega, temperature=...\)"),
        (lambda: Points([100.0, 1e3, 1e4]), r"use Points.at\(omega\) for omega in rad/s"),
        (lambda: Points(np.log(W), temperature=np.full(4, 20.0)), "temperature is in kelvin here"),
        (lambda: Units("bananas"), r"unknown unit \[bananas\]"),
        (lambda: Units("kN/m", "furlong"), r"unknown unit \[furlong\] for the amplitude"),
        (lambda: Measurement(W, K, units="kN/m"), r"units are Units\('kN/m', 'mm'\)"),
        (lambda: Measurement(W, K.real), r"stiffness is real: give storage \+ 1j \* loss"),
        (lambda: Measurement(W, [1, 2, 3, 4]), "stiffness is real"),
        (
            lambda: Measurement(W, K, conditions={"temperature": [293.15, 303.15, 313.15, 323.15]}),
            "subtract 273.15",
        ),
        (lambda: Measurement(W, K, conditions={"temperature": [-300.0] * 4}), "absolute zero"),
    ],
)
def test_the_obvious_wrong_call_is_refused(call, says: str):
    with pytest.raises(DataError, match=says):
        call()


def test_the_right_calls_are_as_short():
    at = Points.at(W, temperature=170.0, amplitude=[1.0, 2.0, 3.0, 4.0])
    assert np.allclose(at.omega, W)
    assert at.temperature.tolist() == [443.15] * 4
    assert Units("N/mm2", "%") == Units("N/mm^2", "%")
    hot = Measurement(W, K, conditions={"temperature": [210.0, 220.0, 230.0, 240.0]})  # a melt
    assert len(hot) == 4


def test_a_note_on_several_tests_is_of_the_rows_that_are_left(tmp_path):
    path = tmp_path / "job.csv"
    rows = [
        f"{f},100,10,{t},{run}"
        for run, t in (("a", 20), ("b", 20), ("c", 40))
        for f in (1, 2, 3, 4)
    ]
    path.write_text(
        "\n".join(["frequency [Hz],storage [Pa],loss [Pa],temperature [degC],run", *rows])
    )
    note = "note together"
    assert "3 values of run, choose one by '@run=a'" in springpot.read(path).provenance[note]
    assert "2 values of run" in springpot.read(f"{path}@temperature=20").provenance[note]
    assert note not in springpot.read(f"{path}@temperature=40").provenance
    assert note not in springpot.read(f"{path}@temperature=20,run=b").provenance
