"""Questions with committed answers: 60 diagnoses, 30 fits, 20 tests in time, each one command line.

Data are computed here from textbook formulas, or are registered data sets: nothing of the
framework's elements is used, so that an error there cannot hide in the data.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

NOISE = 0.006
"""Standard deviation of K' and K'' over |K|, and of a signal in time over its largest value."""
OMEGA = 2.0 * np.pi * np.geomspace(0.1, 100.0, 24)
AMPLITUDES = (0.2, 0.5, 1.0, 2.0)
TEMPERATURES = (-10.0, 10.0, 30.0, 50.0)
TIME = np.geomspace(0.02, 200.0, 120)


@dataclass(frozen=True)
class Case:
    """One command line.

    `arguments` name files of `files`, which are written to the folder it runs in.
    """

    name: str
    arguments: tuple[str, ...]
    files: tuple[tuple[str, str], ...] = ()

    def write(self, folder: Path) -> None:
        """Put the data files of this case into a folder."""
        for name, text in self.files:
            (folder / name).write_text(text)


def generator(name: str) -> np.random.Generator:
    """A stream of random numbers of its own for each case, whatever the others are."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def table(columns: dict[str, np.ndarray]) -> str:
    """A CSV text."""
    rows = "".join(
        ",".join(f"{x:.9g}" for x in row) + "\n" for row in zip(*columns.values(), strict=True)
    )
    return ",".join(columns) + "\n" + rows


BASES = {
    "fractional-kelvin": lambda s: 60.0 + 25.0 * s**0.5,
    "fractional-maxwell": lambda s: 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.7)),
    "zener": lambda s: 50.0 + 1.0 / (1.0 / 200.0 + 1.0 / (6.0 * s)),
    "fractional-zener": lambda s: 30.0 + 1.0 / (1.0 / 300.0 + 1.0 / (40.0 * s**0.6)),
}

EFFECTS = {
    "nothing": lambda s, k, x: k,
    "inertia": lambda s, k, x: k + 4e-4 * s**2,
    "series-spring": lambda s, k, x: 1.0 / (1.0 / k + 1.0 / 900.0),
    "time-delay": lambda s, k, x: k * np.exp(-3e-4 * s),
    "parallel-dashpot": lambda s, k, x: k + 0.4 * s,
    "relaxation-mode": lambda s, k, x: k + 80.0 * s / (s + 12.0),
    "unknown": lambda s, k, x: k * (1.0 + 0.08 * np.sin(3.0 * np.log(np.abs(s)))),
    "friction": lambda s, k, x: k + 4j * 6.0 / (np.pi * x),
    "payne": lambda s, k, x: k + 40.0 / (1.0 + (x / 0.6) ** 1.2),
}
BY_AMPLITUDE = ("friction", "payne")
"""Effects that one amplitude cannot show."""


def disturbed(stiffness: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Measured values: both parts scatter in proportion to |K|."""
    parts = rng.standard_normal((2, len(stiffness)))
    return stiffness + NOISE * np.abs(stiffness) * (parts[0] + 1j * parts[1])


def sweep(name: str, base: str, effect: str) -> str:
    """A sweep, at several amplitudes where the effect needs them."""
    levels = AMPLITUDES if effect in BY_AMPLITUDE else (1.0,)
    omega = np.tile(OMEGA[::3] if len(levels) > 1 else OMEGA, len(levels))
    x = np.repeat(levels, len(omega) // len(levels))
    s = 1j * omega
    k = disturbed(EFFECTS[effect](s, BASES[base](s), x), generator(name))
    columns = {
        "frequency [Hz]": omega / (2.0 * np.pi),
        "storage [kN/m]": k.real,
        "loss [kN/m]": k.imag,
    }
    if len(levels) > 1:
        columns["amplitude [mm]"] = x
    return table(columns)


def heated(name: str, base: str) -> str:
    """Sweeps at four temperatures whose times follow Arrhenius with 60 kJ/mol from 20 degC."""
    celsius = np.repeat(TEMPERATURES, len(OMEGA) // 3)
    omega = np.tile(OMEGA[::3], len(TEMPERATURES))
    factor = np.exp(60e3 / 8.314462618 * (1.0 / (celsius + 273.15) - 1.0 / 293.15))
    k = disturbed(BASES[base](1j * omega * factor), generator(name))
    return table(
        {
            "frequency [Hz]": omega / (2.0 * np.pi),
            "storage [kN/m]": k.real,
            "loss [kN/m]": k.imag,
            "temperature [degC]": celsius,
        }
    )


def diagnoses() -> Iterator[Case]:
    """Sixty sweeps: what is missing is known."""
    for base in BASES:
        for effect in EFFECTS:
            name = f"{base} hides {effect}"
            yield Case(
                name,
                ("diagnose", "sweep.csv", "--model", base),
                (("sweep.csv", sweep(name, base, effect)),),
            )
    for base in ("fractional-kelvin", "fractional-zener"):
        name = f"{base} hides a temperature"
        yield Case(
            name, ("diagnose", "sweep.csv", "--model", base), (("sweep.csv", heated(name, base)),)
        )
    for effect in ("nothing", "inertia", "time-delay", "series-spring", "unknown", "friction"):
        name = f"any material hides {effect}"
        yield Case(name, ("diagnose", "sweep.csv"), (("sweep.csv", sweep(name, "zener", effect)),))
    for truth in (
        "springpot",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-kelvin4",
        "fractional-zener",
    ):
        for model in ("springpot", "fractional-zener"):
            name = f"artificial-{truth}-noise1"
            yield Case(f"{name} as {model}", ("diagnose", name, "--model", model))
    for name, *model in (
        ("nist-srm2491@temperature=20", "fractional-maxwell"),
        ("nist-srm2491@temperature=20",),
        ("rheodata-linear-polymer-frequency-sweep", "fractional-maxwell-ab"),
        ("artificial-hidden", "fractional-maxwell"),
        ("artificial-hidden", "fractional-maxwell + inertia"),
        ("artificial-hidden", "fractional-maxwell + inertia + time-delay"),
    ):
        yield Case(
            " as ".join((name, *model)), ("diagnose", name, *(("--model", *model) if model else ()))
        )


def fits() -> Iterator[Case]:
    """Thirty fits: the paper's models on its artificial materials, measured and published ones.

    Of the paper's models and artificial materials there are five each.
    """
    models = (
        "springpot",
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-kelvin4",
        "fractional-zener",
    )
    for truth in models:
        for model in models:
            name = f"artificial-{truth}-noise2"
            yield Case(f"{name} by {model}", ("identify", name, "--model", model))
    for name, model in (
        ("nist-srm2491@temperature=20", "oldroyd-b"),
        ("reconstruction-makris-1992", "makris"),
        ("reconstruction-pdms-table4-zener", "fractional-zener"),
        ("artificial-hidden", "fractional-maxwell + inertia + time-delay"),
        ("rheodata-linear-polymer-frequency-sweep", "maxwell-5"),
    ):
        yield Case(f"{name} by {model}", ("identify", name, "--model", model))


def relaxation(late: float = 0.0) -> np.ndarray:
    """A standard solid after a step in kPa; `late` adds a slower part."""
    return 50.0 + 200.0 * np.exp(-TIME / 0.3) + late * np.exp(-TIME / 20.0)


def creep() -> np.ndarray:
    """The compliance of the same solid in 1/kPa: it retards from 1/250 to 1/50 within 1.5 s."""
    return 1.0 / 50.0 - (1.0 / 50.0 - 1.0 / 250.0) * np.exp(-TIME / 1.5)


def in_time(name: str, header: str, signal: np.ndarray, time: np.ndarray = TIME) -> str:
    """A signal with noise in proportion to its largest value."""
    noise = NOISE * np.max(np.abs(signal)) * generator(name).standard_normal(len(signal))
    return table({"time [s]": time, header: signal + noise})


def record(name: str, friction: float = 0.0) -> str:
    """Displacement and force at 1 Hz of the solid: 40 kN/m beside a springless Maxwell element."""
    time = np.linspace(0.0, 8.0, 400)
    moved, speed = np.sin(2.0 * np.pi * time), 2.0 * np.pi * np.cos(2.0 * np.pi * time)
    force = 40.0 * moved + 3.0 * speed + friction * np.sign(speed)
    force += NOISE * np.max(np.abs(force)) * generator(name).standard_normal(len(time))
    return table({"time [s]": time, "displacement [mm]": moved, "force [N]": force})


def frequency(name: str, change: str) -> str:
    """A sweep of the standard solid in kPa, with one effect of its rig."""
    s = 1j * OMEGA
    k = 50.0 + 200.0 * s / (s + 1.0 / 0.3)
    if change == "inertia":
        k = k + 4e-4 * s**2
    if change == "time-delay":
        k = k * np.exp(-5e-4 * s)
    if change == "gain-error":
        k = 1.05 * k
    k = disturbed(k, generator(name))
    return table(
        {"frequency [Hz]": OMEGA / (2.0 * np.pi), "storage [kPa]": k.real, "loss [kPa]": k.imag}
    )


def tests_in_time() -> Iterator[Case]:
    """Twenty questions of tests in time, some beside a sweep of the same solid."""
    relaxed = "relaxation [kPa]"
    alone = {
        "relaxation of nothing hidden": (relaxed, relaxation()),
        "relaxation hides a slow part": (relaxed, relaxation(60.0)),
        "relaxation hides a drift": (relaxed, relaxation() - 0.1 * TIME),
        "relaxation hides a ramp": (
            relaxed,
            relaxation() - 200.0 * np.exp(-TIME / 0.3) * np.exp(-TIME / 0.1),
        ),
        "creep of nothing hidden": ("compliance [1/kPa]", creep()),
        "creep hides a flow": ("compliance [1/kPa]", creep() + 4e-5 * TIME),
        "creep hides a slow part": (
            "compliance [1/kPa]",
            creep() + 0.004 * (1.0 - np.exp(-TIME / 30.0)),
        ),
    }
    for name, (header, signal) in alone.items():
        files = (("test.csv", in_time(name, header, signal)),)
        yield Case(name, ("diagnose", "test.csv", "--model", "zener"), files)
    for name, friction in (("record of nothing hidden", 0.0), ("record hides friction", 8.0)):
        yield Case(
            name,
            ("diagnose", "test.csv", "--model", "kelvin"),
            (("test.csv", record(name, friction)),),
        )
    step = ("step.csv", in_time("relaxation", relaxed, relaxation()))
    crept = ("step.csv", in_time("creep", "compliance [1/kPa]", creep()))
    for beside, second in (("relaxation", step), ("creep", crept)):
        for change in ("nothing", "inertia", "time-delay", "gain-error"):
            name = f"sweep hides {change} beside a {beside}"
            files = (("sweep.csv", frequency(name, change)), second)
            yield Case(name, ("diagnose", "sweep.csv", "step.csv", "--model", "zener"), files)
    for model, file in (("zener", step), ("fractional-zener", step), ("zener", crept)):
        name = f"{model} fitted to {'relaxation' if file is step else 'creep'}"
        yield Case(name, ("identify", "step.csv", "--model", model), (file,))


CASES = {"diagnoses": diagnoses, "fits": fits, "tests-in-time": tests_in_time}
