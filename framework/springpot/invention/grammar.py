"""The grammar of laws: a plane, a form of the frequency, and a form of a condition.

A candidate is a text as a user would type it, read by the same parser: units, bounds, sizes and
exact derivatives follow from it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from itertools import count, permutations, product
from zlib import crc32

from springpot.errors import ModelError
from springpot.measurement.measurement import Measurement
from springpot.rheology.effect import PLANES, Effect
from springpot.rheology.grammar import parsed
from springpot.rheology.typed import law
from springpot.rheology.written import Written

POWERS = ("@^n", "@^(-n)")
SATURATIONS = ("1/(1 + (@/Xc)^n)", "(@/Xc)^n/(1 + (@/Xc)^n)", "exp(-@/Xc)")
GROWTHS = ("(1 + (@/Xc)^n)",)
THRESHOLDS = ("max(0, 1 - Xc/@)^n", "max(0, 1 - @/Xc)^n")
OF_CONDITION = (*POWERS, *SATURATIONS, *GROWTHS, *THRESHOLDS)
"""Of a condition, which stands where the @ is."""
THERMAL_POWERS = ("(@/T0)^n", "(@/T0)^(-n)")
OF_TEMPERATURE = ("exp(E/R*(1/@ - 1/T0))", "exp(-E/R*(1/@ - 1/T0))", *THERMAL_POWERS)
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
ACTIVE = ("-i*k", "-k*(1 + i*h)", "k*(1 - i*h)")
"""Those that take loss away: by itself such a law gives out energy, and stands alone."""
COMPLIANCES = ("1/k", "1/(c*i*omega)", "1/(c*(i*omega)^a)")
CHANGES = ("1 + b*(#)", "1 + i*b*(#)", "1 + (1 - i*h)*b*(#)", "exp(-i*omega*tau*(#))")
"""Factors of K that go with a form of a condition, which stands where the # is."""
FACTORS = ("1/(1 + (@/Xc)^n)", "1/(1 + i*(@/Xc)^n)", "exp(-@/Xc)")
"""Those that are one where the condition is nothing."""
CLOCKS = ("1/(1 + (@/Xc)^n)", "1 + (@/Xc)^n", "exp(-@/Xc)", "exp(-b*omega^a*@^n)")
YIELDING = (
    "parallel: k*slider(Xc/X)",
    "parallel: k/(1 - i*(X/Xc)^n)",
    "parallel: k/(1 - i*c*X^n/omega^a)",
    "parallel: k*(1 + i*h*(X/Xc)^n)/(1 + (X/Xc)^(2*n))",
    "chain: 1 - slider(b/X)",
)
"""Of the amplitude: a spring before what slips or flows, a network that breaks up, and play."""
OF_OWN = (
    "series: Y/(k*Y^n)",
    "series: Y/(i*c*(omega*Y)^a)",
    "series: 1/(k*(1 + (Y/Xc)^n))",
)
"""Of the amplitude that a part in series takes itself: over its force."""
THERMAL_FACTORS = ("(@/T0)^n",)
THERMAL_CLOCKS = ("exp(E/R*(1/@ - 1/T0))", "exp(-C1*(@ - T0)/(C2 + @ - T0))", "(@/T0)^n")
ALONE = (
    *(f"parallel: {form}" for form in (*STIFFNESSES, *ACTIVE)),
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
_POWER = re.compile(r"(\w|@)+\^(\w+|\(-\w+\))")
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
    texts, columns = [*ALONE], measurement.conditions
    for condition in conditions:
        texts += [filled(text, condition, columns) for text in _of(condition)]
    for first, second in permutations(conditions, 2):
        texts += _of_both(first, second, columns)
    return laws(texts, measurement)


def forms_of(condition: str, plane: str) -> list[str]:
    """The forms of a condition, which stands where the @ is, in the law of a plane."""
    if condition == "temperature":
        return list(OF_TEMPERATURE)
    # What gives way only beyond a threshold is endlessly stiff before: that has no number.
    return [form for form in OF_CONDITION if plane != "compliance" or form not in THRESHOLDS]


def filled(text: str, condition: str, taken: Collection[str]) -> str:
    """A text with the name of a condition put in, its parameters not called as others are."""
    symbol = {"amplitude": "X", "temperature": "T"}.get(condition, condition)
    return renamed(text, taken).replace("@", symbol)


def _of(condition: str) -> Iterator[str]:
    """Laws of one condition, and of the frequency."""
    forms, yielding = forms_of(condition, "stiffness"), forms_of(condition, "compliance")
    ones = (*STIFFNESSES, *ACTIVE)
    yield from (f"parallel: {times(one, form)}" for one, form in product(ones, forms))
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
        yield from (f"shift: {form.replace('@', '(omega*@)')}" for form in CLOCKS[:3])
        yield from (*YIELDING, *OF_OWN)


def _of_both(first: str, second: str, columns: Collection[str]) -> Iterator[str]:
    """Laws that go with a power of one condition and with any form of another."""
    powers = [form for form in forms_of(first, "compliance") if form in (*POWERS, *THERMAL_POWERS)]
    for word, ones in (("parallel", STIFFNESSES), ("series", COMPLIANCES)):
        plane = "stiffness" if word == "parallel" else "compliance"
        for one, power, form in product(ones, powers, forms_of(second, plane)):
            law = times(filled(one, first, columns), filled(power, first, columns))
            # A product of two powers comes in either order: once is enough.
            if form in (*POWERS, *THERMAL_POWERS) and first > second:
                continue
            taken = [*columns, *_WORD.findall(law)]
            yield f"{word}: {times(law, filled(form, second, taken))}"


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
    # A compliance has its stiffness first: that is its size, not the place of a saturation.
    if one.startswith("1/") and _POWER.fullmatch(other):
        return other + one[1:]
    return f"{one}*{other}"


def is_active(effect: Effect) -> bool:
    """Whether a law takes loss away.

    Examples
    --------
    >>> import springpot
    >>> from springpot.invention.grammar import is_active
    >>> [is_active(springpot.law(f"parallel: {text}*X^n")) for text in ("-i*k", "i*k", "-k")]
    [True, False, False]
    """
    return effect.plane == "stiffness" and formula_of(effect).startswith(ACTIVE)


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


def renamed(form: str, taken: Collection[str]) -> str:
    """A form whose parameters are not called as others already are: a further k is k2.

    Examples
    --------
    >>> from springpot.invention.grammar import renamed
    >>> renamed("k*X^n", ["k", "c"]), renamed("P^n*X^n2", ["n"])
    ('k2*X^n', 'P^n3*X^n2')
    """
    names = new_names(form, taken)
    return _WORD.sub(lambda word: names[word[0]], form)


def new_names(form: str, taken: Collection[str]) -> dict[str, str]:
    """Of each word of a form the one that `renamed` writes."""
    names, used = {}, {*taken, *_WORD.findall(form)}
    for word in dict.fromkeys(_WORD.findall(form)):
        names[word] = word
        if word in taken:
            stem = word.rstrip("0123456789")
            names[word] = next(new for i in count(2) if (new := f"{stem}{i}") not in used)
        used.add(names[word])
    return names


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
    word = next(word for word, joins in PLANES.items() if joins.kind.plane == effect.plane)
    return f"{word}: {formula_of(effect)}"
