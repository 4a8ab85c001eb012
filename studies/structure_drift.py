"""What a missing effect does to a building.

Drifts foretold with dampers that were identified rightly and wrongly.

    python studies/structure_drift.py [--records 20] [-o results/structure_drift]

Question: how far off is a building's drift that is foretold with a damper identified wrongly?
Measure: the largest drift under artificial ground motions, less the one with the true damper. What
would answer it: the right model within 0.2 %, and a wrong one more than 2 % off.

A damper (fractional Maxwell, k = 400 kN/m, c = 60 kN s^alpha/m, alpha = 0.55) is tested from 1 to
48 Hz on a rig whose clamp moves with it (0.6 kg), with 0.5 % noise: all of it artificial. It is
identified with the clamp's inertia and without, and by classical models. Braces of 60 such dampers
then stand in each storey of a frame of three, under artificial ground motions of 3 m/s^2; the clamp
stays in the laboratory. What each identification foretells is set beside what the true damper does.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import springpot
from paper.asking import question
from springpot.errors import OutputError
from springpot.identification import Identification
from springpot.measurement import Measurement, Units
from springpot.rheology import Real
from springpot.structure import Damper, Frame, artificial, modes_of, motion_of

TRUE = {"k": 400.0, "c": 60.0, "alpha": 0.55}
CLAMP = 0.6e-3
"""Of the rig, in t: with forces in kN and ways in m."""
NOISE = 0.005
MODELS = (
    "fractional-maxwell + inertia",
    "fractional-maxwell",
    "fractional-kelvin",
    "maxwell",
    "kelvin",
)
KILO = 1e3
"""kN/m in N/m."""
COUNT = 60.0
HEADERS = (
    "identified as",
    "error of the fit %",
    "damping of the first mode %",
    "drift off by %",
    "worst record %",
)


@dataclass(frozen=True)
class Row:
    """One identification, and how far its drifts are off, record by record."""

    name: str
    misfit: float
    damping: float
    off: Real


def tested(rng: np.random.Generator) -> Measurement:
    """The sweep from the rig."""
    omega = 2 * np.pi * np.geomspace(1.0, 48.0, 40)
    model = springpot.parse_model("fractional-maxwell + inertia")
    exact = model.stiffness(model.vector(TRUE | {"inertia.m": CLAMP}), omega)
    noise = 1.0 + NOISE * (rng.normal(size=40) + 1j * rng.normal(size=40))
    return Measurement(omega, exact * noise, units=Units("kN/m", "mm"), name="damper")


def braced(model: springpot.Model, theta: Real) -> Frame:
    """Three storeys with that damper, theta in N, m and s."""
    dampers = tuple(Damper(model, theta, storey, COUNT) for storey in (1, 2, 3))
    return Frame(np.full(3, 1e5), np.array([8e7, 7e7, 6e7]), 0.02, dampers)


def as_identified(found: Identification) -> Frame:
    """The frame with the damper as it was identified; the clamp's mass stays in the laboratory."""
    known = found.of_specimen
    model = found.model
    for effect in found.model.effects:
        model = model - effect
    kept = [found.model.names.index(name) for name in model.names]
    powers = np.array([parameter.unit.stiffness for parameter in model.parameters])
    return braced(model, known.theta[kept] * KILO**powers)


def rows(records: int) -> list[Row]:
    """Every model against the truth."""
    rng = np.random.default_rng(20)
    data = tested(rng)
    model = springpot.parse_model("fractional-maxwell")
    truth = braced(model, model.vector(TRUE) * np.array([KILO, KILO, 1.0]))
    shaken = [artificial(rng, duration=15.0) for _ in range(records)]
    exact = [motion_of(truth, record).peak_drift.max() for record in shaken]
    found = [Row("the true damper", 0.0, modes_of(truth)[0].damping, np.zeros(records))]
    for name in MODELS:
        fit = springpot.identify(data, name)
        frame = as_identified(fit)
        drifts = [motion_of(frame, record).peak_drift.max() for record in shaken]
        off = np.array(drifts) / np.array(exact) - 1.0
        found.append(Row(name, fit.relative_rms, modes_of(frame)[0].damping, off))
    return found


def cells(row: Row) -> list[str]:
    """As they are printed."""
    worst = row.off[np.argmax(np.abs(row.off))]
    values = (100 * row.misfit, 100 * row.damping)
    return [
        row.name,
        *(f"{value:.3g}" for value in values),
        f"{100 * row.off.mean():+.2g}",
        f"{100 * worst:+.2g}",
    ]


def markdown(found: Sequence[Row], records: int) -> str:
    """The page of results."""
    lines = [HEADERS, ["---"] * len(HEADERS), *(cells(row) for row in found)]
    table = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return (
        f"# What a missing effect does to a building\n\n{question(__doc__)}\n\nWritten by `python"
        " studies/structure_drift.py`, whose text says what was done. Largest drift of a frame of"
        f" three storeys, against the one with the true damper; mean and worst of {records}"
        f" artificial ground motions.\n\n{table}\n"
    )


def draw(found: Sequence[Row], path: Path) -> None:
    """Drifts of all records, for each identification."""
    from springpot.report.canvas import COLOURS, QUIET, blank, save

    with blank(7.2, 3.4) as figure:
        axes = figure.subplots()
        for place, row in enumerate(found[1:]):
            axes.plot(100 * row.off, np.full(len(row.off), place), "|", ms=12, color=COLOURS[place])
        axes.axvline(0.0, color=QUIET)
        axes.set(xlabel="peak drift foretold, less the true one [%]", yticks=range(len(found) - 1))
        axes.set_yticklabels(
            [f"{row.name}\n(fit {100 * row.misfit:.2g} % off)" for row in found[1:]]
        )
        axes.margins(y=0.12)
        axes.invert_yaxis()
        save(figure, path)


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=20)
    parser.add_argument("-o", "--output", type=Path, default=Path("results/structure_drift"))
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    found = rows(given.records)
    (given.output / "README.md").write_text(markdown(found, given.records), encoding="utf-8")
    with (given.output / "drifts.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(HEADERS)
        writer.writerows(cells(row) for row in found)
    try:
        draw(found, given.output / "drifts.png")
    except OutputError as error:
        print(error)
    print(markdown(found, given.records))


if __name__ == "__main__":
    main()
