"""springpot and an example plugin as wheels in a fresh environment, used far from the checkout."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "tests" / "example_plugin"
SOURCES = ("pyproject.toml", "README.md", "LICENSE", "framework", "plugins")

STUDY = """
from springpot.benchmark import Study

STUDY = Study(
    "tiny", ["example-data"], ["own"], ["relative"], ["example-optimiser", "native"],
    repetitions=2, budget=300,
)
"""


@dataclass(frozen=True)
class Environment:
    """A virtual environment with springpot and the example, and an empty folder to work in."""

    folder: Path
    home: Path

    def run(self, *command: str | Path, code: int = 0) -> str:
        """Standard output of a command of the environment."""
        clean = {
            key: value
            for key, value in os.environ.items()
            if not key.startswith(("PYTHON", "SPRINGPOT"))
        }
        found = subprocess.run(
            [_binary(self.folder, str(command[0])), *map(str, command[1:])],
            cwd=self.home,
            env=clean,
            capture_output=True,
            text=True,
        )
        assert found.returncode == code, found.stdout + found.stderr
        return found.stdout if code == 0 else found.stderr

    def springpot(self, *arguments: str | Path, code: int = 0) -> str:
        """Standard output of the installed command line (standard error where it fails)."""
        return self.run("springpot", *arguments, code=code)

    def springpots(self, *commands: Sequence[str]) -> list[str]:
        """Standard output of several command lines, all of them in one process."""
        code = (
            "import sys, json; from springpot.cli.group import run\n"
            "for words in json.loads(sys.argv[1]): assert run(words) == 0; print(chr(0))"
        )
        return self.run("python", "-c", code, json.dumps(commands)).split("\0\n")[:-1]


def _binary(folder: Path, name: str) -> str:
    return sysconfig.get_path("scripts", "venv", vars={"base": str(folder)}) + os.sep + name


def _pip(*arguments: str | Path) -> None:
    quiet = ["--disable-pip-version-check", "--no-input", "--quiet"]
    command = [sys.executable, "-m", "pip", *quiet, *map(str, arguments)]
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """The environment; it borrows numpy and the like from the running one.

    So that no network is needed.
    """
    base = tmp_path_factory.mktemp("installed")
    source, home = base / "source", base / "home"
    # Built from copies, so that no build leaves anything in the checkout or takes anything from an
    # older one.
    ignored = shutil.ignore_patterns("__pycache__", "*.egg-info", "build", "test_*.py")
    source.mkdir()
    for name in SOURCES:
        path = ROOT / name
        if path.is_dir():
            shutil.copytree(path, source / name, ignore=ignored)
        else:
            shutil.copy(path, source / name)
    shutil.copytree(EXAMPLE, base / "example", ignore=ignored)
    folder = base / "environment"
    venv.create(folder, with_pip=False)
    places = {"base": str(folder), "platbase": str(folder)}
    site = Path(sysconfig.get_path("purelib", "venv", vars=places))
    (site / "borrowed.pth").write_text(
        sysconfig.get_path("purelib") + "\n" + sysconfig.get_path("platlib") + "\n"
    )
    # Pip must not take the running environment's springpot for an older one to be replaced.
    alone = "--no-deps", "--no-index", "--no-build-isolation", "--no-compile", "--ignore-installed"
    python = _binary(folder, "python")
    _pip("--python", python, "install", *alone, source, base / "example")
    home.mkdir()
    return Environment(folder, home)


def _csv(path: Path, omega: np.ndarray, stiffness: np.ndarray) -> Path:
    rows = [
        f"{w!r},{k.real!r},{k.imag!r}"
        for w, k in zip(omega.tolist(), stiffness.tolist(), strict=True)
    ]
    path.write_text("\n".join(["omega [rad/s],storage [kN/m],loss [kN/m]", *rows]) + "\n")
    return path


Write = Callable[..., Path]
OMEGA = 2 * np.pi * np.geomspace(0.5, 50.0, 30)
MAXWELL = 1 / (1 / 400.0 + 1 / (60.0 * (1j * OMEGA) ** 0.5))


def _names(listing: str) -> Sequence[str]:
    return [item["name"] for item in json.loads(listing)["items"]]


def test_it_is_the_installed_springpot_that_runs(installed: Environment):
    modules = "springpot", "springpot_plugins", "springpot_example"
    code = (
        f"import {', '.join(modules)}; "
        f"print(*[m.__file__ for m in ({', '.join(modules)})], sep='\\n')"
    )
    for path in installed.run("python", "-c", code).splitlines():
        assert Path(path).is_relative_to(installed.folder)
    assert not [path for path in ROOT.glob("build*") if path.is_dir()]


ASKED = ("damper.csv", "fractional-maxwell"), ("nist-srm2491@temperature=20", "maxwell-3")


def of_the_page() -> list[list[str]]:
    """The commands of the page on plugins, in words."""
    page = (ROOT / "docs" / "plugins.md").read_text()
    blocks = re.findall(r"^```console\n(.*?)^```$", page, re.M | re.S)
    return [shlex.split(line) for block in blocks for line in block.splitlines()]


@pytest.fixture(scope="module")
def answers(installed: Environment) -> list[str]:
    """What commands answer: to start each by itself would take as long as all of them together."""
    _csv(installed.home / "damper.csv", OMEGA, MAXWELL)
    return installed.springpots(
        *(["identify", of, "-m", model, "--json"] for of, model in ASKED),
        ["--help"],
        ["peak-loss", "example-data"],
        *(words for _, *words in of_the_page()),
    )


@pytest.mark.soak
def test_identify_works_outside_the_checkout(answers: list[str]):
    answer, embedded = map(json.loads, answers[:2])
    found = {name: entry["value"] for name, entry in answer["parameters"].items()}
    assert found == pytest.approx({"k": 400.0, "c": 60.0, "alpha": 0.5}, rel=1e-6)
    assert embedded["relative_rms"] < 0.2


@pytest.mark.soak
def test_every_command_of_the_page_on_plugins_works(answers: list[str]):
    called = of_the_page()
    assert len(called) >= 4
    assert {name for name, *_ in called} == {"springpot"}
    assert len(answers) == 4 + len(called)
    assert all(answers[4:])


@pytest.mark.soak
def test_the_command_stands_among_springpots_own(answers: list[str]):
    listed, told = answers[2:4]
    assert re.search(r"^  peak-loss +The frequency at which", listed, re.M)
    assert told == "the loss is largest at 314.2 rad/s\n"


@pytest.mark.soak
def test_whatever_the_example_offers_is_listed_beside_what_is_built_in(installed: Environment):
    ours = {
        "models": ("example-model", "kelvin"),
        "effects": ("charge-amplifier", "inertia"),
        "optimisers": ("example-optimiser", "native"),
        "datasets": ("example-data", "nist-srm2491"),
        "readers": ("example-json", "springpot-csv"),
    }
    listings = installed.springpots(
        *(["list", kind, "--json"] for kind in ours), ["list", "models"]
    )
    for names, listing in zip(ours.values(), listings, strict=False):
        assert set(names) <= set(_names(listing))
        assert json.loads(listing)["unavailable"] == []
    assert "example-model" in listings[-1]


@pytest.mark.soak
def test_the_model_is_identified_from_the_data_set(installed: Environment):
    answer = json.loads(
        installed.springpot("identify", "example-data", "--model", "example-model", "--json")
    )
    assert answer["model"] == "example-model"
    values = {name: (entry["value"], entry["unit"]) for name, entry in answer["parameters"].items()}
    truth = {"c0": 2.0, "k": 400.0, "c": 60.0, "alpha": 0.5}
    assert {name: value for name, (value, _) in values.items()} == pytest.approx(truth, rel=1e-5)
    assert values["c"][1] == "kN s^alpha/m"


@pytest.mark.soak
def test_the_reader_opens_its_files(installed: Environment):
    path = installed.home / "damper.json"
    columns = {"omega": OMEGA, "storage": MAXWELL.real, "loss": MAXWELL.imag}
    path.write_text(
        json.dumps({"unit": "kN/m"} | {key: column.tolist() for key, column in columns.items()})
    )
    answer = json.loads(
        installed.springpot("identify", path, "-m", "damper-in-solvent + inertia", "--json")
    )
    assert answer["relative_rms"] < 1e-6
    path.write_text('{"omega": [1, 2], "storage": [3, "four"]}')
    told = installed.springpot("identify", path, "-m", "kelvin", code=2)
    assert told.count("\n") == 1
    assert "damper.json" in told


@pytest.mark.soak
def test_the_effect_takes_part_in_diagnosis_and_is_found(installed: Environment):
    noise = np.random.default_rng(7).normal(size=(2, len(OMEGA))) * 0.003
    lost = 1j * OMEGA / (1j * OMEGA + 2.0)
    data = _csv(
        installed.home / "drifting.csv", OMEGA, MAXWELL * lost * (1 + noise[0] + 1j * noise[1])
    )
    answer = json.loads(
        installed.springpot("diagnose", data, "--model", "fractional-maxwell", "--json")
    )
    assert answer["verdict"] == "effect-missing"
    first = answer["candidates"][0]
    assert "charge-amplifier" in {first["effect"], *first["class"]}
    mine = next(entry for entry in answer["candidates"] if entry["effect"] == "charge-amplifier")
    assert mine["parameters"]["omega_c"]["value"] == pytest.approx(2.0, rel=0.1)


@pytest.mark.soak
def test_the_optimiser_runs_in_a_study(installed: Environment):
    script = installed.home / "tiny.py"
    script.write_text(STUDY)
    store = "results/tiny/tiny.sqlite"
    asked = (
        ["run", str(script), "--workers", "1", "--quiet", "--json"],
        ["tables", store, "--format", "csv"],
    )
    told, table = installed.springpots(*asked)
    answer = json.loads(told)
    assert (answer["trials"], answer["ran"], answer["failed"]) == (4, 4, 0)
    assert answer["store"] == store
    assert "example-optimiser" in table
    assert "native" in table


@pytest.mark.soak
def test_the_optimiser_identifies_too(installed: Environment):
    arguments = ["--optimiser", "example-optimiser", "--budget", "500", "--seed", "1", "--json"]
    answers = [
        *map(
            json.loads,
            installed.springpots(*2 * [["identify", "example-data", "-m", "maxwell", *arguments]]),
        )
    ]
    assert answers[0]["optimiser"] == "example-optimiser"
    assert answers[0]["parameters"] == answers[1]["parameters"]


@pytest.mark.soak
def test_without_the_example_nothing_of_it_is_there():
    code = "from springpot.registry import plugins; print(*plugins().names('model'))"
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "kelvin" in told
    assert "example-model" not in told
