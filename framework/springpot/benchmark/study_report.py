"""The report of a study: one HTML file whose first table says which optimiser to use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from springpot.benchmark.archive import opened
from springpot.benchmark.comparison import OVER_ALL, MeanRanks, OptimiserChoice, scopes
from springpot.benchmark.plan import ASKED, ProblemRow
from springpot.benchmark.standings import CHOICE_NOTE, COMPARING, INSIDER, NOISY, PLAIN, Findings
from springpot.benchmark.statistics import Interval
from springpot.benchmark.summary import CellSummary, store_path
from springpot.files import write_text
from springpot.report.page import element_of, page
from springpot.report.text import seconds
from springpot.writing import NAMED, Html, counted, joined, number, table, tag, wide, wide_table

from .robustness import OF_ITS_OWN, fairness
from .study_plots import (
    Pens,
    Pool,
    accuracy_against_time,
    attained,
    diagram,
    distribution,
    pair,
    pools,
    profile_figures,
    progress,
    share_text,
    verdict,
    with_gradients,
)

STYLE = """
.plot { width: 100%; height: auto; display: block; font: 12px system-ui, sans-serif; }
.keys { max-width: none; line-height: 1.9; }
.keys .key { white-space: normal; }
.key svg { margin-right: 5px; }
.choice td b { overflow-wrap: anywhere; }
.choice td span { display: block; }
.choice .share { white-space: nowrap; font-size: 0.92em; }
.choice td:nth-child(-n+2) { white-space: normal; }
.heat td { text-align: right; padding: 2px 5px; white-space: nowrap; font-size: 0.85em; }
.heat th { white-space: nowrap; font-size: 0.85em; padding: 2px 5px; }
.heat thead th { writing-mode: vertical-rl; transform: rotate(180deg); text-align: left; }
.heat td.sure { font-weight: 700; }
pre + .scroll td:last-child { white-space: normal; }
.facts .fact b { overflow-wrap: anywhere; }
details table { font-size: 0.85em; }
@media (max-width: 760px) {
  .choice td > div { min-width: 0; }
  .heat thead { display: table-header-group; }
  .heat table { display: table; }
  .heat tbody { display: table-row-group; }
  .heat tr { display: table-row; }
  .heat td, .heat td.number { display: table-cell; white-space: nowrap; }
  .heat td::before { content: none; }
}
"""


def write_study_report(
    study: str | Path, out: Path = Path("results"), beside: Path | None = None
) -> Path:
    """Write ``report.html`` beside a study's store.

    Parameters
    ----------
    study : str or Path
        A study's script, store, folder or name.
    out : Path
        Folder of all results.
    beside : Path, optional
        An archive whose trials are shown too.

    Raises
    ------
    StudyError
        If there are no results.
    OutputError
        If the file cannot be written.
    """
    path = store_path(study, out)
    with opened(path, beside) as store:
        findings = Findings.of(store)
    return write_text(path.parent / "report.html", study_html(findings))


def study_html(findings: Findings) -> Html:
    """The report as text."""
    # Before one problem is done by all optimisers there is nothing to compare, but failures show
    # already.
    by_budget = pools(findings)
    head = [*_head(findings, by_budget)]
    body = [*head, *_failures(findings)]
    if findings.races:
        # By what they reach: the best get the lines that are told apart most easily.
        pens = Pens([label for label, _ in attained(findings.races)])
        body = [
            *head,
            *_choices(findings, by_budget),
            *_rankings(findings),
            *_profiles(findings, pens),
            *_progress(findings, pens),
            *_pairs(findings),
            *_cost(findings, pens),
            *_failures(findings),
            *_noise(findings),
            *fairness(findings.facts, findings.summaries),
        ]
    return page(
        f"{findings.name}: which optimiser?",
        *body,
        *_tables(findings),
        *_repeat(findings),
        style=STYLE,
    )


def _head(findings: Findings, by_budget: Sequence[Pool]) -> Iterator[Html]:
    cells = [summary.cell for summary in findings.summaries]
    problems = {cell.problem.id: cell.problem for cell in cells}
    trials = sum(summary.trials for summary in findings.summaries)
    failed = sum(summary.failed for summary in findings.summaries)
    # How much stands behind the answer, before the answer.
    counts = (
        counted(len({cell.label for cell in cells}), "optimiser"),
        counted(len({problem.model for problem in problems.values()}), "model"),
        counted(len({problem.dataset for problem in problems.values()}), "data set"),
        counted(len(problems), "problem"),
        f"{counted(trials, 'trial')} of {findings.scale.budget} evaluations",
        f"{failed} failed",
    )
    yield tag("h1", f"{findings.name}: which optimiser?")
    yield tag(
        "p",
        f"{', '.join(counts)}. Run on {findings.facts.get('started', '')[:10]}.",
        class_="quiet",
    )
    if ASKED[0] in findings.facts:
        told = [(key, findings.facts[key]) for key in ASKED if key in findings.facts]
        lines = (tag("li", tag("b", key.capitalize()), f": {text}") for key, text in told)
        yield tag("ul", *lines)
    if by_budget:
        # The last is that of the whole budget.
        yield tag("div", *verdict(findings, by_budget[-1]), class_="verdict")
        raced = {summary.cell.label: summary.cell.optimiser for summary in findings.summaries}
        # Who reads the advice alone is to know of whom it is, and who knows more than the others.
        named = {INSIDER} & set(raced.values())
        if by_budget[-1].ranking.decided:
            named |= {raced[by_budget[-1].label]} & OF_ITS_OWN.keys()
        yield from (tag("p", OF_ITS_OWN[name], class_="quiet") for name in sorted(named))


def _choices(findings: Findings, by_budget: Sequence[Pool]) -> Iterator[Html]:
    marks = findings.scale.marks
    headers = ("model", "data", *(f"{mark} evaluations" for mark in marks))
    by_problem: dict[int, list[OptimiserChoice]] = {}
    for choice in findings.choices:
        by_problem.setdefault(choice.race.problem.id, []).append(choice)
    rows = []
    # A ranking takes two optimisers.
    if by_budget:
        rows.append(_all_problems(findings, by_budget))
    # Marked in every cell: an optimiser with gradients needs a model that has them.
    graded = with_gradients(findings)
    for choices in sorted(by_problem.values(), key=lambda choices: choices[0].race.problem.model):
        problem = choices[0].race.problem
        rows.append(
            (
                problem.model,
                _data(findings, problem),
                *(_chosen(choice, graded) for choice in choices),
            )
        )
    yield tag("h2", "Which optimiser should I use?")
    yield tag(
        "p",
        "For your model, your data and the evaluations you can afford. Shown are the share of"
        " trials that reached the target, with its 95 % interval (over all problems: for further"
        " problems like these), and the expected evaluations to it. ∇: uses gradients.",
        class_="quiet",
    )
    yield wide(f"table of {', '.join(headers)}", table(headers, rows), "choice")
    note = CHOICE_NOTE.format(target=f"{findings.scale.target:g}")
    yield tag("details", tag("summary", "How this is decided"), tag("p", note))


def _data(findings: Findings, problem: ProblemRow) -> str:
    """The data set, with the objective where there are several."""
    objectives = {race.problem.objective for race in findings.races}
    if len(objectives) > 1:
        return f"{problem.dataset}, {problem.objective}"
    return problem.dataset


def _all_problems(findings: Findings, by_budget: Sequence[Pool]) -> tuple[str, ...]:
    graded = with_gradients(findings)
    cells = []
    for pool in by_budget:
        certainty = pool.ranking.doubt or _alike(pool.alike)
        cells.append(
            _cell(pool.label, _reached(pool.success, pool.running_time), certainty, graded)
        )
    return ("all", f"all {len(findings.races)} problems", *cells)


def _chosen(choice: OptimiserChoice, graded: set[str]) -> Html:
    if choice.label is None:
        return tag("div", "none: all failed")
    # Where no trial reached the target there is no share to tell: how near the best came is.
    share = f"missed: excess {number(choice.excess, 2)}"
    if choice.success.value:
        share = _reached(choice.success, choice.running_time)
    certainty = "too few trials to tell"
    if choice.decided:
        certainty = _alike(choice.alike)
    return _cell(choice.label, share, certainty, graded)


def _reached(success: Interval | None, running_time: float) -> str:
    share = share_text(success)
    # Endless where no trial reached the target.
    if np.isfinite(running_time):
        share += f" in {number(running_time, 3)}"
    return share


def _alike(alike: Sequence[str]) -> str:
    """Who cannot be told from the first."""
    if not alike:
        return "alone"
    names = ", ".join(alike[:NAMED])
    if len(alike) > NAMED:
        names += f" +\u00a0{len(alike) - NAMED}"
    return f"as good: {names}"


def _cell(label: str, share: str, certainty: str, graded: set[str]) -> Html:
    if label in graded:
        label += " ∇"
    return tag(
        "div",
        tag("b", label),
        tag("span", share, class_="share"),
        tag("span", certainty, class_="quiet"),
    )


def _rankings(findings: Findings) -> Iterator[Html]:
    rankings = _over_all(findings)
    if not rankings:
        return
    yield tag("h2", "Who ranks where, and how sure is it?")
    largest = rankings[-1]
    if not np.isnan(largest.p_all):
        # What rounding leaves of nothing is no probability.
        least = float(np.finfo(float).eps)
        p = f"p = {number(largest.p_all, 2)}"
        if largest.p_all < least:
            p = f"p < {number(least, 2)}"
        line = f"Friedman's test that all are alike at {largest.budget} evaluations: {p}."
        yield tag("p", line, class_="quiet")
    # What the whole budget says comes first.
    yield pair([diagram(ranking) for ranking in reversed(rankings)])
    diagrams = []
    for ranking in findings.rankings:
        # One budget is enough to look at; the table of ranks has all.
        if ranking.scope != OVER_ALL and ranking.budget == findings.scale.budget:
            diagrams.append(tag("div", joined([tag("h3", ranking.scope), diagram(ranking)])))
    if diagrams:
        yield tag("details", tag("summary", "By model and by data set"), pair(diagrams))


def _over_all(findings: Findings) -> list[MeanRanks]:
    """The rankings over all problems, by ascending budget."""
    return [ranking for ranking in findings.rankings if ranking.scope == OVER_ALL]


def _profiles(findings: Findings, pens: Pens) -> Iterator[Html]:
    yield tag("h2", "How fast do they get there?")
    yield pens.key()
    everything = distribution(
        findings, findings.races, pens, "All problems: share of trials and targets reached"
    )
    yield pair([everything, *profile_figures(findings, pens)])
    parts = [
        distribution(findings, races, pens, name)
        for name, races in scopes(findings.races)
        if name != OVER_ALL
    ]
    if parts:
        yield tag("details", tag("summary", "By model and by data set"), pair(parts))


def _progress(findings: Findings, pens: Pens) -> Iterator[Html]:
    yield tag("h2", "Progress on each problem")
    yield tag(
        "p",
        "Excess: (f - f_best) / (g - f_best), g at the centre of the box or of no response at all;"
        " below the target it no longer counts. Median of all trials; quartiles for the three that"
        " fall earliest; where half of the trials failed there is no line. On noisy data also what"
        " the same points are worth against the data without their noise.",
        class_="quiet",
    )
    yield pens.key()
    for race in sorted(findings.races, key=lambda race: race.problem.model):
        name = f"{race.problem.model} on {_data(findings, race.problem)}"
        yield tag("details", tag("summary", name), pair(progress(findings, race, pens)))


def _pairs(findings: Findings) -> Iterator[Html]:
    rankings = _over_all(findings)
    if not rankings:
        return
    ranking = rankings[-1]
    # Best first in rows and columns, so that what beats what lies above the diagonal.
    order = [int(i) for i in np.argsort(ranking.means, kind="stable")]
    head = tag("tr", tag("th", ""), *(tag("th", ranking.labels[j]) for j in order))
    rows = [
        tag("tr", tag("th", ranking.labels[i]), *(_heat(ranking, i, j) for j in order))
        for i in order
    ]
    yield tag("h2", "Who beats whom?")
    yield tag(
        "p",
        "Chance in per cent that a trial of the row's optimiser ends below one of the column's on"
        f" the same problem at {ranking.budget} evaluations, ties by half (A12); bold where the two"
        " are told apart, as in the diagrams above.",
        class_="quiet",
    )
    shown = tag("table", tag("thead", head), tag("tbody", *rows))
    yield wide("table of optimisers and problems", shown, "heat")


def _heat(ranking: MeanRanks, i: int, j: int) -> Html:
    if i == j:
        return tag("td", "")
    chance = float(ranking.chances[i, j])
    # At most about half opaque, so that the number in it can be read.
    strength = abs(chance - 0.5) * 1.1
    # Blue and vermilion, which the colour-blind tell apart (doi:10.1038/nmeth.1618).
    colour = "213,94,0"
    if chance > 0.5:
        colour = "0,114,178"
    attributes = {"style": f"background:rgba({colour},{strength:.2f})"}
    if ranking.told(i, j):
        attributes["class_"] = "sure"
    return tag("td", f"{100 * chance:.0f}", **attributes)


def _cost(findings: Findings, pens: Pens) -> Iterator[Html]:
    by_label: dict[str, list[CellSummary]] = {}
    for summary in findings.summaries:
        by_label.setdefault(summary.cell.label, []).append(summary)
    found = {label: _cost_row(label, summaries) for label, summaries in by_label.items()}
    # By the time itself, which stands first in each row and is not shown.
    rows = sorted(row for row in found.values() if row)
    untold = [label for label, row in found.items() if not row]
    headers = (
        "optimiser",
        "trial, median",
        "an evaluation",
        "with gradient",
        "evaluations, median",
    )
    yield tag("h2", "What do they cost?")
    yield tag(
        "p",
        "Processor time of the optimiser with the model's, for one trial run alone on this machine;"
        " medians over problems.",
        class_="quiet",
    )
    if any(summary.processor for summary in findings.summaries):
        yield pens.key()
        yield pair([accuracy_against_time(findings, pens)])
    if rows:
        yield wide_table(headers, [row[1:] for row in rows], headers[1:])
    # Such as those of an archive, which were run elsewhere.
    if untold:
        whose = "anybody: they were run elsewhere, or failed"
        if rows:
            whose = ", ".join(untold)
        yield tag("p", f"No time is known of {whose}.", class_="quiet")


def _cost_row(
    label: str, summaries: Sequence[CellSummary]
) -> tuple[float, str, str, str, str, str] | None:
    known = [
        (s.processor, s.each, s.evaluations, s.gradients or 0.0)
        for s in summaries
        if s.processor and s.each and s.evaluations
    ]
    if not known:
        return None
    spent, rates, evaluations, gradients = np.array(known).T
    middle, each = float(np.median(spent)), float(np.median(rates))
    share = f"{100 * float(np.median(gradients / evaluations)):.0f} %"
    return (
        middle,
        label,
        seconds(middle),
        seconds(each),
        share,
        number(float(np.median(evaluations)), 3),
    )


def _failures(findings: Findings) -> Iterator[Html]:
    yield tag("h2", "Failures")
    counted: Counter[tuple[str, str, str]] = Counter()
    # The same fault on twenty problems is one line with a count.
    for summary in findings.summaries:
        for (status, reason), count in summary.reasons.items():
            counted[summary.cell.label, status, reason] += count
    if not counted:
        yield tag("p", "No trial failed.")
        return
    yield tag(
        "p", "A trial that failed counts as one that never reached any target.", class_="quiet"
    )
    rows = [(*key, str(count)) for key, count in counted.most_common()]
    headers = ("optimiser", "status", "reason", "trials")
    yield wide_table(headers, rows, headers[3:])


def _noise(findings: Findings) -> Iterator[Html]:
    if NOISY not in findings.facts:
        return
    made = COMPARING[NOISY](findings)
    yield tag("h2", "What does noise change?")
    yield tag("p", made.note, class_="quiet")
    yield element_of(made)


def _tables(findings: Findings) -> Iterator[Html]:
    yield tag("h2", "All numbers")
    names = ["summary", "failures"]
    # Before every optimiser has finished a trial of one problem there is nothing to compare.
    if findings.races:
        names += ["profiles", "ranks", "anytime", "sensitivity"]
    for name in names:
        # Folded, at the end: for who wants the numbers behind the pictures.
        made = (PLAIN | COMPARING)[name](findings)
        if made.rows:
            yield tag(
                "details",
                tag("summary", name),
                tag("p", made.note, class_="quiet"),
                element_of(made),
            )


def _repeat(findings: Findings) -> Iterator[Html]:
    facts = dict(findings.facts)
    yield tag("h2", "To repeat this")
    yield tag("pre", facts.pop("command", ""))
    # The list of cells is for programs, and the name stands above.
    left_out = {"cells", "optima", "name", "common start", NOISY, *ASKED}
    rows = [(key, value) for key, value in sorted(facts.items()) if key not in left_out]
    yield wide_table(("what", "value"), rows)
    yield tag(
        "p",
        "Random numbers come from the seed, the names of data set, model and objective, and the"
        " repetition: the same for every optimiser. Made by springpot.",
        class_="quiet",
    )
