"""Whatever a person does while the page reads or computes is kept.

Each test holds an answer back for as long.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import pytest
from browsing import IN_A_BROWSER, Open, Page, playwright

from springpot.web import Workbench
from springpot.web.desk import DeskWorker

pytestmark = IN_A_BROWSER

MODEL = "fractional-maxwell"
GROWN = f"{MODEL} + inertia"
BAD = b"hello\nworld\n"


@pytest.fixture
def judged(page: Open, damper: bytes) -> Page:
    """The README's file with the README's model.

    The server has the answer from the first test that asked for it.
    """
    here: Page = page()
    here.name(MODEL)
    here.drop("damper.csv", damper)
    here.shows(MODEL)
    return here


def models_asked(here: Page) -> list[str]:
    """The models whose answers the page asks for from now on."""
    found: list[str] = []

    def heard(request: Any) -> None:
        if request.url.endswith("/api/answer"):
            found.append(request.post_data_json["state"]["model"])

    here.page.on("request", heard)
    return found


@pytest.mark.soak_cases("False")
@pytest.mark.parametrize("dropped_first", [True, False])
def test_a_model_that_is_named_before_its_data_are_read_is_judged(
    page: Open, damper: bytes, dropped_first: bool
):
    here = page()
    asked = models_asked(here)
    with here.held("data"):
        if dropped_first:
            here.drop("damper.csv", damper)
        here.name(MODEL)
        assert here.reads("#expression-says") == f"{MODEL} is judged as soon as there are data."
        here.page.locator("#verdict").focus()
        if not dropped_first:
            here.drop("damper.csv", damper)
        assert here.page.input_value("#expression") == MODEL
    here.shows(MODEL)
    assert asked == [MODEL], "and nobody waited for another"


@pytest.mark.soak
def test_a_model_that_is_named_during_the_first_answer_takes_its_place(page: Open, damper: bytes):
    here = page()
    with here.held("answer"):
        here.drop("damper.csv", damper)
        here.page.locator("#facts").wait_for()
        here.name(MODEL)
    here.shows(MODEL)
    assert here.page.locator("#redo").get_attribute("title") == "there is nothing to redo"


CAUSES = """() => {
    window.soFar = [];
    new MutationObserver(() => {
        const tried = document.querySelectorAll("[data-title='Tried so far'] [role=option]");
        if (tried.length) window.soFar.push([...tried].map((option) => option.textContent));
    }).observe(document.getElementById("effects"), { childList: true });
}"""


@pytest.mark.soak
def test_a_first_look_is_there_while_causes_are_sought(page: Open, damper: bytes):
    here = page()
    here.name("fractional-maxwell")
    with here.held("answer"):
        here.drop("damper.csv", damper.replace(b"73.2", b"73.3"))  # not answered yet
        here.page.locator("#number:has-text('the noise floor')").wait_for()
        assert "is being sought" in here.reads("#verdict")
        assert "too high above" in here.reads("#fails")
        assert here.page.locator("#plot-view .line.model").count() == 2
        assert here.page.locator("#effects [role=option]").count() == 0
        here.page.evaluate(CAUSES)
    here.page.locator("#effects [data-title='Explains it']").wait_for()
    assert "effect-missing" in here.reads("#verdict")
    assert here.page.locator("[data-title='Tried so far']").count() == 0
    so_far = here.page.evaluate("() => window.soFar")
    assert len(so_far[-1]) > 3
    assert "m = 0.59" in " ".join(so_far[-1])


@pytest.mark.soak
def test_five_who_use_one_server_hear_their_place_and_share_what_is_the_same(
    page: Open, bench: Workbench, damper: bytes, monkeypatch: pytest.MonkeyPatch
):
    performed = []
    perform = DeskWorker.perform

    def counted(worker: DeskWorker, task: str, *given: Any) -> Any:
        performed.append(task)
        return perform(worker, task, *given)

    monkeypatch.setattr(DeskWorker, "perform", counted)
    desk, mine = bench._desk, damper.replace(b"73.2", b"74.1")
    pages = [page() for _ in range(5)]
    contents = [mine] * 4 + [damper.replace(b"73.2", b"72.7")]
    with ExitStack() as kept:
        for here, content in zip(pages, contents, strict=True):
            kept.enter_context(here.held("answer"))
            here.name(MODEL)
            here.drop("damper.csv", content)
            here.page.locator("#facts").wait_for()
        free = desk._free["long"]
        others = [free.get_nowait() for _ in range(free.qsize())]  # what others use
    for here in pages:
        here.page.locator("#stage:has-text('of 2 in the queue')").wait_for()
    places = [here.reads("#stage").partition("place ")[2][0] for here in pages]
    assert sorted({*places[:4], places[4]}) == ["1", "2"]
    assert len(set(places[:4])) == 1
    loop = next(iter(desk._running.values())).work.get_loop()
    for worker in others:
        loop.call_soon_threadsafe(free.put_nowait, worker)
    for here in pages:
        here.shows(MODEL)
    assert performed.count("answer") == 2
    errors = [here.error() for here in pages]
    assert len(set(errors[:4])) == 1


@pytest.mark.soak
def test_what_is_typed_stays_while_an_answer_arrives(page: Open, damper: bytes):
    here = page()
    here.name(MODEL)
    with here.held("answer"):
        here.drop("damper.csv", damper)
        here.page.locator("#facts").wait_for()
        here.page.fill("#expression", "zen")
        here.page.locator("#undo").focus()
    here.shows(MODEL)
    assert here.page.input_value("#expression") == "zen"


@pytest.mark.soak
def test_a_step_on_the_data_that_are_open_ends_no_reading(judged: Page, damper: bytes):
    here = judged
    with here.held("data"):
        here.drop("other.csv", damper.replace(b"73.2", b"73.9"))
        here.page.click("text=Open instead")
        here.page.click("#effect-inertia")
        here.name("kelvin")
    here.shows("kelvin")
    assert here.reads("#data-name") == "other"
    assert here.page.locator("#rungs li").count() == 1


@pytest.mark.soak
def test_a_file_that_is_refused_ends_no_answer(judged: Page):
    here = judged
    with here.held("answer"):
        here.page.click("#effect-inertia")
        here.drop("bad.csv", BAD)
        here.page.click("text=Open instead")
        here.page.locator("#refused").wait_for()
    here.shows(GROWN)
    assert here.reads("#refused").startswith("bad.csv: ")


@pytest.mark.soak
def test_another_view_ends_no_answer(judged: Page):
    here = judged
    with here.held("answer"):
        here.page.click("#effect-inertia")
        here.page.select_option("#view", "cole-cole")
    here.shows(GROWN)
    assert here.page.input_value("#view") == "cole-cole"
    # One sweep has nothing to be shifted by.
    assert here.page.locator("#view [value=master-curve]").is_disabled()


def test_a_second_click_accepts_nothing_twice_and_undo_takes_it_back(judged: Page):
    here = judged
    before = here.reads("#verdict")
    with here.held("answer"):
        here.page.dblclick("#effect-inertia")
        assert (
            here.page.locator("#accept").get_attribute("title")
            == "wait for the computation, or cancel it"
        )
        here.page.click("#undo")
        here.done()
        assert here.reads("#verdict") == before
        here.page.click("#redo")
    here.shows(GROWN)
    assert here.page.locator("#redo").get_attribute("title") == "there is nothing to redo"


def test_a_curve_of_the_model_before_is_not_drawn_over_the_next(judged: Page):
    here = judged
    with here.page.expect_response("**/api/curve"), here.held("curve"):
        here.page.locator("[aria-label='move k']").focus()
        here.page.keyboard.press("ArrowRight")
        here.page.click("#effect-inertia")
        here.shows(GROWN)
    assert here.page.locator("#plot-view .line.edited").count() == 0


@pytest.mark.soak
def test_the_file_that_was_dropped_last_is_open_however_slowly_the_first_was_read(
    page: Open, damper: bytes
):
    here = page()
    here.page.evaluate("""() => {
            const read = File.prototype.arrayBuffer;
            File.prototype.arrayBuffer = async function () {
                if (this.name === "slow.csv") await new Promise((go) => { window.go = go; });
                return read.call(this);
            };
        }""")
    here.name(MODEL)
    here.drop("slow.csv", damper.replace(b"73.2", b"73.9"))
    here.drop("damper.csv", damper)
    here.shows(MODEL)
    here.page.evaluate("() => window.go()")
    here.done()
    assert here.reads("#data-name") == "damper"


def test_answers_to_a_question_are_not_asked_for_again_by_an_answer_that_arrives(judged: Page):
    here = judged
    rows = b"".join(b"%d,%d,%d\n" % (i, 9 + i, i) for i in range(1, 9))
    with here.held("answer"):
        here.page.click("#effect-inertia")
        here.drop("mine.csv", b"frequency [Hz],storage,loss\n" + rows)
        here.page.click("text=Open instead")
        here.page.select_option("#asked-0", label="kPa")
    here.shows(GROWN)
    assert (
        here.page.locator("#asked-0").evaluate("choice => choice.selectedOptions[0].label") == "kPa"
    )


@pytest.mark.soak
def test_a_state_without_an_answer_says_why_even_after_another_message(page: Open, damper: bytes):
    here = page()
    here.name("kelvn")
    here.drop("damper.csv", damper)
    refused = here.page.locator("#refused")
    playwright.expect(refused).to_contain_text("did you mean kelvin")
    here.drop("mine.csv", b"frequency [Hz],storage,loss\n" + damper.partition(b"\n")[2])
    here.page.click("text=Open instead")
    here.page.locator("#question").wait_for()
    here.done()
    playwright.expect(refused).to_contain_text("did you mean kelvin")
    here.judge(MODEL)
    assert refused.is_hidden()


@pytest.mark.soak
def test_a_first_answer_that_was_cancelled_is_begun_again(page: Open, damper: bytes):
    here = page()
    here.name(MODEL)
    with here.held("answer"):
        here.drop("damper.csv", damper)
        here.page.locator("#facts").wait_for()
        here.page.click("#cancel")
    here.done()
    assert "'Judge this model' begins it again" in here.reads("#refused")
    here.page.click("#judge")
    here.shows(MODEL)


@pytest.mark.soak
def test_a_plan_is_offered_until_the_accepted_effect_is_told_from_its_twin(judged: Page):
    here = judged
    here.page.click("#leave")
    plan = here.page.locator('[data-leave="plan"]')
    assert plan.get_attribute("aria-disabled") == "false"
    here.page.keyboard.press("Escape")
    here.page.click("#effect-inertia")
    here.shows(GROWN)
    here.page.click("#leave")
    # The mass may be the specimen's own: that is still to be told apart.
    assert plan.get_attribute("aria-disabled") == "false"
    assert here.violations() == []
