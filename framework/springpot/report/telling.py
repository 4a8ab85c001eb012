"""``print(result)``: the text that the command line prints."""

from __future__ import annotations

from functools import singledispatch

from springpot.comparison import Comparison, Ranking
from springpot.diagnosis import Diagnosis, Ladder
from springpot.identification import Identification

from .answers import comparison_text, diagnosis_text
from .climbed import ladder_text
from .fits import identification_text
from .ranking import ranked_text


@singledispatch
def told(result: object) -> str:
    """The text of a result; of anything else its short form."""
    return repr(result)


# The functions of the command line themselves: what Python prints cannot differ from what a shell shows.
told.register(Identification, identification_text)
told.register(Diagnosis, diagnosis_text)
told.register(Ladder, ladder_text)
told.register(Comparison, comparison_text)
told.register(Ranking, ranked_text)
