"""Many specimens with parameters of their own against as many fits of one each, in the same run.

Ratios, never absolute times.
"""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from patience import patient

import springpot
from springpot.identification import fit

SLACK = 2.0
"""Cost of a specimen among many over that among few; what is dense in all would cost 16 times."""


def batch(count: int) -> springpot.Measurement:
    """Specimens of twenty points each that differ in stiffness and dashpot."""
    rng, specimen = np.random.default_rng(1), np.repeat(np.arange(1.0, count + 1), 20)
    omega = np.tile(np.geomspace(1.0, 100.0, 20), count)
    k, c = (size * np.repeat(np.exp(0.1 * rng.standard_normal(count)), 20) for size in (100.0, 2.0))
    noise = 1.0 + 0.003 * (rng.standard_normal(len(omega)) + 1j * rng.standard_normal(len(omega)))
    exact = (k + 1j * c * omega) * noise
    return springpot.Measurement(omega, exact, conditions={"specimen": specimen})


def seconds(count: int, own: str, tie: tuple[str, ...] = ()) -> float:
    """Processor time of a fit with its intervals and population, of a specimen."""
    data = batch(count)
    began = process_time()
    fit = springpot.identify(data, "kelvin", own={own: "specimen"}, tie=tie)
    assert fit.parameters
    assert fit.populations
    return (process_time() - began) / count


@pytest.mark.soak
@pytest.mark.parametrize(("own", "tie"), [("k", ()), ("*", ()), ("k", ("c = 0.02*k",))])
@patient
def test_a_specimen_costs_the_same_among_many(own, tie, capsys):
    seconds(10, own, tie)
    few, many = seconds(100, own, tie), seconds(1600, own, tie)
    with capsys.disabled():
        print(
            f"\n{own} {tie}: {1e3 * few:.2f} ms a specimen among 100, {1e3 * many:.2f} among 1600"
        )
    assert many < SLACK * few


@patient
def test_specimens_together_cost_less_than_each_alone(capsys):
    model, data = springpot.parse_model("kelvin"), batch(100)
    parts = [data.subset(data.conditions["specimen"] == i) for i in range(1, 101)]
    together = seconds(100, "*")
    began = process_time()
    for part in parts:
        fit(model, part)
    alone = (process_time() - began) / 100
    with capsys.disabled():
        print(f"\n{1e3 * together:.2f} ms a specimen together, {1e3 * alone:.2f} alone")
    assert together < alone
