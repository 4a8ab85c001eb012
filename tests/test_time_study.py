"""The study of tests in time and at frequencies.

On artificial data its pages are right, on one specimen all hold.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from springpot.registry import parse_model

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def beside(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "studies"))


@pytest.fixture
def study(monkeypatch):
    spec = importlib.util.spec_from_file_location(
        "time_and_frequency", ROOT / "studies" / "time_and_frequency.py"
    )
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "time_and_frequency", module)
    spec.loader.exec_module(module)
    return module


def write(folder, name, header, columns):
    lines = [
        header,
        *("\t".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns), strict=True)),
    ]
    (folder / name).write_text("\n".join(lines) + "\n")


@pytest.mark.soak
def test_three_tests_of_one_model_predict_each_other(study, tmp_path, monkeypatch, capsys):
    folder = tmp_path / "data" / "polystyrene-three-tests"
    folder.mkdir(parents=True)
    model, rng = parse_model("fractional-maxwell"), np.random.default_rng(1)
    theta, t, omega = (
        model.theta(k=1e5, c=1e5, alpha=0.6),
        np.geomspace(0.1, 100.0, 80),
        np.geomspace(0.01, 10.0, 40),
    )
    noise = [1.0 + 0.01 * rng.normal(size=n) for n in (80, 80, 40, 40)]
    k = model.stiffness(theta, omega)
    write(
        folder,
        "stressrelaxation_ps160_data.csv",
        "Time\tRelaxation Modulus",
        (t, model.relaxation(theta, t) * noise[0]),
    )
    write(
        folder,
        "creep_ps160_data.csv",
        "Time\tCreep Compliance",
        (t, model.creep(theta, t) * noise[1]),
    )
    header = "Angular Frequency\tStorage Modulus\tLoss Modulus"
    write(
        folder, "oscillation_ps160_data.csv", header, (omega, k.real * noise[2], k.imag * noise[3])
    )
    monkeypatch.setenv("SPRINGPOT_DATA", str(tmp_path / "data"))
    out = tmp_path / "out"
    monkeypatch.setattr(
        sys, "argv", ["x", "--temperature", "160", "--model", "fractional-maxwell", "-o", str(out)]
    )
    study.main()
    page = (out / "README.md").read_text()
    assert "Of 6 predictions 6 hold, 0 do not" in page
    assert page.count("| yes |") == 3
    assert len((out / "predictions.csv").read_text().splitlines()) == 7
    assert capsys.readouterr().out.count("holds") == 6


def test_without_the_data_it_says_where_they_should_be(study, monkeypatch):
    monkeypatch.setenv("SPRINGPOT_DATA", "")
    with pytest.raises(SystemExit, match="SPRINGPOT_DATA"):
        study.tests_at(160)


@pytest.mark.soak
def test_a_building_drifts_right_with_the_right_damper_only(tmp_path, monkeypatch, capsys):
    spec = importlib.util.spec_from_file_location(
        "structure_drift", ROOT / "studies" / "structure_drift.py"
    )
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "structure_drift", module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "MODELS", ("fractional-maxwell + inertia", "kelvin"))
    monkeypatch.setattr(sys, "argv", ["x", "--records", "1", "-o", str(tmp_path)])
    module.main()
    _, _, right, wrong = (tmp_path / "drifts.csv").read_text().splitlines()
    assert abs(float(right.split(",")[3])) < 0.2
    assert float(wrong.split(",")[3]) > 2.0
    assert "true damper" in capsys.readouterr().out
