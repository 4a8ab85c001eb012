"""What a file holds, as text.

Its columns, its sweeps, what cannot be opened, what was noted, and what to do next.

Made of the dictionaries that ``springpot inspect --json`` prints, told in the words in which the
data came.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from springpot.measurement.covered import OtherTest
from springpot.measurement.reader import with_part
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.numerics import NEGLIGIBLE
from springpot.report.text import LETTERS
from springpot.writing import counted, number, suggested

from .text import TextTable, cut, percent, wrapped

LONG = 24
"""Sweeps that are printed: a screen of them; JSON has all."""
KNOWN = ("step", "temperature", "repeat", "points", "frequency", "amplitude")
"""What is told of a sweep beside the labels that tell it from others."""
PLAIN = frozenset({*KNOWN, "conditions"})
SWEPT = 2.0
"""Highest over lowest frequency from which curves can be shifted onto one another."""
HISTORY = "history"
"""Kind of a test in time that is none of those with a name: a record of displacement and force."""


def inspected_text(result: dict[str, Any], units: Units, spec: str, width: int) -> str:
    """What a measurement holds.

    Parameters
    ----------
    result : dict
        Schema ``springpot.inspection/1``.
    units : Units
        Of the measurement.
    spec : str
        How the user named it.
    width : int
        Columns of the window.
    """
    sweeps, points = result["sweeps"], result["points"]
    labels = [
        f"{name}: {_few(words, width)}"
        for name, words in result["labels"].items()
        if name != "step"
    ]
    # Steps that are among the sweeps have a line there; of the others one has to learn why.
    together = {sweep.get("step") for sweep in sweeps}
    others = [part for part in result["parts"] if part["name"] not in together]
    given = "not given"
    if result["standard_deviations"]:
        given = "given"
    # One sweep is told by its columns already.
    sweeps_shown = ""
    if len(sweeps) > 1:
        sweeps_shown = sweeps_text(sweeps, result["parts"], units, width)
    others_shown = ""
    if others:
        others_shown = parts_text(others, width)
    parts = [
        f"{result['data']}: {counted(points, 'point')}, {counted(len(sweeps), 'sweep')}",
        _columns(result, units),
        "\n".join(labels),
        f"standard deviations: {given}",
        sweeps_shown,
        others_shown,
        "\n".join(
            wrapped(_noted(key, value), width) for key, value in result["provenance"].items()
        ),
        # A command that is broken cannot be copied.
        next_step(result, spec),
    ]
    return "\n\n".join(part for part in parts if part)


def _few(words: Sequence[str], width: int) -> str:
    """As many words as fit a line, and how many there are."""
    # The label itself and the count stand in the same line.
    room = width - LETTERS.label
    line = ", ".join(words)
    if len(line) <= room:
        return line
    whole_words = line[:room].rpartition(", ")[0]
    return f"{whole_words or line[:room]}, ... ({len(words)})"


def _noted(key: str, value: str) -> str:
    """What the file or its reader says; the word behind ``note`` is for programs."""
    return f"{_shown_key(key)}: {value}"


def _shown_key(key: str) -> str:
    if key.startswith("note "):
        return "note"
    return key


def _columns(result: dict[str, Any], units: Units) -> str:
    clock = "frequency"
    if units.clock == "rad/s":
        clock = "angular frequency"
    ranges = {
        clock: _clocked(result["frequency"], units),
        units.storage: result["storage"],
        units.loss: result["loss"],
        **result["conditions"],
    }
    rows = [
        [name, number(each["from"]), number(each["to"]), each["unit"]]
        for name, each in ranges.items()
    ]
    return TextTable(("column", "from", "to", "unit"), rows, frozenset({"from", "to"})).plain()


def _clocked(hertz: dict[str, Any], units: Units) -> dict[str, Any]:
    """A range in Hz as the data tell it."""
    return {
        "from": units.on_clock(hertz["from"]),
        "to": units.on_clock(hertz["to"]),
        "unit": units.clock,
    }


def sweeps_text(
    sweeps: Sequence[dict[str, Any]], parts: Sequence[dict[str, Any]], units: Units, width: int
) -> str:
    """A line for each sweep; the first column is what to write behind ``#`` for one of them.

    A narrow window goes without the amplitudes, whose range stands above.
    """
    first = sweeps[0]
    # Only what every sweep has can be a column.
    labels = [
        name for name in first if name not in PLAIN and all(name in sweep for sweep in sweeps)
    ]
    keys = [*labels, *(key for key in KNOWN if first.get(key) is not None)]
    amplitude = (first["amplitude"] or {}).get("unit")
    unit_of = {"temperature": "degC", "frequency": units.clock, "amplitude": amplitude}
    heads = []
    for key in keys:
        head = key
        if key in unit_of:
            head = f"{key} [{unit_of[key]}]"
        heads.append(head)
    numbers = {part["name"]: f"#{part['number']}" for part in parts}
    rows = []
    for sweep in sweeps[:LONG]:
        entries = {**sweep, "frequency": _clocked(sweep["frequency"], units)}
        rows.append([numbers.get(sweep.get("step"), ""), *(_cell(entries[key]) for key in keys)])
    spare = [head for head in heads if head.startswith("amplitude")]
    table = TextTable(["part", *heads], rows, frozenset(heads) - {*labels, "step"}, spare)
    if not numbers:
        table = table.lacking("part")
    text = table.as_text(width)
    more = len(sweeps) - LONG
    if more > 0:
        text += f"\n... and {more} more; --json has all"
    return text


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        # A range whose ends are printed alike is one number.
        return " to ".join(dict.fromkeys([number(value["from"], 3), number(value["to"], 3)]))
    if isinstance(value, str):
        return cut(value, LETTERS.label)
    return f"{value:.4g}"


def parts_text(parts: Sequence[dict[str, Any]], width: int) -> str:
    """Parts that are not among the data, each with its reason."""
    rows = []
    for part in parts:
        reason = ""
        if not part["usable"]:
            reason = part["says"]
        rows.append(
            [f"#{part['number']}", cut(part["name"], LETTERS.label), str(part["points"]), reason]
        )
    table = TextTable(("part", "name", "rows", "cannot be opened"), rows, frozenset({"rows"}))
    if all(part["usable"] for part in parts):
        table = table.lacking("cannot be opened")
    if table.width <= width:
        return table.plain()
    # Reasons are sentences, too long for a column of a narrow window.
    lines = ["parts that cannot be opened or were left out:"]
    for label, name, count, reason in rows:
        line = f"  {label} {name}, {count} rows"
        if reason:
            line += f": {reason}"
        lines.append(wrapped(line, width))
    return "\n".join(lines)


def next_step(result: dict[str, Any], spec: str) -> str:
    """The command to go on with.

    Choose a part, then one curve of several temperatures, then a model.
    """
    together = result["provenance"].get("note together", "")
    # Several tests in one file come first: whatever else is done with them together is wrong.
    # What is chosen may hold an apostrophe itself: it ends where the sentence goes on.
    if offered := re.search(r"choose one by '(.*?)'(?=; |$)", together):
        chosen = offered[1]
        # Only the first condition of a selection begins with @; a further one follows a comma.
        if "@" in spec:
            chosen = chosen.replace("@", ",", 1)
        return f"next: {suggested('inspect', spec + chosen)}"
    # To a degree: what wanders about one setting is no second temperature.
    temperatures = {
        round(sweep["temperature"])
        for sweep in result["sweeps"]
        if sweep.get("temperature") is not None
    }
    swept = any(
        sweep["frequency"]["to"] > SWEPT * sweep["frequency"]["from"] for sweep in result["sweeps"]
    )
    # Sweeps at several temperatures: whether they make one curve is asked before any model.
    if len(temperatures) > 1 and swept:
        return f"next: {suggested('mastercurve', spec)}"
    if "note parts" in result["provenance"] and swept:
        # A file alone tells of no parts where nobody knows its columns before the user says them.
        used = next((part["number"] for part in result["parts"] if part["usable"]), 1)
        return f"next: {suggested('compare', with_part(spec, used))}"
    return f"next: {suggested('compare', spec)}"


def in_time_text(
    result: dict[str, Any], tests: Sequence[TimeTest | OtherTest], spec: str, width: int
) -> str:
    """What tests in time hold."""
    head = (
        f"{result['data']}: {counted(len(tests), 'test')} in time,"
        f" {counted(result['points'], 'point')}"
    )
    blocks = [
        _test_text(each, test, width) for each, test in zip(result["tests"], tests, strict=True)
    ]
    # No model is known to follow a test of another kind.
    following = f"next: {suggested('diagnose', spec)}"
    if any(isinstance(test, OtherTest) for test in tests):
        following = f"next: {suggested('identify', spec, '--model', 'EXPR')}"
        following += f"   ({suggested('list models')} shows all)"
    # A steady sine is a point of a sweep as well.
    if any(test.kind == HISTORY for test in tests):
        following += "\nor, if it swings steadily: "
        following += suggested("signals", spec, "-o", "sweep.csv")
    return "\n\n".join([wrapped(head, width), *blocks, following])


def _test_text(result: dict[str, Any], test: TimeTest | OtherTest, width: int) -> str:
    if isinstance(test, OtherTest):
        rows = _of_kind(result, test)
    else:
        rows = _in_time(result, test)
    rows += [(_shown_key(key), value) for key, value in result["provenance"].items()]
    return "\n".join(wrapped(f"{key:<11} {value}", width, " " * 12) for key, value in rows)


def _of_kind(result: dict[str, Any], test: OtherTest) -> list[tuple[str, str]]:
    answer = result["response"]
    ends = f"{number(answer['from'])} to {_sized(answer['to'], answer['unit'])}"
    rows = [
        ("test", f"{result['name']}: {result['kind']}, {result['points']} points"),
        ("answer", f"{test.quantity}, {ends}"),
    ]
    if result["temperature"] is not None:
        rows.append(("temperature", f"{result['temperature']:.4g} degC"))
    return rows


def _in_time(result: dict[str, Any], test: TimeTest) -> list[tuple[str, str]]:
    clock, answer = result["time"], result["response"]
    noise, largest = result["noise"], result["largest"]
    # What rounding leaves of a share is none.
    share = noise["relative"] if noise["relative"] > NEGLIGIBLE else 0.0
    imposed, answered = test.words
    size = _sized(largest["value"], largest["unit"])
    # A record of any shape has no step, and so no rise.
    if test.kind != HISTORY:
        size += f", reached in {number(test.rise)} s"
    rows = [
        ("test", f"{result['name']}: {result['kind']}, {result['points']} points"),
        ("time", f"{number(clock['from'])} to {number(clock['to'])} s"),
        ("imposed", f"{imposed}, up to {size}"),
        (
            "answer",
            f"{answered}, {number(answer['from'])} to {_sized(answer['to'], answer['unit'])}",
        ),
        (
            "noise",
            f"{percent(share, 2)} and {_sized(noise['absolute'], answer['unit'], 2)}",
        ),
    ]
    if result["temperature_moves"] is not None:
        low, high = result["temperature_moves"]
        rows.append(("temperature", f"{low:.4g} to {high:.4g} degC, followed by shifts"))
    elif result["temperature"] is not None:
        rows.append(("temperature", f"{result['temperature']:.4g} degC"))
    return rows


def _sized(value: float, unit: str, digits: int = 4) -> str:
    if unit == "-":
        return number(value, digits)
    return f"{number(value, digits)} {unit}"
