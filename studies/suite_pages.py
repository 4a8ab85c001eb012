"""A page for every problem of the suites, made when the site is built (a hook of mkdocs).

Written from the suites themselves and the archives of their races: nothing of it is kept in the
repository, where it could grow old.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from springpot import plugins
from springpot.benchmark import Study
from springpot.benchmark.plan import RaceCase, problem_of, reference_of
from springpot.benchmark.plot import Dot, Pen, PlotAxis, key, scatter
from springpot.benchmark.statistics import expected_running_time
from springpot.identification.problem import SpecimenProblem
from springpot.measurement import DataSet, Measured, Measurement, Suite
from springpot.rheology import Real
from springpot.timetests import Test
from suite import IMAGES, ROOT, ROUNDING, TARGET, short
from suite_repeated import archived

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

RACES = {
    "springpot-60": ("suite_race", "suite_repeated"),
    "springpot-hard-20": ("suite_hard",),
    "springpot-rugged-20": ("suite_rugged",),
}
"""Studies whose archives tell who arrives."""
EASIER = ("funnel",)
"""Features that are the smaller, the harder a problem is."""
ROW = re.compile(r"^\| `([\w-]+)` \|", re.M)
"""Of the tables of problems in docs/suite.md."""
MAP = re.compile(r"!\[.*?\]\(images/(springpot-60\.svg)\)")

Hits = Mapping[str, Sequence[tuple[Real, Real]]]
"""Evaluations at which trials met the target, and that they spent, by optimiser."""


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pages."""
    from mkdocs.structure.files import File

    for name in RACES:
        for problem, text in pages(plugins().find("suite", name)):
            files.append(File.generated(config, f"suite/{problem}.md", content=text))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """On the page of the suites names of problems lead to their pages, also in the map."""
    if page.file.src_uri != "suite.md":
        return markdown

    def drawn(link: re.Match[str]) -> str:
        picture = (IMAGES / link[1]).read_text(encoding="utf-8")
        narrow = '<svg style="max-width: 100%; height: auto"'
        return f"<div>{picture[picture.index('<svg') :].replace('<svg', narrow, 1)}</div>"

    def linked(row: re.Match[str]) -> str:
        return f"| [`{row[1]}`](suite/{row[1]}.md) |" if row[1] in known else row[0]

    known = {short(name) for suite in RACES for name in plugins().find("suite", suite).measured}
    return MAP.sub(drawn, ROW.sub(linked, markdown))


def pages(suite: Suite) -> Iterator[tuple[str, str]]:
    """The pages of a suite, each with the name of its problem."""
    trials = _trials(suite.name)
    plan = Study("suite", [suite.name], ["own"], ["own"], ["random-search"]).plan()
    names = [short(each.name) for each in suite.problems]
    for i, (known, case) in enumerate(zip(suite.problems, plan.cases, strict=True)):
        beside = {"before it": names[:i][-1:], "after it": names[i + 1 :][:1]}
        ways = (f"{where} [{n}]({n}.md)" for where, each in beside.items() for n in each)
        text = _page(suite, known, case, trials.get(known.name, {}))
        yield names[i], f"{text}\n*In the suite {', '.join(ways)}.*\n"


def _trials(suite: str) -> dict[str, dict[str, list[tuple[Real, Real]]]]:
    found: dict[str, dict[str, list[tuple[Real, Real]]]] = {}
    for name in RACES[suite]:
        path = ROOT / "results" / name / f"{name}.zip"
        for problem, entrants in archived(path, suite).items():
            for label, trials in entrants.items():
                found.setdefault(problem, {}).setdefault(label, []).append(trials)
    return found


def _page(suite: Suite, known: DataSet, case: RaceCase, hits: Hits) -> str:
    problem = problem_of(case.source, case.source.model_of(case.model), case.objective)
    parts = (
        f"# {known.name}\n\n{known.summary} One of the problems of [{suite.name}](../suite.md).",
        *(_picture(test) for test in case.source.tests),
        _facts(known, problem),
        _parameters(known, case, problem),
        _features(suite.measured, known.name),
        _arrived(hits),
        _alone(known),
    )
    return "\n\n".join(parts) + "\n"


def _facts(known: DataSet, problem: SpecimenProblem) -> str:
    assert known.best is not None
    # Of exact data nothing but rounding is left.
    best = f"{known.best:.6g}" if known.best > ROUNDING else "0"
    goal = known.best + TARGET * (reference_of(problem) - known.best)
    seed = "that of the data set"
    if known.kind != "artificial" or known.test.endswith("no noise"):
        seed = "none is needed"
    elif not known.test.startswith("data set"):
        seed = f'noise is drawn by `numpy.random.default_rng(list(b"{known.name}"))`'
    rows = (
        f"**Model**: `{known.model}`, {problem.dimension} parameters",
        f"**Data**: {known.test} ({known.kind}; {known.citation})",
        f"**Seed**: {seed}; optimisers draw from that of their study",
        f"**Objective**: `{known.objective}`; best known value {best}; a trial has arrived at"
        f" {goal:.6g}, a millionth of the way from there to {reference_of(problem):.4g}",
    )
    return "\n".join(f"- {row}" for row in rows)


def _parameters(known: DataSet, case: RaceCase, problem: SpecimenProblem) -> str:
    units, space = case.source.tests[0].units, problem.space
    truth = dict[str, str]()
    text = "## Parameters\n\n"
    if known.truth:
        values = space.from_theta(space.model.vector(dict(known.truth)))
        truth = {each: f"{value:.6g}" for each, value in zip(space.names, values, strict=True)}
    text += "| parameter | unit | from | to | truth |\n| --- | --- | ---: | ---: | ---: |\n"
    for each, low, high in zip(space.parameters, space.lower, space.upper, strict=True):
        factor, unit = units.of(each.unit)
        told = truth.get(each.name, "not known")
        if factor != 1.0:
            unit = f"{factor:g} {unit}"
        text += f"| `{each.name}` | {unit} | {low:.4g} | {high:.4g} | {told} |\n"
    if known.truth and space.model.search is not None:
        own = ", ".join(f"`{key}` = {value:g}" for key, value in known.truth.items())
        text += f"\nSearched in the paper's form; in the model's own parameters the truth is {own}."
    return text


def _features(measured: Mapping[str, Measured], name: str) -> str:
    own = measured[name]
    text = f"## How hard it is: {own.part}\n\n"
    text += f"| feature | here | easier by it, of {len(measured)} |\n| --- | ---: | ---: |\n"
    for name, value in own.features.items():
        others = np.array([each.features[name] for each in measured.values()])
        easier = others > value if name in EASIER else others < value
        text += f"| {name} | {value:g} | {np.count_nonzero(easier)} |\n"
    return text + "\nWhat the features are: [of the suite](../suite.md#what-was-measured-of-them)."


def _arrived(hits: Hits) -> str:
    text = "## Who arrives, and when\n\n"
    found, never = list[tuple[float, str]](), list[str]()
    for label, parts in hits.items():
        at, spent = (np.concatenate(each) for each in zip(*parts, strict=True))
        there = np.isfinite(at)
        if not there.any():
            never.append(f"`{label}`")
            continue
        time, median = expected_running_time(at, spent), np.median(at[there])
        row = f"| `{label}` | {there.sum()} of {len(at)} | {time:,.0f} | {median:,.0f} |"
        found.append((time, row))
    if found:
        text += "| optimiser | trials there | expected running time | median of those there |\n"
        text += "| --- | ---: | ---: | ---: |\n"
        text += "".join(f"{row}\n" for _, row in sorted(found))
        text += "\nIn evaluations, of 8,000, from the archived trials."
    return text + (f" In no trial: {', '.join(never)}." if never else "")


def _alone(known: DataSet) -> str:
    race = RACES[known.name.partition("/")[0]][0]
    return f"""## Alone

An optimiser beside the archived trials, and the same without these in Python:

```console
$ springpot run results/{race}/{race}.zip --problem {known.name} --optimiser auto
```

```python
from springpot.benchmark import Study, run_study

study = Study("mine", ["{known.name}"], ["own"], ["own"], ["auto", "cma-es"], budget=8000)
run_study(study)
```"""


def _picture(test: Test) -> str:
    if isinstance(test, Measurement):
        across, label = test.omega / (2.0 * np.pi), "frequency [Hz]"
        series = {"storage": test.stiffness.real, "loss": test.stiffness.imag}
        unit = test.units.stiffness
    else:
        across, label = test.time, "time [s]"
        series, unit = {"force": test.response}, test.force_unit
        if test.control == "force":
            series, unit = {"displacement": test.response}, test.displacement_unit
    pens = [Pen(i) for i in range(len(series))]
    x, y = _axis(label, across), _axis(unit, np.concatenate(list(series.values())))
    dots = [
        Dot(name, float(a), float(b), pen)
        for pen, (name, column) in zip(pens, series.items(), strict=True)
        for a, b in zip(across, column, strict=True)
    ]
    shown = scatter(dots, x, y, "the data") + key(list(series), pens)
    return f'<div style="max-width: 32em; font-size: 12px">{shown}</div>'


def _axis(label: str, values: Real) -> PlotAxis:
    low, high = float(values.min()), float(values.max())
    # What spans decades is seen on decades; a record that turns its sign is not.
    if low > 0.0 and high > 20.0 * low:
        return PlotAxis(label, low / 1.2, high * 1.2, logarithmic=True)
    step = 10.0 ** np.floor(np.log10(high - low or 1.0) - 1.0)
    # The first of 1, 2, 5 ... by five of which all is spanned, so that ticks are round.
    for each in (m * 10.0**power * step for power in range(3) for m in (1.0, 2.0, 5.0)):
        low = np.floor(values.min() / each) * each
        if low + 5.0 * each >= high:
            break
    return PlotAxis(label, low, low + 5.0 * each)
