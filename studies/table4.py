"""Table 4 and Figures 11 and 12.

Models of the silicone fluid at 20 degC, amplitude 10 mrad, 0.3 to 63 Hz.

    springpot run studies/table4.py

The measured moduli are not printed. What is printed are the parameters of three fits, so the curves
of these fits stand in for the data: reconstructions. They show how far the three published fits
agree with one another, and what every model of the paper makes of them; how well a model fits the
fluid itself they cannot show (studies/nist_fluid.py does that on measured moduli of such a fluid).
"""

from __future__ import annotations

from pathlib import Path

from paper.draw import Curve, can_draw, legend_above, moduli, sheet
from paper.published import FLUIDS, in_fluid_columns
from paper.results import Results, relative_rms
from springpot import open_measurement
from springpot.benchmark import Study, Table, save_table
from springpot.report.page import Entry
from springpot_plugins.datasets.shipped import TABLE_4

DATA = {f"reconstruction-pdms-table4-{key}": (key, model) for key, (model, _) in TABLE_4.items()}
SHOWN = ("fractional-kelvin", "fractional-maxwell", "fractional-kelvin4", "fractional-zener")
"""Rhombi, triangles, squares and circles of Figures 11 and 12."""


def finish(path: Path, folder: Path) -> None:
    """Write both tables and the figures."""
    results = Results.of(path)
    save_table(table(results), folder, "table4")
    save_table(agreement(), folder, "agreement")
    if can_draw(folder):
        figures(results, folder)


def table(results: Results) -> Table:
    """The paper's rows, then what each model makes of the published curves."""
    rows: list[tuple[Entry, ...]] = [
        ("-", FLUIDS[model], *in_fluid_columns(model, theta), None, "paper")
        for model, theta in TABLE_4.values()
    ]
    for name, (key, _) in DATA.items():
        data = open_measurement(name)
        for model in FLUIDS:
            for who in ("pso-paper", "native"):
                best = results.best(name, model, who)
                if best:
                    values = in_fluid_columns(model, best.theta)
                    rows.append(
                        (
                            f"{key} row",
                            FLUIDS[model],
                            *values,
                            relative_rms(model, best.theta, data),
                            who,
                        )
                    )
    columns = (
        "curve of",
        "model",
        "E or E1 [Pa]",
        "eta or eta2 [Pa s^alpha]",
        "E2 [Pa]",
        "alpha [-]",
    )
    note = (
        "Curves computed at 30 frequencies from 0.3 to 63 Hz from the printed parameters; not"
        " measured. Relative rms error: root mean square of |E - E_c| / |E_c|. Of each optimiser"
        " the best run by eq. (44). A zero is printed as the lower end of the search box. The model"
        " with two orders has E, tau and two orders; given are E, E tau^beta and beta."
    )
    return Table(
        "Table 4: models of the silicone fluid", (*columns, "relative rms error", "who"), rows, note
    )


def agreement() -> Table:
    """How far apart the curves of the three published rows are."""
    names = list(DATA)
    rows: list[tuple[Entry, ...]] = [
        (DATA[one][0], *(distance(one, other) for other in names)) for one in names
    ]
    note = (
        "Relative rms difference of the row's curve from the column's, 0.3 to 63 Hz. Were all three"
        " good fits of the same points, the differences would be no larger than their errors. With"
        " E2 = 0 (standard) or E1 = 0 (Zener) all three rows are the same Maxwell model, so the"
        " best fit would be the same in each."
    )
    return Table(
        "Agreement of the fits printed in Table 4",
        ("row", *(DATA[name][0] for name in names)),
        rows,
        note,
    )


def distance(one: str, other: str) -> float:
    """Relative rms difference of the published curve of `one` from that of `other`."""
    key, model = DATA[one]
    return relative_rms(model, TABLE_4[key][1], open_measurement(other))


def figures(results: Results, folder: Path) -> None:
    """Both moduli of the published Maxwell fit and of the four models fitted to it."""
    name = "reconstruction-pdms-table4-maxwell"
    data = open_measurement(name)
    best = {model: trial.theta for model in SHOWN if (trial := results.best(name, model))}
    curves = [
        Curve(
            FLUIDS[model],
            model,
            theta,
            {"linestyle": "-" if model == "fractional-kelvin" else "--"},
        )
        for model, theta in best.items()
    ]
    for number, part in ((11, "storage"), (12, "loss")):
        with sheet(folder, f"figure{number}", 7.4, 4.6) as page:
            axes = page.subplots()
            moduli(axes, data, curves, part)
            axes.lines[-1].set_label("published Maxwell fit")
            legend_above(
                page,
                axes,
                f"Figure {number}: {part} modulus of the silicone fluid (reconstruction)",
            )


study = Study(
    "table4",
    datasets=list(DATA),
    models=list(FLUIDS),
    objectives=["paper"],
    optimisers=["pso-paper", "native"],
    repetitions=5,
    budget=8020,
    asks=(
        "Do the three published fits of the silicone fluid agree, and which models can follow"
        " them?",
        "Differences of the published curves, and the error of eq. (44) of every model on"
        " each of them.",
        "Published curves that differ by less than models do that are fitted to them.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
