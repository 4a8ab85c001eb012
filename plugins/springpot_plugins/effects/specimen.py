"""Effects of the specimen's own mass."""

from __future__ import annotations

from springpot.rheology import Effect, Layer, fixed_side_wave, mass, moving_side_wave

SCHRAG = "Schrag 1977, Trans. Soc. Rheol. 21, 399"

EFFECTS = (
    Effect(
        "specimen-inertia",
        moving_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken where it is moved: storage falls as omega squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        equation="K * z / tan(z), z = omega * sqrt(m / K)",
        prior=0.8,
    ),
    Effect(
        "specimen-inertia-fixed",
        fixed_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken at its fixed end: storage grows with omega squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        prior=0.3,
        equation="K * z / sin(z), z = omega * sqrt(m / K)",
    ),
)
