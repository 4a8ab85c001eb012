"""Units of a formula's parameters, worked out from those of what it stands among.

Addends have one unit, powers and what functions take have none, and the whole has that of its
plane: linear equations for the powers of the units of each parameter, solved one by one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from springpot.errors import ModelError

from ..numerics import ALIKE
from .grammar import OWN, free_names
from .parameters import Dimension, Exponent
from .terms import Called, Joined, Name, Number, Power, Term

Unit: TypeAlias = dict[tuple[str, str], float]
"""Powers of units: ``("time", "")`` to a number, ``("time", "alpha")`` to a multiple of alpha.

``("?", "k")`` is the unit of the parameter k, yet to be found.
"""
PURE: Unit = {}
OF_VARIABLE: dict[str, Unit] = {
    "omega": {("time", ""): -1.0},
    "s": {("time", ""): -1.0},
    "f": {("time", ""): -1.0},
    "X": {("amplitude", ""): 1.0},
    "T": {("K", ""): 1.0},
    "T0": {("K", ""): 1.0},
}
OF_PLANE: dict[str, Unit] = {
    "stiffness": {("stiffness", ""): 1.0},
    "compliance": {("stiffness", ""): -1.0},
    "log-complex": PURE,
    "shift": PURE,
}
GAS: Unit = {("kJ/mol", ""): 1.0, ("K", ""): -1.0}
_WORDS = {"stiffness": "a stiffness", "time": "a time", "amplitude": "an amplitude"}


def units_of(
    term: Term, plane: str, text: str, columns: Mapping[str, object], whole: bool = True
) -> dict[str, Dimension]:
    """The unit of each parameter of a formula.

    Parameters
    ----------
    term : Term
        The formula.
    plane : str
        What it gives: a ``stiffness``, a ``compliance``, or a factor (``log-complex``, ``shift``).
    text : str
        As it was typed, for messages.
    columns : mapping of str
        Names that are columns of the data; each has a unit of its own.
    whole : bool
        Whether these are all: else what seems one parameter too many may be a column.

    Raises
    ------
    ModelError
        If units do not fit each other, or two parameters count only together.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology.dimensional import units_of
    >>> from springpot.rheology.grammar import parsed
    >>> text = "-m*omega^2"
    >>> Units("kN/m", "mm").of(units_of(parsed(text), "stiffness", text, {})["m"])
    (1000.0, 'kg')
    """
    equations = _Equations(text, columns)
    found = equations.unit(term)
    equations.equal(found, OF_PLANE[plane], term, f"the whole is {_shown(OF_PLANE[plane])}")
    names = free_names(term, columns)
    units = {name: equations.resolved({("?", name): 1.0}) for name in names}
    for name, unit in units.items():
        # As units may be scaled there at will, so may the numbers: the law stays the same.
        others = [other for base, other in unit if base == "?"]
        if others and whole:
            together = ", ".join(dict.fromkeys([name, *others]))
            raise ModelError(f"'{text:.80}': {together} count only together: leave out one of them")
    return {name: _dimension(unit) for name, unit in units.items()}


class _Equations:
    """What is known of the units so far."""

    def __init__(self, text: str, columns: Mapping[str, object]) -> None:
        self.text = text
        self.columns = columns
        self.found: dict[str, Unit] = {}

    def resolved(self, unit: Unit) -> Unit:
        """A unit with those of the parameters that are known already put in."""
        whole: Unit = {}
        for key, power in unit.items():
            base, name = key
            if base == "?" and name in self.found:
                whole = _sum(whole, self.resolved(self.found[name]), power)
            else:
                whole = _sum(whole, {key: power})
        return whole

    def equal(self, a: Unit, b: Unit, term: Term, why: str) -> None:
        """Let two units be one; what is open is found by it."""
        off = self.resolved(_sum(a, b, -1.0))
        for (base, name), power in off.items():
            if base == "?":
                rest = {key: value for key, value in off.items() if key != (base, name)}
                self.found[name] = _sum({}, rest, -1.0 / power)
                return
        if off:
            here = _shown(self.resolved(a))
            raise ModelError(
                f"'{self.text:.80}', sign {term.place}: units do not fit: {why}, here is {here}"
            )

    def unit(self, term: Term) -> Unit:
        """The unit of a part, and on the way all that follows from it."""
        if isinstance(term, Number):
            return GAS if term.name == "R" else PURE
        if isinstance(term, Name):
            own: Unit = {("?", term.name): 1.0}
            if term.name in self.columns:
                own = {("amplitude" if term.name == OWN else term.name, ""): 1.0}
            return OF_VARIABLE.get(term.name, own)
        if isinstance(term, Called):
            return self._called(term)
        if isinstance(term, Power):
            return self._power(term)
        assert isinstance(term, Joined)
        left, right = self.unit(term.left), self.unit(term.right)
        if term.sign in "*/":
            return _sum(left, right, 1.0 if term.sign == "*" else -1.0)
        # Nothing has any unit: max(0, X - Xc).
        nothing = [isinstance(part, Number) and part.value == 0 for part in term.parts]
        if not any(nothing):
            word = f"beside {_shown(self.resolved(left))}"
            self.equal(right, left, term.right, f"{word} stands the same")
        return right if nothing[0] else left

    def _called(self, term: Called) -> Unit:
        inner = self.unit(term.inner)
        if term.function == "abs":
            return inner
        if term.function == "sqrt":
            return _sum({}, inner, 0.5)
        self.equal(inner, PURE, term.inner, f"{term.function} takes a pure number")
        return PURE

    def _power(self, term: Power) -> Unit:
        self.equal(self.unit(term.exponent), PURE, term.exponent, "a power is a pure number")
        base, exponent = self.resolved(self.unit(term.base)), _linear(term.exponent)
        if exponent is not None and set(exponent) <= {""}:
            return _sum({}, base, exponent.get("", 0.0))
        plain = all(kind != "?" and not symbol for kind, symbol in base)
        # (X/Xc)^n is a pure number to the power n: what is open below a free power makes it so.
        if exponent is None or not plain:
            self.equal(base, PURE, term.base, "below this power stands a pure number")
            return PURE
        return {
            (kind, symbol): power * share
            for (kind, _), power in base.items()
            for symbol, share in exponent.items()
        }


def _linear(term: Term) -> dict[str, float] | None:
    """A power as multiples of parameters, of one under ``""``; None where it is no such sum."""
    if isinstance(term, Number):
        return {"": term.value.real}
    if isinstance(term, Name):
        return {term.name: 1.0}
    if not isinstance(term, Joined):
        return None
    left, right = _linear(term.left), _linear(term.right)
    if left is None or right is None:
        return None
    if term.sign in "+-":
        sign = 1.0 if term.sign == "+" else -1.0
        pairs = {**left, **right}
        sums = {name: left.get(name, 0.0) + sign * right.get(name, 0.0) for name in pairs}
        return {name: share for name, share in sums.items() if share}
    if term.sign == "*" and set(left) == {""}:
        return {name: share * left[""] for name, share in right.items()}
    if term.sign in "*/" and set(right) == {""} and right[""]:
        factor = right[""] if term.sign == "*" else 1.0 / right[""]
        return {name: share * factor for name, share in left.items()}
    return None


def _sum(a: Unit, b: Unit, times: float = 1.0) -> Unit:
    whole = dict(a)
    for key, power in b.items():
        whole[key] = whole.get(key, 0.0) + times * power
    return {key: power for key, power in whole.items() if abs(power) > ALIKE}


def _plain(power: float) -> float:
    """A whole number where it is one: it is printed."""
    rounded = round(power, 9)
    return int(rounded) if rounded == int(rounded) else rounded


def _dimension(unit: Unit) -> Dimension:
    """Powers of stiffness, time and amplitude, and what is beyond them."""
    powers: dict[str, Exponent] = {}
    for (base, symbol), power in unit.items():
        if base == "?":
            return Dimension()
        powers[base] = (*powers.get(base, ()), (symbol, _plain(power)))
    if list(powers) in (["K"], ["kJ/mol"]) and next(iter(powers.values())) == (("", 1),):
        return Dimension(label=next(iter(powers)))
    plain = {base: power[0][1] for base, power in powers.items() if power[0][0] == ""}
    whole = {base: number for base, number in plain.items() if len(powers[base]) == 1}
    time: float | str = whole.get("time", 0)
    # What is beside a fractional order in one unit has a name of its own for long: N s^alpha/m.
    if len(powers.get("time", ())) == 1 and powers["time"][0][1] == 1 and powers["time"][0][0]:
        time = powers.pop("time")[0][0]
    usual = ("stiffness", "time", "amplitude")
    beyond = tuple(
        (base, power)
        for base, power in sorted(powers.items())
        if not (base in usual and base in whole)
    )
    stiffness, amplitude = whole.get("stiffness", 0), whole.get("amplitude", 0)
    return Dimension(stiffness, time, amplitude, beyond=beyond)


def _shown(unit: Unit) -> str:
    """A unit in words."""
    words = []
    for (base, symbol), power in unit.items():
        word = f"the unit of {symbol}" if base == "?" else _WORDS.get(base, base)
        exponent = f"{_plain(power):g}" + (f"*{symbol}" if symbol and base != "?" else "")
        words.append(word if exponent == "1" else f"{word}^{exponent}")
    return " times ".join(words) or "a pure number"
