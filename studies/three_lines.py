"""The picture of the three lines: a model's error, what any material could reach, and the noise.

    python studies/three_lines.py [--out docs/images/three_lines.png]

Three artificial measurements of one damper, judged by the same model: nothing is missing, a
relaxation mode is missing, a moving mass is missing. All numbers in the picture come from
`springpot.diagnose`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

import springpot
from springpot.diagnosis import Diagnosis

ROOT = Path(__file__).resolve().parent.parent
JUDGED = "fractional-kelvin"
CASES = (
    ("Nothing is missing", JUDGED, (40.0, 12.0, 0.4)),
    ("A relaxation mode is missing", f"{JUDGED} + relaxation-mode", (40.0, 12.0, 0.4, 60.0, 0.02)),
    ("A moving mass is missing", f"{JUDGED} + inertia", (40.0, 12.0, 0.4, 0.0009)),
)
"""Headline, the truth, and its parameters in kN/m, s and Mg."""
NOISE = 0.007
FOLLOWS = 0.005
"""Chance of noise below which what a material leaves is more than noise, as in the diagnosis."""
LINES = (
    ("relative_rms", "the model", "#b3422f"),
    ("material_floor", "any material", "#c08a1e"),
    ("noise_floor", "the noise", "#3a6ea5"),
)


def diagnosed(
    truth: str, theta: tuple[float, ...], seed: int
) -> tuple[springpot.Measurement, Diagnosis]:
    """An artificial measurement and what is missing from the judged model."""
    omega = np.geomspace(2.0, 300.0, 40)
    exact = springpot.parse_model(truth).stiffness(np.array(theta), omega)
    noise = NOISE / np.sqrt(2.0) * np.random.default_rng(seed).normal(size=(2, len(omega)))
    units = springpot.Units("kN/m", "mm")
    data = springpot.Measurement(omega, exact * (1.0 + noise[0] + 1j * noise[1]), units=units)
    return data, springpot.diagnose(data, JUDGED)


def draw_curves(axes: Axes, data: springpot.Measurement) -> None:
    """Measured storage and loss with the fit of the judged model."""
    fit = springpot.identify(data, JUDGED)
    modelled = springpot.parse_model(JUDGED).stiffness(fit.theta, data.omega)
    for measured, curve, marker, word in (
        (data.storage, modelled.real, "o", "storage"),
        (data.loss, modelled.imag, "s", "loss"),
    ):
        axes.loglog(
            data.frequency,
            np.abs(measured),
            marker,
            color="0.35",
            markersize=3,
            label=f"measured {word}",
        )
        axes.loglog(data.frequency, np.abs(curve), color=LINES[0][2], linewidth=1.5)
    axes.set_xlabel("frequency [Hz]")
    axes.grid(alpha=0.2)


def draw_lines(axes: Axes, diagnosis: Diagnosis) -> None:
    """The three lines as bars with their figures."""
    for place, (name, _, colour) in enumerate(LINES):
        size = 100.0 * getattr(diagnosis.error, name)
        axes.barh(-place, size, color=colour, height=0.6)
        axes.text(size * 1.15, -place, f"{size:.2g} %", va="center", fontsize=9)
    axes.set_xscale("log")
    axes.set_xlim(0.1, 200.0)
    axes.set_yticks([0, -1, -2], [word for _, word, _ in LINES])
    axes.set_xlabel("error [% of |K|]")
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def conclusion(diagnosis: Diagnosis) -> str:
    """What the three lines say, and what is found, in two short lines."""
    if diagnosis.best is None:
        return "all three lines are one:\nthe model is good enough"
    missing = " or ".join(diagnosis.best.alike)
    if diagnosis.error.material_chance < FOLLOWS:
        return f"no material could follow:\nmissing is {missing}"
    return f"a material could follow:\nmissing is {missing}"


def main() -> None:
    """Draw the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images" / "three_lines.png")
    out = parser.parse_args().out
    figure, axes = plt.subplots(
        2, len(CASES), figsize=(10.0, 5.6), height_ratios=(2.0, 1.0), layout="constrained"
    )
    for number, (headline, truth, theta) in enumerate(CASES):
        data, diagnosis = diagnosed(truth, theta, number)
        print(f"{headline}: {diagnosis.says}; {diagnosis.split}")
        draw_curves(axes[0, number], data)
        axes[0, number].set_title(headline, fontsize=11, fontweight="bold")
        axes[1, number].set_title(conclusion(diagnosis), fontsize=9)
        draw_lines(axes[1, number], diagnosis)
    axes[0, 0].set_ylabel("|K'|, |K''| [kN/m]")
    axes[0, 0].legend(fontsize=8)
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
