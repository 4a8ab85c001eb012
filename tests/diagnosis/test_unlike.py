"""Sweeps that are judged one by one, and what their answers say together."""

from types import SimpleNamespace

import pytest

from springpot.diagnosis.notes import unlike
from springpot.identification.value import Value


def of(name: str, verdict: str = "adequate", **values: float) -> SimpleNamespace:
    told = {k: Value(v, 0.99 * v, 1.01 * v, "kN/m") for k, v in values.items()}
    return SimpleNamespace(data=name, verdict=verdict, parameters=told)


def test_sweeps_judged_one_by_one_that_are_not_alike_are_told_of():
    """Each by itself is adequate, and no one specimen has them all."""
    alike = [of("a", k=400.0, c=60.0), of("b", k=404.0, c=60.5)]
    says = unlike([*alike, of("c", k=440.0, c=60.2), of("d", k=400.0)])
    assert says.startswith("each was judged by itself, and k of a, b, c and 1 more differ by more")


@pytest.mark.parametrize(
    "judged",
    [
        [of("a", k=400.0, c=60.0), of("b", k=404.0, c=60.5)],
        [of("a", k=400.0), of("b", c=500.0)],
        [of("a", k=400.0), of("b", "effect-missing", k=500.0)],
    ],
)
def test_alike_sweeps_unlike_names_and_what_is_not_followed_are_not(judged):
    assert unlike(judged) == ""
