"""Artificial exports in the layouts of five more makers: they open, or say exactly what they need.

Every number in them was made here; of the makers is only how lines, names and units are arranged.
"""

import math

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.registry import open_in_time

FREQUENCIES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


@pytest.fixture
def export(tmp_path):
    """Write a file as Windows programs do and return its path."""

    def put(name, lines, encoding="latin-1"):
        path = tmp_path / name
        path.write_bytes("\r\n".join(lines).encode(encoding))
        return path

    return put


def sweep(row):
    return [row(i, frequency) for i, frequency in enumerate(FREQUENCIES)]


def sine(size, phase, t):
    return size * math.sin(2.0 * math.pi * t + phase)


def netzsch(decimal="POINT", separator="SEMICOLON"):
    return [
        *(
            "#EXPORTTYPE:;DATA ALL",
            "#FILE:;rubber.ngb-dm2",
            "#FORMAT:;NETZSCH5",
            "#FTYPE:;ANSI",
            "#IDENTITY:;R1",
        ),
        *(f"#DECIMAL:;{decimal}", f"#SEPARATOR:;{separator}", "#MTYPE:;DMA", "#SAMPLE:;rubber", ""),
    ]


def test_netzsch_with_the_frequency_in_a_column(export):
    names = "##Temp./°C;Time/min;Freq./Hz;E'/MPa;E\"/MPa;tan d;Amplitude/um;Dyn. Force/N"
    path = export(
        "netzsch.csv",
        [*netzsch(), names, *sweep(lambda i, f: f"25.0;{i};{f};{100 + i};{10 + i};0.1;20.0;1.5")],
    )
    found = springpot.read(path)
    np.testing.assert_allclose(found.frequency, FREQUENCIES)
    assert (found.units.stiffness, found.units.letter, found.units.amplitude) == ("MPa", "E", "um")
    assert found.stiffness[-1] == 107.0 + 17.0j
    assert set(found.conditions["temperature"]) == {25.0}


def test_netzsch_with_a_curve_for_each_frequency(export):
    names = "##Temp./°C;Time/min;" + ";".join(
        f"E'({f} Hz)/MPa;E\"({f} Hz)/MPa;tan d({f} Hz)" for f in ("1.000", "10.000")
    )
    rows = [f"{20 + i},0;{i},0;{1000 - i},0;50,0;0,05;{1100 - i},5;55,0;0,05" for i in range(8)]
    found = springpot.read(export("netzsch.csv", [*netzsch("COMMA"), names, *rows]))
    assert len(found) == 16
    assert found.frequency.min() == pytest.approx(1.0)
    assert found.frequency.max() == pytest.approx(10.0)
    assert found.storage.max() == 1100.5
    # A line of the header, whose cells another sign parts, is no name of the table.
    head = [each.replace(";", "\t") for each in netzsch("COMMA")]
    found = springpot.read(export("netzsch.csv", [*head, names, *rows]))
    assert set(found.labels["step"]) == {"1.000 Hz", "10.000 Hz"}


def test_netzsch_that_does_not_say_its_frequency_asks_for_it(export):
    rows = [f"{20 + i}.0;{i};{1000 - i};50;0.05" for i in range(8)]
    path = export("netzsch.csv", [*netzsch(), "##Temp./°C;Time/min;E'/MPa;E\"/MPa;tan d", *rows])
    with pytest.raises(DataError, match=r"open '.*netzsch\.csv\?frequency=1\[Hz\]'"):
        springpot.read(path)
    assert set(springpot.read(f"{path}?frequency=5[Hz]").frequency.round(9)) == {5.0}


def test_perkin_elmer_with_a_header_of_facts(export):
    names = (
        "Time (min)",
        "Temperature (°C)",
        "Frequency (Hz)",
        "Storage Modulus (Pa)",
        "Loss Modulus (Pa)",
        "Tan Delta",
        "Displacement (mm)",
    )
    head = [
        "Filename:\tC:\\data\\run.dma",
        "Operator ID:\tme",
        "Sample Weight:\t1.000 mg",
        "",
        "\t".join(names),
    ]
    rows = sweep(lambda i, f: f"{i}\t25.0\t{f}\t{1e8 + 1e6 * i:.4E}\t{1e7:.4E}\t0.1\t0.05")
    found = springpot.read(export("run.txt", [*head, *rows]))
    np.testing.assert_allclose(found.frequency, FREQUENCIES)
    assert found.storage[-1] == pytest.approx(1.07e8)


def test_perkin_elmer_with_units_in_a_row(export):
    names = (
        "Index",
        "Time",
        "Program Temperature",
        "Sample Temperature",
        "Frequency",
        "Storage Modulus",
        "Loss Modulus",
        "Tan Delta",
    )
    units = ("", "Minutes", "Deg C", "Deg C", "Hz", "Pa", "Pa", "")
    head = [
        "Pyris Series - DMA 7e",
        "Data File: rubber.dmd",
        "",
        "\t".join(names),
        "\t".join(units),
    ]
    rows = sweep(lambda i, f: f"{i}\t{i}.0\t25.0\t25.1\t{f}\t{1e8 + 1e6 * i:.4E}\t{1e7:.4E}\t0.1")
    found = springpot.read(export("run.txt", [*head, *rows]))
    assert set(found.conditions["temperature"]) == {25.1}  # of the sample, not of the program
    assert found.units.stiffness == "Pa"


@pytest.mark.parametrize("counter", ["[]", ""])
@pytest.mark.parametrize(
    ("storage", "loss", "unit"), [("M'", "M''", "[MPa]"), ("G'", "G''", "[Pa]")]
)
def test_mettler_toledo_between_blanks(export, counter, storage, loss, unit):
    """A column without a unit leaves no gap between blanks.

    The units still stand under their names.
    """
    names = ("Index", "t", "Ts", "f", storage, loss)
    units = (counter, "[s]", "[°C]", "[Hz]", unit, unit)
    head = ["Curve Name:", "  !&rubber", "Performed 01.02.2024 10:00:00", "", "Curve Values:"]
    rows = sweep(lambda i, f: "".join(f"{x:>14}" for x in (i, 60.0 * i, 25.0, f, 100.0 + i, 10.0)))
    lines = [*head, "".join(f"{x:>14}" for x in names), "".join(f"{x:>14}" for x in units), *rows]
    found = springpot.read(export("mettler.txt", lines))
    np.testing.assert_allclose(found.frequency, FREQUENCIES)
    assert found.stiffness[-1] == 107.0 + 10.0j
    assert found.units.stiffness == unit.strip("[]")
    assert set(found.conditions["temperature"]) == {25.0}


def test_a_unit_that_is_missing_at_the_end_is_missing_there(export):
    rows = sweep(lambda i, f: f"{f}   {100.0 + i}   10.0   0.1")
    found = springpot.read(
        export("blanks.txt", ["f   G'   G''   tan_delta", "[Hz]   [Pa]   [Pa]", *rows])
    )
    assert found.units.stiffness == "Pa"
    np.testing.assert_allclose(found.frequency, FREQUENCIES)


def test_zwick_roell_in_german(export):
    """Time, travel and force of a test machine: a test in time, and a point of a sweep."""
    rows = [
        f"{t / 100:.2f};{sine(2.0, 0.0, t / 100):.5f};{sine(300.0, 0.3, t / 100):.3f}".replace(
            ".", ","
        )
        for t in range(600)
    ]
    path = export("zwick.csv", ['"Prüfzeit";"Standardweg";"Standardkraft"', '"s";"mm";"N"', *rows])
    [test] = open_in_time(path)
    assert (test.kind, test.units.stiffness) == ("history", "N/mm")
    point = springpot.signals_to_measurement([path])
    assert point.frequency[0] == pytest.approx(1.0, rel=1e-4)
    assert abs(point.stiffness[0]) == pytest.approx(150.0, rel=1e-3)
    assert np.angle(point.stiffness[0]) == pytest.approx(0.3, rel=1e-3)


def test_zwick_roell_below_a_report(export):
    head = ["Prüfprotokoll", '"Probe";"Gummi 1"', '"Prüfgeschwindigkeit";"10";"mm/min"', ""]
    names = '"Prüfzeit in s";"Dehnung in %";"Spannung in MPa";"Temperatur in °C"'
    rows = [
        f"{t / 100:.2f};{sine(2.0, 0.0, t / 100):.5f};{sine(3.0, 0.3, t / 100):.5f};23,0".replace(
            ".", ","
        )
        for t in range(600)
    ]
    [test] = open_in_time(export("zwick.tra", [*head, names, *rows]))
    assert test.words == ("strain", "stress")
    assert test.temperature == pytest.approx(23.0)


def test_zwick_roell_dynamic_stiffness(export):
    names, units = (
        '"Frequenz";"Dyn. Steifigkeit";"Verlustwinkel";"Wegamplitude"',
        '"Hz";"N/mm";"°";"mm"',
    )
    found = springpot.read(
        export(
            "dyn.csv", [names, units, *sweep(lambda i, f: f"{f};{200 + i};8;0,1".replace(".", ","))]
        )
    )
    assert found.magnitude[0] == pytest.approx(200.0)
    assert np.degrees(np.angle(found.stiffness)) == pytest.approx(8.0)


@pytest.mark.parametrize("in_brackets", [True, False])
def test_bohlin(export, in_brackets):
    """What others call storage and loss it calls elastic and viscous."""
    names = (
        "Time",
        "Temperature",
        "Frequency",
        "Phase Angle",
        "Complex Modulus",
        "Elastic Modulus",
        "Viscous Modulus",
        "Complex Viscosity",
        "Shear Stress",
        "Strain",
    )
    units = ("s", "°C", "Hz", "°", "Pa", "Pa", "Pa", "Pas", "Pa", "")
    rows = sweep(
        lambda i, f: f"{10 * i}\t25.0\t{f}\t30\t{120 + i}\t{100 + i}\t{60 + i}\t20\t1.0\t0.01"
    )
    if in_brackets:
        head = ["\t".join(f"{n}({u})" if u else n for n, u in zip(names, units, strict=True))]
    else:
        facts = [
            "Bohlin Rheometer System",
            "Test type: Oscillation frequency sweep",
            "Measuring system: CP 4/40",
            "",
        ]
        head = [*facts, "\t".join(names), "\t".join(units)]
    found = springpot.read(export("bohlin.txt", [*head, *rows]))
    np.testing.assert_allclose(found.frequency, FREQUENCIES)
    assert found.stiffness[-1] == 107.0 + 67.0j
    assert set(found.conditions["amplitude"]) == {0.01}
