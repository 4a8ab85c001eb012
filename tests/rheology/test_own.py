"""Parameters that each level has for itself: K of every level is that of its own model."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

import springpot
from springpot.errors import ModelError
from springpot.rheology import Own, Points, dashpot, parallel, spring

LEVELS = np.array([1.0, 2.0, 3.0])
OMEGA = np.geomspace(0.5, 50.0, 6)
AT = Points(np.log(np.tile(OMEGA, 3)), columns={"batch": np.repeat(LEVELS, len(OMEGA))})


def test_each_level_has_the_stiffness_of_its_own_model() -> None:
    shared = springpot.parse_model("fractional-maxwell + inertia")
    model = shared.owning(["k", "inertia.m"], "batch").bound_to(AT)
    theta = model.vector(
        {"k_1": 3.0, "k_2": 4.0, "k_3": 5.0, "c": 0.7, "alpha": 0.4}
        | {"inertia.m_1": 0.01, "inertia.m_2": 0.02, "inertia.m_3": 0.03}
    )
    alone = [
        shared.stiffness(shared.theta(k=k, c=0.7, alpha=0.4, inertia__m=m), OMEGA)
        for k, m in ((3.0, 0.01), (4.0, 0.02), (5.0, 0.03))
    ]
    np.testing.assert_allclose(model.stiffness(theta, AT), np.concatenate(alone), rtol=1e-14)


@given(st.lists(st.sampled_from(["k", "c", "alpha"]), min_size=1, unique=True), st.integers(0, 99))
def test_the_derivatives_are_those_of_differences(names: list[str], seed: int) -> None:
    if "alpha" in names:
        names = [*{*names, "c"}]
    model = springpot.parse_model("fractional-kelvin").owning(names, "batch").bound_to(AT)
    theta = np.random.default_rng(seed).uniform(0.2, 0.9, len(model.names))
    by_theta, step = model.jacobian(theta, AT), 1e-6
    for i in range(len(theta)):
        ends = np.tile(theta, (2, 1))
        ends[:, i] += [step, -step]
        value = model.stiffness(ends, AT)
        np.testing.assert_allclose(
            by_theta[:, i], (value[0] - value[1]) / (2 * step), rtol=1e-5, atol=1e-7
        )


def test_settings_side_by_side_are_those_one_after_the_other(rng: np.random.Generator) -> None:
    node = Own(parallel(spring(), dashpot()), ("c",), "batch").bound_to(AT)
    theta = rng.uniform(1.0, 2.0, (4, 4))
    whole = node.respond(theta, AT, 2)
    for row, each in enumerate(theta):
        alone = node.respond(each, AT, 2)
        np.testing.assert_array_equal(whole.value[row], alone.value)
        np.testing.assert_array_equal(whole.by_theta[row], alone.by_theta)
        np.testing.assert_array_equal(whole.by_log_omega[row], alone.by_log_omega)


def test_a_point_between_two_levels_belongs_to_the_nearer_one() -> None:
    node = Own(spring(), ("k",), "batch", (1.0, 2.0))
    at = Points(np.zeros(3), columns={"batch": np.array([1.4, 1.6, 9.0])})
    assert node.respond(np.array([5.0, 7.0]), at).value.real.tolist() == [5.0, 7.0, 7.0]


def test_an_order_of_its_own_has_a_constant_of_its_own() -> None:
    model = springpot.parse_model("fractional-maxwell")
    with pytest.raises(ModelError, match="has a c of its own, too"):
        model.owning(["alpha"], "batch")
    both = model.owning(["c", "alpha"], "batch").bound_to(AT)
    assert {p.name: p.unit.time for p in both.parameters}["c_2"] == "alpha_2"


def test_what_has_no_such_parameter_or_two_conditions_is_refused() -> None:
    model = springpot.parse_model("kelvin")
    with pytest.raises(ModelError, match="no free parameter 'q': it has k, c"):
        model.owning(["q"], "batch")
    with pytest.raises(ModelError, match="each batch has its own already"):
        model.owning(["k"], "batch").owning(["c"], "day")


def test_held_and_own_stand_together() -> None:
    model = springpot.parse_model("fractional-maxwell").holding({"alpha": 0.5})
    model = model.owning(["k"], "batch").bound_to(AT)
    assert model.names == ("k_1", "k_2", "k_3", "c")
    assert model.origins == ("k", "k", "k", "c")
    assert (model.held, model.own) == ({"alpha": 0.5}, {"k": "batch"})
    assert model.released().names == ("k", "c", "alpha")
