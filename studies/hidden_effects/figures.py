"""The figures of the hidden-effect test, computed from collected answers, with Wilson intervals."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from math import sqrt
from typing import Any

import numpy as np

Row = dict[str, Any]
DESIGNS = ("sweep", "field", "signals")
SURE = 0.95


@dataclass(frozen=True)
class Figure:
    """One number with its 95 % interval and its goal; ``better`` is ">=" or "<="."""

    name: str
    design: str
    value: float
    low: float
    high: float
    n: int
    goal: float | None = None
    better: str = ">="

    @property
    def met(self) -> bool | None:
        """Whether the value meets the goal; None where there is no goal or no case."""
        if self.goal is None or not self.n:
            return None
        return self.value >= self.goal if self.better == ">=" else self.value <= self.goal

    def to_dict(self) -> Row:
        """Return plain values."""
        return asdict(self) | {"met": self.met}


def wilson(k: int, n: int, z: float = 1.959964) -> tuple[float, float]:
    """Return the Wilson score interval of k successes in n."""
    if n == 0:
        return 0.0, 1.0
    p, scale = k / n, 1.0 + z * z / n
    middle, half = p + z * z / (2 * n), z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


# --- reading one answer
def answer(row: Row) -> Row:
    """Return the diagnosis, empty where the tool failed."""
    return row.get("answer") or {}


def verdict(row: Row) -> str:
    """Return the verdict, "failed" where there is none."""
    return str(answer(row).get("verdict", "failed"))


def flagged(row: Row) -> bool:
    """Whether the tool says that something is missing, named or not."""
    return verdict(row) in {"effect-missing", "unexplained"}


def first(row: Row) -> Row:
    """Return the first candidate, empty where there is none."""
    return (answer(row).get("candidates") or [{}])[0]


def first_class(row: Row) -> list[str]:
    """Return the class of the first candidate."""
    top = first(row)
    return list(top.get("class") or ([top["effect"]] if top else []))


def named(row: Row) -> bool:
    """Whether the first candidate is a hidden effect, by name."""
    return verdict(row) == "effect-missing" and first(row).get("effect") in row["truth"]


def classed(row: Row) -> bool:
    """Whether a hidden effect is in the first class."""
    return verdict(row) == "effect-missing" and bool(set(first_class(row)) & set(row["truth"]))


def sure(row: Row) -> bool:
    """Whether one name is given with confidence."""
    return verdict(row) == "effect-missing" and float(first(row).get("probability") or 0.0) > SURE


def accepted(row: Row) -> list[str]:
    """Return the effects that automatic discovery accepted."""
    steps = (row.get("ladder") or {}).get("steps") or []
    return [s["accepted"] for s in steps if s.get("accepted")]


def found(row: Row, effect: str) -> bool:
    """Whether discovery accepted ``effect`` or a member of a class that holds it."""
    ladder = row.get("ladder") or {}
    classes = [set(c) for c in (ladder.get("diagnosis") or {}).get("classes") or []]
    classes += [
        set(s["class"]) | {s["accepted"]} for s in ladder.get("steps") or [] if s.get("class")
    ]
    names = set(accepted(row))
    return effect in names or any(effect in c and names & c for c in classes)


def settled(row: Row) -> float:
    """Return the error after acceptance over the noise floor.

    Of the ladder where there is one, else predicted.
    """
    steps = (row.get("ladder") or {}).get("steps")
    if steps:
        last = steps[-1]
        return float(last["relative_rms"]) / float(last["noise_floor"])
    floor = (answer(row).get("error") or {}).get("noise_floor")
    after = first(row).get("error_after")
    return float(after) / float(floor) if floor and after else float("nan")


# --- figures
def share(
    name: str,
    design: str,
    rows: Iterable[Row],
    hit: Callable[[Row], bool],
    goal: float | None = None,
    better: str = ">=",
) -> Figure:
    """Return the share of ``rows`` that ``hit``."""
    hits = [bool(hit(r)) for r in rows]
    low, high = wilson(sum(hits), len(hits))
    return Figure(
        name,
        design,
        sum(hits) / len(hits) if hits else float("nan"),
        low,
        high,
        len(hits),
        goal,
        better,
    )


def mean(
    name: str, design: str, values: Iterable[float], goal: float | None = None, better: str = "<="
) -> Figure:
    """Return a mean with its normal 95 % interval."""
    x = np.array(list(values), dtype=float)
    x = x[np.isfinite(x)]
    if not x.size:
        return Figure(name, design, float("nan"), float("nan"), float("nan"), 0, goal, better)
    half = 1.96 * float(x.std()) / sqrt(x.size)
    return Figure(
        name,
        design,
        float(x.mean()),
        float(x.mean()) - half,
        float(x.mean()) + half,
        x.size,
        goal,
        better,
    )


def expected_calibration_error(p: np.ndarray, hit: np.ndarray, bins: int = 10) -> float:
    """Return sum over bins of |accuracy - mean probability|, weighted by their share."""
    if not p.size:
        return float("nan")
    place = np.minimum((p * bins).astype(int), bins - 1)
    gaps = [
        abs(float(np.mean(hit[place == b] - p[place == b]))) * float(np.mean(place == b))
        for b in np.unique(place)
    ]
    return float(sum(gaps))


def calibration(
    name: str, design: str, rows: list[Row], right: Callable[[Row], bool], goal: float | None
) -> Figure:
    """Return the calibration error of the first probability with a bootstrap interval."""
    use = [r for r in rows if verdict(r) == "effect-missing"]
    p = np.array([float(first(r).get("probability") or 0.0) for r in use])
    hit = np.array([float(right(r)) for r in use])
    rng = np.random.default_rng(5)
    picks = (rng.integers(0, max(p.size, 1), max(p.size, 1)) for _ in range(400 if p.size else 0))
    draws = [expected_calibration_error(p[i], hit[i]) for i in picks] or [float("nan")]
    low, high = np.percentile(draws, [2.5, 97.5])
    return Figure(
        name,
        design,
        expected_calibration_error(p, hit),
        float(low),
        float(high),
        p.size,
        goal,
        "<=",
    )


def chance_calibration(name: str, design: str, rows: list[Row]) -> Figure:
    """Return the calibration error that answers of exactly these probabilities have by chance.

    It is not zero.
    """
    p = np.array(
        [float(first(r).get("probability") or 0.0) for r in rows if verdict(r) == "effect-missing"]
    )
    rng = np.random.default_rng(6)
    draws = [
        expected_calibration_error(p, (rng.random(p.size) < p).astype(float)) for _ in range(400)
    ]
    low, high = np.percentile(draws, [2.5, 97.5])
    return Figure(name, design, float(np.mean(draws)), float(low), float(high), p.size, None, "<=")


def table(rows: list[Row]) -> list[Figure]:
    """Return every figure for every design that has cases."""
    out: list[Figure] = []
    for design in DESIGNS:
        here = [r for r in rows if r["design"] == design]
        if here:
            out += [
                *_detection(design, here),
                *_naming(design, here),
                *_ladder(design, here),
                *_outside(design, here),
            ]
            out += _service(design, here)
    return out


def _kind(rows: list[Row], *kinds: str, least: float = 0.0) -> list[Row]:
    return [r for r in rows if r["kind"] in kinds and r["chi2"] >= least]


def _detection(d: str, rows: list[Row]) -> list[Figure]:
    nothing = _kind(rows, "nothing")
    ladders = [r for r in nothing if r.get("ladder")]
    return [
        share("failed (fault, time-out)", d, rows, lambda r: verdict(r) == "failed", 0.0, "<="),
        share("detected, chi2 >= 30", d, _kind(rows, "one", "two", least=30), flagged, 0.99),
        share("nothing missing, yet flagged", d, nothing, flagged, 0.02, "<="),
        share(
            "nothing missing, called inconclusive",
            d,
            nothing,
            lambda r: verdict(r) == "inconclusive",
        ),
        share(
            "nothing missing, yet auto-accepted",
            d,
            ladders,
            lambda r: bool(accepted(r)),
            0.005,
            "<=",
        ),
        same_verdict(d, rows),
    ]


def same_verdict(d: str, rows: list[Row]) -> Figure:
    """Whether other seeds of the simulated noise change the verdict."""
    tried = [r for r in rows if len(r.get("verdicts") or ()) > 1]
    most = max((len(r["verdicts"]) for r in tried), default=0)
    return share(
        f"same verdict for {most} seeds", d, tried, lambda r: len(set(r["verdicts"])) == 1, 0.99
    )


def _naming(d: str, rows: list[Row]) -> list[Figure]:
    one, rich = _kind(rows, "one"), d != "sweep"
    clear = [r for r in _kind(one, "one", least=120) if identifiable(r)]
    wrong = "confident name and wrong"
    return [
        share("in first class, chi2 >= 60", d, _kind(one, "one", least=60), classed, 0.98),
        share(
            "first by name, chi2 >= 120",
            d,
            _kind(one, "one", least=120),
            named,
            0.92 if rich else 0.90,
        ),
        share(
            "first by name, chi2 >= 400",
            d,
            _kind(one, "one", least=400),
            named,
            0.98 if rich else 0.97,
        ),
        share("first by name, chi2 >= 120, no equal rival", d, clear, named),
        mean(
            "mean size of first class, chi2 >= 60",
            d,
            (len(first_class(r)) for r in _kind(one, "one", least=60) if first(r)),
            1.8 if rich else 2.5,
        ),
        share(
            wrong, d, _kind(rows, "nothing", "one"), lambda r: sure(r) and not named(r), 0.01, "<="
        ),
        share(wrong + ", of the confident", d, [r for r in one if sure(r)], lambda r: not named(r)),
        share(
            wrong + ", not even its class",
            d,
            _kind(rows, "nothing", "one"),
            lambda r: sure(r) and not classed(r),
        ),
        calibration(
            "calibration error of first probability", d, _kind(rows, "nothing", "one"), named, 0.03
        ),
        chance_calibration(
            "calibration error of a perfect answerer", d, _kind(rows, "nothing", "one")
        ),
        calibration("calibration error, by class", d, _kind(rows, "nothing", "one"), classed, None),
    ]


def identifiable(row: Row) -> bool:
    """Whether no other effect explains the noise-free data as well as the truth.

    The row needs rivals. Those with more parameters than the truth are supersets and lose by
    parsimony; they do not count.
    """
    others = row.get("rivals") or {}
    own = row.get("rival_sizes", {}).get(row["truth"][0], 1)
    return bool(others) and all(
        left > 12.0 or row["rival_sizes"].get(name, 1) > own
        for name, left in others.items()
        if name not in row["truth"]
    )


def _ladder(d: str, rows: list[Row]) -> list[Figure]:
    hidden = _kind(rows, "one", "two", least=30)
    walked = [r for r in hidden if accepted(r)] or [
        r for r in hidden if verdict(r) == "effect-missing"
    ]
    two = [r for r in _kind(rows, "two") if r.get("ladder")]
    clear = [r for r in two if min(r["own_chi2"]) >= 120]
    goal = 0.90 if d != "sweep" else 0.75
    return [
        share(
            "error after acceptance / floor in 0.95-1.05",
            d,
            walked,
            lambda r: 0.95 <= settled(r) <= 1.05,
            0.95,
        ),
        mean("error after acceptance / floor, mean", d, (settled(r) for r in walked)),
        share(
            "the true model itself: its error / true floor in 0.95-1.05",
            d,
            [r for r in walked if r.get("true_ratio")],
            lambda r: 0.95 <= r["true_ratio"] <= 1.05,
        ),
        share(
            "predicted error drop within 20 %", d, [r for r in walked if r.get("ladder")], _foreseen
        ),
        share("two effects, both found (all)", d, two, _both),
        share("two effects, both found, each chi2 >= 120", d, clear, _both, goal),
        share(
            "two effects, exactly these accepted, each >= 120",
            d,
            clear,
            lambda r: _both(r) and len(accepted(r)) == 2,
        ),
        share("two effects, one of them in first class", d, _kind(rows, "two", least=60), classed),
    ]


def _both(row: Row) -> bool:
    return all(found(row, effect) for effect in row["truth"])


def _foreseen(row: Row) -> bool:
    steps = row["ladder"]["steps"]
    if len(steps) < 2 or steps[1].get("predicted_error") is None:
        return False
    drop = steps[0]["relative_rms"] - steps[1]["relative_rms"]
    return bool(
        abs(steps[0]["relative_rms"] - steps[1]["predicted_error"] - drop) <= 0.2 * abs(drop)
    )


def _outside(d: str, rows: list[Row]) -> list[Figure]:
    every = _kind(rows, "outside")
    hard = [r for r in every if (r.get("unexplained") or 0.0) >= 30.0]
    plain = "outside the library"
    return [
        share(
            f"{plain}: flagged, unexplained chi2 >= 30",
            d,
            hard,
            flagged,
            0.97 if d == "sweep" else 0.95,
        ),
        share(
            f"{plain}: flagged, correlated noise left out",
            d,
            [r for r in hard if "correlated-noise" not in r["truth"]],
            flagged,
        ),
        share(
            f"{plain}: called unexplained, unexplained chi2 >= 30",
            d,
            hard,
            lambda r: verdict(r) == "unexplained",
        ),
        share(f"{plain}: confidently misnamed, unexplained chi2 >= 30", d, hard, sure, 0.01, "<="),
        share(f"{plain}: confidently misnamed (all)", d, every, sure),
    ]


def _service(d: str, rows: list[Row]) -> list[Figure]:
    tested = [r for r in rows if r.get("tie_broken") is not None]
    out = [
        share(
            "suggested experiment breaks the tie",
            d,
            tested,
            lambda r: r["tie_broken"],
            0.9 if d != "sweep" else 0.8,
        )
    ]
    # The goals are for 50 and 300 points; what lies between is held to neither of them, nor is the
    # chain that starts two programs and reads records of time signals first.
    for low, high, goal in ((0, 60, 1.0), (60, 250, None), (250, 350, 5.0), (350, 10**9, None)):
        times = [
            r["seconds"] for r in rows if low <= r["points"] < high and r.get("seconds") is not None
        ]
        label = (
            f"seconds per answer, {low}-{high} points"
            if high < 10**9
            else f"seconds per answer, {low}+ points"
        )
        out.append(mean(label, d, times, goal if d != "signals" else None))
    return out
