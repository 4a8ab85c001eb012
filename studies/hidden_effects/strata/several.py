"""The strata of several effects at once, each of which is plain to see beside the others."""

from __future__ import annotations

import numpy as np

from hidden_effects.cases import hide_in
from hidden_effects.scaling import NotVisible
from hidden_effects.setup import deviation, draw_base, draw_noise, draw_sweep
from hidden_effects.strata.drawn import Drawn, log_uniform, white

PLAIN = 120.0
"""Chi-square left without one of the effects, all else refitted, from which goals ask its name."""
MOST = 10000.0
"""Chi-square that the bare base leaves at most: what an eye sees from afar."""
KINDS = {2: "two", 3: "three"}


def two(seed: int, rng: np.random.Generator) -> Drawn:
    """Two effects are hidden; sweeps and fields take turns."""
    return _several(seed, rng, 2)


def three(seed: int, rng: np.random.Generator) -> Drawn:
    """Three effects are hidden; sweeps and fields take turns."""
    return _several(seed, rng, 3)


def _several(seed: int, rng: np.random.Generator, count: int) -> Drawn:
    design = ("sweep", "field")[seed % 2]
    sweep = draw_sweep(rng, design, 1, strain=False)
    network, theta = draw_base(rng, sweep)
    noise = draw_noise(rng, sweep, network.stiffness(sweep, theta))
    target = log_uniform(rng, count * PLAIN, MOST)
    truth = hide_in(rng, sweep, network, theta, noise, target, count)
    if min(hidden.chi2 for hidden in truth.hidden) < PLAIN:
        raise NotVisible
    k = truth.stiffness
    sigma = deviation(noise, sweep, k)
    return Drawn(
        seed=seed,
        stratum=KINDS[count],
        detail=design,
        kind=KINDS[count],
        model=truth.model,
        sweep=sweep,
        K=k + sigma * white(rng, k.size),
        K_true=k,
        floor=float(np.sqrt(np.mean(2.0 * sigma**2 / np.abs(k) ** 2))),
        right=tuple(hidden.name for hidden in truth.hidden),
        chi2=truth.chi2,
        own=tuple(hidden.chi2 for hidden in truth.hidden),
        parameters=noise,
        sd=sigma if rng.random() < 0.5 else None,
    )
