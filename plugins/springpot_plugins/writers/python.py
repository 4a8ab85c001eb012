"""A small Python file that needs numpy alone."""

from __future__ import annotations

from springpot.rheology import Real
from springpot.solvers import Handoff, Writer

TEMPLATE = '''"""{heading}"""

import numpy as np

EQUILIBRIUM = {equilibrium:.17g}
VISCOSITY = {viscosity:.17g}
WEIGHTS = np.array([{weights}])
TIMES = np.array([{times}])


def stiffness(omega):
    """Complex stiffness at the angular frequencies omega in rad/s."""
    s = 1j * np.atleast_1d(omega)
    turned = s[:, None] * TIMES
    return EQUILIBRIUM + VISCOSITY * s + (turned / (1 + turned)) @ WEIGHTS


def respond(t, displacement):
    """Force for a displacement, straight between samples and before them at its first value."""
    t, x = np.asarray(t, dtype=float), np.asarray(displacement, dtype=float)
    state, force = np.zeros(len(TIMES)), np.empty(len(t))
    speed = np.gradient(x, t)
    force[0] = EQUILIBRIUM * x[0] + VISCOSITY * speed[0]
    for k in range(1, len(t)):
        z = (t[k] - t[k - 1]) / TIMES
        state = np.exp(-z) * state - np.expm1(-z) / z * (x[k] - x[k - 1])
        force[k] = EQUILIBRIUM * x[k] + VISCOSITY * speed[k] + WEIGHTS @ state
    return force
'''


def to_python(handoff: Handoff) -> str:
    """The file."""
    prony = handoff.prony
    # The heading goes between three quotes, and may hold a file's name with anything in it.
    quoted = "\n".join(handoff.heading()).replace("\\", "\\\\").replace('"', '\\"')
    return TEMPLATE.format(
        heading=quoted + "\n",
        equilibrium=prony.equilibrium,
        viscosity=prony.viscosity,
        weights=_listed(prony.weights),
        times=_listed(prony.times),
    )


def _listed(numbers: Real) -> str:
    # Seventeen digits read back as the same bits.
    return ", ".join(f"{number:.17g}" for number in numbers)


WRITER = Writer(
    "python",
    to_python,
    "a file with stiffness(omega) and respond(t, x) that needs numpy alone",
    ".py",
)
