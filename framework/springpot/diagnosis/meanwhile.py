"""What is told of the effects that may be missing while they are being tried."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real


class TriedEffect(NamedTuple):
    """An effect that was fitted by itself, for those who draw it before the answer is there.

    Attributes
    ----------
    effect : Effect
        The effect.
    model : Model
        The model with it.
    theta : ndarray, shape (p,)
        Its parameters.
    """

    effect: Effect
    model: Model
    theta: Real


Fitted: TypeAlias = Callable[[TriedEffect], None]
"""Called with each effect as its fit comes, and once more where a better one does."""


def unseen(tried: TriedEffect) -> None:
    """For those who wait for the answer."""
