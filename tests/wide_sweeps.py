"""Sweeps at many temperatures, from glass to rubber: 58 decades of reduced frequency in one file.

As a spectrometer writes them: 21 temperatures, ten frequencies at each. The formulas are written
here by hand (Williams, Landel and Ferry, https://doi.org/10.1021/ja01619a008; Havriliak and Negami,
https://doi.org/10.1016/0032-3861(67)90021-3).
"""

import numpy as np

import springpot

NOISE = 0.006
"""Root mean square of the scatter, relative to |E*|."""
C1, C2 = 27.0, 120.0
"""Of the shift about 25 degC, 45 decades at -50 degC."""
CELSIUS = np.repeat(np.linspace(-50.0, 100.0, 21), 10)
HERTZ = np.tile(np.geomspace(0.1, 100.0, 10), 21)


def modulus():
    """9 GPa in the glass, 2 MPa in the rubber, and a broad way between them."""
    above = CELSIUS - 25.0
    s = 2j * np.pi * HERTZ * 10.0 ** (-C1 * above / (C2 + above))
    return 2e6 + (9e9 - 2e6) / (1.0 + (100.0 * s) ** -0.2) ** 0.5


def spectrum(rng, *, force_held=False):
    """The measurement; at held force the strain goes with the compliance, so with the frequency."""
    exact = modulus()
    real, imaginary = NOISE * np.sqrt(0.5) * rng.normal(size=(2, len(exact)))
    conditions = {"temperature": CELSIUS}
    if force_held:
        conditions["amplitude"] = 1e-4 * (np.abs(exact) / np.abs(exact).max()) ** -0.3
    return springpot.Measurement(
        2.0 * np.pi * HERTZ,
        exact * (1.0 + real + 1j * imaginary),
        conditions=conditions,
        units=springpot.Units("Pa", "-"),
        name="wide",
    )
