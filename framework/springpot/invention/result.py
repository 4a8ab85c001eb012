"""What an invention says, as plain data; and the grammar of laws it is looked for among.

A law has a plane, a form of the frequency, and a form of a condition. A candidate is a text as a
user would type it, read by the same parser: units, bounds, sizes and exact derivatives follow from
it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count, permutations, product
from typing import Any, Literal
from zlib import crc32

import numpy as np

from springpot.diagnosis.evidence import distance, log_prior_of_one
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.marginal import harmonic_evidence, marginal
from springpot.diagnosis.result import NextExperiment
from springpot.diagnosis.scan import applicable, possible, scan_effects
from springpot.diagnosis.search import grown_with
from springpot.errors import ModelError
from springpot.identification.leastsquares import Effort
from springpot.identification.value import Value
from springpot.lazy import Drawn, Printed
from springpot.measurement.measurement import Measurement
from springpot.misfit.error import Error
from springpot.misfit.floor import is_arithmetic
from springpot.numerics import NEGLIGIBLE
from springpot.plain_data import alive, jsonable, read
from springpot.registry import parse_model
from springpot.rheology.effect import PLANES, Effect
from springpot.rheology.grammar import parsed
from springpot.rheology.model import Model
from springpot.rheology.typed import law
from springpot.rheology.written import Written
from springpot.thresholds import EVIDENCE, INVENTION, VERDICT

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
    >>> from springpot.invention.result import times
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
    >>> from springpot.invention.result import is_active
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
    >>> from springpot.invention.result import renamed
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
    >>> from springpot.invention.result import symbols
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


Verdict = Literal["law", "class", "none"]


@dataclass(frozen=True)
class Weighed:
    """A fitted law and how likely it is.

    Attributes
    ----------
    grown : Grown
        The model with it.
    log_weight : float
        Log of its marginal likelihood and prior.
    probability : float
        Beside the other laws.
    """

    grown: Grown
    log_weight: float
    probability: float

    @property
    def effect(self) -> Effect:
        """The law."""
        return self.grown.effects[0]


def weighed(search: Search) -> list[Weighed]:
    """The laws that were fitted, each formula once, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    best: dict[str, Grown] = {}
    for grown in search.grown:
        best.setdefault(grown.effects[0].name, grown)
    rivals = [grown for grown in best.values() if _is_rival(search, grown)]
    if not rivals:
        return []
    exact = [grown for grown in best.values() if is_arithmetic(grown.refit)]
    if exact:
        # What is left is rounding, and says nothing: the shortest formula is the law.
        rivals = exact
        logs = np.array([search.best.log_likelihood + _log_prior(g.effects[0]) for g in exact])
    else:
        logs = np.array([marginal(search, g) + _log_prior(g.effects[0]) for g in rivals])
    chances = np.exp(logs - logs.max())
    chances = chances / chances.sum()
    rows = zip(rivals, logs.tolist(), chances.tolist(), strict=True)
    return sorted((Weighed(*row) for row in rows), key=lambda law: -law.log_weight)


def _is_rival(search: Search, grown: Grown) -> bool:
    """Whether its price could still decide: a law far from the data needs none."""
    return grown.refit.log_likelihood > search.best.log_likelihood - INVENTION.hopeless


def _log_prior(effect: Effect) -> float:
    """The longer a formula, the more of its length there are."""
    return log_prior_of_one(1.0) - INVENTION.symbol * symbols(effect)


def rivals_of(laws: Sequence[Weighed]) -> list[Weighed]:
    """The class of the likeliest law: those that these data cannot tell from it.

    Of laws that have become one the shortest stands for all.
    """
    kept: list[Weighed] = []
    for one in laws:
        if one.log_weight <= laws[0].log_weight - EVIDENCE.rivals:
            continue
        place = next((i for i, other in enumerate(kept) if _is_same(one, other)), len(kept))
        if place == len(kept):
            kept.append(one)
        elif symbols(one.effect) < symbols(kept[place].effect):
            longer = kept[place]
            kept[place] = replace(longer, grown=one.grown)
    return kept


def _is_same(law: Weighed, other: Weighed) -> bool:
    """Whether a law has become another one, as c omega^a does where a is nothing."""
    frame = other.grown.refit.frame()
    return distance(frame, law.grown.refit, other.grown.refit) < INVENTION.same


def nothing(search: Search) -> float:
    """Log-evidence that no law is missing."""
    complete = search.base.log_likelihood + harmonic_evidence(search.base)
    return complete + float(np.log(EVIDENCE.prior_nothing))


def verdict_of(search: Search, laws: Sequence[Weighed]) -> Verdict:
    """Whether a law is found, a class of them, or none.

    One is found where noise alone is no credible cause of the misfit, the evidence prefers the law,
    and what it leaves is noise.
    """
    if not laws or search.alarm >= INVENTION.alarm:
        return "none"
    clear = laws[0].log_weight > nothing(search) + EVIDENCE.as_good
    structure = search.left.p_value < VERDICT.structure_alarm
    if not clear or (structure and not is_arithmetic(laws[0].grown.refit)):
        return "none"
    return "law" if len(rivals_of(laws)) == 1 else "class"


def known_alike(search: Search, law: Weighed, library: Sequence[Effect]) -> list[Grown]:
    """Effects with a name that these data cannot tell from a law, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    law : Weighed
        The law.
    library : sequence of Effect
        Effects with a name.
    """
    effects = possible(search.base, applicable(library, search.base.fit.measurement))
    scores = scan_effects(search.base, search.frame, effects).scores[: INVENTION.known]
    effort = Effort(NEGLIGIBLE, law.grown.refit.rss + 2.0 * INVENTION.hopeless)
    grown = [grown_with(search, score, effort) for score in scores]
    least = law.grown.refit.log_likelihood - EVIDENCE.rivals
    alike = [each for each in grown if each.refit.log_likelihood > least]
    return sorted(alike, key=lambda each: -each.refit.log_likelihood)


SCHEMA = "springpot.invention/1"


@dataclass(frozen=True)
class FoundLaw:
    """A law that was found.

    Attributes
    ----------
    text : str
        As it is typed: ``parallel: i*k*X^(-n)``.
    plane : str
        In which it joins the model: ``parallel``, ``series``, ``chain`` or ``shift``.
    probability : float
        Beside the other laws that were tried, one of them being right.
    alike : tuple of str
        Laws that these data cannot tell from it, itself included.
    parameters : dict of str to Value
        With their intervals.
    error_after : float
        Relative error of the model with it.
    causal : bool
        Whether it follows from what was; what does not is an instrument's fault, or no law.
    passive : bool or None
        Whether it gives out no energy; None of a factor, which has none of its own.
    like : tuple of str
        Effects with a name that these data cannot tell from it.
    says : str
        What kind of law it is, and what the named ones would be.
    """

    text: str
    plane: str
    probability: float
    alike: tuple[str, ...]
    parameters: dict[str, Value]
    error_after: float
    causal: bool
    passive: bool | None
    like: tuple[str, ...]
    says: str

    def effect(self, name: str = "law-1") -> Effect:
        """The law as an effect, to be added to a model or written as a plugin."""
        return law(self.text, name)

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where `alike` is called class."""
        row = {"class" if name == "alike" else name: value for name, value in vars(self).items()}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> FoundLaw:
        """What `to_dict` gave."""
        law(row["text"])
        return read(cls, row, alike=tuple(row["class"]))


@dataclass(frozen=True, eq=False)
class Invention(Drawn, Printed):
    """The answer to the question which law is missing.

    Its picture has the data, the model and the law.

    Attributes
    ----------
    data : str
        What was measured.
    model : Model
        What the law is missing from.
    verdict : {"law", "class", "none"}
        One law, several that these data cannot tell apart, or none.
    says : str
        The verdict in one sentence.
    error : Error
        The model's error before, the noise floor and the material floor.
    laws : tuple of FoundLaw
        The likeliest first; where none is found those that come nearest.
    next_experiment : NextExperiment or None
        What would tell the class apart.
    notes : tuple of str
        What these data cannot tell at all.
    tried : int
        Laws that were held against the data.
    searched : Search, optional
        The fits behind it; a file does not hold them.
    ranked : tuple of Weighed
        The whole class, fitted, of which `laws` tells the first; none of a file.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> omega, X = np.tile(np.geomspace(1, 100, 8), 3), np.repeat([0.2, 1.0, 3.0], 8)
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=(2, 24))
    >>> softening = (10 + 1j * omega + 5 * X**-0.5) * (1 + noise[0] + 1j * noise[1])
    >>> data = springpot.Measurement(omega, softening, conditions={"amplitude": X})
    >>> found = springpot.invent(data, "kelvin")
    >>> found.verdict, found.laws[0].text
    ('class', 'parallel: k*X^(-n)')
    """

    data: str
    model: Model
    verdict: Verdict
    says: str
    error: Error
    laws: tuple[FoundLaw, ...]
    next_experiment: NextExperiment | None
    notes: tuple[str, ...]
    tried: int
    searched: Search | None = None
    ranked: tuple[Weighed, ...] = ()

    @property
    def best(self) -> FoundLaw | None:
        """The likeliest law, or None where none is found."""
        if self.verdict == "none":
            return None
        return self.laws[0]

    @property
    def search(self) -> Search:
        """The fits behind it."""
        return alive(self.searched, Search, f"the invention of {self.data}")

    def effect(self, name: str = "law-1") -> Effect:
        """The likeliest law as an effect.

        Raises
        ------
        ModelError
            If none was found.
        """
        if self.best is None:
            raise ModelError(f"no law was found of {self.data}: {self.says}")
        return self.best.effect(name)

    def __repr__(self) -> str:
        found = "".join(f", {law.text}" for law in filter(None, [self.best]))
        return f"<Invention of {self.data} beside {self.model.name}: {self.verdict}{found}>"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.invention/1``."""
        row: dict[str, Any] = {
            "schema": SCHEMA,
            "data": self.data,
            "model": self.model.name,
        }
        row |= {"verdict": self.verdict, "says": self.says, "error": self.error}
        row["laws"] = [
            {
                **law.to_dict(),
                "error_before": self.error.relative_rms,
                "noise_floor": self.error.noise_floor,
            }
            for law in self.laws
        ]
        row |= {"next_experiment": self.next_experiment, "notes": self.notes, "tried": self.tried}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Invention:
        """What `to_dict` gave."""
        return read(cls, answer, model=parse_model(answer["model"]))
