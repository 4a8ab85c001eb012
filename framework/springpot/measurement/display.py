"""A measurement in a notebook: its first rows and its curve."""

from __future__ import annotations

from base64 import b64encode

from springpot.drawing import draw
from springpot.errors import OutputError
from springpot.markup import Html, joined, table, tag

from .rows import Rows

SHOWN = 8
"""Rows of a table; the curve shows the rest."""


def html_of(data: Rows) -> Html:
    """The first rows in their units, and the curve where pictures can be drawn."""
    unit = data.units.stiffness
    units = {"temperature": "degC", "amplitude": data.units.amplitude}
    clock = {"Hz": "frequency [Hz]", "rad/s": "omega [rad/s]"}[data.units.clock]
    headers = [clock, f"{data.units.storage} [{unit}]", f"{data.units.loss} [{unit}]"]
    headers += [f"{name} [{units.get(name, '-')}]" for name in data.conditions]
    columns = [
        data.units.on_clock(data.frequency),
        data.storage,
        data.loss,
        *data.conditions.values(),
    ]
    rows = [[f"{column[i]:.4g}" for column in columns] for i in range(min(SHOWN, len(data)))]
    more = len(data) - len(rows)
    beside = joined(())
    if more > 0:
        beside = tag("p", f"and {more} more rows")
    return tag("div", tag("p", tag("b", data.name)), table(headers, rows), beside, _curve(data))


def _curve(data: Rows) -> Html:
    try:
        figure = draw(data)
    except OutputError:  # without matplotlib the table is all there is
        return joined(())
    picture: bytes = figure._repr_png_()  # type: ignore[union-attr]
    return tag(
        "img",
        src=f"data:image/png;base64,{b64encode(picture).decode()}",
        width="640",
        alt=data.name,
    )
