"""The grammar word for word, and the rules by which laws are weighed, each at its edge."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from lawful_data import AMPLITUDE, OMEGA, lossy, swept

import springpot
from springpot.errors import OptionError
from springpot.invention import inventing, result, search
from springpot.invention.search import shorter
from springpot.rheology import Points
from springpot.thresholds import EVIDENCE, INVENTION, SEARCH, VERDICT


@pytest.mark.parametrize("condition", ["amplitude", "temperature", "current"])
def test_laws_of_a_condition(condition, stays):
    texts = list(result._of(condition))
    stays(
        {
            "forms": {
                plane: result.forms_of(condition, plane) for plane in ("stiffness", "compliance")
            },
            "laws": {text: result.filled(text, condition, ["k"]) for text in texts},
        }
    )


def test_laws_of_the_frequency_alone(stays):
    stays({result.text_of(law): result.symbols(law) for law in result.candidates(swept(lossy), [])})


def test_a_law_is_tried_once_and_what_never_vanishes_is_none():
    texts = ["parallel: k", "parallel: k", "parallel: 1 + k", "series: 1/k"]
    found = result.laws(texts, swept(lossy))
    assert [result.text_of(law) for law in found] == ["parallel: k", "series: 1/k"]
    assert [law.name for law in found] == ["try-1c8e6225", "try-d83606c7"]


def test_a_law_may_go_with_what_was_varied():
    data = swept(lossy, conditions={"amplitude": AMPLITUDE, "current": 1.0 + AMPLITUDE[::-1]})
    both = inventing.varied(data)
    assert both == ["amplitude", "current"]
    assert inventing._conditions(data, None) == inventing.conditions_of(data)
    assert inventing._conditions(data, both[::-1]) == both
    assert inventing._conditions(data, both[:1]) == both[:1]
    assert inventing._conditions(data, []) == []
    with pytest.raises(OptionError, match="no law can go with 'humidity' of made"):
        inventing._conditions(data, ["humidity"])
    still = swept(lossy, conditions={"current": np.ones(len(OMEGA))})
    with pytest.raises(OptionError, match="there is none"):
        inventing._conditions(still, ["current"])


def law(text, name="one"):
    return springpot.law(text, name)


@pytest.mark.parametrize(
    ("text", "form", "product"),
    [
        ("parallel: i*k", "X^n", "parallel: i*k*X^n"),
        ("series: 1/k", "X^n", "series: X^n/k"),
        ("parallel: k", "1/(1 + (X/Xc)^n)", "parallel: k/(1 + (X/Xc)^n)"),
        ("chain: 1 + b*(X^n)", "T^m", "chain: 1 + b*(T^m*X^n)"),
        ("chain: exp(-i*omega*tau)", "X^n", ""),
        ("shift: 1 + b", "X^n", ""),
    ],
)
def test_a_law_times_a_form_of_a_further_condition(text, form, product):
    assert search._times(law(text), form) == product


def test_two_laws_are_one_with_the_second_s_size_in_that_of_the_first():
    first, second = law("parallel: k*X^n"), law("parallel: -k*X^(-n)", "two")
    text = search._joined(first, second)
    assert text == "parallel: k*X^n - k*r*X^(-n2)"
    assert search._joined(law("parallel: c*i*omega"), first) == "parallel: c*i*omega + c*r*X^n"
    model = springpot.parse_model("kelvin") + first + second
    start = np.array([1.0, 2.0, 5.0, 0.5, 20.0, 0.25])
    both = law(text, "both")
    values = dict(zip(model.names, start, strict=True))
    assert values["one.k"] == 5.0
    assert values["two.k"] == 20.0
    whole = springpot.parse_model("kelvin") + both
    carried = search._carried(search._Two(first, second, model, start, 1.0), whole, both)
    assert dict(zip(whole.names, carried, strict=True)) == {
        "k": 1.0, "c": 2.0, "both.k": 5.0, "both.n": 0.5, "both.r": 4.0, "both.n2": 0.25,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("first", "second", "pairs"),
    [
        ("parallel: k", "parallel: c*i*omega", 1),
        ("parallel: k", "series: 1/k", 0),
        ("chain: 1 + b", "chain: exp(i*p)", 0),
        ("series: 1/k", "series: 1/(c*i*omega)", 1),
    ],
)
def test_terms_of_one_plane_alone_are_added(first, second, pairs, monkeypatch):
    one, two = law(first), law(second, "two")
    model = springpot.parse_model("kelvin") + one + two
    both = search._Two(one, two, model, np.arange(1.0, 1.0 + len(model.names)), 1.0)
    fitted = []
    monkeypatch.setattr(search, "_after_the_best", lambda found, effects: [both])
    monkeypatch.setattr(search, "_together", lambda found: [both])
    monkeypatch.setattr(search, "enough_for", lambda base, grown: True)

    def refit(model, data, noise, seeds, starts, effort):
        fitted.append((len(seeds), starts))
        return SimpleNamespace(rss=1.0, theta=seeds[0])

    monkeypatch.setattr(search, "refit", refit)
    base = SimpleNamespace(
        model=springpot.parse_model("kelvin"), fit=SimpleNamespace(measurement=swept(lossy))
    )
    base.data = base.noise = None
    memory = search.Memory()
    monkeypatch.setattr(search, "effort_of", lambda found: None)
    paying = [True]
    monkeypatch.setattr(search, "pays", lambda best, effects, left: paying[0])
    alone = SimpleNamespace(base=base, grown=["the best"])
    found = list(search._with_terms(alone, [], memory))
    # Both starts of the same pair are those of one fit.
    assert fitted == [(2, 0)] * pairs
    assert len(found) == len(memory.fits) == pairs
    # Next time where it ended is a start as well, unless it is no rival by the data at hand.
    list(search._with_terms(alone, [], memory))
    assert fitted == [(2, 0), (3, 0)] * pairs
    far = search.Memory(memory.fits, behind=frozenset(memory.fits))
    assert list(search._with_terms(alone, [], far)) == []
    paying[0] = False
    assert list(search._with_terms(alone, [], search.Memory())) == []
    paying[0] = True
    monkeypatch.setattr(search, "enough_for", lambda base, grown: False)
    assert list(search._with_terms(alone, [], search.Memory())) == []


def grown(likelihood, name="one", **more):
    """A fitted law of this log-likelihood."""
    refit = SimpleNamespace(log_likelihood=likelihood, **more)
    return SimpleNamespace(refit=refit, effects=(SimpleNamespace(name=name),))


def told(*weights, **more):
    return [
        result.Weighed(grown(weight, str(i), **more), weight, 0.5)
        for i, weight in enumerate(weights)
    ]


@pytest.fixture
def apart(monkeypatch):
    """Laws that are all unlike, nothing being as likely as 0."""
    monkeypatch.setattr(result, "_is_same", lambda law, other: False)
    monkeypatch.setattr(result, "nothing", lambda found: 0.0)
    monkeypatch.setattr(result, "is_arithmetic", lambda fitted: fitted.exact)


CLEAR = EVIDENCE.as_good + 1.0
FAR = CLEAR - EVIDENCE.rivals


@pytest.mark.parametrize(
    ("weights", "alarm", "left", "exact", "verdict"),
    [
        ([], 0.0, 1.0, False, "none"),
        ([CLEAR], 0.0, 1.0, False, "law"),
        ([CLEAR], INVENTION.alarm, 1.0, False, "none"),
        ([EVIDENCE.as_good], 0.0, 1.0, False, "none"),
        ([CLEAR], 0.0, VERDICT.structure_alarm, False, "law"),
        ([CLEAR], 0.0, 0.99 * VERDICT.structure_alarm, False, "none"),
        ([CLEAR], 0.0, 0.0, True, "law"),
        ([EVIDENCE.as_good], 0.0, 0.0, True, "none"),
        ([CLEAR, FAR], 0.0, 1.0, False, "law"),
        ([CLEAR, FAR + 0.1], 0.0, 1.0, False, "class"),
    ],
)
@pytest.mark.usefixtures("apart")
def test_a_law_is_found_where_noise_goes_not_as_far_and_nothing_is_left(
    weights, alarm, left, exact, verdict
):
    found = SimpleNamespace(alarm=alarm, left=SimpleNamespace(p_value=left))
    assert result.verdict_of(found, told(*weights, exact=exact)) == verdict


def test_the_class_holds_each_curve_once(monkeypatch):
    laws = told(5.0, 4.0, 3.0, 5.0 - EVIDENCE.rivals)
    monkeypatch.setattr(result, "_is_same", lambda law, other: law is laws[2] and other is laws[1])
    monkeypatch.setattr(result, "symbols", lambda effect: 7)
    assert result.rivals_of(laws) == laws[:2]
    # Of laws that have become one the shortest stands for all, with the weight of the likeliest.
    monkeypatch.setattr(result, "symbols", lambda effect: 6 if effect is laws[2].effect else 7)
    first, second = result.rivals_of(laws)
    assert (first, second.effect, second.log_weight) == (laws[0], laws[2].effect, 4.0)
    frames = SimpleNamespace(frame=lambda: "frame")
    for apart, same in ((0.9, True), (1.0, False), (1.1, False)):
        monkeypatch.undo()
        monkeypatch.setattr(result, "distance", lambda *given, far=apart: far * INVENTION.same)
        laws = told(1.0, 0.9)
        object.__setattr__(laws[0].grown, "refit", frames)
        assert result._is_same(laws[1], laws[0]) == same


def test_only_a_law_near_the_data_is_weighed():
    found = SimpleNamespace(best=SimpleNamespace(log_likelihood=10.0))
    edge = 10.0 - INVENTION.hopeless
    assert not result._is_rival(found, grown(edge))
    assert result._is_rival(found, grown(edge + 1e-6))


def test_laws_are_weighed_by_their_evidence_and_their_length(monkeypatch):
    monkeypatch.setattr(result, "symbols", lambda effect: {"a": 3, "b": 5}[effect.name])
    monkeypatch.setattr(result, "marginal", lambda found, each: each.refit.log_likelihood)
    monkeypatch.setattr(result, "log_prior_of_one", lambda share: np.log(share) - 7.0)
    monkeypatch.setattr(result, "is_arithmetic", lambda fitted: fitted.exact)
    best = SimpleNamespace(log_likelihood=4.0)
    rows = [
        grown(4.0, "b", exact=False),
        grown(4.0, "a", exact=False),
        grown(3.9, "a", exact=False),
    ]
    first, second = result.weighed(SimpleNamespace(best=best, grown=rows))
    assert [first.effect.name, second.effect.name] == ["a", "b"]
    price = INVENTION.symbol
    assert first.log_weight == pytest.approx(4.0 - 7.0 - 3 * price)
    assert first.probability == pytest.approx(1.0 / (1.0 + np.exp(-2.0 * price)))
    assert second.probability == pytest.approx(1.0 - first.probability)
    # Where one is exact, only exact ones count, whatever their likelihood.
    rows = [grown(1.0, "b", exact=True), grown(4.0, "a", exact=False)]
    [only] = result.weighed(SimpleNamespace(best=best, grown=rows))
    assert (only.effect.name, only.probability) == ("b", 1.0)
    assert only.log_weight == pytest.approx(4.0 - 7.0 - 5 * price)
    assert result.weighed(SimpleNamespace(best=best, grown=[])) == []


def test_named_effects_are_alike_that_come_as_near(monkeypatch):
    level = 10.0 - EVIDENCE.rivals
    likelihoods = [level, level + 0.1, 11.0, level - 1.0]
    scores = SimpleNamespace(scores=likelihoods)
    monkeypatch.setattr(result, "possible", lambda base, library: library)
    monkeypatch.setattr(result, "scan_effects", lambda *given: scores)
    efforts = []
    monkeypatch.setattr(
        result, "grown_with", lambda found, score, effort: efforts.append(effort) or grown(score)
    )
    monkeypatch.setattr(result, "applicable", lambda library, measurement: library)
    base = SimpleNamespace(fit=SimpleNamespace(measurement=None))
    [law] = told(10.0, rss=50.0)
    found = result.known_alike(SimpleNamespace(base=base, frame=0), law, [])
    assert [each.refit.log_likelihood for each in found] == [11.0, level + 0.1]
    # What is no rival of the law ends early.
    assert {each.hopeless for each in efforts} == {50.0 + 2.0 * INVENTION.hopeless}


def test_nothing_is_as_likely_as_its_prior(monkeypatch):
    monkeypatch.setattr(result, "harmonic_evidence", lambda base: 2.0)
    found = SimpleNamespace(base=SimpleNamespace(log_likelihood=3.0))
    assert result.nothing(found) == pytest.approx(5.0 + np.log(EVIDENCE.prior_nothing))


def row(text="parallel: k", error=0.01, alike=3):
    return SimpleNamespace(text=text, error_after=error, alike=("x",) * alike)


def test_what_is_said_of_a_search(stays):
    base = SimpleNamespace(error=0.05, floor=0.01)
    far = SimpleNamespace(base=base, alarm=INVENTION.alarm)
    near = SimpleNamespace(base=base, alarm=0.99 * INVENTION.alarm)
    stays(
        [
            inventing._says(far, "none", [row()]),
            inventing._says(near, "none", []),
            inventing._says(near, "none", [row()]),
            inventing._says(near, "law", [row()]),
            inventing._says(near, "class", [row()]),
        ]
    )
    assert inventing._next("law", []) is None
    assert inventing._next("none", []) is None


@pytest.mark.parametrize("model", ["material", "kelvin"])
@pytest.mark.parametrize("named", [[], ["amplitude"]])
def test_what_a_sweep_of_the_frequency_alone_cannot_tell(model, named, stays):
    moved = {"amplitude": 1.0 / OMEGA}
    stays(
        [
            list(inventing._notes(data, springpot.parse_model(model), named))
            for data in (swept(lossy), swept(lossy, conditions=moved))
        ]
    )


def test_a_fit_that_gives_no_numbers_is_none():
    at = swept(lossy)

    def fitted(theta):
        return SimpleNamespace(
            refit=SimpleNamespace(
                model=springpot.parse_model("maxwell"),
                theta=np.array(theta),
                fit=SimpleNamespace(measurement=at),
            )
        )

    assert search._has_numbers(fitted([1.0, 2.0]))
    assert not search._has_numbers(fitted([np.nan, 2.0]))
    assert not search._has_numbers(fitted([0.0, 0.0]))


@pytest.mark.parametrize(
    ("alarm", "left", "exact", "goes_on"),
    [
        (0.0, 0.0, False, True),
        (SEARCH.look_further, 0.0, False, False),
        (0.0, SEARCH.left_over, False, False),
        (0.0, 0.0, True, False),
    ],
)
def test_a_search_goes_on_while_something_is_left(monkeypatch, alarm, left, exact, goes_on):
    asked = []

    class Found(SimpleNamespace):
        def __init__(self, base, frame, scan, structure):
            super().__init__(base=base, frame=frame, scan=scan, structure=structure)
            self.alarm, self.grown, self.best = alarm, [], base

    one = np.ones(1)
    base = SimpleNamespace(
        frame=lambda: "frame",
        data=SimpleNamespace(mean=SimpleNamespace(stiffness=one)),
        noise=SimpleNamespace(weights=one),
    )
    monkeypatch.setattr(search, "replace", lambda found, **new: vars(found).update(new) or found)
    scan = SimpleNamespace(scores=list(range(100)))
    monkeypatch.setattr(search, "Search", Found)
    monkeypatch.setattr(search, "possible", lambda base, library: [])
    monkeypatch.setattr(search, "scan_effects", lambda *given: scan)
    monkeypatch.setattr(search, "battery", lambda *given: SimpleNamespace(p_value=left))
    monkeypatch.setattr(search, "_with_score", lambda found, score, memory: [score])
    monkeypatch.setattr(search, "_promising", lambda scan, base, count: scan.scores[:count])
    monkeypatch.setattr(search, "_shortened", lambda *given: ["d"])
    monkeypatch.setattr(search, "_sort", lambda found: asked.append(len(found.grown)))
    monkeypatch.setattr(search, "is_arithmetic", lambda fitted: exact)
    monkeypatch.setattr(search, "_with_conditions", lambda *given: ["a"])
    monkeypatch.setattr(search, "_with_terms", lambda *given: ["b", "c"])
    memory = search.Memory()
    search._of_any(memory, base, [], None)
    fitted = INVENTION.refined
    assert asked == [fitted] * (alarm == 0.0) + [fitted + 3, fitted + 4] * goes_on
    # Of the same data in the same noise it is not sought twice.
    asked.clear()
    search._of_one_term(memory, base, [], None)
    assert asked == []


@pytest.mark.parametrize("set_aside", [(), ("row 7",)])
@pytest.mark.parametrize(("left", "better"), [(1.0, 0.0), (0.0, 9.9), (0.0, 10.1)])
def test_what_a_single_law_settles_is_asked_again_where_a_longer_one_explains_far_more(
    left, better, set_aside, monkeypatch
):
    asked = []

    def found(evidence):
        best = SimpleNamespace(log_evidence=evidence)
        return SimpleNamespace(best=best, grown=["law"], left=SimpleNamespace(p_value=left))

    alone, further, again = found(100.0), found(100.0 + better), found(200.0)

    def search_data(data, model, library, rng, seek, begun=None):
        asked.append((seek.func, begun))
        return (again if len(asked) > 1 else alone), list(set_aside)

    monkeypatch.setattr(search, "search_data", search_data)
    monkeypatch.setattr(search, "_grown_further", lambda memory, begun, library, rng: further)
    monkeypatch.setattr(search, "is_arithmetic", lambda fitted: False)
    answer = search.search_laws(None, None, [], None)
    first = (search._of_one_term, None)
    if better <= SEARCH.decisive:
        assert answer is (further if left < SEARCH.left_over else alone)
        assert asked == [first]
    else:
        # Rows that a single law sets aside are no longer set aside.
        assert answer is again
        assert asked == [first, (search._of_any, None if set_aside else further)]


@pytest.mark.parametrize(("share", "behind"), [(0.9, False), (1.1, True), (np.nan, False)])
def test_a_law_far_behind_on_nearly_the_same_data_is_not_fitted_again(share, behind):
    data = swept(lossy)

    def fitted(factor):
        model = SimpleNamespace(stiffness=lambda theta, points: factor * data.stiffness)
        return SimpleNamespace(model=model, theta=None)

    # A hundredth of |K| is a deviation of the noise; twice the log-likelihood goes with its square.
    factor = 1.0 + 0.01 * np.sqrt(share * 2.0 * INVENTION.hopeless / len(data))
    weights = (1.0 + 1.0j) / (0.01 * data.magnitude)
    base = SimpleNamespace(
        data=SimpleNamespace(mean=data), noise=SimpleNamespace(weights=weights, turn=None)
    )
    memory = search.Memory({"near": fitted(1.0), "other": fitted(factor)})
    assert memory.beside(base).behind == ({"other"} if behind else set())
    assert search.Memory().beside(base).behind == set()


def scored(text, predicted):
    """A score of a law that should leave so much."""
    return SimpleNamespace(
        influence=SimpleNamespace(effect=law(text)), predicted=predicted, text=text
    )


def test_of_laws_that_explain_the_same_the_shorter_is_tried():
    short, long = scored("parallel: k", 20.0), scored("parallel: k*X^n", 20.0)
    fitted = SimpleNamespace(rss=100.0)
    rows = [long, short]
    assert search._promising(SimpleNamespace(scores=rows), fitted, 2) == [short, long]
    assert search._promising(SimpleNamespace(scores=rows), fitted, 1) == [short]
    # Its further parameter and symbols are paid by what it leaves less.
    more = result.symbols(law("parallel: k*X^n")) - result.symbols(law("parallel: k"))
    price = np.log1p(80.0) + 2.0 * INVENTION.symbol * more
    for less, first in ((price + 1.0, True), (price - 1.0, False)):
        near = scored("parallel: k*X^n", 20.0 - less)
        paid = 2.0 * (np.log1p(80.0 + less) - np.log1p(80.0))
        ordered = search._promising(SimpleNamespace(scores=[short, near]), fitted, 2)
        assert paid < 1.0
        assert (ordered[0] is near) == first


def test_a_kind_of_law_is_tried_once_whatever_the_form_of_its_condition():
    texts = ("parallel: k*X^n", "parallel: k/(1 + (X/Xc)^n)", "parallel: -k*X^n", "series: X^n/k",
             "parallel: i*k*X^n", "parallel: c*i*omega*X^n", "parallel: k*X^(-n)")  # fmt: skip
    rows = [SimpleNamespace(effects=(law(text),)) for text in texts]
    found = search._of_each_kind(SimpleNamespace(grown=rows))
    kept = [row for i, row in enumerate(rows) if i not in (1, 6)]
    assert found == kept[: INVENTION.extended]


@pytest.mark.parametrize("sign", ["+", "-"])
@pytest.mark.parametrize("size", ["", "-"])
@pytest.mark.parametrize("place", [0, 1])
def test_a_term_with_a_loss_is_what_it_is_without_and_the_loss_alone(sign, size, place):
    whole = f"{size}{{}}*(1 {sign} i*h)*X^n"
    text = f"parallel: {whole.format('k')}"
    if place:
        text = f"parallel: i*k*X^2 {size or '+'} k*r*(1 {sign} i*h)*X^n"
    values = {"k": 3.0, "h": 0.4, "n": 0.7} | ({"r": 2.0} if place else {})
    at = Points.at(np.ones(3), amplitude=np.array([0.5, 1.0, 2.0]))

    def response(text, values):
        element = springpot.law(text).element
        theta = np.array([values[each.name] for each in element.parameters])
        return element.respond(theta, at).value

    bare, alone = (response(*each) for each in shorter(springpot.law(text), values))
    twice = response("parallel: i*k*X^2", values) if place else 0.0
    assert bare + alone - twice == pytest.approx(response(text, values))
    # The one without a loss, the other with nothing else.
    assert (bare - twice).imag == pytest.approx(0.0)
    assert (alone - twice).real == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("form", "power"),
    [
        ("*(1 + (X/m)^n)", "*X^n"),
        ("/(1 + (X/m)^n)", "*X^(-n)"),
        ("*(X/m)^n/(1 + (X/m)^n)", "*X^n"),
    ],
)
def test_of_what_saturates_or_grows_from_a_constant_the_power_is_tried_alone(form, power):
    text = f"parallel: i*k{form}"
    (found,) = shorter(springpot.law(text), {"k": 3.0, "m": 2.0, "n": 0.7})
    assert springpot.law(found[0]).name == springpot.law(f"parallel: i*k{power}").name, found
