"""Records of PEER, and suites of records: mean and envelope."""

from __future__ import annotations

import json

import click
import numpy as np
import pytest

from springpot.cli import group
from springpot.errors import DataError
from springpot.registry import parse_model
from springpot.structure import Damper, Frame, GroundMotion, simulate
from springpot.structure.answers import RecordSuite, described_suite
from springpot.structure.reading import read_record, records_meant

pytestmark = pytest.mark.usefixtures("asked_once")

FRAME = """[structure]
storeys = 2
mass = 1e5
stiffness = [8e7, 7e7]
damping = 0.02

[[damper]]
model = "maxwell"
parameters = { k = 40, c = 6 }
unit = "kN/mm"
storey = 1
slope = 30
"""
HEADER = """PEER NGA STRONG MOTION DATABASE RECORD
Nowhere 01/01/2000, A station, 090
ACCELERATION TIME SERIES IN UNITS OF G
"""
VALUES = np.round(0.1 * np.sin(0.7 * np.arange(13)), 7)


def at2(values=VALUES, per_line: int = 5, count: str = "NPTS=   {}, DT=   .0100 SEC,") -> str:
    """A record as PEER writes it, so many numbers a line."""
    rows = [values[i : i + per_line] for i in range(0, len(values), per_line)]
    lines = ["  ".join(f"{value:.7E}" for value in row) for row in rows]
    return HEADER + count.format(len(values)) + "\n" + "\n".join(lines) + "\n"


def scaled(factor: float) -> str:
    return at2(factor * VALUES)


@pytest.mark.parametrize("per_line", [1, 4, 5, 8])
@pytest.mark.parametrize("count", ["NPTS=   {}, DT=   .0100 SEC,", "  {}    0.0100    NPTS, DT"])
def test_a_record_of_peer_is_in_g_with_any_count_of_numbers_a_line(write, per_line, count):
    for name in ("RSN1.AT2", "renamed.txt"):
        record = read_record(str(write(at2(per_line=per_line, count=count), name)), None)
        assert record.step == pytest.approx(0.01)
        assert record.acceleration == pytest.approx(9.80665 * VALUES)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("UNITS OF G", "UNITS OF CM/S"), "line 3: 'ACCELERATION TIME SERIES IN UNITS OF CM/S'"),
        (("ACCELERATION TIME", "VELOCITY TIME"), "line 3: .* give the .AT2 file"),
        (("NPTS=   13", "NPTS=   14"), "line 4: NPTS says 14 numbers, and there are 13"),
        (("NPTS", "N"), "line 4: no NPTS= and DT="),
        (("DT=   .0100", "DT=   .0"), "does not rise"),
        (("DT=   .0100", "DT=   ."), "line 4: no NPTS= and DT="),
        ((f"{VALUES[6]:.7E}", "1.0E"), "line 6: could not convert"),
        ((f"{VALUES[6]:.7E}", "nan"), "sample 7 is no number"),
    ],
)
def test_a_bad_record_of_peer_is_one_line_with_its_place(write, change, says):
    path = write(at2().replace(*change), "bad.at2")
    with pytest.raises(DataError, match=says) as told:
        read_record(str(path), None)
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)


def test_a_folder_is_its_records_and_a_pattern_what_it_fits(write, tmp_path):
    for name in ("b.AT2", "a.csv", "notes.md"):
        write(at2(), name)
    folder = write("", "x").parent
    names = [str(folder / name) for name in ("a.csv", "b.AT2")]
    assert records_meant([str(folder)]) == names
    assert records_meant([str(folder / "*.AT2"), names[0]]) == names[::-1]
    assert records_meant(["artificial:2"]) == ["artificial:2"]
    # A file that is there is meant, whatever signs its name has.
    bracket = str(write(at2(), "a[1].at2"))
    assert records_meant([bracket]) == [bracket]
    with pytest.raises(DataError, match="no record there"):
        records_meant([str(folder / "*.none")])


def test_mean_and_envelope_are_those_of_the_records_each_alone(springpot, write):
    """The structure is linear: twice the record is twice the drift."""
    frame = write(FRAME, "frame.toml")
    paths = [write(scaled(factor), f"r{factor:g}.at2") for factor in (1.0, 2.0, 6.0)]
    picture = frame.parent / "suite.svg"
    many = [word for path in paths for word in ("--record", path)]
    answer = springpot("simulate", frame, *many, "--figure", picture, "--json").json
    alone = springpot("simulate", frame, "--record", paths[0], "--json").json
    assert answer["schema"] == "springpot.simulations/1"
    assert answer["records"][0] == alone
    assert picture.stat().st_size > 2_000
    for storey, one in zip(answer["storeys"], alone["storeys"], strict=True):
        for name in ("drift", "damper_force"):
            assert storey[name]["mean"] == pytest.approx(3.0 * one[name])
            assert storey[name]["envelope"] == pytest.approx(6.0 * one[name])
        assert storey["drift"]["worst"] == "r6"
    [damper], [one] = answer["dampers"], alone["dampers"]
    for name in ("axial_force", "stroke"):
        assert damper[name]["mean"] == pytest.approx(3.0 * one[name])
        assert damper[name]["envelope"] == pytest.approx(6.0 * one[name])
    told = springpot("simulate", frame, *many).out
    for word in ("3 records", "drift 2 [mm]", "envelope", "stroke 1 [mm]", "r6"):
        assert word in told
    assert "band" not in told


def test_one_bad_record_of_many_stops_none_of_the_others(springpot, write, tmp_path):
    frame, suite = write(FRAME, "frame.toml"), tmp_path / "suite"
    suite.mkdir()
    for name, text in (("a.at2", scaled(1.0)), ("b.at2", "none\n"), ("c.at2", scaled(3.0))):
        (suite / name).write_text(text)
    answer = springpot("simulate", frame, "--record", suite, "--json")
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "b.at2, line 4" in answer.err
    whole = json.loads(answer.out)
    assert [each["record"]["name"] for each in whole["records"]] == ["a", "c"]
    assert [each["record"] for each in whole["refused"]] == [str(suite / "b.at2")]


def test_every_record_has_the_same_draws_so_that_mean_and_envelope_have_bands():
    model = parse_model("maxwell")
    theta = model.theta(k=4e7, c=6e6)
    damper = Damper(model, theta, covariance=np.diag((0.1 * theta) ** 2))
    frame = Frame([1e5], [8e7], 0.02, (damper,))
    one, three = (
        simulate(frame, GroundMotion(0.01, size * VALUES), np.random.default_rng(1), draws=5)
        for size in (1.0, 3.0)
    )
    suite = RecordSuite([one, three])
    low, high = one.band()
    assert np.all(low < high)
    for name, factor in (("mean", 2.0), ("envelope", 3.0)):
        assert np.array(suite.bands()[name]) == pytest.approx(factor * np.array([low, high]))
    result = described_suite(suite)
    assert result["storeys"][0]["drift"]["mean_low"] == pytest.approx(2.0 * low[0])


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ((), "give a --record or a --frequency"),
        (("--record", "artificial", "--frequency", "1"), "give a --record or a --frequency"),
        (("--frequency", "1", "--next-experiment"), "--next-experiment is for a --record"),
    ],
)
def test_the_ground_shakes_by_a_record_or_steadily(more, says, write):
    frame = str(write("", "frame.toml"))
    with pytest.raises(click.UsageError, match=says):
        group.run(["simulate", frame, *more])
