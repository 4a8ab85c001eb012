"""Effects of the specimen's own mass."""

from __future__ import annotations

from springpot.rheology import Effect, Layer, fixed_side_wave, mass, moving_side_wave

SCHRAG = "Schrag 1977, Trans. Soc. Rheol. 21, 399"
HEAVIEST = 100.0
"""Density times thickness squared, in kg/m, that no specimen of a modulus exceeds.

0.2 m of a filled solid of
2500 kg/m^3. A plate 1 mm thick has 0.001, a block of rubber of 20 mm has 0.5."""

EFFECTS = (
    Effect(
        "specimen-inertia",
        moving_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken where it is moved: storage falls as omega"
        " squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        equation="K * z / tan(z), z = omega * sqrt(m / K)",
        prior=0.8,
        largest_of_modulus=HEAVIEST,
    ),
    Effect(
        "specimen-inertia-fixed",
        fixed_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken at its fixed end: storage grows with omega"
        " squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        prior=0.3,
        equation="K * z / sin(z), z = omega * sqrt(m / K)",
        largest_of_modulus=HEAVIEST,
    ),
)
