"""What small structures do, to the last digit that machines share."""

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.structure import (
    Damper,
    Frame,
    GroundMotion,
    answers,
    artificial,
    modes_of,
    motion_of,
    simulate,
    steady_of,
    steady_state,
)
from springpot.structure.answers import described

pytestmark = pytest.mark.usefixtures("asked_once")

MAXWELL, KELVIN = parse_model("fractional-maxwell"), parse_model("kelvin")
THETA = MAXWELL.theta(k=4e6, c=6e5, alpha=0.55)
COVARIANCE = np.diag((0.05 * THETA) ** 2)


def damper(storey, expression="fractional-maxwell", covariance=None, count=3.0, slope=30.0, **own):
    model = parse_model(expression)
    theta = THETA
    if own:
        theta = model.vector({name.replace("__", "."): value for name, value in own.items()})
    cosine = float(np.cos(np.radians(slope)))
    return Damper(model, theta, storey, count, covariance, cosine=cosine)


def frame(*dampers, damping=0.02):
    return Frame(np.array([1e5, 9e4]), np.array([8e7, 7e7]), damping, dampers)


def shaken(step=0.01, duration=2.0):
    return artificial(np.random.default_rng(1), duration=duration, step=step)


SLIDING = {
    "friction": {"friction__F": 2e4},
    "cubic-stiffness": {"cubic-stiffness__k3": 3e10},
    "power-law-damper": {"power-law-damper__F": 1e5, "power-law-damper__a": 0.5},
    "elasto-sliding": {"elasto-sliding__k": 5e6, "elasto-sliding__F": 2e4},
}
STRUCTURES = {
    "bare": frame(),
    "two dampers": frame(damper(1, covariance=COVARIANCE), damper(2, covariance=COVARIANCE)),
    "both in one storey": frame(damper(1), damper(1, count=1, slope=0.0), damping=0.0),
} | {
    name: frame(damper(1), damper(2, f"kelvin + {name}", k=2e6, c=1e5, **own))
    for name, own in SLIDING.items()
}


@pytest.mark.soak_cases("power-law-damper")
@pytest.mark.parametrize("case", list(STRUCTURES))
def test_motion_of_a_structure(case, stays):
    found = motion_of(STRUCTURES[case], shaken(0.02))
    stays(
        {
            "displacement": found.displacement,
            "force": found.force,
            "axial": found.axial_force,
            "stroke": found.stroke,
            "peaks": found.peaks,
            "drift": found.peak_drift,
            "one damper": [found.peak_axial_force, found.peak_stroke],
            "storeys": found.peak_storey_force,
            "energy": found.energy,
        }
    )


@pytest.mark.parametrize("step", [0.001, 0.3])
def test_peaks_between_samples(step, stays):
    record = GroundMotion(step, np.sin(np.arange(60) * 0.5), "sine")
    stays(motion_of(STRUCTURES["two dampers"], record).peaks)


def test_modes_and_steady_state(stays):
    structure = STRUCTURES["two dampers"]
    omega = 2.0 * np.pi * np.array([0.5, 2.0, 4.0, 9.0])
    steady = steady_of(structure, omega)
    stays(
        {
            "modes": modes_of(structure),
            "with friction": modes_of(STRUCTURES["friction"]),
            "drift": steady.drift,
            "force": steady.axial_force,
            "state": steady_state(structure, omega),
        }
    )


def test_artificial_record(stays):
    record = artificial(np.random.default_rng(2), duration=1.0, step=0.05, peak=2.0)
    stays({"a": record.acceleration, "t": record.time, "fine": record.finer(3).acceleration})


def test_simulation_with_its_band(stays, monkeypatch):
    asked = []
    monkeypatch.setattr(answers, "_notes", lambda frame, omega, *of: asked.append(omega) or [])
    monkeypatch.setattr(
        answers, "_outside", lambda frame, omega: asked.append(omega) or np.zeros(len(omega), bool)
    )
    found = simulate(STRUCTURES["two dampers"], shaken(0.05, 1.0), np.random.default_rng(3), 2)
    stays({"band": found.band(), "drift": found.motion.peak_drift, "told": described(found)})
    # What is measured of a damper is held against angular frequencies.
    swinging = [2.0 * np.pi * mode.frequency for mode in found.modes]
    assert [each.tolist() for each in asked] == [pytest.approx(swinging)] * len(asked)
    assert len(asked) == 2


STEEP = """[structure]
storeys = 2
mass = 1e5
stiffness = [8e7, 7e7]
damping = 0.02

[[damper]]
model = "fractional-maxwell"
parameters = { k = 4e7, c = 6e6, alpha = 0.55 }
unit = "N/m"
storey = 2
count = 4
slope = 30
"""
RECORD = "time [s],acceleration [g]\n" + "".join(
    f"{0.02 * i:.2f},{0.1 * np.sin(0.4 * i):.6f}\n" for i in range(80)
)


@pytest.mark.parametrize("json", [True, False])
@pytest.mark.parametrize("asked", ["record", "artificial", "steady"])
def test_simulate(springpot, write, stays, undrawn, asked, json):
    structure, record = write(STEEP, "frame.toml"), write(RECORD, "record.csv")
    options = {
        "record": ("--record", record, "--draws", 2),
        "artificial": ("--record", "artificial:7", "--draws", 2),
        "steady": ("--frequency", "0.5,4,20"),
    }[asked]
    picture = record.parent / "picture.svg"
    more = ("--json",) if json else ("--figure", picture)
    told = springpot("simulate", structure, *options, *more)
    assert told.code == 0, told.err
    if json:
        stays(told.json)
    else:
        lines = told.out.replace(str(record.parent), "").splitlines()
        stays({"text": lines, "figures": undrawn})
