"""The noise floor and the material floor over 58 decades of reduced frequency.

Neither gives way to rounding.
"""

import numpy as np
import pytest

from springpot.misfit import any_material
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.material import material_floor
from springpot.registry import parse_model
from wide_sweeps import NOISE, spectrum

ADEQUATE = "havriliak-negami + wlf-shift"


@pytest.fixture(scope="module", params=[False, True], ids=["strain held", "force held"])
def data(request):
    return spectrum(np.random.default_rng(1), force_held=request.param)


@pytest.mark.suite_cases("strain held")
def test_without_a_model_the_floor_is_the_scatter_within_each_sweep(data):
    """The temperature is not even in this model: neighbours in a sweep tell the noise."""
    assert NOISE / 1.5 < fitted_to_floor(any_material(), data).floor < 1.7 * NOISE


@pytest.mark.soak_cases("force held", "strain held")
def test_no_material_is_further_off_than_an_adequate_model_with_the_same_effects(data):
    base = fitted_to_floor(parse_model(ADEQUATE), data)
    lowest = material_floor(base, np.random.default_rng(0))
    assert lowest.relative_rms <= 1.001 * base.relative_rms
    assert lowest.relative_rms < 1.2 * NOISE
