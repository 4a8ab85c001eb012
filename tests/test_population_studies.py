"""The studies of populations and certificates: what they draw, and what their tables must show."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

import springpot

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def studies(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "studies"))
    yield
    for name in ("populations", "certificates"):
        sys.modules.pop(name, None)


def rows(name: str) -> list[dict[str, str]]:
    with (ROOT / "results" / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_hidden_mass_leaves_what_it_is_said_to():
    import populations

    omega, mass = populations.OMEGA, populations.hidden_mass(15.0)
    exact = 100.0 + 2.0j * omega - mass * omega**2
    sd = populations.NOISE * np.abs(exact) * (1.0 + 1.0j)
    left = springpot.identify(springpot.Measurement(omega, exact, sd=sd), "kelvin")
    # Deviations of each part; the mass changes them a little.
    assert left.cost == pytest.approx(15.0, rel=0.05)


def test_means_are_covered_and_components_found():
    for row in rows("populations/covered"):
        assert 0.93 <= float(row["means held"]) <= 0.97
        assert float(row["within / truth"]) == pytest.approx(1.0, abs=0.2)
        assert float(row["batches / truth"]) == pytest.approx(1.0, abs=0.2)


def test_scatter_is_no_effect_and_one_in_all_specimens_is_found():
    share = {row["what"]: float(row["share"]) for row in rows("populations/judged")}
    assert share["scatter taken for an effect"] <= 0.02
    assert share["hidden effect found"] >= 0.95
    assert share["by one specimen alone"] < 0.5


def test_a_thousand_specimens_take_less_than_a_minute():
    for row in rows("populations/costs"):
        spent = float(row["fit, intervals, population [s]"]) + float(row["judgement [s]"])
        assert spent < 60.0 * max(int(row["specimens"]) / 1000, 1)


@pytest.mark.soak
def test_certificates_cover_and_decide_as_they_say(tmp_path):
    for row in rows("certificates/covered"):
        assert float(row["covers"]) == pytest.approx(0.95, abs=0.02)
    for row in rows("certificates/risked"):
        assert float(row["are outside"]) == pytest.approx(float(row["its mean"]), abs=0.07)
    import certificates

    code = certificates.code_at(tmp_path, 1.0)
    found = certificates.first_rows(np.random.default_rng(1), code)
    assert [row.name for row in found] == [name for name, *_ in certificates.ASKED]
    assert all(row.verdict == "conforming" for row in found)
