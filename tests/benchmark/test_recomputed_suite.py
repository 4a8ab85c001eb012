"""The main study's tables follow from its archive, as another program computes them."""

from __future__ import annotations

import ast
import csv
from pathlib import Path

import numpy as np
import pytest
import recomputed
import recomputed_suite

from springpot.benchmark import save_table
from springpot.benchmark.archive import opened
from springpot.benchmark.exporting import write_csv
from springpot.benchmark.standings import study_tables

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results"
SUITE = ROOT / "plugins" / "springpot_plugins" / "suites" / "springpot-60.csv"


@pytest.fixture(scope="module")
def tables():
    return recomputed_suite.tables(*recomputed_suite.races(RESULTS, SUITE))


@pytest.mark.soak
def test_every_cell_is_what_numpy_makes_of_the_archive(tables):
    agree, wrong = recomputed_suite.compared(tables, RESULTS)
    assert wrong == []
    assert agree == 46 * (15 + 3) + 2 * 6 * 3


@pytest.mark.soak
def test_so_is_every_cell_of_the_tables_of_its_report(tmp_path):
    """Of 46 optimisers on 60 problems, where signed ranks are partly exact and partly normal."""
    with opened(RESULTS / "suite_race" / "suite_race.zip") as store:
        for name, table in study_tables(store):
            save_table(table, tmp_path, name, ("csv",))
        write_csv(store, tmp_path)
    agree, wrong = recomputed.compared(tmp_path, tmp_path)
    assert wrong == []
    assert agree > 80_000
    kept = RESULTS / "suite_race" / "summary.csv"
    assert (tmp_path / "summary.csv").read_bytes() == kept.read_bytes()


@pytest.mark.soak
def test_no_rival_exceeds_95_percent_on_the_hard_half(tables):
    """`auto` does, which came after the suite."""
    shares = {label: row[3] for label, row in tables["suite_race/parts"].items()}
    assert shares.pop(recomputed_suite.CHOICE) > max(shares.values())
    assert max(shares.values()) <= 0.95, shares


@pytest.mark.soak
def test_a_cell_that_is_off_is_found(tables, tmp_path):
    for name in tables:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / f"{name}.csv").write_bytes((RESULTS / f"{name}.csv").read_bytes())
    selector = tmp_path / "suite_race" / "selector.csv"
    with selector.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    rows[1][1] = str(1.001 * float(rows[1][1]))
    with selector.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows(rows)
    _, wrong = recomputed_suite.compared(tables, tmp_path)
    assert len(wrong) == 1


@pytest.mark.parametrize("race", ["hard", "rugged"])
def test_so_are_the_shares_on_the_drawn_suites(race):
    name = f"suite_{race}"
    raced = recomputed_suite.Race(
        RESULTS / name / f"{name}.zip", SUITE.with_name(f"springpot-{race}-20.csv")
    )
    # All of their problems are hard or deceptive.
    shares = {
        label: [*raced.share(label, "hard half"), *raced.charged(label, "hard half")]
        for label in raced.labels
    }
    _, wrong = recomputed_suite.compared({f"{name}/parts": shares}, RESULTS)
    assert wrong == []


def rows_of(name):
    with (RESULTS / name).open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def hits_of(row):
    """As many as the share of a cell says."""
    trials = int(row["trials"])
    return np.where(np.arange(trials) < round(float(row["success"]) * trials), 1.0, np.inf)


def test_shares_of_the_first_race_follow_from_its_cells():
    cells = rows_of("optimiser_comparison/summary.csv")
    for row in rows_of("optimiser_comparison/ranking.csv"):
        own = [cell for cell in cells if cell["optimiser"] == row["optimiser"]]
        noisy = [cell for cell in own if cell["data set"].endswith("-noise1")]
        for column, chosen in (("all", own), ("1 % noise", noisy)):
            written = [float(row[f"{column}{end}"]) for end in ("", " low", " high")]
            found = recomputed_suite.share_over([hits_of(cell) for cell in chosen])
            assert written == pytest.approx(found, abs=1e-12), (row["optimiser"], column)


def test_shares_of_the_swarm_and_its_rivals_follow_from_their_cells():
    cells = rows_of("swarm_claim/summary.csv")
    last = [row for row in rows_of("swarm_claim/swarm_ranks.csv") if row["budget"] == "40000"]
    assert len(last) == 2 * 16
    for row in last:
        own = [cell for cell in cells if cell["optimiser"] == row["optimiser"]]
        noisy = row["data"] == "noisy"
        hits = [hits_of(cell) for cell in own if ("-noise" in cell["data set"]) == noisy]
        written = [float(row[f"success{end}"]) for end in ("", " low", " high")]
        assert written == pytest.approx(recomputed_suite.share_over(hits), abs=1e-12), row


def test_it_knows_nothing_of_springpot():
    tree = ast.parse(Path(recomputed_suite.__file__).read_text(encoding="utf-8"))
    names = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    names |= {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    assert names <= {
        *("__future__", "csv", "io", "json", "sys", "zipfile", "math", "pathlib", "numpy")
    }
