"""All that a diagnosis of a sweep found, for those who go on from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from springpot.errors import ModelError
from springpot.identification.space import require_conditions
from springpot.misfit.drift_search import Course
from springpot.misfit.material import MaterialFloor
from springpot.misfit.outliers import (
    Outlier,
)
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .grown import Search
from .result import Diagnosis
from .scan import scan_effects

if TYPE_CHECKING:
    from .evidence import Evidence


class GrownBy(NamedTuple):
    """A model with one more effect.

    Attributes
    ----------
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters.
    refitted : bool
        Whether it was fitted with the effect; else the effect stands where the scan puts it, and
        the rest as before.
    """

    model: Model
    theta: Real
    refitted: bool


@dataclass(frozen=True, eq=False)
class Case:
    """All that a diagnosis found, for those who go on from it.

    Attributes
    ----------
    search : Search
        Fits and scans of the model.
    naming : Search
        Those by which effects are named: of the model, or of any material where the model does not
        follow it.
    floor : MaterialFloor
        The least error that any material reaches.
    evidence : Evidence
        Of every effect.
    outliers : tuple of Outlier
        Points set aside.
    diagnosis : Diagnosis
        The answer.
    course : Course or None
        How the specimen changed with time, where that is what the misfit goes with.
    drawn : mapping or None
        State of the generator of simulated noise after it, from which a further rung goes on.
    """

    search: Search
    naming: Search
    floor: MaterialFloor
    evidence: Evidence
    outliers: tuple[Outlier, ...]
    diagnosis: Diagnosis
    course: Course | None = None
    drawn: Mapping[str, Any] | None = None

    def __repr__(self) -> str:
        return f"<Case {self.diagnosis!r:.200}>"

    def grown_with(self, effect: Effect) -> GrownBy:
        """The model as accepting one effect would make it, without a new fit.

        Parameters
        ----------
        effect : Effect
            Scanned or not: the ``physics`` of a candidate, or any other.

        Raises
        ------
        ModelError
            If the model cannot take the effect, the data lack a column that it needs, or nothing is
            known of it.

        Examples
        --------
        >>> import springpot
        >>> ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept="inertia")
        >>> case = ladder.steps[0].case
        >>> grown = case.grown_with(case.diagnosis.best.physics)
        >>> grown.model.name, grown.refitted
        ('fractional-maxwell + inertia', True)
        """
        base = self.search.base
        # A fit that was made is better than what the scan foretells of it.
        for grown in self.search.grown:
            if grown.names == (effect.name,):
                return GrownBy(grown.refit.identified.model, grown.refit.identified.theta, True)
        if effect.by_levels:
            raise ModelError(
                f"{effect.name} has a factor for each level, which only a fit can tell"
            )
        if not effect.element.parameters:
            raise ModelError(f"{effect.name} has no parameter, and nothing of it can be fitted")
        require_conditions(base.model + effect, base.fit.measurement)
        scores = [score for score in self.search.scan.scores if score.influence.effect == effect]
        for score in scores or scan_effects(base, self.search.frame, [effect]).scores:
            for theta in score.starts[:1]:
                return GrownBy(score.influence.model, theta, False)
        raise ModelError(f"{effect.name} changes nothing that these data show of {base.model.name}")
