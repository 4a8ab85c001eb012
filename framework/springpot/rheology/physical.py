"""Whether a law that somebody wrote can be one of a material: causal, and passive.

A causal law is analytic where the real part of s is positive, real on the real axis there and grows
no faster than a power: it follows from what was, and from nothing else. A passive one gives out no
energy in any cycle.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import cast

import numpy as np

from .points import HALF_PI, Complex, Real
from .written import FACTORS, TypedLaw, Written, examples

AROUND = 256
"""Points of a circle on which a mean is taken."""
NEARLY = 0.97
"""Radius of a circle beside its distance from the imaginary axis."""
OFF = 1e-3
"""By how much a mean may miss the value at the centre, beside the largest value on the circle."""
SLOW, FAST, STEEPEST = 30.0, 300.0, 30.0
"""Rates between which the logarithm of a law grows by no more than that: 13 powers of ten."""


def causal(element: Written) -> bool:
    """Whether a law is causal.

    Examples
    --------
    >>> from springpot.rheology.physical import causal
    >>> from springpot.rheology.written import written
    >>> causal(written("-m*omega^2")), causal(written("i*h"))
    (True, False)
    """
    with np.errstate(all="ignore"):
        real = np.geomspace(0.03, 30.0, 25).astype(complex)
        values = _values(element, real)
        # Of what is no number anywhere nothing is said against.
        if np.max(np.abs(values.imag)) > OFF * np.max(np.abs(values)):
            return False
        ends = np.log(np.abs(_values(element, np.array([SLOW, FAST], dtype=complex))))
        if not ends[1] - ends[0] < STEEPEST:
            return False
        turn = np.exp(2j * np.pi * np.arange(AROUND) / AROUND)
        for x, slope in product(np.geomspace(0.03, 30.0, 7), (0.0, 1.0, 4.0, 16.0)):
            centre = x * (1.0 + 1j * slope)
            circle = _values(element, centre + NEARLY * x * turn)
            off = np.abs(np.mean(circle) - _values(element, np.array([centre]))[0])
            if not off <= OFF * np.max(np.abs(circle)):
                return False
    return True


def passive(element: Written) -> bool:
    """Whether a law of stiffness or compliance gives out no energy, at any of some sizes.

    Examples
    --------
    >>> from springpot.rheology.physical import passive
    >>> from springpot.rheology.written import written
    >>> passive(written("c*i*omega")), passive(written("-c*i*omega"))
    (True, False)
    """
    at, usual = examples(element)
    assert isinstance(element.law, TypedLaw)
    sign = -1.0 if element.plane == "compliance" else 1.0
    at = replace(at, log_omega=np.linspace(-3.0, 3.0, len(at.log_omega)))
    with np.errstate(all="ignore"):
        for share in product((0.5, 1.5), repeat=min(len(usual), 4)):
            values = [value * by for value, by in zip(usual, (*share, 1.0, 1.0), strict=False)]
            values += usual[len(values) :]
            value = np.asarray(element.law.dual(at, values).value, dtype=complex)
            if np.any(sign * value.imag < -1e-9 * np.abs(value)):
                return False
    return True


def _values(element: Written, s: Complex) -> Complex:
    """The law at complex rates s (n,), at one set of conditions."""
    at, usual = examples(element)
    assert isinstance(element.law, TypedLaw)
    one = at.mapped(lambda column: np.full(len(s), column[0]))
    there = replace(one, log_omega=cast("Real", np.log(s) - HALF_PI))
    return np.broadcast_to(np.asarray(element.law.dual(there, usual).value, complex), s.shape)


def told(element: Written) -> str:
    """What kind of law it is, in a few words.

    Examples
    --------
    >>> from springpot.rheology.physical import told
    >>> from springpot.rheology.written import written
    >>> told(written("i*h"))
    "not causal: no physical law, an instrument's fault"
    """
    # The first harmonic of what knows an amplitude is no linear answer: friction follows no clock.
    linear = "amplitude" not in element.needs
    if linear and not causal(element):
        return "not causal: no physical law, an instrument's fault"
    # What multiplies a signal or moves a clock has no energy of its own.
    if element.plane in FACTORS:
        return "causal"
    if not passive(element):
        return "not passive: it gives out energy"
    if not linear:
        return "passive"
    return "causal and passive"
