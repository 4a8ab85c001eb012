"""The third harmonic of the force tells apart what one curve of K cannot."""

import numpy as np
import pytest

import springpot
from springpot.diagnosis import notes
from springpot.diagnosis.marginal import _open_harmonic, _price_of_a_bound, harmonic_evidence
from springpot.misfit.floor import fitted_to_floor
from springpot.registry import parse_model
from springpot.thresholds import EVIDENCE

OMEGA = np.geomspace(0.5, 60.0, 24)
AMPLITUDE = 2.0
FORCE = 60.0
SOLID = 300.0 + 40.0 * np.sqrt(1j * OMEGA)
LOSS = 4j * FORCE / (np.pi * AMPLITUDE)


def measured(third):
    """K of a solid with the same loss at all frequencies, 1 % noise and a third force harmonic."""
    rng = np.random.default_rng(5)
    noise = rng.standard_normal((2, 2, 24)) @ np.eye(24)
    stiffness = (SOLID + LOSS) * (1.0 + 0.01 * (noise[0, 0] + 1j * noise[0, 1]))
    harmonics = np.full((24, 2), 1e-3 + 0j)
    harmonics[:, 1] = third + 0.003 * (noise[1, 0] + 1j * noise[1, 1])
    return springpot.Measurement(
        OMEGA, stiffness, conditions={"amplitude": np.full(24, AMPLITUDE)}, harmonics=harmonics
    )


def test_friction_makes_a_third_of_its_force_at_three_times_the_frequency():
    """Fourier series of a square wave: F3 / F1 = 1/3, in phase with the velocity's sign."""
    model = parse_model("kelvin + friction")
    points = measured(0.0).points
    theta = model.vector({"k": 100.0, "c": 0.0, "friction.F": FORCE})
    third = model.third_harmonic(theta, points)
    np.testing.assert_allclose(np.abs(third), np.abs(LOSS / 3.0 / (100.0 + LOSS)), rtol=1e-12)
    assert not np.any(
        parse_model("kelvin + inertia").third_harmonic(np.array([100.0, 1.0, 0.1]), points)
    )
    assert (
        parse_model("kelvin + payne").third_harmonic(
            np.ones(6)[: len(parse_model("kelvin + payne").names)], points
        )
        is None
    )


@pytest.mark.soak
@pytest.mark.parametrize(
    ("third", "effect", "other"),
    [
        (LOSS / 3.0 / (SOLID + LOSS), "friction", "hysteretic-loss"),
        (0.0, "hysteretic-loss", "friction"),
    ],
    ids=["with", "without"],
)
def test_friction_and_a_hysteretic_loss_are_told_apart_at_one_amplitude(third, effect, other):
    diagnosis = springpot.diagnose(measured(third), "fractional-kelvin")
    assert diagnosis.verdict == "effect-missing"
    assert diagnosis.best.effect == effect
    assert other not in diagnosis.best.alike


def sizes_alone(data):
    """The same data as most tables have them: the share of a harmonic without its phase."""
    share = np.abs(data.harmonic(3))
    return springpot.Measurement(
        data.omega, data.stiffness, conditions={**data.conditions, "h3": share}
    )


@pytest.mark.parametrize("third", [LOSS / 3.0 / (SOLID + LOSS), 0.0], ids=["with", "without"])
def test_the_size_of_a_harmonic_tells_friction_from_a_hysteretic_loss(third):
    evidence = {
        (effect, phase): harmonic_evidence(fitted_to_floor(parse_model(f"kelvin + {effect}"), data))
        for phase, data in (("phase", measured(third)), ("size", sizes_alone(measured(third))))
        for effect in ("friction", "hysteretic-loss")
    }
    true, false = (
        ("friction", "hysteretic-loss") if np.any(third) else ("hysteretic-loss", "friction")
    )
    for phase in ("phase", "size"):
        assert evidence[true, phase] > evidence[false, phase] + 2.0 * EVIDENCE.as_good
    # What the phase says is only added to it.
    assert evidence[true, "size"] >= evidence[true, "phase"]


@pytest.mark.parametrize(("effect", "open_to"), [("friction", 0.01), ("elasto-sliding", 0.1)])
def test_what_a_sweep_leaves_open_of_a_law_is_open_in_its_harmonic(effect, open_to):
    """How stiff a slider is no single amplitude tells; a friction is known to 2 %."""
    fitted = fitted_to_floor(parse_model(f"kelvin + {effect}"), measured(0.0))
    third = fitted.model.third_harmonic(fitted.theta, fitted.data.mean.points)
    room = _open_harmonic(fitted, third).max()
    assert 0.1 * open_to < room < open_to


@pytest.mark.soak
def test_without_harmonics_they_are_one_class():
    data = measured(0.0)
    data = springpot.Measurement(data.omega, data.stiffness, conditions=data.conditions)
    assert {"friction", "hysteretic-loss"} <= set(
        springpot.diagnose(data, "fractional-kelvin").best.alike
    )


def test_filled_rubber_makes_little_of_a_third_harmonic():
    """At most a twelfth of dK / d ln X, so that none is left where K no longer changes."""
    model = parse_model("kelvin + payne")
    theta = model.vector(
        {"k": 1.0, "c": 0.0, "payne.k": 2.0, "payne.h": 0.3, "payne.Xc": 1.0, "payne.m": 0.6}
    )
    amplitude = np.array([1e-9, 0.3, 1.0, 3.0, 1e9])
    step = 1e-5

    def stiffness(x):
        return model.stiffness(theta, springpot.rheology.Points(np.zeros(5), amplitude=x))

    slope = np.abs(stiffness(amplitude * np.exp(step)) - stiffness(amplitude * np.exp(-step))) / (
        2.0 * step
    )
    at = springpot.rheology.Points(np.zeros(5), amplitude=amplitude)
    centre, radius = model.third_harmonic_range(theta, at)
    np.testing.assert_array_equal(centre, 0.0)
    np.testing.assert_allclose(
        radius, slope / 12.0 / np.abs(stiffness(amplitude)), rtol=1e-3, atol=1e-9
    )


def test_a_bound_costs_what_its_room_is_beside_a_prediction():
    """In units of what is known of a prediction.

    One that is right, a bound far away, and one that is met.
    """
    one = np.ones(3)
    assert _price_of_a_bound(0.0 * one, 0.0 * one) == 0.0
    # Beside a harmonic of nothing only the decades of the room are paid for.
    assert _price_of_a_bound(0.0 * one, 10.0 * one) == pytest.approx(np.log(1.0 + np.log(10.0)))
    # Where one is seen, a prediction that met it would have been the better guess by its square.
    assert _price_of_a_bound(2.0 * one, 2.0 * one) == pytest.approx(
        np.log(4.0 * (1.0 + np.log(2.0)))
    )
    # Never more than to know nothing at all.
    assert _price_of_a_bound(1e3 * one, 1e6 * one) == -EVIDENCE.unpredicted_harmonic


@pytest.mark.parametrize(("levels", "says"), [(2, ""), (3, "growing as amplitude^2 ± ")])
def test_three_amplitudes_tell_how_a_harmonic_grows(levels, says):
    amplitude = np.geomspace(0.1, 1.0, levels)
    data = springpot.Measurement(
        np.ones(levels), np.full(levels, 1.0 + 1.0j), conditions={"amplitude": amplitude}
    )
    found = notes._growth(data, 0.01 * amplitude**2, np.arange(levels))
    assert bool(found) == bool(says)
    assert says in found
    assert ("cubic spring" in found) == bool(says)
