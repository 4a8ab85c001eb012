"""Models against one set of data and one noise floor: which fails, where, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

from springpot.errors import DataError, OptionError
from springpot.identification import require_conditions
from springpot.measurement import Measurement
from springpot.rheology import Model

from .candidates import printed
from .display import html_of_comparison
from .findings import Finding, findings, judged
from .floor import fitted_to_floor
from .overtones import overtones
from .refit import Refit, refit
from .result import Error, Where
from .where import where
from .words import times

SCHEMA = "springpot.comparison/1"
STARTS = 4
MOST_PLACES = 3
"""Places named in the sentence on a model; all are in `where`."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """One model against the data.

    Attributes
    ----------
    refit : Refit
        Its fit, in units of the noise.
    error : Error
        Its error and the noise floor, relative to |K|.
    delta_bic : float
        Bayesian information criterion above that of the best model compared.
    where : tuple of Where
        Where it fails.
    findings : tuple of Finding
        Tests on its residual.
    """

    refit: Refit
    error: Error
    delta_bic: float
    where: tuple[Where, ...]
    findings: tuple[Finding, ...]

    @property
    def model(self) -> Model:
        """The model."""
        return self.refit.model

    @property
    def fails(self) -> bool:
        """Whether any test found something."""
        return any(finding.found for finding in self.findings)

    @property
    def says(self) -> str:
        """The judgement in one sentence."""
        ratio = f"error {times(self.error.relative_rms / self.error.noise_floor)} the noise floor"
        if not self.fails:
            return f"{ratio}; nothing is left but noise"
        if not self.where:
            return f"{ratio}; {next(finding.says for finding in self.findings if finding.found)}"
        return f"{ratio}; {'; '.join(place.says for place in self.where[:MOST_PLACES])}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "model": self.model.name,
            "error": asdict(self.error),
            "chi_square": self.refit.rss,
            "degrees_of_freedom": self.refit.fit.dof,
            "delta_bic": self.delta_bic,
            "fails": self.fails,
            "says": self.says,
            "parameters": {name: asdict(value) for name, value in printed(self.refit).items()},
            "where": [place.to_dict() for place in self.where],
            "tests": [finding.to_dict() for finding in self.findings],
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several models against the same data.

    Attributes
    ----------
    data : str
        Name of the data.
    judgements : tuple of Judgement
        One for each model, in the order in which they were given.
    harmonics : tuple of Finding
        What the force harmonics say, whatever the model.
    notes : tuple of str
        What else the user should know.
    """

    data: str
    judgements: tuple[Judgement, ...]
    harmonics: tuple[Finding, ...]
    notes: tuple[str, ...]

    @property
    def best(self) -> Judgement:
        """The model with the least information criterion."""
        return min(self.judgements, key=lambda judgement: judgement.delta_bic)

    @cached_property
    def measurement(self) -> Measurement:
        """The data, repeats averaged, with the standard deviations of the noise floor."""
        found = self.judgements[0].refit
        return replace(found.data.mean, sd=found.noise.sd)

    def __repr__(self) -> str:
        errors = ", ".join(
            f"{one.model.name} {one.error.relative_rms / one.error.noise_floor:.3g} x floor"
            for one in self.judgements
        )
        return f"<Comparison of {self.data}: {errors}>"

    def _repr_html_(self) -> str:
        return html_of_comparison(self)

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison/1``."""
        return {
            "schema": SCHEMA,
            "data": self.data,
            "best": self.best.model.name,
            "models": [judgement.to_dict() for judgement in self.judgements],
            "harmonics": [finding.to_dict() for finding in self.harmonics],
            "notes": list(self.notes),
        }


def compare(measurement: Measurement, models: Sequence[Model]) -> Comparison:
    """Fit models and judge each against the noise floor that they share.

    The floor is the lowest that any of the models finds: a model that fails takes part of its failure for noise.

    Parameters
    ----------
    measurement : Measurement
        The data.
    models : sequence of Model
        At least one.

    Raises
    ------
    OptionError
        If there is no model.
    ModelError
        If the data lack a column that a model needs.
    DataError
        If there are too few data to judge a model.
    """
    if not models:
        raise OptionError("nothing to compare: give at least one model")
    fits = _fits(measurement, models)
    quiet = fits[0]
    least = min(-2.0 * fit.log_evidence for fit in fits)
    judgements = tuple(_judgement(fit, -2.0 * fit.log_evidence - least) for fit in fits)
    harmonics = judged(overtones(quiet.data.mean, quiet.noise.sd))
    notes = (quiet.noise.doubt,) if quiet.noise.doubt else ()
    return Comparison(measurement.name, judgements, tuple(harmonics), notes)


def _fits(measurement: Measurement, models: Sequence[Model]) -> list[Refit]:
    """Fits of all models in units of one noise."""
    for model in models:
        require_conditions(model, measurement)
    first = [fitted_to_floor(model, measurement) for model in models]
    for found in first:
        if found.fit.dof < 1:
            raise DataError(
                f"{measurement.name}: {len(found.fit.measurement)} points cannot judge {found.model.name}, which has "
                f"{len(found.theta)} parameters; measure at more frequencies"
            )
    quiet = min(first, key=lambda found: found.floor)
    return [
        found if found is quiet else refit(found.model, quiet.data, quiet.noise, [found.theta], starts=STARTS)
        for found in first
    ]


def _judgement(found: Refit, delta_bic: float) -> Judgement:
    frame, noise = found.frame(), found.noise
    error = Error(found.relative_rms, found.floor, noise.source, noise.doubt)
    return Judgement(found, error, delta_bic, tuple(where(frame)), tuple(findings(frame, noise.source)))
