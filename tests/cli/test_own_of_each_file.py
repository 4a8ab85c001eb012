"""``--own``: parameters that each file, or each level of a column, has for itself."""

import numpy as np
import pytest

from springpot import read

FREQUENCY = np.geomspace(0.5, 50.0, 10)


@pytest.fixture
def specimens(write):
    """Two files, one stiffer than the other, with the same dashpot."""

    def table(k):
        rows = [f"{f:.5g},{k},{0.8 * np.pi * f:.6g}" for f in FREQUENCY]
        return "\n".join(["frequency [Hz],storage [N/mm],loss [N/mm]", *rows])

    return [write(table(90.0), "soft.csv"), write(table(110.0), "stiff.csv")]


def test_each_file_has_its_own_where_no_column_is_named(springpot, specimens):
    found = springpot("identify", *specimens, "--joint", "-m", "kelvin", "--own", "k", "--json")
    parameters = found.json["parameters"]
    assert parameters["k_1"]["value"] == pytest.approx(90.0, rel=1e-5)
    assert parameters["k_2"]["value"] == pytest.approx(110.0, rel=1e-5)
    assert "file: 1 is soft, 2 is stiff" in found.json["notes"]


@pytest.mark.soak
def test_a_prediction_says_of_which_level(springpot, specimens, tmp_path):
    fit = tmp_path / "fit.json"
    fit.write_text(
        springpot("identify", *specimens, "--joint", "-m", "kelvin", "--own", "k", "--json").out
    )
    told = springpot("predict", fit, "--frequency", "1", "--at", "file=2", "--json")
    assert told.json["points"][0]["storage"] == pytest.approx(110.0, rel=1e-5)
    named = springpot("predict", fit, "-f", "1", "--at", f"file={specimens[1].stem}", "--json")
    assert named.json["points"] == told.json["points"]
    assert named.json["points"][0]["file"] == specimens[1].stem
    table = tmp_path / "one.csv"
    springpot("predict", fit, "-f", "1", "--at", "file=2", "-o", table)
    assert read(table).labels["file"].tolist() == [specimens[1].stem]
    quantities = springpot("quantities", fit, "--at", "file=2", "--json").json["quantities"]
    assert {row["at"]["file"] for row in quantities} == {specimens[1].stem}
    springpot("predict", fit, "--frequency", "1").is_one_line("depends on file", "file=")


def test_what_is_no_parameter_or_column_is_one_line(springpot, specimens):
    one = specimens[0]
    springpot("identify", one, "-m", "kelvin", "--own", "k:").is_one_line("NAMES:COLUMN")
    springpot("identify", one, "-m", "kelvin", "--own", "k:day").is_one_line("no column 'day'")
    springpot("diagnose", one, "-m", "kelvin", "--own", "k:row").is_one_line("no column 'row'")
    springpot("diagnose", one, "-m", "kelvin", "--own", "q:row").is_one_line(
        "no free parameter 'q'"
    )


@pytest.mark.soak
def test_a_population_has_every_parameter_for_itself(springpot, specimens, write):
    third = write(specimens[0].read_text().replace(",90.0,", ",100.0,"), "third.csv")
    found = springpot(
        "identify", *specimens, third, "--joint", "-m", "kelvin", "--population", "file", "--json"
    )
    assert set(found.json["population"]) == {"k", "c"}
    assert list(found.json["specimens"])[2] == "third"
    assert found.json["specimens"][specimens[1].stem]["k"] == pytest.approx(110.0, rel=1e-5)


@pytest.mark.soak
def test_files_that_are_specimens_need_no_further_word(springpot, specimens):
    one = springpot("identify", *specimens, "--joint", "-m", "kelvin", "--own", "k", "--json").json
    for words in (("--own", "k"), ("--population", "file", "--share", "c"), ("--share", "c")):
        found = springpot("identify", *specimens, "-m", "kelvin", *words, "--json").json
        assert found["parameters"] == one["parameters"]
    # A column of each file is its own matter.
    apart = springpot("identify", *specimens, "-m", "kelvin", "--own", "k:day")
    assert apart.err.count("no column 'day'") == 2


@pytest.mark.soak
def test_specimens_are_judged_and_discovered_together(springpot, write, tmp_path):
    files, rng = [], np.random.default_rng(1)
    for i, k in enumerate((90.0, 100.0, 110.0)):
        omega = 2.0 * np.pi * FREQUENCY
        parts = k - 2e-3 * omega**2, 0.4 * omega
        parts = [each + 0.3 * rng.standard_normal(10) for each in parts]
        rows = [
            ",".join(f"{value:.8g}" for value in row) for row in zip(FREQUENCY, *parts, strict=True)
        ]
        table = "\n".join(["frequency [Hz],storage [N/mm],loss [N/mm]", *rows])
        files.append(write(table, f"s{i}.csv"))
    words = ["-m", "kelvin", "--own", "k", "--effects", "inertia,hysteretic-loss"]
    text = springpot("diagnose", *files, *words).out
    assert "of s0 + s1 + s2: effect-missing" in text
    named = " ".join(map(str, files))
    assert f"springpot discover {named} --model kelvin --accept inertia --own k" in text
    report = tmp_path / "report.html"
    ladder = springpot("discover", *files, *words, "inertia", "--report", report, "--json").json
    assert all(f"file s{i}" in report.read_text() for i in range(3))
    assert ladder["steps"][-1]["accepted"] == "inertia"
    assert ladder["verdict"] == "adequate"
