"""The report of a discovery: whole, quiet and safe whatever the data are called."""

import json
import re
from base64 import b64decode, b64encode
from hashlib import sha256
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest

import springpot
from springpot.errors import OutputError
from springpot.measurement import Measurement, Units
from springpot.report.html import excluded_rows, report_html, write_report
from springpot.report.ladder_text import figure_ladder
from springpot.report.text import percent
from springpot.writing import Html, html, joined, table, tag

Figure = pytest.importorskip("matplotlib.figure").Figure

EVIL = "<script>alert(1)</script>\"'&amp;$\\frac$"
UNPAINTED = "<svg></svg>"
OMEGA = 2.0 * np.pi * np.geomspace(0.5, 100.0, 40)
COMMAND = [
    "springpot",
    "discover",
    f"{EVIL}.csv",
    "--model",
    "fractional-maxwell",
    "--accept",
    "inertia",
]
LONG = ("specimen-inertia-fixed", "-inertia", "self-heating")
TAGS = """
    html head meta title style body main h1 h2 h3 p b i ul li div span figure img figcaption table
    thead tbody tr th td details summary pre svg g text polyline polygon script
"""
KNOWN = set(TAGS.split())


class Page(HTMLParser):
    """What a browser would make of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words, self.open = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, name, attributes):
        self.tags.append(name)
        self.attributes += [(name, key, value or "") for key, value in attributes]
        if name not in {"meta", "img", "br"}:
            self.open.append(name)

    def handle_startendtag(self, name, attributes):
        self.tags.append(name)
        self.attributes += [(name, key, value or "") for key, value in attributes]

    def handle_endtag(self, name):
        assert self.open.pop() == name

    def handle_data(self, data):
        self.words.append(data)


def measured(temperatures=(20.0,), name=EVIL):
    """A damper with a moving mass under a name that no page should believe."""
    s = 1j * OMEGA
    exact = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.5)) + 6e-4 * s**2
    rng = np.random.default_rng(7)
    count = len(temperatures)
    scatter = rng.normal(size=(2, count * len(s)))
    conditions = {"temperature": np.repeat(temperatures, len(s))} if count > 1 else {}
    return Measurement(
        np.tile(OMEGA, count),
        np.tile(exact, count) * (1 + 0.01 * (scatter[0] + 1j * scatter[1])),
        conditions=conditions,
        units=Units("kN/m", "mm"),
        name=name,
        provenance={f"note {EVIL}": f"measured by {EVIL}"},
        labels={EVIL: np.full(count * len(s), EVIL)},
    )


@pytest.fixture(scope="module")
def ladder():
    few = ["inertia", "specimen-inertia-fixed", "time-delay", "friction"]
    return springpot.discover(measured(), "fractional-maxwell", accept=["inertia"], only=few)


@pytest.fixture(scope="module")
def page(ladder):
    """Of its pictures, most of the work, the first is painted."""
    paint, painted = Figure.savefig, []

    def stand_in(self, file, **given):
        if painted:
            file.write(UNPAINTED.encode())
        else:
            painted.append(paint(self, file, **given))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", stand_in)
        return report_html(ladder, measured(), COMMAND)


@pytest.fixture(scope="module")
def painted(ladder):
    return report_html(ladder, measured(), COMMAND)


def pictures_in(page):
    return [b64decode(text).decode() for text in re.findall(r"base64,([A-Za-z0-9+/=]+)", page)]


def test_names_from_data_stay_text(page):
    found = Page(page)
    assert set(found.tags) <= KNOWN
    assert found.tags.count("script") == 2  # what is pointed at, and the program that shows it
    assert not found.open
    assert EVIL in "".join(found.words)
    assert not [key for _, key, _ in found.attributes if key.startswith("on")]


def test_nothing_is_fetched_from_elsewhere(page):
    found = Page(page)
    sources = [
        value for _, key, value in found.attributes if key in {"src", "href", "data", "action"}
    ]
    assert sources
    assert all(value.startswith("data:image/svg+xml;base64,") for value in sources)
    assert not re.search(r"url\((?!#)", page)
    assert "@import" not in page
    [policy] = [
        value for _, key, value in found.attributes if key == "content" and "default-src" in value
    ]
    assert policy.startswith("default-src 'none'")
    program = re.findall(r"<script>(.*?)</script>", page, re.S)[-1]
    assert policy.endswith(
        f"script-src 'sha256-{b64encode(sha256(program.encode()).digest()).decode()}'"
    )


def test_every_rung_is_in_it_with_what_each_effect_would_do(page, ladder):
    [text] = re.findall(r'<script type="application/json" id="given">(.*?)</script>', page, re.S)
    given = json.loads(text)
    assert given["scene"]["name"] == EVIL
    assert len(given["rungs"]) == len(ladder.steps) == 2
    for step, rung in zip(ladder.steps, given["rungs"], strict=True):
        assert rung["discovery"]["steps"][-1]["relative_rms"] == pytest.approx(step.relative_rms)
        assert set(rung["previews"]) == {row.effect for row in step.case.diagnosis.candidates}
    previews = given["rungs"][0]["previews"]
    assert previews["inertia"]["error"] == pytest.approx(ladder.steps[1].relative_rms, rel=0.05)
    assert given["excluded"] == []


@pytest.mark.soak
@pytest.mark.usefixtures("unpainted")
def test_only_the_first_step_and_the_last_are_unfolded():
    three = springpot.discover(measured(), "kelvin", accept=["inertia", "relaxation-mode"])
    found = re.findall(
        r"<details( open(?:=\"\")?)?><summary>Step (\d)", report_html(three, measured(), COMMAND)
    )
    assert [(bool(unfolded), number) for unfolded, number in found] == [
        (True, "0"),
        (False, "1"),
        (True, "2"),
    ]


def test_points_that_no_model_was_fitted_to_are_named(ladder):
    whole = measured()
    more = Measurement(
        np.append(2.0, whole.omega),
        np.append(9.0 + 1.0j, whole.stiffness),
        units=whole.units,
        name="one more",
    )
    assert excluded_rows(ladder, more) == [0]


def test_a_picture_holds_no_script_either(page):
    (picture,) = (each for each in pictures_in(page) if each != UNPAINTED)
    assert "<path" in picture
    assert "<script" not in picture
    assert picture.rstrip().endswith("</svg>")


@pytest.mark.soak
def test_pictures_hold_no_script_either(painted):
    pictures = pictures_in(painted)
    assert len(pictures) == 1 + 2 * (2 + 4 + 4)
    assert not [picture for picture in pictures if "<script" in picture]
    assert all(picture.rstrip().endswith("</svg>") for picture in pictures)


@pytest.mark.parametrize(
    "heading",
    [
        "Point at it",
        "The error, step by step",
        "Data and model",
        "Where the model fails",
        "Residual planes",
        "Other views",
        "Which effects could it be?",
        "What these data cannot tell apart",
        "What to measure next",
        "The model",
        "To repeat this",
    ],
)
def test_every_section_is_there(page, heading):
    assert tag("h2", heading) in page


def test_it_says_how_to_repeat_it(page, ladder):
    words = "".join(Page(page).words)
    assert measured().digest() in words
    assert springpot.__version__ in words
    assert "numpy" in words
    assert "springpot discover" in words
    assert "fractional-maxwell + inertia" in words
    for step in ladder.steps:
        assert percent(step.relative_rms) in words


@pytest.mark.soak
def test_the_same_result_gives_the_same_page(painted, ladder):
    assert report_html(ladder, measured(), COMMAND) == painted


@pytest.mark.soak
@pytest.mark.usefixtures("unpainted")
def test_sweeps_have_their_colours_named():
    data = measured((0.0, 20.0, 40.0), "three sweeps")
    page = report_html(
        springpot.discover(data, "fractional-maxwell", accept=["inertia"]), data, ["x"]
    )
    words = Page(page).words
    assert {"0 °C", "20 °C", "40 °C"} <= set(words)


@pytest.mark.soak
@pytest.mark.usefixtures("unpainted")
def test_with_nothing_accepted_there_is_one_column():
    data = measured(name="plain")
    page = report_html(springpot.discover(data, "fractional-maxwell", accept=[]), data, ["x"])
    assert "no effect was accepted" in page
    assert page.count("base64,") == 1 + 2 + 4 + 4


@pytest.mark.soak
@pytest.mark.usefixtures("unpainted")
def test_a_report_is_written_whole_or_refused(ladder, tmp_path):
    path = write_report(ladder, measured(), tmp_path / "a.html", COMMAND)
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
    with pytest.raises(OutputError, match=r"must end in \.html"):
        write_report(ladder, measured(), tmp_path / "a.pdf", COMMAND)
    with pytest.raises(OutputError, match="no folder"):
        write_report(ladder, measured(), tmp_path / "no" / "a.html", COMMAND)


def test_a_picture_of_many_steps_has_room_for_every_name(ladder):
    from dataclasses import replace

    from matplotlib.backends.backend_agg import FigureCanvasAgg

    long = [
        replace(ladder.steps[1], accepted=name)
        for name in ("specimen-inertia-fixed", "-inertia", "self-heating")
    ]
    figure = figure_ladder(replace(ladder, steps=(*ladder.steps, *long, *long)))
    FigureCanvasAgg(figure).draw()
    [axes] = figure.axes
    boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
    assert len(boxes) == 8
    for one, other in pairwise(boxes):
        # Slanted labels overlap as boxes; their anchors must not.
        assert other.x1 - one.x1 > 20
    assert min(box.y0 for box in boxes) >= 0


@pytest.mark.parametrize("text", ["<b>", "&", '"', "'", "</td>"])
def test_markup_escapes_text_once_and_html_never(text):
    assert html(html(text)) == html(text)
    element = Page(tag("p", text, title=text))
    assert (element.tags, element.words, element.attributes) == (
        ["p"],
        [text],
        [("p", "title", text)],
    )
    assert tag("p", Html("<b>x</b>")) == "<p><b>x</b></p>"
    assert joined([text, Html("<br>")]).endswith("<br>")


def test_table_cells_carry_their_headers():
    cells = table(("a", "<b>"), [("1", "2")], numbers=("<b>",))
    assert '<td class="number" data-label="&lt;b&gt;">2</td>' in cells
    assert '<td data-label="a">1</td>' in cells
