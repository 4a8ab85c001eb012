"""``print(result)``: the text that the command line prints."""

from __future__ import annotations

from functools import singledispatch

from springpot.comparison.comparing import Comparison
from springpot.comparison.ranking import Ranking
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.identification.result import Identification

from .answers import comparison_text, diagnosis_text
from .fit_text import identification_text
from .ladder_text import ladder_text
from .ranking import ranked_text


@singledispatch
def told(result: object) -> str:
    """The text of a result; of anything else its short form."""
    return repr(result)


# The functions of the command line themselves: what Python prints cannot differ from what a shell
# shows.
told.register(Identification, identification_text)
told.register(Diagnosis, diagnosis_text)
told.register(Ladder, ladder_text)
told.register(Comparison, comparison_text)
told.register(Ranking, ranked_text)
