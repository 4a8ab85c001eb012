"""Tests in time: what a model answers, identification, prediction of one test from another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .answer import TimeCandidate, TimeDiagnosis, TimeError, best_of, missing_of
    from .comparing import TimeComparison, compare
    from .diagnosis import diagnose
    from .discovery import TimeLadder, TimeStep, discover
    from .fitting import identify
    from .predicted_test import TestPrediction
    from .prediction import Known, predict_test
    from .recording import recorded
    from .residuals_of_tests import Test
    from .response import predicted
    from .result import PartResult, TimeIdentification
    from .where import Place

__all__ = [
    "Known",
    "PartResult",
    "Place",
    "Test",
    "TestPrediction",
    "TimeCandidate",
    "TimeComparison",
    "TimeDiagnosis",
    "TimeError",
    "TimeIdentification",
    "TimeLadder",
    "TimeStep",
    "best_of",
    "compare",
    "diagnose",
    "discover",
    "identify",
    "missing_of",
    "predict_test",
    "predicted",
    "recorded",
]

_WHERE = {
    "Known": "springpot.timetests.prediction",
    "PartResult": "springpot.timetests.result",
    "Place": "springpot.timetests.where",
    "Test": "springpot.timetests.residuals_of_tests",
    "TestPrediction": "springpot.timetests.predicted_test",
    "TimeCandidate": "springpot.timetests.answer",
    "TimeComparison": "springpot.timetests.comparing",
    "TimeDiagnosis": "springpot.timetests.answer",
    "TimeError": "springpot.timetests.answer",
    "TimeIdentification": "springpot.timetests.result",
    "TimeLadder": "springpot.timetests.discovery",
    "TimeStep": "springpot.timetests.discovery",
    "best_of": "springpot.timetests.answer",
    "compare": "springpot.timetests.comparing",
    "diagnose": "springpot.timetests.diagnosis",
    "discover": "springpot.timetests.discovery",
    "identify": "springpot.timetests.fitting",
    "missing_of": "springpot.timetests.answer",
    "predict_test": "springpot.timetests.prediction",
    "predicted": "springpot.timetests.response",
    "recorded": "springpot.timetests.recording",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
