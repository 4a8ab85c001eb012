"""The same law with less in it: what a search adds last may make superfluous what it took first."""

from __future__ import annotations

import re
from collections.abc import Iterator

from springpot.rheology.effect import Effect

from .grammar import text_of

RATIO = "r"
"""The size of a second term in that of the first."""
_LOSSY = re.compile(r"(?P<whole>\*\(1 (?P<sign>[+-]) i\*(?P<h>h\d?)\))")
_GROWN = re.compile(
    r"(?P<low>\(\w+/\w+\)\^n\d?)?(?P<over>/?)\(1 \+ \((?P<of>\w+)/\w+\)\^(?P<power>n\d?)\)"
)
Values = dict[str, float]


def shorter(effect: Effect, values: Values) -> Iterator[tuple[str, Values]]:
    """Texts of the laws that lack one thing of a law, and the values to start from.

    Of a stiffness with a loss of its own the stiffness alone and the loss alone; of what saturates,
    or grows from a constant, the power alone.

    Parameters
    ----------
    effect : Effect
        A law, of one term or of two.
    values : dict of str to float
        Its fitted parameters.

    Examples
    --------
    >>> import springpot
    >>> from springpot.invention.shorter import shorter
    >>> mine = springpot.law("parallel: i*k*X^(-n) - k*r*(1 - i*h)*X^n2")
    >>> [text for text, _ in shorter(mine, {"k": 2.0, "n": 1.0, "r": 3.0, "h": 0.1, "n2": 1.0})]
    ['parallel: i*k*X^(-n) - k*r*X^n2', 'parallel: i*k*X^(-n) + i*k*r*X^n2']
    """
    word, _, formula = text_of(effect).partition(": ")
    terms = _terms(formula)
    size = effect.element.parameters[0].name
    for place, term in enumerate(terms):
        if lossy := _LOSSY.search(term):
            bare, h = term.replace(lossy["whole"], "", 1), lossy["h"]
            rest = {name: value for name, value in values.items() if name != h}
            yield f"{word}: {_sum(terms, place, bare)}", rest
            own = RATIO if place else size
            rest = rest | {own: rest[own] * values[h]}
            if not place and RATIO in rest:
                rest[RATIO] /= values[h]
            sign = "+" if bare[0] == lossy["sign"] else "-"
            yield f"{word}: {_sum(terms, place, f'{sign}i*{bare[1:]}')}", rest
        if grown := _GROWN.search(term):
            power = f"{grown['of']}^{grown['power']}"
            if grown["over"] and not grown["low"]:
                power = f"*{grown['of']}^(-{grown['power']})"
            yield f"{word}: {_sum(terms, place, term.replace(grown[0], power, 1))}", values


def _terms(formula: str) -> list[str]:
    """The terms of a sum, each with its sign before it."""
    signed = formula if formula.startswith("-") else f"+{formula}"
    terms: list[str] = []
    depth = 0
    for part in re.split(r" (?=[+-] )", signed):
        # Within brackets a sign parts no terms.
        if depth:
            terms[-1] += f" {part}"
        else:
            terms.append(part[0] + part[1:].lstrip())
        depth += part.count("(") - part.count(")")
    return terms


def _sum(terms: list[str], place: int, other: str) -> str:
    new = [*terms[:place], other, *terms[place + 1 :]]
    return new[0].removeprefix("+") + "".join(f" {term[0]} {term[1:]}" for term in new[1:])
