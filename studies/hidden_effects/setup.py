"""Where and how a case is measured: frequencies, conditions, base model and noise."""

from __future__ import annotations

import numpy as np

from hidden_effects.bases import BASE_WEIGHTS, BASES, LAWS, Base, Complex, Law, Real, Sweep
from hidden_effects.fit import Network


def _frequencies(rng: np.random.Generator, design: str) -> Real:
    """Frequencies in rad/s between 0.01 and 200 Hz."""
    if design == "field":
        decades, count = rng.uniform(1.5, 3.0), int(rng.integers(10, 21))
    else:
        decades, count = rng.uniform(2.0, 4.0), int(rng.integers(20, 81))
    first = 10.0 ** rng.uniform(-2.0, np.log10(200.0) - decades)
    if design == "sweep" and rng.random() < 0.2:
        grid = np.linspace(first, first * 100.0, count)
    else:
        grid = np.geomspace(first, first * 10.0**decades, count)
    return 2.0 * np.pi * grid


def draw_sweep(rng: np.random.Generator, design: str, repeats: int, strain: bool) -> Sweep:
    """Rows in measuring order.

    Temperature by temperature, amplitude by amplitude, repeat by repeat.
    """
    omega = _frequencies(rng, design)
    omega = omega[::-1] if rng.random() < 0.2 else omega
    top = 10.0 ** (rng.uniform(-2.5, -1.0) if strain else rng.uniform(-1.0, 1.3))
    if design == "field":
        amplitudes = np.geomspace(top / rng.uniform(4.0, 30.0), top, int(rng.integers(3, 5)))
        count, span = int(rng.integers(3, 5)), rng.uniform(20.0, 60.0)
        temperatures = np.round(rng.uniform(-10.0, 30.0) + np.linspace(0.0, span, count), 1)
    else:
        amplitudes, temperatures = np.array([top]), np.array([20.0])
    t, x, n, w = (
        g.ravel()
        for g in np.meshgrid(
            temperatures, amplitudes, np.arange(1, repeats + 1), omega, indexing="ij"
        )
    )
    with_amplitude = design == "field" or rng.random() < 0.4
    return Sweep(
        w,
        t if design == "field" else None,
        x if with_amplitude else None,
        n if repeats > 1 else None,
    )


def _law(rng: np.random.Generator) -> tuple[Law, Real]:
    if rng.random() < 0.5:
        return LAWS["arrhenius-shift"], np.array([rng.uniform(15e3, 110e3)])
    return LAWS["wlf-shift"], np.array([rng.uniform(3.0, 12.0), rng.uniform(80.0, 200.0)])


def draw_base(
    rng: np.random.Generator, sweep: Sweep, wanted: str | Base | None = None
) -> tuple[Network, Real]:
    """A base that relaxes inside the reduced window, with a law where there are temperatures."""
    weights = np.array(list(BASE_WEIGHTS.values()))
    if isinstance(wanted, Base):
        base = wanted
    else:
        base = BASES[wanted or str(rng.choice(list(BASE_WEIGHTS), p=weights / weights.sum()))]
    law, own = _law(rng) if sweep.temperature is not None else (None, np.zeros(0))
    reference = (
        float(np.round(np.median(sweep.temperature), 1)) if sweep.temperature is not None else 20.0
    )
    network = Network(base, law, reference=reference)
    window = network.reduced(sweep, np.concatenate([np.ones(len(base.parameters)), own]))
    low, high = np.log(window.min()), np.log(window.max())
    k = 10.0 ** rng.uniform(2.0, 6.0)

    def tau() -> float:
        return float(np.exp(-rng.uniform(low + 0.2 * (high - low), high - 0.2 * (high - low))))

    return network, np.concatenate([base.draw(rng, k, tau), own])


def draw_noise(rng: np.random.Generator, sweep: Sweep, k: Complex) -> dict[str, float]:
    """0.1-3 % of |K| per part, in three of ten cases with an absolute floor sigma_F / X on top."""
    relative = float(10.0 ** rng.uniform(-3.0, np.log10(0.03)))
    share = float(rng.uniform(0.5, 3.0)) if rng.random() < 0.3 else 0.0
    return {
        "relative": relative,
        "force": share * relative * float(np.min(np.abs(k) * _lever(sweep))),
    }


def deviation(noise: dict[str, float], sweep: Sweep, k: Complex) -> Real:
    """Return the standard deviation of each part of K."""
    return np.hypot(noise["relative"] * np.abs(k), noise["force"] / _lever(sweep))


def _lever(sweep: Sweep) -> Real:
    return np.ones(len(sweep)) if sweep.amplitude is None else sweep.amplitude
