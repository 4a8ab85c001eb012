"""``springpot diagnose``: which physical effect is missing from a model."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from .common import geometry_option, json_option, judged_option, opened, seed_option
from .faults import BAD_INPUT, FAULT, exit_code

if TYPE_CHECKING:
    from springpot.measurement import Measurement
    from springpot.rheology import Model


@click.command("diagnose", epilog="Example: springpot diagnose damper.csv --model fractional-maxwell")
@click.argument("data", nargs=-1, required=True, metavar="DATA...")
@judged_option
@seed_option
@geometry_option
@json_option
def command(data: tuple[str, ...], model: str | None, seed: int | None, geometry: str | None, as_json: bool) -> int:
    """Where a model fails on DATA, which physical effect is missing, how sure that is, and what to measure next.

    Without --model any linear passive material is judged: what is missing then is no part of the material.

    Each DATA is a file or a registered data set and gets its own answer; with several, --json prints one line of
    JSON for each. One that cannot be used is named on stderr, and the others are still answered.
    """
    from springpot.registry import parse_model

    expression = None if model is None else parse_model(model)
    lines = as_json and len(data) > 1
    worst = 0
    for i, name in enumerate(data):
        if i and not as_json:
            print()
        opener = partial(opened, name, geometry)
        code = exit_code(partial(_answer, opener, expression, seed or 0, as_json, lines))
        if code not in (0, BAD_INPUT, FAULT):  # interrupted, or nobody reads on
            return code
        worst = max(worst, code)
    return worst


def _answer(opener: Callable[[], Measurement], model: Model | None, seed: int, as_json: bool, line: bool) -> int:
    from springpot.api import diagnose
    from springpot.report.answers import diagnosis_text
    from springpot.report.jsontext import to_json

    measurement = opener()
    diagnosis: Any = diagnose(measurement, model, seed=seed)
    text = to_json(diagnosis, None if line else 2) if as_json else diagnosis_text(diagnosis, measurement)
    print(text, flush=True)
    return 0
