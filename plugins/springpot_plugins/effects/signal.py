"""Effects of the measurement chain.

They multiply the stiffness, disturb the force or misread the clock.
"""

from __future__ import annotations

from math import inf, pi

from springpot.rheology import (
    PURE,
    RADIAN_PER_SECOND,
    Dimension,
    Effect,
    Layer,
    Parameter,
    chain,
    crosstalk_force,
    delay,
    filter_mismatch,
    gain,
    parallel,
)

RADIAN = Dimension(label="rad")
RESONANCE = Parameter("omega_r", "ω_r", RADIAN_PER_SECOND, typical=100.0)
DAMPING_RATIO = Parameter("zeta", "ζ", lower=1e-4, upper=1.0, scale="linear", typical=0.05)

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
    Effect.from_formula(
        "phase-error",
        "chain: exp(i * phi)",
        "the phase is wrong by the same angle at all frequencies, which no causal material does",
        (Parameter("phi", "φ", RADIAN, -0.5 * pi, 0.5 * pi, "linear", 0.0),),
        "phase",
        layer=Layer.SIGNAL,
        citation="exp(i phi), elementary",
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
    Effect.from_formula(
        "fixture-resonance",
        "chain: 1 / (1 - (omega / omega_r)^2 + 2 * i * zeta * omega / omega_r)",
        "the force channel has a resonance at a fixed frequency: gain error growing as omega"
        " squared",
        (RESONANCE, DAMPING_RATIO),
        "resonance",
        layer=Layer.SIGNAL,
        citation="Ewins, Modal Testing, 2000",
        aliases=("transducer-resonance",),
        # A resonance far above all frequencies changes nothing.
        absent_at=inf,
        prior=0.3,
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
    Effect.from_formula(
        "frequency-error",
        "shift: 1 + e",
        "the clock is wrong: all frequencies by one fraction",
        (Parameter("e", "e", PURE, -0.9, scale="linear", typical=0.1),),
        "clock",
        layer=Layer.SIGNAL,
        citation="ln(1 + e), elementary",
        aliases=("clock-error",),
        prior=0.3,
    ),
)
