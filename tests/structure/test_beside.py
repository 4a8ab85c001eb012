"""Dampers that are not linear.

Friction, sliders, stops and powers of the speed, followed for what they are.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from springpot import Units
from springpot.registry import parse_model
from springpot.structure import (
    Damper,
    Frame,
    GroundMotion,
    artificial,
    modes_of,
    motion_of,
    simulate,
)

MASS, OMEGA = 1e5, 2 * np.pi * 1.5
K, C = 2e6, 1e5


def oscillator(expression: str, **own: float) -> Frame:
    """One storey, with a Kelvin damper that has something beside it."""
    model = parse_model(expression)
    theta = model.vector(
        {"k": K, "c": C, **{name.replace("__", "."): value for name, value in own.items()}}
    )
    return Frame([MASS], [MASS * OMEGA**2], 0.0, (Damper(model, theta),))


def shaken(peak: float = 3.0) -> GroundMotion:
    return artificial(np.random.default_rng(3), duration=3.0, step=0.01, peak=peak)


def integrated(record: GroundMotion, force, memory: float = 0.0):
    """Displacement by an adaptive integrator that knows nothing of steps or exponentials."""

    def rate(t, y):
        x, v, held = y
        acceleration = np.interp(t, record.time, record.acceleration)
        pulled, change = force(x, v, held)
        return v, -acceleration - OMEGA**2 * x - (K * x + C * v + pulled) / MASS, change

    found = solve_ivp(
        rate,
        (0, record.time[-1]),
        [0, 0, memory],
        "DOP853",
        record.time,
        rtol=1e-7,
        atol=1e-10,
        max_step=0.01,
    )
    return found.y[0]


SMOOTH = [
    ("kelvin + cubic-stiffness", {"cubic-stiffness.k3": 3e9}, lambda x, v, _: (3e9 * x**3, 0.0)),
    ("kelvin + cubic-damping", {"cubic-damping.c3": 3e6}, lambda x, v, _: (3e6 * v**3, 0.0)),
    (
        "kelvin + power-law-damper",
        {"power-law-damper.F": 1e5, "power-law-damper.a": 0.5},
        lambda x, v, _: (1e5 * np.sign(v) * abs(v) ** 0.5, 0.0),
    ),
    (
        "kelvin + dead-zone",
        {"dead-zone.k": 1e7, "dead-zone.b": 0.01},
        lambda x, v, _: (1e7 * np.sign(x) * max(abs(x) - 0.01, 0.0), 0.0),
    ),
    (
        "kelvin + elasto-sliding",
        {"elasto-sliding.k": 1e7, "elasto-sliding.F": 5e4},
        lambda x, v, r: (r, 0.0 if abs(r) >= 5e4 and r * v > 0 else 1e7 * v),
    ),
]


@pytest.mark.soak_cases(
    "kelvin + cubic-damping",
    "kelvin + cubic-stiffness",
    "kelvin + dead-zone",
    "kelvin + elasto-sliding",
    "kelvin + power-law-damper",
)
@pytest.mark.parametrize(("expression", "own", "force"), SMOOTH, ids=[each[0] for each in SMOOTH])
def test_a_force_beside_the_material_against_an_adaptive_integrator(expression, own, force):
    record = shaken()
    found = motion_of(oscillator(expression, **own), record).displacement[:, 0]
    exact = integrated(record, force)
    bare = motion_of(oscillator("kelvin"), record).displacement[:, 0]
    assert np.abs(bare - exact).max() > 0.05 * np.abs(exact).max()
    assert np.abs(found - exact).max() < 5e-3 * np.abs(exact).max()


FRICTION = 1.5e4


@pytest.fixture(scope="module")
def struck():
    """A spring and friction alone, struck once.

    (record, motion, stiffness of storey and damper together).
    """
    model = parse_model("spring + friction")
    frame = Frame(
        [MASS],
        [MASS * OMEGA**2],
        0.0,
        (Damper(model, model.vector({"k": K, "friction.F": FRICTION})),),
    )
    pulse = np.where(np.arange(1500) < 30, 3.0, 0.0)
    record = GroundMotion(0.005, pulse)
    return motion_of(frame, record), MASS * OMEGA**2 + K


def test_friction_takes_the_same_from_each_swing_and_then_holds(struck):
    """A block on a spring loses 2 F / k a turn, and at last sticks within F / k of the middle."""
    motion, stiffness = struck
    x = motion.displacement[200:, 0]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x))) * np.sign(x[1:-1]) < 0) + 1
    heights = np.abs(x[turns])
    swinging = heights > 2 * FRICTION / stiffness
    assert swinging.sum() >= 4
    assert -np.diff(heights[swinging]) == pytest.approx(2 * FRICTION / stiffness, rel=0.05)
    assert np.ptp(x[-100:]) < 1e-9 * np.abs(x).max()
    assert abs(x[-1]) <= FRICTION / stiffness * 1.01
    held = motion.force[-100:, 0] - K * motion.displacement[-100:, 0]
    assert np.abs(held).max() < FRICTION


def test_energy_goes_into_friction(struck):
    motion, _ = struck
    energy = motion.energy
    left = 0.5 * MASS * OMEGA**2 * motion.displacement[-1, 0] ** 2
    assert energy["dampers"][-1] + left == pytest.approx(energy["input"][-1], rel=0.01)


def test_a_motion_below_the_friction_never_begins():
    """The storey is as if the damper were a strut."""
    still = motion_of(oscillator("kelvin + friction", friction__F=1e6), shaken(peak=0.5))
    free = motion_of(oscillator("kelvin"), shaken(peak=0.5))
    assert np.abs(still.displacement).max() < 2e-3 * np.abs(free.displacement).max()


@pytest.mark.soak
def test_shorter_steps_change_little_and_several_dampers_feel_one_another():
    model = parse_model("fractional-maxwell + friction")
    theta = model.vector({"k": 4e7, "c": 6e6, "alpha": 0.55, "friction.F": 1e5})
    frame = Frame(
        np.full(3, 1e5),
        [8e7, 7e7, 6e7],
        0.02,
        tuple(Damper(model, theta, i, 0.5) for i in (1, 2, 3)),
    )
    record = artificial(np.random.default_rng(1), duration=2.0, step=0.02)
    coarse, fine = motion_of(frame, record), motion_of(frame, record.finer(4))
    error = np.abs(coarse.drift - fine.drift[::4]).max(axis=0)
    assert np.all(error < 5e-3 * fine.peak_drift)
    without = tuple(Damper(model - "friction", theta[:3], i, 0.5) for i in (1, 2, 3))
    plain = Frame(frame.mass, frame.stiffness, 0.02, without)
    assert np.all(motion_of(plain, record).peak_drift > coarse.peak_drift)
    assert [mode.s for mode in modes_of(frame)] == [mode.s for mode in modes_of(plain)]


@pytest.mark.soak
def test_units_and_a_slope_change_nothing_but_the_numbers():
    """The same brace in kN and mm; two on a slope pull by the cosine of what they feel."""
    model = parse_model("kelvin + power-law-damper")
    si = Damper(model, np.array([K, C, 1e5, 0.5]))
    # F is the force at one mm/s here, and that in kN.
    small = Damper(
        model, np.array([K * 1e-6, C * 1e-6, 1e2 * 1e-3**0.5, 0.5]), units=Units("kN/mm", "mm")
    )
    braces = [Frame([MASS], [MASS * OMEGA**2], 0.0, (each,)) for each in (si, small)]
    record = shaken()
    one, same = (motion_of(frame, record) for frame in braces)
    assert same.displacement == pytest.approx(one.displacement, rel=1e-6, abs=1e-9)
    cosine = np.cos(np.radians(30.0))
    theta = np.array([K, C, 1e5 / cosine**1.5 / 2, 0.5]) * [
        1 / (2 * cosine**2),
        1 / (2 * cosine**2),
        1.0,
        1.0,
    ]
    sloping = Damper(model, theta, count=2, cosine=cosine)
    turned = motion_of(Frame([MASS], [MASS * OMEGA**2], 0.0, (sloping,)), record)
    assert turned.displacement == pytest.approx(one.displacement, rel=1e-6, abs=1e-9)


def test_what_is_not_known_of_friction_is_a_band():
    frame = oscillator("kelvin + friction", friction__F=FRICTION)
    [damper] = frame.dampers
    unsure = Damper(damper.model, damper.theta, covariance=np.diag((0.2 * damper.theta) ** 2))
    found = simulate(
        Frame(frame.mass, frame.stiffness, 0.0, (unsure,)),
        shaken(),
        np.random.default_rng(1),
        draws=6,
    )
    low, high = found.band()
    assert low[0] < found.motion.peak_drift[0] < high[0]
