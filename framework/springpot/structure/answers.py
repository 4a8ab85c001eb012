"""What a structure did, as plain data: the JSON of ``springpot simulate``.

Under many records it is the mean and the envelope of what is largest under each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.rheology.points import Real

from .damper import Damper
from .frame import Mode, steady_of
from .motion import Motion, Simulation, band_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from springpot.rheology.points import Real

    from .frame import Frame, SteadyState
    from .motion import Motion, Simulation


LARGEST: dict[str, Callable[[Motion], Real]] = {
    "drift": lambda motion: motion.peak_drift,
    "damper_force": lambda motion: motion.peak_storey_force,
    "axial_force": lambda motion: motion.peak_axial_force,
    "stroke": lambda motion: motion.peak_stroke,
    "energy": lambda motion: motion.work[-1],
}
"""What is told of each record: of each storey the first two, of each entry of dampers the rest."""


@dataclass(frozen=True, eq=False)
class RecordSuite:
    """A structure under many records.

    Parameters
    ----------
    simulations : sequence of Simulation
        Under one record each, with the same draws of its dampers.
    refused : mapping of str to str
        Records that could not be used, with the reason.
    """

    simulations: Sequence[Simulation]
    refused: dict[str, str] = field(default_factory=dict)

    def largest(self, name: str) -> Real:
        """One of `LARGEST` under each record, shape (r, k)."""
        return np.array([LARGEST[name](each.motion) for each in self.simulations])

    def mean(self, name: str) -> Real:
        """Mean over the records (k,)."""
        return np.asarray(self.largest(name).mean(axis=0))

    def envelope(self, name: str) -> Real:
        """Largest under any record (k,)."""
        return np.asarray(self.largest(name).max(axis=0))

    def worst(self, name: str) -> list[str]:
        """Names (k,) of the records of the envelope."""
        names = [each.motion.record.name for each in self.simulations]
        return [names[i] for i in self.largest(name).argmax(axis=0)]

    @property
    def bounds(self) -> dict[str, RecordSuite]:
        """The same at each end of the dampers' factors; nothing where they have none."""
        return {
            name: RecordSuite([each.bounds[name] for each in self.simulations])
            for name in self.simulations[0].bounds
        }

    def bands(self) -> dict[str, tuple[Real, Real]]:
        """Ends (n,) of the bands of the drifts' mean and of their envelope.

        Every record has the same draws of the dampers, so that each draw has its mean.
        """
        drifts = np.array([each.drifts for each in self.simulations])
        return {
            "mean": band_of(drifts.mean(axis=0), self.mean("drift")),
            "envelope": band_of(drifts.max(axis=0), self.envelope("drift")),
        }


def described_steady(steady: SteadyState) -> dict[str, Any]:
    """As plain data, schema ``springpot.steady-state/2``.

    Amplitudes at 1 m/s^2 of the ground, energies a cycle.

    Of each storey the drift in m and the force of its dampers along the floor in N; of each entry
    of dampers the force and stroke of one along its axis, and the energy in J that all of them
    take.
    """
    # Phases are left to Python: JSON has no complex numbers.
    columns = {
        "frequency": steady.omega / (2.0 * np.pi),
        "drift": np.abs(steady.drift),
        "storey_force": np.abs(steady.storey_force),
        "axial_force": np.abs(steady.axial_force),
        "stroke": np.abs(steady.stroke),
        "energy": steady.energy,
        "outside_measured": _outside(steady.frame, steady.omega),
    }
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return {
        "schema": "springpot.steady-state/2",
        "points": [dict(zip(columns, row, strict=True)) for row in rows],
        "bounds": {
            name: described_steady(steady_of(bound, steady.omega))["points"]
            for name, bound in steady.frame.bounds.items()
        },
        "notes": _notes(steady.frame, steady.omega, "frequencies"),
    }


def _outside(frame: Frame, omega: Real) -> NDArray[np.bool_]:
    """Whether any damper was not measured at each of these (n,), in rad/s."""
    masks = [damper.outside(omega) for damper in frame.dampers]
    return np.asarray(np.any([np.zeros(len(omega), dtype=bool), *masks], axis=0))


def _notes(frame: Frame, omega: Real, of: str, strokes: Sequence[float] = ()) -> list[str]:
    """A line for each damper that is used outside of what it was measured at."""
    remarks = [(i, damper.remark(omega, of)) for i, damper in enumerate(frame.dampers, 1)]
    pairs = zip(frame.dampers, strokes, strict=False)
    remarks += [(i, damper.remark_on_stroke(stroke)) for i, (damper, stroke) in enumerate(pairs, 1)]
    return [f"damper {i}: {remark}" for i, remark in remarks if remark]


def described(simulation: Simulation) -> dict[str, Any]:
    """As plain data, schema ``springpot.simulation/2``; lengths in m, forces in N, energies in J.

    Force and stroke of a damper are those of one along its axis, and its energy is what one has
    taken when the record ends; ``damper_force`` of a storey is that of all its dampers along the
    floor, at one instant.
    """
    motion = simulation.motion
    low, high = simulation.band()
    swinging = 2.0 * np.pi * np.array([mode.frequency for mode in simulation.modes])
    return {
        "schema": "springpot.simulation/2",
        "record": {
            "name": motion.record.name,
            "step": motion.record.step,
            "samples": len(motion.record.acceleration),
            "peak": float(np.abs(motion.record.acceleration).max()),
        },
        "modes": _modes(simulation),
        "storeys": [
            {"drift": drift, "low": below, "high": above, "damper_force": force}
            for drift, below, above, force in zip(
                motion.peak_drift.tolist(),
                low.tolist(),
                high.tolist(),
                motion.peak_storey_force.tolist(),
                strict=True,
            )
        ],
        "dampers": _dampers(motion),
        "energy": {name: float(each[-1]) for name, each in motion.energy.items()},
        "bounds": {name: described(each) for name, each in simulation.bounds.items()},
        "draws": len(simulation.drifts),
        "level": simulation.level,
        "notes": [
            *_notes(motion.frame, swinging, "modes", motion.peak_stroke.tolist()),
            *notes_of_heat(motion, simulation.modes[0]),
        ],
    }


def _dampers(motion: Motion) -> list[dict[str, Any]]:
    """What one of each entry bears, moves, takes, and how warm that makes it."""
    told = {
        "axial_force": motion.peak_axial_force.tolist(),
        "stroke": motion.peak_stroke.tolist(),
        "energy": motion.work[-1].tolist(),
        "temperature_rise": rises_of(motion),
    }
    return [
        {
            "model": damper.model.name,
            "storey": damper.storey,
            "count": damper.count,
            "slope": float(np.degrees(np.arccos(damper.cosine))),
            **dict(zip(told, row, strict=True)),
        }
        for damper, *row in zip(motion.frame.dampers, *told.values(), strict=True)
    ]


def _modes(simulation: Simulation) -> list[dict[str, Any]]:
    """Frequency and damping of each mode, and whether a damper was not measured there."""
    swinging = 2.0 * np.pi * np.array([mode.frequency for mode in simulation.modes])
    outside = _outside(simulation.motion.frame, swinging).tolist()
    return [
        {"frequency": mode.frequency, "damping": mode.damping, "outside_measured": beyond}
        for mode, beyond in zip(simulation.modes, outside, strict=True)
    ]


def described_suite(suite: RecordSuite) -> dict[str, Any]:
    """As plain data, schema ``springpot.simulations/1``: one of `described` for each record.

    Mean and envelope of the drift, with their bands, of force, stroke and energy; the same at the
    bounds.
    """
    bounds = {name: _mean_and_envelope(each) for name, each in suite.bounds.items()}
    return {
        "schema": "springpot.simulations/1",
        "records": [described(each) for each in suite.simulations],
        **_mean_and_envelope(suite),
        "bounds": bounds,
        "refused": [{"record": name, "says": says} for name, says in suite.refused.items()],
        "level": suite.simulations[0].level,
    }


def _mean_and_envelope(suite: RecordSuite) -> dict[str, Any]:
    """Of storeys and of dampers."""
    told: dict[str, list[dict[str, Any]]] = {}
    for name in LARGEST:
        columns = suite.mean(name).tolist(), suite.envelope(name).tolist(), suite.worst(name)
        keys = ("mean", "envelope", "worst")
        told[name] = [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]
    for name, ends in suite.bands().items():
        for drift, low, high in zip(told["drift"], *(end.tolist() for end in ends), strict=True):
            drift |= {f"{name}_low": low, f"{name}_high": high}
    parts = {"storeys": ("drift", "damper_force"), "dampers": ("axial_force", "stroke", "energy")}
    return {
        part: [
            dict(zip(names, row, strict=True))
            for row in zip(*(told[name] for name in names), strict=True)
        ]
        for part, names in parts.items()
    }


def rises_of(motion: Motion) -> list[float | None]:
    """By how many kelvin one damper of each entry warms; nothing where its capacity is not stated.

    As if no heat left it: records are shorter than a damper takes to cool.
    """
    rises: list[float | None] = []
    for damper, taken in zip(motion.frame.dampers, motion.work[-1].tolist(), strict=True):
        rises.append(None if damper.heat_capacity is None else taken / damper.heat_capacity)
    return rises


def notes_of_heat(motion: Motion, mode: Mode) -> list[str]:
    """One line for each damper that warms: what its model would feel of it.

    Parameters
    ----------
    motion : Motion
        Under a record.
    mode : Mode
        Of its frame, where stiffness is compared.
    """
    pairs = zip(motion.frame.dampers, rises_of(motion), strict=True)
    return [
        f"damper {i}: {_felt(damper, rise, mode)}"
        for i, (damper, rise) in enumerate(pairs, 1)
        if rise is not None
    ]


def _felt(damper: Damper, rise: float, mode: Mode) -> str:
    warms = f"warms by {rise:.3g} K if no heat leaves it"
    if damper.temperature is None or "temperature" not in damper.model.needs:
        return f"{warms}; its model knows no temperature, and stays as it was"
    warm = replace(damper, temperature=damper.temperature + rise)
    at = np.array([2j * np.pi * mode.frequency])
    ratio = float(np.abs(warm.stiffness(at)[0] / damper.stiffness(at)[0])[0])
    return (
        f"{warms}, and its model would feel it: |K| at mode 1 would end at {100 * ratio:.3g} % of"
        f" that at {damper.temperature:g} degC, which the motion has throughout"
    )
