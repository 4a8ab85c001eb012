"""What a user knows beforehand, in printed units: held values, bounds, start values, options.

The words of the command line, ``alpha=0.5`` and ``k1=0:200``, become the same mappings that Python
takes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

from springpot.errors import ModelError, OptionError
from springpot.identification.runs import Optimiser
from springpot.measurement.opening import Test, conditions, tests_without
from springpot.measurement.units import Units
from springpot.registry import plugins
from springpot.rheology.model import Model
from springpot.rheology.parameters import HasParameters

Bounds = tuple[float, float]
V = TypeVar("V")


def constrained(
    model: Model,
    units: Units,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, Bounds] | None = None,
) -> Model:
    """The model with parameters held or bounded, of values in printed units.

    Parameters
    ----------
    model : Model
        The model.
    units : Units
        Those of the tests.
    fix : mapping of str to float, optional
        Parameters to hold: ``{"alpha": 0.5, "inertia.m": 0.6}``.
    bounds : mapping of str to (float, float), optional
        Lower and upper end, by name.

    Raises
    ------
    ModelError
        If a name is unknown or a value cannot be.
    OptionError
        If these are no mappings, or what they hold are no numbers.
    """
    fixed = own_values(model, units, fix, "fix")
    own_bounds: dict[str, Bounds] = {}
    for name, ends in by_name(bounds, "bounds", '{"k": (0, 200)}').items():
        # Text is a sequence too: "05" would pass for the ends 0 and 5.
        if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
            raise OptionError(
                f"bounds of {name} are a lower and an upper end, such as (0, 200), not {ends!r:.40}"
            )
        low, high = ends
        own_bounds[name] = (own_value(model, units, name, low), own_value(model, units, name, high))
    return model.holding(fixed, own_bounds)


def own_values(
    model: HasParameters, units: Units, given: Mapping[str, float] | None, option: str
) -> dict[str, float]:
    """Printed values by name, such as start values, in the units of theta.

    Raises
    ------
    ModelError
        If the model has no such parameter.
    OptionError
        If these are no values by name.
    """
    values = by_name(given, option, '{"k": 100.0}')
    return {name: own_value(model, units, name, value) for name, value in values.items()}


def by_name(given: Mapping[str, V] | None, option: str, example: str) -> Mapping[str, V]:
    """What a user gives by name of parameter; nothing where it is left out.

    Raises
    ------
    OptionError
        If it is no mapping, as where somebody writes the words of the command line.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise OptionError(
            f"{option} is a dictionary by parameter, such as {example}, not {given!r:.40}"
        )
    return given


def own_value(model: HasParameters, units: Units, name: str, value: float) -> float:
    """A printed value in the unit of theta.

    Raises
    ------
    ModelError
        If the model has no such parameter.
    OptionError
        If the value is no number.
    """
    for parameter in model.parameters:
        if parameter.name != name:
            continue
        factor, unit = units.of(parameter.unit)
        try:
            printed = float(value)
        except (TypeError, ValueError):
            raise OptionError(f"{name} is a number in {unit}, not {value!r:.40}") from None
        return printed / factor
    raise ModelError(
        f"{model.name} has no free parameter '{name}': it has {', '.join(model.names)}"
    )


def excluded(tests: Sequence[Test], exclude: str | Sequence[str]) -> list[Test]:
    """Tests without rows, chosen by texts such as ``frequency=40..60``, ``time=..0.1``, ``row=3``.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.
    """
    # A single text need not stand in a list.
    if isinstance(exclude, str):
        exclude = [exclude]
    for text in exclude:
        tests = tests_without(tests, conditions(text, text))
    return list(tests)


def values_of(texts: Iterable[str]) -> dict[str, float]:
    """Numbers by name, of texts such as ``alpha=0.5``.

    Raises
    ------
    OptionError
        If one is none.
    """
    numbers = {}
    for text in texts:
        name, value = _pair(text, "alpha=0.5")
        numbers[name] = _number(value, text)
    return numbers


def bounds_of(texts: Iterable[str]) -> dict[str, Bounds]:
    """Ends by name, of texts such as ``k1=0:200``; either end may be left open.

    Raises
    ------
    OptionError
        If one is none.
    """
    bounds = {}
    for text in texts:
        name, ends = _pair(text, "k1=0:200")
        low, colon, high = ends.partition(":")
        if not colon:
            raise OptionError(f"'{text}': write bounds as NAME=LOW:HIGH, such as k1=0:200")
        least, most = float("-inf"), float("inf")
        # An end may be left open: k1=0:
        if low.strip():
            least = _number(low, text)
        if high.strip():
            most = _number(high, text)
        bounds[name] = (least, most)
    return bounds


def optimiser_of(text: str) -> Optimiser:
    """The optimiser that ``NAME`` or ``NAME:option=value,option=value`` names.

    Raises
    ------
    ModelError
        If the name is unknown.
    OptionError
        If it has no such option, or the value is of another kind.
    """
    name, _, options = text.partition(":")
    kind: type[Optimiser] = plugins().find("optimiser", name.strip())
    chosen = {}
    for part in options.split(","):
        # A comma at the end is no option; nor is nothing behind the colon.
        if part.strip():
            option, value = _option(kind, name, part)
            chosen[option] = value
    return kind(**chosen)


def _option(kind: type[Optimiser], optimiser: str, text: str) -> tuple[str, Any]:
    name, value = _pair(text, "particles=40")
    known = {field.name: field.default for field in fields(kind) if field.init}  # type: ignore[arg-type]
    if name not in known:
        raise OptionError(
            f"{optimiser} has no option '{name}': it has {', '.join(known) or 'none'}"
        )
    # The default shows of which kind a value is.
    default = known[name]
    # Before the numbers: in Python true and false are whole numbers too.
    if isinstance(default, bool):
        if value.lower() not in ("true", "false"):
            raise OptionError(f"{optimiser}: {name} is true or false, not '{value}'")
        return name, value.lower() == "true"
    try:
        if isinstance(default, int):
            return name, int(value)
        if isinstance(default, float):
            return name, float(value)
        return name, value
    except ValueError:
        raise OptionError(
            f"{optimiser}: {name} is a number such as {default}, not '{value}'"
        ) from None


def _pair(text: str, example: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise OptionError(f"'{text}': write NAME=VALUE, such as {example}")
    return name, value


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise OptionError(f"'{where}': '{text.strip()}' is no number") from None
