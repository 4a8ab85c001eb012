"""What every installed model and effect answers, in frequency and in time, as numbers."""

import numpy as np
import pytest

import springpot
from springpot.errors import SpringpotError
from springpot.registry import parse_model, plugins
from springpot.rheology import Points, nonlinear
from springpot.rheology.model import Family

OMEGA = np.array([0.3, 1.1, 4.0, 17.0, 60.0, 250.0])
AT = Points(
    np.log(OMEGA),
    np.array([0.02, 0.1, 0.4, 1.1, 2.0, 5.0]),
    np.array([278.0, 288.0, 293.0, 299.0, 311.0, 333.0]),
    295.0,
)
TIME = np.array([0.0, 0.01, 0.05, 0.2, 0.21, 1.0, 3.0, 10.0])
WAY = np.array([0.0, 0.1, 0.4, 0.9, 0.7, -0.5, -0.2, 0.3])


def theta_of(model):
    """Values beside the usual ones, each another, and orders within their range."""
    values = []
    for i, parameter in enumerate(model.parameters):
        value = parameter.typical * (1.0 + 0.1 * np.cos(i))
        values.append(min(max(value, parameter.lower), parameter.upper))
    return np.array(values)


def answer(ask):
    """What is answered, or why nothing is."""
    try:
        return ask()
    except SpringpotError as error:
        return str(error)


def in_frequency(model):
    theta = theta_of(model)
    return {
        "theta": theta,
        "K": answer(lambda: model.stiffness(theta, AT)),
        "by theta": answer(lambda: model.jacobian(theta, AT)),
        "by ln omega": answer(lambda: model.slope(theta, AT)),
        "third": answer(lambda: model.third_harmonic(theta, AT)),
        "third range": answer(lambda: model.third_harmonic_range(theta, AT)),
    }


def in_time(model):
    theta = theta_of(model)
    return {
        "spectrum": answer(lambda: _lines(model.spectrum(theta, (0.1, 10.0), temperature=299.0))),
        "relaxation": answer(lambda: model.relaxation(theta, TIME[1:], temperature=299.0)),
        "creep": answer(lambda: model.creep(theta, TIME[1:], temperature=299.0)),
        "force": answer(lambda: model.respond(theta, TIME, WAY)),
        "way": answer(lambda: model.respond_force(theta, TIME, WAY)),
    }


def _lines(spectrum):
    return [spectrum.equilibrium, spectrum.viscosity, spectrum.weights, spectrum.rates]


def models():
    items = plugins().items("model")
    return {item.name: item.build(3) if isinstance(item, Family) else item for item in items}


def test_models_in_frequency(stays):
    named = models()
    stays({name: in_frequency(named[name]) for name in sorted(named)})


def test_effects_in_frequency(stays):
    effects = sorted(plugins().items("effect"), key=lambda each: each.name)
    zener = parse_model("zener")
    stays({each.name: in_frequency(zener + each) for each in effects})


@pytest.mark.soak
def test_models_in_time(stays):
    named = models()
    stays({name: in_time(named[name]) for name in sorted(named)}, within=1e-3)


def test_effects_in_time(stays):
    effects = sorted(plugins().items("effect"), key=lambda each: each.name)
    zener = parse_model("zener")
    # Of these most of the time goes into finding that they are no sum of relaxations.
    asked = [each for each in effects if each.name not in ("diffusion", "frame-resonance")]
    stays({each.name: in_time(zener + each) for each in asked}, within=1e-3)


def test_networks_and_their_drawings(stays):
    expressions = (
        "zener + inertia + time-delay",
        "fractional-maxwell + series-spring + friction",
        "springpot + arrhenius-shift + vertical-shift",
        "maxwell-3 + relaxation-mode + relaxation-mode",
    )
    found = {}
    for expression in expressions:
        model = parse_model(expression)
        found[expression] = {
            "drawing": springpot.rheology.drawing.drawing_of(model).splitlines(),
            "names": model.names,
            "needs": sorted(model.needs),
            "held": answer(lambda model=model: model.holding({model.names[0]: 2.0}).names),
            **in_frequency(model),
        }
    stays(found)


@pytest.mark.parametrize("value", [-0.1, 1.1, np.nan, np.inf])
def test_a_parameter_is_held_within_its_range_only(value):
    with pytest.raises(SpringpotError, match="alpha cannot be"):
        parse_model("springpot").holding({"alpha": value})
    assert parse_model("springpot").holding({"alpha": 1.0}).names == ("c",)


def test_a_slider_moved_step_by_step_is_one_that_is_moved_along(rng):
    way = np.append(0.0, np.cumsum(rng.normal(size=60)))
    along, _ = nonlinear.jenkins_law(np.arange(61.0), way, np.zeros(61), 3.0, 2.0)
    force, steps = 0.0, [0.0]
    for each in np.diff(way):
        force = nonlinear.jenkins_step(force, each, 3.0, 2.0)
        steps.append(force)
    np.testing.assert_allclose(along, steps, atol=1e-12)
    assert np.sum(np.abs(along) == 2.0) > 10


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.9])
def test_poles_that_stand_for_a_springpot_hold_its_modulus(alpha):
    """A power of the frequency over the band, to the accuracy that a spectrum says of itself."""
    model = parse_model("springpot")
    omega = np.geomspace(0.1, 10.0, 30)
    found = model.spectrum(np.array([2.0, alpha]), (0.1, 10.0))
    exact = 2.0 * (1j * omega) ** alpha
    assert np.max(np.abs(found.stiffness(omega) / exact - 1.0)) <= 1.2 * found.error
    assert found.error < 1e-3


def test_parameters_of_all_models_and_effects(stays):
    """Their dimensions, bounds and sizes, and what is said of them."""
    installed = {**models(), **{each.name: each for each in plugins().items("effect")}}
    rows = {}
    for name in sorted(installed):
        item = installed[name]
        element = getattr(item, "element", item)
        rows[name] = {p.name: [p, p.is_order] for p in element.parameters}
    stays(rows)


def test_what_all_effects_are(stays):
    """Where they join, which tests can have them, and where they are gone."""
    rows = {}
    for each in sorted(plugins().items("effect"), key=lambda each: each.name):
        one = each.of_one("test 1")
        rows[each.name] = {
            "layer": each.layer.name,
            "of": [each.of_test, each.of_apparatus, each.in_time, each.by_levels, each.narrow],
            "plane": each.plane,
            "gone at": each.vanishes_at,
            "needs": sorted(each.needs),
            "tests": [str(each.applies_to), sorted(each.applies_to.controls)],
            "one": [one.name, one.expression, one.aliases, str(one.applies_to)],
        }
    stays(rows)
