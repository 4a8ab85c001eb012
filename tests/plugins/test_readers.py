"""The built-in readers: what they open, what they refuse and in which words."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot.errors import DataError
from springpot.measurement import Choice, Measurement, Units, open_measurement, pick_reader
from springpot.registry import (
    open_measurement as open_named,
    signals_to_measurement,
    write_measurement,
)
from springpot_plugins.readers import signals_csv, springpot_csv, springpot_readers
from springpot_plugins.readers.columns import NOTES_OF_VALUES

READERS = tuple(springpot_readers())
HEADER = "frequency [Hz],storage [kN/m],loss [kN/m]\n"


@pytest.fixture
def opened(tmp_path):
    """Open a file of the given content."""

    def open_it(content, name="data.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return open_measurement(path, (), READERS)

    return open_it


def test_the_plain_case(opened):
    found = opened(HEADER + "1,2,3\n2,4,5\n")
    np.testing.assert_allclose(found.omega, [2 * np.pi, 4 * np.pi], rtol=1e-15)
    np.testing.assert_array_equal(found.stiffness, [2 + 3j, 4 + 5j])
    assert found.units == Units("kN/m", "-")
    assert found.name == "data"


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"]
)
@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_encodings_separators_and_line_ends(opened, separator, encoding, ending):
    rows = [
        "# Prüfer: Müller",
        "omega [rad/s],storage [Pa],loss [Pa],temperature [°C]",
        "1,2.5,3,20",
        "2,4,5,20",
    ]
    text = ending.join(row if row.startswith("#") else row.replace(",", separator) for row in rows)
    found = opened(text.encode(encoding))
    np.testing.assert_array_equal(found.stiffness, [2.5 + 3j, 4 + 5j])
    np.testing.assert_array_equal(found.conditions["temperature"], [20, 20])
    assert found.provenance["Prüfer"] == "Müller"


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_comma(opened, separator):
    text = (
        "frequency [Hz],storage [Pa],loss [Pa]".replace(",", separator)
        + f"\n1,5{separator}2,25{separator}1e3\n"
    )
    found = opened(text)
    assert found.frequency[0] == pytest.approx(1.5)
    assert found.stiffness[0] == 2.25 + 1000j


def test_magnitude_with_phase_or_loss_factor(opened):
    for line in (
        "|K| [N/mm],phase [deg]\n1,5,30",
        "magnitude [N/mm],loss_factor [-]\n1,5,0.57735026918962573",
    ):
        found = opened("frequency [Hz]," + line + "\n")
        np.testing.assert_allclose(found.stiffness, [5 * np.exp(1j * np.pi / 6)], rtol=1e-14)
    found = opened("frequency [Hz],storage [N/mm],tan delta [-]\n1,5,0.2\n")
    np.testing.assert_allclose(found.stiffness, [5 + 1j])


def test_units_of_loss_and_deviations_follow_the_storage(opened):
    found = opened(
        "frequency [kHz],storage [kN/m],loss [N/m],storage_sd [N/mm],loss_sd\n1,2,3000,4,5\n"
    )
    assert found.omega[0] == pytest.approx(2000 * np.pi)
    np.testing.assert_allclose(found.stiffness, [2 + 3j])
    np.testing.assert_allclose(found.sd, [4 + 5j])


def test_further_columns_are_conditions_or_labels(opened):
    found = opened(
        "frequency [Hz],storage [Pa],loss [Pa],current [A],lane,"
        "run [text]\n1,2,3,0.5,a,1\n2,2,3,,b,2\n"
    )
    np.testing.assert_array_equal(found.conditions["current"], [0.5, np.nan])
    assert found.labels["lane"].tolist() == ["a", "b"]
    assert found.labels["run"].tolist() == ["1", "2"]
    assert found.provenance["unit current"] == "A"


def test_harmonics_columns(opened):
    found = opened("frequency [Hz],storage [Pa],loss [Pa],h3_re [-],h3_im [-]\n1,2,3,0.25,-0.5\n")
    assert np.isnan(found.harmonics[0, 0])
    assert found.harmonics[0, 1] == 0.25 - 0.5j
    assert found.harmonic(3) == [0.25 - 0.5j]
    assert found.harmonic(5) is None


@pytest.mark.parametrize("title", ["h3 [-]", "F3/F1", "I3/I1 [-]", "I3/1", "I_3/I_1", "σ3/σ1"])
def test_a_harmonic_of_which_only_the_size_was_noted(opened, title):
    found = opened(f"frequency [Hz],storage [Pa],loss [Pa],{title}\n1,2,3,0.25\n2,3,4,\n")
    np.testing.assert_array_equal(found.harmonic(3), [0.25, np.nan])
    assert np.isrealobj(found.harmonic(3))
    share = opened("frequency [Hz],storage [Pa],loss [Pa],I3/I1 [%]\n1,2,3,25\n")
    assert share.harmonic(3) == [0.25]
    # The motion's own is a condition like any other.
    assert opened("f [Hz],storage [Pa],loss [Pa],X3/X1\n1,2,3,0.01\n").harmonic(3) is None


ERRORS = {
    "missing loss": (
        "frequency [Hz],storage [Pa]\n1,2\n",
        r"found .*; missing loss \[unit\], phase \[deg\] or loss_factor",
    ),
    "missing frequency": (
        "storage [Pa],loss [Pa]\n1,2\n",
        r"missing frequency \[Hz\] or omega \[rad/s\]",
    ),
    "no unit": (
        "frequency,T,storage [Pa],loss [Pa]\n1,293,2,3\n",
        r"no unit; .*write frequency \[Hz\] or omega \[rad/s\]",
    ),
    "no unit of one modulus": (
        "frequency [Hz],storage [Pa],loss\n1,2,3\n",
        r"column 'loss': there is no unit; write loss \[N/mm\]",
    ),
    "unknown unit": ("frequency [Hz],storage [kN/mn],loss [Pa]\n1,2,3\n", r"did you mean \[kN/m\]"),
    "omega in hertz": ("omega [Hz],storage [Pa],loss [Pa]\n1,2,3\n", "omega is in rad/s"),
    "mixed kinds": ("frequency [Hz],storage [kN/m],loss [Pa]\n1,2,3\n", "cannot be converted"),
    "negative frequency": (
        HEADER + "1,2,3\n-1,2,3\n",
        r"line 3, column 'frequency \[Hz\]': .* positive, got -1",
    ),
    "zero frequency": (HEADER + "0,2,3\n", "must be positive"),
    "duplicate": (HEADER + "1,2,3\n2,2,3\n1,5,6\n", "line 4.*stands already in line 2.*repeat"),
    "nan": (HEADER + "1,nan,3\n", r"line 2, column 'storage \[kN/m\]': 'nan' is no finite number"),
    "text": (HEADER + "1,2,3\n2,two,3\n", "line 3.*'two' is no number"),
    "underscore": (HEADER + "1,2_000,3\n", "'2_000' is no number"),
    "empty cell": (HEADER + "1,,3\n", "line 2.*the cell is empty"),
    "ragged": (HEADER + "1,2,3\n2,3\n", "line 3: 2 cells where the header has 3"),
    "decimal comma": (HEADER + "1,5,2,3\n", "decimal comma, separate the columns by semicolons"),
    "thousands": ("frequency [Hz];storage [Pa];loss [Pa]\n1;1.234,5;3\n", "both comma and point"),
    "empty": ("", "the file is empty"),
    "blank": ("\n  \n\n", "empty|no reader recognises"),
    "header only": (HEADER, "no row of numbers"),
    "two of a name": (
        "frequency [Hz],storage [Pa],loss [Pa],storage [Pa]\n1,2,3,4\n",
        "two columns are called 'storage'",
    ),
    "both frequencies": (
        "frequency [Hz],omega [rad/s],storage [Pa],loss [Pa]\n1,2,3,4\n",
        "keep one",
    ),
    "sd alone": (
        "frequency [Hz],storage [Pa],loss [Pa],loss_sd [Pa]\n1,2,3,4\n",
        "standard deviations need",
    ),
    "sd zero": (
        "frequency [Hz],storage [Pa],loss [Pa],storage_sd [Pa],loss_sd [Pa]\n1,2,3,0,1\n",
        "line 2.*positive",
    ),
    "amplitude unit": (
        "frequency [Hz],storage [Pa],loss [Pa],amplitude\n1,2,3,4\n",
        r"amplitude \[-\] for a strain",
    ),
    "absolute zero": (
        "frequency [Hz],storage [Pa],loss [Pa],temperature [K]\n1,2,3,-4\n",
        "absolute zero",
    ),
    "repeat": ("frequency [Hz],storage [Pa],loss [Pa],repeat\n1,2,3,1.5\n", "whole"),
    "binary": (bytes(range(256)) * 20, "no reader recognises"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_every_slip_has_its_one_line(opened, case):
    content, message = ERRORS[case]
    with pytest.raises(DataError, match=message) as caught:
        opened(content)
    assert "\n" not in str(caught.value)
    assert "data.csv" in str(caught.value)


def test_repeats_make_duplicates_meant(opened):
    found = opened("frequency [Hz],storage [Pa],loss [Pa],repeat\n1,2,3,1\n1,2,3,2\n")
    assert found.repeat.tolist() == [1, 2]


@pytest.mark.parametrize("spec", ["no/such.csv", "nosuch", "", "x" * 5000, "a\0b", ".", "/"])
def test_what_is_not_there(spec):
    with pytest.raises(DataError) as caught:
        open_measurement(spec, (), READERS)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def _random_measurement(rng, n, sd, extra):
    omega = np.exp(rng.uniform(-20, 20, n))
    stiffness = rng.normal(size=n) * 10.0 ** rng.integers(-300, 300, n) + 1j * rng.normal(size=n)
    return Measurement(
        omega,
        stiffness,
        sd=(
            np.abs(rng.normal(size=n)) + 1j * np.abs(rng.normal(size=n)) + (1 + 1j) * 1e-300
            if sd
            else None
        ),
        conditions=(
            {
                "temperature": rng.normal(size=n),
                "amplitude": np.exp(rng.normal(size=n)),
                "current": rng.normal(size=n),
            }
            if extra
            else {}
        ),
        repeat=np.arange(n) if extra else None,
        harmonics=rng.normal(size=(n, 3)) + 1j * rng.normal(size=(n, 3)) if extra else None,
        units=Units("kgf/mm", "um"),
        name="a name",
        provenance={"citation": "who, when", "unit current": "A"} if extra else {},
        labels={"file": np.array([f'{i}, or "so"' for i in range(n)])} if extra else {},
    )


def _same_bits(first, second):
    for name in ("omega", "stiffness", "sd", "repeat", "harmonics"):
        a, b = getattr(first, name), getattr(second, name)
        assert (a is None) == (b is None), name
        assert a is None or a.tobytes() == b.tobytes(), name
    assert first.conditions.keys() == second.conditions.keys()
    assert all(
        first.conditions[key].tobytes() == second.conditions[key].tobytes()
        for key in first.conditions
    )
    assert {key: column.tolist() for key, column in first.labels.items()} == {
        key: column.tolist() for key, column in second.labels.items()
    }
    assert first.name == second.name
    origins = [
        {k: v for k, v in each.provenance.items() if k not in NOTES_OF_VALUES}
        for each in (first, second)
    ]
    assert origins[0] == origins[1]


@pytest.mark.parametrize(("sd", "extra"), list(product([False, True], repeat=2)))
def test_what_is_written_reads_back_as_the_same_bits(tmp_path, rng, sd, extra):
    measurement = _random_measurement(rng, 40, sd, extra)
    path = write_measurement(measurement, tmp_path / "out.csv")
    again = open_named(path)
    _same_bits(measurement, again)
    # Amplitudes keep their unit only where there are amplitudes.
    assert again.units == (measurement.units if extra else Units("kgf/mm", "-"))
    springpot_csv.write_csv(again, tmp_path / "twice.csv")
    assert (tmp_path / "twice.csv").read_bytes() == path.read_bytes()


@pytest.mark.soak
def test_a_hundred_thousand_rows(tmp_path, rng):
    measurement = _random_measurement(rng, 100_000, True, False)
    path = write_measurement(measurement, tmp_path / "big.csv")
    _same_bits(measurement, open_named(path))


def _head_of(text):
    return text.encode("utf-8", errors="ignore")


BYTES = st.one_of(
    st.binary(max_size=400),
    st.text(max_size=200).map(_head_of),
    st.lists(
        st.sampled_from(
            (
                *(
                    "frequency [Hz]",
                    "omega [rad/s]",
                    "storage [Pa]",
                    "loss [Pa]",
                    "time [s]",
                    "force [N]",
                    "x_mm",
                ),
                *(
                    "repeat",
                    "h2_re",
                    "1",
                    "-2.5",
                    "1e999",
                    "nan",
                    "",
                    "#",
                    '"',
                    ",",
                    ";",
                    "\t",
                    "\n",
                    "\r",
                    "\0",
                ),
                *("1,5", "[", "(", "²"),
            )
        ),
        max_size=40,
    ).map(lambda parts: _head_of(",".join(parts))),
    st.lists(
        st.lists(
            st.sampled_from(["1", "2.5", "nan", "", "x", "1e400", "-0"]), min_size=3, max_size=3
        ),
        max_size=8,
    ).map(lambda rows: _head_of(HEADER + "\n".join(",".join(row) for row in rows))),
)


def _complaint_about(reader, path):
    """What the reader says against a file; any error but a DataError is a crash."""
    try:
        assert len(reader.read(path, Choice())) > 0
    except DataError as error:
        return str(error)
    return ""


@pytest.mark.soak
@given(BYTES)
@settings(max_examples=400, deadline=None)
def test_arbitrary_bytes_never_crash(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "fuzz.csv"
    path.write_bytes(data)
    for reader in READERS:
        assert 0.0 <= reader.recognises(data) <= 1.0
        assert "\n" not in _complaint_about(reader, path)


SIGNAL = np.linspace(0.0, 30.0, 1500)


def _signal_text(header, separator=",", decimal=".", scale=1.0):
    q, u = np.cos(2 * SIGNAL), 3 * np.cos(2 * SIGNAL + 0.5)
    rows = [
        separator.join(f"{v:.12g}".replace(".", decimal) for v in row)
        for row in zip(SIGNAL * scale, q, u, strict=True)
    ]
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize(
    ("header", "separator", "decimal", "scale", "unit"),
    [
        ("time [s],displacement [mm],force [N]", ",", ".", 1.0, "N/mm"),
        ("t_s,disp_mm,force_kN", ",", ".", 1.0, "kN/mm"),
        ("Time [ms];Displacement [in];Force [lbf]", ";", ",", 1000.0, "lbf/in"),
        ("time [s]\tstrain [-]\tstress [kPa]", "\t", ".", 1.0, "kPa"),
        ("time (s),angle (rad),torque (N m)", ",", ".", 1.0, "N m/rad"),
    ],
)
def test_signals_of_many_headers(tmp_path, header, separator, decimal, scale, unit):
    path = tmp_path / "run.csv"
    path.write_text("# a comment\n" + _signal_text(header, separator, decimal, scale))
    assert pick_reader(path, READERS) is signals_csv.READER
    found = signals_to_measurement([path])
    assert found.units.stiffness == unit
    np.testing.assert_allclose(found.omega, [2.0], rtol=1e-8)
    np.testing.assert_allclose(found.stiffness, [3 * np.exp(0.5j)], rtol=1e-7)


def test_missing_samples_and_a_header_with_a_remark(tmp_path):
    lines = _signal_text(
        "t_s,disp_mm,force_N,vel_mm_s (every 4th sample, converted from in/kip)"
    ).splitlines()
    lines[1:] = [line + ",0" for line in lines[1:]]
    lines[100] = lines[100].replace(lines[100].split(",")[1], "")
    lines[200] = "1.5,nan,,"
    path = tmp_path / "run.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(
        signals_to_measurement([path]).stiffness, [3 * np.exp(0.5j)], rtol=1e-6
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time [s],displacement [mm]\n1,2\n", "no column of force"),
        ("time,displacement [mm],force [N]\n1,2,3\n", r"no unit; write time \[s\]"),
        (
            "time [s],displacement [mm],force [N]\n1,2,x\n",
            "line 2, column 'force \\[N\\]': 'x' is no number",
        ),
        ("time [s],displacement [mm],force [N]\n", "no row of numbers"),
        (HEADER + "1,2,3\n", "no signals against time"),
    ],
)
def test_signals_that_cannot_be_used(tmp_path, text, message):
    path = tmp_path / "run.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=message):
        signals_to_measurement([path])


def test_large_signal_files_are_mapped_not_held(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    path.write_text(_signal_text("time [s],displacement [mm],force [N]"))
    inside = signals_csv.signals(path, Choice())
    monkeypatch.setattr(signals_csv, "IN_MEMORY", 10)
    monkeypatch.setattr(signals_csv, "CHUNK", 1000)
    mapped = signals_csv.signals(path, Choice())
    assert isinstance(mapped.force, np.memmap)
    np.testing.assert_array_equal(mapped.force, inside.force)
    np.testing.assert_array_equal(mapped.time, inside.time)
