"""``springpot regression`` and ``springpot export``: exit codes, files and JSON."""

from functools import partial

import pytest

from springpot.benchmark import run_study

SCRIPT = """
from dataclasses import replace
from springpot import plugins
from springpot.benchmark import Study
swarm = plugins().find("optimiser", "pso-paper")
swarm = swarm() if isinstance(swarm, type) else swarm
swarm = replace(swarm, inertia_first={first}, inertia_last={last})
study = Study("tiny", ["artificial-springpot"], ["own"], ["paper"], [("swarm", swarm)],
              repetitions=12, budget={budget}, target=1e-7, stop_at_target=True)
"""


@pytest.fixture
def study(tmp_path, monkeypatch, write):
    monkeypatch.chdir(tmp_path)
    # Where trials run is not what is tested: workers would be started for each of four studies.
    monkeypatch.setattr(
        "springpot.benchmark.gate.regression.run_study", partial(run_study, engine="serial")
    )

    def script(first=0.9, last=0.4, budget=4000):
        return write(
            SCRIPT.format(first=first, last=last, budget=budget), f"tiny_{first}_{last}_{budget}.py"
        )

    return script


def test_update_check_and_a_regression(springpot, study):
    good = study()
    assert springpot("regression", "check", good).is_one_line(
        "no baseline", "springpot regression update"
    )
    assert springpot("regression", "check").is_one_line("there is no baseline under results")
    made = springpot("regression", "update", good, "--json").json
    assert made == {"schema": "springpot.files/1", "files": ["results/tiny/baseline.json"]}
    passed = springpot("regression", "check")
    assert passed.code == 0
    assert "1 comparisons, nothing got worse" in passed.out
    failed = springpot("regression", "check", study(1.0, 1.0))
    assert failed.code == 1
    assert (
        "worse: swarm on artificial-springpot (model springpot, objective paper) got worse"
        in failed.out
    )
    assert failed.err == ""
    assert "seen: swarm, in 80 % of cases: costs x1." in passed.out
    assert springpot("regression", "check", "--level", "2").is_one_line("--level")
    assert springpot("regression", "check", study(budget=99)).is_one_line(
        "made with a budget of 4000"
    )
    assert springpot("regression", "check", "--baseline", "x.json").is_one_line(
        "--baseline needs exactly one study"
    )


@pytest.mark.soak
def test_export(springpot, study):
    springpot("run", study(), "--engine", "serial", "--quiet", "--repeats", 2)
    answer = springpot("export", "tiny", "--format", "ioh", "--json").json
    assert set(answer) == {"schema", "format", "folder", "files", "trials", "left_out", "hint"}
    assert (answer["folder"], answer["trials"], answer["left_out"]) == ("results/tiny/ioh", 2, 0)
    told = springpot("export", "tiny", "--format", "csv", "-o", "mine")
    assert "2 trials in 2 files in mine" in told.out
    assert springpot("export", "tiny", "--format", "doc").is_one_line("--format")
    assert springpot("export", "nothing", "--format", "csv").is_one_line("run the study first")
