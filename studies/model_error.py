"""Modelling error, the end of section 5.1: data of one model fitted by another.

    springpot run studies/model_error.py

Data of the Kelvin type with four parameters are fitted by the three-parameter Kelvin model, which
the paper calls unacceptable, and data of both three-parameter models by both four-parameter models,
which it calls acceptable.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from paper.draw import Curve, can_draw, legend_above, moduli, sheet
from paper.published import MODELS, in_columns
from paper.results import Results, percent, relative_rms
from springpot import Measurement, identify, open_measurement, plugins
from springpot.benchmark import Study, Table, save_table
from springpot.measurement import DataSet
from springpot.report.page import Entry

TOO_SIMPLE = {
    "fractional-kelvin4": ["fractional-kelvin"],
    "fractional-zener": ["fractional-kelvin", "fractional-maxwell"],
}
RICH_ENOUGH = {
    "fractional-kelvin": ["fractional-kelvin4", "fractional-zener"],
    "fractional-maxwell": ["fractional-kelvin4", "fractional-zener"],
}
PAIRS = TOO_SIMPLE | RICH_ENOUGH
SAYS = {("fractional-kelvin4", "fractional-kelvin"): "unacceptable"} | {
    (data, model): "acceptable" for data, models in RICH_ENOUGH.items() for model in models
}
ACCEPTABLE = 0.02
"""Relative error up to which a fit is called acceptable here: the larger noise of section 5.1."""
WITHOUT_BOX = "identify, no box"


def dataset(model: str) -> DataSet:
    """The artificial data, with k-bar left to the data.

    1000 kN/m is less than what these models reach.
    """
    found: DataSet = plugins().find("data set", f"artificial-{model}")
    return replace(found, stiffness_scale=None)


def finish(path: Path, folder: Path) -> None:
    """Write the table and a figure of the two cases that the paper names."""
    results = Results.of(path)
    save_table(table(results), folder, "model_error")
    if can_draw(folder):
        figure(results, folder)


def table(results: Results) -> Table:
    """Error of every fit and what it means."""
    rows: list[tuple[Entry, ...]] = []
    for source, models in PAIRS.items():
        data = open_measurement(f"artificial-{source}")
        for model in models:
            for who, theta in fits(results, data, model).items():
                error = relative_rms(model, theta, data) if theta else None
                verdict = (
                    None
                    if error is None
                    else "acceptable"
                    if error <= ACCEPTABLE
                    else "unacceptable"
                )
                says = SAYS.get((source, model))
                rows.append(
                    (MODELS[source], MODELS[model], who, *in_columns(theta), error, verdict, says)
                )
    heads = ("k1 [kN/m]", "k2 or k [kN/m]", "c [kN s^alpha/m]", "alpha [-]")
    columns = ("data of", "fitted by", "who", *heads, "relative rms error", "verdict", "paper")
    note = (
        "Relative rms error: root mean square of |K - K_m| / |K_m| over the 14 frequencies. The"
        " paper gives words, not numbers; acceptable here means an error of at most"
        f" {100 * ACCEPTABLE:g} %, the larger of its noise levels. A four-parameter model contains"
        " the three-parameter ones as limits (k1 or k2 infinite for Kelvin, zero for Maxwell): in"
        " a box of stiffnesses the infinite limit is out of reach, without one it is found."
    )
    return Table(
        "Modelling error: data of one model fitted by another (end of section 5.1)",
        columns,
        rows,
        note,
    )


def fits(results: Results, data: Measurement, model: str) -> dict[str, dict[str, float]]:
    """Parameters by swarm and native solver in the paper's box, and by the latter without a box."""
    found = {}
    for who in ("pso-paper", "native"):
        best = results.best(data.name, model, who)
        found[f"{who}, best run"] = best.theta if best else {}
    free = identify(data, model, objective="paper")
    return found | {WITHOUT_BOX: dict(zip(free.model.names, free.theta.tolist(), strict=True))}


def figure(results: Results, folder: Path) -> None:
    """Both moduli: the unacceptable case above, an acceptable one below."""
    cases = [
        ("fractional-kelvin4", "fractional-kelvin"),
        ("fractional-kelvin", "fractional-kelvin4"),
    ]
    with sheet(folder, "model_error", 8.6, 6.4) as page:
        panels = page.subplots(2, 2)
        for row, (source, model) in zip(panels, cases, strict=True):
            data = open_measurement(f"artificial-{source}")
            theta = fits(results, data, model)[WITHOUT_BOX]
            curve = Curve("fitted model", model, theta)
            for axes, part in zip(row, ("storage", "loss"), strict=True):
                moduli(axes, data, [curve], part, log=False)
            error = percent(relative_rms(model, theta, data))
            row[0].set_title(f"{MODELS[model]},\nfitted to {MODELS[source]}: error {error}")
        legend_above(page, panels[0, 0], "Modelling error, end of section 5.1")


study = Study(
    "model_error",
    datasets=[dataset(model) for model in PAIRS],
    models={f"artificial-{source}": models for source, models in PAIRS.items()},
    objectives=["paper"],
    optimisers=["pso-paper", "native"],
    repetitions=10,
    budget=8020,
    asks=(
        "Is a model with too few parameters seen to be wrong, and one with too many harmless?",
        "The error of eq. (44) at the optimum, and whether the peak of the loss is met.",
        "An error well above that of the true model where parameters lack; none where there"
        " are too many.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
