"""Effects of the instrument: its compliance adds to that of the model, its chain distorts signals.

What the chain does multiplies the stiffness, disturbs the force or misreads the clock.
"""

from __future__ import annotations

from math import inf, pi

from springpot.rheology import (
    AMPLITUDE,
    PURE,
    RADIAN_PER_SECOND,
    Dimension,
    Effect,
    InstrumentConstant,
    Layer,
    Parameter,
    balanced_series,
    chain,
    crosstalk_force,
    dashpot,
    delay,
    filter_mismatch,
    gain,
    parallel,
    relaxation_time,
    series,
    slip_film,
    spring,
    springpot,
    stiffness,
)

RADIAN = Dimension(label="rad")
RESONANCE = Parameter("omega_r", "ω_r", RADIAN_PER_SECOND, typical=100.0)
DAMPING_RATIO = Parameter("zeta", "ζ", lower=1e-4, upper=1.0, scale="linear", typical=0.05)

SIGNALS = (
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


STRUCTURAL_DAMPING = Parameter("zeta", "ζ", lower=1e-4, upper=0.3, scale="linear", typical=0.05)
"""Of steel frames and their joints, even on rubber mounts.

Above, it would be no resonance but a mode.
"""
BALANCE = "first harmonics are balanced; higher ones of the force do not move the model"

IN_SERIES = (
    Effect(
        "series-spring",
        series,
        spring("k"),
        "mounting, tool or transducer give way elastically: the measured stiffness saturates, most"
        " where it is large",
        Layer.MOUNTING,
        "Liu et al. 2011, Rheologica Acta 50, 537",
        ("mounting-compliance", "instrument-compliance"),
        equation="1 / (1 / K + 1 / k)",
        constant=InstrumentConstant(
            "compliance as modulus",
            "k",
            "an instrument compliance that is a spring of {stated} in series",
        ),
    ),
    Effect.from_formula(
        "frame-resonance",
        "series: 1 / (k * (1 - (omega / omega_r)^2 + 2 * i * zeta * (omega / omega_r)))",
        "the frame gives way with a resonance of its own at a fixed frequency",
        (stiffness(), RESONANCE, STRUCTURAL_DAMPING),
        "frame",
        layer=Layer.MOUNTING,
        citation="Ewins, Modal Testing, 2000",
        # Its peak can imitate whatever is narrow in a sweep: it competes where no common effect
        # explains the data.
        narrow=True,
    ),
    Effect(
        "series-dashpot",
        series,
        dashpot("c"),
        "the specimen slips or flows as a whole: stiffness is lost towards low frequency",
        citation="Yoshimura and Prud'homme 1988, J. Rheol. 32, 53",
        aliases=("slip", "wall-slip", "flow"),
        equation="1 / (1 / K + 1 / (c * s))",
    ),
    Effect.from_formula(
        "hardening-mount",
        "series: 1 / (k * (1 + (Y / Xh)^2))",
        "a mount in series that stiffens as it is moved further: the specimen gets more of a large"
        " displacement",
        (stiffness(), Parameter("Xh", "X_h", AMPLITUDE)),
        "hardening spring",
        layer=Layer.MOUNTING,
        citation="Nayfeh and Mook, Nonlinear Oscillations, 1979",
        aliases=("hardening-series-spring",),
        prior=0.3,
        only_varied=True,
    ),
    Effect(
        "power-law-slip",
        balanced_series,
        slip_film("F", "a"),
        "the whole specimen yields, or slips on its plates: it flows the faster the larger the"
        " stress, and stiffness is lost at large amplitude",
        citation="Hatzikiriakos and Dealy 1991, J. Rheol. 35, 497",
        aliases=("stress-slip", "nonlinear-slip", "yielding-as-a-whole"),
        approximate=BALANCE,
        prior=0.3,
        only_varied=True,
        equation=(
            "1 / (1 / K + 1 / S), S = i * F * g * omega^a * Y^(a - 1), Y = X * |K / (K + S)|, "
            "g = 2 / sqrt(pi) * gamma(1 + a / 2) / gamma((3 + a) / 2)"
        ),
    ),
    Effect(
        "series-springpot",
        series,
        springpot("c", "alpha"),
        "a further broad creep in series: the compliance grows as a power of 1/omega",
        citation="Schiessel et al. 1995, doi:10.1088/0305-4470/28/23/012",
        equation="1 / (1 / K + 1 / (c * s^alpha))",
    ),
    Effect.from_formula(
        "retardation-mode",
        "series: 1 / (k * (1 + s * tau))",
        "one more retardation time: a step in storage compliance and a bump in loss compliance at"
        " omega = 1/tau",
        (stiffness(), relaxation_time()),
        "kelvin",
        citation="Ferry, Viscoelastic Properties of Polymers, 1980",
        aliases=("kelvin-unit",),
        prior=0.3,
    ),
)
