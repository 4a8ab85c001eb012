"""Hide effects in a base and scale them until the best refitted base leaves a wanted chi-square."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep
from hidden_effects.effects import EFFECTS, NONLINEAR, Effect, Scene
from hidden_effects.fit import Coordinates, Network, jacobian, linear_loss, refit, whiten
from hidden_effects.setup import deviation

LARGEST = 1.5  # no disturbance changes the stiffness by more than this, relative
HEAT, SHIFT = "self-heating", "temperature-shift"


class NotVisible(Exception):
    """The base absorbs this effect, or it would have to be absurdly large: draw again."""


def eligible(sweep: Sweep, network: Network) -> list[str]:
    """Names of the effects that these data could show at all."""
    has_field = sweep.temperature is not None
    names = [
        e.name
        for e in EFFECTS.values()
        if not e.needs or has_field or (e.needs == "amplitude" and sweep.amplitude is not None)
    ]
    return [*names, HEAT, SHIFT] if network.law else names


def pick(rng: np.random.Generator, sweep: Sweep, network: Network, count: int) -> list[str]:
    """Distinct effects; amplitude-dependent ones and series ones do not meet (see effects.py)."""
    names = [str(n) for n in rng.choice(eligible(sweep, network), size=count, replace=False)]
    crooked = NONLINEAR | {HEAT}
    if crooked & set(names) and any(EFFECTS[n].series for n in names if n in EFFECTS):
        raise NotVisible
    if {HEAT, SHIFT} <= set(names):
        raise NotVisible
    return names


@dataclass(frozen=True)
class Plan:
    """A truth whose hidden part can be scaled.

    ``names`` are the hidden effects, ``sizes`` the places of their sizes in ``theta``; ``fitted``
    is the model that the user believes in, whose parameters come first in ``theta``.
    """

    names: tuple[str, ...]
    network: Network
    theta: Real
    sizes: tuple[int, ...]
    fitted: Network

    @property
    def start(self) -> Real:
        """Return the true parameters of the fitted model."""
        return self.theta[: self.fitted.size_of_base]

    def at(self, scale: float | Real) -> Real:
        """Return the parameters with the hidden sizes multiplied by ``scale``."""
        theta = self.theta.copy()
        theta[list(self.sizes)] *= scale
        return theta

    def label(self, name: str) -> str:
        """Return the public name: a hidden temperature shift is called by its law."""
        return self.network.law.name if name == SHIFT and self.network.law else name

    def values(self, name: str, theta: Real) -> dict[str, float]:
        """Return the parameters of one hidden effect."""
        first = self.sizes[self.names.index(name)]
        if name == SHIFT:
            labels = self.network.law.parameters if self.network.law else ()
        else:
            labels = ("resistance",) if name == HEAT else EFFECTS[name].parameters
        return {
            label: float(v)
            for label, v in zip(labels, theta[first : first + len(labels)], strict=True)
        }


def hide(
    rng: np.random.Generator, sweep: Sweep, network: Network, theta: Real, names: list[str]
) -> Plan:
    """Add the named effects to the base, with first sizes that disturb it by about a per cent."""
    own, nb = network.size_of_base, len(network.base.parameters)
    theta = theta.copy()
    if SHIFT in names:  # the law is there, small at first, and the fitted model does not have it
        theta[nb] *= 0.02
    k0 = network.stiffness(sweep, theta)
    scene = Scene(sweep, k0, network.reduced(sweep, theta))
    effects: list[Effect] = [EFFECTS[n] for n in names if n in EFFECTS]
    values: list[float] = []
    places = {SHIFT: nb}
    if HEAT in names:
        assert sweep.amplitude is not None
        places[HEAT] = own
        values.append(0.1 / float(np.max(0.5 * sweep.omega * k0.imag * sweep.amplitude**2)))
    for effect in effects:
        places[effect.name] = own + len(values)
        drawn = list(effect.draw(rng, scene))
        drawn[0] *= -1.0 if effect.signs and rng.random() < 0.35 else 1.0
        values += drawn
    grown = replace(network, effects=tuple(effects), heating=HEAT in names)
    fitted = replace(network, law=None) if SHIFT in names else network
    return Plan(
        tuple(names),
        grown,
        np.concatenate([theta, values]),
        tuple(places[n] for n in names),
        fitted,
    )


def scale_to(
    truth: Callable[[float], Complex],
    fitted: Network,
    start: Real,
    sweep: Sweep,
    noise: dict[str, float],
    target: float,
) -> tuple[float, float]:
    """Find the scale at which ``fitted`` leaves ``target`` of noise-free ``truth(scale)``.

    Return it and chi-square.

    The first guess projects a small disturbance on what the base cannot follow; then secant steps
    in ln scale against ln chi-square, every one with a full, warm-started refit.
    """
    k0 = fitted.stiffness(sweep, start)
    sigma = deviation(noise, sweep, k0)
    at = Coordinates.around(fitted.kinds, start)
    change = whiten(truth(1e-3) - k0, sigma)
    slope = linear_loss(jacobian(fitted, at, at.to_search(start), sweep, sigma), change)
    if slope <= 1e-9 * float(change @ change):
        raise NotVisible
    scale, power = 1e-3 * float(np.sqrt(target / slope)), 2.0
    before: tuple[float, float] | None = None
    for _ in range(25):
        k = _acceptable(truth, scale, k0)
        start, chi2 = refit(fitted, start, sweep, k, deviation(noise, sweep, k))
        gap = float(np.log(target / max(chi2, 1e-12)))
        if abs(gap) < 0.01:
            return scale, chi2
        if before is not None and abs(np.log(scale / before[0])) > 1e-12:
            power = float(np.clip(np.log(chi2 / before[1]) / np.log(scale / before[0]), 0.7, 6.0))
        before = (scale, max(chi2, 1e-12))
        scale *= float(np.exp(np.clip(gap / power, -1.5, 1.5)))
    raise NotVisible


def _acceptable(truth: Callable[[float], Complex], scale: float, k0: Complex) -> Complex:
    with np.errstate(all="ignore"):
        k = truth(scale)
        far = np.max(np.abs(k / k0 - 1.0))
    if not np.all(np.isfinite(k)) or far > LARGEST:
        raise NotVisible
    return k


def own_chi2(plan: Plan, theta: Real, name: str, sweep: Sweep, noise: dict[str, float]) -> float:
    """Chi-square left of the noise-free truth when the fitted model lacks ``name`` alone."""
    k = plan.network.stiffness(sweep, theta)
    network = plan.network
    drop = np.zeros(theta.size, dtype=bool)
    first = plan.sizes[plan.names.index(name)]
    if name == SHIFT:
        drop[len(network.base.parameters) : network.size_of_base] = True
        network = replace(network, law=None)
    elif name == HEAT:
        drop[first] = True
        network = replace(network, heating=False)
    else:
        drop[first : first + len(EFFECTS[name].parameters)] = True
        network = replace(network, effects=tuple(e for e in network.effects if e.name != name))
    return refit(network, theta[~drop], sweep, k, deviation(noise, sweep, k), 120)[1]
