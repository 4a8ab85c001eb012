"""A plugin of springpot with one of each kind.

This file and the entry point in pyproject.toml are all it takes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from springpot.errors import DataError
from springpot.hooks import hookimpl
from springpot.identification import Card, Objective, Optimiser, Recorder
from springpot.measurement import (
    MODULUS_UNITS,
    Choice,
    DataSet,
    Measurement,
    Reader,
    Record,
    Units,
    known_unit,
)
from springpot.rheology import (
    PURE,
    RADIAN_PER_SECOND,
    Answered,
    AppliesTo,
    Complex,
    Effect,
    Formula,
    Layer,
    Model,
    Parameter,
    Points,
    StageLaw,
    chain,
    dashpot,
    on_response,
    parallel,
    relaxation_time,
    series,
    spring,
    springpot,
)

# A model: elements put together. Its derivatives, bounds, units and drawing follow from them.

MODEL = Model(
    "example-model",
    parallel(dashpot("c0"), series(spring("k"), springpot("c", "alpha"))),
    "fractional Maxwell element in a Newtonian solvent",
    "Schiessel et al. 1995, doi:10.1088/0305-4470/28/23/012",
    aliases=("damper-in-solvent",),
)


@hookimpl
def springpot_models() -> Iterable[Model]:
    """One model."""
    return [MODEL]


# An effect: an element and the way in which it joins a model. This element is a law of its own,
# with its derivatives.


def high_pass(at: Points, omega_c: Any) -> Any:
    """H = i omega / (i omega + omega_c), dH / d omega_c and dH / d ln omega."""
    below = 1j * at.omega + omega_c
    value = 1j * at.omega / below
    return value, (-value / below,), value * omega_c / below


EFFECT = Effect(
    "charge-amplifier",
    chain,
    Formula((Parameter("omega_c", "ω_c", RADIAN_PER_SECOND),), high_pass, kind="high-pass"),
    "a charge amplifier loses the force below its corner frequency omega_c and advances its phase",
    Layer.SIGNAL,
    "Gautschi, Piezoelectric Sensorics, 2002",
)


# An effect of tests in time: what is recorded of a response, and its derivatives. Both are offered.


def sagged(record: Record, response: Any, size: Any, tau: Any) -> Answered:
    """The response without what a piezoelectric transducer has lost since the load moved."""
    time = np.maximum(record.time, 0.0)
    lost = 1.0 - np.exp(-time / tau)
    by_tau = size * response * (1.0 - lost) * time / tau**2
    return Answered(response * (1.0 - size * lost), (-response * lost, by_tau), 1.0 - size * lost)


SHARE = Parameter("size", "s", PURE, 0.0, 1.0, "linear", 0.1)
OF_A_TEST = Effect(
    "charge-loss",
    on_response,
    StageLaw(sagged, (SHARE, relaxation_time("tau"))),
    "a piezoelectric transducer loses the share s of its charge within some tau",
    citation="Gautschi, Piezoelectric Sensorics, 2002",
    signature="a force that sags with the transducer's own time, however long the load is held",
    applies_to=AppliesTo(("displacement",)),
)


@hookimpl
def springpot_effects() -> Iterable[Effect]:
    """Two effects, which from now on take part in the diagnosis of their tests."""
    return [EFFECT, OF_A_TEST]


# An optimiser: a frozen dataclass of options with one method. The recorder counts, keeps the best
# and ends the run.


@dataclass(frozen=True)
class OneFifth(Optimiser):
    """The (1+1) evolution strategy: a random step that grows with success.

    Parameters
    ----------
    step : float
        The first step as a fraction of the box.
    """

    step: float = 0.2
    name: ClassVar[str] = "example-optimiser"
    card: ClassVar[Card] = Card(
        "(1+1) evolution strategy, one-fifth rule", "Rechenberg, Evolutionsstrategie, 1973"
    )

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Step until the recorder ends it."""
        low, high, step = problem.lower, problem.upper, self.step
        x = low + (high - low) * rng.random(problem.dimension)
        best = problem(x)
        while True:
            trial = np.clip(x + step * (high - low) * rng.normal(size=len(x)), low, high)
            value = problem(trial)
            if value <= best:
                x, best, step = trial, value, min(1.0, 1.5 * step)
            else:
                step *= 1.5**-0.25


@hookimpl
def springpot_optimisers() -> Iterable[type[Optimiser]]:
    """One optimiser: the class, not an instance."""
    return [OneFifth]


# An objective
def _mostly_storage(measurement: Measurement) -> Complex:
    """Weights (n,): their real part weighs K', their imaginary part K''."""
    return np.asarray((2.0 + 1.0j) / measurement.magnitude, dtype=np.complex128)


@hookimpl
def springpot_objectives() -> Iterable[Objective]:
    """One objective."""
    return [
        Objective(
            "example-objective", "the differences over |K_m|, those of K' twice", _mostly_storage
        )
    ]


# A data set: what is known about it, and a function that is called only when it is used.

TRUTH = {"c0": 2.0, "k": 400.0, "c": 60.0, "alpha": 0.5}


def load() -> Measurement:
    """Exact data of the model at 15 frequencies from 0.5 to 50 Hz."""
    omega = 2.0 * np.pi * np.geomspace(0.5, 50.0, 15)
    stiffness = MODEL.stiffness(MODEL.vector(TRUTH), omega)
    return Measurement(omega, stiffness, units=Units("kN/m", "mm"), name="example-data")


DATA = DataSet(
    "example-data",
    "artificial data of the example model at 15 frequencies, without noise",
    load,
    kind="artificial",
    licence="CC0-1.0",
    size=15,
    truth=TRUTH,
    model="example-model",
)


@hookimpl
def springpot_datasets() -> Iterable[DataSet]:
    """One data set."""
    return [DATA]


# A reader: how a format is recognised, read and written. This one is {"unit": ..., "omega": [...],
# ...} in JSON.


def read(path: Path, choice: Choice) -> Measurement:
    """The measurement in a file; whatever is wrong with it is told in one line."""
    if choice:
        raise DataError("an example-json file holds one sweep: there is nothing to choose")
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
        columns = ([float(v) for v in table[key]] for key in ("omega", "storage", "loss"))
        omega, storage, loss = map(np.array, columns)
        units = Units(known_unit(table["unit"], MODULUS_UNITS, "storage and loss"))
        return Measurement(omega, storage + 1j * loss, units=units, name=path.stem)
    except Exception as error:
        raise DataError(f"{type(error).__name__}: {error}") from None


def text(data: Measurement) -> str:
    """The text of a file; what the format has no place for is refused, not lost."""
    more = (data.conditions, data.labels, data.sd, data.repeat, data.harmonics)
    if any(column is not None and len(column) for column in more):
        raise DataError(f"{data.name}: example-json holds frequency, storage and loss only")
    columns = {"omega": data.omega, "storage": data.storage, "loss": data.loss}
    lists = {key: column.tolist() for key, column in columns.items()}
    return json.dumps({"unit": data.units.stiffness} | lists)


def recognises(head: bytes) -> float:
    """Sure of a JSON object that has omega."""
    return 0.9 if head.lstrip().startswith(b"{") and b'"omega"' in head else 0.0


@hookimpl
def springpot_readers() -> Iterable[Reader]:
    """One reader."""
    summary = "JSON with unit, omega in rad/s, storage and loss"
    return [Reader("example-json", summary, recognises, read, text=text)]
