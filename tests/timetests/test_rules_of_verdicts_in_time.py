"""Chances, candidates and facts of a diagnosis in time, with values by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.diagnosis.evidence import unknown_odds
from springpot.diagnosis.in_practice import Misfit
from springpot.diagnosis.result import leaving_out_the_beginning
from springpot.diagnosis.verdict import rule_for
from springpot.measurement import TimeTest
from springpot.misfit.residual_scatter import ResidualScatter
from springpot.misfit.residuals_of_tests import SweepPart, parts_of_specimen
from springpot.registry import plugins
from springpot.thresholds import EVIDENCE, VERDICT
from springpot.timetests import diagnosis, exponentials, hypotheses as trying, verdict


def tried(name="friction", evidence=0.0, delta=0.0, helps=False, prior=1.0, fit=None, left=None):
    effect = SimpleNamespace(name=name, prior=prior, summary="what it is")
    return SimpleNamespace(
        effect=effect, evidence=evidence, delta=delta, helps=helps, fit=fit, left=left
    )


def promised(*priors):
    return {
        str(i): [SimpleNamespace(effect=SimpleNamespace(prior=prior))]
        for i, prior in enumerate(priors)
    }


def test_chances_are_priors_times_what_the_evidence_is_worth():
    each = [tried(evidence=6.0), tried(evidence=-2.0)]
    slip = 3.0
    nothing, first, second, unnamed = verdict._weights(each, promised(1.0, 2.0, 1.0), slip)
    assert nothing + first + second + unnamed == pytest.approx(1.0)
    something = 1.0 - EVIDENCE.prior_nothing
    assert first / nothing == pytest.approx(np.exp(3.0) * something / 4.0 / EVIDENCE.prior_nothing)
    assert first / second == pytest.approx(np.exp(4.0))
    assert unnamed / nothing == pytest.approx(
        np.exp(1.5) * something / 4.0 * EVIDENCE.apparatus / EVIDENCE.prior_nothing
    )


def test_beside_a_narrow_effect_others_as_narrow_keep_their_share():
    """Four points that were off in one of several tests were a resonance, for certain."""
    each = [SimpleNamespace(effect=SimpleNamespace(narrow=narrow)) for narrow in (True, False)]
    told = verdict._beside_narrow([0.1, 0.5, 0.3, 0.1], each)
    other = 0.5 * EVIDENCE.other_shape
    assert told == pytest.approx([0.1, 0.5 - other, 0.3, 0.1 + other])


def test_what_is_unexplained_is_as_unknown_as_its_chance_of_noise_says():
    weights, chance = [0.3, 0.5, 0.2], 1e-4
    odds = unknown_odds(chance)
    assert odds / (1.0 + odds) > 0.2
    nothing, first, unknown = verdict._posterior(weights, "unexplained", chance)
    assert unknown == pytest.approx(odds / (1.0 + odds))
    assert first / nothing == pytest.approx(5.0 / 3.0)
    assert nothing + first + unknown == pytest.approx(1.0)
    # Already as unknown as that, or not at all unexplained: as the evidence has it.
    assert verdict._posterior([0.0, 1e-9, 1.0 - 1e-9], "unexplained", 0.9)[-1] > 0.99
    assert verdict._posterior(weights, "cannot-tell", chance) == pytest.approx(weights)


def noise_of(size, memory=0.0):
    return ResidualScatter(size, memory, excess=0.0, local=1.0)


def error(relative_rms=0.02, over_floor=1.5):
    return SimpleNamespace(relative_rms=relative_rms, over_floor=over_floor)


def test_one_effect_alone_is_missing_for_certain():
    pair = [tried("friction"), tried("inertia")]
    for says, alike, first in (
        ("effect-missing", ["friction"], "missing"),
        ("effect-missing", ["friction", "inertia"], "cannot-tell"),
        ("cannot-tell", ["friction"], "cannot-tell"),
    ):
        rows = verdict._candidates(pair, [0.7, 0.2], alike, [error(), error()], says, error())
        assert rows[0].verdict == first
        assert [row.probability for row in rows] == [0.7, 0.2]
    assert rows[1].verdict == "absent"
    assert rows[0].alike == ("friction",)


@pytest.mark.parametrize(
    ("delta", "told"), [(VERDICT.clear_evidence, "absent"), (50.0, "cannot-tell")]
)
def test_an_effect_for_which_something_speaks_is_not_absent(delta, told):
    assert verdict._open(tried("inertia", delta=delta), ["friction"]) == told


def test_what_was_fitted_has_parameters_and_its_error_and_else_it_is_foretold():
    values = {"k": 1.0, "friction.F": 2.0, "friction#2.F": 3.0, "inertia.m": 4.0}
    fit = SimpleNamespace(parameters=values)
    known = tried(fit=fit, delta=9.0)
    known.effect = plugins().effect("friction")
    found = verdict._candidate(known, 0.4, ["friction"], error())
    assert found.parameters == {"F": 3.0}
    assert (found.error_after, found.over_floor, found.delta_bic) == (0.02, 1.5, 9.0)
    assert np.isnan(found.predicted_error)
    foretold = verdict._candidate(tried(), 0.4, ["friction", "inertia"], error())
    assert (foretold.predicted_error, foretold.parameters) == (0.02, {})
    assert np.isnan(foretold.error_after)
    assert foretold.alike == ("friction", "inertia")


def test_facts_are_the_gain_of_the_best_and_what_is_beyond_doubt():
    before = SimpleNamespace(misfit=True, doubtful=False)
    none = verdict.facts_of(before, [], False)
    assert (none.gain, none.something, none.ruled_out, none.by_battery) == (0.0, False, False, True)
    for missed in (True, False):
        left = SimpleNamespace(misfit=missed)
        clear = VERDICT.clear_evidence + 1.0
        best = tried(evidence=clear, delta=clear, helps=True, left=left)
        told = verdict.facts_of(before, [best, tried(delta=99.0)], False)
        assert told.gain == best.delta
        assert (told.something, told.ruled_out, told.named, told.left) == (True, True, True, missed)
    unknown = verdict.facts_of(before, [tried()], True)
    assert (unknown.ruled_out, unknown.named, unknown.left) == (True, False, False)


def joined(alone, count=40, tests=2):
    """An effect beside which tests are at the noise, and each by itself at so much of it."""
    rows = [SimpleNamespace(over_floor=1.0, over_floor_alone=alone) for _ in range(tests)]
    noise = ResidualScatter(1.0, 0.0, 0.0, 0.5)
    left = SimpleNamespace(
        misfit=False, scatters=(noise,) * tests, residuals=(np.ones(count),) * tests
    )
    return tried(
        helps=True, fit=SimpleNamespace(tests=rows, theta=np.ones(5)), left=left, delta=99.0
    )


def test_what_each_test_by_itself_is_followed_better_by_is_not_all_that_is_missing():
    """A clamp's delay beside a gain: its force channel's resonance took both, for certain."""
    before = SimpleNamespace(misfit=True, doubtful=True)
    assert verdict.facts_of(before, [joined(0.7)], False).left
    # Five parameters more follow that much of what is noise.
    assert not verdict.facts_of(before, [joined(0.95)], False).left
    assert not trying.chow_rejects(joined(0.7, tests=1))
    assert not trying.chow_rejects(joined(0.7, count=5))


def test_a_fault_of_the_apparatus_casts_no_doubt_by_what_a_specimen_would_need():
    before = SimpleNamespace(misfit=False, doubtful=False)
    clear = VERDICT.clear_evidence + 1.0
    dear = clear + 2.0 * float(np.log(EVIDENCE.apparatus))
    told = {
        odds: verdict.facts_of(before, [tried("drift", odds, clear)], False)
        for odds in (clear, dear)
    }
    assert told[clear].something
    assert not told[dear].something
    assert rule_for(told[clear]).verdict == "inconclusive"
    assert rule_for(told[dear]).verdict == "adequate"


BY_ITSELF = "nothing is missing that these tests could show"
UNKNOWN = "no known effect explains it: something is missing that is not in the library"


def candidate(delta=50.0, alike=("friction",), over_floor=1.1, lowers=True):
    return SimpleNamespace(
        effect=alike[0],
        delta_bic=delta,
        alike=alike,
        over_floor=over_floor,
        lowers=lambda _: lowers,
    )


@pytest.mark.parametrize(
    ("says", "candidates", "more", "told"),
    [
        ("adequate", [candidate()], {}, f", which so few samples leave to chance: {BY_ITSELF}"),
        ("inconclusive", [], {}, ": what is left is hardly noise alone, which may be chance;"
         " measure longer or repeat it"),
        ("inconclusive", [candidate(1.0)], {}, ": what is left is hardly noise alone, which may be"
         " chance; measure longer or repeat it"),
        ("inconclusive", [candidate()], {}, ": friction would help a little, which may be chance;"
         " measure longer or repeat it"),
        ("unexplained", [], {}, f", and {UNKNOWN}"),
        ("unexplained", [candidate(1.0)], {}, f", and {UNKNOWN}"),
        ("effect-missing", [candidate(1.0)], {}, f", and {UNKNOWN}"),
        ("unexplained", [candidate(lowers=False)], {}, f", and {UNKNOWN}"),
        ("unexplained", [], {"apart": "apart"}, "; apart"),
        ("unexplained", [candidate()], {}, ", and no single known effect explains it:"
         " friction helps (1.1 x with it), but a pattern is left"),
        ("unexplained", [candidate(over_floor=1.4)], {}, ", and no single known effect explains it:"
         " friction helps (1.4 x with it) but is not all"),
        ("unexplained", [candidate()], {"apart": "apart"},
         "; apart; friction helps (1.1 x with it), but a pattern is left"),
        ("effect-missing", [candidate(lowers=False, alike=("friction", "inertia"))],
         {"rival": ", rival"}, "; missing is friction or inertia: 1.1 x with it, rival"),
        ("effect-missing", [candidate()], {"jump": "a jump"},
         "; missing is friction, or it is a jump"),
        ("effect-missing", [candidate(1.0)], {"jump": "a jump"},
         "; a jump, explains more than any known effect"),
    ],
)  # fmt: skip
def test_a_verdict_in_one_sentence(says, candidates, more, told):
    size = "the error is 1.5 x the noise"
    assert verdict.sentence(error(), says, candidates, (), **more) == size + told
    where = (SimpleNamespace(says="at the end"),)
    place = "" if says == "adequate" else "; at the end"
    assert verdict.sentence(error(), says, candidates, where, **more) == size + told + place


FAR = 10.0 + EVIDENCE.rivals


def left(squares):
    judged = SimpleNamespace(misfit=squares > FAR)
    return SimpleNamespace(
        squares=lambda noise: squares,
        misfit=False,
        beside=lambda noise: judged,
        over=lambda noise: 1.0,
    )


def test_alike_are_those_that_fit_as_well_and_those_that_add_the_same():
    shapes = {"friction": [1.0, 0.0], "play": [1.0, 0.0], "creep": [0.0, 1.0], "slip": [-1.0, 0.0]}
    entries = {name: [SimpleNamespace(direction=np.array(shape))] for name, shape in shapes.items()}
    near, far = EVIDENCE.rivals - 0.5, EVIDENCE.rivals + 0.5
    first = tried("friction", delta=99.0, helps=True, left=left(10.0))
    as_well = tried("inertia", delta=99.0 - near, left=left(99.0))
    dearer = tried("filter", delta=99.0 - far, helps=True, left=left(10.0 + near))
    worse = tried("clock", delta=99.0 - far, helps=True, left=left(10.0 + far))
    unsure = tried("offset", delta=99.0 - far, left=left(10.0))
    each = [first, as_well, dearer, worse, unsure]
    found = verdict._class(each, entries, [])
    assert found == ["friction", "inertia", "filter", "play", "slip"]
    assert verdict._class([tried(delta=99.0)], entries, []) == []
    # By odds another may come first: it is of its own class, however far it is off.
    assert verdict._class([worse, first], entries, [])[:2] == ["clock", "friction"]
    assert trying.collinear_with("unknown", entries) == []
    classes = verdict._classes(entries, [first, tried("creep"), tried("play")], ["friction"])
    assert classes == (("play", "slip"),)
    assert verdict._classes(entries, [first], ["friction", "play"]) == (("friction", "play"),)


def test_the_test_that_is_missed_most_is_what_an_error_is_of():
    tests = [
        SimpleNamespace(name="a", over_floor=1.0, relative_rms=0.1, noise_floor=0.1),
        SimpleNamespace(name="b", over_floor=3.0, relative_rms=0.03, noise_floor=0.01),
    ]
    noise = [noise_of(size, 0.2) for size in (1.0, 2.0)]
    found = verdict.error_of(tests, noise, SimpleNamespace(errors=(0.5, 0.02)))
    assert (found.test, found.relative_rms, found.over_floor) == ("b", 0.03, pytest.approx(3.0))
    assert found.noise_source == "residual"
    assert found.material_floor == 0.02
    alone = verdict.error_of(tests[:1], noise)
    assert (alone.test, alone.noise_source) == ("", "signal")
    assert np.isnan(alone.material_floor)
    other = verdict.error_of(tests, noise, at=0)
    assert (other.test, other.relative_rms, other.noise_floor) == ("a", 0.1, 0.1)


def test_another_test_that_the_best_effect_leaves_missed_most_is_told():
    def left(*ratios: float, misfit: bool = True) -> SimpleNamespace:
        rows = [
            SimpleNamespace(name=name, over_floor=ratio, relative_rms=0.1 * ratio, noise_floor=0.1)
            for name, ratio in zip("ab", ratios, strict=True)
        ]
        return SimpleNamespace(misfit=misfit, rows=lambda *_: rows)

    noise = [noise_of(2.0)] * 2
    before = left(20.0, 6.0).rows()
    for one, says in (
        (left(1.0, 5.0), ", b still 5 x"),
        (left(1.0, 1.2, misfit=False), ""),
        (left(4.0, 1.0), ""),
    ):
        best = SimpleNamespace(left=one, fit=None)
        [after], beside = verdict._after([best], [], noise, before)
        assert (after.test, beside) == ("a", says)
    # Together they are at the noise, and one by one still better than that.
    apart = joined(0.7)
    apart.left.rows = left(1.0, 1.0).rows
    beside = verdict._after([apart], [], noise, before)[1]
    assert beside == ", though each test by itself is followed better than chance lets"


def test_an_effect_of_the_rig_is_as_much_commoner_as_the_rigs_are():
    effect = SimpleNamespace(prior=0.5, of_apparatus=False)
    rig = SimpleNamespace(prior=0.5, of_apparatus=True)
    assert trying.prior_weight(effect) == 0.5
    assert trying.prior_weight(rig) == 0.5 * EVIDENCE.apparatus
    each = trying.Hypothesis((rig,), None, np.zeros(0), None, delta=12.0)
    assert each.evidence == pytest.approx(12.0 + 2.0 * np.log(0.5 * EVIDENCE.apparatus))


def test_a_sweep_is_missed_by_what_the_model_lies_beside_it():
    model, omega = springpot.parse_model("kelvin"), np.array([1.0, 4.0])
    data = springpot.Measurement(omega, np.array([3.0 + 1.0j, 2.0 + 5.0j]))
    [part] = parts_of_specimen([data])
    theta = model.theta(k=2.0, c=1.5)
    found = verdict.misfit_of(part, SimpleNamespace(model=model, theta=theta, reference=20.0))
    exact = Misfit.of_stiffness(model.stiffness(theta, omega), data.stiffness)
    assert found.modulus == pytest.approx(exact.modulus)
    assert found.phase == pytest.approx(exact.phase)


@pytest.mark.parametrize(("low", "told"), [(1.0, True), (2.0, False)])
def test_the_beginning_of_a_step_is_left_out_where_it_fails_from_the_first_sample(low, told):
    time = np.array([1.0, 2.0, 4.0, 8.0])
    part = SimpleNamespace(test=TimeTest.of_relaxation(time, 1.0 / time))
    place = SimpleNamespace(low=low, high=2.0)
    steps = list(verdict._steps([part], "unexplained", [place]))
    assert steps == ([leaving_out_the_beginning(3.0, rows=2)] if told else [])
    assert [step.exclude for step in steps] == ([(1, 2)] if told else [])


@pytest.mark.parametrize(("part", "word"), [(0, "storage"), (1, "loss")])
@pytest.mark.parametrize(("sign", "side"), [(1.0, "low"), (-1.0, "high")])
def test_a_sweep_beside_others_is_missed_where_it_would_be_alone(part, word, sign, side):
    """In the words of a sweep that stands alone, by its name."""
    omega = np.geomspace(1.0, 100.0, 12)
    sd = np.full(12, 0.01 * (1.0 + 1.0j))
    sweep = springpot.Measurement(omega, np.full(12, 1.0 + 1.0j), sd=sd, name="sweep.csv")
    residual = np.zeros((2, 12))
    residual[part, 6:] = -6.0 * sign
    (place,) = SweepPart(sweep).places(residual.ravel())
    assert place.says.startswith(f"sweep.csv: {word} modulus 4.2 % of |G*| too {side} above")
    assert (place.low, place.high) == pytest.approx(sweep.frequency[[6, 11]])


@pytest.mark.parametrize("control", ["displacement", "force"])
def test_exponentials_follow_a_material_and_the_force_of_what_is_beside_it(control):
    """Under a displacement K of Maxwell elements, under a force 1/K of Kelvin elements."""
    time = np.linspace(0.0, 50.0, 300)
    test = TimeTest(time, np.ones(300), springpot.measurement.Loading.step(), control, "mm", "N")
    known = np.geomspace(1e-4, 1e4, 9)
    quick = SimpleNamespace(test=test, known=(known, np.ones(9)))
    kind = exponentials.QuickPart
    for name in ("band", "times", "omega", "share"):
        attribute = vars(kind)[name]
        read = attribute.fget if isinstance(attribute, property) else attribute.func
        setattr(quick, name, read(quick))
    quick.solver = vars(kind)["solver"].func(quick)
    quick._asked = lambda change: kind._asked(quick, change)
    s, tau = 1j * quick.omega, 7.0
    change = 3.0 + 2.0 * s * tau / (1.0 + s * tau)
    beside = [0.4, 0.0]
    if control == "force":
        change, beside = 3.0 + 2.0 / (1.0 + s * tau), [0.0, 0.0]
    change = change + beside[0] * s
    (amounts,) = kind.followed(quick, change[None]).T
    turned = s[:, None] * quick.times
    if control == "force":
        curve = amounts[0] + amounts[1] / s + (amounts[3:] / (1.0 + turned)).sum(1)
    else:
        curve = amounts[0] + amounts[1] * s + (amounts[3:] * turned / (1.0 + turned)).sum(1)
    np.testing.assert_allclose(curve[:-2], change[:-2], rtol=1e-3)
    assert amounts[1] == pytest.approx(beside[0], abs=0.01)


@pytest.mark.parametrize(
    ("stiffness", "named"), [(1e9, ["friction"]), (90.0, ["friction", "elasto-sliding"])]
)
def test_a_slider_without_give_is_friction_by_another_name(stiffness, named):
    time = np.linspace(0.0, 3.0, 80)
    test = TimeTest.of_history(time, np.sin(6.0 * time), 30.0 * np.cos(6.0 * time), "mm", "N")
    model = springpot.parse_model("kelvin + elasto-sliding")
    own = {"k": 3.0, "c": 5.0, "elasto-sliding.k": stiffness, "elasto-sliding.F": 20.0}
    slider = SimpleNamespace(
        effect=plugins().effect("elasto-sliding"),
        model=model,
        theta=model.vector(own),
        left=SimpleNamespace(count=4),
    )
    dry = SimpleNamespace(effect=plugins().effect("friction"), left=SimpleNamespace(count=3))
    both, parts = ["friction", "elasto-sliding"], parts_of_specimen([test])
    assert trying.without_nested(both, [dry, slider], parts, 293.15) == named
    assert trying.without_nested(both, [slider, dry], parts, 293.15) == both


@pytest.mark.parametrize(("unit", "factor"), [("N", 1e3), ("kN", 1.0)])
def test_a_class_is_the_same_in_any_unit(unit, factor):
    time = np.linspace(0.1, 60.0, 80)
    noise = 0.02 * np.random.default_rng(1).normal(size=80)
    force = factor * (30.0 - 0.1 * time + noise)
    test = TimeTest.of_history(time, np.full(80, 3.0), force, "mm", unit)
    model = springpot.parse_model("spring + thermal-force")
    own = {"k": 10.0 * factor, "thermal-force.size": -3.0 * factor, "thermal-force.tau": 30.0}
    drift = SimpleNamespace(effect=plugins().effect("force-drift"), left=SimpleNamespace(count=2))
    grown = SimpleNamespace(
        effect=plugins().effect("thermal-force"),
        model=model,
        theta=model.vector(own),
        left=SimpleNamespace(count=3),
    )
    both, parts = ["force-drift", "thermal-force"], parts_of_specimen([test])
    assert trying.without_nested(both, [drift, grown], parts, 293.15) == both


def test_of_each_test_it_is_told_what_is_the_wrong_way_round(monkeypatch):
    """A sweep whose columns are exchanged has no force to turn."""
    told = {
        "record": {"note sign": "as if the force counted the other way, open 'a.csv?force=-N'"},
        "sweep": {"note exchange": "if they are, open 'b.csv?storage=loss,loss=storage'"},
    }
    tests = [SimpleNamespace(name=name, provenance=said) for name, said in told.items()]
    monkeypatch.setattr(diagnosis, "turned_over", lambda test: test)
    monkeypatch.setattr(diagnosis, "parts_of_specimen", lambda given: None)
    monkeypatch.setattr(diagnosis, "FitResiduals", SimpleNamespace(of=lambda fit, _: fit.bic))
    monkeypatch.setattr(diagnosis, "bic_of", lambda bic: bic)
    anew = SimpleNamespace(bic=0.0, relative_rms=0.01)
    monkeypatch.setattr(diagnosis, "identify", lambda *_: anew)
    steps, _ = diagnosis._turns(tests, None, SimpleNamespace(bic=1e3))
    assert [step.says for step in steps] == [
        "the force counts the other way: turn it",
        "storage and loss stand in each other's place: exchange them",
    ]
