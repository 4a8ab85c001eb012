"""``springpot list``: what is installed, and which plugins could not be used."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from .common import emit, json_option

if TYPE_CHECKING:
    from springpot.measurement.opening import Suite
    from springpot.registry import Registry

KINDS = (
    "models",
    "optimisers",
    "effects",
    "datasets",
    "suites",
    "readers",
    "objectives",
    "writers",
)


@click.command("list", epilog="Example: springpot list models fractional-zener")
@click.argument("kind", type=click.Choice(KINDS), metavar="KIND")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option(
    "--verbose", "-v", is_flag=True, help="Show every detail of each, such as drawings and options."
)
@json_option
def command(kind: str, names: Sequence[str], verbose: bool, as_json: bool) -> None:
    """List what is installed of one KIND; with a NAME, show all that is known about it.

    Of a library of optimisers, such as optimagic-NAME, its name lists what it has, and that of a
    suite its problems.

    KIND is models, optimisers, effects, datasets, suites, readers, objectives or writers.
    Plugins that could not be loaded are listed with their distribution and the reason.
    """
    from springpot.registry import plugins
    from springpot.report import plugin_cards as cards

    installed = plugins()
    kind_of = cards.KINDS[kind]
    columns, whole = kind_of.columns, verbose
    members = _members(installed, kind, names)
    if kind == "suites" and names:
        described, whole = _problems(installed, names), any("/" in name for name in names)
        columns = cards.PROBLEM_COLUMNS
    elif members is not None:
        described = [kind_of.describe(item) for item in members]
    elif names:
        described, whole = [kind_of.describe(kind_of.find(installed, name)) for name in names], True
    else:
        described = [kind_of.describe(item) for item in kind_of.all(installed)]
    result: dict[str, Any] = {
        "schema": "springpot.list/1",
        "kind": kind,
        "items": described,
        "unavailable": [
            {"plugin": fault.plugin, "distribution": fault.distribution, "reason": fault.reason}
            for fault in installed.faults
        ],
    }
    emit(result, as_json, lambda: _show(columns, result, whole))


def _members(installed: Registry, kind: str, names: Sequence[str]) -> list[Any] | None:
    """Optimisers of a library that is named, and only here imported; None where none is."""
    if kind != "optimisers" or len(names) != 1:
        return None
    families = {family.name: family for family in installed.items("optimiser family")}
    if names[0] not in families:
        return None
    return list(families[names[0]].members().values())


def _problems(installed: Registry, names: Sequence[str]) -> list[dict[str, Any]]:
    """The problems of suites, or single ones that are named ``SUITE/PROBLEM``."""
    from springpot.report import plugin_cards as cards

    described = []
    for name in names:
        suite: Suite = installed.find("suite", name.partition("/")[0])
        problems = (suite.problem(name),) if "/" in name else suite.problems
        described += [cards.problem(each, suite.measured.get(each.name)) for each in problems]
    return described


def _show(columns: Sequence[str], result: dict[str, Any], whole: bool) -> None:
    from springpot.report import plugin_cards as cards
    from springpot.report.text import TextTable

    if whole:
        print("\n\n".join(cards.card(item) for item in result["items"]))
    elif result["items"]:
        headers = [column.replace("_", " ") for column in columns]
        rows = [[cards.cell(item[column]) for column in columns] for item in result["items"]]
        TextTable(headers, rows, frozenset({"size", "points"})).show()
    else:
        print(f"no {result['kind']} are installed")
    # Below every list: what somebody misses there may be what could not be loaded.
    for fault in result["unavailable"]:
        print(
            f"unavailable: plugin '{fault['plugin']}' of {fault['distribution']}: {fault['reason']}"
        )
