"""What the tool answered, kept as plain data, and the table made of it.

Question: does discovery that begins with a plain model find the physics that is known of a measured
set, and what does it leave? Measure: the effects that it accepts, and the error over the noise
floor before and after. What would answer it: the known effects accepted and no others, with an
error of at most 1.5 times the floor.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from paper.asking import asking
from springpot import Measurement, compare
from springpot.benchmark import Table
from springpot.diagnosis import Ladder
from springpot.files import write_text
from springpot.report.page import Entry

from .published import asked, yardsticks
from .sets import SETS, RealSet

PLACES = 3
"""Places told of those where the last model fails."""
COLUMNS = (
    *("set", "points", "model", "noise floor", "source", "error/floor before"),
    *("effects accepted [cannot be told from]", "error/floor after", "verdict", "what remains"),
)
NOTE = (
    "Error: root mean square of |K - K_model| / |K|; noise floor: the same of noise alone, here"
    " that of the last model, since a bad model takes part of its failure for noise; source: where"
    " it comes from. Before: the model alone over that same floor. Effects are accepted by"
    " `discover` on its own, in this order; in brackets those that these data cannot tell from it."
    " Verdict and remains: on the last model."
)


def answer(one: RealSet, data: Measurement, ladder: Ladder, given: bool = False) -> dict[str, Any]:
    """What the tool says of a set from one model.

    `springpot.discovery/2`, its tests and harmonics, without the rest.

    Parameters
    ----------
    one : RealSet
        The set.
    data : Measurement
        Its data.
    ladder : Ladder
        What was discovered.
    given : bool
        Whether the effects were not chosen by the tool.
    """
    said = ladder.to_dict()
    last = said.pop("diagnosis")
    tests = () if data.harmonics is None else compare(data, [ladder.model]).harmonics
    kept = ("error", "says", "notes")
    return said | {
        "set": one.name,
        "data": one.data,
        "points": len(data),
        "given": given,
        "model": ladder.steps[0].model.name,
        "yardsticks": yardsticks(one, data),
        "last": (
            {key: last[key] for key in kept}
            | {"where": [w["says"] for w in last["where"][:PLACES]]}
        ),
        "rivals": [_rival(c) for c in last["candidates"][:PLACES]],
        "harmonics": [finding.says for finding in tests if finding.found],
    }


def _rival(candidate: dict[str, Any]) -> dict[str, Any]:
    return {
        key: candidate[key]
        for key in ("effect", "verdict", "probability", "delta_bic", "parameters")
    }


def save(found: Sequence[dict[str, Any]], folder: Path) -> Path:
    """Write the answers on one set."""
    (folder / "answers").mkdir(parents=True, exist_ok=True)
    path: Path = write_text(
        folder / "answers" / f"{found[0]['set']}.json", json.dumps(found, indent=1) + "\n"
    )
    return path


def saved(folder: Path) -> Iterator[dict[str, Any]]:
    """All answers in the order of the sets."""
    for one in SETS:
        path = folder / "answers" / f"{one.name}.json"
        if path.exists():
            yield from json.loads(path.read_text(encoding="utf-8"))


def table(answers: Sequence[dict[str, Any]]) -> Table:
    """One row for each set and model."""
    title = "Measured data: what is missing and what remains"
    return asking(__doc__, Table(title, COLUMNS, [_row(one) for one in answers], NOTE))


def _row(one: dict[str, Any]) -> tuple[Entry, ...]:
    steps, last = one["steps"], one["last"]
    floor = steps[-1]["noise_floor"]
    before, after = (step["relative_rms"] / floor for step in (steps[0], steps[-1]))
    source = last["error"]["noise_source"] + (
        " (given doubted)" if "given" in last["error"]["doubt"] else ""
    )
    accepted = (
        "as given" if one["given"] else "; ".join(_accepted(step) for step in steps[1:]) or "none"
    )
    remains = _remains(one)
    return (
        *(one["set"], one["points"], asked(one), f"{100 * floor:.2g} %", source),
        *(round(before, 2), accepted, round(after, 2), one["verdict"], remains),
    )


def _remains(one: dict[str, Any]) -> str:
    """Where the last model fails, or what is said to be missing where no place is told."""
    if one["verdict"] == "adequate":
        return "nothing that the tests see"
    last = one["last"]
    return "; ".join(last["where"]) or str(last["says"]).partition("; ")[2]


def _accepted(step: dict[str, Any]) -> str:
    name: str = step["accepted"]
    alike = [other for other in step["class"] if other != name]
    return f"{name} [{', '.join(alike)}]" if alike else name
