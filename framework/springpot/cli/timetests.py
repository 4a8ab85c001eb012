"""What commands do with tests in time: find them among the data, identify from them, show them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .common import emit, opened

if TYPE_CHECKING:
    from springpot.identification import Identification
    from springpot.measurement import TimeTest
    from springpot.rheology import Model
    from springpot.timetests import Known, Test, TestPrediction, TimeDiagnosis, TimeIdentification

SWEEPS_ONLY = ("optimiser", "objective", "budget", "restarts", "seed")
"""Options of searches among sweeps."""


def named_tests(data: Sequence[str], geometry: str | None) -> list[Test] | None:
    """The tests that DATA name, where at least one of them is a test in time; None otherwise.

    Raises
    ------
    SpringpotError
        If one of them cannot be opened, or a geometry is given, which is for sweeps.
    """
    from springpot.errors import OptionError
    from springpot.registry import open_in_time

    found = [open_in_time(spec) for spec in data]
    if not any(found):
        return None
    if geometry is not None:
        raise OptionError("--geometry is for sweeps: convert tests in time to stress and strain in their file")
    tests: list[Test] = []
    for spec, in_time in zip(data, found, strict=True):
        tests += in_time or [opened(spec)]
        for test in in_time:
            for key, value in test.provenance.items():
                if key.startswith("note "):
                    print(f"note: {test.name}: {value}", file=sys.stderr)
    return tests


def identify(tests: Sequence[Test], expression: str, figure: Path | None, as_json: bool, options: Any) -> None:
    """``springpot identify`` of tests in time, alone or beside sweeps."""
    from springpot.errors import OptionError
    from springpot.registry import parse_model
    from springpot.timetests import identify as identify_in_time

    given = [name for name in SWEEPS_ONLY if options.get(name) is not None]
    if given or options.get("intervals", "jacobian") != "jacobian":
        name = given[0] if given else "intervals"
        raise OptionError(f"--{name} is for sweeps: tests in time are identified by the native solver")
    found = identify_in_time(tests, parse_model(expression))
    if figure is not None:
        from springpot.report.timetests import figure_tests

        figure_tests(found, tests, figure)
    emit(found, as_json, lambda: _show(found, figure))


def _show(found: TimeIdentification, figure: Path | None) -> None:
    from springpot.report.numbers import number, percent, seconds, with_interval
    from springpot.report.text import Table, indented
    from springpot.rheology.drawing import drawing_of

    points = sum(test.points for test in found.tests)
    count = f"{len(found.tests)} tests, " if len(found.tests) > 1 else ""
    names = " + ".join(test.name for test in found.tests)
    print(f"{found.model.name} fitted to {names} ({count}{points} points)\n")
    print(indented(drawing_of(found.model)) + "\n")
    rows = [
        [name, *with_interval(entry["value"], entry["low"], entry["high"]), entry["unit"]]
        for name, entry in found.parameters.items()
    ]
    Table(("parameter", "value", "95 % interval", "unit"), rows, frozenset({"value"})).show()
    print()
    headers = ("test", "kind", "points", "error", "noise floor", "x floor", "x floor alone")
    judged = [
        [t.name, t.kind, str(t.points), percent(t.error), percent(t.floor, 2), number(t.ratio, 2), number(t.alone, 2)]
        for t in found.tests
    ]
    Table(headers, judged, frozenset(headers[2:])).show()
    status = "converged" if found.converged else "not converged"
    print(f"\nsearch      {status}, {found.evaluations} evaluations in {seconds(found.seconds)}")
    for note in found.notes:
        print(f"note        {note}")
    if figure is not None:
        print(f"figure      {figure}")


def diagnose(tests: Sequence[Test], model: Model | None, as_json: bool) -> None:
    """``springpot diagnose`` of tests in time: what is missing, from the raw signals."""
    from springpot.errors import ModelError
    from springpot.registry import plugins
    from springpot.timetests import diagnose as diagnose_in_time

    if model is None:
        raise ModelError("tests in time are judged by a model: give --model, such as fractional-zener")
    found = diagnose_in_time(tests, model, plugins().items("effect"))
    emit(found, as_json, lambda: _show_diagnosis(found))


def _show_diagnosis(found: TimeDiagnosis) -> None:
    from springpot.report.numbers import number
    from springpot.report.text import Table

    print(f"{found.base.model.name}: {found.verdict}\n{found.says}\n")
    rows = [
        [
            each.effect,
            each.verdict,
            number(each.delta_bic, 3),
            number(each.over_floor, 2),
            ", ".join(
                f"{name.partition('.')[2]} {entry['value']:.3g} {entry['unit']}"
                for name, entry in each.parameters.items()
            ),
        ]
        for each in found.candidates
    ]
    Table(("effect", "verdict", "delta BIC", "x floor after", "parameters"), rows, frozenset({"delta BIC"})).show()
    for name in found.missing:
        print(f"\n{name}: {next(each.says for each in found.candidates if each.effect == name)}")


def described(tests: Sequence[TimeTest]) -> dict[str, Any]:
    """What files of tests in time hold, schema ``springpot.inspection/1``."""
    return {
        "schema": "springpot.inspection/1",
        "data": " + ".join(test.name for test in tests),
        "points": sum(map(len, tests)),
        "tests": [_described(test) for test in tests],
    }


def _described(test: TimeTest) -> dict[str, Any]:
    import numpy as np

    from springpot.measurement import noise_of

    noise = noise_of(test)
    steps = np.diff(test.time)
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
        "noise": {
            "floor": noise.floor,
            "absolute": noise.absolute,
            "relative": noise.relative,
            "source": "estimated" if noise.estimated else "assumed",
        },
        "provenance": dict(test.provenance),
    }


def inspect(tests: Sequence[TimeTest], as_json: bool) -> None:
    """``springpot inspect`` of tests in time."""
    result = described(tests)
    emit(result, as_json, lambda: _show_inspected(result))


def _show_inspected(result: dict[str, Any]) -> None:
    from springpot.report.numbers import number, percent
    from springpot.report.text import Table

    plural = "" if len(result["tests"]) == 1 else "s"
    print(f"{result['data']}: {len(result['tests'])} test{plural} in time, {result['points']} points")
    for test in result["tests"]:
        clock, answer, noise = test["time"], test["response"], test["noise"]
        print()
        answered = {"displacement": "force", "force": "displacement"}[test["imposed"]]
        rows = [
            ["test", f"{test['name']}: {test['kind']}, {test['points']} points"],
            ["time", f"{number(clock['from'])} to {number(clock['to'])} s"],
            ["imposed", f"{test['imposed']}, up to {_sized(test['largest'])}, risen in {number(test['rise'])} s"],
            ["answer", f"{answered}, {number(answer['from'])} to {number(answer['to'])} {answer['unit']}"],
            ["noise", f"{percent(noise['relative'], 2)} and {number(noise['absolute'], 2)} {answer['unit']}"],
        ]
        if test["temperature"] is not None:
            rows.append(["temperature", f"{test['temperature']:.4g} degC"])
        rows += [[key, value] for key, value in test["provenance"].items()]
        Table(("", ""), rows).show()


def _sized(entry: dict[str, Any]) -> str:
    from springpot.report.numbers import number

    return f"{number(entry['value'])} {entry['unit']}"


def predict(
    found: Identification | Known,
    spec: str,
    temperature: float | None,
    output: Path | None,
    figure: Path | None,
    as_json: bool,
) -> None:
    """``springpot predict --history``: another test of the specimen, and whether its prediction holds."""
    from springpot.files import write_text
    from springpot.timetests import predict_test

    predicted = predict_test(found, _asked(spec, temperature))
    if output is not None:
        write_text(output, _table_text(predicted))
    if figure is not None:
        from springpot.report.timetests import figure_prediction

        figure_prediction(predicted, figure)
    emit(predicted, as_json, lambda: print(f"{predicted.model}: {predicted.says}"))
    for path in (output, figure):
        if path is not None and not as_json:
            print(f"written: {path}")


def _asked(spec: str, temperature: float | None) -> Test:
    """The test to be predicted: in time, measured or only planned, or else a sweep."""
    from dataclasses import replace

    from springpot.errors import DataError
    from springpot.registry import open_in_time

    mark = "," if "?" in spec else "?"
    in_time = open_in_time(f"{spec}{mark}answer=none")
    if not in_time:
        return opened(spec)
    if len(in_time) > 1:
        raise DataError(f"{spec}: {len(in_time)} tests; choose one by '#', such as {spec}#1")
    test = in_time[0]
    return test if temperature is None else replace(test, temperature=temperature)


def _table_text(predicted: TestPrediction) -> str:
    """A CSV table with units in its header."""
    clock = "frequency [Hz]" if predicted.kind == "sweep" else "time [s]"
    unit = predicted.unit
    names = [clock, f"value [{unit}]", f"low [{unit}]", f"high [{unit}]"]
    columns = [predicted.at, predicted.value, predicted.low, predicted.high]
    if predicted.judged:
        names, columns = [*names, f"measured [{unit}]"], [*columns, predicted.measured]
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return "\n".join([",".join(names), *(",".join(map(repr, row)) for row in rows)]) + "\n"
