"""Tests in time: what a model answers, identification, prediction of one test from another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .comparing import compare
    from .diagnosis import diagnose, examine
    from .discovery import discover
    from .fitting import identify
    from .known import Known
    from .predicted_test import TestPrediction
    from .prediction import predict_test
    from .recording import recorded
    from .residuals_of_tests import Test
    from .response import predicted
    from .result import TimeIdentification

__all__ = [
    "Known",
    "Test",
    "TestPrediction",
    "TimeIdentification",
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
    "Known": "springpot.timetests.known",
    "Test": "springpot.timetests.residuals_of_tests",
    "TestPrediction": "springpot.timetests.predicted_test",
    "TimeIdentification": "springpot.timetests.result",
    "compare": "springpot.timetests.comparing",
    "diagnose": "springpot.timetests.diagnosis",
    "discover": "springpot.timetests.discovery",
    "examine": "springpot.timetests.diagnosis",
    "identify": "springpot.timetests.fitting",
    "predict_test": "springpot.timetests.prediction",
    "predicted": "springpot.timetests.response",
    "recorded": "springpot.timetests.recording",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
