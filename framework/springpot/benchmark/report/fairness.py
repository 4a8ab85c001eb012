"""What all optimisers of a study have in common, and what not."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence

from springpot.benchmark.robustness import noise_levels
from springpot.benchmark.summary import CellSummary
from springpot.writing import Html, tag

OF_ITS_OWN = {
    "native": (
        "native knows how the model is built: it reads its starts off the data by variable"
        " projection, which no other optimiser could do with what it is given."
    ),
    "auto": (
        "auto chooses by rules that were learnt from half of the problems of springpot-60: on these"
        " it is no newcomer."
    ),
    "least-squares-alternating": (
        "least-squares-alternating was made for these models: that logarithms and parameters take"
        " turns was found by a trial on sweeps of springpot-60."
    ),
    "pso-paper": (
        "pso-paper is born where the paper has it, in (0, k-bar) of a box that reaches twice as"
        " far, and may leave the box."
    ),
}
"""What is peculiar to some optimisers, by name."""


def fairness(facts: Mapping[str, str], summaries: Sequence[CellSummary]) -> Iterator[Html]:
    """The section of the report."""
    yield tag("h2", "What is fair about it")
    lines = [*_common(facts), *_different(summaries)]
    yield tag("ul", *(tag("li", line) for line in lines))


def _common(facts: Mapping[str, str]) -> Iterator[str]:
    yield (
        "In common: data, model, objective, box and budget. Evaluations are counted by springpot,"
        " not by the optimiser; one with its derivative counts as one."
    )
    levels = noise_levels(facts)
    if levels:
        percent = ", ".join(f"{100 * level:g}" for level in sorted(set(levels.values())))
        yield (
            f"Noise: {percent} %, drawn anew for every repetition from the seed, the name of the"
            " data and the repetition: the same draw for all optimisers, models and levels. Data"
            " whose truth is unknown keep what they have."
        )
    else:
        yield "Noise: whatever the data sets hold, the same in every repetition."
    if "common start" in facts:
        begin = json.loads(facts["common start"])
        yield (
            "First point: common. Each repetition has one, uniform in the box; it is evaluation 1"
            f" of every optimiser. Those that begin at a point begin there: {_listed(begin)}. The"
            " others have its value and go their own way."
        )
    else:
        yield (
            "First point: each optimiser's own. All of a repetition get one stream of random"
            " numbers, but use it in their own ways, so that their first points differ;"
            " x0='common' gives them the same one."
        )


def _different(summaries: Sequence[CellSummary]) -> Iterator[str]:
    labels = dict.fromkeys(summary.cell.label for summary in summaries)
    graded = [
        label
        for label in labels
        if any(summary.gradients for summary in summaries if summary.cell.label == label)
    ]
    yield f"Not in common: derivatives, used by {_listed(graded)}."
    yield (
        "Settings are the authors' or the library's defaults, unless the label names others: nobody"
        " was tuned on these problems. An optimiser without randomness runs once where nothing but"
        " random numbers differs between repetitions, and that run stands for all."
    )
    names = {summary.cell.optimiser for summary in summaries}
    yield from (sentence for name, sentence in OF_ITS_OWN.items() if name in names)


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "nobody"
    return ", ".join(names)
