"""One noise for all models: that of the likeliest fit, not of the quietest."""

import numpy as np

from springpot.comparison import comparing
from springpot.distributions import autoregressive
from springpot.measurement import Measurement
from springpot.measurement.replicates import average_repeats
from springpot.measurement.scatter import Noise
from springpot.misfit.refit import refit
from springpot.registry import parse_model


def test_a_wrong_model_tells_no_noise_with_a_memory(monkeypatch):
    """Beside its misfit what goes on from point to point is not seen, and the noise seems small."""
    omega, model, wrong = np.geomspace(0.1, 100.0, 60), parse_model("zener"), parse_model("kelvin")
    noise = autoregressive(np.random.default_rng(4).normal(size=(2, 60)), 0.8)
    exact = model.stiffness(model.theta(k1=50.0, k2=90.0, c=90.0), omega)
    data = Measurement(omega, exact * (1.0 + 0.01 * (noise[0] + 1j * noise[1])))
    size = data.magnitude * (1.0 + 1.0j)

    def to_floor(model, data):
        told = Noise(0.006 * size, 100.0, "estimated")
        if model is not wrong:
            told = Noise(0.01 * size, 30.0, "estimated", memory=0.8)
        return refit(model, average_repeats(data), told, starts=2)

    monkeypatch.setattr(comparing, "fitted_to_floor", to_floor)
    fits = comparing._fits(data, [wrong, model], lambda words: None)
    assert [fit.noise.memory for fit in fits] == [0.8, 0.8]
