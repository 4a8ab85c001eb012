"""One polystyrene, three tests, five temperatures.

Fit one test, predict the other two, and judge them honestly.

    SPRINGPOT_DATA=FOLDER python studies/time_and_frequency.py [--temperature 160] [-o
    results/time_and_frequency]

Question: does a model that is fitted to one test of a polymer predict the two others? Measure: the
error of each prediction beside what is to be expected, and of all tests fitted together. What would
answer it: each prediction within twice what is to be expected, and tests that agree when fitted
together.

FOLDER holds ``polystyrene-three-tests`` (github.com/mirandi1/pyRheo, demos/data/polystyrene):
oscillation, stress relaxation and creep at 130, 145, 160, 175 and 190 degC. Each model is fitted to
each test alone, and to all three together; every fit then predicts the tests that it has not seen.
A prediction holds where its error is within twice what is to be expected from the parameters'
uncertainty, the fit's own misfit and the noise of the test.
"""

from __future__ import annotations

import argparse
import csv
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import springpot
from paper.asking import question
from springpot.errors import OutputError, SpringpotError
from springpot.identification import Identification
from springpot.timetests import Test, TestPrediction, identify, predict_test

FOLDER = "polystyrene-three-tests"
TEMPERATURES = (130, 145, 160, 175, 190)
MODELS = ("fractional-maxwell", "fractional-maxwell-ab", "maxwell-6")
FILES = {
    "relaxation": "stressrelaxation_ps{T}_data.csv?time=s,relaxation=Pa",
    "creep": "creep_ps{T}_data.csv?time=s,compliance=1/Pa",
    "oscillation": "oscillation_ps{T}_data.csv?1=omega[rad/s],2=storage[Pa],3=loss[Pa]",
}
HEADERS = (
    *("temperature", "model", "fitted to", "fit error %", "predicted", "error %"),
    *("expected %", "bias %", "seen before %", "error within %", "verdict"),
)


@dataclass(frozen=True)
class Row:
    """One prediction: which model, fitted to what, said how well what."""

    temperature: int
    model: str
    fitted: str
    misfit: float
    predicted: str
    found: TestPrediction

    def cells(self) -> list[str]:
        """As they are printed."""
        found = self.found
        within = f"{100 * found.error_inside:.3g}" if found.inside > 0.0 else "-"
        return [
            *(str(self.temperature), self.model, self.fitted, f"{100 * self.misfit:.3g}"),
            *(self.predicted, f"{100 * found.error:.3g}", f"{100 * found.expected:.3g}"),
            *(f"{100 * found.bias:+.3g}", f"{100 * found.inside:.0f}", within, found.verdict),
        ]


def folder() -> Path:
    """Where the data are.

    Raises
    ------
    SystemExit
        If they are nowhere.
    """
    for root in os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep):
        if root and (Path(root) / FOLDER).is_dir():
            return Path(root) / FOLDER
    raise SystemExit(f"no {FOLDER}: name the folder above it by SPRINGPOT_DATA")


def tests_at(temperature: int) -> dict[str, Test]:
    """The three tests at one temperature."""
    found: dict[str, Test] = {}
    for name, pattern in FILES.items():
        spec = str(folder() / pattern.format(T=temperature))
        in_time = springpot.open_in_time(spec)
        found[name] = in_time[0] if in_time else springpot.open_measurement(spec)
    return found


def rows(temperatures: Sequence[int], models: Sequence[str]) -> Iterator[Row]:
    """Every prediction of a test that was not fitted."""
    for temperature in temperatures:
        tests = tests_at(temperature)
        for name in models:
            model = springpot.parse_model(name)
            for fitted, test in tests.items():
                found = identify(test, model)
                for other, unseen in tests.items():
                    if other != fitted:
                        yield Row(
                            temperature,
                            name,
                            fitted,
                            found.relative_rms,
                            other,
                            predict_test(found, unseen),
                        )


def together(
    temperatures: Sequence[int], models: Sequence[str]
) -> Iterator[tuple[int, Identification]]:
    """All three tests with one set of parameters."""
    for temperature in temperatures:
        tests = list(tests_at(temperature).values())
        for name in models:
            yield temperature, identify(tests, springpot.parse_model(name))


def markdown(headers: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table."""
    rule = ["---"] * len(headers)
    return "\n".join("| " + " | ".join(line) + " |" for line in (headers, rule, *lines)) + "\n"


def summary(found: Sequence[Row]) -> str:
    """The median error within what was seen, of each pair of tests and model."""
    pairs = dict.fromkeys((row.fitted, row.predicted) for row in found)
    models = list(dict.fromkeys(row.model for row in found))
    lines = []
    for fitted, predicted in pairs:
        cells = [fitted, predicted]
        for model in models:
            within = [
                100 * row.found.error_inside
                for row in found
                if (row.model, row.fitted, row.predicted) == (model, fitted, predicted)
                and row.found.inside > 0.0
            ]
            cells.append(f"{median(within):.3g}" if within else "-")
        lines.append(cells)
    return markdown(
        ("fitted to", "predicted", *(f"{model}: error within %" for model in models)), lines
    )


def report(found: Sequence[Row], joint: Sequence[tuple[int, Identification]]) -> str:
    """The page of results."""
    counts = {
        verdict: sum(row.found.verdict == verdict for row in found)
        for verdict in ("holds", "fails", "vague")
    }
    own = [
        [
            *(str(t), fit.model.name, test.kind, f"{100 * test.relative_rms:.3g}"),
            *(
                f"{test.over_floor_alone:.3g}",
                f"{test.over_floor:.3g}",
                "yes" if test.agrees else "no",
            ),
        ]
        for t, fit in joint
        for test in fit.tests
    ]
    headers = (
        "temperature",
        "model",
        "test",
        "error %",
        "x floor alone",
        "x floor together",
        "agrees",
    )
    return (
        f"# One polystyrene, three tests, five temperatures\n\n{question(__doc__)}\n\nWritten by"
        " `python studies/time_and_frequency.py`; its text says what was done. Errors are root mean"
        " squares over that of the signal (of |K| for oscillation). *Seen before* is the share of"
        " a test at times or frequencies that the fitted test reached, *error within* the error"
        f" there; the rest is extrapolated.\n\nOf {len(found)} predictions {counts['holds']} hold,"
        f" {counts['fails']} do not, and of {counts['vague']} the fit hardly says anything.\n\n##"
        " Median over the temperatures\n\n"
        + summary(found)
        + "\n## Fit one, predict another\n\n"
        + markdown(HEADERS, [row.cells() for row in found])
        + "\n## All three with one set of parameters\n\n"
        + markdown(headers, own)
    )


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--temperature", type=int, choices=TEMPERATURES, help="one temperature only"
    )
    parser.add_argument("--model", action="append", help="models; may be repeated")
    parser.add_argument("-o", "--output", type=Path, default=Path("results/time_and_frequency"))
    given = parser.parse_args()
    temperatures = TEMPERATURES if given.temperature is None else (given.temperature,)
    models = given.model or MODELS
    given.output.mkdir(parents=True, exist_ok=True)
    found = list(rows(temperatures, models))
    joint = list(together(temperatures, models))
    (given.output / "README.md").write_text(report(found, joint), encoding="utf-8")
    with (given.output / "predictions.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(HEADERS)
        writer.writerows(row.cells() for row in found)
    try:
        from springpot.report.residuals import figure_tests

        middle = next(
            (fit for t, fit in joint if t == 160 and fit.model.name == "maxwell-6"), joint[0][1]
        )
        at = next(t for t, fit in joint if fit is middle)
        figure_tests(middle, list(tests_at(at).values()), given.output / "together.png")
    except OutputError as error:
        print(error)
    for row in found:
        print(f"{row.temperature} {row.model} {row.fitted}: {row.found.says}")


if __name__ == "__main__":
    try:
        main()
    except SpringpotError as error:
        raise SystemExit(str(error)) from None
