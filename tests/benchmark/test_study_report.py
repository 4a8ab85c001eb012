"""The report of a study: self-contained, escaped, and saying who wins."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from benchmark_fakes import Moody, Walk, artificial, small_study

from springpot.benchmark import Findings, Store, run_study, study_report
from springpot.benchmark.plot import (
    Dot,
    Pen,
    PlotAxis,
    Ranked,
    StepLine,
    critical_differences,
    plot,
    scatter,
)
from springpot.benchmark.statistics import wilson
from springpot.benchmark.study_plots import pools, share_text, verdict
from springpot.benchmark.study_report import study_html, write_study_report
from springpot.identification import Optimiser
from springpot.writing import joined

NASTY = '<script>alert("&")</script>'


@dataclass(frozen=True)
class Lazy(Walk):
    """Gives up at once."""

    name: ClassVar[str] = "lazy"

    def minimise(self, problem, budget, rng):
        """One point."""
        problem(problem.lower)


class Reader(HTMLParser):
    """Tags, attributes and text of a page, and whether its tags match."""

    def __init__(self):
        super().__init__()
        self.tags, self.attributes, self.words, self.open = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in {"meta", "br", "img"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    return reader


def report_of(
    tmp_path: Path, optimisers: list[Optimiser | tuple[str, Optimiser]], **changes: object
) -> str:
    outcome = run_study(
        small_study(optimisers=optimisers, **changes), engine="serial", out=tmp_path, quiet=True
    )
    path = write_study_report(str(outcome.store))
    assert path == outcome.store.parent / "report.html"
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    entrants = [(NASTY, Walk()), Lazy(), Moody(mood="throw")]
    return report_of(tmp_path_factory.mktemp("report"), entrants, repetitions=8)


@pytest.mark.soak
def test_nothing_is_loaded_and_nothing_runs(page):
    reader = read(page)
    assert not {"script", "iframe", "link", "object", "img"} & set(reader.tags)
    loading = [
        value
        for name, value in reader.attributes
        if name in {"src", "href", "action"} or name.startswith("on")
    ]
    assert loading == []
    assert "url(" not in page
    assert any(value and value.startswith("default-src 'none'") for _, value in reader.attributes)
    assert 'name="viewport"' in page


def test_the_first_sentence_says_who_takes_derivatives(tmp_path, monkeypatch):
    one = small_study(
        datasets=[artificial()], models=["own"], optimisers=[Walk(), Lazy()], budget=50
    )
    outcome = run_study(one, engine="serial", out=tmp_path, quiet=True, tables=False)
    with Store(outcome.store) as store:
        found = Findings.of(store)
    graded = [replace(summary, gradients=1.0) for summary in found.summaries]
    for findings, told in ((found, ""), (replace(found, summaries=graded), ", which takes deriv")):
        assert f"use <b>walk</b>{told}" in str(joined(verdict(findings, pools(findings)[-1])))
    # And below it, before the tables, what is peculiar to who is to be used, and of nobody else.
    own = {"walk": "walk was made for this.", "lazy": "lazy was not."}
    monkeypatch.setattr(study_report, "OF_ITS_OWN", own)
    head, _ = str(study_html(found)).split("Which optimiser should I use?")
    assert own["walk"] in head
    assert own["lazy"] not in head


def test_who_is_to_be_used_over_all_problems_is_worked_out_once(tmp_path, monkeypatch):
    one = small_study(
        datasets=[artificial()], models=["own"], optimisers=[Walk(), Lazy()], budget=50
    )
    outcome = run_study(one, engine="serial", out=tmp_path, quiet=True, tables=False)
    with Store(outcome.store) as store:
        found = Findings.of(store)
    asked = []
    monkeypatch.setattr(study_report, "pools", lambda *_: asked.append(1) or pools(found))
    study_html(found)
    assert len(asked) == 1


def test_who_has_no_time_is_named_below_those_who_have(tmp_path):
    """As trials of an archive have none."""
    one = small_study(
        datasets=[artificial()], models=["own"], optimisers=[Walk(), Lazy()], budget=50
    )
    outcome = run_study(one, engine="serial", out=tmp_path, quiet=True, tables=False)
    with Store(outcome.store) as store:
        found = Findings.of(store)
    summaries = tuple(
        replace(summary, processor=None if summary.cell.label == "walk" else 0.1, each=0.01)
        for summary in found.summaries
    )
    page = str(study_html(replace(found, summaries=summaries)))
    costs = page.partition("What do they cost?")[2].partition("<h2>")[0]
    assert "No time is known of walk." in costs
    assert 'optimiser">lazy<' in costs
    assert 'optimiser">walk<' not in costs


def test_data_cannot_break_the_page(page):
    assert NASTY not in page
    assert any(NASTY in word for word in read(page).words)


def test_the_first_table_names_the_winner(page):
    first = re.search(r"<tbody>(.*?)</tbody>", page, re.S).group(1)
    assert first.count("<tr>") == 5
    winners = re.findall(r"<b>(.*?)</b>", first)
    assert set(winners) == {"&lt;script&gt;alert(&quot;&amp;&quot;)&lt;/script&gt;"}
    assert page.index("Which optimiser should I use?") < page.index("Who ranks where")


def test_failures_and_what_repeats_it_are_told(page):
    words = " ".join(read(page).words)
    assert "ValueError: out of" in words
    for told in ("seed", "python", "numpy", "machine", "started", "To repeat this"):
        assert told in words


def test_a_study_in_which_everything_failed_still_has_a_report(tmp_path):
    words = " ".join(read(report_of(tmp_path, [Moody(mood="throw"), Moody(mood="exit")])).words)
    assert "none: all failed" in words
    assert "ValueError: out of" in words


def test_one_optimiser_and_one_problem(tmp_path):
    page = report_of(tmp_path, [Walk()], datasets=[artificial()], models=["own"], repetitions=1)
    assert "walk" in page
    assert "too few trials to tell" in page or "alone" in page


@pytest.mark.soak
def test_the_same_store_gives_the_same_report(tmp_path):
    first = report_of(tmp_path, [Walk(), Lazy()])
    with Store(tmp_path / "small" / "small.sqlite") as store:
        assert Findings.of(store).races
    path = write_study_report(str(tmp_path / "small" / "small.sqlite"))
    assert path.read_text(encoding="utf-8") == first


@pytest.mark.soak
def test_what_a_study_asks_stands_before_what_it_found(tmp_path):
    asks = ("Who is first?", "Share of trials.", "One ahead of all.")
    words = " ".join(read(report_of(tmp_path, [Walk(), Lazy()], asks=asks)).words)
    places = [words.index(sentence) for sentence in asks]
    assert places == sorted(places)
    assert places[-1] < words.index("Which optimiser should I use?")


def numbers(path: str) -> list[float]:
    return [float(value) for value in re.findall(r"-?\d+\.?\d*", path)]


def test_steps_stay_in_the_frame_and_skip_what_is_infinite():
    x = np.geomspace(1, 1000, 30)
    y = np.where(x < 10, np.inf, 1.0 / x)
    line = StepLine("a < b", x, y, Pen(0), np.stack([0.5 * y, np.full_like(y, np.inf)]))
    picture = plot([line], PlotAxis("n", 1, 1000, True), PlotAxis("f", 1e-3, 1, True), "t")
    [path] = re.findall(r'd="(M[^Z"]*)"', picture)
    assert "a &lt; b" in picture
    assert max(numbers(path)) <= 420
    assert min(numbers(path)) >= 0
    assert numbers(path)[0] > 150
    assert "nan" not in picture
    assert "inf" not in picture


def test_a_flat_line_has_one_step():
    picture = plot(
        [StepLine("a", np.arange(1.0, 50), np.ones(49), Pen(9))],
        PlotAxis("n", 1, 49),
        PlotAxis("f", 0, 2),
        "t",
    )
    [path] = re.findall(r'd="(M[^"]*)"', picture)
    assert path.count("V") == 0
    assert 'stroke-dasharray="6 3"' in picture


def test_critical_differences_show_every_name_and_bar():
    rows = [Ranked(f"o{i}", 1.0 + i, 0.8 + i, 1.2 + i) for i in range(4)]
    picture = critical_differences(rows, [(0, 1), (1, 3)], "ranks")
    assert all(f">o{i}<" in picture for i in range(4))
    assert picture.count('stroke-width="3"') == 2


def test_headline_diagram_and_tables_say_the_same_of_few_problems(page):
    """Four problems cannot tell, whatever their eight trials each say."""
    headline = page.partition('class="verdict"')[2].partition("</div>")[0]
    assert "4 problems cannot tell 3 optimisers apart" in headline
    assert "is 0.38" in headline  # 2 / 2**4 times three pairs
    assert "<b>" not in headline
    assert page.count("their range (4 problems cannot tell)") >= 1
    assert "certain" not in headline


@pytest.mark.soak
def test_headline_diagram_and_tables_say_the_same_of_one_problem(tmp_path):
    entrants = [("twin", Walk()), ("slow", Walk(shrink=0.8)), Moody(mood="throw")]
    page = report_of(tmp_path, entrants, datasets=[artificial()], models=["own"], repetitions=12)
    headline = page.partition('class="verdict"')[2].partition("</div>")[0]
    with Store(tmp_path / "small" / "small.sqlite") as store:
        findings = Findings.of(store)
    ranking, choice = findings.rankings[-1], findings.choices[-1]
    best = int(np.argmin(ranking.means))
    alike = {ranking.labels[best], *ranking.alike(best)}
    assert alike == {choice.label, *choice.alike}
    assert "moody" not in " ".join(alike)
    named = set(re.findall(r"twin|slow|moody", headline))
    assert named == alike
    assert "For this problem" in headline


def test_a_share_is_whole_only_where_it_is():
    assert share_text(wilson(1250, 1250)) == "100 % [99, 100]"
    assert share_text(wilson(1249, 1250)) == "99 % [99, 100]"
    assert share_text(wilson(0, 20)) == "0 % [0, 17]"
    assert share_text(None) == "-"


@pytest.mark.soak
def test_accuracy_stands_against_time(tmp_path):
    """A small point a problem, a large one an optimiser, and the names of those that none beats."""
    text = report_of(tmp_path, [("quick", Walk()), ("slow", Walk(shrink=0.99))])
    picture = text.partition("<title>accuracy against time</title>")[2].partition("</svg>")[0]
    assert picture.count('r="2.5"') == 2 * 4  # two data sets, two models
    assert picture.count('r="5"') == 2
    assert re.search(r">(quick|slow)</text>", picture)
    assert "nan" not in picture


def test_a_point_beyond_the_axes_is_drawn_at_their_end():
    dots = [Dot("far", 1e9, 1e9, Pen(0), large=True, name="far"), Dot("near", 1e-9, 1e-9, Pen(8))]
    picture = scatter(
        dots, PlotAxis("s", 0.1, 10.0, True), PlotAxis("excess", 1e-3, 1.0, True), "t"
    )
    assert all(
        0.0 <= value <= 420.0
        for value in numbers(" ".join(re.findall(r'c[xy]="([^"]*)"', picture)))
    )
    assert 'text-anchor="end"' in picture.partition("far")[2]
    assert 'fill="white"' in picture  # beyond the first seven colours points are hollow


def test_what_it_was_run_with_is_told(tmp_path):
    """Versions of the plugins' distributions and of the library that did the work."""
    from importlib.metadata import version

    class Borrowed(Walk):
        name: ClassVar[str] = "borrowed"
        card = replace(Walk.card, distribution="click")

    text = report_of(tmp_path, [Borrowed()], repetitions=1)
    repeat = text.partition("To repeat this")[2]
    for name in ("springpot", "numpy", "click"):
        assert f"{name}</td>" in repeat
        assert version(name) in repeat
