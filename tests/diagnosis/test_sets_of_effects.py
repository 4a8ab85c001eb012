"""Effects that are missing together are found as a set, and what stays is the likeliest set."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, exact, measured

from springpot import Measurement, diagnose
from springpot.diagnosis import discovery, ladder
from springpot.diagnosis.discovery import SweepRungs, searched_sets
from springpot.diagnosis.evidence import Evidence
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.ladder import FoundSet, Rungs, rung_of
from springpot.diagnosis.result import silent
from springpot.diagnosis.scan import scan_effects
from springpot.diagnosis.search import _less_one, go_on_from, search_from
from springpot.misfit.error import Error
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.refit import refit
from springpot.registry import parse_model, plugins

OMEGA = SWEEP.omega
DELAYED = (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2) * np.exp(-5e-4j * OMEGA)
THREE = (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2 + 15.0j) * np.exp(-5e-4j * OMEGA)
"""A mass, a delay, and a hysteretic loss of 15 kN/m."""
LIBRARY = [
    plugins().effect(name)
    for name in ("inertia", "time-delay", "hysteretic-loss", "series-spring", "parallel-dashpot")
]


def searched(stiffness):
    """What single effects and pairs explain."""
    base = fitted_to_floor(parse_model(KELVIN.name), measured(SWEEP, stiffness, level=0.002))
    return search_from(base, LIBRARY, np.random.default_rng(0))


def case_of(search):
    """An examination, as far as sets are concerned."""
    return SimpleNamespace(search=search, naming=search, course=None)


def rungs():
    """Those of a sweep, whose data are in the searches."""
    return SweepRungs(measurement=None, effects=LIBRARY, rng=np.random.default_rng(0))


def rung(search, accepted=None):
    """A step of a ladder, as far as sets are concerned."""
    case = case_of(search)
    told = SimpleNamespace(verdict="unexplained")
    return SimpleNamespace(case=case, model=search.base.model, accepted=accepted, diagnosis=told)


def likeliest(first, last, *names):
    """The likeliest set, begun with effects that were accepted one after the other."""
    end = SimpleNamespace(base=last, scan=first.scan)
    return rungs().likeliest_set([rung(first), *(rung(end, name) for name in names)])


def with_effects(search, *names):
    """The fit of the search's base with some effects."""
    model = search.base.model
    for name in names:
        model = model + name
    return refit(model, search.base.data, search.base.noise)


@pytest.fixture(scope="module")
def three():
    return searched(THREE)


@pytest.fixture(scope="module")
def delayed():
    return searched(DELAYED)


@pytest.mark.soak
def test_three_effects_of_which_no_two_explain_the_data_are_found_together(three):
    assert max(len(grown.effects) for grown in three.grown) == 2
    found = rungs().complete_set([rung(three)])
    assert sorted(each.name for each in found.effects) == [
        "hysteretic-loss",
        "inertia",
        "time-delay",
    ]
    # What a rung begins with fits as the set was fitted, whatever came first.
    model = parse_model(KELVIN.name) + "hysteretic-loss" + "time-delay" + "inertia"
    known = rungs()
    known.sets.append(found)
    (fit,) = known.fits_of(model)
    assert fit is found.fit
    off = measured(SWEEP, THREE, level=0.002).stiffness / fit.stiffness
    assert np.sqrt(np.mean(np.abs(off - 1.0) ** 2)) < 1.2 * three.base.floor


def test_where_a_pair_explains_the_data_no_further_set_is_sought(delayed):
    assert rungs().complete_set([rung(delayed)]) is None


def test_beside_a_set_that_leaves_noise_alone_no_larger_one_is_sought(delayed):
    """Beside one that leaves more than noise a further effect, or two in the place of one, are."""
    wanted = {("inertia", "time-delay"): {2}, ("series-spring",): {1, 2}}
    found = [each for each in delayed.grown if each.key in wanted]
    assert {each.key for each in found} == wanted.keys()
    for grown in found:
        search = replace(delayed, grown=list(delayed.grown))
        asked = discovery._neighbours(search, grown, LIBRARY)
        assert {len(each.effects) for each in asked} == wanted[grown.key]


@pytest.mark.soak
def test_one_rung_is_exchanged_for_the_effect_that_belongs_there(delayed):
    """A mount took the place of the mass beside a delay."""
    last = with_effects(delayed, "series-spring", "time-delay")
    found = likeliest(delayed, last, "series-spring", "time-delay")
    assert {effect.name for effect in found.effects} == {"time-delay", "inertia"}
    assert found.fit.rss < last.rss - 20.0


@pytest.mark.soak
def test_one_rung_is_exchanged_for_two_only_if_the_evidence_says_so(three, delayed):
    for search, wanted in ((three, ["hysteretic-loss", "time-delay"]), (delayed, ["time-delay"])):
        last = with_effects(search, "inertia", "parallel-dashpot")
        found = likeliest(search, last, "inertia", "parallel-dashpot")
        assert sorted(effect.name for effect in found.effects) == sorted(["inertia", *wanted])


def test_rivals_that_the_first_rung_has_seen_are_weighed_too(delayed, monkeypatch):
    """They may differ from what was accepted in every place."""
    begun = []
    searched = discovery.searched_sets
    monkeypatch.setattr(
        discovery,
        "searched_sets",
        lambda search, effects: begun.extend(search.grown) or searched(search, []),
    )
    last = with_effects(delayed, "series-spring", "hysteretic-loss")
    found = likeliest(delayed, last, "series-spring", "hysteretic-loss")
    assert ("inertia", "time-delay") in {grown.key for grown in begun}
    assert {effect.name for effect in found.effects} == {"inertia", "time-delay"}


def test_a_single_rung_is_what_the_diagnosis_says(delayed):
    assert likeliest(delayed, with_effects(delayed, "inertia"), "inertia") is None


class Others(Rungs):
    """Rungs of which others stand in the place of those that were accepted."""

    decisive = None

    def complete_set(self, steps):
        return self.likeliest_set(steps)

    def examined(self, model, progress, before, effect):
        diagnosis = SimpleNamespace(verdict="adequate", candidates=(), parameters={}, tests=())
        diagnosis.model, diagnosis.next_experiment = model, None
        diagnosis.error = Error(0.1, 0.1, "given")
        return SimpleNamespace(diagnosis=diagnosis, untold=None)

    def likeliest_set(self, steps):
        effects = tuple(plugins().effect(name) for name in self.effects)
        return FoundSet(effects, None, lambda names: {name: (name, "another") for name in names})


@pytest.mark.parametrize(
    ("accepted", "found", "told"),
    [
        (["inertia", "friction"], ["friction", "inertia"], ["inertia", "friction"]),
        (["inertia", "friction"], ["time-delay", "friction"], ["friction", "time-delay"]),
        (["friction"], ["inertia", "friction"], ["friction", "inertia"]),
        (["inertia", "friction"], ["time-delay"], ["time-delay"]),
    ],
)
def test_what_stays_keeps_its_rung(accepted, found, told):
    others, model, steps = Others(effects=found), parse_model("kelvin"), []
    for name in (None, *accepted):
        model = model if name is None else model + name
        steps.append(rung_of(others.examined(model, None, None, None), None, name))
    settled = others.settled(steps, silent)
    assert [step.accepted for step in settled] == [None, *told]
    assert [step.alike for step in settled[1:]] == [(name, "another") for name in told]
    # As far as nothing changes the examinations are those that were made.
    kept = [step.accepted for step in steps[1:]] + [None] * 2
    same = next(i for i, name in enumerate([*told, ""]) if name != kept[i])
    assert all(settled[i].examined is steps[i].examined for i in range(1 + same))


@pytest.mark.parametrize(("beside", "foretold"), [(np.nan, 0.02), (0.01, None)])
def test_what_was_foretold_of_two_effects_is_not_told_of_one(beside, foretold):
    others, model = Others(effects=[]), parse_model("kelvin")
    case = others.examined(model, None, None, None)
    case.diagnosis.candidates = (
        SimpleNamespace(
            effect="friction", alike=("friction",), predicted_error=0.02, error_beside=beside
        ),
    )
    before = rung_of(case)
    after = rung_of(others.examined(model + "friction", None, None, None), before, "friction")
    assert after.predicted_error == foretold


@pytest.mark.parametrize(("gain", "kept"), [(0.5, 3), (0.9, 2)], ids=["predicts", "follows"])
def test_what_a_set_adds_beside_the_unexplained_has_to_predict(monkeypatch, gain, kept):
    """A delay that follows what no effect explains is not folded into the model."""

    class Left(Others, SweepRungs):
        verdicts = ("effect-missing", "unexplained", "unexplained")

        def examined(self, model, progress, before, effect):
            case = super().examined(model, progress, before, effect)
            case.diagnosis.verdict = self.verdicts[len(model.effects)]
            case.search = SimpleNamespace(base=model)
            return case

    left = Left(effects=["friction", "time-delay"], measurement=None, rng=None)
    model = parse_model("kelvin")
    steps = [rung_of(left.examined(model, None, None, None))]
    steps.append(rung_of(left.examined(model + "friction", None, None, None), steps[0], "friction"))
    monkeypatch.setattr(ladder, "alive", lambda part, kind, what: part)
    monkeypatch.setattr(discovery, "prediction_gain", lambda before, after: gain)
    monkeypatch.setattr(discovery, "_likelier", lambda one, other: False)
    assert len(left.settled(steps, silent)) == kept


@pytest.mark.parametrize(
    ("chain", "kept"),
    [(["inertia", "time-delay"], 3), (["inertia", "time-delay", "series-spring"], 3)],
)
def test_the_last_of_a_set_goes_where_it_does_nothing_beside_the_others(chain, kept):
    """A spring in series with a mass and a delay, which the data do not hold."""
    rungs, data = [], measured(SWEEP, DELAYED, level=0.002)
    for count in range(len(chain) + 1):
        model = sum((plugins().effect(name) for name in chain[:count]), parse_model(KELVIN.name))
        fit = fitted_to_floor(model, data)
        case = SimpleNamespace(search=SimpleNamespace(base=fit))
        rungs.append(SimpleNamespace(model=model, case=case))
    assert len(discovery._spared(rungs)) == kept


def test_a_set_that_was_found_is_taken_to_its_end_but_for_what_was_refused():
    def asked(verdict, *refused):
        steps = [SimpleNamespace(diagnosis=SimpleNamespace(verdict=verdict))]
        effect = others.wanted(steps, refused)
        return effect and effect.name

    others = Others(effects=["inertia", "friction", "time-delay"])
    assert asked("inconclusive") is None
    assert asked("unexplained") == "inertia"
    # Half of it may look like noise to a rung between.
    assert asked("inconclusive") == "friction"
    assert asked("inconclusive", "time-delay") is None
    assert (len(others.sets), others.plan) == (1, [])


def test_sets_that_differ_in_two_places_are_told_place_by_place(monkeypatch):
    def told(chance, *names):
        return SimpleNamespace(names=names, probability=chance)

    sets = [
        told(0.4, "a", "b"),
        told(0.3, "c", "d"),
        told(0.2, "c", "b"),
        told(0.1, "a", "b", "e"),
    ]
    evidence = Evidence(None, 0.0, 0.0, tuple(sets))
    # Beside what is likely, what has the same curve, however unlikely.
    monkeypatch.setattr(Evidence, "same_curve", lambda self, names, of_any_size: [["d", "f"], []])
    assert evidence.places("ba") == {"b": ("b", "d", "f"), "a": ("a", "c")}


@pytest.mark.soak
def test_the_best_set_is_minimal(three):
    """Without any of its effects the evidence is less, beyond doubt."""
    found = searched_sets(three, LIBRARY)
    best = Evidence.of(found).explanations[0].grown
    for i in range(len(best.effects)):
        rest = tuple(sorted(name for j, name in enumerate(best.names) if j != i))
        (without, *_) = [one for one in found.grown if one.key == rest]
        assert without.refit.log_evidence < best.refit.log_evidence - 5.0


@pytest.mark.parametrize(
    ("stiffness", "left"),
    [(DELAYED, []), (exact(KELVIN, SWEEP) * np.exp(-5e-4j * OMEGA), [("time-delay",)])],
    ids=["both", "delay"],
)
def test_of_a_pair_what_can_be_spared_goes(stiffness, left):
    base = fitted_to_floor(parse_model(KELVIN.name), measured(SWEEP, stiffness, level=0.002))
    effects = tuple(plugins().effect(name) for name in ("inertia", "time-delay"))
    scanned = scan_effects(base, base.frame(), effects)
    search = Search(base, base.frame(), scanned, None)
    model = sum(effects, base.model)
    pair = Grown(effects, refit(model, base.data, base.noise, [], starts=2), 0.0)
    less = _less_one(search, [pair])
    assert [grown.names for grown in less] == left
    assert all(grown.predicted == scanned.scores[0].predicted for grown in less)
    # In another noise too, where the search anew found neither.
    before = Search(base, base.frame(), scanned, None, [pair])
    after = go_on_from(Search(base, base.frame(), scanned, None), before, np.random.default_rng(1))
    assert {grown.key for grown in after.grown} == {pair.key, *left}
    search.grown.append(pair)
    assert _less_one(search, [pair]) == [], "no better than what is known"


@pytest.mark.soak
@pytest.mark.parametrize("seed", [0, 2, 3, 4])
def test_a_sharp_resonance_that_only_a_pair_reaches_is_missing_by_itself(seed):
    """It doubles K at 45 Hz, between two of 18 frequencies: far from what a tangent tells."""
    frequency = np.linspace(1.4, 76.0, 18)
    s, ratio = 2j * np.pi * frequency, frequency / 44.7
    zener = 0.13 + 1.0 / (1.0 / 1.7 + 1.0 / (0.033 * s**0.66))
    stiffness = 1.0 / (1.0 / zener + 0.125 / (1.0 - ratio**2 + 0.1j * ratio))
    real, imaginary = np.random.default_rng(seed).standard_normal((2, 18))
    noisy = stiffness * (1.0 + 0.014 * (real + 1j * imaginary))
    found = diagnose(Measurement(s.imag, noisy), "fractional-zener")
    assert found.says.endswith("missing is frame-resonance or another narrow feature")
    assert found.best.effect == "frame-resonance"
