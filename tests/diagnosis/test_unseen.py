"""What a fit has not seen.

The foretold error is that of fits without it, and it counts among what is left.
"""

import numpy as np
import pytest
from hidden_data import design, measured

import springpot
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.frame import folds_of, unseen_error
from springpot.misfit.refit import left_out_error
from springpot.misfit.residual_tests import battery

STEPS = design(8, 0.1, 50.0, temperatures=(-10.0, 5.0, 20.0, 35.0, 50.0))
KELVIN_VOIGT = 50.0 + 0.3j * STEPS.omega


def fitted(stiffness, model, seed=0):
    return fitted_to_floor(
        springpot.parse_model(model), measured(STEPS, stiffness, seed, 0.005, known=True)
    )


def test_of_a_linear_model_it_is_the_error_of_fits_without_each_level():
    base = fitted(KELVIN_VOIGT, "kelvin")
    frame = base.frame()
    folds = folds_of(frame.measurement, "temperature")
    count = 2 * sum(int(np.sum(fold)) for fold in folds)
    (foretold,) = unseen_error(frame, frame.rest[None], "temperature")
    assert foretold == pytest.approx(count * left_out_error(base, folds) ** 2, rel=1e-3)


def test_where_no_inner_level_was_measured_nothing_is_foretold():
    frame = fitted(KELVIN_VOIGT, "kelvin").frame()
    assert unseen_error(frame, frame.rest[None], "amplitude") is None


@pytest.mark.parametrize(("gain", "seen"), [(1.0, False), (1.03, True)])
def test_a_temperature_that_the_others_do_not_foretell_is_left(gain, seen):
    """One specimen was cut anew.

    At one temperature the stiffness is larger, and no law of temperature has that.
    """
    other = np.where(STEPS.celsius == 20.0, gain, 1.0)
    left = battery(fitted(KELVIN_VOIGT * other, "kelvin").frame(), np.random.default_rng(1))
    assert (left.parts["unseen temperature"] < 0.005) == seen
    assert (left.p_value < 0.005) == seen
    (told,) = (one for one in left.findings if one.test == "unseen temperature")
    assert "temperature that a fit has not seen" in told.says
