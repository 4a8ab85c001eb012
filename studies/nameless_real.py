"""Laws sought in measured data, and in data simulated from published equations.

    python studies/nameless_real.py [NAME ...] [--out results/nameless/real] [--figures docs/images]

Question: is the law of a device whose physics is known found in measured data, and in those of a
published equation? Measure: the class of laws that the data cannot tell apart, and the error beside
the noise floor before and after. What would answer it: a class that holds the known law with its
exponents in their intervals, or `none` where no formula of the grammar is that law.

Filled EPDM by strain, a friction damper by amplitude and band tension, a magnetorheological damper
by current and amplitude: a set that is not on this machine is passed over. The hysteretic benchmark
(Bouc-Wen; Noel and Schoukens 2016, with the published values) and the Silverbox (Wigren and
Schoukens 2013: the published equation, with a resonance at 68 Hz) are moved by a sine of each
frequency and amplitude, of which the first harmonic of the force is kept, with noise of 0.5 %.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import springpot
from paper.asking import question
from springpot import Measurement, Units
from springpot.errors import DataError

DATA = Path(
    os.environ.get(
        "SPRINGPOT_DATA", Path(__file__).resolve().parent.parent.parent / "shared" / "data"
    )
)
STEPS = 4000
"""Steps of a period."""
PERIODS = 4
"""Periods after which a loop is closed."""


def first_harmonic(
    force: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray], omega: float, x: float
) -> complex:
    """K of a force that a displacement x sin(omega t) takes, from its last period."""
    phase = 2.0 * np.pi * np.arange(PERIODS * STEPS) / STEPS
    y, v, a = x * np.sin(phase), omega * x * np.cos(phase), -(omega**2) * x * np.sin(phase)
    wave = np.exp(-1j * phase[-STEPS:])
    return complex(np.mean(force(y, v, a)[-STEPS:] * wave) * 2j / x)


def bouc_wen(y: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The force in N: mass, damper, spring, and a part that remembers."""
    alpha, beta, gamma, delta = 5e4, 1e3, 0.8, -1.1
    z = np.zeros(len(y))
    for i, way in enumerate(np.diff(y)):
        middle = z[i]
        # Twice, that the slope be that of the middle of the step.
        for share in (0.5, 1.0):
            slope = alpha - beta * (gamma * np.sign(way) * middle + delta * abs(middle))
            middle = z[i] + share * slope * way
        z[i + 1] = middle
    return 2.0 * a + 10.0 * v + 5e4 * y + z


def silverbox(y: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The force in V: a spring that stiffens with the cube of the way."""
    return a / (2.0 * np.pi * 68.0) ** 2 + 2e-4 * v + y + 3.9 * y**3


def simulated(
    name: str, force: Callable[..., np.ndarray], hertz: np.ndarray, x: np.ndarray
) -> Measurement:
    """K at each frequency and amplitude, with noise of 0.5 %."""
    omega, amplitude = (each.ravel() for each in np.meshgrid(2.0 * np.pi * hertz, x))
    exact = np.array([first_harmonic(force, *pair) for pair in zip(omega, amplitude, strict=True)])
    noise = 0.005 * np.random.default_rng(1).normal(size=(2, len(omega))) * np.abs(exact)
    return Measurement(
        omega,
        exact + noise[0] + 1j * noise[1],
        conditions={"amplitude": amplitude},
        units=Units("N/m", "m"),
        name=name,
    )


def epdm() -> Measurement:
    """The strain sweep of the filled elastomer at 10 Hz."""
    data = springpot.read(DATA / "elastomer-epdm-70-dma-payne" / "normalized.csv")
    return data.subset(np.flatnonzero(data.labels["run"] == "sd_10hz"))


SETS: dict[str, tuple[Callable[[], Measurement], str, tuple[str, ...]]] = {
    "epdm": (epdm, "material", ("amplitude",)),
    "friction-damper": (
        lambda: springpot.read(DATA / "friction-damper-brfd-lehigh" / "normalized_harmonics.csv"),
        "material",
        ("amplitude", "band_tension_lb"),
    ),
    "mr-damper": (
        lambda: springpot.read(DATA / "mr-damper-utfsm-sinusoid" / "normalized_harmonics.csv"),
        "material",
        ("amplitude", "current_a"),
    ),
    "bouc-wen": (
        lambda: simulated(
            "bouc-wen", bouc_wen, np.geomspace(2.0, 100.0, 10), np.geomspace(1e-4, 2e-3, 8)
        ),
        "material + inertia",
        ("amplitude",),
    ),
    "silverbox": (
        lambda: simulated(
            "silverbox", silverbox, np.geomspace(10.0, 120.0, 10), np.geomspace(0.03, 0.3, 8)
        ),
        "material + inertia",
        ("amplitude",),
    ),
}
"""Data, the model beside which a law is sought, and the columns that it may go with."""


def main() -> None:
    """Seek, keep the answer, draw it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SETS))
    parser.add_argument("--out", type=Path, default=Path("results/nameless/real"))
    parser.add_argument("--figures", type=Path, default=Path("docs/images"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or SETS:
        opened, model, along = SETS[name]
        try:
            data = opened()
        except DataError as error:
            print(f"{name}: not on this machine ({error})")
            continue
        found = springpot.invent(data, model, along=list(along), seed=0)
        (options.out / f"{name}.json").write_text(json.dumps(found.to_dict(), indent=1) + "\n")
        (options.out / f"{name}.txt").write_text(f"{question(__doc__)}\n\n{found}\n")
        found.plot(options.figures / f"law-{name}.png")
        print(found, "\n", flush=True)


if __name__ == "__main__":
    main()
