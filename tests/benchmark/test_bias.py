"""Tests of bias see one that was built in, and none where there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from benchmark_fakes import Walk

from springpot import plugins
from springpot.benchmark.traits import Ripples, bias_of, bias_table
from springpot.errors import StudyError
from springpot.identification import Card, Optimiser


@dataclass(frozen=True)
class Drawn(Optimiser):
    """Random points that are moved by a share of the way to the centre, or to the edge."""

    pull: float = 0.0

    name: ClassVar[str] = "drawn"
    card: ClassVar[Card] = Card("random points, pulled")

    def minimise(self, problem, budget, rng):
        u = rng.random((budget, problem.dimension))
        goal = np.full_like(u, 0.5) if self.pull > 0 else np.round(u)
        problem.batch(u + abs(self.pull) * (goal - u))


def test_what_was_built_in_is_found_and_nothing_else():
    tested = [bias_of(Drawn(pull), f"pull {pull}", runs=40, budget=60) for pull in (0.0, 0.4, -0.7)]
    table = bias_table("test", tested)
    verdicts = [row[-1] for row in table.rows]
    assert verdicts[0] == "none seen"
    assert verdicts[1].startswith("to the centre")
    assert "better at the centre" in verdicts[1]
    assert verdicts[2].startswith("away from the centre")
    assert "to the edges" in verdicts[2]
    assert "better at a corner" in verdicts[2]


def test_the_landscape_has_the_same_values_wherever_its_optimum_is():
    x = (np.indices((40, 40)).reshape(2, -1).T + 0.5) / 40
    values = [np.sort(Ripples(np.array(o)).evaluate(x)) for o in ([0.5, 0.5], [0, 1], [0.2, 0.85])]
    np.testing.assert_allclose(values[0], values[1], atol=1e-12)
    np.testing.assert_allclose(values[0], values[2], atol=1e-12)
    assert Ripples(np.array([0.0, 0.3])).evaluate(np.array([1.0, 0.3])) == pytest.approx(0.0)


def test_it_is_the_same_again_and_not_for_descents():
    one, other = (bias_of(Walk(), runs=3, budget=20) for _ in range(2))
    assert np.array_equal(one.found, other.found)
    assert one.reached["corner"].tolist() == other.reached["corner"].tolist()
    with pytest.raises(StudyError, match="native uses derivatives"):
        bias_of(plugins().find("optimiser", "native")())
