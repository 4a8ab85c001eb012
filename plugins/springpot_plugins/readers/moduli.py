"""Which modulus a title tells of: by its letter, as G' or E(t), or words, as shear or tensile."""

from __future__ import annotations

import re
from collections.abc import Iterable

_SWEEP = re.compile(r"(?:\A|[^A-Za-z])([GEK])(?:['′’´`*]|_?prime|p(?![A-Za-z]))")
"""``G'``, ``|E*|``, ``Storage modulus (G′)``; primes as programs spell them."""
_TIMED = re.compile(r"(?:\A|[^A-Za-z])([GEJD])\s*\(t\)")
"""``G(t)``, ``E(t)``, and the compliances J of shear and D of tension."""
_OF_COMPLIANCE = {"J": "G", "D": "E"}
_WORDS = {
    "G": re.compile(r"\bshear\b", re.IGNORECASE),
    "E": re.compile(r"\b(?:young|tensile|flexural|elongational)\b", re.IGNORECASE),
    "K": re.compile(r"\bbulk\b", re.IGNORECASE),
}


def letter_of(titles: Iterable[str], is_modulus: bool) -> str:
    """G, E or K (bulk modulus or stiffness) of the first title that tells; empty if none does."""
    for title in titles:
        match = _SWEEP.search(title) or _TIMED.search(title)
        if match:
            letter = _OF_COMPLIANCE.get(match[1], match[1])
            # In N/mm a G is no modulus; in Pa a K may be the bulk modulus or any: it is better
            # asked for.
            if is_modulus == (letter != "K"):
                return letter
        named = [letter for letter, word in _WORDS.items() if word.search(title)]
        if is_modulus and len(named) == 1:
            return named[0]
    return ""
