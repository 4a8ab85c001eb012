"""Tests in time from which two effects are missing, and whether both are accepted by name.

Question: are both of two effects that are missing from a test in time accepted by name? Measure:
the share of drawn cases in which discovery accepts both, and that of what it accepts though neither
is in its class. What would answer it: the goals of the study of sweeps, both by name in half of the
cases and at most 1 % invented.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from paper.asking import question
from springpot.errors import SpringpotError
from springpot.measurement import TimeTest
from springpot.registry import parse_model
from springpot.timetests import discover, identify, recorded

from .cases import INSIDE, NOISE, Setting, _between, drawn_setting
from .physics import Real, Stiffness

PLAIN = 120.0
"""Chi-square left without one of the two, all else refitted, from which goals ask its name.

As in the study of sweeps."""
OF_NETWORK = {"series-spring", "parallel-spring", "relaxation-mode", "retardation-mode"}
"""What changes K: whatever else is hidden acts on the K that it has made."""
ADDED = {
    "force-drift",
    "displacement-drift",
    "thermal-force",
    "thermal-growth",
    "friction",
    "cubic-stiffness",
    "dead-zone",
    "asymmetric-stop",
    "asymmetric-stiffness",
}
"""What is added to the response, whatever the rest does."""
TRIES = 200


class Altered(Setting):
    """A setting whose material has one more part."""

    other: Stiffness

    @property
    def stiffness(self) -> Stiffness:
        """K(s) with that part."""
        return self.other


@dataclass(frozen=True, eq=False)
class Two:
    """One measurement from which two effects are missing."""

    setting: Setting
    hidden: tuple[str, str]
    truth: dict[str, float]
    test: TimeTest
    sd: float

    def left_by(self, effects: Sequence[str]) -> float:
        """Chi-square that the base model with these effects leaves, begun at the truth."""
        model = parse_model(self.setting.base)
        for name in effects:
            model = model + name
        values = self.setting.theta | self.truth
        start = model.vector({name: values[name] for name in model.names})
        fit = identify(self.test, model, seeds=[start])
        left = recorded(fit.model, fit.theta, self.test).value - self.test.response
        return float(np.sum(left[np.isfinite(left)] ** 2) / self.sd**2)

    @property
    def plain(self) -> bool:
        """Whether each is plainly missed beside the other."""
        whole = self.left_by(self.hidden)
        return all(self.left_by([one]) - whole > PLAIN for one in self.hidden)


def drawn_two(seed: int, index: int) -> Two:
    """One case: two effects of the library, each plain to see beside the other."""
    for attempt in range(TRIES):
        rng = np.random.default_rng([seed, index, attempt])
        try:
            case = _drawn(rng, index)
            if case is not None and case.plain:
                return case
        except SpringpotError:
            continue
    raise RuntimeError(f"case {index}: nothing plain in {TRIES} draws")


def _drawn(rng: np.random.Generator, index: int) -> Two | None:
    at = drawn_setting(rng)
    library = INSIDE[at.kind]
    first = str(rng.choice(sorted((OF_NETWORK | ADDED) & library.keys())))
    second = str(rng.choice(sorted(library)))
    # Of two that change the course or the signal the order would matter.
    if first == second or (first in ADDED and second not in OF_NETWORK | ADDED):
        return None
    if first in ADDED and second in OF_NETWORK:
        first, second = second, first
    truth: dict[str, float] = {}
    exact = library[first](at, rng)
    beside = replace(at, truth={})
    if first in OF_NETWORK:
        beside = _with(at, first)
        exact = library[second](beside, rng)
    else:
        exact = exact + library[second](beside, rng) - at.answer()
    for name, own in ((first, at.truth), (second, beside.truth)):
        truth |= {f"{name}.{key}": value for key, value in own.items()}
    sd = _between(rng, *NOISE) * float(np.abs(exact).max())
    response: Real = exact + sd * rng.normal(size=len(exact))
    test = TimeTest(at.t, response, at.loading, at.control, "mm", "N", name=f"two-{index}")
    return Two(at, (first, second), truth, test, sd)


def _with(at: Setting, name: str) -> Setting:
    """The setting with a part of its network, of the size that was drawn."""
    own, true = at.stiffness, dict(at.truth)
    changed: dict[str, Stiffness] = {
        "series-spring": lambda s: 1.0 / (1.0 / true["k"] + 1.0 / own(s)),
        "parallel-spring": lambda s: true["k"] + own(s),
        "relaxation-mode": lambda s: own(s) + true["k"] * s * true["tau"] / (1.0 + s * true["tau"]),
        "retardation-mode": lambda s: (
            1.0 / (1.0 / own(s) + 1.0 / (true["k"] * (1.0 + s * true["tau"])))
        ),
    }
    altered = Altered(at.kind, at.base, at.theta, at.t, at.x, at.loading)
    altered.other = changed[name]
    return altered


@dataclass(frozen=True)
class LadderVerdict:
    """What discovery accepted, beside what is true."""

    index: int
    kind: str
    base: str
    hidden: tuple[str, ...]
    accepted: tuple[str, ...]
    classes: tuple[tuple[str, ...], ...]
    verdict: str
    over: float
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    @classmethod
    def from_dict(cls, kept: dict[str, Any]) -> LadderVerdict:
        """Back from plain data."""
        listed = {name: tuple(kept[name]) for name in ("hidden", "accepted")}
        classes = tuple(tuple(each) for each in kept["classes"])
        return cls(**{**kept, **listed, "classes": classes})

    @property
    def by_name(self) -> int:
        """How many of the hidden ones were accepted by name."""
        return len(set(self.hidden) & set(self.accepted))

    @property
    def by_class(self) -> int:
        """How many stand in the class of an accepted one."""
        return sum(any(name in alike for alike in self.classes) for name in self.hidden)

    @property
    def invented(self) -> int:
        """Accepted effects in whose class no hidden one is."""
        return sum(not set(self.hidden) & set(alike) for alike in self.classes)


def judged(case: Two, index: int, effects: Sequence[Any]) -> LadderVerdict:
    """Discover what is missing from one case."""
    began = process_time()
    found = discover([case.test], parse_model(case.setting.base), effects)
    seconds = process_time() - began
    steps = [step for step in found.steps if step.accepted]
    return LadderVerdict(
        index=index,
        kind=case.setting.kind,
        base=case.setting.base,
        hidden=case.hidden,
        accepted=tuple(str(step.accepted) for step in steps),
        classes=tuple(step.alike for step in steps),
        verdict=found.verdict,
        over=found.steps[-1].over_floor,
        seconds=seconds,
    )


def figures(rows: Sequence[LadderVerdict]) -> list[tuple[str, float, int]]:
    """Each figure with its name and the number behind it."""
    accepted = sum(len(row.accepted) for row in rows)
    two, seconds = len(rows), [row.seconds for row in rows]
    return [
        ("both accepted by name", float(np.mean([row.by_name == 2 for row in rows])), two),
        ("both in a class", float(np.mean([row.by_class == 2 for row in rows])), two),
        ("an effect accepted by name", sum(row.by_name for row in rows) / (2 * two), 2 * two),
        ("an effect in a class", sum(row.by_class for row in rows) / (2 * two), 2 * two),
        ("invented", sum(row.invented for row in rows) / max(accepted, 1), accepted),
        ("adequate in the end", float(np.mean([row.verdict == "adequate" for row in rows])), two),
        ("processor time of a ladder, mean, s", float(np.mean(seconds)), two),
    ]


def write_several(rows: Sequence[LadderVerdict], output: Path, seed: int) -> None:
    """The table of the study."""
    lines = [
        "# Two hidden effects of a test in time",
        "",
        question(__doc__),
        "",
        f"`python studies/hidden_effect_time.py --several --cases {len(rows)} --seed {seed}`:"
        " tests from which two effects are missing, each of a chi-square of"
        f" {PLAIN:g} or more beside the other, computed by inversion of Laplace transforms and"
        " asked by `discover --auto`. Invented is what was accepted though neither is in its"
        " class.",
        "",
        "| | figure | of |",
        "|---|---:|---:|",
    ]
    lines += [f"| {name} | {value:.3g} | {count} |" for name, value, count in figures(rows)]
    lines += ["", "| test | cases | both by name | both in a class |", "|---|---:|---:|---:|"]
    for kind in sorted({row.kind for row in rows}):
        own = [row for row in rows if row.kind == kind]
        named, known = (
            sum(getattr(row, way) == 2 for row in own) for way in ("by_name", "by_class")
        )
        lines.append(f"| {kind} | {len(own)} | {named} | {known} |")
    (output / "README.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    told = {name: value for name, value, _ in figures(rows)}
    (output / "figures.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
