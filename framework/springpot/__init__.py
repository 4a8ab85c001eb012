"""springpot: identify viscoelastic models, find the missing physical effect, race optimisers fairly.

The names here are loaded when first used, so that the command line starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_WHERE = {
    "Measurement": "springpot.measurement",
    "Units": "springpot.measurement",
    "TimeTest": "springpot.measurement",
    "open_in_time": "springpot.registry",
    "geometry": "springpot.measurement",
    "Model": "springpot.rheology",
    "Effect": "springpot.rheology",
    "open_measurement": "springpot.registry",
    "parse_model": "springpot.registry",
    "plugins": "springpot.registry",
    "compare": "springpot.api",
    "diagnose": "springpot.api",
    "discover": "springpot.api",
    "identify": "springpot.api",
    "mastercurve": "springpot.api",
    "read": "springpot.api",
    "signals_to_measurement": "springpot.registry",
    "write_measurement": "springpot.registry",
}

__all__ = ["__version__", *_WHERE]


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'springpot' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
