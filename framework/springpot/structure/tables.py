"""What a structure did, as tables for people."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from springpot.cli.timetests import WHERE
from springpot.report.text import TextTable
from springpot.writing import LISTED, counted, number

BOUNDS = (
    "bounds, all dampers at the {} of their property modification factors (as in ASCE 7 and 41;"
    " unchecked):"
)
FORCE, STROKE = "axial force {} [kN]", "stroke {} [mm]"


def _last_lines(notes: list[str], figure: Path | None) -> list[str]:
    """What is said below the tables."""
    lines = [f"note        {note}" for note in notes]
    if figure is not None:
        lines.append(f"figure      {figure}")
    return lines


def show_steady(result: dict[str, Any], figure: Path | None) -> None:
    """Print a steady state, as `described_steady` gives it."""
    print(
        "amplitudes at 1 m/s^2 of the ground: axial force and stroke of one damper of each kind,"
        " the force of"
    )
    print("all of a storey along the floor, and the energy that each kind takes in a cycle\n")
    _points(result["points"]).show()
    for end, points in zip(("least", "largest"), result["bounds"].values(), strict=False):
        print(f"\n{BOUNDS.format(end)}\n")
        _points(points).show()
    if last := _last_lines(result["notes"], figure):
        print("", *last, sep="\n")


def _points(points: list[dict[str, Any]]) -> TextTable:
    """A row for each frequency."""
    storeys, dampers = (range(1, len(points[0][name]) + 1) for name in ("drift", "stroke"))
    shown = {
        "drift": ("drift {} [mm]", 1e3, storeys),
        "storey_force": ("dampers of storey {} [kN]", 1e-3, storeys),
        "axial_force": (FORCE, 1e-3, dampers),
        "stroke": (STROKE, 1e3, dampers),
        "energy": ("energy {} [kJ]", 1e-3, dampers),
    }
    headers = ["f [Hz]"]
    for title, _, which in shown.values():
        headers += [title.format(i) for i in which]
    rows = []
    for point in points:
        cells = [point["frequency"]]
        for name, (_, factor, _) in shown.items():
            cells += [factor * value for value in point[name]]
        where = WHERE[point["outside_measured"]]
        rows.append([*(number(cell) for cell in cells), where])
    table = TextTable((*headers, "measured"), rows, frozenset(headers))
    if not any(point["outside_measured"] for point in points):
        table = table.lacking("measured")
    return table


def _show_dampers(result: dict[str, Any]) -> None:
    """What one damper of each kind must bear and move, and what all of a storey pull together."""
    rows = [
        [
            str(damper["storey"]),
            damper["model"],
            f"{damper['count']:g}",
            f"{damper['slope']:.4g}",
            number(1e-3 * damper["axial_force"]),
            number(1e3 * damper["stroke"]),
            number(1e-3 * damper["energy"]),
            number(damper["temperature_rise"], 3),
        ]
        for damper in result["dampers"]
    ]
    headers = ["storey", "damper", "count", "slope [deg]", "axial force [kN]", "stroke [mm]"]
    headers += ["energy [kJ]", "warmer by [K]"]
    TextTable(headers, rows, frozenset(headers) - {"storey", "damper"}).telling().show()
    print("each: one damper along its axis; all of a storey together along the floor:\n")
    braced = sorted({damper["storey"] for damper in result["dampers"]})
    sums = [[str(i), number(1e-3 * result["storeys"][i - 1]["damper_force"])] for i in braced]
    TextTable(
        ("storey", "force of its dampers [kN]"), sums, frozenset({"force of its dampers [kN]"})
    ).show()
    print()


def _show_modes(modes: list[dict[str, Any]]) -> None:
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


def show_motion(result: dict[str, Any], figure: Path | None) -> None:
    """Print a motion, as `described` gives it."""
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
    if result["bounds"]:
        _show_bounds(result)
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
    _show_next(result)


def show_suite(result: dict[str, Any], figure: Path | None) -> None:
    """Print many records, as `described_suite` gives them."""
    dampers = range(1, len(result["dampers"]) + 1)
    headers = ["record", "peak [m/s^2]", "storey", "drift [mm]"]
    headers += [title.format(i) for i in dampers for title in (FORCE, STROKE)]
    rows = []
    for each in result["records"]:
        drifts = [storey["drift"] for storey in each["storeys"]]
        most = max(drifts)
        cells = [number(each["record"]["peak"], 3), str(drifts.index(most) + 1), number(1e3 * most)]
        for damper in each["dampers"]:
            cells += [number(1e-3 * damper["axial_force"]), number(1e3 * damper["stroke"])]
        rows.append([each["record"]["name"], *cells])
    TextTable(headers, rows, frozenset(headers) - {"record"}, cuts=True).show()
    print(
        f"\n{counted(len(rows), 'record')}, the largest drift and its storey under each; of all:\n"
    )
    _show_mean_and_envelope(result, result["level"])
    for end, bound in zip(("least", "largest"), result["bounds"].values(), strict=False):
        print(f"\n{BOUNDS.format(end)}\n")
        _show_mean_and_envelope(bound, 0.0)
    under: dict[str, list[str]] = {}
    for each in result["records"]:
        for note in each["notes"]:
            under.setdefault(note, []).append(each["record"]["name"])
    notes = [
        note if len(names) == len(rows) else f"{', '.join(names)}: {note}"
        for note, names in under.items()
    ]
    if last := _last_lines(notes, figure):
        print("", *last, sep="\n")
    _show_next(result)


def _show_bounds(result: dict[str, Any]) -> None:
    """The nominal between what it is at both ends of the dampers' factors."""
    columns = [result["bounds"]["lower"], result, result["bounds"]["upper"]]
    shown = {
        "storeys": {"drift": ("drift {} [mm]", 1e3)},
        "dampers": {"axial_force": (FORCE, 1e-3), "stroke": (STROKE, 1e3)},
        "modes": {"frequency": ("f of mode {} [Hz]", 1.0), "damping": ("damping {} [%]", 100.0)},
    }
    rows = [
        [title.format(i + 1), *(number(factor * each[part][i][name]) for each in columns)]
        for part, names in shown.items()
        for name, (title, factor) in names.items()
        for i in range(len(result[part]))
    ]
    print(BOUNDS.format("least and at the largest") + "\n")
    headers = ("", "lower", "nominal", "upper")
    TextTable(headers, rows, frozenset(headers[1:])).show()
    print()


def _show_mean_and_envelope(result: dict[str, Any], level: float) -> None:
    """A row for each drift, force and stroke."""
    rows = []
    for i, storey in enumerate(result["storeys"], 1):
        drift = storey["drift"]
        rows.append(_both(f"drift {i} [mm]", 1e3, drift))
        if level:
            ends = [
                f"[{number(1e3 * drift[f'{name}_low'])}, {number(1e3 * drift[f'{name}_high'])}]"
                for name in ("mean", "envelope")
            ]
            rows[-1][2], rows[-1][4] = ends
    for i, damper in enumerate(result["dampers"], 1):
        rows.append(_both(FORCE.format(i), 1e-3, damper["axial_force"]))
        rows.append(_both(STROKE.format(i), 1e3, damper["stroke"]))
        rows.append(_both(f"energy {i} [kJ]", 1e-3, damper["energy"]))
    band = f"{100 * level:.0f} % band"
    headers = ("", "mean", band, "envelope", f"{band} ", "under")
    TextTable(headers, rows, frozenset({"mean", "envelope"})).telling().show()


def _show_next(result: dict[str, Any]) -> None:
    """What could be measured of the dampers, the most telling first; nothing where not asked."""
    if "next_experiment" not in result:
        return
    asked = result["next_experiment"]
    now = asked["half_width"]
    rows = [
        [
            str(test["damper"]),
            test["says"],
            f"{number(test['point'], 3)}",
            number(1e3 * test["half_width"], 3),
        ]
        for test in asked["tests"][:LISTED]
    ]
    print(
        f"\nband of the drift of storey {asked['storey']}: +- {number(1e3 * now, 3)} mm; after a"
        " further test of a damper:\n"
    )
    headers = ("damper", "test", "most at [Hz]", "then +- [mm]")
    TextTable(headers, rows, frozenset(headers[2:])).show()


def _both(title: str, factor: float, both: dict[str, Any]) -> list[str]:
    mean, envelope = (number(factor * both[name]) for name in ("mean", "envelope"))
    return [title, mean, "", envelope, "", both["worst"]]
