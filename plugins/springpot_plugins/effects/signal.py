"""Effects of the measurement chain.

They multiply the stiffness, disturb the force or misread the clock.
"""

from __future__ import annotations

from math import inf

from springpot.rheology import (
    Effect,
    Layer,
    chain,
    clock,
    crosstalk_force,
    delay,
    filter_mismatch,
    force_resonance,
    gain,
    parallel,
    phase,
    shift,
)

EFFECTS = (
    Effect(
        "time-delay",
        chain,
        delay("tau"),
        "force and displacement are sampled at different instants: a phase error that grows as"
        " omega",
        Layer.SIGNAL,
        "exp(-s tau), elementary",
        equation="K * exp(-s * tau)",
    ),
    Effect(
        "phase-error",
        chain,
        phase("phi"),
        "the phase is wrong by the same angle at all frequencies, which no causal material does",
        Layer.SIGNAL,
        "exp(i phi), elementary",
        equation="K * exp(i * phi)",
    ),
    Effect(
        "gain-error",
        chain,
        gain("g"),
        "calibration, area or gap is wrong: everything is too large or too small by one fraction",
        Layer.SIGNAL,
        "1 + g, elementary",
        ("area-error", "calibration-error"),
        equation="K * (1 + g)",
    ),
    Effect(
        "filter-mismatch",
        chain,
        filter_mismatch("tau"),
        "one channel has a low-pass filter that the other lacks: phase error as omega, gain error"
        " as its square",
        Layer.SIGNAL,
        "1 / (1 + s tau), elementary",
        prior=0.3,
        equation="K / (1 + s * tau) if tau > 0 else K * (1 - s * tau)",
    ),
    Effect(
        "fixture-resonance",
        chain,
        force_resonance("omega_r"),
        "the force channel has a resonance at a fixed frequency: gain error growing as omega"
        " squared",
        Layer.SIGNAL,
        "Ewins, Modal Testing, 2000",
        ("transducer-resonance",),
        # A resonance far above all frequencies changes nothing.
        absent_at=inf,
        prior=0.3,
        equation="K / (1 - r^2 + 2 * i * zeta * r), r = omega / omega_r",
    ),
    Effect(
        "crosstalk",
        parallel,
        crosstalk_force("F", "phi"),
        "the drive leaks into the force signal: a fixed force of fixed phase, the larger the"
        " smaller the amplitude",
        Layer.SIGNAL,
        "F exp(i phi) / X, elementary",
        prior=0.3,
        equation="K + F * exp(i * phi) / X",
    ),
    Effect(
        "frequency-error",
        shift,
        clock("e"),
        "the clock is wrong: all frequencies by one fraction",
        Layer.SIGNAL,
        "ln(1 + e), elementary",
        ("clock-error",),
        prior=0.3,
        equation="K(omega * (1 + e))",
    ),
)
