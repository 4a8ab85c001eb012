"""An archived study stands beside another as if all had run together."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmark_fakes import Moody, Walk, artificial, measurement, small_study

from springpot.benchmark import Findings, Store, archive, run_study
from springpot.benchmark.archive import Archive, opened, study_of, take_over, write_archive
from springpot.benchmark.exporting import export
from springpot.benchmark.standings import study_tables
from springpot.benchmark.summary import TrialRow
from springpot.benchmark.trial import Status, pack
from springpot.errors import StudyError
from springpot.measurement import DataSet

RIVALS = ["native", "nlopt-direct-l", ("broken", Moody(mood="throw"))]


def a_study(optimisers, **changes):
    told = {
        "datasets": [artificial(), artificial(0.02, "noisy"), DataSet("lab", "own", unknown)],
        "models": {"kelvin": ["own"], "noisy": ["own"], "lab": ["fractional-kelvin"]},
        "repetitions": 3,
        "budget": 60,
        "noise": [0, 0.01],
    }
    return small_study(optimisers=optimisers, **(told | changes))


def unknown():
    return measurement(0.01, "lab")


def run_in(folder, study):
    return run_study(study, engine="serial", out=folder, quiet=True, tables=False).store


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study of all, an archive of its rivals, and a study of the walk alone."""
    folder = tmp_path_factory.mktemp("archive")
    run_in(folder / "all", a_study([Walk(), *RIVALS]))
    with Store(run_in(folder / "rivals", a_study(RIVALS))) as store:
        assert write_archive(store, folder / "rivals.zip") == 5 * 3 * 3
    run_in(folder / "walk", a_study([Walk()]))
    return folder


def store_in(folder, name):
    return folder / name / "small" / "small.sqlite"


def test_the_same_trials_are_the_same_bytes_of_plain_text(folder):
    with Store(store_in(folder, "rivals")) as store:
        write_archive(store, folder / "again.zip")
    assert (folder / "again.zip").read_bytes() == (folder / "rivals.zip").read_bytes()
    with zipfile.ZipFile(folder / "rivals.zip") as whole:
        names = whole.namelist()
        told = json.loads(whole.read("study.json"))
        texts = [whole.read(name).decode("utf-8") for name in names]
        # The earliest date that a zip can tell, whenever it is written.
        assert {each.date_time for each in whole.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    assert names == ["study.json", "trials.csv", "traces.csv", "oracles.csv"]
    assert all(texts)
    assert {"python", "machine", "numpy", "seed", "started"} <= set(told["facts"])


def test_tables_beside_an_archive_are_those_of_one_study(folder):
    """But for the times, which another machine took."""
    before = store_in(folder, "walk").read_bytes()
    with Store(store_in(folder, "all")) as store:
        wanted = dict(study_tables(store))
    with opened(store_in(folder, "walk"), folder / "rivals.zip") as store:
        found = dict(study_tables(store))
        assert "rivals.zip, study small" in store.facts()["beside"]
    del wanted["timing"], found["timing"]
    assert {n: sorted(map(repr, t.rows)) for n, t in found.items()} == {
        n: sorted(map(repr, t.rows)) for n, t in wanted.items()
    }
    assert store_in(folder, "walk").read_bytes() == before


def test_an_archive_alone_has_the_tables_of_its_study(folder, tmp_path):
    """But for the times; its trials go to other tools by their own numbers, too."""
    with Store(store_in(folder, "rivals")) as store:
        wanted = dict(study_tables(store))
    with opened(folder / "rivals.zip") as store:
        found = dict(study_tables(store))
    del wanted["timing"], found["timing"]
    assert {n: t.rows for n, t in found.items()} == {n: t.rows for n, t in wanted.items()}
    for path, name in ((folder / "rivals.zip", "zip"), (store_in(folder, "rivals"), "store")):
        export(path, "csv", tmp_path / name)
    traces = [(tmp_path / each / "traces.csv").read_bytes() for each in ("zip", "store")]
    assert traces[0] == traces[1]


def test_what_an_archive_says_of_itself_stays_with_its_trials(folder, tmp_path):
    """Libraries that only it used, whence it came, and the question for who enters it."""
    asks = ("who?", "how many", "one of them")
    facts = {"a-library": "1.2", "numpy": "0.1", "beside": "older.zip, study older"}
    with Store(tmp_path / "old.sqlite", write=True) as store:
        store.register(a_study(RIVALS, asks=asks).plan(), facts)
        write_archive(store, tmp_path / "old.zip")
    with opened(store_in(folder, "walk"), tmp_path / "old.zip") as store:
        told = store.facts()
    assert told["a-library"] == "1.2"
    assert told["beside"] == "old.zip, study small (numpy 0.1); older.zip, study older"
    # A study of one's own has its own question.
    assert "question" not in told
    assert "question" in Archive.read(tmp_path / "old.zip").facts


def test_a_study_takes_over_what_its_archive_holds(folder, tmp_path):
    """And runs the others alone."""
    plan, archive = a_study([Walk(), *RIVALS]).plan(), Archive.read(folder / "rivals.zip")
    with Store(tmp_path / "small.sqlite", write=True) as store:
        numbers = store.register(plan, {})
        # A store that holds all of them runs these again, too.
        take_over(store, archive)
        take_over(store, archive, anew=["native"])
        tasks = list(plan.tasks(lambda cell: store.finished(numbers[cell.index])))
    missing = {plan.entrants[plan.cells[task.cell].entrant].label for task in tasks}
    assert missing == {"walk", "native"}


def test_what_a_study_ran_itself_is_not_shown_twice(folder):
    with opened(store_in(folder, "all"), folder / "rivals.zip") as store:
        assert len(store.cells()) == 5 * 4
    mine = run_in(folder / "mine", a_study([("native", Walk(shrink=0.9))]))
    with opened(mine, folder / "rivals.zip") as store:
        labels = dict.fromkeys(cell.label for cell in store.cells())
    assert list(labels) == ["native", "native (archive)", "nlopt-direct-l", "broken"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"budget": 61}, "its evaluations a trial is 60, not 61"),
        ({"seed": 2}, "its seed is 1, not 2"),
        ({"target": 1e-4}, "its target is 0.001, not 0.0001"),
        ({"stop_at_target": True}, "its stop at the target is none, not True"),
        ({"x0": "common"}, "only one of them has a common first point"),
        ({"noise": [0, 0.02]}, "no trials of kelvin+2%, fractional-kelvin, paper with these data"),
        ({"objectives": ["log"]}, "no trials of kelvin, fractional-kelvin, log with these data"),
        ({"datasets": [artificial(0.03, "kelvin")], "models": ["own"], "noise": []}, "these data"),
    ],
)
def test_other_problems_budgets_and_seeds_are_refused_in_one_line(folder, tmp_path, changes, told):
    study = a_study([Walk()], **{"repetitions": 1, "budget": 60} | changes)
    plan = study.plan()
    with Store(tmp_path / "small.sqlite", write=True) as store:
        store.register(plan, {})
    with (
        pytest.raises(StudyError, match="cannot stand beside small") as error,
        opened(tmp_path / "small.sqlite", folder / "rivals.zip"),
    ):
        pass
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def changed(source, target, name, old, new):
    """An archive with one text replaced."""
    with zipfile.ZipFile(source) as whole, zipfile.ZipFile(target, "w") as copy:
        for entry in whole.namelist():
            text = whole.read(entry).decode()
            if entry == name:
                assert old in text
                text = text.replace(old, new, 1)
            copy.writestr(entry, text)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("study.json", "springpot.archive/2", "springpot.archive/1"),
        ("study.json", '"problem": 0', '"problem": 99'),
        ("study.json", '"seed"', '"sod"'),
        ("trials.csv", "budget,exact,60", "budget,exact,61"),
        ("trials.csv", "budget,exact,60", "won,exact,60"),
        ("traces.csv", "\n0,0,", "\n0,7,"),
        ("traces.csv", "0,0,1,", "0,0,one,"),
        ("oracles.csv", "3,0,", "44,0,"),
    ],
)
def test_a_damaged_archive_is_told_in_one_line(folder, tmp_path, name, old, new):
    changed(folder / "rivals.zip", tmp_path / "bad.zip", name, old, new)
    with (
        pytest.raises(StudyError, match=r"bad\.zip is no archive of a study, or damaged") as error,
        opened(store_in(folder, "walk"), tmp_path / "bad.zip"),
    ):
        pass
    assert "\n" not in str(error.value)


def test_half_an_archive_and_no_archive_are_told(folder, tmp_path):
    whole = (folder / "rivals.zip").read_bytes()
    for size in (0, 100, len(whole) // 2, len(whole) - 1):
        (tmp_path / "half.zip").write_bytes(whole[:size])
        with pytest.raises(StudyError, match="no archive of a study, or damaged"):
            Archive.read(tmp_path / "half.zip")
    with pytest.raises(StudyError, match="no archive of a study, or damaged"):
        Archive.read(tmp_path / "absent.zip")


def test_an_optimiser_enters_an_archived_study_by_one_command(springpot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    published = replace(
        a_study(["native", "cma-es"]),
        name="published",
        datasets=["artificial-springpot"],
        models=["own"],
        repetitions=1,
        x0="common",
        stop_at_target=True,
        asks=("who?", "how many", "one of them"),
    )
    with Store(run_in(tmp_path, published)) as store:
        write_archive(store, tmp_path / "published.zip")
        bests = store.bests()
    with opened(tmp_path / "published.zip") as store:
        # Known before the race, and not the best of its trials, which stop above it.
        assert sorted(store.bests().values()) == sorted(bests.values())
    assert Archive.read(tmp_path / "published.zip").optima
    mine = study_of(tmp_path / "published.zip", ["nlopt-bobyqa"])
    cases = [case.digest for case in mine.plan().cases]
    assert cases == [case.digest for case in published.plan().cases]
    command = ["run", "published.zip", "--optimiser", "nlopt-bobyqa", "--engine", "serial", "-q"]
    assert springpot(*command).code == 0
    table = (tmp_path / "results/published-beside/summary.csv").read_text(encoding="utf-8")
    for label in ("native", "cma-es", "nlopt-bobyqa"):
        assert table.count(f",{label},") == 2
    report = (tmp_path / "results/published-beside/report.html").read_text(encoding="utf-8")
    assert "published.zip, study published" in report
    assert "<b>Question</b>: who?" in report
    grown = ["archive", "published-beside", "--beside", "published.zip", "-o", "grown.zip"]
    assert springpot(*grown).code == 0
    cells = Archive.read(tmp_path / "grown.zip").cells
    assert sorted(cell.label for cell in cells) == sorted(["native", "cma-es", "nlopt-bobyqa"] * 2)


def test_data_of_a_file_are_sought_under_its_name_beside_an_archive(tmp_path, monkeypatch):
    table = "frequency [Hz],storage [kN/m],loss [kN/m]\n1,100,40\n2,110,50\n5,120,60\n"
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "pad.csv").write_text(table, encoding="utf-8")
    mine = replace(
        a_study(["native"]),
        datasets=[str(tmp_path / "lab" / "pad.csv")],
        models=["kelvin"],
        objectives=["paper"],
        repetitions=1,
        noise=[0],
    )
    with Store(run_in(tmp_path, mine)) as store:
        write_archive(store, tmp_path / "lab" / "mine.zip")
        write_archive(store, tmp_path / "mine.zip")
    monkeypatch.chdir(tmp_path)
    found = study_of(Path("lab/mine.zip"), ["cma-es"]).plan().cases
    assert [case.digest for case in found] == [case.digest for case in mine.plan().cases]
    with pytest.raises(StudyError, match="put the file that 'pad' was read from into this folder"):
        study_of(Path("mine.zip"), ["cma-es"])


@pytest.mark.soak
def test_a_thin_archive_has_fewer_improvements_and_the_same_hits_and_curves(tmp_path):
    changes = {"budget": 900, "repetitions": 1, "noise": []}
    path = run_in(tmp_path, a_study([Walk(shrink=0.97), "native"], **changes))
    with Store(path) as store:
        write_archive(store, tmp_path / "whole.zip")
        write_archive(store, tmp_path / "thin.zip", thin=True)
    run_in(tmp_path / "other", a_study(["random-search"], **changes))
    found = []
    for name in ("whole.zip", "thin.zip"):
        with opened(store_in(tmp_path, "other"), tmp_path / name) as store:
            found.append(Findings.of(store).scores)
    for whole, thin in zip(*found, strict=True):
        assert np.array_equal(whole.hits, thin.hits)
        assert np.array_equal(whole.curve, thin.curve)
    sizes = [(tmp_path / name).stat().st_size for name in ("thin.zip", "whole.zip")]
    assert sizes[0] < 0.8 * sizes[1]


@pytest.mark.parametrize("known", [{}, {"best": 1.0}, {"trace": pack([(1, 9.0)])}])
def test_what_has_no_best_or_no_improvements_is_kept_as_it_is(known):
    row = TrialRow(0, 0, Status.ERROR, **known)
    assert archive._thinned(row, 1.0, None, None) is row


def test_the_published_race_takes_a_new_optimiser_on_all_its_problems():
    """Each by its own objective, on data that are the same on whatever processor."""
    published = Path(__file__).parents[2] / "results" / "suite_race" / "suite_race.zip"
    cases = study_of(published, ["random-search"]).plan().cases
    raced = {problem.digest: problem.dataset for problem in Archive.read(published).problems}
    assert {case.digest: case.source.name for case in cases} == raced


def test_one_problem_of_the_published_race_is_raced_alone(springpot):
    published = Path(__file__).parents[2] / "results" / "suite_race" / "suite_race.zip"
    wave = "springpot-60/shear-wave"
    alone = study_of(published, ["random-search"], [wave])
    assert [case.source.name for case in alone.plan().cases] == [wave]
    # It does not go on with what was run of all.
    assert alone.name != study_of(published, ["random-search"]).name
    told = springpot("run", published, "--optimiser", "native", "--problem", "shear-waves")
    assert (told.code, "has no trials of 'shear-waves'" in told.err) == (2, True)
