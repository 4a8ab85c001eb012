"""A typed law costs at most half as much again as the same effect of a plugin, fit and all."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from patience import patient

import springpot

OMEGA = np.tile(2.0 * np.pi * np.geomspace(0.3, 30.0, 10), 6)
CONDITIONS = {
    "amplitude": np.repeat(np.geomspace(0.1, 3.0, 6), 10),
    "temperature": np.repeat(np.linspace(10.0, 60.0, 6), 10),
}
PAIRS = {
    "inertia": ("parallel: -m*omega^2", 0.002),
    "series-spring": ("series: 1/k", 900.0),
    "time-delay": ("chain: exp(-i*omega*tau)", 1e-3),
    "strain-softening": ("chain: 1/(1 + (X/Xc)^n)", 4.0, 1.0),
    "arrhenius-dashpot": ("parallel: c*i*omega*exp(E/R*(1/T - 1/T0))", 1.0, 40.0),
}
LIMIT = 1.5


def seconds(data: springpot.Measurement, models: list[springpot.Model]) -> list[float]:
    """Median processor time of a fit of each model, turn by turn, so that both meet what comes."""
    spent: list[list[float]] = [[] for _ in models]
    for _ in range(5):
        for times, model in zip(spent, models, strict=True):
            began = process_time()
            springpot.identify(data, model, seed=1)
            times.append(process_time() - began)
    return [float(np.median(times)) for times in spent]


@pytest.mark.suite_cases("inertia", "time-delay")
@patient
@pytest.mark.parametrize("name", PAIRS)
def test_a_typed_law_costs_half_as_much_again_at_most(name: str):
    text, *values = PAIRS[name]
    base = springpot.parse_model("fractional-maxwell")
    blank = springpot.Measurement(OMEGA, OMEGA + 0j, conditions=CONDITIONS)
    typed = (base + springpot.law(text)).bound_to(blank.points)
    exact = typed.stiffness(np.array([400.0, 60.0, 0.5, *values]), blank.points)
    noise = 0.005 * np.random.default_rng(3).normal(size=(2, len(OMEGA)))
    disturbed = exact * (1.0 + noise[0] + 1j * noise[1])
    data = springpot.Measurement(OMEGA, disturbed, conditions=CONDITIONS)
    plugin, own = seconds(data, [base + name, typed])
    assert own < LIMIT * plugin
