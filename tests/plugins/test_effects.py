"""Every built-in effect: exact derivatives, names, units, needs, limits, and order of typing."""

from __future__ import annotations

import pickle
import textwrap
from dataclasses import replace
from importlib.metadata import EntryPoint
from itertools import combinations

import numpy as np
import pytest
from effects_common import BASES, EFFECTS, POINTS, base, cauchy, grown, own_theta, stencil, values

from springpot.errors import DataError
from springpot.measurement.units import Units
from springpot.registry import Registry, parse_model, plugins
from springpot.rheology import FULL, Points, balanced_series, draw, heated

DESIGN = {
    "stiffness": (
        "parallel-spring parallel-dashpot parallel-springpot relaxation-mode"
        " inertia hysteretic-loss"
    ),
    "amplitude": (
        "friction elasto-sliding smooth-hysteresis power-law-damper"
        " cubic-stiffness dead-zone payne self-heating"
    ),
    "compliance": "series-spring series-dashpot series-springpot",
    "signal": "time-delay phase-error gain-error fixture-resonance",
    "others": "arrhenius-shift wlf-shift vertical-shift specimen-inertia",
}

every_effect = pytest.mark.parametrize("name", EFFECTS)
both_bases = pytest.mark.parametrize("base_name", BASES)


def differentiate(model, theta, derivative):
    """Numerical dK/dtheta (p, n) and dK/d ln omega (n,)."""

    def along(i):
        def k(x):
            moved = theta.astype(type(x))
            moved[i] = x
            return model.network.respond(moved, POINTS).value

        return derivative(k, theta[i], 0.02 * abs(theta[i]))

    def in_time(x):
        return model.network.respond(theta, POINTS.shifted(x)).value

    return np.array([along(i) for i in range(len(theta))]), derivative(in_time, 0.0, 0.02)


@every_effect
@both_bases
def test_derivatives_are_exact(name, base_name):
    model, theta = grown(base_name, name)
    response = model.network.respond(theta, POINTS, FULL)
    # A real loss or the size of K is no analytic function of complex parameters.
    real = EFFECTS[name].composition in (heated, balanced_series) or name == "yielding"
    derivative = stencil if real else cauchy
    by_theta, by_log_omega = differentiate(model, theta, derivative)
    scale = np.max(np.abs(response.value))
    np.testing.assert_allclose(response.by_theta, by_theta, rtol=1e-9, atol=1e-10 * scale)
    np.testing.assert_allclose(response.by_log_omega, by_log_omega, rtol=1e-9, atol=1e-10 * scale)


@every_effect
def test_leading_axes_are_evaluated_side_by_side(name):
    model, theta = grown("fractional-zener", name)
    stack = theta * np.array([0.9, 1.0, 1.1, 1.05])[:, None].reshape(2, 2, 1)
    together = model.network.respond(stack, POINTS, FULL)
    assert together.value.shape == (2, 2, 6)
    assert together.by_theta.shape == (2, 2, len(theta), 6)
    for i in np.ndindex(2, 2):
        alone = model.network.respond(stack[i], POINTS, FULL)
        np.testing.assert_allclose(together.value[i], alone.value, rtol=1e-13)
        np.testing.assert_allclose(together.by_theta[i], alone.by_theta, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(
            together.by_log_omega[i], alone.by_log_omega, rtol=1e-12, atol=1e-13
        )


@every_effect
@both_bases
def test_an_effect_of_no_size_leaves_the_model_as_it_was(name, base_name):
    effect = EFFECTS[name]
    model, theta = grown(base_name, name)
    before = base(base_name).stiffness(np.array(list(BASES[base_name].values())), POINTS)
    first = model.names.index(f"{name}.{effect.element.parameters[0].name}")
    there = np.max(np.abs(model.stiffness(theta, POINTS) - before))
    theta[first] = 1e-10 if effect.vanishes_at == 0.0 else 1e10
    gone = np.max(np.abs(model.stiffness(theta, POINTS) - before))
    assert there > 1e-3
    assert gone < 1e-8


@pytest.mark.soak
def test_every_pair_is_the_same_model_whatever_the_order_of_typing():
    for one, other in combinations(EFFECTS, 2):
        model, theta = grown("fractional-zener", one, other)
        swapped, _ = grown("fractional-zener", other, one)
        assert model.names == swapped.names
        np.testing.assert_array_equal(
            model.stiffness(theta, POINTS), swapped.stiffness(theta, POINTS)
        )


def test_effects_join_from_the_material_outwards():
    """Temperature moves the material, not the rig; the mass is outside the mounting.

    The chain sees all.
    """
    model, theta = grown(
        "fractional-maxwell", "time-delay", "inertia", "series-spring", "arrhenius-shift"
    )
    given = values(model, "fractional-maxwell")
    material, own = grown("fractional-maxwell", "arrhenius-shift")
    k = material.stiffness(own, POINTS)
    k = 1.0 / (1.0 / k + 1.0 / given["series-spring.k"]) - given["inertia.m"] * POINTS.omega**2
    k = k * np.exp(-1j * POINTS.omega * given["time-delay.tau"])
    np.testing.assert_allclose(model.stiffness(theta, POINTS), k, rtol=1e-12)


def test_all_names_of_the_design_are_there_and_no_name_or_alias_twice():
    assert {name for line in DESIGN.values() for name in line.split()} <= set(EFFECTS)
    names = [word for effect in EFFECTS.values() for word in (effect.name, *effect.aliases)]
    assert len(names) == len(set(names))


@every_effect
def test_expressions_parse_print_and_round_trip(name):
    expression = f"fractional-maxwell + {name} + relaxation-mode"
    model = parse_model(expression)
    assert model.name == expression
    assert parse_model(model.name).names == model.names
    for alias in EFFECTS[name].aliases:
        assert parse_model(f"springpot + {alias}").effects[0] is EFFECTS[name]
    assert f"{name}.{EFFECTS[name].element.parameters[0].name}" in draw(model.network)


@every_effect
def test_an_effect_says_what_it_is(name):
    effect = EFFECTS[name]
    assert len(effect.summary.split()) >= 5
    assert not effect.summary.endswith(".")
    assert effect.citation


PLANES = {"stiffness": lambda k: k, "compliance": lambda k: 1.0 / k, "log-complex": np.log}
OF_WHOLE = {"hardening-mount", "power-law-slip", "specimen-inertia", "specimen-inertia-fixed"}
"""What they add hangs on what is there."""


@pytest.mark.parametrize("name", [name for name in EFFECTS if name not in OF_WHOLE])
def test_in_its_plane_an_effect_adds_the_same_to_any_model(name):
    effect = EFFECTS[name]
    if effect.plane == "shift":
        model = parse_model(f"kelvin + {name}")
        theta = np.append([2.0, 0.0], own_theta(effect))
        assert model.stiffness(theta, POINTS) == pytest.approx(2.0)
        return
    plane = PLANES[effect.plane]
    whole, alone = (
        [plane(model.stiffness(theta, POINTS)) for model, theta in both]
        for both in ([grown(each, name) for each in BASES], [grown(each) for each in BASES])
    )
    added = [with_it - without for with_it, without in zip(whole, alone, strict=True)]
    np.testing.assert_allclose(added[0], added[1], rtol=1e-9, atol=1e-12)
    assert np.abs(added[0]).max() > 1e-3


@every_effect
def test_a_missing_column_is_named(name):
    model, theta = grown("fractional-maxwell", name)
    assert model.needs == EFFECTS[name].needs <= {"amplitude", "temperature"}
    for column in model.needs:
        with pytest.raises(DataError, match=column):
            model.stiffness(theta, replace(POINTS, **{column: None}))
    bare = dict.fromkeys({"amplitude", "temperature"} - model.needs)
    np.testing.assert_array_equal(
        model.stiffness(theta, replace(POINTS, **bare)), model.stiffness(theta, POINTS)
    )


@every_effect
def test_bounds_hold_the_typical_size_and_signs_are_physical(name):
    signed = {
        "tau": ("time-delay", "filter-mismatch"),
        "k3": ("cubic-stiffness",),
        "q": ("intrinsic-nonlinearity",),
    }
    signed |= {"phi": ("phase-error", "crosstalk"), "g": ("gain-error",), "e": ("frequency-error",)}
    signed |= {"n": ("vertical-shift",)}
    for parameter in EFFECTS[name].element.parameters:
        assert parameter.lower <= parameter.typical <= parameter.upper
        may_be_negative = name in signed.get(parameter.name, ())
        assert (parameter.lower < 0) == may_be_negative
        assert parameter.scale == "linear" if may_be_negative else True


LABELS = {
    "parallel-spring": {"k": "kN/m"},
    "parallel-dashpot": {"c": "kN s/m"},
    "parallel-springpot": {"c": "kN s^alpha/m", "alpha": "-"},
    "relaxation-mode": {"k": "kN/m", "tau": "s"},
    "basset": {"c": "kN s^1.5/m"},
    "inertia": {"m": "kg"},
    "specimen-inertia": {"m": "kg"},
    "hardening-mount": {"k": "kN/m", "Xh": "mm"},
    "power-law-slip": {"F": "N", "a": "-"},
    "friction": {"F": "N"},
    "elasto-sliding": {"k": "kN/m", "F": "N"},
    "smooth-hysteresis": {"k": "kN/m", "F": "N", "n": "-", "beta": "-"},
    "yielding": {"k": "kN/m", "F": "N", "a": "-"},
    "power-law-damper": {"F": "N", "a": "-"},
    "cubic-stiffness": {"k3": "kN/m mm^-2"},
    "cubic-damping": {"c3": "kN s^3/m mm^-2"},
    "dead-zone": {"k": "kN/m", "b": "mm"},
    "payne": {"k": "kN/m", "h": "-", "Xc": "mm", "m": "-"},
    "intrinsic-nonlinearity": {"q": "mm^-2"},
    "strain-softening": {"Xc": "mm", "n": "-"},
    "shear-thinning": {"Vc": "mm/s", "n": "-"},
    "self-heating": {"s": "1/W"},
    "time-delay": {"tau": "s"},
    "phase-error": {"phi": "rad"},
    "fixture-resonance": {"omega_r": "rad/s", "zeta": "-"},
    "crosstalk": {"F": "N", "phi": "rad"},
    "arrhenius-shift": {"Ea": "kJ/mol"},
    "wlf-shift": {"C1": "-", "C2": "K"},
    "arrhenius-dashpot": {"c": "kN s/m", "Ea": "kJ/mol"},
    "arrhenius-springpot": {"c": "kN s^alpha/m", "alpha": "-", "Ea": "kJ/mol"},
}


@pytest.mark.parametrize("name", LABELS)
def test_units_are_those_of_the_data(name):
    units = Units("kN/m", "mm")
    labels = {p.name: units.of(p.unit)[1] for p in EFFECTS[name].element.parameters}
    assert labels == LABELS[name]


def test_printed_values_are_in_the_printed_unit():
    """2 N of friction at 0.5 mm and 3 kg at 10 rad/s, in data of kN/m and mm."""
    units = Units("kN/m", "mm")
    at = Points(np.log([10.0]), amplitude=np.array([0.5]))
    for name, value, in_newton_per_metre in (
        ("friction", 2.0, 4j * 2.0 / (np.pi * 0.5e-3)),
        ("inertia", 3.0, -3.0 * 10.0**2),
    ):
        element = EFFECTS[name].element
        factor, _ = units.of(element.parameters[0].unit)
        stiffness = element.respond(np.array([value / factor]), at).value
        np.testing.assert_allclose(1e3 * stiffness, in_newton_per_metre)
    factor, _ = units.of(EFFECTS["self-heating"].element.parameters[0].unit)
    loss_watt = 0.5 * 10.0 * 7e3 * 0.5e-3**2
    shift = EFFECTS["self-heating"].element.respond(np.array([0.04 / factor]), at).value * 7.0
    np.testing.assert_allclose(shift, 0.04 * loss_watt)


MINE = """
import numpy as np
from springpot.hooks import hookimpl
from springpot.rheology import Effect, Formula, Layer, Parameter, SECOND, chain


def sample_and_hold(at, period):
    z = 0.5 * at.omega * period
    lag = np.exp(-1j * z)
    value = np.sin(z) / z * lag
    by_log = lag * (np.cos(z) - np.sin(z) / z) - 1j * z * value
    return value, (by_log / period,), by_log


@hookimpl
def springpot_effects():
    hold = Formula((Parameter("T", "T", SECOND),), sample_and_hold, kind="hold")
    says = "the converter holds each sample for a period"
    return [Effect("sample-and-hold", chain, hold, says, Layer.SIGNAL)]
"""


def test_a_user_writes_an_effect_in_under_thirty_lines(tmp_path, monkeypatch):
    assert len(textwrap.dedent(MINE).strip().splitlines()) < 30
    (tmp_path / "my_sample_and_hold.py").write_text(MINE)
    monkeypatch.syspath_prepend(tmp_path)
    found = Registry([EntryPoint("mine", "my_sample_and_hold", "springpot")])
    assert found.faults == []
    model = base("fractional-zener") + found.effect("sample-and-hold")
    theta = model.vector(BASES["fractional-zener"] | {"sample-and-hold.T": 0.3})
    response = model.network.respond(theta, POINTS, FULL)
    by_theta, by_log_omega = differentiate(model, theta, cauchy)
    np.testing.assert_allclose(response.by_theta, by_theta, rtol=1e-9)
    np.testing.assert_allclose(response.by_log_omega, by_log_omega, rtol=1e-9)
    delayed, own = grown("fractional-zener", "time-delay")
    own[-1] = 0.15
    phase = np.angle(response.value) - np.angle(delayed.stiffness(own, POINTS))
    np.testing.assert_allclose(phase, 0.0, atol=1e-12)


@every_effect
def test_linear_effects_make_no_third_harmonic(name):
    effect = EFFECTS[name]
    third = effect.third_harmonic(own_theta(effect), POINTS)
    if "amplitude" not in effect.needs:
        np.testing.assert_array_equal(third, np.zeros(6))
    elif third is not None and name not in {"crosstalk", "self-heating"}:
        assert np.max(np.abs(third)) > 1e-3


@pytest.mark.parametrize("first", ["wlf-shift", "hardening-mount", "fixture-resonance"])
@pytest.mark.parametrize("name", EFFECTS)
def test_a_model_fixed_at_its_parameters_grows_as_the_model_itself(name, first):
    """The scan evaluates, for all settings of an effect, the grown model with the others held."""
    model, theta = grown("fractional-zener", first)
    effect = EFFECTS[name]
    own = own_theta(effect) * np.array([[1.0], [0.9], [1.05]])
    with_effect = model + effect
    new = [i for i, parameter in enumerate(with_effect.names) if parameter not in model.names]
    old = [i for i in range(len(with_effect.names)) if i not in new]
    full = np.empty((3, len(with_effect.names)))
    full[:, old], full[:, new] = theta, own
    found = (model.fixed_at(theta) + effect).stiffness(own, POINTS)
    np.testing.assert_allclose(found, with_effect.stiffness(full, POINTS), rtol=1e-12)


def test_each_can_be_sent_to_another_process():
    """As every answer that holds it is by Dask, and by whoever keeps one for later."""
    known = list(plugins().items("effect"))
    assert len(known) > len(EFFECTS)
    assert [effect.name for effect in known if pickle.loads(pickle.dumps(effect)) != effect] == []
