"""A law that was found goes on: as a file, a rung, a plugin, and never by --auto."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import springpot
from springpot import Invention
from springpot.cli.discover import accepted
from springpot.cli.init import command as init, plugin_of
from springpot.errors import DataError
from springpot.testing import check_effect


@pytest.mark.soak
def test_its_file_is_loaded_as_it_was(files: Path):
    found = springpot.load(files / "law.json")
    assert isinstance(found, Invention)
    assert found.to_dict() == json.loads((files / "law.json").read_text())
    assert "i*k*X^(-n)" in str(found)
    with pytest.raises(DataError, match="has no Search behind it"):
        found.search  # noqa: B018


@pytest.mark.soak
def test_it_is_a_rung_like_any_other(files: Path):
    law = accepted(str(files / "law.json"), 1)
    assert law.expression == "(law-1 = parallel: i*k*X^(-n))"
    fit = springpot.identify(files / "made.csv", f"material + {law.expression}")
    assert fit["law-1.n"].value == pytest.approx(0.6, abs=0.03)
    assert fit.predict(frequency=[2.0], amplitude=3.0).stiffness.shape == (1,)


@pytest.mark.soak
def test_two_laws_without_a_name_are_two(files: Path):
    names = [accepted("series: X^n/k", i).name for i in (1, 2)]
    assert names == ["law-1", "law-2"]
    assert accepted("inertia", 1).name == "inertia"


@pytest.mark.soak
def test_another_answer_is_no_law(tmp_path: Path):
    ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept=[])
    (tmp_path / "ladder.json").write_text(json.dumps(ladder.to_dict()))
    with pytest.raises(DataError, match="holds no law"):
        accepted(str(tmp_path / "ladder.json"), 1)


@pytest.mark.soak
def test_its_plugin_keeps_the_contract(files: Path, tmp_path: Path):
    arguments = ["plugin", "--from", str(files / "law.json"), "--folder", str(tmp_path)]
    answer = CliRunner().invoke(init, arguments, catch_exceptions=False)
    assert "springpot list effects my-law" in answer.output
    path = tmp_path / "springpot_mine.py"
    assert path.read_text() == plugin_of(files / "law.json")
    spec = importlib.util.spec_from_file_location("springpot_mine", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (effect,) = module.springpot_effects()
    assert check_effect(effect) == []
    diagnosed = springpot.diagnose(files / "made.csv", effects=[effect], only=["my-law"])
    assert diagnosed.best is not None
    assert diagnosed.best.effect == "my-law"


@pytest.mark.soak
def test_only_a_plugin_is_made_of_a_law(files: Path):
    answer = CliRunner().invoke(init, ["study", "--from", str(files / "law.json")])
    assert "only a plugin is made of a law, not a study" in str(answer.exception)
