"""Identification from tests in time, alone or with frequency sweeps of the same specimen.

`identify` runs the native solver, or gives the same sum of squares to another optimiser as an
`InTimeProblem`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np

from springpot.distributions import student
from springpot.errors import ModelError, SpringpotError
from springpot.identification.convex import ConvexSpectrum
from springpot.identification.fitting import (
    notes_on_specimens,
    refuse_search,
    require_robust,
    start_at,
)
from springpot.identification.material import is_material
from springpot.identification.problem import Objective, SpecimenProblem
from springpot.identification.result import Identification
from springpot.identification.robust import until_at_rest
from springpot.identification.runs import Optimiser
from springpot.identification.searching import NATIVE, best_run
from springpot.identification.space import box_of
from springpot.identification.value import LOST
from springpot.misfit.error import times
from springpot.misfit.residuals_of_tests import (
    Test,
    TestPart,
    parts_of_specimen,
    reach_of,
)
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model, sorted_out
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, VERDICT

from ..numerics import NEGLIGIBLE, NORMAL, SMALLEST, rms
from .exponentials import quick_parts
from .hypotheses import FitResiduals
from .material import FoundLines, UntoldError, coordinates_around, spectral
from .native import STARTS, Minimum, TimeSearch
from .score import TimeScan
from .specimen import at_rigs, reference_of, require_tests, residual_of, rig_of_sweeps
from .temperatures import is_material_alone
from .valley import MaterialTangent, with_intervals

FASTEST = 10.0
"""By how much the stiffness of the shortest time may exceed what was measured.

Glass lies beyond it.
"""


class InTimeProblem(SpecimenProblem):
    """Minimise the residuals of tests over their noise.

    Parameters
    ----------
    model : Model
        What is fitted.
    parts : sequence of TestPart
        To what, each with its weight.
    reference : float
        Temperature in kelvin at which shifts are one.
    size, reach : float
        Typical stiffness and largest displacement of the tests.
    """

    def __init__(
        self, model: Model, parts: Sequence[TestPart], reference: float, size: float, reach: float
    ) -> None:
        self.model, self.parts, self.reference = model, list(parts), reference
        slowest = min(part.test.seen[0] for part in parts)
        self.space = box_of(model, FASTEST * size, max(1.0, 1.0 / slowest), reach)

    @classmethod
    def alike(
        cls, model: Model, tests: Sequence[Test], objective: Objective, scale: float | None
    ) -> InTimeProblem:
        """Tests whose noise nobody knows, side by side.

        Within a test samples weigh as the objective has it; beside others each of its numbers
        weighs as one of the size of their root mean square. `scale` is the largest stiffness of the
        box, where it is given.
        """
        parts = []
        for part in parts_of_specimen(tests):
            even = part.with_sd(np.full(len(part.measured), rms(part.measured)))
            parts.append(even.weighed_by(objective))
        size = max(part.stiffness for part in parts) if scale is None else scale / FASTEST
        return cls(model, parts, reference_of(tests), size, reach_of(parts))

    @property
    def nothing(self) -> float:
        """Objective of no response."""
        return float(np.sum([np.sum(part.signal**2) for part in self.parts]))

    def with_tests(self, tests: Sequence[Test]) -> InTimeProblem:
        """The same on other numbers of the same tests."""
        pairs = zip(self.parts, tests, strict=True)
        twin = copy(self)
        twin.parts = [replace(part, test=test).with_sd(part.sd) for part, test in pairs]
        return twin

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., m) and their derivative (..., m, d)."""
        rows = x.reshape(-1, x.shape[-1])
        pairs = [self._one(row) for row in rows]
        value = np.stack([residual for residual, _ in pairs]).reshape(*x.shape[:-1], -1)
        slopes = np.stack([by_x for _, by_x in pairs])
        return value, slopes.reshape(*value.shape, x.shape[-1])

    def _one(self, x: Real) -> tuple[Real, Real]:
        theta = self.space.theta(x)
        # Counted here, where every evaluation passes, so that none goes past the recorder.
        self.tally.points += 1
        try:
            value, by_theta = residual_of(self.parts, self.model, theta, self.reference)
        except SpringpotError:
            # Somewhere in the box a model may leave what can be followed: an optimiser goes on from
            # elsewhere.
            count = sum(part.count() for part in self.parts)
            return np.full(count, np.inf), np.zeros((count, len(x)))
        return value, by_theta @ self.space.jacobian(x)


BUDGET = 2000
"""Evaluations of an optimiser.

Each takes some milliseconds, so that this is a matter of ten seconds.
"""


def identify(
    tests: Sequence[Test] | Test,
    model: Model,
    *,
    seeds: Sequence[Real] = (),
    thorough: bool = True,
    optimiser: Optimiser | None = None,
    budget: int | None = None,
    restarts: int | None = None,
    seed: int | None = None,
    noise: Sequence[Real | None] | None = None,
    near: bool = False,
    start: Mapping[str, float] | None = None,
    simpler: Sequence[Model] = (),
    intervals: str = "slopes",
    objective: Objective | None = None,
) -> Identification:
    """Identify the parameters of a model from tests of one specimen, each weighed by its own noise.

    Parameters
    ----------
    tests : TimeTest, Measurement, or a sequence of them
        At least one in time.
    model : Model
        Any model whose parts have a meaning in time, with effects of the tests themselves or
        without.
    seeds : sequence of ndarray, shape (p,)
        Further starts, in the units of the first test in time.
    thorough : bool
        Whether other starts are looked for too; else the search begins at the seeds and nowhere
        else.
    optimiser : Optimiser, optional
        Another way to the same minimum, in the box of the native solver's problem; each test weighs
        as there.
    budget, restarts, seed : int, optional
        Of the optimiser: evaluations of each run, number of runs, and of the generator.
    noise : sequence of ndarray, shape (n,), or None, optional
        Standard deviation of each sample of each test, where it is known better than the signal
        itself tells.
    near : bool
        Whether the only seed is so near that a few exact steps end the search.
    start : mapping of str to float, optional
        Where the native solver begins too, in the units of the first test in time; parameters that
        are left out start where they fit best beside these.
    simpler : sequence of Model
        Models that the model contains, at whose fits the native solver begins too.
    intervals : {"slopes", "jacobian", "profile", "bootstrap"}
        Where the intervals come from: by the slopes alone, or with those where a parameter without
        an end is elsewhere, or the last two of `springpot.identify`.
    objective : Objective, optional
        How samples of a test weigh among each other; by default by their noise.

    Returns
    -------
    Identification
        Parameters with intervals, and each test's error beside its noise floor, together and alone.

    Raises
    ------
    SpringpotError
        If model and tests do not fit each other.

    Notes
    -----
    A test that the model misses by more than noise, when fitted alone, weighs as if its noise were
    that large, and samples whose misses are alike count once: so no test outvotes another by a
    precision that the model cannot use.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.measurement import TimeTest
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 60)
    >>> exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), t)
    >>> identify(TimeTest.of_relaxation(t, exact, "kPa"), model).theta.round(3)
    array([400. ,  60. ,   0.5])
    """
    if not isinstance(tests, Sequence):
        tests = [tests]
    given = list(tests)
    if not given:
        raise ModelError("there is no test to identify a model from")
    model = at_rigs(model, given)
    if objective is not None:
        parts = [part.weighed_by(objective) for part in parts_of_specimen(given, noise)]
        given, noise = [part.test for part in parts], [part.sd for part in parts]
    if optimiser is not None and optimiser.name != NATIVE:
        refuse_search(model, optimiser, start)
    fits = [identify(given, part, noise=noise) for part in simpler]
    known = {*model.names, *model.origins}
    for begun in (start, *(part.model.named(part.theta) for part in fits)):
        if mine := {name: value for name, value in (begun or {}).items() if name in known}:
            seeds = [*seeds, start_at(model, mine, lambda rest: identify(given, rest, noise=noise))]
    effort = (budget or BUDGET, restarts, seed)

    def fitted(model: Model) -> Identification:
        return _fitted(given, model, seeds, thorough, optimiser, effort, noise, near, intervals)

    if thorough:
        result = _at_best_rig(fitted, model, given)
    else:
        result = fitted(model)
    if objective is not None:
        result = replace(result, objective=objective.name)
    parts = parts_of_specimen(given, noise)
    left = FitResiduals.of(result, parts)
    # One noise in all answers: that about the model, and not what the signal alone tells.
    return _told(replace(result, parts=left.rows(parts, left.noise, result.tests)))


def identify_robustly(
    tests: Sequence[Test], model: Model, loss: str, **search: Any
) -> Identification:
    """The same with samples that lie far off counting less, by the weights of a sweep's robust fit.

    Parameters
    ----------
    tests, model
        As of `identify`.
    loss : {"huber", "soft-l1"}
        By which a sample counts less, as far as it is off in the scatter of its own test.
    **search
        Options of `identify`, but for the noise.

    Raises
    ------
    SpringpotError
        As of `identify`, or if another search or other intervals than its own are wanted.
    """
    wanted: Optimiser | None = search.get("optimiser")
    intervals = search.get("intervals", "jacobian")
    require_robust(loss, wanted.name if wanted else NATIVE, intervals)
    # Intervals are asked for once, of the fit in which all counts have come to rest.
    fit = identify(tests, model, **search | {"intervals": "slopes"})
    objective, parts = search.get("objective"), parts_of_specimen(tests)
    if objective is not None:
        parts = [part.weighed_by(objective) for part in parts]

    def off(fit: Identification) -> list[Real]:
        left = [part.over_noise(fit.model, fit.theta, fit.reference).value for part in parts]
        # Of a fit that goes through its data nothing is far off.
        return [each / max(NORMAL * float(np.median(np.abs(each))), NEGLIGIBLE) for each in left]

    def again(fit: Identification, counts: list[Real], intervals: str = "slopes") -> Identification:
        options: dict[str, Any] = {"thorough": False, "intervals": intervals}
        options["noise"] = [part.sd / count for part, count in zip(parts, counts, strict=True)]
        return identify(tests, fit.model, seeds=[fit.theta], **options)

    fit, counts = until_at_rest(fit, off, again, loss)
    fit = again(fit, counts, intervals)
    half = sum(int(np.count_nonzero(count**2 < 0.5)) for count in counts)
    told = f"{loss}: {half} of {sum(map(len, counts))} numbers count less than half"
    return replace(fit, notes=(*fit.notes, told if half else f"{loss}: no number lies off"))


def refound(
    fit: Identification, objective: Objective | None = None
) -> Callable[[Sequence[Test]], Mapping[str, float]]:
    """What finds the parameters of other tests, by name, from where a fit has ended."""

    def again(moved: Sequence[Test]) -> Mapping[str, float]:
        found = identify(
            moved, fit.model, objective=objective, seeds=[fit.theta], thorough=False, near=True
        )
        return found.model.named(found.theta)

    return again


def _at_best_rig(
    fitted: Callable[[Model], Identification],
    model: Model,
    tests: Sequence[Test],
) -> Identification:
    """The fit with one rig for all tests; where that fails, with one that only the sweeps have."""
    apart = rig_of_sweeps(model, tests)
    if apart is None:
        return fitted(model)
    try:
        one = fitted(model)
    except ModelError:
        # No test in time can have such an effect: what is left is that the sweeps alone do.
        return fitted(apart)
    if max(test.over_floor for test in one.tests) <= VERDICT.agrees:
        return one
    other = fitted(apart)
    if one.cost < VERDICT.agrees * other.cost:
        return one
    return other


def _fitted(
    given: Sequence[Test],
    model: Model,
    seeds: Sequence[Real],
    thorough: bool,
    optimiser: Optimiser | None,
    effort: tuple[int, int | None, int | None],
    noise: Sequence[Real | None] | None,
    near: bool,
    intervals: str,
) -> Identification:
    """The fit of a model whose effects act where they are marked to."""
    began = perf_counter()
    # Before any work: what cannot be fitted is told in one line.
    require_tests(model, given)
    parts = parts_of_specimen(given, noise)
    reference = reference_of(given)
    if model.own and (thorough or not len(seeds)):
        seeds, thorough = [*seeds, *_of_levels(model, parts, reference)], False
    elif thorough or not len(seeds):
        seeds = [*seeds, *_scanned(given, model, parts, noise)]
    # Of any material the spectrum itself is sought, which is a problem of another kind.
    if is_material(model):
        search, found = _of_material(model, parts, reference, seeds)
        result = search.result(found, perf_counter() - began)
        tangent = MaterialTangent.of(result.model, result.theta, found.parts, reference)
        # A fit on the way is judged by the lines that carry, of which each counts.
        if intervals == "slopes":
            return _beside_lines(result, tangent.ends_of_amounts(_quantile(result)))
        return _among_lines(result, tangent, intervals)
    # Without a seed there is no other place to begin at.
    search = TimeSearch(model, parts, reference, seeds, thorough or not len(seeds))
    found = _native(search, near)
    result = search.result(found, perf_counter() - began)
    if optimiser is not None and optimiser.name != NATIVE:
        result, found = _by_optimiser(search, found, optimiser, effort, began)
    return with_intervals(result, search, found, intervals, effort[2] or 0)


def _quantile(result: Identification) -> float:
    """Standard deviations from a value to the end of its interval."""
    return student(INTERVAL, max(result.dof, 1.0))


def _beside_lines(result: Identification, amounts: Sequence[tuple[float, float]]) -> Identification:
    """A material with the intervals of its K_e and c that other lines leave."""
    low, high = result.low.copy(), result.high.copy()
    for i, ends in enumerate(amounts):
        low[i], high[i] = ends
    return replace(result, low=low, high=high)


def _among_lines(
    result: Identification, tangent: MaterialTangent, intervals: str
) -> Identification:
    """A material with all lines near it, and what is known of it as wide as these allow."""
    moves, search = tangent.leanings, tangent.search
    # K_e and c are parameters whatever they carry, and so are those of effects.
    before = np.ones(len(moves), dtype=bool)
    before[2 : search.count] = tangent.carries[2:]
    slopes = np.eye(len(moves))[:, before]
    spread = slopes @ result.theta_covariance @ slopes.T + moves @ moves.T
    low, high = np.zeros(len(moves)), np.full(len(moves), np.inf)
    low[before], high[before] = result.low, result.high
    notes = result.notes
    if intervals == "bootstrap":
        # Fits of simulated tests would hold the lines where these tests have put them.
        notes = (*notes, "intervals of any material are as wide as other lines leave them")
    found = replace(
        result,
        model=search.model,
        theta=search.theta(search.weights, tangent.u),
        low=low,
        high=high,
        slopes=np.eye(len(moves)),
        spread=spread,
        notes=notes,
    )
    quantile = _quantile(result)
    stiffness, reach = found.theta[0], quantile * float(np.sqrt(spread[0, 0]))
    at_rest = max(stiffness - reach, 0.0), stiffness + reach
    return _beside_lines(found, tangent.ends_of_amounts(quantile) or [at_rest])


def _told(fit: Identification) -> Identification:
    """The fit with notes on what its numbers do not say, the gravest first."""
    notes = [*fit.notes, *notes_on_specimens(fit.model, fit.words)]
    if not fit.converged:
        notes.append("the search did not come to rest: the parameters may be improved by more data")
    for test in fit.parts:
        # One alone has no others: that its search was cut off is told above.
        if len(fit.parts) > 1 and not test.agrees:
            ratios = (
                f"{times(test.over_floor)} its noise floor with common parameters,"
                f" {times(test.over_floor_alone)} with its own"
            )
            notes.append(f"{test.name} does not agree with the other tests: {ratios}")
    if fit.on_sweeps:
        names = ", ".join(fit.on_sweeps)
        notes.append(f"{names}: of the rig of the sweeps; the tests in time are free of it")
    for parameter, value, low, high in zip(
        fit.model.parameters, fit.theta, fit.low, fit.high, strict=True
    ):
        if parameter.detail:
            continue
        wide = parameter.scale == "log" and high > LOST * max(low, SMALLEST)
        if value in (parameter.lower, parameter.upper):
            notes.append(f"{parameter.name} ends at its bound {value:g}")
        elif not np.isfinite(high) or wide:
            notes.append(f"{parameter.name} is hardly determined by these tests")
    return replace(fit, notes=tuple(notes))


def _native(search: TimeSearch, near: bool) -> Minimum:
    """All tests together; where there are several, each weighs as it is missed alone."""
    parts, starts = search.parts, search.starts()
    if near:
        u, evaluations, converged = search.ended(parts, starts[0], 0)
    else:
        u, evaluations, converged = search.solved(parts, starts)
    together = [search.ratio(part, u) for part in parts]
    # A test by itself outvotes no other.
    if len(parts) == 1:
        return Minimum(u, parts, together, evaluations, converged)
    # Each begins where all together ended, so that alone it can only do better.
    parts, alone, spent = _weighed(
        parts, together, lambda part: (search, *search.solved([part], [u])[:2])
    )
    # Once more with the new weights, from where the first ones led.
    u, more, converged = search.solved(parts, [u])
    return Minimum(u, parts, alone, evaluations + spent + more, converged)


def _by_optimiser(
    search: TimeSearch,
    native: Minimum,
    optimiser: Optimiser,
    effort: tuple[int, int | None, int | None],
    began: float,
) -> tuple[Identification, Minimum]:
    """The minimum that another optimiser finds; `effort`: its budget, restarts and seed."""
    model, parts = search.model, native.parts
    if model.of_tests:
        raise ModelError(
            f"{model.name}: effects of a test are fitted by the native solver;"
            " leave the optimiser out"
        )
    # Weighed as in the native search, so that both look for the same minimum.
    problem = InTimeProblem(model, parts, search.reference, *search.sizes)
    best, notes = best_run(problem, optimiser, *effort)
    u = search.coordinates.u(best.theta.copy(), search.size)
    found = replace(native, u=u, evaluations=best.evaluations, converged=best.status != "budget")
    result = search.result(found, perf_counter() - began)
    # The theta that was found, not one that went to search coordinates and back.
    told = replace(
        result,
        theta=best.theta,
        optimiser=optimiser.name,
        status=best.status,
        converged=found.converged,
        notes=(*result.notes, *notes),
    )
    return told, found


def _weighed(
    parts: Sequence[TestPart],
    together: Sequence[float],
    fitted: Callable[[TestPart], tuple[TimeSearch, Real, int]],
) -> tuple[list[TestPart], list[float], int]:
    """Parts that weigh as each is missed even when fitted alone.

    Also the errors over the noise that they have alone, which are none larger than those together,
    and evaluations spent.
    """
    weighed, alone, evaluations = [], [], 0
    for part, ratio in zip(parts, together, strict=True):
        search, u, spent = fitted(part)
        evaluations += spent
        alone.append(min(ratio, search.ratio(part, u)))
        weighed.append(part.with_scale(search.scale(part, u)))
    return weighed, alone, evaluations


def _scanned(
    given: Sequence[Test],
    model: Model,
    parts: Sequence[TestPart],
    noise: Sequence[Real | None] | None,
) -> list[Real]:
    """Starts (p,) with the last effect where a scan of the model without it puts it.

    A threshold has a minimum for each way to share the force between it and the rest, a drift that
    a material has taken for slow modes never comes back, and a mass that swings has a minimum for
    each cycle that it misses: natural sizes find any of them.
    """
    inside, beside, _ = sorted_out(model)
    effects = [each.effect for each in beside]
    # Of the tests alone where no nonlinear force stands there; any material is sought with them.
    if not effects and not is_material(model):
        effects = list(model.of_tests)
    if not effects and any(test.control == "force" for test in given):
        effects = [each.effect for each in inside]
    if not effects:
        return []
    last = effects[-1]
    try:
        base = identify(given, model - last, noise=noise)
        entries = TimeScan(base, quick_parts(parts)).entries([last])
    except SpringpotError:
        # It has no law in such a test, or nothing is left to fit: natural sizes are left.
        return []
    best = entries.get(last.name, [])[:STARTS]
    starts = []
    for entry in best:
        # With the model's own parameters made way for the force, and as they were: the linear step
        # may lead astray.
        starts += [entry.start(base, model, moved=True), entry.start(base, model, moved=False)]
    return starts


def _of_levels(model: Model, parts: Sequence[TestPart], reference: float) -> list[Real]:
    """Starts (p,) of levels with parameters of their own: as all alike, and from there alone."""
    one, places = model.of_any_level, model.places
    tests = [part.test for part in parts]
    alike = identify(tests, one, noise=[part.sd for part in parts]).theta
    apart, level = np.tile(alike, (len(places), 1)), list(map(model.level_of, tests))
    for number in dict.fromkeys(each for each in level if each is not None):
        mine = [part for part, each in zip(parts, level, strict=True) if each == number]
        search = TimeSearch(one, mine, reference, [alike], thorough=False)
        apart[number] = search.theta(search.solved(mine, search.starts())[0])
    start, own = model.at_all_levels(np.median(apart, axis=0)), places[0] != places[-1]
    start[places[:, own]] = apart[:, own]
    return [start, model.at_all_levels(alike)]


def _of_material(
    model: Model, parts: Sequence[TestPart], reference: float, seeds: Sequence[Real]
) -> tuple[TimeSearch, Minimum]:
    """Any linear passive material, whose spectrum the tests choose."""
    # For its sizes only: the spectrum has a way of its own to its minimum.
    typical = TimeSearch(model, parts, reference)
    around = len(model.material.parameters)
    coordinates = coordinates_around(model, typical)
    own = [seed[len(seed) - len(model.parameters) + around :] for seed in seeds]

    # The lines are chosen anew by each fit: every one has a search of its own, in other
    # coordinates.
    def fitted(found: FoundLines) -> tuple[TimeSearch, Real]:
        search = TimeSearch(found.model, parts, reference, thorough=False)
        return search, search.coordinates.u(found.theta, search.size)

    def alone_in(part: TestPart) -> tuple[TimeSearch, Real, int]:
        if part.lines is not None:
            # What it has of the model is some other material, or no more is needed to follow it.
            search, u = _by_lines(part, part.lines, reference)
            if is_material_alone(model, part) or search.scale(part, u) == 1.0:
                return search, u, 0
        found = spectral(model, [part], reference, coordinates, own)
        return *fitted(found), found.evaluations

    found = spectral(model, parts, reference, coordinates, own)
    search, u = fitted(found)
    evaluations = found.evaluations
    alone = [search.ratio(part, u) for part in parts]
    if len(parts) > 1:
        parts, alone, spent = _weighed(parts, alone, alone_in)
        found = found.again(parts)
        search, u = fitted(found)
        evaluations += spent + found.evaluations
    # Only of all tests together: what one of them leaves open another may tell.
    if found.untold:
        raise UntoldError(found)
    return search, Minimum(u, parts, alone, evaluations, True)


@lru_cache(maxsize=256)
def _by_lines(part: TestPart, lines: ConvexSpectrum, reference: float) -> tuple[TimeSearch, Real]:
    """A test as any material alone follows it, whatever else other tests have."""
    alone = Model("material", Continuum(tuple(lines.rates.tolist())))
    search = TimeSearch(alone, [part], reference, thorough=False)
    return search, search.coordinates.u(lines.amounts, search.size)
