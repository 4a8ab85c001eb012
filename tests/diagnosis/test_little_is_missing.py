"""A pattern is certain however small.

The headline tells its size, so that the user can say whether it matters.
"""

import numpy as np
import pytest

import springpot

HERTZ = np.geomspace(0.1, 50.0, 40)


def stepped(size, noise):
    """A material whose gain steps at 3 Hz, as where a transducer changes its range."""
    rng = np.random.default_rng(4)
    s = 2j * np.pi * HERTZ
    real, imaginary = noise * rng.normal(size=(2, len(HERTZ)))
    stiffness = (
        (20.0 + 15.0 * s**0.4) * (1.0 + size * (HERTZ > 3.0)) * (1.0 + real + 1j * imaginary)
    )
    return springpot.diagnose(
        springpot.Measurement(s.imag, stiffness, units=springpot.Units("kN/m", "mm"))
    )


@pytest.mark.soak_cases("0.004-0.0003-True", "0.1-0.005-False")
@pytest.mark.parametrize(("size", "noise", "little"), [(0.004, 0.0003, True), (0.1, 0.005, False)])
def test_the_headline_says_where_it_is_little(size, noise, little):
    found = stepped(size, noise)
    assert found.verdict == "unexplained"
    assert ("(it is little" in found.says) is little
    assert (" % of |K|" in found.says) is little
