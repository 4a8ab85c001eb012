"""Problems drawn by a seed from the library's own models, effects and tests: as many as one likes.

A suite of sixty is too few to learn a choice from. Each problem here hangs on its seed and its
number alone: a model, up to three effects, true parameters, a test, noise, an objective and how
wide the box is. What cannot be a problem (more than fourteen parameters, a truth outside of its
box, a response that is no number) is drawn anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from springpot import parse_model
from springpot.benchmark import Study
from springpot.benchmark.plan import problem_of
from springpot.benchmark.traits import descents, uniform
from springpot.errors import SpringpotError
from springpot.identification.problem import Problem, SpecimenProblem
from springpot.identification.space import rounded_up
from springpot.measurement import DataSet, Measurement
from springpot.rheology import Real
from springpot.timetests import as_had_by
from springpot_plugins.suites.described import computed, planned

MOST = 14
"""Parameters."""
STARTS, STARTS_IN_TIME = 40, 4
"""Descents beside that from the truth among which the least objective is looked for."""

SWEEPS = {
    "plain": {"hertz": [0.05, 50.0, 16]},
    "amplitude": {"hertz": [0.5, 20.0, 5], "amplitude": [0.25, 0.5, 1.0, 2.0, 4.0]},
    "temperature": {"hertz": [0.05, 50.0, 7], "temperature": [0.0, 10.0, 20.0, 35.0, 50.0]},
    "specimen": {"hertz": [0.1, 50.0, 8], "specimen": [1.0, 2.0, 3.0, 4.0]},
}
STEP: dict[str, Any] = {"kind": "relaxation", "seconds": [0.01, 100.0, 25]}
RECORD = {"kind": "record", "seconds": 4.0, "samples": 81, "amplitude": 1.5}

SPRINGS = ("kelvin", "maxwell", "zener", "zener-kelvin", "jeffreys", "burgers", "zener-2")
CHAINS = ("prony", "maxwell", "kelvin")
FRACTIONAL = (
    *("springpot", "fractional-kelvin", "fractional-maxwell", "fractional-kelvin4"),
    *("fractional-zener", "fractional-maxwell-ab", "oldroyd-b", "makris"),
    *("fractional-maxwell-dashpot", "fractional-kelvin-dashpot", "fractional-solid"),
    *("fractional-jeffreys", "fractional-maxwell-general", "fractional-kelvin-general"),
    *("fractional-zener5", "fractional-zener-general", "fractional-poynting-thomson-general"),
    *("fractional-burgers", "huet", "huet-sayegh", "1s2p1d", "2s2p1d", "havriliak-negami"),
)
EFFECTS = {
    "plain": (
        *("inertia", "time-delay", "series-spring", "parallel-spring", "parallel-dashpot"),
        *("phase-error", "hysteretic-loss", "fixture-resonance", "frame-resonance"),
        *("specimen-inertia", "relaxation-mode", "parallel-springpot"),
    ),
    "amplitude": (
        *("elasto-sliding", "backlash", "friction", "dead-zone", "cubic-damping", "payne"),
        *("cubic-stiffness", "power-law-damper", "inertia", "time-delay", "series-spring"),
    ),
    "temperature": ("arrhenius-shift", "wlf-shift", "vertical-shift", "free-shift"),
    "specimen": ("free-vertical-shift:specimen",),
    "step": (),
    "record": ("elasto-sliding", "backlash-in-time", "force-offset"),
}
KINDS = {"plain": 0.52, "amplitude": 0.22, "temperature": 0.12, "specimen": 0.07, "step": 0.04}
"""Shares of the kinds of tests; the rest are records. Tests in time cost ten times the others."""

RANGES = {
    **dict.fromkeys(("k", "k0", "k1", "k2", "k3", "k4", "k5", "k6", "k7"), (20.0, 1000.0)),
    **dict.fromkeys(("c", "c0", "c1", "c2", "c3"), (3.0, 500.0)),
    **dict.fromkeys(("tau", "ratio", "delta"), (5e-3, 3.0)),
    "series-spring.k": (500.0, 4000.0),
    "parallel-dashpot.c": (0.5, 20.0),
    "parallel-springpot.c": (5.0, 100.0),
    "hysteretic-loss.h": (5.0, 100.0),
    "inertia.m": (1e-4, 1e-3),
    "time-delay.tau": (2e-4, 1e-2),
    "fixture-resonance.omega_r": (60.0, 600.0),
    "frame-resonance.omega_r": (30.0, 200.0),
    "frame-resonance.k": (1000.0, 5000.0),
    "specimen-inertia.m": (5e-4, 1e-2),
    "elasto-sliding.F": (50.0, 500.0),
    "friction.F": (5.0, 80.0),
    "power-law-damper.F": (0.5, 10.0),
    "dead-zone.b": (0.4, 2.0),
    "backlash.b": (0.03, 0.2),
    "backlash-in-time.b": (0.05, 0.4),
    "cubic-damping.c3": (3e-6, 3e-5),
    "payne.h": (0.05, 0.5),
    "payne.Xc": (0.4, 2.0),
    "arrhenius-shift.Ea": (20.0, 150.0),
    "wlf-shift.C1": (4.0, 15.0),
    "wlf-shift.C2": (50.0, 150.0),
    "force-offset.size": (5.0, 40.0),
}
"""Of true parameters by name, of which the logarithm is uniform."""
LINEAR = {
    "phase-error.phi": (-0.05, 0.05),
    "cubic-stiffness.k3": (-3.0, 10.0),
    "fixture-resonance.zeta": (0.01, 0.3),
    "frame-resonance.zeta": (0.01, 0.2),
    "power-law-damper.a": (0.3, 1.8),
    "payne.m": (0.4, 1.0),
    "vertical-shift.n": (-1.0, 2.0),
    "nu": (0.2, 1.0),
}
"""And of those that are uniform themselves; what is named nowhere is an order or a factor."""
ORDERS = (0.1, 0.9)
TIMES = (3e-3, 5.0)
"""Of chains, in order."""
NOISE, WIDTHS = (0.0, 0.005, 0.02), (1.0, 1.0, 3.0, 10.0)
OBJECTIVES = ("relative", "relative", "paper")


def drawn(seed: int, number: int) -> DataSet:
    """The problem of that number."""
    return described(f"drawn-{seed}-{number}", seed, number)[1]


def described(
    name: str, seed: int, number: int, sweeps: Mapping[str, Mapping[str, Any]] = SWEEPS
) -> tuple[dict[str, Any], DataSet]:
    """The problem of that number under a name, with its row of a suite's description."""
    rng = np.random.default_rng([seed, number])
    while True:
        found = _attempt(name, rng, sweeps)
        if found is not None:
            return found


def _attempt(
    name: str, rng: np.random.Generator, sweeps: Mapping[str, Mapping[str, Any]]
) -> tuple[dict[str, Any], DataSet] | None:
    kind = str(rng.choice([*KINDS, "record"], p=[*KINDS.values(), 1.0 - sum(KINDS.values())]))
    protocols = _protocols(kind, sweeps)
    expression = _expression(kind, rng)
    noise = float(rng.choice(NOISE))
    objective = str(rng.choice(OBJECTIVES))
    try:
        plans = [planned(each) for each in protocols]
        model = as_had_by(parse_model(expression), plans)
        if len(model.names) > MOST:
            return None
        truth = _truth(model.names, rng)
        tests = computed(name, expression, protocols, truth, noise)
    except SpringpotError:
        # Not every effect suits every model.
        return None
    scale, wide = None, float(rng.choice(WIDTHS))
    if isinstance(tests[0], Measurement):
        scale = wide * rounded_up(float(np.max(tests[0].magnitude)))
    given: dict[str, Any] = {"truth": truth, "model": expression, "objective": objective}
    made = DataSet(
        name,
        f"{expression}; {kind}; noise of {100 * noise:g} %; {wide:g} times the box",
        lambda: tests,
        kind="artificial",
        licence="none needed",
        citation="computed here",
        stiffness_scale=scale,
        **given,
    )
    try:
        problem = searched(made)
    except SpringpotError:
        # A record of nothing at its first sample is no data.
        return None
    inside = place(made, problem)
    held = np.all((inside >= problem.lower) & (inside <= problem.upper))
    with np.errstate(all="ignore"):
        usable = bool(held) and np.isfinite(problem.evaluate(inside))
    told = {**given, "tests": [kind], "noise": noise, "scale": scale, "wide": wide}
    return (told, made) if usable else None


def _protocols(kind: str, sweeps: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    if kind == "record":
        return [RECORD]
    if kind == "step":
        return [STEP]
    return [{"kind": "sweep", **sweeps[kind]}]


def _expression(kind: str, rng: np.random.Generator) -> str:
    family = rng.random()
    if family < 0.25:
        model = f"{rng.choice(CHAINS)}-{rng.integers(2, 6)}"
    elif family < 0.4 or kind == "record":
        model = str(rng.choice(SPRINGS))
    else:
        model = str(rng.choice(FRACTIONAL))
    known = EFFECTS[kind]
    fewest = int(kind not in ("plain", "step", "record") and len(known) > 0)
    most = min(3, len(known))
    effects = rng.permutation(known)[: rng.integers(fewest, most + 1)] if known else ()
    return " + ".join((model, *map(str, effects)))


def _truth(names: tuple[str, ...], rng: np.random.Generator) -> dict[str, float]:
    times = [name for name in names if name.startswith("tau") and name[3:].isdigit()]
    truth = dict(zip(times, np.sort(np.exp(rng.uniform(*np.log(TIMES), len(times)))), strict=True))
    for name in names:
        if name in truth:
            continue
        last = name.rpartition(".")[2]
        ranges = RANGES.get(name, RANGES.get(last))
        if ranges is not None:
            truth[name] = np.exp(rng.uniform(*np.log(ranges)))
        else:
            truth[name] = rng.uniform(*LINEAR.get(name, LINEAR.get(last, ORDERS)))
    return {name: float(f"{truth[name]:.3g}") for name in names}


def searched(problem: DataSet) -> SpecimenProblem:
    """A problem as an optimiser gets it."""
    (case,) = Study("drawn", [problem], ["own"], ["own"], ["random-search"]).plan().cases
    return problem_of(case.source, case.source.model_of(case.model), case.objective)


def place(known: DataSet, problem: SpecimenProblem) -> Real:
    """Where the truth lies in the box."""
    model = as_had_by(parse_model(known.model), known.tests())
    return problem.space.from_theta(model.vector(dict(known.truth)))


def best(known: DataSet, problem: SpecimenProblem) -> float:
    """The least objective that descents from the truth and from uniform points end at."""
    count = STARTS if isinstance(problem, Problem) else STARTS_IN_TIME
    starts = np.vstack([place(known, problem), uniform(problem, count)])
    return float(np.nanmin(descents(problem, starts)[1]))
