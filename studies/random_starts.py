"""Many random starts beside one identification, in the measure of the many.

    python studies/random_starts.py [--shared FOLDER] [--out results/random_starts]

Question: do 64 random starts find what one identification misses, and what do they cost? Measure:
the error of each fit in pyRheo's own measure, and its processor time. What would answer it: a fit
by random starts that is better by more than a thousandth.

pyRheo (Miranda-Valdez et al. 2025, DOI 10.1039/D5DD00021A) fits an oscillation by SciPy's Powell or
Nelder-Mead method from 64 random starts. It minimises the sum of squares of the relative
differences of G' and of G'', each by itself, here the objective `relative-each`. Its starts are
uniform between a thousandth of the least G'' and a thousand times the greatest G', exponents
between 0 and 1. The procedure is written anew here, models by their formulas, so that it needs no
package. FOLDER holds the measured sets; one that is not there is left out with a word.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

import springpot
from paper.asking import asking
from springpot.benchmark import Table, save_table
from springpot.errors import SpringpotError
from springpot.report.page import Entry

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared"
STARTS = 64
METHODS = ("Powell", "Nelder-Mead")
EXPONENT = (0.01, 0.99)
PASCAL = "?storage=Pa,loss=Pa"
POLYSTYRENE = "data/polystyrene-three-tests/oscillation_ps"
SETS = (
    ("polydimethylsiloxane, 20 degC", "nist-srm2491@temperature=20"),
    ("polystyrene, 130 degC", f"{POLYSTYRENE}130_data.csv{PASCAL}"),
    ("polystyrene, 190 degC", f"{POLYSTYRENE}190_data.csv{PASCAL}"),
    ("metal-coordinated network", f"unseen/epstein.csv{PASCAL}"),
    ("cellulose hydrogel", "data/instrument-files/rheocompass_saos.csv"),
    ("wormlike micelles", "data/mitmaps-saos/normalized.csv"),
)

Curve = Callable[[NDArray[np.complex128], NDArray[np.float64]], NDArray[np.complex128]]


def series(*parts: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The stiffness of elements in series."""
    return np.asarray(1.0 / sum(1.0 / part for part in parts))


FORMULAS: dict[str, tuple[str, Curve]] = {
    "maxwell": ("mm", lambda s, x: series(x[0] + 0 * s, x[1] * s)),
    "zener": ("mmm", lambda s, x: x[0] + series(x[1] + 0 * s, x[2] * s)),
    "fractional-maxwell": ("mme", lambda s, x: series(x[0] + 0 * s, x[1] * s ** x[2])),
    "fractional-maxwell-dashpot": ("mme", lambda s, x: series(x[0] * s, x[1] * s ** x[2])),
    "fractional-maxwell-general": (
        "meme",
        lambda s, x: series(x[0] * s ** x[1], x[2] * s ** x[3]),
    ),
    "fractional-kelvin": ("mme", lambda s, x: x[0] + x[1] * s ** x[2]),
    "fractional-kelvin-dashpot": ("mme", lambda s, x: x[0] * s + x[1] * s ** x[2]),
    "fractional-kelvin-general": ("meme", lambda s, x: x[0] * s ** x[1] + x[2] * s ** x[3]),
    "fractional-zener": ("mmme", lambda s, x: x[0] + series(x[1] + 0 * s, x[2] * s ** x[3])),
    "fractional-zener5": (
        "mmeme",
        lambda s, x: x[0] + series(x[1] * s ** x[2], x[3] * s ** x[4]),
    ),
}
"""Models of pyRheo by their names here: kinds of their parameters (a modulus, an exponent), K."""


class Ended(NamedTuple):
    """The least sum of squares and the processor time it took [s]."""

    squares: float
    seconds: float


def misfit(modulus: NDArray[np.complex128], data: springpot.Measurement) -> float:
    """Sum of the squares of the relative differences of G' and of G'', each over itself."""
    apart = modulus - data.stiffness
    return float(np.sum((apart.real / data.storage) ** 2 + (apart.imag / data.loss) ** 2))


def from_random_starts(
    data: springpot.Measurement, model: str, method: str, rng: np.random.Generator
) -> Ended:
    """The best of the random starts."""
    kinds, curve = FORMULAS[model]
    s = 1j * data.omega
    modulus = float(data.loss.min()) / 1000.0, float(data.storage.max()) * 1000.0
    bounds = [modulus if kind == "m" else EXPONENT for kind in kinds]
    low, high = np.transpose(bounds)
    began = time.process_time()
    with np.errstate(all="ignore"):
        found = [
            minimize(lambda x: misfit(curve(s, x), data), start, method=method, bounds=bounds).fun
            for start in rng.uniform(low, high, (STARTS, len(kinds)))
        ]
    return Ended(float(np.nanmin(found)), time.process_time() - began)


def identified(data: springpot.Measurement, model: str) -> Ended:
    """One identification in the same measure, without its judgement."""
    began = time.process_time()
    fit = springpot.identify(data, model, objective="relative-each")
    seconds = time.process_time() - began
    return Ended(misfit(fit.model.stiffness(fit.theta, data.points), data), seconds)


def opened(shared: Path) -> Iterator[tuple[str, springpot.Measurement]]:
    """The sets that can be opened here."""
    for title, name in SETS:
        where = name if name.startswith("nist") else str(shared / name)
        try:
            yield title, springpot.open_measurement(where)
        except SpringpotError as error:
            print(f"{title} left out: {error}")


def compared(data: springpot.Measurement, title: str) -> list[tuple[Entry, ...]]:
    """A row for each model: errors as root mean squares in per cent, and processor times."""
    rows: list[tuple[Entry, ...]] = []
    values = 2 * len(data.omega)
    for model in FORMULAS:
        one = identified(data, model)
        many = [
            from_random_starts(data, model, method, np.random.default_rng(64)) for method in METHODS
        ]
        errors = [100.0 * np.sqrt(each.squares / values) for each in (one, *many)]
        rows.append((title, model, *errors, *(each.seconds for each in (one, *many))))
        print(*rows[-1], flush=True)
    return rows


def table(rows: list[tuple[Entry, ...]]) -> Table:
    """All rows, with what they show in all."""
    errors = np.array([row[2:5] for row in rows], dtype=float)
    seconds = np.array([row[5:8] for row in rows], dtype=float)
    above = int(np.sum(errors[:, 0] > errors[:, 1:].min(1) * (1.0 + 1e-3)))
    better = errors[:, 1:].argmin(1)
    spared = np.choose(better, seconds[:, 1:].T) / seconds[:, 0]
    note = (
        f"Root mean square of the relative differences of G' and of G'', each by itself, and"
        f" processor time; {STARTS} random starts with each of the two methods, within pyRheo's"
        f" bounds, by formulas in NumPy. One identification is above the better of the two by more"
        f" than a thousandth in {above} of {len(rows)} fits, and takes {np.min(spared):.1f} to"
        f" {np.max(spared):.0f} times less processor time than that, {np.median(spared):.0f}"
        " times in the median."
    )
    columns = (
        *("set", "model", "springpot, rms error [%]"),
        *(f"{method}, rms error [%]" for method in METHODS),
        *(f"{who} [s]" for who in ("springpot", *METHODS)),
    )
    return Table("Random starts beside one identification", columns, rows, note)


def main() -> None:
    """Fit all models to all sets both ways."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--shared", type=Path, default=SHARED, help="folder of the measured sets")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "random_starts")
    options = parser.parse_args()
    rows = [row for title, data in opened(options.shared) for row in compared(data, title)]
    options.out.mkdir(parents=True, exist_ok=True)
    save_table(asking(__doc__, table(rows)), options.out, "random_starts")


if __name__ == "__main__":
    main()
