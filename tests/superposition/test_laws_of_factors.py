"""Laws judged beside known factors: by their scatter, and by what sweeps have in common."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares

from springpot.identification.free_factors import Factors
from springpot.identification.known_factors import Allowed
from springpot.rheology import Points
from springpot.superposition.laws import SLOWER, judged_laws, slower_when_hot

CELSIUS = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0])
KELVIN = CELSIUS + 273.15
ARRHENIUS = 7000.0 * (1.0 / KELVIN - 1.0 / 303.15)
WLF = -np.log(10.0) * 8.0 * (CELSIUS - 30.0) / (120.0 + CELSIUS - 30.0)
OFF = np.array([0.02, -0.03, 0.0, 0.015, -0.025, 0.03])


def factors(log_a, sd=0.02, log_b=None, levels=CELSIUS, column="temperature"):
    m = len(levels)
    variance = np.full(2 * m, sd**2)
    variance[[2, m + 2]] = 0.0
    covariance = np.diag(variance) + 0.3 * np.outer(np.sqrt(variance), np.sqrt(variance))
    return Factors(
        column, levels, 2, log_a, np.zeros(m) if log_b is None else log_b, covariance, 2.0
    )


def as_said_by(found, element):
    """The data themselves say what the factors say."""
    at = Points(np.zeros(len(found)), None, found.levels + 273.15, 303.15)
    bounds = np.array([(p.lower, p.upper) for p in element.parameters]).T

    def off(theta):
        return element.respond(theta, at).value.real - found.log_a

    starts = [
        bounds[0] + np.array([0.05, share])[: len(bounds[0])] * np.ptp(bounds, axis=0)
        for share in (0.1, 0.3, 0.6)
    ]
    ends = [least_squares(off, start, bounds=bounds, x_scale="jac") for start in starts]
    theta = min(ends, key=lambda end: end.cost).x
    return theta, 0.9 * theta, 1.1 * theta


def allowed(overlaps):
    m = len(CELSIUS)
    first, last = np.full(m, -2.0), np.full(m, 2.0)
    return Allowed("temperature", CELSIUS, first, last, np.full((m, m), overlaps))


def judged(found, placed=None, told=False, overlaps=False):
    m = len(found)
    every = np.ones(m, dtype=bool)
    laws, refused = judged_laws(
        found,
        every if placed is None else placed,
        every & told,
        partial(as_said_by, found),
        allowed(overlaps),
    )
    return {
        "laws": [{**law.to_dict(), "factors": law.log_factors, "low": law.low} for law in laws],
        "refused": refused,
    }


CASES = {
    "activated": lambda: judged(factors(ARRHENIUS + OFF)),
    "glassy": lambda: judged(factors(WLF + OFF)),
    "surely glassy": lambda: judged(factors(WLF + OFF / 10.0, sd=0.002)),
    "unsure": lambda: judged(factors(WLF + OFF, sd=0.5)),
    "vertical": lambda: judged(factors(WLF + OFF, log_b=np.log(KELVIN / 303.15) + OFF), told=True),
    "two levels": lambda: judged(factors(WLF, levels=CELSIUS), placed=CELSIUS < 40.0),
    "in common": lambda: judged(factors(3.0 * ARRHENIUS), overlaps=True),
    "a law of none": lambda: judged(factors(np.array([4.0, 3.0, 0.0, -3.0, -4.0, -4.1]))),
    "pressure": lambda: judged(factors(ARRHENIUS, column="pressure")),
}


@pytest.mark.parametrize("case", list(CASES))
def test_laws_beside_factors(case, stays):
    stays(CASES[case](), within=1e-3)


ALL = np.ones(len(CELSIUS), dtype=bool)


def test_shifts_that_rise_beyond_their_scatter_are_told():
    rising = 0.002 * (CELSIUS - 30.0)
    assert slower_when_hot(factors(rising, sd=0.02), ALL) == [SLOWER]
    assert slower_when_hot(factors(rising, sd=0.08), ALL) == []
    assert slower_when_hot(factors(-rising, sd=0.02), ALL) == []
    assert slower_when_hot(factors(rising, column="pressure"), ALL) == []
    assert slower_when_hot(factors(rising), CELSIUS == 30.0) == []
