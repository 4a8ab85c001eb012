"""Nonlinear effects: they need a column of amplitudes, and most show in the third harmonic."""

from __future__ import annotations

from math import inf

from springpot.rheology import (
    AMPLITUDE,
    PURE,
    Dimension,
    Effect,
    Layer,
    Parameter,
    coulomb_friction,
    cubic_dashpot,
    cubic_spring,
    elasto_sliding,
    gapped_spring,
    heated,
    heating,
    parallel,
    payne_softening,
    power_law_damper,
    smooth_hysteresis,
    yielding_spring,
)

WARMEST = 0.01
"""Shift in ln omega for each W/m^3, in m^3/W, that no specimen of a modulus exceeds.

Foam 5 cm thick, 0.03 W/(m K),
warms by L^2 / (8 lambda) = 0.010 K m^3/W at most, and no polymer's times change by more than a
factor of e in a kelvin (0.8 at the glass transition, by the universal constants of WLF).
"""
TYPICAL_LIMIT = 3.0
"""Where softening is sought, over the middle of what was measured.

Mostly a test ends soon after it has begun.
"""
LIMIT = Parameter("Xc", "X_c", AMPLITUDE, typical=TYPICAL_LIMIT)
RATE_LIMIT = Parameter("Vc", "V_c", Dimension(time=-1, amplitude=1), typical=TYPICAL_LIMIT)
STEEPEST = 3.0
"""Power of the amplitude with which K falls at most.

A yielding gel's falls as its square, and a little faster.
"""
GELB = "Gelb and Vander Velde, Multiple-Input Describing Functions, 1968"

# Of the effects here and in the other files, rarer physics counts a third (prior=0.3): beside what
# every laboratory meets it should need better evidence, and be found all the same.

EFFECTS = (
    Effect(
        "friction",
        parallel,
        coulomb_friction("F"),
        "dry friction: a loss the same at all frequencies that falls as 1/amplitude, with odd"
        " harmonics",
        Layer.MOVING_PARTS,
        GELB,
        ("coulomb-friction",),
        equation="K + i * 4 * F / (pi * X)",
    ),
    Effect(
        "elasto-sliding",
        parallel,
        elasto_sliding("k", "F"),
        "a spring that slips at a certain force: storage falls with amplitude, the loss has a peak,"
        " odd harmonics",
        Layer.MOVING_PARTS,
        "Jenkin 1922; Iwan 1966, doi:10.1115/1.3625199",
        ("jenkins",),
        equation=(
            "K + k / pi * (b - sin(2 * b) / 2 + i * sin(b)^2), b = arccos(1 - 2 * min(F / (k *"
            " X), 1))"
        ),
    ),
    Effect(
        "smooth-hysteresis",
        parallel,
        smooth_hysteresis("k", "F", "n", "beta"),
        "a spring that yields gradually, at any rate alike: storage falls with amplitude, loss"
        " peaks, odd harmonics",
        Layer.MOVING_PARTS,
        "Wen 1976, J. Eng. Mech. Div. ASCE 102, 249; Ikhouane and Rodellar 2007, Systems with"
        " Hysteresis",
        ("bouc-wen",),
        # Rarer than plain friction, from which one amplitude cannot tell it.
        prior=0.3,
        equation=(
            "K + F / X * fundamental(z), z' = k / F * x' * (1 - |z|^n * (beta * sgn(z * x') + 1 -"
            " beta))"
        ),
    ),
    Effect(
        "yielding",
        parallel,
        yielding_spring("k", "F", "a"),
        "a part that yields: elastic at first, beyond a force it flows and the force lies flat over"
        " the speed, as of a gel, an emulsion, a field-responsive fluid",
        citation="Gamota and Filisko 1991, J. Rheol. 35, 399: a spring before what flows",
        aliases=("viscoplastic", "yield-stress", "force-plateau"),
        approximate="first harmonic in frequency: both parts are moved by a sine",
        equation=(
            "K + 1 / (1 / k + 1 / S), S = i * F * g * omega^a * Y^(a - 1), Y = X * |k / (k + S)|, "
            "g = 2 / sqrt(pi) * gamma(1 + a / 2) / gamma((3 + a) / 2)"
        ),
    ),
    Effect(
        "power-law-damper",
        parallel,
        power_law_damper("F", "a"),
        "a damper force that goes as a power of the speed: loss as omega^a, amplitude^(a-1), no"
        " storage",
        Layer.MOVING_PARTS,
        "Elliott, Tehrani and Langley 2015, doi:10.1098/rsta.2014.0402",
        equation=(
            "K + i * F * g * omega^a * X^(a - 1), g = 2 / sqrt(pi) * gamma(1 + a / 2) / gamma((3 +"
            " a) / 2)"
        ),
    ),
    Effect(
        "cubic-damping",
        parallel,
        cubic_dashpot("c3"),
        "a damper force that goes as the cube of the speed: loss as omega^3 and amplitude squared",
        Layer.MOVING_PARTS,
        "Elliott, Tehrani and Langley 2015, doi:10.1098/rsta.2014.0402",
        prior=0.3,
        equation="K + i * 3 / 4 * c3 * omega^3 * X^2",
    ),
    Effect(
        "dead-zone",
        parallel,
        gapped_spring("k", "b"),
        "a stop that touches only beyond a gap: storage grows with amplitude, the loss is"
        " untouched",
        Layer.MOVING_PARTS,
        GELB,
        ("bump-stop", "gap"),
        equation="K + k * (1 - 2 / pi * (arcsin(r) + r * sqrt(1 - r^2))), r = min(b / X, 1)",
    ),
    Effect(
        "cubic-stiffness",
        parallel,
        cubic_spring("k3"),
        "stiffening or softening with the square of the amplitude, the same at all frequencies",
        citation="Nayfeh and Mook, Nonlinear Oscillations, 1979",
        aliases=("duffing",),
        equation="K + 3 / 4 * k3 * X^2",
    ),
    Effect(
        "payne",
        parallel,
        payne_softening("k"),
        "a filler network breaks up: storage falls with amplitude while the loss passes through a"
        " peak",
        citation="Kraus 1984, J. Appl. Polym. Sci. Appl. Polym. Symp. 39, 75",
        aliases=("kraus",),
        equation="K + k * (1 + 2 * i * h * u) / (1 + u^2), u = (X / Xc)^m",
    ),
    Effect.from_formula(
        "intrinsic-nonlinearity",
        "chain: 1 + q * X^2",
        "the material softens or stiffens with amplitude squared by the same fraction at all"
        " frequencies",
        (Parameter("q", "q", Dimension(amplitude=-2), -inf, scale="linear"),),
        "amplitude gain",
        layer=Layer.MATERIAL,
        citation="Hyun and Wilhelm 2009, Macromolecules 42, 411",
        aliases=("maos",),
        prior=0.3,
    ),
    Effect.from_formula(
        "strain-softening",
        "chain: 1 / (1 + (X / Xc)^n)",
        "the whole material softens beyond an amplitude: storage and loss fall by one factor at all"
        " frequencies",
        (LIMIT, Parameter("n", "n", PURE, 0.3, STEEPEST, "linear", 1.0)),
        "damping function",
        layer=Layer.MATERIAL,
        citation="Soskey and Winter 1984, doi:10.1122/1.549770",
        aliases=("damping-function", "strain-thinning"),
        approximate="first harmonic: the factor is of the amplitude, not of the history",
        # Where Xc is far beyond all amplitudes nothing softens.
        absent_at=inf,
    ),
    Effect.from_formula(
        "shear-thinning",
        "chain: 1 / (1 + (omega * X / Vc)^n)",
        "a liquid flows the more easily the faster it is moved: storage and loss fall with"
        " frequency times amplitude",
        (RATE_LIMIT, Parameter("n", "n", PURE, 0.3, 1.0, "linear", 0.8)),
        "thinning",
        layer=Layer.MATERIAL,
        citation=(
            "Cross 1965, doi:10.1016/0095-8522(65)90022-X; Doraiswamy et al. 1991,"
            " doi:10.1122/1.550184"
        ),
        aliases=("rate-thinning", "cross-thinning"),
        approximate="first harmonic: the factor is of the largest rate, not of the momentary one",
        absent_at=inf,
        prior=0.3,
        only_varied=True,
    ),
    Effect(
        "self-heating",
        heated,
        heating("s"),
        "the specimen is warmed by its own loss and behaves as at a lower frequency, growing with"
        " power",
        Layer.SPECIMEN,
        "first order in the steady rise of temperature, which the power omega K'' X^2 / 2 of the"
        " warm specimen keeps up",
        equation="K(omega * exp(-s * P)), P = omega * imag(K(omega * exp(-s * P))) * X^2 / 2",
        largest_of_modulus=WARMEST,
    ),
    Effect.from_formula(
        "backlash",
        "chain: 1 - slider(b / X)",
        "a joint with play in the drive: the specimen moves less than measured, and later",
        (Parameter("b", "b", AMPLITUDE, typical=0.3),),
        "play",
        layer=Layer.SIGNAL,
        citation=GELB,
        aliases=("play",),
        prior=0.3,
    ),
)
