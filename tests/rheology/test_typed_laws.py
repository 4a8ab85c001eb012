"""Laws as text: what is allowed, exact derivatives, units, and that they are effects as any."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import springpot
from derivatives import check_derivatives
from springpot import Measurement, Units
from springpot.errors import ModelError, SpringpotError
from springpot.registry import parse_model
from springpot.rheology import Effect, Points
from springpot.rheology.factors import LARGEST_SHIFT
from springpot.rheology.grammar import parsed
from springpot.rheology.nodes import FULL
from springpot.rheology.terms import LOG_OMEGA, Dual
from springpot.rheology.written import examples, told, written
from springpot.testing import check_effect

LAWS = [
    "my-mass = parallel: -m*omega^2",
    "series: 1/(k*(1 + (X/Xc)^n))",
    "chain: exp(-i*omega*tau)",
    "chain: 1/(1 + (i*omega*tau)^alpha)",
    "parallel: c*(i*omega)^alpha * exp(E/R*(1/T - 1/T0))",
    "parallel: k*(1 - tanh(X/Xc))*s*tau/(1 + s*tau)",
    "parallel: k*max(0, 1 - Xc/X)",
    "shift: exp(E/R*(1/T - 1/T0))",
    "shift: 1 + d*X",
    "shift: 10^(-C1*(T - T0)/(C2 + T - T0))",
    "chain: (T/T0)^n",
    "series: Y/(i*c*(omega*Y)^a)",
    "parallel: k*slider(Xc/X)",
]
UNITS = Units("kN/m", "mm")


LEAVES = [
    *("a", "b", "omega", "s", "2", "0.5", "s^a", "(i*omega*b)^a", "(1 + s*b)^(2*a)", "(a*omega)^b"),
    *("log(2 + a*omega)", "sqrt(b + s)", "tanh(a*omega)", "max(a, b)", "min(a, 2*b)", "abs(a)"),
    "slider(a/(a + b))",
]
NODES = ["({} + {})", "({} - 0.3*{})", "{}*{}", "{}*exp(-{}/9)", "{}*{}/(a + b*s + 1)"]


@st.composite
def formulas(draw, depth=3):
    """Text of a formula of a, b and omega that has slopes wherever they are above 0.

    Its units are not looked at.
    """
    if depth == 0 or draw(st.booleans()):
        return draw(st.sampled_from(LEAVES))
    parts = [draw(formulas(depth=depth - 1)) for _ in range(2)]
    return draw(st.sampled_from(NODES)).format(*parts)


@pytest.mark.soak
@settings(max_examples=60, deadline=None)
@given(text=formulas(), values=st.tuples(*[st.floats(0.4, 2.5)] * 3))
def test_slopes_of_any_formula_are_those_of_a_tiny_step(text, values):
    term = parsed(text)
    names = ("a", "b", "ln omega")

    def at(a, b, log_omega):
        omega = np.exp(log_omega)
        known = {"a": Dual(a, {"a": 1.0}), "b": Dual(b, {"b": 1.0})}
        known["omega"] = Dual(omega, {LOG_OMEGA: omega})
        known["s"] = Dual(1j * omega, {LOG_OMEGA: 1j * omega})
        # What is too large for a number is left out below.
        with np.errstate(all="ignore"):
            return term.at(known | {LOG_OMEGA: Dual(log_omega, {LOG_OMEGA: 1.0})})

    whole = at(*values)
    # At a kink there is no slope.
    assume(abs(values[0] - values[1]) > 0.01 and abs(values[0] - 2 * values[1]) > 0.01)
    assume(np.isfinite(whole.value) and 1e-3 < abs(whole.value) < 1e6)
    for place, name in enumerate(names):
        exact = whole.slopes.get(LOG_OMEGA if place == 2 else name, 0.0)
        # A circle about the point: a complex step, whatever i stands in the formula itself. The
        # steeper the formula, the smaller it is.
        step = 1e-3 / (1.0 + abs(exact / whole.value))
        turns = np.exp(2j * np.pi * np.arange(8) / 8)
        around = [
            at(*(value + step * turn * (i == place) for i, value in enumerate(values))).value
            for turn in turns
        ]
        slope = np.mean(np.array(around) / turns) / step
        assert abs(exact - slope) < 1e-8 * (abs(whole.value) + abs(slope)), (text, name)


@pytest.mark.parametrize("text", LAWS)
def test_a_law_has_exact_derivatives(text):
    element = springpot.law(text).element
    at, theta = examples(element)
    # Where a threshold is passed: below it there is nothing to be derived.
    check_derivatives(element, 0.6 * np.array(theta), at)


@pytest.mark.soak_cases(
    "my-mass = parallel: -m*omega^2",
    "series: 1/(k*(1 + (X/Xc)^n))",
    "chain: exp(-i*omega*tau)",
    "chain: 1/(1 + (i*omega*tau)^alpha)",
    "parallel: c*(i*omega)^alpha * exp(E/R*(1/T - 1/T0))",
    "parallel: k*(1 - tanh(X/Xc))*s*tau/(1 + s*tau)",
    "parallel: k*max(0, 1 - Xc/X)",
    "shift: exp(E/R*(1/T - 1/T0))",
    "shift: 1 + d*X",
    "shift: 10^(-C1*(T - T0)/(C2 + T - T0))",
    "series: Y/(i*c*(omega*Y)^a)",
    "parallel: k*slider(Xc/X)",
)
@pytest.mark.parametrize("text", LAWS)
def test_a_law_keeps_the_contract_of_effects(text):
    # Who typed it is its source.
    mine = replace(springpot.law(text), citation="typed by a user")
    assert check_effect(mine) == []


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("parallel: -m*omega^2", "m", (1000.0, "kg")),
        ("parallel: c*i*omega", "c", (1.0, "kN s/m")),
        ("parallel: c*(i*omega)^alpha", "c", (1.0, "kN s^alpha/m")),
        ("series: 1/(k*(1 + (X/Xc)^n))", "Xc", (1.0, "mm")),
        ("series: 1/(k*(1 + (X/Xc)^n))", "n", (1.0, "-")),
        ("chain: exp(-i*omega*tau)", "tau", (1.0, "s")),
        ("parallel: k*exp(E/R*(1/T - 1/T0))", "E", (1.0, "kJ/mol")),
        ("parallel: k*X^(-n)", "k", (1.0, "kN/m mm^n")),
        ("parallel: F/X", "F", (1.0, "N")),
        ("parallel: k*2^(-X/Xc)", "Xc", (1.0, "mm")),
        ("shift: 10^(-C1*(T - T0)/(C2 + T - T0))", "C2", (1.0, "K")),
        ("parallel: a*T/T0", "a", (1.0, "kN/m")),
    ],
)
def test_units_follow_from_those_of_the_data(text, name, unit):
    parameters = {each.name: each for each in springpot.law(text).element.parameters}
    assert UNITS.of(parameters[name].unit) == unit


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("parallel: k*__import__('os')", 'sign 14: "\'" has no meaning'),
        ("parallel: k.real", "sign 1: a formula has no attribute"),
        ("parallel: k*eval(c)", "sign 3: 'eval' is no function"),
        ("parallel: k*(lambda x)", "sign"),
        ("parallel: k*9^9^9", "sign 5: a power beyond 20"),
        ("parallel: k*X^99", "sign 5: a power beyond 20 is no law"),
        ("parallel: k*omega^(i*alpha)", "a power is a real number"),
        ("parallel: k*(1 + X)", "sign 8: units do not fit: beside a pure number stands the same"),
        ("parallel: k + c*X", "never vanishes: none of k, c"),
        ("parallel: exp(-i*omega*tau)", "units do not fit: the whole is a stiffness"),
        ("parallel: k*exp(omega)", "sign 7: units do not fit: exp takes a pure number"),
        ("parallel: k*", "this is no formula"),
        ("parallel: 2*omega", "has no parameter"),
        ("parallel: k + m*omega^2", "never vanishes: none of k, m does it alone"),
        ("parallel: k*abs(s*tau)", "abs takes what is real"),
        ("shift: i*k", "a factor of the frequency is real"),
        ("parallel: __k*X", "is no name of a parameter"),
        ("parallel: " + "-" * 900 + "k", "is no law"),
        ("parallel: " + "k+" * 400 + "k", "is no law"),
        ("parallel: k" + "0" * 1_000_000, "is too long"),
        ("beside: k", "write NAME = PLANE: FORMULA"),
        ("os.system = parallel: k", "is no name of a law"),
        ("k*X", "is no law"),
        ("parallel: k*slider(s*tau)", "slider takes what is real"),
        ("series: X^n/(k*Y^n)", "has both X, of the whole, and Y, of the part in series"),
    ],
)
def test_what_is_no_law_is_refused_in_one_line_that_names_the_sign(text, words):
    with pytest.raises(ModelError) as refused:
        springpot.law(text)
    message = str(refused.value)
    assert words in message
    assert "\n" not in message
    assert len(message) < 350


@pytest.mark.parametrize(
    "text", ["parallel: 1e-9*k*X^2/X^2", "series: 1e9/k", "chain: 1 + 1e-6*g", "parallel: 1e7*k"]
)
def test_a_law_may_vanish_whatever_numbers_stand_in_it(text):
    assert springpot.law(text).vanishes_at in (0.0, np.inf)


def test_a_model_is_left_without_a_law_by_its_name_and_without_an_effect_by_an_alias():
    model = parse_model("fractional-maxwell + inertia + (parallel: c*s)")
    assert (model - "law-2").name == "fractional-maxwell + inertia"
    assert (model - "inerter" - "law-2").name == "fractional-maxwell"


HOSTILE = [
    *("k.__class__", "k.__class__.__mro__[1]", "().__class__", "k.real.real", "(k).__init__(1)"),
    *("__import__(1)", "open(1)", "eval(k)", "exec(k)", "compile(k)", "globals()", "getattr(k, X)"),
    *("input()", "exit()", "print(k)", "breakpoint()", "help(k)", "vars()", "dir()", "type(k)"),
    *("k[0]", "[k]", "{k}", "{k: 1}", "(k, 1)", "k,", "*k", "**k", "exp(*k)", "exp(x=k)"),
    *("lambda: k", "k if X else 1", "k and X", "not k", "k < 1", "k == 1", "k := 1", "k = 1"),
    *("k; X", "k\nX", "k # X", "'k'", 'f"{k}"', "b'k'", "k @ X", "k // X", "k % X", "k << 9"),
    *("~k", "k | X", "k & X", "await k", "yield k", "(yield)", "[k for k in X]", "k!", "k?", "$k"),
    *("k\x00", "k\\", "\u03c9*k", "k*0x10", "k*1_000", "k*1j", "k*1e999", "k*True", "k*None"),
    *("k*...", "9^9^9^9*k", "k^(10^10)", "k*1/0", "k*0/0", "k*log(0)", "k*1e308*1e308", ""),
    *("exp", "exp()", "exp(k, k)", "max(k)", "k exp", "k k", "2k", "k(X)", "3(k)", "()", "((k)"),
    *("(" * 99 + "k" + ")" * 99 + "(", "-" * 999 + "k", "k^" * 300 + "k", "k" * 999, "k*" * 499),
    *(
        "_",
        "__",
        "_k*X",
        "k__*X",
        "k*" + "x" * 31,
        "abs(s)*k",
        "max(s, k)",
        "k^i",
        "k^s",
        "k^(1+i)",
    ),
]


@pytest.mark.parametrize("plane", ["parallel", "chain"])
def test_hostile_text_is_one_line_and_nothing_of_it_is_run(plane):
    for text in HOSTILE:
        with pytest.raises(SpringpotError) as refused:
            springpot.law(f"{plane}: {text}")
        assert "\n" not in str(refused.value), text
        assert len(str(refused.value)) < 350, text


def test_a_law_is_told_to_be_causal_and_passive_or_not():
    assert told(written("c*i*omega")) == "causal and passive"
    assert told(written("-c*i*omega")).startswith("not passive")
    assert told(written("i*h")).startswith("not causal")
    assert told(written("exp(i*omega*tau)", "log-complex")).startswith("not causal")
    assert told(written("exp(-i*omega*tau)", "log-complex")) == "causal"


def test_a_formula_is_the_model_that_it_writes():
    typed, named = parse_model("k + c*(i*omega)^alpha"), parse_model("spring")
    omega = np.geomspace(0.1, 100.0, 7)
    theta = np.array([2.0, 0.5, 0.4])
    expected = 2.0 + 0.5 * (1j * omega) ** 0.4
    assert np.allclose(typed.stiffness(theta, omega), expected, rtol=1e-13)
    assert typed.names == ("k", "c", "alpha")
    assert named.names == ("k",)


@pytest.mark.parametrize(
    "expression",
    [
        "fractional-maxwell + (law-1 = series: 1/(k*(1 + (X/Xc)^n))) + inertia",
        "k + c*(i*omega)^alpha",
        "k + c*(i*omega)^alpha + inertia",
    ],
)
def test_a_model_of_formulas_is_read_again_from_its_name(expression):
    model = parse_model(expression)
    again = parse_model(model.name)
    assert (again.name, again.names) == (model.name, model.names)
    omega, theta = np.array([1.0, 3.0]), np.linspace(0.4, 0.9, len(model.names))
    at = Points(np.log(omega), amplitude=np.array([1.0, 2.0]))
    assert np.array_equal(again.stiffness(theta, at), model.stiffness(theta, at))


def test_an_effect_by_its_formula_is_the_one_that_is_installed():
    mine = Effect.from_formula("mine", "parallel: -m*omega^2")
    base, omega = parse_model("fractional-maxwell"), np.geomspace(1.0, 50.0, 9)
    theta = np.array([4.0, 2.0, 0.6, 1e-3])
    installed = (base + "inertia").stiffness(theta, omega)
    assert np.allclose((base + mine).stiffness(theta, omega), installed, rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "text", "theta"),
    [
        ("hardening-mount", "series: 1/(k*(1 + (Y/Xh)^2))", [500.0, 0.9]),
        # Of the force at a speed of one: the first harmonic of |v|^(1/2) sgn(v) is 1.11284.
        ("power-law-slip", "series: Y/(1.1128357889*i*F*(omega*Y)^a)", [90.0, 0.5]),
        ("elasto-sliding", "parallel: k*slider(F/(k*X))", [120.0, 30.0]),
        ("backlash", "chain: 1 - slider(b/X)", [0.05]),
    ],
)
def test_a_part_in_series_feels_its_own_amplitude_and_a_slider_its_force(name, text, theta):
    at = Points.at(np.geomspace(1.0, 100.0, 7), amplitude=np.geomspace(0.1, 3.0, 7))
    base = parse_model("fractional-maxwell")
    typed, named = (
        model.network.respond(np.array([400.0, 60.0, 0.5, *theta]), at, FULL)
        for model in (base + springpot.law(text), base + name)
    )
    np.testing.assert_allclose(typed.value, named.value, rtol=1e-10)
    np.testing.assert_allclose(typed.by_log_omega, named.by_log_omega, rtol=1e-8)
    if name != "power-law-slip":  # whose constant goes with its order
        np.testing.assert_allclose(typed.by_theta, named.by_theta, rtol=1e-8, atol=1e-12)


def test_beside_a_model_or_as_a_column_y_is_a_name_like_any_other():
    assert [p.name for p in springpot.law("parallel: Y*(i*omega*tau)^a").element.parameters] == [
        *("Y", "tau", "a")
    ]
    at = Points(np.zeros(2), columns={"Y": np.array([1.0, 3.0])})
    grown = springpot.law("parallel: k*Y^n").bound_to(at).element
    assert grown.respond(np.array([2.0, 1.0]), at).value.real.tolist() == [2.0, 6.0]


def swept(law, theta, sigma=0.003, **columns):
    """An artificial sweep at four levels of a column, with a hidden law beside a springpot."""
    omega = np.tile(2 * np.pi * np.geomspace(0.3, 30.0, 12), 4)
    columns = {name: np.repeat(values, 12) for name, values in columns.items()}
    model = parse_model("fractional-maxwell") + springpot.law(law)
    rng = np.random.default_rng(5)
    noise = 1.0 + sigma * (rng.normal(size=48) + 1j * rng.normal(size=48))
    ones = np.ones(48, dtype=complex)
    data = Measurement(omega, ones, conditions=columns, units=Units("kN/m", "mm"))
    exact = model.bound_to(data.points).stiffness(np.array(theta), data.points)
    return Measurement(omega, exact * noise, conditions=columns, units=Units("kN/m", "mm"))


HIDDEN = "creeping-grip = parallel: k*log(1 + X/Xc)"


@pytest.mark.soak
def test_a_hidden_effect_is_found_by_its_typed_law(tmp_path):
    data = swept(HIDDEN, [400.0, 60.0, 0.5, 40.0, 0.5], amplitude=[0.2, 0.5, 1.0, 3.0])
    few = ["creeping-grip", "payne", "cubic-stiffness", "friction", "backlash", "inertia"]
    found = springpot.diagnose(data, "fractional-maxwell", effects=[HIDDEN], only=few)
    assert found.best is not None
    assert found.best.effect == "creeping-grip"
    assert found.best.over_floor < 1.2
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps(found.to_dict()))
    again = springpot.load(path)
    assert again.best.effect == "creeping-grip"
    assert again.best.physics.expression == f"({HIDDEN})"


def test_a_column_of_the_data_is_a_variable_and_a_fit_is_loaded_again(tmp_path):
    law = "grip = parallel: k*current/(current + Ic)"
    data = swept(law, [400.0, 60.0, 0.5, 80.0, 0.7], current=[0.1, 0.5, 1.0, 2.0])
    fit = springpot.identify(data, f"fractional-maxwell + ({law})", seed=1)
    assert fit.model.names == ("k", "c", "alpha", "grip.k", "grip.Ic")
    assert fit.theta[3:] == pytest.approx([80.0, 0.7], rel=0.1)
    assert data.units.of(fit.model.parameters[4].unit)[1] == "current"
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    again = springpot.load(path)
    assert again.model.name == fit.model.name
    assert np.array_equal(again.theta, fit.theta)


def test_what_is_no_column_and_counts_only_together_is_refused():
    data = swept(
        "a = parallel: k*log(1 + X/Xc)", [4e2, 60.0, 0.5, 9.0, 1.0], amplitude=[1, 2, 3, 4]
    )
    with pytest.raises(SpringpotError, match="count only together"):
        springpot.identify(data, "fractional-maxwell + (parallel: k*current)")


def test_a_held_parameter_of_a_law_stays_held_where_columns_are_met():
    law = "grip = parallel: k*current/(current + Ic)"
    data = swept(law, [400.0, 60.0, 0.5, 80.0, 0.7], current=[0.1, 0.5, 1.0, 2.0])
    fit = springpot.identify(data, f"fractional-maxwell + ({law})", seed=1, fix={"grip.Ic": 0.7})
    assert fit.model.names == ("k", "c", "alpha", "grip.k")
    assert fit.theta[3] == pytest.approx(80.0, rel=0.05)


def test_what_is_nothing_to_a_power_has_slopes():
    at = Points.at([1.0, 1.0], amplitude=[1.0, 4.0])
    grip = springpot.law("parallel: k*max(0, X - Xc)^n").element
    response = grip.respond(np.array([2.0, 2.0, 0.5]), at, depth=FULL)
    assert response.value.real.tolist() == [0.0, pytest.approx(2.0 * 2.0**0.5)]
    assert np.all(np.isfinite(response.by_theta))


def test_a_power_of_a_reduced_frequency_is_an_order():
    mode = springpot.law("parallel: k*(i*omega*tau)^a/(1 + (i*omega*tau)^a)").element
    assert [p.name for p in mode.parameters if p.is_order] == ["a"]


def test_a_power_of_the_warmth_may_be_large():
    # Of a modulus that falls by half in 10 K the power is 20.
    warm, wide = (springpot.law(f"chain: {base}^n").element for base in ("(T/T0)", "(X/0.1/X)"))
    assert [(p.lower, p.upper) for p in warm.parameters] == [(-20.0, 20.0)]
    assert [(p.lower, p.upper) for p in wide.parameters] == [(-4.0, 4.0)]


def test_a_law_of_the_clock_is_bounded_where_a_search_strays():
    clock = springpot.law("shift: exp(-X/Xc)").element
    at = Points.at([1.0], amplitude=[1e3])
    response = clock.respond(np.array([1e-3]), at, depth=FULL)
    assert response.value.real.tolist() == [-LARGEST_SHIFT]
    assert response.by_theta.ravel().tolist() == [0.0]


def test_units_with_a_power_that_a_parameter_decides_keep_the_contract():
    effect = Effect.from_formula("grip", "parallel: k*X^(-n)", "a grip that fades")
    assert [each for each in check_effect(effect) if each.startswith("units")] == []


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6), st.floats(-1.0, 1.0))
def test_a_part_in_series_takes_the_amplitude_that_is_left_to_it(logs, body):
    # A resonance beside a softening spring bends what is solved: Newton's steps go in circles.
    effect = springpot.law(
        "series: 1/(k*(1 + i*z*omega/w0 - (omega/w0)^2)) + 1/(k*r*(1 + (Y/Xc)^n))"
    )
    own, alone = 10.0 ** np.array(logs), 10.0**body
    points = Points.at(np.geomspace(0.1, 10.0, 15), amplitude=np.resize([0.1, 1.0, 9.0], 15))
    whole = (parse_model("spring") + effect).stiffness(np.array([alone, *own]), points)
    part = 1.0 / (1.0 / whole - 1.0 / alone)
    taken = replace(points, amplitude=points.need("amplitude") * np.abs(whole / part))
    assert effect.element.respond(own, taken).value == pytest.approx(part, rel=1e-6)
