"""Noise whose memory was read beside a misfit, which an effect explains.

The memory is then as long as the misfit, and in such noise no effect has evidence: each model is
weighed in its own.
"""

from types import SimpleNamespace

import pytest

from springpot.diagnosis import examination
from springpot.thresholds import SEARCH


@pytest.mark.parametrize(
    ("gain", "memory", "likelier", "anew"),
    [
        # Beyond doubt in the noise that was found: the better model tells the noise.
        (1.1, 0.0, -1.0, True),
        # Neither beyond doubt, nor a memory that may be a misfit.
        (0.9, 0.0, 9.0, False),
        # Beyond doubt only where each is weighed in its own noise.
        (0.1, 0.8, 1.1, True),
        (0.1, 0.8, 0.9, False),
    ],
)
def test_the_search_is_made_anew_in_the_noise_of_a_better_model(
    monkeypatch, gain, memory, likelier, anew
):
    # Of twice a log-likelihood so many times what is decisive.
    size = 0.5 * SEARCH.decisive
    base = SimpleNamespace(noise=SimpleNamespace(memory=memory), log_evidence=0.0, all=0.0)
    best = SimpleNamespace(log_evidence=gain * size, all=likelier * size)
    search = SimpleNamespace(base=base, best=best, confounded=[])
    monkeypatch.setattr(examination, "remembered", lambda base, gain: None)
    sharper = SimpleNamespace(noise=None)
    monkeypatch.setattr(examination, "sharpened", lambda base, best: sharper)
    monkeypatch.setattr(examination, "in_noise", lambda fitted, noise: fitted)
    monkeypatch.setattr(examination, "likelihood_of_all", lambda fitted: fitted.all)
    monkeypatch.setattr(examination, "go_on_from", lambda new, search, rng: new)
    found = examination._in_sharper_noise(search, [], None, lambda base, library, rng: base)
    assert (found is sharper) is anew
