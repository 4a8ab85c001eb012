"""Tests in time: what a model answers, identification, prediction of one test from another."""

from .answer import TimeCandidate, TimeDiagnosis, TimeError, best_of, missing_of
from .compare import TimeComparison, compare
from .diagnosis import diagnose
from .discover import TimeLadder, TimeStep, discover
from .identify import identify
from .parts import Test
from .predicted import predicted
from .prediction import Known, TestPrediction, predict_test
from .recorded import recorded
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
