"""The contracts of a model and of an effect; of its law in time on a made-up test of each kind."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from springpot.errors import DataError
from springpot.identification.material import is_material
from springpot.identification.native import fit
from springpot.measurement.imposed import Loading
from springpot.measurement.recording import recorded
from springpot.measurement.timetest import TimeTest
from springpot.misfit.residuals_of_tests import InTimePart
from springpot.rheology.drawing import drawing_of
from springpot.rheology.effect import CONTROLS, Effect, Layer
from springpot.rheology.elements import Continuum, spring, springpot
from springpot.rheology.model import Family, Model
from springpot.rheology.nodes import parallel, series
from springpot.rheology.points import Points, Real
from springpot.timetests.specimen import Scales, tries_of

from ..numerics import ALIKE, DIFFERENCE, NEGLIGIBLE, PRINTED, ROUNDING
from .networks import (
    CONTRACT,
    OMEGA,
    POINTS,
    SAMPLE,
    Aspect,
    cited,
    complaints,
    derivative,
    name_and_summary,
    network_aspects,
    sample,
    sample_measurement,
)

RATES = (0.03, 1.0, 40.0)
"""Lines [rad/s] below, within and above the frequencies at which a material is checked."""


def check_model(
    model: Model | Family, *, passive: bool = False, skip: Collection[str] = ()
) -> list[str]:
    """What is wrong with a model, as plain sentences; of a family, with some of its members.

    Aspects: ``words`` (name, summary, citation, drawing), ``parameters``, ``shapes``,
    ``derivatives`` (exact, by Cauchy's integral), ``finite`` (over the search box), ``units``,
    ``pure``, ``search`` (the search form inverts and keeps the bounds) and ``passive``. Of a
    material whose spectrum the data choose everything is checked with lines in it, whether
    ``passive`` is asked for or not, and ``spectrum``: that a fit follows a network of springs,
    springpots and dashpots.

    Parameters
    ----------
    model : Model or Family
        The model.
    passive : bool
        Also demand that storage and loss are never negative.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    if isinstance(model, Family):
        return _check_family(model, passive, skip)
    if is_material(model):
        return _check_material(model, skip)
    aspects = {
        "words": lambda: _words(model),
        **network_aspects(model),
        "search": lambda: _search(model),
    }
    if passive:
        aspects["passive"] = lambda: _passive(model)
    return complaints(aspects, skip)


def _check_family(family: Family, passive: bool, skip: Collection[str]) -> list[str]:
    sentences = complaints(
        {"words": lambda: name_and_summary(family.name, family.summary, family.aliases)}
    )
    for number in (1, 3):
        expected = f"{family.name.removesuffix('-N')}-{number}"
        member = family.member(expected)
        # A member's name is typed and stored: it must lead back to the same member.
        if member is None or member.base != expected:
            sentences.append(
                f"words: member {number} is called {member and member.base}, not {expected}"
            )
        else:
            sentences += [
                f"{expected}: {says}" for says in check_model(member, passive=passive, skip=skip)
            ]
    return sentences


def _check_material(model: Model, skip: Collection[str]) -> list[str]:
    """The contract with the lines that a fit may choose.

    Without any there is only a spring beside a dashpot.
    """
    lined = replace(model, material=Continuum(RATES))
    aspects = {
        "words": lambda: _words(model),
        **network_aspects(lined),
        "passive": lambda: _passive(lined),
    }
    return complaints({**aspects, "spectrum": lambda: _spectrum(model)}, skip)


def _spectrum(model: Model) -> Iterator[str]:
    """Any network of springs, springpots and dashpots is one of the materials."""
    data = sample_measurement()
    theta = sample(SAMPLE.parameters, np.random.default_rng(CONTRACT.seed), (1,))[0]
    exact = SAMPLE.stiffness(theta, data.points)
    fitted = fit(model, replace(data, stiffness=exact))
    left = np.abs(fitted.model.stiffness(fitted.theta, data.points) / exact - 1.0)
    if not left.max() < CONTRACT.followed:
        yield (
            f"a spring beside a spring in series with a springpot is followed to {left.max():.1e}"
            " only"
        )
    if np.any(fitted.theta < 0.0):
        yield "a weight of the spectrum is negative"


def _words(model: Model) -> Iterator[str]:
    yield from name_and_summary(model.base, model.summary, model.aliases)
    yield from cited(model.citation)
    if len(drawing_of(model).splitlines()) < 2:
        yield "the drawing is no picture of a network"


def _search(model: Model) -> Iterator[str]:
    form = model.search
    if form is None:
        return
    x = sample(form.parameters, np.random.default_rng(CONTRACT.seed), (4,))
    # Search points keep the order of the form, as they do wherever one is searched.
    if form.ordered:
        x[:, list(form.ordered)] = np.sort(x[:, list(form.ordered)], axis=-1)
    if not np.allclose(form.from_elements(form.to_elements(x)), x, rtol=1e-8):
        yield "from_elements does not undo to_elements"
    numeric = np.stack([derivative(form.to_elements, row, 1e-3) for row in x])
    # Written this way round, a derivative that is no number fails too.
    if not np.max(np.abs(form.jacobian(x) - numeric)) < CONTRACT.exact * np.max(np.abs(numeric)):
        yield "jacobian is not the derivative of to_elements"
    # In any order: an optimiser knows nothing of the order, and the form has to mend it.
    free = sample(form.parameters, np.random.default_rng(CONTRACT.seed), (50,))
    theta = form.to_elements(form.repaired(free))
    for parameter, values in zip(model.parameters, theta.T, strict=True):
        if np.any(values < parameter.lower) or np.any(values > parameter.upper):
            yield f"a lawful search point gives {parameter.name} beyond its bounds"


def _passive(model: Model) -> Iterator[str]:
    rng = np.random.default_rng(CONTRACT.seed)
    theta = sample(model.parameters, rng, (200,))
    # Orders at the very ends of their range are lawful too.
    for i, parameter in enumerate(model.parameters):
        if parameter.scale == "linear" and np.isfinite(parameter.upper):
            theta[::3, i] = rng.choice([parameter.lower, parameter.upper], len(theta[::3]))
    stiffness = model.stiffness(theta, OMEGA)
    for name, part in (("storage", stiffness.real), ("loss", stiffness.imag)):
        # A loss of zero, as of a spring, is computed to rounding only.
        if np.any(part < -ROUNDING * np.abs(stiffness)):
            yield f"the {name} is negative for lawful parameters"


MODEL = Model("sample", parallel(spring("k0"), series(spring("k"), springpot("c", "alpha"))))
THETA = np.array([50.0, 400.0, 60.0, 0.5])


def tests_in_time() -> list[TimeTest]:
    """One test of each kind, in N and mm, with the response of a common material."""
    # Decades for tests by a step, even steps for what moves all the time, as they are recorded.
    late, even = np.geomspace(0.01, 100.0, 60), np.linspace(0.0, 20.0, 160)
    wave = np.sin(1.3 * even) * (1.0 + 0.3 * np.sin(0.31 * even))
    release = Loading(np.array([0.0, 0.0, 7.0, 7.0, 20.0]), np.array([0.0, 1.0, 1.0, 0.0, 0.0]))
    held = Loading(np.concatenate([[0.0], late]), np.concatenate([[0.0], np.ones(len(late))]))
    bare = [
        TimeTest(late, late, Loading.step(), "displacement", "mm", "N", name="relaxation"),
        TimeTest(late, late, held, "displacement", "mm", "N", name="held from its first sample"),
        TimeTest(late, late, Loading.step(), "force", "mm", "N", name="creep"),
        TimeTest(even, even, release, "force", "mm", "N", name="recovery"),
        TimeTest(even, even, Loading(even, even), "displacement", "mm", "N", name="startup"),
        TimeTest(even, even, Loading(even, wave), "displacement", "mm", "N", name="history"),
        TimeTest(even, even, Loading(even, wave), "force", "mm", "N", name="history under a force"),
    ]
    return [replace(test, response=recorded(MODEL, THETA, test).value) for test in bare]


def law_aspects(effect: Effect) -> dict[str, Aspect]:
    """The contract of an effect at a stage of a test, beside its words."""
    tests = [test for test in tests_in_time() if effect.applies_to(test)]
    return {
        "suits": lambda: _suits(tests),
        "shapes": lambda: _shapes(effect, tests),
        "derivatives": lambda: _derivatives(effect, tests),
        "pure": lambda: _pure(effect, tests),
        "vanishes": lambda: _law_vanishes(effect, tests),
    }


def _suits(tests: list[TimeTest]) -> Iterator[str]:
    if not tests:
        yield ("no relaxation, creep, recovery, startup or cyclic test can have it: see applies_to")


def _theta(effect: Effect, test: TimeTest) -> Real:
    """Parameters of the material, and those of the effect at one of the places that are tried."""
    places = tries_of(effect, test, Scales.of([InTimePart(test)]))
    place = places[int(np.random.default_rng(CONTRACT.seed).integers(len(places)))]
    return np.concatenate([THETA, place])


def _shapes(effect: Effect, tests: list[TimeTest]) -> Iterator[str]:
    for test in tests:
        record = recorded(MODEL + effect, _theta(effect, test), test)
        expected = (len(test), len(THETA) + len(effect.element.parameters))
        if record.value.shape != expected[:1] or record.by_theta.shape != expected:
            yield (
                f"in a {test.kind} test shapes are {record.value.shape} and"
                f" {record.by_theta.shape}, not {expected}"
            )
        # Without the first sample: at the instant of a step the response may be endless.
        numbers = np.all(np.isfinite(record.value[1:])) and np.all(np.isfinite(record.by_theta[1:]))
        if not numbers:
            yield f"in a {test.kind} test something is no number"


def _derivatives(effect: Effect, tests: list[TimeTest]) -> Iterator[str]:
    model = MODEL + effect
    for test in tests:
        theta = _theta(effect, test)
        # Closer than usual, or differences this small would show the tolerance.
        slopes = recorded(model, theta, test, tolerance=ALIKE).by_theta
        for i, name in enumerate(model.names):
            step = DIFFERENCE * max(abs(theta[i]), DIFFERENCE)
            moved = step * (np.arange(len(theta)) == i)
            ends = [
                recorded(model, theta + sign * moved, test, tolerance=ALIKE).value
                for sign in (1.0, -1.0)
            ]
            wanted = (ends[0] - ends[1]) / (2.0 * step)
            off = np.abs(wanted - slopes[:, i])[1:]
            size = float(np.abs(wanted[1:]).max())
            wrong = float(np.mean(off > CONTRACT.agree * size + ALIKE))
            # A parameter that does nothing in this kind of test has no derivative to be wrong.
            if size > 0.0 and wrong > CONTRACT.apart:
                where = f"at {100.0 * wrong:.0f} % of the samples"
                yield f"in a {test.kind} test the derivative by {name} is wrong {where}"


def _pure(effect: Effect, tests: list[TimeTest]) -> Iterator[str]:
    # One test is enough: whether arguments are changed does not depend on what was imposed.
    for test in tests[:1]:
        theta = _theta(effect, test)
        before = theta.copy(), test.loading.value.copy(), test.response.copy()
        first = recorded(MODEL + effect, theta, test).value
        again = recorded(MODEL + effect, theta, test).value
        after = theta, test.loading.value, test.response
        if not all(np.array_equal(a, b) for a, b in zip(before, after, strict=True)):
            yield "it changes its arguments"
        if not np.array_equal(first, again, equal_nan=True):
            yield "the same parameters do not give the same record"


def _change(effect: Effect, theta: Real, test: TimeTest) -> float:
    """Largest change of a record by an effect, over the largest number of that record."""
    # Without the first sample, as above.
    alone = test.response[1:]
    grown = recorded(MODEL + effect, theta, test).value[1:]
    return float(np.abs(grown - alone).max() / np.abs(alone).max())


def _law_vanishes(effect: Effect, tests: list[TimeTest]) -> Iterator[str]:
    null, first = effect.vanishes_at, len(THETA)
    for test in tests:
        theta = _theta(effect, test)
        if not _change(effect, theta, test) > PRINTED:
            yield f"in a {test.kind} test it changes nothing at a size that is tried"
        tried = abs(theta[first])
        theta[first] = tried / ALIKE if np.isinf(null) else null + ALIKE * tried
        left = _change(effect, theta, test)
        if not left < CONTRACT.gone:
            yield (
                f"in a {test.kind} test {left:.1e} of the record still changes when"
                f" {effect.element.parameters[0].name}, its first parameter, goes to {null:g};"
                " put the size first, or give absent_at"
            )


COLUMNS = frozenset({"amplitude", "temperature"})


def check_effect(effect: Effect, *, on: Model = SAMPLE, skip: Collection[str] = ()) -> list[str]:
    """What is wrong with an effect, as plain sentences.

    Aspects: ``words`` (name, summary, citation, prior), ``shapes``, ``derivatives`` (of the grown
    model), ``pure`` (arguments are left alone) and ``vanishes`` (at ``vanishes_at``, and only
    there). Of the network also ``parameters``, ``finite``, ``units``, ``columns`` (it asks for the
    conditions that it uses, no others) and ``harmonic``; of what a test in time did ``suits`` (some
    test can have it).

    Parameters
    ----------
    effect : Effect
        The effect.
    on : Model
        The model that it joins.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    # An effect of the levels of a column has parameters only once it knows these levels.
    effect = effect.bound_to(POINTS)
    aspects: dict[str, Aspect] = {"words": lambda: _effect_words(effect)}
    if effect.of_test:
        return complaints(aspects | law_aspects(effect), skip)
    grown = on + effect
    aspects |= {
        **network_aspects(grown),
        "vanishes": lambda: _vanishes(effect, on, grown),
        "columns": lambda: _columns(effect, grown),
        "harmonic": lambda: _harmonic(effect),
    }
    return complaints(aspects, skip)


def _effect_words(effect: Effect) -> Iterator[str]:
    yield from name_and_summary(effect.name, effect.summary, effect.aliases)
    yield from cited(effect.citation)
    if not 0.0 < effect.prior <= 1.0:
        yield f"the prior is {effect.prior}, not above 0 and at most 1"
    if not isinstance(effect.layer, Layer):
        yield (
            f"the layer is {effect.layer!r}, not one of {', '.join(layer.name for layer in Layer)}"
        )
    if not effect.element.parameters:
        yield "the element has no parameter, so there is no size to be found"
    if effect.of_test and len(effect.signature.split()) < 3:
        yield "the signature must say in a sentence how the effect shows in a record"
    controls = effect.applies_to.controls
    if not controls or set(controls) - set(CONTROLS):
        yield f"controls are some of {', '.join(CONTROLS)}, not {controls!r}"


def _vanishes(effect: Effect, on: Model, grown: Model) -> Iterator[str]:
    theta = sample(grown.parameters, np.random.default_rng(CONTRACT.seed), (4,))
    n = len(on.parameters)
    alone = on.stiffness(theta[:, :n], POINTS)
    if not np.max(np.abs(grown.stiffness(theta, POINTS) / alone - 1.0)) > 1e-4:
        yield "at its typical size it changes nothing"
    size, null = effect.element.parameters[0], effect.vanishes_at
    # A factor at every level: the effect is gone only when all of them are.
    if effect.by_levels:
        theta[:, n:] = null
    # A size that is zero as a rule gives no scale to come near by.
    typical = abs(size.typical) or 1.0
    if np.isinf(null):
        # An effect that vanishes at infinity, such as the stiffness of a mounting.
        theta[:, n] = typical / CONTRACT.nearly
    elif null == 0.0:
        theta[:, n] = CONTRACT.nearly * typical
    else:
        theta[:, n] = null + CONTRACT.nearly * null
    left = np.max(np.abs(grown.stiffness(theta, POINTS) / alone - 1.0))
    if not left < NEGLIGIBLE:
        yield (
            f"it does not vanish when {size.name}, its first parameter, goes to {null:g}: K still"
            f" changes by {left:.1e}; put the parameter that measures its size first, or give"
            " absent_at"
        )


def _without(column: str) -> Points:
    if column == "amplitude":
        return replace(POINTS, amplitude=None)
    return replace(POINTS, temperature=None)


def _columns(effect: Effect, grown: Model) -> Iterator[str]:
    theta = sample(grown.parameters, np.random.default_rng(CONTRACT.seed))
    for column in sorted(effect.needs - COLUMNS):
        yield (
            f"it needs '{column}', but measurements have only amplitude and temperature beside the"
            " frequency"
        )
    # Used without being asked for, a column that the data lack would be an error within a fit.
    for column in sorted(COLUMNS - grown.needs):
        try:
            bare = grown.stiffness(theta, _without(column))
        except (DataError, TypeError):
            yield f"it uses the {column} without saying so: name it in the element's conditions"
            continue
        if not np.array_equal(bare, grown.stiffness(theta, POINTS)):
            yield (
                f"it depends on the {column} without saying so: name it in the element's conditions"
            )
    # Asked for without being used, it would refuse data that lack it for nothing.
    for column in sorted(COLUMNS & effect.needs):
        try:
            grown.stiffness(theta, _without(column))
        except DataError as error:
            if column not in str(error):
                yield f"without the column {column} its error does not name it: {error}"
        else:
            yield f"it says that it needs the {column}, but works without"


def _harmonic(effect: Effect) -> Iterator[str]:
    theta = sample(effect.element.parameters, np.random.default_rng(CONTRACT.seed), (2,))
    third = effect.third_harmonic(theta, POINTS)
    expected = (2, len(POINTS.log_omega))
    if third is not None and (np.shape(third) != expected or not np.all(np.isfinite(third))):
        yield f"the third harmonic must be finite and of shape {expected}"
