"""Every set asked without naming a model: any linear passive material is judged.

Question: does discovery without a model explain a measured set, or name the cause of what it
leaves? Measure: the error over the noise floor when it ends, and the causes that it names. What
would answer it: at least 12 of the 16 sets within 1.5 times the floor or with a named cause.

What it leaves needs a cause.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from paper.asking import asking
from springpot import Measurement, discover
from springpot.benchmark import Table
from springpot.diagnosis import Ladder
from springpot.files import write_text
from springpot.report.page import Entry

from .sets import SETS, RealSet

MODEL = "material"
FOLDER = Path("answers") / "without_model"
NEAR = 1.5
"""An error within this factor of the noise floor leaves nothing to explain."""
GOAL = 12
"""Sets of the sixteen that must be near the floor or have a named cause."""
CAUSES = (
    "what is missing looks like",
    "what is missing goes with",
    "repeats differ",
    "no linear passive material behaves as",
    "no shift of times and moduli",
    "odd nonlinearity",
)
"""How a note begins that names a cause which is no effect of the library."""
MOVED = "would explain the data as well, and no fit can tell"
"""How a note ends that names effects of a condition which was not varied by itself."""
ONLY_POINTS = "nothing else is missing"
"""What the headline says where single points are all that is wrong.

Beside other structure they explain nothing.
"""
UNKNOWN = RealSet("", "", (), "", "")
COLUMNS = (
    *("set", "points", "noise floor", "material floor", "error before/floor"),
    *("effects accepted [cannot be told from]", "error after/floor", "verdict"),
    *("named cause of what is left", "within 1.5 x or named", "judged", "by what"),
)
NOTE = (
    "No model is named: any linear passive material is judged (model `material`), and `discover`"
    " accepts effects on its own. Noise floor: of the last rung; material floor: the least error of"
    " any such material before an effect is accepted. Named cause: the effects said to be missing"
    " where the verdict is `effect-missing`, otherwise what a note tells of repeats, single points,"
    " the measuring chain, a column that no effect knows, effects of an amplitude that moved with"
    " the frequency, temperatures at which no linear material behaves so or that no shift joins, or"
    " force harmonics that the model does not make. Judged by a rule: confidently wrong, where an"
    " effect is accepted or called missing and none of its class is true of the set; right, where"
    " one that is true is accepted or called missing, or the headline says so; defensible, where a"
    " note names it, or where the headline begins with it and names an effect that is not behind"
    " it; else hedged."
)


def ask(one: RealSet, data: Measurement) -> dict[str, Any]:
    """What the tool says of a set when no model is named.

    Parameters
    ----------
    one : RealSet
        The set.
    data : Measurement
        Its data.
    """
    return _kept(one, data, discover(data, MODEL))


def _kept(one: RealSet, data: Measurement, ladder: Ladder) -> dict[str, Any]:
    said = ladder.to_dict()
    first, last = ladder.steps[0].case.diagnosis.to_dict(), said.pop("diagnosis")
    kept = ("verdict", "says", "notes", "error")
    return said | {
        "set": one.name,
        "data": one.data,
        "points": len(data),
        "first": {key: first[key] for key in kept},
        "last": {key: last[key] for key in kept} | {"missing": _missing(last)},
    }


def _missing(diagnosis: dict[str, Any]) -> list[str]:
    """The effects one of which is said to be missing."""
    if diagnosis["verdict"] != "effect-missing" or not diagnosis["candidates"]:
        return []
    return list(diagnosis["candidates"][0]["class"])


def save(answer: dict[str, Any], folder: Path) -> Path:
    """Write the answer on one set."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    path: Path = write_text(
        folder / FOLDER / f"{answer['set']}.json", json.dumps(answer, indent=1) + "\n"
    )
    return path


def saved(folder: Path) -> Iterator[dict[str, Any]]:
    """All answers in the order of the sets."""
    for one in SETS:
        path = folder / FOLDER / f"{one.name}.json"
        if path.exists():
            yield json.loads(path.read_text(encoding="utf-8"))


def table(answers: Sequence[dict[str, Any]]) -> Table:
    """One row for each set, and one for the goal."""
    good = sum(is_settled(one) for one in answers)
    met = "met" if good >= GOAL else "not met"
    goal = (
        f"goal: at least {GOAL} of {len(SETS)} within {NEAR:g} x of the noise floor or with a named"
        " cause"
    )
    empty = (None,) * (len(COLUMNS) - 4)
    counts = counted([judged(one) for one in answers])
    rows = [
        *(_row(one) for one in answers),
        (goal, *empty, f"{good} of {len(answers)}: {met}", counts, None),
    ]
    return asking(__doc__, Table("Measured data without a model", COLUMNS, rows, NOTE))


def judged(one: dict[str, Any]) -> str:
    """Right, defensible, hedged or confidently wrong; see `NOTE`."""
    true = set(known(one).true)
    named = [{step["accepted"], *step["class"]} for step in one["steps"] if step["accepted"]]
    if not named and one["last"]["missing"] and one["last"]["says"].startswith(tuple(true)):
        return "right" if set(one["last"]["missing"]) & true else "defensible"
    if one["last"]["missing"]:
        named.append(set(one["last"]["missing"]))
    if not all(group & true for group in named):
        return "confidently wrong"
    first = one["first"]
    said = f"{first['verdict']}: {first['says']}"
    if named or any(word in said for word in true):
        return "right"
    if first["verdict"] == "adequate":
        return "confidently wrong"
    if any(word in note for word in true for note in [*first["notes"], *one["last"]["notes"]]):
        return "defensible"
    return "hedged"


def counted(words: Sequence[str]) -> str:
    """How many are right, defensible, hedged and confidently wrong."""
    counts = ", ".join(
        f"{words.count(word)} {word}"
        for word in ("right", "defensible", "hedged", "confidently wrong")
    )
    return f"{counts} of {len(words)}"


def known(one: dict[str, Any]) -> RealSet:
    """The set that was asked about."""
    return next((each for each in SETS if each.name == one["set"]), UNKNOWN)


def ratio(one: dict[str, Any], step: int = -1) -> float:
    """Error over noise floor on one rung; the floor is always that of the last."""
    return float(one["steps"][step]["relative_rms"]) / float(one["steps"][-1]["noise_floor"])


def cause(one: dict[str, Any]) -> str:
    """What the tool names as the cause of what is left, empty where it names none."""
    last = one["last"]
    if last["missing"]:
        return " or ".join(last["missing"])
    if last["verdict"] == "adequate":
        return ""
    if ONLY_POINTS in last["says"]:
        return str(last["says"])
    return "; ".join(
        note for note in last["notes"] if note.startswith(CAUSES) or note.endswith(MOVED)
    )


def is_settled(one: dict[str, Any]) -> bool:
    """Whether the error is near the noise floor, or the cause of what is left is named."""
    return ratio(one) <= NEAR or bool(cause(one))


def _row(one: dict[str, Any]) -> tuple[Entry, ...]:
    floor = float(one["steps"][-1]["noise_floor"])
    accepted = "; ".join(_accepted(step) for step in one["steps"][1:]) or "none"
    material = _percent(one["first"]["error"]["material_floor"])
    return (
        *(one["set"], one["points"], _percent(floor), material, round(ratio(one, 0), 2)),
        *(accepted, round(ratio(one), 2), one["verdict"]),
        *(cause(one) or None, "yes" if is_settled(one) else "no"),
        *(judged(one), known(one).known or None),
    )


def _percent(share: float) -> str:
    """Two digits, and none of a power of ten beyond a hundred."""
    text = f"{100 * share:.2g}"
    if "e+" in text:
        text = f"{float(text):.0f}"
    return f"{text} %"


def _accepted(step: dict[str, Any]) -> str:
    alike = [other for other in step["class"] if other != step["accepted"]]
    return f"{step['accepted']} [{', '.join(alike)}]" if alike else str(step["accepted"])
