"""Numbers that stand in the networks, against their definitions."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest

from springpot.rheology import named, nodes, parameters
from springpot.rheology.parameters import Dimension, Parameter


def quotient(above, below):
    """Coefficients of a quotient of two power series, exactly."""
    found = []
    for i, value in enumerate(above):
        rest = value - sum(found[j] * below[i - j] for j in range(i))
        found.append(rest / below[0])
    return found


def test_series_of_a_wave_are_those_of_z_cot_z_and_of_z_over_sin_z():
    order = len(nodes.MOVING_SERIES)
    assert len(nodes.FIXED_SERIES) == order == 7
    sine = [Fraction((-1) ** n, factorial(2 * n + 1)) for n in range(order)]
    cosine = [Fraction((-1) ** n, factorial(2 * n)) for n in range(order)]
    one = [Fraction(int(n == 0)) for n in range(order)]
    assert pytest.approx([float(c) for c in quotient(cosine, sine)]) == nodes.MOVING_SERIES
    assert pytest.approx([float(c) for c in quotient(one, sine)]) == nodes.FIXED_SERIES


@pytest.mark.parametrize("moving", [True, False])
def test_a_wave_and_its_slope_are_one_curve_on_both_sides_of_the_change(moving):
    edge = nodes.SMALL
    u = np.array([0.999, 1.001]) * edge + 0j
    value, slope = nodes.wave_factor(u, moving)
    exact, exact_slope = nodes._closed(u, moving)
    np.testing.assert_allclose(value, exact, rtol=1e-12)
    np.testing.assert_allclose(slope, exact_slope, rtol=1e-9)
    both = nodes.wave_factor(np.array([0.5 * edge, 4.0 - 1.0j]), moving)
    alone = [nodes.wave_factor(np.array([each]), moving) for each in (0.5 * edge, 4.0 - 1.0j)]
    np.testing.assert_array_equal(both, np.array(alone)[:, :, 0].T)


def test_dimensions_are_powers_of_stiffness_time_and_amplitude():
    powers = {
        "STIFFNESS": (1, 0, 0),
        "VISCOSITY": (1, 1, 0),
        "INERTANCE": (1, 2, 0),
        "FORCE": (1, 0, 1),
        "AMPLITUDE": (0, 0, 1),
        "SECOND": (0, 1, 0),
        "RADIAN_PER_SECOND": (0, -1, 0),
        "PURE": (0, 0, 0),
    }
    for name, (stiffness, time, amplitude) in powers.items():
        assert getattr(parameters, name) == Dimension(stiffness, time, amplitude)
    assert parameters.quasi_property("c", "n").unit == Dimension(1, "n")
    assert parameters.viscosity().unit == Dimension(1, 1)
    assert parameters.relaxation_time().unit == Dimension(0, 1)


def test_an_order_is_a_pure_number_from_0_to_1():
    order = parameters.order()
    assert (order.lower, order.upper, order.scale, order.typical) == (0.0, 1.0, "linear", 0.5)
    assert order.is_order
    for other in (
        Parameter("a", "a", Dimension(0, 1), 0.0, 1.0, "linear"),
        Parameter("a", "a", Dimension(), 0.0, 1.0, "log"),
        Parameter("a", "a", Dimension(), 0.1, 1.0, "linear"),
        Parameter("a", "a", Dimension(), 0.0, 2.0, "linear"),
    ):
        assert not other.is_order
    moved = parameters.quasi_property("c", "n").renamed("mount.c")
    assert (moved.name, moved.unit.time) == ("mount.c", "mount.n")
    assert parameters.quasi_property("c", "n").renamed("d").unit.time == "n"
    assert parameters.viscosity().renamed("mount.c").unit == Dimension(1, 1)


@pytest.mark.parametrize(
    ("lower", "upper"),
    [(0.0, 1.0), (0.0, 0.5), (2.0, 40.0), (1.0, np.inf), (-3.0, np.inf), (-np.inf, 2.0)],
)
def test_two_sizes_of_an_effect_lie_apart_within_its_bounds(lower, upper):
    each = Parameter("k", "k", Dimension(), lower, upper, "linear")
    first, second = (named._inside(each, share) for share in (0.3, 0.6))
    assert lower < first < upper
    assert lower < second < upper
    assert abs(first - second) > 0.1
