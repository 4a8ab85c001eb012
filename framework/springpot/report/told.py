"""``print(result)`` and a result in a notebook: one document, as text and as HTML."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

from springpot.comparison.result import Comparison, Ranking
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.identification.result import Identification
from springpot.identification.value import Quantities
from springpot.invention.result import Invention
from springpot.superposition.curve import MasterCurve
from springpot.writing import USUAL

from .answers import comparison_document, diagnosis_document, quantities_document
from .fit_text import fit_document
from .invention import invention_document
from .ladder_text import ladder_document, ranking_document
from .mastercurve import mastercurve_document
from .text import Passage, Prose, as_html, as_text


@singledispatch
def document_of(result: object, **asked: Any) -> list[Passage]:
    """The document of a result; of anything else its short form."""
    return [Prose(repr(result))]


document_of.register(Identification, fit_document)
document_of.register(Diagnosis, diagnosis_document)
document_of.register(Ladder, ladder_document)
document_of.register(Comparison, comparison_document)
document_of.register(Ranking, ranking_document)
document_of.register(Invention, invention_document)
document_of.register(MasterCurve, mastercurve_document)
document_of.register(Quantities, quantities_document)


def told(result: object, columns: int = USUAL, **asked: Any) -> str:
    """What the command line prints of a result, for a window of so many columns.

    Parameters
    ----------
    result : object
        Anything; of what has no document its `repr`.
    columns : int
        Of the window.
    **asked
        What the document of such a result may be asked for, such as ``verbose``.
    """
    return as_text(document_of(result, **asked), columns)


def shown(result: object) -> str:
    """What a notebook shows of a result."""
    return as_html(document_of(result))
