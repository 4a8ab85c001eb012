"""What stands mixed up in a table: tests, columns, and channels that count the other way.

Whether rows of several tests stand together, and which columns tell them apart: nobody fits them as
one without a word, and nobody takes what sets them apart for noise. With the one notion of a sweep
for all that look at neighbours: the lines along which measured points follow one another, and runs,
in which one thing was swept while all that is said of the others stayed.

Of a linear passive material K = K_e + i omega c + integral of H(r) i omega / (i omega + r) d ln r
with H >= 0 (the Kramers-Kronig relations and positive work in one), so that a course of storage has
its own course of loss. Columns that no such material could have, but one could if they were
exchanged, were named the wrong way round. A specimen that gives work away, or pulls when pushed,
has a channel of the wrong sign.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from shlex import split
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import autocorrelation_time
from springpot.numerics import BEYOND, COARSE, PER_DECADE, evenly, non_negative, rows_alike
from springpot.rheology.levels import levels_of
from springpot.rheology.points import STEADY, Complex, Real, real_form
from springpot.thresholds import COURSE, SIGNALS, VARIED

from .independence import (
    DECIMALS,
    POINTS_PER_DEGREE,
    SMOOTH_DEGREE,
    at_one_frequency,
    frequency_numbers,
    held_frequency_numbers,
    independent,
)
from .measurement import CONDITIONS, Measurement
from .timetest import TimeTest

NOTE = "note together"
"""Key of the note in a measurement's provenance."""
RUNS = frozenset(
    (
        *(
            "run",
            "set",
            "test",
            "series",
            "specimen",
            "sample",
            "file",
            "batch",
            "cycle",
            "dataset",
            "measurement",
        ),
        *("probe", "lauf", "serie", "versuch", "messung", "essai", "prueba", "prova"),
    )
)
"""Names of columns that tell one test from another, also where they hold numbers."""
_ANSWERS = frozenset(
    {"normal_force", "torque", "stress", "gap", "time", "axial_force", "displacement"}
)
"""Names of columns that mostly hold what a specimen answered, or when.

Rounded in the file they look like settings, and are some only where they stand for whole sweeps.
"""
TIME = "time"
"""The column in which files hold when a point was measured."""
MOST_NAMES = 0.5
"""Share of rows that distinct words may be, to be names of runs and not remarks on rows."""

_HELD = 0.01
"""Share of the largest within which numbers with a fraction are one that was held.

A rig's own rounding, 0.400 and
0.401 mrad, is no setting. Rheometers hold what was set within 1 to 2 %."""


class TestRows(Hashable, Protocol):
    """What of a measurement tells its tests and its sweeps."""

    @property
    def omega(self) -> Real:
        """Angular frequency (n,) in rad/s."""

    @property
    def conditions(self) -> Mapping[str, Real]:
        """Columns (n,) beside the frequency."""

    @property
    def labels(self) -> Mapping[str, NDArray[np.str_]]:
        """Columns (n,) of words."""

    @property
    def repeat(self) -> NDArray[np.int64] | None:
        """Which repetition a row (n,) belongs to."""


def runs_together(
    numbers: Mapping[str, Real],
    words: Mapping[str, NDArray[np.str_]],
    known: frozenset[str] = frozenset(),
) -> dict[str, str]:
    """A note where a column says that the rows are of several tests.

    They are fitted as one set of data.

    Parameters
    ----------
    numbers, words : mapping of str to ndarray, shape (n,)
        Conditions and labels of the rows.
    known : frozenset of str
        Columns of which another note tells already.
    """
    columns = []
    for key, column in {**words, **{key: numbers[key] for key in numbers if key in RUNS}}.items():
        values = np.unique(column[column == column])  # not those that are missing
        # A word on nearly every row is a remark, such as a time of day, and names no test.
        several = 1 < len(values) <= max(2, MOST_NAMES * len(column))
        if (
            several
            and key not in known
            and not _names_a_condition(np.unique(column, return_inverse=True)[1], numbers)
        ):
            columns.append(
                f"{len(values)} values of {key}, choose one by '@{_chosen(key, values[0])}'"
            )
    if not columns:
        return {}
    return {NOTE: f"rows of several tests are together: {'; '.join(columns)}"}


def _chosen(column: str, value: np.str_ | np.float64) -> str:
    """How a user chooses the rows of one value: ``current=0.5``."""
    if isinstance(value, np.str_):
        return f"{column}={value}"
    return f"{column}={value:g}"


def largest_test(measurement: Measurement, column: str) -> str:
    """How a user chooses the rows of a column's most frequent value, such as ``current=0.5``.

    Parameters
    ----------
    measurement : Measurement
        The data.
    column : str
        One of its conditions or labels.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement.mixed_up import largest_test
    >>> data = Measurement([1.0, 2.0, 1.0], [1j, 2j, 3j], conditions={"current": [0.0, 0.0, 0.5]})
    >>> largest_test(data, "current")
    'current=0'
    """
    words = {**measurement.conditions, **measurement.labels}[column]
    values, count = np.unique(words, return_counts=True)
    return _chosen(column, values[np.argmax(count)])


def tests_together(measurement: Measurement) -> list[str]:
    """Columns that name the tests of which rows stand together, those of few values first."""
    settings = settings_of(measurement)
    apart = told_apart(measurement)
    return [
        name for name in settings if name in measurement.labels or name in RUNS or name in apart
    ]


def settings_of(data: TestRows) -> dict[str, NDArray[np.int64]]:
    """Columns that no effect knows and that hold a setting, test or specimen, few values first.

    Parameters
    ----------
    data : Measurement
        The data.

    Returns
    -------
    dict of str to ndarray of int, shape (n,)
        For each column the number of the value of each row.

    Examples
    --------
    >>> import numpy as np
    >>> current = {"current": np.repeat([0.0, 1.0], 4)}
    >>> data = Measurement(np.tile([1.0, 2.0, 4.0, 8.0], 2), np.ones(8) + 1j, conditions=current)
    >>> settings_of(data)["current"].tolist()
    [0, 0, 0, 0, 1, 1, 1, 1]
    """
    columns: dict[str, NDArray[np.float64] | NDArray[np.str_]] = dict(data.labels)
    columns |= {
        name: column
        for name, column in data.conditions.items()
        if name not in {*CONDITIONS, *_ANSWERS}
    }
    columns |= {
        name: data.conditions[name]
        for name in sorted(_ANSWERS & data.conditions.keys())
        if _stands_for_sweeps(data, name)
    }
    numbered = {}
    for name, column in columns.items():
        values, number = np.unique(column, return_inverse=True)
        number = number.ravel().astype(np.int64)
        # What differs from row to row was measured, as a torque is, and not set; and a sweep of too
        # few points for a course of its own tells none of a setting.
        if not 1 < len(values) <= len(column) // POINTS_PER_DEGREE:
            continue
        if not _was_held(np.asarray(values)) and not _names_a_condition(number, data.conditions):
            numbered[name] = number
    return dict(sorted(numbered.items(), key=lambda each: int(each[1].max())))


def _stands_for_sweeps(data: TestRows, name: str) -> bool:
    """Whether a column that holds answers has few values, each that of whole sweeps.

    A gap or a waiting time that was chosen, not that of a point.

    Within one sweep what is rounded stands still too, but no frequency comes again.
    """
    values, number = np.unique(data.conditions[name], return_inverse=True)
    # More times tell a course, more answers that they were measured.
    if not 1 < len(values) < COURSE.fewest_times:
        return False
    frequency = frequency_numbers(data)
    seen = np.unique(np.column_stack([number.ravel(), frequency]), axis=0)
    # Each frequency at most of the values, on average.
    return bool(2 * len(seen) > len(values) * len(np.unique(frequency)))


def _was_held(values: NDArray[np.generic]) -> bool:
    """Whether distinct values, ascending, are one that was held.

    Whole numbers may count specimens or years.
    """
    if values.dtype.kind not in "fi" or np.all(np.round(values.astype(float)) == values):
        return False
    return bool(np.ptp(values) <= _HELD * np.max(np.abs(values)))


def _names_a_condition(number: NDArray[np.intp], conditions: Mapping[str, Real]) -> bool:
    """Whether each level of temperature or amplitude has one value of a column, as a step has."""
    for name in CONDITIONS:
        if name not in conditions:
            continue
        level = levels_of(name, conditions[name])
        pairs = np.unique(np.column_stack([level, number.ravel()]), axis=0)
        if len(pairs) == len(np.unique(level)) < len(level):
            return True
    return False


# Every look at neighbours asks anew, of the same data: of a few it is remembered.
@lru_cache(maxsize=8)
def told_apart(data: TestRows) -> dict[str, NDArray[np.int64]]:
    """The settings (n,) without which rows alike in frequency and conditions would be one point.

    Such rows are neither repeats of each other nor points of one sweep. Names set apart what is no
    other repeat already: a column of specimens that are the repeats themselves stays out. Numbers
    are sizes of something that was changed, whether or not the rows are numbered as repeats.

    Parameters
    ----------
    data : Measurement
        The data.
    """
    settings = settings_of(data)
    if not settings:
        return {}
    same = [frequency_numbers(data)]
    same += [
        levels_of(name, data.conditions[name]) for name in CONDITIONS if name in data.conditions
    ]
    repeat = np.zeros(len(data.omega), dtype=np.int64)
    if data.repeat is not None:
        repeat = data.repeat
    apart: dict[str, NDArray[np.int64]] = {}

    def points(beside: Sequence[NDArray[np.int64]], name: str) -> int:
        columns = [*same, *apart.values(), *beside]
        # A name and a repeat are two words for one thing; a size and a repeat are not.
        if name in data.labels or name in RUNS:
            columns.append(repeat)
        return len(np.unique(np.column_stack(columns), axis=0))

    while more := sorted(settings.keys() - apart.keys()):
        left = {name: points([settings[name]], name) - points([], name) for name in more}
        # Whatever tells most rows apart first: beside it others, such as the number of cycles, say
        # nothing more.
        name = min(left, key=lambda name: (-left[name], int(settings[name].max()), name))
        if left[name] == 0:
            break
        apart[name] = settings[name]
    return apart


@dataclass(frozen=True, eq=False)
class ConditionRun:
    """Rows that were measured under one set of conditions.

    Parameters
    ----------
    conditions : dict of str to str or float
        What tells them from other rows: step, run, repeat, temperature and amplitude (the means),
        as far as known.
    rows : ndarray of int
        Their numbers.
    """

    conditions: dict[str, str | float]
    rows: NDArray[np.int64]

    @property
    def name(self) -> str:
        """Such as ``temperature 20, repeat 1``; ``all`` where nothing tells the rows apart."""
        parts = []
        for name, value in self.conditions.items():
            if not isinstance(value, str):
                value = f"{value:.4g}"
            parts.append(f"{name} {value}")
        return ", ".join(parts) or "all"


def runs_of(data: TestRows) -> Iterator[ConditionRun]:
    """The sweeps, by runs and conditions.

    By the names of parts and runs in the order of the file, then by temperature, amplitude and
    repeat.

    A condition that was itself swept or only wandered does not part them: a temperature ramp is one
    sweep, and so is a frequency sweep in which the strain follows the frequency.

    Parameters
    ----------
    data : Measurement
        The data.
    """
    # Names first, since they were given; levels of conditions are only read off the numbers.
    parts = [np.arange(len(data.omega))]
    for column in _named(data):
        parts = [finer for rows in parts for finer in _by_value(column, rows)]
    for name in ("temperature", "amplitude"):
        if name in data.conditions:
            parts = [finer for rows in parts for finer in _by_level(data, name, rows)]
    # Last: a repeat is one of a sweep, under conditions that are the same.
    if data.repeat is not None:
        parts = [finer for rows in parts for finer in _parted(rows, [data.repeat])]
    for rows in parts:
        yield ConditionRun(_conditions(data, rows, len(parts)), rows)


def _by_value(column: NDArray[np.str_] | Real, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The rows of each value, in the order of the file."""
    return [rows[column[rows] == value] for value in dict.fromkeys(column[rows].tolist())]


def _named(data: TestRows) -> list[NDArray[np.str_] | Real]:
    """Columns that name parts and runs."""
    columns: list[NDArray[np.str_] | Real] = []
    for name, words in data.labels.items():
        if name == "step" or len(np.unique(words)) <= MOST_NAMES * len(words):
            columns.append(words)
    apart = told_apart(data)
    return [
        *columns,
        *(column for name, column in data.conditions.items() if name in RUNS or name in apart),
    ]


def _by_level(data: TestRows, name: str, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The rows of each level, ascending, where frequencies were swept at each.

    Else all as they are.
    """
    level = levels_of(name, data.conditions[name][rows])
    count = int(level.max()) + 1
    frequency = held_frequency_numbers(data.omega[rows])
    pairs = len(np.unique(np.column_stack([level, frequency]), axis=0))
    # A level at which one frequency was measured is no sweep.
    if count == 1 or pairs < 2 * count:
        return [rows]
    if name == "amplitude" and pairs < VARIED.recurs * len(np.unique(frequency)):
        return [rows]
    return [rows[level == number] for number in range(count)]


def _conditions(data: TestRows, rows: NDArray[np.int64], count: int) -> dict[str, str | float]:
    """What holds for all of the rows."""
    shared: dict[str, str | float] = {}
    for name, words in data.labels.items():
        if name == "step" or (
            count > 1 and len(set(words[rows])) == 1 and len(np.unique(words)) > 1
        ):
            shared[name] = str(words[rows[0]])
    for name in ("temperature", "amplitude"):
        column = data.conditions.get(name)
        # The amplitude is told only where it was set: it wanders in every sweep.
        if column is not None and (name == "temperature" or _is_set(column, rows)):
            shared[name] = float(np.mean(column[rows]))
    names = RUNS | told_apart(data).keys()
    shared |= {
        name: float(data.conditions[name][rows[0]]) for name in data.conditions if name in names
    }
    if data.repeat is not None:
        shared["repeat"] = float(data.repeat[rows[0]])
    return shared


def _is_set(column: Real, rows: NDArray[np.int64]) -> bool:
    """Whether the rows are one level of an amplitude that has several."""
    return (
        int(levels_of("amplitude", column[rows]).max()) == 0
        and int(levels_of("amplitude", column).max()) > 0
    )


SCALES: dict[str, Callable[[Real], Real]] = {"amplitude": np.log, "temperature": np.asarray}
"""Conditions that can be swept at one frequency, each with the scale on which K changes slowly."""


class Sweep(NamedTuple):
    """Points of one sweep.

    Attributes
    ----------
    rows : ndarray of int, shape (m,)
        Row numbers, in the order of `x`.
    x : ndarray, shape (m,)
        ln omega, or where only a condition varies ln amplitude or the temperature.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import sweeps_of
    >>> sweep = sweeps_of(springpot.read("artificial-hidden"))[0]
    >>> len(sweep.rows), sweep.x[:2].round(3)
    (40, array([1.145, 1.281]))
    """

    rows: NDArray[np.int64]
    x: Real


def temperatures_differ(measurement: Measurement) -> bool:
    """Whether there is more than the drift about one set temperature.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement.mixed_up import temperatures_differ
    >>> conditions = {"temperature": [20.0, 20.3]}
    >>> temperatures_differ(Measurement([1.0, 2.0], [1j, 2j], conditions=conditions))
    False
    """
    column = measurement.conditions.get("temperature")
    return column is not None and float(np.ptp(column)) >= VARIED.temperature_wanders


def sweeps_of(measurement: Measurement) -> list[Sweep]:
    """Frequency sweeps, else amplitude or temperature sweeps.

    All rows are one sweep where each differs in all.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import Measurement
    >>> omega = np.array([1.0, 2.0, 4.0, 1.0, 2.0, 4.0])
    >>> temperature = np.array([20.0] * 3 + [40.0] * 3)
    >>> data = Measurement(omega, np.ones(6) + 1j, conditions={"temperature": temperature})
    >>> [sweep.rows.tolist() for sweep in sweeps_of(data)]
    [[0, 1, 2], [3, 4, 5]]
    """
    # A sweep of fewer than three points has no course of its own: then the points follow another
    # condition.
    most = max(1, len(measurement) // 3)
    log_omega = np.log(measurement.omega)
    apart = list(told_apart(measurement).values())
    # First by every condition; then an amplitude that moved along with the frequency, as where the
    # force is held, does not part the points of a sweep, of which it would make one for each.
    for held in (CONDITIONS, [name for name in CONDITIONS if independent(measurement, name)]):
        groups = [
            part for _, rows in measurement.sweeps(held=held) for part in _parted(rows, apart)
        ]
        if len(groups) <= most and not at_one_frequency(measurement):
            return [_ordered(rows, log_omega) for rows in groups]
    for name, scale in SCALES.items():
        column = measurement.conditions.get(name)
        if column is None or np.ptp(column) == 0:
            continue
        groups = _at_constant(measurement, name)
        if len(groups) <= most:
            return [_ordered(rows, scale(column)) for rows in groups]
    # Nothing was held while something else was swept: all points in the order of frequency are the
    # best there is.
    return [_ordered(np.arange(len(measurement)), log_omega)]


def longest_memory(sweeps: Sequence[Sweep]) -> float:
    """Correlation of neighbours above which noise of a sweep is alike as slow curves are."""
    return float(np.exp(-SMOOTH_DEGREE / max(len(rows) for rows, _ in sweeps)))


def _parted(rows: NDArray[np.int64], columns: list[NDArray[np.int64]]) -> list[NDArray[np.int64]]:
    """The rows of each set of values of some columns (n,)."""
    if not columns:
        return [rows]
    return [rows[part] for part in rows_alike(*(column[rows] for column in columns))]


def _at_constant(measurement: Measurement, swept: str) -> list[NDArray[np.int64]]:
    """Rows at one frequency and equal conditions but for the swept one."""
    # A frequency that was held is told as it was measured, now a little higher and now a little
    # lower.
    columns = [held_frequency_numbers(measurement.omega).astype(float)]
    for name in SCALES:
        if name != swept and name in measurement.conditions:
            columns.append(np.round(measurement.conditions[name], DECIMALS))
    columns += [number.astype(float) for number in told_apart(measurement).values()]
    if measurement.repeat is not None:
        columns.append(measurement.repeat.astype(float))
    return rows_alike(*columns)


def _ordered(rows: NDArray[np.int64], x: Real) -> Sweep:
    order = np.argsort(x[rows], kind="stable")
    return Sweep(rows[order], x[rows[order]])


Turned = TypeVar("Turned")
EXCHANGED = "note exchange"
"""Key of the note in a measurement's provenance."""
FEWEST_POINTS = 5
"""With fewer points nearly any pair of curves is that of some material."""
LEAST_RANGE = 5.0
"""Ratio of highest and lowest frequency.

Over less, both curves are straight lines and tell little of each other.
"""
MOST_DECADES = 20.0
"""Of frequencies and of |K|.

No instrument and no master curve has more, and a spectrum over hundreds of decades
would take seconds at each opening."""
MOST_ROWS = 10_000
"""Larger tables are written by programs, which mix up no columns, and finding their sweeps would
take time.
"""
BACK = 0.1
"""Share by which a test goes back under a load that is held, from which a note says so."""
FAR = 0.1
"""Relative rms from which no material is near.

Measured sweeps that were named rightly lie at 0.001 to 0.2, exchanged
at 0.3 to 0.8, those of a springpot of order 1/2, whose two parts are alike, at 0.1."""
NEAR = 0.2
"""Share of that misfit which the exchanged columns may have left.

A mass or a delay takes a sweep far from every
material too, but exchanging its columns brings it no nearer (0.8 to 3 times of the misfit in all
data at hand).
"""


def exchange_note(measurement: Measurement) -> dict[str, str]:
    """A note where storage and loss look exchanged; empty otherwise.

    Parameters
    ----------
    measurement : Measurement
        The data; the sweep with the most points is looked at.
    """
    if len(measurement) > MOST_ROWS:
        return {}
    sweep = max(sweeps_of(measurement), key=lambda each: len(each.rows))
    rows = sweep.rows[evenly(len(sweep.rows), COARSE)]
    omega, stiffness = measurement.omega[rows], measurement.stiffness[rows]
    if len(np.unique(omega)) < FEWEST_POINTS or omega.max() < LEAST_RANGE * omega.min():
        return {}
    if max(decades(omega), decades(np.abs(stiffness))) > MOST_DECADES:
        return {}
    # Of what is left neither is near the end of what a number can be.
    omega, stiffness = omega / omega.max(), stiffness / np.abs(stiffness).max()
    # By an absolute bound first: sound data, which nearly all are, need no second fit.
    as_named = material_misfit(omega, stiffness)
    if as_named < FAR:
        return {}
    exchanged = material_misfit(omega, stiffness.imag + 1j * stiffness.real)
    if exchanged > NEAR * as_named:
        return {}
    return {
        EXCHANGED: (
            f"no material has such storage and loss ({100 * as_named:.0f} % off), but one has them"
            f" the other way round ({100 * exchanged:.1f} %): if the columns are exchanged, open"
            " 'FILE?storage=loss,loss=storage'"
        )
    }


def decades(positive: Real) -> float:
    """Powers of ten between the least and the largest of some positive numbers."""
    return float(np.log10(positive.max()) - np.log10(positive.min()))


def material_misfit(omega: Real, stiffness: Complex) -> float:
    """Relative rms distance of a sweep from the nearest linear passive material.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s.
    stiffness : ndarray of complex, shape (n,)
        Complex stiffness or modulus; none zero.

    Returns
    -------
    float
        Root mean square of |K - K_material| / |K|.

    Examples
    --------
    >>> import numpy as np
    >>> omega = np.logspace(-1, 1, 9)
    >>> maxwell = 1j * omega / (1 + 1j * omega)
    >>> bool(material_misfit(omega, maxwell) < 0.01)
    True
    >>> bool(material_misfit(omega, maxwell.conj()) > 0.3)
    True
    """
    low, high = np.log10([omega.min() / BEYOND, omega.max() * BEYOND])
    rates = np.logspace(low, high, int(PER_DECADE * (high - low)) + 1)
    modes = 1j * omega[:, None] / (1j * omega[:, None] + rates)
    # Beside the spectrum a spring and a dashpot, its limits at infinitely low and high rates.
    basis = np.column_stack([np.ones_like(omega), 1j * omega / omega.max(), modes])
    # Relative at each point: a sweep over decades would else be judged at its stiff end alone.
    weighted = basis / np.abs(stiffness)[:, None]
    target = stiffness / np.abs(stiffness)
    _, left = non_negative(real_form(weighted), real_form(target))
    return float(np.sqrt(left / len(omega)))


SIGN = "note sign"
"""Where the doubt is kept among what is told of a test."""


def said_of_sign(provenance: Mapping[str, str]) -> list[str]:
    """What was noted of the sign when data were opened, as a list of one or none."""
    return [said for key, said in provenance.items() if key == SIGN]


def turned(provenance: Mapping[str, str]) -> str:
    """The data the right way round, where a channel counts the other way or two are exchanged.

    Empty for others.
    """
    said = provenance.get(SIGN) or provenance.get(EXCHANGED, "")
    return "".join(split(said.partition(", open ")[2]))


def wrong_way(provenance: Mapping[str, str]) -> str:
    """What of such data is the wrong way round: ``force``, ``phase`` or ``storage and loss``."""
    if SIGN not in provenance:
        return "storage and loss"
    return "phase" if "as if the phase" in provenance[SIGN] else "force"


def turned_over(test: Turned) -> Turned:
    """The same test, what it answers counting the other way; one of frequencies stays."""
    if not isinstance(test, TimeTest):
        return test
    told = {key: said for key, said in test.provenance.items() if key != SIGN}
    return replace(test, response=-test.response, provenance=told)


def sign_note(test: TimeTest, hint: str) -> dict[str, str]:
    """What to tell of a test in which force and displacement count in opposite directions.

    Nothing of another.

    Parameters
    ----------
    test : TimeTest
        Of any kind.
    hint : str
        What to say behind the file's name to turn one channel, such as ``force=-N``.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.mixed_up import sign_note
    >>> t = np.linspace(0.0, 1.0, 200)
    >>> test = TimeTest.of_history(t, np.sin(20 * t), -3.0 * np.sin(20 * t + 0.4), "mm", "N")
    >>> sign_note(test, "force=-N")["note sign"][:45]
    'the specimen gives work away, as if the force'
    """
    moved = np.interp(test.time, test.loading.time, test.loading.value)
    pulled = test.response
    if test.control == "force":
        moved, pulled = pulled, moved
    if test.kind == "history":
        turned, why = _gives_work(test.time, moved, pulled), "the specimen gives work away"
    else:
        # No cycle, over which work is counted: a push is answered by a push until it is taken
        # back. By how much, as what has relaxed to nothing is noise of either sign.
        size = np.abs(moved if test.control == "displacement" else pulled)
        until = 1 + int(np.flatnonzero(size >= (1.0 - STEADY) * size.max())[-1])
        turned = bool(np.sum((moved * pulled)[:until]) < 0.0)
        why = "force and displacement are opposed"
    if not turned:
        return {}
    turn = f"if one channel counts the other way, open 'FILE?{hint}'"
    return {SIGN: f"{why}, as if the force had the wrong sign: {turn}"}


def history_note(test: TimeTest) -> dict[str, str]:
    """A note where a test goes back though its load is held, as after a load that nobody tells of.

    The creep of any passive material only grows, and its relaxation only falls (Bernstein).

    Parameters
    ----------
    test : TimeTest
        Of any kind.
    """
    if not test.after_step:
        return {}
    size = test.response * np.sign(test.loading.value[np.argmax(np.abs(test.loading.value))])
    few = max(1, len(size) // 10)
    first, last = float(np.mean(size[:few])), float(np.mean(size[-few:]))
    if not first > 0.0:
        return {}
    moved, held, went, back = "stress", "strain", "grows", last / first - 1.0
    if test.control == "force":
        moved, held, went, back = "strain", "stress", "falls", 1.0 - last / first
    if back < BACK:
        return {}
    return {
        "note history": f"the {moved} {went} by {100.0 * back:.0f} % while the {held} is held,"
        " as after a load that the file does not tell of, or where the specimen changes: no"
        " material does that by itself; give the record from its rest on"
    }


def _gives_work(time: Real, moved: Real, pulled: Real) -> bool:
    """Whether the force surely goes against the velocity, and not surely with the displacement.

    Above a resonance the storage is negative, and with a late channel the loss; with the wrong sign
    no part is left.
    """
    if np.any(np.diff(time) <= 0.0):
        return False
    columns = np.stack([np.ones_like(moved), moved, np.gradient(moved, time)], axis=1)
    size = np.abs(columns).max(axis=0)
    if not np.all(size > 0.0):
        return False
    amounts, _, rank, _ = np.linalg.lstsq(columns / size, pulled, rcond=None)
    if rank < columns.shape[1]:
        return False
    rest = pulled - (columns / size) @ amounts
    # What is left of a record is alike from sample to sample: it holds fewer than it seems.
    power = float(np.mean(rest**2)) * autocorrelation_time(rest)
    inverse = np.linalg.inv((columns / size).T @ (columns / size))
    sd = np.sqrt(np.diag(inverse) * power)
    stiffness, damping = amounts[1:] / np.maximum(sd[1:], np.finfo(float).tiny)
    return bool(damping < -SIGNALS.negative and stiffness < SIGNALS.negative)
