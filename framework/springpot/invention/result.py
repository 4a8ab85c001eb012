"""What an invention says, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from springpot.diagnosis.evidence import distance, log_prior_of_one
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.marginal import harmonic_evidence, marginal
from springpot.diagnosis.result import NextExperiment
from springpot.diagnosis.scan import applicable, possible, scan_effects
from springpot.diagnosis.search import grown_with
from springpot.errors import ModelError
from springpot.identification.leastsquares import Effort
from springpot.identification.value import Value
from springpot.lazy import Drawn, Printed
from springpot.misfit.error import Error
from springpot.misfit.floor import is_arithmetic
from springpot.numerics import NEGLIGIBLE
from springpot.plain_data import alive, jsonable, read
from springpot.registry import parse_model
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.typed import law
from springpot.thresholds import EVIDENCE, INVENTION, VERDICT

from .grammar import symbols

Verdict = Literal["law", "class", "none"]


@dataclass(frozen=True)
class Weighed:
    """A fitted law and how likely it is.

    Attributes
    ----------
    grown : Grown
        The model with it.
    log_weight : float
        Log of its marginal likelihood and prior.
    probability : float
        Beside the other laws.
    """

    grown: Grown
    log_weight: float
    probability: float

    @property
    def effect(self) -> Effect:
        """The law."""
        return self.grown.effects[0]


def weighed(search: Search) -> list[Weighed]:
    """The laws that were fitted, each formula once, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    best: dict[str, Grown] = {}
    for grown in search.grown:
        best.setdefault(grown.effects[0].name, grown)
    rivals = [grown for grown in best.values() if _is_rival(search, grown)]
    if not rivals:
        return []
    exact = [grown for grown in best.values() if is_arithmetic(grown.refit)]
    if exact:
        # What is left is rounding, and says nothing: the shortest formula is the law.
        rivals = exact
        logs = np.array([search.best.log_likelihood + _log_prior(g.effects[0]) for g in exact])
    else:
        logs = np.array([marginal(search, g) + _log_prior(g.effects[0]) for g in rivals])
    chances = np.exp(logs - logs.max())
    chances = chances / chances.sum()
    rows = zip(rivals, logs.tolist(), chances.tolist(), strict=True)
    return sorted((Weighed(*row) for row in rows), key=lambda law: -law.log_weight)


def _is_rival(search: Search, grown: Grown) -> bool:
    """Whether its price could still decide: a law far from the data needs none."""
    return grown.refit.log_likelihood > search.best.log_likelihood - INVENTION.hopeless


def _log_prior(effect: Effect) -> float:
    """The longer a formula, the more of its length there are."""
    return log_prior_of_one(1.0) - INVENTION.symbol * symbols(effect)


def rivals_of(laws: Sequence[Weighed]) -> list[Weighed]:
    """The class of the likeliest law: those that these data cannot tell from it.

    Of laws that have become one the shortest stands for all.
    """
    kept: list[Weighed] = []
    for one in laws:
        if one.log_weight <= laws[0].log_weight - EVIDENCE.rivals:
            continue
        place = next((i for i, other in enumerate(kept) if _is_same(one, other)), len(kept))
        if place == len(kept):
            kept.append(one)
        elif symbols(one.effect) < symbols(kept[place].effect):
            longer = kept[place]
            kept[place] = replace(longer, grown=one.grown)
    return kept


def _is_same(law: Weighed, other: Weighed) -> bool:
    """Whether a law has become another one, as c omega^a does where a is nothing."""
    frame = other.grown.refit.frame()
    return distance(frame, law.grown.refit, other.grown.refit) < INVENTION.same


def nothing(search: Search) -> float:
    """Log-evidence that no law is missing."""
    complete = search.base.log_likelihood + harmonic_evidence(search.base)
    return complete + float(np.log(EVIDENCE.prior_nothing))


def verdict_of(search: Search, laws: Sequence[Weighed]) -> Verdict:
    """Whether a law is found, a class of them, or none.

    One is found where noise alone is no credible cause of the misfit, the evidence prefers the law,
    and what it leaves is noise.
    """
    if not laws or search.alarm >= INVENTION.alarm:
        return "none"
    clear = laws[0].log_weight > nothing(search) + EVIDENCE.as_good
    structure = search.left.p_value < VERDICT.structure_alarm
    if not clear or (structure and not is_arithmetic(laws[0].grown.refit)):
        return "none"
    return "law" if len(rivals_of(laws)) == 1 else "class"


def known_alike(search: Search, law: Weighed, library: Sequence[Effect]) -> list[Grown]:
    """Effects with a name that these data cannot tell from a law, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    law : Weighed
        The law.
    library : sequence of Effect
        Effects with a name.
    """
    effects = possible(search.base, applicable(library, search.base.fit.measurement))
    scores = scan_effects(search.base, search.frame, effects).scores[: INVENTION.known]
    effort = Effort(NEGLIGIBLE, law.grown.refit.rss + 2.0 * INVENTION.hopeless)
    grown = [grown_with(search, score, effort) for score in scores]
    least = law.grown.refit.log_likelihood - EVIDENCE.rivals
    alike = [each for each in grown if each.refit.log_likelihood > least]
    return sorted(alike, key=lambda each: -each.refit.log_likelihood)


SCHEMA = "springpot.invention/1"


@dataclass(frozen=True)
class FoundLaw:
    """A law that was found.

    Attributes
    ----------
    text : str
        As it is typed: ``parallel: i*k*X^(-n)``.
    plane : str
        In which it joins the model: ``parallel``, ``series``, ``chain`` or ``shift``.
    probability : float
        Beside the other laws that were tried, one of them being right.
    alike : tuple of str
        Laws that these data cannot tell from it, itself included.
    parameters : dict of str to Value
        With their intervals.
    error_after : float
        Relative error of the model with it.
    causal : bool
        Whether it follows from what was; what does not is an instrument's fault, or no law.
    passive : bool or None
        Whether it gives out no energy; None of a factor, which has none of its own.
    like : tuple of str
        Effects with a name that these data cannot tell from it.
    says : str
        What kind of law it is, and what the named ones would be.
    """

    text: str
    plane: str
    probability: float
    alike: tuple[str, ...]
    parameters: dict[str, Value]
    error_after: float
    causal: bool
    passive: bool | None
    like: tuple[str, ...]
    says: str

    def effect(self, name: str = "law-1") -> Effect:
        """The law as an effect, to be added to a model or written as a plugin."""
        return law(self.text, name)

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where `alike` is called class."""
        row = {"class" if name == "alike" else name: value for name, value in vars(self).items()}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> FoundLaw:
        """What `to_dict` gave."""
        law(row["text"])
        return read(cls, row, alike=tuple(row["class"]))


@dataclass(frozen=True, eq=False)
class Invention(Drawn, Printed):
    """The answer to the question which law is missing.

    Its picture has the data, the model and the law.

    Attributes
    ----------
    data : str
        What was measured.
    model : Model
        What the law is missing from.
    verdict : {"law", "class", "none"}
        One law, several that these data cannot tell apart, or none.
    says : str
        The verdict in one sentence.
    error : Error
        The model's error before, the noise floor and the material floor.
    laws : tuple of FoundLaw
        The likeliest first; where none is found those that come nearest.
    next_experiment : NextExperiment or None
        What would tell the class apart.
    notes : tuple of str
        What these data cannot tell at all.
    tried : int
        Laws that were held against the data.
    searched : Search, optional
        The fits behind it; a file does not hold them.
    ranked : tuple of Weighed
        The whole class, fitted, of which `laws` tells the first; none of a file.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> omega, X = np.tile(np.geomspace(1, 100, 8), 3), np.repeat([0.2, 1.0, 3.0], 8)
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=(2, 24))
    >>> softening = (10 + 1j * omega + 5 * X**-0.5) * (1 + noise[0] + 1j * noise[1])
    >>> data = springpot.Measurement(omega, softening, conditions={"amplitude": X})
    >>> found = springpot.invent(data, "kelvin")
    >>> found.verdict, found.laws[0].text
    ('class', 'parallel: k*X^(-n)')
    """

    data: str
    model: Model
    verdict: Verdict
    says: str
    error: Error
    laws: tuple[FoundLaw, ...]
    next_experiment: NextExperiment | None
    notes: tuple[str, ...]
    tried: int
    searched: Search | None = None
    ranked: tuple[Weighed, ...] = ()

    @property
    def best(self) -> FoundLaw | None:
        """The likeliest law, or None where none is found."""
        if self.verdict == "none":
            return None
        return self.laws[0]

    @property
    def search(self) -> Search:
        """The fits behind it."""
        return alive(self.searched, Search, f"the invention of {self.data}")

    def effect(self, name: str = "law-1") -> Effect:
        """The likeliest law as an effect.

        Raises
        ------
        ModelError
            If none was found.
        """
        if self.best is None:
            raise ModelError(f"no law was found of {self.data}: {self.says}")
        return self.best.effect(name)

    def __repr__(self) -> str:
        found = "".join(f", {law.text}" for law in filter(None, [self.best]))
        return f"<Invention of {self.data} beside {self.model.name}: {self.verdict}{found}>"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.invention/1``."""
        row: dict[str, Any] = {
            "schema": SCHEMA,
            "data": self.data,
            "model": self.model.name,
        }
        row |= {"verdict": self.verdict, "says": self.says, "error": self.error}
        row["laws"] = [
            {
                **law.to_dict(),
                "error_before": self.error.relative_rms,
                "noise_floor": self.error.noise_floor,
            }
            for law in self.laws
        ]
        row |= {"next_experiment": self.next_experiment, "notes": self.notes, "tried": self.tried}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Invention:
        """What `to_dict` gave."""
        return read(cls, answer, model=parse_model(answer["model"]))
