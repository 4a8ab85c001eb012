"""Data sets that come with the package, computed or measured.

The paper's artificial data, section 5.1: five models at 14 frequencies, exact and with the noise of
eq. (53). For demonstrations, a simple material on a test rig that is not. And reconstructions:
curves from the parameters printed in Tables 3 to 6. The paper shows its measured points only in
figures. What a fitted model gives at frequencies of our choice says nothing about scatter or about
what the model missed; these sets serve to repeat the paper's arithmetic.

Measured are the certified silicone fluid of NIST, SRM 2491, embedded with its uncertainties; and
the oscillatory sets of the package rheopy-rheodata, read from its files without importing it.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import DataSet, Measurement, Units, with_noise
from springpot.rheology import Real

from ..models import paper
from ..models.paper import MODELS
from ..readers.springpot_csv import parse

SEED = 2017
"""Seed of the registered noisy sets; `artificial` draws others.

Any number would do: results name these sets.
"""
FREQUENCIES = np.arange(0.5, 14.0, 1.0)
"""0.5 to 13.5 Hz in steps of 1 Hz."""
SCALE = 1000.0
"""k-bar in kN/m."""
_THREE = {"k": 400.0, "c": 150.0, "alpha": 0.6}
_FOUR = {"k1": 600.0, "k2": 400.0, "c": 150.0, "alpha": 0.6}
TRUTH = {
    "springpot": {"c": 150.0, "alpha": 0.6},
    "fractional-kelvin": _THREE,
    "fractional-maxwell": _THREE,
    "fractional-kelvin4": _FOUR,
    "fractional-zener": _FOUR,
}
CITATION = (
    "Parameters identification of fractional models of viscoelastic dampers and fluids, section 5.1"
)


def artificial(
    model: str,
    level: float = 0.0,
    *,
    symmetric: bool = False,
    seed: int | np.random.Generator = SEED,
) -> Measurement:
    """Artificial data of one of the paper's models in kN/m.

    Parameters
    ----------
    model : str
        One of `TRUTH`.
    level : float
        Noise level of eq. (53), such as 0.01; 0 for exact data.
    symmetric : bool
        Noise of both signs instead of the one-sided noise as printed.
    seed : int or numpy.random.Generator
        Where the noise comes from; the registered sets use `SEED`.

    Raises
    ------
    DataError
        If the paper has no such model.
    """
    if model not in TRUTH:
        raise DataError(
            f"there are no artificial data of '{model}': the paper has {', '.join(TRUTH)}"
        )
    known = next(item for item in MODELS if item.base == model)
    omega = 2.0 * np.pi * FREQUENCIES
    exact = Measurement(
        omega,
        known.stiffness(known.vector(TRUTH[model]), omega),
        units=Units("kN/m", "mm"),
        name=f"artificial-{model}{_suffix(level, symmetric)}",
        provenance={"source": "computed, section 5.1", "model": model},
    )
    if level == 0:
        return exact
    return with_noise(exact, level, np.random.default_rng(seed), symmetric=symmetric)


def _suffix(level: float, symmetric: bool) -> str:
    if not level:
        return ""
    # The noise that the paper prints is what its name says without a word; the other kind says so.
    kind = "noise"
    if symmetric:
        kind = "symmetric"
    return f"-{kind}{100 * level:g}"


def _dataset(model: str, level: float, symmetric: bool) -> DataSet:
    noise = "without noise"
    if level:
        kind = "one-sided as printed"
        if symmetric:
            kind = "both signs"
        noise = f"with {100 * level:g} % noise of eq. (53), {kind}, seed {SEED}"
    return DataSet(
        f"artificial-{model}{_suffix(level, symmetric)}",
        f"computed from {model} at 14 frequencies from 0.5 to 13.5 Hz, {noise}",
        partial(artificial, model, level, symmetric=symmetric),
        kind="artificial",
        licence="none needed",
        citation=CITATION,
        size=len(FREQUENCIES),
        truth=dict(TRUTH[model]),
        model=model,
        stiffness_scale=SCALE,
    )


def _artificial_sets() -> list[DataSet]:
    """Five models, exact and with noise of 1 % and 2 %, one-sided and symmetric."""
    variants = [(0.0, False), (0.01, False), (0.02, False), (0.01, True), (0.02, True)]
    return [_dataset(model, level, symmetric) for model in TRUTH for level, symmetric in variants]


HIDDEN = "artificial-hidden"


class HiddenSweep(NamedTuple):
    """Of the set with hidden effects."""

    seed: int
    noise: float
    hertz: NDArray[np.float64]
    """In Hz."""


SWEEP = HiddenSweep(seed=7, noise=0.01, hertz=np.geomspace(0.5, 100.0, 40))
HIDDEN_TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5, "inertia.m": 6e-4, "time-delay.tau": 4e-4}
"""kN/m, kN s^alpha/m, -, tonnes (0.6 kg), s."""


def hidden() -> Measurement:
    """A fractional Maxwell damper between plates with a mass, its force read late, noise of 1 %."""
    s = 2j * np.pi * SWEEP.hertz
    material = 1.0 / (
        1.0 / HIDDEN_TRUTH["k"] + 1.0 / (HIDDEN_TRUTH["c"] * s ** HIDDEN_TRUTH["alpha"])
    )
    exact = (material + HIDDEN_TRUTH["inertia.m"] * s**2) * np.exp(
        -HIDDEN_TRUTH["time-delay.tau"] * s
    )
    rng = np.random.default_rng(SWEEP.seed)
    scatter = rng.normal(size=len(s)) + 1j * rng.normal(size=len(s))
    # Two parts share the scatter: each has NOISE / sqrt(2), so that the whole has NOISE.
    return Measurement(
        2.0 * np.pi * SWEEP.hertz,
        exact * (1.0 + SWEEP.noise * scatter / np.sqrt(2.0)),
        units=Units("kN/m", "mm"),
        name=HIDDEN,
        provenance={
            "source": f"computed, never measured; noise of {100 * SWEEP.noise:g} %,"
            f" seed {SWEEP.seed}"
        },
    )


def _hidden_sets() -> list[DataSet]:
    """One set."""
    return [
        DataSet(
            HIDDEN,
            "computed: a fractional Maxwell damper on a rig with a moving mass and a time delay, 1"
            " % noise",
            hidden,
            kind="artificial",
            licence="none needed",
            citation="computed here; elements as in the paper, eq. (21)",
            size=len(SWEEP.hertz),
            truth=dict(HIDDEN_TRUTH),
            model="fractional-maxwell + inertia + time-delay",
            physics=("a moving mass of 0.6 kg", "the force is read 0.4 ms late"),
        )
    ]


_PAPER = "Parameters identification of fractional models of viscoelastic dampers and fluids"
_MAKRIS = "Makris (1992), PhD dissertation, State University of New York at Buffalo, eq. (54)"
DAMPER_HZ = np.linspace(1.0, 50.0, 50)
"""Our grid: Figures 7 to 10 reach about 50 Hz."""
MAKRIS = {"c0": 15.0, "tau": 0.3 ** (1.0 / 0.6), "ratio": 0.6, "q": 1.0}
"""C0 = 15 kN s/m, lambda = 0.3 s^0.6, r = 0.6, q = 1."""
TABLE_3 = {
    "kelvin": ("fractional-kelvin", {"k": 23.098, "c": 23.098, "alpha": 0.5110}),
    "maxwell": ("fractional-maxwell", {"k": 1402.79, "c": 20.663, "alpha": 0.5822}),
    "kelvin4": ("fractional-kelvin4", {"k1": 1196.2, "k2": 0.5337, "c": 19.022, "alpha": 0.6049}),
    "zener": ("fractional-zener", {"k1": 0.04804, "k2": 1364.19, "c": 20.402, "alpha": 0.5856}),
}
TABLE_4 = {
    "maxwell": ("fractional-maxwell", {"k": 85931.0, "c": 2060.9, "alpha": 0.7500}),
    "standard": ("fractional-kelvin4", {"k1": 92931.0, "k2": 0.0, "c": 2129.4, "alpha": 0.7369}),
    "zener": ("fractional-zener", {"k1": 0.0, "k2": 88898.4, "c": 2067.8, "alpha": 0.7301}),
}
TABLE_5 = {
    "0.1mrad-maxwell": ("fractional-maxwell", {"k": 80614.7, "c": 2038.84, "alpha": 0.7544}),
    "1mrad-maxwell": ("fractional-maxwell", {"k": 87876.0, "c": 2095.16, "alpha": 0.7470}),
    "10mrad-maxwell": ("fractional-maxwell", {"k": 85931.0, "c": 2060.90, "alpha": 0.7500}),
    "0.1mrad-standard": (
        "fractional-kelvin4",
        {"k1": 80362.8, "k2": 168.4, "c": 1999.2, "alpha": 0.7595},
    ),
    "1mrad-standard": (
        "fractional-kelvin4",
        {"k1": 96591.5, "k2": 187.4, "c": 2172.0, "alpha": 0.7325},
    ),
    "10mrad-standard": (
        "fractional-kelvin4",
        {"k1": 92931.0, "k2": 0.0, "c": 2129.4, "alpha": 0.7369},
    ),
}
TABLE_6 = (
    (63.0, 80614.7, 2038.8, 0.7544),
    (50.0, 75925.2, 1992.2, 0.7676),
    (43.0, 68786.9, 1941.9, 0.8009),
    (28.0, 60248.8, 1885.1, 0.8033),
    (20.0, 52960.2, 1843.2, 0.8229),
    (10.0, 40452.7, 1793.3, 0.8602),
    (5.0, 30474.4, 1781.8, 0.8937),
)
"""Highest frequency in Hz, E in Pa, eta in Pa s^alpha, alpha."""
_MODELS = {model.base: model for model in (*paper.MODELS, *paper.FLUIDS)}


def fluid_hz(highest: float) -> Real:
    """Our grid of 30 frequencies, evenly spaced in the logarithm, from 0.3 Hz to `highest`."""
    return np.geomspace(0.3, highest, 30)


def _computed(
    name: str, model: str, truth: dict[str, float], hertz: Real, unit: str, source: str
) -> Measurement:
    omega = 2.0 * np.pi * hertz
    known = _MODELS[model]
    # A branch of zero stiffness is what Table 4 prints; 1/0 is the limit that is wanted.
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = known.stiffness(known.vector(truth), omega)
    origin = {
        "source": f"reconstruction from {source}, not measured",
        "model": model,
        "grid": "chosen by us",
    }
    # A stiffness moves by a length, a modulus by a strain.
    moved = "-"
    if "m" in unit:
        moved = "mm"
    return Measurement(omega, stiffness, units=Units(unit, moved), name=name, provenance=origin)


def _reconstruction(
    name: str, model: str, truth: dict[str, float], hertz: Real, unit: str, source: str
) -> DataSet:
    name = f"reconstruction-{name}"
    return DataSet(
        name,
        f"computed from {model} with the parameters of {source} at frequencies of our choice; not"
        " measured",
        partial(_computed, name, model, truth, hertz, unit, source),
        kind="reconstruction",
        licence="none needed",
        citation=f"{source}; {_PAPER}",
        size=len(hertz),
        truth=dict(truth),
        model=model,
        stiffness_scale=None,
    )


def _reconstructions() -> list[DataSet]:
    """The damper of Makris and the silicone fluid, from every row of Tables 3 to 6."""
    sets = [_reconstruction("makris-1992", "makris", MAKRIS, DAMPER_HZ, "kN/m", _MAKRIS)]
    sets += [
        _reconstruction(f"makris-table3-{key}", model, truth, DAMPER_HZ, "kN/m", "Table 3")
        for key, (model, truth) in TABLE_3.items()
    ]
    for number, table in ((4, TABLE_4), (5, TABLE_5)):
        sets += [
            _reconstruction(
                f"pdms-table{number}-{key}", model, truth, fluid_hz(63.0), "Pa", f"Table {number}"
            )
            for key, (model, truth) in table.items()
        ]
    for row, (highest, modulus, eta, alpha) in enumerate(TABLE_6, 1):
        truth = {"k": modulus, "c": eta, "alpha": alpha}
        name, source = f"pdms-table6-{row}", f"Table 6, row {row}"
        sets.append(
            _reconstruction(name, "fractional-maxwell", truth, fluid_hz(highest), "Pa", source)
        )
    return sets


def computed_sets() -> list[DataSet]:
    """Those of section 5.1, the one with something hidden, and reconstructions."""
    return [*_artificial_sets(), *_hidden_sets(), *_reconstructions()]


NAME = "nist-srm2491"
NIST_CITATION = (
    "Schultheisz, Flynn, Leigh: NIST Special Publication 260-147, Table 9; 10.6028/NIST.SP.260-147"
)
_COLUMNS = ("omega [rad/s]", "storage [Pa]", "loss [Pa]", "storage_sd [Pa]", "loss_sd [Pa]")
DOI = "10.6028/NIST.SP.260-147"


def _fluid() -> Measurement:
    # By the package, which may be installed as a zip file.
    text = files(__package__).joinpath(f"{NAME}.csv").read_text(encoding="utf-8")
    return replace(parse(text, NAME), name=NAME)


def _of_nist() -> list[DataSet]:
    """One set of six temperatures, 0 to 50 degC, at 16 frequencies each."""
    return [
        DataSet(
            NAME,
            "polydimethylsiloxane melt, 6 temperatures, 0 to 50 degC, 0.1 to 100 rad/s, with"
            " standard uncertainties",
            _fluid,
            licence="public domain (US government work)",
            citation=NIST_CITATION,
            doi=DOI,
            origin="doi.org/10.6028/NIST.SP.260-147",
            test=(
                "small-strain oscillatory shear of a certified reference fluid, 16 frequencies at"
                " each temperature"
            ),
            columns=(*_COLUMNS, "temperature [degC]"),
            fit=(
                "WLF: ln a = -C1 (T - T_R) / (C2 + T - T_R), C1 = 6.64, C2 = 299.4 K, T_R = 25"
                " degC; vertical shift"
            ),
            aliases=("nist-srm2491-pdms",),
            size=96,
            physics=(
                "entangled melt in its terminal zone: a viscous limit at low frequency",
                (
                    "thermorheologically simple: WLF with C1 = 6.64 (natural logarithm), C2 = 299.4"
                    " K at 25 degC (NIST)"
                ),
                "a small vertical shift with density",
            ),
        )
    ]


INSTALL = "install it with: pip install 'springpot[data]' (or pip install rheopy-rheodata)"
_FREQUENCY = "caggioni_linear_polymer_frequency_sweep"
_AMPLITUDE = "caggioni_linear_polymer_amplitude_sweep"


def _folder() -> Path | None:
    spec = find_spec("rheodata")
    if spec is None or not spec.submodule_search_locations:
        # Not installed, or another module of that name that is no package.
        return None
    return Path(spec.submodule_search_locations[0]) / "datasets"


def _columns(identifier: str) -> dict[str, Real]:
    folder = _folder()
    if folder is None:
        raise DataError(f"data set '{_name(identifier)}' needs rheopy-rheodata: {INSTALL}")
    try:
        with (folder / identifier / "data.csv").open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        return {
            key: np.array([float(row[key]) for row in rows])
            for key in rows[0]
            if key != "sample_id"
        }
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise DataError(
            f"data set '{_name(identifier)}': rheopy-rheodata has changed its file: {error}"
        ) from None


def _of_package(identifier: str) -> Measurement:
    columns = _columns(identifier)
    n = len(columns["Gp_Pa"])
    # The amplitude sweep was made at 1 rad/s, the frequency sweep at 0.5 % strain (dataset.yaml of
    # the package).
    omega, strain = np.ones(n), np.full(n, 0.5)
    if identifier == _AMPLITUDE:
        strain = columns["strain_pct"]
    else:
        omega = columns["omega_rad/s"]
    return Measurement(
        omega,
        columns["Gp_Pa"] + 1j * columns["Gpp_Pa"],
        conditions={"temperature": np.full(n, 25.0), "amplitude": strain},
        units=Units("Pa", "%", "rad/s", "G"),
        name=_name(identifier),
        provenance={"source": "PyPI package rheopy-rheodata", "set": identifier, "licence": "MIT"},
    )


def _name(identifier: str) -> str:
    return f"rheodata-{identifier.removeprefix('caggioni_').replace('_', '-')}"


def _of_rheodata() -> list[DataSet]:
    """The frequency sweep and the amplitude sweep.

    Listed as unavailable where the package is absent.
    """
    fluid = "high-molecular-weight linear polymer in water, 25 degC"
    sets = (
        (_FREQUENCY, f"{fluid}, 0.1 to 100 rad/s at 0.5 % strain", 31, ("linear range",)),
        (
            _AMPLITUDE,
            f"{fluid}, 0.1 to 1000 % strain at 1 rad/s",
            41,
            ("linear up to about 10 % strain",),
        ),
    )
    missing = ""
    if not find_spec("rheodata"):
        missing = f"rheopy-rheodata is not installed; {INSTALL}"
    return [
        DataSet(
            _name(identifier),
            summary,
            partial(_of_package, identifier),
            licence="MIT",
            citation="Caggioni, community contribution to rheopy-rheodata 0.1.1",
            size=size,
            physics=physics,
            unavailable=missing,
        )
        for identifier, summary, size, physics in sets
    ]


def measured_sets() -> list[DataSet]:
    """The silicone fluid, and those of rheopy-rheodata where it is installed."""
    return [*_of_nist(), *_of_rheodata()]
