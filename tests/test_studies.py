"""The shipped studies.

Each loads, runs end to end with a tiny budget, and writes the same tables however it ran.
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from soaked import soaked
from springpot.benchmark import load_study, run_study
from springpot.cli.group import run as command

ROOT = Path(__file__).resolve().parents[1]
OWN = {
    "table1": {"table1"},
    "table2": {"table2", "table2_symmetric"},
    "table3": {"table3", "conclusions"},
    "table4": {"table4", "agreement"},
    "table5": {"table5", "constancy"},
    "table6": {"table6", "validity"},
    "model_error": {"model_error"},
    "nist_fluid": {"isothermal", "all_temperatures", "shift_factors"},
    "optimiser_comparison": {"ranking", "timing_by_optimiser"},
    "swarm_claim": {"swarm_overview", "swarm_ranks"},
}
"""Tables that each study of the paper adds."""
SCRIPTS = [ROOT / "studies" / f"{name}.py" for name in OWN]


@pytest.fixture(autouse=True)
def no_figures(monkeypatch):
    """Figures take most of the time; one test draws them."""
    import matplotlib.figure

    monkeypatch.setattr(
        matplotlib.figure.Figure, "savefig", lambda self, file, **_: file.write(b"figure")
    )


def small(path: Path):
    """The study with few data sets, so that a test is short; names and tables stay."""
    study = load_study(path)
    if study.name == "table2":
        return replace(study, datasets=list(study.datasets)[::10])
    if study.name == "optimiser_comparison":
        chosen = ["artificial-springpot", "artificial-fractional-maxwell-noise1"]
        return replace(
            study, datasets=chosen, models=["own"], optimisers=["pso-paper", "native", "cma-es"]
        )
    if study.name == "swarm_claim":
        return replace(study, datasets=["artificial-springpot", "artificial-springpot-noise1"])
    return study


def tables(folder: Path) -> dict[str, bytes]:
    """Everything that must not depend on how a study ran.

    All but the times and the report, which names them.
    """
    kinds, own = {".md", ".csv", ".tex", ".html"}, {"timing", "report"}
    return {
        p.name: p.read_bytes() for p in folder.iterdir() if p.suffix in kinds and p.stem not in own
    }


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_study_is_named_like_its_script_and_says_what_it_shows(path):
    study = load_study(path)
    assert study.name == path.stem
    assert study.finish is not None
    assert study.asks
    said = path.read_text(encoding="utf-8").split('"""')[1]
    assert f"springpot run studies/{path.name}" in said
    assert f"[{path.stem}" in (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")


@pytest.mark.suite_cases("table1")
@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_study_runs_with_a_tiny_budget(path, tmp_path):
    outcome = run_study(
        small(path), engine="serial", budget=60, repeats=2, out=tmp_path, quiet=True
    )
    assert outcome.failed == 0
    folder = tmp_path / path.stem
    for stem in OWN[path.stem]:
        for suffix in ("md", "csv", "tex", "html"):
            assert (folder / f"{stem}.{suffix}").stat().st_size > 0
        rows = list(csv.reader((folder / f"{stem}.csv").open(encoding="utf-8")))
        assert len(rows) > 1
        assert {len(row) for row in rows} == {len(rows[0])}
        assert not any("np." in entry for row in rows for entry in row)
    assert list(folder.glob("*.png"))
    before = tables(folder)
    again = run_study(small(path), engine="serial", budget=60, repeats=2, out=tmp_path, quiet=True)
    assert again.ran == 0
    assert tables(folder) == before


@pytest.mark.soak_cases("table3")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["table3", *map(soaked, ("nist_fluid", "table1", "table6"))])
def test_one_worker_and_two_give_the_same_bytes(name, tmp_path):
    path = ROOT / "studies" / f"{name}.py"
    found = []
    for workers in (1, 2):
        run_study(
            path, workers=workers, budget=60, repeats=2, out=tmp_path / str(workers), quiet=True
        )
        found.append(tables(tmp_path / str(workers) / name))
    assert found[0] == found[1]


@pytest.mark.soak
@pytest.mark.slow
def test_a_script_and_the_command_do_the_same(tmp_path):
    script = ROOT / "studies" / "table1.py"
    options = ["--engine", "serial", "--budget", "60", "--repeats", "2", "--out"]
    quiet = {"env": {**os.environ, "OMP_NUM_THREADS": "1"}, "check": True, "capture_output": True}
    subprocess.run([sys.executable, script, *options, tmp_path / "script"], **quiet)
    assert command(["run", str(script), *options, str(tmp_path / "command")]) == 0
    one, other = tables(tmp_path / "script" / "table1"), tables(tmp_path / "command" / "table1")
    assert one == other
    assert all(
        (tmp_path / way / "table1" / "report.html").is_file() for way in ("script", "command")
    )
    assert {"table1.md", "summary.csv", "failures.tex"} <= one.keys()


def cells(study: str, table: str, **wanted: str) -> list[dict[str, str]]:
    """Rows of a committed table that hold these entries."""
    with (ROOT / "results" / study / f"{table}.csv").open(encoding="utf-8") as stream:
        return [
            row
            for row in csv.DictReader(stream)
            if all(row[key] == value for key, value in wanted.items())
        ]


def test_committed_table_1_is_within_the_paper_s_error():
    """The native solver finds all models' parameters to the printed digits, from every seed."""
    rows = cells("table1", "table1", who="native")
    assert len(rows) == 5
    assert all(float(row["largest error"]) < 1e-6 for row in rows)
    assert all(
        float(row["as good as the paper"]) == 1.0 for row in rows if row["model"] != "springpot"
    )


def test_committed_table_2_has_errors_of_the_order_of_the_noise():
    rows = cells("table2", "table2", who="optimum (native)")
    assert len(rows) == 10
    limit = {"springpot": 1.0, "Kelvin, three parameters": 1.0, "Maxwell, three parameters": 1.0}
    for row in rows:
        assert float(row["error over noise"]) < limit.get(row["model"], 15.0)


def test_committed_table_3_collapses_to_the_maxwell_model():
    rows = cells(
        "table3", "table3", **{"data": "eq. (54) with Makris' parameters", "best run of": "native"}
    )
    by_model = {row["model"]: row for row in rows}
    kelvin, zener = (
        by_model["Kelvin type, four parameters"],
        by_model["Maxwell type, four parameters"],
    )
    maxwell = by_model["Maxwell, three parameters"]
    assert float(kelvin["k2 or k [kN/m]"]) < 1e-3
    assert float(zener["k1 [kN/m]"]) < 1e-3
    for row in (kelvin, zener):
        for column in ("c [kN s^alpha/m]", "alpha [-]"):
            assert float(row[column]) == pytest.approx(float(maxwell[column]), rel=1e-4)


def test_committed_race_says_what_the_documents_say():
    """Six optimisers always arrive, the paper's swarm in three trials of five."""
    rows = {row["optimiser"]: row for row in cells("optimiser_comparison", "ranking")}
    assert len(rows) == 17
    assert {int(row["trials"]) for row in rows.values()} == {1250}
    always = {name for name, row in rows.items() if float(row["all"]) == 1.0}
    assert always == {
        "native",
        "least-squares",
        "dual-annealing",
        "nlopt-nelder-mead",
        "cma-es",
        "differential-evolution",
    }
    assert 0.55 < float(rows["pso-paper"]["all"]) < 0.65
    assert (
        float(rows["native"]["evaluations to target"])
        < 100
        < float(rows["cma-es"]["evaluations to target"])
    )


def test_committed_ranks_of_the_swarm_are_below_those_of_cma_es_at_every_budget():
    swarms = {
        "500": "pso-paper-500",
        "2000": "pso-paper-2000",
        "8000": "pso-paper",
        "40000": "pso-paper",
    }
    for data in ("exact", "noisy"):
        for budget, swarm in swarms.items():
            (ours,) = cells("swarm_claim", "swarm_ranks", data=data, budget=budget, optimiser=swarm)
            (theirs,) = cells(
                "swarm_claim", "swarm_ranks", data=data, budget=budget, optimiser="cma-es"
            )
            assert float(ours["mean rank"]) > float(theirs["mean rank"])


def test_committed_shift_factors_are_nist_s():
    """With WLF and vertical shift a model of the paper gives NIST's shift factors to about 1 %."""
    (nist,) = cells("nist_fluid", "shift_factors", model="NIST")
    (ours,) = cells(
        "nist_fluid", "shift_factors", model="fractional-maxwell-ab + wlf-shift + vertical-shift"
    )
    for column in nist:
        if column != "model":
            assert float(ours[column]) == pytest.approx(float(nist[column]), rel=0.015)
