"""What commands do with tests in time: find them among the data, identify from them, show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.writing import in_shell

from .common import emit, note_to_stderr, notes_of, opened, seen_through, tell_written, window

if TYPE_CHECKING:
    from springpot.identification.result import Identification
    from springpot.measurement.covered import OtherTest
    from springpot.measurement.timetest import TimeTest
    from springpot.misfit.residuals_of_tests import Test
    from springpot.timetests.prediction import TestPrediction

WHERE = ("within", "outside")
"""What tables say of a point that lies within, or outside of, what was measured."""


def named_tests(data: Sequence[str], geometry: str | None) -> list[Test] | None:
    """The tests that DATA name, where at least one of them is a test in time; None otherwise.

    Raises
    ------
    SpringpotError
        If one of them cannot be opened, or does not fit the geometry.
    """
    from springpot.errors import DataError
    from springpot.registry import open_in_time

    # All are opened before anything is decided: one test in time makes the sweeps beside it part of
    # a joint fit.
    of_each: list[tuple[TimeTest | OtherTest, ...]] = []
    unusable: list[DataError] = []
    for spec in data:
        try:
            of_each.append(open_in_time(spec))
        except DataError as error:
            unusable.append(error)
    if not any(of_each) and (of_each or len(data) > 1):
        # Each gets an answer of its own, or its line: it is opened for that again.
        return None
    if unusable:
        # A joint answer without one of its tests would be another one.
        raise unusable[0]
    tests: list[Test] = []
    for spec, in_time in zip(data, of_each, strict=True):
        for test in in_time:
            for key, value in test.provenance.items():
                if key.startswith("note "):
                    note_to_stderr(test.name, value)
            tests.append(seen_through(test, geometry))
        # What is no test in time among tests in time is a sweep of the same specimen.
        if not in_time:
            tests.append(opened(spec, geometry))
    return tests


def turned_data(tests: Sequence[Test], data: Sequence[str]) -> list[str]:
    """The data, each the right way round where a channel is to be turned or two exchanged."""
    from springpot.measurement.mixed_up import turned
    from springpot.measurement.reader import file_and_choice

    others = [other for test in tests if (other := turned(test.provenance))]
    if others and len(data) == 1:
        return others[:1]
    return [
        next(
            (other for other in others if file_and_choice(other)[0] == file_and_choice(spec)[0]),
            spec,
        )
        for spec in data
    ]


def described(tests: Sequence[TimeTest | OtherTest]) -> dict[str, Any]:
    """What files of tests in time hold, schema ``springpot.inspection/1``."""
    from springpot.measurement.opening import together

    return {
        "schema": "springpot.inspection/1",
        "data": together(test.name for test in tests),
        "points": sum(map(len, tests)),
        "tests": [_described(test) for test in tests],
    }


def _described(test: TimeTest | OtherTest) -> dict[str, Any]:
    import numpy as np

    from springpot.measurement.covered import OtherTest

    if isinstance(test, OtherTest):
        return _described_of_kind(test)

    from springpot.measurement.timenoise import noise_of

    noise = noise_of(test)
    source = "assumed"
    if noise.estimated:
        source = "estimated"
    steps = np.diff(test.time)
    moves = None
    if test.warmth is not None:
        moves = [float(test.warmth.min()), float(test.warmth.max())]
    return {
        "name": test.name,
        "kind": test.kind,
        "points": len(test),
        "time": {"from": float(test.time[0]), "to": float(test.time[-1]), "unit": "s"},
        "longest_step": float(steps.max()),
        "shortest_step": float(steps.min()),
        "imposed": test.control,
        "largest": {"value": float(np.abs(test.loading.value).max()), "unit": test.loading_unit},
        "rise": test.rise,
        "response": {
            "from": float(test.response.min()),
            "to": float(test.response.max()),
            "unit": test.response_unit,
        },
        "stiffness_unit": test.units.stiffness,
        "temperature": test.temperature,
        "temperature_moves": moves,
        "noise": {
            "floor": noise.floor,
            "absolute": noise.absolute,
            "relative": noise.relative,
            "source": source,
        },
        "provenance": dict(test.provenance),
    }


def _described_of_kind(test: OtherTest) -> dict[str, Any]:
    ends = {"from": float(test.measured.min()), "to": float(test.measured.max())}
    return {
        "name": test.name,
        "kind": test.kind,
        "points": len(test),
        "response": {**ends, "unit": test.unit},
        "stiffness_unit": test.units.stiffness,
        "temperature": test.temperature,
        "provenance": dict(test.provenance),
    }


def inspect(tests: Sequence[TimeTest | OtherTest], spec: str, as_json: bool, line: bool) -> None:
    """``springpot inspect`` of tests in time."""
    from springpot.report.inspection import in_time_text

    result = described(tests)
    emit(result, as_json, lambda: print(in_time_text(result, tests, spec, window())), line)


def predict(
    identified: Identification,
    spec: str,
    temperature: float | None,
    level: float,
    geometry: str | None,
    output: Path | None,
    figure: Path | None,
    as_json: bool,
) -> None:
    """``springpot predict --history``.

    Another test of the specimen, and whether its prediction holds.
    """
    from springpot.files import write_text
    from springpot.report.text import wrapped
    from springpot.timetests.prediction import predict_test

    test = _asked(spec, temperature, geometry)
    predicted = predict_test(identified, test, level)
    if output is not None:
        write_text(output, _table_text(predicted, test))
    if figure is not None:
        predicted.plot(figure)
    said = wrapped(f"{predicted.model}: {predicted.says}", window())
    emit(
        predicted,
        as_json,
        lambda: print("\n".join(filter(None, [said, notes_of(predicted.notes)]))),
    )
    if not as_json:
        tell_written(output, figure, above="")


def _asked(spec: str, temperature: float | None, geometry: str | None) -> Test:
    """The test to be predicted: in time, measured or only planned, or else a sweep."""
    from springpot.errors import DataError
    from springpot.measurement.covered import OtherTest
    from springpot.measurement.reader import with_part
    from springpot.registry import open_in_time

    # Behind the first question mark answers are parted by commas.
    mark = "," if "?" in spec else "?"
    # What is only planned has no answer yet, which a reader would else ask for.
    in_time = open_in_time(f"{spec}{mark}answer=none")
    if not in_time:
        return opened(spec, geometry)
    if len(in_time) > 1:
        raise DataError(
            f"{spec}: {len(in_time)} tests; choose one by '#', such as"
            f" {in_shell(with_part(spec, 1))}"
        )
    test = seen_through(in_time[0], geometry)
    if temperature is None:
        return test
    if isinstance(test, OtherTest):
        return replace(test, temperature=temperature)
    # At one temperature: that which the file has from sample to sample would go before it.
    return replace(test, temperature=temperature, warmth=None)


def _table_text(predicted: TestPrediction, test: Test) -> str:
    """A CSV table with units in its header, which opens again as the predicted test."""
    import numpy as np

    from springpot.measurement.timetest import TimeTest
    from springpot.measurement.units import Units

    clock, at = "time [s]", predicted.at
    quantities = {predicted.quantity: slice(None)}
    if predicted.kind == "sweep":
        # All of storage, then all of loss, at the same frequencies.
        half = len(at) // 2
        quantities = {"storage": slice(half), "loss": slice(half, None)}
        units = Units(clock=predicted.clock)
        clock, at = units.clock_head, units.on_clock(at[:half])
    names, columns = [clock], [at]
    if isinstance(test, TimeTest):
        names.append(f"{test.words[0]} [{test.loading_unit}]")
        columns.append(np.interp(at, test.loading.time, test.loading.value))
    for quantity, rows in quantities.items():
        told = {"": predicted.value, "_low": predicted.low, "_high": predicted.high}
        if predicted.judged:
            told["_measured"] = predicted.measured
        names += [f"{quantity}{end} [{predicted.unit}]" for end in told]
        columns += [column[rows] for column in told.values()]
    lines = [",".join([*names, "measured [text]"])]
    places = [WHERE[outside] for outside in predicted.outside[: len(at)].tolist()]
    for *row, place in zip(*(column.tolist() for column in columns), places, strict=True):
        # `repr` keeps every digit.
        lines.append(",".join([*map(repr, row), place]))
    return "\n".join(lines) + "\n"
