"""``springpot identify`` of many files, jointly, and of what a user knows.

Text that fits its window.
"""

import csv
import io
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import springpot as library
from springpot.cli import diagnose, group
from springpot.cli.common import of_each
from springpot.identification import Value
from springpot.measurement import joined
from springpot.report.text import TextTable, shown, width, wrapped

pytestmark = pytest.mark.usefixtures("asked_once")

MODEL = ("--model", "fractional-maxwell")


@pytest.fixture
def dampers(write, rng):
    """Three dampers of one kind, the last with another spring."""
    paths = []
    for i, k in enumerate((400.0, 400.0, 500.0)):
        frequency = np.geomspace(0.5, 50.0, 15)
        stiffness = 1.0 / (1.0 / k + 1.0 / (60.0 * (2j * np.pi * frequency) ** 0.5))
        stiffness *= 1.0 + 0.01 * (rng.normal(size=15) + 1j * rng.normal(size=15))
        rows = zip(
            frequency.tolist(), stiffness.real.tolist(), stiffness.imag.tolist(), strict=True
        )
        text = "frequency [Hz],storage [kN/m],loss [kN/m]\n" + "".join(
            f"{a!r},{b!r},{c!r}\n" for a, b, c in rows
        )
        paths.append(write(text, f"damper{i}.csv"))
    return paths


def test_each_file_has_its_row_and_a_bad_one_stops_nobody(springpot, dampers, tmp_path):
    answer = springpot("identify", dampers[0], tmp_path / "no.csv", dampers[2], *MODEL)
    assert answer.code == 2
    assert "no.csv" in answer.err
    header, _, *rows = answer.out.splitlines()
    assert header.split()[:2] == ["data", "error"]
    assert "k [kN/m]" in header
    assert [row.split()[0] for row in rows] == ["damper0", "damper2"]


def test_csv_holds_values_ends_and_verdict(springpot, dampers):
    answer = springpot("identify", *dampers, *MODEL, "--csv")
    assert (answer.code, answer.err) == (0, "")
    rows = list(csv.DictReader(io.StringIO(answer.out)))
    assert [row["data"] for row in rows] == ["damper0", "damper1", "damper2"]
    for row, k in zip(rows, (400.0, 400.0, 500.0), strict=True):
        low, value, high = (float(row[f"{name} [kN/m]"]) for name in ("k_low", "k", "k_high"))
        assert low < value < high
        assert value == pytest.approx(k, rel=0.05)
        assert row["good_enough"] == "true"
        assert 0.003 < float(row["noise_floor [-]"]) < 0.03


def test_json_of_many_files_is_lines(springpot, dampers):
    lines = [
        json.loads(line)
        for line in springpot("identify", *dampers, *MODEL, "--json").out.splitlines()
    ]
    assert [line["data"] for line in lines] == ["damper0", "damper1", "damper2"]


def test_a_joint_fit_is_narrower_and_says_where_it_is_not_good_enough(springpot, dampers):
    alone = springpot("identify", dampers[0], *MODEL, "--json").json["parameters"]["k"]
    together = springpot("identify", *dampers[:2], *MODEL, "--joint", "--json").json
    both = together["parameters"]["k"]
    assert together["data"] == "damper0 + damper1"
    assert both["high"] - both["low"] < alone["high"] - alone["low"]
    assert together["error"]["good_enough"]
    assert together["error"]["noise_source"] == "repeats"
    different = springpot("identify", *dampers, *MODEL, "--joint", "--json").json
    assert different["error"]["relative_rms"] > 2.0 * together["error"]["relative_rms"]


def test_joint_files_keep_their_names_units_and_conditions():
    one = library.Measurement([1.0], [1.0 + 1j], units=library.Units("kN/m", "mm"), name="one")
    two = library.Measurement([2.0], [3.0 + 1j], units=library.Units("N/mm", "mm"), name="two")
    both = joined([one, two])
    assert both.stiffness.tolist() == [1.0 + 1j, 3.0 + 1j]
    assert both.labels["file"].tolist() == ["one", "two"]
    in_newton = joined([library.Measurement([1.0], [1.0 + 1j], units=library.Units("N/m")), one])
    assert in_newton.stiffness.tolist() == [1.0 + 1j, 1000.0 + 1000.0j]
    with pytest.raises(library.errors.DataError, match="no joint test"):
        joined([one, library.Measurement([1.0], [1.0 + 1j])])
    hot = library.Measurement(
        [1.0], [1.0 + 1j], conditions={"temperature": [20.0]}, units=one.units
    )
    with pytest.raises(
        library.errors.DataError, match=r"one lacks temperature.*'FILE\?temperature=20\[degC\]'"
    ):
        joined([one, hot])


def test_a_test_that_is_named_twice_does_not_count_as_two(springpot, dampers):
    """Its intervals would be narrower by a factor of 1.4."""
    answer = springpot("identify", dampers[0], dampers[0], *MODEL, "--joint")
    assert answer.is_one_line("hold the same numbers: name each test once")


def test_joint_files_need_not_share_what_no_effect_knows():
    counted = {"point": [1.0, 2.0], "temperature": [20.0, 20.0]}
    one = library.Measurement([1.0, 2.0], [1.0 + 1j, 2.0 + 1j], conditions=counted, name="one")
    two = library.Measurement([3.0], [1.0 + 1j], conditions={"temperature": [20.0]}, name="two")
    both = joined([one, two])
    assert set(both.conditions) == {"temperature"}
    assert both.provenance["note columns"] == "point: known of some of the files only, and left out"


@pytest.mark.soak
def test_what_is_known_beforehand_is_an_option(springpot, dampers):
    options = (
        "--fix",
        "alpha=0.5",
        "--bounds",
        "k=0:350",
        "--start",
        "c=50",
        "--exclude",
        "frequency=..1",
    )
    answer = springpot("identify", dampers[0], *MODEL, *options, "--json").json
    alpha = answer["parameters"]["alpha"]
    assert (alpha["value"], alpha["fixed"]) == (0.5, True)
    assert answer["parameters"]["k"]["value"] == pytest.approx(350.0)
    assert len(answer["kept"]["measurement"]["omega"]) == 12
    told = springpot("identify", f"{dampers[0]}@frequency=1..10", *MODEL, "--fix", "alpha=0.5")
    assert "fixed" in told.out
    assert "points, 1.3" in told.out
    diagnosed = springpot("diagnose", dampers[0], *MODEL, "--fix", "alpha=0.8")
    assert "(with alpha = 0.8 held)" in diagnosed.out.splitlines()[0]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--fix", "alpha"), "name=value"),
        (("--fix", "alpha=high"), "no number"),
        (("--bounds", "k=5"), "name=low:high"),
        (("--exclude", "speed=1"), "no condition 'speed'"),
        (("--optimiser", "pso-paper:swarm=3"), "no option 'swarm'"),
        (("--csv", "--json"), "not both"),
    ],
)
def test_what_cannot_be_is_one_line(springpot, dampers, options, says):
    assert springpot("identify", dampers[0], *MODEL, *options).is_one_line(says)


def test_options_of_an_optimiser_count(springpot, dampers):
    options = ("--budget", "60", "--seed", "1", "--json")
    few, many = (
        springpot(
            "identify", dampers[0], *MODEL, "--optimiser", f"pso-paper:particles={n}", *options
        ).json
        for n in (5, 30)
    )
    assert few["objective"]["value"] != many["objective"]["value"]


@pytest.mark.soak_cases("72")
@pytest.mark.parametrize("columns", [72])
def test_no_line_is_wider_than_the_window_but_for_rows_of_tables(springpot, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = springpot("diagnose", "artificial-hidden", *MODEL).out
    lines = [
        line
        for line in text.splitlines()
        if not line.startswith(("next: ", "inertia ", "time-", "fixture", "--"))
    ]
    assert max(width(line) for line in lines if "probability" not in line) <= columns
    assert text.splitlines()[-1].startswith(
        "next: springpot discover artificial-hidden --model fractional-maxwell"
    )
    assert "-v tells" in text
    assert len(springpot("diagnose", "artificial-hidden", *MODEL, "-v").out) > len(text)


def test_a_narrow_window_goes_without_the_spare_columns():
    table = TextTable(("a", "spare", "b"), [("1", "x" * 30, "2")])
    spare = replace(table, spare=("spare",))
    assert spare.fitted(20).headers == ["a", "b"]
    assert spare.fitted(60).headers == ["a", "spare", "b"]
    assert wrapped("  one two three", 9) == "  one two\n    three"


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (Value(1e-90, 8.5e-191, 1.4e197, "s"), ("-", "not determined")),
        (Value(7.4e12, 5e4, np.inf, "kN/m"), ("-", "not determined, above 50000")),
        (Value(1e-9, 0.0, 12.0, "kN/m"), ("0", "[0, 12]")),
        (Value(-0.033, -0.99, np.inf, "-"), ("-", "not determined")),
        (Value(0.0, 0.0, np.inf, "N s/mm"), ("-", "not determined")),
        (Value(0.5, 0.5, 0.5, "-", fixed=True), ("0.5000", "fixed")),
        (Value(400.1, 399.2, 401.0, "kN/m"), ("400.1", "[399.2, 401.0]")),
    ],
)
def test_what_the_data_leave_open_is_no_number(value, told):
    assert shown(value) == told


@pytest.mark.parametrize(
    ("raised", "code", "said"),
    [(KeyboardInterrupt, 130, "interrupted: 1 of 2 are done\n"), (BrokenPipeError, 141, "")],
)
def test_only_who_interrupts_is_told_how_far_it_came(capsys, monkeypatch, raised, code, said):
    """A reader that has gone, such as ``head``, interrupted nothing."""
    monkeypatch.setattr("os.dup2", lambda *_: None)

    def answer(name):
        if name == "b":
            raise raised

    assert of_each(["a", "b"], answer) == code
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(("verdict", "told"), [("adequate", True), ("effect-missing", False)])
def test_only_sweeps_that_the_model_follows_are_compared(monkeypatch, capsys, verdict, told):
    """What is missing bends the parameters otherwise in each band."""
    values = {"a": 400.0, "b": 440.0}

    def answered(data: list[str], *_: object) -> SimpleNamespace:
        value = values[data[0]]
        found = {"k": Value(value, 0.99 * value, 1.01 * value, "kN/m")}
        return SimpleNamespace(verdict=verdict, data=data[0], parameters=found)

    monkeypatch.setattr(diagnose, "opened", lambda name, geometry: name)
    monkeypatch.setattr(diagnose.timetests, "named_tests", lambda data, geometry: None)
    monkeypatch.setattr(diagnose, "_answer", answered)
    assert group.run(["diagnose", "a", "b", "-m", "kelvin"]) == 0
    note = "note: each was judged by itself"
    assert (note in capsys.readouterr().out) is told
    # Each line of JSON is an answer.
    assert group.run(["diagnose", "a", "b", "-m", "kelvin", "--json"]) == 0
    out, err = capsys.readouterr()
    assert note not in out
    assert (note in err) is told
