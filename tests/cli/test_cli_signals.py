"""``springpot signals``: from records of two channels to a measurement that can be opened again."""

import numpy as np
import pytest

KEYS = {"file", "frequency", "storage", "loss", "storage_sd", "loss_sd", "amplitude"}


@pytest.fixture
def records(write):
    """Three tests of a damper with K = (100 + 20 i) f^0.3 N/mm, and noise of 1 N in the force."""
    time, rng = np.arange(0.0, 5.0, 0.004), np.random.default_rng(3)
    paths = []
    for f in (1.0, 2.0, 4.0):
        turn = np.exp(2j * np.pi * f * time)
        displacement = 2.0 * turn.imag
        force = (2.0 * _stiffness(f) * turn).imag + rng.normal(size=len(time))
        rows = "\n".join(
            f"{a!r},{b!r},{c!r}" for a, b, c in np.c_[time, displacement, force].tolist()
        )
        paths.append(write(f"time [s],displacement [mm],force [N]\n{rows}\n", f"test-{f:g}.csv"))
    return paths


def _stiffness(frequency):
    return (100.0 + 20.0j) * frequency**0.3


def test_the_stiffness_lies_within_its_uncertainty(springpot, records):
    answer = springpot("signals", *records, "--json").json
    assert set(answer) == {"schema", "files", "output", "units", "rows", "provenance"}
    assert answer["schema"] == "springpot.signals/1"
    assert answer["units"] == {"frequency": "Hz", "stiffness": "N/mm", "amplitude": "mm"}
    assert all(set(row) == KEYS for row in answer["rows"])
    for row, f in zip(answer["rows"], (1.0, 2.0, 4.0), strict=True):
        assert abs(row["frequency"] - f) < 1e-3
        assert abs(row["storage"] - _stiffness(f).real) < 4 * row["storage_sd"]
        assert abs(row["loss"] - _stiffness(f).imag) < 4 * row["loss_sd"]
        assert row["storage_sd"] < 0.1


def test_what_is_written_is_what_was_shown(springpot, records, tmp_path):
    output = tmp_path / "damper.csv"
    answer = springpot("signals", *records, "-o", output)
    assert (answer.code, answer.err) == (0, "")
    assert f"written: {output}" in answer.out
    again = springpot("inspect", output, "--json").json
    assert again["points"] == 3
    assert again["standard_deviations"]
    rows = springpot("signals", *records, "--json").json["rows"]
    assert abs(again["storage"]["to"] - max(row["storage"] for row in rows)) < 1e-9
    assert springpot("inspect", output).out.startswith(f"{output.stem}: ")


def test_frequency_window_and_harmonics_can_be_given(springpot, records):
    options = ("--frequency", "2", "--window", "1", "4", "--harmonics", "1", "--json")
    [row] = springpot("signals", records[1], *options).json["rows"]
    assert row["frequency"] == 2.0
    assert abs(row["storage"] - _stiffness(2.0).real) < 4 * row["storage_sd"]


def test_bad_input_is_one_line(springpot, records, damper, tmp_path):
    assert springpot("signals").is_one_line("missing argument")
    assert springpot("signals", tmp_path / "none.csv").is_one_line("none.csv")
    assert springpot("signals", damper).is_one_line("damper.csv", "signals")
    assert springpot("signals", records[0], "--frequency", "0").is_one_line("--frequency")
    assert springpot("signals", records[0], "--window", "90", "99").is_one_line("window")
    assert springpot("signals", records[0], "-o", tmp_path / "no" / "a.csv").is_one_line(
        "no folder"
    )
    assert springpot("signals", records[0], "-o", tmp_path).is_one_line("is a folder")
