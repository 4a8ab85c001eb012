"""What an invention says, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.diagnosis.grown import Search
from springpot.diagnosis.result import NextExperiment
from springpot.drawing import draw, html_of, text_of
from springpot.errors import ModelError
from springpot.identification.value import Value, values_of
from springpot.misfit.error import Error
from springpot.plain_data import alive, jsonable
from springpot.registry import parse_model
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.typed import law

from .weighing import Verdict, Weighed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
        known = dict(row)
        known |= {"parameters": values_of(row["parameters"]), "like": tuple(row["like"])}
        law(row["text"])
        return cls(alike=tuple(known.pop("class")), **known)


@dataclass(frozen=True, eq=False)
class Invention:
    """The answer to the question which law is missing.

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
    >>> omega, X = np.tile(np.geomspace(3, 300, 12), 4), np.repeat([0.2, 0.5, 1.0, 3.0], 12)
    >>> model = springpot.parse_model("fractional-maxwell + (series: X^n/k)")
    >>> at = springpot.Measurement(omega, omega + 0j, conditions={"amplitude": X}).points
    >>> exact = model.stiffness(np.array([400.0, 60.0, 0.5, 900.0, 0.7]), at)
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=(2, 48))
    >>> noisy = exact * (1 + noise[0] + 1j * noise[1])
    >>> found = springpot.invent(springpot.Measurement(omega, noisy, conditions={"amplitude": X}))
    >>> found.verdict, found.laws[0].text
    ('class', 'series: X^n/k')
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

    def __str__(self) -> str:
        return text_of(self)

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
        twice = ("error_before", "noise_floor")
        rows = [{k: v for k, v in row.items() if k not in twice} for row in answer["laws"]]
        following = answer["next_experiment"]
        return cls(
            data=answer["data"],
            model=parse_model(answer["model"]),
            verdict=answer["verdict"],
            says=answer["says"],
            error=Error.from_dict(answer["error"]),
            laws=tuple(FoundLaw.from_dict(row) for row in rows),
            next_experiment=following and NextExperiment.from_dict(following),
            notes=tuple(answer["notes"]),
            tried=answer["tried"],
        )

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None
    ) -> Figure | Axes | Path:
        """Data, model and law; see `springpot.drawing.draw`."""
        return draw(self, path, ax)

    def _repr_html_(self) -> str:
        return html_of(self)
