"""Fits as text for people: one in full, or many as a table of one row each."""

from __future__ import annotations

import csv
from collections.abc import Collection, Sequence
from io import StringIO
from math import log

from springpot.identification import Identification, Value
from springpot.rheology.drawing import drawing_of

from .numbers import number, percent, seconds
from .reference import reference_note
from .spectrum import in_words
from .text import Table, indented, wrapped
from .values import OPEN, shown

FAR = log(1e6)
"""Logarithm of the ratio to the natural size of the data from which a parameter leaves no trace of its size."""


def identification_text(found: Identification, width: int = 120, verbose: bool = False) -> str:
    """Parameters with their intervals, the error beside its floors, and whether the model is good enough.

    Parameters
    ----------
    found : Identification
        The fit.
    width : int
        Columns of the window.
    verbose : bool
        Whether to tell the search form, the objective and the optimiser too.
    """
    data = found.measurement
    low, high = number(float(data.frequency.min()), 3), number(float(data.frequency.max()), 3)
    search = ""
    if verbose and found.search_parameters:
        search = parameters_text("search form", dict(found.search_parameters))
    parts = [
        f"{found.model.name} fitted to {data.name} ({len(data)} points, {low} to {high} Hz)",
        indented(drawing_of(found.model)),
        parameters_text("parameter", dict(found.parameters), gone(found)),
        search,
        reference_note(data, [found.model.network]),
        _spectrum(found),
        "\n".join(wrapped(line, width, " " * 12) for line in _lines(found, verbose)),
    ]
    return "\n\n".join(part for part in parts if part)


def parameters_text(heading: str, parameters: dict[str, Value], open_ones: Collection[str] = ()) -> str:
    """A table of values with their intervals; one that the data leave open is called so."""
    rows = []
    for name, value in parameters.items():
        told = ("-", OPEN) if name in open_ones else shown(value)
        rows.append([name, *told, value.unit])
    return Table((heading, "value", "95 % interval", "unit"), rows, frozenset({"value"})).plain()


def gone(found: Identification) -> set[str]:
    """Parameters that have grown out of all proportion to the data, whatever their interval says."""
    far = found.fit.task.coordinates.log & (found.fit.u > FAR)
    return {name for name, one in zip(found.model.names, far, strict=True) if one}


def _spectrum(found: Identification) -> str:
    if found.spectrum is None:
        return ""
    return f"spectrum    {in_words(found.spectrum, found.measurement.units.stiffness)}"


def _lines(found: Identification, verbose: bool) -> list[str]:
    """What is told of a fit, a line for each thing."""
    lines = [f"error       {percent(found.relative_rms)} of |K| (relative rms){beside_floors(found)}"]
    if found.standing is not None:
        lines.append(
            f"verdict     {'good enough' if found.standing.good_enough else 'not good enough'}: {_reason(found)}"
        )
    spent = f"{found.evaluations} evaluations in {seconds(found.seconds)}"
    if verbose or found.optimiser != "native" or found.status != "converged":
        lines.append(f"objective   {found.fit.objective.name}, {number(found.fit.cost)}")
        lines.append(f"optimiser   {found.optimiser}, {found.status}, {spent}")
    return lines + [f"note        {note}" for note in (*found.notes, *unused(found))]


def _reason(found: Identification) -> str:
    assert found.standing is not None
    return found.standing.says.partition("; ")[2] or found.standing.says


def beside_floors(found: Identification) -> str:
    """The error beside what noise alone leaves and what any material leaves, where the data are enough to tell."""
    standing = found.standing
    if standing is None or not standing.noise_floor > 0.0:
        return ""
    ratio = number(found.relative_rms / standing.noise_floor, 2)
    noise = f"{ratio} x the noise floor of {percent(standing.noise_floor, 2)} ({standing.noise_source})"
    return f", {noise}; material floor {percent(standing.material_floor, 2)}"


def unused(found: Identification) -> list[str]:
    """Conditions that vary in the data and that the model does not know."""
    told = []
    for name in ("temperature", "amplitude"):
        if name not in found.measurement.conditions or name in found.model.needs:
            continue
        levels = int(found.measurement.levels(name).max()) + 1
        if levels > 1:
            told.append(f"{name} was not used: the data have {levels} levels of it, the model has no effect of it")
    return told


def many_text(found: Sequence[Identification]) -> str:
    """One row for each file: error, floor, verdict and the parameters."""
    names, rows = _columns(found), []
    for fit in found:
        cells = [_cell(fit, name) for name in names]
        rows.append([fit.measurement.name, percent(fit.relative_rms), *_verdict(fit), *cells])
    headers = ["data", "error", "noise floor", "good enough", *(_header(found[0], name) for name in names)]
    return Table(headers, rows, frozenset(headers[1:3] + headers[4:])).plain()


def many_csv(found: Sequence[Identification]) -> str:
    """The same as CSV, with both ends of each interval; units stand in the header."""
    names, stream = _columns(found), StringIO()
    write = csv.writer(stream, lineterminator="\n").writerow
    headers = [f"{name}{end} [{found[0].parameters[name].unit}]" for name in names for end in ("", "_low", "_high")]
    write(["data", "model", "relative_rms [-]", "noise_floor [-]", "good_enough", *headers])
    for fit in found:
        values = [fit.parameters[name] for name in names if name in fit.parameters]
        cells = [repr(end) for value in values for end in (value.value, value.low, value.high)]
        floor = "" if fit.standing is None else repr(fit.standing.noise_floor)
        good = "" if fit.standing is None else str(fit.standing.good_enough).lower()
        write([fit.measurement.name, fit.model.name, repr(fit.relative_rms), floor, good, *cells])
    return stream.getvalue()


def _columns(found: Sequence[Identification]) -> list[str]:
    return list(dict.fromkeys(name for fit in found for name in fit.parameters))


def _header(fit: Identification, name: str) -> str:
    unit = fit.parameters[name].unit if name in fit.parameters else "-"
    return name if unit == "-" else f"{name} [{unit}]"


def _cell(fit: Identification, name: str) -> str:
    value = fit.parameters.get(name)
    if value is None:
        return "-"
    return "open" if shown(value)[1].startswith(OPEN) else shown(value)[0]


def _verdict(fit: Identification) -> tuple[str, str]:
    if fit.standing is None:
        return "-", "-"
    return percent(fit.standing.noise_floor, 2), "yes" if fit.standing.good_enough else "no"
