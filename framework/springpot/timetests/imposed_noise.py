"""Noise of the channel that was imposed: a model answers to it, and the specimen never felt it.

What an effect makes of that answer, as a mass that swallows what is fast, is no evidence for it
(errors in variables: Fuller 1987, Measurement Error Models, chapter 1).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.measurement.imposed import Loading
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from ..numerics import NORMAL
from .lines import is_even
from .residuals_of_tests import InTimePart, TestPart

ORDER = 8
"""Of the differences that tell the noise: of a sine of twelve samples a hundredth is left."""
OF_NOISE = 12870.0
"""Variance of such a difference of white noise of variance one: 16 over 8."""
WORTH = 0.15
"""Share of the samples that such a median is worth: by 600 simulated channels of 100 to 3,000."""
DOUBT = 2.0
"""Standard errors by which the noise may be larger than it looks."""
FEWEST = 100
"""Samples below which it is not told."""
APART = 16
"""Samples between two of the kicks that are tried, in turn up and down."""
HEARD = 0.05
"""Share of the response's own noise below which nobody hears it."""


def imposed_noise(value: Real) -> float:
    """Standard deviation of white noise in a channel (n,) that was evenly sampled.

    By the median of its differences of the eighth order, which corners do not move.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.timetests.imposed_noise import imposed_noise
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=2000)
    >>> round(imposed_noise(np.sin(0.1 * np.arange(2000)) + noise), 3)
    0.01
    """
    return NORMAL * float(np.median(np.abs(np.diff(value, ORDER)))) / float(np.sqrt(OF_NOISE))


def felt(part: TestPart, model: Model, theta: Real, reference: float) -> Real:
    """What a model answers to that noise, over the standard deviations, as it is to be expected.

    Parameters
    ----------
    part : TestPart
        A test.
    model : Model
        Any model.
    theta : ndarray, shape (p,)
        Its parameters.
    reference : float
        Temperature in kelvin at which shifts are one.

    Returns
    -------
    ndarray, shape (m,)
        Zero where the channel is quiet beside the response, or was not recorded.
    """
    quiet, size = np.zeros(len(part.measured)), _heard(part)
    if size == 0.0 or not isinstance(part, InTimePart):
        return quiet
    # Of independent noise the answers add as squares do: those to some kicks stand for all.
    kicks = np.zeros(len(part.at))
    kicks[APART::APART] = size
    kicks[2 * APART :: 2 * APART] *= -1.0
    loading = part.test.loading
    moved = replace(part.test, loading=Loading(loading.time, loading.value + kicks))
    rows = np.arange(len(part.at))
    before = part.answer(model, theta, reference, rows).value
    after = replace(part, test=moved, noise=part.sd).answer(model, theta, reference, rows).value
    share = np.count_nonzero(kicks) / len(kicks)
    answer = np.where(part.counted, (after - before) / part.sd, 0.0)
    return np.asarray(answer / np.sqrt(share), dtype=float)


def _heard(part: TestPart) -> float:
    """The noise of the imposed channel, as large as it may well be.

    Zero where the response's own drowns it.
    """
    if not isinstance(part, InTimePart) or len(part.at) < FEWEST or not is_even(part.at):
        return 0.0
    loading = part.test.loading
    if not np.array_equal(loading.time, part.at):
        return 0.0
    size, factor = imposed_noise(loading.value), part.stiffness
    if part.test.control == "force":
        factor = 1.0 / factor
    if size * factor < HEARD * float(np.median(part.sd)):
        return 0.0
    error = float(np.sqrt(2.0 / (WORTH * len(part.at))))
    return size * float(np.sqrt(1.0 + DOUBT * error))
