"""springpot: identify viscoelastic models, find missing physical effects, race optimisers fairly.

The names here are loaded when first used, so that the command line starts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:  # what a user's type checker sees, and `offered` imports
    from springpot.api import (
        compare,
        diagnose,
        discover,
        identify,
        invent,
        mastercurve,
        predict,
        read,
    )
    from springpot.comparison import Comparison
    from springpot.derived import quantities
    from springpot.diagnosis import Diagnosis, Ladder
    from springpot.identification import Identification, Prediction
    from springpot.invention import Invention
    from springpot.loading import load
    from springpot.measurement import Measurement, TimeTest, Units, geometry
    from springpot.registry import (
        open_in_time,
        open_measurement,
        parse_model,
        plugins,
        signals_to_measurement,
        write_measurement,
    )
    from springpot.rheology import Effect, Model, law
    from springpot.testreport import certify, cycles
    from springpot.web import workbench

__version__ = "0.1.0"

__all__ = [
    "__version__",
    "Comparison",
    "Diagnosis",
    "Effect",
    "Identification",
    "Invention",
    "Ladder",
    "Measurement",
    "Model",
    "Prediction",
    "TimeTest",
    "Units",
    "certify",
    "compare",
    "cycles",
    "diagnose",
    "discover",
    "geometry",
    "identify",
    "invent",
    "law",
    "load",
    "mastercurve",
    "open_in_time",
    "open_measurement",
    "parse_model",
    "plugins",
    "predict",
    "quantities",
    "read",
    "signals_to_measurement",
    "workbench",
    "write_measurement",
]

__getattr__, _ = offered(__name__)


def __dir__() -> list[str]:
    return sorted(__all__)
