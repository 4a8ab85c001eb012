"""Artificial data with something hidden in them, for demonstrations.

The material is simple, the test rig is not.
"""

from __future__ import annotations

import numpy as np

from springpot.measurement import DataSet, Measurement, Units

NAME = "artificial-hidden"
SEED = 7
NOISE = 0.01
FREQUENCIES = np.geomspace(0.5, 100.0, 40)
"""In Hz."""
TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5, "inertia.m": 6e-4, "time-delay.tau": 4e-4}
"""kN/m, kN s^alpha/m, -, tonnes (0.6 kg), s."""


def hidden() -> Measurement:
    """A fractional Maxwell damper between plates with a mass, its force read late, noise of 1 %."""
    s = 2j * np.pi * FREQUENCIES
    material = 1.0 / (1.0 / TRUTH["k"] + 1.0 / (TRUTH["c"] * s ** TRUTH["alpha"]))
    exact = (material + TRUTH["inertia.m"] * s**2) * np.exp(-TRUTH["time-delay.tau"] * s)
    rng = np.random.default_rng(SEED)
    scatter = rng.normal(size=len(s)) + 1j * rng.normal(size=len(s))
    # Two parts share the scatter: each has NOISE / sqrt(2), so that the whole has NOISE.
    return Measurement(
        2.0 * np.pi * FREQUENCIES,
        exact * (1.0 + NOISE * scatter / np.sqrt(2.0)),
        units=Units("kN/m", "mm"),
        name=NAME,
        provenance={"source": f"computed, never measured; noise of {100 * NOISE:g} %, seed {SEED}"},
    )


def datasets() -> list[DataSet]:
    """One set."""
    return [
        DataSet(
            NAME,
            "computed: a fractional Maxwell damper on a rig with a moving mass and a time delay, 1"
            " % noise",
            hidden,
            kind="artificial",
            licence="none needed",
            citation="computed here; elements as in the paper, eq. (21)",
            size=len(FREQUENCIES),
            truth=dict(TRUTH),
            model="fractional-maxwell + inertia + time-delay",
            physics=("a moving mass of 0.6 kg", "the force is read 0.4 ms late"),
        )
    ]
