"""A figure that shows itself at the end of a notebook's cell, without pyplot's global state."""

from __future__ import annotations

from io import BytesIO

from matplotlib.figure import Figure

SCREEN = 110
"""Dots per inch of a picture in a notebook: text of 10 points stays readable at a column's width.
"""


class Picture(Figure):
    """A figure of its own; notebooks ask it for its PNG."""

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=SCREEN)
        return stream.getvalue()
