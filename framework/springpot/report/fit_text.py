"""The document of a fit; many fits as a table or CSV of one row each."""

from __future__ import annotations

import csv
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from io import StringIO
from math import hypot, isfinite, log, nan

from springpot.identification.intervals import IDENTIFIABLE
from springpot.identification.kept import note_on_levels
from springpot.identification.population import specimens_of
from springpot.identification.result import Identification
from springpot.identification.value import Value
from springpot.rheology.drawing import drawing_of
from springpot.writing import FEW, counted, number

from ..numerics import NEGLIGIBLE
from .answers import quantities_passages, reference_note
from .figures import beside_floors, in_words, population_passages
from .text import (
    OPEN,
    Listing,
    Passage,
    Preformatted,
    Prose,
    TextTable,
    percent,
    seconds,
    shown,
    told_range,
)

FAR = log(1e6)
"""Log of the ratio to the data's natural size from which a parameter's size leaves no trace."""

BIASED = (
    "the intervals are those of this model as it is: what it misses may move its parameters by more"
)


def fit_document(identified: Identification, verbose: bool = False) -> list[Passage]:
    """Parameters with intervals, each test or the error beside its floors, and what to know.

    Parameters
    ----------
    identified : Identification
        The fit.
    verbose : bool
        Whether to tell the search form, the objective and the optimiser too.
    """
    search: Passage = Prose()
    # The search form is how the model was searched, not what it is: most need it never.
    if verbose and identified.search_parameters:
        search = parameters_table("search form", identified.search_parameters)
    tests: Passage = Prose()
    if identified.sweep is None:
        tests = _tests(identified)
    return [
        Prose(f"{identified.model.name} fitted to {identified.name} ({_size(identified)})"),
        Preformatted(drawing_of(identified.model)),
        parameters_table("parameter", _listed(identified, verbose), gone(identified)),
        Prose(f"tied        {'; '.join(ties)}" if (ties := identified.model.ties) else ""),
        Prose(_identifiable(identified)),
        _budget(identified) if verbose else Prose(),
        *population_passages(identified),
        search,
        Prose(reference_note(identified.sweep, [identified.model.network])),
        Prose(_spectrum(identified)),
        *quantities_passages(identified.quantities, verbose),
        tests,
        # Below the words that stand behind the name of a line.
        Listing(_lines(identified, verbose), hang=" " * 12),
    ]


def _identifiable(identified: Identification) -> str:
    """What profiles tell of the parameters, each verdict with those that have it."""
    told = identified.identifiable
    parts = (
        (verdict, [name for name, found in told.items() if found == verdict])
        for verdict in IDENTIFIABLE
    )
    words = "; ".join(f"{verdict}: {', '.join(names)}" for verdict, names in parts if names)
    return f"profile     {words}" if words else ""


def _size(identified: Identification) -> str:
    """How much was measured."""
    if identified.sweep is not None:
        return f"{len(identified.sweep)} points, {told_range(identified.sweep)}"
    count = f"{sum(test.points for test in identified.tests)} points"
    # A count of one says nothing.
    if len(identified.tests) > 1:
        count = f"{counted(len(identified.tests), 'test')}, {count}"
    return count


def _tests(identified: Identification) -> TextTable:
    """A row for each test; in a narrow window the last columns go, and long names are cut."""
    headers = ("test", "kind", "points", "error", "noise floor", "x floor", "alone")
    rows = []
    for test in identified.tests:
        errors = [
            percent(test.relative_rms),
            percent(test.noise_floor, 2),
            number(test.over_floor, 2),
            number(test.over_floor_alone, 2),
        ]
        rows.append([test.name, test.kind, str(test.points), *errors])
    legend = {"alone": "x floor where the test has parameters of its own"}
    table = TextTable(headers, rows, frozenset(headers[2:]), ("alone", "points"), legend, cuts=True)
    # A single test is fitted alone in any case.
    if len(rows) == 1:
        return replace(table.lacking("alone"), spare=("points",))
    return table


def parameters_table(
    heading: str, parameters: Mapping[str, Value], open_ones: Collection[str] = ()
) -> TextTable:
    """A table of values with their intervals; one that the data leave open is called so."""
    rows = []
    for name, value in parameters.items():
        size, interval = shown(value)
        # Out of all proportion to the data, it leaves no trace of its size in them.
        if name in open_ones:
            size, interval = "-", OPEN
        rows.append([name, size, interval, value.unit])
    return TextTable((heading, "value", "95 % interval", "unit"), rows, frozenset({"value"}))


def _few(identified: Identification) -> bool:
    """Whether the specimens are so few that each is told by itself."""
    return len(specimens_of(identified.populations)) <= FEW


def _listed(identified: Identification, verbose: bool) -> Mapping[str, Value]:
    """The parameters that are told one by one: of many specimens those that they share."""
    if verbose or _few(identified):
        return identified.parameters
    pairs = zip(identified.model.names, identified.model.origins, strict=True)
    theirs = {name for name, origin in pairs if origin in identified.populations}
    return {name: value for name, value in identified.parameters.items() if name not in theirs}


def _budget(identified: Identification) -> Passage:
    """The standard uncertainty of each parameter by where it comes from, as shares of it."""
    terms = list(dict.fromkeys(term for row in identified.budget.values() for term in row))
    rows = []
    for name, row in identified.budget.items():
        value = abs(identified.parameters[name].value) or nan
        whole = hypot(*row.values())
        # What another fit moves by rounding is no term.
        parts = [part * (part > NEGLIGIBLE * value) for part in row.values()]
        rows.append([name, *(percent(part / value, 2) for part in (*parts, whole))])
    headers = ("standard uncertainty", *terms, "together")
    return TextTable(headers, rows, frozenset(headers[1:])) if rows else Prose()


def gone(identified: Identification) -> set[str]:
    """Parameters that grew out of all proportion to the data, whatever their interval says."""
    if identified.uncertainty is None:
        return set()
    far = identified.fit.task.coordinates.log & (identified.fit.u > FAR)
    return {name for name, one in zip(identified.model.names, far, strict=True) if one}


def _spectrum(identified: Identification) -> str:
    if identified.spectrum is None:
        return ""
    return f"spectrum    {in_words(identified.spectrum, identified.measurement.units.stiffness)}"


def _lines(identified: Identification, verbose: bool) -> list[str]:
    """What is told of a fit, a line for each thing."""
    lines = []
    # Of tests in time their table tells it.
    if identified.sweep is not None:
        lines.append(
            f"error       {percent(identified.relative_rms)} of {identified.magnitude} (relative"
            f" rms){beside_floors(identified)}"
        )
    elif identified.standing is not None and isfinite(identified.standing.material_floor):
        worst = max(identified.tests, key=lambda test: test.over_floor)
        floor = percent(identified.standing.material_floor, 2)
        lines.append(f"floor       material floor {floor} of {worst.name}")
    if identified.standing is not None:
        verdict = "not good enough"
        if identified.standing.good_enough:
            verdict = "good enough"
        lines.append(f"verdict     {verdict}: {_reason(identified)}")
    if identified.calibration is not None:
        lines.append(f"accuracy    intervals hold {identified.calibration.says} of the instrument")
    spent = f"{identified.evaluations} evaluations in {seconds(identified.seconds)}"
    # The usual way to the usual end is worth no line; whatever was chosen or went otherwise is.
    if verbose or identified.optimiser != "native" or identified.status != "converged":
        lines.append(f"objective   {identified.objective}, {number(identified.cost)}")
        lines.append(f"optimiser   {identified.optimiser}, {identified.status}, {spent}")
    notes = (
        *identified.notes,
        *unused(identified),
        *_of_floor(identified),
        *_of_intervals(identified),
    )
    numbered: set[str] = set()
    # Which number a specimen has, where no parameter is told by its number.
    if not verbose and not _few(identified):
        columns = identified.model.own.values()
        numbered = {note_on_levels(identified.words, column) for column in columns}
    return lines + [f"note        {note}" for note in notes if note not in numbered]


def _reason(identified: Identification) -> str:
    assert identified.standing is not None
    # The error and its floor have been told by the line above.
    error, _, rest = identified.standing.says.partition("; ")
    return rest if rest and error.startswith("error ") else identified.standing.says


def _of_floor(identified: Identification) -> list[str]:
    """What `diagnose` may say otherwise.

    It knows better models than this one, about which the data scatter less.
    """
    standing = identified.standing
    if standing is None or standing.good_enough or standing.noise_source != "estimated":
        return []
    return [
        "the noise floor is estimated from the scatter about this model:"
        " diagnose may find a lower one"
    ]


def _of_intervals(identified: Identification) -> list[str]:
    """What no width of an interval makes up for: the bias of a model that misses something."""
    if identified.standing is None or identified.standing.good_enough:
        return []
    return [BIASED]


def unused(identified: Identification) -> list[str]:
    """Conditions that vary in a sweep and that the model does not know."""
    notes: list[str] = []
    if identified.sweep is None:
        return notes
    for name in ("temperature", "amplitude"):
        if name not in identified.measurement.conditions or name in identified.model.needs:
            continue
        # A temperature that was noted once for all rows is no condition that a model misses.
        levels = int(identified.measurement.levels(name).max()) + 1
        if levels > 1:
            notes.append(
                f"{name} was not used: the data have {levels} levels of it,"
                " the model has no effect of it"
            )
    return notes


def many_text(fits: Sequence[Identification]) -> str:
    """One row for each file: error, floor, verdict and the parameters."""
    columns, rows = _columns(fits), []
    for fit in fits:
        cells = [_cell(_in_column(fit, *column)) for column in columns]
        rows.append([fit.name, percent(fit.relative_rms), *_verdict(fit), *cells])
    headers = [
        "data",
        "error",
        "noise floor",
        "good enough",
        *(name if unit == "-" else f"{name} [{unit}]" for name, unit in columns),
    ]
    return TextTable(headers, rows, frozenset(headers[1:3] + headers[4:])).plain()


def many_csv(fits: Sequence[Identification]) -> str:
    """The same as CSV, with both ends of each interval; units stand in the header."""
    columns, stream = _columns(fits), StringIO()
    write = csv.writer(stream, lineterminator="\n").writerow
    headers = []
    for name, unit in columns:
        headers += [f"{name} [{unit}]", f"{name}_low [{unit}]", f"{name}_high [{unit}]"]
    write(["data", "model", "relative_rms [-]", "noise_floor [-]", "good_enough", *headers])
    for fit in fits:
        cells = []
        for column in columns:
            value = _in_column(fit, *column)
            if value is None:
                # Empty, so that what follows stays under its own header.
                cells += [""] * 3
            else:
                # `repr` keeps every digit: another program reads them.
                cells += [repr(each) for each in (value.value, value.low, value.high)]
        row = [fit.name, fit.model.name, repr(fit.relative_rms), *_judged(fit), *cells]
        write(row)
    return stream.getvalue()


def _judged(fit: Identification) -> tuple[str, str]:
    """Noise floor and whether the fit is good enough.

    Left empty where that is not judged: any word would be taken for a verdict.
    """
    if fit.standing is None:
        return "", ""
    return repr(fit.standing.noise_floor), str(fit.standing.good_enough).lower()


def _columns(fits: Sequence[Identification]) -> list[tuple[str, str]]:
    """Names and units of the parameters of all files.

    A model of levels may have more in one than in another, and files may be in different units.
    """
    return list(
        dict.fromkeys((name, each.unit) for fit in fits for name, each in fit.parameters.items())
    )


def _in_column(fit: Identification, name: str, unit: str) -> Value | None:
    """A parameter of a file, where it is in this unit."""
    value = fit.parameters.get(name)
    return value if value is not None and value.unit == unit else None


def _cell(value: Value | None) -> str:
    if value is None:
        return "-"
    size, interval = shown(value)
    # The sentence of an open value is too long for a cell.
    if interval.startswith(OPEN):
        return "open"
    return size


def _verdict(fit: Identification) -> tuple[str, str]:
    if fit.standing is None:
        return "-", "-"
    verdict = "no"
    if fit.standing.good_enough:
        verdict = "yes"
    return percent(fit.standing.noise_floor, 2), verdict
