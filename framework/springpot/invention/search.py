"""The search for a law: all candidates by their slopes, the leaders in earnest, then what is left.

A law is put to the test in its plane beside the model: where the model is any material, the
spectrum is solved anew for each setting of the law (variable projection), so that nothing but the
law and the material's passivity is assumed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from springpot.diagnosis.examination import search_data
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.scan import (
    Scan,
    Score,
    best_pairs,
    enough_for,
    possible,
    scan_effects,
)
from springpot.diagnosis.search import effort_of, pays, sort_by_evidence
from springpot.identification.problem import weighted
from springpot.measurement.measurement import Measurement
from springpot.misfit.floor import is_arithmetic
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residual_tests import battery
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Real
from springpot.thresholds import INVENTION, SEARCH

from .result import (
    filled,
    forms_of,
    formula_of,
    is_active,
    laws,
    new_names,
    renamed,
    symbols,
    text_of,
    times,
)

ELSEWHERE = 2
"""Starts beside those that the scan gives a law."""
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
    >>> from springpot.invention.search import shorter
    >>> mine = springpot.law("parallel: i*k*X^(-n) - k*r*(1 - i*h)*X^n2")
    >>> [text for text, _ in shorter(mine, {"k": 2.0, "n": 1.0, "r": 3.0, "h": 0.1, "n2": 1.0})]
    ['parallel: i*k*X^(-n) - k*r*X^n2', 'parallel: i*k*X^(-n) + i*k*r*X^n2']
    """
    word, _, formula = text_of(effect).partition(": ")
    terms = _terms(formula)
    size = effect.element.parameters[0].name
    for place, term in enumerate(terms):
        shorter_terms: list[tuple[str, Values]] = []
        if lossy := _LOSSY.search(term):
            shorter_terms += _stiffness_and_loss(term, lossy, values, place, size)
        if grown := _GROWN.search(term):
            shorter_terms.append((term.replace(grown[0], _power_alone(grown), 1), values))
        for other, begun in shorter_terms:
            yield f"{word}: {_sum(terms, place, other)}", begun


def _stiffness_and_loss(
    term: str, lossy: re.Match[str], values: Values, place: int, size: str
) -> list[tuple[str, Values]]:
    """A term without its loss and one of that loss alone, with the values to start from."""
    bare, share = term.replace(lossy["whole"], "", 1), values[lossy["h"]]
    rest = {name: value for name, value in values.items() if name != lossy["h"]}
    # The first term has the size of the law; the second is a ratio to it.
    own = RATIO if place else size
    of_loss = rest | {own: rest[own] * share}
    if not place and RATIO in of_loss:
        of_loss[RATIO] /= share
    sign = "+" if bare[0] == lossy["sign"] else "-"
    return [(bare, rest), (f"{sign}i*{bare[1:]}", of_loss)]


def _power_alone(grown: re.Match[str]) -> str:
    """The power in the place of what saturates, or grows from a constant."""
    if grown["over"] and not grown["low"]:
        return f"*{grown['of']}^(-{grown['power']})"
    return f"{grown['of']}^{grown['power']}"


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


SUMMED = ("stiffness", "compliance")
"""Planes in which terms add up; in the others they are factors."""
OF_A_CONDITION = frozenset({"n", "n2", "Xc", "Xc2"})
"""Parameters of the form of a condition."""


@dataclass(frozen=True)
class Memory:
    """Fits to nearly the same data: in other units of their noise, or of a row more.

    Attributes
    ----------
    fits : dict of str to Refit
        The model with a law, by the law's text.
    searches : dict of tuple to Search
        Those for a law of one term, by data and noise.
    behind : frozenset of str
        Laws that are no rivals by the data at hand.
    """

    fits: dict[str, Refit] = field(default_factory=dict)
    searches: dict[tuple[bytes, bytes], Search] = field(default_factory=dict)
    behind: frozenset[str] = frozenset()

    def beside(self, base: Refit, asked: Sequence[Effect] | None = None) -> Memory:
        """The same, the laws that are asked, or all, held against the data of a fit."""
        texts = self.fits if asked is None else self.fits.keys() & set(map(text_of, asked))
        left = {text: _left_by(self.fits[text], base) for text in texts}
        most = min(left.values(), default=0.0) + 2.0 * INVENTION.hopeless
        return replace(self, behind=frozenset(text for text in left if left[text] > most))


def _left_by(fitted: Refit, base: Refit) -> float:
    """Whitened sum of squares that a fit to nearly the same data leaves of those of `base`."""
    mean, noise = base.data.mean, base.noise
    left = mean.stiffness - fitted.model.stiffness(fitted.theta, mean.points)
    return float(np.sum(weighted(left, noise.weights, noise.turn) ** 2))


def search_laws(
    measurement: Measurement, model: Model, library: Sequence[Effect], rng: np.random.Generator
) -> Search:
    """Look for the law that is missing from a model of measured data.

    Laws of one term settle the noise and set points aside; what they leave is sought in it. Where
    that finds far more, what they settled is asked again.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        What a law may be missing from.
    library : sequence of Effect
        The laws of one term.
    rng : numpy.random.Generator
        For simulated noise.
    """
    memory = Memory()
    seek = partial(_of_one_term, memory)
    search, set_aside = search_data(measurement, model, library, rng, seek=seek)
    if not _leaves_more(search):
        return search
    further = _grown_further(memory, search, library, rng)
    if further.best.log_evidence - search.best.log_evidence < SEARCH.decisive:
        return further
    begun = None if set_aside else further
    seek = partial(_of_any, memory)
    return search_data(measurement, model, library, rng, seek=seek, begun=begun)[0]


def _of_one_term(
    memory: Memory, base: Refit, library: Sequence[Effect], rng: np.random.Generator
) -> Search:
    """The search for a law of one term, on the same data in the same noise the same once more."""
    key = base.data.mean.stiffness.tobytes(), base.noise.weights.tobytes()
    if key not in memory.searches:
        memory.searches[key] = _one_term(memory, base, library, rng)
    return memory.searches[key]


def _one_term(
    memory: Memory, base: Refit, library: Sequence[Effect], rng: np.random.Generator
) -> Search:
    effects = possible(base, library)
    frame = base.frame()
    search = Search(base, frame, scan_effects(base, frame, effects, rng), battery(frame, rng))
    search.left = search.structure
    # Where noise alone goes as far, nothing is fitted: that is what keeps laws from being invented.
    if search.alarm >= SEARCH.look_further:
        return search
    known = memory.beside(base, effects)
    # One after the other: what is far from the best so far is not searched to its end.
    for score in _promising(search.scan, base, INVENTION.refined):
        search.grown += _with_score(search, score, known)
    _sort(search)
    search.left = battery(search.best.frame(), rng)
    return search


def _leaves_more(search: Search) -> bool:
    """Whether what was found leaves something, of computed data more than rounding."""
    if not search.grown:
        return False
    # Of computed data the first law to reach arithmetic is the law, whatever rounding looks like.
    return search.left.p_value < SEARCH.left_over and not is_arithmetic(search.best)


def _of_any(
    memory: Memory, base: Refit, library: Sequence[Effect], rng: np.random.Generator
) -> Search:
    """The search for a law of one term, and where it leaves something for a longer one."""
    search = _of_one_term(memory, base, library, rng)
    return _grown_further(memory, search, library, rng) if _leaves_more(search) else search


def _grown_further(
    memory: Memory, search: Search, library: Sequence[Effect], rng: np.random.Generator
) -> Search:
    """The same with laws of a further condition, of two terms, and shorter ones."""
    known = memory.beside(search.base)
    effects = possible(search.base, library)
    further = [*_with_conditions(search, effects, known), *_with_terms(search, effects, known)]
    search = replace(search, grown=[*search.grown, *further])
    _sort(search)
    search.grown += _shortened(search, known)
    _sort(search)
    search.left = battery(search.best.frame(), rng)
    return search


def _with_score(search: Search, score: Score, memory: Memory) -> Iterator[Grown]:
    """The model with a law, from where the scan saw it."""
    effect = score.influence.effect
    return _with_law(search, effect, list(score.starts), memory, ELSEWHERE)


def _with_law(
    search: Search, effect: Effect, seeds: list[Real], memory: Memory, starts: int = 0
) -> Iterator[Grown]:
    """The model with a law, from seeds and where its fit to nearly the same data ended.

    None where that fit is no rival by these data.
    """
    base, text = search.base, text_of(effect)
    if text in memory.behind:
        return
    if text in memory.fits:
        seeds, starts = [memory.fits[text].theta, *seeds], 0
    fitted = refit(base.model + effect, base.data, base.noise, seeds, starts, effort_of(search))
    memory.fits[text] = fitted
    yield Grown((effect,), fitted, fitted.rss)


def _sort(search: Search) -> None:
    """The best first, without those that a search has led to where they give no numbers."""
    search.grown = [grown for grown in search.grown if _has_numbers(grown)]
    sort_by_evidence(search)


def _promising(scan: Scan, fitted: Refit, count: int) -> list[Score]:
    """The scores of most evidence, were they right: what explains the same is better if shorter."""

    def price(score: Score) -> float:
        effect = score.influence.effect
        drop = max(fitted.rss - score.predicted, 0.0)
        paid = len(effect.element.parameters) * float(np.log1p(drop))
        return score.predicted + paid + 2.0 * INVENTION.symbol * symbols(effect)

    return sorted(scan.scores, key=price)[:count]


def _of_each_kind(search: Search) -> list[Grown]:
    """The best laws that differ by more than the form of their condition."""
    kinds: dict[tuple[object, ...], Grown] = {}
    for grown in search.grown:
        (effect,) = grown.effects
        text = formula_of(effect)
        of_frequency = frozenset(_names(effect)) - OF_A_CONDITION
        kind = (effect.plane, of_frequency, text.startswith("-"), "i*" in text)
        kinds.setdefault(kind, grown)
    return list(kinds.values())[: INVENTION.extended]


def _has_numbers(grown: Grown) -> bool:
    refit = grown.refit
    with np.errstate(all="ignore"):
        at = refit.model.network.respond(refit.theta, refit.fit.measurement.points, GRADIENT)
    return bool(np.all(np.isfinite(at.value)) and np.all(np.isfinite(at.by_theta)))


def _with_conditions(search: Search, effects: Sequence[Effect], memory: Memory) -> Iterator[Grown]:
    """The best laws, each with a further condition."""
    base, measurement = search.base, search.base.fit.measurement
    conditions = frozenset[str]().union(*(effect.needs for effect in effects))
    for effect in [grown.effects[0] for grown in _of_each_kind(search)]:
        taken = [*_names(effect), *measurement.conditions]
        forms = [
            filled(form, name, taken)
            for name in sorted(conditions - effect.needs)
            for form in forms_of(name, effect.plane)
        ]
        products = laws(filter(None, (_times(effect, form) for form in forms)), measurement)
        scanned = scan_effects(base, search.frame, possible(base, products))
        for score in _promising(scanned, base, SEARCH.seconds):
            if pays(search.grown[0], (score.influence.effect,), score.predicted):
                yield from _with_score(search, score, memory)


def _times(effect: Effect, form: str) -> str:
    """A law times a form of a condition; empty where it is a factor without a size."""
    word, _, text = text_of(effect).partition(": ")
    if effect.plane in SUMMED:
        return f"{word}: {times(text, form)}"
    if "b*(" in text:
        return f"{word}: {text.replace('b*(', f'b*({form}*', 1)}"
    return ""


class _Two(NamedTuple):
    """Two terms of one plane, the model that has both, a start of it (p,), what it should leave."""

    first: Effect
    second: Effect
    model: Model
    start: Real
    left: float


def _with_terms(search: Search, effects: Sequence[Effect], memory: Memory) -> Iterator[Grown]:
    """Laws of two terms, each pair once."""
    starts: dict[str, list[_Two]] = {}
    for two in (*_after_the_best(search, effects), *_together(search)):
        # With a term that gives out energy a sum follows whatever there is.
        if is_active(two.first) or is_active(two.second):
            continue
        if two.first.plane == two.second.plane and two.first.plane in SUMMED:
            starts.setdefault(_joined(two.first, two.second), []).append(two)
    base = search.base
    foretold = {text: min(tried, key=lambda two: two.left) for text, tried in starts.items()}
    for text in sorted(foretold, key=lambda text: foretold[text].left)[: INVENTION.refined]:
        likely, tried = foretold[text], starts[text]
        # What is true is so without a second term: that would be a longer text for the same curve.
        if not pays(search.grown[0], (likely.first, likely.second), likely.left):
            continue
        for both in laws([text], base.fit.measurement):
            model = base.model + both
            if enough_for(base, model):
                seeds = [_carried(two, model, both) for two in tried]
                yield from _with_law(search, both, seeds, memory)


def _after_the_best(search: Search, effects: Sequence[Effect]) -> Iterator[_Two]:
    """What the best laws leave shows a second term."""
    for grown in _of_each_kind(search):
        (first,) = grown.effects
        others = [
            other
            for other in effects
            if other.plane == first.plane and other != first and not is_active(other)
        ]
        if first.plane not in SUMMED or is_active(first):
            continue
        scanned = scan_effects(grown.refit, grown.refit.frame(), others)
        for score in _promising(scanned, grown.refit, SEARCH.seconds):
            for start in score.starts:
                second = score.influence
                yield _Two(first, second.effect, second.model, start, score.predicted)


def _together(search: Search) -> Iterator[_Two]:
    """Terms that explain the residual only together."""
    base, scores = search.base, search.scan.scores[: INVENTION.paired]
    for pair in best_pairs(search.frame, scores, base.model, base.theta, INVENTION.pairs):
        first, second = pair.first.influence.effect, pair.second.influence.effect
        yield _Two(first, second, pair.model, pair.start, base.rss - pair.gain)


def _shortened(search: Search, memory: Memory) -> Iterator[Grown]:
    """The best laws with one thing less, each once."""
    base = search.base
    done = {text_of(grown.effects[0]) for grown in search.grown}
    for grown in search.grown[: INVENTION.extended]:
        (effect,) = grown.effects
        known = grown.refit.model.named(grown.refit.theta)
        values = {name: known.pop(f"{effect.name}.{name}") for name in _names(effect)}
        for text, start in shorter(effect, values):
            if text in done:
                continue
            done.add(text)
            for law in laws([text], base.fit.measurement):
                seed = _seed(base.model + law, known, law, start)
                yield from _with_law(search, law, [seed], memory)


def _joined(first: Effect, second: Effect) -> str:
    """The text of the sum of two laws, the second's size being told in that of the first.

    So one parameter alone still makes the law vanish.
    """
    word, _, one = text_of(first).partition(": ")
    other = renamed(formula_of(second), _names(first))
    size = new_names(formula_of(second), _names(first))[_names(second)[0]]
    mine = f"{_names(first)[0]}*{RATIO}"
    other = re.sub(rf"/{size}\b", f"/({mine})", other)
    other = re.sub(rf"\b{size}\b", mine, other)
    return f"{word}: {one} + {other}".replace("+ -", "- ")


def _carried(two: _Two, model: Model, both: Effect) -> Real:
    """The start of the model with two laws, as that of the model with one law of both."""
    values = dict(zip(two.model.names, two.start.tolist(), strict=True))
    mine = {name: values.pop(f"{two.first.name}.{name}") for name in _names(two.first)}
    size, *others = _names(two.second)
    ratio = values.pop(f"{two.second.name}.{size}") / mine[_names(two.first)[0]]
    called = new_names(formula_of(two.second), _names(two.first))
    for name in others:
        mine[called[name]] = values.pop(f"{two.second.name}.{name}")
    mine[RATIO] = ratio
    return _seed(model, values, both, mine)


def _seed(
    model: Model, known: Mapping[str, float], law: Effect, values: Mapping[str, float]
) -> Real:
    """Parameters of a model with a law, the law's own by their short names."""
    whole = {**known, **{f"{law.name}.{name}": values[name] for name in _names(law)}}
    # A fit of a material takes the effects' parameters from the end, and asks for no lines.
    return np.array([whole[name] for name in model.names if name in whole])


def _names(effect: Effect) -> list[str]:
    return [parameter.name for parameter in effect.element.parameters]
