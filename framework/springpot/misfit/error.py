"""The error of a model between the noise floor and the material floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from springpot.identification.value import in_floors
from springpot.plain_data import jsonable, number
from springpot.thresholds import SCATTER


@dataclass(frozen=True)
class Error:
    """Error of the model against the noise floor and the material floor, all relative to |K|.

    Of tests in time that of the test which the model misses most, relative to its signal.

    Attributes
    ----------
    relative_rms : float
        Root mean square of |K_model - K| / |K|.
    noise_floor : float
        The same for noise alone.
    noise_source : {"given", "repeats", "estimated", "residual", "signal"}
        Where the noise comes from; of tests in time ``residual``, the upper part of the residual's
        spectrum, or ``signal`` where there are too few samples for one.
    doubt : str
        One sentence where given standard deviations disagree with the data's own scatter.
    material_floor : float
        The least error that any linear passive material reaches beside the model's effects.
    material_chance : float
        That noise alone leaves a residual like that material's. Both are nan where no material was
        looked for.
    noise_memory : float, optional
        Of tests in time: correlation of neighbouring samples of the noise.
    test : str, optional
        The test of which all of this is told, where there are several.
    """

    relative_rms: float
    noise_floor: float
    noise_source: str
    doubt: str = ""
    material_floor: float = 0.0
    material_chance: float = 1.0
    noise_memory: float | None = None
    test: str = ""

    @property
    def is_hardly_noise(self) -> bool:
        """Whether an error is too large for what is called noise.

        Scatter about models, or of unequal repeats.
        """
        if self.noise_source == "repeats":
            return self.noise_floor > SCATTER.repeats_alike
        return self.noise_source == "estimated" and self.relative_rms > SCATTER.believed

    @property
    def over_floor(self) -> float:
        """The error in noise floors."""
        return in_floors(self.relative_rms, self.noise_floor)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas."""
        row = {**vars(self), "over_floor": self.over_floor}
        if self.noise_memory is None:
            del row["noise_memory"]
        if not self.test:
            del row["test"]
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Error:
        """What `to_dict` gave."""
        return cls(
            relative_rms=float(row["relative_rms"]),
            noise_floor=number(row["noise_floor"]),
            noise_source=row["noise_source"],
            doubt=row["doubt"],
            material_floor=number(row["material_floor"]),
            material_chance=number(row["material_chance"]),
            noise_memory=row.get("noise_memory"),
            test=row.get("test", ""),
        )

    @property
    def advice(self) -> str:
        """What to do about noise that is hard to believe."""
        if self.noise_source == "repeats":
            return (
                f"rows that differ by {100 * self.noise_floor:.2g} % are no repeats of each other:"
                " judge them apart"
            )
        return f"noise of {100 * self.noise_floor:.2g} % is no good measurement: repeat it"
