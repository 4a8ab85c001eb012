"""What a structure did, as plain data, and which test of a damper would tell more of it.

The JSON of ``springpot simulate``; under many records it is the mean and the envelope of what is
largest under each. The drift follows what is not known of a damper along the principal axes of its
fit's covariance; a further test adds its Fisher information to that covariance. What could be
measured is what the diagnosis offers as a next experiment, with a noise like that of the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.diagnosis.experiment import ACTION, Action, actions, planned_sweep
from springpot.errors import ModelError
from springpot.identification.prediction import Known
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.plain_data import Plain
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..distributions import student
from .damper import Damper, axes_of, sizes_of
from .frame import Frame, Mode, steady_of
from .motion import GroundMotion, Motion, Simulation, band_of, motion_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

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


WIDE = student(INTERVAL, inf)
"""Standard deviations of half a band."""


@dataclass(frozen=True, eq=False)
class FurtherTest(Plain):
    """A test of a damper, and what it would do to the drift.

    Attributes
    ----------
    damper : int
        Which one, 1 for the first entry; others of the same fit gain as well.
    says : str
        What to measure.
    half_width : float
        Half of the band of the drift in m after it.
    point : float
        Of its frequencies in Hz the one that alone would do most.
    action : dict
        Conditions of the test in numbers, as in `springpot.diagnosis`.
    """

    damper: int
    says: str
    half_width: float
    point: float
    action: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class FurtherTests(Plain):
    """What could be measured of the dampers, the most telling first.

    Attributes
    ----------
    storey : int
        Whose drift has the widest band.
    half_width : float
        Half of that band in m now.
    tests : list of FurtherTest
        By the band that they leave.
    """

    storey: int
    half_width: float
    tests: list[FurtherTest]


def further_tests(frame: Frame, records: Sequence[GroundMotion]) -> FurtherTests:
    """The tests of its dampers, ranked by the band of the drift that they leave.

    Parameters
    ----------
    frame : Frame
        With dampers from fits of sweeps.
    records : sequence of GroundMotion
        The drift is the mean of the largest under each.

    Raises
    ------
    ModelError
        If no damper has parameters that are uncertain, from the fit of a sweep.
    """
    fits: dict[int, tuple[int, Known]] = {}
    for i, damper in enumerate(frame.dampers, 1):
        if damper.tested is not None:
            fits.setdefault(id(damper.tested), (i, damper.tested))
    if not any(known.sweep is not None for _, known in fits.values()):
        raise ModelError(
            "no damper is from the fit of a sweep: what is not known of one is what a further test"
            " would narrow"
        )
    moves = {key: _moves(frame, records, key) for key in fits}
    # Each fit adds its own variance; a test of one lowers that part alone.
    variance = np.sum([np.sum(each**2, axis=0) for each in moves.values()], axis=0)
    storey = int(np.argmax(variance))
    ranked = [
        test
        for key, (i, known) in fits.items()
        for test in _of_one(known, i, moves[key][:, storey], float(variance[storey]))
    ]
    ranked.sort(key=lambda test: test.half_width)
    return FurtherTests(storey + 1, WIDE * float(np.sqrt(variance[storey])), ranked)


def _moves(frame: Frame, records: Sequence[GroundMotion], source: int) -> Real:
    """What one standard deviation along each axis of a fit does to the drifts in m, (q, n)."""
    members = [i for i, damper in enumerate(frame.dampers) if id(damper.tested) == source]
    count = frame.dampers[members[0]].axes.shape[1]

    def drifts(along: Real) -> Real:
        moved = [
            damper.moved(along) if i in members else damper
            for i, damper in enumerate(frame.dampers)
        ]
        there = Frame(frame.mass, frame.stiffness, frame.damping, tuple(moved))
        peaks = [motion_of(there, record).peak_drift for record in records]
        return np.asarray(np.mean(peaks, axis=0))

    # Over the width that the band has, not an endless slope: it bends within it.
    return np.array([0.5 * (drifts(axis) - drifts(-axis)) for axis in np.eye(count)])


def _of_one(known: Known, damper: int, moves: Real, variance: float) -> Iterator[FurtherTest]:
    """What could be measured of one damper."""
    if known.sweep is None:
        return
    rest = variance - float(moves @ moves)
    best, closest = np.inf, None
    for action in actions(known.sweep):
        # Another specimen, or none, has no part in this one's uncertainty.
        if action.scale != 1.0:
            continue
        seen = _seen(known, action)
        left = [_left(moves, rows) for rows in np.split(seen, len(seen) // 2)]
        point = int(np.argmin(left))
        whole = WIDE * np.sqrt(rest + _left(moves, seen))
        yield FurtherTest(damper, action.says, float(whole), _hertz(action, point), action.action)
        if left[point] < best:
            best, closest = left[point], (action, point, seen[2 * point : 2 * point + 2])
    if closest is None:
        return
    action, point, rows = closest
    # All at the one frequency that tells most.
    whole = WIDE * np.sqrt(rest + _left(moves, np.sqrt(ACTION.points / action.repeats) * rows))
    hertz = _hertz(action, point)
    told = {name: values for name, values in action.action.items() if len(values) == 1}
    where = ", ".join(f"{name} {value[0]:.3g}" for name, value in told.items() if name != "repeats")
    says = f"measure {ACTION.points} times at {hertz:.3g} Hz" + (f" ({where})" if where else "")
    told |= {"omega": [2.0 * np.pi * hertz], "repeats": [float(ACTION.points)]}
    yield FurtherTest(damper, says, float(whole), hertz, told)


def _hertz(action: Action, point: int) -> float:
    return float(np.exp(action.points.log_omega[point]) / (2.0 * np.pi))


def _left(moves: Real, seen: Real) -> float:
    """Variance of the drift after a test that sees the axes (q,) by the rows of (m, q)."""
    information = np.eye(len(moves)) + seen.T @ seen
    return float(moves @ np.linalg.solve(information, moves))


def _seen(known: Known, action: Action) -> Real:
    """Slopes (2 n, q) of K' and K'' of each point along the axes of the fit, over their noise."""
    sweep, model, theta = known.sweep, known.model, known.theta
    assert sweep is not None
    made = SweepPart(sweep)
    if sweep.sd is None:
        made = made.with_sd(known.misfit * made.size)
    plan = planned_sweep(action, made, known)
    slopes = plan.answer(model, theta, known.reference, np.arange(len(plan.measured))).by_theta
    axes = sizes_of(model, theta)[:, None] * axes_of(model, theta, known.theta_covariance)
    seen = slopes / plan.sd[:, None] @ axes
    return np.reshape(seen.reshape(2, -1, axes.shape[1]).swapaxes(0, 1), seen.shape)
