"""What effects of a condition would explain that was not varied by itself, and so took no part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from springpot.measurement import CONDITIONS, Measurement, spread_of, telling
from springpot.rheology import Effect

from .refit import Refit, refit
from .search import Search

AS_GOOD = 3.0
"""Log-evidence by which an explanation may be worse and count as good: odds of one to twenty."""


def confounded_effects(found: Search, library: Sequence[Effect]) -> dict[str, Refit]:
    """Effects that took no part, with their fits, which explain the data as well as the best model that did.

    They form a class with whatever was found: the condition that they need moved with the frequency, or an amplitude
    with the temperature, so that no fit can say which of the two is the cause.

    Parameters
    ----------
    found : Search
        A finished search.
    library : sequence of Effect
        Effects that may be missing.
    """
    base = found.base
    moved = _moved(base.fit.measurement)
    alike = {}
    for effect in library:
        if effect.narrow or not effect.needs & moved or not effect.needs <= set(base.fit.measurement.conditions):
            continue
        grown = refit(base.model + effect, base.data, base.noise, starts=2)
        if grown.log_evidence > max(found.best.log_evidence, base.log_evidence + AS_GOOD) - AS_GOOD:
            alike[effect.name] = grown
    return alike


def confounded_in_words(found: Search, library: Sequence[Effect]) -> Iterator[str]:
    """A sentence for each condition that varied, but not by itself; none where all did.

    Parameters
    ----------
    found : Search
        A finished search.
    library : sequence of Effect
        Effects that may be missing.
    """
    moved = _moved(found.base.fit.measurement)
    if not moved:
        return
    alike = confounded_effects(found, library)
    for name in sorted(moved):
        beside = "frequency" if name == "temperature" else "frequency or temperature"
        names = [effect.name for effect in library if effect.name in alike and name in effect.needs]
        told = f": {', '.join(names)} would explain the data as well, and no fit can tell" if names else ""
        yield f"the {name} was not varied by itself but moves with {beside}; its effects are not judged{told}"


def _moved(measurement: Measurement) -> set[str]:
    """Conditions that varied, but not by themselves."""
    spreads = {name: spread_of(measurement, name) for name in CONDITIONS}
    moved = {name for name, spread in spreads.items() if spread is not None and spread.varied}
    return moved - telling(measurement)
