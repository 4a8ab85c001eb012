"""Measurements as tables of other libraries, and back."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.measurement import Measurement, Units, rows

OMEGA = 2.0 * np.pi * np.array([1.0, 2.0, 3.0])
TABLE = Measurement(
    OMEGA,
    np.array([3.0 + 1.0j, 4.0 + 2.0j, 5.0 + 3.0j]),
    sd=np.array([0.3 + 0.1j, 0.4 + 0.2j, 0.5 + 0.3j]),
    conditions={"amplitude": np.array([0.1, 0.2, 0.3]), "age": np.array([1.0, 2.0, 3.0])},
    labels={"batch": np.array(["a", "b", "c"])},
    repeat=np.array([0, 1, 1]),
    units=Units("kN/m", "mm"),
    name="all columns",
)


def test_headings_are_those_of_a_file() -> None:
    found = rows.columns_of(TABLE)
    assert {name: np.asarray(column).tolist() for name, column in found.items()} == {
        "frequency [Hz]": [1.0, 2.0, 3.0],
        "storage [kN/m]": [3.0, 4.0, 5.0],
        "loss [kN/m]": [1.0, 2.0, 3.0],
        "storage_sd [kN/m]": [0.3, 0.4, 0.5],
        "loss_sd [kN/m]": [0.1, 0.2, 0.3],
        "amplitude [mm]": [0.1, 0.2, 0.3],
        "age [-]": [1.0, 2.0, 3.0],
        "repeat": [0, 1, 1],
        "batch": ["a", "b", "c"],
    }


class Frame(dict):
    """As much of a `pandas.DataFrame` as is asked for."""

    def __init__(self, columns, **attrs):
        super().__init__(columns)
        self.columns, self.attrs = list(columns), attrs

    def __getitem__(self, name):
        return SimpleNamespace(to_numpy=lambda: np.array(self.get(name)))

    def renamed(self, old, new):
        return Frame({new if name == old else name: column for name, column in self.items()})


def test_all_columns_come_back(monkeypatch) -> None:
    monkeypatch.setattr(rows, "library", lambda name: SimpleNamespace(DataFrame=Frame))
    again = Measurement.from_dataframe(TABLE.to_dataframe())
    assert again.digest() == TABLE.digest()
    assert (again.units, again.name) == (TABLE.units, TABLE.name)
    turning = Measurement(OMEGA, TABLE.stiffness, units=Units("Pa", "-", "rad/s"))
    again = Measurement.from_dataframe(turning.to_dataframe())
    assert (again.digest(), again.units) == (turning.digest(), turning.units)


def test_a_table_needs_a_frequency_and_both_moduli_with_their_units() -> None:
    given = {"frequency [rpm]": [60.0], "storage [MPa]": [1.0], "loss [MPa]": [2.0]}
    warm = Frame({**given, "temperature [K]": [300.0], "storage_sd [MPa]": [1.0]})
    found = rows.arguments_of(warm)
    assert found["omega"].tolist() == pytest.approx([2.0 * np.pi])
    assert found["stiffness"].tolist() == [1.0 + 2.0j]
    assert found["conditions"]["temperature"].tolist() == pytest.approx([26.85])
    assert found["name"] == "table"
    assert "sd" not in found, "one part alone is no standard deviation"
    assert found["units"] == Units("MPa", "-", "Hz")
    for name in given:
        with pytest.raises(DataError, match="the table has no column"):
            rows.arguments_of(warm.renamed(name, "more [-]"))
    for name, without in (("frequency [rpm]", "frequency"), ("temperature [K]", "temperature")):
        with pytest.raises(DataError):
            rows.arguments_of(warm.renamed(name, without))
    with pytest.raises(DataError, match="no heading such as"):
        rows.arguments_of(warm.renamed("loss [MPa]", "loss [MPa"))


def test_each_variable_has_its_unit(monkeypatch) -> None:
    monkeypatch.setattr(rows, "library", lambda name: SimpleNamespace(Dataset=lambda *given: given))
    values, columns, told = rows.dataset(TABLE)
    assert {name: column[2] for name, column in values.items()} == {
        "stiffness": {"units": "kN/m"},
        "sd": {"units": "kN/m"},
    }
    assert {name: column[2]["units"] for name, column in columns.items()} == {
        "omega": "rad/s", "amplitude": "mm", "age": "-", "batch": "-", "repeat": "-"
    }  # fmt: skip
    assert told == {"name": "all columns"}
    values, columns, _ = rows.dataset(Measurement(OMEGA, TABLE.stiffness))
    assert (list(values), list(columns)) == (["stiffness"], ["omega"])


def test_a_measurement_goes_to_pandas_and_back() -> None:
    pytest.importorskip("pandas")
    data = springpot.read("nist-srm2491@temperature=20")
    frame = data.to_dataframe()
    assert {"omega [rad/s]", "storage [Pa]", "storage_sd [Pa]", "temperature [degC]"} <= set(frame)
    again = springpot.Measurement.from_dataframe(frame)
    assert np.array_equal(again.stiffness, data.stiffness)
    assert np.array_equal(again.omega, data.omega)
    assert np.array_equal(again.conditions["temperature"], data.conditions["temperature"])
    assert (again.units, again.units.clock, again.name) == (data.units, "rad/s", data.name)
    with pytest.raises(DataError, match="'storage'"):
        springpot.Measurement.from_dataframe(frame.drop(columns="storage [Pa]"))
    with pytest.raises(DataError):
        springpot.Measurement.from_dataframe(frame.rename(columns={"omega [rad/s]": "omega"}))


def test_a_measurement_goes_to_xarray() -> None:
    pytest.importorskip("xarray")
    data = springpot.read("nist-srm2491@temperature=20")
    found = data.to_xarray()
    assert np.array_equal(found["stiffness"].values, data.stiffness)
    assert found["omega"].attrs["units"] == "rad/s"
