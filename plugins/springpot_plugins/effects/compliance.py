"""Effects in series: their compliance adds to that of the model."""

from __future__ import annotations

from springpot.rheology import (
    AMPLITUDE,
    Effect,
    InstrumentConstant,
    Layer,
    Parameter,
    balanced_series,
    dashpot,
    relaxation_time,
    series,
    slip_film,
    spring,
    springpot,
    stiffness,
)

from .signal import RESONANCE

STRUCTURAL_DAMPING = Parameter("zeta", "ζ", lower=1e-4, upper=0.3, scale="linear", typical=0.05)
"""Of steel frames and their joints, even on rubber mounts.

Above, it would be no resonance but a mode.
"""
BALANCE = "first harmonics are balanced; higher ones of the force do not move the model"

EFFECTS = (
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
