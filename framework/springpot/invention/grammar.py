"""The grammar of laws: a plane, a form of the frequency, and a form of a condition.

A candidate is a text as a user would type it, read by the same parser: units, bounds, sizes and
exact derivatives follow from it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import product
from zlib import crc32

from springpot.errors import ModelError
from springpot.measurement.measurement import Measurement
from springpot.rheology.effect import PLANES, Effect
from springpot.rheology.grammar import parsed
from springpot.rheology.typed import law
from springpot.rheology.written import Written

POWERS = ("@^n", "@^(-n)")
SATURATIONS = ("1/(1 + (@/Xc)^n)", "(@/Xc)^n/(1 + (@/Xc)^n)", "exp(-@/Xc)")
THRESHOLDS = ("max(0, 1 - Xc/@)^n", "max(0, 1 - @/Xc)^n")
OF_CONDITION = (*POWERS, *SATURATIONS, *THRESHOLDS)
"""Of a condition, which stands where the @ is."""
OF_TEMPERATURE = ("exp(E/R*(1/@ - 1/T0))", "exp(-E/R*(1/@ - 1/T0))", "(@/T0)^n", "(@/T0)^(-n)")
STIFFNESSES = (
    "k",
    "-k",
    "i*k",
    "k*(1 + i*h)",
    "-k*(1 - i*h)",
    "c*i*omega",
    "c*(i*omega)^a",
    "i*c*omega^a",
)
"""Of the frequency, beside the model: each also times a form of a condition."""
COMPLIANCES = ("1/k", "1/(c*i*omega)", "1/(c*(i*omega)^a)")
CHANGES = ("1 + b*(#)", "1 + i*b*(#)", "exp(-i*omega*tau*(#))")
"""Factors of K that go with a form of a condition, which stands where the # is."""
FACTORS = ("1/(1 + (@/Xc)^n)", "1/(1 + i*(@/Xc)^n)", "exp(-@/Xc)")
"""Those that are one where the condition is nothing."""
CLOCKS = ("1/(1 + (@/Xc)^n)", "1 + (@/Xc)^n", "exp(-@/Xc)")
THERMAL_FACTORS = ("(@/T0)^n",)
THERMAL_CLOCKS = ("exp(E/R*(1/@ - 1/T0))", "exp(-C1*(@ - T0)/(C2 + @ - T0))", "(@/T0)^n")
ALONE = (
    *(f"parallel: {form}" for form in STIFFNESSES),
    "parallel: -m*omega^2",
    "parallel: c*(i*omega)^(1 + a)",
    "parallel: k*(i*omega*tau)^a/(1 + (i*omega*tau)^a)",
    *(f"series: {form}" for form in COMPLIANCES),
    "series: 1/(k*(1 + (i*omega*tau)^a))",
    "series: 1/(k*(1 + i*z*omega/w0 - (omega/w0)^2))",
    "chain: 1 + b",
    "chain: 1 + b*(i*omega)^a",
    "chain: exp(i*p)",
    "chain: exp(-i*omega*tau)",
    "chain: 1/(1 + i*omega*tau)",
    "chain: 1 + i*omega*tau",
    "chain: 1/(1 + i*z*omega/w0 - (omega/w0)^2)",
    "shift: 1 + b",
)
"""Laws of the frequency alone."""
_WORD = re.compile(r"[A-Za-z]\w*")


def candidates(measurement: Measurement, conditions: Iterable[str]) -> list[Effect]:
    """All laws of the frequency and of one condition.

    Parameters
    ----------
    measurement : Measurement
        The data, by which sizes are tried.
    conditions : iterable of str
        Columns that a law may go with.
    """
    texts = [*ALONE]
    for condition in conditions:
        texts += [filled(text, condition, measurement.conditions) for text in _of(condition)]
    return laws(texts, measurement)


def forms_of(condition: str, plane: str) -> list[str]:
    """The forms of a condition, which stands where the @ is, in the law of a plane."""
    if condition == "temperature":
        return list(OF_TEMPERATURE)
    # What gives way only beyond a threshold is endlessly stiff before: that has no number.
    return [form for form in OF_CONDITION if plane != "compliance" or form not in THRESHOLDS]


def filled(text: str, condition: str, taken: Iterable[str]) -> str:
    """A text with the name of a condition put in, its parameters not called as others are."""
    symbol = {"amplitude": "X", "temperature": "T"}.get(condition, condition)
    return renamed(text, taken).replace("@", symbol)


def _of(condition: str) -> Iterator[str]:
    """Laws of one condition, and of the frequency."""
    forms, yielding = forms_of(condition, "stiffness"), forms_of(condition, "compliance")
    yield from (f"parallel: {times(one, form)}" for one, form in product(STIFFNESSES, forms))
    yield from (f"series: {times(one, form)}" for one, form in product(COMPLIANCES, yielding))
    yield from (f"chain: {one.replace('#', form)}" for one, form in product(CHANGES, forms))
    factors: tuple[str, ...] = FACTORS
    clocks: tuple[str, ...] = CLOCKS
    if condition == "temperature":
        factors, clocks = THERMAL_FACTORS, THERMAL_CLOCKS
    yield from (f"chain: {form}" for form in factors)
    yield from (f"shift: {form}" for form in clocks)
    if condition == "amplitude":
        # What goes with the rate goes with the product.
        rate = [form.replace("@", "(omega*@)") for form in (*SATURATIONS, *THRESHOLDS)]
        yield from (f"parallel: {times(one, form)}" for one, form in product(("k", "i*k"), rate))
        yield from (f"chain: {form.replace('@', '(omega*@)')}" for form in FACTORS)
        yield from (f"shift: {form.replace('@', '(omega*@)')}" for form in CLOCKS)


def times(one: str, other: str) -> str:
    """The product of two forms as one would write it.

    Examples
    --------
    >>> from springpot.invention.grammar import times
    >>> times("i*k", "1/(1 + (X/Xc)^n)"), times("1/k", "X^n")
    ('i*k/(1 + (X/Xc)^n)', 'X^n/k')
    """
    if other.startswith("1/"):
        return one + other[1:]
    if one.startswith("1/"):
        return other + one[1:]
    return f"{one}*{other}"


def laws(texts: Iterable[str], measurement: Measurement) -> list[Effect]:
    """Laws by their texts, each once, with the columns and the sizes of the data."""
    found = []
    for text in dict.fromkeys(texts):
        # Each under a name of its own, by which two of them can stand in one model.
        name = f"try-{crc32(text.encode()):08x}"
        try:
            # Whether it is causal is worked out of those alone that are told.
            found.append(law(text, name, text).bound_to(measurement.points))
        except ModelError:
            # Of a grammar's products some never vanish, or have two parameters that are one.
            continue
    return found


def renamed(form: str, taken: Iterable[str]) -> str:
    """A form whose parameters are not called as others already are: a further k is k2.

    Examples
    --------
    >>> from springpot.invention.grammar import renamed
    >>> renamed("k*X^n", ["k", "c"])
    'k2*X^n'
    """
    taken = set(taken)
    return _WORD.sub(lambda word: word[0] + "2" * (word[0] in taken), form)


def symbols(effect: Effect) -> int:
    """What it takes to write a law: the parts of its formula.

    Examples
    --------
    >>> import springpot
    >>> from springpot.invention.grammar import symbols
    >>> symbols(springpot.law("parallel: -m*omega^2"))
    7
    """
    return sum(1 for _ in parsed(formula_of(effect)).walk())


def formula_of(effect: Effect) -> str:
    """The formula of a typed law, without its plane."""
    assert isinstance(effect.element, Written)
    return effect.element.text


def text_of(effect: Effect) -> str:
    """A law as it is typed, without a name: ``series: X^n/k``."""
    word = next(word for word, joins in PLANES.items() if joins == effect.composition)
    return f"{word}: {formula_of(effect)}"
