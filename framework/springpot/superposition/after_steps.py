"""Relaxations at several temperatures as what a master curve is made of.

After a step of the displacement a material shows one function of time, G(t) = K_e + sum of g_j
exp(-r_j t), and a shift factor multiplies the times in it as it multiplies frequencies: G(t; T) =
b G(t / a). So relaxations are laid over one another as sweeps are, at 1 / t in place of omega.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.errors import DataError
from springpot.identification.problem import Objective
from springpot.measurement.measurement import Measurement
from springpot.measurement.timetest import TimeTest
from springpot.rheology.points import Complex, Real


def after_steps(tests: Sequence[TimeTest]) -> Measurement:
    """The relaxation moduli of all tests at 1 / t, with the temperature of each sample.

    The time counts from the middle of the step, as after a ramp the answer is that of a sudden step
    there (L. J. Zapas and J. C. Phillips, 1971, J. Res. NBS 75A, 33).

    Parameters
    ----------
    tests : sequence of TimeTest
        Relaxations, each at one temperature.

    Raises
    ------
    DataError
        If a test is no relaxation, its temperature is not known, or it shows no positive modulus.
    """
    columns = [_modulus(test.in_units(tests[0].units)) for test in tests]
    rates, moduli, celsius = (np.concatenate(column) for column in zip(*columns, strict=True))
    return Measurement(
        rates,
        moduli.astype(np.complex128),
        conditions={"temperature": celsius},
        units=tests[0].units,
        name=" + ".join(dict.fromkeys(test.name.partition("#")[0] for test in tests)),
        provenance=tests[0].provenance,
    )


def _modulus(test: TimeTest) -> tuple[Real, Real, Real]:
    """One over time, modulus and temperature (n,) of what was read after the step."""
    if test.kind != "relaxation":
        raise DataError(
            f"{test.name}: a master curve is made of sweeps or of relaxations,"
            f" and this is a test of {test.kind}"
        )
    if test.temperature is None:
        raise DataError(
            f"{test.name}: a master curve needs the temperature: add a column, or open it as"
            f" '{test.name}?temperature=25[degC]'"
        )
    clock = test.time - test.start
    seen = clock > test.rise
    modulus = test.response[seen] / test.loading.value[-1]
    if not len(modulus) or np.any(modulus <= 0.0):
        raise DataError(
            f"{test.name}: the modulus is not positive after the step: leave such samples out"
        )
    return 1.0 / (clock[seen] - 0.5 * test.rise), modulus, np.full(len(modulus), test.temperature)


def by_one_number(objective: Objective) -> Objective:
    """An objective for data that are one number at each point, and have no loss."""

    def weights(measurement: Measurement) -> Complex:
        return np.asarray(objective.weighing(measurement).real, dtype=np.complex128)

    return Objective(objective.name, objective.summary, weights, objective.logarithmic)
