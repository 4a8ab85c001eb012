"""What a user knows beforehand, in printed units: held values, bounds, start values, options.

The words of the command line, ``alpha=0.5`` and ``k1=0:200``, become the same mappings that Python
takes.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError, ModelError, OptionError
from springpot.identification.material import is_material
from springpot.identification.runs import Optimiser
from springpot.measurement.conversion import FILE, LEVELS, file_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test, conditions, sweep_of, tests_without, together
from springpot.measurement.units import Units
from springpot.numerics import set_numbers
from springpot.registry import plugins
from springpot.rheology.levels import levels_of
from springpot.rheology.model import Model
from springpot.rheology.parameters import HasParameters
from springpot.rheology.spectrum import MOST_TERMS

Bounds = tuple[float, float]
V = TypeVar("V")
EVERY = "*"
"""In the place of a parameter's name."""


def times_of(text: str, per_decade: int = 1) -> NDArray[np.float64]:
    """Relaxation times in s, evenly over the decades of a range such as ``1e-6:1e6``.

    Raises
    ------
    OptionError
        If it is no range, or holds more than a series has.

    Examples
    --------
    >>> from springpot.constraints import times_of
    >>> times_of("1e-2:1e1").round(6)
    array([ 0.01,  0.1 ,  1.  , 10.  ])
    """
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = 0.0, 0.0
    if not 0.0 < low < high < np.inf:
        raise OptionError(f"'{text:.40}' is no range of times: write two in s, such as 1e-6:1e6")
    count = int(np.round(per_decade * np.log10(high / low))) + 1
    if count > MOST_TERMS:
        raise OptionError(
            f"{count} times are more than the {MOST_TERMS} of a series: narrow --times, or fewer a"
            " decade"
        )
    return np.geomspace(low, high, count)


def at_times(model: Model, times: NDArray[np.float64]) -> dict[str, float]:
    """The times of a sum of relaxations, held in the order in which it has them.

    Raises
    ------
    OptionError
        If it has not as many.
    """
    names = [
        parameter.name
        for parameter in model.material.parameters
        if (parameter.unit.time, parameter.unit.stiffness) == (1, 0)
    ]
    if len(names) != len(times):
        raise OptionError(
            f"--times are {len(times)}, and {model.name} has {len(names)}: give a family of sums of"
            " relaxations, --model prony or maxwell-N"
        )
    return dict(zip(names, times.tolist(), strict=True))


def constrained(
    model: Model,
    units: Units,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    tie: str | Sequence[str] = (),
) -> Model:
    """The model with parameters held, bounded or tied, of values in printed units.

    Parameters
    ----------
    model : Model
        The model.
    units : Units
        Those of the tests.
    fix : mapping of str to float, optional
        Parameters to hold: ``{"alpha": 0.5, "inertia.m": 0.6}``.
    bounds : mapping of str to (float, float), optional
        Lower and upper end, by name.
    tie : str or sequence of str
        Parameters that follow from others, or keep an order: ``["k2 = 2*k1", "tau1 < tau2"]``.

    Raises
    ------
    ModelError
        If a name is unknown or one of a free spectrum, or a value cannot be.
    OptionError
        If these are no mappings, or what they hold are no numbers.
    """
    fixed = own_values(model, units, fix, "fix")
    own_bounds: dict[str, Bounds] = {}
    for name, ends in by_name(bounds, "bounds", '{"k": (0, 200)}').items():
        # Text is a sequence too: "05" would pass for the ends 0 and 5.
        if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
            raise OptionError(
                f"bounds of {name} are a lower and an upper end, such as (0, 200), not {ends!r:.40}"
            )
        low, high = ends
        own_bounds[name] = (own_value(model, units, name, low), own_value(model, units, name, high))
    return tied(model.holding(fixed, own_bounds), units, tie)


def tied(model: Model, units: Units, tie: str | Sequence[str]) -> Model:
    """The model with parameters that follow from others, whose numbers are in printed units.

    Raises
    ------
    ModelError
        If a tie is none, or cannot be kept.
    OptionError
        If it is no text.
    """
    # A single text need not stand in a list.
    ties = [tie] if isinstance(tie, str) else list(tie)
    for text in ties:
        if not isinstance(text, str):
            raise OptionError(f"a tie is a text such as 'k2 = 2*k1', not {text!r:.40}")
        for name in model.held:
            if re.search(rf"(?<![\w.#-]){re.escape(name)}(?![\w.])", text):
                raise ModelError(f"'{text:.80}': {name} is held already, so nothing ties it")
    if ties and is_material(model):
        raise ModelError(
            f"{model.name}: parameters of a free spectrum cannot be tied; name a model that has"
            " them, such as prony-3"
        )
    factors = {each.name: units.of(each.unit)[0] for each in model.parameters}
    return model.tying(ties, factors)


def owning(
    model: Model,
    tests: Sequence[Test],
    own: Mapping[str, str] | None,
    share: str | Sequence[str] = (),
    specimen: str | None = None,
) -> tuple[Model, list[Test]]:
    """The model with parameters of which each level of a column has its own, and the tests.

    Words of a column, such as the names of files, are numbered in their order, so that the levels
    have a place in a model.

    Parameters
    ----------
    model : Model
        The model.
    tests : sequence of Test
        A sweep, or tests in time beside others: these have the levels of files or temperatures.
    own : mapping of str to str, optional
        The column of each such parameter: ``{"k": "batch"}``; ``"*"`` is every parameter.
    share : str or sequence of str
        Parameters that all levels share; without `own` every other one is each specimen's.
    specimen : str, optional
        Columns whose levels are the specimens, in the place of the files: ``"batch,number"``.

    Raises
    ------
    ModelError
        If a name is unknown, or the material is a free spectrum.
    DataError
        If the data have no such column or a single level of it.
    OptionError
        If it is no mapping.
    """
    tests = numbered(tests, model.needs)
    wanted = _of_ties(model, by_name(own, "own", '{"k": "batch"}'))
    shared = [share] if isinstance(share, str) else list(share)
    for name in shared:
        if name not in model.names:
            raise ModelError(f"{model.name} has no free parameter '{name}' that could be shared")
        if name in wanted:
            raise ModelError(f"{name} is each level's own, or shared: not both")
    if shared and not wanted:
        wanted = {EVERY: FILE}
    if specimen is not None:
        wanted, tests = _of_specimens(wanted, tests, specimen)
    if not wanted:
        return model, list(tests)
    if is_material(model):
        raise ModelError(
            f"{model.name}: levels have parameters of their own in a model with a name, not in a"
            " free spectrum: name one, such as fractional-zener"
        )
    counted = list(tests)
    for name, column in wanted.items():
        names = [name]
        if name == EVERY:
            # Factors of levels are each level's already.
            of_levels = {prefix for effect, prefix in model.named_effects() if effect.by_levels}
            names = [
                each
                for each in model.names
                if each.rpartition(".")[0] not in of_levels and each not in shared
            ]
        model = model.owning(names, column)
        sweep = sweep_of(counted)
        counted = marked(counted, column) if sweep is None else [_numbered(sweep, column)]
    return model, counted


def numbered(tests: Sequence[Test], columns: Iterable[str]) -> list[Test]:
    """The tests, with numbers for the words of those columns of which a law needs the levels.

    Parameters
    ----------
    tests : sequence of Test
        A sweep, or tests in time, which have no columns of words and stay as they are.
    columns : iterable of str
        What a model or an effect needs beside the frequency, such as ``"batch"``.
    """
    sweep = sweep_of(tests)
    if sweep is None:
        return list(tests)
    for column in sorted(set(columns) & set(sweep.labels)):
        sweep = _numbered(sweep, column)
    return [sweep]


def marked(tests: Sequence[Test], column: str) -> list[Test]:
    """Tests, in time among them, each with the number of its level where files are the levels.

    Raises
    ------
    DataError
        If tests are not told apart by the column, or all have one level of it.
    """
    if column == FILE:
        files = list(dict.fromkeys(file_of(test.name) for test in tests))
        number = {file: 1.0 + i for i, file in enumerate(files)}
        tests = [_with_mark(test, number[file_of(test.name)]) for test in tests]
    for test in tests:
        if column not in test.conditions:
            others = "or tell tests apart by file (--own k) or temperature (--own k:temperature)"
            value = "20[degC]" if column == "temperature" else "1[-]"
            known = f"say it of each test, such as 'FILE?{column}={value}'"
            raise DataError(f"{test.name} has no {column}: {known}, {others}")
    values = np.concatenate([np.unique(test.conditions[column]) for test in tests])
    if len(np.unique(levels_of(column, values))) < 2:
        raise DataError(
            f"{together(test.name for test in tests)}: one {column} alone, and nothing is its own:"
            " name tests that differ in it"
        )
    return list(tests)


def _with_mark(test: Test, number: float) -> Test:
    if isinstance(test, Measurement):
        every = np.full(len(test), number)
        return replace(test, conditions={**test.conditions, FILE: every})
    return replace(test, marks={**test.marks, FILE: number})


def asks_for_all(own: Mapping[str, str], share: Sequence[str]) -> bool:
    """Whether files are levels of one fit: parameters are those of each, or shared by all."""
    return FILE in own.values() or bool(share and not own)


def _of_ties(model: Model, wanted: Mapping[str, str]) -> dict[str, str]:
    """The columns by what is free: a tied parameter is a level's own with what it hangs on."""
    bases, found = model.bases, {name: wanted[name] for name in wanted if name not in model.bases}
    for name in set(wanted) & set(bases):
        on = bases[name]
        while any(each in bases for each in on):
            on = [base for each in on for base in bases.get(each, [each])]
        if EVERY not in wanted and not set(on) & set(found):
            found |= dict.fromkeys(on, wanted[name])
    return found


def _of_specimens(
    wanted: dict[str, str], tests: Sequence[Test], columns: str
) -> tuple[dict[str, str], Sequence[Test]]:
    """What is each specimen's own, and the tests, where columns tell the specimens.

    Else files do.
    """
    sweep = sweep_of(tests)
    if sweep is not None:
        return wanted, [_labelled(sweep, columns)]
    if not wanted or not columns.isidentifier():
        raise DataError(
            "beside tests in time one column tells specimens, and of what is their own: name it,"
            " and what they share, as in --specimen batch --share c"
        )
    return {name: columns if by == FILE else by for name, by in wanted.items()}, tests


def _labelled(sweep: Measurement, columns: str) -> Measurement:
    """The sweep whose levels of columns are the specimens that files are else."""
    if FILE in sweep.conditions:
        raise DataError(f"{sweep.name} has a column '{FILE}' of its own: name it as the specimen")
    words = np.array(_words(sweep, columns.replace("/", ",")))
    _, repeat = np.unique(words, return_inverse=True)
    if sweep.repeat is not None:
        # A repeat of one is none of another.
        repeat = set_numbers(repeat.ravel(), sweep.repeat)
    return replace(sweep, labels={**sweep.labels, FILE: words}, repeat=repeat.ravel())


def _words(sweep: Measurement, columns: str) -> list[str]:
    """Of each row what several columns say together: ``2/7``."""
    told = []
    for name in (each.strip() for each in columns.split(",")):
        if name in sweep.labels:
            told.append(sweep.labels[name].tolist())
        elif name in sweep.conditions:
            told.append([f"{value:g}" for value in sweep.conditions[name].tolist()])
        else:
            raise _no_column(sweep, name)
    return ["/".join(each) for each in zip(*told, strict=True)]


def _no_column(sweep: Measurement, name: str) -> DataError:
    """That there is no such column; of one file, what else specimens can be."""
    if name == FILE:
        return DataError(
            f"{sweep.name} is one file: name several, or the column that tells specimens apart,"
            " as in --own k:batch"
        )
    known = ", ".join([*sweep.conditions, *sweep.labels]) or "none"
    return DataError(f"{sweep.name} has no column '{name}' (there are: {known})")


def _numbered(sweep: Measurement, column: str) -> Measurement:
    """The sweep with a column of numbers, where it has one of words, or is several."""
    outer, nested, _ = column.rpartition("/")
    if "/" in outer:
        raise OptionError(f"'{column}': a population has one level above it, as in batch/specimen")
    if nested or "," in column:
        words = _words(sweep, column.replace("/", ","))
        sweep = replace(sweep, labels={**sweep.labels, column: np.array(words)})
    if nested:
        # The column of what specimens are of, which tells their batches.
        sweep = _numbered(sweep, outer)
    if column in sweep.labels:
        labels = dict(sweep.labels)
        given = labels.pop(column).tolist()
        words = list(dict.fromkeys(given))
        places = {word: 1.0 + i for i, word in enumerate(words)}
        number = np.array([places[word] for word in given])
        told = {LEVELS.format(column): json.dumps(words)}
        sweep = replace(
            sweep,
            conditions={**sweep.conditions, column: number},
            labels=labels,
            provenance={**sweep.provenance, **told},
        )
    if column not in sweep.conditions:
        raise _no_column(sweep, column)
    level = levels_of(column, sweep.points.need(column))
    if len(np.unique(level)) < 2:
        raise DataError(f"{sweep.name} has one level of {column}: nothing is its own")
    if sweep.repeat is None:
        return sweep
    # Counted anew within a level: what has parameters of its own is no repeat of another.
    first = np.full(int(level.max()) + 1, sweep.repeat.max())
    np.minimum.at(first, level, sweep.repeat)
    return replace(sweep, repeat=sweep.repeat - first[level])


def own_values(
    model: HasParameters, units: Units, given: Mapping[str, float] | None, option: str
) -> dict[str, float]:
    """Printed values by name, such as start values, in the units of theta.

    Raises
    ------
    ModelError
        If the model has no such parameter.
    OptionError
        If these are no values by name.
    """
    values = by_name(given, option, '{"k": 100.0}')
    return {name: own_value(model, units, name, value) for name, value in values.items()}


def by_name(given: Mapping[str, V] | None, option: str, example: str) -> Mapping[str, V]:
    """What a user gives by name of parameter; nothing where it is left out.

    Raises
    ------
    OptionError
        If it is no mapping, as where somebody writes the words of the command line.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise OptionError(
            f"{option} is a dictionary by parameter, such as {example}, not {given!r:.40}"
        )
    return given


def own_value(model: HasParameters, units: Units, name: str, value: float) -> float:
    """A printed value in the unit of theta.

    Raises
    ------
    ModelError
        If the model has no such parameter, or it is one of a free spectrum.
    OptionError
        If the value is no number.
    """
    # Effects around a free spectrum have parameters of their own.
    chosen = isinstance(model, Model) and is_material(model) and model.material.parameters
    if chosen and any(part.name == name for part in chosen):
        raise ModelError(
            f"{name} of a free spectrum goes with its lines, which the data choose as a whole: it"
            " can be given no value, bound or start; name a model that has it, such as prony-3"
        )
    for parameter in model.parameters:
        if parameter.name != name:
            continue
        factor, unit = units.of(parameter.unit)
        try:
            printed = float(value)
        except (TypeError, ValueError):
            raise OptionError(f"{name} is a number in {unit}, not {value!r:.40}") from None
        return printed / factor
    raise ModelError(
        f"{model.name} has no free parameter '{name}': it has {', '.join(model.names)}"
    )


def excluded(tests: Sequence[Test], exclude: str | Sequence[str]) -> list[Test]:
    """Tests without rows, chosen by texts such as ``frequency=40..60``, ``time=..0.1``, ``row=3``.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.
    """
    # A single text need not stand in a list.
    if isinstance(exclude, str):
        exclude = [exclude]
    for text in exclude:
        tests = tests_without(tests, conditions(text, text))
    return list(tests)


def values_of(texts: Iterable[str]) -> dict[str, float]:
    """Numbers by name, of texts such as ``alpha=0.5``.

    Raises
    ------
    OptionError
        If one is none.
    """
    numbers = {}
    for text in texts:
        name, value = _pair(text, "alpha=0.5")
        numbers[name] = _number(value, text)
    return numbers


def settings_of(texts: Iterable[str]) -> dict[str, float | str]:
    """Settings by name, of texts such as ``batch=2`` or ``file=pad-1``: numbers, else words.

    Raises
    ------
    OptionError
        If one is no setting.
    """
    settings: dict[str, float | str] = {}
    for text in texts:
        name, value = _pair(text, "batch=2")
        try:
            settings[name] = float(value)
        except ValueError:
            settings[name] = value.strip()
    return settings


def bounds_of(texts: Iterable[str]) -> dict[str, Bounds]:
    """Ends by name, of texts such as ``k1=0:200``; either end may be left open.

    Raises
    ------
    OptionError
        If one is none.
    """
    bounds = {}
    for text in texts:
        name, ends = _pair(text, "k1=0:200")
        low, colon, high = ends.partition(":")
        if not colon:
            raise OptionError(f"'{text}': write bounds as NAME=LOW:HIGH, such as k1=0:200")
        least, most = float("-inf"), float("inf")
        # An end may be left open: k1=0:
        if low.strip():
            least = _number(low, text)
        if high.strip():
            most = _number(high, text)
        bounds[name] = (least, most)
    return bounds


def own_of(texts: Iterable[str]) -> dict[str, str]:
    """Columns by name of parameter, of texts such as ``k,c:batch``; of each file without a column.

    Raises
    ------
    OptionError
        If one names no parameter.
    """
    own = {}
    for text in texts:
        names, colon, column = text.partition(":")
        for name in names.split(","):
            if not name.strip() or (colon and not column.strip()):
                raise OptionError(f"'{text}': write --own NAMES:COLUMN, such as k,c:batch")
            own[name.strip()] = column.strip() or FILE
    return own


PARAMETERS = ("own", "share", "tie", "specimen", "population")
"""Options that say whose parameters are, and how they follow from one another."""


def parameters_of(text: str) -> dict[str, Any]:
    """The arguments ``own``, ``share``, ``tie`` and ``specimen``, as a command line has them.

    Raises
    ------
    OptionError
        If there is anything else.

    Examples
    --------
    >>> from springpot.constraints import parameters_of
    >>> parameters_of("--own k:batch --tie 'c = 2*k'")
    {'own': {'k': 'batch'}, 'tie': ['c = 2*k']}
    """
    given: dict[str, list[str]] = {}
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise OptionError(f"'{text:.80}': {error}") from None
    for option, value in zip(words[::2], [*words[1::2], ""], strict=False):
        name = option.removeprefix("--")
        if option == name or name not in PARAMETERS or not value:
            raise OptionError(
                f"'{option:.40} {value:.40}': write --own k:batch, --share c, --tie 'k2 = 2*k1',"
                " --population COLUMN or --specimen COLUMNS"
            )
        given.setdefault(name, []).append(value)
    own = own_of(given.pop("own", ()))
    own |= dict.fromkeys([EVERY] * bool(given.get("population")), given.pop("population", [""])[0])
    found: dict[str, Any] = {"own": own} if own else {}
    if "share" in given:
        found["share"] = ",".join(given["share"]).replace(",", " ").split()
    if "specimen" in given:
        found["specimen"] = given["specimen"][0]
    return found | ({"tie": given["tie"]} if "tie" in given else {})


LITERAL = re.compile(r"Literal\[([^]]*)\]")


def optimiser_of(text: str) -> Optimiser:
    """The optimiser that ``NAME`` or ``NAME:option=value,option=value`` names.

    Raises
    ------
    ModelError
        If the name is unknown.
    OptionError
        If it has no such option, or the value is of another kind.
    """
    name, _, options = text.partition(":")
    kind: type[Optimiser] = plugins().find("optimiser", name.strip())
    chosen = {}
    for part in options.split(","):
        # A comma at the end is no option; nor is nothing behind the colon.
        if part.strip():
            option, value = _option(kind, name, part)
            chosen[option] = value
    return kind(**chosen)


def _option(kind: type[Optimiser], optimiser: str, text: str) -> tuple[str, Any]:
    name, value = _pair(text, "particles=40")
    known = {field.name: field.default for field in fields(kind) if field.init}  # type: ignore[arg-type]
    if name not in known:
        raise OptionError(
            f"{optimiser} has no option '{name}': it has {', '.join(known) or 'none'}"
        )
    words = _words_of(kind, name)
    if value in words:
        return name, value
    # The default shows of which kind a value is.
    default = known[name]
    if words and isinstance(default, str):
        raise OptionError(f"{optimiser}: {name} is {' or '.join(words)}, not '{value}'")
    # Before the numbers: in Python true and false are whole numbers too.
    if isinstance(default, bool):
        if value.lower() not in ("true", "false"):
            raise OptionError(f"{optimiser}: {name} is true or false, not '{value}'")
        return name, value.lower() == "true"
    try:
        if isinstance(default, int):
            return name, int(value)
        if isinstance(default, float):
            return name, float(value)
        return name, value
    except ValueError:
        known_words = "".join(f" or {word}" for word in words)
        raise OptionError(
            f"{optimiser}: {name} is a number such as {default}{known_words}, not '{value}'"
        ) from None


def _words_of(kind: type[Optimiser], name: str) -> list[str]:
    """Words that an option may be, as its annotation says."""
    # As text: what a plugin annotates by may be imported for type checkers only.
    [told] = (str(field.type) for field in fields(kind) if field.name == name)  # type: ignore[arg-type]
    return [word for part in LITERAL.findall(told) for word in re.findall(r"[\w-]+", part)]


def _pair(text: str, example: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise OptionError(f"'{text}': write NAME=VALUE, such as {example}")
    return name, value


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise OptionError(f"'{where}': '{text.strip()}' is no number") from None
