"""What the diagnosis says of a case, beside what is true of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from time import process_time
from typing import Any

import numpy as np

from springpot.errors import SpringpotError
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify, recorded

from .cases import Case

DETECTED, NAMED = 30.0, 60.0
"""Chi-square of what the base model misses, beyond noise, from which it should be seen, and named.

As in the study of sweeps.
"""
NEAR_FLOOR = (0.95, 1.05)


@dataclass(frozen=True)
class Verdict:
    """One case, counted.

    Attributes
    ----------
    visible : float
        Chi-square of the base fit beyond that of the true model.
    verdict : str
        Of the diagnosis.
    missing : tuple of str
        The class that it named.
    after, oracle : float
        Error over the floor with the best effect, and with the true one.
    seconds : float
        Processor time of the diagnosis.
    """

    index: int
    kind: str
    base: str
    hidden: str
    outside: bool
    points: int
    memory: float
    visible: float
    verdict: str
    missing: tuple[str, ...]
    delta: float
    after: float
    oracle: float
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    @property
    def flagged(self) -> bool:
        """Whether something is said to be missing."""
        return self.verdict in ("effect-missing", "unexplained")

    @property
    def right(self) -> bool:
        """Whether the true effect is in the class that was named."""
        return self.hidden in self.missing


def library() -> list[Any]:
    """All that is installed."""
    return list(plugins().items("effect"))


def judged(case: Case, index: int, effects: Sequence[Any]) -> Verdict:
    """Diagnose one case."""
    model = parse_model(case.setting.base)
    base = identify(case.test, model)
    began = process_time()
    found = diagnose(case.test, model, effects)
    seconds = process_time() - began
    left = recorded(model, base.theta, case.test).value - case.test.response
    noise = case.exact - case.test.response
    # What the true model leaves is the mark; where there is none to fit, the noise that was drawn.
    oracle = _oracle(case, base.theta)
    if oracle is None:
        oracle = noise
    best, delta = found.error.over_floor, 0.0
    if found.best is not None:
        best = found.candidates[0].over_floor
    if found.candidates:
        delta = found.candidates[0].delta_bic
    # The floor in the unit of the record: the error of the base fit over how many times the noise
    # it is said to be.
    floor = found.error.noise_floor / max(found.error.relative_rms, 1e-300)
    size = _rms(left) * floor
    return Verdict(
        index=index,
        kind=case.setting.kind,
        base=case.setting.base,
        hidden=case.hidden,
        outside=case.outside,
        points=len(case.test),
        memory=case.memory,
        visible=_squares(left, case) - _squares(oracle, case),
        verdict=found.verdict,
        missing=found.leading,
        delta=delta,
        after=best,
        oracle=_rms(oracle) / size,
        seconds=seconds,
    )


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _squares(residual: Any, case: Case) -> float:
    """Chi-square over the true noise."""
    seen = residual
    # At the instant of a step a springpot's force has no limit.
    if not np.isfinite(residual[0]):
        seen = residual[1:]
    white = np.diff(seen, prepend=0.0) + (1.0 - case.memory) * np.concatenate([[0.0], seen[:-1]])
    white[0] = seen[0] * np.sqrt(1.0 - case.memory**2)
    return float(np.sum(white**2) / (case.sd**2 * (1.0 - case.memory**2)))


def _oracle(case: Case, theta: Any) -> Any:
    """What the true model leaves, fitted from the truth."""
    if not case.hidden or case.outside:
        return None
    model = parse_model(case.setting.base) + case.hidden
    values = dict(case.setting.theta) | {
        f"{case.hidden}.{name}": value for name, value in case.setting.truth.items()
    }
    try:
        fit = identify(case.test, model, seeds=[model.vector(values)], thorough=False)
    except SpringpotError:
        return None
    return recorded(model, fit.theta, case.test).value - case.test.response
