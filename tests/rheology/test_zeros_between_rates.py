"""The compliance of springs and dashpots has one rate between two of the stiffness.

However far apart the rates lie, and however weak a line is.
"""

from __future__ import annotations

import numpy as np
import pytest

from springpot.rheology.rational import Lines, Rational

ABOVE = 1.0 + 1e-13
"""Of what is found by its logarithm, and may lie 25 decades from one."""


def network(rng: np.random.Generator, lines: int, decades: float, weak: float) -> Rational:
    """Lines at rates over so many decades, the weakest a share `weak` of the strongest."""
    rates = np.sort(10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, lines))
    weights = weak ** rng.uniform(size=lines)
    ends = np.append(rng.integers(0, 2, 2) * rng.uniform(0.1, 1.0, 2), 0.0)
    nothing = np.zeros((lines, 1))
    return Rational(ends, np.zeros((3, 1)), Lines(rates, weights, nothing, nothing))


def stiffness(of: Rational, s: np.ndarray) -> np.ndarray:
    rates, weights, _, _ = of.lines
    return of.ends[0] + of.ends[1] * s + (s[:, None] / (s[:, None] + rates)) @ weights


@pytest.mark.parametrize("decades", [1.0, 8.0, 24.0])
@pytest.mark.parametrize("weak", [0.1, 1e-9])
def test_they_stand_in_turn_and_k_is_zero_there(rng, decades, weak):
    for lines in (1, 2, 7, 30, 60):
        of = network(rng, lines, decades, weak)
        spring, dashpot, _ = of.ends
        zeros = of._zeros()
        assert len(zeros) == lines - 1 + bool(spring) + bool(dashpot)
        ends = np.concatenate([[0.0] * bool(spring), of.lines.rates, [np.inf] * bool(dashpot)])
        assert np.all((ends[:-1] <= zeros * ABOVE) & (zeros <= ends[1:] * ABOVE))
        # Beside a weak line both are one to many digits: there only the interval is told.
        apart = np.min(np.abs(zeros[:, None] / of.lines.rates - 1.0), axis=1) > 1e-6
        for side, sign in ((1.0 - 1e-9, 1.0), (1.0 + 1e-9, -1.0)):
            assert np.all(sign * stiffness(of, -zeros[apart] * side) > 0.0)


def test_a_spring_beside_a_dashpot_has_one_and_either_alone_none():
    for ends, zeros in (([2.0, 4.0], [0.5]), ([2.0, 0.0], []), ([0.0, 4.0], [])):
        of = Rational(np.array([*ends, 0.0]), np.zeros((3, 1)), Lines.none(1))
        np.testing.assert_allclose(of._zeros(), zeros)


def test_the_compliance_of_the_compliance_is_the_stiffness(rng):
    of = network(rng, 30, 12.0, 0.1)
    again = of.inverse().inverse()
    s = 1j * np.geomspace(1e-7, 1e7, 50)
    np.testing.assert_allclose(stiffness(again, s), stiffness(of, s), rtol=1e-9)
