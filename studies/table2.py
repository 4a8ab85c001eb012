"""Table 2: parameters identified from artificial data with noise of 1 % and 2 %, eq. (53).

    springpot run studies/table2.py

The paper shows one draw of the noise for each level, to which it applied its swarm 20 times. One
draw says little about the sensitivity to noise, so here 20 are drawn, each searched 20 times: the
tables give mean and standard deviation over the draws, once for the one-sided noise as printed (r
from 0 to 1) and once for noise of both signs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from paper.draw import COLOURS, INK, can_draw, legend_above, sheet
from paper.published import MODELS, TABLE_2, in_columns
from paper.results import Results
from springpot import Measurement, identify, plugins
from springpot.benchmark import Study, Table, save_table
from springpot.measurement import DataSet
from springpot.report.page import Entry
from springpot_plugins.datasets.shipped import SCALE, TRUTH, artificial

DRAWS = 20
LEVELS = (0.01, 0.02)
KINDS = {"one-sided": False, "symmetric": True}
SWARM, OPTIMUM = "pso-paper, best run", "optimum (native)"
Estimates = dict[tuple[str, float, str, str], list[dict[str, float]]]
"""From model, noise level, kind of noise and who to the parameters of every draw."""


def name_of(model: str, level: float, kind: str, draw: int) -> str:
    """Name of the data with one draw of the noise."""
    return f"artificial-{model}-{kind}{100 * level:g}-draw{draw:02d}"


def drawn(model: str, level: float, kind: str, draw: int) -> Measurement:
    """Artificial data with one draw of the noise; its stream depends on the arguments alone."""
    rng = np.random.default_rng(
        [2017, draw, list(TRUTH).index(model), round(1000 * level), KINDS[kind]]
    )
    data = artificial(model, level, symmetric=KINDS[kind], seed=rng)
    return replace(data, name=name_of(model, level, kind, draw))


def noisy(model: str, level: float, kind: str, draw: int) -> DataSet:
    """The same as a data set that knows its truth."""
    return DataSet(
        name_of(model, level, kind, draw),
        f"section 5.1, {model} with {kind} noise of {100 * level:g} %, draw {draw}",
        partial(drawn, model, level, kind, draw),
        kind="artificial",
        model=model,
        truth=dict(TRUTH[model]),
        stiffness_scale=SCALE,
    )


def cases() -> Iterator[tuple[str, float, str]]:
    """All combinations of kind of noise, model and level."""
    return ((model, level, kind) for kind in KINDS for model in MODELS for level in LEVELS)


def finish(path: Path, folder: Path) -> None:
    """Write a table and a figure for each kind of noise."""
    found = estimates(Results.of(path))
    for kind in KINDS:
        stem = "table2" if kind == "one-sided" else f"table2_{kind}"
        save_table(table(found, kind), folder, stem)
        if can_draw(folder):
            figure(found, kind, folder, stem)


def estimates(results: Results) -> Estimates:
    """What the swarm found, and the optimum it was looking for, of every draw."""
    objective = plugins().find("objective", "paper")
    found: Estimates = {}
    for model, level, kind in cases():
        names = [name_of(model, level, kind, draw) for draw in range(DRAWS)]
        best = [results.best(name, model) for name in names]
        found[model, level, kind, SWARM] = [trial.theta for trial in best if trial]
        fits = [
            identify(drawn(model, level, kind, d), model, objective=objective) for d in range(DRAWS)
        ]
        found[model, level, kind, OPTIMUM] = [
            dict(zip(fit.model.names, fit.theta.tolist(), strict=True)) for fit in fits
        ]
    return found


def table(found: Estimates, kind: str) -> Table:
    """Mean and standard deviation over the draws, beside the paper's one draw."""
    rows: list[tuple[Entry, ...]] = []
    for model, title in MODELS.items():
        for level in LEVELS:
            noise = f"{100 * level:g} %"
            printed = TABLE_2.get((model, level)) if kind == "one-sided" else None
            if printed:
                paper = in_columns(printed)
                pairs = [entry for value in paper for entry in (value, None)]
                away = distance(printed, found[model, level, kind, OPTIMUM])
                rows.append(
                    (title, noise, "paper, one draw", *pairs, worst([printed], model, level), away)
                )
            for who in (SWARM, OPTIMUM):
                draws = found[model, level, kind, who]
                rows.append((title, noise, who, *moments(draws), worst(draws, model, level), None))
    heads = ["k1 [kN/m]", "k2 or k [kN/m]", "c [kN s^alpha/m]", "alpha [-]"]
    columns = [column for head in heads for column in (head, f"sd of {head.split(' [')[0]}")]
    note = (
        "Exact: k1 = 600, k2 = k = 400, c = 150, alpha = 0.6. Mean and standard deviation over"
        f" {DRAWS} draws. Error over noise: the largest, over the parameters, root mean square"
        " relative error divided by the noise level. Paper in sd: the largest distance of the"
        " paper's value from our mean in our standard deviations."
    )
    head = ("model", "noise", "who", *columns, "error over noise", "paper in sd")
    return Table(f"Table 2: artificial data with {kind} noise, eq. (53)", head, rows, note)


def moments(draws: list[dict[str, float]]) -> list[Entry]:
    """Mean and standard deviation of every column."""
    if not draws:
        return [None] * 8
    columns = zip(*map(in_columns, draws), strict=True)
    return [
        entry
        for column in columns
        for entry in (
            (None, None)
            if None in column
            else (float(np.mean(column)), float(np.std(column, ddof=1)))
        )
    ]


def worst(draws: list[dict[str, float]], model: str, level: float) -> float | None:
    """Largest root mean square relative error of a parameter over the noise level."""
    if not draws:
        return None
    errors = [[draw[name] / exact - 1.0 for name, exact in TRUTH[model].items()] for draw in draws]
    return float(np.max(np.sqrt(np.mean(np.square(errors), axis=0))) / level)


def distance(printed: dict[str, float], draws: list[dict[str, float]]) -> float:
    """How many standard deviations the paper's values are from our mean, at most."""
    values = {name: np.array([draw[name] for draw in draws]) for name in printed}
    return max(float(abs(printed[name] - v.mean()) / v.std(ddof=1)) for name, v in values.items())


def figure(found: Estimates, kind: str, folder: Path, stem: str) -> None:
    """Relative errors of every parameter of every model."""
    places = [(model, name) for model in MODELS for name in TRUTH[model]]
    with sheet(folder, stem, 8.6, 6.2) as page:
        panels = page.subplots(1, 2, sharey=True)
        for axes, level in zip(panels, LEVELS, strict=True):
            for row, (model, name) in enumerate(places):
                exact = TRUTH[model][name]
                for who, colour, shift in ((OPTIMUM, COLOURS[1], 0.14), (SWARM, COLOURS[0], -0.14)):
                    errors = [
                        100 * (draw[name] / exact - 1) for draw in found[model, level, kind, who]
                    ]
                    axes.errorbar(
                        np.mean(errors),
                        row + shift,
                        xerr=2 * np.std(errors, ddof=1),
                        fmt="o",
                        color=colour,
                        label=f"{who}: mean, 2 sd",
                    )
                printed = TABLE_2.get((model, level)) if kind == "one-sided" else None
                if printed:
                    error = 100 * (printed[name] / exact - 1)
                    axes.plot(
                        error,
                        row,
                        "x",
                        color=INK,
                        markersize=7,
                        markeredgewidth=1.8,
                        zorder=4,
                        label="paper",
                    )
            axes.axvline(0.0, color=INK, linewidth=0.8)
            axes.set_xscale("symlog", linthresh=1.0)
            axes.xaxis.set_major_formatter("{x:g}")
            axes.set(xlabel="relative error [%]", title=f"noise {100 * level:g} %, {kind}")
        panels[0].set(yticks=range(len(places)), ylim=(len(places) - 0.4, -0.6))
        panels[0].set_yticklabels(
            [f"{MODELS[model]}:  {'α' if name == 'alpha' else name}" for model, name in places]
        )
        handles, labels = panels[0].get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        legend_above(
            page,
            list(unique.values()),
            f"Table 2: errors of the parameters over {DRAWS} draws of the noise",
        )


study = Study(
    "table2",
    datasets=[noisy(*case, draw) for case in cases() for draw in range(DRAWS)],
    models=["own"],
    objectives=["paper"],
    optimisers=["pso-paper"],
    repetitions=20,
    budget=8020,
    asks=(
        "How far does noise of 1 % and 2 % move what is identified?",
        "Mean and standard deviation of parameters over 20 draws of the noise, and where the"
        " paper's row lies among these.",
        "Errors of the order of the noise, and the paper's rows within three standard deviations.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
