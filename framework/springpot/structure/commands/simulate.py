"""``springpot simulate``: a structure with identified dampers under a record."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.cli.common import DATA, FILE, INPUT, emit, json_option
from springpot.cli.predict import numbers
from springpot.cli.timetests import WHERE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from springpot.rheology.points import Real
    from springpot.structure.frame import Frame, SteadyState
    from springpot.structure.motion import Simulation


@click.command(
    "simulate",
    epilog="Example: springpot simulate frame.toml --record artificial:3.0 --figure drift.png",
)
@click.argument("structure", type=INPUT, metavar="STRUCTURE.toml")
@click.option(
    "--record", type=DATA, metavar="FILE", help="CSV of time and acceleration, or artificial:PEAK."
)
@click.option(
    "--frequency", "-f", metavar="HZ", help="Steady state instead: numbers with commas, or 0.5..10."
)
@click.option(
    "--draws",
    type=click.IntRange(min=0),
    default=40,
    show_default=True,
    help="Of uncertain parameters.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of all random numbers.",
)
@click.option(
    "--figure",
    type=FILE,
    metavar="FILE",
    help="Draw drifts, loops and energy (.png, .svg or .pdf).",
)
@json_option
def command(
    structure: Path,
    record: str | None,
    frequency: str | None,
    draws: int,
    seed: int,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Drift, force, energy and damping of a frame or oscillator whose dampers were identified.

    STRUCTURE.toml has [structure] with mass [kg], stiffness [N/m] and damping, and a [[damper]] for
    each kind with fit = 'FIT.json' (of 'springpot identify --json') or a model with parameters. The
    band of the drift carries what is not known of the dampers. With --frequency the ground shakes
    with 1 m/s^2 at each frequency instead.
    """
    import numpy as np

    from springpot.report.canvas import check_figure_path
    from springpot.structure.motion import simulate
    from springpot.structure.reading import read_record, read_structure

    # A path that cannot be written is told before time is spent on the motion.
    if figure is not None:
        check_figure_path(figure)
    if (record is None) == (frequency is None):
        raise click.UsageError("give a --record or a --frequency", click.get_current_context())
    if record is None:
        _steady(structure, str(frequency), figure, as_json)
        return
    # One generator for the record and the draws: one seed repeats both.
    rng = np.random.default_rng(seed)
    simulation = simulate(read_structure(structure), read_record(record, rng), rng, draws)
    if figure is not None:
        from springpot.structure.figures import figure_motion

        figure_motion(simulation, figure)
    emit(described(simulation), as_json, lambda: _show(simulation, figure))


def _steady(structure: Path, frequency: str, figure: Path | None, as_json: bool) -> None:
    """The steady state at each frequency in Hz."""
    import numpy as np

    from springpot.structure.frame import steady_of
    from springpot.structure.reading import read_structure

    steady = steady_of(read_structure(structure), 2.0 * np.pi * np.array(numbers(frequency)))
    if figure is not None:
        from springpot.structure.figures import figure_steady

        figure_steady(steady, figure)
    emit(described_steady(steady), as_json, lambda: _show_steady(steady, figure))


def described_steady(steady: SteadyState) -> dict[str, Any]:
    """As plain data, schema ``springpot.steady-state/2``.

    Amplitudes at 1 m/s^2 of the ground, energies a cycle.

    Of each storey the drift in m and the force of its dampers along the floor in N; of each entry
    of dampers the force and stroke of one along its axis, and the energy in J that all of them
    take.
    """
    import numpy as np

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
        "notes": _notes(steady.frame, steady.omega, "frequencies"),
    }


def _outside(frame: Frame, omega: Real) -> NDArray[np.bool_]:
    """Whether any damper was not measured at each of these (n,), in rad/s."""
    import numpy as np

    masks = [damper.outside(omega) for damper in frame.dampers]
    return np.asarray(np.any([np.zeros(len(omega), dtype=bool), *masks], axis=0))


def _notes(frame: Frame, omega: Real, of: str, strokes: Sequence[float] = ()) -> list[str]:
    """A line for each damper that is used outside of what it was measured at."""
    remarks = [(i, damper.remark(omega, of)) for i, damper in enumerate(frame.dampers, 1)]
    pairs = zip(frame.dampers, strokes, strict=False)
    remarks += [(i, damper.remark_on_stroke(stroke)) for i, (damper, stroke) in enumerate(pairs, 1)]
    return [f"damper {i}: {remark}" for i, remark in remarks if remark]


def _last_lines(notes: list[str], figure: Path | None) -> list[str]:
    """What is said below the tables."""
    lines = [f"note        {note}" for note in notes]
    if figure is not None:
        lines.append(f"figure      {figure}")
    return lines


def _show_steady(steady: SteadyState, figure: Path | None) -> None:
    from springpot.format_numbers import number
    from springpot.report.text import TextTable

    storeys, dampers = range(1, len(steady.frame) + 1), range(1, len(steady.frame.dampers) + 1)
    shown = {
        "drift": ("drift {} [mm]", 1e3, storeys),
        "storey_force": ("dampers of storey {} [kN]", 1e-3, storeys),
        "axial_force": ("axial force {} [kN]", 1e-3, dampers),
        "stroke": ("stroke {} [mm]", 1e3, dampers),
        "energy": ("energy {} [kJ]", 1e-3, dampers),
    }
    headers = ["f [Hz]"]
    for title, _, which in shown.values():
        headers += [title.format(i) for i in which]
    rows = []
    described = described_steady(steady)
    for point in described["points"]:
        cells = [point["frequency"]]
        for name, (_, factor, _) in shown.items():
            cells += [factor * value for value in point[name]]
        where = WHERE[point["outside_measured"]]
        rows.append([*(number(cell) for cell in cells), where])
    table = TextTable((*headers, "measured"), rows, frozenset(headers))
    if not any(point["outside_measured"] for point in described["points"]):
        table = table.lacking("measured")
    print(
        "amplitudes at 1 m/s^2 of the ground: axial force and stroke of one damper of each kind,"
        " the force of"
    )
    print("all of a storey along the floor, and the energy that each kind takes in a cycle\n")
    table.show()
    if last := _last_lines(described["notes"], figure):
        print("", *last, sep="\n")


def described(simulation: Simulation) -> dict[str, Any]:
    """As plain data, schema ``springpot.simulation/2``; lengths in m, forces in N, energies in J.

    Force and stroke of a damper are those of one along its axis; ``damper_force`` of a storey is
    that of all its dampers along the floor, at one instant.
    """
    import numpy as np

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
        "dampers": [
            {
                "model": damper.model.name,
                "storey": damper.storey,
                "count": damper.count,
                "slope": float(np.degrees(np.arccos(damper.cosine))),
                "axial_force": force,
                "stroke": stroke,
            }
            for damper, force, stroke in zip(
                motion.frame.dampers,
                motion.peak_axial_force.tolist(),
                motion.peak_stroke.tolist(),
                strict=True,
            )
        ],
        "energy": {name: float(each[-1]) for name, each in motion.energy.items()},
        "draws": len(simulation.drifts),
        "level": simulation.level,
        "notes": _notes(motion.frame, swinging, "modes", motion.peak_stroke.tolist()),
    }


def _modes(simulation: Simulation) -> list[dict[str, Any]]:
    """Frequency and damping of each mode, and whether a damper was not measured there."""
    import numpy as np

    swinging = 2.0 * np.pi * np.array([mode.frequency for mode in simulation.modes])
    outside = _outside(simulation.motion.frame, swinging).tolist()
    return [
        {"frequency": mode.frequency, "damping": mode.damping, "outside_measured": beyond}
        for mode, beyond in zip(simulation.modes, outside, strict=True)
    ]


def _show_dampers(result: dict[str, Any]) -> None:
    """What one damper of each kind must bear and move, and what all of a storey pull together."""
    from springpot.format_numbers import number
    from springpot.report.text import TextTable

    rows = [
        [
            str(damper["storey"]),
            damper["model"],
            f"{damper['count']:g}",
            f"{damper['slope']:.4g}",
            number(1e-3 * damper["axial_force"]),
            number(1e3 * damper["stroke"]),
        ]
        for damper in result["dampers"]
    ]
    headers = ("storey", "damper", "count", "slope [deg]", "axial force [kN]", "stroke [mm]")
    TextTable(headers, rows, frozenset(headers) - {"storey", "damper"}).show()
    print("each: one damper along its axis; all of a storey together along the floor:\n")
    braced = sorted({damper["storey"] for damper in result["dampers"]})
    sums = [[str(i), number(1e-3 * result["storeys"][i - 1]["damper_force"])] for i in braced]
    TextTable(
        ("storey", "force of its dampers [kN]"), sums, frozenset({"force of its dampers [kN]"})
    ).show()
    print()


def _show_modes(modes: list[dict[str, Any]]) -> None:
    from springpot.format_numbers import number
    from springpot.report.text import TextTable

    rows = [
        [
            str(i),
            number(mode["frequency"]),
            f"{100 * mode['damping']:.3g} %",
            WHERE[mode["outside_measured"]],
        ]
        for i, mode in enumerate(modes, 1)
    ]
    headers = ("mode", "f [Hz]", "damping", "measured")
    table = TextTable(headers, rows, frozenset({"f [Hz]", "damping"}))
    if not any(mode["outside_measured"] for mode in modes):
        table = table.lacking("measured")
    table.show()


def _show(simulation: Simulation, figure: Path | None) -> None:
    from springpot.format_numbers import number
    from springpot.report.text import TextTable

    result = described(simulation)
    record = result["record"]
    print(
        f"{record['name']}: {record['samples']} samples, {number(record['peak'], 3)} m/s^2 at"
        " most\n"
    )
    rows = [
        [
            str(i),
            number(1e3 * row["drift"]),
            f"[{number(1e3 * row['low'])}, {number(1e3 * row['high'])}]",
        ]
        for i, row in enumerate(result["storeys"], 1)
    ]
    band = f"{100 * result['level']:.0f} % band"
    drifts = TextTable(("storey", "drift [mm]", band), rows, frozenset({"drift [mm]"}))
    # Parameters that were stated have no uncertainty: a band of no width would claim that they are
    # known.
    if not result["level"]:
        drifts = drifts.lacking(band)
    drifts.show()
    print()
    _show_modes(result["modes"])
    print()
    if result["dampers"]:
        _show_dampers(result)
    energy = result["energy"]
    told = f"energy      {number(energy['input'] / 1e3)} kJ put in"
    # Where nothing moved, or what was put in has gone back, nobody has taken a share of it.
    if energy["input"] > 0.0:
        share = 100.0 * energy["dampers"] / energy["input"]
        told += f", {share:.3g} % of it taken by the dampers"
    print(
        told,
        *_last_lines(result["notes"], figure),
        sep="\n",
    )
