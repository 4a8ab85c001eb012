"""Every example in a docstring runs and prints what it shows."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import springpot

MODULES = [
    found.name
    for found in pkgutil.walk_packages(springpot.__path__, "springpot.")
    if not found.name.endswith("__main__")
    and not found.name.startswith("springpot.benchmark.gate.pytest_plugin")
]


@pytest.mark.soak_cases(
    "springpot.solvers.prony",
    "springpot.timetests.fitting",
    "springpot.timetests.prediction",
    "springpot.web.launch",
    "springpot.comparison.result",
    "springpot.invention.result",
    "springpot.timetests.diagnosis",
    "springpot.misfit.residuals_of_tests",
)
@pytest.mark.usefixtures("asked_once")
@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name: str, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    for found in doctest.DocTestFinder().find(importlib.import_module(name)):
        # Most docstrings have none, and a debugger would be made ready for each.
        if found.examples:
            runner.run(found)
    assert runner.failures == 0


@pytest.mark.parametrize(
    "name",
    [
        "identify",
        "diagnose",
        "discover",
        "compare",
        "mastercurve",
        "read",
        "load",
        "Measurement",
        "Units",
        "Identification",
    ],
)
def test_what_users_call_first_has_an_example(name: str):
    assert ">>> " in (getattr(springpot, name).__doc__ or "")
