"""Effects in series: their compliance adds to that of the model."""

from __future__ import annotations

from springpot.rheology import (
    Effect,
    Layer,
    dashpot,
    resonant_frame,
    retardation_mode,
    series,
    spring,
    springpot,
)

EFFECTS = (
    Effect(
        "series-spring",
        series,
        spring("k"),
        "mounting, tool or transducer give way elastically: the measured stiffness saturates, most where it is large",
        Layer.MOUNTING,
        "Liu et al. 2011, Rheologica Acta 50, 537",
        ("mounting-compliance", "instrument-compliance"),
        equation="1 / (1 / K + 1 / k)",
    ),
    Effect(
        "frame-resonance",
        series,
        resonant_frame("k"),
        "the frame gives way with a resonance of its own at a fixed frequency",
        Layer.MOUNTING,
        "Ewins, Modal Testing, 2000",
        narrow=True,
        equation="1 / (1 / K + 1 / (k * (1 - r^2 + 2 * i * zeta * r))), r = omega / omega_r",
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
    Effect(
        "series-springpot",
        series,
        springpot("c", "alpha"),
        "a further broad creep in series: the compliance grows as a power of 1/omega",
        citation="Schiessel et al. 1995, doi:10.1088/0305-4470/28/23/012",
        equation="1 / (1 / K + 1 / (c * s^alpha))",
    ),
    Effect(
        "retardation-mode",
        series,
        retardation_mode("k", "tau"),
        "one more retardation time: a step in storage compliance and a bump in loss compliance at omega = 1/tau",
        citation="Ferry, Viscoelastic Properties of Polymers, 1980",
        aliases=("kelvin-unit",),
        prior=0.3,
        equation="1 / (1 / K + 1 / (k * (1 + s * tau)))",
    ),
)
