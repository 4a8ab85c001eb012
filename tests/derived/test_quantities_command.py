"""``springpot quantities``."""

import numpy as np
import pytest

FREQUENCY = np.geomspace(0.1, 20.0, 15)


@pytest.fixture
def sweep(write):
    """A Maxwell element of 100 kN/m and 10 kN s/m: a crossover at 10 rad/s, of 50 kN/m."""
    s = 2j * np.pi * FREQUENCY
    stiffness = 1000.0 * s / (100.0 + 10.0 * s)
    rows = zip(FREQUENCY, stiffness.real, stiffness.imag, strict=True)
    lines = [f"{a:.6g},{b:.9g},{c:.9g}" for a, b, c in rows]
    header = "frequency [Hz],storage [kN/m],loss [kN/m]"
    return write("\n".join([header, *lines]), "maxwell.csv")


def test_a_model_is_fitted_where_one_is_named(springpot, sweep):
    answer = springpot("quantities", sweep, "-m", "maxwell", "--frequency", "1", "--json").json
    rows = {row["name"]: row for row in answer["quantities"]}
    assert rows["crossover frequency"]["value"] == pytest.approx(10.0 / (2.0 * np.pi), rel=1e-5)
    assert rows["viscous constant at rest"]["unit"] == "kN s/m"
    assert rows["loss factor"]["at"] == {"frequency": 1.0}


def test_without_one_the_data_answer(springpot, sweep, tmp_path):
    table = tmp_path / "table.csv"
    out = springpot("quantities", sweep, "-o", table).out
    assert "crossover stiffness" in out
    assert "are those of a model" in out
    assert table.read_text().splitlines()[1].split(",")[5] == "data"
    assert springpot("quantities", sweep, "--csv").out == table.read_text()


def test_what_is_no_fit_and_no_data_is_one_line(springpot, tmp_path, sweep):
    springpot("quantities", tmp_path / "none.csv").is_one_line("none.csv")
    springpot("quantities", sweep, "-m", "maxwell", "--without", "inertia").is_one_line("inertia")


def test_what_would_be_ignored_is_refused(springpot, sweep, write):
    """A fit has a model, and data alone know of no temperature: both were passed over."""
    fit = write(springpot("identify", sweep, "--model", "maxwell", "--json").out, "fit.json")
    springpot("quantities", fit, "--model", "zener").is_one_line("leave out --model")
    asked = springpot("quantities", sweep, "--temperature", "50", "--without", "inertia")
    asked.is_one_line("--temperature, --without: data alone")
