"""What plugins offer, described for people and as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, fields
from typing import Any

from springpot.hooks import SolverFormat
from springpot.identification.problem import Objective
from springpot.identification.runs import Optimiser, OptimiserFamily
from springpot.measurement.opening import DataSet, Measured, Suite, TimeReader
from springpot.measurement.reader import Reader
from springpot.measurement.units import Units
from springpot.registry import Registry
from springpot.rheology.drawing import drawing_of
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model
from springpot.rheology.parameters import Parameter
from springpot.writing import suggested

from .text import TextTable, indented

EXAMPLE_UNITS = Units("N/m", "m")
"""The units in which a model's parameters are listed; results come in those of the data."""

EXAMPLE_MEMBER = 2
"""The member by which a family such as ``prony-N`` is shown."""


@dataclass(frozen=True)
class KindOfCard:
    """How one kind of thing is found and shown.

    Parameters
    ----------
    word : str
        What the registry calls it.
    columns : tuple of str
        Keys of the description that make the table.
    describe : callable
        From the thing to its description.
    """

    word: str
    columns: tuple[str, ...]
    describe: Callable[[Any], dict[str, Any]]

    def find(self, plugins: Registry, name: str) -> Any:
        """The thing called `name`; of models also a member of a family, of effects a typed law."""
        # To a user a reader of tests in time is a reader as any other.
        if self.word == "reader" and name in plugins.names("time reader"):
            return plugins.find("time reader", name)
        if self.word == "effect":
            return plugins.effect(name)
        if self.word != "model":
            return plugins.find(self.word, name)
        models = plugins.shelf("model").items
        # A family stands for itself here; `plugins.model` would ask which member is meant.
        if name in models:
            return models[name]
        return plugins.model(name)

    def all(self, plugins: Registry) -> list[Any]:
        """All that there are.

        Of optimisers also libraries of many, which are not imported for that.
        """
        items = list(plugins.items(self.word))
        beside = {"optimiser": "optimiser family", "reader": "time reader"}.get(self.word)
        if beside is not None:
            items += plugins.items(beside)
        return items


def model(item: Model | Family) -> dict[str, Any]:
    """Describe a model, or a family by its second member."""
    # A family has no parameters before its size is chosen.
    if isinstance(item, Family):
        shown = item.build(EXAMPLE_MEMBER)
    else:
        shown = item
    search_parameters = []
    if shown.search:
        search_parameters = parameters(shown.search.parameters)
    return {
        "name": item.name,
        "aliases": list(item.aliases),
        "summary": item.summary,
        "citation": shown.citation,
        "parameters": parameters(shown.parameters),
        "search_parameters": search_parameters,
        "needs": sorted(shown.needs),
        "drawing": drawing_of(shown),
    }


def effect(item: Effect) -> dict[str, Any]:
    """Describe an effect."""
    equation = ""
    if item.equation:
        equation = f"K_m = {item.equation}"
    return {
        "name": item.name,
        "aliases": list(item.aliases),
        "summary": item.summary,
        "equation": equation,
        "plane": item.plane,
        "layer": item.layer.name.lower().replace("_", " "),
        "tests": str(item.applies_to),
        "needs": sorted(item.needs),
        "parameters": parameters(item.element.parameters),
        "citation": item.citation,
        "approximate": item.approximate,
        "signature": item.signature,
    }


def optimiser(item: type[Optimiser] | OptimiserFamily) -> dict[str, Any]:
    """Describe an optimiser with its options and their defaults, or a library of optimisers."""
    if isinstance(item, OptimiserFamily):
        # What its members can do is known only once the library is imported.
        summary = f"{item.summary}: {suggested('list optimisers', item.name)}"
        known = dict.fromkeys(("global", "gradient", "batched", "stochastic"), False)
        return {"name": item.name, "summary": summary, "citation": "", **known, "options": {}}
    card = item.card
    return {
        "name": item.name,
        "summary": card.summary,
        "citation": card.citation,
        "global": card.globally,
        "gradient": card.gradient,
        "batched": card.batched,
        "stochastic": card.stochastic,
        "options": options(item),
    }


def dataset(item: DataSet) -> dict[str, Any]:
    """Describe a registered data set, without loading it."""
    return {
        "name": item.name,
        "kind": item.kind,
        # Zero stands for a size that is not known beforehand.
        "points": item.size or None,
        "licence": item.licence,
        "where": item.where,
        "summary": item.summary,
        "citation": item.citation,
        "doi": item.doi,
        "origin": item.origin,
        "test": item.test,
        "columns": list(item.columns),
        "model": item.model,
        "fit": item.fit,
        "truth": dict(item.truth),
        "physics": list(item.physics),
        "aliases": list(item.aliases),
        "unavailable": item.unavailable,
    }


def suite(item: Suite) -> dict[str, Any]:
    """Describe a suite; its problems are not computed for that."""
    return {"name": item.name, "problems": len(item.problems), "summary": item.summary}


def problem(item: DataSet, measured: Measured | None) -> dict[str, Any]:
    """Describe a problem of a suite, with what was measured of it."""
    told = {"part": "", "features": {}}
    if measured is not None:
        told = {"part": measured.part, "features": dict(measured.features)}
    kept = ("name", "summary", "model", "truth", "test", "kind", "licence", "citation")
    described = dataset(item)
    known = {key: described[key] for key in kept}
    return known | told | {"objective": item.objective, "best": item.best}


def reader(item: Reader | TimeReader) -> dict[str, Any]:
    """Describe a reader of sweeps, signals that become points of a sweep, or tests in time."""
    signals = writes = False
    if isinstance(item, TimeReader):
        holds = "tests in time"
    else:
        signals, writes = item.signals is not None, item.text is not None
        holds = "sweeps"
        if signals:
            holds = "signals"
    return {
        "name": item.name,
        "summary": item.summary,
        "holds": holds,
        "signals": signals,
        "writes": writes,
    }


def objective(item: Objective) -> dict[str, Any]:
    """Describe an objective."""
    return {"name": item.name, "summary": item.summary, "citation": item.citation}


def writer(item: SolverFormat) -> dict[str, Any]:
    """Describe a writer."""
    return {"name": item.name, "summary": item.summary, "suffix": item.suffix}


def parameters(of: Iterable[Parameter]) -> list[dict[str, Any]]:
    """Describe parameters, with the units of data in N/m and m."""
    return [
        {
            "name": parameter.name,
            "symbol": parameter.symbol,
            "unit": EXAMPLE_UNITS.of(parameter.unit)[1],
            "lower": parameter.lower,
            "upper": parameter.upper,
        }
        for parameter in of
    ]


def options(of: type[Optimiser]) -> dict[str, Any]:
    """An optimiser's options and their defaults."""
    defaults: dict[str, Any] = {}
    for option in fields(of):  # type: ignore[arg-type]
        # An option without a default has to be given: it is listed all the same.
        defaults[option.name] = None
        if option.default_factory is not MISSING:
            defaults[option.name] = option.default_factory()
        elif option.default is not MISSING:
            defaults[option.name] = option.default
    return defaults


# By the words that a user types behind ``springpot list``.
KINDS = {
    "models": KindOfCard("model", ("name", "parameters", "summary"), model),
    "optimisers": KindOfCard(
        "optimiser", ("name", "global", "gradient", "batched", "summary"), optimiser
    ),
    "effects": KindOfCard("effect", ("name", "plane", "tests", "needs", "summary"), effect),
    "datasets": KindOfCard(
        "data set", ("name", "kind", "points", "licence", "where", "summary"), dataset
    ),
    "suites": KindOfCard("suite", ("name", "problems", "summary"), suite),
    "readers": KindOfCard("reader", ("name", "holds", "writes", "summary"), reader),
    "objectives": KindOfCard("objective", ("name", "summary"), objective),
    "writers": KindOfCard("writer", ("name", "suffix", "summary"), writer),
}


PROBLEM_COLUMNS = ("name", "part", "model", "test", "summary")
"""Of the problems of a suite, which its name lists."""


def cell(value: Any) -> str:
    """A value of a description as one line of text."""
    if value is None or value in ("", [], {}):
        return ""
    # An empty cell is read as no: a column of `False` would hide the few that are yes.
    if isinstance(value, bool):
        if value:
            return "yes"
        return ""
    if isinstance(value, dict):
        return ", ".join(f"{key} = {item}" for key, item in value.items())
    if isinstance(value, list):
        return ", ".join(_word(item) for item in value)
    return str(value)


def _word(item: Any) -> str:
    """An entry of a list; of a parameter its name."""
    if isinstance(item, dict):
        return str(item["name"])
    return str(item)


def card(description: dict[str, Any]) -> str:
    """A description as a few lines: name and summary, the drawing, then whatever is known."""
    lines = [f"{description['name']}: {description['summary']}"]
    if description.get("drawing"):
        lines += ["", indented(description["drawing"]), ""]
    for key, value in description.items():
        # What is not known is not told: half of a card would be empty lines.
        if key in ("name", "summary", "drawing") or value in (None, "", [], {}, False):
            continue
        if key == "parameters":
            lines += [indented(_parameter_table(value))]
        else:
            lines += [f"  {key.replace('_', ' ')}: {cell(value)}"]
    return "\n".join(lines)


def _parameter_table(of: list[dict[str, Any]]) -> str:
    rows = [
        [item["name"], item["symbol"], item["unit"], f"{item['lower']:g} to {item['upper']:g}"]
        for item in of
    ]
    return TextTable(("parameter", "symbol", "unit (data in N/m)", "range"), rows).plain()
