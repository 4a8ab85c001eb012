"""Patience with a busy machine.

A claim about speed fails only where it fails every time it is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

P = ParamSpec("P")
ATTEMPTS = 5


def patient(test: Callable[P, None]) -> Callable[P, None]:
    """Measure again, up to five times in all.

    What else a machine does passes, slow code stays slow.
    """

    @wraps(test)
    def again(*args: P.args, **kwargs: P.kwargs) -> None:
        for _ in range(ATTEMPTS - 1):
            try:
                return test(*args, **kwargs)
            except AssertionError:
                continue
        return test(*args, **kwargs)

    return again
