"""Model expressions: names of models and effects, and laws as text among them.

``fractional-maxwell + inertia``, ``material + (series: 1/(k*(1 + (X/Xc)^n)))`` and ``k +
c*(i*omega)^alpha`` are read by the same rules: parts at the outermost ``+``; a part in brackets
with the word of a plane is an effect; what comes before the first effect is the model, by its name
or by its formula.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from springpot.errors import ModelError

from .effect import PLANES, Effect
from .model import Model
from .written import written

_LAW = re.compile(rf"\s*(?:([^=:()]*)=)?\s*({'|'.join(PLANES)})\s*:(.*)", re.DOTALL)
_NAME = re.compile(r"[A-Za-z][\w-]*")
_SIGNS = frozenset("*/^(")
"""No name of a model has one of these, and hardly a formula none."""


class Parts(NamedTuple):
    """A model expression taken apart.

    Attributes
    ----------
    model : str
        The name of the model, or its formula.
    by_formula : bool
        Whether it is a formula.
    effects : tuple of str
        Names and laws.
    """

    model: str
    by_formula: bool
    effects: tuple[str, ...]


def is_law(text: str) -> bool:
    """Whether a text is a law such as ``drag = parallel: c*i*omega``, and no name.

    Examples
    --------
    >>> from springpot.rheology.typed import is_law
    >>> is_law("parallel: -m*omega^2"), is_law("inertia")
    (True, False)
    """
    return _LAW.fullmatch(_bare(text)) is not None


def _bare(text: str) -> str:
    text = text.strip()
    if text[:1] == "(" and text[-1:] == ")":
        return text[1:-1]
    return text


def law(text: str, name: str = "law-1", summary: str = "") -> Effect:
    """An effect of your own, as text.

    Parameters
    ----------
    text : str
        ``NAME = PLANE: FORMULA`` or ``PLANE: FORMULA``. ``parallel`` is a stiffness beside the
        model, ``series`` a compliance, ``chain`` a factor of K, ``shift`` one of the frequency.
        ``omega``, ``f``, ``i``, ``s`` (i omega), ``X``, ``T`` and ``T0`` in kelvin, ``R`` and
        columns of the data are known; whatever else is named is a parameter.
    name : str
        Its name where the text gives none.
    summary : str
        One sentence of physics; by default what kind of law it is.

    Returns
    -------
    Effect
        An effect like any other: its parameters have units, bounds and sizes by the data.

    Raises
    ------
    ModelError
        If it is no formula, its units do not fit, or it cannot vanish.

    Examples
    --------
    >>> import springpot
    >>> mine = springpot.law("my-mass = parallel: -m*omega^2")
    >>> (springpot.parse_model("fractional-maxwell") + mine).names
    ('k', 'c', 'alpha', 'my-mass.m')
    """
    match = _LAW.fullmatch(_bare(text))
    if match is None:
        raise ModelError(
            f"'{text:.80}' is no law: write NAME = PLANE: FORMULA, such as"
            f" 'my-mass = parallel: -m*omega^2'; PLANE is one of {', '.join(PLANES)}"
        )
    own, plane, formula = match.groups()
    if own is not None:
        name = own.strip()
    if not _NAME.fullmatch(name):
        raise ModelError(f"'{name:.40}' is no name of a law: letters, digits and hyphens are")
    effect = Effect.from_formula(name, f"{plane}: {formula}", summary)
    shown = " ".join(formula.split())
    return replace(effect, expression=f"({name} = {plane}: {shown})")


def expression_parts(expression: str, is_effect: Callable[[str], bool]) -> Parts:
    """A model expression taken apart.

    Parameters
    ----------
    expression : str
        As users type it.
    is_effect : callable
        Whether a text is the name of an effect.

    Raises
    ------
    ModelError
        If a part is empty, or brackets do not close.

    Examples
    --------
    >>> from springpot.rheology.typed import expression_parts
    >>> expression_parts("k + c*(i*omega)^alpha + drag", lambda name: name == "drag")
    Parts(model='k + c*(i*omega)^alpha', by_formula=True, effects=('drag',))
    """
    parts = _at_outermost_plus(expression)
    if not all(parts):
        raise ModelError(f"'{expression}' has an empty part: write MODEL + EFFECT + EFFECT")
    # From the end: a parameter of the formula before may well be called as an effect is.
    first = len(parts)
    while first > 1 and (is_law(parts[first - 1]) or is_effect(parts[first - 1])):
        first -= 1
    head = parts[:first]
    if is_law(head[0]):
        raise ModelError(f"'{head[0]}' is an effect: write MODEL + {head[0]}")
    if any(_SIGNS & set(part) for part in head if not is_law(part)):
        return Parts(" + ".join(head), True, tuple(parts[first:]))
    return Parts(parts[0], False, tuple(parts[1:]))


def _at_outermost_plus(expression: str) -> list[str]:
    parts, depth = [""], 0
    for sign in expression:
        depth += {"(": 1, ")": -1}.get(sign, 0)
        if depth < 0:
            break
        if sign == "+" and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    if depth:
        raise ModelError(f"'{expression:.80}': its brackets do not close")
    return [part.strip() for part in parts]


def model_of(formula: str) -> Model:
    """The model without effects of a formula such as ``k + c*(i*omega)^alpha``."""
    element = written(formula)
    return Model(element.text, element, "a formula as it was typed", drawing="")
