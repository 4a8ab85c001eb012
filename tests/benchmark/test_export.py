"""Exports hold what the store holds; where iohinspector and cocopp are installed, they read it."""

import csv
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from benchmark_fakes import Moody, Walk, artificial, measurement, small_study

from springpot.benchmark import Store, export, frame, run_study
from springpot.benchmark.trial import at
from springpot.errors import OutputError, SpringpotError, StudyError


def study(**changes):
    datasets = [artificial(), artificial(0.05, "noisy"), measurement(0.02, "measured, real")]
    models = {"measured, real": ["springpot"]}
    given = {
        "optimisers": [Walk(), ("slow <walk>", Walk(shrink=0.99)), Moody(mood="throw")],
        "repetitions": 3,
    }
    return small_study(**{"datasets": datasets, "models": models, **given, **changes})


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    run_study(study(), engine="serial", out=folder, quiet=True)
    return folder


@pytest.fixture(scope="module")
def sound(results):
    """Trials with a value, with their cells, in the order of the study."""
    with Store(results / "small" / "small.sqlite") as store:
        cells = {cell.id: cell for cell in store.cells()}
        return [
            (cells[number], row) for number, rows in store.trials() for row in rows if row.trace
        ]


def runs_of(path):
    """Tables of the runs in a .dat file, split at their headers."""
    runs = []
    for line in path.read_text().splitlines():
        if line[0] in "e%":
            runs.append([])
        else:
            runs[-1].append([float(part) for part in line.split()])
    return [np.array(run) for run in runs]


def test_ioh_files_hold_every_improvement(results, sound, tmp_path):
    made = export("small", "ioh", tmp_path, results)
    assert (made.trials, made.left_out) == (len(sound), 9)
    found = {}
    for path in tmp_path.glob("*/*.json"):
        index = json.loads(path.read_text())
        [scenario] = index["scenarios"]
        runs = runs_of(path.parent / scenario["path"])
        for told, run in zip(scenario["runs"], runs, strict=True):
            assert (run[0, 0], run[-1, 0]) == (1, told["evals"])
            assert told["best"]["y"] == run[:, 1].min()
            found[index["algorithm"]["name"], index["function_name"], told["instance"]] = (
                run,
                index["attributes"],
            )
    assert len(found) == len(sound)
    for cell, row in sound:
        name = f"{cell.problem.dataset.replace(', ', '--')}_{cell.problem.model}_paper"
        run, attributes = found[cell.label, name, row.repetition + 1]
        evaluations, values = row.improvements()
        assert run[:, 1] == pytest.approx(at(evaluations, values, run[:, 0].astype(int)), rel=1e-15)
        assert set(evaluations.tolist()) <= set(run[:, 0].tolist())
        if row.oracle is None:
            assert attributes == ["evaluations", "raw_y"]
        else:
            assert run[-1, 2:] == pytest.approx(
                [row.recommendations()[1][-1], row.oracle_trace()[1][-1]], rel=1e-15
            )


def test_coco_files_hold_the_noise_free_precision(results, sound, tmp_path):
    made = export("small", "coco", tmp_path, results)
    assert (made.trials, made.left_out) == (len(sound), 9)
    names = dict(
        line.split(" ", 1) for line in (tmp_path / "functions.txt").read_text().splitlines()
    )
    assert names == {
        "1": "kelvin_fractional-kelvin_paper",
        "2": "noisy_fractional-kelvin_paper",
        "3": "measured--real_springpot_paper",
    }
    for path in tmp_path.glob("*/*.info"):
        head, comment, runs = path.read_text().splitlines()
        assert head.startswith("suite = 'springpot', funcId = ")
        assert "settings" not in head
        assert comment.startswith("%")
        data, *told = runs.split(", ")
        run = runs_of(path.parent / data)
        timed = runs_of((path.parent / data).with_suffix(".tdat"))
        assert len(told) == len(run) == len(timed) == 3
        for table, grid, text in zip(run, timed, told, strict=True):
            assert table[0, 0] == grid[0, 0] == 1
            assert table[-1, 0] == grid[-1, 0] == int(text.split(":")[1].split("|")[0])
            assert np.all(np.diff(table[:, 2]) <= 0)
            assert float(text.split("|")[1]) == pytest.approx(table[-1, 2], rel=0.06)
    [noisy] = (
        row
        for cell, row in sound
        if cell.label == "walk" and cell.problem.dataset == "noisy" and row.repetition == 0
    )
    [reference] = {cell.problem.reference for cell, _ in sound if cell.problem.dataset == "noisy"}
    table = runs_of(tmp_path / "walk" / "data_f2" / "bbobexp_f2_DIM3.dat")[0]
    # The truth has no misfit without noise, so the precision is the oracle trace over the value at
    # the centre.
    assert table[-1, 2] == pytest.approx(noisy.oracle_trace()[1][-1] / reference, rel=1e-9)
    assert table[-1, 4] == pytest.approx(noisy.best, rel=1e-9)


def test_csv_has_every_trial_and_its_trace(results, sound, tmp_path):
    assert export("small", "csv", tmp_path, results).left_out == 0
    trials = list(csv.DictReader((tmp_path / "trials.csv").open()))
    assert len(trials) == 27
    assert sum(row["status"] == "error" and row["best"] == "" for row in trials) == 9
    kept = {(r["dataset"], r["optimiser"], int(r["repetition"])): r for r in trials}
    for cell, row in sound:
        told = kept[cell.problem.dataset, cell.label, row.repetition]
        assert float(told["best"]) == row.best
        assert json.loads(told["theta"]) == row.theta
    points = list(csv.DictReader((tmp_path / "traces.csv").open()))
    for cell, row in sound:
        who = (cell.problem.dataset, cell.label, str(row.repetition))
        mine = [p for p in points if (p["dataset"], p["optimiser"], p["repetition"]) == who]
        assert {1, 10, 100, 300} <= {int(p["evaluations"]) for p in mine}
        assert float(mine[-1]["best"]) == row.best
        assert (mine[-1]["oracle"] == "") == (row.oracle is None)


def test_bad_wishes_are_one_line(results, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "polars", None)
    (tmp_path / "file").write_text("in the way")
    for wish, error, message in [
        (
            lambda: export("small", "xlsx", tmp_path, results),
            StudyError,
            "unknown export format 'xlsx': use ioh",
        ),
        (
            lambda: export("small", "parquet", tmp_path, results),
            StudyError,
            "needs pyarrow: pip install pyarrow",
        ),
        (
            lambda: export("small", "csv", tmp_path / "file" / "x", results),
            OutputError,
            "cannot write",
        ),
        (lambda: export("nothing", "csv", tmp_path, results), StudyError, "there are no results"),
        (
            lambda: frame("small", "polars", out=results),
            StudyError,
            "needs polars: pip install polars",
        ),
        (
            lambda: frame("small", "dask", out=results),
            StudyError,
            "unknown library 'dask': use pandas or polars",
        ),
        (
            lambda: frame("small", "pandas", "plots", results),
            StudyError,
            "unknown results 'plots': use trials",
        ),
    ]:
        with pytest.raises(SpringpotError, match=message) as caught:
            wish()
        assert isinstance(caught.value, error)
        assert "\n" not in str(caught.value)


def test_labels_that_make_one_file_name_get_folders_of_their_own(tmp_path):
    twins = [("a b", Walk()), ("a-b", Walk(shrink=0.9)), ("A*B", Walk(shrink=0.8))]
    run_study(
        small_study(optimisers=twins, repetitions=1, models=["own"]),
        engine="serial",
        out=tmp_path,
        quiet=True,
    )
    for kind in ("ioh", "coco"):
        export("small", kind, tmp_path / kind, tmp_path)
        assert {path.name for path in (tmp_path / kind).iterdir() if path.is_dir()} == {
            "a-b",
            "a-b-2",
            "A-B-3",
        }


@pytest.mark.soak_cases("pandas")
@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_frames(results, sound, library):
    pytest.importorskip(library, reason=f"{library} is in the extra 'ecosystem'")
    trials = frame("small", library, out=results)
    assert trials.shape[0] == 27
    best = [value for value in trials["best"].to_list() if value is not None and value == value]
    assert best == [row.best for _, row in sound]
    traces = frame("small", library, "traces", results)
    assert set(traces["evaluations"].to_list()) >= {1, 10, 100, 300}


def test_parquet_reads_back(results, sound, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is in the extra 'ecosystem'")
    export("small", "parquet", tmp_path, results)
    table = parquet.read_table(tmp_path / "trials.parquet")
    assert [value for value in table["best"].to_pylist() if value is not None] == [
        row.best for _, row in sound
    ]
    assert table.schema.metadata[b"name"] == b"small"
    assert parquet.read_table(tmp_path / "traces.parquet").num_rows > len(sound)


@pytest.mark.parametrize("kind", ["ioh", "coco"])
def test_iohinspector_reads_it(results, sound, tmp_path, kind):
    pytest.importorskip("iohinspector", reason="iohinspector is in the extra 'ecosystem'")
    export("small", kind, tmp_path, results)
    script = """if True:
        import sys, json, warnings
        warnings.simplefilter("error", UserWarning)
        import iohinspector
        manager = iohinspector.DataManager()
        manager.add_folder(sys.argv[1])
        points = manager.load(monotonic=True, include_meta_data=True)
        ends = points.group_by("data_id").min()
        print(json.dumps([manager.overview["best_y"].to_list(), ends["raw_y"].to_list()]))
    """
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    overview, ends = json.loads(done.stdout)
    assert len(overview) == len(ends) == len(sound)
    if kind == "ioh":
        assert sorted(overview) == sorted(row.best for _, row in sound)
        assert sorted(ends) == pytest.approx(sorted(overview), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("algorithms", [1, 2])
def test_cocopp_writes_its_report(results, tmp_path, algorithms):
    for name in ("six", "cocopp"):
        pytest.importorskip(name, reason=f"{name} is in the extra 'ecosystem'")
    export("small", "coco", tmp_path / "coco", results)
    if algorithms == 1:
        for path in [*(tmp_path / "coco" / "walk").rglob("*.*")]:
            path.unlink()
    command = [sys.executable, "-m", "springpot.benchmark.coco_suite", "coco", "-o", "report"]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )
    assert done.returncode == 0, done.stderr
    assert "ALL done" in done.stdout
    pages = {path.name for path in (tmp_path / "report").rglob("*.html")}
    assert {"index.html"} < pages
    assert len(list((tmp_path / "report").rglob("*.svg"))) > 5


@pytest.mark.soak
def test_a_report_of_no_export_is_one_line(tmp_path):
    command = [sys.executable, "-m", "springpot.benchmark.coco_suite", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "holds no COCO export" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("kind", ["ioh", "coco"])
def test_exports_tell_the_time_of_one_trial_alone_beside_that_in_a_batch(tmp_path, kind):
    raced = small_study(
        datasets=[artificial()],
        models=["fractional-kelvin"],
        optimisers=["pso-paper", Walk()],
        repetitions=3,
        budget=200,
    )
    run_study(raced, engine="serial", out=tmp_path / "results", quiet=True)
    export("small", kind, tmp_path / "made", tmp_path / "results")
    with Store(tmp_path / "results" / "small" / "small.sqlite") as store:
        label = {cell.id: cell.label for cell in store.cells()}
        alone = {number: [row.processor for row in rows] for number, rows in store.trials()}
    for number, times in alone.items():
        known = float(np.median([each for each in times if each is not None]))
        suffix = {"ioh": "json", "coco": "info"}[kind]
        [path] = (tmp_path / "made" / label[number]).glob(f"*.{suffix}")
        if kind == "ioh":
            pairs = json.loads(path.read_text())["experiment_attributes"]
            told = {key: value for pair in pairs for key, value in pair.items()}
            assert float(told["processor [s]"]) == pytest.approx(known, rel=1e-4)
            shared = "processor_batched [s]" in told
        else:
            comment = path.read_text().splitlines()[1]
            assert f", processor {known:.4g} s" in comment
            shared = "processor_batched" in comment
        assert shared == (label[number] == "pso-paper")
