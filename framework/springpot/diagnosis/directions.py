"""What an effect could change: its influence on K over a grid of physically possible settings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.identification import Window, settings
from springpot.measurement import Measurement
from springpot.rheology import Complex, Effect, Model, Real


@dataclass(frozen=True, eq=False)
class Influence:
    """How K changes when an effect joins a fitted model with the model's parameters held.

    Parameters
    ----------
    effect : Effect
        The effect.
    model : Model
        The grown model.
    theta : ndarray, shape (g, p)
        Parameters of the grown model on the grid: the fitted ones and a setting of the effect.
    change : ndarray of complex, shape (g, n)
        K of the grown model minus K of the fitted one.
    relative : ndarray, shape (g,)
        Root mean square of |change| / |K|.
    added : tuple of str
        Names of the effect's own parameters, its size first.
    """

    effect: Effect
    model: Model
    theta: Real
    change: Complex
    relative: Real
    added: tuple[str, ...]

    def sized(self, setting: int, factor: float) -> dict[str, float]:
        """The effect's own parameters at a setting, its size changed so that it changes K `factor` times as much."""
        values = {name: float(self.theta[setting, self.model.names.index(name)]) for name in self.added}
        values[self.added[0]] *= factor if self.effect.vanishes_at == 0.0 else 1.0 / factor
        return values


def influence(model: Model, theta: Real, stiffness: Complex, effect: Effect, measurement: Measurement) -> Influence:
    """What `effect` would change at a fitted model, over a grid of its settings.

    Parameters
    ----------
    model : Model
        The fitted model.
    theta : ndarray, shape (p,)
        Its parameters.
    stiffness : ndarray of complex, shape (n,)
        Its K at the measured points.
    effect : Effect
        The effect that may be missing.
    measurement : Measurement
        The data.
    """
    grown = model + effect
    old = [grown.names.index(name) for name in model.names]
    new = [i for i in range(len(grown.names)) if i not in old]
    added = tuple(grown.parameters[i] for i in new)
    grid = settings(added, Window.of(measurement), 64 if len(added) == 1 else 160 * (len(added) - 1) + 96)
    full = np.empty((len(grid), len(grown.names)))
    full[:, old] = theta
    full[:, new] = grid
    with np.errstate(all="ignore"):  # settings beyond what floating-point numbers hold are left out below
        change = _finite(grown.network.respond(full, measurement.points).value - stiffness)
    relative = np.sqrt(np.mean(np.abs(change / stiffness) ** 2, axis=-1))
    usable = np.isfinite(relative) & (relative > 1e-7)
    names = tuple(parameter.name for parameter in added)
    return Influence(effect, grown, full[usable], change[usable], relative[usable], names)


def _finite(values: Complex) -> Complex:
    return np.where(np.isfinite(values), values, np.nan)
