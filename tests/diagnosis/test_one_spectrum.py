"""Two parts of a material that are needed together may as well be one spectrum of another shape.

That is said.
"""

import numpy as np
import pytest

import springpot
from springpot.diagnosis.evidence import Explanation
from springpot.diagnosis.grown import Grown
from springpot.misfit.floor import fitted_to_floor

OMEGA = np.geomspace(0.1, 1e3, 45)


def havriliak_negami(omega, alpha, gamma):
    """An asymmetric relaxation, which no two parts of the library make."""
    s = 1j * omega
    return 40.0 + 200.0 * (1.0 - (1.0 + (s * 0.05) ** alpha) ** -gamma)


@pytest.fixture(
    scope="module", params=[(0.6, 1.3, 0.001), (0.6, 0.3, 0.003)], ids=["wide", "skewed"]
)
def found(request):
    alpha, gamma, noise = request.param
    rng = np.random.default_rng(8)
    stiffness = havriliak_negami(OMEGA, alpha, gamma)
    real, imaginary = noise * rng.normal(size=(2, len(OMEGA)))
    stiffness = stiffness * (1.0 + real + 1j * imaginary)
    units = springpot.Units("kN/m", "mm")
    return springpot.diagnose(
        springpot.Measurement(OMEGA, stiffness, units=units), "fractional-zener"
    )


@pytest.mark.soak
def test_something_is_missing_but_no_part_is_named_with_confidence(found):
    assert found.verdict == "effect-missing"
    assert found.candidates[0].probability < 0.95
    assert "something of another shape" in found.says


@pytest.mark.parametrize(("force", "slips"), [(1e9, False), (10.0, True)])
def test_a_slider_that_never_slips_is_a_part_of_the_material(force, slips):
    """It is a spring; with a springpot beside it one spectrum of another shape may replace both."""
    omega, amplitude = np.tile(OMEGA, 3), np.repeat([0.1, 1.0, 10.0], len(OMEGA))
    grown = springpot.parse_model("dashpot + parallel-springpot + elasto-sliding")
    true = {"c": 1.0, "parallel-springpot.c": 50.0, "parallel-springpot.alpha": 0.3}
    true |= {"elasto-sliding.k": 30.0, "elasto-sliding.F": force}
    theta = np.array([true[name] for name in grown.names])
    points = springpot.rheology.Points.at(omega, amplitude=amplitude)
    exact = grown.stiffness(theta, points)
    real, imaginary = 0.002 * np.random.default_rng(3).normal(size=(2, len(omega)))
    data = springpot.Measurement(
        omega,
        exact * (1.0 + real + 1j * imaginary),
        conditions={"amplitude": amplitude},
        units=springpot.Units("kN/m", "mm"),
        sd=0.002 * np.abs(exact) * (1.0 + 1j),
    )
    refit = fitted_to_floor(grown, data, [theta])
    effects = tuple(
        springpot.plugins().effect(name) for name in ("parallel-springpot", "elasto-sliding")
    )
    one = Explanation(Grown(effects, refit, 0.0), 0.9)
    assert one.one_spectrum == (not slips)
