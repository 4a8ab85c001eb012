"""Data with a law that has no name, from formulas of their own: nothing of springpot is used here.

Each family is a plane, a function of frequency, amplitude and a free column, and the texts under
which a class may name it. Families of `OUTSIDE` are no law of the grammar.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Values = dict[str, float]
Law = Callable[[Values, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Family:
    """One kind of law.

    Parameters
    ----------
    name : str
        In tables.
    plane : str
        ``parallel`` adds to K, ``series`` to 1/K, ``chain`` multiplies K,
        and ``exponent`` by its exponential.
    law : callable
        Of values, omega, amplitude and column: what it adds, of any size; of a chain the change of
        the factor.
    values : dict of str to (float, float)
        Parameters and the range that each is drawn of; ``Xc`` in shares of the range of what it is
        a place of, in logarithms.
    texts : tuple of str
        Formulas that are this law, in the words of springpot; its exponents have the names that
        they have here.
    column : bool
        Whether the column ``P`` was varied in the place of the amplitude.
    """

    name: str
    plane: str
    law: Law
    values: dict[str, tuple[float, float]]
    texts: tuple[str, ...] = ()
    column: bool = False

    def draw(self, rng: np.random.Generator, x: np.ndarray) -> Values:
        """Parameters, places in the range of a condition."""
        values = {name: float(rng.uniform(*ends)) for name, ends in self.values.items()}
        if "Xc" in values:
            low, high = np.log(x.min()), np.log(x.max())
            values["Xc"] = float(np.exp(low + values["Xc"] * (high - low)))
        return values


POWER = {"n": (0.4, 1.6)}
PLACE = {"Xc": (0.3, 0.7)}
SATURATION = PLACE | {"n": (1.0, 2.0)}


def _fallen(v: Values, x: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + (x / v["Xc"]) ** v["n"])


INSIDE = (
    Family(
        "loss X^-n",
        "parallel",
        lambda v, w, x, p: 1j * x ** -v["n"],
        POWER,
        ("parallel: i*k*X^(-n)",),
    ),
    Family(
        "stiffening X^n", "parallel", lambda v, w, x, p: x ** v["n"], POWER, ("parallel: k*X^n",)
    ),
    Family(
        "softening X^n", "parallel", lambda v, w, x, p: -(x ** v["n"]), POWER, ("parallel: -k*X^n",)
    ),
    Family(
        "drag X^n",
        "parallel",
        lambda v, w, x, p: 1j * w * x ** v["n"],
        POWER,
        ("parallel: c*i*omega*X^n",),
    ),
    Family(
        "springpot X^-n",
        "parallel",
        lambda v, w, x, p: (1j * w) ** v["a"] * x ** -v["n"],
        POWER | {"a": (0.3, 0.7)},
        ("parallel: c*(i*omega)^a*X^(-n)",),
    ),
    Family(
        "loss omega^a X^n",
        "parallel",
        lambda v, w, x, p: 1j * w ** v["a"] * x ** v["n"],
        POWER | {"a": (0.3, 1.6)},
        ("parallel: i*c*omega^a*X^n",),
    ),
    Family(
        "saturation",
        "parallel",
        lambda v, w, x, p: _fallen(v, x),
        SATURATION,
        ("parallel: k/(1 + (X/Xc)^n)", "parallel: -k*(X/Xc)^n/(1 + (X/Xc)^n)"),
    ),
    Family(
        "fade",
        "parallel",
        lambda v, w, x, p: np.exp(-x / v["Xc"]),
        PLACE,
        ("parallel: k*exp(-X/Xc)",),
    ),
    Family(
        "threshold",
        "parallel",
        lambda v, w, x, p: 1j * np.maximum(0.0, 1.0 - v["Xc"] / x) ** v["n"],
        PLACE | {"n": (0.7, 1.6)},
        ("parallel: i*k*max(0, 1 - Xc/X)^n",),
    ),
    Family(
        "mount X^n",
        "series",
        lambda v, w, x, p: (x ** v["n"]).astype(complex),
        POWER,
        ("series: X^n/k",),
    ),
    Family(
        "slip X^n",
        "series",
        lambda v, w, x, p: x ** v["n"] / (1j * w),
        POWER,
        ("series: X^n/(c*i*omega)",),
    ),
    Family(
        "gain X^n",
        "chain",
        lambda v, w, x, p: (-(x ** v["n"])).astype(complex),
        POWER,
        ("chain: 1 + b*(X^n)",),
    ),
    Family(
        "delay X^n",
        "exponent",
        lambda v, w, x, p: -1j * w * x ** v["n"],
        POWER,
        ("chain: exp(-i*omega*tau*(X^n))",),
    ),
    Family(
        "loss P^n",
        "parallel",
        lambda v, w, x, p: 1j * p ** v["n"],
        POWER,
        ("parallel: i*k*P^n",),
        column=True,
    ),
    Family(
        "loss, P saturates",
        "parallel",
        lambda v, w, x, p: 1j * (1.0 - _fallen(v, p)),
        SATURATION,
        ("parallel: i*k*(P/Xc)^n/(1 + (P/Xc)^n)", "parallel: i*k/(1 + (P/Xc)^n)"),
        column=True,
    ),
    Family(
        "two terms",
        "parallel",
        lambda v, w, x, p: 1j * (x / x.max()) ** -v["n2"] + 6.0 * (x / x.max()) ** v["n"],
        POWER | {"n2": (0.7, 0.9)},
        ("parallel: k*X^n + i*k*r*X^(-n2)", "parallel: i*k*X^(-n) + k*r*X^n2"),
    ),
)
OUTSIDE = (
    Family(
        "waves in X",
        "parallel",
        lambda v, w, x, p: np.cos(v["q"] * np.log(x)) + 0j,
        {"q": (4.0, 7.0)},
    ),
    Family(
        "hump in X",
        "parallel",
        lambda v, w, x, p: 1j * np.exp(-8.0 * np.log(x / np.median(x)) ** 2),
        {},
    ),
    Family(
        "resonance that moves with X",
        "parallel",
        lambda v, w, x, p: 1.0 / (1.0 + 0.1j - (w * x**0.2 / np.median(w)) ** 2),
        {},
    ),
    Family(
        "steps in omega",
        "chain",
        lambda v, w, x, p: np.where(np.sin(v["q"] * np.log(w)) > 0, 1.0, -1.0) + 0j,
        {"q": (3.0, 5.0)},
    ),
)
"""What no formula of the grammar is."""


def material(rng: np.random.Generator, omega: np.ndarray) -> np.ndarray:
    """A spring and a fractional Maxwell element: K of a linear passive material."""
    k, alpha = rng.uniform(200.0, 600.0), rng.uniform(0.4, 0.7)
    c = 0.15 * k * np.median(omega) ** -alpha * rng.uniform(0.5, 2.0)
    s = (1j * omega) ** alpha
    return rng.uniform(0.0, 0.3) * k + k * c * s / (k + c * s)


def grid(rng: np.random.Generator, column: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Omega, amplitude and column of 100 points: 10 frequencies at 10 levels."""
    omega = np.tile(2.0 * np.pi * np.geomspace(0.3, 30.0, 10), 10)
    levels = np.repeat(np.geomspace(1.0, rng.uniform(20.0, 60.0), 10), 10)
    one = np.ones(100)
    return (omega, one, levels) if column else (omega, 0.1 * levels, one)


def with_law(family: Family, k: np.ndarray, law: np.ndarray, share: float) -> np.ndarray:
    """K with a law that changes it by this share, root mean square."""
    if family.plane == "series":
        base = 1.0 / k
    else:
        base = k if family.plane == "parallel" else np.ones_like(k)
    size: float = share / np.sqrt(np.mean(np.abs(law / base) ** 2))
    whole = base + size * law
    if family.plane == "exponent":
        return k * np.exp(size * law)
    if family.plane == "parallel":
        return whole
    return 1.0 / whole if family.plane == "series" else k * whole
