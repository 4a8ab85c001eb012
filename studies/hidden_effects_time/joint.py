"""Several tests of one specimen.

What one of them has, what all have, and what the calibration between them is.

Sweeps are K(i omega), written out; relaxation and creep come by inversion of Laplace transforms:
nothing here knows how springpot computes them. How visible something hidden is follows without
springpot too: it is the least chi-square that the base model, fitted by these formulas to what was
measured without noise, must leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from springpot.measurement import Measurement, TimeTest

from .physics import Real, Stiffness, creep, material, relaxation

TOGETHER = (
    ("sweep", "relaxation"),
    ("sweep", "creep"),
    ("relaxation", "creep"),
    ("sweep", "relaxation", "creep"),
)
"""Tests of one specimen."""
BASES = ("springpot", "zener", "fractional-kelvin", "fractional-maxwell", "fractional-zener")
GROUPS = {
    "nothing": 0.25,
    "material": 0.2,
    "rig": 0.15,
    "signal": 0.12,
    "calibration": 0.15,
    "outside": 0.13,
}
"""What is hidden, and in which share of the cases."""
NOISE = (0.002, 0.02)
"""Standard deviation of the noise: of a sweep as a share of |K|, of a record of its largest value.
"""
POINTS, SAMPLES = (15, 40), (60, 400)
GIVEN = 0.5
"""Share of the sweeps that come with their standard deviations."""


@dataclass(frozen=True, eq=False)
class Specimen:
    """What was measured of one specimen, without noise yet.

    Attributes
    ----------
    tests : tuple of str
        Kinds of the tests.
    base : str
        The model that will be judged.
    theta : dict
        Its true parameters.
    at : dict of str to ndarray
        Angular frequencies of a sweep, times of the others.
    """

    tests: tuple[str, ...]
    base: str
    theta: dict[str, float]
    at: dict[str, Real]

    @property
    def stiffness(self) -> Stiffness:
        """K(s)."""
        return material(self.base, self.theta)

    @property
    def size(self) -> float:
        """|K| at one radian a second."""
        return float(abs(self.stiffness(np.array([1j]))[0]))

    @property
    def in_time(self) -> tuple[str, ...]:
        """The tests that are no sweep."""
        return tuple(test for test in self.tests if test != "sweep")

    def answers(self, changed: dict[str, Stiffness]) -> dict[str, Real]:
        """What each test shows; `changed` has the K(s) of those that feel another one."""
        laws = {test: changed.get(test, self.stiffness) for test in self.tests}
        return {test: shown(test, laws[test], self.at[test]) for test in self.tests}

    def all_feel(self, law: Stiffness) -> dict[str, Stiffness]:
        """One K(s) for all tests."""
        return dict.fromkeys(self.tests, law)


def shown(test: str, law: Stiffness, at: Real) -> Real:
    """What a test of that kind shows of K(s)."""
    if test == "relaxation":
        return relaxation(law, at)
    if test == "creep":
        return creep(law, at)
    return np.asarray(law(1j * at))


@dataclass(frozen=True, eq=False)
class Found:
    """What is hidden: its name, the tests that have it, and what all tests show with it."""

    name: str
    where: tuple[str, ...]
    exact: dict[str, Real]


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number of any size between two."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def signed(rng: np.random.Generator, low: float, high: float) -> float:
    """The same of either sign."""
    return between(rng, low, high) * float(rng.choice([-1.0, 1.0]))


def drawn_specimen(rng: np.random.Generator) -> Specimen:
    """Tests, a material and its parameters."""
    tests = TOGETHER[int(rng.integers(len(TOGETHER)))]
    base = str(rng.choice(BASES))
    alpha, k = float(rng.uniform(0.25, 0.75)), between(rng, 10.0, 1000.0)
    tau, soft = between(rng, 0.3, 3.0), k * float(rng.uniform(0.1, 0.6))
    theta = {
        "springpot": {"c": k, "alpha": alpha},
        "zener": {"k1": soft, "k2": k, "c": k * tau},
        "fractional-kelvin": {"k": soft, "c": k, "alpha": alpha},
        "fractional-maxwell": {"k": k, "c": k * tau**alpha, "alpha": alpha},
        "fractional-zener": {"k1": soft, "k2": k, "c": k * tau**alpha, "alpha": alpha},
    }[base]
    at = {}
    for test in tests:
        at[test] = np.geomspace(0.01, 100.0, int(between(rng, *SAMPLES)))
        if test == "sweep":
            at[test] = np.geomspace(0.1, 100.0, int(rng.integers(POINTS[0], POINTS[1] + 1)))
    return Specimen(tests, base, theta, at)


# --- what is hidden
# ---------------------------------------------------------------------------------------


def of_material(specimen: Specimen, rng: np.random.Generator) -> Found:
    """A slow mode or a solvent's dashpot, which all tests feel."""
    own = specimen.stiffness
    name = str(rng.choice(["relaxation-mode", "parallel-dashpot"]))
    c = between(rng, 0.003, 0.3) * specimen.size
    k, tau = between(rng, 0.05, 1.0) * specimen.size, between(rng, 2.0, 40.0)

    def law(s: Real) -> Real:
        if name == "parallel-dashpot":
            return np.asarray(own(s) + c * s)
        return np.asarray(own(s) + k * s * tau / (1.0 + s * tau))

    return Found(name, specimen.tests, specimen.answers(specimen.all_feel(law)))


def of_rig(specimen: Specimen, rng: np.random.Generator) -> Found:
    """A mass that moves along, or what yields: on one rig, of a sweep or in time, or on all.

    A mass in a relaxation shows nothing, and that of a creep test rings at 0.5 to 10 rad/s.
    """
    own = specimen.stiffness
    yields = between(rng, 1.0, 30.0) * specimen.size
    mass = between(rng, 0.01, 0.5) * abs(own(np.array([100j]))[0]) / 100.0**2
    where, lot = specimen.tests, float(rng.random())
    name = "series-spring"
    if "sweep" in specimen.tests and lot < 0.5:
        where = ("sweep",)
        name = "inertia" if lot < 0.25 else name
    elif lot < 0.8:
        where = (str(rng.choice(specimen.in_time)),)
        if where == ("creep",) and rng.random() < 0.5:
            name, rings = "inertia", between(rng, 0.5, 10.0)
            mass = abs(own(np.array([1j * rings]))[0]) / rings**2
    laws: dict[str, Stiffness] = {
        "inertia": lambda s: own(s) + mass * s**2,
        "series-spring": lambda s: 1.0 / (1.0 / own(s) + 1.0 / yields),
    }
    return Found(name, where, specimen.answers(dict.fromkeys(where, laws[name])))


def of_signal(specimen: Specimen, rng: np.random.Generator) -> Found:
    """A fault of one channel: a delay, an angle, a gain of the sweep, or the drift of a record."""
    exact = specimen.answers({})
    names = ["drift"]
    if "sweep" in specimen.tests:
        names = ["time-delay", "phase-error", "gain-error", "drift"]
    name = str(rng.choice(names))
    if name == "drift":
        test = str(rng.choice(specimen.in_time))
        name = "force-drift" if test == "relaxation" else "displacement-drift"
        share = signed(rng, 0.01, 0.3) * np.abs(exact[test]).max()
        exact[test] = exact[test] + share * specimen.at[test] / 100.0
        return Found(name, (test,), exact)
    factor: Real = np.exp(1j * specimen.at["sweep"] * between(rng, 2e-4, 3e-3))
    if name == "phase-error":
        factor = np.asarray(np.exp(1j * signed(rng, 0.005, 0.1)))
    if name == "gain-error":
        factor = np.asarray(1.0 + signed(rng, 0.01, 0.2))
    exact["sweep"] = exact["sweep"] * factor
    return Found(name, ("sweep",), exact)


def of_calibration(specimen: Specimen, rng: np.random.Generator) -> Found:
    """One test against the others.

    A gain of some percent, or a dimension of the specimen that was mistaken.
    """
    exact = specimen.answers({})
    test = str(rng.choice(specimen.tests))
    factor = 1.0 + signed(rng, 0.01, 0.15)
    if rng.random() < 0.3:
        factor = between(rng, 1.3, 3.0) ** float(rng.choice([-1.0, 1.0]))
    exact[test] = exact[test] * factor
    return Found("gain-error", (test,), exact)


def of_nothing(specimen: Specimen, rng: np.random.Generator) -> Found:
    """Nothing."""
    return Found("", (), specimen.answers({}))


def of_no_library(specimen: Specimen, rng: np.random.Generator) -> Found:
    """A hum, a slip, a bump or a wandering zero in one record; a ripple in a sweep."""
    exact = specimen.answers({})
    test = str(rng.choice(specimen.tests))
    n = len(specimen.at[test])
    course, size = np.arange(n) / n, signed(rng, 0.03, 0.3)
    if test == "sweep":
        ripple = 1.0 + size * np.sin(2.0 * np.pi * float(rng.uniform(2.3, 4.7)) * course)
        return Found("ripple", (test,), exact | {test: exact[test] * ripple})
    place, width = float(rng.uniform(0.3, 0.8)), float(rng.uniform(0.02, 0.06))
    shapes = {
        "hum": np.sin(2.0 * np.pi * np.arange(n) / float(rng.uniform(9.0, 25.0))),
        "slip": (course > place).astype(float),
        "bump": np.exp(-(((course - place) / width) ** 2)),
        "wander": np.sin(2.0 * np.pi * float(rng.uniform(2.3, 4.7)) * course),
    }
    name = str(rng.choice(list(shapes)))
    change = 0.5 * size * np.abs(exact[test]).max() * shapes[name]
    return Found(name, (test,), exact | {test: exact[test] + change})


HIDDEN: dict[str, Callable[[Specimen, np.random.Generator], Found]] = {
    "nothing": of_nothing,
    "material": of_material,
    "rig": of_rig,
    "signal": of_signal,
    "calibration": of_calibration,
    "outside": of_no_library,
}


# --- a case
# ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class JointCase:
    """Tests of one specimen, and what is known of them.

    Attributes
    ----------
    specimen : Specimen
        Its tests and its material.
    group : str
        Of what kind it is that is hidden, one of `GROUPS`.
    found : Found
        What is hidden, where, and the tests without noise.
    tests : tuple of TimeTest or Measurement
        What springpot is given.
    visible : float
        Chi-square that no parameters of the base model can take.
    """

    specimen: Specimen
    group: str
    found: Found
    tests: tuple[TimeTest | Measurement, ...]
    visible: float

    @property
    def truth(self) -> frozenset[str]:
        """Names that are right, an effect of one test by itself or said of which.

        A gain of one test is that of the other just as well where there are two: only their ratio
        is seen.
        """
        name, where = self.found.name, self.found.where
        if name != "gain-error":
            return frozenset([name, *(f"{name}:{test}" for test in where if len(where) == 1)])
        if len(self.specimen.tests) == 2:
            where = self.specimen.tests
        names = {"sweep": "gain-error"}
        return frozenset(names.get(test, f"test-gain:{test}") for test in where)


def drawn_case(seed: int, index: int) -> JointCase:
    """The case of that number."""
    rng = np.random.default_rng([seed, index])
    specimen = drawn_specimen(rng)
    group = str(rng.choice(list(GROUPS), p=list(GROUPS.values())))
    found = HIDDEN[group](specimen, rng)
    sd, tests = {}, []
    for name in specimen.tests:
        exact, at = found.exact[name], specimen.at[name]
        share = between(rng, *NOISE)
        noise = rng.normal(size=len(at))
        if name == "sweep":
            # K' and K'' are equally uncertain, each by that share of |K|.
            sd[name] = share * np.abs(exact)
            swept = exact + sd[name] * (noise + 1j * rng.normal(size=len(at)))
            given = sd[name] * (1.0 + 1.0j) if rng.random() < GIVEN else None
            tests.append(Measurement(at, swept, sd=given, name=name))
            continue
        sd[name] = np.full(len(at), share * np.abs(exact).max())
        make = TimeTest.of_relaxation if name == "relaxation" else TimeTest.of_compliance
        tests.append(make(at, exact + sd[name] * noise, name=name))
    return JointCase(specimen, group, found, tuple(tests), _visible(specimen, found, sd))


def _visible(specimen: Specimen, found: Found, sd: dict[str, Real]) -> float:
    """The least chi-square of the base model, over what is measured without noise."""
    names = list(specimen.theta)

    def turned(values: dict[str, float]) -> Real:
        return np.array(
            [values[name] if name == "alpha" else np.log(values[name]) for name in names]
        )

    def missed(u: Real) -> Real:
        pairs = zip(names, u.tolist(), strict=True)
        theta = {name: value if name == "alpha" else float(np.exp(value)) for name, value in pairs}
        law = material(specimen.base, theta)
        left = [(shown(t, law, specimen.at[t]) - found.exact[t]) / sd[t] for t in specimen.tests]
        return np.concatenate([np.concatenate([each.real, each.imag]) for each in left])

    start = turned(specimen.theta)
    alpha = np.array([name == "alpha" for name in names])
    low = np.where(alpha, 0.01, start - 12.0)
    high = np.where(alpha, 0.99, start + 12.0)
    return 2.0 * float(least_squares(missed, start, bounds=(low, high)).cost)
