"""Effects that can imitate anything narrow: never proposed, but told of where nothing else explains the data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from springpot.rheology import Effect

from .refit import Refit, refit
from .search import Search, scan_effects

DECISIVE = 10.0
"""Drop of the information criterion from which an imitator is worth a word."""


def imitators(found: Search, library: Sequence[Effect]) -> Iterator[str]:
    """One sentence for each effect of no prior weight that takes up much of an unexplained misfit.

    Parameters
    ----------
    found : Search
        A finished search that explained nothing.
    library : sequence of Effect
        All effects; those with a prior weight have been tried already.
    """
    base = found.base
    held = set(base.fit.measurement.conditions)
    for effect in library:
        if effect.prior > 0 or not effect.needs <= held:
            continue
        for score in scan_effects(base, found.frame, [effect]).scores:
            grown = refit(score.influence.model, base.data, base.noise, list(score.starts), starts=2)
            if 2.0 * (grown.log_evidence - base.log_evidence) >= DECISIVE:
                yield (
                    f"{effect.name}{_place(grown, effect)} would take up {100 * _share(base, grown):.0f} % of the "
                    f"misfit; it can imitate any narrow feature, so it is only a hint (--accept {effect.name})"
                )


def _share(base: Refit, grown: Refit) -> float:
    """Share of the misfit beyond noise that is gone."""
    beyond = base.rss - base.fit.dof
    return float(np.clip((base.rss - grown.rss) / max(beyond, 1e-300), 0.0, 1.0))


def _place(grown: Refit, effect: Effect) -> str:
    """Where in frequency the effect sits, if it has a frequency of its own."""
    for name, value in zip(grown.model.names, grown.theta, strict=True):
        if name.startswith(effect.name) and "omega" in name:
            return f" near {value / (2.0 * np.pi):.3g} Hz"
    return ""
