"""What a card of a solid is told.

A tolerance as a share or in percent, and a Poisson's ratio that can be.
"""

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.solvers import Handoff, Prony
from springpot.solvers.exporting import _share

SERIES = Prony(12.5, 0.0, np.array([31.25]), np.array([0.25]), (1.0, 300.0), 0.0043)


def card(poisson):
    return Handoff(
        SERIES,
        "zener",
        {},
        unit="MPa",
        is_modulus=True,
        poisson=poisson,
        letter="G",
        bulk="relaxing",
    )


def test_a_tolerance_in_percent_is_the_same_as_a_share():
    assert _share("0.5%") == pytest.approx(0.005)
    assert _share(" 0.5 %") == _share("0.005") == _share(0.005) == 0.005
    assert _share(None) is None


@pytest.mark.parametrize("poisson", [None, -1.5, -1.0, 0.5, 0.7])
def test_no_solid_has_poissons_ratio_outside_of_minus_one_and_a_half(poisson):
    with pytest.raises(ModelError, match="Poisson's ratio, above -1 and below"):
        _ = card(poisson).solid


@pytest.mark.parametrize("poisson", [-0.9, 0.0, 0.49])
def test_within_these_it_has_one(poisson):
    assert card(poisson).solid is not None
