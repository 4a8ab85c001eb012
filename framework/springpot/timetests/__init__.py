"""Tests in time: what a model answers, identification, prediction of one test from another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .diagnosis import diagnose, examine
    from .discovery import discover
    from .fitting import compare, identify
    from .prediction import predict_test
    from .recording import predicted, recorded
    from .residuals_of_tests import Test
    from .where import TestPrediction

__all__ = [
    "Test",
    "TestPrediction",
    "compare",
    "diagnose",
    "discover",
    "examine",
    "identify",
    "predict_test",
    "predicted",
    "recorded",
]

_WHERE = {
    "Test": "springpot.timetests.residuals_of_tests",
    "TestPrediction": "springpot.timetests.where",
    "compare": "springpot.timetests.fitting",
    "diagnose": "springpot.timetests.diagnosis",
    "discover": "springpot.timetests.discovery",
    "examine": "springpot.timetests.diagnosis",
    "identify": "springpot.timetests.fitting",
    "predict_test": "springpot.timetests.prediction",
    "predicted": "springpot.timetests.recording",
    "recorded": "springpot.timetests.recording",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
