"""Figures as they stand in a sentence."""

from __future__ import annotations


def times(ratio: float) -> str:
    """A ratio with two digits, such as ``3.1 x``; whole from a hundred on, never with a power of ten."""
    return f"{ratio:.0f} x" if ratio >= 99.5 else f"{ratio:.2g} x"
