"""The JSON of every answer is as its schema in docs/schemas says, and a wrong one is not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot
from springpot import timetests
from springpot.errors import DataError
from springpot.measurement import TimeTest
from springpot.registry import plugins

pytestmark = pytest.mark.usefixtures("asked_once")

jsonschema = pytest.importorskip("jsonschema")
FOLDER = Path(__file__).resolve().parents[1] / "docs" / "schemas"
DATA, MODEL = "artificial-hidden", "fractional-maxwell"


def answers() -> dict[str, Any]:
    fit = springpot.identify(
        "nist-srm2491@temperature=20", "fractional-zener", bounds={"k1": (0.0, 5.0)}
    )
    ladder = springpot.discover(DATA, MODEL, accept="inertia")
    return {
        "identification": fit,
        "prediction": fit.predict([0.0, 1.0]),
        "diagnosis": ladder.steps[0].case.diagnosis,
        "discovery": ladder,
        "comparison": springpot.compare(DATA, MODEL),
        "invention": springpot.invent(f"{DATA}@frequency=..20", MODEL),
    }


def answers_in_time() -> dict[str, Any]:
    """Of one short record of a springpot with a mass that the model leaves out."""
    whole = springpot.parse_model("springpot + inertia")
    t = np.linspace(0.0, 6.0, 120)
    x = np.sin(0.5 * t**1.5)
    force = whole.respond(whole.vector({"c": 60.0, "alpha": 0.4, "inertia.m": 8.0}), t, x)
    noise = 0.5 * np.random.default_rng(5).normal(size=len(t))
    test = TimeTest.of_history(t, x, force + noise, "m", "N", control="displacement")
    effects = [plugins().effect(name) for name in ("inertia", "time-delay")]
    fit = timetests.identify([test], springpot.parse_model("springpot"))
    ladder = timetests.discover([test], "springpot", effects)
    return {
        "identification": fit,
        "prediction": timetests.predict_test(fit, test),
        "diagnosis": ladder.diagnosis,
        "discovery": ladder,
        "comparison": timetests.compare(
            [test], ["springpot", "kelvin", "fractional-maxwell + friction"]
        ),
    }


def schema(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    return found


def test_answers_are_as_their_schemas_say_and_come_back_as_they_were(tmp_path: Path):
    found = [*answers().items(), *answers_in_time().items()]
    assert {path.stem for path in FOLDER.glob("*.json")} == {name for name, _ in found}
    for name, answer in found:
        jsonschema.Draft202012Validator.check_schema(schema(name))
        document = told(answer, name)
        if name != "prediction":
            again = back(document, tmp_path / "answer.json")
            assert type(again) is type(answer)
            assert told(again, name) == document
            assert repr(again) == repr(answer)
            assert str(again) == str(answer)
    told(springpot.identify(DATA, "material"), "identification")


def told(answer: Any, name: str) -> dict[str, Any]:
    """Its plain data, which are strict JSON and as the schema says."""
    document: dict[str, Any] = answer.to_dict()
    json.dumps(document, allow_nan=False)
    jsonschema.validate(document, schema(name))
    assert document["schema"] == schema(name)["properties"]["schema"]["const"]
    return document


def back(document: dict[str, Any], path: Path) -> Any:
    path.write_text(json.dumps(document), encoding="utf-8")
    return springpot.load(path)


def test_a_file_holds_what_was_said_and_not_the_fits_behind_it(tmp_path: Path):
    ladder = springpot.discover(DATA, MODEL, accept=[])
    again = back(ladder.to_dict(), tmp_path / "ladder.json")
    with pytest.raises(DataError, match="has no Case behind it"):
        again.steps[0].case  # noqa: B018


@pytest.mark.parametrize("name", [path.stem for path in sorted(FOLDER.glob("*.json"))])
def test_a_wrong_answer_is_refused(name: str):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"schema": f"springpot.{name}/1", "data": 3}, schema(name))
