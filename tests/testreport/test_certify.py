"""``springpot certify``: a code is met or not, how sure that is, and why not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.testreport import LoopRecord
from springpot.testreport.code import amount, between, ratio_of_units, read_code

CODES = Path(__file__).resolve().parents[2] / "docs" / "codes"
DAMPING = 20.0 / (20.0 * 2.0 * np.pi)
"""Gives 20 kN at the speed of 20 mm and 1 Hz."""
SIMPLE = """[code]
name = "a < b"
source = "none"

[[require]]
name = "=energy"
quantity = "W_d"
of = "test"
to = "mean"
within = "10 %"
"""


def record(path, force, cycles=6, per_cycle=60):
    rng = np.random.default_rng(len(path.name))
    t = np.arange(cycles * per_cycle + 1) / per_cycle
    x, v = 20.0 * np.sin(2.0 * np.pi * t), 40.0 * np.pi * np.cos(2.0 * np.pi * t)
    pulled = force(x, v)
    pulled = pulled + 0.004 * np.abs(pulled).max() * rng.standard_normal(len(t))
    rows = np.column_stack([t, x, pulled, 20.0 + t])
    header = "time [s],displacement [mm],force [kN],temperature [degC]"
    path.parent.mkdir(exist_ok=True)
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.8g")


def damper(size):
    return lambda x, v: size * DAMPING * v + 0.3 * x


def loose(x, v):
    """With play and weak: it takes a third less."""
    return 0.9 * np.sign(x) * np.maximum(np.abs(x) - 5.0, 0.0) + 0.65 * DAMPING * v


@pytest.fixture
def tests(tmp_path):
    folder = tmp_path / "tests"
    record(folder / "design-1.csv", damper(1.02))
    record(folder / "design-2.csv", damper(0.98))
    (folder / "README.md").write_text("what these are", encoding="utf-8")
    return folder


def test_tests_that_are_as_asked_conform(springpot, tests, tmp_path):
    page = tmp_path / "certificate.html"
    told = springpot("certify", tests, "--code", CODES / "viscous-damper.toml", "-o", page)
    assert told.code == 0, told.err
    assert "conforming: of 12 rows 12 conforming" in told.out
    assert "unchecked" in told.out
    text = page.read_text(encoding="utf-8")
    for word in (
        "unchecked",
        "calibration of the load cell",
        "Budget of uncertainty",
        "data:image",
    ):
        assert word in text
    answer = springpot("certify", tests, "--code", CODES / "viscous-damper.toml", "--json").json
    assert answer["schema"] == "springpot.certificate/1"
    row = next(row for row in answer["rows"] if row["name"] == "force against the nominal")
    assert row["value"] == pytest.approx(1.02, abs=row["expanded"])
    names = [line["name"] for line in row["lines"]]
    assert names[1:] == [
        "calibration of the load cell", "calibration of the displacement",
        "lag between the channels",
    ]  # fmt: skip
    assert row["lines"][1]["standard"] == pytest.approx(row["value"] * 0.005 / 1.96, rel=1e-3)


@pytest.mark.soak
def test_where_a_test_fails_its_hidden_effect_is_named(springpot, tests):
    record(tests / "design-2.csv", loose)
    told = springpot("certify", tests, "--code", CODES / "viscous-damper.toml", "--json")
    assert told.code == 1
    answer = json.loads(told.out)
    assert answer["verdict"] == "not conforming"
    reasons = {each["test"]: each for each in answer["reasons"]}
    assert reasons["design-2"]["effects"] == ["dead-zone"]
    assert reasons["design-1"]["effects"] == []


@pytest.mark.soak
def test_a_lag_that_no_single_frequency_shows_is_found_in_all_of_them(tmp_path, rng):
    """A channel that is 4 ms late makes a damper softer the faster it moves."""
    code, records = tmp_path / "code.toml", []
    asked = '[nominal]\nK_eff = "0.8 kN/mm"\n' + SIMPLE.replace("W_d", "K_eff")
    asked = asked.replace('to = "mean"', 'to = "nominal"').replace("10 %", "5 %")
    code.write_text(asked.replace("[code]", '[code]\nmodel = "kelvin"'), encoding="utf-8")
    for frequency in (0.5, 1.0, 2.0, 4.0, 8.0):
        omega = 2.0 * np.pi * frequency
        t = np.arange(4 * 40 + 1) / (40.0 * frequency)
        late = omega * (t - 0.004)
        force = 8.0 * np.sin(late) + 0.1 * omega * np.cos(late)
        force += 0.003 * force.max() * rng.standard_normal(len(t))
        record_ = LoopRecord(t, 10.0 * np.sin(omega * t), force, "mm", "kN", f"{frequency:g} Hz")
        records.append(record_)
    certificate = springpot.certify(records, code)
    assert [row.test for row in certificate.rows if row.verdict == "not conforming"] == ["8 Hz"]
    together = certificate.reasons[-1]
    assert together.test == "all 5 tests together"
    assert "time-delay" in together.effects


def test_what_goes_with_the_temperature_is_told_where_no_diagnosis_can_be(tests, monkeypatch):
    """It softens by 3 % a cycle while it warms by 1 K."""

    def refused(*given):
        raise DataError("too short")

    monkeypatch.setattr("springpot.testreport.certificate.diagnose", refused)
    rows = np.arange(361) / 60.0
    record(tests / "design-2.csv", lambda x, v: (0.6 * DAMPING * v) * np.exp(-0.03 * rows))
    certificate = springpot.certify(tests, CODES / "viscous-damper.toml")
    says = " ".join(next(e for e in certificate.reasons if e.test == "design-2").says)
    assert "% a cycle while the temperature changes by +1 K" in says
    assert "no diagnosis: too short" in says


def test_required_tests_that_are_missing_fail_a_code(springpot, tests):
    (tests / "design-2.csv").unlink()
    told = springpot("certify", tests, "--code", CODES / "viscous-damper.toml", "--no-why")
    assert told.code == 1
    assert "missing: 'cycles at the design speed' asks for 2 with 5 whole cycles" in told.out


def test_property_factors_are_measured_multiplied_and_limited(tmp_path):
    folder = tmp_path / "tests"
    record(folder / "design-1.csv", lambda x, v: 0.3 * x + 4.0 * np.sign(v))
    record(folder / "cold-1.csv", lambda x, v: 0.33 * x + 4.4 * np.sign(v))
    certificate = springpot.certify(folder, CODES / "isolator.toml")
    cold, system = certificate.factors[1:]
    assert cold.high.value == pytest.approx(1.1, abs=cold.high.expanded)
    # The load cell is the same: only the temperatures, each test's own, and the noise are left.
    assert "calibration of the load cell" not in [
        line.name for line in cold.high.lines if line.standard > 1e-9
    ]
    assert system.high.value == pytest.approx(1.0 + 0.75 * (1.1 * cold.high.value - 1.0))
    assert certificate.verdict == "conforming"


def test_a_result_nearer_to_a_limit_than_its_uncertainty_is_undecided(tests, tmp_path):
    code = tmp_path / "code.toml"
    code.write_text(SIMPLE.replace("10 %", "2 %"), encoding="utf-8")
    certificate = springpot.certify(tests, code, why=False)
    assert certificate.verdict == "undecided"
    assert all(0.01 < row.risk < 0.99 for row in certificate.rows)


def test_files_run_nothing_and_pages_are_escaped(springpot, tests, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    code, book, page = (tmp_path / name for name in ("code.toml", "c.xlsx", "c.html"))
    code.write_text(SIMPLE, encoding="utf-8")
    assert springpot("certify", tests, "--code", code, "-o", book).code == 0
    sheet = openpyxl.load_workbook(book)["certificate"]
    assert sheet["A2"].value == "=energy"
    assert sheet["A2"].data_type == "s"
    assert springpot("certify", tests, "--code", code, "-o", page).code == 0
    text = page.read_text(encoding="utf-8")
    assert "a &lt; b" in text
    assert "a < b" not in text


def test_a_file_that_is_no_record_is_named_and_not_passed_over(springpot, tests, tmp_path):
    (tests / "design-3.csv").write_text("nothing here\n", encoding="utf-8")
    code = tmp_path / "code.toml"
    code.write_text(SIMPLE, encoding="utf-8")
    told = springpot("certify", tests, "--code", code)
    assert told.code == 0
    assert "left out: " in told.out
    assert "design-3.csv" in told.out


@pytest.mark.parametrize(("before", "after", "says"), [
    ("[code]", "[kode]", "there is no 'kode'"),
    ('source = "none"', "", "[code]: source is text"),
    ('"W_d"', '"W"', "[[require]] 1: quantity 'W' is none of"),
    ('within = "10 %"', "", "give within = '15 %', or low and high"),
    ('within = "10 %"', 'within = "10 kN"', "[[require]] 1: within"),
    ('to = "mean"', 'to = "nominal"', "[nominal] has no W_d"),
    ('of = "test"', 'of = "tests"', "of is cycle or test or mean"),
    ("[[require]]", "[[require", "is no TOML"),
    ('to = "mean"\nwithin = "10 %"', 'to = "value"\nlow = "3 N"', "is no unit of what is in kN mm"),
    ('source = "none"', 'source = "none"\nstatus = "signed"', "needs signed_by"),
    ('within = "10 %"', 'within = "10 %"\nrecords = "cold*"', "no test is named cold*"),
])  # fmt: skip
def test_a_wrong_code_is_one_line_with_file_and_key(
    springpot, tests, tmp_path, before, after, says
):
    path = tmp_path / "mine.toml"
    assert before in SIMPLE
    path.write_text(SIMPLE.replace(before, after), encoding="utf-8")
    assert springpot("certify", tests, "--code", path).is_one_line("mine.toml", says)


def test_an_error_is_stated_with_its_unit(tmp_path):
    path = tmp_path / "mine.toml"
    error = '\n[[error]]\nname = "lag"\nacts = "phase"\naccuracy = "0.3 deg"\nmeans = "limits"\n'
    path.write_text(SIMPLE + error, encoding="utf-8")
    assert read_code(path).errors[0].standard == pytest.approx(np.radians(0.3) / np.sqrt(3.0))
    path.write_text(SIMPLE + error.replace("0.3 deg", "0.3"), encoding="utf-8")
    with pytest.raises(DataError, match=r"mine.toml: \[\[error\]\] 1: .*"):
        read_code(path)


@pytest.mark.parametrize("path", sorted(CODES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_examples_say_that_nobody_has_checked_them(path):
    code = read_code(path)
    assert code.status == "unchecked"
    assert code.source


def test_amounts_are_read_in_any_spelling_of_their_unit():
    assert amount("1.4 kJ", "kN mm") == pytest.approx(1400.0)
    assert amount("2 kip/in", "N/mm") == pytest.approx(350.253, rel=1e-5)
    assert amount("15 %", "-") == pytest.approx(0.15)
    assert between("0.9..1.1 Hz", "Hz") == (0.9, 1.1)
    assert between("..40 mm", "mm") == (-np.inf, 40.0)
    assert ratio_of_units("kN s/m", "N s/mm") == pytest.approx(1.0)
    for wrong in ("1 kN", "ten mm", "1 mm/mm/mm", "3..1 mm"):
        with pytest.raises(DataError):
            (between if ".." in wrong else amount)(wrong, "mm")
