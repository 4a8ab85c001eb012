"""Tests in time: what a model answers, identification, prediction of one test from another."""

from .identify import identify
from .parts import Test
from .predicted import predicted
from .result import PartResult, TimeIdentification

__all__ = ["PartResult", "Test", "TimeIdentification", "identify", "predicted"]
