"""The pytest plugin: fixture `accuracy_gate` and option ``--springpot-update``.

Imported by every run of pytest where springpot is installed, hence nothing heavy up here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

UPDATE = "--springpot-update"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    text = "let accuracy_gate write its baselines instead of comparing with them"
    parser.getgroup("springpot").addoption(UPDATE, action="store_true", help=text)


@pytest.fixture
def accuracy_gate(request: pytest.FixtureRequest) -> Callable[..., Any]:
    """A function that fails the test if an optimiser became worse since the baseline was made.

    ``accuracy_gate("studies/gate.py")`` or ``accuracy_gate(study, baseline=path)``: arguments and
    result are those of `springpot.benchmark.gate.regression.check`. With ``--springpot-update`` it
    writes the baseline instead.
    """

    def gate(study: Any, baseline: Any = None, **options: Any) -> Any:
        __tracebackhide__ = True
        from springpot.benchmark.gate.regression import check, update
        from springpot.errors import SpringpotError

        try:
            if request.config.getoption(UPDATE):
                # The others say how to compare, which is not done here.
                shared = {key: options[key] for key in ("out", "workers") if key in options}
                return update(study, baseline, **shared)
            outcome = check(study, baseline, **options)
        except SpringpotError as error:
            pytest.fail(str(error), pytrace=False)
        # A sentence for each that got worse says more than a traceback through this file.
        if not outcome.passed:
            pytest.fail("\n".join(outcome.regressions), pytrace=False)
        return outcome

    return gate
