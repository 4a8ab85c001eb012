"""Complex stiffness against frequency, as whoever asks for it wants to see it.

Hz, storage, loss, magnitude.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from springpot.rheology.points import Complex, Real


class Moduli:
    """What has a complex stiffness at angular frequencies, measured or predicted.

    Attributes
    ----------
    omega : ndarray, shape (n,)
        In rad/s.
    stiffness : ndarray of complex, shape (n,)
        K = K' + i K''.

    Examples
    --------
    >>> from springpot import Measurement
    >>> data = Measurement([62.83185307179586], [3.0 + 4.0j])
    >>> data.frequency, data.magnitude
    (array([10.]), array([5.]))
    """

    omega: Real
    stiffness: Complex

    def __len__(self) -> int:
        return len(self.omega)

    @property
    def frequency(self) -> Real:
        """Frequency f = omega / 2 pi in Hz, shape (n,)."""
        return self.omega / (2.0 * np.pi)

    @property
    def storage(self) -> Real:
        """Storage modulus K', shape (n,)."""
        return self.stiffness.real

    @property
    def loss(self) -> Real:
        """Loss modulus K'', shape (n,)."""
        return self.stiffness.imag

    @cached_property
    def magnitude(self) -> Real:
        """|K|, shape (n,)."""
        return np.abs(self.stiffness)
