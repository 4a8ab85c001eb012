"""Cases: a test, a base model that will be judged, and what is hidden from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from springpot.measurement import Loading, TimeTest

from .physics import Real, Stiffness, clock, creep, material, played, relaxation, to_history

NOISE = (0.001, 0.02)
"""Standard deviation of the noise over the largest response, of good transducers to poor ones."""
READ = (0.0003, 0.01)
"""The same of a transducer of the motion, over its largest reading."""
SAMPLES = (120, 1000)
REMEMBERED = 0.25
"""Share of the cases whose noise has a memory, as that of a filtered transducer."""
RAMP = 1.0
"""Seconds to which all times of a case refer; each material has its own near it."""


@dataclass
class Setting:
    """One test before anything is hidden.

    The clock, what is imposed, the material and the ideal response.

    Attributes
    ----------
    kind : str
        ``relaxation``, ``creep``, ``recovery``, ``startup`` or ``history``.
    base : str
        Name of the model that will be judged.
    theta : dict
        Its parameters.
    t, x : ndarray
        Samples, and what is imposed there.
    loading : Loading
        The same as springpot is told.
    """

    kind: str
    base: str
    theta: dict[str, float]
    t: Real
    x: Real
    loading: Loading
    truth: dict[str, float] = field(default_factory=dict)

    @property
    def stiffness(self) -> Stiffness:
        """K(s)."""
        return material(self.base, self.theta)

    @property
    def control(self) -> str:
        """What is imposed."""
        return "force" if self.kind in ("creep", "recovery") else "displacement"

    @property
    def size(self) -> float:
        """|K| at the middle of the test."""
        middle = 1.0 / np.sqrt(self.t[self.t > 0.0][0] * self.t[-1])
        return float(abs(self.stiffness(np.array([1j * middle]))[0]))

    def answer(
        self, stiffness: Stiffness | None = None, t: Real | None = None, x: Real | None = None
    ) -> Real:
        """The response of a material, by another clock or to another course if these are given."""
        stiffness = self.stiffness if stiffness is None else stiffness
        clock = self.t if t is None else t
        if self.kind == "relaxation":
            return relaxation(stiffness, clock)
        if self.kind == "creep":
            return creep(stiffness, clock)
        if self.kind == "recovery":
            return self.recovered(stiffness, clock, 1.0, 0.0)
        return to_history(stiffness, self.t, self.x if x is None else x)

    def recovered(self, stiffness: Stiffness, t: Real, first: float, last: float) -> Real:
        """Creep under `first`, and from the release on under `last`."""
        released = self.loading.time[2]
        found = first * creep(stiffness, t)
        after = t > released
        found[after] += (last - first) * creep(stiffness, t[after] - released)
        return found


Hidden = Callable[[Setting, np.random.Generator], Real]
BASES = {
    "relaxation": (
        "springpot",
        "maxwell",
        "zener",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
    ),
    "creep": (
        "springpot",
        "kelvin",
        "zener",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
    ),
    "recovery": (
        "springpot",
        "zener",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
    ),
    "startup": (
        "springpot",
        "maxwell",
        "zener",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
    ),
    "history": (
        "springpot",
        "maxwell",
        "zener",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
    ),
}


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number of any size between two."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn_setting(rng: np.random.Generator, kinds: Sequence[str] = tuple(BASES)) -> Setting:
    """A test of one of some kinds, a material and its parameters."""
    kind = str(rng.choice(list(kinds)))
    base = str(rng.choice(BASES[kind]))
    n = int(_between(rng, *SAMPLES))
    alpha, k = float(rng.uniform(0.25, 0.75)), _between(rng, 10.0, 1000.0)
    tau = _between(rng, 0.3, 3.0)
    own = {
        "springpot": {"c": k, "alpha": alpha},
        "kelvin": {"k": k, "c": k * tau},
        "maxwell": {"k": k, "c": k * tau},
        "zener": {"k1": k * float(rng.uniform(0.1, 0.6)), "k2": k, "c": k * tau},
        "fractional-kelvin": {"k": k * float(rng.uniform(0.1, 0.6)), "c": k, "alpha": alpha},
        "fractional-maxwell": {"k": k, "c": k * tau**alpha, "alpha": alpha},
        "fractional-zener": {
            "k1": k * float(rng.uniform(0.1, 0.6)),
            "k2": k,
            "c": k * tau**alpha,
            "alpha": alpha,
        },
    }[base]
    if kind in ("relaxation", "creep"):
        t = np.geomspace(0.01, 100.0, n)
        return Setting(kind, base, own, t, np.ones(n), Loading.step())
    if kind == "recovery":
        t = np.linspace(0.0, 20.0, n + 1)[1:]
        release = float(rng.uniform(6.0, 12.0))
        knots = np.array([0.0, 0.0, release, release, 20.0])
        values = np.array([0.0, 1.0, 1.0, 0.0, 0.0])
        return Setting(kind, base, own, t, (t < release).astype(float), Loading(knots, values))
    if kind == "startup":
        t = np.linspace(0.0, 10.0, n)
        return Setting(kind, base, own, t, t.copy(), Loading(t, t))
    t = np.linspace(0.0, 30.0, n)
    rate = float(rng.uniform(0.7, 1.6))
    x = np.sin(rate * t) * (1.0 + float(rng.uniform(0.0, 0.4)) * np.sin(0.31 * rate * t))
    return Setting(kind, base, own, t, x, Loading(t, x))


# --- what the test did


def finite_ramp(at: Setting, rng: np.random.Generator) -> Real:
    """A step that took some time."""
    rise = at.truth["rise"] = _between(rng, 0.02, 1.0)
    stiffness = at.stiffness
    function = (
        (lambda s: stiffness(s) / s**2)
        if at.kind == "relaxation"
        else (lambda s: 1.0 / (s**2 * stiffness(s)))
    )
    return _ramped(function, at.t, rise)


def _ramped(function: Stiffness, t: Real, rise: float) -> Real:
    from .physics import inverse

    whole = inverse(function, t)
    after = t > rise
    whole[after] -= inverse(function, t[after] - rise)
    return whole / rise


def drift(at: Setting, rng: np.random.Generator) -> Real:
    """A zero that wanders."""
    ideal = at.answer()
    share = _between(rng, 0.003, 0.3) * float(rng.choice([-1.0, 1.0]))
    rate = at.truth["rate"] = share * float(np.abs(ideal).max()) / at.t[-1]
    return ideal + rate * at.t


def thermal(at: Setting, rng: np.random.Generator) -> Real:
    """A fixture that grows."""
    ideal = at.answer()
    share = _between(rng, 0.005, 0.3) * float(rng.choice([-1.0, 1.0]))
    size = at.truth["size"] = share * float(np.abs(ideal).max())
    # Steel a tenth of a millimetre thick, in air that is blown at it, takes seconds to follow it.
    tau = at.truth["tau"] = max(_between(rng, 0.05, 0.5) * at.t[-1], 1.0)
    return ideal + size * (1.0 - np.exp(-at.t / tau))


def ageing(at: Setting, rng: np.random.Generator) -> Real:
    """A material that ages while it is tested."""
    mu = at.truth["mu"] = float(rng.uniform(0.15, 1.0))
    waited = at.truth["waited"] = _between(rng, 0.05, 0.5) * at.t[-1]
    return at.answer(t=clock(lambda u: (waited / (waited + u)) ** mu, at.t))


def warming(at: Setting, rng: np.random.Generator) -> Real:
    """A specimen that comes to its temperature."""
    s = at.truth["s"] = _between(rng, 0.2, 4.0) * float(rng.choice([-1.0, 1.0]))
    tau = at.truth["tau"] = _between(rng, 0.01, 0.3) * at.t[-1]
    return at.answer(t=clock(lambda u: np.exp(-s * np.exp(-u / tau)), at.t))


def clipping(at: Setting, rng: np.random.Generator) -> Real:
    """A channel that saturates."""
    ideal = at.answer()
    limit = at.truth["limit"] = float(rng.uniform(0.5, 0.97)) * float(np.abs(ideal).max())
    return np.clip(ideal, -limit, limit)


def damage(at: Setting, rng: np.random.Generator) -> Real:
    """A specimen that loses stiffness with every cycle."""
    share = at.truth["d"] = _between(rng, 0.003, 0.15)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(at.x)))]) / (4.0 * np.abs(at.x).max())
    return at.answer() * np.exp(-share * way)


def backlash(at: Setting, rng: np.random.Generator) -> Real:
    """A joint with play."""
    reach = at.truth["b"] = _between(rng, 0.005, 0.3)
    return at.answer(x=played(at.x, reach))


def bearing(at: Setting, rng: np.random.Generator) -> Real:
    """A bearing that holds a share of the force back."""
    force = at.truth["F"] = _between(rng, 0.005, 0.3)
    return at.recovered(at.stiffness, at.t, 1.0 - force, force)


def one_stop(at: Setting, rng: np.random.Generator) -> Real:
    """A stop on one side."""
    k = at.truth["k"] = _between(rng, 0.05, 3.0) * at.size
    place = at.truth["place"] = float(rng.uniform(0.1, 0.85)) * float(rng.choice([-1.0, 1.0]))
    if at.kind == "startup":
        place = at.truth["place"] = abs(place) * float(at.x.max())
    side = np.sign(place)
    return at.answer() + k * side * np.maximum(side * (at.x - place), 0.0)


def lean(at: Setting, rng: np.random.Generator) -> Real:
    """Stiffer on one side."""
    k2 = at.truth["k2"] = (
        _between(rng, 0.01, 0.5) * at.size * float(rng.choice([-1.0, 1.0])) / np.abs(at.x).max()
    )
    return at.answer() + k2 * at.x**2


# --- what the specimen or the rig has


def _linear(change: Callable[[Setting, np.random.Generator], Stiffness]) -> Hidden:
    def hidden(at: Setting, rng: np.random.Generator) -> Real:
        return at.answer(change(at, rng))

    hidden.__doc__ = change.__doc__
    return hidden


@_linear
def series_spring(at: Setting, rng: np.random.Generator) -> Stiffness:
    """An instrument that gives."""
    k, own = _between(rng, 1.0, 30.0) * at.size, at.stiffness
    at.truth["k"] = k
    return lambda s: 1.0 / (1.0 / k + 1.0 / own(s))


@_linear
def parallel_spring(at: Setting, rng: np.random.Generator) -> Stiffness:
    """A spring beside."""
    k, own = _between(rng, 0.02, 1.0) * at.size, at.stiffness
    at.truth["k"] = k
    return lambda s: k + own(s)


@_linear
def mode(at: Setting, rng: np.random.Generator) -> Stiffness:
    """One more relaxation time."""
    k, own = _between(rng, 0.05, 1.0) * at.size, at.stiffness
    tau = _between(rng, 0.05, 5.0)
    at.truth |= {"k": k, "tau": tau}
    return lambda s: own(s) + k * s * tau / (1.0 + s * tau)


@_linear
def retarded(at: Setting, rng: np.random.Generator) -> Stiffness:
    """One more retardation time."""
    j, own = _between(rng, 0.05, 1.0) / at.size, at.stiffness
    tau = _between(rng, 0.05, 5.0)
    at.truth |= {"k": 1.0 / j, "tau": tau}
    return lambda s: 1.0 / (1.0 / own(s) + j / (1.0 + s * tau))


@_linear
def swinging(at: Setting, rng: np.random.Generator) -> Stiffness:
    """A mass that swings in creep."""
    mass, own = _between(rng, 1e-3, 1.0) * at.size, at.stiffness
    at.truth["m"] = mass
    return lambda s: own(s) + mass * s**2


def accelerations(x: Real, t: Real) -> Real:
    """Second derivative (n,) of a motion; at the ends, where none is seen, that of the next."""
    inner = np.gradient(np.gradient(x, t), t)[2:-2]
    return np.pad(inner, 2, mode="edge")


def moving_mass(at: Setting, rng: np.random.Generator) -> Real:
    """A mass that is shaken."""
    mass = at.truth["m"] = _between(rng, 0.01, 1.0) * at.size
    return at.answer() + mass * accelerations(at.x, at.t)


def friction(at: Setting, rng: np.random.Generator) -> Real:
    """Dry friction."""
    force = at.truth["F"] = _between(rng, 0.005, 0.3) * at.size
    return at.answer() + force * np.sign(np.gradient(at.x, at.t))


def cubic(at: Setting, rng: np.random.Generator) -> Real:
    """A spring that hardens."""
    k3 = at.truth["k3"] = _between(rng, 0.01, 0.5) * at.size
    return at.answer() + k3 * at.x**3


def gap(at: Setting, rng: np.random.Generator) -> Real:
    """Stops on both sides."""
    k, b = _between(rng, 0.05, 2.0) * at.size, float(rng.uniform(0.1, 0.8))
    at.truth |= {"k": k, "b": b}
    return at.answer() + k * np.sign(at.x) * np.maximum(np.abs(at.x) - b, 0.0)


def delay(at: Setting, rng: np.random.Generator) -> Real:
    """A force that is read late."""
    tau = at.truth["tau"] = _between(rng, 0.003, 0.3)
    return np.interp(at.t - tau, at.t, at.answer())


INSIDE: dict[str, dict[str, Hidden]] = {
    "relaxation": {
        "finite-ramp": finite_ramp,
        "force-drift": drift,
        "thermal-force": thermal,
        "ageing": ageing,
        "thermal-transient": warming,
        "parallel-spring": parallel_spring,
        "relaxation-mode": mode,
    },
    "creep": {
        "finite-ramp": finite_ramp,
        "displacement-drift": drift,
        "thermal-growth": thermal,
        "ageing": ageing,
        "thermal-transient": warming,
        "series-spring": series_spring,
        "retardation-mode": retarded,
        "inertia": swinging,
    },
    "recovery": {
        "displacement-drift": drift,
        "thermal-growth": thermal,
        "bearing-friction": bearing,
        "series-spring": series_spring,
        "retardation-mode": retarded,
    },
    "startup": {
        "force-drift": drift,
        "thermal-force": thermal,
        "relaxation-mode": mode,
        "force-clipping": clipping,
        "asymmetric-stop": one_stop,
    },
    "history": {
        "force-drift": drift,
        "damage": damage,
        "force-clipping": clipping,
        "backlash-in-time": backlash,
        "asymmetric-stop": one_stop,
        "asymmetric-stiffness": lean,
        "inertia": moving_mass,
        "friction": friction,
        "cubic-stiffness": cubic,
        "dead-zone": gap,
        "time-delay": delay,
        "relaxation-mode": mode,
        "series-spring": series_spring,
    },
}


# --- what no effect of the library is


def hum(at: Setting, rng: np.random.Generator) -> Real:
    """Mains that leak into the signal, slow by aliasing."""
    ideal = at.answer()
    index = np.arange(len(ideal))
    period = float(rng.uniform(9.0, 25.0))
    size = _between(rng, 0.01, 0.1) * float(np.abs(ideal).max())
    return ideal + size * np.sin(2.0 * np.pi * index / period + float(rng.uniform(0.0, 6.0)))


def slip(at: Setting, rng: np.random.Generator) -> Real:
    """A specimen that slips once, in the middle of the test."""
    ideal = at.answer()
    k = int(rng.uniform(0.4, 0.8) * len(ideal))
    size = _between(rng, 0.02, 0.2) * float(np.abs(ideal).max())
    return ideal - size * (np.arange(len(ideal)) >= k)


def bump(at: Setting, rng: np.random.Generator) -> Real:
    """Somebody leans on the table."""
    ideal = at.answer()
    middle = float(rng.uniform(0.3, 0.8)) * len(ideal)
    wide = float(rng.uniform(0.02, 0.06)) * len(ideal)
    size = _between(rng, 0.03, 0.3) * float(np.abs(ideal).max())
    return ideal + size * np.exp(-(((np.arange(len(ideal)) - middle) / wide) ** 2))


def frozen(at: Setting, rng: np.random.Generator) -> Real:
    """A record that stood still for a while."""
    ideal = at.answer()
    first = int(rng.uniform(0.3, 0.7) * len(ideal))
    ideal[first : first + int(rng.uniform(0.05, 0.12) * len(ideal))] = ideal[first]
    return ideal


def twice(at: Setting, rng: np.random.Generator) -> Real:
    """A zero that wanders to and fro."""
    ideal = at.answer()
    size = _between(rng, 0.01, 0.1) * float(np.abs(ideal).max())
    steps = np.arange(len(ideal)) / len(ideal)
    return ideal + size * np.sin(2.0 * np.pi * float(rng.uniform(2.3, 4.7)) * steps)


OUTSIDE: dict[str, Hidden] = {
    "hum": hum,
    "slip": slip,
    "bump": bump,
    "frozen": frozen,
    "wander": twice,
}


# --- a case


@dataclass(frozen=True, eq=False)
class Case:
    """One measurement, and what is known of it.

    Attributes
    ----------
    setting : Setting
        The test.
    hidden : str
        Name of what is hidden; empty where nothing is.
    outside : bool
        Whether the library has no such effect.
    test : TimeTest
        What springpot is given.
    sd, memory : float
        Of the noise.
    exact : ndarray
        The response without noise.
    """

    setting: Setting
    hidden: str
    outside: bool
    test: TimeTest
    sd: float
    memory: float
    exact: Real


def drawn_case(seed: int, index: int, read: bool = False) -> Case:
    """One case: a fifth has nothing missing, a seventh something that no library has.

    Where the motion is `read`, it is a record, and of its motion springpot knows what a transducer
    with noise says.
    """
    rng = np.random.default_rng([seed, index])
    at = drawn_setting(rng, ("history",)) if read else drawn_setting(rng)
    lot = rng.random()
    if lot < 0.2:
        name, exact = "", at.answer()
    elif lot < 0.2 + 1.0 / 7.0:
        name = str(rng.choice(list(OUTSIDE)))
        exact = OUTSIDE[name](at, rng)
    else:
        name = str(rng.choice(list(INSIDE[at.kind])))
        exact = INSIDE[at.kind][name](at, rng)
    sd = _between(rng, *NOISE) * float(np.abs(exact).max())
    memory = float(rng.uniform(0.2, 0.6)) if rng.random() < REMEMBERED else 0.0
    white = rng.normal(size=len(exact) + 50)
    noise = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white)[50:]
    response, name_of_test = exact + sd * noise, f"case-{index}"
    test = TimeTest(at.t, response, at.loading, at.control, "mm", "N", name=name_of_test)
    if read:
        own = _between(rng, *READ) * float(np.abs(at.x).max()) * rng.normal(size=len(at.x))
        test = TimeTest.of_history(
            at.t, at.x + own, response, "mm", "N", control="displacement", name=name_of_test
        )
    return Case(at, name, name in OUTSIDE, test, sd, memory, exact)
