"""The ladder: effects accepted one after the other, and the error falling to the noise floor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from springpot.drawing import draw, html_of, text_of
from springpot.identification import require_conditions
from springpot.measurement import Measurement
from springpot.rheology import Effect, Model

from .diagnose import Case, Progress, examine, printed, silent, within
from .policy import LADDER, SEARCH
from .refit import Refit, refit
from .result import Diagnosis, Value, Verdict
from .search import scan_effects
from .unseen import prediction_gain

MOST_HIDDEN = 2
"""Effects that may be accepted from an unexplained rung on, if they complete the model."""
LONGEST = 6
"""Effects accepted at most."""


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Step:
    """One rung: a model, what was accepted to reach it, and its error against the floor.

    Attributes
    ----------
    model : Model
        The model of this rung.
    accepted : str or None
        The effect that was added, None for the first rung.
    relative_rms, noise_floor, material_floor : float
        Relative error, what noise alone leaves, and the least that any material reaches with the same effects.
    predicted_error : float or None
        What the rung before foretold.
    parameters : dict of str to Value
        All parameters with their intervals.
    changed : dict of str to float
        Old parameters that moved by more than their interval, with the ratio new over old.
    case : Case
        The examination of this rung's model: fit, noise, scan and diagnosis.
    alike : tuple of str
        Effects that the data could not tell from the accepted one, itself included.
    """

    model: Model
    accepted: str | None
    relative_rms: float
    noise_floor: float
    material_floor: float
    predicted_error: float | None
    parameters: dict[str, Value]
    changed: dict[str, float]
    case: Case
    alike: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Step {self.model.name}: error {self.relative_rms / self.noise_floor:.3g} x floor>"

    def to_dict(self) -> dict[str, Any]:
        """As in the schema."""
        told = ("accepted", "relative_rms", "noise_floor", "material_floor", "predicted_error")
        row = {name: getattr(self, name) for name in told}
        values = {name: asdict(value) for name, value in self.parameters.items()}
        return {
            "model": self.model.name,
            **row,
            "material_chance": self.case.diagnosis.error.material_chance,
            "class": list(self.alike),
            "parameters": values,
            "changed": self.changed,
        }


@dataclass(frozen=True, eq=False)
class Ladder:
    """Steps from the user's model to the last accepted one, with the last diagnosis."""

    data: str
    steps: tuple[Step, ...]
    verdict: Verdict
    diagnosis: Diagnosis

    @property
    def model(self) -> Model:
        """The model of the last rung."""
        return self.steps[-1].model

    def __str__(self) -> str:
        return text_of(self)

    def __repr__(self) -> str:
        errors = " -> ".join(f"{step.relative_rms / step.noise_floor:.3g}" for step in self.steps)
        return f"<Ladder {self.model.name} of {self.data}: error {errors} x floor; {self.verdict}>"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.discovery/1``."""
        return {
            "schema": "springpot.discovery/1",
            "data": self.data,
            "steps": [step.to_dict() for step in self.steps],
            "verdict": self.verdict,
            "diagnosis": self.diagnosis.to_dict(),
        }

    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure | Axes | Path:
        """The error falling to the noise floor; see `springpot.drawing.draw`."""
        return draw(self, path, ax)

    def _repr_html_(self) -> str:
        return html_of(self)


Reached: TypeAlias = Callable[[Ladder], None]


def discover(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    accept: Sequence[Effect] | None = None,
    progress: Progress = silent,
    reached: Reached | None = None,
) -> Ladder:
    """Accept effects until nothing significant is left, or the given ones in order.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        Where to begin.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    accept : sequence of Effect, optional
        Effects to accept in this order; without it every decision is taken by the evidence.
    progress : callable
        Told in a few words what is being done.
    reached : callable, optional
        Given the ladder as it stands after each rung, so that what was reached is there even if the rest is
        interrupted. The ladder that is returned may be shorter: rungs that led nowhere are taken back.
    """
    case = examine(measurement, model, library, rng, progress=within("step 0", progress))
    steps = [_step(case, None, None)]
    _hand_out(measurement, steps, reached)
    wanted = list(accept) if accept is not None else None
    while _open(steps) if wanted is None else wanted:
        effect = _decisive(case) if wanted is None else wanted.pop(0)
        if effect is None:
            break
        predicted = _predicted(case, effect)
        rung = within(f"step {len(steps)}", progress)
        previous, case = case, _grown(measurement, case, effect, library, rng, rung)
        steps.append(replace(_step(case, effect.name, predicted, previous), alike=_alike(previous, effect)))
        _hand_out(measurement, steps, reached)
    if accept is None:
        steps = _explained(steps)
        case = steps[-1].case
    if accept is None and len(steps) > 2:
        rung = within(f"step {len(steps)}", progress)
        case, steps = _pruned(measurement, case, steps, library, rng, rung)
    return _ladder(measurement, steps)


def _ladder(measurement: Measurement, steps: Sequence[Step]) -> Ladder:
    """The ladder that ends with the last of these steps."""
    diagnosis = steps[-1].case.diagnosis
    return Ladder(measurement.name, tuple(steps), diagnosis.verdict, diagnosis)


def _hand_out(measurement: Measurement, steps: Sequence[Step], reached: Reached | None) -> None:
    """Give away what there is so far."""
    if reached is not None:
        reached(_ladder(measurement, steps))


def _open(steps: Sequence[Step]) -> bool:
    """Whether further rungs could count: see `_explained`."""
    verdicts = [step.case.diagnosis.verdict for step in steps]
    beyond = len(verdicts) - 1 - verdicts.index("unexplained") if "unexplained" in verdicts else 0
    return len(steps) <= LONGEST and beyond < MOST_HIDDEN


def _grown(
    measurement: Measurement,
    case: Case,
    effect: Effect,
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress,
) -> Case:
    """The next rung, fitted also from the smaller model with the effect as the scan saw it: it cannot do worse."""
    base = case.search.base
    require_conditions(base.model + effect, measurement)
    seeds = [start for score in scan_effects(base, case.search.frame, [effect]).scores for start in score.starts]
    seeds += [grown.refit.theta for grown in case.search.grown if grown.names == (effect.name,)]
    return examine(measurement, base.model + effect, library, rng, seeds, progress)


def _decisive(case: Case) -> Effect | None:
    """The effect whose absence is beyond doubt, if there is one."""
    diagnosis = case.diagnosis
    if diagnosis.verdict not in ("effect-missing", "unexplained") or not diagnosis.candidates:
        return None
    if case.naming.alarm > LADDER.clear or case.naming.gain < SEARCH.decisive:
        return None
    return diagnosis.candidates[0].physics


def _explained(steps: list[Step]) -> list[Step]:
    """The rungs up to the first that no effect explains, and those beyond it that have shown to be physics.

    Effects that hide one another can leave a rung unexplained that two more steps explain; where they do not, they
    may only have been fitted to what is no effect of the library. What predicts data that were left out much better
    than the model before, such as a shift of moduli beside a shift of times, stays; the rest is still unexplained.
    """
    verdicts = [step.case.diagnosis.verdict for step in steps]
    if "unexplained" not in verdicts:
        return steps
    first = verdicts.index("unexplained")
    if verdicts[-1] in ("adequate", "inconclusive") and len(verdicts) - 1 - first <= MOST_HIDDEN:
        return steps
    kept = first + 1
    while kept < len(steps):
        before, after = (step.case.search.base for step in steps[kept - 1 : kept + 1])
        if prediction_gain(before, after) > LADDER.predicts:
            break
        kept += 1
    return steps[:kept]


def _predicted(case: Case, effect: Effect) -> float | None:
    foretold = (each.predicted_error for each in case.diagnosis.candidates if each.effect == effect.name)
    return next(foretold, None)


def _alike(case: Case, effect: Effect) -> tuple[str, ...]:
    alike = (each.alike for each in case.diagnosis.candidates if each.effect == effect.name)
    return next(alike, (effect.name,))


def _step(case: Case, accepted: str | None, predicted: float | None, before: Case | None = None) -> Step:
    base = case.search.base
    parameters = printed(base)
    changed = {}
    if before is not None:
        for name, old in printed(before.search.base).items():
            new = parameters.get(name)
            if new is not None and old.value and not old.low <= new.value <= old.high:
                changed[name] = new.value / old.value
    error = case.diagnosis.error
    errors = error.relative_rms, error.noise_floor, error.material_floor
    return Step(base.model, accepted, *errors, predicted, parameters, changed, case)


def _pruned(
    measurement: Measurement,
    case: Case,
    steps: list[Step],
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[Case, list[Step]]:
    """Drop accepted effects that later ones have made needless."""
    base = case.search.base
    added = [step.accepted for step in steps[1:] if step.accepted]
    for name in added[:-1]:
        smaller: Refit = refit(base.model - name, base.data, base.noise)
        if smaller.log_evidence > base.log_evidence:
            previous, case = case, examine(measurement, smaller.model, library, rng, progress=progress)
            dropped = replace(_step(case, None, None, previous), accepted=f"-{name}")
            return case, [*steps, dropped]
    return case, steps
