"""``print(result)``: the text that the command line prints."""

from __future__ import annotations

from functools import singledispatch

from springpot.comparison.comparing import Comparison
from springpot.comparison.ranking import Ranking
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.identification.part_result import in_time
from springpot.identification.result import Identification
from springpot.timetests.result import TimeIdentification

from .answers import comparison_text, diagnosis_text
from .fit_text import (
    climbed_in_time_text,
    compared_in_time_text,
    diagnosed_in_time_text,
    fitted_in_time_text,
    identification_text,
)
from .ladder_text import ladder_text
from .ranking import ranked_text


@singledispatch
def told(result: object) -> str:
    """The text of a result; of anything else its short form."""
    return repr(result)


# The functions of the command line themselves: what Python prints cannot differ from what a shell
# shows.
told.register(Identification, identification_text)
told.register(TimeIdentification, fitted_in_time_text)
told.register(Ranking, ranked_text)


@told.register
def _diagnosis(result: Diagnosis) -> str:
    if in_time(result.tests):
        return diagnosed_in_time_text(result)
    return diagnosis_text(result)


@told.register
def _ladder(result: Ladder) -> str:
    if in_time(result.diagnosis.tests):
        return climbed_in_time_text(result)
    return ladder_text(result)


@told.register
def _comparison(result: Comparison) -> str:
    if in_time(result.tests):
        return compared_in_time_text(result)
    return comparison_text(result)
