"""Relaxations, or creep, at several temperatures as what a master curve is made of.

After a step of the displacement a material shows one function of time, G(t) = K_e + sum of g_j
exp(-r_j t), after one of the force another, J(t) = J_g + t / eta + sum of L_j (1 - exp(-r_j t)). A
shift factor multiplies the times in them as it multiplies frequencies: G(t; T) = b G(t / a) and
J(t; T) = J(t / a) / b. So they are laid over one another as sweeps are, at 1 / t in place of omega.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from springpot.errors import DataError
from springpot.identification.problem import Objective
from springpot.measurement.measurement import Measurement
from springpot.measurement.timetest import TimeTest
from springpot.rheology.continuum import Compliance, Continuum, Relaxation
from springpot.rheology.points import Complex, Real

SHOWN = {"relaxation": Relaxation(), "creep": Compliance()}
"""Any material, as tests of each kind show it."""
PER_DECADE = 20
"""Points of a decade of time: a spectrum changes little from one to the next (a factor of 1.12)."""


class AfterSteps(NamedTuple):
    """Tests as one set of points.

    Attributes
    ----------
    unfitted : Continuum
        Any material, as these tests show it.
    points : Measurement
        Moduli or compliances at 1 / t, with the temperature of each.
    """

    unfitted: Continuum
    points: Measurement


def after_steps(tests: Sequence[TimeTest]) -> AfterSteps:
    """What all tests show at 1 / t, with the temperature of each sample.

    The time counts from the middle of the step, as after a ramp the answer is that of a sudden step
    there (L. J. Zapas and J. C. Phillips, 1971, J. Res. NBS 75A, 33). Of samples that lie closer
    than twenty to a decade the mean is taken.

    Parameters
    ----------
    tests : sequence of TimeTest
        Relaxations or creep, each at one temperature.

    Raises
    ------
    DataError
        If a test is of another kind than these or than the first, its temperature is not known, or
        what it shows is not positive.
    """
    kind = tests[0].kind
    columns = [_shown(test.in_units(tests[0].units), kind) for test in tests]
    rates, values, celsius = (np.concatenate(column) for column in zip(*columns, strict=True))
    points = Measurement(
        rates,
        values.astype(np.complex128),
        conditions={"temperature": celsius},
        units=tests[0].units,
        name=" + ".join(dict.fromkeys(test.name.partition("#")[0] for test in tests)),
        provenance=tests[0].provenance,
    )
    return AfterSteps(SHOWN[kind], points)


def _shown(test: TimeTest, kind: str) -> tuple[Real, Real, Real]:
    """One over time, what was read after the step, and the temperature (n,)."""
    if test.kind not in SHOWN or test.kind != kind:
        raise DataError(
            f"{test.name}: a master curve is made of sweeps, of relaxations or of creep, all alike,"
            f" and this is a test of {test.kind}"
        )
    if test.temperature is None:
        raise DataError(
            f"{test.name}: a master curve needs the temperature: add a column, or open it as"
            f" '{test.name}?temperature=25[degC]'"
        )
    clock = test.time - test.start
    seen = clock > test.rise
    values = test.response[seen] / test.loading.value[-1]
    if not len(values) or np.any(values <= 0.0):
        raise DataError(
            f"{test.name}: what it shows is not positive after the step: leave such samples out"
        )
    log_rates = -np.log(clock[seen] - 0.5 * test.rise)
    bins = np.unique(np.floor(log_rates * PER_DECADE / np.log(10.0)), return_inverse=True)[1]
    count = np.bincount(bins)
    rates = np.exp(np.bincount(bins, log_rates) / count)
    return rates, np.bincount(bins, values) / count, np.full(len(count), test.temperature)


def by_one_number(objective: Objective) -> Objective:
    """An objective for data that are one number at each point, and have no loss."""

    def weights(measurement: Measurement) -> Complex:
        return np.asarray(objective.weighing(measurement).real, dtype=np.complex128)

    return Objective(objective.name, objective.summary, weights, objective.logarithmic)
