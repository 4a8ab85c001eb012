"""What Python users call, with names where objects are meant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

import springpot.invention as invention
import springpot.superposition as superposition
import springpot.timetests as timetests
from springpot.comparison.comparing import compare as compare_objects, rank
from springpot.comparison.result import Comparison
from springpot.constraints import (
    Bounds,
    constrained,
    excluded,
    numbered,
    optimiser_of,
    own_values,
    owning,
)
from springpot.diagnosis.discovery import discover as discover_objects
from springpot.diagnosis.examination import diagnose as diagnose_objects
from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis, Fitted, Progress, silent, unseen
from springpot.errors import DataError, ModelError, OptionError
from springpot.identification.fitting import identify as identify_objects
from springpot.identification.problem import Objective
from springpot.identification.result import Identification
from springpot.identification.runs import Optimiser
from springpot.identification.searching import refound
from springpot.identification.space import require_conditions
from springpot.measurement.conversion import joined
from springpot.measurement.covered import OtherTest
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import PROMISED, Test, sweep_of
from springpot.measurement.timetest import TimeTest
from springpot.misfit.material import any_material
from springpot.registry import effect_of, open_tests, parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model

from .thresholds import INTERVAL, INTERVALS

if TYPE_CHECKING:
    from springpot.invention.result import Invention
    from springpot.superposition.curve import MasterCurve
    from springpot.timetests.prediction import TestPrediction

Data: TypeAlias = Test | str | Path | Sequence[Test | str | Path]
"""What users give: a test, its file or name, or several of one specimen."""


def read(spec: str | Path) -> Test | tuple[Test, ...]:
    """The test that `spec` names, as on the command line: a sweep, or a test in time.

    Parameters
    ----------
    spec : str or Path
        A file or the name of a registered data set, either with conditions:
        ``nist-srm2491@temperature=20``.

    Returns
    -------
    Measurement or TimeTest
        All tests of a file that holds several in time.

    Raises
    ------
    DataError
        If there is no such thing or it cannot be read.

    Examples
    --------
    >>> import springpot
    >>> springpot.read("artificial-hidden@frequency=1..10")
    <Measurement artificial-hidden@frequency=1..10: 17 points, 1.13 to 9.93 Hz>
    """
    tests = open_tests(spec)
    if len(tests) > 1:
        return tests
    return tests[0]


def identify(
    measurement: Data,
    model: Model | str,
    *,
    optimiser: Optimiser | str | None = None,
    objective: Objective | str | None = None,
    budget: int | None = None,
    restarts: int | None = None,
    seed: int | None = None,
    intervals: str = "jacobian",
    simpler: Sequence[Model | str] = (),
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    tie: str | Sequence[str] = (),
    own: Mapping[str, str] | None = None,
    share: str | Sequence[str] = (),
    specimen: str | None = None,
    start: Mapping[str, float] | None = None,
    robust: str | None = None,
    exclude: str | Sequence[str] = (),
    accuracy: Accuracy | str | None = None,
) -> Identification:
    """Identify the parameters of a model.

    Data, model, optimiser and objective may be given by name.

    Parameters
    ----------
    measurement : Measurement, TimeTest, str, Path, or a sequence of them
        The data, or their name as for `read`. Tests in time, alone or beside sweeps, are those of
        one specimen, each weighed by its own noise; sweeps alone are fitted as one.
    model : Model or str
        The model, or an expression such as ``"fractional-maxwell + inertia"``.
    optimiser : Optimiser or str, optional
        Who searches, with options as in ``"pso-paper:particles=40"``; the native solver by default.
    objective : Objective or str, optional
        How the misfit is measured; by default weighted by given standard deviations, else relative.
    budget, restarts, seed, intervals, simpler
        As in `springpot.identification.identify`.
    fix : mapping of str to float, optional
        Parameters that are held, in printed units: ``{"alpha": 0.5}``.
    bounds : mapping of str to (float, float), optional
        Ends between which parameters are sought, in printed units: ``{"k": (0.0, 200.0)}``.
    tie : str or sequence of str
        Parameters that follow from others, or keep an order: ``["k2 = 2*k1", "tau1 < tau2"]``;
        their numbers are in printed units.
    own : mapping of str to str, optional
        Parameters of which each level of a column has its own, and the column: ``{"k": "batch"}``;
        ``"file"`` where each sweep is a specimen, ``"batch,number"`` where several columns tell
        them, ``"batch/specimen"`` where they are of batches. All others are shared.
    share : str or sequence of str
        Parameters that all specimens share; where no `own` is given every other is their own.
    specimen : str, optional
        Columns whose levels are the specimens, in the place of files: ``"batch,number"``. They
        differ, which repeats do not: the intervals follow their scatter.
    start : mapping of str to float, optional
        Where the native solver begins too, in printed units.
    robust : {"huber", "soft-l1"}, optional
        Let numbers that lie far off count less.
    exclude : str or sequence of str
        Rows to leave out: ``"frequency=40..60"`` or ``["row=3", "temperature=20,frequency=1..2"]``.
    accuracy : Accuracy or str, optional
        What the instrument promises, such as ``1%,3mrad``, or as the data set says: the intervals
        hold it as an error that all tests have in common, and a misfit within it is good enough.

    Returns
    -------
    Identification
        Parameters with their intervals, residuals, predictions.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> omega = 2 * np.pi * np.arange(0.5, 14.0)
    >>> model = springpot.parse_model("fractional-maxwell")
    >>> theta = model.theta(k=400.0, c=150.0, alpha=0.6)
    >>> data = springpot.Measurement(omega, model.stiffness(theta, omega))
    >>> springpot.identify(data, "fractional-maxwell").theta.round(6)
    array([400. , 150. ,   0.6])
    """
    # Before the data are opened: a mistyped word is told at once.
    _check_search(intervals, budget, optimiser)
    tests = excluded(_tests(measurement), exclude)
    # Values come as they are printed: the units of the data must be known to read them.
    units = timetests.units_of(tests)
    held = constrained(_model(model), units, fix, bounds, tie)
    judged, tests = owning(held, tests, own, share, specimen)
    search: dict[str, Any] = {"budget": budget, "restarts": restarts, "seed": seed}
    search |= {"optimiser": _optimiser(optimiser), "objective": _objective(objective)}
    search |= {"intervals": intervals, "start": own_values(judged, units, start, "start")}
    search["simpler"] = [_model(part) for part in simpler]
    data = sweep_of(tests)
    if data is None:
        if robust is None:
            fit = timetests.identify(tests, judged, **search)
        else:
            fit = timetests.identify_robustly(tests, judged, robust, **search)
    else:
        search["robust"] = robust
        fit = identify_objects(data, judged, **search)
    if (promised := _promised(accuracy, tests)) is not None:
        fit = _calibrated(fit, tests, search["objective"], promised)
    # Floors are judged by a room above identification, which must not know it: so its judge is
    # handed down.
    return replace(fit, judge=partial(timetests.standing_of, promised=promised))


def _calibrated(
    fit: Identification, tests: Sequence[Test], objective: Objective | None, promised: Accuracy
) -> Identification:
    """A fit whose intervals hold what the instrument promises."""
    again = timetests.refound if sweep_of(tests) is None else refound
    scatter = np.sqrt(np.clip(np.diag(fit.theta_covariance), 0.0, None))
    return fit.calibrated(promised.calibration(fit, scatter, tests, again(fit, objective)))


def diagnose(
    measurement: Data,
    model: Model | str | None = None,
    *,
    effects: Sequence[Effect | str] | None = None,
    only: Sequence[str] | None = None,
    without: str | Sequence[str] = (),
    seed: int = 0,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    tie: str | Sequence[str] = (),
    own: Mapping[str, str] | None = None,
    share: str | Sequence[str] = (),
    specimen: str | None = None,
    exclude: str | Sequence[str] = (),
    accuracy: Accuracy | str | None = None,
    progress: Progress = silent,
) -> Diagnosis:
    """Find which physical effect is missing from a model.

    Parameters
    ----------
    measurement : Measurement, TimeTest, str, Path, or a sequence of them
        The data, or their name as for `read`; see `identify`.
    model : Model or str, optional
        The model to be judged; without it any linear passive material, so that only what is no part
        of the material can be missing.
    effects : sequence of Effect or str, optional
        Effects to look for beside the installed ones, also as text as in `springpot.law`; one of
        the same name takes the installed one's place.
    only : sequence of str, optional
        Names of the effects that may be named; by default all.
    without : str or sequence of str
        Names of effects that may not: a user knows that nothing slips.
    seed : int
        Of simulated noise; the same seed gives the same bits.
    fix, bounds, tie, own, share, specimen, exclude
        What is known beforehand, and rows to leave out; see `identify`.
    accuracy : Accuracy or str, optional
        What the instrument promises, such as ``1%,3mrad``: a misfit within it is no verdict on the
        model.
    progress : callable, optional
        Told in a few words what is being done.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.

    Examples
    --------
    >>> import springpot
    >>> found = springpot.diagnose("artificial-hidden", "fractional-maxwell")
    >>> found.verdict, found.best.effect
    ('effect-missing', 'inertia')
    """
    tests = excluded(_tests(measurement), exclude)
    held = constrained(_judged(model), timetests.units_of(tests), fix, bounds, tie)
    judged, tests = owning(held, tests, own, share, specimen)
    promised = _promised(accuracy, tests)
    data = sweep_of(tests)
    if data is None:
        progress(f"judging {judged.name}")
        known = library(effects, only, without)
        return timetests.diagnose(tests, judged, known, accuracy=promised)
    rng = np.random.default_rng(seed)
    known = library(effects, only, without, data)
    return diagnose_objects(data, judged, known, rng, progress, promised)


def discover(
    measurement: Data,
    model: Model | str | None = None,
    *,
    accept: Effect | str | Sequence[Effect | str] | None = None,
    effects: Sequence[Effect | str] | None = None,
    only: Sequence[str] | None = None,
    without: str | Sequence[str] = (),
    seed: int = 0,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    tie: str | Sequence[str] = (),
    own: Mapping[str, str] | None = None,
    share: str | Sequence[str] = (),
    specimen: str | None = None,
    exclude: str | Sequence[str] = (),
    accuracy: Accuracy | str | None = None,
    progress: Progress = silent,
    reached: Callable[[Any], None] | None = None,
    begun: Ladder | None = None,
    fitted: Fitted = unseen,
) -> Ladder:
    """Add missing effects one by one and watch the error fall.

    Parameters
    ----------
    measurement : Measurement, TimeTest, str, Path, or a sequence of them
        The data, or their name as for `read`; see `identify`.
    model : Model or str, optional
        Where to begin; without it any linear passive material.
    accept : Effect, str or sequence of them, optional
        Effects to accept, in this order, each by its name or as a law (`springpot.law`); without
        it the evidence decides.
    effects : sequence of Effect or str, optional
        Effects to look for beside the installed ones.
    only, without
        Which effects may be named; see `diagnose`.
    seed : int
        Of simulated noise.
    fix, bounds, tie, own, share, specimen, exclude
        What is known beforehand, and rows to leave out; see `identify`.
    accuracy : Accuracy or str, optional
        What the instrument promises, such as ``1%,3mrad``: a misfit within it is no verdict on the
        model.
    progress : callable, optional
        Told in a few words what is being done.
    reached : callable, optional
        Given the ladder as it stands after each step: what was reached is there even if the rest is
        interrupted.
    begun : Ladder, optional
        The answer for the first of what is accepted now, all else being the same: its steps are not
        computed again.
    fitted : callable, optional
        Given each effect as soon as it was fitted by itself: its ``effect``, the ``model`` with it
        and ``theta``; once more where a better fit comes.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.

    Examples
    --------
    >>> import springpot
    >>> ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept="inertia")
    >>> [f"{step.relative_rms:.1%}" for step in ladder.steps]
    ['24.1%', '4.4%']
    """
    tests = excluded(_tests(measurement), exclude)
    held = constrained(_judged(model), timetests.units_of(tests), fix, bounds, tie)
    begin, tests = owning(held, tests, own, share, specimen)
    promised = _promised(accuracy, tests)
    known = library(effects, only, without, sweep_of(tests))
    # None lets the evidence decide; an empty list accepts nothing.
    asked = None
    if accept is not None:
        asked = [_effect(effect, known, number) for number, effect in enumerate(_listed(accept), 1)]
        tests = numbered(tests, {column for effect in asked for column in effect.needs})
    data = sweep_of(tests)
    wanted = None if asked is None else [_met(effect, data) for effect in asked]
    if data is None:
        return timetests.discover(
            tests, begin, known, wanted, progress, reached, promised, begun, fitted
        )
    grown = begin
    # Grown as it will be: an effect may be refused because of one accepted before it.
    for effect in wanted or ():
        grown = grown.taking(effect)
    # What cannot be accepted is told before the first fit, not after it.
    require_conditions(grown, data)
    rng = np.random.default_rng(seed)
    return discover_objects(
        data, begin, known, rng, wanted, progress, reached, promised, begun, fitted
    )


def invent(
    measurement: Data,
    model: Model | str | None = None,
    *,
    along: str | Sequence[str] | None = None,
    seed: int = 0,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    tie: str | Sequence[str] = (),
    own: Mapping[str, str] | None = None,
    share: str | Sequence[str] = (),
    specimen: str | None = None,
    exclude: str | Sequence[str] = (),
    progress: Progress = silent,
) -> Invention:
    """Find the law that is missing from a model as a formula, where no library has it.

    Parameters
    ----------
    measurement : Measurement, str, Path, or a sequence of them
        Sweeps, or their name as for `read`.
    model : Model or str, optional
        What the law is sought beside; without it any linear passive material.
    along : str or sequence of str, optional
        Columns that a law may go with; by default all that were varied by themselves.
    seed : int
        Of simulated noise; the same seed gives the same bits.
    fix, bounds, tie, own, share, specimen, exclude
        What is known beforehand, and rows to leave out; see `identify`.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Invention
        The class of laws that these data cannot tell apart, the likeliest first; none where noise
        goes as far, or no law of the grammar follows what is missing.

    Raises
    ------
    SpringpotError
        If a name is unknown, a test is one in time, or model and data do not fit each other.

    Examples
    --------
    >>> import springpot
    >>> springpot.invent("artificial-hidden@frequency=..20", "fractional-maxwell").verdict
    'none'
    """
    tests = excluded(_tests(measurement), exclude)
    held = constrained(_judged(model), timetests.units_of(tests), fix, bounds, tie)
    judged, tests = owning(held, tests, own, share, specimen)
    data = sweep_of(tests)
    if data is None:
        raise DataError("a law is sought in sweeps: tests in time are read by diagnose")
    rng = np.random.default_rng(seed)
    columns = None if along is None else _listed(along)
    return invention.invent(data, judged, library(data=data), rng, columns, progress)


def _promised(accuracy: Accuracy | str | None, tests: Sequence[Test]) -> Accuracy | None:
    """What the instrument promises, as a user or else the data set says."""
    told = {test.provenance.get(PROMISED, "") for test in tests}
    # Of several instruments none speaks for the others.
    if accuracy is None and len(told) == 1:
        accuracy = told.pop() or None
    if isinstance(accuracy, str):
        return Accuracy.of(accuracy)
    return accuracy


def compare(
    measurement: Data,
    models: Model | str | Sequence[Model | str] | None = None,
    *,
    seed: int = 0,
    progress: Progress = silent,
) -> Comparison:
    """Judge models against the same noise floor.

    Their errors, where they fail, and how sure that is.

    Parameters
    ----------
    measurement : Measurement, TimeTest, str, Path, or a sequence of them
        The data, or their name as for `read`; see `identify`.
    models : Model, str or sequence of them, optional
        At least one; without it all installed models are ranked against what any linear passive
        material reaches.
    seed : int
        Of simulated noise.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Comparison
        A `springpot.comparison.Ranking` where no models are given.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if a model and the data do not fit each other.

    Examples
    --------
    >>> import springpot
    >>> models = ["fractional-maxwell", "fractional-maxwell + inertia"]
    >>> compared = springpot.compare("artificial-hidden", models)
    >>> [f"{judged.model.name}: {judged.error.relative_rms:.1%}" for judged in compared.judgements]
    ['fractional-maxwell: 24.1%', 'fractional-maxwell + inertia: 4.4%']
    """
    tests, rng = _tests(measurement), np.random.default_rng(seed)
    judged = None
    if models is not None:
        judged = [_model(model) for model in _listed(models)]
    data = sweep_of(tests)
    if judged is None:
        installed = list(plugins().items("model"))
        if data is None:
            return timetests.rank(tests, installed, library(), progress)
        return rank(data, installed, library(), rng, progress)
    if data is None:
        return timetests.compare(tests, judged, progress)
    return compare_objects(data, judged, rng, progress)


def predict(
    fit: Identification,
    test: Test | str | Path,
    *,
    level: float = INTERVAL,
) -> TestPrediction:
    """What a fit says of another test of the specimen, and whether that holds.

    Parameters
    ----------
    fit : Identification
        Of a sweep or of tests in time; `load` reads one from its file.
    test : Measurement, TimeTest, str or Path
        Any test that it was not fitted to, or its name as for `read`.
    level : float
        Probability of the band.

    Raises
    ------
    SpringpotError
        If the test lacks a condition that the model needs, or its unit is of another kind.

    Examples
    --------
    >>> import springpot
    >>> fit = springpot.identify("artificial-hidden@frequency=..5", "fractional-maxwell + inertia")
    >>> springpot.predict(fit, "artificial-hidden@frequency=5..").kind
    'sweep'
    """
    if not isinstance(fit, Identification):
        raise DataError(f"{_shown(fit)} is no fit: give what `identify` or `load` returned")
    asked = _tests(test)
    if len(asked) > 1:
        raise DataError(f"{len(asked)} tests: predict one at a time")
    return timetests.predict_test(fit, asked[0], level)


def mastercurve(
    measurement: Data,
    *,
    column: str = "temperature",
    reference: float | str | None = None,
    vertical: bool = True,
    objective: Objective | str | None = None,
) -> MasterCurve:
    """Bring sweeps, relaxations, or creep onto one curve without a model.

    The laws of temperature are judged by the free factors.

    Parameters
    ----------
    measurement : Measurement, TimeTest, str, Path, or a sequence of them
        The data, or their name as for `read`: sweeps, or relaxations or creep each at one
        temperature.
    column : str
        The condition whose levels are shifted: ``"temperature"``, ``"amplitude"`` or any column of
        the data.
    reference : float or str, optional
        Level at which the factors are one: in degC, or text such as ``"25degC"`` or ``"298.15K"``.
    vertical : bool
        Whether the stiffness has a factor for each level too.
    objective : Objective or str, optional
        How the misfit is measured; by default weighted by given standard deviations, else relative.

    Raises
    ------
    SpringpotError
        If a name is unknown, or the data have no such levels.

    Examples
    --------
    >>> import springpot
    >>> curve = springpot.mastercurve("nist-srm2491", reference="20degC")
    >>> [round(level.a, 2) for level in curve.levels]
    [1.63, 1.27, 1.0, 0.8, 0.66, 0.54]
    """
    # Words first: a mistyped one is told before a large file is read.
    if isinstance(reference, str):
        reference = superposition.level_of(reference, column)
    how = _objective(objective)
    tests = _tests(measurement)
    sweep = sweep_of(tests)
    data: Measurement | list[TimeTest] = [test for test in tests if isinstance(test, TimeTest)]
    if sweep is not None:
        data = sweep
    elif len(data) < len(tests):
        raise DataError(
            "a master curve is made of sweeps or of tests in time, not of several kinds together"
        )
    return superposition.mastercurve(
        data, column=column, reference=reference, vertical=vertical, objective=how
    )


def library(
    effects: Sequence[Effect | str] | None = None,
    only: Sequence[str] | None = None,
    without: str | Sequence[str] = (),
    data: Measurement | None = None,
) -> list[Effect]:
    """The installed effects, and `effects` beside them or in their places.

    Parameters
    ----------
    effects : sequence of Effect or str, optional
        One of the same name as an installed one takes its place.
    only, without : sequence of str
        Names of those that are wanted, of all by default, and of those that are not.
    data : Measurement, optional
        Those of which a law knows the columns and sizes.

    Raises
    ------
    SpringpotError
        If a name is unknown, or nothing is left.

    Examples
    --------
    >>> from springpot.api import library
    >>> len(library(["inertia"])) == len(library())
    True
    >>> [effect.name for effect in library(only=["inertia", "time-delay"], without="inertia")]
    ['time-delay']
    """
    by_name = {effect.name: effect for effect in plugins().items("effect")}
    if effects is not None:
        # One of the same name takes the installed one's place: so a user may try another version of
        # an effect.
        for own in [_effect(effect, ()) for effect in _listed(effects)]:
            by_name[own.name] = own
    every = list(by_name.values())
    # Looked up as any name: by an alias too, and one that is unknown is told.
    wanted = by_name.keys() if only is None else {_effect(name, every).name for name in only}
    unwanted = {_effect(name, every).name for name in _listed(without)}
    chosen = [_met(effect, data) for effect in every if effect.name in wanted - unwanted]
    if not chosen:
        raise OptionError("no effect is left that may be named: name more, or leave out fewer")
    return chosen


def _met(effect: Effect, data: Measurement | None) -> Effect:
    """An effect with what it takes from the data; one by levels waits for its fit."""
    if data is None or effect.by_levels:
        return effect
    return effect.bound_to(data.points)


def _effect(effect: Effect | str, among: Sequence[Effect], number: int = 1) -> Effect:
    if isinstance(effect, Effect):
        return effect
    if not isinstance(effect, str):
        raise ModelError(f"an effect is an Effect or its name, not {_shown(effect)}")
    # What the user brings goes before what is installed under the same name.
    for known in among:
        if known.name == effect:
            return known
    return effect_of(effect, number)


def _tests(data: Data) -> list[Test]:
    """The tests that a user gives or names: a single sweep, or several with one in time."""
    given = [data]
    # Text is a sequence too, of letters.
    if isinstance(data, Sequence) and not isinstance(data, str):
        given = list(data)
    tests: list[Test] = []
    for each in given:
        if isinstance(each, Measurement | TimeTest | OtherTest):
            tests.append(each)
        elif isinstance(each, str | PurePath):
            tests += open_tests(each)
        else:
            raise DataError(f"data are a test, a path or a name, not {_shown(each)}")
    if not tests:
        raise DataError("there are no data: give a test, a path or a name")
    sweeps = [test for test in tests if isinstance(test, Measurement)]
    # Sweeps alone are one measurement; beside tests in time each weighs by its own noise.
    if len(tests) == len(sweeps) > 1:
        return [joined(sweeps)]
    return tests


def _listed(given: Any) -> Sequence[Any]:
    """One thing is a list of one."""
    # A string is a sequence too, of letters.
    if isinstance(given, str) or not isinstance(given, Sequence):
        return [given]
    return given


def _model(model: Model | str) -> Model:
    if not isinstance(model, str | Model):
        raise ModelError(
            f"a model is a Model or an expression like 'fractional-maxwell', not {_shown(model)}"
        )
    if isinstance(model, str):
        return parse_model(model)
    return model


def _judged(model: Model | str | None) -> Model:
    """A model, or any material where none is given."""
    if model is None:
        return any_material()
    return _model(model)


def _shown(thing: object) -> str:
    """Something that was given in place of something else, in few characters."""
    # An array prints itself over many lines, and an error is one.
    line = " ".join(repr(thing).split())
    return f"{line:.40} ({type(thing).__name__})"


def _objective(objective: Objective | str | None) -> Objective | None:
    if not isinstance(objective, str):
        return objective
    by_name: Objective = plugins().find("objective", objective)
    return by_name


def _check_search(intervals: str, budget: int | None, optimiser: Optimiser | str | None) -> None:
    """Refuse what is no kind of interval, and a budget of nobody."""
    if intervals not in INTERVALS:
        raise OptionError(f"intervals are {', '.join(INTERVALS)}, not '{intervals}'")
    if budget is not None and optimiser is None:
        raise OptionError(
            "a budget is an optimiser's: name one, or leave the budget out; the native solver ends"
            " by itself"
        )


def _optimiser(optimiser: Optimiser | str | None) -> Optimiser | None:
    if not isinstance(optimiser, str):
        return optimiser
    return optimiser_of(optimiser)
