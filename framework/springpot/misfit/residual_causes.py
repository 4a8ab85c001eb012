"""What the best model leaves, without a name.

Its column, its size, fixed in Hz or moving, causal or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from springpot.distributions import f_sf, normal_quantile
from springpot.identification.problem import weighted
from springpot.measurement.independence import (
    at_one_frequency,
    distinct_log_omega,
    frequency_numbers,
)
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import (
    TIME,
    largest_test,
    settings_of,
    sweeps_of,
    temperatures_differ,
    tests_together,
)
from springpot.measurement.replicates import ADVICE, stands_again
from springpot.rheology.nodes import Shift
from springpot.rheology.points import Complex, Real, real_form
from springpot.thresholds import VERDICT

from ..numerics import FAR, MOST_STEPS, ROUNDING, SMALLEST, orthonormal, projected_out, rms
from .error import percent, plain
from .frame import (
    ENOUGH_NEIGHBOURS,
    LEAST_SEEN,
    NoiseFrame,
    beyond,
    chance_of_squares,
    relative_to,
)
from .refit import Refit
from .where import WIDE, where

Rows: TypeAlias = NDArray[np.int64]

NARROW = 8
"""Narrow resonances that are tried for each point of a sweep."""
MOST_BESIDE = 25
"""Bumps beyond each end of the data at most."""
WIDTHS = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0)
"""Widths of the bumps in steps of the measured frequencies."""
RESONANCES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
"""Widths of narrow resonances in the same steps: a wider one is seen at several points."""
SIZES = np.geomspace(1e-2, 1e2, 17)
"""Sizes of the bumps in sizes of the residual."""
PATTERNS = {
    "fixed": "it stays at the same frequencies at all temperatures, as faults of an instrument do",
    "moving": "it moves along the frequency with temperature as the material does",
    "": "",
}


def causal_evidence(frame: NoiseFrame, x: Real, groups: Sequence[Rows]) -> float:
    """Log-evidence for causality against independent K' and K''.

    Near zero where the data cannot tell.

    Parameters
    ----------
    frame : NoiseFrame
        The fit whose residual is judged.
    x : ndarray, shape (n,)
        Ln omega along which it is a curve, reduced by temperature or not.
    groups : sequence of ndarray of int
        Rows that share one curve, such as sweeps.
    """
    n, step = len(x), step_of(frame)
    off = frame.measurement.stiffness - frame.model_stiffness
    size = rms(np.abs(off / relative_to(frame.model_stiffness, frame.measurement)))
    best: dict[str, Real] = {}
    # The width is not known: a bump narrower or broader than the residual's would call anything
    # unlikely.
    for width in WIDTHS:
        total: dict[str, Real] = {}
        for rows in groups:
            both = np.concatenate([rows, rows + n])
            # Each group by itself: what the parameters follow in the others is no matter of its
            # curve.
            absorbed = orthonormal(frame.absorbed[both])
            values = frame.residual[both]
            values = projected_out(values, absorbed)
            for name, columns in _bumps(frame, x, rows, width * step):
                columns = projected_out(columns, absorbed)
                total[name] = total.get(name, 0.0) + _evidence_of_bumps(
                    columns, values, size * SIZES
                )
        for name, evidence in total.items():
            best[name] = np.append(best.get(name, []), np.max(evidence))
    # Best against best: causal curves must beat those of storage and loss apart, and of either
    # alone.
    top = {name: float(np.max(values)) for name, values in best.items()}
    return top.pop("causal") - max(top.values())


def step_of(frame: NoiseFrame) -> float:
    """Distance of neighbouring measured frequencies in ln omega, within reason."""
    distinct = distinct_log_omega(frame.measurement)
    if len(distinct) < 2:
        return 1.0
    return float(max(np.median(np.diff(distinct)), np.ptp(distinct) / MOST_STEPS))


def _present(frame: NoiseFrame) -> Complex:
    """K of the model (n,); where there is none of it, one that is nothing beside the measured.

    A relative change of zero is no change, and its reciprocal no number.
    """
    least = ROUNDING * np.max(frame.measurement.magnitude)
    there = np.abs(frame.model_stiffness) > least
    return np.where(there, frame.model_stiffness, least)


def _bumps(frame: NoiseFrame, x: Real, rows: Rows, width: float) -> Iterator[tuple[str, Real]]:
    """Columns (2m, q) of the causal curve and of those whose parts are independent, whitened."""
    stiffness = _present(frame)[rows]
    shapes = np.array(list(_shapes(x[rows], stiffness, width)))
    weights = frame.weights[rows]
    turn = None if frame.turn is None else frame.turn[rows]

    def whitened(change: Complex) -> Real:
        return weighted(change, weights, turn).T

    real, imaginary = whitened(shapes.real * stiffness), whitened(1j * shapes.imag * stiffness)
    yield "causal", real + imaginary
    yield "apart", np.concatenate([real, imaginary], axis=1)
    yield "storage", real
    yield "loss", imaginary


def _shapes(x: Real, stiffness: Complex, width: float) -> Iterator[Complex]:
    """Causal relative changes of K.

    Resonances in and beside the band, and what those far away leave in it.
    """
    beside = min(FAR, MOST_BESIDE * width)
    for pole in np.arange(x.min() - beside, x.max() + beside + width, width):
        at = 1j * np.exp(np.clip(x - pole, -300.0, 300.0))
        yield 2.0 * width * at / (1.0 + 2.0 * width * at + at**2)
    # A gain and a delay, a spring, a dashpot and a mass beside K, a spring and a dashpot in series
    # with it.
    s = 1j * np.exp(x - np.mean(x))
    for far in (
        np.ones_like(s),
        s,
        1.0 / stiffness,
        s / stiffness,
        s**2 / stiffness,
        stiffness,
        stiffness / s,
    ):
        yield far / np.max(np.abs(far))


def _evidence_of_bumps(columns: Real, values: Real, sizes: Real) -> Real:
    """Log-evidence of columns with normal coefficients of each size, over that of noise alone."""
    power, directions = np.linalg.eigh(columns.T @ columns)
    # Directions of hardly any power are differences of nearly equal bumps: rounding.
    kept = power > 1e-10 * max(float(power[-1]), SMALLEST)
    power = power[kept]
    along = (directions[:, kept].T @ (columns.T @ values)) ** 2 / power
    gain = power * sizes[:, None] ** 2
    # Normal coefficients are integrated out exactly: more bumps cost what they could follow of
    # noise.
    explained = gain / (1.0 + gain) * along
    return np.asarray(0.5 * np.sum(explained - np.log1p(gain), axis=1), dtype=np.float64)


@dataclass(frozen=True)
class Column:
    """A column that no effect knows, and with which the misfit goes.

    Attributes
    ----------
    name : str
        Of the column.
    values : int
        How many different ones it has.
    share : float
        Of the square of the relative error that a gain and a phase at each value, sloping along
        the frequency, takes.
    of_gains : float
        The same of a gain at each value alone, which is what splits a column.
    one_test : str
        How a user chooses the rows of one value: ``current=0.5``.
    """

    name: str
    values: int
    share: float
    of_gains: float
    one_test: str

    @property
    def headline(self) -> str:
        """What it is to the misfit, as the end of a sentence."""
        if self.name == TIME:
            return f"it goes with {self.name}, the specimen is another in each sweep"
        return f"it goes with {self.name}, a column that no effect knows"

    @property
    def says(self) -> str:
        """One plain sentence."""
        why = "no effect knows that column"
        if self.name == TIME:
            why = "each sweep is of a material of its own"
        return (
            f"what is missing goes with {self.name}: a gain and a phase of its own, with slopes, at"
            f" each of its {self.values} values takes {100 * self.share:.0f} % of the misfit;"
            f" {why}, so choose one by '@{self.one_test}'"
        )


@dataclass(frozen=True)
class EqualRows:
    """Rows measured under the same conditions that differ, though no model can tell them apart.

    Attributes
    ----------
    difference : float
        Relative rms by which they scatter about the mean of those of one frequency.
    share : float
        Of the misfit, in chi-square, that lies between them.
    """

    difference: float
    share: float

    @property
    def headline(self) -> str:
        """What they are to the misfit, as the end of a sentence."""
        return f"{self._differ}, which no model follows: are they repeats without a number?"

    @property
    def says(self) -> str:
        """One plain sentence."""
        return f"{self._differ}, which is {100 * self.share:.0f} % of the misfit: {ADVICE}"

    @property
    def _differ(self) -> str:
        return f"rows measured under the same conditions differ by {percent(self.difference)}"


def equal_rows_behind(frame: NoiseFrame, measurement: Measurement) -> EqualRows | None:
    """Rows of one frequency between which most of a misfit lies; None where it lies elsewhere.

    What rows under the same conditions differ by is no lack of fit: it needs no model to be seen.

    Parameters
    ----------
    frame : NoiseFrame
        The fit of the best model.
    measurement : Measurement
        The data as given; rows of the fit may have been set aside.
    """
    if stands_again(measurement) is None:
        return None
    number = frequency_numbers(frame.measurement)
    count = np.bincount(number)
    both = np.concatenate([number, number + len(count)])
    mean = np.bincount(both, frame.rest) / np.tile(count, 2)
    between = frame.rest - mean[both]
    share = float(between @ between) / float(frame.rest @ frame.rest)
    if share <= VERDICT.takes_most:
        return None
    stiffness = measurement.stiffness
    number = frequency_numbers(measurement)
    count = np.bincount(number)
    middle = (
        np.bincount(number, stiffness.real) + 1j * np.bincount(number, stiffness.imag)
    ) / count
    off = np.abs(stiffness / middle[number] - 1.0)
    # About their own mean: of each frequency one degree of freedom is spent.
    return EqualRows(float(np.sqrt(np.sum(off**2) / (len(number) - len(count)))), share)


def column_behind(frame: NoiseFrame) -> Column | None:
    """The column of the file with which a misfit goes.

    None where there is none, or it takes too little.

    A current, a preload or a batch that was changed between tests looks like scatter, or like a
    fault of the chain from row to row, to all that knows frequency, temperature and amplitude
    alone.

    Parameters
    ----------
    frame : NoiseFrame
        The fit of the best model.
    """
    settings = settings_of(frame.measurement)
    misfit, spare = float(frame.rest @ frame.rest), frame.size - int(frame.absorbed.shape[1])
    along = np.log(frame.measurement.omega)
    # At one frequency there are no slopes, only what rounding makes of them.
    slopes = np.zeros_like(along)
    if not at_one_frequency(frame.measurement):
        slopes = (along - np.mean(along)) / np.ptp(along)
    best: Column | None = None
    for name, number in settings.items():
        values = int(number.max()) + 1
        at_each = (number == np.arange(values)[:, None]).astype(np.float64)
        # Sloping and bent along the frequency: what shifts the times of a material changes its size
        # too, by its slope, and by decades its slope as well.
        shapes = np.concatenate([at_each, at_each * slopes, at_each * slopes**2])
        basis = frame.beyond(frame.relative(shapes), LEAST_SEEN)
        pattern = basis @ (basis.T @ frame.rest)
        taken, spent = float(pattern @ pattern), int(basis.shape[1])
        if spent == 0 or spare <= spent:
            continue
        left = max(misfit - taken, SMALLEST)
        free = spare - spent
        chance = f_sf(frame.worth * taken / spent / (left / free), spent, frame.worth * free)
        share = _share_taken(frame, basis)
        # Each of the columns might have been it (Bonferroni); and what takes less than most of it
        # explains nothing.
        is_behind = share > VERDICT.takes_most and chance * len(settings) < VERDICT.sentence_alarm
        if is_behind and (best is None or share > best.share):
            gains = frame.beyond(frame.relative(at_each)[:, :values], LEAST_SEEN)
            one_test = largest_test(frame.measurement, name)
            best = Column(name, values, share, _share_taken(frame, gains), one_test)
    return best


def _share_taken(frame: NoiseFrame, basis: Real) -> float:
    """What of the squares of a misfit, relative to |K|, an orthonormal basis (2n, q) takes."""
    # What is off across K counts as what is off along it, though noise may be larger along.
    whole = max(_relative_squares(frame, frame.rest), SMALLEST)
    left = frame.rest - basis @ (basis.T @ frame.rest)
    return 1.0 - _relative_squares(frame, left) / whole


def one_test_of(measurement: Measurement, column: Column | None) -> tuple[str, str]:
    """How to choose the rows of one test, such as ``current=0.5``, and why.

    Both empty where the rows are of one.

    Parameters
    ----------
    measurement : Measurement
        The data, of which the best model leaves more than noise.
    column : Column or None
        With which of the columns the misfit goes.
    """
    # Before what only tells rows apart: with this one the misfit goes.
    if column is not None:
        return column.one_test, column.says
    names = tests_together(measurement)
    if not names:
        return "", ""
    one_test = largest_test(measurement, names[0])
    why = (
        f"rows of several tests stand together, told apart by {names[0]}; choose one by"
        f" '@{one_test}'"
    )
    return one_test, why


@dataclass(frozen=True)
class _Seen:
    """Energy of a residual in some directions, in units of the noise, and their number."""

    energy: float
    size: float
    scale_dof: float

    @property
    def chance(self) -> float:
        """That noise alone has so much."""
        if self.size == 0:
            return 1.0
        return chance_of_squares(self.energy, self.size, self.scale_dof)

    @property
    def excess(self) -> float:
        """Energy beyond that of noise."""
        return max(self.energy - self.size, 0.0)


def discrepancy(frame: NoiseFrame, log_shift: Real | None = None) -> list[str]:
    """Sentences on what a model leaves.

    None where that is noise, and none on what the data cannot tell.

    Parameters
    ----------
    frame : NoiseFrame
        The fit of the best model.
    log_shift : ndarray, shape (n,), optional
        Its ln a_T at the points, see `log_shift_of`; without it nothing is said of temperature.
    """
    places = where(frame)
    # Either is enough: a place is found where slow shapes see nothing, and slow shapes where no
    # block stands out.
    if not places and _seen(frame, frame.structured).chance > VERDICT.sentence_alarm:
        return []
    place = ""
    if places:
        place = places[0].says
    pattern = _pattern(frame, log_shift)
    sentences = [
        _size_in_words(frame, place),
        PATTERNS[pattern],
        _causality(frame, pattern, log_shift),
    ]
    return [sentence for sentence in sentences if sentence]


def log_shift_of(found: Refit) -> Real | None:
    """Ln a_T of a fitted model at the points (n,), or None if it has no shift with temperature."""
    model, points = found.model, found.fit.measurement.points
    total: Real | None = None
    for effect, prefix in model.named_effects():  # the second of one name has a prefix of its own
        if effect.composition.kind is Shift and "temperature" in effect.needs:
            names = [name for name in model.names if name.rpartition(".")[0] == prefix]
            theta = found.theta[[model.names.index(name) for name in names]]
            value = np.asarray(effect.element.respond(theta, points).value.real, dtype=np.float64)
            total = value if total is None else total + value
    return total


def _size_in_words(frame: NoiseFrame, place: str) -> str:
    off = np.abs(frame.measurement.stiffness - frame.model_stiffness) / frame.measurement.magnitude
    noise = (
        1.0 / frame.weights.real**2 + 1.0 / frame.weights.imag**2
    ) / frame.measurement.magnitude**2
    # Of the noise too the parameters have followed a part, so that less of it is in what is left.
    kept = 1.0 - frame.absorbed.shape[1] / frame.size
    beyond_noise = np.mean(off**2) - kept * np.mean(noise)
    size = float(np.sqrt(max(beyond_noise, 0.0)))
    share = f"{plain(100 * size, 2)} % of {frame.measurement.units.magnitude}"
    much = "no more than the noise in size"
    if size > 0:
        much = f"about {share} beyond the noise"
    if not place:
        return f"what is left is {much}"
    return f"what is left is {much}: {place}"


def _seen(frame: NoiseFrame, basis: Real) -> _Seen:
    energy = frame.worth * float(np.sum((basis.T @ frame.rest) ** 2))
    return _Seen(energy, int(basis.shape[1]), frame.scale_dof)


def _relative_squares(frame: NoiseFrame, whitened: Real) -> float:
    """Sum of squares of whitened numbers (2n,) relative to |K|; what has no weight counts not."""
    weights = real_form(frame.weights)
    there = weights > 0.0
    size = np.tile(np.abs(relative_to(frame.model_stiffness, frame.measurement)), 2)
    return float(np.sum((whitened[there] / (weights * size)[there]) ** 2))


def _curve(frame: NoiseFrame, x: Real) -> Real:
    """Basis (2n, q) of any one curve along x, in size and phase of K."""
    step = step_of(frame)
    knots = x.min() + step * np.arange(-3, np.ptp(x) / step + 5.0)
    splines = BSpline.design_matrix(x, knots, 3).toarray().T
    # Those that hardly reach the data would follow single points at the ends.
    splines = splines[np.sum(splines, axis=1) > 0.1]
    return frame.beyond(frame.relative(splines), LEAST_SEEN)


def _pattern(frame: NoiseFrame, log_shift: Real | None) -> str:
    """Whether the residual is one curve of frequency (fixed) or reduced frequency (moving)."""
    # Where the shift is small beside the band, one curve is as good as the other.
    if log_shift is None or not temperatures_differ(frame.measurement) or np.ptp(log_shift) < WIDE:
        return ""
    x = np.log(frame.measurement.omega)
    # Each without what the other has: both follow slow misfits, and only what one alone follows can
    # tell.
    fixed, moving = _curve(frame, x), _curve(frame, x + log_shift)
    by_fixed_only = _seen(frame, beyond(fixed, moving))
    by_moving_only = _seen(frame, beyond(moving, fixed))
    if _explains_alone(by_fixed_only, by_moving_only):
        return "fixed"
    if _explains_alone(by_moving_only, by_fixed_only):
        return "moving"
    return ""


def _explains_alone(one: _Seen, other: _Seen) -> bool:
    """Whether only the first of two rival descriptions explains something, beyond a remainder."""
    return one.chance < VERDICT.sentence_alarm and other.excess < VERDICT.rival_rest * one.excess


def _causality(frame: NoiseFrame, pattern: str, log_shift: Real | None) -> str:
    x, groups = (
        np.log(frame.measurement.omega),
        [sweep.rows for sweep in sweeps_of(frame.measurement)],
    )
    if np.ptp(x) == 0.0:
        return ""
    reduced = x
    if pattern == "moving" and log_shift is not None:
        reduced = x + log_shift
    # One curve through all sweeps has more points to tell by; but only where it is all that is
    # left.
    if pattern and _is_one(frame, _curve(frame, reduced)):
        x, groups = reduced, [np.arange(len(x))]
    frame = _no_rougher(frame)
    evidence = causal_evidence(frame, x, groups)
    if evidence > VERDICT.causal:
        return "it is consistent with causality, so that a material or a rig can be its cause"
    # A resonance is sought only where the cheap test fails: hundreds of them are tried.
    not_causal = evidence < -VERDICT.causal
    if not_causal and causal_evidence(_with_resonance(frame, x), x, groups) < -VERDICT.causal:
        return (
            "it is not causal (storage and loss do not belong together): a fault of the instrument"
            " or of the analysis, or a nonlinearity, is likelier than a property of a linear"
            " material; a loss that does not change with frequency (ideal hysteretic damping) is"
            " not causal either"
        )
    return ""


def _no_rougher(frame: NoiseFrame) -> NoiseFrame:
    """The frame with noise as large as neighbours differ.

    Scatter beyond the stated one is no breach of causality.
    """
    n, lines = len(frame.measurement), [sweep.rows for sweep in sweeps_of(frame.measurement)]
    bend = np.concatenate([np.diff(frame.rest[rows + k], 2) for rows in lines for k in (0, n)])
    if len(bend) < ENOUGH_NEIGHBOURS:
        return frame
    # The median, which a narrow resonance does not raise; second differences of white noise vary
    # six times as much.
    scatter = float(np.median(np.abs(bend))) / (normal_quantile(0.75) * np.sqrt(6.0))
    return replace(frame, weights=frame.weights / max(scatter, 1.0))


def _is_one(frame: NoiseFrame, curve: Real) -> bool:
    """Whether one curve is all that the residual has beside noise.

    Else each sweep is judged by itself.
    """
    free = frame.size - int(frame.absorbed.shape[1]) - int(curve.shape[1])
    left = frame.worth * float(frame.rest @ frame.rest) - _seen(frame, curve).energy
    return _Seen(left, frame.worth * free, frame.scale_dof).chance > VERDICT.all_of_it


def _with_resonance(frame: NoiseFrame, x: Real) -> NoiseFrame:
    """The frame of a model that has one resonance more.

    Too narrow for the points, it would not look causal.
    """
    step, best, most = step_of(frame), np.zeros((0, len(x)), dtype=np.complex128), 0.0
    for pole in np.arange(x.min() - step, x.max() + step, step / NARROW):
        for width in step * np.array(RESONANCES):
            at = 1j * np.exp(x - pole)
            shape = frame.model_stiffness / (1.0 + 2.0 * width * at + at**2)
            shapes = np.array([shape, at * shape])
            energy = _seen(frame, frame.beyond(frame.whiten(shapes).T)).energy
            if energy > most:
                best, most = shapes, energy
    return replace(frame, jacobian=np.concatenate([frame.jacobian, best]))
