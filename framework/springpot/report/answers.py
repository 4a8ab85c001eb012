"""Documents of diagnoses and comparisons, and to which temperature shift constants refer.

Without that temperature they cannot be compared with published ones.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from springpot.diagnosis.result import Candidate, Diagnosis, NextExperiment, Shelf
from springpot.errors import ModelError
from springpot.identification.value import Quantities, Quantity, Value
from springpot.measurement.measurement import Measurement
from springpot.measurement.units import Units
from springpot.misfit.error import Error, over_floor, plain
from springpot.misfit.residual_tests import Finding
from springpot.numerics import NEGLIGIBLE
from springpot.rheology.effect import find_effect
from springpot.rheology.nodes import Node
from springpot.rheology.points import KELVIN, Points, Real
from springpot.writing import FEW, LISTED, NAMED, SHOWN, counted, listed, number

from .text import OPEN, Listing, Passage, Prose, TextTable, percent, shown

if TYPE_CHECKING:
    from springpot.comparison.result import Comparison, Judgement


OUTSIDE = "outside     of what was measured: it holds only if the model does"


def quantities_document(answer: Quantities) -> list[Passage]:
    """A row for each, and what there is none of."""
    outside = OUTSIDE if any(row.outside for row in answer) else ""
    table: Passage = Prose("nothing can be told")
    if len(answer):
        table = quantities_table(answer, answer.rows)
    below = Listing([*(f"note        {note}" for note in answer.notes), *filter(None, [outside])])
    return [Prose(answer.title), table, below]


def quantities_passages(answer: Quantities | None, verbose: bool = False) -> list[Passage]:
    """Within another answer: a few that were measured; all of them if `verbose`.

    Parameters
    ----------
    answer : Quantities or None
        Of none there is no passage.
    verbose : bool
        Whether what lies outside of the measured range, and what there is none of, is told too.
    """
    if answer is None:
        return []
    if verbose:
        return quantities_document(answer)[1:] if answer.rows or answer.notes else []
    rows = [row for row in answer if not row.outside][:FEW]
    return [quantities_table(answer, rows)] if rows else []


def quantities_table(answer: Quantities, rows: Sequence[Quantity]) -> TextTable:
    """A row for each of these, with its place and who says it; what is the same for all below."""
    shared = set.intersection(*(set(row.at.items()) for row in rows))
    same = {name: value for name, value in rows[0].at.items() if (name, value) in shared}
    cells = []
    for row in rows:
        size, interval = shown(row.value)
        source = f"{row.source}, outside" if row.outside else row.source
        own = {name: value for name, value in row.at.items() if name not in same}
        place = replace(row, at=own).place(answer.units) or "-"
        cells.append([row.name, size, interval, row.value.unit, place, source])
    headers = ("quantity", "value", "95 % interval", "unit", "at", "from")
    told = [f"at {replace(rows[0], at=same).place(answer.units)}"] if same else []
    if answer.without:
        told.insert(0, f"of the material, without {', '.join(answer.without)}")
    legend = {"quantity": "; ".join(told)} if told else {}
    return TextTable(headers, cells, frozenset({"value"}), ("at",), legend)


PROBES = (290.0, 330.0)
"""Kelvin; what refers to a temperature changes if the reference moves from one to the other."""


def refers(node: Node, columns: Mapping[str, Real]) -> bool:
    """Whether parameters of `node` mean something else at another reference temperature.

    Parameters
    ----------
    node : Node
        A network or an element.
    columns : mapping of str to ndarray, shape (n,)
        What it may need beside frequency, amplitude and temperature.
    """
    theta: Real = np.array([parameter.typical for parameter in node.parameters])
    ones = np.ones(2)
    first = {name: np.full(2, column[0]) for name, column in columns.items()}
    # Tried, not asked: whatever element a plugin offers, this is what its parameters do.
    at_probes = [
        Points(np.zeros(2), ones, np.array(PROBES), reference, first) for reference in PROBES
    ]
    one, other = (node.respond(theta, points).value for points in at_probes)
    return not np.array_equal(one, other)


def reference_note(measurement: Measurement | None, nodes: Iterable[Node]) -> str:
    """One sentence on the reference temperature; empty where no parameter shown refers to one.

    Parameters
    ----------
    measurement : Measurement or None
        The data, which set the reference; an answer from a file knows none.
    nodes : iterable of Node
        Networks or elements whose parameters are shown.
    """
    if measurement is None or "temperature" not in measurement.conditions:
        return ""
    columns = measurement.points.columns
    if not any(refers(node, columns) for node in nodes):
        return ""
    # The way through kelvin leaves rounding behind.
    celsius = round(measurement.reference_temperature - KELVIN, 2)
    return (
        f"shift constants refer to T_ref = {celsius:g} °C, where the shift is 1; "
        "all other parameters are those at this temperature"
    )


def effects_note(measurement: Measurement | None, names: Iterable[str]) -> str:
    """`reference_note` for the parameters of effects given by name."""
    return reference_note(measurement, _elements(names))


def _elements(names: Iterable[str]) -> Iterator[Node]:
    for name in names:
        try:
            yield find_effect(name).element
        # An effect that was handed in for this one diagnosis is in no registry.
        except ModelError:
            continue


PLACES, NOTES = 3, 2
"""Places of failure and notes that are told where not everything is asked for."""
SPARE = ("delta BIC", "predicted", "cannot be told from")
"""Columns that a narrow window goes without, the first first; the sentences say the same."""
HOPELESS = 0.01
"""Probability below which an effect that helps is none to be shown beside one that explains.

One in a hundred data sets.
"""
RANKED = frozenset({"probability", "delta BIC", "predicted", "after"})
FOLDED: Mapping[Shelf, str] = {
    "helps": "helps too",
    "ruled-out": "ruled out, as the error stays",
}
SHELVES: Mapping[Shelf, str] = {
    "explains": "explains it",
    "helps": "helps",
    "ruled-out": "ruled out",
}


def diagnosis_document(
    diagnosis: Diagnosis,
    data: Measurement | None = None,
    verbose: bool = False,
    lead: str = "",
    fitted: bool = True,
) -> list[Passage]:
    """The answer: verdict, error, where, parameters, effects that matter, what to measure next.

    Parameters
    ----------
    diagnosis : Diagnosis
        The answer, of sweeps, tests in time or both.
    data : Measurement, optional
        A sweep's data, to say which temperature the constants of a shift refer to.
    verbose : bool
        Everything that was found, not only what leads.
    lead : str
        Stands before the first line.
    fitted : bool
        Whether the parameters are told.
    """
    notes = diagnosis.notes
    if data is not None:
        # What was noted of the data has been told when they were opened.
        notes = tuple(note for note in notes if note not in data.provenance.values())
    most, places = NOTES, PLACES
    if verbose:
        most, places = len(notes), len(diagnosis.where)
    values = refers = ""
    if fitted and diagnosis.parameters:
        values = f"fitted: {_values(diagnosis.parameters)}"
        refers = reference_note(data, [diagnosis.model.network])
    failing = places_failed(diagnosis, places)
    # That an adequate model fails nowhere its verdict has said.
    if diagnosis.verdict == "adequate" and not diagnosis.where:
        failing = Prose()
    rows = ranked(diagnosis, verbose)
    # Told once: beside the fitted parameters, or else below the ranking.
    below = "" if refers else effects_note(data, (row.effect for row in rows))
    folded, absent = not_shown(diagnosis, rows, LISTED), ""
    # Of an adequate model the sizes at which effects would have been seen are the answer; beside a
    # missing effect they are detail.
    if verbose or diagnosis.verdict == "adequate":
        folded = Prose()
        absent = absent_text(diagnosis, LISTED)
    title = f"{lead}{diagnosis.model.name} of {diagnosis.data}: {diagnosis.verdict}"
    return [
        Prose(f"{title}{_held_values(diagnosis, data)}", diagnosis.says),
        Prose(error_line(diagnosis), diagnosis.split),
        failing,
        Prose(values, refers),
        *quantities_passages(diagnosis.quantities, verbose),
        ranking(diagnosis, rows, verbose),
        Prose(below),
        physics(rows),
        folded,
        Prose(absent),
        left_out(diagnosis.left_out, [row.effect for row in diagnosis.candidates]),
        Prose(_next(diagnosis)),
        steps_of(diagnosis),
        Listing(notes[:most], mark="note: "),
        Prose(_more(diagnosis, verbose, len(notes) - most)),
    ]


def _values(parameters: Mapping[str, Value], brief: bool = False) -> str:
    return "; ".join(f"{name} {value_text(value, brief)}" for name, value in parameters.items())


def _held_values(diagnosis: Diagnosis, data: Measurement | None) -> str:
    """What a user held, which no test of the model could move."""
    units = Units()
    if data is not None:
        units = data.units
    # Held parameters are none of the model's own any more: their units are those of the model with
    # all set free.
    known = {parameter.name: parameter for parameter in diagnosis.model.released().parameters}
    assignments = []
    for name, value in diagnosis.model.held.items():
        factor, unit = units.of(known[name].unit)
        text = f"{name} = {factor * value:g}"
        if unit != "-":
            text += f" {unit}"
        assignments.append(text)
    if not assignments:
        return ""
    return f" (with {', '.join(assignments)} held)"


def _more(diagnosis: Diagnosis, verbose: bool, notes: int) -> str:
    """What -v would tell beside this."""
    if verbose:
        return ""
    kinds = ((len(diagnosis.where) - PLACES, "place"), (notes, "note"))
    left = [counted(count, word) for count, word in kinds if count > 0]
    if not left:
        return ""
    return f"-v tells {', '.join(left)} more"


def error_line(diagnosis: Diagnosis) -> str:
    """``error 8.3 % -> 1.1 % with inertia, 1.1 x floor``, and the two floors.

    Of several tests in time all of it is of one, which is named.
    """
    error, best = diagnosis.error, diagnosis.best
    before = f"error {percent(error.relative_rms)}"
    if error.test:
        before = f"error of {error.test} {percent(error.relative_rms)}"
    if best is None:
        return f"{before}, {times(error.relative_rms, error)}; {floors(error)}"
    after = f"{percent(best.after)} with {best.effect}, {times(best.after, error)}"
    return f"{before} -> {after}; {floors(error)}"


def floors(error: Error) -> str:
    """``noise floor 0.63 % (estimated); material floor 0.62 %``.

    What noise leaves, and what any material, where one was looked for.
    """
    noise = f"noise floor {percent(error.noise_floor)} ({error.noise_source})"
    if not isfinite(error.material_floor):
        return noise
    return f"{noise}; material floor {percent(error.material_floor)}"


def times(value: float, error: Error) -> str:
    """An error in units of the noise floor."""
    # Exact data have no noise to measure by.
    if not error.noise_floor > 0:
        return "no noise floor"
    return f"{times_floor(value, error.noise_floor)} x floor"


def times_floor(value: float, floor: float) -> str:
    """Two digits of the ratio to the floor, without a power of ten."""
    ratio = value / floor
    # From here on two digits would be written with a power of ten.
    if ratio >= 99.5:
        return plain(ratio, 2)
    return number(ratio, 2)


def beside_floor(value: float | None, floor: float, digits: int = 3) -> str:
    """An error beside the floor, compactly: ``0.46 % (1.0 x)``."""
    shown = percent(value, digits)
    if value is None or shown == "-" or not floor > 0.0:
        return shown
    return f"{shown} ({times_floor(value, floor)} x)"


def places_failed(diagnosis: Diagnosis, most: int | None = None) -> Passage:
    """Where the model fails, a line each."""
    if diagnosis.where:
        says = [place.says for place in diagnosis.where[:most]]
        return Listing(says, "where it fails:", "  ")
    return Prose(f"where it fails: {nowhere(diagnosis)}")


def nowhere(diagnosis: Diagnosis) -> str:
    """What to say where no place of failure is named.

    Only an adequate model leaves nothing but noise.
    """
    if diagnosis.verdict == "adequate":
        return "nowhere: what is left looks like noise"
    if diagnosis.verdict == "inconclusive":
        return (
            "no single band of frequencies stands out,"
            " and these data cannot tell whether anything is missing"
        )
    off = times(diagnosis.error.relative_rms, diagnosis.error)
    return f"no single band of frequencies stands out; all points together are off by {off}"


def worth_showing(diagnosis: Diagnosis, most: int = SHOWN) -> list[Candidate]:
    """Leading effects that explain the misfit or help.

    What is shown is read as a suggestion.
    """
    explain, help_ = diagnosis.on_shelf("explains"), diagnosis.on_shelf("helps")
    # Beside what explains the misfit many others help a little, as they resemble it.
    if explain:
        help_ = tuple(row for row in help_ if row.probability >= HOPELESS)
    return [*explain, *help_][:most]


def ranked(diagnosis: Diagnosis, verbose: bool = False) -> list[Candidate]:
    """The effects to show: none of a model that is adequate, all of another if `verbose`."""
    # Where nothing is missing, a ranking of what is missing would be read as if something were.
    if diagnosis.verdict == "adequate":
        return []
    if verbose:
        return [row for shelf in SHELVES for row in diagnosis.on_shelf(shelf)]
    return worth_showing(diagnosis)


def ranking(diagnosis: Diagnosis, rows: Sequence[Candidate], whole: bool = True) -> Passage:
    """The table of candidates, the same on terminals and pages.

    Parameters
    ----------
    diagnosis : Diagnosis
        Whose they are.
    rows : sequence of Candidate
        Of none there is no table.
    whole : bool
        Whether it keeps all columns and the intervals of the parameters in any window.
    """
    if not rows:
        return Prose()
    # JSON and -v have the intervals.
    return replace(
        _ranking(diagnosis, rows), whole=whole, brief=_ranking(diagnosis, rows, brief=True)
    )


def _ranking(diagnosis: Diagnosis, rows: Sequence[Candidate], brief: bool = False) -> TextTable:
    """All columns; `brief` without the intervals of the parameters."""
    floor = diagnosis.error.noise_floor
    headers = (
        "effect",
        "shelf",
        "probability",
        "delta BIC",
        "predicted",
        "after",
        "parameters",
        "cannot be told from",
    )
    cells = [
        (
            row.effect,
            SHELVES[diagnosis.shelf_of(row)],
            probability(row.probability),
            number(row.delta_bic, 3),
            beside_floor(row.predicted_error, floor, 2),
            _after(row, floor),
            _values(row.parameters, brief),
            ", ".join(name for name in row.alike if name != row.effect),
        )
        for row in rows
    ]
    return TextTable(headers, cells, RANKED, SPARE)


def _after(row: Candidate, floor: float) -> str:
    """The error with an effect; beside the leading one, where it only shows there.

    Of one that was not fitted to the end, what is foretold.
    """
    if isfinite(row.error_beside):
        return f"{beside_floor(row.error_beside, floor, 2)} beside"
    if isfinite(row.predicted_error) and not isfinite(row.error_after):
        return f"about {beside_floor(row.predicted_error, floor, 2)}"
    return beside_floor(row.error_after, floor, 2)


def physics(rows: Sequence[Candidate], most: int = NAMED) -> Listing:
    """What the first effects do, in a sentence each."""
    return Listing([f"{row.effect}: {row.says}" for row in rows[:most]], mark="  ")


def probability(value: float) -> str:
    """Three digits, with no false nothing and no false certainty."""
    if value < 1e-3:
        return "<0.001"
    if value > 0.999:
        return ">0.999"
    return f"{value:.3f}"


def value_text(value: Value, brief: bool = False) -> str:
    """``0.42 [0.40, 0.44] kg``, or `brief` without the interval.

    What the data leave open is called so.
    """
    size, interval = shown(value)
    text = f"{size} {interval}".removeprefix("- ").strip()
    # A value that the data leave open is none, however narrow the window: there the interval is all
    # there is to tell.
    if brief and not interval.startswith(OPEN):
        text = size
    if value.unit == "-" or text.startswith(OPEN):
        return text
    return f"{text} {value.unit}"


def absent_effects(diagnosis: Diagnosis) -> list[Candidate]:
    """Effects that would have been seen, those seen at the smallest size first."""
    return sorted((c for c in diagnosis.candidates if c.verdict == "absent"), key=lambda c: c.bound)


def not_shown(diagnosis: Diagnosis, rows: Sequence[Candidate], most: int | None = None) -> Prose:
    """What helps and has no row, and what leaves the error as it is: a line each, by name."""
    told = {row.effect for row in rows}
    lines = []
    for shelf, words in FOLDED.items():
        names = [row.effect for row in diagnosis.on_shelf(shelf) if row.effect not in told]
        if names:
            lines.append(f"{words}: {listed(names, most)}")
    return Prose(*lines)


def absent_text(diagnosis: Diagnosis, most: int | None = None) -> str:
    """The absent effects by name, each with the size from which it would have been seen."""
    absent = absent_effects(diagnosis)
    if not absent:
        return ""
    # Of tests in time no size is known.
    if not any(isfinite(row.bound) for row in absent):
        return f"absent: {', '.join(row.effect for row in absent)}"
    named = [f"{row.effect} ({percent(row.bound, 2)})" for row in absent]
    return f"absent, or it would have been seen from this size on: {listed(named, most)}"


def left_out(reasons: Mapping[str, str], judged: Container[str] = ()) -> Listing:
    """What could not be tried, and why; of what was judged all the same, why only nearly."""
    lines = []
    for name, reason in reasons.items():
        how = "fitted nearly" if name in judged else "left out"
        lines.append(f"{how}: {name}: {reason}")
    return Listing(lines)


def steps_of(diagnosis: Diagnosis) -> Listing:
    """What can be done with the data themselves, with the error that is foretold."""
    before = percent(diagnosis.error.relative_rms)
    lines = []
    for step in diagnosis.steps:
        foretold, after = percent(step.error_after), ""
        # What the answer has set aside already is no part of its error.
        if isfinite(step.error_after) and foretold != before:
            after = f" ({before} -> {foretold})"
        lines.append(f"{step.says}{after}: {step.command}")
    return Listing(lines, mark="to do: ")


def _next(diagnosis: Diagnosis) -> str:
    advice = diagnosis.next_experiment
    if advice is None:
        return ""
    return experiment_text(advice)


def experiment_text(advice: NextExperiment) -> str:
    """What to measure next, and what it will show."""
    return f"next experiment: {advice.says}"


def comparison_document(comparison: Comparison) -> list[Passage]:
    """The models side by side, then what the tests say on each."""
    error, size = comparison.judgements[0].error, comparison.magnitude
    best = ""
    # Of a single model "best" would be praise.
    if len(comparison.judgements) > 1:
        best = f"{comparison.best.model.name} is best; "
    floor = f"noise floor {percent(error.noise_floor)} of {size} ({error.noise_source})"
    judged = [
        Listing(_significant(one.findings), f"{one.model.name} {_state(one)}: {one.says}", "  ")
        for one in comparison.judgements
    ]
    return [
        Prose(f"{comparison.data}: {best}{floor}"),
        _compared(comparison),
        handy_model(comparison),
        *judged,
        Listing(_significant(comparison.harmonics)),
        left_out(comparison.left_out),
        Listing(comparison.notes, mark="note: "),
    ]


def handy_model(comparison: Comparison) -> Prose:
    """The model to write down where the best one has more parameters than are worth it."""
    fewest = comparison.handy
    if fewest is None:
        return Prose()
    error, count = percent(fewest.error.relative_rms), fewest.free_parameters
    return Prose(
        f"the simplest that is nearly as near as any that can be written down is"
        f" {fewest.model.name}: {error} with {count} parameters"
    )


def _compared(comparison: Comparison) -> TextTable:
    """A row for each model; of several tests each has its own column."""
    tests = comparison.tests
    by_test = tuple(f"x floor of {test.name}" for test in tests if len(tests) > 1)
    headers = ("model", "error", "x floor", *by_test)
    headers += ("material floor", "chi2/dof", "delta BIC", "parameters")
    rows = []
    for judged in comparison.judgements:
        error, dof = judged.error, judged.degrees_of_freedom
        ratios = [over_floor(error.relative_rms, error.noise_floor, 2)]
        if by_test:
            ratios += [number(test.over_floor, 2) for test in judged.by_test]
        row = (
            judged.model.name,
            percent(error.relative_rms),
            *ratios,
            percent(error.material_floor),
            number(judged.chi_square / max(dof, 1), 3),
            # Models that are one curve differ by rounding alone.
            number(round(judged.delta_bic, 2), 3),
            str(judged.free_parameters),
        )
        rows.append(row)
    spare = ("chi2/dof", "parameters", "delta BIC", "material floor")
    return TextTable(headers, rows, frozenset(headers[1:]), spare)


def _state(judged: Judgement) -> str:
    """In a word whether a model stands its tests."""
    if judged.fails:
        return "fails"
    if judged.unclear:
        return "is open"
    return "holds"


def _significant(findings: Sequence[Finding]) -> list[str]:
    """A line for each test that found something."""
    return [f"{finding.says} ({chance(finding.p_value)})" for finding in findings if finding.found]


def chance(value: float) -> str:
    """``p = 0.004``, with no number smaller than anyone can mean."""
    if value < NEGLIGIBLE:
        return "p < 1e-6"
    return f"p = {number(value, 2)}"
