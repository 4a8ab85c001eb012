"""Table 1: parameters identified from artificial data without noise.

    springpot run studies/table1.py

The paper applies its swarm 5 times to each model and prints the result. One such group says little
about a random search, so the swarm runs 100 times here: the first five are set beside the paper's
row, all twenty groups of five show what five runs can be expected to give.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from paper.draw import COLOURS, INK, can_draw, legend_above, logarithmic, sheet
from paper.published import MODELS, TABLE_1, as_printed, in_columns, largest_error
from paper.results import Results, best_of
from springpot import plugins
from springpot.benchmark import Interval, Study, Table, save_table
from springpot.benchmark.statistics import wilson
from springpot.benchmark.summary import TrialRow
from springpot.report.page import Entry

GROUP = 5
SWARM, NATIVE = "pso-paper", "native"
TRUTH = {model: dict(plugins().find("data set", f"artificial-{model}").truth) for model in MODELS}


def finish(path: Path, folder: Path) -> None:
    """Write the table and a figure of how far groups of five runs fall from the truth."""
    results = Results.of(path)
    groups = {model: groups_of(results, model) for model in MODELS}
    save_table(table(results, groups), folder, "table1")
    if can_draw(folder):
        figure(results, groups, folder)


def groups_of(results: Results, model: str) -> list[TrialRow]:
    """The best trial, by its objective, of each full group of five swarms."""
    trials = results.of_cell(f"artificial-{model}", model, SWARM)
    full = [trials[i : i + GROUP] for i in range(0, len(trials), GROUP)]
    return [best for group in full if len(group) == GROUP and (best := best_of(group))]


def table(results: Results, groups: dict[str, list[TrialRow]]) -> Table:
    """The paper's table with its own row, ours, and how often we are as good as the paper."""
    rows: list[tuple[Entry, ...]] = []
    for model, name in MODELS.items():
        if model in TABLE_1:
            rows.append((name, "paper", *numbers(model, TABLE_1[model]), None))
        first = groups[model][0].theta if groups[model] else {}
        rows.append(
            (
                name,
                f"{SWARM}, best of {GROUP}",
                *numbers(model, first),
                as_good(model, groups[model]),
            )
        )
        native = results.of_cell(f"artificial-{model}", model, NATIVE)
        rows.append(
            (
                name,
                NATIVE,
                *numbers(model, native[0].theta if native else {}),
                as_good(model, native),
            )
        )
    values = ("k1 [kN/m]", "k2 or k [kN/m]", "c [kN s^alpha/m]", "alpha [-]")
    heads = ("model", "who", *values, "largest error", "as good as the paper")
    note = (
        "Exact: k1 = 600, k2 = k = 400, c = 150, alpha = 0.6. The paper has no row for the"
        f" springpot. Last column: share of groups of {GROUP} swarms (of single runs of {NATIVE})"
        " whose parameters, rounded as printed, err by no more than the paper's row, with its 95 %"
        " interval (Wilson)."
    )
    return Table("Table 1: artificial data without noise", heads, rows, note)


def numbers(model: str, theta: Mapping[str, float]) -> tuple[Entry, ...]:
    """Parameters in the paper's columns, and the largest error of them."""
    return *in_columns(theta), largest_error(theta, TRUTH[model]) if theta else None


def as_good(model: str, trials: list[TrialRow]) -> Interval | None:
    """How often trials are within the paper's error, both rounded as printed."""
    if model not in TABLE_1:
        return None
    allowed = largest_error(TABLE_1[model], TRUTH[model]) + 1e-12
    return wilson(
        sum(largest_error(as_printed(t.theta), TRUTH[model]) <= allowed for t in trials),
        len(trials),
    )


def figure(results: Results, groups: dict[str, list[TrialRow]], folder: Path) -> None:
    """Largest error of each group of five, of the native solver and of the paper."""
    with sheet(folder, "table1", 7.2, 3.9) as page:
        axes = page.subplots()
        for row, model in enumerate(MODELS):
            errors = [largest_error(trial.theta, TRUTH[model]) for trial in groups[model]]
            spread = row + np.linspace(-0.25, 0.25, len(errors))
            axes.plot(
                errors, spread, "o", color=COLOURS[0], alpha=0.7, label=f"best of {GROUP} swarms"
            )
            native = results.of_cell(f"artificial-{model}", model, NATIVE)
            if native:
                worst = max(largest_error(trial.theta, TRUTH[model]) for trial in native)
                axes.plot(
                    max(worst, 1e-16),
                    row,
                    "D",
                    color=COLOURS[1],
                    markersize=7,
                    label="native, worst run",
                )
            printed = largest_error(TABLE_1[model], TRUTH[model]) if model in TABLE_1 else 0.0
            if printed > 0:
                axes.plot(
                    printed,
                    row,
                    "x",
                    color=INK,
                    markersize=10,
                    markeredgewidth=2.2,
                    zorder=4,
                    label="paper",
                )
        logarithmic(axes, "x")
        axes.set(
            xlabel="largest relative error of a parameter",
            yticks=range(len(MODELS)),
            ylim=(4.6, -0.6),
        )
        axes.set_yticklabels(list(MODELS.values()))
        handles = {handle.get_label(): handle for handle in axes.lines}
        legend_above(
            page,
            list(handles.values()),
            "Table 1: errors without noise (paper's Maxwell: none in print)",
        )


study = Study(
    "table1",
    datasets=[f"artificial-{model}" for model in MODELS],
    models=["own"],
    objectives=["paper"],
    optimisers=[SWARM, NATIVE],
    repetitions=100,
    budget=8020,
    target=1e-16,
    stop_at_target=True,
    asks=(
        "Does the paper's swarm find the parameters of exact data, as its Table 1 says?",
        "The largest relative error of a group's five best parameters beside the paper's"
        " printed row, for twenty groups of five swarms.",
        "Most groups as good as the paper's row: it is what such a search gives. Few: it was"
        " a lucky one.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
