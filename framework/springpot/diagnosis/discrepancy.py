"""What the best model leaves, told without a name: how large, fixed in Hz or moving with temperature, causal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy.interpolate import BSpline
from scipy.stats import chi2, f, norm

from springpot.rheology import Complex, Real, Shift

from .bases import orthonormal
from .causality import causal_evidence, step_of
from .frame import Frame
from .refit import Refit
from .sweeps import sweeps_of, temperatures_differ
from .where import where

ALARM = 1e-3
"""Chance of noise alone below which something is held to be seen."""
NOTHING = 0.01
"""Chance of noise alone above which nothing is held to be seen."""
SMALL = 0.25
"""Share of the misfit of a rival description that may be left by the one that is named."""
LEAST_SHIFT = 0.7
"""Range of ln a_T below which fixed and moving cannot be told apart."""
RESOLVED = 1e-3
"""Share of a shape that the others must leave for it to count."""
SURE = 10.0
"""Log-evidence from which a residual is called causal, or not."""
FEWEST = 10
"""Second differences from which they tell the scatter."""
NARROW = 8
"""Narrow resonances that are tried for each point of a sweep."""
PATTERNS = {
    "fixed": "it stays at the same frequencies at all temperatures, as faults of an instrument do",
    "moving": "it moves along the frequency with temperature as the material does",
    "": "",
}


@dataclass(frozen=True)
class _Seen:
    """Energy of a residual in some directions, in units of the noise, and their number."""

    energy: float
    size: int
    scale_dof: float

    @property
    def chance(self) -> float:
        """That noise alone has so much."""
        if self.size == 0:
            return 1.0
        if self.scale_dof == inf:
            return float(chi2.sf(self.energy, self.size))
        return float(f.sf(self.energy / self.size, self.size, max(self.scale_dof, 1.0)))

    @property
    def excess(self) -> float:
        """Energy beyond that of noise."""
        return max(self.energy - self.size, 0.0)


def discrepancy(frame: Frame, log_shift: Real | None = None) -> list[str]:
    """Sentences on what a model leaves; none where that is noise, and none on what the data cannot tell.

    Parameters
    ----------
    frame : Frame
        The fit of the best model.
    log_shift : ndarray, shape (n,), optional
        Its ln a_T at the points, see `log_shift_of`; without it nothing is said of temperature.
    """
    places = where(frame)
    if not places and _seen(frame, np.concatenate([frame.smooth, frame.shared], axis=1)).chance > ALARM:
        return []
    told = [_size(frame, places[0].says if places else "")]
    pattern = _pattern(frame, log_shift)
    told.append(PATTERNS[pattern])
    told.append(_causality(frame, pattern, log_shift))
    return [sentence for sentence in told if sentence]


def log_shift_of(found: Refit) -> Real | None:
    """Ln a_T of a fitted model at the points (n,), or None where it has no shift with temperature."""
    model, points = found.model, found.fit.measurement.points
    total: Real | None = None
    for effect, prefix in model.named_effects():  # the second of one name has a prefix of its own
        if effect.composition.kind is Shift and "temperature" in effect.needs:
            names = [name for name in model.names if name.rpartition(".")[0] == prefix]
            theta = found.theta[[model.names.index(name) for name in names]]
            value = np.asarray(effect.element.respond(theta, points).value.real, dtype=np.float64)
            total = value if total is None else total + value
    return total


def _size(frame: Frame, place: str) -> str:
    off = np.abs(frame.measurement.stiffness - frame.model_stiffness) / frame.measurement.magnitude
    noise = (1.0 / frame.weights.real**2 + 1.0 / frame.weights.imag**2) / frame.measurement.magnitude**2
    kept = 1.0 - frame.absorbed.shape[1] / frame.size
    size = float(np.sqrt(max(np.mean(off**2) - kept * np.mean(noise), 0.0)))
    much = f"about {100 * size:.2g} % of |K| beyond the noise" if size > 0 else "no more than the noise in size"
    return f"what is left is {much}{': ' if place else ''}{place}"


def _seen(frame: Frame, basis: Real) -> _Seen:
    return _Seen(float(np.sum((basis.T @ frame.rest) ** 2)), int(basis.shape[1]), frame.scale_dof)


def _without(basis: Real, other: Real) -> Real:
    """Orthonormal basis of what one basis has beyond another."""
    left = basis - other @ (other.T @ basis)
    return orthonormal(left[:, np.linalg.norm(left, axis=0) > RESOLVED], RESOLVED)


def _relative(frame: Frame, shapes: Complex) -> Real:
    """Relative changes of K (m, n), whitened, as columns (2n, m)."""
    return frame.whiten(shapes * frame.model_stiffness).T


def _curve(frame: Frame, x: Real) -> Real:
    """Basis (2n, q) of any one curve along x, in size and phase of K."""
    step = step_of(frame)
    knots = x.min() + step * np.arange(-3, np.ptp(x) / step + 5.0)
    splines = BSpline.design_matrix(x, knots, 3).toarray().T
    splines = splines[np.sum(splines, axis=1) > 0.1]
    return frame.beyond(_relative(frame, np.concatenate([splines, 1j * splines])), RESOLVED)


def _pattern(frame: Frame, log_shift: Real | None) -> str:
    """Whether the residual is one curve of the frequency (fixed) or of the reduced frequency (moving)."""
    if log_shift is None or not temperatures_differ(frame.measurement) or np.ptp(log_shift) < LEAST_SHIFT:
        return ""
    x = np.log(frame.measurement.omega)
    fixed, moving = _curve(frame, x), _curve(frame, x + log_shift)
    by_fixed_only = _seen(frame, _without(fixed, moving))
    by_moving_only = _seen(frame, _without(moving, fixed))
    if by_fixed_only.chance < ALARM and by_moving_only.excess < SMALL * by_fixed_only.excess:
        return "fixed"
    if by_moving_only.chance < ALARM and by_fixed_only.excess < SMALL * by_moving_only.excess:
        return "moving"
    return ""


def _causality(frame: Frame, pattern: str, log_shift: Real | None) -> str:
    x, groups = np.log(frame.measurement.omega), [sweep.rows for sweep in sweeps_of(frame.measurement)]
    if np.ptp(x) == 0.0:
        return ""
    reduced = x + log_shift if pattern == "moving" and log_shift is not None else x
    if pattern and _is_one(frame, _curve(frame, reduced)):
        x, groups = reduced, [np.arange(len(x))]
    frame = _no_rougher(frame)
    evidence = causal_evidence(frame, x, groups)
    if evidence > SURE:
        return "it is consistent with causality, so that a material or a rig can be its cause"
    if evidence < -SURE and causal_evidence(_with_resonance(frame, x), x, groups) < -SURE:
        return (
            "it is not causal (storage and loss do not belong together): a fault of the instrument or of the "
            "analysis, or a nonlinearity, is likelier than a property of a linear material; a loss that does not "
            "change with frequency (ideal hysteretic damping) is not causal either"
        )
    return ""


def _no_rougher(frame: Frame) -> Frame:
    """The frame with noise as large as neighbours differ: scatter beyond the stated one is no breach of causality."""
    n, lines = len(frame.measurement), [sweep.rows for sweep in sweeps_of(frame.measurement)]
    bend = np.concatenate([np.diff(frame.rest[rows + k], 2) for rows in lines for k in (0, n)])
    if len(bend) < FEWEST:
        return frame
    scatter = float(np.median(np.abs(bend))) / (norm.ppf(0.75) * np.sqrt(6.0))
    return replace(frame, weights=frame.weights / max(scatter, 1.0))


def _is_one(frame: Frame, curve: Real) -> bool:
    """Whether one curve is all that the residual has beside noise; else each sweep is judged by itself."""
    free = frame.size - int(frame.absorbed.shape[1]) - int(curve.shape[1])
    left = float(frame.rest @ frame.rest) - _seen(frame, curve).energy
    return _Seen(left, free, frame.scale_dof).chance > NOTHING


def _with_resonance(frame: Frame, x: Real) -> Frame:
    """The frame of a model that has one resonance more: too narrow for the points, it would not look causal."""
    step, best, most = step_of(frame), np.zeros((0, len(x)), dtype=np.complex128), 0.0
    for pole in np.arange(x.min() - step, x.max() + step, step / NARROW):
        for width in step * np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8]):
            at = 1j * np.exp(x - pole)
            shape = frame.model_stiffness / (1.0 + 2.0 * width * at + at**2)
            shapes = np.array([shape, at * shape])
            energy = _seen(frame, frame.beyond(frame.whiten(shapes).T)).energy
            if energy > most:
                best, most = shapes, energy
    return replace(frame, jacobian=np.concatenate([frame.jacobian, best]))
