"""Dampers that are a slider and nothing else: what they hold, how far they go, what they take."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.structure import GroundMotion, artificial, motion_of, steady_of
from springpot.structure.reading import read_structure

pytestmark = pytest.mark.usefixtures("asked_once")

MASS, STIFFNESS, DAMPING = 1e4, 4e6, 0.02
TEXT = """[structure]
mass = 1e4
stiffness = 4e6
damping = 0.02

[[damper]]
model = "%s"
parameters = { %s }
unit = "kN/m"
"""
SLIDER = TEXT % ("elasto-sliding", '"elasto-sliding.k" = %g, "elasto-sliding.F" = 6')
COULOMB = TEXT % ("friction", '"friction.F" = %g')


SHORT = "time [s],acceleration [g]\n" + "".join(f"{0.02 * i:.2f},{0.3}\n" for i in range(40))


def reference(record: GroundMotion, stiffness: float, limit: float) -> tuple[float, float]:
    """Largest drift and work on the slider, by short explicit steps of another kind (Verlet)."""
    parts = 200
    fine = record.finer(parts)
    h, viscous = fine.step, 2.0 * DAMPING * np.sqrt(STIFFNESS * MASS)
    x = v = q = most = work = 0.0
    acceleration = 0.0
    for ground in fine.acceleration.tolist():
        way = h * v + 0.5 * h * h * acceleration
        before = q
        q = min(max(q + stiffness * way, -limit), limit)
        work += 0.5 * (before + q) * way
        x += way
        half = v + 0.5 * h * acceleration
        acceleration = -(STIFFNESS * x + viscous * half + q) / MASS - ground
        v = half + 0.5 * h * acceleration
        most = max(most, abs(x))
    return most, work


@pytest.mark.parametrize("stiffness", [4e3, 4e4])
def test_a_slider_alone_moves_and_takes_what_another_integrator_finds(write, stiffness):
    """Samples of a force that jumps told 3 % less of its work."""
    record = artificial(np.random.default_rng(1), duration=2.0)
    motion = motion_of(read_structure(write(SLIDER % (stiffness), "f.toml")), record)
    most, work = reference(record, 1e3 * stiffness, 6e3)
    assert motion.peak_drift[0] == pytest.approx(most, rel=1e-3)
    assert motion.peak_axial_force[0] == pytest.approx(6e3)
    assert motion.work[-1, 0] == pytest.approx(work, rel=2e-3)


def test_dry_friction_takes_its_force_times_the_path(write):
    record = artificial(np.random.default_rng(1), duration=4.0, step=0.002)
    motion = motion_of(read_structure(write(COULOMB % (3), "f.toml")), record)
    path = np.abs(np.diff(motion.drift[:, 0])).sum()
    assert motion.work[-1, 0] == pytest.approx(3e3 * path, rel=1e-3)


def test_dry_friction_that_holds_the_mass_lets_nothing_move(write):
    record = artificial(np.random.default_rng(1), duration=2.0, peak=2.0)
    motion = motion_of(read_structure(write(COULOMB % (2e-3 * MASS * 1.01), "f.toml")), record)
    # Where it could move it would go by some mm.
    assert np.abs(motion.drift).max() < 1e-3 * 2.0 * MASS / STIFFNESS


def test_a_slider_has_modes_of_the_bare_frame_and_no_steady_state(springpot, write):
    path = write(COULOMB % (3), "f.toml")
    with pytest.raises(ModelError, match="'friction' has no steady state"):
        steady_of(read_structure(path), np.array([1.0]))
    answer = springpot("simulate", path, "--record", write(SHORT, "r.csv"), "--json").json
    assert answer["modes"][0]["damping"] == pytest.approx(DAMPING)
    assert answer["dampers"][0]["axial_force"] == pytest.approx(3e3)


def test_an_effect_that_needs_a_material_stays_none_alone(springpot, write):
    path = write(TEXT % ("time-delay", "tau = 1"), "f.toml")
    springpot("simulate", path, "--record", "artificial").is_one_line("write MODEL + time-delay")
