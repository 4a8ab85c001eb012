"""Pages without their pictures, which are most of the work."""

from io import BytesIO
from typing import Any

import pytest


def leave_unpainted(patch: pytest.MonkeyPatch) -> None:
    """Let the pictures in a page be drawn up but not painted."""
    figure = pytest.importorskip("matplotlib.figure")
    paint = figure.Figure.savefig

    def stand_in(self: Any, file: Any, **given: Any) -> None:
        if isinstance(file, BytesIO):
            file.write(b"<svg></svg>")
        else:
            paint(self, file, **given)

    patch.setattr(figure.Figure, "savefig", stand_in)
