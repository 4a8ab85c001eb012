"""Tests in time: what a model answers, identification, prediction of one test from another."""

from .compare import TimeComparison, compare
from .diagnosis import TimeCandidate, TimeDiagnosis, diagnose
from .identify import identify
from .parts import Test
from .predicted import predicted
from .prediction import Known, TestPrediction, predict_test
from .result import PartResult, TimeIdentification

__all__ = [
    "Known",
    "PartResult",
    "Test",
    "TestPrediction",
    "TimeCandidate",
    "TimeComparison",
    "TimeDiagnosis",
    "TimeIdentification",
    "compare",
    "diagnose",
    "identify",
    "predict_test",
    "predicted",
]
