"""Written and read again: the same bits and the same units, whatever they are."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot.measurement import (
    AMPLITUDE_UNITS,
    FREQUENCY_UNITS,
    MODULUS_UNITS,
    TEMPERATURE_UNITS,
    Choice,
    Measurement,
    Units,
    known_unit,
    open_measurement,
)
from springpot_plugins.readers import generic, springpot_csv

from .conftest import READERS

ANY = st.floats(allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(min_value=1e-300, max_value=1e300)


@st.composite
def measurements(draw):
    """Any measurement that the class allows, with whole columns drawn."""
    n = draw(st.integers(2, 6))

    def column(of):
        return np.array(draw(st.lists(of, min_size=n, max_size=n)))

    sd = column(POSITIVE) + 1j * column(POSITIVE) if draw(st.booleans()) else None
    conditions = {"temperature": column(st.floats(-273.15, 1e6))} if draw(st.booleans()) else {}
    if amplitude := draw(st.sampled_from(["", *AMPLITUDE_UNITS])):
        conditions["amplitude"] = column(POSITIVE)
    stiffness = np.empty(n, complex)
    stiffness.real, stiffness.imag = column(ANY), column(ANY)
    stiffness[stiffness == 0] = 1.0
    return Measurement(
        np.array(draw(st.lists(POSITIVE, min_size=n, max_size=n, unique=True))),
        stiffness,
        sd=sd,
        conditions=conditions,
        repeat=np.arange(n) if draw(st.booleans()) else None,
        units=Units(draw(st.sampled_from(list(MODULUS_UNITS))), amplitude or "-"),
        name="data",
    )


@pytest.mark.soak
@given(measurements())
@settings(max_examples=60, deadline=None)
def test_reading_writing_and_reading_gives_the_same_bits(tmp_path_factory, measured):
    folder = tmp_path_factory.getbasetemp()
    once, twice = folder / "once.csv", folder / "twice.csv"
    springpot_csv.write_csv(measured, once)
    again = open_measurement(once, (), READERS)
    springpot_csv.write_csv(again, twice)
    assert again.units == measured.units
    for name in ("omega", "stiffness", "sd", "repeat"):
        before, after = getattr(measured, name), getattr(again, name)
        assert (before is None) == (after is None), name
        assert before is None or before.tobytes() == after.tobytes(), name
    for name, column in measured.conditions.items():
        assert column.tobytes() == again.conditions[name].tobytes(), name
    assert once.read_text().replace("once", "") == twice.read_text().replace("twice", "")


def test_a_sweep_up_and_down_may_be_written_and_read(tmp_path):
    """In a table of instruments a frequency may come twice.

    A slip in one's own table is still found.
    """
    path = tmp_path / "up-and-down.txt"
    path.write_text("f in Hz;G' in Pa;G'' in Pa\n1;2;3\n2;3;4\n1;2,1;3\n")
    measured = open_measurement(path, (), READERS)
    springpot_csv.write_csv(measured, tmp_path / "out.csv")
    again = open_measurement(tmp_path / "out.csv", (), READERS)
    assert again.stiffness.tobytes() == measured.stiffness.tobytes()
    assert again.repeat is None
    assert dict(again.provenance) == dict(measured.provenance)


TABLES = {
    "frequency": FREQUENCY_UNITS,
    "modulus": MODULUS_UNITS,
    "amplitude": AMPLITUDE_UNITS,
    "temperature": TEMPERATURE_UNITS,
}


@pytest.mark.parametrize("table", TABLES)
def test_every_unit_is_known_by_its_own_name(table):
    for unit in TABLES[table]:
        assert known_unit(unit, TABLES[table], table) == unit


@pytest.mark.soak_cases("{name} ({unit})", "{name} / {unit}", "{name} [{unit}]")
@pytest.mark.parametrize("style", ["{name} [{unit}]", "{name} ({unit})", "{name} / {unit}"])
def test_every_unit_is_read_in_every_way_of_writing_it(tmp_path, style):
    path = tmp_path / "data.csv"
    for modulus in MODULUS_UNITS:
        for clock in ("Hz", "kHz", "1/min"):
            names = (("frequency", clock), ("storage", modulus), ("loss", modulus))
            header = ";".join(style.format(name=name, unit=unit) for name, unit in names)
            path.write_text(f"{header}\n1;2;3\n2;3;4\n")
            found = generic.READER.read(path, Choice())
            assert found.units.stiffness == modulus, header
            assert found.omega[0] == FREQUENCY_UNITS[clock], header
    for amplitude in AMPLITUDE_UNITS:
        header = "omega [rad/s];storage [Pa];loss [Pa];" + style.format(
            name="amplitude", unit=amplitude
        )
        path.write_text(f"{header}\n1;2;3;4\n")
        assert generic.READER.read(path, Choice()).units.amplitude == amplitude
