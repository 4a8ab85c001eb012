"""``print(result)``: the text that the command line prints."""

from __future__ import annotations

from functools import singledispatch

from springpot.diagnosis import Comparison, Diagnosis, Ladder, Ranking
from springpot.identification import Identification

from .answers import comparison_text, diagnosis_text, ladder_text
from .fits import identification_text
from .ranking import ranked_text


@singledispatch
def told(result: object) -> str:
    """The text of a result; of anything else its short form."""
    return repr(result)


@told.register
def _fit(result: Identification) -> str:
    return identification_text(result)


@told.register
def _diagnosis(result: Diagnosis) -> str:
    return diagnosis_text(result)


@told.register
def _ladder(result: Ladder) -> str:
    return ladder_text(result)


@told.register
def _comparison(result: Comparison) -> str:
    return comparison_text(result)


@told.register
def _ranking(result: Ranking) -> str:
    return ranked_text(result)
