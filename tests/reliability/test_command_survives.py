"""The command as a whole.

Its own output stays its own, Ctrl-C is quiet at any moment, no path is too long.
"""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from time import sleep

import pytest
from faulty_optimisers import MARK, left_behind

from soaked import soaked

HERE = Path(__file__).parent
SCRIPT = """
import sys
sys.path.insert(0, {here!r})
from dataclasses import replace
from faulty_optimisers import Faulty, Innocent, race

print("a script that prints")
study = replace(
    race([], {repetitions}),
    optimisers=[("shouting", Faulty(deed="shout")), ("innocent", Innocent()), "cma-es"],
    finish=lambda path, folder: print("a finish that prints"),
    deadline=120.0,
)
"""


def script(folder, repetitions=1):
    path = folder / "race.py"
    path.write_text(SCRIPT.format(here=str(HERE), repetitions=repetitions))
    return path


def springpot(*arguments, **environment):
    command = [sys.executable, "-m", "springpot", *map(str, arguments)]
    return subprocess.run(command, text=True, capture_output=True, env=os.environ | environment)


@pytest.mark.soak_cases("local")
@pytest.mark.parametrize("engine", ["local", soaked("serial")])
def test_what_others_print_is_not_in_the_json(tmp_path, engine):
    done = springpot("run", script(tmp_path), "--engine", engine, "--json", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["ran"] == 3
    assert "a script that prints" in done.stderr
    assert "look at me" in done.stderr


@pytest.mark.soak_cases("local")
@pytest.mark.parametrize("engine", ["local", soaked("serial")])
def test_quiet_is_quiet_and_a_long_folder_of_temporary_files_no_hindrance(tmp_path, engine):
    """A socket with a path could have 108 characters."""
    long = tmp_path / ("x" * 100) / ("y" * 100)
    long.mkdir(parents=True)
    asked = ["run", script(tmp_path), "--engine", engine, "--json", "--quiet", "--out", tmp_path]
    done = springpot(*asked, TMPDIR=str(long))
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["ran"] == 3
    assert done.stderr == ""


@pytest.mark.soak_cases("1.5")
@pytest.mark.parametrize("after", [0.5, 1.5, *map(soaked, (0.3, 0.4, 0.6, 0.8, 1.1))])
def test_ctrl_c_in_the_first_moments_shows_no_traceback(tmp_path, after):
    command = [
        sys.executable,
        "-m",
        "springpot",
        "run",
        str(script(tmp_path, 200)),
        "--out",
        str(tmp_path),
    ]
    # A terminal sends Ctrl-C to all processes of its group.
    process = subprocess.Popen(
        command,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    sleep(after)
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=300)
    if (
        told.startswith("Fatal Python error")
        or "in _run_module_as_main" in told.partition("springpot/cli")[0]
    ):
        pytest.skip("on this busy machine Python had not come to the first line of ours")
    assert "Traceback" not in told
    # Before Python has set its handler the signal itself ends the process, without a word; a shell
    # calls both 130.
    assert process.returncode == 130 or (process.returncode == -signal.SIGINT and not told)


@pytest.mark.soak
def test_ctrl_c_while_a_string_is_run_ends_with_the_same_code(tmp_path):
    """As while a dataclass is made: CPython then ends by the signal, whatever the exit code."""
    path = tmp_path / "study.py"
    path.write_text('exec("import os, signal; os.kill(os.getpid(), signal.SIGINT)")')
    done = springpot("run", path, "--out", tmp_path)
    assert (done.returncode, done.stderr) == (130, "")


@pytest.mark.soak
def test_ctrl_c_ends_an_optimiser_of_identify_too(tmp_path):
    model = "fractional-maxwell"
    asked = ["identify", f"artificial-{model}", "--model", model, "--optimiser", "nlopt-esch"]
    process = subprocess.Popen(
        [sys.executable, "-m", "springpot", *asked, "--budget", "100000000"],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env=os.environ | {MARK: str(tmp_path)},
    )
    # The command, and the process in which its optimiser runs.
    while process.poll() is None and len(left_behind(str(tmp_path))) < 2:
        sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    out, told = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")
    assert "Traceback" not in told
    assert left_behind(str(tmp_path)) == []


@pytest.mark.parametrize("error", ["ImportError", "AttributeError", "SystemError"])
def test_an_error_that_a_library_makes_of_ctrl_c_is_no_fault(error):
    """As numpy does where it is interrupted while it is imported."""
    program = f"""
import os, signal
import springpot.cli.group

def run(arguments):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        raise {error}("partially initialised") from None

springpot.cli.group.run = run
springpot.cli.main(["list"])
"""
    process = subprocess.run([sys.executable, "-c", program], text=True, capture_output=True)
    assert (process.returncode, process.stderr) == (130, "")


@pytest.mark.soak_cases("0", "1", "2")
@pytest.mark.parametrize("closed", [0, 1, 2])
def test_a_stream_that_is_closed_is_no_fault(tmp_path, closed):
    """As services start their programs."""
    asked = [
        "identify",
        "artificial-fractional-kelvin",
        "--model",
        "fractional-kelvin",
        "--optimiser",
        "cma-es",
    ]
    done = subprocess.run(
        [sys.executable, "-m", "springpot", *asked, "--budget", "300", "--json"],
        text=True,
        capture_output=True,
        preexec_fn=lambda: os.close(closed),
        env=os.environ | {"SPRINGPOT_CACHE": str(tmp_path)},
    )
    assert (done.returncode, done.stderr) == (0, "")
    if closed != 1:
        assert json.loads(done.stdout)["optimiser"] == "cma-es"


NOISY = """
import os

print("loaded")

from springpot.hooks import hookimpl
from springpot.identification import Objective


def weights(data):
    print("asked")
    return 1.0 / abs(data.stiffness) * (1.0 + 1.0j)


@hookimpl
def springpot_objectives():
    print("listed")
    return (Objective("talking", "relative squares, with words", weights),)
"""


@pytest.mark.soak
def test_what_a_plugin_prints_is_not_in_the_json(tmp_path):
    """Where its author has left a print while it was being written."""
    (tmp_path / "talking.py").write_text(NOISY)
    about = tmp_path / "talking-0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: talking\nVersion: 0.1\n")
    (about / "entry_points.txt").write_text("[springpot]\ntalking = talking\n")
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    asked = [
        "identify",
        "nist-srm2491@temperature=20",
        "--model",
        "fractional-maxwell",
        "--objective",
        "talking",
    ]
    done = springpot(*asked, "--json", PYTHONPATH=paths)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["objective"]["name"] == "talking"
    assert {"loaded", "listed", "asked"} <= set(done.stderr.split())


@pytest.mark.soak
def test_a_link_that_leads_to_itself_is_one_line(tmp_path):
    link = tmp_path / "link.py"
    link.symlink_to(link.name)
    store = tmp_path / "out" / "faulty" / "faulty.sqlite"
    store.parent.mkdir(parents=True)
    store.symlink_to(store.name)
    for asked in (
        ["tables", link],
        ["run", link],
        ["run", script(tmp_path), "--out", tmp_path / "out", "--quiet"],
    ):
        done = springpot(*asked)
        assert done.returncode == 2, done.stderr
        assert done.stderr.count("\n") == 1
