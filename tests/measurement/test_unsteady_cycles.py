"""Which first cycles are left out: those beyond the F limit, both sides of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.measurement.signals import unsteady_cycles
from springpot.thresholds import SIGNALS


def counted(first, settled):
    """Of groups with such stiffness, displaced by one."""
    each = np.concatenate([first, settled]).astype(complex)
    return unsteady_cycles(SimpleNamespace(groups=np.stack([np.ones_like(each), each], axis=1)))


def limit(settled):
    """Distance from the mean at the limit.

    Of two degrees of freedom against d the F distribution has a closed form, P(F > f) =
    (1 + 2 f / d)^(-d/2).
    """
    n = len(settled)
    d = 2 * (n - 1)
    f = 0.5 * d * (SIGNALS.ruled_out ** (-2.0 / d) - 1.0)
    per_part = np.sum(np.abs(settled - settled.mean()) ** 2) / d
    return np.sqrt(2.0 * f * per_part * (1.0 + 1.0 / n))


@pytest.mark.parametrize("n", [3, 4, 8])
@pytest.mark.parametrize("along", [1.0, 1j, -0.6 + 0.8j])
def test_both_sides_of_the_limit(rng, n, along):
    settled = 5.0 + 0.1 * (rng.normal(size=n) + 1j * rng.normal(size=n))
    calm = np.full(n, settled.mean())
    for share, unlike in ((1.0 - 1e-6, 0), (1.0 + 1e-6, 1)):
        first = calm.copy()
        first[0] += share * limit(settled) * along
        assert counted(first, settled) == unlike


def test_only_an_unbroken_beginning_counts(rng):
    settled = 5.0 + 0.1 * rng.normal(size=6)
    far, near = 9.0, settled.mean()
    assert counted([far, far, near, near, near, near], settled) == 2
    assert counted([far, near, far, near, near, near], settled) == 1
    assert counted([near, far, near, near, near, near], settled) == 0
    assert counted([far] * 6, settled) == 6


def test_two_settled_groups_tell_no_scatter():
    assert counted([9.0, 9.0], np.array([5.0, 5.001])) == 0
    assert counted([9.0, np.nan, 5.0], np.array([5.0, 5.001, 5.0])) == 0


def test_rounding_is_no_transient():
    assert counted([5.0 * (1 + 1e-15)] * 3, np.array([5.0, 5.0, 5.0])) == 0
    assert counted([5.001] * 3, np.array([5.0, 5.0, 5.0])) == 3
