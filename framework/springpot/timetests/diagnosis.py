"""Which effect is missing from a model of tests in time, and which test would tell two apart.

Harmonics hide what happens within a cycle; the record does not. The error of the model stands
beside the noise of the record, every effect is judged by how far the error falls for its
parameters, and those that fall alike are one class. All are scanned at once, and the leading few
are fitted.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from springpot.diagnosis.experiment import (
    ACTION,
    TYPED_IN,
    WAITED_FOR,
    WORKED_FOR,
    Planned,
    first_telling,
    planned_sweeps,
    worth_telling_apart,
)
from springpot.diagnosis.in_practice import Accuracy, in_practice
from springpot.diagnosis.result import (
    Candidate,
    Diagnosis,
    Fitted,
    NextExperiment,
    ToDo,
    turning,
    unseen,
)
from springpot.identification.convex import within_material
from springpot.identification.material import is_material
from springpot.identification.native import FittedModel
from springpot.identification.result import Identification
from springpot.measurement.imposed import Loading
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned, turned_over, wrong_way
from springpot.measurement.timenoise import noise_of
from springpot.measurement.timetest import TimeTest
from springpot.misfit.error import plain
from springpot.misfit.residual_scatter import (
    scatter_of,
)
from springpot.misfit.residuals_of_tests import (
    InTimePart,
    SweepPart,
    Test,
    TestPart,
    parts_of_specimen,
    reach_of,
    units_of,
)
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Real
from springpot.thresholds import EXPERIMENT, SEARCH, VERDICT

from ..numerics import SMALLEST, evenly, rms
from .disturbances import slip_beside
from .exponentials import quick_parts
from .fitting import identify, refound
from .hypotheses import (
    AskedTests,
    FitResiduals,
    Hypothesis,
    ScanEntry,
    bic_of,
    delta_bic,
    evidence_over_misfit,
    no_worse,
    of_what_helps,
    one_of_each,
    sum_of_squares,
)
from .material import material_floor
from .score import TimeScan
from .screening import (
    alone,
    exactly_fitted,
    from_the_data,
    leading_of_scan,
    nearly_all,
    noise_of_best,
    of_material,
)
from .specimen import at_rigs, at_tests
from .valley import beside_limits
from .verdict import TimeCase, answer_of, misfit_of, worst_of

SAMPLES = 200
"""Of a planned record, which moves all the time."""


def next_test(case: TimeCase) -> NextExperiment | None:
    """The test that would tell the two leading effects of a diagnosis apart.

    None where it is plain which of them it is, or that nothing is missing.
    """
    if case.diagnosis.verdict == "adequate":
        return None
    fits = {each.effect.name: each.fit for each in case.tried if each.fit is not None}
    # What is ruled out is no rival of anything.
    believed = [
        each for each in case.diagnosis.candidates if case.diagnosis.shelf_of(each) != "ruled-out"
    ]
    chances = {each.effect: each.probability for each in believed}
    # Whether the likeliest holds is the question; of the others alone it is none.
    if not chances or max(chances, key=chances.__getitem__) not in fits:
        return None
    chances = {name: chance for name, chance in chances.items() if name in fits}
    parts = case.asked.parts
    pairs = worth_telling_apart(chances) or _of_one_class(case.diagnosis.candidates, chances)
    return first_telling(pairs, fits, chances, parts, partial(planned_tests, parts))


def _of_one_class(candidates: Sequence[Candidate], fits: Collection[str]) -> list[tuple[str, str]]:
    """The first with each that these tests do not tell from it, however unlike their chances.

    None of them where something else is believed in.
    """
    believed = [each for each in candidates[:1] if each.probability > EXPERIMENT.rival]
    alike = [name for each in believed for name in each.alike if name in fits]
    return [(alike[0], name) for name in alike[1:]]


def planned_tests(parts: Sequence[TestPart], fit: FittedModel) -> Iterator[Planned]:
    """What could be measured next of a specimen, the cheap things first.

    Parameters
    ----------
    parts : sequence of TestPart
        The tests that were made.
    fit : Identification
        A model that follows them, which says how large K is.
    """
    # Of many tests of one kind the first stands for all.
    kinds: dict[str, InTimePart] = {}
    for part in parts:
        if isinstance(part, InTimePart):
            kinds.setdefault(part.test.kind, part)
    for part in kinds.values():
        # The mean of four is half as noisy.
        quieter = replace(part, noise=0.5 * part.sd)
        again = f"repeat {part.test.name} four times"
        yield Planned(again, quieter, WORKED_FOR, {"repeats": [4.0]})
        yield from _changed(part)
    yield from _sweeps(parts, fit)


def _changed(part: InTimePart) -> Iterator[Planned]:
    """The same kind of test, longer, sooner, larger, smaller, faster, slower or let go."""
    test = part.test
    moved = "step" if test.after_step else "motion"
    for factor, word in ((ACTION.stronger, "three times"), (1.0 / ACTION.stronger, "a third of")):
        says = f"impose {word} the {moved} of {test.name}"
        larger = _with(part, test.time, test.loading.scaled(factor))
        yield Planned(says, larger, TYPED_IN, {"factor": [factor]})
    if test.after_step:
        yield from _of_step(part)
        return
    for factor, word in (
        (ACTION.farther, "ten times as fast"),
        (1.0 / ACTION.farther, "ten times as slowly"),
    ):
        loading = replace(test.loading, time=test.loading.time / factor)
        faster = _with(part, test.time / factor, loading)
        yield Planned(
            f"run the {moved} of {test.name} {word}", faster, TYPED_IN, {"faster": [factor]}
        )


def _of_step(part: InTimePart) -> Iterator[Planned]:
    test = part.test
    clock = test.time - test.start
    first, last = float(np.min(clock[clock > 0.0])), float(clock[-1])
    later = test.start + np.geomspace(last, ACTION.farther * last, ACTION.points)
    says = f"go on with {test.name} to {plain(ACTION.farther * last)} s: {ACTION.points} samples"
    yield Planned(says, _with(part, later, test.loading), WAITED_FOR, {"time": later.tolist()})
    sooner = test.start + np.geomspace(first / ACTION.farther, first, ACTION.points)
    start = plain(first / ACTION.farther)
    says = f"read {test.name} sooner, from {start} s on: {ACTION.points} samples"
    yield Planned(says, _with(part, sooner, test.loading), WAITED_FOR, {"time": sooner.tolist()})
    end = float(test.time[-1])
    loading, back = test.loading, float(test.loading.value[0])
    let_go = Loading(
        np.concatenate([loading.time[loading.time < end], [end, end]]),
        np.concatenate([loading.value[loading.time < end], [loading.value[-1], back]]),
    )
    times = end + np.geomspace(first, last, ACTION.points)
    says = f"let {test.name} go at {plain(end)} s and record as long again: {ACTION.points} samples"
    yield Planned(says, _with(part, times, let_go), WAITED_FOR, {"release": [end]})


def _with(part: InTimePart, time: Real, loading: Loading) -> InTimePart:
    """A planned test beside one that was made, as noisy as its middle sample."""
    rows = evenly(len(time), SAMPLES)
    test = replace(
        part.test,
        time=time[rows],
        response=np.zeros(len(rows)),
        loading=loading,
        warmth=None,
        aside={},
        measured=False,
    )
    return InTimePart(test, noise=np.full(len(rows), float(np.median(part.sd))))


def _sweeps(parts: Sequence[TestPart], fit: FittedModel) -> Iterator[Planned]:
    """What could be measured next in the rig of a sweep, or a sweep where there is none."""
    made = next((part for part in parts if isinstance(part, SweepPart)), None)
    if made is not None:
        for each in planned_sweeps(made, fit):
            yield replace(each, says=f"{made.test.name}: {each.says}")
        return
    seen = [part.resolved for part in parts]
    omega = np.geomspace(
        min(each[0] for each in seen), max(each[1] for each in seen), ACTION.points
    )
    hertz = omega / (2.0 * np.pi)
    says = (
        f"measure a sweep of the same specimen: {ACTION.points} points from {plain(hertz[0])} to"
        f" {plain(hertz[-1])} Hz"
    )
    yield Planned(says, _sweep(parts, fit, omega), WAITED_FOR, {"omega": omega.tolist()})


def _sweep(parts: Sequence[TestPart], fit: FittedModel, omega: Real) -> SweepPart:
    """A sweep under the conditions of the tests, as noisy for its size as they are."""
    amplitude = np.full(len(omega), reach_of(parts))
    conditions: Mapping[str, Real] = {"amplitude": amplitude}
    for name in fit.model.own.values():
        # Of specimens with parameters of their own the first stands for all.
        conditions = {**conditions, name: np.full(len(omega), parts[0].test.conditions[name][0])}
    if any("temperature" in part.conditions for part in parts):
        conditions = {**conditions, "temperature": np.full(len(omega), fit.reference - KELVIN)}
    units = units_of([part.test for part in parts])
    plan = Measurement(
        omega, np.ones(len(omega), dtype=np.complex128), conditions=conditions, units=units
    )
    size = np.abs(fit.model.stiffness(fit.theta, replace(plan, reference=fit.reference).points))
    share = float(np.median([rms(part.sd) / max(rms(part.measured), SMALLEST) for part in parts]))
    return SweepPart(plan).with_sd(share * np.tile(size, 2))


def diagnose(
    tests: Sequence[Test] | Test,
    model: Model | str,
    effects: Iterable[Effect] | None = None,
    *,
    accuracy: Accuracy | None = None,
) -> Diagnosis:
    """Find which effect is missing from a model of tests in time.

    Parameters
    ----------
    tests : TimeTest, Measurement, or a sequence of them
        Of one specimen, at least one in time.
    model : Model or str
        The model to be judged, or its expression, such as ``"fractional-zener + force-drift"``.
    effects : iterable of Effect, optional
        What may be missing; by default all that is installed. Those without a law in time, or whose
        conditions the tests lack, are passed over.
    accuracy : Accuracy, optional
        What the instrument promises: a misfit within it is no verdict on the model.

    Returns
    -------
    Diagnosis
        Verdict, candidates best first, and where the model fails.

    Raises
    ------
    SpringpotError
        If the model itself does not fit the tests.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.timetests import diagnose
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 80)
    >>> exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), t) + 0.2 * t
    >>> noise = np.random.default_rng(1).normal(size=80)
    >>> test = springpot.TimeTest.of_relaxation(t, exact + noise, "kPa")
    >>> names = ("force-drift", "force-offset", "parallel-spring")
    >>> few = [springpot.plugins().effect(name) for name in names]
    >>> diagnose(test, model, few).best.effect
    'force-drift'
    """
    return examine(tests, model, effects, accuracy=accuracy).diagnosis


def examine(
    tests: Sequence[Test] | Test,
    model: Model | str,
    effects: Iterable[Effect] | None = None,
    *,
    base: Identification | None = None,
    accuracy: Accuracy | None = None,
    fitted: Fitted = unseen,
) -> TimeCase:
    """The same with the fits behind it; `base` is that of the model, where it is known already.

    `accuracy` is what the instrument promises; `fitted` is given each effect that was fitted.
    """
    given = list(tests) if isinstance(tests, Sequence) else [tests]
    if isinstance(model, str):
        model = parse_model(model)
    if effects is None:
        effects = list(plugins().items("effect"))
    library = [there for effect in effects for there in at_tests(effect, given)]
    model = at_rigs(model, given)
    turns, base = _turns(given, model, base)
    if turns:
        # Until it is turned nothing else holds, and no effect is looked for.
        case = _judged(given, model, [], base, None, fitted)
        told = replace(case.diagnosis, steps=turns).behind_a_sign()
        return _finished(case._replace(diagnosis=told), accuracy)
    # The noise is needed to judge and a good model to know the noise: so a second round, where it
    # matters.
    case = _judged(given, model, library, base, None, fitted)
    # A sample that is all that is missed says nothing of the specimen.
    while case.aside is not None:
        given = _without(given, *case.aside)
        case = _judged(given, model, library, None, None, fitted)
    noise = _noise_beside(case)
    if noise is not None:
        # `base` was fitted with the weights of the first noise: it is fitted anew with those of the
        # second.
        case = _judged(given, model, library, None, noise, fitted)
    return _finished(case, accuracy)


def _turns(
    tests: Sequence[Test], model: Model, base: Identification | None
) -> tuple[tuple[ToDo, ...], Identification | None]:
    """What turns the channels that count the other way, if the model follows them so; and the fit.

    A record alone may look so, as above a resonance that it does not show.
    """
    specs = {test.name: spec for test in tests if (spec := turned(test.provenance))}
    if not specs:
        return (), base
    base = base or identify(tests, model)
    anew = [turned_over(test) if test.name in specs else test for test in tests]
    fit = identify(anew, model)
    before, after = (
        bic_of(FitResiduals.of(one, parts_of_specimen(given)))
        for one, given in ((base, tests), (fit, anew))
    )
    if before - after < SEARCH.decisive:
        return (), base
    whats = {test.name: wrong_way(test.provenance) for test in tests}
    steps = [turning(spec, name, fit.relative_rms, whats[name]) for name, spec in specs.items()]
    return tuple(steps), base


def _finished(case: TimeCase, accuracy: Accuracy | None) -> TimeCase:
    """A case with what is told when all is judged."""
    shown = beside_limits(case.base, case.asked.parts)
    misfits = [misfit_of(part, case.base) for part in case.asked.parts]
    values = shown.parameters
    if accuracy is not None:
        base, tests = case.base, case.asked.tests
        values = accuracy.beside(values, base, tests, units_of(tests), refound(base))
    told = in_practice(replace(case.diagnosis, parameters=values), misfits, accuracy)
    lowest = material_floor([case.base]).errors[worst_of(told.tests)]
    error = replace(told.error, material_floor=lowest)
    told = replace(told, error=error, next_experiment=next_test(case))
    return case._replace(diagnosis=told)


def _without(tests: Sequence[Test], number: int, row: int, off: float) -> list[Test]:
    """The tests, a sample of one of them set aside that is off by so many times the noise."""
    return [
        replace(test, aside={**test.aside, row: off})
        if i == number and isinstance(test, TimeTest)
        else test
        for i, test in enumerate(tests)
    ]


def _noise_beside(first: TimeCase) -> list[Real | None] | None:
    """The noise of each test as the best model shows it, where the signal told another.

    None where it did not.

    Corners that friction, stops or a release make in a signal look like noise that grows with it.
    """
    noise = [_better_noise(part, first.best_fit) for part in first.asked.parts]
    if all(each is None for each in noise):
        return None
    return noise


def _better_noise(part: TestPart, fit: Identification) -> Real | None:
    """The noise of one test as a fit shows it; None where what the signal told will do."""
    # The answer to a step is smooth between its jumps: its signal has told its noise already.
    if not isinstance(part, InTimePart) or part.test.after_step:
        return None
    # Only the shape of the noise weighs samples against one another: its size is read from what is
    # left anyway.
    if part.sd.max() < VERDICT.agrees * part.sd.min():
        return None
    over_noise = part.residual(fit.model, fit.theta, fit.reference).value
    all_noise = not scatter_of(over_noise).doubtful
    better = noise_of(part.test, over_noise * part.sd, all_noise=all_noise).sd
    share = better / part.sd
    if share.max() > VERDICT.agrees * share.min():
        return better
    return None


def _judged(
    given: Sequence[Test],
    model: Model,
    effects: Sequence[Effect],
    base: Identification | None,
    known: Sequence[Real | None] | None,
    fitted: Fitted,
) -> TimeCase:
    """The diagnosis with a certain noise."""
    if base is None:
        base = identify(given, model, noise=known)
    parts = parts_of_specimen(given, known)
    before = FitResiduals.of(base, parts)
    beside = [effect for effect in effects if not _within(base.model, effect)]
    left_out: dict[str, str] = {}
    asked = AskedTests(given, parts, quick_parts(parts), known, beside, left_out)
    entries = TimeScan(base, asked.quick).entries(beside)
    tried = _screened(asked, base, entries, before, fitted)
    better = _better_start(asked, base, before, tried)
    if better is not None:
        return _judged(given, model, effects, better, known, fitted)
    # A model with one more effect can always do as well as the one without: worse is a search that
    # failed.
    tried = one_of_each([no_worse(each, before) for each in tried])
    # By a criterion that needs no noise, which is only read from what the best one leaves.
    slip = slip_beside(parts, base, before)
    stories = [each.left for each in tried] or [before]
    best = min([*stories, slip.left], key=bic_of)
    noise = noise_of_best(before, best)
    judged = [replace(each, delta=delta_bic(before, each.left, noise)) for each in tried]
    # Where the misfit is not certain, it is the noise over which an effect shows it.
    certain = before.misfit or delta_bic(before, best, noise) >= SEARCH.decisive
    if certain and best.misfit:
        # No unit but that of what the best explanation misses: over the noise alone whatever takes
        # a little more of a large misfit would be proved.
        judged = [
            replace(each, delta=evidence_over_misfit(parts, before, each, best)) for each in tried
        ]
    else:
        judged = [of_what_helps(parts, before, each) for each in judged]
    # By their chances, so that what is rare stands behind what is common and explains the tests as
    # well.
    # Where all leave less than the noise, the one that leaves least stands first all the same.
    ranked = sorted(judged, key=lambda each: (-round(each.evidence, 1), sum_of_squares(each.left)))
    # What cannot be told from another material and helps no more than one is no candidate.
    ranked = [each for each in ranked if each.effect.name not in left_out or each.helps]
    # Why one that helps was fitted only nearly stays: its acceptance would end there.
    for each in ranked:
        if each.fit is not None:
            left_out.pop(each.effect.name, None)
    return answer_of(asked, base, before, ranked, noise, entries, slip)


def _screened(
    asked: AskedTests,
    base: Identification,
    entries: dict[str, list[ScanEntry]],
    before: FitResiduals,
    fitted: Fitted,
) -> list[Hypothesis]:
    """Effects that were fitted, by screening, each stage dearer than the one before.

    A linear scan, fits by fixed exponentials, exact fits.
    """
    if is_material(base.model):
        return of_material(asked, base, leading_of_scan(entries, before), fitted)
    nearly = nearly_all(asked, base, entries, before, fitted)
    return exactly_fitted(asked, from_the_data(asked, base, nearly, before), before, fitted)


def _better_start(
    asked: AskedTests, base: Identification, before: FitResiduals, tried: Sequence[Hypothesis]
) -> Identification | None:
    """The model alone, fitted from where effects have led it; None where that is no nearer.

    As for sweeps: what a small effect seems to explain may be a minimum that was left behind, and
    an order or a spring at the end of its range is one.
    """
    nearest = sorted(tried, key=lambda each: bic_of(each.left))[: SEARCH.tried_alone]
    if not tried or is_material(base.model):
        return None
    noise = noise_of_best(before, nearest[0].left)
    if delta_bic(before, nearest[0].left, noise) < SEARCH.decisive:
        return None
    seeds = [alone(each, base.model) for each in nearest]
    fit = identify(asked.tests, base.model, seeds=seeds, thorough=False, noise=asked.known)
    left = FitResiduals.of(fit, asked.parts)
    # Of several tests a fit weighs one against another: it is another minimum only if none loses.
    gains = [
        float(old @ old - new @ new)
        for old, new in zip(before.residuals, left.residuals, strict=True)
    ]
    if min(gains) < 0.0 or sum(gains) <= 2.0 * SEARCH.better:
        return None
    return fit


def _within(material: Model, effect: Effect) -> bool:
    """Whether a free spectrum has an effect already.

    That of one rig alone the other tests are free of.
    """
    return effect.in_time and within_material(material, effect)
