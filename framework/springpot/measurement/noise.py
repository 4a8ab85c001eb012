"""Artificial measurement noise as the paper adds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.errors import DataError

from .measurement import Measurement


def with_noise(
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    *,
    symmetric: bool = False,
    displacement: tuple[float, float] = (0.005, 0.01),
) -> Measurement:
    """The measurement with noise on the amplitudes of force and displacement, eq. (53).

    The displacement (q_c, q_s) gives the force by eq. (17); u_c, u_s, q_c, q_s are each multiplied
    by 1 + r level, and eq. (43) turns them back into K' and K''.

    Parameters
    ----------
    measurement : Measurement
        Exact data.
    level : float
        Noise level epsilon, such as 0.01.
    rng : numpy.random.Generator
        Draws r_1 ... r_4 for every frequency, in this order.
    symmetric : bool
        Draw r from (-1, 1); by default from (0, 1), as printed, which shifts all amplitudes
        upwards.
    displacement : tuple of float
        Cosine and sine amplitudes q_c and q_s, in metres in the paper (section 5.1).

    Raises
    ------
    DataError
        If the level is not positive and below 1.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import with_noise
    >>> exact = Measurement(np.ones(3), np.full(3, 2.0 + 1.0j))
    >>> noisy = with_noise(exact, 0.01, np.random.default_rng(1), symmetric=True)
    >>> bool(np.all(np.abs(noisy.stiffness / exact.stiffness - 1.0) < 0.05))
    True
    """
    if not 0 < level < 1:
        raise DataError(f"the noise level must lie between 0 and 1, got {level}")
    least, kind = 0.0, "one-sided as printed, r from (0, 1)"
    if symmetric:
        least, kind = -1.0, "symmetric, r from (-1, 1)"
    r = rng.uniform(least, 1.0, size=(4, len(measurement)))
    qc, qs = displacement
    uc = measurement.storage * qc + measurement.loss * qs
    us = -measurement.loss * qc + measurement.storage * qs
    uc, us, qc_noisy, qs_noisy = (1.0 + level * r) * np.stack(np.broadcast_arrays(uc, us, qc, qs))
    squared = qc_noisy**2 + qs_noisy**2
    storage = (uc * qc_noisy + us * qs_noisy) / squared
    loss = (uc * qs_noisy - us * qc_noisy) / squared
    return replace(
        measurement,
        stiffness=storage + 1j * loss,
        provenance={**measurement.provenance, "noise": f"eq. (53) at {100 * level:g} %, {kind}"},
    )
