"""Table 5: the silicone fluid at three amplitudes of torsion.

    springpot run studies/table5.py

The measured moduli are not printed, so whether the fluid depends on the amplitude cannot be tested
again. What can be tested is the print against itself: the Maxwell and the standard row of one
amplitude come from the same points, so the Maxwell model, fitted to the curve of the standard row,
should give the Maxwell row; and the parameters that change with the amplitude can be compared with
how much the curves change.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper.draw import COLOURS, Curve, can_draw, legend_above, moduli, sheet
from paper.published import FLUIDS, in_fluid_columns
from paper.results import Results, relative_rms
from springpot import open_measurement
from springpot.benchmark import Study, Table, save_table
from springpot.report.page import Entry
from springpot_plugins.datasets.shipped import TABLE_5

DATA = {key: f"reconstruction-pdms-table5-{key}" for key in TABLE_5}
AMPLITUDES = ("0.1mrad", "1mrad", "10mrad")
MODELS = ("fractional-maxwell", "fractional-kelvin4")


def finish(path: Path, folder: Path) -> None:
    """Write both tables and a figure of the curves."""
    results = Results.of(path)
    save_table(table(results), folder, "table5")
    save_table(constancy(), folder, "constancy")
    if can_draw(folder):
        figure(folder)


def table(results: Results) -> Table:
    """Each printed row, and what both models make of its curve."""
    rows: list[tuple[Entry, ...]] = []
    for key, name in DATA.items():
        model, theta = TABLE_5[key]
        amplitude, _, row = key.partition("-")
        rows.append((amplitude, row, FLUIDS[model], *in_fluid_columns(model, theta), None, "paper"))
        for fitted in MODELS:
            best = results.best(name, fitted)
            if best:
                error = relative_rms(fitted, best.theta, open_measurement(name))
                values = in_fluid_columns(fitted, best.theta)
                rows.append((amplitude, row, FLUIDS[fitted], *values, error, "fitted here"))
    columns = (
        "amplitude",
        "curve of row",
        "model",
        "E or E1 [Pa]",
        "eta or eta2 [Pa s^alpha]",
        "E2 [Pa]",
        "alpha [-]",
    )
    note = (
        "Curves computed at 30 frequencies from 0.3 to 63 Hz from the printed parameters; not"
        " measured. Best run of both optimisers by eq. (44). A zero is printed as the lower end of"
        " the search box."
    )
    return Table(
        "Table 5: amplitudes of torsion", (*columns, "relative rms error", "who"), rows, note
    )


def constancy() -> Table:
    """How far parameters and curves change with amplitude, and between rows of one amplitude."""
    rows: list[tuple[Entry, ...]] = []
    for row in ("maxwell", "standard"):
        printed = [TABLE_5[f"{amplitude}-{row}"][1] for amplitude in AMPLITUDES]
        for name in printed[0]:
            values = [theta[name] for theta in printed]
            rows.append(
                (
                    f"{FLUIDS[TABLE_5[f'0.1mrad-{row}'][0]]}: {name}",
                    float(np.ptp(values) / max(values)),
                )
            )
        for one in AMPLITUDES[1:]:
            rows.append(
                (
                    f"curve of the {row} row, {one} from 0.1mrad",
                    distance(f"{one}-{row}", f"0.1mrad-{row}"),
                )
            )
    rows += [
        (
            f"curve of the standard row from that of the Maxwell row, {a}",
            distance(f"{a}-standard", f"{a}-maxwell"),
        )
        for a in AMPLITUDES
    ]
    note = (
        "Of a parameter: largest less smallest value over the largest. Of a curve: relative rms"
        " difference, 0.3 to 63 Hz. The paper calls the parameters approximately constant. With E2"
        " = 0, as printed for 10 mrad, the standard model is the Maxwell model: both rows should"
        " then hold the same numbers; that they do not means that a search stopped short of the"
        " optimum, and tells the size of such errors."
    )
    return Table("Change with the amplitude in Table 5", ("what", "relative change"), rows, note)


def distance(one: str, other: str) -> float:
    """Relative rms difference of the published curve of `one` from that of `other`."""
    model, theta = TABLE_5[one]
    return relative_rms(model, theta, open_measurement(DATA[other]))


def figure(folder: Path) -> None:
    """Both moduli of all six rows."""
    data = open_measurement(DATA["0.1mrad-maxwell"])
    curves = []
    for key, (model, theta) in TABLE_5.items():
        amplitude, row = key.split("-")
        label = f"{amplitude.replace('mrad', ' mrad')}, {FLUIDS[model]}"
        line = "-" if row == "maxwell" else "--"
        style = {"color": COLOURS[AMPLITUDES.index(amplitude)], "marker": None, "linestyle": line}
        curves.append(Curve(label, model, theta, style))
    with sheet(folder, "table5", 9.0, 4.6) as page:
        panels = page.subplots(1, 2)
        for axes, part in zip(panels, ("storage", "loss"), strict=True):
            moduli(axes, data, curves, part)
            axes.lines[-1].remove()
        legend_above(
            page, panels[0], "Table 5: the published fits at three amplitudes (reconstruction)"
        )


study = Study(
    "table5",
    datasets=list(DATA.values()),
    models=list(MODELS),
    objectives=["paper"],
    optimisers=["pso-paper", "native"],
    repetitions=5,
    budget=8020,
    asks=(
        "Are the parameters of the silicone fluid constant with the amplitude, as the paper says?",
        "Relative changes of parameters and of curves over three amplitudes, beside what two"
        " rows of the same points differ by.",
        "Changes that are no larger than those between two rows of the same points.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
