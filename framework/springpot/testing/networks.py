"""What models and effects have in common: exact derivatives, finite values, units, shapes.

A contract is a set of aspects, functions that yield sentences; running it never raises. Parameters
are random lawful ones, and derivatives are compared with exact differences.
"""

from __future__ import annotations

import json
import pickle
import random
import re
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from springpot.identification.space import paper_box
from springpot.measurement.measurement import Measurement
from springpot.measurement.units import Units
from springpot.processes import Ended, can_copy, elsewhere
from springpot.rheology.elements import Continuum, spring, springpot
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL, parallel, series
from springpot.rheology.parameters import MAXWELL_FORM, Parameter
from springpot.rheology.points import Points, Real, power_of_s
from springpot.rheology.poles import CIRCLE

from ..numerics import ALIKE


class Strictness(NamedTuple):
    """How closely a plugin is looked at, and what is asked of it."""

    deadline: float
    """Seconds in which a plugin must have shown all that is asked of it.

    The slowest of springpot's own take five.
    """
    seed: int
    """Of whatever is drawn: a contract that holds once holds again."""
    summary: int
    """Characters of a summary that still fit a listing."""
    exact: float
    """Relative error above which a derivative is not exact; finite differences are worse than
    this.
    """
    described: int
    """Characters of a summary."""
    agree: float
    """Relative difference from it up to which a derivative is right.

    The response itself is good to 1e-6.
    """
    apart: float
    """Share of the samples that may lie at a corner, where a difference is no derivative."""
    gone: float
    """Change of the record that is left there, over the largest response."""
    nearly: float
    """Distance from the size at which an effect vanishes, relative to its typical size."""
    followed: float
    """Relative error to which lines follow a smooth spectrum at points that are two a decade.

    1.1e-4 with the most lines
    that a fit allows itself, which leaves a few of the measured numbers over."""
    long: int
    """Evaluations in which it must get somewhere."""
    better: float
    """What is left by then of the objective at the centre of the box."""
    random_files: int
    """Files of random bytes, and as many of random pieces of tables."""
    damaged: int
    """Bytes of a sample that are damaged; more would take long and show no more."""


CONTRACT = Strictness(
    deadline=120.0,
    seed=20240607,
    summary=160,
    exact=1e-8,
    described=240,
    agree=2e-3,
    apart=0.03,
    gone=1e-5,
    nearly=1e-24,
    followed=2e-4,
    long=400,
    better=0.5,
    random_files=40,
    damaged=1 << 14,
)
Aspect: TypeAlias = Callable[[], Iterable[str]]

NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*(-N)?")


def complaints(
    aspects: Mapping[str, Aspect], skip: Collection[str] = (), deadline: float = CONTRACT.deadline
) -> list[str]:
    """What is wrong, each sentence preceded by its aspect; empty if nothing is.

    It is looked at in a copy of this process, in which a plugin may crash or hang; where threads
    run here, in one more of them, in which it may hang.

    Parameters
    ----------
    aspects : mapping of str to callable
        The contract.
    skip : collection of str
        Aspects that are left out.
    deadline : float
        Seconds that all aspects together may take.
    """
    unknown = sorted(set(skip) - set(aspects))
    # A skip that is misspelt would leave its author in the belief that it is one.
    if unknown:
        return [f"skip: there is no aspect '{unknown[0]}': known are {', '.join(aspects)}"]
    wanted = {name: aspect for name, aspect in aspects.items() if name not in skip}
    # Nothing wrong, because nothing was looked at, must not pass.
    if not wanted:
        return ["skip: every aspect is left out, so nothing was checked"]
    look = elsewhere if can_copy() else _beside
    ended = look(lambda report: _report(wanted, report), deadline)
    told = [
        json.loads(line) for line in ended.message.splitlines(keepends=True) if line.endswith(b"\n")
    ]
    sentences = [f"{name}: {says}" for name, found in told for says in found]
    # The first that has not answered is the one under way.
    for name in list(wanted)[len(told) :][:1]:
        reason = ended.cause
        if ended.late:
            reason = f"does not end: all aspects together may take {deadline:g} s"
        sentences.append(f"{name}: {reason}")
    return sentences


def _beside(action: Callable[[Callable[[bytes], object]], None], deadline: float) -> Ended:
    """`elsewhere` for a process that has threads, which no copy of it would have."""
    told: list[bytes] = []
    beside = threading.Thread(target=action, args=(told.append,), daemon=True)
    beside.start()
    beside.join(deadline)
    return Ended(b"".join(told), late=beside.is_alive(), cause="ends without an answer")


def _report(wanted: Mapping[str, Aspect], report: Callable[[bytes], object]) -> None:
    for name, aspect in wanted.items():
        report(json.dumps((name, _run(aspect))).encode() + b"\n")


def _run(aspect: Aspect) -> list[str]:
    sentences: list[str] = []
    with kept_random_state() as touched, np.errstate(all="ignore"):
        try:
            sentences.extend(aspect())
        except (Exception, SystemExit) as error:
            # What was said before it stays said; a plugin may also call sys.exit.
            sentences.append(f"raises {type(error).__name__}: {' '.join(str(error).split())}")
        if touched():
            sentences.append(
                "changes the process-wide random state:"
                " draw only from the generator that is handed in"
            )
    return sentences


@contextmanager
def kept_random_state() -> Iterator[Callable[[], bool]]:
    """Put the process-wide random states back at the end.

    Gives a function that tells whether they have changed.
    """
    before = np.random.get_state(legacy=False)  # noqa: NPY002  it is what is watched
    own = random.getstate()

    def touched() -> bool:
        now = np.random.get_state(legacy=False)  # noqa: NPY002
        # As bytes: the states hold arrays, which have no single answer to whether they are equal.
        return pickle.dumps(now) != pickle.dumps(before) or random.getstate() != own

    try:
        yield touched
    finally:
        np.random.set_state(before)  # noqa: NPY002
        random.setstate(own)


def name_and_summary(name: str, summary: str, aliases: Iterable[str] = ()) -> Iterator[str]:
    """Sentences about what users type and read."""
    for word in (name, *aliases):
        if not NAME.fullmatch(word):
            yield (
                f"'{word}' must be lower-case words, digits and hyphens,"
                " such as 'fractional-maxwell'"
            )
    if len(summary.split()) < 2 or "\n" in summary or len(summary) > CONTRACT.summary:
        yield (
            f"the summary must be one sentence of at most {CONTRACT.summary} characters,"
            f" not {summary!r:.60}"
        )
    elif summary.endswith("."):
        yield "the summary ends with a full stop, which a listing does not need"


def cited(citation: str) -> Iterator[str]:
    """A sentence if there is no source."""
    if not citation.strip():
        yield (
            "there is no citation: say where the equation or the numbers come from,"
            " with a DOI where there is one"
        )


def sample(
    parameters: Sequence[Parameter], rng: np.random.Generator, shape: tuple[int, ...] = ()
) -> Real:
    """Random parameters well inside their bounds.

    Parameters
    ----------
    parameters : sequence of Parameter
        The p parameters.
    rng : numpy.random.Generator
        Source of randomness.
    shape : tuple of int
        Leading axes.

    Returns
    -------
    ndarray, shape (*shape, p)
    """
    columns = []
    for parameter in parameters:
        if parameter.scale == "log":
            # A factor of e to either side, for such sizes are known by their decade.
            drawn = parameter.typical * np.exp(rng.uniform(-1.0, 1.0, shape))
        elif np.isfinite(parameter.upper) and np.isfinite(parameter.lower):
            # Clear of the ends, where a derivative has one side only.
            drawn = parameter.lower + (parameter.upper - parameter.lower) * rng.uniform(
                0.3, 0.9, shape
            )
        else:
            drawn = parameter.typical * rng.uniform(0.3, 0.9, shape)
        columns.append(np.clip(drawn, parameter.lower, parameter.upper))
    return np.stack(columns, axis=-1)


def derivative(function: Callable[[Any], Any], x: Real, reach: float = 0.01) -> Any:
    """Derivative of `function` by each entry of `x` (p,), on the last axis.

    The mean over a circle in the complex plane (Cauchy's integral) has no truncation error to speak
    of, unlike a finite difference. A function that is not analytic (it reads only the loss, say, or
    refuses complex numbers) is differenced along the real axis instead, to eighth order.

    Parameters
    ----------
    function : callable
        From (p,) to an array.
    x : ndarray, shape (p,)
        Where.
    reach : float
        Radius of the circle, or the step, relative to each entry.
    """
    centre = function(x)
    columns = []
    for i in range(len(x)):
        # A parameter of zero has no size to go by.
        radius = reach * (abs(x[i]) or 0.01)
        column = _around(function, x, i, radius, np.abs(centre))
        # What takes no complex numbers, or is not analytic, is told by real steps.
        if column is None:
            column = _difference(function, x, i, radius)
        columns.append(column)
    return np.stack(columns, axis=-1)


def _around(function: Callable[[Any], Any], x: Real, i: int, radius: float, size: Real) -> Any:
    try:
        values = _along(function, x, i, radius * CIRCLE)
    except (TypeError, ValueError):
        return None
    # An analytic function does not change with the conjugate (Cauchy and Riemann).
    by_x, by_conjugate = (np.mean(values * turn, axis=-1) / radius for turn in (1 / CIRCLE, CIRCLE))
    analytic = np.all(np.abs(by_conjugate) < 1e-7 * (np.abs(by_x) + size))
    if not analytic:
        return None
    return by_x


def _difference(function: Callable[[Any], Any], x: Real, i: int, radius: float) -> Any:
    # Of eighth order: weights of f(x + i h) - f(x - i h) for i = 1 ... 4.
    weights, steps = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280]), np.arange(1, 5)
    both = radius * np.concatenate([steps, -steps])
    return _along(function, x, i, both) @ np.concatenate([weights, -weights]) / radius


def _along(function: Callable[[Any], Any], x: Real, i: int, steps: Any) -> Any:
    around = np.repeat(x[None].astype(np.result_type(steps, float)), len(steps), axis=0)
    around[:, i] += steps
    return np.stack([function(point) for point in around], axis=-1)


OMEGA: Real = np.geomspace(0.1, 30.0, 9)
POINTS = Points(np.log(OMEGA), np.linspace(0.5, 2.0, 9), np.linspace(285.0, 305.0, 9))

SAMPLE = Model(
    "sample", parallel(spring("k1"), series(spring("k2"), springpot())), search=MAXWELL_FORM
)
"""A solid with four parameters on which effects, optimisers and objectives are tried."""


def sample_measurement() -> Measurement:
    """Data over four decades of frequency, with both conditions."""
    omega = np.geomspace(1e-2, 1e2, 9)
    conditions = {"amplitude": np.linspace(0.5, 2.0, 9), "temperature": np.linspace(10.0, 30.0, 9)}
    stiffness = 500.0 * power_of_s(0.4, np.log(omega))
    return Measurement(
        omega, stiffness, conditions=conditions, units=Units("kN/m", "mm"), name="sample"
    )


def network_aspects(model: Model) -> dict[str, Aspect]:
    """The contract of a network, that of a grown model included."""
    # Functions, called one after the other: one that raises is told as a sentence and does not end
    # the rest.
    return {
        "parameters": lambda: _parameters(model.parameters),
        "shapes": lambda: _shapes(model),
        "derivatives": lambda: _derivatives(model),
        "finite": lambda: _finite(model),
        "units": lambda: _units(model),
        "pure": lambda: _pure(model),
    }


def _thetas(model: Model, count: int = 4) -> Real:
    return sample(model.parameters, np.random.default_rng(CONTRACT.seed), (count,))


def _parameters(parameters: Sequence[Parameter]) -> Iterator[str]:
    names = [parameter.name for parameter in parameters]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"two parameters are called {name}"
    for parameter in parameters:
        name = parameter.name
        if not re.fullmatch(r"([\w#-]+\.)?[^\W\d]\w*", name):
            yield (
                f"the parameter name '{name}' is no identifier,"
                " so that it cannot be given as a keyword"
            )
        if (
            not parameter.lower <= parameter.typical <= parameter.upper
            or not parameter.lower < parameter.upper
        ):
            yield (
                f"{name}: the typical size {parameter.typical} is not within {parameter.lower} to"
                f" {parameter.upper}"
            )
        if parameter.scale == "log" and not (
            parameter.lower >= 0 and 0 < parameter.typical < np.inf
        ):
            yield f"{name}: a logarithmic scale needs a positive typical size and no negative bound"
        if isinstance(parameter.unit.time, str) and parameter.unit.time not in names:
            yield f"{name}: its unit names the order '{parameter.unit.time}', which is no parameter"
        # A stiffness with lengths, and a modulus with strains: units are printed differently for
        # each.
        for units in (Units("kN/m", "mm"), Units("Pa", "-")):
            if not units.of(parameter.unit)[1].strip():
                yield f"{name}: its unit cannot be printed for data in {units.stiffness}"


def _shapes(model: Model) -> Iterator[str]:
    theta = _thetas(model, 6).reshape(2, 3, -1)
    n, p = len(OMEGA), len(model.parameters)
    whole = model.network.respond(theta, POINTS, FULL)
    expected = {"value": (2, 3, n), "by_theta": (2, 3, p, n), "by_log_omega": (2, 3, n)}
    wrong = [name for name, shape in expected.items() if getattr(whole, name).shape != shape]
    for name in wrong:
        yield (
            f"{name} has the shape {getattr(whole, name).shape}, not {expected[name]},"
            f" for theta of (2, 3, {p})"
        )
    # Only where the shape is right: otherwise the values could not be compared.
    for name in [name for name in expected if name not in wrong]:
        rows = [
            getattr(model.network.respond(row, POINTS, FULL), name) for row in theta.reshape(6, -1)
        ]
        if not np.allclose(
            np.reshape(rows, expected[name]), getattr(whole, name), rtol=1e-10, atol=1e-13
        ):
            yield f"{name} of stacked parameters differs from that of one set after the other"


def _derivatives(model: Model) -> Iterator[str]:
    theta = _thetas(model)
    worst = np.max([_by_theta(model, row) for row in theta], axis=0)
    for name, error in zip(model.names, worst, strict=True):
        # Written this way round, an error that is no number fails too.
        if not error < CONTRACT.exact:
            yield f"dK/d{name} is not the derivative of K: off by {error:.1e} relative to K/{name}"
    slope = max(_by_log_omega(model, row) for row in theta)
    if not slope < CONTRACT.exact:
        yield f"by_log_omega is not dK/d ln omega: off by {slope:.1e} relative to K"


def _by_theta(model: Model, theta: Real) -> Real:
    """Relative error of dK/dtheta (p,)."""
    response = model.network.respond(theta, POINTS, FULL)
    exact = np.swapaxes(response.by_theta, -1, -2)
    # Relative to K over the parameter: a derivative that is zero by nature has no size of its own.
    natural = np.abs(response.value)[:, None] / np.maximum(np.abs(theta), 1e-4) + np.abs(exact)
    worst: Real = _error(
        exact, lambda x: model.network.respond(x, POINTS).value, theta, natural
    ).max(axis=0)
    return worst


def _by_log_omega(model: Model, theta: Real) -> float:
    response = model.network.respond(theta, POINTS, FULL)
    exact = response.by_log_omega[:, None]
    natural = np.abs(response.value)[:, None] + np.abs(exact)
    error = _error(
        exact,
        lambda x: model.network.respond(theta, POINTS.shifted(x[0])).value,
        np.zeros(1),
        natural,
    )
    return float(error.max())


def _error(exact: Any, function: Callable[[Any], Any], x: Real, natural: Real) -> Real:
    """Relative error of `exact`; none where a kink lies so near that two radii disagree."""
    near = derivative(function, x, 3e-3)
    nearer = derivative(function, x, 1e-3)
    # A derivative that is nothing beside the others is held against them, not against its own
    # roundings.
    natural = np.maximum(natural, ALIKE * np.max(natural))
    smooth = np.abs(near - nearer) <= 0.1 * CONTRACT.exact * natural
    wrong = np.abs(exact - nearer) / natural
    # A derivative that is not a number is wrong, kink or not; and where all is rough, nothing has
    # been shown.
    bad = np.isnan(exact) | ~smooth.any(axis=0)
    return np.where(bad, np.inf, np.where(smooth, wrong, 0.0))


def _finite(model: Model) -> Iterator[str]:
    """Optimisers visit the whole box and its corners; none may meet an infinity there."""
    box = paper_box(model, sample_measurement())
    inside = np.random.default_rng(CONTRACT.seed).random((300, len(box.lower)))
    for where, x in (("inside", inside), ("in a corner of", np.round(inside))):
        theta = box.theta(box.lower + x * (box.upper - box.lower))
        response = model.network.respond(theta, sample_measurement().points, FULL)
        for name, values in response._asdict().items():
            bad = ~np.isfinite(values.reshape(len(theta), -1)).all(axis=1)
            if bad.any():
                shown = ", ".join(
                    f"{key} = {v:.3g}" for key, v in zip(model.names, theta[bad][0], strict=True)
                )
                yield f"{name} is not finite {where} the search box, such as at {shown}"


def converted(model: Model, theta: Real, stiffness: float, time: float, amplitude: float) -> Real:
    """`theta` (p,) in units where old ones of stiffness, time and amplitude have these values."""
    values = model.named(theta)
    factors: list[float] = []
    own = {"stiffness": stiffness, "time": time, "amplitude": amplitude}
    for parameter in model.parameters:
        unit = parameter.unit
        factor = unit.size(stiffness, time, amplitude, values.get(str(unit.time)))
        # A power that another parameter decides: that one has the same prefix.
        prefix = parameter.name.removesuffix(parameter.name.rpartition(".")[2])
        for base, shares in unit.beyond:
            exponent = sum(
                share * (values[prefix + name] if name else 1.0) for name, share in shares
            )
            factor *= own.get(base, 1.0) ** exponent
        factors.append(factor)
    changed: Real = theta * np.array(factors)
    return changed


def _units(model: Model) -> Iterator[str]:
    """In other units the numbers must change as the parameters' units say."""
    changes = {
        "stiffness": (1e-3, 1.0, 1.0),
        "time": (1.0, 1 / 60, 1.0),
        "amplitude": (1.0, 1.0, 1e3),
    }
    for what, (stiffness, time, amplitude) in changes.items():
        # In minutes instead of seconds a frequency has another number, and so has an amplitude in
        # other units.
        at = replace(POINTS.shifted(-np.log(time)), amplitude=POINTS.need("amplitude") * amplitude)
        for theta in _thetas(model):
            other = _of_rates(model, time).stiffness(
                converted(model, theta, stiffness, time, amplitude), at
            )
            if not np.allclose(
                other, stiffness * model.stiffness(theta, POINTS), rtol=1e-8, atol=0.0
            ):
                yield (
                    f"K does not follow a change of the unit of {what}:"
                    " a parameter's Dimension is wrong"
                )
                # Once for each unit: the same slip shows at every set of parameters.
                break


def _of_rates(model: Model, time: float) -> Model:
    """The model with any lines of its spectrum in a unit of time of which the old has `time`."""
    if not isinstance(model.material, Continuum):
        return model
    return replace(model, material=Continuum(tuple(rate / time for rate in model.material.rates)))


def _apart_alike(model: Model, theta: Real) -> bool:
    """Whether K' and K'' by themselves are those of K, to the last bit."""
    whole = model.network.respond(theta, POINTS).value
    pairs = zip(model.network.parts(theta, POINTS), (whole.real, whole.imag), strict=True)
    return all(np.array_equal(np.broadcast_to(own, of.shape), of) for own, of in pairs)


def _pure(model: Model) -> Iterator[str]:
    theta = _thetas(model)
    before = theta.copy()
    columns = [
        POINTS.log_omega.copy(),
        POINTS.need("amplitude").copy(),
        POINTS.need("temperature").copy(),
    ]
    first = model.network.respond(theta, POINTS, FULL)
    second = model.network.respond(theta, POINTS, FULL)
    if not all(np.array_equal(a, b) for a, b in zip(first, second, strict=True)):
        yield "two calls with the same arguments differ"
    elif not _apart_alike(model, theta):
        yield "K' and K'' apart are others than those of K"
    after = [POINTS.log_omega, POINTS.need("amplitude"), POINTS.need("temperature")]
    if not np.array_equal(theta, before) or not all(map(np.array_equal, columns, after)):
        yield "the arrays that are handed in are changed"
