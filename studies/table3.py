"""Table 3 and Figures 7 to 10: the viscous damper of Makris (1992).

    springpot run studies/table3.py

The points that Makris measured are not printed. They are replaced by his own model of them, eq.
(54) with his parameters, at 50 frequencies from 1 to 50 Hz: a reconstruction. It has no scatter and
cannot give back the digits of Table 3, but the conclusions of section 5.2 can be checked on it. To
see how much the replacement matters, the same models are also fitted to the curve of the paper's
own three-parameter Maxwell fit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from paper.draw import COLOURS, INK, Curve, can_draw, legend_above, moduli, sheet
from paper.published import MODELS, in_columns
from paper.results import Results, absolute_rms, relative_rms
from springpot import Measurement, open_measurement, plugins
from springpot.benchmark import Study, Table, save_table
from springpot.report.page import Entry
from springpot_plugins.datasets.shipped import MAKRIS, TABLE_3

MAKRIS_DATA, MAXWELL_DATA = "reconstruction-makris-1992", "reconstruction-makris-table3-maxwell"
TITLES = {MAKRIS_DATA: "eq. (54) with Makris' parameters", MAXWELL_DATA: "Maxwell row of Table 3"}
PRINTED = dict(TABLE_3.values())
SCALE = 2000.0
"""k-bar in kN/m, of the order of the paper's k."""


def finish(path: Path, folder: Path) -> None:
    """Write the table, the conclusions and the figures."""
    results = Results.of(path)
    save_table(table(results), folder, "table3")
    save_table(conclusions(results), folder, "conclusions")
    if can_draw(folder):
        figures(results, folder)


def table(results: Results) -> Table:
    """The paper's table with its rows and ours.

    Every row is judged against the same reconstructed points.
    """
    makris = open_measurement(MAKRIS_DATA)
    printed = [
        ("paper's row", MODELS[model], *in_columns(theta), *errors(model, theta, makris), None)
        for model, theta in PRINTED.items()
    ]
    ours = [row for data in TITLES for row in fitted(results, data)]
    values = ("k1 [kN/m]", "k2 or k [kN/m]", "c [kN s^alpha/m]", "alpha [-]")
    note = (
        "Relative rms error: root mean square of |K - K_m| / |K_m|; of the paper's rows, against"
        " eq. (54). The fits minimise eq. (44); of each optimiser the best run is shown. Makris'"
        " own parameters are C0 = 15 kN s/m, lambda = 0.3 s^0.6, r = 0.6, q = 1; his model, fitted"
        " to its own curve, returns them. The data are a reconstruction: nothing here was measured."
    )
    columns = ("data", "model", *values, "relative rms error", "error by eq. (44)", "best run of")
    return Table("Table 3: viscous damper of Makris (1992)", columns, [*printed, *ours], note)


def fitted(results: Results, name: str) -> Iterator[tuple[Entry, ...]]:
    """Our rows for one data set."""
    data = open_measurement(name)
    for model in [*MODELS, *(["makris"] if name == MAKRIS_DATA else [])]:
        for who in ("pso-paper", "native"):
            best = results.best(name, model, who)
            if best is None:
                continue
            columns = (
                in_columns(best.theta)
                if model in MODELS
                else (None, None, best.theta["c0"], best.theta["q"])
            )
            title = MODELS.get(model, "Makris, eq. (54): C0, q")
            yield TITLES[name], title, *columns, *errors(model, best.theta, data), who


def errors(model: str, theta: Mapping[str, float], data: Measurement) -> tuple[float, float]:
    """Error relative to each |K_m|, and relative to the whole."""
    return relative_rms(model, theta, data), absolute_rms(model, theta, data)


def conclusions(results: Results) -> Table:
    """The remarks of section 5.2, each with what was measured here."""
    data = open_measurement(MAKRIS_DATA)
    best = {model: trial.theta for model in MODELS if (trial := results.best(MAKRIS_DATA, model))}
    if len(best) < len(MODELS):
        return Table(
            "Conclusions of section 5.2", ("remark", "measured"), [], "The study is not complete."
        )
    error = {model: 100 * absolute_rms(model, theta, data) for model, theta in best.items()}
    maxwell, kelvin4, zener = (
        best[m] for m in ("fractional-maxwell", "fractional-kelvin4", "fractional-zener")
    )
    gap = {
        who: max(abs(theta[theirs] / maxwell[own] - 1) for own, theirs in names.items())
        for who, theta, names in (
            ("Kelvin type", kelvin4, {"k": "k1", "c": "c", "alpha": "alpha"}),
            ("Maxwell type", zener, {"k": "k2", "c": "c", "alpha": "alpha"}),
        )
    }
    rows: list[tuple[Entry, ...]] = [
        (
            "k2 of the Kelvin type and k1 of the Maxwell type are zero in approximation",
            (
                f"k2 = {kelvin4['k2']:.2g} kN/m beside k1 = {kelvin4['k1']:.4g}; "
                f"k1 = {zener['k1']:.2g} kN/m beside k2 = {zener['k2']:.4g}"
            ),
            verdict(kelvin4["k2"] < 1e-3 * kelvin4["k1"] and zener["k1"] < 1e-3 * zener["k2"]),
        ),
        (
            "the four-parameter models reduce to the three-parameter Maxwell model",
            "remaining parameters differ from Maxwell's by "
            + ", ".join(f"{g:.1e} ({w})" for w, g in gap.items()),
            verdict(max(gap.values()) < 0.01),
        ),
        (
            "the four-parameter models approximate the data a little better",
            (
                f"error by eq. (44) {error['fractional-maxwell']:.4g} % with three parameters,"
                f" {error['fractional-kelvin4']:.4g} % and {error['fractional-zener']:.4g} % with"
                " four"
            ),
            verdict(
                min(error["fractional-kelvin4"], error["fractional-zener"])
                < 0.99 * error["fractional-maxwell"]
            ),
        ),
        (
            "alpha and c of the Maxwell model agree well with Makris' r and C0",
            (
                f"alpha = {maxwell['alpha']:.3f}, r = {MAKRIS['ratio']:g}; c = {maxwell['c']:.1f}, "
                f"C0 = {MAKRIS['c0']:g}, of different units and meaning"
            ),
            "alpha yes; c cannot be compared",
        ),
        (
            "Maxwell is the better choice, Kelvin can be accepted too",
            (
                f"error by eq. (44) {error['fractional-maxwell']:.3g} % (Maxwell), "
                f"{error['fractional-kelvin']:.3g} % (Kelvin)"
            ),
            verdict(error["fractional-maxwell"] < error["fractional-kelvin"]),
        ),
    ]
    note = (
        "Measured on the reconstruction from eq. (54), which has no scatter for an extra parameter"
        " to follow."
    )
    return Table(
        "Conclusions of section 5.2", ("remark of the paper", "measured", "holds"), rows, note
    )


def verdict(holds: bool) -> str:
    """Yes or no."""
    return "yes" if holds else "no"


def figures(results: Results, folder: Path) -> None:
    """Figures 7 to 10 with the paper's own curves beside ours."""
    data = open_measurement(MAKRIS_DATA)
    for number, part, models in (
        (7, "storage", ("fractional-kelvin", "fractional-kelvin4")),
        (8, "loss", ("fractional-kelvin", "fractional-kelvin4")),
        (9, "storage", ("fractional-maxwell", "fractional-zener")),
        (10, "loss", ("fractional-maxwell", "fractional-zener")),
    ):
        curves = []
        for i, model in enumerate(models):
            marker = {
                "marker": "D" if i == 0 else None,
                "color": COLOURS[i],
                "linestyle": "-" if i == 0 else "--",
            }
            best = results.best(MAKRIS_DATA, model)
            if best:
                curves.append(Curve(f"{MODELS[model]}, fitted here", model, best.theta, marker))
            printed = {"marker": None, "color": COLOURS[i], "linewidth": 1.6, "linestyle": ":"}
            curves.append(Curve(f"{MODELS[model]}, Table 3", model, PRINTED[model], printed))
        with sheet(folder, f"figure{number:02d}", 7.4, 4.6) as page:
            axes = page.subplots()
            moduli(axes, data, curves, part, log=False)
            axes.set(xlim=(0, None), ylim=(0, None))
            axes.lines[-1].set(label="eq. (54), Makris' parameters", color=INK)
            legend_above(
                page,
                axes,
                f"Figure {number}: {part} stiffness of the damper (reconstruction)",
                columns=2,
            )


study = Study(
    "table3",
    datasets=[replace(plugins().find("data set", name), stiffness_scale=SCALE) for name in TITLES],
    models={MAKRIS_DATA: [*MODELS, "makris"], MAXWELL_DATA: list(MODELS)},
    objectives=["paper"],
    optimisers=["pso-paper", "native"],
    repetitions=10,
    budget=8020,
    asks=(
        "Do the paper's conclusions on Makris' damper hold at the optimum?",
        "Parameters and the error of eq. (44) of each model, on Makris' own model and on the"
        " curve of the paper's fit.",
        "The order of models by their errors is the paper's, and their parameters make other"
        " models of four parameters than of three.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
