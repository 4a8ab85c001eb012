"""Tests in time: what a model answers, identification, prediction of one test from another."""

from .compare import TimeComparison, compare
from .diagnosis import TimeCandidate, TimeDiagnosis, diagnose
from .discover import TimeLadder, TimeStep, discover
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
    "TimeLadder",
    "TimeStep",
    "compare",
    "diagnose",
    "discover",
    "identify",
    "predict_test",
    "predicted",
]
