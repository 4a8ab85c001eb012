"""Further cases of what the suite tests by a few: run by ``make soak`` only."""

from __future__ import annotations

from typing import Any

import pytest


def soaked(*values: Any, **named: Any) -> Any:
    """One case of a parametrised test for the soak; arguments as for `pytest.param`."""
    marks = [pytest.mark.soak, *named.pop("marks", ())]
    return pytest.param(*values, marks=marks, **named)
