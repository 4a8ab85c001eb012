"""Tests in time: what a model answers, identification, prediction of one test from another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.measurement.recording import predicted as predicted, recorded as recorded
    from springpot.misfit.residuals_of_tests import Test as Test, units_of as units_of

    from .comparing import compare as compare, rank as rank, standing_of as standing_of
    from .diagnosis import diagnose as diagnose, examine as examine
    from .discovery import discover as discover
    from .fitting import (
        identify as identify,
        identify_robustly as identify_robustly,
        refound as refound,
    )
    from .prediction import TestPrediction as TestPrediction, predict_test as predict_test
    from .specimen import answered as answered, as_had_by as as_had_by

__getattr__, __dir__ = offered(__name__)
