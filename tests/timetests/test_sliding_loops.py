"""Raw loops of a damper that slides.

The threshold is found although a viscous damper has as much loss.
"""

import numpy as np
import pytest

import springpot
from springpot.measurement import TimeTest, noise_of
from springpot.timetests import identify

SLIDER, FORCE, SPRING = 1500.0, 3900.0, 30.0


@pytest.fixture(scope="module")
def loop():
    """Ten cycles that grow and fade at 0.5 Hz, 25 mm; the slider yields after 2.6 mm."""
    t = np.linspace(0.0, 20.0, 1501)
    x = 25.0 * np.sin(np.pi * t) * np.sin(np.pi * t / 20.0)
    slid = np.zeros_like(x)
    for i in range(1, len(x)):
        slid[i] = np.clip(slid[i - 1] + SLIDER * (x[i] - x[i - 1]), -FORCE, FORCE)
    noise = 30.0 * np.random.default_rng(0).normal(size=len(t))
    return TimeTest.of_history(
        t, x, SPRING * x + slid + noise, "mm", "N", control="displacement", name="slider"
    )


@pytest.mark.soak_cases("material")
@pytest.mark.parametrize("model", ["kelvin", "material"])
def test_the_threshold_is_found_from_no_start(loop, model):
    found = identify(loop, springpot.parse_model(f"{model} + elasto-sliding"))
    values = dict(zip(found.model.names, found.theta, strict=True))
    assert values["elasto-sliding.F"] == pytest.approx(FORCE, rel=0.03)
    assert values["elasto-sliding.k"] == pytest.approx(SLIDER, rel=0.1)


def test_where_the_force_crosses_zero_the_noise_is_that_of_the_rest():
    """Hardly less: in proportion to force the few samples of crossings would outvote the loop."""
    t = np.linspace(0.0, 20.0, 2001)
    force = 1000.0 * np.sin(np.pi * t)
    shaken = force * (1.0 + 0.02 * np.random.default_rng(1).normal(size=len(t)))
    noise = noise_of(
        TimeTest.of_history(t, np.sin(np.pi * t), shaken, "mm", "N", control="displacement")
    )
    assert noise.sd.min() == pytest.approx(0.01 * 1000.0 / np.sqrt(2.0), rel=0.15)
    assert noise.sd.max() == pytest.approx(0.02 * 1000.0, rel=0.15)
